// Moving pictures of sheep: strips of 24 pictures, six a row, each drawn on a canvas, or as the background of another element.
//
// Owns which strips are loaded and which move. Only those in view move, at most 40 of them, all by one timer; none moves
// while the page scrolls, and none when pictures are stopped. Strips are decoded away from the page's thread. To the browser a
// canvas is a layer of its own, which costs each frame of a page that scrolls; a background is painted once.
//
// Start at [`Strips`].

import { styled } from './dom.js'
import { media } from './session.js'

const PICTURES = 24
const ACROSS = 6
const MOST_MOVING = 40
/** A browser opens six connections to one place: one is the stream of events, one is for what is asked meanwhile. */
const MOST_LOADING = 4
/** Strips that are kept: 0.1 MB each. The browser keeps those decoded that it draws. */
const MOST_KEPT = 300
/** Small ones: 0.2 MB each. */
const MOST_SMALL = 300
/** Milliseconds a picture is shown. */
const PACE = 125
/** Milliseconds after the last scroll until pictures move again. */
const REST = 140
/** Pixels a millisecond above which nobody sees single pictures. */
const FAST = 1

/** @typedef {{canvas: HTMLElement, key: string | null, colour: string, near: boolean, drawn: number, held: number | null, phase: number}} Shown */

export class Strips {
  /** @param {import('./store.js').Store} store */
  constructor(store) {
    this.store = store
    /** @type {Map<Element, Shown>} */ this.shown = new Map()
    /** @type {Map<string, HTMLImageElement>} The last used last. */ this.kept = new Map()
    /** @type {Set<string>} */ this.loading = new Set()
    /** @type {Set<string>} Those that the program is making, or cannot make. */ this.lost = new Set()
    /** @type {Map<string, ImageBitmap>} */ this.smalls = new Map()
    /** @type {Set<string>} */ this.shrinking = new Set()
    this.scrolled = 0
    this.scrolledTo = 0
    this.fast = false
    this.tick = 0
    /** @type {ReturnType<typeof setInterval> | undefined} */ this.timer = undefined
    this.seer = new IntersectionObserver(seen => {
      for (const { target, isIntersecting } of seen) {
        const one = this.shown.get(target)
        if (one) one.near = isIntersecting
      }
      this.load()
    }, { rootMargin: '120px' })
    addEventListener('scroll', event => this.scroll(event), { capture: true, passive: true })
    addEventListener('scrollend', () => { this.scrolled = 0; this.load() }, { capture: true, passive: true })
    store.on(['moving'], () => this.run())
    store.on(['jobs', 'state'], changed => this.again(changed.has('state')))
  }

  /**
   * Shows a sheep's strip on `canvas`, from now on; an element of another kind has the class `strip`.
   * @param {HTMLElement} canvas
   * @param {{id: string, strip: string | null, colour: string | null}} sheep
   */
  show(canvas, sheep) {
    const one = this.shown.get(canvas)
    if (one && one.key === sheep.strip) return
    const phase = [...sheep.id].reduce((sum, letter) => sum + letter.charCodeAt(0), 0) % PICTURES
    const fresh = { canvas, key: sheep.strip, colour: sheep.colour ?? '', near: one?.near ?? false, drawn: -1, held: null, phase }
    this.shown.set(canvas, fresh)
    if (!one) this.seer.observe(canvas)
    if (!one && canvas instanceof HTMLCanvasElement) Object.assign(canvas, { width: 160, height: 90 })
    if (!this.draw(fresh, phase)) blank(fresh, this.lost.has(sheep.strip ?? ''))
    this.load()
    this.run()
  }

  /** @param {Element} canvas */
  forget(canvas) {
    this.seer.unobserve(canvas)
    this.shown.delete(canvas)
    if (!this.shown.size) this.run()
  }

  /**
   * Shows one picture and keeps it, 0 to 1 through the strip; null lets it move again.
   * @param {Element} canvas
   * @param {number | null} part
   */
  hold(canvas, part) {
    const one = this.shown.get(canvas)
    if (!one) return
    one.held = part === null ? null : Math.min(PICTURES - 1, Math.max(0, Math.floor(part * PICTURES)))
    if (one.held !== null) this.draw(one, one.held)
  }

  /** @param {Event} event */
  scroll({ target }) {
    const now = performance.now(), to = target instanceof Element ? target.scrollTop : 0
    this.fast = Math.abs(to - this.scrolledTo) > FAST * (now - this.scrolled)
    this.scrolled = now
    this.scrolledTo = to
  }

  run() {
    const needed = this.store.moving && this.shown.size > 0
    if (needed === (this.timer !== undefined)) return
    clearInterval(this.timer)
    this.timer = needed ? setInterval(() => this.step(), PACE) : undefined
  }

  step() {
    if (document.hidden || performance.now() - this.scrolled < REST) return
    this.tick += 1
    let moving = 0
    for (const one of this.shown.values()) {
      if (!one.near || one.held !== null || !one.key || moving >= MOST_MOVING || !one.canvas.isConnected) continue
      moving += 1
      this.draw(one, (this.tick + one.phase) % PICTURES)
    }
  }

