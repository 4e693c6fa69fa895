// Missing: which effect the model lacks. The ranking while it is computed, its curves, Add and undo.

import { act, explain, go, needDesk, on, plain, rung, rungOf, shown, told } from "./app.js";
import { fill, h, worded } from "./elements.js";
import { short, small } from "./numbers.js";
import { own } from "./own.js";

/** Rows that are shown before the rest is asked for. */
const FIRST = 12;

export function missing() {
  const head = h("section", {});
  const table = h("section", { "aria-label": "Ranking" });
  const mine = own();
  const element = h("aside", { class: "panel", "aria-label": "Missing" }, head, table, mine);
  let all = false;
  const draw = () => {
    const ranking = told.desk?.ranking, base = rungOf(ranking?.rung) ?? rung();
    if (!base) return;
    fill(head, heading(ranking, base, trying()));
    const rows = rowsOf(ranking), settled = rows.filter((row) => row.converged !== false);
    const few = settled.slice(0, FIRST), more = rows.length - few.length;
    fill(table, rows.length > 0 && ranked(all ? rows : few, base, ranking),
      more > 0 && !all && h("button", { type: "button", class: "tiny", onclick: () => {
        all = true;
        draw();
      } }, `All ${rows.length} effects${rows.length > settled.length ? `; the search gave up for ${rows.length - settled.length}` : ""}`));
  };
  for (const kind of /** @type {const} */ (["desk", "job", "rung", "effect"])) on(kind, draw);
  return element;
}

/** Rank the effects beside the last rung. */
export function rank() {
  act("rank");
}

/** Add the effect whose row is chosen, or the best. */
export function addChosen() {
  const { ranking } = told.desk ?? {};
  const rows = rowsOf(ranking);
  const chosen = rows.find((row) => row.effect === shown.effect) ?? rows[0];
  if (chosen && !has(chosen.effect)) add([chosen.effect]);
}

/** @param {number} by */
export function step(by) {
  const rows = rowsOf(told.desk?.ranking);
  if (!rows.length) return;
  const at = rows.findIndex((row) => row.effect === shown.effect);
  explain(rows[Math.min(Math.max(at + by, 0), rows.length - 1)].effect);
}

/** Whether effects are being added: a second click does not add them again. */
let adding = false;

/**
 * Add effects one after the other.
 * @param {string[]} effects
 * @param {number} [after] the rung that they are to stand on; those above it are taken down
 */
async function add(effects, after) {
  if (adding) return;
  adding = true;
  shown.rung = null;
  for (const effect of effects) {
    if ((await act("add", { effect, after })) === undefined) break;
    after = undefined;
  }
  adding = false;
}

/** Whether the last model of the ladder has an effect. @param {string} effect */
function has(effect) {
  return needDesk().rungs.some((each) => each.added === effect);
}

/**
 * @param {import("./app.js").Ranking | null | undefined} ranking
 * @param {import("./app.js").Rung} base
 * @param {boolean} running
 */
function heading(ranking, base, running) {
  const begin = h("button", { type: "button", class: running ? "" : "main", disabled: running, "data-key": "rank", title: "Try every effect (r)", onclick: rank },
    ranking?.done ? "Rank again" : running ? "Ranking …" : "Find what is missing");
  const answer = ranking?.answer;
  const named = (answer?.effects ?? []).filter((effect) => rungOf(ranking?.rung) && !has(effect));
  return [
    h("div", { class: "row spread" }, h("h2", {}, `Beside ${base.title}`), begin),
    !ranking && h("p", { class: "soft" }, "Every effect of the library is added to the last model of the ladder and fitted. The best is named if it explains the error, and if no other explains it as well."),
    answer && h("div", { class: "verdict" }, verdict(answer.sentences).map((line) => h("p", {}, line))),
    ranking?.shape && h("img", { class: "shape", alt: "The missing force over the variables that it depends on", src: `data:image/svg+xml,${encodeURIComponent(ranking.shape)}` }),
    named.length > 1 && answer?.verdict === "missing" &&
      h("button", { type: "button", "data-key": "all", onclick: () => add(named) }, `Add ${named.map(worded).join(" and ")}`),
    ranking?.done && needDesk().second === null && h("div", { class: "row" },
      h("p", { class: "small soft" }, "This is of one recording. A second one of the same specimen, moved otherwise, tells whether the model carries over."),
      h("button", { type: "button", class: "tiny", "data-key": "second", onclick: () => go("open") }, "Add a second recording")),
    answer && answer.indistinguishable.length > 1 && h("p", { class: "small" }, "This recording cannot tell apart: ", h("b", {}, answer.indistinguishable.join(", ")), "."),
  ];
}

