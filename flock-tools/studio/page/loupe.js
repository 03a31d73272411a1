// Joins, frame by frame, as the wall shows them.
//
// One decoder takes the packets of both clips in a row, as the player does. Owns the frames around a join; the functions
// above `loupe` need no page: a test asks them for hashes and compares these with ffmpeg's.
//
// Start at [`decoded`] and [`loupe`].

import { make, styled } from './dom.js'
import { dim, markBad, quiet, ready } from './parts.js'
import { media } from './session.js'
import { way } from './store.js'
import { short } from './words.js'

/** WebCodecs, for which this TypeScript has no words. */
const { VideoDecoder, VideoFrame, EncodedVideoChunk } = /** @type {any} */ (globalThis)

/** @typedef {{head: PacketsHead, data: Uint8Array}} Packets */
/** @typedef {{clip: number, frame: number, width: number, height: number, data: Uint8Array, colours: any}} Picture I420 planes, one after the other */

export const able = () => Boolean(VideoDecoder && globalThis.isSecureContext)

/**
 * The packets that the frames `from` to `to` of a clip need, all of them unless these are given.
 * @param {string} key
 * @param {number} [from]
 * @param {number} [to]
 * @returns {Promise<Packets>}
 */
export async function packets(key, from = 0, to = 2 ** 32 - 1) {
  const answer = await fetch(media('packets', key, { from: String(from), to: String(to) }))
  if (!answer.ok) throw new Error(`the clip cannot be read: the studio answers ${answer.status}`)
  const bytes = new Uint8Array(await answer.arrayBuffer())
  const long = new DataView(bytes.buffer).getUint32(0, true)
  return { head: JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + long))), data: bytes.subarray(4 + long) }
}

/**
 * Decodes clips in a row with one decoder that is not emptied between them. `each` gets every frame in the order in which
 * it is shown, and is waited for.
 * @param {Packets[]} clips
 * @param {(picture: Picture) => void | Promise<void>} each
 */
export async function decoded(clips, each) {
  let work = Promise.resolve(), failed = /** @type {unknown} */ (null), waiting = 0
  const decoder = new VideoDecoder({ output: (/** @type {any} */ frame) => { waiting++; work = work.then(() => take(frame)) }, error: (/** @type {unknown} */ error) => { failed = error } })
  const [num, den] = clips[0].head.rate
  const bases = clips.map((_, at) => clips.slice(0, at).reduce((sum, { head }) => sum + head.frames, 0))
  const take = async (/** @type {any} */ frame) => {
    const running = Math.round(frame.timestamp * num / (den * 1e6))
    let clip = clips.length - 1
    while (clip && bases[clip] > running) clip--
    try {
      await each({ clip, frame: running - bases[clip], width: frame.visibleRect.width, height: frame.visibleRect.height, colours: frame.colorSpace.toJSON(), data: await i420(frame) })
    } catch (error) { failed ??= error } finally {
      frame.close()
      waiting--
    }
  }
  try {
    for (const [at, { head, data }] of clips.entries()) {
      if (at === 0 || head.description !== clips[at - 1].head.description) {
        if (at) await decoder.flush()
        decoder.configure({ codec: head.codec, description: Uint8Array.from(atob(head.description), letter => letter.charCodeAt(0)), hardwareAcceleration: 'prefer-software' })
      }
      let place = 0
      for (const { pts, key, bytes } of head.packets) {
        while (decoder.decodeQueueSize + waiting > 24 && !failed) await new Promise(done => setTimeout(done, 1))
        if (failed) throw failed
        decoder.decode(new EncodedVideoChunk({ type: key ? 'key' : 'delta', timestamp: Math.round((bases[at] + pts) * den * 1e6 / num), data: data.subarray(place, place + bytes) }))
        place += bytes
      }
    }
    await decoder.flush()
    await work
    if (failed) throw failed
  } finally {
    if (decoder.state !== 'closed') decoder.close()
  }
}

