// What tables say of a sheep: a name, the figure that is sorted by, and its words.

const columns = [
  ['share', one => one.visits, one => percent(one.visits)],
  ['want', one => one.want, one => percent(one.want)],
  ['share / want', one => ratio(one), one => !one.want ? '–' : one.visits ? inLine(ratio(one)) : 'never'],
  ['lit a day', one => one.minutes_a_day, one => one.frames ? minutes(one.minutes_a_day) : 'no loop'],
  ['comes back after', one => one.return_minutes ?? Infinity, one => minutes(one.return_minutes)],
  ['soonest', one => one.returns?.soonest ?? Infinity, one => one.returns ? minutes(one.returns.soonest) : '–'],
  ['leads to', one => one.leads_to, one => digits(one.leads_to)],
  ['comes from', one => one.comes_from, one => digits(one.comes_from)],
]

const ratio = one => one.want ? one.visits / one.want : 1

// For a column: so many decimals that all are in line, or two digits of a very small one
const inLine = ratio => ratio < 0.01 ? ratio.toPrecision(2) : ratio.toFixed(3)

// The head of a row: the picture of a sheep and its id.
const rowHead = at => make('th', { scope: 'row' }, make('span', { class: 'sheep' }, picture(at), make('span', { class: 'id' }, sheep[at].id)))
