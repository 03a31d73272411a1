// The walk of a seed, played with the real clips, and what strikes about it: joins, what comes too often, what too soon.
//
// Owns the screen, its controls and the line of the next clips. `mse.js` plays, `loupe.js` looks at joins frame by frame,
// `ways.js` draws the small graph. Every control acts on what was on the screen when it was pressed.

import { button, icon, make, styled } from './dom.js'
import { dim, labelled, markBad, quiet, ready } from './parts.js'
import { player } from './mse.js'
import { pieceAt } from './pieces.js'
import { loupe } from './loupe.js'
import { Ways } from './ways.js'
import { media } from './session.js'
import { way } from './store.js'
import { digits, percent, short } from './words.js'

const AHEAD = 12, FIRST_STEPS = 60, MOST_CLIPS = 9000
/** Milliseconds between two looks of the counter while it plays. */
const PACE = 80
/** How much one press of "too often" takes from a want, and of "too soon" from a weight. */
const STEP = 2 ** -0.25

/** @type {MakeView} */
export function view(root, store, api, shell) {
  const tabs = ['walk', 'joins'].map(name => quiet(name === 'walk' ? 'The walk' : 'The joins', () => shell.go('walk', name === 'joins' ? { show: 'joins' } : {})))
  const rooms = [make('div', { class: 'room' }), make('div', { class: 'room' })]
  root.append(make('div', { class: 'bar tabs', role: 'group', 'aria-label': 'What is shown' }, ...tabs), ...rooms)
  const parts = [new Walk(rooms[0], store, api, shell), loupe(rooms[1], store, api, shell)]
  let at = -1
  /** @type {Key[]} */ const keys = []
  return {
    keys,
    enter(params) {
      const next = params.get('show') === 'joins' ? 1 : 0
      if (at >= 0 && at !== next) parts[at].leave()
      at = next
      rooms.forEach((room, which) => { room.hidden = which !== at })
      tabs.forEach((tab, which) => tab.setAttribute('aria-pressed', String(which === at)))
      keys.splice(0, keys.length, ...parts[at].keys)
      parts[at].enter(params)
    },
    leave() { parts[at].leave() },
  }
}

class Walk {
  /** @type {WalkClip[]} */ clips = []
  /** @type {import('./pieces.js').Piece[]} */ pieces = []
  /** @type {Map<string, WalkOften>} */ often = new Map()
  /** @type {Map<number, WalkSoon>} */ soon = new Map()
  /** @type {Set<string>} transitions whose previews were asked for */ asked = new Set()
  previewed = 0
  drawn = 0
  /** @type {import('./pieces.js').Player | null} */ player = null
  seed = ''
  from = ''
  revision = ''
  at = -1
  open = false
  asking = 0
  speeds = [1, 2, 4]
  fast = 1

  /** @param {HTMLElement} root @param {import('./store.js').Store} store @param {import('./api.js').Api} api @param {Shell} shell */
  constructor(root, store, api, shell) {
    this.store = store
    this.api = api
    this.shell = shell
    this.strips = shell.strips
    this.ways = new Ways(store)
    this.keys = this.bound()
    this.field = make('input', { class: 'field', id: 'walk-seed', inputmode: 'numeric', maxlength: 19, size: 8, autocomplete: 'off', onchange: () => this.shell.go('walk', { seed: this.field.value.replace(/\D/g, '') || '1', from: this.from }) })
    this.start = make('select', { class: 'field', id: 'walk-from', onchange: () => this.shell.go('walk', { seed: this.seed, from: this.start.value }) })
    this.rates = this.speeds.map(times => quiet(`${times}×`, () => this.speed(times), { 'aria-label': `speed ${times}` }))
    this.pace = make('span', { class: 'dim', role: 'status' })
    this.word = make('span', { class: 'corner' })
    this.card = make('div', { class: 'title-card', hidden: true })
    this.screen = make('div', { class: 'screen', onclick: () => this.toggle() }, this.word, this.card)
    this.playing = button('Play', () => this.toggle(), { icon: 'play', class: 'tool' })
    this.counter = make('output', { class: 'counter' })
    this.line = make('ol', { class: 'line', 'aria-label': 'The next clips' })
    this.head = make('i', { class: 'playhead' })
    this.now = make('div', { class: 'now' })
    this.lists = make('div', {})
    this.note = make('p', { class: 'note', hidden: true })
    this.badly = quiet('Bad join', () => this.bad())
    const tools = make('div', { class: 'bar transport' }, this.playing,
      quiet('Join before', () => this.join(-1)), quiet('−1', () => this.player?.step(-1), { 'aria-label': 'a frame back' }),
      quiet('+1', () => this.player?.step(1), { 'aria-label': 'a frame on' }), quiet('Next join', () => this.join(1)),
      this.counter, make('span', { class: 'grow' }),
      quiet('Too often', () => this.tooOften()), quiet('Too soon', () => this.tooSoon()),
      this.badly, quiet('Loupe', () => this.look()))
    const top = make('div', { class: 'bar' }, labelled('Seed', this.field), quiet('Another', () => this.another()),
      labelled('from', this.start), make('span', { class: 'grow' }), this.pace, make('span', { class: 'together' }, ...this.rates))
    root.append(make('div', { class: 'split' },
      make('div', { class: 'stage' }, top, this.screen, tools, make('div', { class: 'line-box' }, this.line), this.note),
      make('div', { class: 'panel' }, this.ways.canvas, this.now, this.lists)))
    store.on(['state'], () => { if (this.open && store.state.revision !== this.revision) this.again() })
    store.on(['sheep', 'state'], () => { if (this.open) { this.tell(); this.drawLine() } })
    store.on(['jobs'], () => { if (this.open) this.preview() })
  }

