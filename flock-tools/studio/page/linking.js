// The making of a link, or the leading of one elsewhere: from where, to where, and what it would do.
//
// Owns the line that follows the pointer, the card beside the target, and its questions: a what-if at once, the middle pictures when
// the pointer rests, and after them a moving preview. What nobody waits for any more is cancelled. A link that is led elsewhere is
// one step of undo, and keeps its length and its weight.
//
// Start at [`Linking.start`].

import { button, draw, make, styled } from './dom.js'
import { cost } from './panel.js'
import { way } from './store.js'
import { digits, times } from './words.js'

/** Milliseconds on one target until its middle pictures are asked for. */
const REST = 300

/**
 * @typedef {object} Around What a link needs of the graph.
 * @property {import('./store.js').Store} store
 * @property {import('./api.js').Api} api
 * @property {Shell} shell
 * @property {import('./scene.js').Scene} scene
 * @property {import('./panel.js').Panel} panel
 * @property {SVGElement} svg
 * @property {SVGElement} world
 * @property {(chosen: import('./panel.js').Chosen, take: boolean) => void} choose
 * @property {() => void} mark
 */

/** @typedef {Transition & {end: 'from' | 'to'}} Moved A transition that is led elsewhere, by one of its ends. */

export class Linking {
  /** @param {Around} graph */
  constructor(graph) {
    this.graph = graph
    /** @type {string | null} The sheep that stays. */ this.from = null
    /** @type {Moved | null} */ this.moved = null
    /** @type {string | null} */ this.to = null
    this.card = make('div', { class: 'linkcard card', role: 'status', hidden: true })
    this.line = draw('path', { class: 'making' })
    /** The place of the moving preview. */ this.film = make('div', { class: 'middles' })
    /** @type {ReturnType<typeof setTimeout> | undefined} */ this.rest = undefined
    new ResizeObserver(() => this.follow()).observe(this.card)
  }

  /** @param {string} from @param {Moved | null} [moved] */
  start(from, moved = null) {
    Object.assign(this, { from, moved, to: null })
    this.graph.svg.classList.add('linking')
    this.graph.world.append(this.line)
    this.graph.mark()
    this.card.hidden = false
    const words = moved ? `${moved.from} to ${moved.to}: go to the sheep where it is to ${moved.end === 'to' ? 'end' : 'begin'}` : `A link from ${from}: go to the sheep it leads to`
    this.card.replaceChildren(make('span', {}, words), button('Cancel', () => this.end(), { class: 'quiet tight' }))
    this.follow()
  }

  /**
   * Leads a transition elsewhere.
   * @param {{from: string, to: string}} which
   * @param {'from' | 'to'} end
   */
  move({ from, to }, end) {
    const edge = this.graph.store.byWay.get(way(from, to))
    if (edge) this.start(end === 'to' ? from : to, { ...edge, end })
  }

  /**
   * The ends of the link to a sheep.
   * @param {string} other
   * @returns {[string, string]}
   */
  ends(other) {
    const held = this.from ?? ''
    return this.moved?.end === 'from' ? [other, held] : [held, other]
  }

  /**
   * What makes it.
   * @param {string} other
   * @returns {Edit[]}
   */
  edits(other) {
    const [from, to] = this.ends(other), old = this.moved
    return old ? [{ do: 'link', from, to, frames: old.frames }, { do: 'weight', from, to, value: old.weight }, { do: 'unlink', from: old.from, to: old.to }] : [{ do: 'link', from, to }]
  }

  /**
   * Under the pointer, in the drawing's pixels.
   * @param {number} x
   * @param {number} y
   * @param {string | null} under
   */
  drag(x, y, under) {
    const from = this.from === null ? undefined : this.graph.scene.discs.get(this.from)
    if (!from) return
    this.aim(under === this.from ? null : under)
    if (this.to === null) this.line.setAttribute('d', `M${from.x} ${from.y}L${x} ${y}`)
  }

