// What the pointer does on the drawing of the graph.
//
// Owns what a press, a drag and a click mean: from a disc's rim, or from an end of the chosen arrow, to another disc is a link; a disc
// by its middle is carried and pinned; all else moves the view. Never draws.
//
// Start at [`point`].

/** @typedef {import('./graph.js').Graph} Graph */

/** Pixels that a pressed pointer may move and still be a click. */
const STILL = 4

/**
 * Listens to the pointer.
 * @param {Graph} graph
 */
export function point(graph) {
  /** @type {{id: string | null, rim: boolean, end: 'from' | 'to' | null, x: number, y: number, moved: boolean, sx: number, sy: number} | null} */ let held = null
  const begin = (/** @type {string} */ id, /** @type {'from' | 'to' | null} */ end) => { end && graph.edge ? graph.linking.move(graph.edge, end) : graph.linking.start(id) }
  const at = (/** @type {PointerEvent | MouseEvent} */ event) => {
    const box = graph.stage.getBoundingClientRect(), [x, y] = [event.clientX - box.left, event.clientY - box.top]
    const [ix, iy] = graph.scene.inside(x, y)
    return { x, y, ix, iy, under: graph.scene.under(ix, iy) }
  }
  graph.svg.addEventListener('pointerdown', event => {
    if (event.button !== 0 || event.target instanceof Element && event.target.closest('.cross')) return
    const { x, y, under } = at(event), { edge } = graph
    const handle = event.target instanceof Element ? event.target.closest('.end') : null, end = handle && (handle.matches('.to') ? 'to' : 'from')
    const id = end && edge ? edge[end === 'to' ? 'from' : 'to'] : under?.id ?? null
    held = { id, end, rim: end !== null || !!under?.rim, x, y, moved: false, sx: graph.scene.x, sy: graph.scene.y }
    graph.svg.setPointerCapture(event.pointerId)
  })
  graph.svg.addEventListener('pointermove', event => {
    const { x, y, ix, iy, under } = at(event)
    if (!held) {
      graph.svg.classList.toggle('rim', !!under?.rim)
      graph.svg.classList.toggle('middle', !!under && !under.rim)
      graph.svg.classList.toggle('edge', !under && !!graph.scene.arrowUnder(ix, iy))
      return
    }
    if (!held.moved && Math.hypot(x - held.x, y - held.y) < STILL) return
    if (!held.moved && held.id !== null && held.rim) begin(held.id, held.end)
    held.moved = true
    if (held.id === null) graph.scene.look(graph.scene.zoom, held.sx + x - held.x, held.sy + y - held.y)
    else if (held.rim) graph.linking.drag(ix, iy, under?.id ?? null)
    else carry(graph, held.id, ix, iy)
  })
  graph.svg.addEventListener('pointerup', event => {
    const done = held, { ix, iy, under } = at(event)
    held = null
    if (!done) return
    if (!done.moved && done.end && done.id !== null) begin(done.id, done.end)
    else if (!done.moved) click(graph, under?.id ?? null, ix, iy)
    else if (done.id !== null && done.rim) under && under.id !== done.id ? graph.linking.make(under.id) : graph.linking.end()
    else if (done.id !== null) graph.pin(done.id, graph.scene.layout(ix, iy))
  })
  graph.svg.addEventListener('pointercancel', () => { held = null; graph.linking.end() })
  graph.svg.addEventListener('contextmenu', event => {
    const { ix, iy, under } = at(event), edge = under ? null : graph.scene.arrowUnder(ix, iy)
    if (!under && !edge) return
    event.preventDefault()
    graph.choose(under ? { sheep: under.id } : edge && { from: edge.from, to: edge.to }, true)
    graph.menu(event.clientX, event.clientY)
  })
  graph.svg.addEventListener('wheel', event => {
    event.preventDefault()
    const { x, y } = at(event)
    graph.scene.zoomBy(Math.exp(-event.deltaY / (event.ctrlKey ? 100 : 400)), x, y)
  }, { passive: false })
  graph.discs.addEventListener('focusin', event => {
    const id = event.target instanceof Element ? event.target.getAttribute('data-sheep') : null
    if (id !== null && id !== graph.store.focus) graph.store.look(id)
  })
}

/**
 * Chooses what is under the pointer, or makes the link that is being made.
 * @param {Graph} graph
 * @param {string | null} id
 * @param {number} x
 * @param {number} y
 */
function click(graph, id, x, y) {
  if (graph.linking.from !== null) {
    if (id !== null && id !== graph.linking.from) graph.linking.make(id)
    else graph.linking.end()
  } else if (id !== null) graph.choose({ sheep: id }, true)
  else {
    const edge = graph.scene.arrowUnder(x, y)
    graph.choose(edge && { from: edge.from, to: edge.to }, true)
  }
}

/**
 * Moves a disc with the pointer.
 * @param {Graph} graph
 * @param {string} id
 * @param {number} x
 * @param {number} y
 */
function carry(graph, id, x, y) {
  const one = graph.store.byId.get(id)
  if (!one) return
  Object.assign(one, graph.scene.layout(x, y), { pinned: true })
  graph.scene.place()
  graph.place()
}
