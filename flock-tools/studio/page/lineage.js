// The family tree of a pool: parents above, children below, and what was done to make each.
//
// Owns where everybody stands in the drawing. A large tree is drawn around one sheep. Never changes anything: breeding goes
// on in the Breed view.
//
// Start at [`placed`].

import { button, draw, make, styled } from './dom.js'
import { dim, kindOf, quiet, SPECIES } from './parts.js'
import { media } from './session.js'
import { digits, short, times, why } from './words.js'

const WIDE = 108, HIGH = 132, SIZE = 30, MOST = 400, MOST_NAMED = 90, MOST_TRIES = 40

const KINDS = Object.values(SPECIES)

/** @typedef {{node: LineageNode, row: number, x: number, y: number, parents: string[], children: string[]}} Placed */

/**
 * Where every node stands: in the row below its lowest parent, near the middle of its relatives.
 * @param {LineageNode[]} nodes
 * @param {LineageEdge[]} edges
 * @returns {Map<string, Placed>}
 */
function placed(nodes, edges) {
  /** @type {Map<string, Placed>} */ const all = new Map(nodes.map(node => [node.id, { node, row: 0, x: 0, y: 0, parents: [], children: [] }]))
  for (const { parent, child } of edges) {
    const above = all.get(parent), below = all.get(child)
    if (!above || !below || above === below || below.parents.includes(parent)) continue
    below.parents.push(parent)
    above.children.push(child)
  }
  let moved = true
  // A ledger has no circles; a damaged one must not hold the page.
  for (let round = 0; moved && round < nodes.length; round++) {
    moved = false
    for (const one of all.values()) {
      const row = one.parents.reduce((most, id) => Math.max(most, (all.get(id)?.row ?? -1) + 1), 0)
      if (row > one.row) { one.row = Math.min(row, nodes.length); moved = true }
    }
  }
  // Founders stand right above their first child, not at the top of everything.
  for (const one of all.values()) if (!one.parents.length && one.children.length) one.row = Math.max(0, Math.min(...one.children.map(id => all.get(id)?.row ?? 1)) - 1)
  /** @type {Placed[][]} */ const rows = []
  for (const one of all.values()) (rows[one.row] ??= []).push(one)
  const full = rows.filter(Boolean)
  full.forEach((row, at) => row.forEach((one, which) => { one.row = at; one.x = which; one.y = at }))
  const middle = (/** @type {string[]} */ ids) => { const xs = ids.map(id => all.get(id)?.x ?? 0); return xs.reduce((sum, x) => sum + x, 0) / xs.length }
  for (let sweep = 0; sweep < 8; sweep++) {
    for (const row of sweep % 2 ? [...full].reverse() : full) {
      const near = (/** @type {Placed} */ one) => { const ids = sweep % 2 ? one.children : one.parents; return ids.length ? middle(ids) : one.x }
      const wished = row.map(one => ({ one, at: near(one) })).sort((a, b) => a.at - b.at)
      let edge = -Infinity
      for (const { one, at } of wished) { one.x = Math.max(at, edge + 1); edge = one.x }
      const shift = wished.reduce((sum, { one, at }) => sum + at - one.x, 0) / wished.length
      for (const { one } of wished) one.x += shift
    }
  }
  const left = Math.min(...[...all.values()].map(one => one.x))
  for (const one of all.values()) one.x -= left
  return all
}

/**
 * Those of a tree that are nearest to one: parents and children, then theirs.
 * @param {Map<string, Placed>} all @param {string} id @param {number} most
 */
export function family(all, id, most) {
  /** @type {Set<string>} */ const found = new Set([id])
  for (const which of /** @type {const} */ (['parents', 'children'])) {
    let rim = [id], room = found.size + (most >> 1)
    while (rim.length && found.size < room) {
      rim = rim.flatMap(one => all.get(one)?.[which] ?? []).filter(one => !found.has(one))
      for (const one of rim) if (found.size < room) found.add(one)
    }
  }
  return found
}

/**
 * The outline of a species.
 * @param {string | null} species
 */