  /** @returns {Key[]} */
  bound() {
    return [
      { keys: ['Space'], does: 'play or stand still', hint: 'play', run: () => this.toggle() },
      { keys: [',', '.'], does: 'a frame back, a frame on', hint: 'frames', run: event => this.player?.step(event.key === ',' ? -1 : 1) },
      { keys: ['j', 'k'], does: 'ten frames back, ten on', hint: 'ten frames', run: event => this.player?.step(event.key === 'j' ? -10 : 10) },
      { keys: ['Shift+J', 'Shift+K'], does: 'to the join before, to the next', hint: 'joins', run: event => this.join(event.key === 'J' ? -1 : 1) },
      { keys: ['ArrowLeft', 'ArrowRight'], does: 'a clip back, a clip on', hint: 'clips', run: event => this.clip(event.key === 'ArrowLeft' ? -1 : 1) },
      { keys: ['m'], does: 'mark the nearest join as bad, or take the mark away', hint: 'bad join', run: () => this.bad() },
      { keys: ['l'], does: 'look at the nearest join frame by frame', hint: 'loupe', run: () => this.look() },
      { keys: ['o'], does: 'what is shown comes too often: want it less', hint: 'too often', run: () => this.tooOften() },
      { keys: ['s'], does: 'what is shown came too soon: take the way that led here less often', hint: 'too soon', run: () => this.tooSoon() },
      { keys: ['1', '2', '4'], does: 'speed', run: event => this.speed(Number(event.key)) },
      { keys: ['n'], does: 'another seed', run: () => this.another() },
      { keys: ['f'], does: 'from the sheep in focus', when: () => this.store.focused?.in_flock === true, run: () => this.shell.go('walk', { seed: this.seed, from: this.store.focus ?? '' }) },
    ]
  }

  /** @param {URLSearchParams} params */
  enter(params) {
    this.open = true
    const seed = params.get('seed') ?? (this.seed || String(1 + Math.floor(Math.random() * 999_999))), from = params.get('from') ?? ''
    this.offer()
    if (seed === this.seed && from === this.from && this.player) { this.ways.draw(); return }
    this.seed = seed
    this.from = from
    this.shell.note({ seed, from })
    this.field.value = seed
    this.start.value = from
    this.begin()
  }

  leave() {
    this.open = false
    this.player?.pause()
  }

  another() { this.shell.go('walk', { seed: String(1 + Math.floor(Math.random() * 999_999)), from: this.from }) }

  /** The sheep from which a walk may begin. */
  offer() {
    const ids = this.store.state.sheep.filter(one => one.shown).map(one => one.id)
    this.start.replaceChildren(make('option', { value: '' }, 'where the seed begins'), ...ids.map(id => make('option', { value: id }, id)))
    this.start.value = this.from
  }

  async begin() {
    this.player?.close()
    this.player = null
    this.at = -1
    this.pieces = []
    this.note.hidden = true
    for (const old of this.screen.querySelectorAll('video')) old.remove()
    if (!await this.fetch(FIRST_STEPS)) return
    this.player = player(this.screen, this.store.state.fps, {
      frame: (frame, piece) => this.shown(frame, piece),
      card: (piece, why) => this.carded(piece, why),
      playing: is => this.stands(!is),
      pace: times => this.paced(times),
    })
    if (!this.player.exact) this.say('This browser cannot join clips exactly: at a join, what is seen here may stand for a moment. On the wall it does not.')
    this.player.have(this.pieces)
    this.speed(1)
    if (this.shell.moving()) this.player.play()
    else { this.stands(true); this.player.seek(0) }
  }

