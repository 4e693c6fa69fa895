// Map: stiffness, P(inclusion) and what could hide over the sites; a site opens its recording.

import { act, ask, go, needDesk, on, plain, refuse, told } from "./app.js";
import { fill, h, svg } from "./elements.js";
import { short } from "./numbers.js";

/** @typedef {{label: string, unit: string, limits: [number, number] | null, told: string}} Layer */

/** From low to high: Matplotlib's cividis in nine steps, read alike by the colour-blind. */
const SCALE = ["#00224e", "#123570", "#3b496c", "#575d6d", "#707173", "#8a8678", "#a59c74", "#c3b369", "#fee838"]
  .map((colour) => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16)));
/** How many mm a radius is told to: beyond it nothing is excluded. */
const LARGEST = 10;
/** Of the largest value: a uniform tissue shall not look like a mountain range. */
const LEAST_RANGE = 0.1;
/** The drawing's own size where it has a page to itself, and room for its axes and its scale. */
const SIZE = 560, LEFT = 46, RIGHT = 72, TOP = 10, BOTTOM = 46;

/** @type {Record<string, Layer>} */
const LAYERS = {
  mean: { label: "stiffness", unit: "N/m", limits: null, told: "stiffness felt at each place" },
  sd: { label: "its error", unit: "N/m", limits: null, told: "standard deviation of the stiffness" },
  probability: { label: "P(inclusion)", unit: "", limits: [0, 1], told: "that the place lies in an inclusion" },
  radius: { label: "could hide", unit: "mm", limits: [0, LARGEST], told: "radius of the largest round inclusion that the sites do not exclude at 95 %" },
};

/** @typedef {Record<string, import("./messages.js").Numbers>} Raster */

export function map() {
  const element = h("div", { class: "sheet wide" });
  let layer = "mean", number = -1;
  /** @type {Raster} */
  let raster = {};
  const draw = () => {
    const found = told.desk?.map;
    if (!found) {
      fill(element, h("div", { class: "empty" }, h("p", {}, "A recording of a scan, or a table of sites, gives a map."), h("button", { type: "button", onclick: () => go("open") }, "Open a scan")));
      return;
    }
    fill(
      element,
      h("div", { class: "row spread" }, h("h1", {}, "Map"), choose(raster, layer, (name) => {
        layer = name;
        draw();
      })),
      h("div", { class: "mapgrid" }, picture(found, raster, layer, visit), side(found)),
    );
  };
  on("desk", async () => {
    const found = needDesk().map;
    if (found && found.number !== undefined && found.number !== number) {
      number = found.number;
      raster = {};
      try {
        const { arrays } = await ask("raster");
        if (number === found.number) raster = arrays;
      } catch (error) {
        refuse(error);
      }
    }
    draw();
  });
  on("theme", draw);
  draw();
  return element;
}

/**
 * Buttons of the layers that there are.
 * @param {Raster} raster
 * @param {string} layer
 * @param {(name: string) => void} pick
 */
export function choose(raster, layer, pick) {
  return h("div", { class: "row" }, Object.keys(LAYERS).filter((name) => raster[name]).map((name) =>
    h("button", { type: "button", class: "tiny", title: LAYERS[name].told, "aria-pressed": name === layer, "data-key": `layer-${name}`, "data-layer": name, onclick: () => pick(name) }, LAYERS[name].label)));
}

/**
 * The map as one drawing; where a raster is not there yet, or of too few sites, the sites alone.
 * @param {import("./told.js").MapMessage} found
 * @param {Raster} raster
 * @param {string} layer
 * @param {((site: number) => void) | null} [open] what a site does; nothing where there is none
 * @param {number} [size] of its longer side: letters stay as they are
 */
export function picture(found, raster, layer, open = null, size = SIZE) {
  const { label, unit } = LAYERS[layer];
  const place = placed(found, raster, size);
  const { x, y, wide, tall } = place;
  const values = layerOf(raster, layer, found);
  const [low, high] = LAYERS[layer].limits ?? range(values);
  const words = h("p", { class: "small soft readout", "aria-live": "off" }, `${label}${unit && ` [${unit}]`}: ${LAYERS[layer].told}`);
  const drawing = /** @type {SVGSVGElement} */ (svg("svg", { viewBox: `0 0 ${LEFT + wide + RIGHT} ${TOP + tall + BOTTOM}`, role: "group", "aria-label": `Map of the ${label}` }));
  drawing.append(patterns(place), svg("rect", { x: LEFT, y: TOP, width: wide, height: tall, fill: "url(#unknown)", stroke: "var(--line)" }));
  if (raster[layer]) {
    const image = svg("image", {
      x: x(place.edges[0]), y: y(place.edges[3]), width: x(place.edges[1]) - x(place.edges[0]), height: y(place.edges[2]) - y(place.edges[3]),
      preserveAspectRatio: "none", href: coloured(values, raster.x.length, low, high), role: "img", "aria-label": label,
    });
    image.addEventListener("mousemove", (event) => {
      words.textContent = readOut(drawing, /** @type {MouseEvent} */ (event), place, raster, found);
    });
    drawing.append(image);
  }
  for (const each of found.inclusions.filter((one) => one.probability >= 0.5)) drawing.append(...inclusion(each, place));
  const target = Math.min(Math.max(place.gap / 2.2, 5), 16);
  for (const each of found.sites) drawing.append(...mark(each, place, target, found.site ?? null, open, values, [low, high], Boolean(raster[layer])));
  drawing.append(...axes(place), ...bar(place, label, unit, low, high, layer));
  return h("figure", { class: "map" }, drawing, words, legend(found));
}

