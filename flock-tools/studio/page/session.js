// What only the pages of this session know.
//
// Owns the two secrets that the program gave for the token of its address, and who sends which: questions send one in a header;
// pictures, videos and the stream of events, which send no headers of ours, have another one in their addresses, which changes
// nothing. All tabs of this port share them. Another port is another origin, which is kept from them, though not from the cookie.
//
// Start at [`secret`] and [`media`].

const SECRET = 'dreams-studio-secret', LOOK = 'dreams-studio-look'

/** @param {{secret: string, look: string}} told */
export function begin({ secret, look }) {
  localStorage.setItem(SECRET, secret)
  localStorage.setItem(LOOK, look)
}

/** What every question carries. */
export const secret = () => localStorage.getItem(SECRET) ?? ''

/**
 * The address of something that is asked for without a header.
 * @param {string} path
 * @param {Record<string, string>} [asked]
 */
export const bare = (path, asked = {}) => `${path}?${new URLSearchParams({ ...asked, look: localStorage.getItem(LOOK) ?? '' })}`

/**
 * The address of a picture or a clip.
 * @param {'fragments' | 'middle' | 'packets' | 'preview' | 'strip'} kind
 * @param {string} key
 * @param {Record<string, string>} [asked]
 */
export const media = (kind, key, asked) => bare(`/media/${kind}/${encodeURIComponent(key)}`, asked)
