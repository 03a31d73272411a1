// The Wall: all sheep of the flock, the pool and the archive, to choose among them by eye.
//
// Owns the selection, what the keys do, and their rules: there is one focus, never the pointer's; an action is for the
// selected sheep, or if none is selected for the one with the focus, and its button says for how many; the next sheep has
// the focus before the next key is read; at the end the focus stays; rejecting deletes nothing.
//
// Start at [`view`].

import { button, make } from './dom.js'
import { Filter } from './filter.js'
import { Grid } from './grid.js'
import { emptyCell, fillCell } from './cell.js'
import { markKeys, openCompare, openLarge } from './large.js'
import { digits, spoken } from './words.js'

const STEP = 2 ** 0.25
/** Presses of `+` and `-` that follow within this many milliseconds are one step of undo. */
const GESTURE = 1500
const SIZES = { Small: [128, 24], Medium: [208, 46], Large: [340, 46] }

/** @type {MakeView} */
export function view(root, store, api, shell) {
  const wall = new Wall(root, store, api, shell)
  return { enter: params => wall.enter(params), leave: () => { wall.open = false }, keys: wall.keys() }
}

class Wall {
  /** @param {HTMLElement} root @param {import('./store.js').Store} store @param {import('./api.js').Api} api @param {Shell} shell */
  constructor(root, store, api, shell) {
    this.root = root
    this.store = store
    this.api = api
    this.shell = shell
    this.open = false
    /** @type {Set<string>} */ this.selected = new Set()
    /** @type {string | null} Where a selection with Shift began. */ this.anchor = null
    /** @type {string[]} From where a link is being made. */ this.linking = []
    this.pressed = { name: '', of: '', at: 0 }
    this.filter = new Filter(store, () => { this.list(); this.shell.note(this.filter.params()) })
    this.count = make('span', { class: 'dim count', role: 'status' })
    this.banner = make('div', { class: 'banner bar', hidden: true })
    this.unknown = make('div', { class: 'banner bar', hidden: true })
    this.scroller = make('div', { class: 'scroller' })
    this.nothing = make('div', { class: 'empty', hidden: true })
    this.grid = new Grid(this.scroller, {
      cell: () => emptyCell(shell.strips),
      fill: (cell, id) => {
        const one = store.byId.get(id)
        if (one) fillCell(cell, store.live(one), this.how(id), shell.strips)
      },
      empty: cell => { shell.strips.forget(cell.getElementsByClassName('strip')[0]); delete cell.dataset.drawn },
    }, 'Sheep')
    this.buttons = this.actions()
    this.draw()
    this.listen()
  }

  draw() {
    const sizes = make('div', { class: 'choice', role: 'group', 'aria-label': 'Size of pictures' }, ...Object.keys(SIZES).map(name =>
      button(name, () => this.resize(/** @type {keyof typeof SIZES} */ (name)), { 'data-size': name })))
    this.sizes = sizes
    this.root.append(
      make('div', { class: 'bar controls' }, this.filter.search, this.filter.sorting, this.filter.more, this.filter.clear, this.count, make('span', { class: 'grow' }), sizes),
      this.filter.row, this.unknown, this.banner, this.scroller, this.nothing,
      make('div', { class: 'bar actions', role: 'toolbar', 'aria-label': 'What to do with the chosen sheep' }, this.who = make('span', { class: 'who' }), ...this.buttons.map(({ control }) => control)))
    this.resize('Medium')
  }

  /** @param {keyof typeof SIZES} name */
  resize(name) {
    const [least, caption] = SIZES[name]
    this.root.dataset.size = name.toLowerCase()
    for (const one of this.sizes?.children ?? []) one.setAttribute('aria-pressed', String(one instanceof HTMLElement && one.dataset.size === name))
    this.grid.size(least, caption)
  }

