// Transitions worth rendering, with their costs.

function drawSuggested() {
  const suggested = flock.suggested
  if (!suggested) return
  $('#suggested').hidden = false
  $('#suggested .note').textContent = suggested.length === 1
    ? 'The transition that would bring the flock nearest to its wants, balanced by dreams balance.' : suggested.length
    ? 'Transitions that would bring the flock nearer to its wants, balanced by dreams balance. Each is the best one after those above it; the worst ratio is that with all of them.'
    : 'No transition more would bring the flock nearer to its wants than dreams balance does.'
  $('#suggested .ways').replaceChildren(...suggested.map(wayOf))
}

function wayOf(one) {
  const costs = [`${digits(one.frames)} frames, ${digits(one.seconds, 1)} s`]
  if (one.samples) costs.push(`${digits(one.samples / 1e9)} billion samples to render`)
  if (one.bytes) costs.push(`about ${digits(one.bytes / 1e6, 1)} MB`)
  return make('li', looked(one.from),
    make('b', {}, `${sheep[one.from].id} to ${sheep[one.to].id}`), `: ${one.worst_ratio === null ? 'a sheep is still never shown' : `worst ratio ${times(one.worst_ratio)}`}; ${costs.join(', ')}`)
}
