// Moving pictures of sheep: strips of 24 pictures, six a row, each drawn on a canvas.
//
// Owns which strips are loaded and which move. Only those in view move, at most 40 of them, all by one timer; none moves
// while the page scrolls, and none when pictures are stopped. Strips are decoded away from the page's thread.
//
// Start at [`Strips`].

export const PICTURES = 24
const ACROSS = 6
const MOST_MOVING = 40
/** A browser opens six connections to one place: one is the stream of events, one is for what is asked meanwhile. */
const MOST_LOADING = 4
/** Decoded strips that are kept: 1.4 MB each. */
const MOST_KEPT = 72
/** Small ones: 0.2 MB each. */
const MOST_SMALL = 300
/** Milliseconds a picture is shown. */
const PACE = 125
/** Milliseconds after the last scroll until pictures move again. */
const REST = 140
/** Pixels a millisecond above which nobody sees single pictures. */
const FAST = 1

/** @typedef {{canvas: HTMLCanvasElement, key: string | null, colour: string, near: boolean, drawn: number, held: number | null, phase: number}} Shown */

export class Strips {
  /** @param {import('./store.js').Store} store */
  constructor(store) {
    this.store = store
    /** @type {Map<Element, Shown>} */ this.shown = new Map()
    /** @type {Map<string, ImageBitmap>} The last used last. */ this.kept = new Map()
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
   * Shows a sheep's strip on `canvas`, from now on.
   * @param {HTMLCanvasElement} canvas
   * @param {{id: string, strip: string | null, colour: string | null}} sheep
   * @param {number} [width] pixels to draw, best those that it has on the page
   * @param {number} [height]
   */
  show(canvas, sheep, width = 160, height = 90) {
    const one = this.shown.get(canvas)
    if (one && one.key === sheep.strip && canvas.width === width) return
    const phase = [...sheep.id].reduce((sum, letter) => sum + letter.charCodeAt(0), 0) % PICTURES
    const fresh = { canvas, key: sheep.strip, colour: sheep.colour ?? '', near: one?.near ?? false, drawn: -1, held: null, phase }
    this.shown.set(canvas, fresh)
    if (!one) this.seer.observe(canvas)
    if (canvas.width !== width) Object.assign(canvas, { width, height })
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
    const strip = one.key === null ? undefined : this.kept.get(one.key)
    const context = strip && one.canvas.getContext('2d', { alpha: false })
    if (!strip || !context || !one.key) return false
    this.kept.delete(one.key)
    this.kept.set(one.key, strip)
    context.drawImage(strip, ...this.piece(strip, picture), 0, 0, one.canvas.width, one.canvas.height)
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
    const answer = await fetch(`/media/strip/${encodeURIComponent(key)}`)
    if (!answer.ok) throw new Error(`no strip \`${key}\``)
    const strip = await createImageBitmap(await answer.blob())
    this.kept.set(key, strip)
    for (const [old, bitmap] of this.kept) {
      if (this.kept.size <= MOST_KEPT) break
      this.kept.delete(old)
      bitmap.close()
    }
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
    if (small) {
      this.smalls.delete(key)
      this.smalls.set(key, small)
      return small
    }
    if (this.lost.has(key) || this.shrinking.has(key) || this.shrinking.size + this.loading.size >= MOST_LOADING) return undefined
    this.shrinking.add(key)
    fetch(`/media/strip/${encodeURIComponent(key)}`).then(async answer => {
      if (!answer.ok) throw new Error(`no strip \`${key}\``)
      this.smalls.set(key, await createImageBitmap(await answer.blob(), { resizeWidth: 384, resizeHeight: 144, resizeQuality: 'medium' }))
      for (const [old, bitmap] of this.smalls) {
        if (this.smalls.size <= MOST_SMALL) break
        this.smalls.delete(old)
        bitmap.close()
      }
    }).catch(() => { this.lost.add(key) }).finally(() => { this.shrinking.delete(key); there() })
    return undefined
  }

  /**
   * Where a picture is in a strip: left, top, width, height.
   * @param {ImageBitmap} strip
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

/**
 * A ground in the sheep's colour until its strip is there.
 * @param {Shown} one
 * @param {boolean} made the program is making it, which is said: nothing on the page moves for it
 */
function blank(one, made) {
  const context = one.canvas.getContext('2d', { alpha: false })
  if (!context) return
  const { width, height } = one.canvas
  const ground = context.createRadialGradient(width / 2, height / 2, 0, width / 2, height / 2, width / 1.6)
  ground.addColorStop(0, one.colour || '#2a2d33')
  ground.addColorStop(1, '#0b0c0e')
  context.fillStyle = ground
  context.fillRect(0, 0, width, height)
  if (!made) return
  context.font = '12px system-ui, sans-serif'
  context.textAlign = 'center'
  context.fillStyle = '#ebe8e2'
  context.fillText('drawing …', width / 2, height / 2 + 4)
}
