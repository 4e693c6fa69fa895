// A study: its table, a filter, and each row a recording that one click opens.

import { act, go, on, told } from "./app.js";
import { fill, h } from "./elements.js";
import { short } from "./numbers.js";

/** Rows that are shown at once; the filter finds the others. */
const SHOWN = 500;

/** @param {import("./told.js").StudyMessage["rows"][number][number]} value */
function cell(value) {
  return typeof value === "number" ? short(value, 4) : String(value ?? "");
}

/** The section of the study; nothing where none was opened. */
export function study() {
  const body = h("tbody", {}), head = h("thead", {}), count = h("span", { class: "soft small" });
  const filter = h("input", { type: "search", placeholder: "Filter: liver monday refused", "aria-label": "Filter the recordings", oninput: () => draw() });
  const title = h("h2", {});
  const element = h(
    "section", { "aria-label": "Study", class: "study", hidden: true },
    h("div", { class: "row spread" }, title, h("div", { class: "row" }, count, filter)),
    h("div", { class: "tablewrap", tabindex: 0, role: "region", "aria-label": "Recordings of the study" }, h("table", {}, head, body)),
  );

  /** @param {number} row */
  async function open(row) {
    if ((await act("recording", { row })) !== undefined && told.desk?.rungs.length) go("compare");
  }

  function draw() {
    const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    if (!told.study) return;
    const { columns, rows } = told.study;
    const found = rows
      .map((cells, row) => ({ cells, row }))
      .filter(({ cells }) => {
        const text = cells.map(cell).join(" ").toLowerCase();
        return words.every((word) => text.includes(word));
      });
    count.textContent = `${found.length} of ${rows.length} recordings${found.length > SHOWN ? `, the first ${SHOWN} shown` : ""}`;
    fill(head, h("tr", {}, columns.map((name) => h("th", {}, name.replaceAll("_", " ")))));
    fill(body, found.slice(0, SHOWN).map(({ cells: [name, ...others], row }) =>
      h("tr", {}, h("td", {}, h("button", { type: "button", class: "quiet", onclick: () => open(row) }, cell(name))), others.map((value) => h("td", {}, cell(value))))));
  }

  on("study", (news) => {
    element.hidden = false;
    title.textContent = news.name;
    draw();
  });
  return element;
}
