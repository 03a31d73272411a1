// The frame of the page: session, views, addresses, top line, bottom line, layers.
//
// # A view
//
// A view is a module with one function, of the type `MakeView` in `types.d.ts`:
//
//     /** @type {MakeView} */
//     export function view(root, store, api, shell) {
//       // Called once, when the view is first opened. `root` is its empty <section>, which stays when it is left.
//       return {
//         enter(params) {},  // It is shown now, or its address changed meanwhile: `#/walk?seed=7` gives params.get('seed').
//         leave() {},        // It is hidden: end timers, videos, frames. Subscriptions should do nothing while it is hidden.
//         keys: [{ keys: ['j', 'ArrowLeft'], does: 'one frame back', hint: 'back', when: () => true, run: event => {} }],
//       }
//     }
//
// * A view sets `root.dataset.state = 'ready'` when its first data is drawn. A sheep that can be chosen has `data-sheep`, an arrow
//   `data-from` and `data-to`; the focused one has `aria-selected` and the tab stop. `<body data-view>` names the view.
// * The address of a view is `#/NAME?params`. `shell.go('walk', { from: id })` opens one, with an entry in the history;
//   `shell.note({ seed: '7' })` writes the address of this view without an entry, and does not call `enter`.
// * `store.state` is the program's document (`types.d.ts`), `store.byId`, `store.outs`, `store.ins`, `store.byWay` index it.
//   `store.on(['state', 'sheep', 'jobs', 'focus', 'moving', 'supposed'], changed => {})` tells of changes.
//   `store.supposed` is the answer to a what-if while a hand is on a slider or over a target. Objects are replaced by a new
//   state: keep ids, not sheep. `store.focus` is the one sheep that all views look at, `store.look(id)` moves it.
// * `api.edit(edits, gesture)`, `api.whatIf(edits)`, `api.mark(ids, what)`, `api.step('undo')`, `api.get/post/delete(path)`.
//   `api.edit` and `api.mark` say what happened themselves; around others: `try { } catch (error) { api.failed(error) }`.
// * `shell.say(sentence, bad)`, `await shell.ask({ title, text, items, yes })`, `shell.over(element, { label, keys, closed })`,
//   `shell.moving()`.
// * Elements: `make`, `draw`, `button`, `icon`, `styled` of `dom.js`; words for numbers of `words.js`; moving pictures:
//   `shell.strips.show(canvas, sheep)`. Styles only by class or through `styled`; text only as text.
// * Style: classes of `look.css` in its second part: `.bar` (a line of controls), `.card`, `.quiet` and `.strong` (buttons),
//   `.chip`, `.note`, `.figure`, `.empty`, `.split` (a stage and a `.panel` beside it), `.rows`. The style of all views but the
//   Wall and the Graph is in `views.css`.
// * `loopOf(video, key, fps)` of `mse.js` plays one clip again and again without a gap; it returns what ends it.

import { $, button, icon, make } from './dom.js'
import { Keys, written } from './keys.js'
import { Api, Refused } from './api.js'
import { Store } from './store.js'
import { Strips } from './strip.js'
import { spoken, times, why } from './words.js'

/** @type {{name: string, title: string, load: () => Promise<{view: MakeView}>}[]} */
const VIEWS = [
  { name: 'wall', title: 'Wall', load: () => import('./wall.js') },
  { name: 'graph', title: 'Graph', load: () => import('./graph.js') },
  { name: 'walk', title: 'Walk', load: () => import('./walk.js') },
  { name: 'breed', title: 'Breed', load: () => import('./breed.js') },
  { name: 'lineage', title: 'Lineage', load: () => import('./lineage.js') },
  { name: 'globe', title: 'Globe', load: () => import('./globe.js') },
  { name: 'jobs', title: 'Jobs', load: () => import('./jobs.js') },
  { name: 'ship', title: 'Ship', load: () => import('./ship.js') },
]
const LETTERS = { wall: 'w', graph: 'g', walk: 'p', breed: 'b', lineage: 'l', globe: 'o', jobs: 'j', ship: 's' }

const store = new Store()
const api = new Api(store)
const keys = new Keys()
/** @type {Map<string, {root: HTMLElement, view: View}>} */
const made = new Map()
let current = ''
let opening = 0

/** @param {string} name @param {Record<string, string>} params */
function address(name, params) {
  const query = new URLSearchParams(Object.entries(params).filter(([, value]) => value !== '')).toString()
  return `#/${name}${query ? `?${query}` : ''}`
}

/** @type {Shell} */
const shell = {
  go: (name, params = {}) => {
    const to = address(name, params)
    if (location.hash === to) open()
    else location.hash = to
  },
  note: params => history.replaceState(null, '', address(current, params)),
  say, ask, over,
  moving: () => store.moving,
  strips: new Strips(store),
}

