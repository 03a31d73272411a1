// Weights that bring the flock to its wants, and the sheep that pruning would drop, each shown as a before and after; links that
// would help, and links that may go.
//
// Owns these layers. Nothing is written before the artist accepts it.

import { button, make, styled } from './dom.js'
import { cost } from './panel.js'
import { way } from './store.js'
import { digits, percent, spoken, times, why } from './words.js'

/** The most lines that are shown of a list. */
const MOST = 60

/** @param {number | null} ratio */
const ratioed = ratio => ratio === null ? 'a sheep is never shown' : times(ratio)

/**
 * @param {import('./store.js').Store} store
 * @param {import('./api.js').Api} api
 * @param {Shell} shell
 */
export function openBalance(store, api, shell) {
  const told = make('div', { class: 'told' }), accept = button('Take these weights', () => take(), { class: 'strong', disabled: true })
  const field = (/** @type {string} */ label, /** @type {string} */ value, /** @type {string} */ hint) =>
    make('input', { class: 'field typed', inputmode: 'decimal', 'aria-label': label, value, title: hint, onchange: () => ask() })
  const fairness = field('Fairness', '', 'How far transitions of one sheep may differ; empty: as dreams balance has it')
  const floor = field('Floor', '', 'The least weight of a transition; empty: as dreams balance has it')
  /** @type {{from: string, to: string, value: number}[]} */ let values = []
  let asked = 0
  const ask = async () => {
    const mine = ++asked
    accept.toggleAttribute('disabled', true)
    told.replaceChildren(make('p', { class: 'note' }, 'Balancing …'))
    try {
      const query = new URLSearchParams()
      if (fairness.value) query.set('fairness', fairness.value)
      if (floor.value) query.set('floor', floor.value)
      const answer = await api.get(`/api/balance?${query}`)
      if (mine !== asked) return
      values = answer.weights.filter((/** @type {any} */ one) => Math.abs(Math.log2(one.value / one.was)) > 1e-3)
      told.replaceChildren(...balanced(answer, values.length, store))
      accept.toggleAttribute('disabled', values.length === 0)
      if (values.length) accept.focus()
    } catch (error) {
      told.replaceChildren(make('p', { class: 'bad' }, why(error)))
    }
  }
  const take = async () => {
    close()
    await api.edit([{ do: 'weights', values: values.map(({ from, to, value }) => ({ from, to, value })) }])
  }
  const close = shell.over(make('div', { class: 'question wide balance' }, make('h2', {}, 'Balance'), told,
    make('div', { class: 'bar' }, make('label', { class: 'tick' }, 'Fairness', fairness), make('label', { class: 'tick' }, 'Floor', floor), make('span', { class: 'grow' }),
      button('Leave it', () => close(), { class: 'quiet' }), accept)), { label: 'Balance' })
  ask()
}

/**
 * @param {import('./store.js').Store} store
 * @param {import('./api.js').Api} api
 * @param {Shell} shell
 */
export function openPrune(store, api, shell) {
  const told = make('div', { class: 'told' }), accept = button('Prune', () => take(), { class: 'strong', disabled: true })
  const keep = make('select', { class: 'field', 'aria-label': 'Keep the part with', onchange: () => ask() }, make('option', { value: '' }, 'the part that is played'),
    ...store.state.sheep.map(({ id }) => make('option', { value: id }, id)))
  /** @type {string[] | null} */ let drop = null
  let asked = 0
  const ask = async () => {
    const mine = ++asked
    accept.toggleAttribute('disabled', true)
    told.replaceChildren(make('p', { class: 'note' }, 'Looking for what can be reached …'))
    try {
      /** @type {Pruning} */ const answer = await api.get(`/api/prune${keep.value ? `?keep=${encodeURIComponent(keep.value)}` : ''}`)
      if (mine !== asked) return
      const { was, figures } = answer, changes = answer.drop.length > 0 || was.transitions > figures.transitions
      drop = answer.drop
      told.replaceChildren(...changes ? pruned(answer, bring) : [make('p', { class: 'note' }, `Nothing to drop: each of ${spoken(figures.sheep, 'sheep')} can be reached from every other.`)])
      accept.textContent = drop.length ? `Drop ${spoken(drop.length, 'sheep')}` : 'Prune'
      accept.toggleAttribute('disabled', !changes)
      if (changes) accept.focus()
    } catch (error) {
      if (mine === asked) told.replaceChildren(make('p', { class: 'bad' }, why(error)))
    }
  }
  const take = async () => {
    close()
    if (drop) await api.edit([{ do: 'prune', drop }])
  }
  const bring = async (/** @type {NewLink[]} */ links) => {
    if (await api.edit(links.map(({ from, to, frames }) => ({ do: 'link', from, to, frames })))) await ask()
  }
  const close = shell.over(make('div', { class: 'question wide balance' }, make('h2', {}, 'Prune'), told,
    make('div', { class: 'bar' }, make('label', { class: 'tick' }, 'Keep', keep), make('span', { class: 'grow' }),
      button('Leave it', () => close(), { class: 'quiet' }), accept)), { label: 'Prune' })
  ask()
}

