// Sliders of weights and wants, whose figures follow the hand.
//
// Owns the scale, from an eighth to eight times in steps of an eighth of an octave with a stop at 1, and when the program is
// asked: while the thumb moves at most every 50 ms, the newest question wins; when it is let go the edit is made, one step
// of undo for the gesture. Keys that follow within a moment are one gesture.
//
// Start at [`slider`].

import { make, styled } from './dom.js'
import { digits } from './words.js'

const STEPS = 8
const ENDS = 3 * STEPS
const ASK_MS = 50
const GESTURE_MS = 1500

/** @param {number} value */
const stepOf = value => Math.max(-ENDS, Math.min(ENDS, Math.round(STEPS * Math.log2(value || 1))))
/** @param {number} step */
const valueOf = step => Number((2 ** (step / STEPS)).toPrecision(4))

/**
 * @typedef {object} Slid
 * @property {string} label what a screen reader says
 * @property {number} value
 * @property {(value: number) => Edit} edit
 * @property {import('./store.js').Store} store
 * @property {import('./api.js').Api} api
 */

/** The gesture that goes on over several sliders' elements, which may be made anew after an edit. */
const gesture = { of: '', name: '', at: -Infinity }

/** @param {string} of @param {import('./api.js').Api} api */
function gestureOf(of, api) {
  const now = performance.now()
  if (gesture.of !== of || now - gesture.at > GESTURE_MS) Object.assign(gesture, { of, name: api.gesture() })
  gesture.at = now
  return gesture.name
}

/**
 * A slider and a field for the same value. `set(value)` shows another one, unless a hand is on it or was a moment ago.
 * @param {Slid} slid
 */
export function slider({ label, value: first, edit, store, api }) {
  let value = first, asked = -Infinity, held = false, edits = 0
  /** @type {ReturnType<typeof setTimeout> | undefined} */ let later
  const range = make('input', { type: 'range', min: -ENDS, max: ENDS, step: 1, value: stepOf(value), 'aria-label': label, class: 'slide' })
  const typed = make('input', { class: 'field typed', inputmode: 'decimal', 'aria-label': `${label}, typed`, value: digits(value, 3) })
  const show = () => {
    if (document.activeElement !== typed) typed.value = digits(value, 3)
    range.setAttribute('aria-valuetext', digits(value, 3))
    styled(root, { '--part': (stepOf(value) + ENDS) / (2 * ENDS) })
  }
  // A key moves the thumb and lets it go at once: nothing is asked then.
  const ask = () => {
    clearTimeout(later)
    later = setTimeout(async () => {
      asked = performance.now()
      const told = await api.whatIf([edit(value)])
      if (told && held) store.suppose(told)
    }, ASK_MS - (performance.now() - asked))
  }
  const commit = async () => {
    clearTimeout(later)
    held = false
    api.hush()
    if (value === first) return store.suppose(null)
    const before = first
    first = value
    edits += 1
    const done = await api.edit([edit(value)], gestureOf(label, api))
    edits -= 1
    if (done) return
    value = first = before
    range.value = String(stepOf(value))
    store.suppose(null)
    show()
  }
  range.addEventListener('input', () => {
    held = true
    let step = Number(range.value)
    // The pointer stops at 1; keys reach the steps beside it.
    if (Math.abs(step) === 1 && range.matches(':active')) step = 0
    if (String(step) !== range.value) range.value = String(step)
    value = valueOf(step)
    show()
    ask()
  })
  range.addEventListener('change', commit)
  typed.addEventListener('change', () => {
    const said = Number(typed.value.replace(',', ''))
    if (!(said > 0) || !Number.isFinite(said)) { typed.value = digits(value, 3); return }
    value = said
    range.value = String(stepOf(value))
    commit()
  })
  typed.addEventListener('keydown', event => { if (event.key === 'Escape') { typed.value = digits(value, 3); range.focus() } })
  const root = make('div', { class: 'slider' }, range, typed)
  show()
  return {
    root, range,
    /** @param {number} fresh */
    set(fresh) {
      if (held || edits || fresh === value) return
      value = first = fresh
      range.value = String(stepOf(value))
      show()
    },
  }
}

/**
 * Share against want, as a bar with a tick: the tick is in the middle, the bar is at most twice the want.
 * @param {number} ratio
 * @param {string} colour
 */
export function level(ratio, colour) {
  const bar = make('i')
  styled(bar, { width: `${(50 * Math.min(2, ratio)).toFixed(1)}%`, background: colour })
  return make('div', { class: 'level tall', 'aria-hidden': 'true' }, bar, make('b'))
}
