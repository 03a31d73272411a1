// The top: the flock's name, its figures, its faults.

function lead() {
  if (!sheep.length) return 'There are no sheep yet: dreams add puts them in.'
  const parts = [`${spoken(figures.sheep, 'sheep')} and ${spoken(figures.transitions, 'transition')}`]
  if (!flock.day) return `${parts[0]}. ${alone()}`
  parts.push(`a visit every ${minutes(figures.step_minutes)}, on average`, variety())
  return `${parts.filter(Boolean).join('; ')}. ${furthest()}`
}

// What is shown of a flock without a cycle
function alone() {
  const [still] = shown()
  return `No transitions lead round, so there is nothing to walk yet: a unit shows ${still ? `the loop of ${still.id} again and again` : 'nothing'}.`
}

// How much the walk repeats itself
function variety() {
  if (shown().length === 1) return 'always of the same sheep'
  // The page of a large flock has neither its transitions nor a walk.
  if (flock.day === true) return ''
  if (!choosing().length) return `always the same ${digits(shown().length)} sheep in the same order, for there is no choice of transitions`
  const repeat = flock.day.repeat_minutes
  return `in a walk of ${minutes(flock.day.minutes)} ${repeat ? `the longest part that came twice takes about ${minutes(repeat)}` : 'no transition came twice'}`
}

function furthest() {
  const never = sheep.filter(one => one.want && !one.visits)
  if (never.length === 1) return `${never[0].id} is never shown.`
  if (never.length) return `${spoken(never.length, 'sheep')} are never shown.`
  const worst = sheep.reduce((a, b) => off(b) > off(a) ? b : a)
  return off(worst) < 1.01 ? `${sheep.length === 1 ? 'It' : 'Every sheep'} is shown as ${often} as wished.`
    : `Furthest from its want is ${worst.id}, shown ${against(worst)}.`
}

const off = one => !one.want ? 1 : one.visits ? Math.max(one.visits / one.want, one.want / one.visits) : Infinity

function drawHead() {
  $('#name').textContent = named
  $('#lead').textContent = lead()
  const clips = figures.clips_there === null ? digits(figures.clips) : `${digits(figures.clips_there)} of ${digits(figures.clips)}`
  const middle = !flock.day ? NaN : sheep.map(one => one.return_minutes ?? Infinity).sort((a, b) => a - b)[Math.floor(sheep.length / 2)]
  const told = [
    ['worst ratio', !sheep.length ? '–' : flock.worst_ratio === null ? 'a sheep is never shown' : `${flock.worst_ratio < 10 ? flock.worst_ratio.toFixed(2) : times(flock.worst_ratio)} ×`, 'the sheep that is furthest from its want; 1 is perfect'],
    ['evenness', shown().length ? `${digits(2 ** figures.entropy_bits, figures.entropy_bits < 7 ? 1 : 0)} of ${digits(figures.sheep)}` : '–', `as varied as so many sheep that are shown equally often: ${digits(figures.entropy_bits, 3)} of ${digits(figures.most_bits, 3)} bits`],
    ['unique material', minutes(figures.material_seconds / 60), 'all clips, each once'],
    ['a sheep comes back after', Number.isNaN(middle) ? '–' : minutes(Number.isFinite(middle) ? middle : null), 'the sheep in the middle, on average'],
    [figures.clips_there === null ? 'clips' : 'clips there', clips, `${flock.size.join(' × ')} at ${digits(SECOND)} frames per second`],
  ]
  $('#figures').append(...told.map(([name, value, meaning]) =>
    make('div', { title: meaning }, make('dt', {}, name), make('dd', {}, value))))
  $('#faults').hidden = flock.faults.length === 0
  $('#faults ul').append(...flock.faults.map(fault => make('li', {}, make('b', {}, fault.kind), ` ${fault.message}`)))
  $('footer').textContent = `${named} · ${flock.size.join(' × ')} · ${flock.fps[1] === 1 ? flock.fps[0] : flock.fps.join('/')} frames per second · drawn by dreams report`
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
