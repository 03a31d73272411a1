// L-system agents as `crates/agents` understands them: an agent's string, the walk along it, and the crossing of two.
//
// Owns the same interpreter as the program, so that visitors' children are what the program would draw. Never draws.
//
// It is here a second time because the globe walks along every agent again with another angle, three in each frame, and makes
// a child at the press: pictures from the program would be late and many. As WebAssembly it would need a second target and a
// build step, for 150 lines.
//
// Start at [`read`] and [`shape`]. Source: W. B. Langdon, Global Distributed Evolution of L-Systems Fractals (Pfeiffer, 2004).

const MOST_PUBLISHED = 2000, MOST_SEGMENTS = 20_000, MOST_ROUNDS = 64, MOST_STEPS = 400_000, DEEPEST = 200
const KOCH = "('F','F-F++F-F')"

/**
 * @typedef {{v: number, it: number, sc: number, w: number, c: number | null, sw: number, most: number, start: string, rules: Map<string, string>}} Agent
 * @typedef {{agent: Agent, text: string, strokes: number, x: number, y: number, reach: number, size: number, likeness: string}} Shape
 * `x`, `y`: the middle in steps; `reach`: the greatest distance from it; `size`: how large it is drawn, in heights of the picture.
 */

/** @param {string} text @param {number} least @param {number} most */
function number(text, least, most) {
  const value = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(text) ? Number(text) : NaN
  return value >= least && value <= most ? value : null
}

/** @param {string} text @param {number} most */
const whole = (text, most) => /^\+?\d+$/.test(text) && Number(text) <= most ? Number(text) : null

/** @param {string} text @returns {[string, string][] | null} `('F','F-F'),('X','FX')` */
function pairs(text) {
  if (text.length < 4 || !text.startsWith("('") || !text.endsWith("')")) return null
  /** @type {[string, string][]} */ const found = []
  for (const part of text.slice(2, -2).split("'),('")) {
    const at = part.indexOf("','")
    if (at < 0) return null
    const from = [...part.slice(0, at)]
    if (from.length !== 1) return null
    found.push([from[0], part.slice(at + 3)])
  }
  return found
}

/**
 * Reads any text: what is missing or illegal takes the default, and later entries win.
 * @param {string} text
 * @returns {Agent}
 */
export function read(text) {
  let start = 'F++F++F', rules = KOCH, v = 60, it = 2, sc = 5
  /** @type {number | null} */ let w = null
  /** @type {number | null} */ let c = null
  /** @type {number | null} */ let sw = null
  for (const entry of text.replace(/\s/gu, '').split('&')) {
    const at = entry.indexOf('='), value = entry.slice(at + 1)
    if (at < 0) continue
    switch (entry.slice(0, at)) {
      case 'v': v = number(value, -3600, 3600) ?? 60; break
      case 'str': start = value || 'F++F++F'; break
      case 'it': it = whole(value, MOST_ROUNDS) ?? 2; break
      case 'sc': sc = number(value, 1e-3, 1000) ?? 5; break
      case 'rules': rules = pairs(value) ? value : KOCH; break
      case 'w': w = number(value, 0.2, 5); break
      case 'c': c = whole(value, 255); break
      case 'sw': sw = number(value, -90, 90); break
    }
  }
  const extended = /[[\]]/.test(start) || w !== null || c !== null || sw !== null || rules !== KOCH
  return { v, it, sc, w: w ?? 1, c, sw: sw ?? 0, most: extended ? MOST_SEGMENTS : MOST_PUBLISHED, start, rules: new Map(pairs(rules) ?? []) }
}

/**
 * Goes along the string with turns of `degrees`, upwards first. `visit` gets each step that is drawn.
 * @param {Agent} agent
 * @param {number} degrees
 * @param {(x: number, y: number, toX: number, toY: number) => void} visit
 */
