// What all parts of a page use: words for sheep, and the sheep that is looked at. Elements, colours and words for numbers are
// those of the studio's page.

// Shares and wants are of all visits, or of the time on screen, where a sheep without a loop has neither.
const [often, seldom, oftener, seldomer] =
  flock.by === 'time' ? ['long', 'short', 'longer', 'shorter'] : ['often', 'seldom', 'more often', 'more seldom']

// The sheep that are visited. A loop without a way on is never visited again, and by time a sheep without a loop has no
// share.
const isShown = one => one.visits || one.return_minutes
const shown = () => sheep.filter(isShown)

const $ = selector => document.querySelector(selector)

// An image of a sheep, or its colour if there is none. The text beside it says what it shows, so `alt` is empty.
const picture = (at, name = '') => sheep[at].picture
  ? make('img', { src: sheep[at].picture, alt: name, decoding: 'async' })
  : make('span', { class: 'swatch', style: { background: sheep[at].colour } })

// share/want, in words and as a colour
const against = one => one.want ? asWished(one.visits / one.want, often) : 'without a loop'
const shade = one => tint(one.want ? tiltOf(one.visits / one.want) : 0)

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
