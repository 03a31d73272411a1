// Words for numbers, which the report and the studio write alike, and for what went wrong.

/**
 * So many of something whose plural ends in `s`, but for sheep.
 * @param {number} items
 * @param {string} of
 */
export function spoken(items, of) {
  return `${items ? digits(items) : 'no'} ${of}${items === 1 || of === 'sheep' ? '' : 's'}`
}

/** @param {number} number @param {number} [most] decimals */
export const digits = (number, most = 2) => (WRITERS[most] ??= new Intl.NumberFormat('en', { maximumFractionDigits: most })).format(number)
/** @type {Intl.NumberFormat[]} A writer of numbers is slow to make. */
const WRITERS = []

/** @param {unknown} error what was thrown */
export const why = error => error instanceof Error ? error.message : String(error)

/** @param {number} part of 1 */
export function percent(part) {
  const value = 100 * part
  if (value > 0 && value < 1e-6) return 'under 0.000001\u00a0%'
  return `${value === 0 ? 0 : value < 0.1 ? value.toPrecision(1) : value.toFixed(value < 10 ? 2 : 1)}\u00a0%`
}

/** @param {number | null} time in minutes; null: never */
export function minutes(time) {
  if (time === null) return 'never'
  if (time > 0 && time < 1 / 60) return `${(60 * time).toPrecision(1)} s`
  if (time < 1.5) return `${Math.round(60 * time)} s`
  if (time < 100) return `${time.toFixed(time < 10 ? 1 : 0)} min`
  if (time < 36 * 60) return `${(time / 60).toFixed(1)} h`
  return `${digits(time / 1440, time < 14400 ? 1 : 0)} days`
}

/** @param {number} ratio */
export const times = ratio => digits(ratio, ratio < 10 ? 2 : ratio < 100 ? 1 : 0)

/** @param {string} id */
export const short = id => id.length > 18 ? `${id.slice(0, 8)}…${id.slice(-8)}` : id
