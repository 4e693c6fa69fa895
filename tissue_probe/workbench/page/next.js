// Next: the experiment that would tell more, as the models see it.

import { act, ask, on, plain, rung, say, told } from "./app.js";
import { fill, h, worded } from "./elements.js";
import { short } from "./numbers.js";
import { Plot } from "./plot.js";

const COLOURS = ["predicted", "residual", "explained"];

export function next() {
  const words = h("section", {});
  const motion = new Plot({ name: "Suggested motion", sync: "next", lines: [{ label: "position", colour: "measured" }] },
    h("b", {}, "the motion that drives"), " [mm]", h("span", { class: "at" }, "time [s]"));
  const output = new Plot({ name: "Prediction of each model", sync: "next", lines: COLOURS.map((colour) => ({ label: colour, colour })) });
  const plots = h("div", { style: { display: "grid", gap: "0.8rem" } });
  const element = h("div", { class: "sheet" }, h("h1", {}, "The next experiment"), words, plots);
  motion.element.classList.add("tall");
  output.element.classList.add("tall");
  let drawn = "";
  const draw = async () => {
    const ranking = told.desk?.ranking;
    const now = JSON.stringify([ranking?.rung, ranking?.done, ranking?.text, told.desk?.rungs.length]);
    if (now === drawn) return;
    drawn = now;
    fill(words, inWords(ranking));
    plots.replaceChildren();
    if (!ranking?.answer?.suggested_excitation?.excitation.kind) return;
    let answer;
    try {
      answer = await ask("next");
    } catch (error) {
      fill(plots, h("p", { class: "soft" }, plain(error instanceof Error ? error.message : String(error))));
      return;
    }
    const { ok, arrays } = answer;
    plots.append(motion.element, output.element);
    const quantity = rung()?.output ?? { per_drawn: 1, drawn: "N", name: "force" };
    const scaled = (/** @type {ArrayLike<number>} */ of, /** @type {number} */ by) => Float64Array.from(of, (value) => value * by);
    motion.show(arrays.time, [scaled(arrays.position, 1e3)]);
    output.show(arrays.time, COLOURS.map((_, number) => arrays[`output${number}`]
      ? scaled(arrays[`output${number}`], quantity.per_drawn) : new Array(arrays.time.length).fill(null)));
    fill(output.caption, h("b", {}, `${quantity.name}, as predicted`), ` [${quantity.drawn}]`,
      ok.models.map((/** @type {string} */ name, /** @type {number} */ number) => h("span", { class: "key", style: { "--of": `var(--${COLOURS[number]})` } }, name)));
  };
  on("desk", draw);
  on("theme", () => [motion, output].forEach((plot) => plot.restyle()));
  return element;
}

/** @param {import("./app.js").Ranking | null | undefined} ranking */
function inWords(ranking) {
  const { answer, settings = {} } = ranking ?? {};
  if (!answer) {
    return h("div", { class: "card" }, h("p", {}, "The ranking tells which experiment would separate what this recording cannot, or show what it could not have shown."),
      h("div", {}, h("button", { type: "button", class: "main", disabled: !told.desk?.rungs.length, onclick: () => act("rank") }, "Find what is missing")));
  }
  const advice = answer.suggested_excitation;
  if (!advice) return h("p", {}, "No further experiment is needed: nothing that would matter is left open.");
  return h(
    "div",
    { class: "card" },
    answer.sentences.filter((line) => line.startsWith("Next experiment")).map((line) => h("p", {}, plain(line))),
    Object.keys(settings).length > 0 && h("dl", { class: "form" }, Object.entries(settings).map(([name, value]) => h("div", {}, h("dt", { class: "small soft" }, worded(name)), h("dd", { style: { margin: 0, "font-weight": 600 } }, value)))),
    advice.separation !== null && advice.separation > 0 && h("p", {}, `In it the wrong model would leave ${short(advice.separation)} times the noise, and so be told apart.`),
    advice.shows.length > 0 && h("p", {}, `It would show, if it is there: ${advice.shows.map(worded).join(", ")}.`),
    answer.unseen.length > 0 && h("p", { class: "soft" }, `This recording could not have shown: ${answer.unseen.map(worded).join(", ")}.`),
    advice.calibration && h("p", {}, h("b", {}, "Calibrate: "), advice.calibration),
    advice.command && h("div", { class: "command" }, h("code", {}, advice.command), h("button", { type: "button", class: "tiny", onclick: () => copy(advice.command) }, "Copy")),
    advice.command_notes.length > 0 && h("ul", { class: "notes" }, advice.command_notes.map((note) => h("li", {}, plain(note)))),
  );
}

/** @param {string} text */
async function copy(text) {
  await navigator.clipboard.writeText(text);
  say("The command is copied.", true);
}
