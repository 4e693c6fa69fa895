// Open: drop or choose files, say what they do not tell, choose which is fitted.

import { act, go, mark, needChoices, needDesk, on, plain, refuse, say, shown, told } from "./app.js";
import { Refused } from "./connection.js";
import { choice, entry, fill, h } from "./elements.js";
import { short, span } from "./numbers.js";
import { colour } from "./plot.js";
import { question } from "./question.js";
import { study } from "./study.js";

/** @param {Element} stage */
export function open(stage) {
  const input = h("input", { type: "file", multiple: true, class: "files", "aria-label": "Choose recordings", hidden: true, onchange: () => send([...(input.files ?? [])]) });
  const drop = h(
    "section",
    { class: "drop", "aria-label": "Open recordings" },
    h("h1", {}, "Drop recordings of one specimen here"),
    h("p", { class: "soft" }, "Bags of ROS 1 and 2, text, Excel, MATLAB, HDF5, Parquet, TDMS, NumPy; or a state that was taken away."),
    h("button", { type: "button", class: "main", onclick: () => input.click() }, "Choose files"),
    input,
    h("p", { class: "small soft" }, "Files stay on this machine. Folders and files of more than 2 GB: name them when starting ", h("code", {}, "tissue_probe workbench FILES"), "."),
  );
  const files = h("section", { class: "sheet-files", "aria-label": "Recordings" });
  const asked = h("section", { "aria-label": "The model to begin with" });
  const examples = h("section", {});
  const element = h("div", { class: "sheet" }, study(), drop, files, examples, asked);
  const draw = () => {
    drop.classList.toggle("small-drop", (told.desk?.files.length ?? 0) > 0);
    fill(
      files,
      (told.desk?.files.length ?? 0) > 0 && h("h2", {}, "Recordings"),
      (told.desk?.files ?? []).map((file) => card(file)),
    );
    for (const canvas of files.querySelectorAll("canvas")) sketch(canvas);
  };
  let before = "";
  on("desk", () => {
    const now = JSON.stringify([needDesk().files, needDesk().fitted, needDesk().second]);
    if (now === before) return; // what is typed stays
    before = now;
    draw();
  });
  on("choices", () => fill(
    examples,
    h("h2", { style: { "margin-bottom": "0.6rem" } }, "Examples"),
    h("div", { class: "cards" }, needChoices().examples.map((each) =>
      h("button", { type: "button", "data-example": each.name, onclick: () => example(each.name) }, h("b", {}, each.title), h("span", { class: "small soft" }, each.told)))),
  ));
  on("theme", draw);
  question(asked);
  addEventListener("dragover", (event) => {
    event.preventDefault();
    drop.classList.add("over");
    if (shown.stage !== "open" && event.dataTransfer?.types.includes("Files")) go("open");
  });
  addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) drop.classList.remove("over");
  });
  addEventListener("drop", (event) => {
    event.preventDefault();
    drop.classList.remove("over");
    const dropped = event.dataTransfer?.files;
    if (dropped?.length) send([...dropped]);
  });
  stage.append(element);
  return element;
}

/** @param {string} name */
async function example(name) {
  leaveFor(isNew());
  if ((await act("example", { name })) === undefined) leaving = null;
  else leave();
}

/** Which recording the page goes to as soon as the desk shows it: what it was asked for is answered
 * when everything is computed, and there is something to be seen before.
 * @type {((file: import("./told.js").FileMessage) => boolean) | null} */
let leaving = null;
on("stage", () => {
  leaving = null;
});
on("desk", () => leave());

/** @param {(file: import("./told.js").FileMessage) => boolean} which */
function leaveFor(which) {
  leaving = which;
}

/** Recordings that are not on the desk yet. */
function isNew() {
  const known = new Set(told.desk?.files.map((each) => each.number));
  return (/** @type {import("./told.js").FileMessage} */ file) => !known.has(file.number);
}