/**
 * Where things lie on the drawing.
 * @param {import("./told.js").MapMessage} found
 * @param {Raster} raster
 * @param {number} size
 */
function placed(found, raster, size) {
  const columns = raster.x ?? [], rows = raster.y ?? [];
  const step = columns.length > 1 ? (columns[1] - columns[0]) / 2 : 0;
  const all = { x: found.sites.map((each) => each.x), y: found.sites.map((each) => each.y) };
  const some = (/** @type {number[]} */ own, /** @type {ArrayLike<number>} */ axis) => {
    const low = Math.min(...own, axis[0] ?? Infinity), high = Math.max(...own, axis[axis.length - 1] ?? -Infinity);
    return [low, high];
  };
  const [left, right] = some(all.x, columns), [bottom, top] = some(all.y, rows);
  const margin = 0.04 * Math.max(right - left, top - bottom) || 1e-3;
  const across = right - left + 2 * margin, up = top - bottom + 2 * margin;
  const scale = size / Math.max(across, up);
  const gaps = found.sites.map((one) => Math.min(...found.sites.filter((other) => other !== one)
    .map((other) => Math.hypot(one.x - other.x, one.y - other.y) || Infinity)));
  return {
    x: (/** @type {number} */ value) => LEFT + (value - left + margin) * scale,
    y: (/** @type {number} */ value) => TOP + (top + margin - value) * scale,
    wide: across * scale, tall: up * scale, scale, gap: scale * (Math.min(...gaps, 1) || 0.01),
    limits: [left - margin, right + margin, bottom - margin, top + margin],
    edges: columns.length ? [columns[0] - step, columns[columns.length - 1] + step, rows[0] - step, rows[rows.length - 1] + step] : [left, right, bottom, top],
  };
}
/** @typedef {ReturnType<typeof placed>} Place */

/** The stripes of places that no site is near, and the window through which lines are seen. @param {Place} place */
function patterns({ wide, tall }) {
  return svg("defs", {}, svg("clipPath", { id: "window" }, svg("rect", { x: LEFT, y: TOP, width: wide, height: tall })), svg("pattern", { id: "unknown", width: 7, height: 7, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" },
    svg("rect", { width: 7, height: 7, fill: "var(--sunk)" }), svg("line", { x1: 0, y1: 0, x2: 0, y2: 7, stroke: "var(--line)", "stroke-width": 1.5 })));
}

/**
 * Values of a layer as they are drawn; of the sites where there is no raster.
 * @param {Raster} raster
 * @param {string} layer
 * @param {import("./told.js").MapMessage} found
 */
function layerOf(raster, layer, found) {
  if (!raster[layer]) return found.sites.map((each) => each.stiffness ?? NaN);
  if (layer !== "radius") return raster[layer];
  // Where something is known but no radius, none is excluded.
  return Float32Array.from(raster.radius, (value, n) => (Number.isFinite(value) ? 1e3 * value : Number.isFinite(raster.mean[n]) ? LARGEST : NaN));
}

/** @param {ArrayLike<number>} values @returns {[number, number]} */
function range(values) {
  let low = Infinity, high = -Infinity;
  for (let n = 0; n < values.length; n++) {
    if (Number.isFinite(values[n])) {
      low = Math.min(low, values[n]);
      high = Math.max(high, values[n]);
    }
  }
  if (low > high) return [0, 1];
  const more = Math.max(0, LEAST_RANGE * Math.max(Math.abs(low), Math.abs(high)) - (high - low)) / 2;
  return [low - more, high + more];
}

/** @param {number} share @returns {number[]} */
function colourOf(share) {
  const at = Math.min(Math.max(share, 0), 1) * (SCALE.length - 1), below = Math.min(Math.floor(at), SCALE.length - 2);
  return SCALE[below].map((one, n) => Math.round(one + (at - below) * (SCALE[below + 1][n] - one)));
}

/**
 * A layer as a picture's address; what is not known is clear.
 * @param {ArrayLike<number>} values
 * @param {number} columns
 * @param {number} low
 * @param {number} high
 */
function coloured(values, columns, low, high) {
  const canvas = document.createElement("canvas"), rows = values.length / columns;
  canvas.width = columns;
  canvas.height = rows;
  const context = canvas.getContext("2d");
  if (!context) return "";
  const pixels = context.createImageData(columns, rows);
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      const value = values[(rows - 1 - row) * columns + column], to = 4 * (row * columns + column);
      if (!Number.isFinite(value)) continue;
      pixels.data.set([...colourOf((value - low) / (high - low || 1)), 255], to);
    }
  }
  context.putImageData(pixels, 0, 0);
  return canvas.toDataURL();
}

