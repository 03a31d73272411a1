// The live snow globe: agents drift, and visitors breed them.
//
// Owns where everybody is, and which of them a press means: what was on the screen at that moment, not what is there when
// the press is handled. Children are made here at once; the program sends the next generation while the globe goes on.
//
// Start at [`Globe`]. Source: W. B. Langdon, Global Distributed Evolution of L-Systems Fractals (Pfeiffer, 2004).

import { crossed, shape, walk } from './agents.js'
import { make } from './dom.js'
import { quiet } from './parts.js'

const MOST = 25, ATTEMPTS = 30, MOTES = 70
/** Seconds: a screen's fall, a sway, growing up, being held, and from which age agents mate by themselves. */
const FALL_S = 55, SWAY_S = 17, GROW_S = 1.4, HELD_S = 10, GROWN_UP_S = 25
/** Milliseconds: how long ago a picture was drawn that is seen now, and how long pictures are remembered. */
const SEEN_MS = 17, REMEMBERED_MS = 1500
const SPRITES_A_FRAME = 3
const COLOURS = ['#9addfa', '#f4cc64', '#deeffd', '#f35dd5', '#82cafb', '#b7f0c8', '#ff9e7a', '#9283df']

/**
 * @typedef {object} Being
 * @property {import('./agents.js').Shape} shape
 * @property {number} x of the width
 * @property {number} fallen of a screen with its margins, 0 to 1
 * @property {number} depth 0 far, 1 near
 * @property {number} turned
 * @property {number} spin turns a second
 * @property {number} colour
 * @property {number} age seconds
 * @property {number} held seconds
 * @property {number} grown 0 to 1
 * @property {boolean} leaves
 * @property {boolean} liked
 * @property {HTMLCanvasElement} sprite
 * @property {number} drawn for which radius; 0: not yet
 *
 * @typedef {{being: Being, x: number, y: number, r: number}} Spot
 */

/** @type {MakeView} */
export function view(root, store, api, shell) {
  return new Globe(root, store, api, shell)
}

class Globe {
  /** @type {Being[]} */ beings = []
  /** @type {string[]} those that come when somebody leaves */ coming = []
  /** @type {{time: number, spots: Spot[]}[]} what was drawn lately, the last last */ seen = []
  /** @type {Being | null} chosen first, waits for a second */ first = null
  /** @type {Being | null} under the pointer, or reached by keys */ near = null
  /** @type {{x: number, y: number, age: number}[]} */ rings = []
  motes = Array.from({ length: MOTES }, () => ({ x: Math.random(), y: Math.random(), depth: Math.random() }))
  born = 0
  open = false
  asking = false
  byKeys = false
  last = 0
  turn = 0
  clock = 0

  /** @param {HTMLElement} root @param {import('./store.js').Store} store @param {import('./api.js').Api} api @param {Shell} shell */
  constructor(root, store, api, shell) {
    this.root = root
    this.store = store
    this.api = api
    this.shell = shell
    this.canvas = make('canvas', { class: 'globe-canvas', role: 'img', 'aria-label': 'A snow globe of drifting agents' })
    this.told = make('p', { class: 'globe-told', role: 'status' })
    this.keep = quiet('Keep those liked', () => this.save())
    this.stage = make('div', { class: 'globe-stage' }, this.canvas, this.told, make('div', { class: 'bar globe-tools' }, this.keep,
      quiet('Others', () => this.fetch()), quiet('Whole screen', () => this.whole())))
    root.append(this.stage)
    this.keys = this.bound()
    this.canvas.addEventListener('pointerdown', event => this.press(event))
    this.canvas.addEventListener('pointermove', event => { this.byKeys = false; this.hover(this.found(event)?.being ?? null) })
    this.canvas.addEventListener('pointerleave', () => this.hover(null))
    this.canvas.addEventListener('contextmenu', event => event.preventDefault())
    new ResizeObserver(() => { for (const being of this.beings) being.drawn = 0; this.paint() }).observe(this.canvas)
    store.on(['moving'], () => { if (this.open) this.say(this.greeting()) })
  }

