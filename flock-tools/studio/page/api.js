// What the page asks the program, and what the program tells it.
//
// Owns the order of edits, and the stream of events; what the session knows is in `session.js`. Every edit names the revision
// that the page shows; edits are sent one after the other, so that the second names the revision that the first made. Never
// draws: what is to be said goes through `said`, what is to be asked through `confirm`, which `app.js` sets.

import { bare, begin, secret } from './session.js'
import { way } from './store.js'

export class Refused extends Error {
  /** @param {number} status @param {string} message @param {any} body */
  constructor(status, message, body) {
    super(message)
    this.status = status
    this.body = body
  }
}

export class Api {
  /** @param {import('./store.js').Store} store */
  constructor(store) {
    this.store = store
    this.queue = Promise.resolve()
    this.gestures = 0
    /** When this page last changed something. */
    this.changed = -Infinity
    this.sequence = 0
    /** @type {AbortController | null} */ this.asking = null
    /** @type {EventSource | null} */ this.events = null
    /** @type {(text: string, bad?: boolean) => void} */ this.said = () => {}
    /** @type {(question: Question) => Promise<boolean>} */ this.confirm = async () => false
    /** The program knows this page no more: it was started anew. */
    this.closed = false
    /** @type {() => void} */ this.locked = () => {}
  }

  /**
   * Opens the session with the token of the address, or goes on with the one that is open, and fetches the state.
   * Throws [`Refused`] with status 401 if neither is good.
   */
  async open() {
    const token = location.hash.slice(1)
    if (token && !token.startsWith('/')) {
      history.replaceState(null, '', location.pathname)
      begin(await this.ask('POST', '/session', { token }))
    }
    this.closed = false
    await this.listen()
  }

  /**
   * @param {string} method
   * @param {string} path
   * @param {any} [body]
   * @param {AbortSignal} [signal]
   * @returns {Promise<any>} the answer; undefined if it is empty
   */
  async ask(method, path, body, signal) {
    /** @type {Record<string, string>} */ const headers = { 'X-Studio-Secret': secret() }
    if (method !== 'GET') headers['Content-Type'] = 'application/json'
    const sent = method === 'GET' ? undefined : JSON.stringify(body ?? {})
    let answer
    try {
      answer = await fetch(path, { method, headers, body: sent, signal, cache: 'no-store' })
    } catch (error) {
      if (signal?.aborted) throw error
      throw new Refused(0, 'the program does not answer', null)
    }
    const text = await answer.text()
    const told = text && answer.headers.get('Content-Type')?.includes('json') ? JSON.parse(text) : undefined
    if (!answer.ok) throw new Refused(answer.status, told?.error ?? `the program answered ${answer.status}`, told)
    return told
  }
  /** @param {string} path @param {AbortSignal} [signal] */
  get(path, signal) { return this.ask('GET', path, undefined, signal) }
  /** @param {string} path @param {any} [body] @param {AbortSignal} [signal] */
  post(path, body, signal) { return this.ask('POST', path, body, signal) }
  /** @param {string} path */
  delete(path) { return this.ask('DELETE', path) }

  /** Fetches what is new since the state that is here. */
  async refresh() {
    this.store.replace(await this.get(`/api/state?since=${this.store.state.tag}`))
  }
  /** Something was changed here since the state was told, and may be taken back: the next one is fetched as a whole. */
  doubt() { this.store.state.tag = '' }

  /**
   * The state after a change, which came with the answer.
   * @param {{state?: Told}} done
   */
  async changedTo({ state }) {
    if (state) this.store.replace(state)
    else await this.refresh()
    this.changed = performance.now()
  }

  /**
   * Says what went wrong, unless nobody wants to know any more.
   * @param {unknown} error
   */
  failed(error) {
    if (error instanceof DOMException && error.name === 'AbortError') return
    if (!(error instanceof Refused)) console.error(error)
    this.said(error instanceof Error ? error.message : String(error), true)
  }

  /**
   * Runs `work` after all that was asked before.
   * @template T
   * @param {() => Promise<T>} work
   * @returns {Promise<T>}
   */
  after(work) {
    const done = this.queue.then(work)
    this.queue = done.then(() => {}, () => {})
    return done
  }

  /** A name for edits that are undone together. */
  gesture() { return `g${Date.now().toString(36)}.${++this.gestures}` }

  /**
   * Makes edits; those with one `gesture` are one step of undo. If sheep would leave the wall, asks first.
   * Says what was done or why not; false if not.
   * @param {Edit[]} edits
   * @param {string | null} [gesture]
   */
  edit(edits, gesture = null) {
    return this.after(() => this.editNow(edits, gesture, false))
  }

  /** @param {Edit[]} edits @param {string | null} gesture @param {boolean} force @returns {Promise<boolean>} */
  async editNow(edits, gesture, force) {
    try {
      const { revision, tag } = this.store.state
      const done = await this.post('/api/edits', { revision, since: tag, gesture, edits, ...force ? { force } : {} })
      await this.changedTo(done)
      this.said(done.merged ? `${done.said}, beside a change made elsewhere` : done.said)
      return true
    } catch (error) {
      this.doubt()
      if (error instanceof Refused && error.status === 428) {
        const gone = error.body?.no_longer_shown ?? []
        const yes = await this.confirm({ title: gone.length ? `${gone.length === 1 ? 'One sheep' : `${gone.length} sheep`} would leave the wall` : 'No sheep would be left', text: error.message, items: gone, yes: 'Do it anyway' })
        return yes ? this.editNow(edits, gesture, true) : false
      }
      if (error instanceof Refused && error.status === 409 && error.body?.state) this.store.replace(error.body.state)
      this.failed(error)
      return false
    }
  }