/**
 * The boundaries of an inclusion: white on black is seen on every colour.
 * @param {import("./told.js").InclusionMessage} each
 * @param {Place} place
 */
function inclusion(each, place) {
  const { x, y } = place;
  const path = (/** @type {number[][]} */ ring) => ring.map(([u, v], n) => `${n ? "L" : "M"}${x(u).toFixed(1)} ${y(v).toFixed(1)}`).join("") + "Z";
  const rings = /** @type {const} */ ([["boundary_50", "none"], ["boundary_95", "2 5"]]);
  const lines = rings.flatMap(([name, dash]) => [["black", 4], ["white", 1.8]].map(([stroke, width]) =>
    svg("path", { d: each[name].length ? path(each[name]) : "", fill: "none", stroke, "stroke-width": width, "stroke-dasharray": dash, "stroke-linecap": "round", "pointer-events": "none", "clip-path": "url(#window)" })));
  const name = svg("text", { x: x(each.x), y: y(each.y) - 9, "text-anchor": "middle", class: "over" }, `${each.contrast.toFixed(1)}×, P ${each.probability.toFixed(2)}`);
  return [...lines, name];
}

/**
 * @param {import("./told.js").SiteMessage} each
 * @param {Place} place
 * @param {number} size of what can be clicked
 * @param {number | null} chosen
 * @param {((site: number) => void) | null} open
 * @param {ArrayLike<number>} values
 * @param {[number, number]} limits
 * @param {boolean} raster whether there is one below
 */
function mark(each, place, size, chosen, open, values, limits, raster) {
  const stiffness = each.stiffness ?? NaN, known = Number.isFinite(stiffness);
  const opens = open && each.site !== null ? { open, site: each.site } : null;
  const words = `${known ? `${short(stiffness, 4)} ± ${short(each.stiffness_sd, 2)} N/m` : each.verdict}; x ${short(1e3 * each.x)} mm, y ${short(1e3 * each.y)} mm`;
  const [cx, cy] = [place.x(each.x), place.y(each.y)];
  const does = opens ? {
    tabindex: 0, role: "button", "data-site": opens.site, onclick: () => opens.open(opens.site),
    onkeydown: (/** @type {KeyboardEvent} */ event) => event.key === "Enter" && opens.open(opens.site),
  } : { role: "img" };
  const fill_ = raster ? "transparent" : known ? `rgb(${colourOf((stiffness - limits[0]) / (limits[1] - limits[0] || 1))})` : "none";
  const target = svg("circle", { class: `site${opens ? " opens" : ""}`, cx, cy, r: size, fill: fill_, "aria-label": `${words}${opens ? ". Opens its recording" : ""}`, ...does },
    svg("title", {}, words));
  const dot = known
    ? svg("circle", { cx, cy, r: 3, fill: "white", stroke: "black", "stroke-width": 1.2, "pointer-events": "none" })
    : svg("path", { d: `M${cx - 4} ${cy - 4}l8 8m0 -8l-8 8`, stroke: "var(--bad)", "stroke-width": 2, "pointer-events": "none" });
  const ring = chosen !== null && chosen !== undefined && chosen === each.site
    ? [svg("circle", { cx, cy, r: size * 0.8, fill: "none", stroke: "var(--brush)", "stroke-width": 3, "pointer-events": "none" })] : [];
  return [target, dot, ...ring];
}

/** @param {Place} place */
function axes(place) {
  const [left, right, bottom, top] = place.limits, { x, y } = place, below = TOP + place.tall;
  return [
    ...ticks(left, right).map((value) => svg("text", { x: x(value), y: below + 17, "text-anchor": "middle" }, short(1e3 * value))),
    ...ticks(bottom, top).map((value) => svg("text", { x: LEFT - 8, y: y(value) + 4, "text-anchor": "end" }, short(1e3 * value))),
    svg("text", { x: LEFT + place.wide / 2, y: below + 36, "text-anchor": "middle" }, "x [mm]"),
    svg("text", { transform: `translate(12 ${TOP + place.tall / 2}) rotate(-90)`, "text-anchor": "middle" }, "y [mm]"),
  ];
}

