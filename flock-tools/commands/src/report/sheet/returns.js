// The return times of sheep.

const TICKS = [0.5, 1, 2, 5, 10, 20, 30, 60, 120, 240, 480, 960, 1440, 2880, 7200, 14400, 43200, 144000]

function drawReturns() {
  const back = sheep.map((one, at) => ({ one, at })).filter(({ one }) => one.visits && one.return_minutes !== null)
  const section = $('#returns')
  section.hidden = back.length === 0 || !flock.day
  if (section.hidden) return
  back.sort((a, b) => a.one.return_minutes - b.one.return_minutes || a.at - b.at)
  const soonest = Math.min(...sheep.map(one => one.returns?.soonest ?? Infinity))
  const few = sheep.length <= ROWS
  section.className = few ? 'half' : 'wide'
  $('#returns .note').textContent = !Number.isFinite(soonest)
    ? 'The mean time from one visit to the next, for every sheep that is shown.' : few
    ? `The dot is the mean time from one visit to the next, the line runs from the soonest to the longest in a walk of ${minutes(flock.day.minutes)}.`
    : `The mean time from one visit to the next, for every sheep that is shown. In a walk of ${minutes(flock.day.minutes)}, the soonest that any of them came back was after ${minutes(soonest)}.`
  $('#returns .chart').replaceChildren(few ? spans(back) : piles(back))
}

// A row for every sheep: a line from its soonest return to its longest, a dot at the mean.
function spans(back) {
  const ends = back.flatMap(({ one }) => [one.returns?.soonest, one.returns?.longest, one.return_minutes]).filter(time => time > 0)
  const low = Math.log(Math.min(...ends)) - 0.1, high = Math.log(Math.max(...ends)) + 0.1
  const part = time => `${(100 * (Math.log(time) - low) / (high - low)).toFixed(2)}%`
  return make('div', { class: 'rows' }, ...back.map(({ one, at }) => {
    const { soonest, longest } = one.returns ?? { soonest: one.return_minutes, longest: one.return_minutes }
    return make('button', { class: 'sheep row', title: `${minutes(soonest)} to ${minutes(longest)}`, 'data-at': at, ...looked(at) }, picture(at), make('span', { class: 'id' }, one.id),
      make('div', { class: 'span' }, make('i', { style: { left: part(soonest), right: `calc(100% - ${part(longest)})` } }),
        make('b', { style: { left: part(one.return_minutes), background: one.colour } })),
      make('span', { class: 'figure' }, make('b', {}, minutes(one.return_minutes))))
  }))
}

// Every sheep a dot; dots of equal return times are stacked.
function piles(back) {
  const width = Math.max(300, $('#returns .chart').clientWidth)
  const times = back.map(({ one }) => Math.log(one.return_minutes))
  const low = times[0] - 0.3, high = times.at(-1) + 0.3
  const size = Math.max(3, Math.min(13, 0.35 * Math.sqrt(width * 220 / back.length))), pitch = 2 * size + 1
  const x = time => 24 + (width - 48) * (Math.log(time) - low) / (high - low)
  const height = new Map()
  const dots = back.map(({ one, at }) => {
    const column = Math.round(x(one.return_minutes) / pitch), level = height.get(column) ?? 0
    height.set(column, level + 1)
    return { one, at, cx: column * pitch, level }
  })
  const floor = Math.max(...height.values()) * pitch + 8
  const ticks = TICKS.filter(tick => Math.log(tick) > low && Math.log(tick) < high)
  return draw('svg', { viewBox: `0 0 ${width} ${floor + 24}`, width, height: floor + 24, role: 'img', 'aria-label': 'Mean return times of all sheep; the table below has the figures' },
    draw('line', { class: 'axis', x1: 0, x2: width, y1: floor, y2: floor }),
    ...ticks.map(tick => draw('text', { x: x(tick), y: floor + 18 }, minutes(tick))),
    ...dots.map(({ one, at, cx, level }) => draw('circle', {
      cx, cy: floor - 5 - size - level * pitch, r: size, fill: one.colour, 'data-at': at, ...looked(at),
      onpointermove: event => tell(event, picture(at), make('span', {}, make('b', {}, one.id), ` ${minutes(one.return_minutes)}`)), onpointerout: hush,
    })))
}