function outline(species) {
  if (species === 'expression') return draw('rect', { x: -SIZE + 3, y: -SIZE + 3, width: 2 * SIZE - 6, height: 2 * SIZE - 6, rx: 3 })
  const corners = species === 'agents' ? 6 : species === 'plant' ? 3 : 0
  if (!corners) return draw('circle', { r: SIZE - 1 })
  const reach = corners === 3 ? SIZE + 5 : SIZE
  const points = Array.from({ length: corners }, (_, at) => { const turn = 2 * Math.PI * at / corners - Math.PI / 2; return `${(reach * Math.cos(turn)).toFixed(1)},${(reach * Math.sin(turn) + (corners === 3 ? 6 : 0)).toFixed(1)}` })
  return draw('polygon', { points: points.join(' ') })
}

/** @param {number} votes for, less those against */
const signed = votes => `${votes > 0 ? '+' : '−'}${digits(Math.abs(votes), 1)}`

/** @type {MakeView} */
export function view(root, store, api, shell) {
  return new Lineage(root, store, api, shell)
}

class Lineage {
  /** @type {LineageNode[]} */ nodes = []
  /** @type {LineageEdge[]} */ edges = []
  /** @type {Map<string, Placed>} */ tree = new Map()
  /** @type {Map<string, SVGGElement>} */ drawn = new Map()
  /** @type {string | null} */ at = null
  /** @type {string | null} around whom it is drawn; null: everybody */ around = null
  /** 0: as large as fits. */
  zoom = 0
  open = false

  /** @param {HTMLElement} root @param {import('./store.js').Store} store @param {import('./api.js').Api} api @param {Shell} shell */
  constructor(root, store, api, shell) {
    this.root = root
    this.store = store
    this.api = api
    this.shell = shell
    this.keys = this.bound()
    this.find = make('input', { class: 'field', type: 'search', size: 14, list: 'lineage-ids', placeholder: 'Find a sheep', 'aria-label': 'Find a sheep', onchange: () => this.search() })
    this.ids = make('datalist', { id: 'lineage-ids' })
    this.whole = quiet('Everybody', () => this.circle(null))
    this.near = quiet('Its family only', () => this.circle(this.at))
    this.told = make('span', { class: 'dim grow' })
    this.svg = draw('svg', { class: 'tree', role: 'group', 'aria-label': 'The family tree' })
    this.field = make('div', { class: 'field-of' }, this.svg)
    this.panel = make('div', { class: 'panel' })
    // Only the pictures of those that are seen are asked for.
    this.seer = new IntersectionObserver(seen => {
      for (const { target, isIntersecting } of seen) {
        const image = isIntersecting && target.querySelector('image')
        if (image && !image.hasAttribute('href')) image.setAttribute('href', media('strip', image.dataset.strip ?? ''))
      }
    }, { rootMargin: '200px' })
    root.append(make('div', { class: 'split' },
      make('div', { class: 'stage' }, make('div', { class: 'bar' }, this.find, this.ids, this.whole, this.near, this.told, this.legend(),
        quiet('Votes…', () => this.votes()), quiet('Save', () => this.save(), { title: 'the tree as JSON' })), this.field),
      this.panel))
  }

  /** @returns {Key[]} */
  bound() {
    return [
      { keys: ['ArrowUp', 'ArrowDown'], does: 'to a parent, to a child', hint: 'parent, child', run: event => this.kin(event.key === 'ArrowUp' ? 'parents' : 'children') },
      { keys: ['ArrowLeft', 'ArrowRight'], does: 'to its neighbour', hint: 'neighbour', run: event => this.beside(event.key === 'ArrowLeft' ? -1 : 1) },
      { keys: ['Enter', 'b'], does: 'breed from it', hint: 'breed', run: () => this.breed() },
      { keys: ['f'], does: 'its family only, or everybody', hint: 'family', run: () => this.circle(this.around === null ? this.at : null) },
      { keys: ['/'], does: 'find a sheep', hint: 'find', run: () => this.find.focus() },
      { keys: ['+', '-'], does: 'larger, smaller', run: event => this.enlarge(event.key === '+' ? 1.25 : 0.8) },
      { keys: ['e'], does: 'save the tree as JSON', run: () => this.save() },
    ]
  }

  legend() {
    return make('span', { class: 'legend dim' }, ...KINDS.map(species =>
      make('span', {}, draw('svg', { viewBox: '-40 -40 80 80', 'aria-hidden': 'true' }, outline(species)), species)))
  }

