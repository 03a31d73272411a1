// A day of the walk as a ribbon: 24 rows, every visit in its sheep's colour, transitions in between.

const DAY = 86400, HOUR = 3600, ROWS_OF_DAY = 24
let pointed = false
const strip = { starts: [], rows: [], span: DAY }

// When each visit starts and its transition begins, in seconds from the start.
function timed(visits) {
  const frames = new Map(transitions.map(one => [one.from * sheep.length + one.to, one.frames]))
  let now = 0
  return visits.map((at, place) => {
    const starts = now, leavesAt = now + sheep[at].frames / SECOND
    const next = visits[place + 1]
    now = leavesAt + (next === undefined ? 0 : frames.get(at * sheep.length + next) / SECOND)
    return { at, starts, leavesAt, ends: now }
  })
}

function drawDay() {
  const section = $('#day')
  section.hidden = !flock.day
  if (!flock.day) return
  strip.starts = timed(flock.day.visits)
  const total = strip.starts.at(-1).ends
  section.hidden = !total
  if (!total) return
  strip.span = flock.day.whole ? DAY : total
  const different = new Set(flock.day.visits).size
  $('#day .note').textContent = `${flock.day.whole ? 'The first 24 hours' : `The first ${minutes(strip.span / 60)}`} of the walk with seed ${flock.day.seed}, as a unit plays them: ${spoken(flock.day.visits.length, 'visit')} of ${spoken(different, 'sheep')}. Each row is ${minutes(strip.span / ROWS_OF_DAY / 60)}.`
  const ribbon = $('#day .ribbon')
  const each = strip.span / ROWS_OF_DAY
  strip.rows = Array.from({ length: ROWS_OF_DAY }, (_, row) => {
    const lane = make('div', { class: 'lane', style: { background: coloured(row * each, (row + 1) * each) } })
    lane.addEventListener('pointermove', event => tellVisit(event, lane, row))
    lane.addEventListener('pointerleave', () => { hush(); pointed = false; look(null) })
    lane.addEventListener('click', event => choose(visitAt(event, lane, row).at))
    return lane
  })
  const hour = row => flock.day.whole ? `${String(row).padStart(2, '0')}:00` : minutes(row * each / 60)
  ribbon.replaceChildren(...strip.rows.flatMap((lane, row) => [make('span', { class: 'dim' }, row % 3 ? '' : hour(row)), lane]))
  ribbon.setAttribute('role', 'img')
  ribbon.setAttribute('aria-label', 'A day of the walk; how long each sheep is lit in it stands in the table below')
  looking.tellers.push(markDay)
}

// The first visit that has not ended at `time`
function at(time) {
  let [low, high] = [0, strip.starts.length - 1]
  while (low < high) {
    const middle = (low + high) >> 1
    if (strip.starts[middle].ends > time) high = middle
    else low = middle + 1
  }
  return low
}

// The colours from one time to another as a CSS gradient; a transition runs from colour to colour.
function coloured(from, to) {
  const stops = []
  const part = time => `${(100 * (time - from) / (to - from)).toFixed(2)}%`
  for (let place = at(from); place < strip.starts.length && strip.starts[place].starts < to; place++) {
    const { at, starts, leavesAt } = strip.starts[place]
    stops.push(`${sheep[at].colour} ${part(starts)} ${part(leavesAt)}`)
  }
  const next = strip.starts[at(to)]
  if (next && next.starts >= to) stops.push(`${sheep[next.at].colour} ${part(next.starts)}`)
  if (stops.length === 1) stops.push(stops[0])
  return `linear-gradient(to right in oklab, ${stops.join(', ')})`
}

function visitAt(event, lane, row) {
  const box = lane.getBoundingClientRect()
  const time = (row + (event.clientX - box.left) / box.width) * strip.span / ROWS_OF_DAY
  return { ...strip.starts[at(time)], time }
}

function tellVisit(event, lane, row) {
  const visit = visitAt(event, lane, row)
  pointed = true
  if (event.pointerType === 'mouse') look(visit.at)
  const clock = [visit.time / HOUR, visit.time / 60 % 60, visit.time % 60].map(part => String(Math.floor(part)).padStart(2, '0')).join(':')
  const next = strip.starts[strip.starts.indexOf(strip.starts[at(visit.time)]) + 1]
  const turning = visit.time > visit.leavesAt && next ? ` → ${sheep[next.at].id}` : ''
  tell(event, picture(visit.at), make('span', {}, make('b', {}, `${sheep[visit.at].id}${turning}`), ` ${clock}`))
}

// The visits of the sheep that is looked at, over a dimmed ribbon.
function markDay(looked) {
  // While the pointer is on the ribbon itself, it is not dimmed.
  if (pointed) looked = looking.chosen
  const each = strip.span / ROWS_OF_DAY
  $('#day .ribbon').classList.toggle('looking', looked !== null)
  strip.rows.forEach((lane, row) => {
    const marks = []
    if (looked !== null) {
      const [from, to] = [row * each, (row + 1) * each]
      for (let place = at(from); place < strip.starts.length && strip.starts[place].starts < to; place++) {
        const visit = strip.starts[place]
        if (visit.at !== looked) continue
        const left = Math.max(0, (visit.starts - from) / each), right = Math.min(1, (visit.leavesAt - from) / each)
        if (right >= left) marks.push(make('i', { style: { left: `${(100 * left).toFixed(2)}%`, width: `max(2px, ${(100 * (right - left)).toFixed(2)}%)`, background: sheep[looked].colour } }))
      }
    }
    lane.replaceChildren(...marks)
  })
}
