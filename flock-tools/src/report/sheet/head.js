// The top: the flock's name, its figures, its faults.

function spoken(items, of) {
  return `${digits(items)} ${of}${items === 1 ? '' : of === 'sheep' ? '' : 's'}`
}

function lead() {
  const parts = [`${spoken(figures.sheep, 'sheep')} and ${spoken(figures.transitions, 'transition')}`]
  if (flock.day) parts.push(`a new sheep every ${minutes(figures.step_minutes)}, and never the same evening twice`)
  const worst = sheep.reduce((a, b) => off(b) > off(a) ? b : a)
  if (!flock.day) return `${parts[0]}. There is no way round yet that a wall could walk.`
  const told = off(worst) < 1.01 ? 'Every sheep is shown as often as wished'
    : worst.visits ? `Furthest from its want is ${worst.id}, shown ${against(worst)}` : `${worst.id} is never shown`
  return `${parts.join('; ')}. ${told}.`
}

const off = one => one.visits ? Math.max(one.visits / one.want, one.want / one.visits) : Infinity

function drawHead() {
  $('#name').textContent = flock.name || 'without a name'
  $('#lead').textContent = lead()
  const clips = figures.clips_there === null ? digits(figures.clips) : `${digits(figures.clips_there)} of ${digits(figures.clips)}`
  const middle = sheep.map(one => one.return_minutes ?? Infinity).sort((a, b) => a - b)[Math.floor(sheep.length / 2)]
  const told = [
    ['worst ratio', figures.worst_ratio === null ? 'a sheep is never shown' : `${figures.worst_ratio < 10 ? figures.worst_ratio.toFixed(2) : times(figures.worst_ratio)} ×`, 'the sheep that is furthest from its want; 1 is perfect'],
    ['evenness', `${digits(2 ** figures.entropy_bits, 1)} of ${digits(figures.sheep)}`, `as varied as so many sheep that are shown equally often: ${digits(figures.entropy_bits, 3)} of ${digits(figures.most_bits, 3)} bits`],
    ['unique material', minutes(figures.material_seconds / 60), 'all clips, each once'],
    ['a sheep comes back after', Number.isFinite(middle) ? minutes(middle) : 'never', 'the sheep in the middle, on average'],
    [figures.clips_there === null ? 'clips' : 'clips there', clips, `${flock.size.join(' × ')} at ${digits(SECOND)} frames per second`],
  ]
  $('#figures').append(...told.map(([name, value, meaning]) =>
    make('div', { title: meaning }, make('dt', {}, name), make('dd', {}, value))))
  $('#faults').hidden = flock.faults.length === 0
  $('#faults ul').append(...flock.faults.map(fault => make('li', {}, make('b', {}, fault.kind), ` ${fault.message}`)))
  $('footer').textContent = `${flock.name} · ${flock.size.join(' × ')} · ${flock.fps[1] === 1 ? flock.fps[0] : flock.fps.join('/')} frames per second · drawn by flock report`
}

// Light, dark, or as the system has it. Stored if the browser lets a file store it.
const lights = ['as the system', 'light', 'dark']
function shine(light) {
  const root = document.documentElement
  if (light === lights[0]) root.removeAttribute('data-light')
  else root.dataset.light = light
  $('#light').textContent = `◐ ${light}`
  try { localStorage.setItem('flock-light', light) } catch { /* a file may have no storage */ }
}
function drawLight() {
  let light = lights[0]
  try { light = localStorage.getItem('flock-light') ?? light } catch { /* a file may have no storage */ }
  shine(lights.includes(light) ? light : lights[0])
  $('#light').onclick = () => {
    const now = lights.indexOf(document.documentElement.dataset.light ?? lights[0])
    shine(lights[(now + 1) % lights.length])
  }
}
