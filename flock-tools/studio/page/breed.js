// Broods: 20 cells, of which the artist chooses one to three as the parents of the next.
//
// Owns what is chosen and which brood is shown. Cells keep their places: what is under the pointer or has the focus is what
// a press acts on. A new brood's cells are there at the press and fill as the program makes them; nothing waits for the last.

import { button, make, styled } from './dom.js'
import { dim, kindOf, labelled, quiet, SPECIES } from './parts.js'
import { digits, short } from './words.js'

const CELLS = 20, MOST_CHOSEN = 3, OFFERED = 40
const LOCKS = ['palette', 'camera', 'transforms', 'structure']
/** A press that moves farther than this many pixels is a drag. */
const DRAG = 8
/** Milliseconds between two looks at what of a brood is there. */
const PACE = 350

/** @typedef {{id: string, name: string, told: string, species: string | null, strip: string | null, colour: string | null, waits: string}} Shown */

/** @type {MakeView} */
export function view(root, store, api, shell) {
  return new Breed(root, store, api, shell)
}

class Breed {
  /** @type {Brood[]} */ broods = []
  /** @type {Shown[]} */ cells = []
  /** @type {string[]} */ chosen = []
  /** @type {string | null} the brood that is shown; null: the sheep one may begin with */ brood = null
  /** @type {string | null} the sheep that waits for another to be crossed with */ first = null
  /** @type {Map<string, Shown>} sheep one may begin with that are neither in the flock nor alive in the pool */ others = new Map()
  /** @type {Set<string>} */ locked = new Set()
  /** @type {ReturnType<typeof setTimeout> | undefined} */ due
  at = 0
  open = false
  busy = false

  /** @param {HTMLElement} root @param {import('./store.js').Store} store @param {import('./api.js').Api} api @param {Shell} shell */
  constructor(root, store, api, shell) {
    this.root = root
    this.store = store
    this.api = api
    this.shell = shell
    this.keys = this.bound()
    this.title = make('h2', { 'aria-live': 'polite' })
    this.told = make('p', { class: 'note' })
    this.go = button('Breed', () => this.breed(this.chosen), { class: 'strong' })
    this.back = quiet('Previous', () => this.previous())
    this.over = quiet('Start over', () => this.startOver(), { title: 'A brood of strangers' })
    this.list = quiet('All sheep', () => this.turn(null), { title: 'The sheep one may begin with' })
    this.find = make('input', { class: 'field', type: 'search', placeholder: 'Find a sheep', 'aria-label': 'Find a sheep', oninput: () => this.draw() })
    this.species = make('select', { class: 'field', 'aria-label': 'species of strangers' }, ...Object.entries(SPECIES).map(([value, name]) => make('option', { value }, name)))
    this.strangers = make('span', { class: 'together' }, this.over, this.species)
    this.strength = make('input', { type: 'range', min: 0, max: 1, step: 0.05, value: 0.5, id: 'breed-strength', oninput: () => this.drawStrength() })
    this.size = make('output', { class: 'dim', for: 'breed-strength' })
    this.locks = LOCKS.map(name => make('input', { type: 'checkbox', onchange: () => this.lock(name) }))
    this.pool = quiet('Into the pool', () => this.accept('pool'))
    this.flock = quiet('Into the flock', () => this.accept('flock'))
    this.grid = make('div', { class: 'brood', role: 'group', 'aria-label': 'The brood' })
    this.past = make('ol', { class: 'past', 'aria-label': 'Past broods' })
    root.append(
      make('div', { class: 'bar' }, make('div', { class: 'grow heading' }, this.title, this.told), this.find, this.go, this.back, this.list, this.strangers),
      make('div', { class: 'bar settings' }, labelled('Size of change', this.strength, this.size),
        make('span', { class: 'together', role: 'group', 'aria-label': 'What stays as it is' }, dim('Keep'), ...LOCKS.map((name, at) => make('label', { class: 'tick' }, this.locks[at], name))),
        make('span', { class: 'grow' }), this.pool, this.flock),
      this.grid, this.past)
    this.drag()
    this.drawStrength()
    store.on(['state'], () => { if (this.open && this.brood === null) this.draw() })
    store.on(['jobs'], () => this.look())
  }

