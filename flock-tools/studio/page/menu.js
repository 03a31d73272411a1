// A menu at the pointer: a few buttons, one of which is pressed, or none.

import { make, styled } from './dom.js'

/**
 * @param {HTMLElement} root what it lies in
 * @param {number} x of the window, in CSS pixels
 * @param {number} y
 * @param {HTMLButtonElement[]} items
 * @param {() => void} closed
 */
export function openMenu(root, x, y, items, closed) {
  const menu = make('div', { class: 'menu', role: 'menu' }, ...items)
  for (const item of items) item.setAttribute('role', 'menuitem')
  const box = root.getBoundingClientRect()
  styled(menu, { left: `${Math.min(x - box.left, box.width - 180)}px`, top: `${Math.min(y - box.top, box.height - 130)}px` })
  const close = () => {
    menu.remove()
    removeEventListener('pointerdown', outside, true)
    closed()
  }
  /** @param {PointerEvent} event */
  const outside = event => { if (!(event.target instanceof Node && menu.contains(event.target))) close() }
  menu.addEventListener('click', close)
  menu.addEventListener('keydown', event => {
    const at = items.findIndex(item => item === document.activeElement)
    if (event.key === 'Escape') close()
    else if (event.key === 'ArrowDown') items[(at + 1) % items.length].focus()
    else if (event.key === 'ArrowUp') items[(at + items.length - 1) % items.length].focus()
    else return
    event.preventDefault()
  })
  addEventListener('pointerdown', outside, true)
  root.append(menu)
  items[0].focus()
}