  /** @param {Shown} one @param {number} picture @returns {boolean} whether its strip is there */
  draw(one, picture) {
    const { canvas, key } = one, strip = key === null ? undefined : this.kept.get(key)
    if (!strip || !key) return false
    keep(this.kept, key, strip, MOST_KEPT)
    const [x, y, wide, high] = this.piece(strip, picture)
    if (canvas instanceof HTMLCanvasElement) canvas.getContext('2d', { alpha: false })?.drawImage(strip, x, y, wide, high, 0, 0, canvas.width, canvas.height)
    else {
      if (one.drawn < 0) { canvas.textContent = ''; styled(canvas, { 'background-image': `url("${strip.src}")` }) }
      styled(canvas, { 'background-position': `${20 * x / wide}% ${100 / 3 * y / high}%` })
    }
    one.drawn = picture
    return true
  }

  /** Loads the strips that are in view and not there yet. */
  load() {
    // One at a time while the page scrolls, and none while it scrolls fast, so that no frame waits for it.
    const most = (performance.now() - this.scrolled > REST ? MOST_LOADING : this.fast ? 0 : 1) - this.shrinking.size
    for (const one of this.shown.values()) {
      if (this.loading.size >= most) return
      const key = one.key
      if (!one.near || !key || one.drawn >= 0 || this.loading.has(key) || this.lost.has(key)) continue
      if (this.draw(one, one.phase)) continue
      this.loading.add(key)
      this.fetch(key).catch(() => {
        this.lost.add(key)
        for (const other of this.shown.values()) if (other.key === key) blank(other, true)
      }).finally(() => {
        this.loading.delete(key)
        this.load()
      })
    }
  }

  /** @param {string} key */
  async fetch(key) {
    keep(this.kept, key, await loaded(key), MOST_KEPT)
    for (const one of this.shown.values()) {
      if (one.key !== key) continue
      this.draw(one, one.held ?? one.phase)
    }
  }

  /**
   * A strip at two fifths of its size, for small pictures; undefined until it is loaded, which calls `there`.
   * @param {string} key
   * @param {() => void} there
   * @returns {ImageBitmap | undefined}
   */
  small(key, there) {
    const small = this.smalls.get(key)
    if (small) keep(this.smalls, key, small, MOST_SMALL)
    if (small || this.lost.has(key) || this.shrinking.has(key) || this.shrinking.size + this.loading.size >= MOST_LOADING) return small
    this.shrinking.add(key)
    loaded(key).then(async strip => keep(this.smalls, key, await createImageBitmap(strip, { resizeWidth: 384, resizeHeight: 144, resizeQuality: 'medium' }), MOST_SMALL))
      .catch(() => { this.lost.add(key) }).finally(() => { this.shrinking.delete(key); there() })
    return undefined
  }

  /**
   * Where a picture is in a strip: left, top, width, height.
   * @param {ImageBitmap | HTMLImageElement} strip
   * @param {number} picture
   * @returns {[number, number, number, number]}
   */
  piece(strip, picture) {
    const wide = strip.width / ACROSS, high = strip.height / (PICTURES / ACROSS), at = picture % PICTURES
    return [(at % ACROSS) * wide, Math.floor(at / ACROSS) * high, wide, high]
  }

  /**
   * Strips that were made meanwhile are asked for again.
   * @param {boolean} all also those of which nothing was heard
   */
  again(all) {
    if (!this.lost.size) return
    if (all) this.lost.clear()
    else for (const { kind, key, state } of this.store.state.jobs) if (kind === 'strip' && state === 'done') this.lost.delete(key?.replace(/^.* /, '') ?? '')
    this.load()
  }
}

/** @param {string} key */
async function loaded(key) {
  const strip = new Image()
  strip.src = media('strip', key)
  await strip.decode()
  return strip
}

/**
 * Keeps it as the one that was used last.
 * @template T
 * @param {Map<string, T>} all
 * @param {string} key
 * @param {T} one
 * @param {number} most
 */
function keep(all, key, one, most) {
  all.delete(key)
  all.set(key, one)
  for (const old of all.keys()) if (all.size > most) all.delete(old)
}

/**
 * A ground in the sheep's colour until its strip is there.
 * @param {Shown} one
 * @param {boolean} made the program is making it, which is said: nothing on the page moves for it
 */
function blank(one, made) {
  const { canvas } = one, text = made ? 'drawing …' : ''
  if (!(canvas instanceof HTMLCanvasElement)) {
    canvas.textContent = text
    return styled(canvas, { 'background-image': null, '--colour': one.colour || null })
  }
  const context = canvas.getContext('2d', { alpha: false }), { width, height } = canvas
  if (!context) return
  const ground = context.createRadialGradient(width / 2, height / 2, 0, width / 2, height / 2, width / 1.6)
  ground.addColorStop(0, one.colour || '#2a2d33')
  ground.addColorStop(1, '#0b0c0e')
  context.fillStyle = ground
  context.fillRect(0, 0, width, height)
  context.font = '12px system-ui, sans-serif'
  context.textAlign = 'center'
  context.fillStyle = '#ebe8e2'
  context.fillText(text, width / 2, height / 2 + 4)
}
