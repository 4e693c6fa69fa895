// What all parts of the page share: the desk as the server tells it, what this page shows of it,
// and requests.

import { Connection, Refused } from "./connection.js";
import { h } from "./elements.js";

/** Everything the server tells; `null` until it has.
 * @type {{desk: any, job: any, choices: any, study: any, there: boolean}} */
export const told = { desk: null, job: null, choices: null, study: null, there: true };

/** What this page shows: two pages on one desk may show different parts.
 * @type {{stage: string, rung: number | null, beside: null | {kind: "rung" | "second", rung?: number},
 *         stretch: number | null, brush: null | {axis: string, low: number, high: number},
 *         effect: string | null, values: Record<string, number>,
 *         zoom: null | {from: number, to: number}}} */
export const shown = {
  stage: "open", rung: null, beside: null, stretch: null, brush: null, effect: null, values: {},
  zoom: null,
};

/** @type {Map<string, Set<(value: any) => void>>} */
const listeners = new Map();

/**
 * Be told of changes: of `desk`, `job`, `live`, `there`, or of this page's own `stage`, `rung`,
 * `brush`, `values`, `zoom`, `effect`.
 * @param {string} kind
 * @param {(value: any) => void} hear
 */
export function on(kind, hear) {
  let known = listeners.get(kind);
  if (!known) listeners.set(kind, (known = new Set()));
  known.add(hear);
}

/**
 * @param {string} kind
 * @param {any} [value]
 */
export function tell(kind, value) {
  for (const hear of listeners.get(kind) ?? []) hear(value);
}

const connection = new Connection(
  (kind, value) => {
    if (kind === "desk" || kind === "job" || kind === "choices" || kind === "study") told[kind] = value;
    if (kind === "desk") told.job = value.job;
    tell(kind, value);
  },
  (there) => {
    told.there = there;
    tell("there", there);
  },
);

/**
 * @param {string} name
 * @param {Record<string, any>} [more]
 */
export function ask(name, more) {
  return connection.ask(name, more);
}

/**
 * Ask for something, and show why it cannot be done.
 * @param {string} name
 * @param {Record<string, any>} [more]
 * @param {Element | null} [form] where fields stand that the sentence may name
 * @returns {Promise<any>} the answer, or undefined
 */
export async function act(name, more, form = null) {
  try {
    return (await ask(name, more)).ok ?? null;
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
  return rungs.find((/** @type {any} */ each) => each.number === shown.rung) ?? rungs.at(-1) ?? null;
}

/** @param {number | null | undefined} number */
export function rungOf(number) {
  return told.desk?.rungs.find((/** @type {any} */ each) => each.number === number) ?? null;
}

/** @param {string} stage */
export function go(stage) {
  shown.stage = stage;
  tell("stage", stage);
}

/** @param {null | {axis: string, low: number, high: number}} range */
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
