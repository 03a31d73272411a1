// The Graph: to link, to unlink, to weigh.
//
// Owns what is chosen and what the keys do: `L`, go to the other sheep, `Enter` makes a link; `M` leads the chosen arrow elsewhere in
// the same way. What the pointer does is in `pointing.js`, the making of a link in `linking.js`, drawing in `scene.js`, the panel
// beside it in `panel.js`.
//
// Start at [`view`].

import { button, draw, make, styled } from './dom.js'
import { openBalance, openPrune, openTable, suggestions } from './balance.js'
import { Linking } from './linking.js'
import { openMenu } from './menu.js'
import { Panel, cost } from './panel.js'
import { point } from './pointing.js'
import { Scene } from './scene.js'
import { way } from './store.js'
import { spoken } from './words.js'

const STEP = 2 ** 0.125
const GESTURE = 1500
/** Milliseconds a picture of a disc is shown. */
const PACE = 125

/** @type {MakeView} */
export function view(root, store, api, shell) {
  const graph = new Graph(root, store, api, shell)
  return { enter: params => graph.enter(params), leave: () => graph.leave(), keys: graph.keys() }
}

export class Graph {
  /**
   * @param {HTMLElement} root
   * @param {import('./store.js').Store} store
   * @param {import('./api.js').Api} api
   * @param {Shell} shell
   */
  constructor(root, store, api, shell) {
    this.root = root
    this.store = store
    this.api = api
    this.shell = shell
    this.open = false
    /** @type {import('./panel.js').Chosen} */ this.chosen = null
    /** @type {import('./balance.js').Suggested | null} */ this.suggested = null
    /** @type {ReturnType<typeof setInterval> | undefined} */ this.timer = undefined
    this.pressed = { name: '', of: '', at: 0 }
    /** @type {Map<string, {disc: SVGElement, x: number, y: number, r: number, label: string}>} The elements over the discs, and where they are. */
    this.spots = new Map()
    /** @type {(string | null)[]} The sheep that the last `mark` marked. */ this.marked = []
    this.scene = new Scene(store, shell.strips)
    this.scene.moved = () => this.over()
    this.svg = draw('svg', { class: 'lit', role: 'group', 'aria-label': 'The flock as a graph' })
    this.arrows = draw('g', { class: 'arrows' })
    this.discs = draw('g', { class: 'discs', role: 'listbox', 'aria-label': 'Sheep' })
    this.world = draw('g', {}, this.arrows, this.discs)
    this.svg.append(this.world)
    this.stage = make('div', { class: 'plane' }, this.scene.canvas)
    this.stage.append(this.svg)
    /** @type {Linking} */ this.linking = new Linking(this)
    /** @type {Panel} */ this.panel = new Panel(store, api, shell, {
      choose: chosen => this.choose(chosen, true), unlink: (from, to) => this.unlink(from, to), startLink: from => this.linking.start(from), move: (edge, end) => this.linking.move(edge, end), render: (what, draft) => this.render(what, draft),
      balance: () => openBalance(store, api, shell), prune: () => openPrune(store, api, shell), suggest: () => this.suggest(), table: () => openTable(store, shell, sheep => this.choose({ sheep }, true)),
      unpin: sheep => this.pin(sheep, null),
    })
    this.find = make('input', { class: 'field', type: 'search', placeholder: 'Go to', 'aria-label': 'Go to a sheep', list: 'graph-sheep', onchange: () => this.found() })
    this.names = make('datalist', { id: 'graph-sheep' })
    const zooms = make('div', { class: 'zooms', role: 'group', 'aria-label': 'Zoom' },
      button('Nearer', () => this.scene.zoomBy(1.5), { icon: 'plus', class: 'tool' }), button('Further', () => this.scene.zoomBy(1 / 1.5), { icon: 'minus', class: 'tool' }), button('All in view', () => this.scene.look(1, 0, 0), { icon: 'whole', class: 'tool' }))
    this.stage.append(make('div', { class: 'bar seek' }, this.find, this.names), zooms, this.linking.card)
    this.root.append(make('div', { class: 'split' }, this.stage, this.panel.root))
    point(this)
    new ResizeObserver(() => { if (this.open) this.measure() }).observe(this.stage)
    store.on(['state'], () => { if (this.open) this.all() })
    store.on(['supposed'], () => { if (this.open) { this.scene.place(); this.place(); this.panel.figures() } })
    store.on(['jobs'], () => { if (this.open) this.scene.ask() })
    store.on(['focus'], () => { if (this.open && store.focus !== null && store.byId.get(store.focus)?.in_flock) this.mark() })
  }

