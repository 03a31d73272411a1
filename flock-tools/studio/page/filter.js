// Which sheep the Wall shows, and in which order.
//
// Owns the choices, their controls, and the order, which stays as it is while sheep are marked: a mark moves nothing. An
// order is made anew when the artist chooses one. Never draws sheep.
//
// Start at [`Filter`].

import { button, make } from './dom.js'

/** @typedef {[value: string, label: string][]} Choices */

/**
 * How far share is from want, at either side.
 * @param {Sheep} one
 */
const off = one => !one.wanted ? -1 : one.share ? Math.abs(Math.log2(one.share / one.wanted)) : 99
/** @param {Sheep} one */
const liked = one => one.votes ? (one.votes.for + 1) / (one.votes.for + one.votes.against + 2) : 0.5

/** @type {Record<string, {label: string, before: (a: Sheep, b: Sheep) => number}>} */
const ORDERS = {
  id: { label: 'Name', before: () => 0 },
  worst: { label: 'Furthest from its want', before: (a, b) => off(b) - off(a) },
  share: { label: 'Most shown', before: (a, b) => b.share - a.share },
  votes: { label: 'Best liked', before: (a, b) => liked(b) - liked(a) },
  rating: { label: 'Rating', before: (a, b) => b.rating - a.rating },
  activity: { label: 'Liveliest', before: (a, b) => (b.activity ?? -1) - (a.activity ?? -1) },
  newest: { label: 'Newest', before: (a, b) => (b.made_ms ?? 0) - (a.made_ms ?? 0) },
  cost: { label: 'Most left to render', before: (a, b) => left(b) - left(a) },
}
/**
 * Frames that are not rendered yet.
 * @param {Sheep} one
 */
const left = one => one.state === 'there' ? 0 : one.frames * (1 - (one.percent ?? 0) / 100)

const HUES = ['red', 'orange', 'yellow', 'green', 'cyan', 'blue', 'violet', 'pink']
/**
 * The name of a colour.
 * @param {string | null} colour `#rrggbb`
 */
function hue(colour) {
  if (!colour) return ''
  const [r, g, b] = [1, 3, 5].map(at => parseInt(colour.slice(at, at + 2), 16) / 255)
  const most = Math.max(r, g, b), least = Math.min(r, g, b), wide = most - least
  if (wide < 0.09) return most > 0.6 ? 'white' : 'grey'
  const turn = most === r ? (g - b) / wide : most === g ? 2 + (b - r) / wide : 4 + (r - g) / wide
  const degrees = (turn * 60 + 360) % 360
  const ends = [15, 42, 68, 160, 195, 255, 290, 340]
  const at = ends.findIndex(end => degrees < end)
  return HUES[at < 0 ? 0 : at]
}

/**
 * What may be asked of a sheep. `kinds` are the choices, or a function of all sheep; `is` tells whether one fits.
 * @type {{name: string, label: string, kinds: Choices | ((all: Sheep[]) => Choices), is: (one: Sheep, value: string, thirds: number[]) => boolean}[]}
 */
