// One model beside one recording, in six linked plots: time, residual, frequency, depth, speed, phase.

import { ask, brush, needDesk, plain, rungOf, say, shown, told, zoom } from "./app.js";
import { newest, Refused } from "./connection.js";
import { fill, h } from "./elements.js";
import { rowsOf } from "./missing.js";
import { small } from "./numbers.js";
import { Plot } from "./plot.js";

/** Axes of the small plots: how each is called, in which unit, and how many of these make one SI. */
const AXES = {
  indentation: { label: "indentation", unit: "mm", times: 1e3, ticks: undefined },
  speed: { label: "speed of the tip", unit: "mm/s", times: 1e3, ticks: undefined },
  phase: { label: "phase of the cycle", unit: "°", times: 1, ticks: [-180, -90, 0, 90, 180] },
};
/** @typedef {keyof typeof AXES} Axis */
/** @typedef {import("./connection.js").Requests} Requests */

const UNUSED = { colour: "faint", strength: 0.25 };

export class Column {
  /**
   * @param {boolean} first whether sliders and curves of effects act on it
   * @param {Element[]} tools what stands at the right of its head
   */
  constructor(first, tools = []) {
    this.first = first;
    /** @type {{rung: number, source: "fitted" | "second", stretch: number} | null} */
    this.of = null;
    this.end = 1;
    this.explained = false;
    /** @type {import("./told.js").ProfileMessage[]} */
    this.regions = [];
    /** @type {[number, number][]} */
    this.unused = [];
    /** @type {[number, number][]} */
    this.spans = [];
    const time = {
      sync: "time",
      onbrush: (/** @type {number} */ low, /** @type {number} */ high) => brush({ axis: "time", low, high }),
      onzoom: (/** @type {number} */ from, /** @type {number} */ to) => this.look(from, to),
      onreset: () => zoom(null),
    };
    this.signals = new Plot({
      ...time, name: "Measured and predicted over time",
      lines: [{ label: "measured", colour: "measured", width: 3 }, { label: "predicted", colour: "predicted", width: 1.2 }],
    });
    this.residual = new Plot({
      ...time, name: "Residual over time",
      lines: [{ label: "explained", colour: "explained", width: 3 }, { label: "residual", colour: "residual", width: 1 }],
    });
    this.spectrum = new Plot({
      name: "Residual over frequency", logarithmic: true,
      lines: [
        { label: "residual", colour: "residual", width: 1.4 },
        { label: "noise", colour: "noise", width: 1.2, dash: [5, 4] },
        { label: "brushed", colour: "brush", width: 1.4 },
      ],
      onbrush: (low, high) => brush({ axis: "frequency", low, high }),
    });
    this.dots = /** @type {Record<Axis, Plot>} */ ({});
    for (const axis of /** @type {Axis[]} */ (Object.keys(AXES))) {
      const { label, times, ticks } = AXES[axis];
      this.dots[axis] = new Plot({
        name: `Residual over ${label}`, points: true, ticks, lines: [{ label: "residual", colour: "residual" }],
        onbrush: (low, high) => brush({ axis, low: low / times, high: high / times }),
      });
    }
    this.head = h("div", { class: "row" });
    this.element = h(
      "div",
      { class: "column" },
      h("div", { class: "head" }, this.head, h("span", { class: "spring" }), tools),
      this.signals.element,
      this.residual.element,
      h("div", { class: "four" }, this.spectrum.element, Object.values(this.dots).map((plot) => plot.element)),
    );
    this.wantLines = newest(
      (/** @type {Requests["lines"]} */ asked) => ask("lines", asked),
      (answer) => this.showLines(answer),
      (error) => this.failed(error),
    );
    this.wantRest = newest(
      (/** @type {Requests["where"]} */ asked) => this.rest(asked),
      () => undefined,
      (error) => this.failed(error),
    );
  }

  plots() {
    return [this.signals, this.residual, this.spectrum, ...Object.values(this.dots)];
  }

  /**
   * Show a rung on a recording.
   * @param {number} rung
   * @param {"fitted" | "second"} source
   * @param {number} stretch
   */
  set(rung, source, stretch) {
    const other = !this.of || this.of.rung !== rung || this.of.source !== source || this.of.stretch !== stretch;
    this.of = { rung, source, stretch };
    if (other) {
      this.regions = [];
      this.spans = [];
      this.refresh();
      this.refreshRest();
    }
    this.showHead();
  }

  /** Ask for the lines again: the zoom, a slider or a curve has changed. */
  refresh() {
    if (!this.of) return;
    const span = shown.zoom ?? {};
    const more = this.first
      ? { values: Object.keys(shown.values).length ? shown.values : undefined, effect: this.curve() }
      : {};
    const width = Math.max(100, Math.round(this.signals.canvas.clientWidth * devicePixelRatio)) || 900;
    this.wantLines({ ...this.of, ...span, ...more, width: Math.min(width, 8192) });
  }

