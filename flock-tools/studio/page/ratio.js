// A share against its want, as a colour and in words: the report and the studio have the same.
//
// Pure: from the ratio of the two, which is 0 where a sheep is never shown. Start at [`tiltOf`].

import { times } from './words.js'

/**
 * How far a share is from its want: -1 is a quarter of it or less, 1 four times or more.
 * @param {number} ratio
 */
export const tiltOf = ratio => ratio ? Math.max(-1, Math.min(1, Math.log2(ratio) / 2)) : -1

/**
 * The colour of that.
 * @param {number} off
 */
export const tint = off => `color-mix(in oklab, var(${off < 0 ? '--seldom' : '--often'}) ${Math.round(100 * Math.sqrt(Math.abs(off)))}%, var(--even))`

/**
 * The same in words.
 * @param {number} ratio
 * @param {string} [often] or `long`, where time is meant
 */
export function asWished(ratio, often = 'often') {
  if (!ratio) return 'never shown'
  if (ratio > 0.99 && ratio < 1.01) return `as ${often} as wished`
  return ratio > 1 ? `${times(ratio)} times as ${often} as wished` : `${times(1 / ratio)} times less than wished`
}