  /** The chosen arrow. */
  get edge() { return this.chosen && 'from' in this.chosen ? this.chosen : null }

  /** @param {URLSearchParams} params */
  enter(params) {
    this.open = true
    const at = params.get('at'), to = params.get('to')
    this.measure()
    this.all()
    if (at !== null && to !== null && this.store.byWay.has(way(at, to))) this.choose({ from: at, to }, false)
    else if (at !== null && this.store.byId.get(at)?.in_flock) this.choose({ sheep: at }, true)
    else if (this.chosen === null && this.store.focused?.in_flock) this.choose({ sheep: this.store.focused.id }, true)
    else this.choose(this.chosen, false)
    this.timer = setInterval(() => {
      if (!this.shell.moving() || document.hidden || !this.scene.moves || this.store.supposed) return
      this.scene.tick += 1
      this.scene.ask()
    }, PACE)
    this.root.dataset.state = 'ready'
  }

  leave() {
    this.open = false
    clearInterval(this.timer)
    this.linking.end()
    this.store.suppose(null)
  }

  measure() {
    const box = this.stage.getBoundingClientRect()
    this.svg.setAttribute('viewBox', `0 0 ${box.width} ${box.height}`)
    this.scene.size(box.width, box.height)
    this.place()
    this.mark()
  }

  /** After another state. */
  all() {
    const { store, chosen } = this
    if (chosen && 'sheep' in chosen && !store.byId.get(chosen.sheep)?.in_flock) this.chosen = null
    if (chosen && 'from' in chosen && !store.byWay.has(way(chosen.from, chosen.to))) this.chosen = store.byId.has(chosen.from) ? { sheep: chosen.from } : null
    this.scene.size(this.scene.width, this.scene.height)
    const ids = new Set(store.state.sheep.map(one => one.id))
    for (const [id, { disc }] of this.spots) if (!ids.has(id)) { disc.remove(); this.spots.delete(id) }
    for (const { id } of store.state.sheep) {
      if (this.spots.has(id)) continue
      const disc = draw('circle', { class: 'hit', role: 'option', tabindex: -1, 'aria-selected': 'false', 'data-sheep': id })
      this.spots.set(id, { disc, x: Infinity, y: 0, r: 0, label: '' })
      this.discs.append(disc)
    }
    if (this.names.children.length !== ids.size) this.names.replaceChildren(...store.state.sheep.map(one => make('option', { value: one.id })))
    this.place()
    this.mark()
    this.drawPanel()
  }

  /** Puts the elements over their discs: not for less than is seen. */
  place() {
    for (const [id, spot] of this.spots) {
      const told = this.scene.discs.get(id)
      if (!told) continue
      const { x, y, one } = told, r = Math.max(told.r, 5), label = `${id}, ${one.outs} out, ${one.ins} in`
      if (Math.abs(x - spot.x) + Math.abs(y - spot.y) + Math.abs(r - spot.r) > 0.3) {
        Object.assign(spot, { x, y, r })
        for (const [name, value] of /** @type {const} */ ([['cx', x], ['cy', y], ['r', r]])) spot.disc.setAttribute(name, value.toFixed(1))
      }
      if (label !== spot.label) spot.disc.setAttribute('aria-label', spot.label = label)
    }
    this.light()
  }