  /** The effect whose curve is drawn, if the ranking is of this rung. */
  curve() {
    const ranking = told.desk?.ranking;
    const fits = ranking?.rung === this.of?.rung && this.of?.source === "fitted";
    const known = rowsOf(ranking).some((row) => row.effect === shown.effect && row.rmse !== null);
    return fits && known ? shown.effect : undefined;
  }

  refreshRest() {
    if (!this.of) return;
    const some = this.dots.indentation.canvas;
    const size = {
      width: Math.round((some.clientWidth || 220) * devicePixelRatio),
      height: Math.round((some.clientHeight || 140) * devicePixelRatio),
    };
    this.wantRest({ ...this.of, ...size, brush: shown.brush ?? undefined });
  }

  /** @param {Requests["where"]} asked */
  async rest(asked) {
    const axes = /** @type {Axis[]} */ (Object.keys(AXES));
    const [where, marked, spectrum, ...dots] = await Promise.all([
      ask("where", asked),
      ask("brush", asked),
      ask("spectrum", asked),
      ...axes.map((axis) => ask("dots", { ...asked, axis })),
    ]);
    this.regions = where.ok.regions;
    this.spans = marked.ok.spans;
    this.marked = marked.ok;
    this.showSpectrum(spectrum);
    axes.forEach((axis, number) => this.showDots(axis, dots[number]));
    this.showMarks();
    this.showCaptions(this.explained);
    this.onregions?.(this.regions, this.marked);
  }

  /** @param {unknown} error */
  failed(error) {
    if (error instanceof Refused && error.cancelled) return;
    if (rungOf(this.of?.rung) === null) return; // it was taken down meanwhile
    say(plain(error instanceof Error ? error.message : String(error)));
  }

  output() {
    return rungOf(this.of?.rung)?.output ?? { per_drawn: 1, drawn: "N", per_small: 1e3, small: "mN", name: "force" };
  }

  /** @param {import("./connection.js").Answer<"lines">} answer */
  showLines({ ok, arrays }) {
    const output = this.output();
    const x = arrays.time;
    this.end = ok.end;
    this.unused = ok.unused;
    const times = (/** @type {string} */ name, /** @type {number} */ by) =>
      arrays[name] ? Float64Array.from(arrays[name], (value) => value * by) : new Array(x.length).fill(null);
    this.showTimeMarks();
    const limits = { x: /** @type {[number, number]} */ (shown.zoom ? [shown.zoom.from, shown.zoom.to] : [0, ok.end]) };
    this.signals.show(x, [times("measured", output.per_drawn), times("predicted", output.per_drawn)], limits, ok.dense);
    const explained = times("explained", output.per_small);
    const noise = ok.noise * output.per_small;
    this.residual.levels = [{ low: -noise, high: noise, colour: "noise" }];
    this.residual.show(x, [explained, times("residual", output.per_small)], limits, ok.dense);
    this.rmse = ok.rmse;
    this.explained = Boolean(arrays.explained);
    this.showCaptions(this.explained);
    this.onlines?.(ok);
  }

  /** @param {boolean} explained */
  showCaptions(explained) {
    const output = this.output();
    const key = (/** @type {string} */ name, /** @type {string} */ colour) =>
      h("span", { class: "key", style: { "--of": `var(--${colour})` } }, name);
    fill(
      this.signals.caption, h("b", {}, output.name), ` [${output.drawn}]`, key("measured", "measured"),
      key(this.first && Object.keys(shown.values).length ? "predicted, sliders moved" : "predicted", "predicted"),
      h("span", { class: "at" }, "time [s]"),
    );
    fill(
      this.residual.caption, h("b", {}, "residual"), ` [${output.small.replace("um", "µm")}]`,
      explained && key(`${shown.effect} would take off`, "explained"), key("± noise", "noise"),
      this.marked?.count ? h("span", { class: "key", style: { "--of": "var(--brush)" } },
        `${this.marked.count} brushed, rms ${small(this.marked.rmse, output)}`) : null,
      h("span", { class: "at" }, "time [s]"),
    );
    fill(this.spectrum.caption, h("b", {}, "frequency"), " [Hz]", h("span", { class: "at" }, `${output.small.replace("um", "µm")}/√Hz`));
    for (const axis of /** @type {Axis[]} */ (Object.keys(AXES))) {
      fill(this.dots[axis].caption, h("b", {}, AXES[axis].label), ` [${AXES[axis].unit}]`);
    }
  }

  /** @param {import("./connection.js").Answer<"spectrum">} answer */
  showSpectrum({ ok, arrays }) {
    const by = this.output().per_small;
    const root = (/** @type {ArrayLike<number>} */ values) => Float64Array.from(values, (value) => Math.sqrt(Math.max(value, 1e-300)) * by);
    const x = arrays.frequency;
    const marked = arrays.marked ? root(arrays.marked) : new Array(x.length).fill(null);
    const white = new Float64Array(x.length).fill(Math.sqrt(ok.white) * by);
    this.spectrum.show(x, [root(arrays.density), white, marked], { x: [x[0], x[x.length - 1]] });
  }

