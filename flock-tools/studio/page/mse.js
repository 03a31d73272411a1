// Plays clips after each other without a gap, each at its frame.
//
// Knows the fragments of a clip and where each clip begins, counted in frames. Never knows what a sheep is.
// `player()` chooses: one source buffer where the browser has it, else two videos that take turns.

import { read } from './fragments.js'
import { endOf, pieceAt, video } from './pieces.js'
import { media } from './session.js'
import { Turns } from './turns.js'

/** @typedef {import('./pieces.js').Piece} Piece */
/** @typedef {import('./pieces.js').Told} Told */
/** @typedef {import('./fragments.js').File} File */
/** @typedef {import('./fragments.js').Part} Part */

const AHEAD_S = 30, BEHIND_S = 10, KEPT_BYTES = 96 << 20
/** Milliseconds after another pace in which waiting is no stall. */
const PACING_MS = 500

/**
 * @param {HTMLElement} stage where the videos are put
 * @param {[number, number]} fps
 * @param {Told} told
 * @param {boolean} [plain] take the two videos, whatever the browser can
 * @returns {import('./pieces.js').Player}
 */
export function player(stage, fps, told, plain = false) {
  const able = !plain && 'MediaSource' in globalThis && 'requestVideoFrameCallback' in HTMLVideoElement.prototype
  return able ? new Gapless(video(stage), fps, told) : new Turns([video(stage), video(stage)], fps, told)
}

/**
 * Plays one clip again and again without a gap.
 * @param {HTMLVideoElement} video
 * @param {string} key
 * @param {[number, number]} fps
 * @returns {() => void} what ends it
 */
export function loopOf(video, key, fps) {
  const url = media('fragments', key)
  if (!('MediaSource' in globalThis && 'requestVideoFrameCallback' in video)) {
    Object.assign(video, { src: url, loop: true, muted: true })
    video.play().catch(() => {})
    return () => { video.removeAttribute('src'); video.load() }
  }
  video.muted = true
  const one = new Gapless(video, fps, { frame() {}, card() {}, playing() {} })
  one.have([{ start: 0, frames: 1e8, url }])
  one.play()
  return () => one.close()
}

/** One source buffer; every fragment at an offset that is a whole number of frames. */
class Gapless {
  exact = true
  /** @type {Piece[]} */ #pieces = []
  /** @type {Map<string, Promise<File>>} */ #files = new Map()
  /** @type {Map<string, number>} bytes, the least recently used first */ #sizes = new Map()
  /** @type {Map<string, {why: string, until: number}>} */ #failed = new Map()
  /** @type {SourceBuffer | null} */ #buffer = null
  /** @type {number[]} The frames at which the parts in the buffer begin. */ #starts = []
  /** @type {File | null} whose initialisation the buffer has */ #begun = null
  #mime = ''
  #source = new MediaSource()
  #wants = false
  #frame = 0
  #card = -1
  #carded = 0
  #pumping = false
  #again = false
  #closed = false
  /** Until a frame is on the screen after a leap, waiting is no stall. */
  #seeking = true
  #quota = 1
  #counted = { stalls: 0, appended: 0 }
  #late = { dropped: 0, shown: 0 }
  #asked = 1
  #looked = -1e9
  /** When another pace was asked for: the decoder stands for a moment then, however fast it is. */
  #paced = -1e9

