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

function reach(balanced) {
  const [before, after] = [flock.worst_ratio, balanced.worst_ratio]
  // The page of a large flock has not the balanced shares; the same sheep are never shown with any weights.
  const never = sheep.filter((one, at) => one.want && !(balanced.sheep ? balanced.sheep[at][0] : one.visits))
  if (after === null) return `${never.length === 1 ? never[0].id : spoken(never.length, 'sheep')} ${never.length === 1 ? 'is' : 'are'} never shown, whatever the weights.`
  if (before === null) return `With the weights of dreams balance the worst ratio would be ${times(after)}.`
  if (times(before) === times(after)) return `Balancing does not change the worst ratio, which is ${times(after)}.`
  return after < before ? `With the weights of dreams balance the worst ratio would be ${times(after)} instead of ${times(before)}.`
    : `With the weights of dreams balance the worst ratio would be ${times(after)}, so dreams balance --write leaves the weights as they are, with ${times(before)}.`
}

// The sheep that are shown and wanted more than all that they lead to
function bottleneck({ bottleneck }) {
  if (!bottleneck?.sheep) return ''
  const [are, they] = bottleneck.sheep === 1 ? ['is', 'it leads'] : ['are', 'they lead']
  return `No weights reach every want: ${spoken(bottleneck.sheep, 'sheep')} ${are} wanted ${percent(bottleneck.want)} of all visits, ` +
    `all that ${they} to, ${spoken(bottleneck.followers, 'sheep')}, only ${percent(bottleneck.followers_want)}.`
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