const ASKED = [
  { name: 'of', label: 'From', kinds: [['flock', 'In the flock'], ['pool', 'In the pool'], ['archive', 'In the archive'], ['candidates', 'Not in the flock']],
    is: (one, value) => value === 'flock' ? one.in_flock : !one.in_flock && (value === 'candidates' || one.source === value) },
  { name: 'mark', label: 'Mark', kinds: [['kept', 'Kept'], ['none', 'Not marked'], ['rejected', 'Rejected'], ['open', 'Not rejected']],
    is: (one, value) => value === 'open' ? one.mark !== 'rejected' : one.mark === value },
  { name: 'shown', label: 'Share', kinds: [['less', 'Shown less than wanted'], ['more', 'Shown more than wanted'], ['never', 'Never shown'], ['near', 'Near its want']],
    is: (one, value) => value === 'never' ? one.in_flock && !one.shown : one.shown && one.ratio !== null && (value === 'less' ? one.ratio < 0.8 : value === 'more' ? one.ratio > 1.25 : off(one) <= 0.33) },
  { name: 'state', label: 'Clip', kinds: [['there', 'Rendered'], ['open', 'Not rendered'], ['rendering', 'Rendering or waiting'], ['damaged', 'Damaged']],
    is: (one, value) => value === 'open' ? one.state === 'missing' || one.state === 'none' : value === 'rendering' ? one.state === 'queued' || one.state === 'rendering' : one.state === value },
  { name: 'species', label: 'Species', kinds: all => named(all.map(one => one.species ?? 'unknown')), is: (one, value) => (one.species ?? 'unknown') === value },
  { name: 'licence', label: 'Licence', kinds: all => named(all.map(one => one.licence ?? 'none given')), is: (one, value) => (one.licence ?? 'none given') === value },
  { name: 'activity', label: 'Activity', kinds: [['0', 'Calm'], ['1', 'Moderate'], ['2', 'Lively']],
    is: (one, value, thirds) => one.activity !== null && String(thirds.filter(third => (one.activity ?? 0) >= third).length) === value },
  { name: 'colour', label: 'Colour', kinds: all => named(all.map(one => hue(one.colour)).filter(Boolean)), is: (one, value) => hue(one.colour) === value },
  { name: 'votes', label: 'Votes', kinds: [['liked', 'More for than against'], ['disliked', 'More against than for'], ['none', 'No votes yet']],
    is: (one, value) => value === 'none' ? !one.votes : !!one.votes && (value === 'liked' ? one.votes.for > one.votes.against : one.votes.against > one.votes.for) },
  { name: 'rated', label: 'Rating', kinds: [['1', '1 or more'], ['2', '2 or more'], ['3', '3 or more'], ['4', '4 or more'], ['5', '5']], is: (one, value) => one.rating >= Number(value) },
]

/**
 * @param {string[]} values
 * @returns {Choices}
 */
const named = values => [...new Set(values)].sort().map(value => [value, value])

const names = new Intl.Collator('en', { numeric: true })

export class Filter {
  /**
   * @param {import('./store.js').Store} store
   * @param {() => void} changed
   */
  constructor(store, changed) {
    this.store = store
    this.changed = changed
    this.order = 'id'
    this.text = ''
    /** @type {Record<string, string>} */ this.asked = {}
    /** @type {string[]} All ids in the order of when it was chosen. */ this.ranked = []
    this.search = make('input', { class: 'field', type: 'search', placeholder: 'Search', 'aria-label': 'Search by name, author or parent', oninput: () => this.choose(() => { this.text = this.search.value.trim().toLowerCase() }) })
    this.sorting = this.select('Order', Object.entries(ORDERS).map(([value, { label }]) => [value, label]), '', value => { this.order = value })
    /** @type {Map<string, HTMLSelectElement>} */ this.selects = new Map()
    this.row = make('div', { class: 'bar filters', hidden: true })
    this.more = button('Filter', () => this.unfold(this.row.hidden), { class: 'quiet', 'aria-expanded': 'false' })
    this.clear = button('Show all', () => this.choose(() => { this.asked = {}; this.text = ''; this.search.value = '' }), { class: 'quiet', hidden: true })
  }

  /** @param {boolean} open */
  unfold(open) {
    this.row.hidden = !open
    this.more.setAttribute('aria-expanded', String(open))
    if (open) this.drawRow()
  }

  drawRow() {
    const all = this.all()
    for (const { name, label, kinds } of ASKED) {
      const choices = typeof kinds === 'function' ? kinds(all) : kinds
      const before = this.selects.get(name)
      if (before && before.options.length === choices.length + 1) before.value = this.asked[name] ?? ''
      else {
        const fresh = this.select(label, choices, `${label}: any`, value => { if (value) this.asked[name] = value; else delete this.asked[name] })
        fresh.value = this.asked[name] ?? ''
        before ? before.replaceWith(fresh) : this.row.append(fresh)
        this.selects.set(name, fresh)
      }
    }
  }

