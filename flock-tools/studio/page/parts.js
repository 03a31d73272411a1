// Elements that several views use, and the mark of a bad join.

import { button, make } from './dom.js'

/** @typedef {import('./dom.js').Attributes} Attributes */

/** @param {string} label @param {(event: MouseEvent) => void} run @param {Attributes} [more] */
export const quiet = (label, run, more) => button(label, run, { class: 'quiet', ...more })

/** @param {...import('./dom.js').Child} text */
export const dim = (...text) => make('span', { class: 'dim' }, ...text)

/**
 * A control with its label before it, which stay in one line.
 * @param {string} label
 * @param {HTMLElement} control with an id
 * @param {...import('./dom.js').Child} more what belongs to it
 */
export const labelled = (label, control, ...more) =>
  make('span', { class: 'together' }, make('label', { for: control.id, class: 'dim' }, label), control, ...more)

/**
 * Marks the joins of a transition as bad, or takes the mark away. The page shows it at once.
 * @param {Transition | undefined} one
 * @param {import('./store.js').Store} store @param {import('./api.js').Api} api
 */
export async function markBad(one, store, api) {
  if (!one) return
  const { from, to } = one, bad = one.bad = !one.bad
  store.tell('sheep')
  try {
    await api.post('/api/joins/bad', { from, to, bad })
    api.said(`${bad ? 'Marked' : 'No longer marked'} as bad: ${from} to ${to}`)
  } catch (error) {
    one.bad = !bad
    store.tell('sheep')
    api.failed(error)
  }
}

/** What species are called, by the ending of their files. */
export const SPECIES = /** @type {Record<string, string>} */ ({ flam3: 'flame', expr: 'expression', agents: 'agents', plant: 'plant' })

/** @param {string | null} species */
export const kindOf = species => SPECIES[species ?? ''] ?? species ?? ''

/**
 * The view of an element has drawn what it was opened for.
 * @param {Element} within
 */
export function ready(within) {
  const view = within.closest('.view')
  if (view instanceof HTMLElement) view.dataset.state = 'ready'
}