/** The answer's sentences; the next experiment has a stage of its own. @param {string[]} sentences */
function verdict(sentences) {
  const end = sentences.findIndex((line) => line.startsWith("Next experiment"));
  return (end > 0 ? sentences.slice(0, end) : sentences).map(plain);
}

/** A probability in words: nothing is improbable to the last digit. @param {number} share */
function percent(share) {
  return share < 1e-3 ? "< 0.1 %" : `${short(100 * share, 2)} %`;
}

/** Whether effects are tried now. */
function trying() {
  return Boolean(told.desk?.ranking && !told.desk.ranking.done && told.job?.title === "effects are tried");
}

/** The effects that are known by now and their errors, the best first. @param {import("./app.js").Ranking | null | undefined} ranking @returns {import("./told.js").RankedMessage[]} */
export function rowsOf(ranking) {
  if (!ranking) return [];
  if (ranking.answer) return ranking.answer.ranking;
  const rows = (trying() && told.job?.rows) || ranking.rows;
  return Object.entries(rows)
    .map(([effect, errors]) => ({ effect, family: "", ...errors }))
    .sort((one, other) => (one.rmse ?? Infinity) - (other.rmse ?? Infinity));
}

/**
 * @param {import("./told.js").RankedMessage[]} rows
 * @param {import("./app.js").Rung} base
 * @param {import("./app.js").Ranking | null | undefined} ranking
 */
function ranked(rows, base, ranking) {
  const likely = rows.some((row) => typeof row.probability === "number");
  const physics = ranking?.physics ?? {};
  return h(
    "table",
    { class: "ranking" },
    h("thead", {}, h("tr", {},
      h("th", { scope: "col" }, "effect"),
      h("th", { scope: "col", class: "bars" }, likely ? "probability" : "error left"),
      h("th", { scope: "col", class: "number" }, "held out"),
      h("th", {}, h("span", { class: "skip" }, "add")))),
    h("tbody", {}, rows.map((row) => {
      const chosen = shown.effect === row.effect;
      const share = likely ? (row.probability ?? 0) : Math.min((row.rmse ?? 0) / base.rmse, 1);
      const guess = row.converged === false;
      const words = likely ? percent(share) : small(row.rmse, base.output);
      const line = h(
        "tr",
        {
          "aria-selected": chosen, tabindex: 0, "data-key": `row-${row.effect}`, "data-effect": row.effect,
          title: physics[row.effect] ?? "",
          onclick: () => explain(chosen ? null : row.effect),
          onkeydown: (/** @type {KeyboardEvent} */ event) => event.key === " " && (event.preventDefault(), explain(chosen ? null : row.effect)),
        },
        h("td", { class: "effect" }, worded(row.effect)),
        h("td", { class: "bars" }, h("div", { class: `share${likely ? " sure" : ""}`, role: "img", "aria-label": words }, h("i", { style: { width: `${100 * share}%` } })), h("span", { class: "small soft", title: guess ? "The search did not settle: a guess" : "" }, row.rmse === null ? "" : `${guess ? "≈ " : ""}${words}`)),
        h("td", { class: "number" }, row.heldout_rmse === null ? "" : small(row.heldout_rmse, base.output)),
        h("td", {}, row.rmse !== null && h("div", { class: "steps" }, steps(row.effect, ranking))),
      );
      const why = physics[row.effect];
      return chosen && why ? [line, h("tr", { class: "why" }, h("td", { colspan: 4, class: "small soft" }, why))] : [line];
    })),
  );
}

/**
 * What can be done with an effect: put it on the last model, or in the place of what stands above
 * the model that was ranked.
 * @param {string} effect
 * @param {import("./app.js").Ranking | null | undefined} ranking
 */
function steps(effect, ranking) {
  const button = (/** @type {string} */ word, /** @type {string} */ title, /** @type {number | undefined} */ after) => h("button", {
    type: "button", class: "tiny", title, "aria-label": `${word} ${worded(effect)}`, [`data-${word.toLowerCase()}`]: effect,
    onclick: (/** @type {MouseEvent} */ event) => {
      event.stopPropagation();
      add([effect], after);
    },
  }, word);
  const base = rungOf(ranking?.rung), last = needDesk().rungs.at(-1);
  return [
    has(effect) ? h("span", { class: "small soft" }, "added") : button("Add", "Add it to the last model", undefined),
    base && base !== last && !has(effect) &&
      button("Replace", `Add it to ${base.title}, in the place of later effects`, base.number),
  ];
}