/**
 * @param {Pruning} answer
 * @param {(links: NewLink[]) => void} bring
 */
function pruned({ was, figures, drop, ties, parts, fewest, frames }, bring) {
  const side = (/** @type {Figures} */ of, /** @type {string} */ kind, /** @type {string} */ when) => make('div', {}, make('p', { class: kind }, ratioed(of.worst_ratio)),
    make('p', { class: 'note' }, `worst ratio ${when}: ${spoken(of.sheep, 'sheep')}, ${spoken(of.transitions, 'transition')}`))
  return [
    make('div', { class: 'twice' }, side(was, 'figure', 'now'), side(figures, 'figure glow', 'pruned')),
    make('div', { class: 'both' },
      make('div', {}, make('h3', {}, drop.length ? `${spoken(drop.length, 'sheep')} would be dropped` : 'Only transitions would be dropped'),
        make('ul', { class: 'diff', tabindex: 0, 'aria-label': 'Sheep to drop' }, ...drop.slice(0, MOST).map(id => make('li', {}, id)), drop.length > MOST && make('li', { class: 'dim' }, `and ${digits(drop.length - MOST)} more`))),
      make('div', {}, make('h3', {}, 'What would bring them in'),
        make('ul', { class: 'diff', tabindex: 0, 'aria-label': 'Links instead' }, ...parts.map(({ sheep, links }) => make('li', {},
          make('span', { class: 'grow' }, `${sheep[0]}${sheep.length > 1 ? ` and ${spoken(sheep.length - 1, 'sheep')}` : ''}: ${links.map(({ from, to, can_be_rendered: can }) => `${from} to ${to}${can ? '' : ', without a genome'}`).join('; ')}`),
          button('Link', () => bring(links), { class: 'quiet tight', 'aria-label': `Link ${sheep[0]} instead` })))),
        make('p', { class: 'note' }, `All of them by ${spoken(fewest, 'transition')}, ${digits(frames)} frames.`))),
    ties.length > 0 && make('p', { class: 'note' }, `As large is the part with ${ties.join(', with ')}.`),
  ].flatMap(part => part ? [part] : [])
}

/**
 * @param {any} answer
 * @param {number} changes
 * @param {import('./store.js').Store} store
 */
function balanced(answer, changes, store) {
  const before = store.state.figures.worst_ratio
  const weights = [...answer.weights].sort((a, b) => Math.abs(Math.log2(b.value / b.was)) - Math.abs(Math.log2(a.value / a.was))).slice(0, MOST)
  const sheep = [...answer.sheep].sort((a, b) => Math.abs(b.share - b.was) - Math.abs(a.share - a.was)).slice(0, MOST)
  return [
    make('div', { class: 'twice' }, make('div', {}, make('p', { class: 'figure' }, ratioed(before)), make('p', { class: 'note' }, 'worst ratio now')),
      make('div', {}, make('p', { class: 'figure glow' }, ratioed(answer.worst_ratio)), make('p', { class: 'note' }, answer.reachable ? 'balanced' : 'the nearest that weights can reach'))),
    make('div', { class: 'both' },
      make('div', {}, make('h3', {}, changes ? `${spoken(changes, 'weight')} would change` : 'No weight would change'),
        make('ul', { class: 'diff', tabindex: 0, 'aria-label': 'Weights' }, ...weights.map(one => diff(`${one.from} to ${one.to}`, digits(one.was, 2), digits(one.value, 2), one.value > one.was)))),
      make('div', {}, make('h3', {}, 'Shares'),
        make('ul', { class: 'diff', tabindex: 0, 'aria-label': 'Shares' }, ...sheep.map(one => diff(one.id, percent(one.was), percent(one.share), one.share > one.was, `${percent(one.wanted)} wished`))))),
  ]
}

/**
 * @param {string} name
 * @param {string} was
 * @param {string} is
 * @param {boolean} more
 * @param {string} [hint]
 */
const diff = (name, was, is, more, hint) => make('li', { title: hint }, make('span', { class: 'grow' }, name), make('span', { class: 'dim' }, was), make('span', { class: more ? 'rises' : 'falls' }, more ? ' ↑ ' : ' ↓ '), make('b', {}, is))

