// The document of a large flock, unpacked to what the other parts of the page expect.

const flock = JSON.parse(document.getElementById('facts').textContent)
const { figures } = flock
// A million transitions are not on the page.
const transitions = []
// With more transitions than sheep some have a choice of ways on
const choosing = () => figures.transitions > figures.sheep ? shown() : []
const named = flock.name || 'without a name'
const SECOND = flock.fps[0] / flock.fps[1]
const DIGITS = '0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz-_'

const bytes = text => Uint8Array.from(atob(text), letter => letter.charCodeAt(0))

// A column as a function of the place: the number that all have, one of a few, or the upper bytes of a 32-bit float
function column({ same, few, many }) {
  if (few) {
    const [numbers, places] = [few[0], bytes(few[1])]
    return at => numbers[places[at]]
  }
  if (!many) return () => same
  const upper = bytes(many), float = new Float32Array(1), bits = new Uint32Array(float.buffer)
  return at => {
    bits[0] = upper[3 * at] << 24 | upper[3 * at + 1] << 16 | upper[3 * at + 2] << 8
    return float[0]
  }
}

// Ids: a digit tells how many characters each has in common with the one before it.
function unpacked(ids) {
  let id = ''
  return ids.split(' ').map(entry => {
    id = id.slice(0, DIGITS.indexOf(entry[0])) + entry.slice(1)
    return id
  })
}

// With the figures that follow from the others
function derived(one) {
  one.return_minutes = one.visits ? figures.step_minutes / one.visits : null
  one.minutes_a_day = one.visits && 24 * one.visits * one.frames / SECOND / figures.step_minutes
  return one
}

const [visits, want, frames, leadsTo, comesFrom] =
  [flock.visits, flock.want, flock.frames, flock.leads_to, flock.comes_from].map(column)
const sheep = unpacked(flock.ids).map((id, at) => derived({
  id, visits: visits(at), want: want(at), frames: frames(at), leads_to: leadsTo(at), comes_from: comesFrom(at),
}))
for (const { at, ...exact } of flock.worst) derived(Object.assign(sheep[at], exact))
if (flock.by === 'time') {
  const lit = sheep.reduce((sum, one) => sum + one.minutes_a_day, 0)
  for (const one of sheep) one.visits = lit && one.minutes_a_day / lit
}
