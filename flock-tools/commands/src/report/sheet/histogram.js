// How many sheep have which ratio of visits and want, and which return time.

const TIMES = [0.5, 1, 2, 5, 10, 30, 60, 180, 480, 1440, 4320, 14400, 43200, 144000, 525600, 5256000]

// Bars of `count`, `colour` and `words` side by side; a line over them for the counts of `outline`; a text below at each part
// of the width that `ticks` has, unless one before it in the list takes its room.
function histogram(chart, label, bars, ticks, outline = []) {
  const width = Math.max(260, chart.clientWidth), floor = 170, step = width / bars.length
  const most = Math.max(1, ...bars.map(bar => bar.count), ...outline)
  const top = count => floor - (count ? Math.max(2, (floor - 10) * count / most) : 0)
  const bar = ({ count, colour, words }, place) => draw('g', {
    onpointermove: event => tell(event, make('span', {}, make('b', {}, spoken(count, 'sheep')), ` ${words}`)), onpointerout: hush,
  }, draw('rect', { class: 'back', x: place * step, y: 0, width: step, height: floor }),
  draw('rect', { x: place * step, y: top(count), width: 0.86 * step, height: floor - top(count), style: { fill: colour } }))
  const line = outline.map((count, place) => `${place ? 'L' : 'M'}${place * step} ${top(count)}h${step}`).join('')
  const taken = []
  const texts = ticks.map(([part, text]) => {
    const half = 3.3 * text.length, x = Math.max(half, Math.min(width - half, part * width))
    if (taken.some(other => Math.abs(other.x - x) < other.half + half + 6)) return ''
    taken.push({ x, half })
    return draw('text', { x, y: floor + 18 }, text)
  })
  chart.replaceChildren(draw('svg', { viewBox: `0 0 ${width} ${floor + 24}`, width, height: floor + 24, role: 'img', 'aria-label': label },
    ...bars.map(bar), draw('line', { class: 'axis', x1: 0, x2: width, y1: floor, y2: floor }),
    outline.length ? draw('path', { class: 'outline', d: line }) : '', ...texts))
}

function drawRatios() {
  const { reach: widest, written, balanced, never } = flock.ratios, middle = (written.length - 1) / 2
  const ratio = place => 2 ** (widest * (place - middle) / middle)
  const bars = written.map((count, place) => {
    const one = { visits: ratio(place), want: 1 }, outermost = place === 0 || place === written.length - 1
    return { count, colour: shade(one), words: place === middle ? `about as ${often} as wished` : `about ${against(one)}${outermost ? ', or more' : ''}` }
  })
  const powers = [0, -4, 4, -2, 2, -6, 6, -1, 1, -3, 3, -5, 5].filter(power => Math.abs(power) <= widest)
  const ticks = powers.map(power => [0.5 + power / widest * (middle / written.length), power < 0 ? `1/${2 ** -power}` : power ? `${2 ** power} \u00d7` : 'as wished'])
  const parts = [`Sheep of the bars to the right are shown ${oftener} than wished, those of the bars to the left ${seldomer}.`]
  if (balanced) parts.push('The line is the same with the weights of dreams balance.')
  if (flock.balanced) parts.push(reach(flock.balanced), bottleneck(flock.balanced))
  if (never) parts.push(`${digits(never)} never shown.`)
  $('#ratios .note').textContent = parts.filter(Boolean).join(' ')
  histogram($('#ratios .chart'), `How many sheep are shown how many times as ${often} as wished`, bars, ticks, balanced ?? undefined)
}

function drawReturns() {
  const back = sheep.map(one => one.return_minutes).filter(time => time !== null).map(Math.log)
  $('#returns').hidden = back.length === 0 || !flock.day
  if ($('#returns').hidden) return
  const low = back.reduce((a, b) => Math.min(a, b)) - 0.1, high = back.reduce((a, b) => Math.max(a, b)) + 0.1
  const counts = new Array(60).fill(0)
  for (const time of back) counts[Math.floor((time - low) / (high - low) * counts.length)]++
  const at = place => Math.exp(low + (high - low) * place / counts.length)
  const bars = counts.map((count, place) => ({ count, colour: 'var(--even)', words: `after ${minutes(at(place))} to ${minutes(at(place + 1))}` }))
  const ticks = TIMES.map(time => [(Math.log(time) - low) / (high - low), minutes(time)]).filter(([part]) => part > 0 && part < 1)
  ticks.push([0, minutes(at(0))], [1, minutes(at(counts.length))])
  $('#returns .note').textContent = 'The mean time from one visit to the next, for every sheep.'
  histogram($('#returns .chart'), 'How many sheep come back after how long', bars, ticks)
}
