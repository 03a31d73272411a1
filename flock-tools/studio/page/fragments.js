// A fragmented MP4, taken apart: its initialisation, and its fragments with their places in frames.
//
// Never decodes. Start at [`read`].

/**
 * @typedef {{data: Uint8Array, start: number, frames: number}} Part frames from one key frame to the next
 * @typedef {{url: string, mime: string, init: Uint8Array, parts: Part[], frames: number, bytes: number}} File
 */

/** @param {string} url @param {number} rate frames a second @returns {Promise<File>} */
export async function read(url, rate) {
  const answer = await fetch(url)
  if (!answer.ok) throw new Error(`the clip cannot be read: the studio answers ${answer.status}`)
  if (answer.headers.get('X-Whole') === '0') throw new Error('its preview is being made')
  const codec = answer.headers.get('X-Codec') ?? 'avc1.640028'
  const mime = `video/mp4; codecs="${codec}"`
  if (!MediaSource.isTypeSupported(mime)) throw new Error(`this browser cannot play \`${codec}\``)
  const data = new Uint8Array(await answer.arrayBuffer())
  return { url, mime, bytes: data.length, ...fragments(data, rate) }
}

/**
 * Takes a fragmented MP4 apart: its initialisation, and its fragments with their places in frames.
 * @param {Uint8Array} data
 * @param {number} rate frames a second
 */
export function fragments(data, rate) {
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength)
  let scale = 0, usual = 0, head = 0, units = 0
  /** @type {Part[]} */ const parts = []
  for (const box of boxes(view, 0, data.length)) {
    if (box.name === 'moov') {
      for (const { name, at } of deep(view, box)) {
        if (name === 'mdhd') scale = view.getUint32(at + (view.getUint8(at) ? 20 : 12))
        if (name === 'trex') usual = view.getUint32(at + 12)
      }
      head = box.end
    } else if (box.name === 'moof') {
      const long = duration(view, box, usual), start = Math.round(units * rate / scale)
      units += long
      parts.push({ data: data.subarray(box.start, box.end), start, frames: Math.round(units * rate / scale) - start })
    } else if (box.name === 'mdat' && parts.length) {
      const part = parts[parts.length - 1]
      part.data = data.subarray(part.data.byteOffset - data.byteOffset, box.end)
    }
  }
  if (!scale || !parts.length) throw new Error('the clip has no fragments')
  const last = parts[parts.length - 1]
  return { init: data.subarray(0, head), parts, frames: last.start + last.frames }
}

/** @typedef {{name: string, start: number, at: number, end: number}} Box `at`: where its content begins */

/** @param {DataView} view @param {number} from @param {number} to @returns {Generator<Box>} */
function* boxes(view, from, to) {
  for (let at = from; at + 8 <= to;) {
    const wide = view.getUint32(at) === 1
    const size = wide ? Number(view.getBigUint64(at + 8)) : view.getUint32(at) || to - at
    const name = String.fromCharCode(view.getUint8(at + 4), view.getUint8(at + 5), view.getUint8(at + 6), view.getUint8(at + 7))
    if (size < 8 || at + size > to) throw new Error(`the clip ends within its box \`${name}\``)
    yield { name, start: at, at: at + (wide ? 16 : 8), end: at + size }
    at += size
  }
}

/**
 * The boxes within a box, and those in the ones that hold what this page asks for.
 * @param {DataView} view @param {Box} box
 * @returns {Generator<Box>}
 */
function* deep(view, box) {
  for (const inner of boxes(view, box.at, box.end)) {
    if (['trak', 'mdia', 'mvex', 'traf'].includes(inner.name)) yield* deep(view, inner)
    else yield inner
  }
}

/**
 * How long a fragment is, in the track's units.
 * @param {DataView} view @param {Box} moof @param {number} usual
 */
function duration(view, moof, usual) {
  let sum = 0
  for (const { name, at } of deep(view, moof)) {
    const flags = view.getUint32(at) & 0xffffff
    if (name === 'tfhd' && flags & 8) usual = view.getUint32(at + 8 + (flags & 1 ? 8 : 0) + (flags & 2 ? 4 : 0))
    if (name !== 'trun') continue
    const samples = view.getUint32(at + 4)
    if (!(flags & 0x100)) { sum += samples * usual; continue }
    const fields = [0x100, 0x200, 0x400, 0x800].filter(flag => flags & flag).length
    let place = at + 8 + (flags & 1 ? 4 : 0) + (flags & 4 ? 4 : 0)
    for (let sample = 0; sample < samples; sample++, place += 4 * fields) sum += view.getUint32(place)
  }
  return sum
}
