// The ladder at the top: each model with its error, down to the noise; and what is under way.

import { act, choose, go, on, rung, shown, told } from "./app.js";
import { fill, h } from "./elements.js";
import { short, small, span } from "./numbers.js";

/**
 * @param {Element} rungs
 * @param {Element} status
 */
export function ladder(rungs, status) {
  const draw = () => drawLadder(rungs);
  on("desk", draw);
  on("rung", draw);
  on("beside", draw);
  const tell = () => drawStatus(status);
  on("desk", tell);
  on("job", tell);
}

/** @param {Element} place */
function drawLadder(place) {
  const rungs = told.desk?.rungs ?? [];
  if (!rungs.length) {
    fill(place, h("p", {}, told.desk?.files.length ? "The ladder begins with the first fitted model." : ""));
    return;
  }
  const most = Math.max(...rungs.map((each) => each.rmse));
  const least = Math.min(...rungs.map((each) => each.noise)) / 1.5;
  const share = (/** @type {number} */ error) => Math.max(0, Math.log(error / least) / Math.log(most / least || 2));
  const cards = rungs.flatMap((each, number) => {
    const left = h("span", { class: "level", style: { width: `${100 * Math.min(share(each.rmse), 1)}%` } });
    const floor = h("span", { class: "floor", style: { left: `${100 * Math.min(share(each.noise), 1)}%` } });
    const chosen = rung()?.number === each.number;
    const second = each.second ? ` · second ${small(each.second.rmse, each.output)}` : "";
    const card = h(
      "button",
      {
        type: "button", class: `rung${shown.beside?.rung === each.number ? " other" : ""}`,
        "aria-pressed": chosen, "data-key": `rung${each.number}`,
        title: `${each.title}: error ${small(each.rmse, each.output)}, held out ${small(each.heldout, each.output)}, noise ${small(each.noise, each.output)}`,
        onclick: () => {
          choose(each.number === rungs.at(-1)?.number ? null : each.number);
          if (!["compare", "missing", "next"].includes(shown.stage)) go("compare");
        },
      },
      h("span", { class: "name" }, number ? `+ ${each.added}` : each.title),
      h("b", { class: "error" }, small(each.rmse, each.output)),
      h("span", { class: "rest" }, `${short(each.rmse / each.noise)} × noise${second}`),
      left, floor,
    );
    return number ? [h("span", { class: "arrow", "aria-hidden": "true" }, "→"), card] : [card];
  });
  const undo = rungs.length > 1 &&
    h("button", { type: "button", class: "quiet", style: { "align-self": "center" }, title: "Take the last effect away (u)", "data-key": "undo", onclick: () => act("undo") }, "↶ Undo");
  fill(place, cards, undo);
  const last = place.querySelector(".rung:last-of-type");
  last?.scrollIntoView({ block: "nearest", inline: "nearest" });
}

/** @param {Element} place */
function drawStatus(place) {
  const { job } = told;
  if (!job) {
    fill(place);
    return;
  }
  const bar = h("progress", { max: 1, "aria-label": job.title });
  if (job.share !== null && job.share !== undefined) bar.value = job.share;
  fill(
    place,
    h("div", { class: "doing" }, h("div", {}, job.title), h("div", { class: "small soft" }, [job.doing, job.seconds >= 1 && span(job.seconds)].filter(Boolean).join(" · "))),
    bar,
    h("button", { type: "button", class: "tiny", "data-key": "cancel", title: "Cancel (Esc)", onclick: () => act("cancel") }, "Cancel"),
  );
}
