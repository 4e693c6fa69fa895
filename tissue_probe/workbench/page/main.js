// The page: its stages, its keys, its look.

import { act, brush, go, needChoices, needDesk, on, rung, shown, tell, told, zoom } from "./app.js";
import { Charts } from "./charts.js";
import { compare, fit } from "./compare.js";
import { fill, h, svg } from "./elements.js";
import { ladder } from "./ladder.js";
import { live } from "./live.js";
import { map } from "./map.js";
import { addChosen, missing, rank, step } from "./missing.js";
import { next } from "./next.js";
import { open } from "./open.js";
import { Recorded, recordedFile } from "./recorded.js";
import { stopped } from "./stopped.js";
import { take } from "./take.js";

const STAGES = /** @type {const} */ ([
  ["open", "Open", "M4 19V6a1 1 0 0 1 1-1h4l2 2h8a1 1 0 0 1 1 1v2M4 19l3-8h15l-3 8z"],
  ["compare", "Compare", "M3 17c3 0 3-9 6-9s3 6 6 6 3-9 6-9M3 20h18"],
  ["missing", "Missing", "M10 4a6 6 0 1 0 0 12 6 6 0 0 0 0-12zM14.5 14.5L21 21M10 7.5v3M10 13v.1"],
  ["next", "Next", "M4 12h14M13 6l6 6-6 6"],
  ["map", "Map", "M4 4h5v5H4zM10 4h5v5h-5zM16 4h4v5h-4zM4 10h5v5H4zM10 10h5v5h-5zM16 10h4v5h-4zM4 16h5v4H4zM10 16h5v4h-5zM16 16h4v4h-4z"],
  ["take", "Take away", "M12 4v11M7 11l5 5 5-5M4 20h16"],
  ["live", "Live", "M3 12h4l3-8 4 16 3-8h4"],
]);

const KEYS = [
  ["1 … 7", "the stages, from Open to Live"],
  ["r", "find what is missing"],
  ["↑ ↓", "another row of the ranking, its curve over the residual"],
  ["a", "add the effect of that row"],
  ["u", "undo: take the last effect away"],
  ["f", "sliders back to the fitted values"],
  ["drag", "brush samples, in any plot; Esc clears"],
  ["wheel, + −, ← →", "zoom and move in time; 0 or a double click shows all"],
  ["t", "dark or light"],
  ["Esc", "clear the brush; cancel the job under way"],
];

/** @param {string} id */
const byId = (id) => /** @type {HTMLElement} */ (document.getElementById(id));

const stage = byId("stage");
const charts = new Charts();
const recorded = new Recorded();
const panels = { compare: compare(), missing: missing() };
const work = h("div", { class: "work" });
const nothing = h("div", { class: "empty" }, h("p", {}, "Nothing is compared yet."), h("button", { type: "button", class: "main", onclick: () => go("open") }, "Open a recording"));
const sheets = /** @type {Record<string, HTMLElement>} */ ({ open: open(h("div")), next: next(), map: map(), take: take(), live: live() });

function show() {
  const name = shown.stage;
  for (const button of byId("rail").querySelectorAll("button")) {
    if (button.dataset.stage === name) button.setAttribute("aria-current", "page");
    else button.removeAttribute("aria-current");
  }
  const plots = name === "compare" || name === "missing";
  if (!plots) {
    stage.replaceChildren(sheets[name]);
    return;
  }
  if (!rung()) {
    const instead = stopped();
    if (instead) {
      stage.replaceChildren(instead);
      return;
    }
    const file = recordedFile();
    if (stage.firstElementChild !== (file ? recorded.element : nothing)) stage.replaceChildren(file ? recorded.element : nothing);
    if (file) recorded.set(file);
    return;
  }
  const panel = panels[/** @type {keyof typeof panels} */ (name)];
  if (work.lastElementChild !== panel || work.parentElement !== stage) {
    work.replaceChildren(charts.element, panel);
    stage.replaceChildren(work);
    charts.update();
  }
}

