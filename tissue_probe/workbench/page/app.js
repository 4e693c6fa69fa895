// What all parts of the page share: the desk as the server tells it, what this page shows of it,
// and requests.

import { Connection, Refused } from "./connection.js";
import { h } from "./elements.js";

/** @typedef {import("./told.js").DeskMessage} Desk */
/** @typedef {import("./told.js").RungMessage} Rung */
/** @typedef {import("./told.js").RankingMessage} Ranking */
/** @typedef {import("./connection.js").Requests} Requests */

/** Everything the server tells; `null` until it has.
 * @type {{desk: Desk | null, job: import("./told.js").JobMessage | null,
 *   choices: import("./told.js").ChoicesMessage | null,
 *   study: import("./told.js").StudyMessage | null, there: boolean}} */
export const told = { desk: null, job: null, choices: null, study: null, there: true };

/** What this page shows: two pages on one desk may show different parts.
 * @type {{stage: string, rung: number | null, beside: null | {kind: "rung" | "second", rung?: number},
 *         stretch: number | null, brush: null | import("./told.js").Brush,
 *         effect: string | null, values: Record<string, number>,
 *         zoom: null | {from: number, to: number}}} */
export const shown = {
  stage: "open", rung: null, beside: null, stretch: null, brush: null, effect: null, values: {},
  zoom: null,
};

/** The desk, for what runs only once it has come. */
export function needDesk() {
  if (!told.desk) throw new Error("the desk has not come");
  return told.desk;
}

/** The choices of the forms, for what runs only once they have come. */
export function needChoices() {
  if (!told.choices) throw new Error("the choices have not come");
  return told.choices;
}

/**
 * What listeners are told, by its kind: news of the server, and changes of what the page shows.
 * @typedef {import("./connection.js").Heard & {there: boolean, stage: string,
 *   rung: number | null | undefined, brush: typeof shown.brush, zoom: typeof shown.zoom,
 *   effect: string | null, theme: string, values: undefined, fit: undefined, beside: undefined,
 *   unbrush: undefined, unzoom: undefined, lines: import("./told.js").LinesMessage,
 *   regions: {regions: import("./told.js").ProfileMessage[],
 *     marked: import("./told.js").BrushMessage | undefined}}} Changes
 */

/** @type {Map<string, Set<(value: never) => void>>} */
const listeners = new Map();

/**
 * Be told of changes: of `desk`, `job`, `live`, `there`, or of this page's own `stage`, `rung`,
 * `brush`, `values`, `zoom`, `effect`.
 * @template {keyof Changes} K
 * @param {K} kind
 * @param {(value: Changes[K]) => void} hear
 */
export function on(kind, hear) {
  let known = listeners.get(kind);
  if (!known) listeners.set(kind, (known = new Set()));
  known.add(hear);
}

/**
 * @template {keyof Changes} K
 * @param {K} kind
 * @param {Changes[K]} [value]
 */
export function tell(kind, value) {
  for (const hear of listeners.get(kind) ?? []) hear(/** @type {never} */ (value));
}

const connection = new Connection(
  (kind, value) => {
    if (kind === "desk" || kind === "job" || kind === "choices" || kind === "study") Object.assign(told, { [kind]: value });
    if (kind === "desk") told.job = needDesk().job;
    tell(kind, /** @type {never} */ (value));
  },
  (there) => {
    told.there = there;
    tell("there", there);
  },
);

/**
 * @template {keyof Requests} N
 * @param {N} name
 * @param {Requests[N]} [more]
 */
export function ask(name, more) {
  return connection.ask(name, more);
}

/**
 * Ask for something, and show why it cannot be done.
 * @template {keyof Requests} N
 * @param {N} name
 * @param {Requests[N]} [more]
 * @param {Element | null} [form] where fields stand that the sentence may name
 * @returns {Promise<import("./connection.js").Answers[N] | undefined>} the answer, or undefined
 */
export async function act(name, more, form = null) {
  try {
    return (await ask(name, more)).ok;
  } catch (error) {
    refuse(error, form);
    return undefined;
  }
}

/**
 * Show a sentence at the fields that it names, or in the corner where it names none.
 * @param {unknown} error
 * @param {Element | null} [form]
 */
export function refuse(error, form = null) {
  if (!(error instanceof Refused)) {
    say(String(error));
    return;
  }
  if (error.cancelled) return;
  const sentence = plain(error.message);
  // What fills the stage is not said again in the corner.
  if (!form && told.desk?.refusal?.told === error.message) return;
  const place = form?.querySelector(".problem");
  if (!place) {
    say(sentence);
    return;
  }
  place.textContent = sentence;
  mark(form, error.fields);
}

/**
 * Mark the fields that a sentence names.
 * @param {Element | null} form
 * @param {string[]} fields
 */
export function mark(form, fields) {
  for (const label of form?.querySelectorAll("[data-field]") ?? []) {
    label.classList.toggle("wrong", fields.includes(label.getAttribute("data-field") ?? ""));
  }
}

/** A sentence of the server's, whose parameters stand in backticks. @param {string} sentence */
export function plain(sentence) {
  return sentence.replace(/`([a-z_]+)`/g, (_, name) => name.replaceAll("_", " "));
}

/** How long a sentence stays in the corner at least, and for each character [ms]. */
const STAYS = 4000, READ = 60;

/**
 * @param {string} sentence
 * @param {boolean} [well]
 */
export function say(sentence, well = false) {
  const corner = document.getElementById("told");
  const note = h(
    "div",
    { class: well ? "well" : "" },
    h("span", {}, sentence),
    h("button", { class: "quiet tiny", type: "button", "aria-label": "Close", onclick: () => note.remove() }, "×"),
  );
  corner?.append(note);
  while (corner && corner.children.length > 3) corner.firstElementChild?.remove();
  setTimeout(() => note.remove(), STAYS + READ * sentence.length);
}

/** The rung that is shown: that which is chosen, or the last. */
export function rung() {
  const rungs = told.desk?.rungs ?? [];
  return rungs.find((each) => each.number === shown.rung) ?? rungs.at(-1) ?? null;
}

/** @param {number | null | undefined} number */
export function rungOf(number) {
  return told.desk?.rungs.find((each) => each.number === number) ?? null;
}

/** @param {string} stage */
export function go(stage) {
  shown.stage = stage;
  tell("stage", stage);
}

/** @param {null | import("./told.js").Brush} range */
export function brush(range) {
  shown.brush = range;
  tell("brush", range);
}

/** @param {null | {from: number, to: number}} part of the record's time */
export function zoom(part) {
  shown.zoom = part;
  tell("zoom", part);
}

/** @param {string | null} effect */
export function explain(effect) {
  shown.effect = effect;
  tell("effect", effect);
}

/** @param {number | null} number */
export function choose(number) {
  shown.rung = number;
  shown.values = {};
  if (shown.beside?.kind === "rung" && shown.beside.rung === number) shown.beside = null;
  tell("rung", number);
}
