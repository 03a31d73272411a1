// A small drawing of the flock: where the walk is. The graph view is the one to work in.
//
// Start at [`Ways`].

import { make } from './dom.js'

const MOST_ARROWS = 600

export class Ways {
  /** @param {import('./store.js').Store} store */
  constructor(store) {
    this.store = store
    this.from = ''
    this.to = ''
    this.canvas = make('canvas', { class: 'ways', role: 'img', 'aria-label': 'where the walk is' })
    this.due = false
    new ResizeObserver(() => this.draw()).observe(this.canvas)
    store.on(['state'], () => this.draw())
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.draw())
  }

  /**
   * The arrow that is walked; `to` is empty where a sheep is shown.
   * @param {string} from @param {string} to
   */
  at(from, to) {
    if (from === this.from && to === this.to) return
    Object.assign(this, { from, to })
    this.canvas.setAttribute('aria-label', to ? `the walk goes from ${from} to ${to}` : `the walk is at ${from}`)
    this.draw()
  }

  draw() {
    if (this.due) return
    this.due = true
    requestAnimationFrame(() => { this.due = false; this.paint() })
  }

  paint() {
    const { canvas, store } = this, dense = devicePixelRatio, width = canvas.clientWidth, height = canvas.clientHeight
    const pen = canvas.getContext('2d')
    if (!pen || !width) return
    canvas.width = width * dense
    canvas.height = height * dense
    pen.scale(dense, dense)
    const { sheep, transitions } = store.state
    const { color: ink, caretColor: glow, borderTopColor: line } = getComputedStyle(canvas)
    const least = Math.min(9, 40 / Math.sqrt(sheep.length || 1) + 1.2)
    const place = (/** @type {Sheep} */ one) => [width / 2 + one.x * (width / 2 - 12), height / 2 - one.y * (height / 2 - 12)]
    const arrow = (/** @type {string} */ from, /** @type {string} */ to) => {
      const a = store.byId.get(from), b = store.byId.get(to)
      if (!a || !b) return
      const [[ax, ay], [bx, by]] = [place(a), place(b)], bend = 0.12
      pen.beginPath()
      pen.moveTo(ax, ay)
      pen.quadraticCurveTo((ax + bx) / 2 - bend * (by - ay), (ay + by) / 2 + bend * (bx - ax), bx, by)
      pen.stroke()
    }
    pen.strokeStyle = line
    pen.lineWidth = 1
    const drawn = transitions.length > MOST_ARROWS ? store.outs.get(this.from) ?? [] : transitions
    for (const { from, to } of drawn) arrow(from, to)
    const disc = (/** @type {Sheep} */ one, /** @type {number} */ size) => {
      const [x, y] = place(one)
      pen.beginPath()
      pen.arc(x, y, size, 0, 2 * Math.PI)
      pen.fill()
    }
    pen.fillStyle = ink
    for (const one of sheep) disc(one, least * Math.min(2, Math.max(0.4, Math.sqrt(one.share * sheep.length))) / 1.6)
    pen.fillStyle = pen.strokeStyle = glow
    pen.lineWidth = 2.5
    if (this.to) arrow(this.from, this.to)
    for (const id of [this.from, this.to]) {
      const one = store.byId.get(id)
      if (one) disc(one, least + (id === this.from && !this.to ? 3 : 1))
    }
  }
}
