// Live: samples, estimates with bands, residual, NIS, faults, the map as it grows; and commands.

import { act, needChoices, on, say } from "./app.js";
import { entry, fill, h, choice, worded } from "./elements.js";
import { choose, inclusions, picture } from "./map.js";
import { short } from "./numbers.js";
import { Plot } from "./plot.js";

/** How much is shown [s], and points of each line at most. */
const SHOWN = 10, POINTS = 4000;
/** The map's size beside the plots [pixels]. */
const NARROW = 250;
const COLOURS = ["predicted", "residual", "explained", "brush", "here", "measured", "noise"];
const STATUS = ["converging", "converged", "no contact", "model rejected", "disturbed"];

/** Values of the last seconds, by name, over a time of their own. */
class Rows {
  constructor() {
    /** @type {number[]} */
    this.time = [];
    /** @type {Record<string, number[]>} */
    this.values = {};
  }

  /**
   * @param {ArrayLike<number>} time
   * @param {Record<string, ArrayLike<number>>} values
   * @param {number} every takes one of so many
   */
  add(time, values, every = 1) {
    const begun = this.time.length && time[0] < this.time[this.time.length - 1];
    if (begun) {
      this.time = [];
      this.values = {};
    }
    for (let n = 0; n < time.length; n += every) {
      this.time.push(time[n]);
      for (const [name, of] of Object.entries(values)) (this.values[name] ??= []).push(of[n]);
    }
    const old = this.time.findIndex((each) => each > this.time[this.time.length - 1] - SHOWN);
    const drop = Math.max(old, this.time.length - POINTS, 0);
    if (drop > POINTS / 10 || this.time.length > POINTS) {
      this.time.splice(0, drop);
      for (const of of Object.values(this.values)) of.splice(0, drop);
    }
  }
}

export function live() {
  const samples = new Rows();
  /** @type {Record<string, Rows>} */
  const estimates = {};
  const state = h("div", { class: "row" });
  const plots = {
    force: new Plot({ name: "Force, live", sync: "live", lines: [{ label: "force", colour: "measured" }] }, h("b", {}, "force"), " [N]"),
    stiffness: new Plot({ name: "Stiffness, live", sync: "live", lines: COLOURS.flatMap((colour) => [{ label: colour, colour, width: 1.8 }, { label: "low", colour, width: 0.6 }, { label: "high", colour, width: 0.6 }]) }),
    innovation: new Plot({ name: "Residual, live", sync: "live", lines: COLOURS.map((colour) => ({ label: colour, colour, width: 1 })) }, h("b", {}, "residual: measured less predicted"), " [mN]"),
    nis: new Plot({ name: "Normalized innovation squared, live", sync: "live", lines: COLOURS.map((colour) => ({ label: colour, colour, width: 1 })) }, h("b", {}, "NIS"), "1 where the model is right, averaged over 50 blocks"),
  };
  const grid = h("div", {});
  const health = h("ul", { class: "notes" });
  const fault = h("p", { class: "problem" });
  const words = h("div", {});
  const model = h("section", { "aria-label": "Model" });
  const panel = h("aside", { class: "panel", "aria-label": "Live" }, h("section", {}, h("h2", {}, "Driver"), state, fault), commands(), h("section", {}, h("h2", {}, "Estimators"), words), model, h("section", { class: "mapgrid live" }, h("h2", {}, "Map"), grid), h("section", {}, h("h2", {}, "Health"), health));
  const column = h("div", { class: "charts" }, h("div", { class: "column live" }, Object.values(plots).map((plot) => plot.element)));
  const element = h("div", { class: "work" }, column, panel);
  let drawn = 0, judged = "null";
  on("live", (message) => {
    const { arrays } = message;
    if (arrays.time) samples.add(arrays.time, { force: arrays.force, position: arrays.position }, 5);
    for (const name of message.estimators) {
      const part = (/** @type {string} */ value) => arrays[`${name}.${value}`];
      (estimates[name] ??= new Rows()).add(part("time"), {
        stiffness: part("stiffness"), variance: part("stiffness_variance"), innovation: part("innovation"),
        nis: part("normalized_innovation_squared"), status: part("status"),
      });
    }
    fill(state, h("b", {}, message.state || "not heard of yet"));
    fault.textContent = message.fault;
    if (JSON.stringify(message.verdict) !== judged) {
      judged = JSON.stringify(message.verdict);
      fill(model, message.verdict && verdict(message.verdict));
    }
    if (performance.now() - drawn < 90 || !element.isConnected) return;
    drawn = performance.now();
    draw(plots, samples, estimates);
    fill(words, Object.entries(estimates).map(([name, rows], number) => inWords(name, rows, number)));
    fill(health, message.health.map(([name, level, text]) =>
      h("li", { class: level ? "bad" : "" }, `${name}: ${text || "well"}`)));
  });
  let layer = "mean";
  /** @type {import("./app.js").Changes["live_map"] | null} */
  let map = null;
  const drawMap = () => map && fill(grid, choose(map.arrays, layer, (name) => {
    layer = name;
    drawMap();
  }), picture(map, map.arrays, layer, null, NARROW), map.text.split("\n").map((line) => h("p", { class: "small" }, line)), inclusions(map));
  on("live_map", (found) => {
    map = found;
    drawMap();
  });
  on("theme", () => {
    Object.values(plots).forEach((plot) => plot.restyle());
    drawMap();
  });
  return element;
}