  /** @returns {Key[]} */
  bound() {
    return [
      { keys: ['ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown'], does: 'to another cell', run: event => this.move(event.key) },
      { keys: ['Space', 'Enter'], does: 'choose as a parent, one to three', hint: 'choose', run: () => this.choose(this.at) },
      { keys: ['b'], does: 'breed from those chosen', hint: 'breed', run: () => { this.breed(this.chosen) } },
      { keys: ['c'], does: 'cross with the sheep on which it is pressed next', hint: 'cross', run: () => this.cross() },
      { keys: ['Escape'], does: 'cross with none', when: () => this.first !== null, run: () => this.crossing(null) },
      { keys: ['p'], does: 'the previous brood', hint: 'previous', run: () => this.previous() },
      { keys: ['r'], does: 'start over with strangers', hint: 'start over', run: () => this.startOver() },
      { keys: ['s'], does: 'all sheep one may begin with', hint: 'all sheep', run: () => this.turn(null) },
      { keys: ['1', '2', '3', '4'], does: `keep ${LOCKS.join(', ')}`, hint: 'keep', run: event => this.lock(LOCKS[Number(event.key) - 1], true) },
      { keys: ['+', '-'], does: 'larger or smaller changes', run: event => this.stronger(event.key === '+' ? 0.1 : -0.1) },
      { keys: ['a'], does: 'take those chosen into the pool', hint: 'into the pool', run: () => { this.accept('pool') } },
      { keys: ['Shift+A'], does: 'take those chosen into the flock', run: () => { this.accept('flock') } },
      { keys: ['l'], does: 'its family', run: () => this.family() },
      { keys: ['v'], does: 'look at it large', hint: 'large', run: () => this.large() },
    ]
  }

  /** @param {URLSearchParams} params */
  enter(params) {
    this.open = true
    const from = params.get('from'), brood = params.get('brood')
    if (from !== null) {
      this.chosen = from.split(',').filter(Boolean).slice(0, MOST_CHOSEN)
      this.brood = null
    } else if (brood !== null) this.brood = brood
    this.draw()
    this.fetch()
  }

  leave() {
    this.open = false
    this.crossing(null)
    clearTimeout(this.due)
  }

  // What the program tells.

  async fetch() {
    try {
      this.broods = (await this.api.get('/api/broods')).broods.sort((/** @type {Brood} */ a, /** @type {Brood} */ c) => a.at_ms - c.at_ms)
    } catch (error) { return this.api.failed(error) }
    if (this.brood !== null && !this.busy && !this.broods.some(one => one.id === this.brood)) this.brood = null
    await this.meet()
    this.draw()
  }

  /** Finds those who are chosen and neither in the flock nor alive in the pool: the dead may be parents, too. Says who is nobody. */
  async meet() {
    if (this.brood !== null) return
    const strange = this.chosen.filter(id => !this.store.byId.has(id) && !this.others.has(id))
    if (!strange.length) return
    try {
      /** @type {LineageNode[]} */ const family = (await this.api.get('/api/lineage')).nodes
      const children = this.broods.flatMap(brood => brood.cells)
      for (const id of strange) {
        const child = children.find(cell => cell.id === id && cell.strip), kin = family.find(node => node.id === id && node.strip)
        if (child) this.others.set(id, shownChild(child))
        else if (kin) this.others.set(id, { id, name: id, told: kin.alive ? kindOf(kin.species) : `${kindOf(kin.species)}, dead: ${kin.reason ?? 'no reason is known'}`, species: kin.species, strip: kin.strip, colour: null, waits: '' })
      }
    } catch (error) { return this.api.failed(error) }
    const nobody = strange.filter(id => !this.others.has(id))
    if (!nobody.length) return
    this.chosen = this.chosen.filter(id => !nobody.includes(id))
    this.shell.say(`Nobody can breed from ${names(nobody)}: there is no genome of that name`, true)
  }

  /** Something of a brood may be there. */
  look() {
    if (!this.open || this.due || !this.store.state.jobs.some(job => job.kind === 'brood')) return
    this.due = setTimeout(() => { this.due = undefined; if (this.open && !this.busy) this.fetch() }, PACE)
  }

  // What the artist does.