  listen() {
    const { store, scroller } = this
    store.on(['state'], () => this.open && this.list())
    store.on(['sheep'], () => this.open && this.list())
    store.on(['looks'], () => { if (this.open) this.looked() })
    // The rest of the Wall is as it was: only cells in view whose clip is further are drawn.
    store.on(['clips'], () => { if (this.open) this.grid.again(this.grid.cells.keys()) })
    store.on(['jobs'], () => { if (this.open) this.tellUnknown() })
    store.on(['focus'], () => { if (this.open) { this.grid.focus(store.focus, false); this.tell() } })
    scroller.addEventListener('click', event => {
      const id = this.under(event)
      if (!id) return
      if (event.shiftKey) this.reach(id)
      else if (event.ctrlKey || event.metaKey) this.toggle(id)
      else {
        this.unselect()
        this.anchor = id
      }
      this.look(id)
      if (this.linking.length) this.link(id)
    })
    scroller.addEventListener('dblclick', event => { const id = this.under(event); if (id) this.enlarge() })
    scroller.addEventListener('focusin', event => {
      const id = this.under(event)
      if (!id || id === store.focus) return
      // A press with Shift moves the focus before it is a click.
      this.anchor ??= store.focus
      this.look(id)
    })
  }

  /** @param {Event} event */
  under(event) {
    const cell = event.target instanceof Element ? event.target.closest('[data-sheep]') : null
    return cell instanceof HTMLElement ? cell.dataset.sheep ?? null : null
  }

  /** @param {URLSearchParams} params */
  enter(params) {
    this.open = true
    this.filter.take(params)
    this.list()
    const at = params.get('at')
    if (at !== null && this.store.byId.has(at)) this.store.look(at)
    this.look(this.store.focus !== null && this.grid.places.has(this.store.focus) ? this.store.focus : this.grid.ids[0] ?? null)
    this.root.dataset.state = 'ready'
  }

  /** What is shown, after the state or a choice changed. */
  list() {
    const { grid, store, filter } = this
    const before = store.focus === null ? undefined : grid.places.get(store.focus)
    const ids = filter.ids()
    if (ids !== grid.ids && (ids.length !== grid.ids.length || ids.some((id, at) => id !== grid.ids[at]))) {
      grid.list(ids)
      for (const id of this.selected) if (!grid.places.has(id)) this.selected.delete(id)
      // The focus went with its sheep: the sheep that took its place has it.
      if (before !== undefined && store.focus !== null && !grid.places.has(store.focus)) this.look(ids[Math.min(before, ids.length - 1)] ?? null)
      else if (store.focus === null || before === undefined) this.look(store.focus !== null && grid.places.has(store.focus) ? store.focus : ids[0] ?? null)
    } else grid.again(grid.cells.keys())
    const all = filter.all().length
    this.count.textContent = ids.length === all ? spoken(all, 'sheep') : `${digits(ids.length)} of ${spoken(all, 'sheep')}`
    this.tellUnknown()
    this.nothing.hidden = ids.length > 0
    this.scroller.hidden = ids.length === 0
    if (!ids.length) this.nothing.replaceChildren(make('h2', {}, all ? 'No sheep fits' : 'There are no sheep yet'), make('p', {}, all ? 'Show all takes the filters away.' : 'Breed some, or put genomes or clips into the folder with dreams add.'))
    this.tell()
  }

  /** Strips were made. An order by what is seen in them is made anew when all are known: until then nothing moves. */
  looked() {
    const { filter } = this
    if (!filter.needsLooks()) return
    if (!filter.unknown()) {
      if (filter.order === 'activity') filter.rank()
      filter.show()
    }
    this.list()
  }

  /** How many sheep a choice leaves out because nobody has looked at them yet. */
  tellUnknown() {
    const missing = this.filter.needsLooks() ? this.filter.unknown() : 0
    this.unknown.hidden = !missing
    if (!missing) return
    const job = this.store.state.jobs.find(({ kind, state }) => kind === 'measure' && (state === 'queued' || state === 'running'))
    const text = `${spoken(missing, 'sheep')} ${missing === 1 ? 'is' : 'are'} not measured yet: their activity and colour are not known${job ? job.state === 'queued' ? '; it waits for other jobs' : '; they are being measured' : ''}`
    if (this.unknown.firstChild?.textContent === text) return
    this.unknown.replaceChildren(make('span', { class: 'grow' }, text), job ? '' : button('Measure them', () => { this.measure() }, { class: 'quiet' }))
  }