  /**
   * What edits would do; nothing is written. Only the newest question is answered: null for one that was overtaken.
   * @param {Edit[]} edits
   * @returns {Promise<WhatIf | null>}
   */
  async whatIf(edits) {
    const sequence = ++this.sequence
    this.asking?.abort()
    const asking = this.asking = new AbortController()
    try {
      const told = await this.post('/api/whatif', { edits, sequence }, asking.signal)
      return sequence === this.sequence ? told : null
    } catch (error) {
      if (!asking.signal.aborted) this.failed(error)
      return null
    }
  }
  /** Nobody waits for the answer of a what-if any more. */
  hush() {
    this.sequence += 1
    this.asking?.abort()
  }

  /** @param {'undo' | 'redo'} which */
  step(which) {
    return this.after(async () => {
      try {
        const done = await this.post(`/api/${which}`, { since: this.store.state.tag })
        await this.changedTo(done)
        this.said(done?.said ? `${which === 'undo' ? 'Undone' : 'Done again'}: ${done.said}` : which === 'undo' ? 'Undone' : 'Done again')
      } catch (error) { this.failed(error) }
    })
  }

  /**
   * Marks or rates sheep. The page shows it at once, and takes it back if the program refuses.
   * @param {string[]} ids
   * @param {{mark?: Mark, rating?: number}} what
   */
  mark(ids, what) {
    const before = ids.map(id => ({ id, mark: this.store.byId.get(id)?.mark, rating: this.store.byId.get(id)?.rating }))
    this.store.patch(ids, what)
    return this.after(async () => {
      try {
        const done = await this.post('/api/marks', { marks: ids.map(sheep => ({ sheep, ...what })) })
        this.doubt()
        Object.assign(this.store.state, { undo: done.undo ?? null, redo: done.redo ?? null })
        this.store.tell('jobs')
      } catch (error) {
        for (const { id, mark, rating } of before) this.store.patch([id], { mark, rating })
        this.failed(error)
      }
    })
  }

  /**
   * One stream of events for the page; the browser reconnects with the id of the last one it had. The program begins a new
   * stream with `state`, so that no change lies between the stream and the state. Resolves when the first state is there.
   * @returns {Promise<void>}
   */
  listen() {
    this.events?.close()
    const events = this.events = new EventSource(bare('/events'))
    return new Promise((resolve, reject) => {
      const refresh = () => { this.after(() => this.refresh()).then(resolve, error => { reject(error); this.failed(error) }) }
      this.hear(events, refresh)
      events.onopen = () => this.reached(true)
      events.onerror = () => {
        this.reached(false)
        if (events.readyState !== EventSource.CLOSED) return
        // The stream does not say why it was refused; a question does.
        this.get('/api/state').catch(error => {
          if (!(error instanceof Refused) || ![401, 403].includes(error.status)) return
          this.closed = true
          reject(error)
          this.locked()
        })
        setTimeout(() => { if (this.events === events && !this.closed) this.listen().then(resolve, reject) }, 1000)
      }
    })
  }

  /** @param {EventSource} events @param {() => void} refresh */
  hear(events, refresh) {
    /** @param {string} kind @param {(told: any) => void} run */
    const on = (kind, run) => events.addEventListener(kind, event => run(JSON.parse(event.data || 'null')))
    on('state', refresh)
    // A change of this page's own fetches the state itself; its event may come before the answer, or after it.
    on('changed', ({ revision }) => { this.after(async () => { if (revision !== this.store.state.revision || performance.now() - this.changed > 2000) refresh() }) })
    on('job', told => this.store.job(told.job ?? told, true))
    on('looks', ({ looks }) => this.store.looked(looks))
    on('marks', told => this.noted(told))
    on('note', ({ text }) => this.said(text))
  }

  /**
   * Marks, pins or bad joins that this page or another has noted.
   * @param {{marks?: {sheep: string, mark: Mark | null, rating: number | null}[], pins?: {sheep: string, x: number | null, y: number | null}[], joins?: {from: string, to: string, bad: boolean}[]}} told
   */
  noted({ marks = [], pins = [], joins = [] }) {
    for (const { sheep, mark, rating } of marks) this.store.patch([sheep], { ...mark === null ? {} : { mark }, ...rating === null ? {} : { rating } })
    for (const { sheep, x, y } of pins) if (x !== null && y !== null) this.store.patch([sheep], { x, y, pinned: true })
    this.doubt()
    for (const { from, to, bad } of joins) Object.assign(this.store.byWay.get(way(from, to)) ?? {}, { bad })
  }

  /** @param {boolean} online */
  reached(online) {
    if (online === this.store.online) return
    this.store.online = online
    this.store.tell('online')
  }
}
