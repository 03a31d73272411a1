// Shares against wants.

// The most sheep that each have a row; of more, only those that are furthest off.
const ROWS = 40, FURTHEST = 12

function drawShares() {
  const order = sheep.map((_, at) => at).sort((a, b) => ratio(sheep[b]) - ratio(sheep[a]) || a - b)
  const chart = $('#shares .chart')
  const widest = Math.max(0.5, ...sheep.map(one => Math.min(4, Math.abs(Math.log2(ratio(one) || 1 / 16)))))
  const never = sheep.filter(one => one.want && !one.visits).length
  const [more, less] = order.length <= ROWS ? ['to the right', 'to the left'] : ['upwards', 'downwards']
  $('#shares .note').textContent = `Bars ${more} are shown ${oftener} than wished, bars ${less} ${seldomer}; the end of the scale is ${digits(2 ** widest, 1)} times.` + (never ? ` ${spoken(never, 'sheep')} ${never === 1 ? 'is' : 'are'} never shown.` : '')
  const row = at => shareRow(at, widest)
  $('#shares').className = order.length <= ROWS ? 'half' : 'wide'
  if (order.length <= ROWS) return chart.replaceChildren(make('div', { class: 'rows' }, ...order.map(row)))
  const list = (title, part) => make('div', { class: 'one-sided' }, make('h3', {}, title),
    make('div', { class: 'rows' }, ...part.map(at => shareRow(at, widest, true))))
  chart.replaceChildren(skyline(order, widest), make('div', { class: 'two' },
    list('Shown most above their wants', order.slice(0, FURTHEST)), list('Shown most below their wants', order.slice(-FURTHEST).reverse())))
}

// With `oneSided`, all bars begin at the left and have the full width.
function shareRow(at, widest, oneSided = false) {
  const one = sheep[at], off = one.visits || !one.want ? Math.max(-widest, Math.min(widest, Math.log2(ratio(one)))) : -widest
  const length = (oneSided ? 100 : 50) * Math.abs(off) / widest, edge = oneSided ? { left: 0 } : { [off < 0 ? 'right' : 'left']: '50%' }
  const bar = make('div', { class: 'off' }, make('i', {
    style: { ...edge, width: `max(2px, ${length.toFixed(2)}%)`, background: shade(one) },
  }))
  return make('button', { class: 'sheep row', 'data-at': at, ...looked(at) }, picture(at), make('span', { class: 'id' }, one.id), bar,
    make('span', { class: 'figure' }, make('b', {}, percent(one.visits)), ` of ${percent(one.want)}`))
}

// All sheep side by side, one thin bar each
function skyline(order, widest) {
  const [width, height] = [1000, 150], step = width / order.length
  const bars = order.map((at, place) => {
    const one = sheep[at], off = one.visits || !one.want ? Math.max(-widest, Math.min(widest, Math.log2(ratio(one)))) : -widest
    const tall = Math.max(1, Math.abs(off) / widest * height / 2)
    return draw('g', { 'data-at': at, ...looked(at),
      onpointermove: event => tell(event, picture(at), make('span', {}, make('b', {}, one.id), ` ${against(one)}`)), onpointerout: hush },
    draw('rect', { class: 'back', x: place * step, y: 0, width: step, height }),
    draw('rect', { x: place * step, y: off > 0 ? height / 2 - tall : height / 2, width: Math.max(0.5, 0.82 * step), height: tall, style: { fill: shade(one) } }))
  })
  return draw('svg', { class: 'skyline', viewBox: `0 0 ${width} ${height}`, preserveAspectRatio: 'none', role: 'img', 'aria-label': 'All sheep from the one shown most above its want to the one shown most below it' },
    ...bars, draw('line', { x1: 0, x2: width, y1: height / 2, y2: height / 2 }))
}

function markShares(at) {
  for (const marked of document.querySelectorAll('#shares .here, #returns .here')) marked.classList.remove('here')
  if (at === null) return
  for (const mark of document.querySelectorAll(`#shares [data-at="${at}"], #returns [data-at="${at}"]`)) mark.classList.add('here')
}