  /** @param {HTMLVideoElement} video @param {[number, number]} fps @param {Told} told */
  constructor(video, [num, den], told) {
    this.num = num
    this.den = den
    this.told = told
    this.video = video
    this.url = URL.createObjectURL(this.#source)
    this.#source.addEventListener('sourceopen', () => this.#pump(), { once: true })
    this.video.addEventListener('waiting', () => this.#waited())
    this.video.addEventListener('ended', () => this.#ended())
    this.video.src = this.url
    this.video.requestVideoFrameCallback(this.#shown)
    requestAnimationFrame(this.#tick)
  }

  /** @param {number} frame @returns {number} the seconds at which it begins */
  #time(frame) { return frame * this.den / this.num }
  /** @param {number} seconds */
  #frames(seconds) { return seconds * this.num / this.den }

  /** @param {Piece[]} pieces */
  have(pieces) {
    this.#pieces = pieces
    this.#pump()
  }

  play() {
    this.#wants = true
    if (this.#card < 0) this.video.play().catch(() => this.pause())
    this.told.playing(true)
  }

  pause() {
    this.#wants = false
    this.video.pause()
    this.told.playing(false)
  }

  playing() { return this.#wants }
  at() { return this.#frame }
  /** @param {number} by */
  step(by) { this.pause(); this.seek(this.#frame + by) }
  /** @param {number} times */
  speed(times) {
    this.#asked = times
    this.#paced = performance.now()
    this.#go(times)
  }

  /** @param {number} times */
  #go(times) {
    this.video.defaultPlaybackRate = this.video.playbackRate = times
    this.#late = this.counted()
    this.told.pace?.(times)
  }

  /** Slower, where the computer decodes no faster: a walk that stands again and again shows nothing. */
  #ease() {
    if (this.video.playbackRate > 1) this.#go(Math.max(1, Math.floor(8 * this.video.playbackRate) / 10))
  }

  /** Looks at what was dropped of the last frames. */
  #watch() {
    const { dropped, shown } = this.counted(), late = dropped - this.#late.dropped, many = shown - this.#late.shown
    if (many > 200 && late > 0.03 * many) this.#ease()
    else if (many > 900) {
      if (!late && this.video.playbackRate < this.#asked) this.#go(Math.min(this.#asked, 1.25 * this.video.playbackRate))
      this.#late = { dropped, shown }
    }
  }

  /** @param {number} to */
  seek(to) {
    const frame = Math.max(0, Math.min(endOf(this.#pieces) - 1, Math.round(to)))
    this.#frame = frame
    const at = pieceAt(this.#pieces, frame)
    if (this.#isCard(at)) return this.#showCard(at)
    if (this.#card >= 0) this.#hideCard()
    this.#seeking = true
    // The middle of a frame belongs to that frame, however times are rounded.
    this.video.currentTime = this.#time(frame + 0.5)
    this.#pump()
    if (this.#wants) this.video.play().catch(() => {})
  }

  counted() {
    const quality = this.video.getVideoPlaybackQuality()
    return { ranges: this.video.buffered.length, dropped: quality.droppedVideoFrames, shown: quality.totalVideoFrames, ...this.#counted }
  }

  close() {
    this.#closed = true
    this.video.removeAttribute('src')
    this.video.load()
    URL.revokeObjectURL(this.url)
  }

  /** @type {VideoFrameRequestCallback} */
  #shown = (_, { mediaTime }) => {
    if (this.#closed) return
    this.video.requestVideoFrameCallback(this.#shown)
    if (this.#card >= 0) return
    this.#seeking = this.video.seeking
    this.#tell(Math.round(this.#frames(mediaTime)))
  }

  /** @param {number} frame */
  #tell(frame) {
    this.#frame = frame
    this.told.frame(frame, pieceAt(this.#pieces, frame))
    // Four looks a second are enough: each costs time that decoding needs.
    if (Math.abs(frame - this.#looked) < this.num / this.den / 4) return
    this.#looked = frame
    this.#pump()
    this.#watch()
  }

  /** All that there is before a card, or of the walk, was shown. */
  #ended() {
    const next = pieceAt(this.#pieces, Math.round(this.#frames(this.video.currentTime)) - 1) + 1
    if (!this.#wants || this.#card >= 0) return
    if (next >= this.#pieces.length) return this.pause()
    if (!this.#isCard(next)) return
    this.#frame = this.#pieces[next].start
    this.#showCard(next)
  }

  #waited() {
    const at = pieceAt(this.#pieces, this.#frame)
    if (performance.now() - this.#paced < PACING_MS) return
    if (this.#wants && !this.#seeking && this.#card < 0 && !this.#isCard(at) && !this.#isCard(at + 1)) {
      this.#counted.stalls++
      this.#ease()
    }
  }

  // Cards have no picture that a video could show: the clock runs on here, and the video stands.

  /** @param {number} at */
  #isCard(at) {
    const piece = this.#pieces[at]
    if (!piece) return false
    return !piece.url || (this.#failed.get(piece.url)?.until ?? 0) > performance.now()
  }

  #tick = (/** @type {number} */ now) => {
    if (this.#closed) return
    requestAnimationFrame(this.#tick)
    if (this.#card >= 0) this.#runCard(now)
    else if (this.#wants && !this.#seeking) {
      const at = pieceAt(this.#pieces, this.#frame)
      if (this.#isCard(at)) this.#showCard(at)
    }
  }

  /** @param {number} at */
  #showCard(at) {
    const { url, note } = this.#pieces[at]
    this.video.pause()
    this.#card = at
    this.#carded = performance.now()
    this.told.card(at, url ? this.#failed.get(url)?.why ?? '' : note ?? '')
    this.told.frame(this.#frame, at)
    this.#pump()
  }

  #hideCard() {
    this.#card = -1
    this.told.card(null, '')
  }

  /** @param {number} now */
  #runCard(now) {
    const { start, frames } = this.#pieces[this.#card]
    const passed = this.#frames((now - this.#carded) / 1000 * this.video.playbackRate)
    if (!this.#wants || passed < 0) { this.#carded = now; return }
    if (passed >= 1) {
      const whole = Math.floor(passed)
      this.#carded += (now - this.#carded) * whole / passed
      this.#frame += whole
    }
    if (this.#frame < start + frames) return this.told.frame(this.#frame, this.#card)
    if (start + frames >= endOf(this.#pieces)) return this.pause()
    this.#hideCard()
    this.seek(start + frames)
    this.play()
  }

  // What is to be in the buffer, and what no longer.

  async #pump() {
    this.#again = true
    if (this.#pumping || this.#source.readyState === 'closed') return
    this.#pumping = true
    try {
      while (this.#again && !this.#closed) {
        this.#again = false
        await this.#forget()
        const due = await this.#due()
        if (due && !this.#closed && await this.#append(due)) this.#again = true
      }
    } catch (error) {
      // A buffer that was closed meanwhile takes nothing any more.
      if (!this.#closed) this.told.card(pieceAt(this.#pieces, this.#frame), error instanceof Error ? error.message : String(error))
    } finally {
      this.#pumping = false
    }
  }

  /**
   * Whether the buffer has the middles of the first and the last of these frames, in one range.
   * @param {number} from @param {number} to
   */
  #has(from, to) {
    const ranges = this.#buffer?.buffered
    for (let at = 0; ranges && at < ranges.length; at++) {
      if (ranges.start(at) <= this.#time(from + 0.5) && ranges.end(at) >= this.#time(to - 0.5)) return true
    }
    return false
  }

  /** The next part that the buffer lacks. */
  async #due() {
    const from = this.#frame, until = from + Math.max(2, AHEAD_S * this.#quota) * this.num / this.den
    for (let at = pieceAt(this.#pieces, from); at < this.#pieces.length && this.#pieces[at].start < until; at++) {
      const piece = this.#pieces[at]
      if (this.#isCard(at) || !piece.url) {
        if (piece.start <= from) continue
        // Only what is known to end is played to its last frame: what follows the card comes while the card is shown.
        return this.#finish()
      }
      const file = await this.#file(piece.url)
      if (this.#frame < from || this.#frame > from + this.num / this.den || this.#closed) { this.#again = true; return null }
      if (!file) { at--; continue }
      const played = Math.max(0, Math.floor((from - piece.start) / file.frames)) * file.frames
      for (let base = piece.start + played; base < piece.start + piece.frames; base += file.frames) {
        for (const part of file.parts) {
          const start = base + part.start, end = Math.min(start + part.frames, piece.start + piece.frames)
          if (end <= from || start >= end) continue
          if (start >= until) return null
          // What was played of it may be gone.
          if (!this.#has(Math.max(start, from), end)) return { file, part, base }
        }
      }
      if (at === this.#pieces.length - 1) return this.#finish()
    }
    return null
  }

  #finish() {
    if (this.#source.readyState === 'open' && this.#buffer) this.#source.endOfStream()
    return null
  }

  /** @param {{file: File, part: Part, base: number}} due @returns {Promise<boolean>} whether there was room */
  async #append({ file, part, base }) {
    const buffer = this.#buffer ??= this.#source.addSourceBuffer(file.mime)
    if (this.#begun === null) this.#mime = file.mime
    if (this.#begun !== file) {
      if (this.#mime !== file.mime) buffer.changeType(file.mime)
      this.#mime = file.mime
      await this.#put(buffer, file.init)
      this.#begun = file
    }
    buffer.timestampOffset = this.#time(base)
    const end = this.#time(endOf(this.#pieces))
    if (!(this.#source.duration >= end)) this.#source.duration = end
    try {
      await this.#put(buffer, part.data)
    } catch (error) {
      if (!(error instanceof DOMException && error.name === 'QuotaExceededError')) throw error
      // Less is kept ahead from now on; what was played goes first.
      this.#quota = Math.max(1 / 16, this.#quota / 2)
      await this.#remove(0, this.#time(this.#frame) - 1)
      return false
    }
    this.#starts.push(base + part.start)
    this.#counted.appended++
    return true
  }

  /** What lies behind goes, and all of it after a leap to where nothing is. */
  async #forget() {
    const ranges = this.#buffer?.buffered
    if (!ranges?.length) return
    const now = this.#time(this.#frame + 0.5), first = ranges.start(0), last = ranges.end(ranges.length - 1)
    if (this.#card < 0 && (now < first - 0.1 || now > last + 0.1)) return this.#remove(0, Infinity)
    for (let at = pieceAt(this.#pieces, this.#frame); this.#card < 0 && this.#pieces[at] && this.#time(this.#pieces[at].start) < last - 0.1; at++) {
      // What lies behind a card would keep the video from its last frame before it.
      if (this.#isCard(at)) return this.#remove(this.#time(this.#pieces[at].start), Infinity)
    }
    // A browser lets go of all frames that need one which goes: only whole parts may.
    const cut = Math.max(0, ...this.#starts.filter(start => this.#time(start) < now - BEHIND_S))
    this.#starts = this.#starts.filter(start => start >= cut)
    if (first < this.#time(cut) - 0.1) await this.#remove(0, this.#time(cut))
  }

  /** @param {number} from @param {number} to seconds */
  async #remove(from, to) {
    const buffer = this.#buffer
    if (!buffer || to <= from) return
    buffer.remove(from, to)
    await settled(buffer)
  }

  /** @param {SourceBuffer} buffer @param {Uint8Array} data */
  async #put(buffer, data) {
    buffer.appendBuffer(data)
    await settled(buffer)
  }

  /**
   * The file of an address, read once; null if it cannot be had now.
   * @param {string} url
   */
  async #file(url) {
    const known = this.#files.get(url)
    const reading = known ?? read(url, this.num / this.den)
    this.#files.set(url, reading)
    try {
      const file = await reading
      this.#sizes.delete(url)
      this.#sizes.set(url, file.bytes)
      this.#drop()
      return file
    } catch (error) {
      this.#files.delete(url)
      this.#failed.set(url, { why: error instanceof Error ? error.message : String(error), until: performance.now() + 10_000 })
      return null
    }
  }

  #drop() {
    let sum = 0
    for (const bytes of this.#sizes.values()) sum += bytes
    for (const [url, bytes] of this.#sizes) {
      if (sum <= KEPT_BYTES || this.#sizes.size < 3) return
      sum -= bytes
      this.#sizes.delete(url)
      this.#files.delete(url)
    }
  }
}

/** @param {SourceBuffer} buffer */
function settled(buffer) {
  return new Promise((done, fail) => {
    const ended = () => { buffer.removeEventListener('updateend', ended); buffer.removeEventListener('error', broke); done(undefined) }
    const broke = () => { buffer.removeEventListener('updateend', ended); buffer.removeEventListener('error', broke); fail(new Error('the browser cannot decode this clip')) }
    buffer.addEventListener('updateend', ended)
    buffer.addEventListener('error', broke)
  })
}