/** The view of the address, and its params. */
function asked() {
  const [name, query = ''] = location.hash.replace(/^#\/?/, '').split('?')
  return { found: VIEWS.find(one => one.name === name) ?? VIEWS[0], query }
}

async function open() {
  const { found, query } = asked()
  const mine = ++opening
  if (!made.has(found.name)) {
    try {
      const module = await found.load()
      if (!made.has(found.name)) {
        const root = make('section', { class: `view ${found.name}`, 'aria-label': found.title, hidden: true })
        $('#views').append(root)
        made.set(found.name, { root, view: module.view(root, store, api, shell) })
      }
    } catch (error) {
      say(`Cannot open ${found.title}: ${why(error)}`, true)
      return
    }
  }
  if (mine !== opening) return
  const next = made.get(found.name)
  if (!next) return
  if (current && current !== found.name) {
    const last = made.get(current)
    last?.view.leave()
    if (last) last.root.hidden = true
  }
  next.root.hidden = false
  current = found.name
  document.body.dataset.view = current
  keys.view = next.view.keys
  document.title = `${found.title} · ${store.state.name || 'studio'}`
  for (const link of document.querySelectorAll('#rail a')) {
    link.toggleAttribute('aria-current', link.getAttribute('href') === `#/${current}`)
  }
  next.view.enter(new URLSearchParams(query))
  drawKeys()
}

/** @type {ReturnType<typeof setTimeout> | undefined} */
let quiet
/** @param {string} text @param {boolean} [bad] */
function say(text, bad = false) {
  const line = $('#said')
  line.textContent = text
  line.classList.toggle('bad', bad)
  line.title = text
  document.body.classList.toggle('saying', text !== '')
  clearTimeout(quiet)
  if (text) quiet = setTimeout(() => say(''), bad ? 12000 : 6000)
}

/** @param {HTMLElement} content @param {{label: string, keys?: Key[], closed?: () => void}} options */
function over(content, { label, keys: own = [], closed }) {
  const before = document.activeElement
  const dialog = make('dialog', { class: 'over', 'aria-label': label, tabindex: -1 }, content)
  const pop = keys.push(own)
  let open = true
  const close = () => {
    if (!open) return
    open = false
    pop()
    dialog.close()
    dialog.remove()
    if (before instanceof HTMLElement && before.isConnected) before.focus({ preventScroll: true })
    closed?.()
  }
  // A field for a file that was left without a choice says the same, and means itself.
  dialog.addEventListener('cancel', event => { if (event.target === dialog) { event.preventDefault(); close() } })
  dialog.addEventListener('click', event => { if (event.target === dialog) close() })
  document.body.append(dialog)
  dialog.showModal()
  if (!content.querySelector('[autofocus]')) dialog.focus()
  dialog.scrollTop = 0
  return close
}

/** @param {Question} question @returns {Promise<boolean>} */
function ask(question) {
  const { title, text, items = [], yes, tick } = question
  return new Promise(resolve => {
    let answer = false
    const most = 12
    const done = (/** @type {boolean} */ said) => { answer = said; close() }
    const close = over(make('div', { class: 'question' },
      make('h2', {}, title), text && make('p', {}, text),
      items.length > 0 && make('ul', {}, ...items.slice(0, most).map(item => make('li', {}, item)), items.length > most && make('li', {}, `and ${items.length - most} more`)),
      tick && make('label', { class: 'tick' }, make('input', { type: 'checkbox', checked: question.ticked, onchange: (/** @type {Event} */ event) => { question.ticked = event.target instanceof HTMLInputElement && event.target.checked } }), tick),
      make('div', { class: 'bar end' }, button('Cancel', () => done(false), { class: 'quiet', autofocus: true }), button(yes, () => done(true), { class: 'strong' }))),
    { label: title, closed: () => resolve(answer) })
  })
}

function drawRail() {
  $('#rail').append(...VIEWS.map(({ name, title }) => make('a', { href: `#/${name}`, title: `${title} (G ${LETTERS[/** @type {keyof typeof LETTERS} */ (name)].toUpperCase()})` },
    icon(/** @type {any} */ (name)), make('span', {}, title))))
}

const undo = button('Undo', () => api.step('undo'), { icon: 'undo', class: 'tool' })
const redo = button('Redo', () => api.step('redo'), { icon: 'redo', class: 'tool' })
const still = button('Stop all pictures', () => store.move(!store.moving), { icon: 'still', class: 'tool' })
const help = button('All keys', () => showKeys(), { icon: 'keys', class: 'tool' })

function drawTop() {
  const { name, faults, jobs, paused } = store.state
  const figures = store.supposed?.figures ?? store.state.figures
  $('#name').textContent = name || 'A flock without a name'
  const parts = [make('span', {}, spoken(figures.sheep, 'sheep')), make('span', {}, spoken(figures.transitions, 'transition')),
    figures.shown < figures.sheep && make('span', {}, `${figures.sheep - figures.shown} never shown`),
    figures.worst_ratio !== null && make('span', {}, 'worst ratio ', make('b', { 'data-figure': 'worst_ratio' }, times(figures.worst_ratio)))]
  $('#lead').classList.toggle('supposed', store.supposed !== null)
  $('#lead').replaceChildren(...parts.flatMap(part => part ? [part] : []))
  const bad = $('#faults')
  bad.hidden = !faults.length
  bad.replaceChildren(icon('fault'), make('span', {}, spoken(faults.length, 'fault')))
  const own = jobs.filter(job => job.kind !== 'strip'), running = own.filter(job => job.state === 'running'), waiting = own.filter(job => job.state === 'queued').length
  const busy = $('#busy')
  busy.hidden = !running.length && !waiting
  const first = running[0]
  busy.textContent = paused ? `paused, ${waiting} waiting` : first ? `${first.what}${first.of ? ` ${Math.round(100 * first.done / first.of)} %` : ''}${running.length + waiting > 1 ? `, ${running.length + waiting - 1} more` : ''}` : `${waiting} waiting`
  for (const [control, what, does] of /** @type {const} */ ([[undo, store.state.undo, 'Undo'], [redo, store.state.redo, 'Redo']])) {
    control.toggleAttribute('disabled', what === null)
    control.title = what === null ? `Nothing to ${does.toLowerCase()}` : `${does}: ${what}`
    control.setAttribute('aria-label', control.title)
  }
  still.replaceChildren(icon(store.moving ? 'still' : 'play'))
  still.title = store.moving ? 'Stop all pictures' : 'Let pictures move'
  still.setAttribute('aria-label', still.title)
  $('#offline').hidden = store.online
}

function showFaults() {
  const list = make('ul', { class: 'rows' }, ...store.state.faults.map(fault => make('li', {}, make('b', {}, fault.kind), ` ${fault.message}`,
    fault.sheep !== undefined && button(`look at ${fault.sheep}`, () => { close(); store.look(fault.sheep ?? null); shell.go('graph', { at: fault.sheep ?? '' }) }, { class: 'quiet' }))))
  const close = over(make('div', { class: 'question wide' }, make('h2', {}, spoken(store.state.faults.length, 'fault')), list,
    make('div', { class: 'bar end' }, button('Close', () => close(), { class: 'quiet', autofocus: true }))), { label: 'Faults' })
}

/** @param {Key} key */
const caps = key => make('span', { class: 'caps' }, ...key.keys.slice(0, 1).map(name => make('kbd', {}, written(name))))

function drawKeys() {
  const hinted = keys.view.filter(key => key.hint)
  $('#hints').replaceChildren(...hinted.map(key => make('span', {}, caps(key), ` ${key.hint}`)))
}

function showKeys() {
  const title = VIEWS.find(one => one.name === current)?.title ?? ''
  const list = (/** @type {Key[]} */ all) => make('dl', {}, ...all.map(key => make('div', { class: 'keyed' }, make('dt', {}, ...key.keys.map(name => make('kbd', {}, written(name)))), make('dd', {}, key.does))))
  const close = over(make('div', { class: 'question wide keys' }, make('h2', {}, 'Keys'), make('h3', {}, `In ${title}`), list(keys.view), make('h3', {}, 'Everywhere'), list(keys.page),
    make('div', { class: 'bar end' }, button('Close', () => close(), { class: 'quiet' }))), { label: 'Keys', keys: [{ keys: ['?'], does: 'close', run: () => close() }] })
}

keys.page = [
  ...VIEWS.map(({ name, title }, at) => ({ keys: [`g ${LETTERS[/** @type {keyof typeof LETTERS} */ (name)]}`, `Alt+${at + 1}`], does: title, run: () => shell.go(name) })),
  { keys: ['z', 'Mod+z'], does: 'undo', run: () => { api.step('undo') } },
  { keys: ['Shift+Z', 'Mod+Shift+Z', 'Mod+y'], does: 'redo', run: () => { api.step('redo') } },
  { keys: ['!'], does: 'stop all pictures, or let them move', run: () => store.move(!store.moving) },
  { keys: ['?'], does: 'all keys', run: showKeys },
]

/** @param {unknown} [error] why; without one the key is not good */
function close(error) {
  const locked = !error || error instanceof Refused && (error.status === 401 || error.status === 403)
  $('#closed').replaceChildren(make('h2', {}, locked ? 'This page needs its key' : 'The studio does not answer'),
    make('p', {}, locked ? 'Open the whole address that dreams studio printed, with all after the #.' : why(error)))
  $('#closed').hidden = false
}

async function signIn() {
  try {
    await api.open()
    return true
  } catch (error) {
    close(error)
    return false
  }
}

/** Another view, or the address of a program that was started anew. */
async function moved() {
  const view = location.hash === '' || location.hash.startsWith('#/')
  if (!view && !await signIn()) return
  $('#closed').hidden = true
  await open()
}

async function start() {
  api.said = say
  api.confirm = ask
  api.locked = close
  const reduced = matchMedia('(prefers-reduced-motion: reduce)')
  store.moving = !reduced.matches
  reduced.addEventListener('change', () => store.move(!reduced.matches))
  drawRail()
  $('#tools').append(undo, redo, still, help)
  $('#faults').addEventListener('click', showFaults)
  store.on(['state', 'sheep', 'jobs', 'moving', 'online', 'supposed'], drawTop)
  addEventListener('hashchange', moved)
  // The view's code comes while the program is asked; what is wrong with it is said when it is opened.
  asked().found.load().catch(() => {})
  if (await signIn()) await open()
}

start()
