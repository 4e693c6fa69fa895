// Map: stiffness over the sites of a scan; a site opens its recording.

import { act, go, on, told } from "./app.js";
import { fill, h, svg, worded } from "./elements.js";
import { short } from "./numbers.js";

/** From soft to stiff: Matplotlib's cividis in nine steps, read alike by the colour-blind. */
const SCALE = ["#00224e", "#123570", "#3b496c", "#575d6d", "#707173", "#8a8678", "#a59c74", "#c3b369", "#fee838"];
const SIDE = 46, EDGE = 44;
/** A map of few sites is drawn at most so many times as large: its words would grow with it. */
const LARGEST = 1.6;

const LAYERS = {
  stiffness: { label: "stiffness", unit: "N/m" },
  damping: { label: "damping", unit: "N s/m" },
  stiffness_stddev: { label: "standard deviation of the stiffness", unit: "N/m" },
  inclusion_probability: { label: "P(inclusion)", unit: "" },
  could_hide: { label: "could hide an inclusion", unit: "" },
};
/** @typedef {keyof typeof LAYERS} Layer */

export function map() {
  const element = h("div", { class: "sheet" });
  /** @type {Layer} */
  let layer = "stiffness";
  const draw = () => {
    const found = told.desk?.map;
    if (!found) {
      fill(element, h("div", { class: "empty" }, h("p", {}, "A recording of a scan, with its sites, gives a map."), h("button", { type: "button", onclick: () => go("open") }, "Open a scan")));
      return;
    }
    const there = /** @type {Layer[]} */ (Object.keys(LAYERS)).filter((name) => found.cells.some((/** @type {any} */ cell) => typeof cell[name] === "number" || typeof cell[name] === "boolean"));
    if (!there.includes(layer)) layer = "stiffness";
    const pick = (/** @type {Layer} */ name) => {
      layer = name;
      draw();
    };
    fill(
      element,
      h("div", { class: "row spread" }, h("h1", {}, "Map"), h("div", { class: "row" }, there.map((name) =>
        h("button", { type: "button", class: "tiny", "aria-pressed": name === layer, "data-key": `layer-${name}`, onclick: () => pick(name) }, LAYERS[name].label)))),
      h("div", { class: "mapgrid" }, picture(found, layer), side(found)),
    );
  };
  on("desk", draw);
  draw();
  return element;
}

/**
 * @param {any} found
 * @param {Layer} layer
 */
