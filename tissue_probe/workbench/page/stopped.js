// Why there is no model yet: nobody has said on which rig was measured, or the samples are refused.

import { act, go, needChoices, needDesk, plain } from "./app.js";
import { h, worded } from "./elements.js";

/** The recording that is to be fitted. */
function file() {
  return needDesk().files.find((each) => each.number === needDesk().fitted);
}

/** What stands in the place of the plots; null where nothing stops the fit. */
export function stopped() {
  if (!file()) return null;
  if (needDesk().wants_rig) return rigs();
  const why = needDesk().refusal;
  return why ? refusal(why) : null;
}

function rigs() {
  return h(
    "div", { class: "sheet", "data-stopped": "rig" },
    h("h1", {}, `Which rig measured ${file()?.name}?`),
    h("p", { class: "soft" }, "A wrong rig is made up for by effects that are not there, so that none is supposed."),
    h("div", { class: "cards rigs" }, needChoices().rigs.map((rig) =>
      h("button", { type: "button", "data-rig": rig.name, onclick: () => act("ask", { asked: { rig: rig.name } }) },
        drawn(rig.drawing), h("b", {}, worded(rig.name)), h("span", { class: "small soft" }, rig.whose)))),
  );
}

/** A rig's own drawing, which comes with the program. @param {string} drawing */
function drawn(drawing) {
  const figure = document.importNode(new DOMParser().parseFromString(drawing, "image/svg+xml").documentElement, true);
  figure.setAttribute("aria-hidden", "true");
  return figure;
}

/** @param {{told: string, fields: string[]}} why */
function refusal(why) {
  const number = file()?.number;
  return h(
    "div", { class: "sheet", role: "alert", "data-stopped": "refusal" },
    h("h1", {}, `${file()?.name} cannot be fitted as it is`),
    h("p", { class: "problem" }, plain(why.told)),
    h("div", { class: "row" },
      h("button", { type: "button", class: "main", onclick: () => go("open") }, "Change what is said of it"),
      h("button", { type: "button", onclick: () => act("compare") }, "Fit again"),
      h("button", { type: "button", onclick: () => number !== undefined && act("forget", { file: number }) }, "Remove the recording")),
  );
}