  /** @param {string} key */
  move(key) {
    const tops = [...this.grid.children].map(cell => /** @type {HTMLElement} */ (cell).offsetTop), across = Math.max(1, tops.filter(top => top === tops[0]).length)
    const by = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -across, ArrowDown: across }[key] ?? 0
    this.focus(this.at + by)
  }

  /** @param {number} at */
  focus(at) {
    if (at < 0 || at >= this.cells.length) return
    this.at = at
    ;[...this.grid.children].forEach((cell, which) => cell.setAttribute('tabindex', which === at ? '0' : '-1'))
    const cell = this.grid.children[at]
    if (cell instanceof HTMLElement) cell.focus()
  }

  /** @param {number} at */
  choose(at) {
    const cell = this.cells[at]
    if (!cell) return
    this.at = at
    if (this.first !== null) return this.cross()
    if (this.chosen.includes(cell.id)) this.chosen = this.chosen.filter(id => id !== cell.id)
    else if (this.chosen.length < MOST_CHOSEN) this.chosen.push(cell.id)
    else return this.shell.say(`${MOST_CHOSEN} are chosen already: take one away first`, true)
    this.mark()
  }

  /** @param {string[]} parents @param {string} [species] */
  async breed(parents, species) {
    if (this.busy) return
    if (!parents.length && species === undefined) return this.shell.say('Choose one to three sheep first', true)
    const before = { brood: this.brood, chosen: this.chosen, at: this.at }
    this.busy = true
    this.crossing(null)
    // The new cells are there at once: nothing changes under the artist's hand later.
    const told = apart(parents.map(id => this.speciesOf(id)))
    this.show(`A brood of ${parents.length ? names(parents) : 'strangers'}`, told, Array.from({ length: CELLS }, (_, at) => ({ id: parents[at] ?? `new ${at + 1}`, name: parents[at] ?? '', told: '', species: null, strip: null, colour: null, waits: 'asked for' })))
    this.chosen = []
    this.at = 0
    this.mark()
    try {
      const { brood } = await this.api.post('/api/breed', { parents, ...species ? { species } : {}, count: CELLS, strength: Number(this.strength.value), locks: [...this.locked] })
      this.broods.push(brood)
      this.brood = brood.id
      this.shell.note({ brood: brood.id })
      this.shell.say(told || (parents.length ? `Children of ${names(parents)}` : 'Strangers'))
    } catch (error) {
      Object.assign(this, before)
      this.api.failed(error)
    }
    this.busy = false
    this.draw()
  }

  /** @param {string} id @returns {string | null} */
  speciesOf(id) { return this.cells.find(cell => cell.id === id)?.species ?? this.store.byId.get(id)?.species ?? this.others.get(id)?.species ?? null }

  /** The first press takes a sheep, the second crosses it with another. */
  cross() {
    const id = this.cells[this.at]?.id
    if (id === undefined) return
    if (this.first === null) {
      this.crossing(id)
      return this.shell.say(`${id} with which other? Go there and press C`)
    }
    const first = this.first
    this.crossing(null)
    if (first !== id) this.breed([first, id])
  }

  /** @param {string | null} id */
  crossing(id) {
    this.first = id
    this.grid.classList.toggle('crossing', id !== null)
    for (const [at, cell] of this.cells.entries()) this.grid.children[at]?.classList.toggle('first', cell.id === id)
  }

  /** The place of the brood that is shown among all; their number where none is. */
  place() {
    const at = this.broods.findIndex(one => one.id === this.brood)
    return at < 0 ? this.broods.length : at
  }

  previous() {
    if (this.place() > 0) this.turn(this.broods[this.place() - 1].id)
    else if (this.brood !== null) this.turn(null)
  }

  /** @param {string | null} brood */
  turn(brood) {
    if (this.busy) return
    this.brood = brood
    this.chosen = []
    this.at = 0
    this.crossing(null)
    this.shell.note(brood === null ? {} : { brood })
    this.draw()
  }

  startOver() { this.breed([], this.species.value) }

  /** @param {string} name @param {boolean} [turn] */
  lock(name, turn = false) {
    const box = this.locks[LOCKS.indexOf(name)]
    if (turn) box.checked = !box.checked
    if (box.checked) this.locked.add(name)
    else this.locked.delete(name)
    this.shell.say(this.locked.size ? `Kept as it is: ${[...this.locked].join(', ')}` : 'Everything may change')
  }

  /** @param {number} by */
  stronger(by) {
    this.strength.value = String(Number(this.strength.value) + by)
    this.drawStrength()
  }

  drawStrength() { this.size.textContent = digits(Number(this.strength.value)) }

  /** @param {'pool' | 'flock'} into */
  async accept(into) {
    const cells = this.chosen.length ? this.chosen : this.cells[this.at] ? [this.cells[this.at].id] : []
    if (this.brood === null || !cells.length) return this.shell.say('Choose some of a brood first', true)
    try {
      const { said } = await this.api.post('/api/broods/accept', { brood: this.brood, cells, into })
      this.shell.say(said)
      await this.api.refresh()
    } catch (error) { this.api.failed(error) }
  }

  family() {
    const id = this.cells[this.at]?.id
    if (id !== undefined) this.shell.go('lineage', { at: id })
  }

  large() {
    const cell = this.cells[this.at]
    if (!cell?.strip) return
    const canvas = make('canvas', {}), shown = make('div', { class: 'large' }, make('span', { class: 'thumb' }, canvas), make('p', {}, cell.name, dim(` ${cell.told}`)))
    this.shell.strips.show(canvas, cell)
    this.shell.over(shown, { label: cell.name, keys: [{ keys: ['v'], does: 'close', run: () => close() }], closed: () => this.shell.strips.forget(canvas) })
    const close = () => shown.closest('dialog')?.dispatchEvent(new Event('cancel', { cancelable: true }))
  }

  /** A sheep that is dragged onto another is crossed with it. */
  drag() {
    /** @type {{at: number, x: number, y: number, ghost: HTMLElement | null} | null} */ let held = null
    const under = (/** @type {PointerEvent} */ event) => {
      const cell = document.elementFromPoint(event.clientX, event.clientY)?.closest('.kid')
      return cell && cell.parentElement === this.grid ? [...this.grid.children].indexOf(cell) : -1
    }
    const end = () => { held?.ghost?.remove(); held = null; for (const cell of this.grid.children) cell.classList.remove('target') }
    this.grid.addEventListener('pointerdown', event => {
      const at = under(event)
      if (event.button === 0 && at >= 0 && event.pointerType !== 'touch') held = { at, x: event.clientX, y: event.clientY, ghost: null }
    })
    addEventListener('pointermove', event => {
      if (!held) return
      if (!held.ghost && Math.hypot(event.clientX - held.x, event.clientY - held.y) > DRAG) {
        held.ghost = make('div', { class: 'ghost' }, make('canvas', {}))
        const from = this.grid.children[held.at].querySelector('canvas'), to = held.ghost.querySelector('canvas')
        if (from && to) { Object.assign(to, { width: from.width, height: from.height }); to.getContext('2d')?.drawImage(from, 0, 0) }
        document.body.append(held.ghost)
      }
      if (!held.ghost) return
      styled(held.ghost, { transform: `translate(${event.clientX}px, ${event.clientY}px)` })
      const at = under(event)
      ;[...this.grid.children].forEach((cell, which) => cell.classList.toggle('target', which === at && at !== held?.at))
    })
    addEventListener('pointerup', event => {
      const from = held, at = held?.ghost ? under(event) : -1
      end()
      if (!from?.ghost) return
      // The click that ends a drag chooses nothing.
      addEventListener('click', click => click.stopPropagation(), { capture: true, once: true })
      setTimeout(() => dispatchEvent(new Event('click')), 0)
      if (at >= 0 && at !== from.at) this.breed([this.cells[from.at].id, this.cells[at].id])
    })
    addEventListener('pointercancel', end)
    this.grid.addEventListener('dragstart', event => event.preventDefault())
  }

  // What is drawn.

  draw() {
    if (this.busy) return
    const brood = this.broods.find(one => one.id === this.brood)
    if (brood) {
      const ready = brood.cells.filter(cell => cell.strip).length, lost = brood.cells.filter(cell => cell.state === 'failed').length
      this.show(`Brood ${this.place() + 1} of ${this.broods.length}: ${brood.parents.length ? names(brood.parents) : 'strangers'}`,
        [ready + lost < brood.cells.length ? `${ready} of ${brood.cells.length} are there` : lost ? `${lost} did not come out` : '', apart(brood.cells.slice(0, brood.parents.length).map(cell => cell.species))].filter(Boolean).join(' · '), brood.cells.map(shownChild))
    } else {
      const wanted = this.find.value.trim().toLowerCase(), { sheep, candidates } = this.store.state
      const rank = (/** @type {Sheep} */ one) => (this.chosen.includes(one.id) ? 1000 : 0) + (one.mark === 'kept' ? 100 : one.mark === 'rejected' ? -100 : 0) + one.rating
      const offered = [...sheep, ...candidates].filter(one => one.genome && (one.id.toLowerCase().includes(wanted) || kindOf(one.species).includes(wanted)))
      const best = offered.map(one => ({ one, rank: rank(one) })).sort((a, b) => b.rank - a.rank).slice(0, OFFERED)
      this.show('Begin with', offered.length > OFFERED ? `${OFFERED} of ${offered.length}: kept ones and the best rated first` : '',
        [...this.chosen.flatMap(id => this.others.get(id) ?? []), ...best.map(({ one }) => ({ id: one.id, name: one.id, told: kindOf(one.species), species: one.species, strip: one.strip, colour: one.colour, waits: '' }))])
    }
    this.find.hidden = brood !== undefined
    this.list.hidden = this.pool.disabled = this.flock.disabled = brood === undefined
    this.drawPast()
    this.root.dataset.state = 'ready'
  }

  /** @param {string} title @param {string} told @param {Shown[]} cells */
  show(title, told, cells) {
    this.title.textContent = title
    this.told.textContent = told
    const same = cells.length === this.cells.length && cells.every((cell, at) => cell.id === this.cells[at].id)
    if (!same) {
      const focused = this.grid.contains(document.activeElement)
      for (const canvas of this.grid.querySelectorAll('canvas')) this.shell.strips.forget(canvas)
      this.grid.replaceChildren(...cells.map((cell, at) => make('button', { type: 'button', class: 'kid', 'data-sheep': cell.id, tabindex: at === this.at ? 0 : -1, onclick: () => this.choose(at), onfocus: () => { this.at = at }, ondblclick: () => this.large() },
        make('span', { class: 'thumb' }, make('canvas', {}), make('span', { class: 'waits' })), make('span', { class: 'called' }, short(cell.name)), dim(cell.told), make('b', { class: 'number' }))))
      if (focused) setTimeout(() => this.focus(this.at), 0)
    }
    this.cells = cells
    cells.forEach((cell, at) => {
      const button = this.grid.children[at], canvas = button.querySelector('canvas'), waits = button.querySelector('.waits')
      if (canvas) this.shell.strips.show(canvas, cell)
      if (waits && waits.textContent !== cell.waits) waits.textContent = cell.waits
    })
    this.mark()
  }

  /** Which cells are chosen. */
  mark() {
    this.cells.forEach((cell, at) => {
      const button = this.grid.children[at], which = this.chosen.indexOf(cell.id), number = button.querySelector('.number')
      button.setAttribute('aria-pressed', String(which >= 0))
      button.setAttribute('aria-label', [cell.name || `cell ${at + 1}`, cell.told, cell.waits].filter(Boolean).join(', '))
      if (number) number.textContent = which < 0 ? '' : String(which + 1)
    })
    this.go.disabled = !this.chosen.length
    const told = apart(this.chosen.map(id => this.speciesOf(id)))
    this.go.textContent = this.chosen.length < 2 ? 'Breed' : `${told ? 'Breed' : 'Cross'} ${this.chosen.length}`
    this.go.title = told
    this.back.disabled = this.brood === null && !this.broods.length
  }

  drawPast() {
    for (const canvas of this.past.querySelectorAll('canvas')) this.shell.strips.forget(canvas)
    this.past.hidden = !this.broods.length
    this.past.replaceChildren(...this.broods.slice(-30).map(brood => {
      const told = `brood ${this.broods.indexOf(brood) + 1} of ${brood.parents.length ? names(brood.parents) : 'strangers'}`
      const cells = brood.cells.filter(cell => cell.strip).slice(0, 4), pictures = cells.map(() => make('canvas', {}))
      cells.forEach((cell, at) => this.shell.strips.show(pictures[at], { ...cell, colour: null }))
      return make('li', {}, make('button', { type: 'button', 'aria-label': told, title: told, 'aria-current': brood.id === this.brood ? 'true' : null, onclick: () => this.turn(brood.id) }, ...pictures))
    }))
  }
}

/** @param {string[]} ids */
const names = ids => ids.length < 2 ? ids.join('') : `${ids.slice(0, -1).map(short).join(', ')} and ${short(ids[ids.length - 1])}`

/** @param {Cell} cell @returns {Shown} */
const shownChild = ({ id, op, species, strip, state, error }) => ({ id, name: id, told: op, species: species || null, strip, colour: null, waits: strip ? '' : state === 'failed' ? error ?? 'did not come out' : state === 'running' ? 'rendering' : 'waits' })

/**
 * What is said of parents that do not cross, since their species differ; nothing of others.
 * @param {(string | null)[]} species by the endings of their files
 */
function apart(species) {
  const kinds = [...new Set(species.flatMap(one => one ? [kindOf(one)] : []))]
  return kinds.length < 2 ? '' : `${kinds.join(' and ')} do not cross: ${species.length > kinds.length ? 'a child has parents of one species' : 'each child is a mutant of one parent'}`
}
