// The flock as a graph. A disc's area is the sheep's share, the dashed ring's its want, its colour their ratio; an
// arrow is the broader the more often the transition is taken. The outlines of arrows are those of the studio's page.

const stage = $('#flock svg')
const view = { width: 0, height: 0, unit: 0, margin: 0, zoom: 1, x: 0, y: 0 }
let discs = [], arrows = [], names = []

const place = one => [
  view.width / 2 + one.x * (view.width / 2 - view.margin),
  view.height / 2 - one.y * (view.height / 2 - view.margin - view.unit / 6) - view.unit / 6,
]
const radius = share => Math.max(0.28, Math.min(2.3, Math.sqrt(share * sheep.length))) * view.unit

function drawGraph() {
  const box = stage.parentElement.getBoundingClientRect()
  view.width = Math.max(280, box.width)
  view.height = Math.round(view.width < 560 ? view.width * 1.1 : Math.max(420, Math.min(0.68 * view.width, 760)))
  view.unit = Math.min(58, view.width / 9, 0.37 * Math.sqrt(view.width * view.height / 4 / sheep.length))
  view.margin = 6 + Math.max(...sheep.map(one => radius(Math.max(one.visits, one.want))))
  stage.setAttribute('viewBox', `0 0 ${view.width} ${view.height}`)
  stage.setAttribute('height', view.height)
  $('#graph-title').textContent = `${named}: ${spoken(sheep.length, 'sheep')}, ${spoken(transitions.length, 'transition')}. The table below tells the same in figures.`
  arrows = transitions.map(drawArrow)
  discs = sheep.map(drawDisc)
  names = view.unit > 15 ? sheep.map(drawName) : []
  const defs = draw('defs', {}, draw('clipPath', { id: 'round', clipPathUnits: 'objectBoundingBox' },
    draw('circle', { cx: 0.5, cy: 0.5, r: 0.5 })))
  const world = draw('g', { id: 'world' }, draw('g', { class: 'arrows' }, ...arrows), draw('g', { class: 'discs' }, ...discs),
    draw('g', { class: 'names' }, ...names))
  stage.replaceChildren($('#graph-title'), defs, world)
  moveTo(1, 0, 0)
  showLooked(looking.at)
}

function drawDisc(one, at) {
  const [x, y] = place(one), size = radius(one.visits), wished = radius(one.want)
  const group = draw('g', { class: 'disc', transform: `translate(${x.toFixed(1)} ${y.toFixed(1)})`, ...looked(at) })
  const shown = one.visits > 0
  group.append(draw('circle', { class: shown ? 'share' : 'share never', r: size.toFixed(1), style: { fill: shade(one), stroke: shade(one) } }))
  if (Math.abs(wished - size) > 1 + 0.06 * size) group.append(draw('circle', { class: view.unit > 15 ? 'want' : 'want thin', r: wished.toFixed(1) }))
  group.append(draw('circle', { class: 'near', r: Math.max(size, wished, 9) }))
  return group
}

// Pictures appear if discs are large enough to tell them apart: in a small flock, or zoomed in.
function dress() {
  if (view.unit * view.zoom < 14) return
  sheep.forEach((one, at) => {
    const size = radius(one.visits), disc = discs[at]
    if (!one.picture || disc.classList.contains('dressed')) return
    disc.classList.add('dressed')
    const inner = size - Math.max(1, 0.06 * size)
    disc.querySelector('.share').after(draw('image', {
      href: one.picture, x: -inner, y: -inner, width: 2 * inner, height: 2 * inner,
      preserveAspectRatio: 'xMidYMid slice', 'clip-path': 'url(#round)',
    }))
  })
}

function drawName(one) {
  const [x, y] = place(one)
  return draw('text', { x, y: y + Math.max(radius(one.visits), radius(one.want)) + 14 }, short(one.id))
}

function drawArrow({ from, to, visits }) {
  const width = Math.max(0.35, Math.min(5, 0.085 * view.unit * Math.sqrt(visits * transitions.length)))
  const strength = Math.min(1, 0.3 + 0.7 * visits * transitions.length / 4)
  return draw('path', {
    d: from === to ? around(circle(sheep[from]), width) : across(circle(sheep[from]), circle(sheep[to]), width),
    class: visits ? 'arrow' : 'arrow never', style: { '--strength': strength.toFixed(2) },
  })
}

const circle = one => { const [x, y] = place(one); return { x, y, r: radius(one.visits) } }

function showLooked(at) {
  stage.classList.toggle('looking', at !== null)
  for (const disc of [...discs, ...names]) disc.classList.remove('at', 'next', 'before')
  for (const arrow of arrows) arrow.classList.remove('out', 'in')
  if (at === null || !discs.length) return
  transitions.forEach(({ from, to }, which) => {
    if (from === at) { arrows[which].classList.add('out'); mark(to, 'next') }
    else if (to === at) { arrows[which].classList.add('in'); mark(from, 'before') }
  })
  mark(at, 'at')
}
function mark(at, how) {
  discs[at].classList.add(how)
  names[at]?.classList.add(how)
}

function moveTo(zoom, x, y) {
  const reach = (zoom - 1) / 2
  view.zoom = zoom
  view.x = Math.max(-reach * view.width, Math.min(reach * view.width, x))
  view.y = Math.max(-reach * view.height, Math.min(reach * view.height, y))
  const [cx, cy] = [view.width / 2, view.height / 2]
  $('#world').setAttribute('transform', `translate(${cx + view.x} ${cy + view.y}) scale(${zoom}) translate(${-cx} ${-cy})`)
  stage.classList.toggle('near', zoom > 1)
  // Many or near arrows are drawn lighter, so that the flock is visible through them.
  stage.style.setProperty('--ease', (Math.max(0.3, 0.6 - transitions.length / 400) / Math.sqrt(zoom)).toFixed(2))
  dress()
}
function zoomBy(factor, px = view.width / 2, py = view.height / 2) {
  const zoom = Math.max(1, Math.min(12, view.zoom * factor)), by = zoom / view.zoom
  const [dx, dy] = [px - view.width / 2, py - view.height / 2]
  moveTo(zoom, dx - by * (dx - view.x), dy - by * (dy - view.y))
}
function drawZoom() {
  for (const button of document.querySelectorAll('[data-zoom]')) {
    button.onclick = () => { const by = Number(button.dataset.zoom); by ? zoomBy(by) : moveTo(1, 0, 0) }
  }
  stage.addEventListener('wheel', event => {
    // The wheel scrolls the page; with Ctrl, or two fingers, it zooms the flock.
    if (!event.ctrlKey && !event.metaKey) return
    event.preventDefault()
    const box = stage.getBoundingClientRect()
    zoomBy(Math.exp(-event.deltaY / 200), event.clientX - box.left, event.clientY - box.top)
  }, { passive: false })
  let held = null
  stage.addEventListener('pointerdown', event => { if (view.zoom > 1) held = [event.clientX - view.x, event.clientY - view.y] })
  addEventListener('pointermove', event => { if (held) moveTo(view.zoom, event.clientX - held[0], event.clientY - held[1]) })
  addEventListener('pointerup', () => { held = null })
  stage.addEventListener('click', () => looking.chosen !== null && choose(looking.chosen))
  looking.tellers.push(showLooked)
}