  /**
   * @param {Axis} axis
   * @param {import("./connection.js").Answer<"dots">} answer
   */
  showDots(axis, { ok, arrays }) {
    const plot = this.dots[axis], by = AXES[axis].times, fine = this.output().per_small;
    const times = (/** @type {ArrayLike<number>} */ values, /** @type {number} */ of) => Float64Array.from(values, (value) => value * of);
    plot.dots = [{ x: times(arrays.x, by), y: times(arrays.y, fine), colour: shown.brush ? "faint" : "residual" }];
    if (arrays.marked_x) plot.dots.push({ x: times(arrays.marked_x, by), y: times(arrays.marked_y, fine), colour: "brush" });
    const [left, right, bottom, top] = ok.limits;
    const high = 1.06 * Math.max(-bottom, top) * fine;
    plot.show([left * by, right * by], [[0, 0]], { x: [left * by, right * by], y: [-high, high] });
  }

  /** The region of an axis that stands out. @param {string} axis */
  here(axis) {
    const found = this.regions.find((each) => each.axis === axis)?.here;
    const foremost = this.regions.find((each) => each.foremost)?.axis === axis;
    return found ? [{ low: found.begin, high: found.end, colour: "here", label: foremost ? "here" : "stands out", strength: foremost ? 0.2 : 0.1 }] : [];
  }

  /** What stands out, is left out and is brushed over time; to be drawn with the lines. */
  showTimeMarks() {
    const unused = this.unused.map(([low, high]) => ({ low, high, ...UNUSED }));
    const spans = this.spans.map(([low, high]) => ({ low, high, colour: "brush", strength: 0.22 }));
    this.signals.bands = [...unused, ...spans];
    this.residual.bands = [...this.here("time"), ...unused, ...spans];
  }

  /** The same in every plot. */
  showMarks() {
    this.showTimeMarks();
    const own = (/** @type {string} */ axis, /** @type {number} */ by) =>
      shown.brush?.axis === axis ? [{ low: shown.brush.low * by, high: shown.brush.high * by, colour: "brush", strength: 0.22 }] : [];
    this.spectrum.bands = [...this.here("frequency"), ...own("frequency", 1)];
    for (const axis of /** @type {Axis[]} */ (Object.keys(AXES))) {
      this.dots[axis].bands = [...this.here(axis), ...own(axis, AXES[axis].times)];
    }
    for (const plot of this.plots()) plot.redraw();
    for (const region of this.regions) {
      const plot = { time: this.residual, frequency: this.spectrum, ...this.dots }[/** @type {string} */ (region.axis)];
      plot?.describe(region.told);
    }
  }

  showHead() {
    const rung = rungOf(this.of?.rung);
    if (!rung || !this.of) return;
    const second = this.of.source === "second";
    const stretches = (second ? rung.second : rung)?.stretches;
    const desk = needDesk();
    const file = desk.files.find((each) => each.number === (second ? desk.second : desk.fitted));
    fill(
      this.head,
      h("h3", {}, rung.title),
      h("span", { class: "soft" }, second ? `on ${file?.name}, nothing fitted` : file?.name),
      stretches && stretches.names.length > 1 &&
        h("select", {
          "aria-label": "Stretch of the recording",
          onchange: (/** @type {Event} */ event) => this.onstretch?.(Number(/** @type {HTMLSelectElement} */ (event.target).value)),
        }, stretches.names.map((/** @type {string} */ name, /** @type {number} */ number) =>
          h("option", { value: number, selected: number === this.of?.stretch },
            `stretch ${number + 1} of ${stretches.names.length}${number === stretches.worst ? ", the worst" : ""}`))),
    );
  }

  /**
   * @param {number} from
   * @param {number} to
   */
  look(from, to) {
    const span = Math.min(to - from, this.end);
    const begin = Math.min(Math.max(from, 0), this.end - span);
    if (span >= this.end) zoom(null);
    else if (span > this.end * 1e-6) zoom({ from: begin, to: begin + span });
  }

  restyle() {
    for (const plot of this.plots()) plot.restyle();
  }

  destroy() {
    for (const plot of this.plots()) plot.destroy();
  }
}

/** @type {((regions: import("./told.js").ProfileMessage[], marked: import("./told.js").BrushMessage | undefined) => void) | undefined} */
Column.prototype.onregions = undefined;
/** @type {((told: import("./told.js").LinesMessage) => void) | undefined} */
Column.prototype.onlines = undefined;
/** @type {((stretch: number) => void) | undefined} */
Column.prototype.onstretch = undefined;
