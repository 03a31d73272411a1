// The shares as written, or with the weights of `dreams balance`.

const written = {
  sheep: sheep.map(one => [one.visits, one.return_minutes, one.minutes_a_day]),
  transitions: transitions.map(one => one.visits),
  returns: sheep.map(one => one.returns),
}

function drawWeighing() {
  const balanced = flock.balanced
  if (!balanced) return
  $('#weighing').hidden = false
  const buttons = document.querySelectorAll('#weighing button')
  buttons.forEach((button, which) => { button.onclick = () => weigh(which ? balanced : written, buttons, which) })
  $('#weighing .note').textContent = [reach(balanced), bottleneck(balanced)].filter(Boolean).join(' ')
}

const worst = ratio => ratio === null ? 'a sheep is never shown' : times(ratio)

function reach(balanced) {
  const [before, after] = [worst(figures.worst_ratio), worst(balanced.worst_ratio)]
  return before === after ? `The weights are balanced: the worst ratio is ${after}.`
    : `With the weights of dreams balance the worst ratio would be ${after} instead of ${before}.`
}

function bottleneck({ bottleneck }) {
  if (!bottleneck) return ''
  return `No weights reach every want: ${spoken(bottleneck.sheep.length, 'sheep')} ${bottleneck.sheep.length === 1 ? 'is' : 'are'} wanted ${percent(bottleneck.want)} of all visits, ` +
    `all they lead to, ${spoken(bottleneck.followers, 'sheep')}, only ${percent(bottleneck.followers_want)}.`
}

function weigh(weighed, buttons, which) {
  buttons.forEach((button, at) => button.setAttribute('aria-pressed', at === which))
  sheep.forEach((one, at) => {
    [one.visits, one.return_minutes, one.minutes_a_day] = weighed.sheep[at]
    one.returns = weighed === written ? written.returns[at] : null
  })
  transitions.forEach((one, at) => { one.visits = weighed.transitions[at] })
  drawGraph()
  drawShares()
  drawReturns()
  drawTable()
  const at = looking.at
  looking.at = NaN
  look(at)
}
