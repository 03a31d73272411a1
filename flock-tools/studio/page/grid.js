// A grid of thousands of sheep, of which only those in view are elements.
//
// Owns the geometry, the elements, and that the sheep with the focus always has one. Never decides what is shown or what a
// key does: `wall.js` does.
//
// Start at [`Grid`].

import { make, styled } from './dom.js'

/** Rows above and below those in view. */
const SPARE = 2
const GAP = 12

/**
 * @typedef {object} Drawing
 * @property {() => HTMLElement} cell an empty one
 * @property {(cell: HTMLElement, id: string, at: number) => void} fill shows a sheep in it
 * @property {(cell: HTMLElement) => void} empty it is out of view
 */

export class Grid {
  /**
   * @param {HTMLElement} scroller
   * @param {Drawing} drawing
   * @param {string} label
   */
  constructor(scroller, drawing, label) {
    this.scroller = scroller
    this.drawing = drawing
    this.field = make('div', { class: 'field-of-cells', role: 'listbox', 'aria-label': label, 'aria-multiselectable': 'true' })
    scroller.append(this.field)
    /** @type {string[]} */ this.ids = []
    /** @type {Map<string, number>} */ this.places = new Map()
    /** @type {Map<string, HTMLElement>} */ this.cells = new Map()
    /** @type {HTMLElement[]} */ this.spare = []
    this.least = 220
    this.caption = 46
    this.columns = 1
    this.wide = 0
    this.thumb = 0
    this.high = 0
    /** @type {string | null} */ this.kept = null
    scroller.addEventListener('scroll', () => this.draw(), { passive: true })
    new ResizeObserver(() => this.measure()).observe(scroller)
  }

  /** @param {string[]} ids */
  list(ids) {
    this.ids = ids
    this.places = new Map(ids.map((id, at) => [id, at]))
    this.measure()
  }

  /**
   * The least width of a picture and the height of what is below it, in CSS pixels.
   * @param {number} least
   * @param {number} caption
   */
  size(least, caption) {
    this.least = least
    this.caption = caption
    this.measure()
  }

  measure() {
    const width = this.field.clientWidth
    if (!width) return
    const before = this.kept !== null ? this.places.get(this.kept) : undefined
    const offset = before === undefined ? 0 : this.top(before) - this.scroller.scrollTop
    const seen = before !== undefined && this.high > 0 && offset > -this.high && offset < this.scroller.clientHeight
    this.columns = Math.max(1, Math.floor((width + GAP) / (Math.min(this.least, width) + GAP)))
    // Whole pixels: a picture is drawn in its size once, and scrolling only copies it.
    this.wide = Math.floor((width - GAP * (this.columns - 1)) / this.columns)
    this.thumb = Math.round(this.wide * 9 / 16)
    this.high = this.thumb + this.caption + GAP
    styled(this.field, { height: `${Math.ceil(this.ids.length / this.columns) * this.high}px`, '--thumb': `${this.thumb}px` })
    // The sheep with the focus stays where it is on the screen.
    if (seen && before !== undefined) this.scroller.scrollTop = this.top(before) - offset
    for (const [id, cell] of this.cells) if (!this.places.has(id)) this.drop(id, cell)
    this.draw(true)
  }

  /** @param {number} at */
  top(at) {
    return Math.floor(at / this.columns) * this.high
  }

  /**
   * Makes elements for what is in view, and for the focus.
   * @param {boolean} [all] those that are there, too, are drawn anew
   */
  draw(all = false) {
    if (!this.high) return
    const first = Math.floor((this.scroller.scrollTop - this.field.offsetTop) / this.high) - SPARE
    const last = first + Math.ceil(this.scroller.clientHeight / this.high) + 2 * SPARE
    const [from, to] = [Math.max(0, first * this.columns), Math.min(this.ids.length, (last + 1) * this.columns)]
    for (const [id, cell] of this.cells) {
      const at = this.places.get(id) ?? -1
      if ((at < from || at >= to) && id !== this.kept) this.drop(id, cell)
    }
    for (let at = from; at < to; at += 1) this.place(this.ids[at], at, all)
    const kept = this.kept === null ? undefined : this.places.get(this.kept)
    if (this.kept !== null && kept !== undefined && (kept < from || kept >= to)) this.place(this.kept, kept, all)
  }

  /**
   * @param {string} id
   * @param {number} at
   * @param {boolean} anew
   */
  place(id, at, anew) {
    let cell = this.cells.get(id)
    if (cell && !anew) return
    if (!cell) {
      cell = this.spare.pop() ?? this.drawing.cell()
      cell.dataset.sheep = id
      this.cells.set(id, cell)
      if (cell.hidden) cell.hidden = false
      if (!cell.isConnected) this.field.append(cell)
    }
    const column = at % this.columns
    styled(cell, { transform: `translate(${column * (this.wide + GAP)}px, ${this.top(at)}px)`, width: `${this.wide}px` })
    cell.setAttribute('aria-setsize', String(this.ids.length))
    cell.setAttribute('aria-posinset', String(at + 1))
    this.drawing.fill(cell, id, at)
  }

  /**
   * @param {string} id
   * @param {HTMLElement} cell
   */
  drop(id, cell) {
    this.cells.delete(id)
    this.drawing.empty(cell)
    cell.hidden = true
    delete cell.dataset.sheep
    this.spare.push(cell)
  }

  /**
   * Draws these anew, if they are in view.
   * @param {Iterable<string>} ids
   */
  again(ids) {
    for (const id of ids) {
      const cell = this.cells.get(id), at = this.places.get(id)
      if (cell && at !== undefined) this.drawing.fill(cell, id, at)
    }
  }

  /**
   * The sheep with the focus: it has an element, and the keyboard's focus if `take`.
   * @param {string | null} id
   * @param {boolean} take
   */
  focus(id, take) {
    const before = this.kept
    this.kept = id
    const at = id === null ? undefined : this.places.get(id)
    if (id !== null && at !== undefined) {
      if (take) this.show(at)
      this.draw()
    }
    this.again([before, id].filter(/** @returns {one is string} */ one => one !== null))
    const cell = id === null ? undefined : this.cells.get(id)
    if (take) cell?.focus({ preventScroll: true })
  }

  /**
   * Scrolls no further than needed.
   * @param {number} at
   */
  show(at) {
    const top = this.top(at) + this.field.offsetTop, { scrollTop, clientHeight } = this.scroller
    if (top < scrollTop + GAP) this.scroller.scrollTop = Math.max(0, top - GAP)
    else if (top + this.high > scrollTop + clientHeight) this.scroller.scrollTop = top + this.high - clientHeight
  }

  /**
   * The sheep that `key` goes to from the one at `at`; the same at an end.
   * @param {string} key
   * @param {number} at
   */
  towards(key, at) {
    const page = Math.max(1, Math.floor(this.scroller.clientHeight / this.high)) * this.columns
    /** @type {Record<string, number>} */
    const by = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -this.columns, ArrowDown: this.columns, PageUp: -page, PageDown: page, Home: -Infinity, End: Infinity }
    const last = this.ids.length - 1, to = at + by[key]
    // The last row may be short: down from above its gap goes to its last sheep.
    if (key === 'ArrowDown' && to > last) return Math.floor(at / this.columns) < Math.floor(last / this.columns) ? last : at
    if (key === 'ArrowUp' && to < 0) return at
    return Math.max(0, Math.min(last, to))
  }
}
