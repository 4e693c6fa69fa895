// The model to begin with: rig, tissue, how the samples begin, what is known of the rig.

import { act, on, told } from "./app.js";
import { choice, entry, fill, h } from "./elements.js";

/** @param {Element} place */
export function question(place) {
  let before = "";
  const draw = () => {
    if (!told.desk || !told.choices) return;
    const now = JSON.stringify(told.desk.asked);
    if (now === before) return;
    before = now;
    fill(place, form());
  };
  on("desk", draw);
  on("choices", draw);
}

function form() {
  const { asked } = told.desk, { choices } = told;
  const element = h(
    "form",
    {
      class: "card",
      onsubmit: (/** @type {SubmitEvent} */ event) => {
        event.preventDefault();
        const given = new FormData(element);
        const constants = read(String(given.get("constants")));
        act("ask", {
          asked: {
            rig: given.get("rig"), tissue: given.get("tissue"), starts: given.get("starts"),
            lowpass: given.get("lowpass"), known_rig: given.get("known_rig") !== null, constants,
          },
        }, element).then((done) => {
          if (done !== undefined) element.querySelector(".problem")?.replaceChildren();
        });
      },
    },
    h("h2", {}, "The model to begin with"),
    h(
      "div",
      { class: "form" },
      choice("rig", "rig", choices.rig, asked.rig),
      choice("tissue", "tissue", choices.tissue, asked.tissue),
      choice("before the first sample", "starts", choices.starts, asked.starts),
      entry("low-pass [Hz]", "lowpass", asked.lowpass, "none"),
      entry("known constants", "constants", written(asked.constants), "tip_mass=.04+-.001"),
      h("label", { class: "check" }, h("input", { type: "checkbox", name: "known_rig", checked: asked.known_rig }), "rig exactly known"),
      h("button", { type: "submit" }, told.desk.rungs.length ? "Fit again" : "Take it"),
    ),
    h("p", { class: "problem" }),
  );
  return element;
}

/** @param {Record<string, [number, number]>} constants */
function written(constants) {
  return Object.entries(constants).map(([name, [value, deviation]]) => `${name}=${value}+-${deviation}`).join(", ");
}

/**
 * What cannot be understood goes to the server as it is: its sentence says how it is written.
 * @param {string} text
 */
function read(text) {
  /** @type {Record<string, any>} */
  const found = {};
  for (const part of text.split(/[,;]\s*/).filter(Boolean)) {
    const [name, numbers = ""] = part.split("=");
    const [value, deviation = "0"] = numbers.split("+-");
    found[name.trim()] = [value.trim(), deviation.trim()];
  }
  return found;
}