  async measure() {
    try {
      const { jobs } = await this.api.post('/api/jobs', { kind: 'measure' })
      for (const job of jobs) this.store.job(job)
      this.shell.say('They are measured after what is looked at, and can be paused in Jobs')
    } catch (error) { this.api.failed(error) }
  }

  /** @param {string} id */
  how(id) {
    const focused = id === this.store.focus
    return { focused, selected: this.selected.has(id), hit: this.selected.size ? this.selected.has(id) : focused, target: this.linking.length > 0 && focused && !this.linking.includes(id) }
  }

  /**
   * Moves the focus.
   * @param {string | null} id
   */
  look(id) {
    this.store.look(id)
    // The keyboard's focus follows, but is not taken from a field that somebody types in.
    const typing = document.activeElement?.matches('input, select, textarea, dialog *') ?? false
    this.grid.focus(id, !typing)
    this.tell()
  }

  /**
   * The sheep that an action is for, in the order of the Wall.
   * @returns {string[]}
   */
  get hit() {
    if (this.selected.size) return this.grid.ids.filter(id => this.selected.has(id))
    return this.store.focus !== null && this.grid.places.has(this.store.focus) ? [this.store.focus] : []
  }
  /** Those of them that are in the flock. */
  get inside() { return this.hit.filter(id => this.store.byId.get(id)?.in_flock) }
  get outside() { return this.hit.filter(id => !this.store.byId.get(id)?.in_flock) }

  /** What the line of actions says. */
  tell() {
    const one = this.store.focused
    if (this.who) this.who.textContent = this.selected.size ? `${spoken(this.selected.size, 'sheep')} selected` : one?.id ?? ''
    for (const { control, word, hits } of this.buttons) {
      const count = hits().length
      control.toggleAttribute('disabled', count === 0)
      control.textContent = this.selected.size ? `${word} ${digits(count)}` : word
    }
    this.banner.hidden = !this.linking.length
    if (this.linking.length) {
      const to = one && one.in_flock && !this.linking.includes(one.id) ? one.id : null
      this.banner.replaceChildren(make('span', { class: 'grow' }, `A link from ${this.linking.length > 1 ? spoken(this.linking.length, 'sheep') : this.linking[0]}${to ? ` to ${to}` : ': go to the sheep it leads to'}`),
        button('Link', () => { if (to) this.link(to) }, { class: 'strong', disabled: !to }), button('Cancel', () => this.unlink(), { class: 'quiet' }))
    }
  }

  actions() {
    const act = (/** @type {string} */ word, /** @type {() => void} */ run, /** @type {() => string[]} */ hits, /** @type {string} */ key) =>
      ({ word, hits, control: button(word, run, { class: 'quiet tight', title: `${word} (${key})` }) })
    const hit = () => this.hit
    return [
      act('Keep', () => this.mark('kept', false), hit, 'K'), act('Reject', () => this.mark('rejected', false), hit, 'X'), act('Clear', () => this.mark('none', false), hit, 'U'),
      act('Want −', () => this.want(1 / STEP), () => this.inside, '−'), act('Want +', () => this.want(STEP), () => this.inside, '+'),
      act('Link', () => this.startLink(), () => this.inside, 'L'),
      act('Compare', () => this.compare(), () => this.compared().length > 1 ? this.compared() : [], 'C'),
      act('Play', () => this.enlarge(), () => this.hit.slice(0, 1), 'Space'),
      act('Add', () => this.add(), () => this.outside, 'A'), act('Take out', () => this.drop(), () => this.inside, 'Delete'), act('Open', () => this.openOne(), () => this.inside.slice(0, 1), 'Enter'),
    ]
  }

