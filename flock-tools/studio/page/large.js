// Loops seen large: one, or two to four side by side.
//
// Owns the layer and which of its sheep has the focus. Marks go through the functions that the Wall hands over, so that a key
// does the same here and there.

import { button, make } from './dom.js'
import { spokenOf, stateOf } from './cell.js'

/**
 * @typedef {object} Hands
 * @property {import('./store.js').Store} store
 * @property {Shell} shell
 * @property {(mark: Mark, ids: string[]) => void} mark
 * @property {(rating: number, ids: string[]) => void} rate
 * @property {(by: number) => string | null} next the sheep before or after that one on the Wall, which has the focus then
 */

/**
 * Shows a sheep's loop in `frame`: the clip if it is there, else its strip. Returns what ends it.
 * @param {HTMLElement} frame
 * @param {Sheep} one
 * @param {Hands} hands
 */
function play(frame, one, { shell, store }) {
  const canvas = make('canvas', { 'aria-hidden': 'true' })
  frame.replaceChildren(canvas)
  shell.strips.show(canvas, one)
  let ended = false
  /** @type {(() => void) | undefined} */ let stop
  if (one.fragments && shell.moving()) {
    const key = one.fragments
    const video = make('video', { muted: true, playsinline: true, 'aria-hidden': 'true' })
    video.muted = true
    video.addEventListener('playing', () => { canvas.hidden = true })
    frame.append(video)
    import('./mse.js').then(({ loopOf }) => { if (!ended) stop = loopOf(video, key, store.state.fps) }).catch(() => video.remove())
  }
  return () => {
    ended = true
    stop?.()
    shell.strips.forget(canvas)
  }
}

/**
 * One loop over the whole page; the arrows go on along the Wall.
 * @param {string} id
 * @param {Hands} hands
 */
export function openLarge(id, hands) {
  const { store, shell } = hands
  const frame = make('div', { class: 'frame' }), words = make('p', { class: 'words', role: 'status' })
  const keep = button('Keep', () => act('kept'), { class: 'quiet' }), reject = button('Reject', () => act('rejected'), { class: 'quiet' })
  const clear = button('Clear mark', () => act('none'), { class: 'quiet' })
  let at = id, end = () => {}
  const show = (/** @type {string | null} */ next) => {
    if (next === null) return
    at = next
    const one = store.byId.get(at)
    if (!one) return close()
    end()
    end = play(frame, one, hands)
    name.textContent = one.id
    tell()
  }
  const tell = () => {
    const one = store.byId.get(at)
    if (!one) return
    words.textContent = spokenOf(store.live(one)).split(', ').slice(1).join(' · ')
    keep.setAttribute('aria-pressed', String(one.mark === 'kept'))
    reject.setAttribute('aria-pressed', String(one.mark === 'rejected'))
  }
  const act = (/** @type {Mark} */ mark, stay = false) => {
    hands.mark(mark, [at])
    const next = stay ? at : hands.next(1)
    next === at ? tell() : show(next)
  }
  const go = (/** @type {number} */ by) => show(hands.next(by))
  const name = make('h2')
  const content = make('div', { class: 'enlarged' }, frame, make('div', { class: 'bar under' }, make('div', { class: 'grow' }, name, words),
    button('Before', () => go(-1), { class: 'quiet' }), button('Next', () => go(1), { class: 'quiet' }), keep, reject, clear, button('Close', () => close(), { class: 'quiet', icon: 'close' })))
  const off = store.on(['sheep', 'state', 'clips'], tell)
  const close = shell.over(content, {
    label: 'Loop', closed: () => { end(); off() },
    keys: [
      { keys: ['Space', 'Enter', 'Escape'], does: 'close', run: () => close() },
      { keys: ['ArrowLeft', 'ArrowUp'], does: 'the one before', run: () => go(-1) },
      { keys: ['ArrowRight', 'ArrowDown'], does: 'the next one', run: () => go(1) },
      ...markKeys((mark, stay) => act(mark, stay)),
      { keys: ['0', '1', '2', '3', '4', '5'], does: 'rate', run: event => hands.rate(Number(event.key), [at]) },
    ],
  })
  show(id)
}

/**
 * The keys of marks, here and on the Wall.
 * @param {(mark: Mark, stay: boolean) => void} run
 * @returns {Key[]}
 */
export const markKeys = run => [
  { keys: ['k'], does: 'keep, and on to the next', hint: 'keep', run: () => run('kept', false) },
  { keys: ['x'], does: 'reject, and on to the next', hint: 'reject', run: () => run('rejected', false) },
  { keys: ['u'], does: 'take the mark away, and on to the next', run: () => run('none', false) },
  { keys: ['Shift+K'], does: 'keep, and stay', run: () => run('kept', true) },
  { keys: ['Shift+X'], does: 'reject, and stay', run: () => run('rejected', true) },
  { keys: ['Shift+U'], does: 'take the mark away, and stay', run: () => run('none', true) },
]

/**
 * Two to four loops side by side.
 * @param {string[]} ids
 * @param {Hands} hands
 */
export function openCompare(ids, hands) {
  const { store, shell } = hands
  let at = 0
  /** @type {(() => void)[]} */ const ends = []
  const seats = ids.map((id, seat) => {
    const frame = make('div', { class: 'frame' })
    const one = store.byId.get(id)
    if (one) ends.push(play(frame, one, hands))
    const keep = button('Keep', () => { look(seat); hands.mark('kept', [id]) }, { class: 'quiet' })
    const reject = button('Reject', () => { look(seat); hands.mark('rejected', [id]) }, { class: 'quiet' })
    const root = make('div', { class: 'seat', role: 'group', 'aria-label': id, tabindex: -1, 'data-sheep': id, onclick: () => look(seat), onfocusin: () => look(seat) },
      frame, make('div', { class: 'bar' }, make('b', { class: 'grow' }, id), make('span', { class: 'dim' }, one ? stateOf(one) : ''), keep, reject))
    return { id, root, keep, reject }
  })
  const look = (/** @type {number} */ seat) => { at = seat; tell() }
  const tell = () => seats.forEach(({ id, root, keep, reject }, seat) => {
    const mark = store.byId.get(id)?.mark
    root.classList.toggle('focused', seat === at)
    root.classList.toggle('rejected', mark === 'rejected')
    keep.setAttribute('aria-pressed', String(mark === 'kept'))
    reject.setAttribute('aria-pressed', String(mark === 'rejected'))
  })
  const go = (/** @type {number} */ by) => { look((at + by + seats.length) % seats.length); seats[at].root.focus() }
  const content = make('div', { class: 'enlarged compare', 'data-seats': ids.length }, make('div', { class: 'seats' }, ...seats.map(seat => seat.root)),
    make('div', { class: 'bar under end' }, button('Close', () => close(), { class: 'quiet' })))
  const off = store.on(['sheep', 'state'], tell)
  const close = shell.over(content, {
    label: 'Compare', closed: () => { off(); for (const end of ends) end() },
    keys: [
      { keys: ['c', 'Space', 'Escape'], does: 'close', run: () => close() },
      { keys: ['ArrowLeft', 'ArrowUp'], does: 'the one before', run: () => go(-1) },
      { keys: ['ArrowRight', 'ArrowDown'], does: 'the next one', run: () => go(1) },
      ...markKeys(mark => hands.mark(mark, [seats[at].id])),
      { keys: ['0', '1', '2', '3', '4', '5'], does: 'rate', run: event => hands.rate(Number(event.key), [seats[at].id]) },
    ],
  })
  tell()
  seats[0].root.focus()
}
