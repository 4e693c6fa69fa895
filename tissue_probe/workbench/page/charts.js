// The plots of the stages Compare, Missing and Next: one column, or two side by side.

import { needDesk, on, rung, shown, tell, told } from "./app.js";
import { Column } from "./column.js";
import { fill, h } from "./elements.js";

/** Makes the plots once; they are moved from stage to stage with all that is drawn in them. */
export class Charts {
  constructor() {
    this.beside = h("select", {
      "aria-label": "Beside it", title: "Beside it: another model, or the second recording",
      onchange: () => this.choose(this.beside.value),
    });
    this.clear = h("button", { type: "button", class: "tiny", hidden: true, onclick: () => tell("unbrush") }, "Clear brush");
    this.whole = h("button", { type: "button", class: "tiny", hidden: true, onclick: () => tell("unzoom") }, "Whole record");
    this.main = new Column(true, [this.clear, this.whole, this.beside]);
    /** @type {Column | null} */
    this.other = null;
    this.element = h("div", { class: "charts" }, this.main.element);
    this.main.onregions = (regions, marked) => tell("regions", { regions, marked });
    this.main.onlines = (lines) => tell("lines", lines);
    this.main.onstretch = (stretch) => {
      shown.stretch = stretch;
      this.update();
    };
    on("desk", () => this.update());
    on("rung", () => this.update());
    on("zoom", () => {
      this.whole.hidden = !shown.zoom;
      for (const column of this.columns()) column.refresh();
    });
    on("brush", () => {
      this.clear.hidden = !shown.brush;
      for (const column of this.columns()) column.refreshRest();
    });
    on("values", () => this.main.refresh());
    on("effect", () => this.main.refresh());
    /** @type {number | null | undefined} */
    let better;
    on("job", () => {
      const error = told.job?.rows[shown.effect ?? ""]?.rmse;
      if (error !== undefined && error !== better) this.main.refresh();
      better = error;
    });
    on("theme", () => this.columns().forEach((column) => column.restyle()));
    let waiting = 0;
    new ResizeObserver(() => {
      clearTimeout(waiting);
      waiting = window.setTimeout(() => this.columns().forEach((column) => {
        column.refresh();
        column.refreshRest();
      }), 150);
    }).observe(this.element);
  }

  columns() {
    return this.other ? [this.main, this.other] : [this.main];
  }

  /** @param {string} value */
  choose(value) {
    if (value === "") shown.beside = null;
    else if (value === "second") shown.beside = { kind: "second" };
    else shown.beside = { kind: "rung", rung: Number(value) };
    this.update();
    tell("beside");
  }

  update() {
    const own = rung();
    if (!own) return;
    const stretches = own.stretches;
    const stretch = shown.stretch !== null && shown.stretch < stretches.names.length ? shown.stretch : stretches.worst;
    this.main.set(own.number, "fitted", stretch);
    this.options(own);
    const beside = shown.beside;
    const { rungs } = needDesk();
    const there = beside?.kind === "second" ? own.second : rungs.some((each) => each.number === beside?.rung);
    if (!beside || !there) {
      if (this.other) {
        this.other.element.remove();
        this.other.destroy();
        this.other = null;
        this.element.classList.remove("two");
      }
      return;
    }
    if (!this.other) {
      this.other = new Column(false);
      this.element.append(this.other.element);
      this.element.classList.add("two");
    }
    if (beside.kind === "second") this.other.set(own.number, "second", own.second?.stretches.worst ?? 0);
    else this.other.set(/** @type {number} */ (beside.rung), "fitted", stretch);
  }

  /** @param {import("./app.js").Rung} own */
  options(own) {
    const { beside } = shown;
    fill(
      this.beside,
      h("option", { value: "" }, "nothing beside"),
      own.second && h("option", { value: "second", selected: beside?.kind === "second" }, "beside: second recording"),
      needDesk().rungs
        .filter((each) => each.number !== own.number)
        .map((each) =>
          h("option", { value: each.number, selected: beside?.kind === "rung" && beside.rung === each.number }, `beside: ${each.title}`)),
    );
  }
}