  /**
   * Marks, then moves on, unless it shall stay. The focus is on the next sheep before this returns.
   * @param {Mark} mark
   * @param {boolean} stay
   */
  mark(mark, stay) {
    const ids = this.hit
    if (!ids.length) return
    const places = this.grid.places, last = Math.max(...ids.map(id => places.get(id) ?? 0))
    const next = stay ? null : this.grid.ids.slice(last + 1).find(id => !this.selected.has(id)) ?? null
    const end = !stay && next === null
    this.api.mark(ids, { mark })
    if (!stay) this.unselect()
    if (next !== null) this.look(next)
    const did = { kept: 'Kept', rejected: 'Rejected', none: 'Took the mark from' }[mark]
    this.shell.say(`${did} ${ids.length > 1 ? spoken(ids.length, 'sheep') : ids[0]}${end ? '; this is the last one' : ''}`)
  }

  /** @param {number} rating */
  rate(rating, ids = this.hit) {
    if (!ids.length) return
    this.api.mark(ids, { rating })
    this.shell.say(rating ? `Rated ${ids.length > 1 ? spoken(ids.length, 'sheep') : ids[0]} ${rating}` : 'Took the rating away')
  }

  /**
   * Wants all of them more or less by a factor.
   * @param {number} by
   */
  want(by) {
    const ids = this.inside, of = ids.join('\n'), now = performance.now()
    if (!ids.length) return
    if (this.pressed.of !== of || now - this.pressed.at > GESTURE) this.pressed.name = this.api.gesture()
    this.pressed = { name: this.pressed.name, of, at: now }
    // Every press counts from what the press before asked for, whose answer may be on its way.
    const edits = ids.flatMap(sheep => {
      const one = this.store.byId.get(sheep)
      if (!one) return []
      one.want = Number((one.want * by).toPrecision(4))
      return [/** @type {Edit} */ ({ do: 'want', sheep, value: one.want })]
    })
    this.api.edit(edits, this.pressed.name).then(done => done ? undefined : this.api.refresh())
  }

  startLink() {
    this.linking = this.inside
    if (!this.linking.length) return this.shell.say('Only sheep of the flock can be linked: add this one first', true)
    this.unselect()
    this.grid.again(this.grid.cells.keys())
    this.tell()
  }

  /** @param {string} to */
  async link(to) {
    const from = this.linking.filter(id => id !== to)
    if (!from.length) return
    if (!this.store.byId.get(to)?.in_flock) return this.shell.say(`${to} is not in the flock: add it first`, true)
    this.unlink()
    await this.api.edit(from.map(id => ({ do: 'link', from: id, to })))
  }

  unlink() {
    this.linking = []
    this.grid.again(this.grid.cells.keys())
    this.tell()
  }

  compared() {
    if (this.selected.size) return this.hit.slice(0, 4)
    const at = this.grid.places.get(this.store.focus ?? '') ?? 0
    return this.grid.ids.slice(at, at + 2)
  }
  compare() {
    const ids = this.compared()
    if (ids.length < 2) return this.shell.say('Comparing needs two sheep or more', true)
    if (this.selected.size > 4) this.shell.say('Comparing the first four of those selected')
    openCompare(ids, this.hands())
  }
  enlarge() {
    if (this.store.focus !== null) openLarge(this.store.focus, this.hands())
  }

  /** @returns {import('./large.js').Hands} */
  hands() {
    return {
      store: this.store, shell: this.shell, rate: (rating, ids) => this.rate(rating, ids),
      mark: (mark, ids) => { this.api.mark(ids, { mark }) },
      next: by => {
        const { ids, places } = this.grid, at = places.get(this.store.focus ?? '') ?? -1
        const id = ids[Math.max(0, Math.min(ids.length - 1, at + by))] ?? null
        if (id === this.store.focus) this.shell.say(by > 0 ? 'This is the last one' : 'This is the first one')
        this.store.look(id)
        return id
      },
    }
  }

  add() {
    const ids = this.outside
    if (!ids.length) return this.shell.say('All of them are in the flock', true)
    this.unselect()
    this.api.edit([{ do: 'add', candidates: ids }])
  }

  drop() {
    const ids = this.inside
    this.unselect()
    this.api.edit(ids.map(sheep => ({ do: 'drop', sheep })))
  }

