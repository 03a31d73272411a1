// What the program works at: each job with its progress, its cost and its log, and what is still to be rendered.
//
// Owns rows that stay while their job changes, so that the focus and an open log stay too, and that do not change places
// under the pointer.

import { button, make, styled } from './dom.js'
import { quiet } from './parts.js'
import { digits, minutes, spoken } from './words.js'

const MOST_DONE = 400, STRIPS = 'strips'
const ORDER = ['waiting', 'running', 'queued', 'failed', 'cancelled', 'done']
/** @type {Record<string, string>} */
const WORDS = { waiting: 'waits for you', running: 'running', queued: 'queued', failed: 'failed', cancelled: 'cancelled', done: 'done' }

/** @param {number | null} seconds */
const lasting = seconds => seconds === null ? '' : seconds < 1 ? 'under 1 s' : minutes(seconds / 60)

/** @param {Job} job */
export const ended = job => job.state === 'done' || job.state === 'failed' || job.state === 'cancelled'

/**
 * A row for a job, which `update` fits to what is known of it now.
 * @param {(id: Job['id']) => void} cancel
 * @param {(id: Job['id'], paused: boolean) => void} hold
 */
export function jobRow(cancel, hold) {
  const what = make('b', {}), state = make('span', { class: 'chip' }), figures = make('span', { class: 'dim' }), bar = make('i', {})
  const meter = make('span', { class: 'meter', role: 'progressbar', 'aria-valuemin': 0 }, bar), error = make('p', { class: 'bad', hidden: true })
  const log = make('pre', {}), more = make('details', { hidden: true }, make('summary', {}, 'Log'), log)
  /** @type {Job['id']} */ let id = ''
  let paused = false
  const stop = quiet('Cancel', () => cancel(id)), pause = quiet('Pause', () => hold(id, !paused))
  const row = make('li', { class: 'job', tabindex: -1 }, make('div', { class: 'bar' }, what, state, make('span', { class: 'grow' }), figures, pause, stop), meter, error, more)
  return {
    row,
    /** @param {Job} job */
    update(job) {
      id = job.id
      row.dataset.job = String(job.id)
      row.dataset.state = job.state
      paused = job.paused
      const word = paused ? 'paused' : WORDS[job.state]
      row.setAttribute('aria-label', `${job.what}, ${word}`)
      what.textContent = job.what
      state.textContent = word
      state.classList.toggle('bad', job.state === 'failed')
      figures.textContent = [job.of > 1 ? `${digits(job.done)} of ${digits(job.of)}` : '', job.per_second && job.state === 'running' ? `${digits(job.per_second)} a second` : '',
        paused ? '' : job.state === 'running' && job.left_s !== null ? `${lasting(job.left_s)} left` : job.state === 'queued' && job.cost_s !== null ? `costs ${lasting(job.cost_s)}` : ''].filter(Boolean).join(' · ')
      const part = job.state === 'done' ? 1 : job.of ? Math.min(1, job.done / job.of) : 0
      styled(bar, { width: `${100 * part}%` })
      meter.hidden = ended(job) || job.state === 'queued'
      meter.setAttribute('aria-valuenow', String(job.done))
      meter.setAttribute('aria-valuemax', String(job.of))
      meter.setAttribute('aria-label', job.what)
      error.hidden = !job.error
      error.textContent = job.error ?? ''
      const text = (job.log ?? []).join('\n')
      more.hidden = !text
      if (log.textContent !== text) log.textContent = text
      if (job.state === 'waiting') more.open = true
      stop.hidden = ended(job)
      stop.setAttribute('aria-label', `Cancel ${job.what}`)
      pause.hidden = !job.can_pause
      pause.textContent = paused ? 'Go on' : 'Pause'
      pause.setAttribute('aria-label', `${paused ? 'Go on with' : 'Pause'} ${job.what}`)
    },
  }
}

/**
 * Has one job stand still, or go on.
 * @param {import('./api.js').Api} api
 * @param {Job['id']} id @param {boolean} paused
 */
