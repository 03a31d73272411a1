// All sheep in figures, to be read, sorted and copied.

const columns = [
  ['sheep', one => one.id, one => one.id],
  ['share', one => one.visits, one => percent(one.visits)],
  ['want', one => one.want, one => percent(one.want)],
  ['share / want', one => ratio(one), one => !one.want ? '–' : one.visits ? inLine(ratio(one)) : 'never'],
  ['lit a day', one => one.minutes_a_day, one => one.frames ? minutes(one.minutes_a_day) : 'no loop'],
  ['comes back after', one => one.return_minutes ?? Infinity, one => minutes(one.return_minutes)],
  ['soonest', one => one.returns?.soonest ?? Infinity, one => one.returns ? minutes(one.returns.soonest) : '–'],
  ['leads to', (_, at) => leaves[at].length, (_, at) => leaves[at].length],
  ['comes from', (_, at) => enters[at].length, (_, at) => enters[at].length],
]
const sorted = { by: 0, up: true }

function drawTable() {
  const head = columns.map(([name], column) => make('th', { scope: 'col' }, make('button', { onclick: () => sortBy(column) }, name)))
  const rows = sheep.map((one, at) => make('tr', { 'data-at': at, ...looked(at) },
    make('th', { scope: 'row' }, make('span', { class: 'sheep' }, picture(at), make('span', { class: 'id' }, one.id))),
    ...columns.slice(1).map(([, , told]) => make('td', {}, String(told(one, at))))))
  $('#all table').replaceChildren(make('caption', {}, `The ${sheep.length === 1 ? 'one' : digits(sheep.length)} sheep of ${flock.name || 'this flock'}`), make('thead', {}, make('tr', {}, ...head)), make('tbody', {}, ...rows))
  sortBy(sorted.by, sorted.up)
}

function markTable(at) {
  for (const row of document.querySelectorAll('#all tbody tr')) row.classList.toggle('here', Number(row.dataset.at) === at)
}

function sortBy(column, up = sorted.by === column ? !sorted.up : column === 0) {
  Object.assign(sorted, { by: column, up })
  const value = row => columns[column][1](sheep[row.dataset.at], Number(row.dataset.at))
  const body = $('#all tbody')
  body.append(...[...body.rows].sort((a, b) => {
    const [x, y] = [value(a), value(b)]
    return (up ? 1 : -1) * (x < y ? -1 : x > y ? 1 : 0) || a.dataset.at - b.dataset.at
  }))
  $('#all thead').querySelectorAll('th').forEach((head, at) => {
    head.setAttribute('aria-sort', at !== column ? 'none' : up ? 'ascending' : 'descending')
  })
}