fill(
  byId("rail"),
  STAGES.map(([name, label, path], number) =>
    h("button", { type: "button", "data-stage": name, title: `${label} (${number + 1})`, onclick: () => go(name) },
      svg("svg", { viewBox: "0 0 24 24", "aria-hidden": "true" }, svg("path", { d: path })), label)),
);
ladder(byId("ladder"), byId("status"));
on("choices", () => {
  const button = byId("rail").querySelector("[data-stage=live]");
  if (button instanceof HTMLElement) button.hidden = !needChoices().live;
});

let begun = false;

/** The stage that shows what the desk begins with; none while there is nothing to be seen. */
function beginning() {
  const { files, fitted, map: found, rungs, asked } = needDesk();
  if (rungs.length) return "compare";
  if (found) return "map";
  const file = files.find((each) => each.number === fitted);
  return file?.ready && !((file.sites ?? 0) > 1 && asked.site === null) ? "compare" : null;
}

on("stage", () => {
  begun = true;
  show();
  stage.scrollTop = 0;
});
on("desk", () => {
  // What was opened on the command line is shown, unless the user has gone elsewhere meanwhile.
  const first = begun ? null : beginning();
  if (first) {
    shown.stage = first;
    begun = true;
  }
  const known = needDesk().rungs.map((each) => each.number);
  if (shown.rung !== null && !known.includes(shown.rung)) shown.rung = null;
  if (rung()?.number !== last) {
    last = rung()?.number;
    shown.values = {};
    tell("rung", last);
  }
  show();
});
/** @type {number | undefined} */
let last;
on("unbrush", () => brush(null));
on("unzoom", () => zoom(null));

const gone = h("div", { class: "gone", role: "alertdialog", "aria-label": "The server is gone", hidden: true },
  h("h1", {}, "The server is gone"), h("p", {}, "Start ", h("code", {}, "tissue_probe workbench"), " again: this page goes on where it was."));
document.body.append(gone);
on("there", (there) => {
  gone.hidden = there;
});

/** @param {string} theme */
function paint(theme) {
  document.documentElement.dataset.theme = theme;
  tell("theme", theme);
}
const dark = matchMedia("(prefers-color-scheme: dark)");
const kept = localStorage.getItem("theme");
paint(kept ?? (dark.matches ? "dark" : "light"));
dark.addEventListener("change", () => !localStorage.getItem("theme") && paint(dark.matches ? "dark" : "light"));
function turn() {
  const other = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  localStorage.setItem("theme", other);
  paint(other);
}
byId("theme").addEventListener("click", turn);

const help = h("dialog", { "aria-label": "Keys" }, h("h1", { style: { "margin-bottom": "0.8rem" } }, "Keys"),
  h("table", {}, h("tbody", {}, KEYS.map(([key, does]) => h("tr", {}, h("td", {}, h("kbd", {}, key)), h("td", {}, does))))),
  h("form", { method: "dialog", style: { "margin-top": "1rem", "text-align": "right" } }, h("button", {}, "Close")));
document.body.append(help);
byId("help").addEventListener("click", () => help.showModal());

/** @type {Record<string, () => void>} */
const DOES = {
  r: () => {
    if (!rung()) return;
    go("missing");
    rank();
  },
  a: addChosen,
  u: () => (told.desk?.rungs.length ?? 0) > 1 && act("undo"),
  f: fit,
  t: turn,
  "?": () => help.showModal(),
  Escape: () => (shown.brush ? brush(null) : told.job && act("cancel")),
};

addEventListener("keydown", (event) => {
  const target = /** @type {HTMLElement} */ (event.target);
  const typing = target.matches("input:not([type=range]):not([type=checkbox]), textarea, select");
  if (typing || event.ctrlKey || event.metaKey || event.altKey || help.open) return;
  const place = Number(event.key);
  if (place >= 1 && place <= STAGES.length - Number(!told.choices?.live)) go(STAGES[place - 1][0]);
  else if (shown.stage === "missing" && (event.key === "ArrowDown" || event.key === "ArrowUp") && !target.matches("input")) {
    event.preventDefault();
    step(event.key === "ArrowDown" ? 1 : -1);
  } else DOES[event.key]?.();
});
show();