  /** The svg follows the eye. */
  over() {
    const { scene } = this, [x, y] = scene.origin()
    this.world.setAttribute('transform', `translate(${x.toFixed(2)} ${y.toFixed(2)}) scale(${scene.zoom.toFixed(4)})`)
    styled(this.svg, { '--near': scene.zoom })
    this.linking.follow()
  }

  /** Shows which sheep has the focus and what is chosen. */
  mark() {
    const focus = this.store.focus, from = this.linking.from
    this.discs.firstElementChild?.setAttribute('tabindex', this.disc(focus) ? '-1' : '0')
    for (const id of [...this.marked, from, focus]) {
      const disc = this.disc(id), focused = id === focus
      disc?.classList.toggle('focused', focused)
      disc?.classList.toggle('source', from === id)
      disc?.setAttribute('aria-selected', String(focused))
      disc?.setAttribute('tabindex', focused ? '0' : '-1')
    }
    this.marked = [from, focus]
    this.light()
  }

  /** The arrows of the sheep with the focus, the chosen one, and the suggested ones, over the drawing. */
  light() {
    const { store, scene, edge } = this, focus = store.focus
    scene.lit = focus
    /** @type {SVGElement[]} */ const lit = []
    const lights = (/** @type {string} */ from, /** @type {string} */ to, /** @type {string} */ kind) => {
      const outline = scene.outline(from, to)
      if (outline) lit.push(draw('path', { d: outline, class: `arrow ${kind}`, 'data-from': from, 'data-to': to }))
    }
    if (focus !== null) {
      for (const one of store.ins.get(focus) ?? []) lights(one.from, one.to, 'in')
      for (const one of store.outs.get(focus) ?? []) lights(one.from, one.to, 'out')
    }
    if (edge) lights(edge.from, edge.to, 'chosen')
    for (const { from, to } of this.suggested?.add ?? []) if (!store.byWay.has(way(from, to))) lights(from, to, 'suggested')
    for (const { from, to } of this.suggested?.remove ?? []) if (store.byWay.has(way(from, to))) lights(from, to, 'going')
    const { moved } = this.linking
    if (moved) lights(moved.from, moved.to, 'going')
    if (edge && !moved) {
      const { from, to } = edge, middle = scene.middle(from, to)
      const handle = (/** @type {number[]} */ [x, y], /** @type {string} */ kind, /** @type {string} */ label, /** @type {{onclick?: () => void}} */ run, /** @type {SVGElement[]} */ ...drawn) => {
        lit.push(draw('g', { class: kind, role: 'button', tabindex: -1, 'aria-label': label, transform: `translate(${x.toFixed(1)} ${y.toFixed(1)})`, ...run }, draw('circle', { r: 12 }), ...drawn))
      }
      if (middle) handle(middle, 'cross', `Unlink ${from} from ${to}`, { onclick: () => this.unlink(from, to) }, draw('path', { d: 'M-4 -4L4 4M4 -4L-4 4' }))
      scene.endsOf(from, to).forEach((place, at) => handle(place, at ? 'end to' : 'end from', `${from} to ${to}: ${at ? 'end' : 'begin'} elsewhere`, {}, draw('circle', { r: 6 })))
    }
    this.arrows.replaceChildren(...lit)
    scene.ask()
  }

  drawPanel() {
    if (!this.suggested) return this.panel.show(this.chosen)
    const hover = (/** @type {string | null} */ from, /** @type {string} */ to) => {
      for (const arrow of this.arrows.children) arrow.classList.toggle('hovered', from !== null && arrow.getAttribute('data-from') === from && arrow.getAttribute('data-to') === to)
    }
    const list = suggestions(this.suggested, this.store, this.api, { hover, close: () => { this.suggested = null; this.light(); this.drawPanel() } })
    this.panel.root.replaceChildren(...list.flatMap(item => item ? [item] : []))
  }

