// The outlines of arrows between discs: the report and the studio draw them alike.
//
// Pure: from circles and a width to the text of an SVG path. A circle is its middle and its radius, in pixels.

/** @typedef {{x: number, y: number, r: number}} Circle */

/**
 * The control point of the bent arrow from one disc to another. Opposite transitions bend to different sides, so that they
 * do not cover each other.
 * @param {Circle} from
 * @param {Circle} to
 * @returns {[number, number]}
 */
export function bendOf(from, to) {
  const far = Math.hypot(to.x - from.x, to.y - from.y) || 1
  const [nx, ny] = [-(to.y - from.y) / far, (to.x - from.x) / far]
  const bend = Math.min(0.16 * far, 70)
  return [(from.x + to.x) / 2 + bend * nx, (from.y + to.y) / 2 + bend * ny]
}

/**
 * The nine points of that arrow's outline, from rim to rim; the second and the eighth are control points of curves.
 * @param {Circle} from
 * @param {Circle} to
 * @param {number} width
 * @returns {[number, number][]}
 */
export function corners(from, to, width) {
  const [cx, cy] = bendOf(from, to)
  const far = Math.hypot(to.x - from.x, to.y - from.y) || 1
  const [nx, ny] = [-(to.y - from.y) / far, (to.x - from.x) / far]
  const [sx, sy] = towards(from.x, from.y, cx, cy, from.r + 1)
  const [ex, ey] = towards(to.x, to.y, cx, cy, to.r + 2)
  const head = Math.min(2.2 + 2.4 * width, 0.4 * far)
  const [hx, hy] = towards(ex, ey, cx, cy, head)
  const half = width / 2, wing = half + 1 + 0.7 * width
  return [
    beside(sx, sy, cx, cy, half), [cx + half * nx, cy + half * ny], beside(hx, hy, ex, ey, half), beside(hx, hy, ex, ey, wing), [ex, ey],
    beside(hx, hy, ex, ey, -wing), beside(hx, hy, ex, ey, -half), [cx - half * nx, cy - half * ny], beside(sx, sy, cx, cy, -half),
  ]
}

/**
 * The outline as text.
 * @param {Circle} from
 * @param {Circle} to
 * @param {number} width
 */
export function across(from, to, width) {
  const points = corners(from, to, width).map(point => point.map(number => number.toFixed(1)).join(' '))
  return `M${points[0]}Q${points[1]} ${points[2]}L${points[3]}L${points[4]}L${points[5]}L${points[6]}Q${points[7]} ${points[8]}Z`
}

/**
 * The outline of the arrow from a disc to itself.
 * @param {Circle} one
 * @param {number} width
 */
export function around(one, width) {
  const w = 0.6 * one.r + 5, top = one.y - one.r
  return `M${one.x - w / 2} ${top}c${-w} ${-1.6 * w} ${2 * w} ${-1.6 * w} ${w} 0l${-width} 0c${w - width} ${-1.3 * w} ${-1.9 * w} ${-1.3 * w} ${-w + 2 * width} 0z`
}

/**
 * The point at distance `by` from the first point, towards the second.
 * @param {number} x
 * @param {number} y
 * @param {number} tx
 * @param {number} ty
 * @param {number} by
 * @returns {[number, number]}
 */
export function towards(x, y, tx, ty, by) {
  const far = Math.hypot(tx - x, ty - y) || 1
  return [x + by * (tx - x) / far, y + by * (ty - y) / far]
}

/**
 * The point at distance `by` from the first point, at right angles to the way to the second.
 * @param {number} x
 * @param {number} y
 * @param {number} tx
 * @param {number} ty
 * @param {number} by
 * @returns {[number, number]}
 */
function beside(x, y, tx, ty, by) {
  const far = Math.hypot(tx - x, ty - y) || 1
  return [x - by * (ty - y) / far, y + by * (tx - x) / far]
}