/** @param {any} frame @returns {Promise<Uint8Array>} */
async function i420(frame) {
  const data = new Uint8Array(frame.allocationSize())
  await frame.copyTo(data)
  if (frame.format === 'I420') return data
  if (frame.format !== 'NV12') throw new Error(`this browser decodes to \`${frame.format}\`, not to I420`)
  const luma = frame.visibleRect.width * frame.visibleRect.height, chroma = (data.length - luma) / 2, planes = new Uint8Array(data.length)
  planes.set(data.subarray(0, luma))
  for (let at = 0; at < chroma; at++) {
    planes[luma + at] = data[luma + 2 * at]
    planes[luma + chroma + at] = data[luma + 2 * at + 1]
  }
  return planes
}

/**
 * The SHA-1 of every frame of clips that are decoded in a row: what `ffmpeg -f framehash -hash sha160` says of each clip.
 * @param {string[]} keys
 * @returns {Promise<{clip: number, frame: number, sha1: string}[]>}
 */
export async function hashes(keys) {
  /** @type {{clip: number, frame: number, sha1: string}[]} */ const found = []
  await decoded(await Promise.all(keys.map(key => packets(key))), async ({ clip, frame, data }) => {
    const hash = new Uint8Array(await crypto.subtle.digest('SHA-1', data))
    found.push({ clip, frame, sha1: [...hash].map(byte => byte.toString(16).padStart(2, '0')).join('') })
  })
  return found
}

/**
 * How much of two pictures differs, eight times as bright, in grey.
 * @param {Picture} a @param {Picture} b
 */
export function difference(a, b) {
  const grey = new ImageData(a.width, a.height), pixels = new Uint32Array(grey.data.buffer)
  for (let at = 0; at < pixels.length; at++) {
    const by = Math.min(255, 8 * Math.abs(a.data[at] - b.data[at]))
    pixels[at] = 0xff000000 | by << 16 | by << 8 | by
  }
  return grey
}

const AROUND = 24, MOST_BYTES = 160 << 20

/**
 * @param {HTMLElement} root @param {import('./store.js').Store} store @param {import('./api.js').Api} api @param {Shell} shell
 * @returns {View}
 */
export function loupe(root, store, api, shell) {
  return new Loupe(root, store, api, shell)
}

class Loupe {
  /** @type {Join[]} */ all = []
  /** @type {Join[]} */ joins = []
  /** @type {Picture[]} */ pictures = []
  /** The number in `pictures` of the first frame after the join. */
  middle = 0
  at = 0
  chosen = -1
  loading = 0
  open = false
  running = false
  differs = false
  pace = 1
  zoom = 1
  last = 0

  /** @param {HTMLElement} root @param {import('./store.js').Store} store @param {import('./api.js').Api} api @param {Shell} shell */
  constructor(root, store, api, shell) {
    this.store = store
    this.api = api
    this.shell = shell
    this.keys = this.bound()
    this.canvas = make('canvas', { class: 'frame', role: 'img', 'aria-label': 'no frame' })
    this.card = make('div', { class: 'title-card' })
    this.screen = make('div', { class: 'screen', onpointermove: (/** @type {PointerEvent} */ event) => this.aim(event) }, this.canvas, this.card)
    this.heading = make('h2', {})
    this.judge = quiet('Judge them all', () => this.judgeAll())
    this.where = make('output', { class: 'counter' })
    this.track = make('input', { type: 'range', min: 0, max: 1, value: 0, class: 'grow', 'aria-label': 'frame', oninput: () => this.show(Number(this.track.value)) })
    this.paces = [1, 2, 4].map(pace => quiet(pace === 1 ? 'at pace' : `1/${pace}`, () => this.paced(pace)))
    this.runs = quiet('Play', () => this.play(!this.running))
    this.diff = quiet('Difference', () => this.differ(), { 'aria-pressed': 'false' })
    this.badly = quiet('Bad join', () => markBad(this.moved(this.joins[this.chosen]), this.store, this.api))
    this.which = make('select', { class: 'field', 'aria-label': 'which joins', onchange: () => this.list() },
      ...[['all', 'All, the worst first'], ['jumps', 'Those that jump'], ['bad', 'Those marked as bad']].map(([value, text]) => make('option', { value }, text)))
    this.rows = make('ol', { class: 'rows joins' })
    this.note = make('p', { class: 'note' })
    root.append(make('div', { class: 'split' },
      make('div', { class: 'stage' }, this.screen, make('div', { class: 'bar' }, this.track, this.where),
        make('div', { class: 'bar transport' }, this.runs, ...this.paces, quiet('−1', () => this.step(-1), { 'aria-label': 'a frame back' }), quiet('+1', () => this.step(1), { 'aria-label': 'a frame on' }),
          quiet('Flip', () => this.flip()), this.diff, quiet('Larger', () => this.enlarge(this.zoom >= 8 ? 1 / 8 : 2)), make('span', { class: 'grow' }), this.badly),
        this.heading, this.note),
      make('div', { class: 'panel' }, make('div', { class: 'bar' }, this.which, this.judge), this.rows)))
    this.paced(1)
    store.on(['state'], () => { if (this.open) this.fetch() })
    store.on(['sheep'], () => { if (this.open) this.list() })
  }

