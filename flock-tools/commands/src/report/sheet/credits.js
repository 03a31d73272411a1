// Who made the flock, and under which licences.

const sales = { permitted: 'may be sold', forbidden: 'not for sale', unknown: 'not known to be for sale' }

function drawCredits() {
  const credits = flock.credits
  if (!credits) return
  $('#credits').hidden = false
  $('#credits .note').textContent = credits.attributions.length
    ? `Whoever shows this flock has to say: ${credits.attributions.join('; ')}.`
    : 'By the genomes, and by credits.toml in the folder of the flock.'
  const part = one => [one.sheep && spoken(one.sheep, 'sheep'), one.transitions && spoken(one.transitions, 'transition')].filter(Boolean).join(' and ')
  $('#credits .licences').replaceChildren(...credits.licences.map(one => make('li', {},
    make('b', {}, one.licence ?? 'no licence'), `: ${part(one)}, ${sales[one.sale]}`)))
  const more = credits.more_authors ? [make('li', {}, `and ${digits(credits.more_authors)} more`)] : []
  $('#credits .authors').replaceChildren(...credits.authors.map(([author, count]) => make('li', {},
    make('b', {}, author), `: ${spoken(count, 'sheep')}`)), ...more)
}

// What is known of a sheep, for the panel.
function creditPairs(at) {
  const credit = flock.credits?.sheep[at]
  if (!credit) return []
  return [
    ...credit.authors.length ? pair('by', credit.authors.join(', ')) : [],
    ...pair('licence', credit.licence ?? 'none'),
    ...credit.source ? pair('from', credit.source) : [],
    ...credit.parents.length ? pair('bred from', credit.parents.join(', ')) : [],
  ]
}
