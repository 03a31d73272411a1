// The panel beside the graph: the chosen sheep, the chosen arrow, or the whole flock.
//
// Owns its elements and what their buttons do. A panel is made anew when something else is chosen, or something that stands in
// it changes; what has the keyboard's focus keeps it, by its name. Figures and sliders follow without that.
//
// Start at [`Panel`].

import { against, stateOf, tilt } from './cell.js'
import { button, make, styled } from './dom.js'
import { watch } from './growing.js'
import { tint } from './ratio.js'
import { media } from './session.js'
import { level, slider } from './sliders.js'
import { way } from './store.js'
import { digits, minutes, percent, spoken, times, why } from './words.js'

/** @typedef {{sheep: string} | {from: string, to: string} | null} Chosen */

/**
 * @typedef {object} Deeds What the panel asks of the graph.
 * @property {(chosen: Chosen) => void} choose
 * @property {(from: string, to: string) => void} unlink
 * @property {(from: string) => void} startLink
 * @property {(edge: Transition, end: 'from' | 'to') => void} move
 * @property {() => void} balance
 * @property {() => void} prune
 * @property {() => void} suggest
 * @property {() => void} table
 * @property {(what: {sheep?: string, from?: string, to?: string, all_missing?: boolean}, draft?: boolean) => void} render
 * @property {(sheep: string) => void} unpin
 */

/**
 * A small button.
 * @param {string} label
 * @param {(event: MouseEvent) => void} run
 * @param {import('./dom.js').Attributes} [more]
 */
const tight = (label, run, more) => button(label, run, { class: 'quiet tight', ...more })

/** The members that the panel's figures and sliders follow. */
const FLOWS = /^(want|wanted|share|ratio|weight|visits|x|y)$/

/** @param {number | null} seconds */
export const cost = seconds => seconds === null ? '' : minutes(seconds / 60)

export class Panel {
  /** @param {import('./store.js').Store} store @param {import('./api.js').Api} api @param {Shell} shell @param {Deeds} deeds */
  constructor(store, api, shell, deeds) {
    this.store = store
    this.api = api
    this.shell = shell
    this.deeds = deeds
    this.root = make('aside', { class: 'panel', 'aria-label': 'What is chosen' })
    /** @type {Chosen} */ this.chosen = null
    /** @type {(() => void)[]} What follows the figures. */ this.live = []
    /** What stands in the panel besides, and an element of it. */
    this.fixed = ''
    /** @type {ChildNode | null} */ this.first = null
    /** @type {HTMLCanvasElement | null} */ this.canvas = null
  }

  /** @param {Chosen} chosen */
  show(chosen) {
    const fixed = this.fixedOf(chosen)
    if (fixed === this.fixed && this.first === this.root.firstChild) return this.figures()
    this.fixed = fixed
    const same = JSON.stringify(chosen) === JSON.stringify(this.chosen)
    const named = document.activeElement instanceof HTMLElement && this.root.contains(document.activeElement) ? document.activeElement.getAttribute('aria-label') ?? document.activeElement.textContent : null
    const scrolled = same ? this.root.scrollTop : 0
    this.chosen = chosen
    this.live = []
    if (this.canvas) this.shell.strips.forget(this.canvas)
    this.canvas = null
    const one = chosen && 'sheep' in chosen ? this.store.byId.get(chosen.sheep) : undefined
    const edge = chosen && 'from' in chosen ? this.store.byWay.get(way(chosen.from, chosen.to)) : undefined
    const parts = one ? this.sheep(one) : edge ? this.arrow(edge) : this.flock()
    this.root.replaceChildren(...parts.flatMap(part => part ? [part] : []))
    this.first = this.root.firstChild
    if (scrolled) this.root.scrollTop = scrolled
    if (same && named !== null) {
      const again = [...this.root.querySelectorAll('input, button')].find(item => (item.getAttribute('aria-label') ?? item.textContent) === named)
      if (again instanceof HTMLElement) again.focus({ preventScroll: true })
    }
    this.figures()
  }