export function picture(found, layer) {
  const { x, y, cells } = found;
  const values = cells.map((/** @type {any} */ cell) => Number(cell[layer])).filter(Number.isFinite);
  const low = Math.min(...values), high = Math.max(...values);
  const wide = EDGE + SIDE * x.length + 74, tall = SIDE * y.length + 40;
  const drawing = svg("svg", { viewBox: `0 0 ${wide} ${tall}`, role: "group", "aria-label": `Map of the ${LAYERS[layer].label}` });
  drawing.style.setProperty("max-width", `${LARGEST * wide}px`);
  cells.forEach((/** @type {any} */ cell, /** @type {number} */ number) => {
    const column = number % x.length, row = Math.floor(number / x.length);
    const value = Number(cell[layer]), known = cell[layer] !== null && Number.isFinite(value);
    const site = nearest(found.sites, cell);
    const words = `${known ? `${short(value, 4)} ${LAYERS[layer].unit}` : worded(cell.verdict)}${layer === "stiffness" && known ? ` ± ${short(cell.stiffness_stddev, 2)}` : ""}; x ${short(1e3 * cell.x)} mm, y ${short(1e3 * cell.y)} mm`;
    const top = SIDE * (y.length - 1 - row) + 6;
    const rectangle = svg("rect", {
      class: "cell", x: EDGE + SIDE * column, y: top, width: SIDE, height: SIDE, rx: 4, tabindex: 0, role: "button",
      "aria-label": `${words}. Opens its recording`, fill: known ? shade((value - low) / (high - low || 1)) : "transparent",
      "stroke-dasharray": known ? "none" : "4 3", "data-site": site ?? "",
      onclick: () => visit(site), onkeydown: (/** @type {KeyboardEvent} */ event) => event.key === "Enter" && visit(site),
    }, svg("title", {}, words));
    drawing.append(rectangle);
    if (found.site === site && site !== null) {
      drawing.append(svg("circle", { cx: EDGE + SIDE * (column + 0.5), cy: top + SIDE / 2, r: 6, fill: "none", stroke: "var(--brush)", "stroke-width": 3, "pointer-events": "none" }));
    }
  });
  x.forEach((/** @type {number} */ place, /** @type {number} */ n) => drawing.append(svg("text", { x: EDGE + SIDE * (n + 0.5), y: SIDE * y.length + 22, "text-anchor": "middle" }, short(1e3 * place))));
  y.forEach((/** @type {number} */ place, /** @type {number} */ n) => drawing.append(svg("text", { x: EDGE - 8, y: SIDE * (y.length - 0.5 - n) + 10, "text-anchor": "end" }, short(1e3 * place))));
  drawing.append(svg("text", { x: EDGE + (SIDE * x.length) / 2, y: SIDE * y.length + 37, "text-anchor": "middle" }, "x [mm]; up is y [mm]"));
  const right = EDGE + SIDE * x.length + 14, height = SIDE * y.length;
  SCALE.forEach((colour, n) => drawing.append(svg("rect", { x: right, y: 6 + height - ((n + 1) * height) / SCALE.length, width: 12, height: height / SCALE.length + 0.5, fill: colour })));
  drawing.append(svg("text", { x: right + 16, y: 15 }, short(high)),
    svg("text", { x: right + 16, y: 28 }, LAYERS[layer].unit), svg("text", { x: right + 16, y: 6 + height }, short(low)));
  for (const region of found.regions) {
    const column = (region.x - x[0]) / (x[1] - x[0] || 1), row = (region.y - y[0]) / (y[1] - y[0] || 1);
    drawing.append(svg("circle", { cx: EDGE + SIDE * (column + 0.5), cy: SIDE * (y.length - 0.5 - row) + 6, r: SIDE * 0.62, fill: "none", stroke: "var(--residual)", "stroke-width": 2.5, "pointer-events": "none" }));
  }
  return drawing;
}

/** @param {number | null} site */
async function visit(site) {
  if (site === null) return;
  if ((await act("site", { site })) !== undefined) go("compare");
}

/**
 * @param {any[]} sites
 * @param {any} cell
 */
function nearest(sites, cell) {
  const near = sites.map((each) => ({ site: each.site, far: Math.hypot(each.x - cell.x, each.y - cell.y) })).sort((one, other) => one.far - other.far)[0];
  return near && near.far < 1e-4 ? near.site : null;
}

/** @param {number} share */
function shade(share) {
  return SCALE[Math.min(Math.floor(share * SCALE.length), SCALE.length - 1)];
}

/** @param {any} found */
function side(found) {
  return h(
    "div",
    { class: "card" },
    h("p", {}, found.text),
    found.inclusions.length > 0
      ? h("table", {}, h("thead", {}, h("tr", {}, ["x [mm]", "y [mm]", "probability", "N/m", "over background"].map((name) => h("th", { scope: "col", class: "number" }, name)))),
        h("tbody", {}, found.inclusions.map((/** @type {any} */ each) => h("tr", {}, [short(1e3 * each.x), short(1e3 * each.y), each.probability.toFixed(2), `${short(each.stiffness)} ± ${short(each.stiffness_sd, 2)}`, `${short(each.contrast)} ×`].map((text) => h("td", { class: "number" }, text))))))
      : h("p", { class: "soft" }, "No inclusion is told."),
    h("p", { class: "small soft" }, "A site opens what was measured there: compare the model with it, and see which effect is missing."),
  );
}
