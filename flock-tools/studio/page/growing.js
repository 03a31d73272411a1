// A moving preview that is watched while it is drawn.
//
// Owns the source buffer and the questions for what has come since the last one. The file is written in fragments, so its first
// second plays while the rest is drawn. A browser without a source buffer shows it when it is whole.
//
// Start at [`watch`].

import { media } from './session.js'

/** Milliseconds between two questions. */
const PACE = 200
/** As all clips that the program makes. */
const MIME = 'video/mp4; codecs="avc1.640028"'

const pause = () => new Promise(resolve => setTimeout(resolve, PACE))

/**
 * Shows a preview in a video, which is in the page, as it comes. Resolves when all of it is there, to true; or when the video is
 * in the page no more, to false.
 * @param {HTMLVideoElement} video
 * @param {string} key
 * @param {() => Job | null} job what makes it, as it is now; null if it is made
 */
export async function watch(video, key, job) {
  const source = 'MediaSource' in globalThis ? new MediaSource() : null
  const place = source && URL.createObjectURL(source)
  if (source && place) {
    const opened = new Promise(resolve => source.addEventListener('sourceopen', resolve, { once: true }))
    video.src = place
    await opened
    URL.revokeObjectURL(place)
  }
  const buffer = source?.addSourceBuffer(MIME)
  for (let from = 0; video.isConnected; await pause()) {
    const now = job()
    if (now?.state === 'failed' || now?.state === 'cancelled') throw new Error(now.error ?? 'it was cancelled')
    if (!source || !buffer) {
      if (now && now.state !== 'done') continue
      video.src = media('preview', key)
      return true
    }
    // The file is there when its first frame is drawn.
    if (now && now.state !== 'done' && !now.done) continue
    const answer = await fetch(media('preview', key, { from: String(from) }))
    if (!answer.ok) throw new Error(`the studio answers ${answer.status}`)
    const data = await answer.arrayBuffer()
    if (!video.isConnected) break
    if (data.byteLength) await appended(buffer, data)
    from += data.byteLength
    if (answer.headers.get('X-Whole') !== '1') continue
    source.endOfStream()
    return true
  }
  return false
}

/** @param {SourceBuffer} buffer @param {ArrayBuffer} data @returns {Promise<void>} */
function appended(buffer, data) {
  return new Promise((resolve, reject) => {
    buffer.addEventListener('updateend', () => resolve(), { once: true })
    buffer.addEventListener('error', () => reject(new Error('this browser cannot play it')), { once: true })
    buffer.appendBuffer(data)
  })
}