  /**
   * All that is drawn of `chosen` and does not follow the figures, as text; of the whole flock another one each time.
   * @param {Chosen} chosen
   */
  fixedOf(chosen) {
    if (!chosen) return `${Math.random()}`
    const { byId, byWay, outs, ins } = this.store
    const told = 'sheep' in chosen ? [byId, outs, ins].map(all => all.get(chosen.sheep)) : byWay.get(way(chosen.from, chosen.to))
    return JSON.stringify([chosen, told], (name, value) => FLOWS.test(name) ? 0 : value)
  }

  /** The figures follow what is supposed. */
  figures() {
    for (const draw of this.live) draw()
  }

  /**
   * The figures of a sheep, as they are or as they would be.
   * @param {string} id
   */
  told(id) {
    const one = this.store.byId.get(id)
    const supposed = this.store.supposed?.sheep.find(other => other.id === id)
    return one && supposed ? { ...one, ...supposed, shown: supposed.share > 0 } : one
  }

  /** @param {Sheep} one */
  sheep(one) {
    const { store, api, shell, deeds } = this, id = one.id
    this.canvas = make('canvas', { 'aria-hidden': 'true' })
    shell.strips.show(this.canvas, one)
    const words = make('p', { class: 'dim' }), bars = make('div')
    this.live.push(() => {
      const told = this.told(id)
      if (!told) return
      words.textContent = `${percent(told.share)} of ${store.state.by === 'time' ? 'the time' : 'all visits'}, ${percent(told.wanted)} wished; ${against(told)}`
      bars.replaceChildren(level(told.ratio ?? 0, tint(tilt(told))))
    })
    const want = slider({ label: `Want of ${id}`, value: one.want, edit: value => ({ do: 'want', sheep: id, value }), store, api })
    this.live.push(() => want.set(store.byId.get(id)?.want ?? 1))
    const repeat = make('input', { class: 'field typed', type: 'number', min: 1, max: 999, value: one.repeat, 'aria-label': `How often the loop of ${id} is repeated`, onchange: () => { if (repeat.valueAsNumber >= 1) api.edit([{ do: 'repeat', sheep: id, value: Math.round(repeat.valueAsNumber) }]) } })
    const outs = store.outs.get(id) ?? [], ins = store.ins.get(id) ?? []
    return [
      this.whole(), make('div', { class: 'thumb' }, this.canvas), make('h2', {}, id), words, bars,
      make('div', { class: 'pairs' }, make('span', { class: 'dim' }, 'Want'), want.root, make('span', { class: 'dim' }, 'Repeat'), make('div', {}, repeat, make('span', { class: 'dim' }, ` ${digits(one.frames / store.state.fps[0] * store.state.fps[1], 1)} s a loop`))),
      make('p', { class: 'dim small' }, [one.species, stateOf(one) || (one.state === 'there' ? 'loop is there' : ''), one.licence, one.authors.join(', ')].filter(Boolean).join(' · ')),
      ...this.undrawn(one),
      make('div', { class: 'bar' },
        tight('Link', () => deeds.startLink(id), { title: 'Begin a link here (L)' }),
        tight('Walk from here', () => shell.go('walk', { from: id })),
        tight('Breed', () => shell.go('breed', { from: id })),
        ...one.state === 'there' || !one.genome || one.refused ? [] : this.renders({ sheep: id }),
        one.pinned && tight('Unpin', () => deeds.unpin(id)),
        tight('Rename…', () => this.rename(id)),
        tight('Take out', () => { api.edit([{ do: 'drop', sheep: id }]) }, { title: 'Take it out of the flock' })),
      make('h3', {}, `Leads to ${spoken(outs.length, 'sheep')}`), make('ul', { class: 'links' }, ...outs.map(edge => this.leads(edge))),
      make('h3', {}, `Comes from ${spoken(ins.length, 'sheep')}`), make('ul', { class: 'links' }, ...ins.map(edge => this.comes(edge))),
    ]
  }

