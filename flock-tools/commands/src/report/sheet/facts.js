// The document of the page, and the transitions of each sheep.

const flock = JSON.parse(document.getElementById('facts').textContent)
const { sheep, figures } = flock
const transitions = flock.transitions.map(([from, to, visits, frames]) => ({ from, to, visits, frames }))
const leaves = sheep.map(() => []), enters = sheep.map(() => [])
for (const transition of transitions) {
  leaves[transition.from].push(transition)
  enters[transition.to].push(transition)
}
sheep.forEach((one, at) => Object.assign(one, { leads_to: leaves[at].length, comes_from: enters[at].length }))
const SECOND = flock.fps[0] / flock.fps[1]
const named = flock.name || 'without a name'
const pictured = sheep.some(one => one.picture)

// The sheep that have a choice of ways on
const choosing = () => sheep.filter((one, at) => isShown(one) && leaves[at].filter(way => way.visits).length > 1)
