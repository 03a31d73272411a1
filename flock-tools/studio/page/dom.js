// Controls of the page, and its icons. Elements are made in `elements.js`, from where they are handed on.

import { draw, make } from './elements.js'

export { draw, make, styled } from './elements.js'

/** @typedef {import('./elements.js').Child} Child */
/** @typedef {import('./elements.js').Attributes} Attributes */

/** The outlines of the icons, 24 by 24, drawn with a line. */
const ICONS = {
  wall: 'M4 5h7v6H4zM13 5h7v6h-7zM4 13h7v6H4zM13 13h7v6h-7z',
  graph: 'M6 8.5a2.5 2.5 0 1 0 0-5 2.5 2.5 0 0 0 0 5zM18 12a2.5 2.5 0 1 0 0-5 2.5 2.5 0 0 0 0 5zM9 20.5a2.5 2.5 0 1 0 0-5 2.5 2.5 0 0 0 0 5zM8.5 6.5l7 2.2M7 8.4l1.4 7M16.3 11.6l-5.5 5',
  walk: 'M4 5h16v14H4zM10 9v6l5-3z',
  breed: 'M7 4c0 8 10 8 10 16M17 4c0 8-10 8-10 16M8 7h8M8 17h8',
  lineage: 'M12 4v6M12 10c0 3-6 2-6 6M12 10c0 3 6 2 6 6M12 5.5a1.5 1.5 0 1 0 0-3 1.5 1.5 0 0 0 0 3zM6 20a2 2 0 1 0 0-4 2 2 0 0 0 0 4zM18 20a2 2 0 1 0 0-4 2 2 0 0 0 0 4z',
  jobs: 'M4 7h16M4 12h11M4 17h7M19 14v6M16 17h6',
  ship: 'M4 8l8-4 8 4v8l-8 4-8-4zM4 8l8 4 8-4M12 12v8',
  undo: 'M8 5L4 9l4 4M4 9h10a5 5 0 0 1 0 10h-3',
  redo: 'M16 5l4 4-4 4M20 9H10a5 5 0 0 0 0 10h3',
  still: 'M9 6v12M15 6v12',
  play: 'M8 5l11 7-11 7z',
  keys: 'M3 7h18v10H3zM6.5 10.5h.01M10 10.5h.01M13.5 10.5h.01M17 10.5h.01M8 14h8',
  kept: 'M5 12.5l4.5 4.5L19 7.5',
  rejected: 'M6 6l12 12M18 6L6 18',
  close: 'M6 6l12 12M18 6L6 18',
  fault: 'M12 4l9 16H3zM12 10v4M12 17h.01',
  pin: 'M12 21v-6M7 15h10l-2-4V5h1V3H8v2h1v6z',
  more: 'M6 12h.01M12 12h.01M18 12h.01',
  plus: 'M12 5v14M5 12h14',
  minus: 'M5 12h14',
  whole: 'M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5',
  globe: 'M12 20a8 8 0 1 0 0-16 8 8 0 0 0 0 16zM4 12h16M12 4c3 2.5 3 13.5 0 16M12 4c-3 2.5-3 13.5 0 16',
}

/**
 * An icon, which no screen reader reads: the control around it has the name.
 * @param {keyof typeof ICONS} name
 */
export const icon = name => draw('svg', { class: 'icon', viewBox: '0 0 24 24', 'aria-hidden': 'true' }, draw('path', { d: ICONS[name] }))

/**
 * A button. `label` is its text, or with an icon its name and its hint.
 * @param {string} label
 * @param {(event: MouseEvent) => void} run
 * @param {Attributes & {icon?: keyof typeof ICONS}} [attributes]
 */
export function button(label, run, attributes = {}) {
  const { icon: drawn, ...others } = attributes
  const named = drawn ? { 'aria-label': label, title: label } : {}
  return make('button', { type: 'button', onclick: run, ...named, ...others }, drawn ? icon(drawn) : label)
}

/**
 * The one element that `selector` names. A bug of ours if there is none.
 * @param {string} selector
 * @param {ParentNode} [within]
 * @returns {HTMLElement}
 */
export function $(selector, within = document) {
  const found = within.querySelector(selector)
  if (!(found instanceof HTMLElement)) throw new Error(`no element \`${selector}\``)
  return found
}
