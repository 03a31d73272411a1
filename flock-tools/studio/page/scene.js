// The drawing of the flock: a disc's area is the sheep's share, the dashed ring its want, the colour of its rim their ratio;
// an arrow is the broader the more often the transition is taken.
//
// Owns the geometry, the canvas with arrows and discs, and what lies under a point. Thousands of arrows take a tenth of a second
// to draw: they are drawn a few at a time, so that no key waits for them, and until then those drawn before are shown. Never
// changes the flock: `graph.js` does.
//
// Start at [`Scene`]. Places are of the program's layout; zoom and shift are those of the eye.

import { across, around, bendOf, corners, towards } from './arrow.js'
import { tilt } from './cell.js'
import { make, styled } from './dom.js'
import { tint } from './ratio.js'
import { way } from './store.js'
import { short } from './words.js'

/** Steps of the colours from shown too seldom to shown too often. */
const TINTS = 16
/** Discs of at least this radius on the screen have pictures in them. */
const PICTURED = 9
/** Pixels above the drawing, where the field for names is; below, for the lowest names; and beside its middles, for half a name. */
const ABOVE = 34
const BELOW = 14
const BESIDE = 44
/** @typedef {{one: Sheep, x: number, y: number, r: number, want: number, ghost: number | null}} Disc in the drawing's own pixels */
/** Above so many arrows they follow when the hand rests, after so many milliseconds. */
const MANY = 300
const REST = 250
/** Milliseconds that arrows are drawn at once, and how many before the canvas is held to it. */
const SLICE = 6
const BATCH = 24