  /** @param {URLSearchParams} params */
  async enter(params) {
    this.open = true
    const at = params.get('at') ?? this.at ?? this.store.focus
    try {
      const told = await this.api.get('/api/lineage')
      this.nodes = told.nodes
      this.edges = told.edges
    } catch (error) { return this.api.failed(error) }
    this.ids.replaceChildren(...this.nodes.slice(0, 2000).map(({ id }) => make('option', { value: id })))
    const known = at !== null && this.nodes.some(({ id }) => id === at)
    this.at = known ? at : this.nodes[this.nodes.length - 1]?.id ?? null
    this.around = this.nodes.length > MOST || known && params.get('at') ? this.at : null
    if (!known && params.get('at')) this.shell.say(`${at} has no family in the pool`)
    this.plot()
    this.root.dataset.state = 'ready'
  }

  leave() { this.open = false }

  /** @param {'parents' | 'children'} which */
  kin(which) {
    const ids = this.tree.get(this.at ?? '')?.[which] ?? []
    if (ids.length) this.choose(ids[0])
    else this.shell.say(which === 'parents' ? 'It has no parents here' : 'It has no children')
  }

  /** @param {number} by */
  beside(by) {
    const one = this.tree.get(this.at ?? '')
    if (!one) return
    const row = [...this.tree.values()].filter(({ row }) => row === one.row).sort((a, b) => a.x - b.x), next = row[row.indexOf(one) + by]
    if (next) this.choose(next.node.id)
  }

  breed() {
    if (this.at !== null) this.shell.go('breed', { from: this.at })
  }

  /** @param {string | null} id */
  circle(id) {
    if (id === null && this.nodes.length > MOST) this.shell.say(`${this.nodes.length} sheep are too many for one drawing: the ${MOST} nearest are shown`)
    this.around = id ?? (this.nodes.length > MOST ? this.at : null)
    this.plot()
  }

  search() {
    const wanted = this.find.value.trim().toLowerCase()
    const found = this.nodes.find(({ id }) => id.toLowerCase() === wanted) ?? this.nodes.find(({ id }) => id.toLowerCase().includes(wanted))
    if (!wanted) return
    if (!found) return this.shell.say(`Nobody is called ${wanted}`, true)
    if (!this.tree.has(found.id)) { this.at = found.id; this.around = found.id; return this.plot() }
    this.choose(found.id)
  }

  save() {
    const url = URL.createObjectURL(new Blob([JSON.stringify({ nodes: this.nodes, edges: this.edges }, null, 1)], { type: 'application/json' }))
    make('a', { href: url, download: `${this.store.state.pool?.name ?? this.store.state.name}-lineage.json` }).click()
    setTimeout(() => URL.revokeObjectURL(url), 1000)
  }

  /** Reports of votes, as a file or as text. */
  votes() {
    const text = make('textarea', { class: 'report', rows: 8, spellcheck: 'false', 'aria-label': 'reports of votes' })
    const file = make('input', { type: 'file', accept: '.json,application/json', 'aria-label': 'a file of votes', onchange: async () => { text.value = await file.files?.[0]?.text() ?? '' } })
    const unit = make('input', { class: 'field', size: 14, 'aria-label': 'Unit' }), told = make('p', { class: 'bad', role: 'alert' })
    const send = async () => {
      try {
        this.shell.say((await this.api.post('/api/votes/import', { text: text.value, unit: unit.value || undefined })).said)
        close()
        this.enter(new URLSearchParams())
      } catch (error) { told.textContent = why(error) }
    }
    const close = this.shell.over(make('div', { class: 'question wide' }, make('h2', {}, 'Votes from the walls'), make('p', { class: 'note' }, 'What a unit reported, or its votes.json. Taking the same report in twice changes nothing.'), file, text,
      make('label', { class: 'tick' }, 'Unit, if it is new or its report does not name it', unit), told,
      make('div', { class: 'bar end' }, quiet('Cancel', () => close()), button('Take in', send, { class: 'strong' }))), { label: 'Votes from the walls' })
  }

  /** @param {number} by */
  enlarge(by) {
    this.zoom = Math.max(0.25, Math.min(3, this.zoom * by))
    this.scale()
    this.show()
  }