  /**
   * A target is hovered, or none.
   * @param {string | null} to
   */
  aim(to) {
    if (to === this.to || this.from === null) return
    this.to = to
    const { store, api, scene } = this.graph, held = this.from
    clearTimeout(this.rest)
    api.hush()
    store.suppose(null)
    const target = to === null ? undefined : scene.discs.get(to), source = scene.discs.get(held)
    for (const disc of this.graph.world.querySelectorAll('.hit.target')) disc.classList.remove('target')
    if (to === null || to === held || !target || !source) return this.start(held, this.moved)
    const [from, end] = this.ends(to)
    this.graph.world.querySelector(`[data-sheep="${CSS.escape(to)}"]`)?.classList.add('target')
    this.line.setAttribute('d', scene.outline(from, end))
    const there = store.byWay.has(way(from, end))
    const words = make('p', { class: 'dim' }, there ? 'They are linked already' : 'Asking what it would do …'), pictures = make('div', { class: 'middles' }), drawn = !there && this.graph.panel.canDraw(from, end)
    this.film = make('div', { class: 'middles' })
    this.card.replaceChildren(make('h2', {}, `${from} to ${end}`), words, pictures, this.film,
      make('div', { class: 'bar end' }, drawn ? button('Preview', () => this.preview(), { class: 'quiet tight', title: 'A moving preview (V)' }) : '', button('Cancel', () => this.end(), { class: 'quiet tight' }), button(this.moved ? 'Lead it here' : 'Link', () => this.make(to), { class: 'strong tight', disabled: there })))
    this.card.hidden = false
    this.follow()
    if (there) return
    const before = store.state.figures.worst_ratio
    api.whatIf(this.edits(to)).then(told => {
      if (!told || this.to !== to) return
      const ratio = (/** @type {number | null} */ value) => value === null ? '∞' : times(value)
      words.textContent = [`Worst ratio ${ratio(before)} → ${ratio(told.figures.worst_ratio)}`, told.frames ? `${digits(told.frames)} frames` : '', told.cost_s === null ? '' : `${cost(told.cost_s)} to render`].filter(Boolean).join(' · ')
      store.suppose(told)
    })
    if (drawn) this.rest = setTimeout(async () => {
      if (this.to === to) await this.graph.panel.middles(from, end, pictures)
      if (pictures.isConnected && this.graph.shell.moving()) this.preview()
    }, REST)
  }

  /** A moving preview of the link, in the card. */
  preview() {
    if (this.to === null) return
    const [from, to] = this.ends(this.to)
    if (!this.graph.store.byWay.has(way(from, to)) && this.graph.panel.canDraw(from, to)) this.graph.panel.moving(from, to, this.film)
  }

  /** The card stays beside the target, in view. */
  follow() {
    const { scene } = this.graph, disc = scene.discs.get(this.to ?? this.from ?? '')
    if (this.card.hidden || !disc) return
    const [ox, oy] = scene.origin(), wide = this.card.offsetWidth, high = this.card.offsetHeight
    const x = ox + disc.x * scene.zoom, y = oy + disc.y * scene.zoom, r = disc.r * scene.zoom + 14
    const left = x + r + wide < scene.width ? x + r : Math.max(8, x - r - wide)
    styled(this.card, { left: `${Math.max(8, Math.min(scene.width - wide - 8, left)).toFixed(0)}px`, top: `${Math.max(8, Math.min(scene.height - high - 8, y - high / 2)).toFixed(0)}px` })
  }

  /** @param {string} other */
  async make(other) {
    const held = this.from, [from, to] = this.ends(other), edits = this.edits(other)
    this.end()
    if (held === null) return
    if (this.graph.store.byWay.has(way(from, to))) {
      this.graph.shell.say(`${from} leads to ${to} already`, true)
      return this.graph.choose({ from, to }, true)
    }
    if (await this.graph.api.edit(edits)) this.graph.choose({ from, to }, true)
  }

  end() {
    if (this.from === null) return
    // The focus is where the link began, which the panel shows.
    this.graph.store.look(this.from)
    this.from = this.to = this.moved = null
    clearTimeout(this.rest)
    this.line.remove()
    this.line.removeAttribute('d')
    this.card.hidden = true
    this.card.replaceChildren()
    this.graph.svg.classList.remove('linking')
    for (const disc of this.graph.world.querySelectorAll('.hit.target')) disc.classList.remove('target')
    this.graph.api.hush()
    this.graph.store.suppose(null)
    this.graph.mark()
  }
}