  /**
   * @param {string} label
   * @param {Choices} choices
   * @param {string} any the first choice, which asks nothing; none if empty
   * @param {(value: string) => void} chosen
   */
  select(label, choices, any, chosen) {
    /** @type {HTMLSelectElement} */
    const select = make('select', { class: 'field', 'aria-label': label, onchange: () => this.choose(() => chosen(select.value)) },
      any && make('option', { value: '' }, any), ...choices.map(([value, text]) => make('option', { value }, text)))
    return select
  }

  /** @param {() => void} change */
  choose(change) {
    change()
    this.rank()
    this.show()
    this.changed()
  }

  /** What the controls show of the choices. */
  show() {
    const asks = Object.keys(this.asked).length
    this.more.textContent = asks ? `Filter (${asks})` : 'Filter'
    this.clear.hidden = !asks && !this.text
    this.sorting.value = this.order
    if (this.search.value.trim().toLowerCase() !== this.text) this.search.value = this.text
    if (!this.row.hidden) this.drawRow()
    for (const [name, select] of this.selects) select.classList.toggle('set', name in this.asked)
  }

  all() {
    return [...this.store.state.sheep, ...this.store.state.candidates]
  }

  /** Makes the order anew. */
  rank() {
    const { before } = ORDERS[this.order] ?? ORDERS.id
    this.ranked = this.all().sort((a, b) => before(a, b) || names.compare(a.id, b.id)).map(one => one.id)
  }

  /**
   * The ids of the sheep that fit, in order. New sheep are last until an order is chosen.
   * @returns {string[]}
   */
  ids() {
    const { byId } = this.store
    if (byId.size !== this.ranked.length || this.ranked.some(id => !byId.has(id))) {
      const there = this.ranked.filter(id => byId.has(id)), known = new Set(there)
      this.ranked = [...there, ...[...byId.keys()].filter(id => !known.has(id)).sort(names.compare)]
    }
    const asked = ASKED.filter(({ name }) => name in this.asked)
    if (!asked.length && !this.text) return this.ranked
    const thirds = 'activity' in this.asked ? this.thirds() : []
    return this.ranked.filter(id => {
      const one = byId.get(id)
      return one && asked.every(({ name, is }) => is(one, this.asked[name], thirds)) && (!this.text || said(one).includes(this.text))
    })
  }

  /** Whether a choice is about what is seen in pictures. */
  needsLooks() {
    return this.order === 'activity' || 'activity' in this.asked || 'colour' in this.asked
  }

  /** How many sheep have pictures of which nothing is known yet. */
  unknown() {
    return this.all().filter(one => one.strip !== null && one.activity === null).length
  }

  /** Where the second and the last third of all sheep by activity begin. */
  thirds() {
    const lively = this.all().flatMap(one => one.activity === null ? [] : [one.activity]).sort((a, b) => a - b)
    return [lively[Math.floor(lively.length / 3)] ?? 0, lively[Math.floor(2 * lively.length / 3)] ?? 0]
  }

  /**
   * For the address.
   * @returns {Record<string, string>}
   */
  params() {
    return { ...this.asked, ...this.order === 'id' ? {} : { order: this.order }, ...this.text ? { text: this.text } : {} }
  }

  /** @param {URLSearchParams} params */
  take(params) {
    this.asked = Object.fromEntries(ASKED.flatMap(({ name }) => params.get(name) ? [[name, params.get(name) ?? '']] : []))
    this.order = params.get('order') ?? 'id'
    if (!(this.order in ORDERS)) this.order = 'id'
    this.text = params.get('text') ?? ''
    this.rank()
    if (Object.keys(this.asked).length && innerHeight > 600 && innerWidth > 736) this.unfold(true)
    this.show()
  }
}

/**
 * What a search reads of a sheep.
 * @param {Sheep} one
 */
const said = one => `${one.id} ${one.species ?? ''} ${one.authors.join(' ')} ${one.parents.join(' ')}`.toLowerCase()
