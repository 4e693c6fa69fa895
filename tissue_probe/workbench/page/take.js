// Take away: model, report, notebook, the whole state.

import { needDesk, on, refuse } from "./app.js";
import { Refused } from "./connection.js";
import { fill, h } from "./elements.js";

const FILES = [
  { name: "model.yaml", title: "The model", text: "The last model of the ladder with its values: for compare, for the Kalman filters, for the simulated probe.", needs: "model" },
  { name: "report.html", title: "The report", text: "One page that works off line: ladder, equations, values, signals, findings. It is computed again, which takes some seconds.", needs: "model" },
  { name: "map.html", title: "The map", text: "One page that works off line: stiffness, P(inclusion), sizes that could hide, the inclusions.", needs: "map" },
  { name: "steps.ipynb", title: "A notebook", text: "Each step that was made here, by the Python interface.", needs: "file" },
  { name: "desk.workbench", title: "The whole state", text: "One file with recordings, question and ladder: drop it on Open, and all is as it is now.", needs: "file" },
];

export function take() {
  const cards = h("div", { class: "cards" });
  on("desk", () => {
    const there = /** @type {Record<string, boolean>} */ ({ model: needDesk().rungs.length > 0, map: Boolean(needDesk().map), file: needDesk().files.length > 0 });
    fill(cards, FILES.map((each) => h("button", {
      type: "button", disabled: !there[each.needs], "data-take": each.name, "data-key": each.name, onclick: () => fetched(each.name),
    }, h("b", {}, each.title), h("span", { class: "small soft" }, each.text), h("span", { class: "mono soft" }, each.name))));
  });
  return h("div", { class: "sheet" }, h("h1", {}, "Take away"), cards);
}

/** @param {string} name */
async function fetched(name) {
  const answer = await fetch(`/take/${name}`);
  if (!answer.ok) {
    refuse(new Refused(await answer.text(), [], false));
    return;
  }
  const address = URL.createObjectURL(await answer.blob());
  h("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}