  /** @returns {Key[]} */
  bound() {
    return [
      { keys: [',', '.'], does: 'a frame back, a frame on', hint: 'frames', run: event => this.step(event.key === ',' ? -1 : 1) },
      { keys: ['j', 'k'], does: 'ten frames back, ten on', hint: 'ten frames', run: event => this.step(event.key === 'j' ? -10 : 10) },
      { keys: ['Space'], does: 'play over the join, again and again', hint: 'play', run: () => this.play(!this.running) },
      { keys: ['1', '2', '4'], does: 'at pace, at half of it, at a quarter', run: event => this.paced(Number(event.key)) },
      { keys: ['b'], does: 'between the last frame before the join and the first after it', hint: 'flip', run: () => this.flip() },
      { keys: ['d'], does: 'what differs from the frame before', hint: 'difference', run: () => this.differ() },
      { keys: ['+', '-'], does: 'larger, smaller', run: event => this.enlarge(event.key === '+' ? 2 : 0.5) },
      { keys: ['ArrowUp', 'ArrowDown'], does: 'another join', hint: 'joins', run: event => this.choose(Math.max(0, Math.min(this.joins.length - 1, this.chosen + (event.key === 'ArrowUp' ? -1 : 1)))) },
      { keys: ['m'], does: 'mark the join as bad, or take the mark away', hint: 'bad join', run: () => markBad(this.moved(this.joins[this.chosen]), this.store, this.api) },
    ]
  }

  /** @param {URLSearchParams} params */
  async enter(params) {
    this.open = true
    if (!able()) this.say('This browser cannot show single frames exactly: it has no WebCodecs. The figures of the joins are right all the same.')
    const a = params.get('a'), b = params.get('b'), end = params.get('end')
    await this.fetch()
    if (a !== null && b !== null) {
      const at = this.joins.findIndex(({ from, to }) => { const moved = end === 'to' ? from : to; return moved.kind === 'transition' && moved.from === a && moved.to === b })
      if (at >= 0) return this.choose(at)
    }
    if (this.chosen < 0 && this.joins.length) this.choose(0)
  }

  leave() {
    this.open = false
    this.play(false)
  }

  async fetch() {
    try {
      const { joins } = /** @type {{joins: Join[]}} */ (await this.api.get('/api/joins'))
      const judged = new Set(joins.map(join => this.title(join)))
      this.all = [...joins, ...this.others().filter(join => !judged.has(this.title(join)))]
      this.judge.hidden = judged.size === this.all.length
      this.list()
    } catch (error) { this.api.failed(error) }
  }

  /** @param {string} text */
  say(text) {
    this.note.textContent = text
    ready(this.screen)
    this.card.hidden = this.pictures.length > 0
    this.card.textContent = text
  }

  /** @param {JoinEnd} end */
  named(end) { return end.kind === 'loop' ? short(end.sheep ?? '') : `${short(end.from ?? '')} → ${short(end.to ?? '')}` }

  /** @param {Join} join */
  title({ from, to }) { return `${this.named(from)}  |  ${this.named(to)}` }

