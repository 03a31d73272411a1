// Which key does what.
//
// Owns the spelling of keys and the order in which they are looked up: the topmost layer, the view, the page. Fields keep
// what is typed into them, buttons their Enter and Space.

/** @param {KeyboardEvent} event */
function spelled(event) {
  const mod = event.ctrlKey || event.metaKey
  const name = event.key === ' ' ? 'Space' : event.key.length === 1 && (mod || event.altKey) ? event.key.toLowerCase() : event.key
  const letter = name.length === 1 && name.toLowerCase() !== name.toUpperCase()
  const shift = event.shiftKey && (name.length > 1 || letter || mod)
  return `${mod ? 'Mod+' : ''}${event.altKey ? 'Alt+' : ''}${shift ? 'Shift+' : ''}${shift && letter ? name.toUpperCase() : name}`
}

/**
 * How a key is written for people.
 * @param {string} key
 */
export const written = key => key.replace('Mod', 'Ctrl').replace(/Arrow(\w+)/, (_, to) => ARROWS[to]).replace(/(^|[+ ])([a-z])(?=$| )/g, (_, before, letter) => before + letter.toUpperCase())
/** @type {Record<string, string>} */
const ARROWS = { Left: '←', Right: '→', Up: '↑', Down: '↓' }

const FIELDS = 'input:not([type=range],[type=checkbox],[type=radio],[type=button]), textarea, select, [contenteditable]'
const PRESSED = 'button, a[href], summary, input[type=checkbox], input[type=radio], [role=button]'
const SLID = ['ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown', 'Home', 'End', 'PageUp', 'PageDown']

/**
 * Whether the element with the keyboard's focus uses this key itself.
 * @param {EventTarget | null} target
 * @param {string} key
 */
function taken(target, key) {
  if (!(target instanceof Element)) return false
  if (target.matches(FIELDS)) return key !== 'Escape' && !key.startsWith('Mod+Enter') && !key.startsWith('Alt+')
  if (target.matches('input[type=range], input[type=radio], [role=slider]') && SLID.includes(key.replace('Shift+', ''))) return true
  return (key === 'Enter' || key === 'Space') && target.matches(PRESSED)
}

export class Keys {
  constructor() {
    /** @type {Key[][]} The layers over the page, the topmost last. */ this.layers = []
    /** @type {Key[]} */ this.view = []
    /** @type {Key[]} */ this.page = []
    this.first = ''
    this.firstAt = 0
    addEventListener('keydown', event => this.press(event))
  }

  /** The lists in which a key is looked up. */
  get lists() {
    return this.layers.length ? [this.layers[this.layers.length - 1]] : [this.view, this.page]
  }

  /** @param {KeyboardEvent} event */
  press(event) {
    if (event.defaultPrevented || event.isComposing) return
    const key = spelled(event)
    if (taken(event.target, key)) return
    const pair = this.first && event.timeStamp - this.firstAt < 1500 ? `${this.first} ${key}` : ''
    this.first = ''
    const found = pair && this.find(pair) || this.find(key)
    if (found) {
      event.preventDefault()
      found.run(event)
    } else if (!this.layers.length && this.lists.flat().some(one => one.keys.some(name => name.startsWith(`${key} `)))) {
      event.preventDefault()
      this.first = key
      this.firstAt = event.timeStamp
    }
  }

  /** @param {string} key */
  find(key) {
    for (const list of this.lists) {
      const found = list.find(one => one.keys.includes(key) && (!one.when || one.when()))
      if (found) return found
    }
    return undefined
  }

  /**
   * A layer more. Returns what takes it away.
   * @param {Key[]} keys
   */
  push(keys) {
    this.layers.push(keys)
    return () => { this.layers = this.layers.filter(one => one !== keys) }
  }
}