  /** @param {Transition} edge */
  weight({ from, to, weight }) {
    const { store, api } = this, name = way(from, to)
    const made = slider({ label: `Weight of ${from} to ${to}`, value: weight, edit: value => ({ do: 'weight', from, to, value }), store, api })
    this.live.push(() => made.set(store.byWay.get(name)?.weight ?? 1))
    return made
  }
  /**
   * A transition that leaves the chosen sheep, with its weight.
   * @param {Transition} edge
   */
  leads(edge) {
    const { deeds } = this, { from, to } = edge
    const weight = this.weight(edge)
    return make('li', { 'data-from': from, 'data-to': to }, this.named(edge, to), this.visits(edge), button(`Unlink ${from} from ${to}`, () => deeds.unlink(from, to), { icon: 'close', class: 'tool small' }), weight.root)
  }
  /** @param {Transition} edge */
  comes(edge) {
    return make('li', { 'data-from': edge.from, 'data-to': edge.to }, this.named(edge, edge.from), this.visits(edge), button(`Unlink ${edge.from} from ${edge.to}`, () => this.deeds.unlink(edge.from, edge.to), { icon: 'close', class: 'tool small' }))
  }
  /** @param {Transition} edge @param {string} name */
  named(edge, name) {
    return button(name, () => this.deeds.choose({ from: edge.from, to: edge.to }), { class: 'name', title: `The transition from ${edge.from} to ${edge.to}${stateOf(edge) ? `, ${stateOf(edge)}` : ''}`, 'data-state': edge.state })
  }
  /** @param {Transition} edge */
  taken({ from, to }) {
    const { supposed, byWay } = this.store
    return (supposed?.transitions.find(one => one.from === from && one.to === to) ?? byWay.get(way(from, to)))?.visits ?? 0
  }
  /**
   * How often it is taken, of all ways on.
   * @param {Transition} edge
   */
  visits(edge) {
    const figure = make('span', { class: 'dim' })
    this.live.push(() => {
      const share = this.told(edge.from)?.share ?? 0, visits = this.taken(edge)
      figure.textContent = share ? percent(Math.min(1, visits / share)) : 'never'
      figure.title = `of the ways on from ${edge.from}`
    })
    return figure
  }

  /** @param {Transition} edge */
  arrow(edge) {
    const { store, shell, deeds } = this, { from, to } = edge
    const words = make('p', { class: 'dim' })
    this.live.push(() => {
      const visits = this.taken(edge)
      const share = this.told(from)?.share ?? 0
      words.textContent = visits ? `${percent(visits)} of all visits, ${percent(share ? Math.min(1, visits / share) : 0)} of the ways on from ${from}` : 'never taken'
    })
    const weight = this.weight(edge)
    const bad = make('input', { type: 'checkbox', onchange: () => this.bad(edge, bad.checked) })
    bad.checked = edge.bad
    const middles = make('div', { class: 'middles' }), film = make('div', { class: 'middles' }), drawn = this.canDraw(from, to)
    if (drawn) this.middles(from, to, middles)
    const ends = (/** @type {string} */ id) => button(id, () => deeds.choose({ sheep: id }), { class: 'name serif' })
    return [
      this.whole(), make('h2', { class: 'ends' }, ends(from), ' to ', ends(to)), words, middles, film,
      make('div', { class: 'pairs' }, make('span', { class: 'dim' }, 'Weight'), weight.root),
      edge.join && make('p', { class: edge.join.worst > 1 ? 'bad' : 'dim' }, `Joins: ${[edge.join.from && `${digits(edge.join.from.db, 1)} dB as it begins`, edge.join.to && `${digits(edge.join.to.db, 1)} dB as it ends`].filter(Boolean).join(', ')}${edge.join.worst > 1 ? ': it jumps' : ''}`),
      make('p', { class: 'dim small' }, `${digits(edge.frames / store.state.fps[0] * store.state.fps[1], 1)} s, ${digits(edge.frames)} frames · ${stateOf(edge) || (edge.state === 'there' ? 'clip is there' : 'no clip')}`),
      make('label', { class: 'tick' }, bad, 'The join is bad'),
      make('div', { class: 'bar' },
        tight('Walk from here', () => shell.go('walk', { from })),
        tight('Joins', () => shell.go('walk', { show: 'joins', a: from, b: to, end: 'from' })),
        drawn && tight('Preview', () => this.moving(from, to, film), { title: 'A moving preview (V)', 'data-does': 'preview' }),
        ...edge.state === 'there' ? [] : this.renders({ from, to }),
        tight('End elsewhere', () => deeds.move(edge, 'to'), { title: 'Lead it to another sheep (M)' }),
        tight('Begin elsewhere', () => deeds.move(edge, 'from'), { title: 'Have it come from another sheep (Shift M)' }),
        tight('Unlink', () => deeds.unlink(from, to), { title: 'Take the transition away (Delete)' })),
    ]
  }