/**
 * Links that would help, which the graph shows dashed meanwhile, and links that may go.
 * @typedef {{add: {from: string, to: string, worst_ratio: number | null, frames: number, cost_s: number | null}[], remove: {from: string, to: string, worst_ratio: number | null}[]}} Suggested
 */

/**
 * The list of suggestions for the panel's place.
 * @param {Suggested} suggested
 * @param {import('./store.js').Store} store
 * @param {import('./api.js').Api} api
 * @param {{hover: (from: string | null, to: string) => void, close: () => void}} deeds
 */
export function suggestions(suggested, store, api, { hover, close }) {
  const { add, remove } = suggested, open = add.filter(one => !store.byWay.has(way(one.from, one.to))), going = remove.filter(one => store.byWay.has(way(one.from, one.to)))
  /** @type {Set<string>} */ const ticked = new Set()
  const prune = button('Unlink them', () => {
    const gone = going.filter(one => ticked.has(way(one.from, one.to)))
    api.edit(gone.map(({ from, to }) => ({ do: 'unlink', from, to })))
  }, { class: 'quiet', disabled: true })
  const hovers = (/** @type {{from: string, to: string}} */ one) => ({ onpointerenter: () => hover(one.from, one.to), onpointerleave: () => hover(null, ''), onfocusin: () => hover(one.from, one.to), onfocusout: () => hover(null, '') })
  const accept = (/** @type {{from: string, to: string, frames: number}} */ one) => { api.edit([{ do: 'link', from: one.from, to: one.to, frames: one.frames }]) }
  return [
    make('div', { class: 'bar' }, make('h2', { class: 'grow' }, 'Suggestions'), button('Close', close, { class: 'tool', icon: 'close' })),
    make('h3', {}, open.length ? 'Links that would help' : 'No link would help'),
    make('ul', { class: 'links two' }, ...open.map(one => make('li', hovers(one), make('div', { class: 'grow' }, make('div', {}, `${one.from} to ${one.to}`),
      make('div', { class: 'dim small' }, [`worst ratio ${ratioed(one.worst_ratio)}`, `${digits(one.frames)} frames`, one.cost_s === null ? '' : `${cost(one.cost_s)} to render`].filter(Boolean).join(' · '))),
    button('Link', () => accept(one), { class: 'quiet tight', 'aria-label': `Link ${one.from} to ${one.to}` })))),
    make('h3', {}, going.length ? 'Links that may go' : 'Every link is of use'),
    make('ul', { class: 'links two' }, ...going.map(one => {
      const box = make('input', { type: 'checkbox', 'aria-label': `${one.from} to ${one.to}`, onchange: () => {
        box.checked ? ticked.add(way(one.from, one.to)) : ticked.delete(way(one.from, one.to))
        prune.toggleAttribute('disabled', !ticked.size)
        prune.textContent = ticked.size ? `Unlink ${ticked.size}` : 'Unlink them'
      } })
      return make('li', hovers(one), make('label', { class: 'tick grow' }, box, make('span', {}, `${one.from} to ${one.to}`)), make('span', { class: 'dim small' }, ratioed(one.worst_ratio)))
    })),
    going.length > 0 && prune,
  ]
}

/**
 * The graph in figures.
 * @param {import('./store.js').Store} store
 * @param {Shell} shell
 * @param {(sheep: string) => void} choose
 */
export function openTable(store, shell, choose) {
  const rows = [...store.state.sheep].sort((a, b) => b.share - a.share).map(one => make('tr', {},
    make('th', { scope: 'row' }, button(one.id, () => { close(); choose(one.id) }, { class: 'name' })),
    ...[percent(one.share), percent(one.wanted), one.shown && one.ratio ? times(one.ratio) : 'never', digits(one.ins), digits(one.outs)].map(text => make('td', {}, text)),
    make('td', { class: 'long' }, (store.outs.get(one.id) ?? []).map(edge => edge.to).join(', '))))
  const table = make('table', {}, make('thead', {}, make('tr', {}, ...['Sheep', 'Share', 'Want', 'Share / want', 'In', 'Out', 'Leads to'].map(text => make('th', { scope: 'col' }, text)))), make('tbody', {}, ...rows))
  const close = shell.over(make('div', { class: 'question table' }, make('div', { class: 'bar' }, make('h2', { class: 'grow' }, 'The graph in figures'), button('Close', () => close(), { class: 'tool', icon: 'close' })), make('div', { class: 'scroll', tabindex: 0, role: 'region', 'aria-label': 'Table' }, table)), { label: 'The graph in figures' })
  styled(table, { width: '100%' })
}