  /**
   * @param {import('./panel.js').Chosen} chosen
   * @param {boolean} take the keyboard's focus goes there, unless it is in the panel
   */
  choose(chosen, take) {
    this.chosen = chosen
    const id = chosen === null ? null : 'sheep' in chosen ? chosen.sheep : chosen.from
    if (id !== null) {
      this.store.look(id)
      this.scene.reveal(id)
    }
    if (chosen !== null) this.suggested = null
    this.shell.note(chosen === null ? {} : 'sheep' in chosen ? { at: chosen.sheep } : { at: chosen.from, to: chosen.to })
    this.mark()
    this.drawPanel()
    if (take && !document.activeElement?.closest('dialog')) this.disc(id)?.focus({ preventScroll: true })
  }

  /** @param {string | null} id @returns {SVGElement | null} */
  disc(id) {
    return this.spots.get(id ?? '')?.disc ?? null
  }

  found() {
    const id = this.find.value
    if (!this.store.byId.get(id)?.in_flock) return
    this.find.value = ''
    if (this.linking.from !== null) { this.store.look(id); this.linking.aim(id) } else this.choose({ sheep: id }, true)
    this.disc(id)?.focus()
  }

  /**
   * Pins a disc, or lets it go.
   * @param {string} sheep
   * @param {{x: number, y: number} | null} place
   */
  async pin(sheep, place) {
    this.api.doubt()
    try {
      await this.api.post('/api/pins', { sheep, x: place?.x ?? null, y: place?.y ?? null })
      if (!place) await this.api.refresh()
      this.shell.say(place ? `Pinned ${sheep}` : `${sheep} is where the layout puts it`)
      this.drawPanel()
    } catch (error) { this.api.failed(error) }
  }

  /**
   * Moves the disc with the focus, and pins it.
   * @param {string} key
   */
  nudge(key) {
    const one = this.store.focused
    if (!one?.in_flock) return
    const by = 0.02 / this.scene.zoom
    one.x += key.endsWith('Left') ? -by : key.endsWith('Right') ? by : 0
    one.y += key.endsWith('Down') ? -by : key.endsWith('Up') ? by : 0
    one.pinned = true
    this.scene.place()
    this.place()
    this.pin(one.id, { x: one.x, y: one.y })
  }

  /** @param {string} from @param {string} to */
  async unlink(from, to) {
    await this.api.edit([{ do: 'unlink', from, to }])
  }

  /** @param {number} x @param {number} y */
  menu(x, y) {
    const chosen = this.chosen
    if (!chosen) return
    const items = 'sheep' in chosen
      ? [button('Link from here', () => this.linking.start(chosen.sheep)), button('Walk from here', () => this.shell.go('walk', { from: chosen.sheep })), button(this.store.byId.get(chosen.sheep)?.pinned ? 'Unpin' : 'Pin here', () => this.togglePin())]
      : [button('End elsewhere', () => this.linking.move(chosen, 'to')), button('Begin elsewhere', () => this.linking.move(chosen, 'from')), button('Unlink', () => this.unlink(chosen.from, chosen.to)), button('Its joins', () => this.shell.go('walk', { show: 'joins', a: chosen.from, b: chosen.to, end: 'from' })), button('Render', () => this.render({ from: chosen.from, to: chosen.to }))]
    openMenu(this.root, x, y, items, () => this.disc(this.store.focus)?.focus({ preventScroll: true }))
  }

  togglePin() {
    const one = this.store.focused
    if (!one?.in_flock) return
    this.pin(one.id, one.pinned ? null : { x: one.x, y: one.y })
    one.pinned = !one.pinned
    this.scene.ask()
  }