/**
 * @param {string} name
 * @param {Rows} rows
 * @param {number} number
 */
function inWords(name, rows, number) {
  const last = (/** @type {string} */ value) => rows.values[value]?.at(-1) ?? NaN;
  return h("div", { class: "row spread" },
    h("span", { class: "key", style: { color: `var(--${COLOURS[number % COLOURS.length]})` } }, h("b", {}, worded(name))),
    h("span", {}, `${short(last("stiffness"), 4)} ± ${short(1.96 * Math.sqrt(last("variance")), 2)} N/m`),
    h("span", { class: "small soft" }, STATUS[last("status")] ?? ""));
}

/**
 * The monitor's verdict on the model, in a few lines.
 * @param {import("./told.js").VerdictMessage} found
 */
function verdict(found) {
  const times = (/** @type {number | null} */ error) => (error === null ? "not known" : `${short(error, 3)} times the noise`);
  return [
    h("h2", {}, "Model"), h("p", {}, h("b", {}, found.verdict)),
    found.effects.map(([name, probability]) => h("div", { class: "row spread" }, h("span", {}, worded(name)), h("span", {}, short(probability, 2)))),
    h("p", { class: "small" }, `The model leaves ${times(found.error_current)}, the proposed one ${times(found.error_proposed)}.`),
    found.unseen.length ? h("p", { class: "small" }, `Not shown by this motion: ${found.unseen.map(worded).join(", ")}.`) : [],
    found.experiment ? h("p", { class: "small" }, `Next: ${found.experiment}`) : [],
  ];
}

/**
 * @param {{force: Plot, stiffness: Plot, innovation: Plot, nis: Plot}} plots
 * @param {Rows} samples
 * @param {Record<string, Rows>} estimates
 */