  /** @returns {Key[]} */
  bound() {
    return [
      { keys: ['ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown'], does: 'to another agent', hint: 'another', run: event => this.go(event.key) },
      { keys: ['Enter', 'Space'], does: 'like it; two that are liked have a child', hint: 'like', run: () => { if (this.near) this.like(this.near) } },
      { keys: ['Delete', 'x'], does: 'let it go', hint: 'let go', run: () => { if (this.near) this.drop(this.near) } },
      { keys: ['h'], does: 'hold it for ten seconds', hint: 'hold', run: () => { if (this.near) this.near.held = HELD_S } },
      { keys: ['k'], does: 'keep those liked in the pool', hint: 'keep', run: () => { this.save() } },
      { keys: ['n'], does: 'others', run: () => { this.fetch() } },
      { keys: ['f'], does: 'the whole screen', hint: 'whole screen', run: () => this.whole() },
    ]
  }

  async enter() {
    const first = !this.beings.length
    this.open = true
    this.last = performance.now()
    requestAnimationFrame(this.tick)
    if (first) await this.fetch()
    this.say(this.greeting())
    this.root.dataset.state = 'ready'
  }

  leave() { this.open = false }

  greeting() {
    return this.shell.moving() ? 'Touch one, then another: their child appears.' : 'Pictures stand still. Touch one, then another: their child appears.'
  }

  /** @param {string} text */
  say(text) { this.told.textContent = text }

  // Who is there.

  async fetch() {
    try {
      const { strings } = await this.api.get(`/api/globe?agents=${MOST - 5}`)
      for (const being of this.beings) being.leaves ||= !being.liked
      for (const text of strings) this.join(text)
    } catch (error) { this.api.failed(error) }
  }

  /**
   * Takes an agent in, unless nobody would see it or its twin is there. With too many, the oldest that nobody liked leaves.
   * @param {string} text
   * @param {Partial<Being>} [where]
   */
  join(text, where = {}) {
    const made = shape(text)
    if (!made || this.beings.some(being => !being.leaves && being.shape.likeness === made.likeness)) return null
    const number = this.born++
    /** @type {Being} */
    const being = {
      shape: made, x: 0.05 + 0.9 * Math.random(), fallen: Math.random(), depth: (0.2 + number * 0.618034) % 1, turned: Math.random(), spin: [-1, 0, 0, 0, 1][number % 5] / FALL_S,
      colour: number, age: 0, held: 0, grown: 0, leaves: false, liked: false, sprite: document.createElement('canvas'), drawn: 0, ...where,
    }
    this.beings.push(being)
    const staying = this.beings.filter(one => !one.leaves)
    if (staying.length > MOST) this.leaveOne(staying.filter(one => one !== being))
    return being
  }

  /** @param {Being[]} staying */
  leaveOne(staying) {
    const oldest = (/** @type {Being[]} */ all) => all.reduce((a, b) => b.age > a.age ? b : a)
    const unliked = staying.filter(one => !one.liked && one !== this.first)
    oldest(unliked.length ? unliked : staying).leaves = true
  }

  /**
   * A child of two, between them; null if none of 30 can be seen.
   * @param {Being} a @param {Being} b
   * @returns {Being | null}
   */
  mate(a, b) {
    const where = { x: (a.x + b.x) / 2, fallen: (a.fallen + b.fallen) / 2, depth: Math.max(a.depth, b.depth), colour: Math.random() < 0.5 ? a.colour : b.colour, held: 2 * GROW_S }
    for (let attempt = 0; attempt < ATTEMPTS; attempt++) {
      const [one, other] = attempt % 2 ? [b, a] : [a, b], text = crossed(one.shape.text, other.shape.text)
      if (text === a.shape.text || text === b.shape.text) continue
      const child = this.join(text, where)
      if (child) return child
    }
    return null
  }

  // What visitors do.

  /**
   * What was on the screen where and when it was pressed.
   * @param {PointerEvent} event
   * @returns {Spot | null}
   */
  found(event) {
    const box = this.canvas.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top
    const frame = this.seen.filter(({ time }) => time <= event.timeStamp - SEEN_MS).pop() ?? this.seen[0]
    /** @type {Spot | null} */ let best = null
    let least = 1
    for (const spot of frame?.spots ?? []) {
      const far = Math.hypot(spot.x - x, spot.y - y) / Math.max(24, spot.r)
      if (far < least) [least, best] = [far, spot]
    }
    return best
  }