  /**
   * @param {{sheep?: string, from?: string, to?: string, all_missing?: boolean} | null} what
   * @param {boolean} [draft] what is ticked when it is asked
   */
  async render(what, draft = false) {
    if (!what) return this.shell.say('Choose a sheep or a transition first', true)
    try {
      const dry = await this.api.post('/api/jobs', { kind: 'render', ...what, dry: true })
      const one = dry.clips === 1
      if (!dry.clips) return this.shell.say('There is nothing to render')
      /** @type {Question} */
      const question = { title: `Render ${spoken(dry.clips, 'clip')}`, text: dry.cost_s === null ? 'How long it takes is not known.' : `It takes about ${cost(dry.cost_s)} on this machine.`, yes: one ? 'Render it' : 'Render them', tick: 'As a draft: less sharp, and much sooner', ticked: draft }
      if (await this.shell.ask(question)) {
        await this.api.post('/api/jobs', { kind: 'render', ...what, draft: question.ticked === true })
        this.shell.say(`${spoken(dry.clips, 'clip')} ${one ? 'waits' : 'wait'} in the queue`)
      }
    } catch (error) { this.api.failed(error) }
  }

  preview() {
    if (this.linking.from !== null) this.linking.preview()
    else if (!this.panel.preview()) this.shell.say('Choose a transition between two genomes first', true)
  }

  async suggest() {
    this.shell.say('Looking for links that would help …')
    try {
      this.suggested = await this.api.get('/api/suggestions')
      this.shell.say('')
      this.light()
      this.drawPanel()
      this.panel.root.querySelector('button')?.focus()
    } catch (error) { this.api.failed(error) }
  }

  /** @param {string} key */
  step(key) {
    const from = this.store.focus !== null && this.scene.discs.has(this.store.focus) ? this.store.focus : this.store.state.sheep[0]?.id
    const id = from === undefined ? null : this.scene.towards(from, key) ?? from
    if (id === null) return
    if (this.linking.from === null) return this.choose({ sheep: id }, true)
    this.store.look(id)
    this.scene.reveal(id)
    this.mark()
    this.disc(id)?.focus({ preventScroll: true })
    this.linking.aim(id)
  }

  /**
   * The next transition of the sheep with the focus, or the one before.
   * @param {number} by
   */
  turn(by) {
    const id = this.store.focus ?? ''
    const ways = [...this.store.outs.get(id) ?? [], ...this.store.ins.get(id) ?? []]
    if (!ways.length) return this.shell.say('No transition begins or ends here')
    const { edge } = this, at = edge ? ways.findIndex(one => one.from === edge.from && one.to === edge.to) : by > 0 ? -1 : 0
    const next = ways[(at + by + ways.length) % ways.length]
    this.chosen = { from: next.from, to: next.to }
    this.suggested = null
    this.shell.note({ at: next.from, to: next.to })
    this.shell.say(`${next.from} to ${next.to}`)
    this.light()
    this.drawPanel()
  }

  /**
   * A want or a weight is more, or less.
   * @param {number} by
   */
  more(by) {
    const chosen = this.chosen, of = JSON.stringify(chosen), now = performance.now()
    const one = chosen && 'sheep' in chosen ? this.store.byId.get(chosen.sheep) : undefined
    const edge = this.edge && this.store.byWay.get(way(this.edge.from, this.edge.to))
    if (!one && !edge) return
    if (this.pressed.of !== of || now - this.pressed.at > GESTURE) this.pressed.name = this.api.gesture()
    this.pressed = { name: this.pressed.name, of, at: now }
    /** @type {Edit[]} */ let edits = []
    if (one) edits = [{ do: 'want', sheep: one.id, value: one.want = Number((one.want * by).toPrecision(4)) }]
    if (edge) edits = [{ do: 'weight', from: edge.from, to: edge.to, value: edge.weight = Number((edge.weight * by).toPrecision(4)) }]
    this.api.edit(edits, this.pressed.name).then(done => done ? undefined : this.api.refresh())
  }

