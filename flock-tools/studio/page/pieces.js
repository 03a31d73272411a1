// What a player plays: pieces after each other, whose places are counted in frames.
//
// Knows where each piece begins, and what a player can do. Never plays: `mse.js` and `turns.js` do.

/**
 * A piece of what is played. Where it has no file, a card is shown for as long.
 * @typedef {{start: number, frames: number, url: string | null, note?: string}} Piece
 *
 * What a player tells. `frame` is counted from the start of the first piece.
 * @typedef {object} Told
 * @property {(frame: number, piece: number) => void} frame a frame is on the screen
 * @property {(piece: number | null, why: string) => void} card nothing can be shown for this piece; null: it can again
 * @property {(playing: boolean) => void} playing
 * @property {(times: number) => void} [pace] so fast it goes; less than was asked if the computer decodes no faster
 *
 * @typedef {{ranges: number, stalls: number, dropped: number, shown: number, appended: number}} Counted
 *
 * @typedef {object} Player
 * @property {boolean} exact whether joins are shown as on the wall
 * @property {(pieces: Piece[]) => void} have what is played; a longer list may follow, which begins with the same pieces
 * @property {() => void} play
 * @property {() => void} pause
 * @property {() => boolean} playing
 * @property {(frame: number) => void} seek
 * @property {(by: number) => void} step stands still and goes on by so many frames
 * @property {(times: number) => void} speed
 * @property {() => number} at the frame that is shown
 * @property {() => Counted} counted
 * @property {() => void} close
 */

/** @param {HTMLElement} stage */
export function video(stage) {
  const made = document.createElement('video')
  made.muted = true
  made.playsInline = true
  made.disablePictureInPicture = true
  made.setAttribute('aria-label', 'the walk')
  stage.prepend(made)
  return made
}

/**
 * The piece that shows a frame: the last one that begins no later.
 * @param {Piece[]} pieces
 * @param {number} frame
 */
export function pieceAt(pieces, frame) {
  let low = 0, high = pieces.length
  while (high - low > 1) {
    const middle = low + high >> 1
    if (pieces[middle].start <= frame) low = middle
    else high = middle
  }
  return low
}

/** @param {Piece[]} pieces */
export const endOf = pieces => pieces.length ? pieces[pieces.length - 1].start + pieces[pieces.length - 1].frames : 0