export class Scene {
  /** @param {import('./store.js').Store} store @param {import('./strip.js').Strips} strips */
  constructor(store, strips) {
    this.store = store
    this.strips = strips
    this.canvas = make('canvas', { class: 'drawing', 'aria-hidden': 'true' })
    this.width = 0
    this.height = 0
    this.unit = 0
    this.margin = 0
    this.zoom = 1
    this.x = 0
    this.y = 0
    /** @type {Map<string, Disc>} */ this.discs = new Map()
    /** @type {Map<string, number>} How often transitions would be taken, while something is supposed. */ this.visits = new Map()
    /** @type {string | null} The id of the sheep whose arrows are lit. */ this.lit = null
    this.moves = false
    this.tick = 0
    this.asked = false
    /** The arrows as they were drawn last, for the eye of then; discs are drawn for every picture. */
    this.back = { canvas: document.createElement('canvas'), zoom: 1, x: 0, y: 0 }
    this.spare = document.createElement('canvas')
    /** @type {ReturnType<typeof setTimeout> | undefined} */ this.later = undefined
    /** @type {string[]} */ this.tints = []
    /** @type {Record<string, string>} */ this.inks = {}
    this.moved = () => {}
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { this.tints = []; this.renew() })
  }

  /**
   * Measures the box and places everything anew.
   * @param {number} width
   * @param {number} height
   */
  size(width, height) {
    this.width = Math.max(200, width)
    this.height = Math.max(200, height)
    const sheep = this.store.state.sheep.length || 1
    this.unit = Math.min(58, this.width / 9, 0.37 * Math.sqrt(this.width * this.height / 4 / sheep))
    const scale = Math.min(2, devicePixelRatio)
    const [wide, high] = [Math.round(this.width * scale), Math.round(this.height * scale)]
    // Another size empties the canvas: it is drawn before the page is.
    const another = wide !== this.canvas.width || high !== this.canvas.height
    if (another) {
      Object.assign(this.canvas, { width: wide, height: high })
      styled(this.canvas, { width: `${this.width}px`, height: `${this.height}px` })
    }
    this.place()
    if (another) this.draw()
  }

  /** @param {number} share */
  radius(share) {
    return Math.max(0.28, Math.min(2.3, Math.sqrt(share * this.store.state.sheep.length))) * this.unit
  }

  /** The discs and arrows of the state, or of what is supposed. */
  place() {
    const { sheep, transitions } = this.store.state, supposed = this.store.supposed
    const figures = new Map((supposed?.sheep ?? []).map(one => [one.id, one]))
    this.margin = 8 + sheep.reduce((most, one) => Math.max(most, this.radius(Math.max(one.share, one.wanted))), 0)
    this.discs = new Map(sheep.map(one => {
      const [x, y] = this.at(one), told = figures.get(one.id), share = told?.share ?? one.share, wanted = told?.wanted ?? one.wanted
      return [one.id, { one: told ? { ...one, share, wanted, ratio: told.ratio, shown: share > 0 } : one, x, y, r: this.radius(share), want: this.radius(wanted), ghost: told ? this.radius(one.share) : null }]
    }))
    this.visits = new Map(supposed?.transitions.map(one => [way(one.from, one.to), one.visits]))
    this.renew(transitions.length > MANY ? REST : 0)
  }

  /** @param {{x: number, y: number}} one @returns {[number, number]} */
  at(one) {
    const { x, y, wide, high } = this.field()
    return [x + one.x * wide, y - one.y * high]
  }

  /** The middle of the layout in the drawing, and its reach to each side: below what stands above, with room for names. */
  field() {
    const high = (this.height - ABOVE - BELOW) / 2
    return { x: this.width / 2, y: ABOVE + high, wide: this.width / 2 - Math.max(this.margin, BESIDE), high: high - this.margin }
  }
  /**
   * The reverse: a place of the layout.
   * @param {number} left
   * @param {number} top
   */
  layout(left, top) {
    const { x, y, wide, high } = this.field()
    return { x: (left - x) / wide, y: (y - top) / high }
  }

  /** @param {string} from @param {string} to */
  breadth(from, to) {
    const name = way(from, to), count = this.store.state.transitions.length || 1
    const visits = this.visits.get(name) ?? this.store.byWay.get(name)?.visits ?? 1 / count
    return Math.max(0.35, Math.min(5, 0.085 * this.unit * Math.sqrt(visits * count)))
  }
  /** @param {string} from @param {string} to */
  outline(from, to) {
    const a = this.discs.get(from), b = this.discs.get(to), width = this.breadth(from, to)
    if (!a || !b) return ''
    return from === to ? around(a, width) : across(a, b, width)
  }

  /**
   * The middle of an arrow.
   * @param {string} from
   * @param {string} to
   * @returns {[number, number] | null}
   */
  middle(from, to) {
    const a = this.discs.get(from), b = this.discs.get(to)
    if (!a || !b) return null
    if (from === to) return [a.x, a.y - a.r - 0.7 * a.r - 6]
    const [cx, cy] = bendOf(a, b), [[ax, ay], [bx, by]] = this.rims(a, b, 0)
    return [(ax + bx) / 4 + cx / 2, (ay + by) / 4 + cy / 2]
  }

  /**
   * Beside the two discs of an arrow, on it; nowhere if it is too short for that.
   * @param {string} from
   * @param {string} to
   */
  endsOf(from, to) {
    const a = this.discs.get(from), b = this.discs.get(to)
    if (!a || !b || Math.hypot(a.x - b.x, a.y - b.y) < a.r + b.r + 90) return []
    return this.rims(a, b, 13)
  }
  /**
   * Where an arrow is so many pixels from its discs.
   * @param {Disc} a @param {Disc} b @param {number} off
   */
  rims(a, b, off) {
    const [cx, cy] = bendOf(a, b)
    return [a, b].map(one => towards(one.x, one.y, cx, cy, one.r + off))
  }

  /**
   * Draws the discs before the next frame, and the arrows, few of them at once, many as time allows.
   * @param {number} [wait] milliseconds before the arrows
   */
  renew(wait = 0) {
    clearTimeout(this.later)
    this.ask()
    /** @type {Generator | undefined} */ let work
    const go = () => {
      work ??= this.drawArrows()
      const end = performance.now() + SLICE
      while (performance.now() < end) if (work.next().done) return this.ask()
      this.later = setTimeout(go)
    }
    if (wait) this.later = setTimeout(go, wait)
    else go()
  }

  /** Draws before the next frame, once. */
  ask() {
    if (this.asked) return
    this.asked = true
    requestAnimationFrame(() => { this.asked = false; this.draw() })
  }

  colours() {
    if (this.tints.length) return
    const probe = make('span', { hidden: true })
    this.canvas.after(probe)
    const resolved = (/** @type {string} */ colour) => { styled(probe, { color: colour }); return getComputedStyle(probe).color }
    this.tints = Array.from({ length: 2 * TINTS + 1 }, (_, at) => resolved(tint((at - TINTS) / TINTS)))
    this.inks = Object.fromEntries(['ink', 'ground', 'glow', 'bad', 'dim', 'raised'].map(name => [name, resolved(`var(--${name})`)]))
    probe.remove()
  }

  draw() {
    const context = this.canvas.getContext('2d')
    if (!context || !this.canvas.isConnected) return
    this.colours()
    const scale = this.canvas.width / this.width
    context.setTransform(1, 0, 0, 1, 0, 0)
    context.clearRect(0, 0, this.canvas.width, this.canvas.height)
    const [ox, oy] = this.origin(), { back } = this, nearer = this.zoom / back.zoom
    context.setTransform(nearer, 0, 0, nearer, scale * (ox - nearer * back.x), scale * (oy - nearer * back.y))
    context.globalAlpha = this.lit === null ? 1 : 0.5
    if (back.canvas.width) context.drawImage(back.canvas, 0, 0)
    context.globalAlpha = 1
    context.setTransform(scale * this.zoom, 0, 0, scale * this.zoom, scale * ox, scale * oy)
    const seen = [...this.discs.values()].filter(disc => this.inView(disc))
    const pictured = seen.filter(disc => disc.r * this.zoom >= PICTURED && disc.one.strip)
    // The largest move.
    const moving = new Set(pictured.length > 40 ? [...pictured].sort((a, b) => b.r - a.r).slice(0, 40) : pictured)
    for (const disc of seen) this.drawDisc(context, disc, moving.has(disc))
    if (this.unit * this.zoom > 15) for (const disc of seen) this.drawName(context, disc)
    this.moves = moving.size > 0
    this.moved()
  }

  /** Draws all arrows, one at each step; at the end they are those that are shown. */
  *drawArrows() {
    this.colours()
    const { spare, zoom, canvas } = this, scale = canvas.width / this.width, [x, y] = this.origin(), { transitions } = this.store.state
    Object.assign(spare, { width: canvas.width, height: canvas.height })
    const context = spare.getContext('2d', { willReadFrequently: true })
    if (!context) return
    context.setTransform(scale * zoom, 0, 0, scale * zoom, scale * x, scale * y)
    const count = transitions.length, ease = Math.max(0.3, 0.6 - count / 400) / Math.sqrt(zoom)
    let drawn = 0
    for (const one of transitions) {
      const a = this.discs.get(one.from), b = this.discs.get(one.to)
      if (!a || !b || zoom > 1.2 && !this.crosses(one)) continue
      context.fillStyle = one.visits ? this.inks.ink : this.inks.bad
      context.globalAlpha = Math.min(1, ease * Math.min(1, 0.3 + 0.7 * one.visits * count / 4))
      const width = this.breadth(one.from, one.to)
      if (a === b) context.fill(new Path2D(around(a, width)))
      else {
        const [start, bend, neck, wing, tip, wing2, neck2, bend2, end] = corners(a, b, width)
        context.beginPath()
        context.moveTo(...start)
        context.quadraticCurveTo(...bend, ...neck)
        for (const point of [wing, tip, wing2, neck2]) context.lineTo(...point)
        context.quadraticCurveTo(...bend2, ...end)
        context.fill()
      }
      // A canvas puts off what it is told until it is read.
      if (++drawn % BATCH === 0) context.getImageData(0, 0, 1, 1)
      yield
    }
    this.spare = this.back.canvas
    this.back = { canvas: spare, zoom, x, y }
  }

  /** @param {CanvasRenderingContext2D} context @param {Disc} disc @param {boolean} moving */
  drawDisc(context, { one, x, y, r, want, ghost }, moving) {
    const colour = this.tints[TINTS + Math.round(tilt(one) * TINTS)], thin = 1 / this.zoom
    const rim = Math.max(1.2 * thin, Math.min(0.07 * r, 4)), inner = r - rim
    context.beginPath()
    context.arc(x, y, r, 0, 2 * Math.PI)
    context.fillStyle = one.shown ? colour : this.inks.ground
    context.fill()
    const strip = r * this.zoom >= PICTURED && one.strip ? this.strips.small(one.strip, () => this.ask()) : undefined
    if (strip) {
      context.save()
      context.beginPath()
      context.arc(x, y, inner, 0, 2 * Math.PI)
      context.clip()
      const [sx, sy, wide, high] = this.strips.piece(strip, moving ? this.tick : 0)
      const square = Math.min(wide, high)
      context.drawImage(strip, sx + (wide - square) / 2, sy, square, square, x - inner, y - inner, 2 * inner, 2 * inner)
      context.restore()
    }
    if (!one.shown) this.ring(context, x, y, r, colour, [2 * thin, 2 * thin], 1.5 * thin)
    if (Math.abs(want - r) > thin * (1 + 0.06 * r)) this.ring(context, x, y, want, this.inks.ink, [3 * thin, 3 * thin], 1.1 * thin, 0.75)
    if (ghost !== null && Math.abs(ghost - r) > 0.5 * thin) this.ring(context, x, y, ghost, this.inks.glow, [], 1.6 * thin, 0.9)
    if (one.pinned) {
      context.beginPath()
      context.arc(x, y - r, 2.6 * thin, 0, 2 * Math.PI)
      context.fillStyle = this.inks.ink
      context.fill()
    }
  }

  /** @param {CanvasRenderingContext2D} context @param {number} x @param {number} y @param {number} r @param {string} colour @param {number[]} dash @param {number} width @param {number} [alpha] */
  ring(context, x, y, r, colour, dash, width, alpha = 1) {
    context.globalAlpha = alpha
    context.setLineDash(dash)
    context.lineWidth = width
    context.strokeStyle = colour
    context.beginPath()
    context.arc(x, y, r, 0, 2 * Math.PI)
    context.stroke()
    context.setLineDash([])
    context.globalAlpha = 1
  }

  /** @param {CanvasRenderingContext2D} context @param {Disc} disc */
  drawName(context, { one, x, y, r, want }) {
    const size = 12 / this.zoom
    context.font = `${size}px system-ui, sans-serif`
    context.textAlign = 'center'
    context.lineWidth = 3 / this.zoom
    context.lineJoin = 'round'
    context.strokeStyle = this.inks.ground
    context.fillStyle = this.inks.ink
    const below = y + Math.max(r, want) + 1.2 * size
    context.strokeText(short(one.id), x, below)
    context.fillText(short(one.id), x, below)
  }

  /** Where the drawing's own corner is on the screen. */
  origin() {
    return [this.width / 2 + this.x - this.zoom * this.width / 2, this.height / 2 + this.y - this.zoom * this.height / 2]
  }
  /**
   * A point of the screen in the drawing.
   * @param {number} x
   * @param {number} y
   * @returns {[number, number]}
   */
  inside(x, y) {
    const [ox, oy] = this.origin()
    return [(x - ox) / this.zoom, (y - oy) / this.zoom]
  }
  /** @param {Disc} disc */
  inView({ x, y, r, want }) {
    const [ox, oy] = this.origin(), reach = (Math.max(r, want) + 20) * this.zoom
    const [sx, sy] = [ox + x * this.zoom, oy + y * this.zoom]
    return sx > -reach && sy > -reach && sx < this.width + reach && sy < this.height + reach
  }

  /**
   * Whether some of an arrow may be in view.
   * @param {Transition} one
   */
  crosses({ from, to }) {
    const a = this.discs.get(from), b = this.discs.get(to)
    if (!a || !b) return false
    const [left, top] = this.inside(0, 0), [right, bottom] = this.inside(this.width, this.height), slack = 80
    return Math.max(a.x, b.x) > left - slack && Math.min(a.x, b.x) < right + slack && Math.max(a.y, b.y) > top - slack && Math.min(a.y, b.y) < bottom + slack
  }

  /** @param {number} zoom @param {number} x @param {number} y */
  look(zoom, x, y) {
    this.zoom = Math.max(1, Math.min(16, zoom))
    const reach = (this.zoom - 1) / 2
    this.x = Math.max(-reach * this.width, Math.min(reach * this.width, x))
    this.y = Math.max(-reach * this.height, Math.min(reach * this.height, y))
    this.renew()
  }
  /** @param {number} factor @param {number} [px] @param {number} [py] */
  zoomBy(factor, px = this.width / 2, py = this.height / 2) {
    const zoom = Math.max(1, Math.min(16, this.zoom * factor)), by = zoom / this.zoom
    const [dx, dy] = [px - this.width / 2, py - this.height / 2]
    this.look(zoom, dx - by * (dx - this.x), dy - by * (dy - this.y))
  }
  /**
   * Shifts no further than needed for a sheep to be seen.
   * @param {string} id
   */
  reveal(id) {
    const disc = this.discs.get(id)
    if (!disc) return
    const [ox, oy] = this.origin(), edge = 60
    const sx = ox + disc.x * this.zoom, sy = oy + disc.y * this.zoom
    const off = (/** @type {number} */ at, /** @type {number} */ size) => at < edge ? edge - at : at > size - edge ? size - edge - at : 0
    const [dx, dy] = [off(sx, this.width), off(sy, this.height)]
    if (dx || dy) this.look(this.zoom, this.x + dx, this.y + dy)
  }

  /**
   * The sheep under a point of the drawing, and whether the point is on its rim. Small discs are larger to the pointer.
   * @param {number} x
   * @param {number} y
   * @returns {{id: string, rim: boolean} | null}
   */
  under(x, y) {
    /** @type {{id: string, rim: boolean} | null} */ let found = null
    let nearest = Infinity
    for (const [id, disc] of this.discs) {
      const far = Math.hypot(x - disc.x, y - disc.y), reach = Math.max(disc.r + 6 / this.zoom, 12 / this.zoom)
      if (far > reach || far / reach >= nearest) continue
      nearest = far / reach
      found = { id, rim: far > Math.max(0.72 * disc.r, disc.r - 9 / this.zoom) }
    }
    return found
  }

  /**
   * The arrow that passes within 6 pixels of a point of the drawing.
   * @param {number} x
   * @param {number} y
   * @returns {Transition | null}
   */
  arrowUnder(x, y) {
    /** @type {Transition | null} */ let found = null
    let nearest = 6 / this.zoom
    for (const one of this.store.state.transitions) {
      const a = this.discs.get(one.from), b = this.discs.get(one.to)
      if (!a || !b || one.from === one.to) continue
      const slack = 80 + nearest
      if (x < Math.min(a.x, b.x) - slack || x > Math.max(a.x, b.x) + slack || y < Math.min(a.y, b.y) - slack || y > Math.max(a.y, b.y) + slack) continue
      const [cx, cy] = bendOf(a, b)
      for (let at = 1; at < 24; at += 1) {
        const t = at / 24, [p, q, s] = [(1 - t) ** 2, 2 * t * (1 - t), t * t]
        const far = Math.hypot(p * a.x + q * cx + s * b.x - x, p * a.y + q * cy + s * b.y - y)
        if (far < nearest) { nearest = far; found = one }
      }
    }
    return found
  }

  /**
   * The nearest sheep from one in a direction of the arrow keys.
   * @param {string} id
   * @param {string} key
   */
  towards(id, key) {
    const from = this.discs.get(id)
    if (!from) return null
    const [dx, dy] = /** @type {Record<string, [number, number]>} */ ({ ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] })[key]
    /** @type {string | null} */ let found = null
    let best = Infinity
    // One that is mostly that way, else the one that is a little that way and nearest.
    for (const steep of [2, 100]) for (const [other, disc] of found === null ? this.discs : []) {
      const along = (disc.x - from.x) * dx + (disc.y - from.y) * dy, beside = Math.abs((disc.x - from.x) * dy) + Math.abs((disc.y - from.y) * dx)
      if (other === id || along <= 0 || beside > steep * along) continue
      const cost = along + 1.6 * beside
      if (cost < best) { best = cost; found = other }
    }
    return found
  }
}
