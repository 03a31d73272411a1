// What the page knows: the program's state, indexed, and which sheep has the focus.
//
// Views read `store.state` and subscribe; only `api.js` puts what the program says into it. The focus is one sheep for all
// views. Subscribers are called once for all changes of one turn, before the next frame is drawn.

/**
 * What changed: `state` the whole document, `sheep` marks or figures of some, `looks` what is seen in pictures of some, `clips` how far some are
 * that are being rendered, `jobs`, `focus`, `moving`, `online`, `supposed` what an edit would do that is being thought of.
 * @typedef {'state' | 'sheep' | 'looks' | 'clips' | 'jobs' | 'focus' | 'moving' | 'online' | 'supposed'} Topic
 */

/** @param {string} from @param {string} to */
export const way = (from, to) => `${from}\n${to}`

/** @type {State} */
const NOTHING = {
  tag: '', revision: '', name: '', fps: [20, 1], size: [1280, 720], by: 'visits', now_ms: 0,
  figures: { sheep: 0, transitions: 0, shown: 0, worst_ratio: null, entropy_bits: 0, step_minutes: 0 },
  faults: [], sheep: [], candidates: [], transitions: [], undo: null, redo: null, jobs: [], paused: false, pool: null,
  capabilities: { gpu: false },
}

export class Store {
  constructor() {
    this.state = NOTHING
    this.loaded = false
    this.online = true
    /** @type {string | null} The id of the sheep with the focus, of the flock or a candidate. */
    this.focus = null
    /** @type {WhatIf | null} */ this.supposed = null
    /** Whether the artist lets pictures move. */
    this.moving = true
    /** @type {Map<string, Sheep>} */ this.byId = new Map()
    /** @type {Map<string, Transition>} By `way(from, to)`. */ this.byWay = new Map()
    /** @type {Map<string, Transition[]>} */ this.outs = new Map()
    /** @type {Map<string, Transition[]>} */ this.ins = new Map()
    /** @type {Map<string, Job>} What is being rendered, or waits for it: by the id of a sheep, or by `way(from, to)`. */ this.rendering = new Map()
    /** @type {Set<{topics: Set<Topic>, run: (changed: Set<Topic>) => void}>} */ this.listeners = new Set()
    /** @type {Set<Topic>} */ this.changed = new Set()
  }

  /**
   * Calls `run` after changes of `topics`. Returns what ends it.
   * @param {Topic[]} topics
   * @param {(changed: Set<Topic>) => void} run
   */
  on(topics, run) {
    const listener = { topics: new Set(topics), run }
    this.listeners.add(listener)
    return () => { this.listeners.delete(listener) }
  }

  /** @param {Topic} topic */
  tell(topic) {
    if (!this.changed.size) queueMicrotask(() => this.flush())
    this.changed.add(topic)
  }

  flush() {
    const changed = this.changed
    this.changed = new Set()
    for (const { topics, run } of [...this.listeners]) if ([...changed].some(topic => topics.has(topic))) run(changed)
  }

  /**
   * The whole document anew, or what is new since the one that is here: its lists name what is as it was by its place.
   * @param {Told} told
   */
  replace({ since, shares, wants, visits, ...told }) {
    /** @type {State} */ const state = /** @type {any} */ (told)
    if (since !== undefined) {
      for (const list of /** @type {const} */ (['sheep', 'candidates', 'transitions'])) {
        const before = /** @type {any} */ (this.state[list])
        state[list] = told[list].flatMap(part => Array.isArray(part) ? before.slice(...part) : [part])
      }
      state.sheep.forEach((one, at) => {
        Object.assign(one, shares && { share: shares[at] }, wants && { wanted: wants[at] })
        one.ratio = one.wanted ? one.share / one.wanted : null
      })
      if (visits) state.transitions.forEach((one, at) => { one.visits = visits[at] })
    }
    this.state = state
    this.loaded = true
    this.supposed = null
    this.index()
    if (this.focus !== null && !this.byId.has(this.focus)) this.focus = null
    this.tell('state')
  }

  index() {
    const { sheep, candidates, transitions, jobs } = this.state
    this.rendering = new Map()
    for (const job of jobs) this.renders(job)
    this.byId = new Map([...candidates, ...sheep].map(one => [one.id, one]))
    this.byWay = new Map(transitions.map(one => [way(one.from, one.to), one]))
    this.outs = new Map()
    this.ins = new Map()
    for (const one of transitions) {
      const out = this.outs.get(one.from), into = this.ins.get(one.to)
      out ? out.push(one) : this.outs.set(one.from, [one])
      into ? into.push(one) : this.ins.set(one.to, [one])
    }
  }

  /**
   * Changes some fields of some sheep, as marks before the program has answered.
   * @param {string[]} ids
   * @param {Partial<Sheep>} fields
   */
  patch(ids, fields) {
    for (const id of ids) {
      const one = this.byId.get(id)
      if (one) Object.assign(one, fields)
    }
    this.tell('sheep')
  }

  /**
   * One job's news, or a job that was asked for: its first events may have come before the answer, which is older than they are.
   * @param {Job} job
   * @param {boolean} [news]
   */
  job(job, news = false) {
    if (job.id === undefined) return
    const jobs = this.state.jobs, at = jobs.findIndex(one => one.id === job.id)
    if (at >= 0 && !news) return
    if (at < 0) jobs.push(job)
    else jobs[at] = job
    this.tell('jobs')
    if (this.renders(job)) this.tell('clips')
  }

  /**
   * Keeps a job by what it renders, as long as it is not over. False if it renders nothing.
   * @param {Job} job
   */
  renders(job) {
    const { about, state } = job
    if (job.kind !== 'render' || !about) return false
    const key = 'sheep' in about ? about.sheep : way(about.from, about.to)
    if (state === 'queued' || state === 'running' || state === 'waiting') this.rendering.set(key, job)
    else if (this.rendering.get(key)?.id === job.id) this.rendering.delete(key)
    return true
  }

  /**
   * A sheep with the state of its clip as the jobs tell it, which is newer than the document's.
   * @param {Sheep} one
   * @returns {Sheep}
   */
  live(one) {
    const job = one.in_flock ? this.rendering.get(one.id) : undefined
    if (!job) return one
    if (job.state === 'queued') return one.state === 'queued' ? one : { ...one, state: 'queued', percent: null }
    return { ...one, state: 'rendering', percent: Math.floor(100 * job.done / Math.max(1, job.of)) }
  }

  /**
   * What is seen in strips that were made meanwhile.
   * @param {{strip: string, activity: number, colour: string}[]} looks
   */
  looked(looks) {
    const known = new Map(looks.map(look => [look.strip, look]))
    for (const one of this.byId.values()) {
      const look = one.strip === null ? undefined : known.get(one.strip)
      if (look) Object.assign(one, { activity: look.activity, colour: look.colour })
    }
    this.tell('looks')
  }

  /** @param {string | null} id */
  look(id) {
    if (id === this.focus) return
    this.focus = id
    this.tell('focus')
  }

  /** @param {WhatIf | null} told */
  suppose(told) {
    if (told === this.supposed) return
    this.supposed = told
    this.tell('supposed')
  }

  /** @param {boolean} moving */
  move(moving) {
    this.moving = moving
    this.tell('moving')
  }

  /** The sheep with the focus. */
  get focused() {
    return this.focus === null ? undefined : this.byId.get(this.focus)
  }
}