  /**
   * The walk as the program would take it. Whether there is one.
   * @param {number} steps
   */
  async fetch(steps) {
    const asked = ++this.asking
    try {
      const told = await this.api.get(`/api/walk?${new URLSearchParams({ seed: this.seed, steps: String(steps), ...this.from ? { from: this.from } : {} })}`)
      if (asked !== this.asking) return false
      const { clips: single, too_often: often, too_soon: soon } = /** @type {WalkAnswer} */ (told)
      // A loop that is played again is one piece.
      /** @type {WalkClip[]} */ const clips = []
      const places = single.map(clip => {
        const last = clips[clips.length - 1]
        if (last && clip.kind === 'loop' && last.sheep === clip.sheep) last.frames += clip.frames
        else clips.push({ ...clip })
        return clips.length - 1
      })
      const pieces = clips.map(clip => this.piece(clip))
      const kept = this.at < 0 || pieces.length > this.at && this.pieces.slice(0, this.at + 1).every(({ start, frames }, which) => pieces[which].start === start && pieces[which].frames === frames && this.named(clips[which]) === this.named(this.clips[which]))
      if (!kept) { this.say('The flock was changed. This is the walk of the flock as it was.', true); return false }
      Object.assign(this, { clips, pieces, revision: this.store.state.revision })
      this.often = new Map(often.map(one => [one.id, one]))
      this.soon = new Map(soon.map(one => [places[one.clip], { ...one, clip: places[one.clip] }]))
      this.player?.have(pieces)
      this.tell()
      this.drawLine()
      return clips.length > 0
    } catch (error) {
      if (asked !== this.asking) return false
      this.api.failed(error)
      this.say(error instanceof Error ? `There is no walk: ${error.message}.` : '', true)
      return false
    }
  }

  /** The flock was changed while its walk is shown. */
  again() {
    this.revision = this.store.state.revision
    this.fetch(Math.max(FIRST_STEPS, this.clips.length))
  }

  /** @param {WalkClip} clip @returns {import('./pieces.js').Piece} */
  piece(clip) {
    const { start_frame: start, frames, fragments, preview } = clip
    const url = fragments ? media('fragments', fragments) : preview ? media('preview', preview) : null
    return { start, frames, url, note: `${this.named(clip)} is not rendered yet` }
  }

  /** @param {WalkClip} clip */
  named(clip) { return clip.kind === 'loop' ? clip.sheep ?? '' : `${clip.from} to ${clip.to}` }

  // What the player tells.

  /** @param {number} frame @param {number} piece */
  shown(frame, piece) {
    this.screen.dataset.frame = String(frame)
    const now = performance.now()
    if (piece === this.at && this.player?.playing() && now - this.drawn < PACE) return
    this.drawn = now
    const { frames, start } = this.pieces[piece], [num, den] = this.store.state.fps, seconds = Math.floor(frame * den / num)
    styled(this.head, { left: `${100 * (frame - start + 0.5) / frames}%` })
    this.counter.textContent = `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, '0')} · frame ${frame - start + 1} of ${frames}`
    const data = this.screen.dataset
    if (piece === this.at) return
    ready(this.screen)
    this.at = piece
    data.clip = String(piece)
    for (const [name, value] of Object.entries(this.player?.counted() ?? {})) data[name] = String(value)
    if (piece > this.pieces.length - 2 * AHEAD && this.pieces.length < MOST_CLIPS) this.fetch(2 * this.clips.length)
    const clip = this.clips[piece]
    this.word.textContent = clip.fragments || !clip.preview ? '' : 'preview'
    if (clip.kind === 'loop') this.store.look(clip.sheep ?? null)
    this.tell()
    this.drawLine()
    this.preview()
  }

  /** @param {number | null} piece @param {string} why */
  carded(piece, why) {
    this.card.hidden = piece === null
    if (piece === null) return
    const clip = this.clips[piece]
    this.card.replaceChildren(make('p', { class: 'serif' }, clip.kind === 'loop' ? clip.sheep : `${clip.from} → ${clip.to}`), make('p', {}, why))
  }

  /** @param {boolean} still */
  stands(still) {
    this.playing.replaceChildren(icon(still ? 'play' : 'still'))
    this.playing.title = still ? 'Play' : 'Stand still'
    this.playing.setAttribute('aria-label', this.playing.title)
    this.screen.dataset.playing = String(!still)
  }

  /** @param {number} times */
  paced(times) {
    this.pace.textContent = times < this.fast ? `${digits(times, 1)}×: this computer decodes no faster` : ''
  }