  // What is drawn.

  plot() {
    const all = placed(this.nodes, this.edges)
    if (this.around !== null && all.has(this.around)) {
      const near = family(all, this.around, MOST)
      this.tree = placed(this.nodes.filter(({ id }) => near.has(id)), this.edges)
    } else this.tree = all
    this.whole.setAttribute('aria-pressed', String(this.around === null))
    this.near.setAttribute('aria-pressed', String(this.around !== null))
    this.told.textContent = `${this.tree.size === this.nodes.length ? this.nodes.length : `${this.tree.size} of ${this.nodes.length}`} sheep`
    if (!this.tree.size) {
      this.svg.replaceChildren()
      this.panel.replaceChildren(make('p', { class: 'note' }, 'Nobody was bred here yet. Broods that are taken into the pool appear with their parents.'))
      return
    }
    this.drawn = new Map([...this.tree.values()].map(one => [one.node.id, this.node(one)]))
    const shapes = KINDS.map(species => draw('clipPath', { id: `of-${species}` }, outline(species)))
    this.lines = draw('g', { class: 'edges' })
    this.svg.replaceChildren(draw('defs', {}, ...shapes), this.lines, ...this.drawn.values())
    this.seer.disconnect()
    for (const group of this.drawn.values()) this.seer.observe(group)
    this.scale()
    this.choose(this.tree.has(this.at ?? '') ? this.at ?? '' : [...this.tree.keys()][0], false)
  }

  scale() {
    const all = [...this.tree.values()], wide = (Math.max(...all.map(({ x }) => x)) + 1) * WIDE, high = (Math.max(...all.map(({ y }) => y)) + 1) * HIGH
    this.svg.setAttribute('viewBox', `0 0 ${wide} ${high}`)
    if (this.zoom === 0) this.zoom = Math.max(0.75, Math.min(1, this.field.clientWidth / wide))
    styled(this.svg, { width: `${wide * this.zoom}px`, height: `${high * this.zoom}px` })
  }

  /** @param {Placed} one */
  place({ x, y }) { return [(x + 0.5) * WIDE, y * HIGH + SIZE + 12] }

  /** @param {Placed} one */
  node(one) {
    const { id, alive, reason, votes, strip, in_flock: elected } = one.node, species = kindOf(one.node.species), [x, y] = this.place(one)
    const told = [id, species, alive ? '' : `dead: ${reason ?? 'no reason is known'}`, elected ? 'in the flock' : '', votes ? `${signed(votes)} votes` : '', one.parents.length ? `child of ${one.parents.join(' and ')}` : ''].filter(Boolean).join(', ')
    const group = draw('g', { class: `kin ${alive ? '' : 'dead'} ${elected ? 'elected' : ''}`, transform: `translate(${x.toFixed(1)} ${y})`, role: 'button', tabindex: -1, 'aria-label': told, 'data-sheep': id, onclick: () => this.choose(id), ondblclick: () => this.breed() })
    const ground = outline(species)
    ground.classList.add('ground')
    group.append(ground)
    // The first picture of the strip, which has six in a row.
    if (strip) group.append(draw('g', { 'clip-path': `url(#of-${KINDS.includes(species) ? species : 'flame'})` }, draw('svg', { x: -54, y: -31, width: 108, height: 62, viewBox: '0 0 160 90', preserveAspectRatio: 'xMidYMid slice' }, draw('image', { 'data-strip': strip, width: 960, height: 360, onerror: (/** @type {Event} */ event) => { if (event.target instanceof SVGImageElement) this.later(event.target) } }))))
    const rim = outline(species)
    rim.classList.add('rim')
    group.append(rim, draw('text', { y: SIZE + 17 }, short(id)), draw('text', { class: 'small', y: SIZE + 31 }, votes ? signed(votes) : alive ? '' : 'dead'))
    return group
  }

  /**
   * A strip that is being made is asked for again.
   * @param {SVGImageElement} image
   */
  later(image) {
    const tries = Number(image.dataset.tries ?? 0)
    image.dataset.tries = String(tries + 1)
    if (tries < MOST_TRIES) setTimeout(() => { if (this.open && image.isConnected) image.setAttribute('href', media('strip', image.dataset.strip ?? '', { tries: String(tries) })) }, 1500)
  }

