// Beside the graph: the sheep that is looked at, or how to read the drawing.

const panel = $('#panel')

function pair(name, value) {
  return [make('dt', {}, name), make('dd', {}, value)]
}

// Transitions as lines with the sheep at their other end; `part` is the fraction of each.
function lines(title, list, end) {
  const total = list.reduce((sum, one) => sum + one.visits, 0)
  const sorted = [...list].sort((a, b) => b.visits - a.visits)
  const line = one => make('li', {}, make('button', { class: 'sheep', ...looked(one[end]) },
    picture(one[end]), make('span', {}, sheep[one[end]].id), make('span', { class: 'dim' }, total ? percent(one.visits / total) : '–')))
  return [make('h3', {}, title), make('ul', {}, ...sorted.map(line))]
}

function showPanel(at) {
  if (at === null) return panel.replaceChildren(...legend())
  const one = sheep[at]
  const widest = Math.max(one.visits, one.want) || 1
  const bar = make('div', { class: 'bar' },
    make('i', { style: { width: `${100 * one.visits / widest}%`, background: shade(one) } }),
    make('b', { style: { left: `calc(${100 * one.want / widest}% - 1px)` } }))
  panel.replaceChildren(
    one.picture ? make('figure', {}, make('img', { src: one.picture, alt: `${one.id}, its first frame` })) : '',
    make('h3', { class: 'id' }, one.id), make('p', { class: 'against' }, against(one)), bar,
    make('dl', {}, ...pair('share', percent(one.visits)), ...pair('want', percent(one.want)),
      ...pair('lit a day', one.frames ? minutes(one.minutes_a_day) : 'no loop'),
      ...pair('comes back after', minutes(one.return_minutes)),
      ...one.returns ? pair('soonest, longest', `${minutes(one.returns.soonest)}, ${minutes(one.returns.longest)}`) : [],
      ...one.frames ? pair('a visit', `${minutes(one.frames / SECOND / 60)}${one.repeat > 1 ? `, ${one.repeat} loops` : ''}`) : [],
      ...creditPairs(at)),
    ...lines(leaves[at].length ? `leads to ${leaves[at].length}` : 'leads nowhere', leaves[at], 'to'),
    ...lines(enters[at].length ? `comes from ${enters[at].length}` : 'nothing leads to it', enters[at], 'from'),
  )
}

function legend() {
  const sign = (...parts) => draw('svg', { viewBox: '-20 -20 40 40', width: 40, height: 40, 'aria-hidden': true }, ...parts)
  const row = (drawing, text) => make('div', { class: 'key' }, drawing, make('p', {}, text))
  const disc = (r, fill) => draw('circle', { r, style: { fill } })
  return [
    make('h3', {}, 'How to read it'),
    row(sign(disc(15, 'var(--even)')), `A disc is a sheep. Its area is its share of ${flock.by === 'time' ? 'the time that loops are on screen' : 'all visits'}.`),
    row(sign(disc(9, 'var(--seldom)'), draw('circle', { class: 'want', r: 16 })), `The dashed ring is its want. This one is shown too ${seldom}.`),
    row(sign(disc(16, 'var(--often)'), draw('circle', { class: 'want', r: 9 })), `This one is shown too ${often}.`),
    row(sign(draw('path', { class: 'arrow', style: { '--strength': 1, '--ease': .6 }, d: 'M-17 10Q-2 -14 9 -4L7 -8L17 2L4 3L8 0Q-2 -8 -17 13Z' })), 'An arrow is a transition, the broader the more often it is taken.'),
    make('div', { class: 'scale' }, make('span', {}, '¼'), make('i'), make('span', {}, '4 ×')),
    make('p', { class: 'dim small' }, 'share against want'),
    make('p', { class: 'dim' }, 'Point at a sheep, or tap it, to see where it leads; a click keeps it. All of this page follows. Ctrl and the wheel bring the flock nearer.'),
  ]
}

function drawPanel() {
  looking.tellers.push(showPanel)
  showPanel(null)
}