  openOne() {
    const one = this.store.focused
    if (!one) return
    if (this.linking.length) return void this.link(one.id)
    if (one.in_flock) this.shell.go('graph', { at: one.id })
    else this.enlarge()
  }

  /** @param {string} id */
  toggle(id) {
    const before = this.anchor ?? this.store.focus
    if (!this.selected.size && before !== null && before !== id && this.grid.places.has(before)) this.selected.add(before)
    this.selected.has(id) ? this.selected.delete(id) : this.selected.add(id)
    this.anchor = id
    this.grid.again(this.grid.cells.keys())
    this.tell()
  }

  /** The one with the focus is selected, or no longer. */
  select() {
    const id = this.store.focus
    if (id === null) return
    this.selected.has(id) ? this.selected.delete(id) : this.selected.add(id)
    this.anchor = id
    this.grid.again(this.grid.cells.keys())
    this.tell()
  }

  /**
   * Selects all from the anchor to `id`.
   * @param {string} id
   */
  reach(id) {
    const { places, ids } = this.grid
    const from = places.get(this.anchor ?? this.store.focus ?? id) ?? 0, to = places.get(id) ?? from
    this.anchor ??= ids[from]
    this.selected = new Set(ids.slice(Math.min(from, to), Math.max(from, to) + 1))
    this.grid.again(this.grid.cells.keys())
  }

  unselect() {
    this.anchor = null
    if (!this.selected.size) return
    this.selected.clear()
    this.grid.again(this.grid.cells.keys())
  }

  /** @param {KeyboardEvent} event */
  step(event) {
    const at = this.grid.places.get(this.store.focus ?? '') ?? 0
    const id = this.grid.ids[this.grid.towards(event.key, at)] ?? null
    if (id === null) return
    if (event.shiftKey) this.reach(id)
    else this.anchor = null
    this.look(id)
  }

  escape() {
    if (this.linking.length) this.unlink()
    else this.unselect()
    this.tell()
    this.grid.cells.get(this.store.focus ?? '')?.focus({ preventScroll: true })
  }

  /** @returns {Key[]} */
  keys() {
    const arrows = ['ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown', 'Home', 'End', 'PageUp', 'PageDown']
    return [
      { keys: arrows, does: 'move', run: event => this.step(event) },
      { keys: arrows.map(key => `Shift+${key}`), does: 'select on the way', run: event => this.step(event) },
      ...markKeys((mark, stay) => this.mark(mark, stay)),
      { keys: ['0', '1', '2', '3', '4', '5'], does: 'rate', run: event => this.rate(Number(event.key)) },
      { keys: ['s'], does: 'select, or no longer', hint: 'select', run: () => this.select() },
      { keys: ['Mod+a'], does: 'select all that are shown', run: () => { this.selected = new Set(this.grid.ids); this.grid.again(this.grid.cells.keys()); this.tell() } },
      { keys: ['Space'], does: 'play the loop large', hint: 'play', run: () => this.enlarge() },
      { keys: ['Enter'], does: 'open in the graph, or end a link here', hint: 'open', run: () => this.openOne() },
      { keys: ['c'], does: 'compare those selected, or this one and the next', hint: 'compare', run: () => this.compare() },
      { keys: ['+', '='], does: 'want it more', hint: 'want', run: () => this.want(STEP) },
      { keys: ['-'], does: 'want it less', run: () => this.want(1 / STEP) },
      { keys: ['l'], does: 'begin a link here: go to the other sheep, then Enter', hint: 'link', run: () => this.startLink() },
      { keys: ['a'], does: 'put it into the flock', run: () => this.add() },
      { keys: ['Delete'], does: 'take it out of the flock', when: () => this.inside.length > 0, run: () => this.drop() },
      { keys: ['/'], does: 'search', run: () => this.filter.search.focus() },
      { keys: ['f'], does: 'filters', run: () => { this.filter.unfold(true); /** @type {HTMLElement | null} */ (this.filter.row.querySelector('select'))?.focus() } },
      { keys: ['Escape'], does: 'end the search, the link or the selection', run: () => this.escape() },
    ]
  }
}