  enterKey() {
    if (this.linking.from !== null) {
      const to = this.store.focus
      if (to !== null && to !== this.linking.from) this.linking.make(to)
      return
    }
    if (this.chosen === null && this.store.focused?.in_flock) this.choose({ sheep: this.store.focused.id }, false)
    const slide = this.panel.root.querySelector('input')
    if (slide instanceof HTMLElement) slide.focus()
  }

  escape() {
    if (this.linking.from !== null) return this.linking.end()
    const { edge } = this
    if (this.suggested) { this.suggested = null; this.light(); this.drawPanel() }
    else if (edge) this.choose({ sheep: this.store.focus ?? edge.from }, true)
    else if (this.panel.root.contains(document.activeElement)) this.disc(this.store.focus)?.focus()
    else this.choose(null, false)
  }

  /** @returns {Key[]} */
  keys() {
    const arrows = ['ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown'], isArrow = () => this.edge !== null
    return [
      { keys: arrows, does: 'to the nearest sheep that way', run: event => this.step(event.key) },
      { keys: arrows.map(key => `Shift+${key}`), does: 'move the disc, and pin it', run: event => this.nudge(event.key) },
      { keys: ['l'], does: 'begin a link: go to the other sheep, then Enter', hint: 'link', run: () => { if (this.store.focused?.in_flock) this.linking.start(this.store.focused.id) } },
      { keys: ['.', 'n'], does: 'the next transition of this sheep', hint: 'transitions', run: () => this.turn(1) },
      { keys: [',', 'Shift+N'], does: 'the transition before', run: () => this.turn(-1) },
      { keys: ['m', 'Shift+M'], does: 'lead the end of the chosen transition elsewhere, or its begin: go to the other sheep, then Enter', hint: 'lead elsewhere', when: isArrow, run: event => { if (this.edge) this.linking.move(this.edge, event.shiftKey ? 'from' : 'to') } },
      { keys: ['Delete'], does: 'take the chosen transition away', hint: 'unlink', when: isArrow, run: () => { if (this.edge) this.unlink(this.edge.from, this.edge.to) } },
      { keys: ['Enter'], does: 'to the sliders, or end the link here', hint: 'sliders', run: () => this.enterKey() },
      { keys: ['+', '='], does: 'want more, or weigh more', hint: 'more', run: () => this.more(STEP) },
      { keys: ['-'], does: 'want less, or weigh less', run: () => this.more(1 / STEP) },
      { keys: ['b'], does: 'balance', hint: 'balance', run: () => openBalance(this.store, this.api, this.shell) },
      { keys: ['k'], does: 'prune: keep what can be reached', hint: 'prune', run: () => openPrune(this.store, this.api, this.shell) },
      { keys: ['s'], does: 'suggestions', hint: 'suggestions', run: () => { this.suggest() } },
      { keys: ['r'], does: 'render the chosen sheep or transition', hint: 'render', run: () => { this.render(this.chosen) } },
      { keys: ['d'], does: 'render it as a draft', hint: 'as a draft', run: () => { this.render(this.chosen, true) } },
      { keys: ['v'], does: 'a moving preview of the chosen transition, or of the link', hint: 'preview', run: () => this.preview() },
      { keys: ['p'], does: 'pin the disc, or let it go', run: () => this.togglePin() },
      { keys: ['t'], does: 'the graph as a table', run: () => openTable(this.store, this.shell, sheep => this.choose({ sheep }, true)) },
      { keys: ['/'], does: 'go to a sheep by its name', run: () => this.find.focus() },
      { keys: ['i'], does: 'nearer', run: () => this.scene.zoomBy(1.5) },
      { keys: ['o'], does: 'further', run: () => this.scene.zoomBy(1 / 1.5) },
      { keys: ['0'], does: 'the whole flock', run: () => this.scene.look(1, 0, 0) },
      { keys: ['Escape'], does: 'end the link, or choose nothing', run: () => this.escape() },
    ]
  }
}