  // What the artist does.

  toggle() {
    if (this.player?.playing()) this.player.pause()
    else this.player?.play()
  }

  /** @param {number} times */
  speed(times) {
    this.fast = times
    this.rates.forEach((rate, which) => rate.setAttribute('aria-pressed', String(this.speeds[which] === times)))
    this.player?.speed(times)
  }

  /** @param {number} by */
  clip(by) {
    const to = this.pieces[this.at + by]
    if (to) this.player?.seek(to.start)
  }

  /**
   * To a join, a second before it while it plays, else to the first frame after it.
   * @param {number} by
   */
  join(by) {
    const frame = this.player?.at() ?? 0, [num, den] = this.store.state.fps, before = this.player?.playing() ? Math.round(num / den) : 0
    const joins = this.pieces.slice(1).map(({ start }) => Math.max(0, start - before))
    const to = by > 0 ? joins.find(join => join > frame + 2) : joins.filter(join => join < frame - 2 - before).pop()
    this.player?.seek(to ?? (by > 0 ? frame : 0))
  }

  /** The transition whose join is nearest to what is shown. */
  nearest() {
    const frame = this.player?.at() ?? 0, at = pieceAt(this.pieces, frame)
    const { start, frames } = this.pieces[at] ?? { start: 0, frames: 0 }
    const next = at === 0 || frame - start > frames / 2
    const clip = this.clips[at], other = this.clips[next ? at + 1 : at - 1] ?? this.clips[at + 1]
    const moved = clip?.kind === 'transition' ? clip : other
    if (!clip || !moved || moved.kind !== 'transition') return null
    // A transition that is shown has two: the one at its nearer end is meant.
    const enters = clip.kind === 'transition' ? !next : next
    return { from: moved.from ?? '', to: moved.to ?? '', end: enters ? 'from' : 'to' }
  }

  bad() {
    const join = this.nearest()
    if (join) markBad(this.store.byWay.get(way(join.from, join.to)), this.store, this.api)
  }

  look() {
    const join = this.nearest()
    if (join) this.shell.go('walk', { show: 'joins', a: join.from, b: join.to, end: join.end })
  }

  /** The sheep that is shown; in a transition the one at the nearer end. */
  seen() {
    const frame = this.player?.at() ?? 0, at = pieceAt(this.pieces, frame), clip = this.clips[at], piece = this.pieces[at]
    if (!clip) return ''
    return (clip.kind === 'loop' ? clip.sheep : frame - piece.start < piece.frames / 2 ? clip.from : clip.to) ?? ''
  }

  async tooOften() {
    const one = this.store.byId.get(this.seen())
    if (one) await this.api.edit([{ do: 'want', sheep: one.id, value: Number((one.want * STEP).toPrecision(3)) }])
  }

  async tooSoon() {
    const at = pieceAt(this.pieces, this.player?.at() ?? 0)
    const clip = this.clips[at]?.kind === 'transition' ? this.clips[at] : this.clips[at - 1]
    const one = clip && this.store.byWay.get(way(clip.from ?? '', clip.to ?? ''))
    if (one) await this.api.edit([{ do: 'weight', from: one.from, to: one.to, value: Number((one.weight * STEP * STEP).toPrecision(3)) }])
    else this.shell.say('Nothing led here: the walk begins with this sheep', true)
  }

  // What is drawn.

  /** @param {string} text @param {boolean} [again] */
  say(text, again = false) {
    ready(this.screen)
    this.note.hidden = !text
    this.note.replaceChildren(text, again ? ' ' : '', again ? quiet('Walk again', () => { this.seed && this.begin() }) : '')
  }

  drawLine() {
    const from = Math.max(0, this.at)
    for (const canvas of this.line.querySelectorAll('canvas')) this.strips.forget(canvas)
    this.line.replaceChildren(...this.clips.slice(from, from + AHEAD + 1).map((clip, which) => this.block(clip, from + which)))
  }

  /** Asks for previews of what comes next and is not rendered, and takes in those that are ready. */
  preview() {
    const ready = this.store.state.jobs.filter(job => job.kind === 'moving' && job.state === 'done').length
    if (ready > this.previewed) this.fetch(this.clips.length)
    this.previewed = ready
    const due = this.clips.slice(Math.max(0, this.at), this.at + AHEAD).filter(({ kind, fragments, preview }) => kind === 'transition' && !fragments && !preview)
    for (const { from = '', to = '' } of due.slice(0, 2)) {
      if (this.asked.has(way(from, to))) continue
      this.asked.add(way(from, to))
      this.api.post('/api/previews', { from, to, kind: 'moving' }).then(told => { if (told?.ready) this.fetch(this.clips.length) }, error => this.api.failed(error))
    }
  }

