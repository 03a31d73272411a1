// What all parts of a page use: elements, words for sheep, and the sheep that is looked at. Words for numbers are those of
// the studio's page.

// Shares and wants are of all visits, or of the time on screen, where a sheep without a loop has neither.
const [often, seldom, oftener, seldomer] =
  flock.by === 'time' ? ['long', 'short', 'longer', 'shorter'] : ['often', 'seldom', 'more often', 'more seldom']

// The sheep that are visited. A loop without a way on is never visited again, and by time a sheep without a loop has no
// share.
const isShown = one => one.visits || one.return_minutes
const shown = () => sheep.filter(isShown)

const $ = selector => document.querySelector(selector)

function fitted(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined) continue
    if (name === 'style') element.style.cssText = value
    else if (name.startsWith('on')) element.addEventListener(name.slice(2), value)
    else element.setAttribute(name, value)
  }
  element.append(...children)
  return element
}
const make = (name, attributes = {}, ...children) => fitted(document.createElement(name), attributes, children)
const draw = (name, attributes = {}, ...children) =>
  fitted(document.createElementNS('http://www.w3.org/2000/svg', name), attributes, children)

// An image of a sheep, or its colour if there is none. The text beside it says what it shows, so `alt` is empty.
const picture = (at, name = '') => sheep[at].picture
  ? make('img', { src: sheep[at].picture, alt: name, decoding: 'async' })
  : make('span', { class: 'swatch', style: `background: ${sheep[at].colour}` })

// For a column: so many decimals that all are in line, or two digits of a very small one
const inLine = ratio => ratio < 0.01 ? ratio.toPrecision(2) : ratio.toFixed(3)

// share/want, in words
function against(one) {
  if (!one.want) return 'without a loop'
  if (!one.visits) return 'never shown'
  const ratio = one.visits / one.want
  if (ratio > 0.99 && ratio < 1.01) return `as ${often} as wished`
  return ratio > 1 ? `${times(ratio)} times as ${often} as wished` : `${times(1 / ratio)} times less than wished`
}

// How far a sheep is from its want: -1 is a quarter of it or less, 1 four times or more.
const tilt = one => !one.want ? 0 : one.visits ? Math.max(-1, Math.min(1, Math.log2(one.visits / one.want) / 2)) : -1
const tint = one => {
  const off = tilt(one)
  return `color-mix(in oklab, var(${off < 0 ? '--seldom' : '--often'}) ${Math.round(100 * Math.sqrt(Math.abs(off)))}%, var(--even))`
}

// The sheep that is looked at: under the pointer, else the one that was chosen.
const looking = { chosen: null, at: null, tellers: [] }
function look(at) {
  at ??= looking.chosen
  if (at === looking.at) return
  looking.at = at
  for (const tell of looking.tellers) tell(at)
}
function choose(at) {
  looking.chosen = looking.chosen === at ? null : at
  looking.at = NaN
  look(null)
}
const looked = at => ({
  onpointerenter: event => event.pointerType === 'mouse' && look(at),
  onpointerleave: event => event.pointerType === 'mouse' && look(null),
  onclick: event => { event.stopPropagation(); choose(at) },
})
addEventListener('keydown', event => event.key === 'Escape' && looking.chosen !== null && choose(looking.chosen))

// A word beside the pointer
const tip = $('#tip')
function tell(event, ...children) {
  tip.hidden = false
  tip.replaceChildren(...children)
  const { width, height } = tip.getBoundingClientRect()
  const left = Math.max(8, Math.min(event.clientX + 14, innerWidth - width - 8))
  const below = event.clientY + 18 + height < innerHeight
  tip.style.translate = `${left}px ${below ? event.clientY + 18 : event.clientY - height - 14}px`
}
const hush = () => { tip.hidden = true }