/** Go where there is something to be seen; stay where something is asked. */
function leave() {
  if (!told.desk) return;
  const { files, fitted, second, map, rungs, asked } = told.desk;
  const last = files.filter((each) => leaving?.(each)).at(-1);
  if (!last) return;
  const scanned = (last.sites ?? 0) > 1 && asked.site === null;
  if (map && (map.file === last.number) && (last.table || !rungs.length)) go("map");
  else if (last.ready && [fitted, second].includes(last.number) && !scanned) go("compare");
}

/** @param {File[]} files */
async function send(files) {
  leaveFor(isNew());
  for (const file of files) {
    try {
      const answer = await fetch("/upload", {
        method: "POST", body: file, headers: { "content-type": "application/octet-stream", "x-file-name": encodeURIComponent(file.name) },
      });
      if (!answer.ok) refuse(new Refused(await answer.text(), [], false));
    } catch {
      say(`${file.name} could not be read; is it a folder, or has it changed? Name it when starting tissue_probe workbench`);
    }
  }
  leave();
}

/** @param {import("./told.js").FileMessage} file */
function card(file) {
  const { fitted, second } = needDesk();
  const sites = file.sites ?? 0;
  const role = file.number === fitted ? "fitted" : file.number === second ? "second, only held against" : "";
  const facts = file.ready
    ? [`${(file.samples ?? 0).toLocaleString("en")} samples`, `${short(file.rate, 4)} a second`, span(file.seconds ?? 0), sites > 1 && `${sites} sites`].filter(Boolean).join(" · ")
    : file.table ? "a table of sites" : file.problem ? "" : "is read …";
  return h(
    "article",
    { class: `card${role ? " chosen" : ""}`, style: { "margin-top": "0.6rem" } },
    h(
      "div",
      { class: "row spread" },
      h("div", {}, h("h3", {}, file.name), h("span", { class: "soft small" }, [facts, role].filter(Boolean).join(" — "))),
      h(
        "div",
        { class: "row" },
        file.ready && file.number !== fitted && h("button", { type: "button", onclick: () => {
          leaveFor((each) => each.number === file.number);
          act("use", { fitted: file.number, second: second === file.number ? null : second });
        } }, "Fit this"),
        file.ready && fitted !== null && file.number !== fitted && file.number !== second &&
          h("button", { type: "button", onclick: () => act("use", { fitted, second: file.number }) }, "Use as second"),
        fitted !== null && file.number === second && h("button", { type: "button", onclick: () => act("use", { fitted, second: null }) }, "Remove as second"),
        ((file.ready && sites > 1) || file.table) && h("button", { type: "button", onclick: () => act("map", { file: file.number }).then((done) => done !== undefined && go("map")) }, "Map"),
        h("button", { type: "button", class: "quiet", "aria-label": `Take ${file.name} from the desk`, onclick: () => act("forget", { file: file.number }) }, "Remove"),
      ),
    ),
    file.ready
      ? file.notes && file.notes.length > 0 && h("details", {}, h("summary", {}, "How it was read"), h("ul", { class: "notes" }, file.notes.map((note) => h("li", {}, note))))
      : file.problem && layout(file),
    file.ready && secondInput(file),
  );
}

/** Read a file anew by what is stated in a form. @param {import("./told.js").FileMessage} file @param {HTMLFormElement} form @param {object} known */
function define(file, form, known) {
  leaveFor((each) => each.number === file.number);
  act("define", { file: file.number, layout: { ...known, ...Object.fromEntries(new FormData(form)) } }, form);
}

/** The form that names the channel of a second input. @param {import("./told.js").FileMessage} file */
function secondInput(file) {
  const given = /** @type {Record<string, string>} */ (file.layout);
  const form = h(
    "form",
    {
      class: "row",
      onsubmit: (/** @type {SubmitEvent} */ event) => {
        event.preventDefault();
        define(file, form, file.layout);
      },
    },
    entry("channel that drives the force, too", "input2", given.input2, "name of a column"),
    h("button", { type: "submit" }, "Read anew"),
  );
  return h("details", { open: Boolean(given.input2) }, h("summary", {}, "A second input"), form);
}