  /** @param {PointerEvent} event */
  press(event) {
    const spot = this.found(event)
    if (!spot) return
    event.preventDefault()
    if (event.button === 2) this.drop(spot.being)
    else if (event.button === 0) this.like(spot.being)
  }

  /** @param {Being | null} being */
  hover(being) {
    if (being && being !== this.near) being.held = Math.max(being.held, HELD_S)
    else if (!being && this.near && !this.byKeys && this.near !== this.first) this.near.held = Math.min(this.near.held, 0.3)
    this.near = being
    this.canvas.classList.toggle('pointing', being !== null)
  }

  /** @param {Being} being */
  like(being) {
    const gone = !this.beings.includes(being)
    // It was there when it was pressed: it comes back.
    if (gone) this.beings.push(being)
    being.leaves = false
    being.liked = true
    being.held = HELD_S
    this.ring(being)
    const first = this.first
    if (!first || first === being) {
      this.first = first === being ? null : being
      this.say(this.first ? 'Now another: their child appears between them.' : 'Liked.')
    } else {
      this.first = null
      const child = this.mate(first, being)
      if (child) this.ring(child)
      this.say(child ? 'A child. Touch it, if you like it.' : 'These two have no child that could be seen. Try others.')
      this.ask()
    }
    this.count()
    this.paint()
  }

  /** @param {Being} being */
  drop(being) {
    being.leaves = true
    being.liked = false
    if (this.first === being) this.first = null
    if (this.coming.length) this.join(this.coming.shift() ?? '', { fallen: 0 })
    this.say('It goes.')
    this.count()
    this.paint()
  }

  count() {
    const liked = this.beings.filter(being => being.liked).length
    this.keep.textContent = liked ? `Keep ${liked} liked` : 'Keep those liked'
    this.keep.disabled = !liked
  }

  /**
   * To the nearest agent in a direction.
   * @param {string} key
   */
  go(key) {
    const spots = this.seen[this.seen.length - 1]?.spots.filter(({ being }) => !being.leaves) ?? [], from = spots.find(({ being }) => being === this.near)
    const [dx, dy] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[key] ?? [0, 0]
    const far = (/** @type {Spot} */ { x, y }) => {
      if (!from) return Math.hypot(x - this.canvas.clientWidth / 2, y - this.canvas.clientHeight / 2)
      const along = (x - from.x) * dx + (y - from.y) * dy, across = Math.abs((x - from.x) * dy + (y - from.y) * dx)
      return along > 4 ? along + 2 * across : Infinity
    }
    const next = spots.map(spot => ({ spot, far: far(spot) })).filter(one => one.far < Infinity).sort((a, b) => a.far - b.far)[0]
    if (!next) return
    this.byKeys = true
    this.hover(next.spot.being)
    const { agent } = next.spot.being.shape
    this.say(`${next.spot.being.liked ? 'Liked: ' : ''}${next.spot.being.shape.strokes} lines, turns of ${Math.round(agent.v)} degrees`)
  }

  /** The next generation, from those that are liked. */
  async ask() {
    if (this.asking) return
    this.asking = true
    try {
      const { strings } = await this.api.post('/api/globe', { strings: this.beings.filter(being => being.liked).slice(-MOST).map(being => being.shape.text) })
      this.coming = strings
    } catch (error) { this.api.failed(error) }
    this.asking = false
  }

  async save() {
    const strings = this.beings.filter(being => being.liked).slice(-MOST).map(being => being.shape.text)
    if (!strings.length) return this.say('Nobody is liked yet.')
    try {
      const { said } = await this.api.post('/api/globe', { strings, keep: true })
      this.say(said)
    } catch (error) { this.api.failed(error) }
  }

  whole() {
    if (document.fullscreenElement) document.exitFullscreen()
    else this.stage.requestFullscreen().catch(() => {})
  }

