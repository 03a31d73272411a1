// The joins: for the worst ones the last frame of the one clip beside the first of the next.

function drawJoins() {
  const joins = flock.joins
  if (!joins) return
  $('#joins').hidden = false
  const found = joins.jumps && joins.judged === 1 ? 'The one join jumps.' : joins.jumps ? `${digits(joins.jumps)} of ${spoken(joins.judged, 'join')} ${joins.jumps === 1 ? 'jumps' : 'jump'}.`
    : joins.judged === 1 ? 'The one join meets.' : `All ${digits(joins.judged)} joins meet, in value and in velocity.`
  const unjudged = joins.unjudged ? ` ${spoken(joins.unjudged, 'join')} could not be judged: dreams check tells why.` : ''
  $('#joins .note').textContent = `${found}${unjudged}${below(joins)}`
  $('#joins .pairs').replaceChildren(...joins.worst.map(pairOf))
}

function below({ jumps, worst }) {
  if (!worst.length) return ''
  const one = worst.length === 1
  const which = one ? `is ${jumps ? 'the worst' : 'the one that comes nearest to a jump'}` : `are ${jumps ? 'the worst' : 'those that come nearest to a jump'}`
  return ` Below ${which}: the last frame of the one clip, the first of the next, and how much of what is allowed ${one ? 'it takes' : 'they take'}.`
}

function pairOf(join) {
  const jumps = join.severity > 1
  const [before, after] = join.frames
  const part = `${Math.round(100 * join.severity)}\u00a0%`
  return make('figure', { class: jumps ? 'pair jumps' : 'pair', ...join.at === null ? {} : looked(join.at) },
    make('div', { class: 'frames' },
      make('img', { src: before, alt: `the last frame of ${join.before}` }), make('img', { src: after, alt: `the first frame of ${join.after}` })),
    make('figcaption', {},
      make('p', { class: 'ends' }, make('span', {}, join.before), make('span', {}, join.after)),
      make('div', { class: 'bar', title: 'of what is allowed' }, make('i', { style: { width: `${Math.min(100, 50 * join.severity)}%` } }), make('b', { style: { left: 'calc(50% - 1px)' } })),
      make('p', { class: 'why' }, make('b', {}, jumps ? `jumps, ${part}` : part), ` ${join.why}`)))
}