/** The form of what a file does not tell. @param {import("./told.js").FileMessage} file */
function layout(file) {
  const { preview } = file, given = /** @type {Record<string, string>} */ (file.layout), { choices } = told;
  const names = preview?.columns.map((column) => column.name) ?? [];
  const bag = preview?.kind === "bag";
  const form = h(
    "form",
    {
      class: "card", style: { border: 0, padding: 0 },
      onsubmit: (/** @type {SubmitEvent} */ event) => {
        event.preventDefault();
        define(file, form, {});
      },
    },
    h("p", { class: "problem" }, plain(file.problem?.told ?? "")),
    h(
      "div",
      { class: "form" },
      choice("positive forces are of", "force_polarity", ["compression", "tension"], given.force_polarity, "as its name tells"),
      choice("positions grow", "position_polarity", ["into", "out"], given.position_polarity ?? "into"),
      ["time", "position", "force"].filter((role) => !(bag && role === "time")).map((role) =>
        names.length ? choice(role, role, names, given[role], "as its name tells") : entry(role, role, given[role], "name of a column")),
      names.length ? choice("second input", "input2", names, given.input2, "none") : entry("second input", "input2", given.input2, "name of a column, if any"),
      choice("unit of the position", "position_unit", choices?.position_unit ?? [], given.position_unit, "as told, else m"),
      choice("unit of the force", "force_unit", choices?.force_unit ?? [], given.force_unit, "as told, else N"),
      !bag && choice("unit of the time", "time_unit", choices?.time_unit ?? [], given.time_unit, "as told, else s"),
      !bag && entry("samples a second, without a time", "sample_rate", given.sample_rate, "Hz"),
      bag && choice("clock", "clock", ["stamps", "recorder"], given.clock, "as they agree"),
      h("button", { type: "submit", class: "main" }, "Read"),
    ),
    preview && names.length > 0 && !bag && table(preview),
  );
  mark(form, file.problem?.fields ?? []);
  return form;
}

/** @param {import("./told.js").PreviewMessage} preview */
function table(preview) {
  const rows = Math.max(...preview.columns.map((column) => column.first.length));
  return h(
    "div",
    { class: "tablewrap", tabindex: 0, role: "region", "aria-label": "First rows" },
    h(
      "table",
      {},
      h("thead", {}, h("tr", {}, preview.columns.map((column) =>
        h("th", { scope: "col" }, h("div", {}, column.name, column.unit && ` — ${column.unit}`),
          column.sketch.length > 1 && h("canvas", { width: 256, height: 72, "data-sketch": JSON.stringify(column.sketch), role: "img", "aria-label": `Course of ${column.name}` }))))),
      h("tbody", {}, Array.from({ length: rows }, (_, row) =>
        h("tr", {}, preview.columns.map((column) => h("td", { class: "mono" }, column.first[row] ?? ""))))),
    ),
  );
}

/** @param {HTMLCanvasElement} canvas */
function sketch(canvas) {
  const values = /** @type {number[]} */ (JSON.parse(canvas.dataset.sketch ?? "[]"));
  const context = canvas.getContext("2d");
  if (!context || values.length < 2) return;
  const low = Math.min(...values), high = Math.max(...values);
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.strokeStyle = colour("predicted");
  context.lineWidth = 2;
  context.beginPath();
  values.forEach((value, number) => {
    const x = 2 + ((canvas.width - 4) * number) / (values.length - 1);
    const y = 4 + ((canvas.height - 8) * (high - value)) / (high - low || 1);
    if (number) context.lineTo(x, y);
    else context.moveTo(x, y);
  });
  context.stroke();
}
