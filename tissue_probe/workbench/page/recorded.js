// A recording as it was read: what there is to be seen before any model is fitted.

import { ask, on, refuse, told } from "./app.js";
import { fill, h } from "./elements.js";
import { Plot } from "./plot.js";

/** The recording that is fitted, or will be; while there is no map of it to be waited for. */
export function recordedFile() {
  const { files = [], fitted = null } = told.desk ?? {};
  const chosen = files.find((each) => each.number === fitted);
  return [chosen, files.at(-1)].find((each) => each?.ready) ?? null;
}

export class Recorded {
  constructor() {
    const look = (/** @type {string} */ name) => ({ name, sync: "recorded", lines: [{ label: name, colour: "measured" }] });
    this.force = new Plot(look("Force as recorded"), h("b", {}, "force"), " [N]", h("span", { class: "at" }, "time [s]"));
    this.position = new Plot(look("Position as recorded"), h("b", {}, "position"), " [mm]", h("span", { class: "at" }, "time [s]"));
    this.head = h("div", { class: "head" });
    this.element = h("div", { class: "work bare" }, h("div", { class: "charts" },
      h("div", { class: "column recorded" }, this.head, this.force.element, this.position.element)));
    /** @type {import("./told.js").FileMessage | null} */
    this.file = null;
    on("theme", () => [this.force, this.position].forEach((plot) => plot.restyle()));
    on("job", () => this.file && this.showHead());
  }

  /** @param {import("./told.js").FileMessage} file */
  async set(file) {
    const same = this.file?.number === file.number && this.file.samples === file.samples && this.file.problem === file.problem;
    this.file = file;
    this.showHead();
    if (same) return;
    const width = Math.round(this.force.canvas.clientWidth * devicePixelRatio) || 900;
    try {
      const { arrays } = await ask("recorded", { file: file.number, width: Math.min(width, 8192) });
      if (this.file.number !== file.number) return;
      this.force.show(arrays.time, [arrays.force]);
      this.position.show(arrays.time, [Float64Array.from(arrays.position, (value) => 1e3 * value)]);
    } catch (error) {
      refuse(error);
    }
  }

  showHead() {
    fill(this.head, h("h3", {}, this.file?.name), h("span", { class: "soft" }, told.job ? `as recorded; ${told.job.title}` : "as recorded"));
  }
}
