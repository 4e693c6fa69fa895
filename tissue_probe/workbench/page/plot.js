// One plot: uPlot's axes and lines, with marks, a brush and a wheel of our own.

import uPlot from "./vendor/uPlot.js";
import { h } from "./elements.js";
import { short } from "./numbers.js";

/** @typedef {{low: number, high: number, colour: string, label?: string, strength?: number}} Band */

/**
 * @typedef {object} Look
 * @property {string} name what a screen reader calls it
 * @property {{label: string, colour: string, width?: number, dash?: number[]}[]} lines
 * @property {boolean} [logarithmic] both axes
 * @property {boolean} [points] draws points by `dots` in place of lines
 * @property {string} [sync] plots of one such name show one cursor
 * @property {(low: number, high: number) => void} [onbrush]
 * @property {(from: number, to: number) => void} [onzoom]
 * @property {() => void} [onreset]
 * @property {number[]} [ticks] of the x axis
 * @property {(value: number) => string} [x] how a place on the x axis is written
 */

/** A colour of the page by its meaning. @param {string} name */
export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/**
 * Ticks of a logarithmic axis: the powers of ten, with 2 and 5 between them where there are few.
 * @param {number} low
 * @param {number} high
 */
function decadesOf(low, high) {
  const few = Math.log10(high / low) < 2;
  const found = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power++) {
    for (const digit of few ? [1, 2, 5] : [1]) {
      const value = digit * 10 ** power;
      if (value >= low * 0.999 && value <= high * 1.001) found.push(value);
    }
  }
  return found;
}

/** The page's size of letters [CSS pixels]: with it grows all that is drawn. */
function fontSize() {
  return parseFloat(getComputedStyle(document.documentElement).fontSize);
}

/** Fewer points are drawn larger: each of them counts. */
const FEW = 1500;
/** Of a line with several samples a pixel [device pixels]: its columns are filled, and a hair is drawn
 * several times as fast as a wider line. */
const HAIR = 1;
/** A turn of the wheel shows so many times the span. */
const TURN = 1.25;
/** The longest row of points that a drag may cross without being one [pixels]. */
const CLICK = 3;

