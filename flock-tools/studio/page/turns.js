// Two videos that take turns, for browsers without a source buffer: at a join the picture may stand for a moment.
//
// Start at [`Turns`].

import { endOf, pieceAt } from './pieces.js'

/** @typedef {import('./pieces.js').Piece} Piece */
/** @typedef {import('./pieces.js').Told} Told */

export class Turns {
  exact = false
  /** @type {Piece[]} */ #pieces = []
  #frame = 0
  #wants = false
  #closed = false
  #loaded = ['', '']
  #turn = 0
  #last = 0

  /** @param {HTMLVideoElement[]} videos @param {[number, number]} fps @param {Told} told */
  constructor(videos, [num, den], told) {
    this.rate = num / den
    this.told = told
    this.videos = videos
    for (const one of this.videos) one.addEventListener('ended', () => { if (one === this.videos[this.#turn]) this.#next() })
    requestAnimationFrame(this.#tick)
  }

  /** @param {Piece[]} pieces */
  have(pieces) {
    const first = !this.#pieces.length
    this.#pieces = pieces
    if (first && pieces.length) this.seek(0)
  }

  play() {
    this.#wants = true
    this.#last = performance.now()
    this.videos[this.#turn].play().catch(() => {})
    this.told.playing(true)
  }

  pause() {
    this.#wants = false
    this.videos[this.#turn].pause()
    this.told.playing(false)
  }

  playing() { return this.#wants }
  at() { return this.#frame }
  /** @param {number} by */
  step(by) { this.pause(); this.seek(this.#frame + by) }
  /** @param {number} times */
  speed(times) { for (const one of this.videos) one.defaultPlaybackRate = one.playbackRate = times }
  counted() { return { ranges: 1, stalls: 0, dropped: 0, shown: 0, appended: 0 } }

  /** @param {number} to */
  seek(to) {
    this.#frame = Math.max(0, Math.min(endOf(this.#pieces) - 1, Math.round(to)))
    const at = pieceAt(this.#pieces, this.#frame), piece = this.#pieces[at]
    this.told.card(piece.url ? null : at, piece.note ?? '')
    this.told.frame(this.#frame, at)
    if (!piece.url) return
    this.#load(this.#turn, piece.url)
    const shown = this.videos[this.#turn], into = (this.#frame - piece.start + 0.5) / this.rate
    const place = () => { shown.currentTime = Number.isFinite(shown.duration) ? into % shown.duration : into }
    if (shown.readyState) place()
    else shown.addEventListener('loadedmetadata', place, { once: true })
    this.#show()
  }

  close() {
    this.#closed = true
    for (const one of this.videos) { one.removeAttribute('src'); one.load() }
  }

  /** @param {number} which @param {string} url */
  #load(which, url) {
    if (this.#loaded[which] === url) return
    this.#loaded[which] = url
    this.videos[which].src = url
  }

  #show() {
    this.videos.forEach((one, which) => { one.hidden = which !== this.#turn })
    if (this.#wants) this.videos[this.#turn].play().catch(() => {})
    const next = this.#pieces[pieceAt(this.#pieces, this.#frame) + 1]
    if (next?.url) this.#load(1 - this.#turn, next.url)
  }

  /** Frames of the video that is shown, once through. */
  #whole() { return Math.max(1, Math.round(this.videos[this.#turn].duration * this.rate)) || 1 }

  #next() {
    const at = pieceAt(this.#pieces, this.#frame), piece = this.#pieces[at], shown = this.videos[this.#turn], whole = this.#whole()
    const played = Math.floor((this.#frame - piece.start) / whole + 1) * whole
    if (played >= piece.frames) return this.#leave(at)
    this.#frame = piece.start + played
    shown.currentTime = 0
    shown.play().catch(() => {})
  }

  /** @param {number} at the piece that was shown */
  #leave(at) {
    if (at + 1 >= this.#pieces.length) return this.pause()
    this.#turn = 1 - this.#turn
    this.seek(this.#pieces[at + 1].start)
  }

  #tick = (/** @type {number} */ now) => {
    if (this.#closed) return
    requestAnimationFrame(this.#tick)
    const at = pieceAt(this.#pieces, this.#frame), piece = this.#pieces[at], { currentTime, playbackRate } = this.videos[this.#turn]
    const by = piece?.url ? Math.floor(currentTime * this.rate) - (this.#frame - piece.start) % this.#whole() : Math.floor((now - this.#last) / 1000 * this.rate * playbackRate)
    if (!this.#wants || !piece) this.#last = now
    else if (by > 0) {
      this.#last = now
      this.#frame = Math.min(piece.start + piece.frames, this.#frame + by)
      // A card ends by the clock, a video tells its end itself.
      if (this.#frame === piece.start + piece.frames) piece.url ? this.#frame-- : this.#leave(at)
      this.told.frame(this.#frame, pieceAt(this.#pieces, this.#frame))
    }
  }
}
