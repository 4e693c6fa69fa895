// Compare: where the model fails, in sentences, and its values as sliders.

import { brush, on, plain, rung, shown, tell } from "./app.js";
import { fill, h, worded } from "./elements.js";
import { short, small, unit } from "./numbers.js";

/** Steps of a slider: finer than the pixels of the widest. */
const STEPS = 2000;

export function compare() {
  const figures = h("dl", { class: "figures" });
  const marks = h("ul", { class: "marks" });
  const values = h("section", { "aria-label": "Values" });
  const notes = h("section", {});
  const element = h(
    "aside",
    { class: "panel", "aria-label": "Compare" },
    h("section", {}, figures),
    h("section", {}, h("h2", {}, "Here it fails"), marks),
    values,
    notes,
  );
  /** @type {number | null} */
  let drawn = null;
  const draw = () => {
    const own = rung();
    if (!own) return;
    drawFigures(figures, own, null);
    if (drawn !== own.number) drawValues(values, own);
    drawn = own.number;
    fill(notes, details(own));
  };
  on("desk", draw);
  on("rung", () => {
    drawn = null;
    draw();
  });
  on("lines", (lines) => {
    const own = rung();
    if (own) drawFigures(figures, own, lines.rmse ?? null);
  });
  on("regions", ({ regions }) => drawMarks(marks, regions));
  return element;
}

/**
 * @param {Element} place
 * @param {import("./app.js").Rung} own
 * @param {number | null} moved the error at the sliders' values
 */
function drawFigures(place, own, moved) {
  const figure = (/** @type {string} */ name, /** @type {string} */ value, kind = "") => h("div", {}, h("dt", {}, name), h("dd", { class: kind }, value));
  fill(
    place,
    figure(moved === null ? "error, rms" : "error, moved", small(moved ?? own.rmse, own.output), moved !== null && moved > own.rmse * 1.001 ? "bad" : ""),
    figure("held out", small(own.heldout, own.output)),
    figure("noise", small(own.noise, own.output)),
  );
}

/**
 * @param {Element} place
 * @param {import("./told.js").ProfileMessage[]} regions
 */
function drawMarks(place, regions) {
  const found = regions.flatMap((each) => (each.here ? [{ ...each, here: each.here }] : []));
  const axes = /** @type {Record<string, number>} */ ({ indentation: 1e-3, speed: 1e-3 });
  fill(
    place,
    found.length
      ? found.sort((one, other) => Number(other.foremost) - Number(one.foremost)).map((each) => {
        const by = axes[each.axis] ?? 1;
        const range = { axis: /** @type {import("./told.js").Brush["axis"]} */ (each.axis), low: each.here.begin * by, high: each.here.end * by };
        const way = each.axis === "direction";
        return h("li", {}, h("button", {
          type: "button", class: each.foremost ? "foremost" : "", title: "Brush these samples in all plots",
          onclick: () => brush(way ? { axis: "speed", low: each.here.begin < 0 ? -1e9 : 0, high: each.here.begin < 0 ? 0 : 1e9 } : range),
        }, each.foremost ? h("b", {}, "Here: ") : null, each.told));
      })
      : h("li", { class: "soft" }, "The error stands out nowhere."),
  );
}

/**
 * @param {Element} place
 * @param {import("./app.js").Rung} own
 */
function drawValues(place, own) {
  const back = h("button", { type: "button", class: "tiny", "data-key": "fit", title: "Back to the fitted values (f)", onclick: () => fit() }, "Fit");
  const rows = own.parameters.map((each) => parameter(each));
  fill(
    place,
    h("div", { class: "row spread" }, h("h2", {}, "Values, 95 % intervals"), back),
    rows.length ? rows : h("p", { class: "soft" }, "All values are held."),
    own.converged ? null : h("p", { class: "bad small" }, "The fit did not settle: take its values for a guess."),
  );
}

/** Put the sliders back to the fitted values. */
export function fit() {
  shown.values = {};
  tell("values");
  tell("fit");
}

/** @param {import("./told.js").ParameterMessage} each */
function parameter(each) {
  const range = each.to - each.from || 1;
  const share = (/** @type {number} */ value) => Math.min(Math.max((value - each.from) / range, 0), 1);
  const low = 100 * share(each.low ?? each.from), high = 100 * share(each.high ?? each.to);
  const number = h("input", { type: "text", inputmode: "decimal", value: short(each.value, 5), "aria-label": `${worded(each.name)}, ${each.unit}` });
  const slider = h("input", { type: "range", min: 0, max: STEPS, value: Math.round(share(each.value) * STEPS), "aria-label": worded(each.name) });
  const row = h(
    "div",
    { class: `parameter${each.at_limit ? " limit" : ""}`, "data-parameter": each.name },
    h("span", { class: "name", title: `${short(each.low, 5)} to ${short(each.high, 5)} ${each.unit}` }, worded(each.name)),
    number,
    h("span", { class: "unit" }, unit(each.unit)),
    h(
      "div",
      { class: "track" },
      h("span", { class: "interval", style: { left: `${low}%`, width: `${Math.max(high - low, 0.2)}%` } }),
      slider,
    ),
  );
  const move = (/** @type {number} */ value) => {
    shown.values = { ...shown.values, [each.name]: value };
    row.classList.add("moved");
    slider.setAttribute("aria-valuetext", `${short(value, 5)} ${each.unit}`);
    tell("values");
  };
  slider.addEventListener("input", () => {
    const value = each.from + (range * Number(slider.value)) / STEPS;
    number.value = short(value, 5);
    move(value);
  });
  number.addEventListener("change", () => {
    const value = Number(number.value.replace(",", "."));
    if (!Number.isFinite(value)) {
      number.value = short(each.value, 5);
      return;
    }
    slider.value = String(Math.round(share(value) * STEPS));
    move(value);
  });
  on("fit", () => {
    row.classList.remove("moved");
    number.value = short(each.value, 5);
    slider.value = String(Math.round(share(each.value) * STEPS));
  });
  return row;
}

/** @param {import("./app.js").Rung} own */
function details(own) {
  return [
    own.notes.length > 0 && h("details", { open: own.notes.length < 3 }, h("summary", {}, `${own.notes.length} notes on the samples`),
      h("ul", { class: "notes" }, own.notes.map((note) => h("li", {}, plain(note))))),
    own.second_told && h("p", { class: "small bad" }, `Second recording: ${plain(own.second_told)}`),
    h("details", {}, h("summary", {}, "In words"), h("pre", { class: "mono", style: { "white-space": "pre-wrap", margin: 0 } }, plain(own.text))),
  ];
}
