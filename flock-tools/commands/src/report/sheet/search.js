// The sheep that are furthest from their wants, and those that are searched for, in figures.

const FOUND = 50
// The soonest return is not known here: the flock is not walked.
const told = columns.filter(([name]) => name !== 'soonest')

function fill(table, caption, places) {
  const head = ['sheep', ...told.map(([name]) => name)].map(name => make('th', { scope: 'col' }, name))
  const rows = places.map(at => {
    sheep[at].colour ??= shade(sheep[at])
    return make('tr', looked(at), rowHead(at), ...told.map(([, , words]) => make('td', {}, words(sheep[at]))))
  })
  table.replaceChildren(make('caption', {}, caption), make('thead', {}, make('tr', {}, ...head)), make('tbody', {}, ...rows))
}

function drawWorst() {
  $('#worst').hidden = flock.worst.length === 0
  $('#worst h2').textContent = `The ${flock.worst.length} furthest from their wants`
  fill($('#worst table'), $('#worst h2').textContent, flock.worst.map(({ at }) => at))
}

// The places of the sheep with `word` in their ids: the one called so first, then those whose ids begin with it.
let lowered = null
function found(word) {
  lowered ??= sheep.map(one => one.id.toLowerCase())
  const ranks = [[], [], []]
  lowered.forEach((id, at) => {
    const where = id.indexOf(word)
    if (where >= 0) ranks[where > 0 ? 2 : id.length > word.length ? 1 : 0].push(at)
  })
  return ranks.flat()
}

function search() {
  const word = $('#query').value.trim().toLowerCase()
  const places = word ? found(word) : []
  $('#search .note').textContent = !word ? `Any of the ${digits(sheep.length)}, by its id or a part of it.`
    : places.length === 0 ? 'No id has that in it.'
    : places.length > FOUND ? `The first ${FOUND} of ${digits(places.length)}.`
    : `${spoken(places.length, 'sheep')} found.`
  $('#search .scroll').hidden = places.length === 0
  fill($('#search table'), 'The sheep that were found', places.slice(0, FOUND))
}

// A sheep that is chosen anywhere on the page is searched for.
function showChosen(at) {
  if (at === null || at !== looking.chosen) return
  $('#query').value = sheep[at].id
  search()
}