  /** @param {{sheep?: string, from?: string, to?: string}} what */
  renders(what) {
    return [tight('Render', () => this.deeds.render(what), { title: 'Render it (R)' }), tight('Render a draft', () => this.deeds.render(what, true), { title: 'Render it less sharp, and much sooner (D)' })]
  }

  /** @param {string} id */
  rename(id) {
    const name = make('input', { class: 'field', value: id, 'aria-label': 'New name', autocomplete: 'off', autofocus: true })
    const close = this.shell.over(make('form', { class: 'question', onsubmit: async (/** @type {Event} */ event) => {
      event.preventDefault()
      const to = name.value.trim()
      close()
      if (to !== id && await this.api.edit([{ do: 'rename', sheep: id, to }])) this.deeds.choose({ sheep: to })
    } }, make('h2', {}, `Rename ${id}`), make('p', { class: 'note' }, 'Its files are named anew with it.'), name,
    make('div', { class: 'bar end' }, tight('Cancel', () => close(), { type: 'button' }), button('Rename', () => {}, { class: 'strong', type: 'submit' }))), { label: 'Rename' })
    name.select()
  }

  /** The way from here to the panel of the flock. */
  whole() {
    return tight('Whole flock', () => { this.deeds.choose(null); this.root.querySelector('button')?.focus() }, { class: 'quiet tight back', title: 'What of the flock is to be balanced, suggested, rendered (Escape)' })
  }

  /** @param {Transition} edge @param {boolean} bad */
  async bad(edge, bad) {
    try {
      await this.api.post('/api/joins/bad', { from: edge.from, to: edge.to, bad })
      edge.bad = bad
      this.shell.say(bad ? `Noted that ${edge.from} to ${edge.to} joins badly` : 'Took the note away')
    } catch (error) { this.api.failed(error) }
  }

  /** Presses *Preview*; false if there is no such button. */
  preview() {
    const found = this.root.querySelector('[data-does=preview]')
    if (found instanceof HTMLElement) found.click()
    return found !== null
  }

  /**
   * What of a sheep's genome is not drawn, in words.
   * @param {Sheep} one
   */
  undrawn({ refused, without }) {
    return [refused && `Its genome cannot be drawn: ${refused}`, without && `Its genome is drawn without ${without}`].filter(Boolean)
      .map(words => make('p', { class: 'small' }, words))
  }

  /**
   * Whether a transition can be drawn: both sheep have genomes that can, of whatever species.
   * @param {string} from @param {string} to
   */
  canDraw(from, to) { return [from, to].every(id => { const one = this.store.byId.get(id); return one?.genome && !one.refused }) }

  /**
   * Puts the three middle pictures of a transition into `into`, when they are there.
   * @param {string} from
   * @param {string} to
   * @param {HTMLElement} into
   */
  async middles(from, to, into) {
    // Their places are there from the first, so that what is below does not move under the pointer.
    into.replaceChildren(...[1, 2, 3].map(() => make('span', { class: 'thumb waits' })))
    try {
      const ask = () => this.api.post('/api/previews', { from, to, kind: 'middles' })
      let told = await ask()
      if (!told.ready) {
        if (!await this.ready(told.job.id, into)) return
        told = await ask()
      }
      into.replaceChildren(...[1, 2, 3].map(at => make('img', { src: media('middle', told.key, { at: String(at) }), alt: `${from} to ${to} at ${at} quarter${at > 1 ? 's' : ''}`, decoding: 'async', class: 'thumb' })))
      if (told.figures?.flagged) into.append(make('p', { class: 'bad' }, 'dim or flat in the middle'))
    } catch (error) {
      into.replaceChildren(make('p', { class: 'note' }, `No pictures of the middle: ${why(error)}`))
    }
  }