  // What moves.

  tick = (/** @type {number} */ now) => {
    if (!this.open) return
    requestAnimationFrame(this.tick)
    const passed = Math.min(0.1, (now - this.last) / 1000)
    this.last = now
    this.move(passed)
    this.paint(now)
  }

  /** @param {number} passed seconds */
  move(passed) {
    const moves = this.shell.moving() ? passed : 0
    this.clock += moves
    for (const being of this.beings) {
      being.grown = Math.max(0, Math.min(1, being.grown + (being.leaves ? -1 : 1) * passed / GROW_S))
      being.age += moves
      being.held = Math.max(0, being.held - passed)
      if (being.held) continue
      being.fallen += moves / FALL_S * (0.6 + 0.8 * being.depth)
      being.turned += moves * being.spin
      if (being.fallen < 1) continue
      being.fallen -= 1
      // Whoever falls out of sight makes room for the next generation.
      if (this.coming.length && !being.liked && being.age > GROWN_UP_S) { being.leaves = true; being.grown = 0; this.join(this.coming.shift() ?? '', { fallen: 0, x: being.x }) }
    }
    for (const mote of this.motes) mote.y = (mote.y + moves / FALL_S * (0.5 + mote.depth)) % 1
    for (const ring of this.rings) ring.age += passed
    this.rings = this.rings.filter(({ age }) => age < 1)
    this.beings = this.beings.filter(being => !being.leaves || being.grown > 0)
    if (moves) this.meet()
  }

  /** Two grown-up agents that touch: the first is replaced by their child, which stays with the second for ten seconds. */
  meet() {
    const spots = this.seen[this.seen.length - 1]?.spots ?? []
    const ready = spots.filter(({ being }) => being.age > GROWN_UP_S && !being.leaves && being !== this.first && being !== this.near)
    for (const a of ready) {
      for (const b of ready) {
        if (a === b || Math.hypot(a.x - b.x, a.y - b.y) > 0.45 * (a.r + b.r)) continue
        const child = this.mate(a.being, b.being)
        for (const { being } of [a, b]) being.age = 0
        if (!child) return
        if (!a.being.liked) a.being.leaves = true
        child.held = b.being.held = HELD_S
        return
      }
    }
  }

  // What is drawn.

  /** @param {Being} being */
  ring(being) {
    const spot = this.seen[this.seen.length - 1]?.spots.find(one => one.being === being)
    if (spot) this.rings.push({ x: spot.x, y: spot.y, age: 0 })
  }

  /** @param {Being} being @param {number} width @param {number} height @returns {Spot} */
  spot(being, width, height) {
    const r = being.shape.size * (0.5 + 0.5 * being.depth) * height * 0.38, sway = Math.sin(this.clock * 2 * Math.PI / SWAY_S / 1.7 + being.colour) * 0.02
    return { being, r, x: (being.x + sway) * width, y: being.fallen * (height + 2.2 * r) - 1.1 * r }
  }

  paint(now = performance.now()) {
    const { canvas } = this, dense = Math.min(2, devicePixelRatio), width = canvas.clientWidth, height = canvas.clientHeight
    const pen = canvas.getContext('2d', { alpha: false })
    if (!pen || !width) return
    if (canvas.width !== Math.round(width * dense)) canvas.width = Math.round(width * dense)
    if (canvas.height !== Math.round(height * dense)) canvas.height = Math.round(height * dense)
    pen.setTransform(dense, 0, 0, dense, 0, 0)
    const sky = pen.createLinearGradient(0, 0, 0, height)
    sky.addColorStop(0, '#0d1122')
    sky.addColorStop(1, '#231e4d')
    pen.fillStyle = sky
    pen.fillRect(0, 0, width, height)
    pen.globalCompositeOperation = 'lighter'
    pen.fillStyle = '#dfe9ff'
    for (const { x, y, depth } of this.motes) {
      pen.globalAlpha = 0.1 + 0.3 * depth
      pen.beginPath()
      pen.arc((x + 0.01 * Math.sin(this.clock / 3 + 40 * depth)) * width, y * height, 0.6 + 1.5 * depth, 0, 2 * Math.PI)
      pen.fill()
    }
    const spots = this.beings.map(being => this.spot(being, width, height)).sort((a, b) => a.being.depth - b.being.depth)
    this.sprites(spots, dense)
    for (const { being, x, y, r } of spots) {
      pen.globalAlpha = being.grown * (0.45 + 0.55 * being.depth)
      const size = r * 1.3 * (0.3 + 0.7 * being.grown)
      pen.translate(x, y)
      pen.rotate(2 * Math.PI * being.turned)
      pen.drawImage(being.sprite, -size, -size, 2 * size, 2 * size)
      pen.rotate(-2 * Math.PI * being.turned)
      pen.translate(-x, -y)
    }
    pen.globalCompositeOperation = 'source-over'
    this.marks(pen, spots)
    this.seen.push({ time: now, spots })
    while (this.seen.length > 2 && this.seen[0].time < now - REMEMBERED_MS) this.seen.shift()
  }