export class Plot {
  /**
   * @param {Look} look
   * @param {...import("./elements.js").Child} caption
   */
  constructor(look, ...caption) {
    this.look = look;
    /** @type {Band[]} */
    this.bands = [];
    /** @type {Band[]} */
    this.levels = [];
    /** @type {{x: ArrayLike<number>, y: ArrayLike<number>, colour: string}[]} */
    this.dots = [];
    /** @type {{x?: [number, number], y?: [number, number]}} */
    this.limits = {};
    this.dense = false;
    /** @type {uPlot.AlignedData} */
    this.data = /** @type {uPlot.AlignedData} */ ([[], ...look.lines.map(() => [])]);
    this.caption = h("div", { class: "caption" }, ...caption);
    this.canvas = h("div", { class: "canvas" });
    this.readout = h("div", { class: "readout" });
    this.element = h(
      "div",
      { class: "plot", role: "img", "aria-label": look.name, tabindex: 0 },
      this.caption,
      this.canvas,
      this.readout,
      h("button", { type: "button", class: "quiet tiny save", title: "Save this plot as a picture", "aria-label": `Save: ${look.name}`, onclick: () => this.save() }, "⤓"),
    );
    /** @type {uPlot | null} */
    this.drawn = null;
    this.watch = new ResizeObserver(() => this.fit());
    this.watch.observe(this.canvas);
    this.canvas.addEventListener("wheel", (/** @type {WheelEvent} */ event) => this.turn(event), { passive: false });
    this.element.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => this.key(event));
    this.canvas.addEventListener("dblclick", () => this.look.onreset?.());
  }

  /** @param {string} sentence */
  describe(sentence) {
    this.element.setAttribute("aria-label", `${this.look.name}. ${sentence}`);
    this.element.title = "";
  }

  /**
   * @param {ArrayLike<number>} x
   * @param {ArrayLike<number | null>[]} lines
   * @param {{x?: [number, number], y?: [number, number]}} [limits]
   * @param {boolean} [dense] whether several samples lie in a pixel
   */
  show(x, lines, limits = {}, dense = false) {
    this.limits = limits;
    this.dense = dense;
    this.drawn?.series.forEach((series, number) => {
      if (number) series.width = this.widthOf(this.look.lines[number - 1]);
    });
    this.data = /** @type {uPlot.AlignedData} */ (/** @type {unknown} */ ([x, ...lines]));
    if (this.drawn) this.drawn.setData(this.data, true);
    else this.make();
  }

  /** @param {{width?: number}} line */
  widthOf(line) {
    const width = ((line.width ?? 1.4) * fontSize()) / 14;
    return this.dense ? Math.min(width, HAIR / devicePixelRatio) : width;
  }

  redraw() {
    this.drawn?.redraw(false);
  }

  /** Colours have changed. */
  restyle() {
    this.drawn?.destroy();
    this.drawn = null;
    this.make();
  }

  fit() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (this.drawn && width > 0 && height > 0) this.drawn.setSize({ width, height });
    else if (!this.drawn && this.data[0].length) this.make();
  }

  make() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    const size = fontSize();
    const font = `${Math.round(size * 0.79)}px system-ui, "DejaVu Sans", sans-serif`;
    const distr = this.look.logarithmic ? 3 : 1;
    const axis = {
      stroke: colour("soft"), font, ticks: { show: false },
      grid: { stroke: colour("grid"), width: 1 },
      border: { show: false },
    };
    const decades = this.look.logarithmic
      ? { splits: (/** @type {uPlot} */ _, /** @type {number} */ __, /** @type {number} */ low, /** @type {number} */ high) => decadesOf(low, high) }
      : {};
    /** @type {uPlot.Options} */
    const options = {
      width, height,
      padding: [size * 0.55, size * 0.95, 0, 0],
      legend: { show: false },
      cursor: {
        drag: { x: Boolean(this.look.onbrush), y: false, setScale: false, dist: CLICK },
        points: { show: !this.look.points, size: 6 },
        ...(this.look.sync ? { sync: { key: this.look.sync, setSeries: false, scales: ["x", null] } } : {}),
        bind: { dblclick: () => null },
      },
      scales: {
        x: { time: false, distr, range: (_, low, high) => this.limits.x ?? [low, high === low ? low + 1 : high] },
        y: {
          distr,
          range: (_, low, high) => this.limits.y ?? (this.look.logarithmic
            ? uPlot.rangeLog(low ?? 1e-3, high ?? 1, 10, true)
            : uPlot.rangeNum(low ?? 0, high ?? 1, 0.08, true)),
        },
      },
      axes: [
        {
          ...axis, ...decades, size: size * 1.7, gap: 2, space: size * 2.7, ...this.looked(),
          ...(this.look.ticks ? { splits: () => /** @type {number[]} */ (this.look.ticks) } : {}),
        },
        {
          ...axis, ...decades, size: size * 3.3, gap: 4, space: size * 2,
          values: (_, ticks) => ticks.map((tick) => (tick === null ? "" : short(tick, 4))),
        },
      ],
      series: [
        {},
        ...this.look.lines.map((line) => ({
          label: line.label, stroke: colour(line.colour), width: this.widthOf(line),
          dash: line.dash, points: { show: false }, show: !this.look.points, spanGaps: false,
        })),
      ],
      hooks: {
        drawClear: [(plot) => this.behind(plot)],
        draw: [(plot) => this.above(plot)],
        setSelect: [(plot) => this.selected(plot)],
        setCursor: [(plot) => this.read(plot)],
      },
    };
    this.drawn = new uPlot(options, this.data, this.canvas);
  }

  looked() {
    const write = this.look.x;
    return {
      values: (/** @type {uPlot} */ _, /** @type {(number | null)[]} */ ticks) =>
        ticks.map((tick) => (tick === null ? "" : write ? write(tick) : short(tick, 4))),
    };
  }

  /** Marks that lie behind the lines. @param {uPlot} plot */
  behind(plot) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (const { low, high, colour: name, strength } of this.bands) {
      // Of a phase a band may go on through the end of the axis.
      const ends = low <= high ? [[low, high]] : [[low, plot.scales.x.max ?? 180], [plot.scales.x.min ?? -180, high]];
      for (const [begin, end] of ends) {
        const left = plot.valToPos(begin, "x", true), right = plot.valToPos(end, "x", true);
        ctx.globalAlpha = strength ?? 0.17;
        ctx.fillStyle = colour(name);
        ctx.fillRect(left, bbox.top, Math.max(right - left, 1), bbox.height);
      }
    }
    for (const { low, high, colour: name } of this.levels) {
      const top = plot.valToPos(high, "y", true), bottom = plot.valToPos(low, "y", true);
      ctx.globalAlpha = 0.28;
      ctx.fillStyle = colour(name);
      ctx.fillRect(bbox.left, top, bbox.width, Math.max(bottom - top, devicePixelRatio));
    }
    ctx.restore();
  }

  /** @param {uPlot} plot */
  above(plot) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    const size = fontSize() * devicePixelRatio;
    for (const { x, y, colour: name } of this.dots) {
      const side = Math.max(1, Math.round(size * (x.length < FEW ? 0.2 : 0.1)));
      ctx.fillStyle = colour(name);
      const [left, right] = [0, 1].map((value) => plot.valToPos(value, "x", true));
      const [bottom, top] = [0, 1].map((value) => plot.valToPos(value, "y", true));
      for (let n = 0; n < x.length; n++) {
        ctx.fillRect(Math.round(left + (right - left) * x[n]), Math.round(bottom + (top - bottom) * y[n]), side, side);
      }
    }
    ctx.font = `600 ${0.79 * size}px system-ui, "DejaVu Sans", sans-serif`;
    ctx.textBaseline = "top";
    ctx.textAlign = "left";
    for (const { low, colour: name, label } of this.bands) {
      if (!label) continue;
      const left = Math.max(plot.valToPos(low, "x", true), bbox.left) + 4 * devicePixelRatio;
      const wide = ctx.measureText(label).width;
      ctx.fillStyle = colour(name);
      ctx.fillText(label, Math.min(left, bbox.left + bbox.width - wide - 4), bbox.top + 3 * devicePixelRatio);
    }
    ctx.restore();
  }

  /** Tell every curve's value at the cursor. @param {uPlot} plot */
  read(plot) {
    const at = plot.cursor.idx, x = at === null || at === undefined ? undefined : this.data[0][at];
    const write = (/** @type {number | null | undefined} */ value) => (value === null || value === undefined ? "–" : short(value, 4));
    this.readout.textContent = this.look.points || x === undefined || (plot.cursor.left ?? -1) < 0 ? ""
      : [write(x), ...this.look.lines.map((line, number) => [line.label, this.data[number + 1][/** @type {number} */ (at)]])
        .flatMap(([label, value]) => (typeof value === "number" ? [`${label} ${write(value)}`] : []))].join(" · ");
  }

  /** Save what is drawn, with its caption, as a picture. */
  save() {
    const drawn = this.canvas.querySelector("canvas");
    if (!drawn) return;
    const size = fontSize() * devicePixelRatio, head = Math.round(1.9 * size);
    const picture = h("canvas", { width: drawn.width, height: drawn.height + head });
    const ctx = picture.getContext("2d");
    if (!ctx) return;
    ctx.fillStyle = colour("card");
    ctx.fillRect(0, 0, picture.width, picture.height);
    ctx.fillStyle = colour("ink");
    ctx.font = `${0.85 * size}px system-ui, "DejaVu Sans", sans-serif`;
    const caption = [...this.caption.childNodes].map((each) => each.textContent?.trim()).filter(Boolean).join("  ");
    ctx.fillText(caption, 0.6 * size, 1.25 * size);
    ctx.drawImage(drawn, 0, head);
    const link = h("a", { href: picture.toDataURL("image/png"), download: `${this.look.name}.png` });
    link.click();
  }

  /** @param {uPlot} plot */
  selected(plot) {
    const { left, width } = plot.select;
    if (width <= CLICK) return;
    const low = plot.posToVal(left, "x"), high = plot.posToVal(left + width, "x");
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.look.onbrush?.(low, high);
  }

  /** @param {WheelEvent} event */
  turn(event) {
    if (!this.look.onzoom || !this.drawn) return;
    event.preventDefault();
    const at = this.drawn.posToVal(event.clientX - this.drawn.over.getBoundingClientRect().left, "x");
    const sideways = Math.abs(event.deltaX) > Math.abs(event.deltaY);
    if (sideways) this.move(Math.sign(event.deltaX) * 0.1, 1, at);
    else this.move(0, event.deltaY > 0 ? TURN : 1 / TURN, at);
  }

  /**
   * @param {number} shift in shares of the span
   * @param {number} times
   * @param {number} at what stays where it is
   */
  move(shift, times, at) {
    const { min, max } = this.drawn?.scales.x ?? {};
    if (min === undefined || max === undefined || min === null || max === null) return;
    const by = shift * (max - min);
    this.look.onzoom?.(at - (at - min) * times + by, at + (max - at) * times + by);
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const { min, max } = this.drawn?.scales.x ?? {};
    if (!this.look.onzoom || min === undefined || max === undefined || min === null || max === null) return;
    const middle = (min + max) / 2;
    const moves = /** @type {Record<string, [number, number]>} */ ({
      "+": [0, 1 / TURN], "=": [0, 1 / TURN], "-": [0, TURN], ArrowLeft: [-0.1, 1], ArrowRight: [0.1, 1],
    });
    if (event.key === "Home" || event.key === "0") this.look.onreset?.();
    else if (moves[event.key]) this.move(...moves[event.key], middle);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  destroy() {
    this.watch.disconnect();
    this.drawn?.destroy();
    this.drawn = null;
  }
}
