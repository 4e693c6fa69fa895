// Elements of the page, made in one call each.

/** @typedef {Node | string | number | null | undefined | false} One */
/** @typedef {One | (One | One[])[]} Child */

/** Attributes of an element; `onclick` and the like, `class`, `style` as object.
 * @typedef {Record<string, unknown>} Given */

/**
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag
 * @param {Given} [given]
 * @param {...Child} children
 * @returns {HTMLElementTagNameMap[T]}
 */
export function h(tag, given = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(given)) {
    if (value === undefined || value === null) continue;
    if (name.startsWith("aria-")) element.setAttribute(name, String(value));
    else if (value === false) continue;
    else if (name.startsWith("on")) element.addEventListener(name.slice(2), /** @type {EventListener} */ (value));
    else if (name === "style") {
      for (const [property, of] of Object.entries(/** @type {Record<string, string>} */ (value))) element.style.setProperty(property, of);
    } else if (name === "value") Object.assign(element, { value });
    else if (value === true) element.setAttribute(name, "");
    else element.setAttribute(name, String(value));
  }
  append(element, children);
  return element;
}

/**
 * @param {Element} element
 * @param {Child[]} children
 */
function append(element, children) {
  for (const child of children) {
    if (Array.isArray(child)) append(element, child);
    else if (child instanceof Node) element.append(child);
    else if (child !== null && child !== undefined && child !== false) element.append(String(child));
  }
}

/**
 * @param {string} tag
 * @param {Given} given
 * @param {...(SVGElement | string)} children
 * @returns {SVGElement}
 */
export function svg(tag, given = {}, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(given)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), /** @type {EventListener} */ (value));
    else element.setAttribute(name, String(value));
  }
  element.append(...children);
  return element;
}

/**
 * Put others in the place of all children; the field that has the focus keeps it.
 * @param {Element} element
 * @param {...Child} children
 */
export function fill(element, ...children) {
  const focused = document.activeElement;
  const key = element.contains(focused) ? focused?.getAttribute("data-key") : null;
  element.replaceChildren();
  append(element, children);
  if (key) {
    const again = element.querySelector(`[data-key="${CSS.escape(key)}"]`);
    if (again instanceof HTMLElement) again.focus();
  }
}

/**
 * @param {string} label
 * @param {string} name
 * @param {string[]} options
 * @param {string | null | undefined} chosen
 * @param {string} [blank] what stands for none; without, one must be chosen
 */
export function choice(label, name, options, chosen, blank) {
  return h(
    "label",
    { class: "field", "data-field": name },
    label,
    h(
      "select",
      { name },
      blank !== undefined && h("option", { value: "" }, blank),
      options.map((each) => h("option", { value: each, selected: each === chosen }, worded(each))),
    ),
  );
}

/**
 * @param {string} label
 * @param {string} name
 * @param {string | number | null | undefined} value
 * @param {string} [placeholder]
 */
export function entry(label, name, value, placeholder = "") {
  return h(
    "label",
    { class: "field", "data-field": name },
    label,
    h("input", { type: "text", name, value: value ?? "", placeholder, autocomplete: "off" }),
  );
}

/** @param {string} name a name of the program's: compliant_probe */
export function worded(name) {
  return name.replaceAll("_", " ");
}
