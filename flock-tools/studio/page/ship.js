// Whether the flock may go to the walls, and what goes: faults, joins, credits, size, what is new; then pack and publish.
//
// Never asks for a passphrase: that is asked on the terminal where the program runs, and here is said so.

import { button, make } from './dom.js'
import { dim, labelled, quiet } from './parts.js'
import { ended, holdJob, jobRow } from './jobs.js'
import { digits, spoken } from './words.js'

const KINDS = ['check', 'joins', 'pack', 'publish']

/** @param {number} bytes */
const size = bytes => bytes < 1e6 ? `${digits(bytes / 1e3, 0)} kB` : bytes < 1e9 ? `${digits(bytes / 1e6, bytes < 1e7 ? 1 : 0)} MB` : `${digits(bytes / 1e9)} GB`

/** @type {MakeView} */
export function view(root, store, api, shell) {
  /** @type {Map<Job['id'], ReturnType<typeof jobRow>>} */ const rows = new Map()
  /** @type {ShipAnswer | null} */ let told = null
  let open = false, busy = '', began = Date.now()
  const title = make('h2', {}), why = make('ul', { class: 'rows why' }), jobs = make('ol', { class: 'jobs' }), cards = make('div', { class: 'cards' })
  const key = make('input', { class: 'field', id: 'ship-key', list: 'ship-keys', autocomplete: 'off', placeholder: 'name of a key' }), keys = make('datalist', { id: 'ship-keys' })
  const units = make('input', { class: 'field', id: 'ship-units', autocomplete: 'off', placeholder: 'every unit', title: 'Names of units, between commas; every unit that trusts the key if there are none' })
  // Only what the program has told: no request names a path.
  /** @type {HTMLSelectElement} */ const to = make('select', { class: 'field', id: 'ship-to' })
  const pack = button('Pack', () => { sign() }, { class: 'strong' })
  const jumps = make('input', { type: 'checkbox', onchange: () => told && draw(told) }), although = make('label', { class: 'tick', hidden: true }, jumps, 'although joins jump')
  const publish = quiet('Publish', () => { start('publish', { to: to.value }) })
  root.append(
    make('div', { class: 'bar' }, make('div', { class: 'grow' }, title, why), quiet('Check', () => { start('check', { joins: false }) }), quiet('Check the joins too', () => { start('check', { joins: true }) })),
    jobs, cards,
    make('div', { class: 'card send' }, make('h3', {}, 'Send it'), make('p', { class: 'note' }, 'The bundle is signed with your key. Its passphrase is given on the terminal where dreams studio runs, never here.'),
      make('div', { class: 'bar' }, labelled('Signed by', key, keys), labelled('for units', units), although, pack, make('span', { class: 'grow' }), labelled('To', to), publish)))

  async function fetch() {
    try {
      told = /** @type {ShipAnswer} */ (await api.get('/api/ship'))
      draw(told)
    } catch (error) { api.failed(error) }
  }

  /** @param {'check' | 'pack' | 'publish'} what @param {Record<string, any>} body */
  async function start(what, body) {
    if (body.key === '') { key.focus(); return shell.say('Which key signs it?', true) }
    if (body.to === '') { to.focus(); return shell.say('Where does it go? Mount a stick, or start the studio with --to FOLDER', true) }
    try {
      const { job } = await api.post(`/api/ship/${what}`, body)
      store.job(job)
    } catch (error) { api.failed(error) }
  }

  const sign = () => start('pack', { key: key.value.trim(), units: units.value.split(/[\s,]+/).filter(Boolean), allow_jumps: jumps.checked })

  /** @param {Job['id']} id */
  async function cancel(id) {
    try { await api.delete(`/api/jobs/${encodeURIComponent(id)}`) } catch (error) { api.failed(error) }
  }

  /** @param {string} name @param {string} figure @param {...(Node | string | null | false)} more */
  const card = (name, figure, ...more) => make('section', { class: 'card' }, make('h3', {}, name), make('p', { class: 'figure' }, figure), ...more)

  /** @param {ShipAnswer} answer */
  function draw({ faults, joins, credits, bytes, files, packed, difference, ready, why_not: reasons, keys: known = [], targets: places = [] }) {
    title.textContent = ready ? 'Ready for the walls' : 'Not ready yet'
    why.replaceChildren(...reasons.map(reason => make('li', {}, reason)))
    // Joins that jump are a matter of taste, all else is not.
    although.hidden = !joins?.jumps || reasons.length > 1
    pack.disabled = !ready && (although.hidden || !jumps.checked)
    pack.title = ready ? '' : reasons.join('; ')
    keys.replaceChildren(...known.map(value => make('option', { value })))
    const before = to.value
    to.replaceChildren(...places.length ? places.map(value => make('option', { value }, value)) : [make('option', { value: '' }, 'a stick that is mounted, or --to FOLDER')])
    if (places.includes(before)) to.value = before
    if (!key.value && known.length === 1) key.value = known[0]
    const people = new Set(credits.flatMap(({ authors }) => authors)).size
    const changes = difference ? /** @type {[string, string[]][]} */ ([['new', difference.added], ['gone', difference.removed], ['changed', difference.changed]]) : []
    const changed = changes.reduce((sum, [, ids]) => sum + ids.length, 0)
    cards.replaceChildren(
      card('Faults', faults.length ? spoken(faults.length, 'fault') : 'None', make('ul', { class: 'rows scroll' }, ...faults.map(fault => make('li', {}, fault.message)))),
      card('Joins', joins ? joins.jumps ? `${digits(joins.jumps)} of ${digits(joins.judged)} jump` : `all ${digits(joins.judged)} meet` : 'not checked', joins && joins.worst !== null && make('p', { class: 'note' }, `the worst takes ${Math.round(100 * joins.worst)} % of what is allowed`),
        make('p', {}, quiet('Look at them', () => shell.go('walk', { show: 'joins' })))),
      card('Credits', people ? spoken(people, 'person').replace('persons', 'people') : 'nobody is named', make('ul', { class: 'rows scroll' }, ...credits.map(({ licence, sheep, authors }) => make('li', {}, make('b', {}, licence ?? 'no licence'), `, ${spoken(sheep, 'sheep')}`, dim(authors.length ? `: ${authors.join(', ')}` : ''))))),
      card('Size', size(bytes), make('p', { class: 'note' }, spoken(files, 'file'))),
      card(packed ? 'Since the last bundle' : 'What is new', difference ? changed ? spoken(changed, 'change') : 'nothing' : packed ? 'not known' : 'everything',
        make('p', { class: 'note' }, difference ? '' : packed ? 'Check compares the flock as it is now' : 'nothing is packed yet'), make('ul', { class: 'rows scroll' }, ...changes.filter(([, ids]) => ids.length).map(([what, ids]) => make('li', {}, make('b', {}, what), ` ${ids.slice(0, 40).join(', ')}${ids.length > 40 ? ` and ${ids.length - 40} more` : ''}`)))))
    root.dataset.state = 'ready'
  }

  function showJobs() {
    const shown = store.state.jobs.filter(job => KINDS.includes(job.kind) && (!ended(job) || rows.has(job.id)))
    for (const [id, { row }] of rows) if (!shown.some(job => job.id === id)) { row.remove(); rows.delete(id) }
    for (const job of shown) {
      const row = rows.get(job.id) ?? jobRow(cancel, (id, paused) => { holdJob(api, id, paused) })
      if (!rows.has(job.id)) jobs.append(row.row)
      rows.set(job.id, row)
      row.update(job)
    }
    jobs.hidden = !shown.length
    // What they found is asked for when one of them has ended.
    const now = shown.map(({ id, state }) => `${id} ${state}`).join()
    if (busy !== now && Date.now() - began > 100) fetch()
    busy = now
  }

  store.on(['jobs'], () => { if (open) showJobs() })
  store.on(['state'], () => { if (open) { showJobs(); fetch() } })
  return {
    enter() { open = true; began = Date.now(); showJobs(); fetch() },
    leave() { open = false },
    keys: [
      { keys: ['c'], does: 'check', hint: 'check', run: () => { start('check', { joins: false }) } },
      { keys: ['Shift+C'], does: 'check the joins too', run: () => { start('check', { joins: true }) } },
      { keys: ['p'], does: 'pack', hint: 'pack', when: () => !pack.disabled, run: () => { sign() } },
      { keys: ['u'], does: 'publish', hint: 'publish', run: () => { start('publish', { to: to.value }) } },
    ],
  }
}