  /** @param {WalkClip} clip @param {number} which */
  block(clip, which) {
    const [num, den] = this.store.state.fps, seconds = `${Math.round(clip.frames * den / num)} s`
    const soon = this.soon.get(which), often = clip.kind === 'loop' && this.often.get(clip.sheep ?? '')
    const one = clip.kind === 'loop' ? this.store.byId.get(clip.sheep ?? '') : undefined
    const told = [this.named(clip), seconds, clip.fragments ? '' : clip.preview ? 'preview' : 'not rendered', soon && `too soon: again after ${Math.round(soon.after_s)} s`, often && 'too often'].filter(Boolean).join(', ')
    const picture = one && make('span', { class: 'thumb' }, make('canvas', {}))
    const go = make('button', { type: 'button', 'aria-label': told, title: told, onclick: () => this.player?.seek(clip.start_frame) },
      picture, make('span', { class: 'called' }, clip.kind === 'loop' ? short(clip.sheep ?? '') : '→'), dim(clip.kind === 'loop' ? seconds : ''),
      soon && make('em', {}, 'too soon'), often && make('em', {}, 'too often'))
    const canvas = picture?.querySelector('canvas')
    if (canvas && one) this.strips.show(canvas, one)
    const block = make('li', { class: `${clip.kind} ${clip.fragments ? '' : 'missing'} ${which === this.at ? 'current' : ''}` }, which === this.at && this.head, this.joinMark(which), go)
    styled(block, { 'flex-grow': clip.frames })
    return block
  }

  /**
   * The join before a clip, with its figure.
   * @param {number} which
   */
  joinMark(which) {
    const clip = this.clips[which], moved = clip.kind === 'transition' ? clip : this.clips[which - 1]
    if (which === 0 || moved?.kind !== 'transition' || which === Math.max(0, this.at)) return null
    const one = this.store.byWay.get(way(moved.from ?? '', moved.to ?? ''))
    const end = one?.join?.[clip.kind === 'transition' ? 'from' : 'to']
    if (!one) return null
    const text = end ? Number.isFinite(end.db) ? `${Math.round(end.db)} dB` : 'exact' : ''
    return make('span', { class: `join ${one.bad ? 'marked' : ''} ${Number(one.join?.worst) > 1 ? 'jumps' : ''}`, title: [`the join of ${one.from} to ${one.to}`, text, one.bad ? 'marked as bad' : ''].filter(Boolean).join(', ') }, one.bad ? '✕' : text)
  }

  tell() {
    const clip = this.clips[Math.max(0, this.at)]
    if (!clip) return
    const one = this.store.byId.get((clip.kind === 'loop' ? clip.sheep : clip.to) ?? '')
    this.now.replaceChildren(make('h2', {}, clip.kind === 'loop' ? clip.sheep : `${clip.from} → ${clip.to}`),
      make('p', { class: 'note' }, one ? `${clip.kind === 'loop' ? '' : `${one.id}: `}shown ${percent(one.share)} of the ${this.store.state.by === 'time' ? 'time' : 'visits'}, wanted ${percent(one.wanted)}` : ''))
    this.ways.at(clip.kind === 'loop' ? clip.sheep ?? '' : clip.from ?? '', clip.kind === 'loop' ? '' : clip.to ?? '')
    const near = this.nearest(), bad = near && this.store.byWay.get(way(near.from, near.to))?.bad
    this.badly.setAttribute('aria-pressed', String(Boolean(bad)))
    this.lists.replaceChildren(...this.struck('Too often in this walk', [...this.often.values()].map(often => ({ id: often.id, text: `${percent(often.share)} of ${percent(often.wanted)}`, clip: this.clips.findIndex(({ kind, sheep }) => kind === 'loop' && sheep === often.id) }))),
      ...this.struck('Too soon again', [...this.soon.values()].map(soon => ({ id: soon.id, text: `after ${Math.round(soon.after_s)} s`, clip: soon.clip }))))
  }

  /** @param {string} title @param {{id: string, text: string, clip: number}[]} all */
  struck(title, all) {
    if (!all.length) return []
    const go = (/** @type {number} */ clip) => { const piece = this.pieces[clip]; if (piece) this.player?.seek(piece.start) }
    return [make('h3', {}, title), make('ul', { class: 'rows' }, ...all.slice(0, 8).map(({ id, text, clip }) =>
      make('li', {}, make('button', { type: 'button', class: 'row', onclick: () => go(clip) }, make('span', {}, short(id)), dim(text)))))]
  }
}
