// Effects of one's own: from a file, or typed; their program runs after consent only.

import { act, needDesk, on, say } from "./app.js";
import { fill, h } from "./elements.js";

const TEMPLATE = `"""An effect of my own: a further force of the tissue on the tip."""

import sympy as sp

from tissue_probe.physics.effects.effect import INDENTATION, Effect, Parameter

STRENGTH = Parameter(sp.Symbol("my_strength", real=True), "N/m^2", 1e4, -1e8, 1e8)

MY_EFFECT = Effect(
    name="my_effect",
    family="stiffening",
    physics="the force grows with the square of the indentation",
    parameters=(STRENGTH,),
    force=STRENGTH.symbol * INDENTATION * sp.Abs(INDENTATION),
)
`;

export function own() {
  const code = h("textarea", { class: "code", spellcheck: "false", "aria-label": "Program of the effects", name: "text" });
  code.value = TEMPLATE;
  const name = h("input", { type: "text", value: "my_effect.py", "aria-label": "Name of the file" });
  const consent = h("input", { type: "checkbox" });
  const file = h("input", {
    type: "file", accept: ".py", "aria-label": "File of effects",
    onchange: async () => {
      const chosen = file.files?.[0];
      if (!chosen) return;
      code.value = await chosen.text();
      name.value = chosen.name;
      consent.checked = false;
    },
  });
  const known = h("div", {});
  const form = h(
    "form",
    {
      onsubmit: async (/** @type {SubmitEvent} */ event) => {
        event.preventDefault();
        const found = await act("effects", { text: code.value, name: name.value, consent: consent.checked }, form);
        if (!found) return;
        form.querySelector(".problem")?.replaceChildren();
        say(`${found.map((each) => each.name).join(", ")} can be tried; rank again, or add it.`, true);
      },
    },
    h("div", { style: { display: "grid", gap: "0.5rem" } },
      file, code,
      h("div", { class: "row" }, name),
      h("label", { class: "check", "data-field": "consent" }, consent, "This program may run on my machine"),
      h("p", { class: "problem" }),
      h("button", { type: "submit" }, "Check and take")),
  );
  on("desk", () => fill(known, (needDesk().own ?? []).map((each) =>
    h("div", { class: "row spread" }, h("span", {}, h("b", {}, each.name), h("span", { class: "small soft" }, ` from ${each.file}`)),
      h("button", { type: "button", class: "tiny", onclick: () => act("add", { effect: each.name }) }, "Add")))));
  return h("section", {}, known, h("details", {}, h("summary", {}, "Effects of your own"), form));
}
