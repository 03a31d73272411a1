// Elements, as the report and the studio make them: with attributes, listeners, styles and children.
//
// Text is only ever set as text: there is no way here to make an element of a string. Start at [`make`].

/** @typedef {string | number | Node | null | undefined | false} Child */
/** @typedef {Record<string, any>} Attributes `class`, `style` as an object, `onclick` and the like, else attributes */

/**
 * @template {Element & ElementCSSInlineStyle} E
 * @param {E} element
 * @param {Attributes} attributes
 * @param {Child[]} children
 * @returns {E}
 */
function fitted(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue
    if (name === 'style') styled(element, value)
    else if (name.startsWith('on')) element.addEventListener(name.slice(2), value)
    else element.setAttribute(name, value === true ? '' : String(value))
  }
  for (const child of children) if (child || child === 0) element.append(child instanceof Node ? child : String(child))
  return element
}

/**
 * An HTML element.
 * @template {keyof HTMLElementTagNameMap} N
 * @param {N} name
 * @param {Attributes} [attributes]
 * @param {...Child} children
 */
export const make = (name, attributes = {}, ...children) => fitted(document.createElement(name), attributes, children)

/**
 * An SVG element.
 * @template {keyof SVGElementTagNameMap} N
 * @param {N} name
 * @param {Attributes} [attributes]
 * @param {...Child} children
 */
export const draw = (name, attributes = {}, ...children) =>
  fitted(document.createElementNS('http://www.w3.org/2000/svg', name), attributes, children)

/**
 * Sets styles: the page's policy forbids `style` attributes, and allows this.
 * @param {ElementCSSInlineStyle} element
 * @param {Record<string, string | number | null>} styles by their CSS names, custom properties too; null removes one
 */
export function styled(element, styles) {
  for (const [name, value] of Object.entries(styles)) {
    if (value === null) element.style.removeProperty(name)
    else element.style.setProperty(name, String(value))
  }
}
