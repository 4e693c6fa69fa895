// Missing: which effect the model lacks. The ranking while it is computed, its curves, Add and undo.

import { act, explain, on, plain, rung, rungOf, shown, told } from "./app.js";
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
    const rows = rowsOf(ranking);
    fill(table, rows.length > 0 && ranked(rows, base, ranking, all ? rows.length : FIRST),
      rows.length > FIRST && !all && h("button", { type: "button", class: "tiny", onclick: () => {
        all = true;
        draw();
      } }, `All ${rows.length} effects`));
  };
  for (const kind of ["desk", "job", "rung", "effect"]) on(kind, draw);
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
  if (chosen) add(chosen.effect, ranking);
}

/** @param {number} by */
export function step(by) {
  const rows = rowsOf(told.desk?.ranking);
  if (!rows.length) return;
  const at = rows.findIndex((row) => row.effect === shown.effect);
  explain(rows[Math.min(Math.max(at + by, 0), rows.length - 1)].effect);
}

/**
 * @param {string} effect
 * @param {any} ranking
 */
function add(effect, ranking) {
  const after = rungOf(ranking?.rung)?.number;
  shown.rung = null;
  act("add", { effect, after });
}

/**
 * @param {any} ranking
 * @param {any} base
 * @param {boolean} running
 */
function heading(ranking, base, running) {
  const begin = h("button", { type: "button", class: running ? "" : "main", disabled: running, "data-key": "rank", title: "Try every effect (r)", onclick: rank },
    ranking?.done ? "Rank again" : running ? "Ranking …" : "Find what is missing");
  const last = told.desk.rungs.at(-1);
  const answer = ranking?.answer;
  return [
    h("div", { class: "row spread" }, h("h2", {}, `Beside ${base.title}`), begin),
    !ranking && h("p", { class: "soft" }, "Every effect of the library is added to the last model of the ladder and fitted. The best is named if it explains the error, and if no other explains it as well."),
    ranking?.done && h("div", { class: "verdict" }, verdict(ranking.text).map((line) => h("p", {}, line))),
    ranking?.done && last.number !== ranking.rung && rungOf(ranking.rung) &&
      h("p", { class: "small soft" }, "Add puts its effect beside that model again; to go on from the last one, rank again."),
    answer?.indistinguishable.length > 1 && h("p", { class: "small" }, "This recording cannot tell apart: ", h("b", {}, answer.indistinguishable.join(", ")), "."),
  ];
}

/** The verdict's sentences; the next experiment has a stage of its own. @param {string} text */
function verdict(text) {
  const lines = plain(text).split("\n");
  const end = lines.findIndex((line) => line.startsWith("Next experiment") || line.startsWith("The next experiment"));
  return end > 0 ? lines.slice(0, end) : lines;
}

/** Whether effects are tried now. */
function trying() {
  return Boolean(told.desk?.ranking && !told.desk.ranking.done && told.job?.title === "effects are tried");
}

/** The effects that are known by now and their errors, the best first. @param {any} ranking @returns {any[]} */
export function rowsOf(ranking) {
  if (!ranking) return [];
  if (ranking.done) return ranking.answer.ranking;
  const rows = trying() ? told.job.rows : ranking.rows;
  return Object.entries(rows)
    .map(([effect, errors]) => ({ effect, family: "", ...errors }))
    .sort((one, other) => one.rmse - other.rmse);
}

/**
 * @param {any[]} rows
 * @param {any} base
 * @param {any} ranking
 * @param {number} most
 */
function ranked(rows, base, ranking, most) {
  const likely = rows.some((row) => typeof row.probability === "number");
  const physics = ranking.physics ?? {};
  return h(
    "table",
    { class: "ranking" },
    h("thead", {}, h("tr", {},
      h("th", { scope: "col" }, "effect"),
      h("th", { scope: "col", class: "bars" }, likely ? "probability" : "error left"),
      h("th", { scope: "col", class: "number" }, "held out"),
      h("th", {}, h("span", { class: "skip" }, "add")))),
    h("tbody", {}, rows.slice(0, most).map((row) => {
      const chosen = shown.effect === row.effect;
      const share = likely ? (row.probability ?? 0) : Math.min(row.rmse / base.rmse, 1);
      const guess = row.converged === false && !likely;
      const words = likely ? `${short(100 * share, 2)} %` : small(row.rmse, base.output);
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
        h("td", { class: "number" }, row.rmse !== null && h("button", {
          type: "button", class: "tiny", "aria-label": `Add ${worded(row.effect)}`, "data-add": row.effect,
          onclick: (/** @type {MouseEvent} */ event) => {
            event.stopPropagation();
            add(row.effect, ranking);
          },
        }, "Add")),
      );
      const why = physics[row.effect];
      return chosen && why ? [line, h("tr", { class: "why" }, h("td", { colspan: 4, class: "small soft" }, why))] : [line];
    })),
  );
}
