// All sheep in figures, to be read, sorted and copied.

const sortable = [['sheep', one => one.id], ...columns]
const sorted = { by: 0, up: true }

function drawTable() {
  const head = sortable.map(([name], column) => make('th', { scope: 'col' }, make('button', { onclick: () => sortBy(column) }, name)))
  const rows = sheep.map((one, at) => make('tr', { 'data-at': at, ...looked(at) },
    rowHead(at), ...columns.map(([, , told]) => make('td', {}, told(one)))))
  $('#all table').replaceChildren(make('caption', {}, `The ${sheep.length === 1 ? 'one' : digits(sheep.length)} sheep of ${flock.name || 'this flock'}`), make('thead', {}, make('tr', {}, ...head)), make('tbody', {}, ...rows))
  sortBy(sorted.by, sorted.up)
}

function markTable(at) {
  for (const row of document.querySelectorAll('#all tbody tr')) row.classList.toggle('here', Number(row.dataset.at) === at)
}

function sortBy(column, up = sorted.by === column ? !sorted.up : column === 0) {
  Object.assign(sorted, { by: column, up })
  const value = row => sortable[column][1](sheep[row.dataset.at])
  const body = $('#all tbody')
  body.append(...[...body.rows].sort((a, b) => {
    const [x, y] = [value(a), value(b)]
    return (up ? 1 : -1) * (x < y ? -1 : x > y ? 1 : 0) || a.dataset.at - b.dataset.at
  }))
  $('#all thead').querySelectorAll('th').forEach((head, at) => {
    head.setAttribute('aria-sort', at !== column ? 'none' : up ? 'ascending' : 'descending')
  })
}