  /** All joins of the flock with both clips there, as if none was judged. */
  others() {
    return this.store.state.transitions.flatMap(one => {
      const [a, b] = [one.from, one.to].map(id => this.store.byId.get(id))
      if (!a || !b) return []
      const end = (/** @type {Sheep} */ { id, frames, fragments }) => ({ kind: /** @type {const} */ ('loop'), sheep: id, frames, fragments: fragments ?? null })
      const moved = { kind: /** @type {const} */ ('transition'), from: one.from, to: one.to, frames: one.frames, fragments: one.fragments }
      return [{ from: end(a), to: moved, severity: null, db: null }, { from: moved, to: end(b), severity: null, db: null }].filter(({ from, to }) => from.fragments && to.fragments)
    })
  }

  async judgeAll() {
    try {
      this.store.job((await this.api.post('/api/ship/check', { joins: true })).job)
      this.shell.say('All joins are being judged')
    } catch (error) { this.api.failed(error) }
  }

  /**
   * The transition of a join, as the store has it.
   * @param {Join | undefined} join
   */
  moved(join) {
    const end = join?.to.kind === 'transition' ? join.to : join?.from
    return end?.kind === 'transition' ? this.store.byWay.get(way(end.from ?? '', end.to ?? '')) : undefined
  }

  list() {
    const before = this.joins[this.chosen], which = this.which.value
    this.joins = this.all.filter(join => which === 'all' || (which === 'jumps' ? (join.severity ?? 0) > 1 : this.moved(join)?.bad))
    if (before) this.chosen = this.joins.findIndex(join => this.title(join) === this.title(before))
    this.rows.replaceChildren(...this.joins.slice(0, 400).map((join, at) => {
      const severity = join.severity ?? 0, part = join.severity === null ? 'not judged' : `${Math.round(100 * severity)}\u00a0%`, bad = this.moved(join)?.bad, bar = make('i', { class: severity > 1 ? 'jumps' : '' })
      styled(bar, { width: `${Math.min(100, 50 * severity)}%` })
      return make('li', {}, make('button', { type: 'button', class: 'join-row', 'aria-current': at === this.chosen ? 'true' : null, onclick: () => this.choose(at) },
        make('span', {}, `${this.named(join.from)} | ${this.named(join.to)}`), dim(bad ? 'bad · ' : '', part), join.severity !== null && make('span', { class: 'meter' }, bar)))
    }))
    if (!this.all.length) this.say('No clips that join are rendered yet.')
    if (!this.joins.length) this.rows.append(make('li', { class: 'dim' }, which === 'all' ? 'Nothing is rendered yet.' : 'None.'))
    this.badly.setAttribute('aria-pressed', String(Boolean(this.moved(this.joins[this.chosen])?.bad)))
  }

  /** @param {number} which */
  async choose(which) {
    const join = this.joins[which], asked = ++this.loading
    if (!join) return
    this.chosen = which
    this.play(false)
    this.list()
    this.rows.children[which]?.scrollIntoView({ block: 'nearest' })
    this.heading.textContent = this.title(join)
    this.say(join.severity === null ? 'Not judged yet.' : `${join.severity > 1 ? 'Jumps' : 'Meets'}: ${Math.round(100 * join.severity)} % of what is allowed${join.db === null ? '' : `, ${Math.round(join.db)} dB`}${join.why ? `: ${join.why}` : ''}`)
    this.pictures = []
    if (!able()) return
    this.card.hidden = false
    this.card.textContent = 'Decoding …'
    if (!join.from.fragments || !join.to.fragments) { this.blank(); return this.say(`${this.named(join.from.fragments ? join.to : join.from)} is not rendered yet.`) }
    try {
      const [width, height] = this.store.state.size, around = Math.max(4, Math.min(AROUND, Math.floor(MOST_BYTES / (3 * width * height))))
      const [a, b] = await Promise.all([packets(join.from.fragments, Math.max(0, join.from.frames - around), join.from.frames), packets(join.to.fragments, 0, around)])
      /** @type {Picture[]} */ const pictures = []
      await decoded([a, b], picture => {
        if (picture.clip === 0 ? picture.frame >= a.head.frames - around : picture.frame < around) pictures.push(picture)
      })
      if (asked !== this.loading) return
      this.pictures = pictures
      this.card.hidden = true
      this.middle = Math.max(1, pictures.findIndex(({ clip }) => clip === 1))
      this.track.max = String(pictures.length - 1)
      this.show(this.middle - 1)
      if (this.shell.moving()) this.play(true)
    } catch (error) {
      if (asked === this.loading) this.say(error instanceof Error ? error.message : String(error))
    }
  }