export async function holdJob(api, id, paused) {
  try {
    const { job } = await api.post(`/api/jobs/${encodeURIComponent(id)}/pause`, { paused })
    api.said(`${paused ? 'Paused' : 'Goes on'}: ${job.what}`)
  } catch (error) { api.failed(error) }
}

/**
 * The strips of pictures, which are many and quick, as one job.
 * @param {Job[]} jobs
 * @returns {Job[]}
 */
function folded(jobs) {
  const own = (/** @type {Job} */ job) => job.kind === 'strip' && job.state !== 'failed'
  const strips = jobs.filter(own), left = strips.filter(job => !ended(job)), states = strips.map(job => job.state)
  if (strips.length < 2) return jobs
  const state = (/** @type {Job['state'][]} */ (['running', 'queued', 'done', 'cancelled'])).find(one => states.includes(one)) ?? 'done'
  const all = { ...strips[0], id: STRIPS, what: 'pictures of sheep', state, done: strips.length - left.length, of: strips.length }
  return [...jobs.filter(job => !own(job)), { ...all, per_second: null, left_s: null, cost_s: null, log: [], paused: false, can_pause: false }]
}

/** @type {MakeView} */
export function view(root, store, api, shell) {
  /** @type {Map<Job['id'], ReturnType<typeof jobRow>>} */ const rows = new Map()
  let open = false
  const summary = make('h2', {}), told = make('p', { class: 'note' }), list = make('ol', { class: 'jobs' })
  const pause = quiet('Pause', () => { hold() }), launch = button('Render what is missing…', () => { render() })
  const draft = make('input', { type: 'checkbox' })
  root.append(make('div', { class: 'bar' }, make('div', { class: 'grow heading' }, summary, told),
    make('label', { class: 'tick' }, draft, 'as a draft'), launch, pause), list)

  /** @param {Job['id']} id */
  async function cancel(id) {
    try {
      if (id === STRIPS) for (const job of store.state.jobs) if (job.kind === 'strip' && !ended(job)) await api.delete(`/api/jobs/${encodeURIComponent(job.id)}`)
      if (id !== STRIPS) await api.delete(`/api/jobs/${encodeURIComponent(id)}`)
      shell.say(`Cancelled: ${store.state.jobs.find(job => job.id === id)?.what ?? 'pictures'}`)
    } catch (error) { api.failed(error) }
  }

  async function hold() {
    const paused = !store.state.paused
    try {
      await api.post('/api/jobs/pause', { paused })
      store.state.paused = paused
      store.tell('jobs')
      shell.say(paused ? 'Paused: clips wait, what somebody looks at goes on' : 'Work goes on')
    } catch (error) { api.failed(error) }
  }

  async function render() {
    const what = { kind: 'render', all_missing: true, draft: draft.checked }
    try {
      const { clips, cost_s: cost, left_out: items = [] } = await api.post('/api/jobs', { ...what, dry: true })
      if (!clips) return shell.say(items[0] ?? 'Every clip is there', items.length > 0)
      const yes = await shell.ask({ title: `Render ${spoken(clips, 'clip')}?`, text: `${cost === null ? 'How long it takes is not known yet' : `About ${lasting(cost)} on this computer`}${draft.checked ? ', as drafts' : ''}. It can be paused, and goes on after a restart.${items.length ? ' Left out:' : ''}`, items, yes: 'Render' })
      if (!yes) return
      const { jobs } = await api.post('/api/jobs', what)
      for (const job of jobs) store.job(job)
      shell.say(`${spoken(clips, 'clip')} queued`)
    } catch (error) { api.failed(error) }
  }

  /**
   * `jobs` with what takes long first. While the pointer is on the list, the rows that are there keep their places: it
   * would press what it did not aim at.
   * @param {Job[]} jobs
   */
  function inOrder(jobs) {
    const rank = (/** @type {Job} */ job) => 2 * ORDER.indexOf(job.state) + Number(['strip', 'middles'].includes(job.kind))
    const sorted = [...jobs].sort((a, b) => rank(a) - rank(b))
    if (!list.matches(':hover')) return sorted
    const places = new Map([...list.children].map((row, at) => [row instanceof HTMLElement ? row.dataset.job : '', at]))
    const place = (/** @type {Job} */ job) => places.get(String(job.id)) ?? places.size
    return sorted.sort((a, b) => place(a) - place(b))
  }

  function show() {
    const { paused, transitions, sheep } = store.state, jobs = folded(store.state.jobs)
    const shown = inOrder(jobs).filter((job, _, all) => !ended(job) || all.filter(ended).indexOf(job) < MOST_DONE)
    const busy = jobs.filter(job => !ended(job)), left = busy.reduce((sum, job) => sum + (job.left_s ?? job.cost_s ?? 0), 0)
    const missing = [...transitions, ...sheep].filter(one => one.state === 'missing').length
    summary.textContent = busy.length ? `${spoken(busy.length, 'job')}${paused ? ', paused' : ''}` : 'Nothing to do'
    told.textContent = [left ? `about ${lasting(left)} left` : '', missing ? `${spoken(missing, 'clip')} not rendered` : busy.some(job => job.kind === 'render') ? '' : 'every clip is there'].filter(Boolean).join(' · ')
    // It is what to do next only while something is missing.
    launch.className = missing ? 'strong' : 'quiet'
    pause.textContent = paused ? 'Go on' : 'Pause'
    pause.setAttribute('aria-pressed', String(paused))
    for (const [id, { row }] of rows) if (!shown.some(job => job.id === id)) { row.remove(); rows.delete(id) }
    const held = list.contains(document.activeElement) ? document.activeElement : null
    shown.forEach((job, at) => {
      const row = rows.get(job.id) ?? jobRow(cancel, (id, paused) => { holdJob(api, id, paused) })
      rows.set(job.id, row)
      row.update(job)
      if (list.children[at] !== row.row) list.insertBefore(row.row, list.children[at] ?? null)
    })
    // A row that is moved loses the focus.
    if (held instanceof HTMLElement && held !== document.activeElement) held.focus({ preventScroll: true })
    root.dataset.state = 'ready'
  }

  /** @param {number} by */
  function move(by) {
    const all = [...list.children], now = all.findIndex(row => row.contains(document.activeElement)), next = all[Math.max(0, Math.min(all.length - 1, now + by))]
    if (next instanceof HTMLElement) next.focus()
  }

  /** The job with the focus. */
  function chosen() {
    const row = document.activeElement?.closest('.job')
    return row instanceof HTMLElement ? folded(store.state.jobs).find(one => String(one.id) === row.dataset.job) : undefined
  }

  list.addEventListener('pointerleave', () => { if (open) show() })
  store.on(['jobs', 'state'], () => { if (open) show() })
  return {
    async enter() {
      open = true
      show()
      try {
        const { jobs, paused } = await api.get('/api/jobs')
        Object.assign(store.state, { jobs, paused })
        store.tell('jobs')
      } catch (error) { api.failed(error) }
    },
    leave() { open = false },
    keys: [
      { keys: ['ArrowUp', 'ArrowDown'], does: 'another job', run: event => move(event.key === 'ArrowUp' ? -1 : 1) },
      { keys: ['Delete', 'x'], does: 'cancel it', hint: 'cancel', run: () => { const job = chosen(); if (job && !ended(job)) cancel(job.id) } },
      { keys: ['Shift+P'], does: 'pause this one, or let it go on', run: () => { const job = chosen(); if (job?.can_pause) holdJob(api, job.id, !job.paused) } },
      { keys: ['p'], does: 'pause all clips, or go on', hint: 'pause', run: () => { hold() } },
      { keys: ['d'], does: 'as drafts, or as the genomes say', hint: 'as drafts', run: () => { draft.checked = !draft.checked; shell.say(draft.checked ? 'Clips will be drafts' : 'Clips will be as their genomes say') } },
      { keys: ['r'], does: 'render what is missing', hint: 'render what is missing', run: () => { render() } },
    ],
  }
}
