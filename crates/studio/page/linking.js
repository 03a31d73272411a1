// The making of a link: from where, to where, and what it would do.
//
// Owns the line that follows the pointer, the card beside the target, and its questions: a what-if at once, the middle
// pictures when the pointer rests. What nobody waits for any more is cancelled.
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

export class Linking {
  /** @param {Around} graph */
  constructor(graph) {
    this.graph = graph
    /** @type {string | null} */ this.from = null
    /** @type {string | null} */ this.to = null
    this.card = make('div', { class: 'linkcard card', role: 'status', hidden: true })
    this.line = draw('path', { class: 'making' })
    /** @type {ReturnType<typeof setTimeout> | undefined} */ this.rest = undefined
    new ResizeObserver(() => this.follow()).observe(this.card)
  }

  /** @param {string} from */
  start(from) {
    this.from = from
    this.to = null
    this.graph.svg.classList.add('linking')
    this.graph.world.append(this.line)
    this.graph.mark()
    this.card.hidden = false
    this.card.replaceChildren(make('span', {}, `A link from ${from}: go to the sheep it leads to`), button('Cancel', () => this.end(), { class: 'quiet tight' }))
    this.follow()
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
    this.line.setAttribute('d', `M${from.x} ${from.y}L${x} ${y}`)
    this.aim(under === this.from ? null : under)
  }

  /**
   * A target is hovered, or none.
   * @param {string | null} to
   */
  aim(to) {
    if (to === this.to || this.from === null) return
    this.to = to
    const { store, api, scene } = this.graph, from = this.from
    clearTimeout(this.rest)
    api.hush()
    store.suppose(null)
    const target = to === null ? undefined : scene.discs.get(to), source = scene.discs.get(from)
    for (const disc of this.graph.world.querySelectorAll('.hit.target')) disc.classList.remove('target')
    if (to === null || to === from || !target || !source) return this.start(from)
    this.graph.world.querySelector(`[data-sheep="${CSS.escape(to)}"]`)?.classList.add('target')
    this.line.setAttribute('d', scene.outline(from, to, 2 / (store.state.transitions.length || 1)))
    const there = store.byWay.has(way(from, to))
    const words = make('p', { class: 'dim' }, there ? 'They are linked already' : 'Asking what it would do …'), pictures = make('div', { class: 'middles' })
    this.card.replaceChildren(make('h2', {}, `${from} to ${to}`), words, pictures,
      make('div', { class: 'bar end' }, button('Cancel', () => this.end(), { class: 'quiet tight' }), button('Link', () => this.make(to), { class: 'strong tight', disabled: there })))
    this.card.hidden = false
    this.follow()
    if (there) return
    const before = store.state.figures.worst_ratio
    api.whatIf([{ do: 'link', from, to }]).then(told => {
      if (!told || this.to !== to) return
      const ratio = (/** @type {number | null} */ value) => value === null ? 'never' : times(value)
      words.textContent = [`Worst ratio ${ratio(before)} → ${ratio(told.figures.worst_ratio)}`, told.frames ? `${digits(told.frames)} frames` : '', told.cost_s === null ? '' : `${cost(told.cost_s)} to render`].filter(Boolean).join(' · ')
      store.suppose(told)
    })
    if (store.byId.get(from)?.genome && store.byId.get(to)?.genome) this.rest = setTimeout(() => { if (this.to === to) this.graph.panel.middles(from, to, pictures) }, REST)
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

  /** @param {string} to */
  async make(to) {
    const from = this.from
    this.end()
    if (from === null) return
    if (this.graph.store.byWay.has(way(from, to))) {
      this.graph.shell.say(`${from} leads to ${to} already`, true)
      return this.graph.choose({ from, to }, true)
    }
    if (await this.graph.api.edit([{ do: 'link', from, to }])) this.graph.choose({ from, to }, true)
  }

  end() {
    if (this.from === null) return
    // The focus is where the link began, which the panel shows.
    this.graph.store.look(this.from)
    this.from = this.to = null
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