/** Round numbers between two ends, some five. @param {number} low @param {number} high */
function ticks(low, high) {
  const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((digit) => digit * power).find((each) => each >= rough) ?? rough;
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, n) => (first + n) * step);
}

/**
 * @param {Place} place
 * @param {string} label
 * @param {string} unit
 * @param {number} low
 * @param {number} high
 * @param {string} layer
 */
function bar(place, label, unit, low, high, layer) {
  const left = LEFT + place.wide + 14, pieces = 60, piece = place.tall / pieces;
  const shades = Array.from({ length: pieces }, (_, n) => svg("rect", {
    x: left, y: TOP + place.tall - (n + 1) * piece, width: 13, height: piece + 0.6, fill: `rgb(${colourOf((n + 0.5) / pieces)})`,
  }));
  const level = (/** @type {number} */ value) => TOP + place.tall * (1 - (value - low) / (high - low || 1));
  const written = ticks(low, high).filter((value) => value >= low && value <= high).map((value) =>
    svg("text", { x: left + 19, y: level(value) + 4 }, `${short(value, 4)}${layer === "radius" && value === LARGEST ? " +" : ""}`));
  return [...shades, ...written, svg("text", { x: left, y: TOP + place.tall + 17 }, unit || label)];
}

/** @param {import("./told.js").MapMessage} found */
function legend(found) {
  const likely = found.inclusions.some((each) => each.probability >= 0.5);
  return h("p", { class: "small soft legend" }, "● site",
    found.sites.some((each) => !Number.isFinite(each.stiffness ?? NaN)) && h("span", {}, "× site without a value"),
    likely && h("span", {}, "— inclusion, likely boundary"), likely && h("span", {}, "··· holds all of it, 95 %"), h("span", {}, "hatched: no site near"));
}

/**
 * What is known at the place of the pointer.
 * @param {SVGSVGElement} drawing
 * @param {MouseEvent} event
 * @param {Place} place
 * @param {Raster} raster
 * @param {import("./told.js").MapMessage} found
 */
function readOut(drawing, event, place, raster, found) {
  const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(drawing.getScreenCTM()?.inverse());
  const u = place.limits[0] + (point.x - LEFT) / place.scale, v = place.limits[3] - (point.y - TOP) / place.scale;
  const step = (/** @type {ArrayLike<number>} */ axis) => (axis.length > 1 ? axis[1] - axis[0] : 1);
  const column = Math.round((u - raster.x[0]) / step(raster.x)), row = Math.round((v - raster.y[0]) / step(raster.y));
  const n = Math.min(Math.max(row, 0), raster.y.length - 1) * raster.x.length + Math.min(Math.max(column, 0), raster.x.length - 1);
  const where = `x ${short(1e3 * u)} mm, y ${short(1e3 * v)} mm: `;
  if (!Number.isFinite(raster.mean?.[n])) return `${where}no site near`;
  const hides = raster.radius && (Number.isFinite(raster.radius[n])
    ? `an inclusion ${short(found.contrast)} times stiffer of up to ${short(1e3 * raster.radius[n], 2)} mm could hide`
    : "nothing is excluded");
  return [`${where}${short(raster.mean[n], 4)} ± ${short(raster.sd[n], 2)} N/m`, `P(inclusion) ${raster.probability[n].toFixed(2)}`, hides].filter(Boolean).join("; ");
}

/** @param {number} site */
async function visit(site) {
  if ((await act("site", { site })) !== undefined) go("compare");
}

/** @param {import("./told.js").MapMessage} found */
function side(found) {
  return h(
    "div",
    { class: "card" },
    found.text.split("\n").map((line) => h("p", {}, plain(line))),
    inclusions(found),
    found.sites.some((each) => each.site !== null) &&
      h("p", { class: "small soft" }, "A site opens its samples: compare the model with them, and see which effect is missing."),
  );
}

/** The inclusions as a table. @param {import("./told.js").MapMessage} found */
export function inclusions(found) {
  if (!found.inclusions.length) return h("p", { class: "soft" }, "No inclusion is told.");
  return h("table", {},
    h("thead", {}, h("tr", {}, ["x [mm]", "y [mm]", "P", "N/m", "× background"].map((name) => h("th", { scope: "col", class: "number" }, name)))),
    h("tbody", {}, found.inclusions.map((each) => h("tr", {},
      [short(1e3 * each.x), short(1e3 * each.y), each.probability.toFixed(2), `${short(each.stiffness)} ± ${short(each.stiffness_sd, 2)}`, short(each.contrast)]
        .map((text) => h("td", { class: "number" }, text))))));
}