  blank() {
    this.canvas.getContext('2d')?.clearRect(0, 0, this.canvas.width, this.canvas.height)
    this.where.textContent = ''
  }

  /** @param {number} at */
  show(at) {
    const shown = this.pictures[at], pen = this.canvas.getContext('2d', { alpha: false })
    if (!shown || !pen) return
    this.at = at
    const { width, height, data, clip, frame, colours } = shown
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height })
    if (this.differs && at > 0) pen.putImageData(difference(this.pictures[at - 1], shown), 0, 0)
    else {
      const picture = new VideoFrame(data, { format: 'I420', codedWidth: width, codedHeight: height, timestamp: 0, colorSpace: colours })
      pen.drawImage(picture, 0, 0)
      picture.close()
    }
    this.track.value = String(at)
    const join = this.joins[this.chosen], end = clip ? join?.to : join?.from
    this.where.textContent = `${at - this.middle < 0 ? '−' : '+'}${at < this.middle ? this.middle - at : at - this.middle + 1} · ${end ? this.named(end) : ''} ${frame + 1}`
    this.canvas.setAttribute('aria-label', `frame ${frame + 1} of ${end ? this.named(end) : ''}${this.differs ? ', difference from the one before' : ''}`)
    Object.assign(this.screen.dataset, { clip: String(clip), frame: String(frame) })
    this.screen.classList.toggle('after', clip === 1)
  }

  /** @param {number} by */
  step(by) {
    this.play(false)
    this.show(Math.max(0, Math.min(this.pictures.length - 1, this.at + by)))
  }

  flip() {
    this.play(false)
    this.show(this.at === this.middle ? this.middle - 1 : this.middle)
  }

  differ() {
    this.differs = !this.differs
    this.diff.setAttribute('aria-pressed', String(this.differs))
    this.show(this.at)
  }

  /** @param {number} by */
  enlarge(by) {
    this.zoom = Math.max(1, Math.min(8, this.zoom * by))
    styled(this.canvas, { transform: this.zoom > 1 ? `scale(${this.zoom})` : null })
    this.canvas.classList.toggle('coarse', this.zoom > 2)
  }

  /**
   * What is under the pointer stays there while the picture grows.
   * @param {PointerEvent} event
   */
  aim(event) {
    const box = this.screen.getBoundingClientRect()
    styled(this.canvas, { 'transform-origin': `${100 * (event.clientX - box.left) / box.width}% ${100 * (event.clientY - box.top) / box.height}%` })
  }

  /** @param {number} pace */
  paced(pace) {
    this.pace = pace
    this.paces.forEach((one, which) => one.setAttribute('aria-pressed', String([1, 2, 4][which] === pace)))
  }

  /** @param {boolean} on */
  play(on) {
    const began = on && !this.running
    this.running = on && this.pictures.length > 1
    this.runs.textContent = this.running ? 'Stand still' : 'Play'
    if (began && this.running) requestAnimationFrame(now => { this.last = now; requestAnimationFrame(this.tick) })
  }

  tick = (/** @type {number} */ now) => {
    if (!this.running) return
    requestAnimationFrame(this.tick)
    const [num, den] = this.store.state.fps, hold = 1000 * den / num * this.pace, due = Math.floor((now - this.last) / hold)
    if (due < 1) return
    this.last += due * hold
    // After the last frame the first again: whoever looks for a jump wants to see it many times.
    this.show((this.at + due) % this.pictures.length)
  }
}
