// One sheep on the Wall: its moving picture, its name, its share against its want, and what is to be known at a glance.

import { icon, make, styled } from './dom.js'
import { asWished, tiltOf, tint } from './ratio.js'
import { digits, times } from './words.js'

/**
 * How far a sheep is from its want.
 * @param {{in_flock: boolean, shown: boolean, ratio: number | null}} one
 */
export const tilt = one => one.in_flock ? tiltOf(ratioOf(one)) : 0

/** @param {{shown: boolean, ratio: number | null}} one */
const ratioOf = one => one.shown && one.ratio || 0

/**
 * share/want in words.
 * @param {Sheep} one
 */
export function against(one) {
  if (!one.in_flock) return one.source === 'archive' ? 'in the archive' : 'in the pool'
  return one.wanted ? asWished(ratioOf(one)) : 'without a loop'
}

/**
 * The state of its loop in words; empty if all is well.
 * @param {Pick<Sheep, 'state' | 'percent'>} one
 */
export function stateOf(one) {
  if (one.state === 'rendering') return one.percent === null ? 'rendering' : `${Math.round(one.percent)} %`
  return one.state === 'there' || one.state === 'none' ? '' : one.state
}

/**
 * All of that for who hears the page.
 * @param {Sheep} one
 */
export function spokenOf(one) {
  return [one.id, one.mark === 'none' ? '' : one.mark, one.rating ? `rated ${one.rating}` : '', against(one),
    one.in_flock ? `${one.ins} in, ${one.outs} out` : '', one.state === 'rendering' ? `rendering ${stateOf(one)}` : stateOf(one),
    one.votes ? `${one.votes.for} for, ${one.votes.against} against` : ''].filter(Boolean).join(', ')
}

/** @param {import('./strip.js').Strips} strips */
export function emptyCell(strips) {
  const strip = make('div', { class: 'strip', 'aria-hidden': 'true' })
  const cell = make('div', { class: 'cell', role: 'option', tabindex: -1 },
    make('div', { class: 'thumb' }, strip, make('span', { class: 'badge mark' }), make('span', { class: 'badge state' })),
    make('div', { class: 'level' }, make('i'), make('b')),
    make('div', { class: 'caption' }, make('span', { class: 'id' }), make('span', { class: 'ratio' }), make('span', { class: 'more' }), make('span', { class: 'votes' })))
  // The pointer runs through the loop; it never takes the focus.
  strip.addEventListener('pointermove', event => strips.hold(strip, event.offsetX / strip.clientWidth))
  strip.addEventListener('pointerleave', () => strips.hold(strip, null))
  return cell
}

/** @param {Element} cell @param {string} selector */
const part = (cell, selector) => /** @type {HTMLElement} */ (cell.querySelector(selector))

/**
 * @param {HTMLElement} cell
 * @param {Sheep} one
 * @param {{focused: boolean, selected: boolean, hit: boolean, target: boolean}} how `hit`: the next action is for it
 * @param {import('./strip.js').Strips} strips
 */
export function fillCell(cell, one, how, strips) {
  const { focused, selected, hit, target } = how
  // Scrolling draws many cells; what is as it was is left alone.
  const now = [one.id, one.mark, one.rating, one.state, one.percent, one.ratio, one.strip, one.ins, one.outs, one.in_flock, one.votes?.for, one.votes?.against, focused, selected, hit, target].join()
  if (cell.dataset.drawn === now) return
  cell.dataset.drawn = now
  strips.show(part(cell, '.strip'), one)
  cell.tabIndex = focused ? 0 : -1
  cell.setAttribute('aria-selected', String(hit))
  cell.setAttribute('aria-label', spokenOf(one))
  cell.className = `cell ${one.mark} ${one.in_flock ? 'inside' : 'outside'}${focused ? ' focused' : ''}${selected ? ' selected' : ''}${target ? ' target' : ''}`
  part(cell, '.id').textContent = one.id
  const ratio = part(cell, '.ratio'), off = tilt(one)
  ratio.textContent = !one.in_flock ? one.source ?? '' : one.shown && one.ratio ? `${times(one.ratio)}×` : 'never'
  styled(ratio, { '--tint': tint(off) })
  part(cell, '.more').textContent = [one.rating ? '★'.repeat(one.rating) : '', one.in_flock ? `${digits(one.ins)} in, ${digits(one.outs)} out` : one.species ?? ''].filter(Boolean).join(' · ')
  part(cell, '.votes').textContent = one.votes ? `+${one.votes.for} −${one.votes.against}` : ''
  const mark = part(cell, '.mark')
  mark.replaceChildren(...one.mark === 'none' ? [] : [icon(one.mark)])
  part(cell, '.state').textContent = stateOf(one)
  part(cell, '.state').dataset.state = one.state
  styled(part(cell, '.level i'), { width: `${(50 * Math.min(2, one.in_flock && one.ratio || 0)).toFixed(1)}%`, background: tint(off) })
  part(cell, '.level').classList.toggle('none', !one.in_flock || !one.wanted)
}