function draw(plots, samples, estimates) {
  const now = Math.max(samples.time.at(-1) ?? 0, ...Object.values(estimates).map((rows) => rows.time.at(-1) ?? 0));
  const limits = { x: /** @type {[number, number]} */ ([-SHOWN, 0]) };
  const since = (/** @type {number[]} */ time) => time.map((each) => each - now);
  plots.force.show(since(samples.time), [samples.values.force ?? []], limits);
  const named = Object.entries(estimates).slice(0, COLOURS.length);
  const time = [...new Set(named.flatMap(([, rows]) => rows.time))].sort((one, other) => one - other);
  const place = new Map(time.map((each, number) => [each, number]));
  const blank = () => /** @type {(number | null)[]} */ (new Array(time.length).fill(null));
  const lined = (/** @type {(rows: Rows, n: number) => number} */ value) => COLOURS.map((_, number) => {
    const line = blank(), rows = named[number]?.[1];
    rows?.time.forEach((at, n) => (line[place.get(at) ?? 0] = value(rows, n)));
    return line;
  });
  const x = since(time);
  const centre = lined((rows, n) => rows.values.stiffness[n]);
  const off = (/** @type {number} */ sign) => lined((rows, n) => rows.values.stiffness[n] + sign * 1.96 * Math.sqrt(rows.values.variance[n]));
  const low = off(-1), high = off(1);
  plots.stiffness.show(x, centre.flatMap((line, n) => [line, low[n], high[n]]), { ...limits, y: around(centre) });
  plots.innovation.show(x, lined((rows, n) => 1e3 * rows.values.innovation[n]), limits);
  plots.nis.show(x, lined((rows, n) => mean(rows.values.nis, n)), limits);
  fill(plots.stiffness.caption, h("b", {}, "stiffness with 95 % bands"), " [N/m]", named.map(([name], number) =>
    h("span", { class: "key", style: { "--of": `var(--${COLOURS[number]})` } }, worded(name))));
}

/** The mean of the last fifty. @param {number[]} values @param {number} n */
function mean(values, n) {
  const part = values.slice(Math.max(0, n - 49), n + 1);
  return part.reduce((sum, each) => sum + each, 0) / part.length;
}

/** Limits about the middle nine tenths: a filter that begins anew is far off for a moment. @param {(number | null)[][]} lines @returns {[number, number]} */
function around(lines) {
  const known = /** @type {number[]} */ (lines.flat().filter((each) => each !== null && Number.isFinite(each))).sort((one, other) => one - other);
  if (!known.length) return [0, 1];
  const low = known[Math.floor(known.length * 0.05)], high = known[Math.floor(known.length * 0.95)];
  const more = 0.35 * (high - low) || 0.1 * Math.abs(high) || 1;
  return [low - more, high + more];
}

function commands() {
  const place = h("section", { "aria-label": "Commands" });
  on("choices", () => {
    if (!needChoices().commands) {
      fill(place, h("p", { class: "small soft" }, "This page only listens; the workbench was started without --allow-commands."));
      return;
    }
    const button = (/** @type {string} */ name, /** @type {string} */ label, kind = "") =>
      h("button", { type: "button", class: kind, onclick: () => command(name) }, label);
    const excite = form("Excite", "excite", [
      choice("kind", "kind", ["sine", "chirp", "stepped_sweep", "multisine"], "sine"),
      entry("amplitude [V]", "amplitude", "0.85"), entry("frequency [Hz]", "frequency", "10"),
    ]);
    const scan = form("Scan", "scan", [
      entry("rows", "rows", "5"), entry("columns", "columns", "5"), entry("spacing [m]", "spacing", "0.01"), entry("dwell [s]", "dwell_time", "1"),
    ]);
    fill(place, h("h2", {}, "Commands"), h("div", { class: "row" }, button("configure", "Configure"), button("start", "Start", "main"), button("stop", "Stop"), button("emergency_stop", "Emergency stop"), button("reset", "Reset")), excite, scan);
  });
  return place;
}

/**
 * @param {string} title
 * @param {string} name
 * @param {Element[]} fields
 */
function form(title, name, fields) {
  const element = h("form", {
    onsubmit: (/** @type {SubmitEvent} */ event) => {
      event.preventDefault();
      /** @type {Record<string, unknown>} */
      const given = {};
      for (const [key, value] of new FormData(element)) {
        given[key] = key === "kind" ? value : Number(value);
      }
      if (name === "scan") given.origin = [0, 0, 0];
      command(name, given);
    },
  }, h("details", {}, h("summary", {}, title), h("div", { class: "form" }, fields, h("button", { type: "submit" }, title))));
  return element;
}

/**
 * @param {string} name
 * @param {Record<string, unknown>} [given]
 */
async function command(name, given = {}) {
  const said = await act("command", { command: name, given });
  if (said !== undefined) say(String(said), true);
}
