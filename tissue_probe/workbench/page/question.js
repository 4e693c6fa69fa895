// The model to begin with: rig, tissue, how the samples begin, what is known of the rig.

import { act, needChoices, needDesk, on, told } from "./app.js";
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
  const { asked } = needDesk(), choices = needChoices();
  const element = h(
    "form",
    {
      class: "card",
      onsubmit: (/** @type {SubmitEvent} */ event) => {
        event.preventDefault();
        const given = new FormData(element);
        const stated = choices.question.map((item) => [item.name, taken(item, given.get(item.name))]);
        act("ask", { asked: Object.fromEntries(stated) }, element).then((done) => {
          if (done !== undefined) element.querySelector(".problem")?.replaceChildren();
        });
      },
    },
    h("h2", {}, "The model to begin with"),
    h(
      "div",
      { class: "form" },
      choices.question.map((item) => control(item, asked[item.name])),
      h("button", { type: "submit" }, "Apply"),
    ),
    h("p", { class: "problem" }),
  );
  return element;
}

/**
 * The control by which something is stated.
 * @param {import("./told.js").ItemMessage} item
 * @param {unknown} now
 */
function control(item, now) {
  if (item.kind === "choice") return choice(item.label, item.name, item.choices, /** @type {string | null} */ (now), item.name === "rig" ? "not said" : undefined);
  if (item.kind === "flag") {
    return h("label", { class: "check", title: item.about }, h("input", { type: "checkbox", name: item.name, checked: now }), item.label);
  }
  const text = item.kind === "constants" || item.kind === "odds" ? written(/** @type {Record<string, [number, number] | number>} */ (now)) : /** @type {string | number | null} */ (now);
  return entry(item.label, item.name, text, item.example);
}

/**
 * What a control states, as the server takes it.
 * @param {import("./told.js").ItemMessage} item
 * @param {FormDataEntryValue | null} stated
 */
function taken(item, stated) {
  if (item.kind === "flag") return stated !== null;
  return item.kind === "constants" || item.kind === "odds" ? read(String(stated)) : stated;
}

/** @param {Record<string, [number, number] | number>} values */
function written(values) {
  return Object.entries(values).map(([name, known]) => `${name}=${Array.isArray(known) ? known.join("+-") : known}`).join(", ");
}

/**
 * What cannot be understood goes to the server as it is: its sentence says how it is written.
 * @param {string} text
 */
function read(text) {
  /** @type {Record<string, string[]>} */
  const found = {};
  for (const part of text.split(/[,;]\s*/).filter(Boolean)) {
    const [name, numbers = ""] = part.split("=");
    const [value, deviation = "0"] = numbers.split("+-");
    found[name.trim()] = [value.trim(), deviation.trim()];
  }
  return found;
}