  drawEdges() {
    const relevant = this.edges.filter(({ parent, child }) => this.tree.has(parent) && this.tree.has(child))
    /** @type {Map<string, SVGTextElement>} */ const named = new Map()
    const parts = relevant.map(({ parent, child, op }) => {
      const [a, b] = [this.tree.get(parent), this.tree.get(child)]
      if (!a || !b) return null
      const [ax, ay] = this.place(a), [bx, by] = this.place(b), near = parent === this.at || child === this.at
      const start = ay + SIZE + 37, end = by - SIZE, half = (start + end) / 2
      const d = by > ay ? `M${ax} ${start}C${ax} ${half + 16} ${bx} ${half - 16} ${bx} ${end}` : `M${ax} ${ay}L${bx} ${by}`
      // What made a child is said once, above it.
      if (near || relevant.length <= MOST_NAMED) named.set(child, draw('text', { class: near ? 'near' : '', x: bx, y: end - 7 }, op))
      return draw('path', { class: near ? 'near' : '', d })
    })
    this.lines?.replaceChildren(...parts.flatMap(part => part ?? []))
    for (const near of this.lines?.querySelectorAll('.near') ?? []) this.lines?.append(near)
    this.lines?.append(...named.values())
  }

  /** @param {string} id @param {boolean} [focused] */
  choose(id, focused = true) {
    const one = this.tree.get(id)
    if (!one) return
    for (const [other, group] of this.drawn) {
      const kin = one.parents.includes(other) || one.children.includes(other)
      group.classList.toggle('at', other === id)
      group.classList.toggle('next', kin)
      group.setAttribute('tabindex', other === id ? '0' : '-1')
      group.setAttribute('aria-selected', String(other === id))
    }
    this.at = id
    this.shell.note({ at: id })
    if (this.store.byId.has(id)) this.store.look(id)
    this.drawEdges()
    this.tell(one)
    this.show()
    if (focused) this.drawn.get(id)?.focus({ preventScroll: true })
  }

  /** Brings the chosen one into view. */
  show() {
    const one = this.tree.get(this.at ?? '')
    if (!one) return
    const [x, y] = this.place(one).map(part => part * this.zoom)
    const { scrollLeft: left, scrollTop: top, clientWidth: wide, clientHeight: high } = this.field, room = SIZE * 2 * this.zoom
    if (x - room < left || x + room > left + wide || y - room < top || y + room > top + high) this.field.scrollTo({ left: x - wide / 2, top: y - high / 2 })
  }

  /** @param {Placed} one */
  tell({ node, parents, children }) {
    const { id, alive, reason, votes, rating, strip, in_flock: elected } = node
    const link = (/** @type {string} */ other) => make('li', {}, make('button', { type: 'button', class: 'row', onclick: () => this.choose(other) }, make('span', {}, short(other)), dim(this.edges.find(edge => (edge.parent === id && edge.child === other) || (edge.parent === other && edge.child === id))?.op ?? '')))
    const picture = strip && make('canvas', {})
    for (const canvas of this.panel.querySelectorAll('canvas')) this.shell.strips.forget(canvas)
    this.panel.replaceChildren(...[picture && make('span', { class: 'thumb' }, picture), make('h2', {}, id),
      make('p', { class: 'note' }, [kindOf(node.species), elected ? 'in the flock' : alive ? 'alive' : `dead: ${reason ?? 'no reason is known'}`].filter(Boolean).join(', ')),
      make('p', { class: 'note' }, [votes !== 0 && `${signed(votes)} votes`, rating !== null && `rating ${times(rating)}`].filter(Boolean).join(' · ')),
      make('div', { class: 'bar' }, button('Breed from it', () => this.breed(), { class: 'strong' })),
      parents.length > 0 && make('h3', {}, 'Parents'), parents.length > 0 && make('ul', { class: 'rows' }, ...parents.map(link)),
      children.length > 0 && make('h3', {}, `Children: ${children.length}`), children.length > 0 && make('ul', { class: 'rows' }, ...children.slice(0, 60).map(link))]
      .filter(/** @returns {part is HTMLElement} */ part => part instanceof HTMLElement))
    if (picture) this.shell.strips.show(picture, { id, strip, colour: null })
  }
}