  /**
   * Waits for a job as long as somebody looks at `at`; if nobody does any more, the job is cancelled.
   * @param {string | number} id
   * @param {HTMLElement} at
   * @returns {Promise<boolean>}
   */
  ready(id, at) {
    return new Promise((resolve, reject) => {
      const look = () => {
        const job = this.store.state.jobs.find(one => one.id === id)
        if (!at.isConnected) {
          off()
          this.api.delete(`/api/jobs/${encodeURIComponent(id)}`).catch(() => {})
          resolve(false)
        } else if (job?.state === 'done') { off(); resolve(true) }
        else if (job?.state === 'failed' || job?.state === 'cancelled') { off(); reject(new Error(job.error ?? job.state)) }
      }
      const off = this.store.on(['jobs', 'state', 'focus', 'supposed'], look)
      look()
    })
  }

  /**
   * Puts a moving preview of a transition, which need not exist, into `into`. It plays while the rest of it is drawn; if nobody looks
   * at it any more, that ends.
   * @param {string} from @param {string} to @param {HTMLElement} into
   */
  async moving(from, to, into) {
    const before = into.querySelector('video')
    if (before) return before.play().catch(() => {})
    try {
      const told = await this.api.post('/api/previews', { from, to, kind: 'moving' }), id = told.job?.id
      const video = make('video', { controls: true, loop: true, playsinline: true, class: 'wide', 'aria-label': `Preview of ${from} to ${to}` })
      const word = make('p', { class: 'note' }, 'The preview is being drawn …')
      video.muted = true
      video.autoplay = this.shell.moving()
      into.replaceChildren(video, told.ready ? '' : word)
      const whole = await watch(video, told.key, () => told.ready ? null : this.store.state.jobs.find(one => one.id === id) ?? told.job)
      if (!whole && !told.ready) await this.api.delete(`/api/jobs/${encodeURIComponent(id)}`)
      word.remove()
    } catch (error) {
      into.replaceChildren(make('p', { class: 'note' }, `No preview: ${why(error)}`))
    }
  }

  flock() {
    const { store, deeds } = this, { state } = store
    const worst = make('p', { class: 'figure', 'data-figure': 'worst_ratio' }), entropy = make('p', { class: 'figure' })
    this.live.push(() => {
      const figures = store.supposed?.figures ?? state.figures
      worst.textContent = figures.worst_ratio === null ? 'never' : times(figures.worst_ratio)
      entropy.textContent = `${digits(figures.entropy_bits, 1)} bits`
    })
    const missing = state.transitions.filter(one => one.state === 'missing').length + state.sheep.filter(one => one.state === 'missing').length
    const furthest = state.sheep.filter(one => one.wanted).sort((a, b) => Math.abs(tilt(b)) - Math.abs(tilt(a))).slice(0, 8)
    return [
      make('h2', {}, 'The flock'),
      make('div', { class: 'twice' }, make('div', {}, worst, make('p', { class: 'note' }, 'worst ratio')), make('div', {}, entropy, make('p', { class: 'note' }, 'of surprise a step'))),
      make('div', { class: 'bar' }, button('Balance', () => deeds.balance(), { class: 'strong' }), button('Suggestions', () => deeds.suggest(), { class: 'quiet' }), button('Prune', () => deeds.prune(), { class: 'quiet' }), button('Table', () => deeds.table(), { class: 'quiet' }),
        missing > 0 && button(`Render ${spoken(missing, 'clip')}`, () => deeds.render({ all_missing: true }), { class: 'quiet' })),
      make('h3', {}, 'Furthest from their wants'),
      make('ul', { class: 'links' }, ...furthest.map(one => {
        const ratio = make('span', { class: 'dim dot' })
        styled(ratio, { '--tint': tint(tilt(one)) })
        ratio.textContent = one.shown && one.ratio ? `${times(one.ratio)}×` : 'never'
        return make('li', {}, button(one.id, () => deeds.choose({ sheep: one.id }), { class: 'name' }), ratio)
      })),
      make('p', { class: 'note small' }, 'A disc is the larger the more often its sheep is shown, the dashed ring is its want. Drag a disc’s rim to another disc to link them, its middle to move it.'),
    ]
  }
}