export function walk(agent, degrees, visit) {
  /** @type {[string, number][]} */ const places = [[agent.start, 0]]
  /** @type {[number, number, number][]} */ const brackets = []
  /** @type {Map<number, [number, number]>} */ const ways = new Map()
  let x = 0, y = 0, turns = 0, drawn = 0
  for (let steps = 1; places.length; steps++) {
    const place = places[places.length - 1]
    if (place[1] >= place[0].length) { places.pop(); continue }
    if (steps > MOST_STEPS) return
    const letter = place[0][place[1]++], becomes = agent.rules.get(letter)
    if (becomes !== undefined && places.length <= agent.it) { places.push([becomes, 0]); continue }
    switch (letter) {
      case 'F': {
        if (drawn === agent.most) return
        let way = ways.get(turns)
        if (!way) {
          const angle = turns * degrees % 360 * Math.PI / 180
          ways.set(turns, way = [Math.sin(angle), -Math.cos(angle)])
        }
        visit(x, y, x += way[0], y += way[1])
        drawn++
        break
      }
      case '+': turns++; break
      case '-': turns--; break
      case '[':
        if (brackets.length === DEEPEST) return
        brackets.push([x, y, turns])
        break
      case ']': [x, y, turns] = brackets.pop() ?? [x, y, turns]; break
    }
  }
}

/**
 * Measures an agent at rest; null if nobody would see it.
 * @param {string} text
 * @returns {Shape | null}
 */
export function shape(text) {
  const agent = read(text)
  /** @type {number[]} */ const ends = []
  walk(agent, agent.v, (x, y, toX, toY) => { ends.push(x, y, toX, toY) })
  const strokes = ends.length / 4
  if (!strokes) return null
  let x = 0, y = 0, low = [Infinity, Infinity], high = [-Infinity, -Infinity]
  for (let at = 0; at < ends.length; at += 2) {
    x += ends[at]
    y += ends[at + 1]
    low = [Math.min(low[0], ends[at]), Math.min(low[1], ends[at + 1])]
    high = [Math.max(high[0], ends[at]), Math.max(high[1], ends[at + 1])]
  }
  x /= 2 * strokes
  y /= 2 * strokes
  let reach = 0
  for (let at = 0; at < ends.length; at += 2) reach = Math.max(reach, Math.hypot(ends[at] - x, ends[at + 1] - y))
  const grain = Math.max(reach / 512, Number.MIN_VALUE), points = new Set()
  for (let at = 0; at < ends.length; at += 2) points.add(`${Math.round((ends[at] - x) / grain + 0.137)} ${Math.round((ends[at + 1] - y) / grain + 0.137)}`)
  const pixels = agent.sc / 5, sides = [0, 1].map(axis => (high[axis] - low[axis]) * pixels / 80)
  if (points.size < 3 || Math.min(...sides) < 0.01) return null
  // Exponents grow quickly, and pictures don't: every size has its place between these.
  const across = 2 * reach * pixels, size = 0.12 + 0.72 * across / (across + 55)
  return { agent, text, strokes, x, y, reach, size, likeness: `${strokes} ${points.size} ${sides.map(side => (side / across).toFixed(5)).join(' ')}` }
}

/**
 * A child of two strings: aligned at their starts, the part of the first between two cuts is replaced by the second's,
 * which half of the time is a character longer or shorter.
 * @param {string} first @param {string} second
 * @param {() => number} [random]
 */
export function crossed(first, second, random = Math.random) {
  const a = [...first], b = [...second], below = (/** @type {number} */ most) => Math.floor(random() * most)
  const one = below(a.length + 1), other = below(a.length + 1), from = Math.min(one, other), to = Math.max(one, other)
  const end = Math.min(to + [1, -1, 0, 0][below(4)], b.length)
  return [...a.slice(0, from), ...b.slice(Math.min(from, Math.max(0, end)), Math.max(0, end)), ...a.slice(to)].join('')
}