  /** @param {CanvasRenderingContext2D} pen @param {Spot[]} spots */
  marks(pen, spots) {
    const circle = (/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ r) => { pen.beginPath(); pen.arc(x, y, r, 0, 2 * Math.PI); pen.stroke() }
    for (const { being, x, y, r } of spots) {
      const first = being === this.first, near = being === this.near
      if (!first && !near && !being.liked) continue
      pen.globalAlpha = first ? 1 : near ? 0.75 : 0.3
      pen.strokeStyle = first || being.liked ? '#ffd68a' : '#ffffff'
      pen.lineWidth = first || (near && this.byKeys) ? 3 : 1.5
      circle(x, y, Math.max(24, r * 1.08))
    }
    pen.strokeStyle = '#ffd68a'
    pen.lineWidth = 3
    for (const { x, y, age } of this.rings) {
      pen.globalAlpha = 1 - age
      circle(x, y, 20 + 90 * age)
    }
    pen.globalAlpha = 1
  }

  /**
   * Draws new agents, and some of the others again with the sway that they have now.
   * @param {Spot[]} spots @param {number} dense
   */
  sprites(spots, dense) {
    for (let made = 0; made < Math.min(SPRITES_A_FRAME, spots.length); made++) {
      const spot = spots.find(({ being, r }) => being.drawn !== Math.round(r * dense)) ?? (this.shell.moving() ? spots[this.turn++ % spots.length] : null)
      if (spot) this.sprite(spot, Math.round(spot.r * dense))
    }
  }

  /** @param {Spot} spot @param {number} r */
  sprite({ being }, r) {
    const { sprite, shape: { agent, x, y, reach } } = being, half = Math.ceil(r * 1.3), pen = sprite.getContext('2d')
    if (!pen || half < 1) return
    if (sprite.width !== 2 * half) sprite.width = sprite.height = 2 * half
    else pen.clearRect(0, 0, 2 * half, 2 * half)
    being.drawn = r
    const path = new Path2D(), scale = r / reach
    let lastX = NaN, lastY = NaN
    walk(agent, agent.v + agent.sw * Math.sin(2 * Math.PI * this.clock / SWAY_S + being.colour), (ax, ay, bx, by) => {
      if (ax !== lastX || ay !== lastY) path.moveTo(half + (ax - x) * scale, half + (ay - y) * scale)
      path.lineTo(half + (bx - x) * scale, half + (by - y) * scale)
      lastX = bx
      lastY = by
    })
    const own = agent.c ?? being.colour, colours = pen.createRadialGradient(half, half, 0, half, half, r)
    colours.addColorStop(0, COLOURS[own % COLOURS.length])
    colours.addColorStop(1, COLOURS[(own + 1) % COLOURS.length])
    pen.strokeStyle = colours
    pen.lineCap = pen.lineJoin = 'round'
    const thin = Math.max(0.8, Math.min(3, r / 70)) * agent.w
    pen.globalAlpha = 0.13
    pen.lineWidth = thin * 4.5
    pen.stroke(path)
    pen.globalAlpha = 0.95
    pen.lineWidth = thin
    pen.stroke(path)
  }
}
