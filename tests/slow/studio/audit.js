// What a careful visitor finds wrong with the page as it is shown now: controls without a name, text that is hard to
// read, and what is cut off or sticks out. An expression: a list of sentences, empty if all is well.
(() => {
  const found = []
  const paper = new OffscreenCanvas(1, 1).getContext('2d', { willReadFrequently: true })
  const visible = element => {
    if (!element.checkVisibility({ opacityProperty: true, visibilityProperty: true })) return false
    const { width, height } = element.getBoundingClientRect()
    return width > 1 && height > 1
  }
  const told = element => {
    const name = element.getAttribute('aria-label') ?? element.textContent.trim().slice(0, 40)
    return `<${element.tagName.toLowerCase()}${element.className?.baseVal ?? element.className ? '.' + String(element.className.baseVal ?? element.className).trim().replace(/\s+/g, '.') : ''}> ${name}`
  }

  // A colour as red, green, blue and opacity: 0 to 255, 0 to 1.
  const read = new Map()
  const rgba = text => {
    if (!read.has(text)) {
      paper.clearRect(0, 0, 1, 1)
      paper.fillStyle = text
      paper.fillRect(0, 0, 1, 1)
      const [r, g, b, a] = paper.getImageData(0, 0, 1, 1).data
      read.set(text, [r, g, b, a / 255])
    }
    return read.get(text)
  }
  const over = ([r, g, b, a], under) => [r, g, b].map((part, at) => part * a + under[at] * (1 - a))
  const luminance = colour => colour.map(part => part / 255).map(part => part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4)
    .reduce((sum, part, at) => sum + part * [0.2126, 0.7152, 0.0722][at], 0)
  const contrast = (one, other) => {
    const [dark, light] = [luminance(one), luminance(other)].sort((a, b) => a - b)
    return (light + 0.05) / (dark + 0.05)
  }
  // What is behind an element; nothing if that is a picture.
  const ground = element => {
    const layers = []
    for (let at = element; at; at = at.parentElement) {
      const style = getComputedStyle(at)
      if (style.backgroundImage !== 'none') return null
      const colour = rgba(style.backgroundColor)
      layers.push(colour)
      if (colour[3] === 1) break
      // What lies on a picture beside it has that behind it.
      if (style.position === 'absolute' && [...at.parentElement?.children ?? []].some(one => one !== at && one.matches('canvas, img, video'))) return null
    }
    return layers.reverse().reduce((under, layer) => over(layer, under), rgba('Canvas').slice(0, 3))
  }

  // The topmost dialog hides what is below it.
  const root = [...document.querySelectorAll('dialog[open]')].at(-1) ?? document.body
  const walker = document.createTreeWalker(root, NodeFilter.SHOW_TEXT)
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const element = node.parentElement
    if (!node.data.trim() || !element || element.closest('script, style, option, [aria-hidden=true], :disabled, [disabled]') || !visible(element)) continue
    const style = getComputedStyle(element)
    if (rgba(style.color)[3] === 0) continue
    const isDrawn = element instanceof SVGElement
    const under = ground(element)
    if (under && !isDrawn) {
      const colour = over(rgba(style.color), under)
      const ratio = contrast(colour, under)
      if (ratio < 4.5) found.push(`contrast ${ratio.toFixed(2)} of ${told(element)}`)
    }
    if (isDrawn) {
      const paint = style.fill === 'none' ? style.stroke : style.fill
      const behind = ground(element.closest('svg').parentElement)
      const ratio = behind && contrast(over(rgba(paint), behind), behind)
      // Letters with a seam of the ground around them are read on anything.
      if (ratio && ratio < 4.5) found.push(`contrast ${ratio.toFixed(2)} of ${told(element)}`)
    }
    const size = parseFloat(style.fontSize)
    if (size < 11) found.push(`letters of ${size} px in ${told(element)}`)
  }

  // Scrolled into view, nothing may be outside of the window or of what holds it.
  const scrolls = element => /auto|scroll/.test(getComputedStyle(element).overflowX)
  const all = [...root.querySelectorAll('*')].filter(element => !(element instanceof SVGElement) && visible(element))
  if (document.documentElement.scrollWidth > innerWidth) found.push(`the page is ${document.documentElement.scrollWidth} px wide in ${innerWidth}`)
  for (const element of all) {
    const style = getComputedStyle(element)
    const holdsText = [...element.childNodes].some(node => node.nodeType === Node.TEXT_NODE && node.data.trim())
    const hides = /hidden|clip/.test(style.overflowX)
    const whole = element.title || element.closest('[title]')?.title || element.closest('[aria-label]')?.getAttribute('aria-label') || ''
    if (holdsText && hides && element.scrollWidth > element.clientWidth + 1 && !whole) found.push(`cut off sideways: ${told(element)}`)
    if (holdsText && /hidden|clip/.test(style.overflowY) && element.scrollHeight > element.clientHeight + 2 && element.clientHeight > 0 && !whole) found.push(`cut off below: ${told(element)}`)
    const { left, right } = element.getBoundingClientRect()
    const isHeld = (() => { for (let at = element.parentElement; at; at = at.parentElement) if (scrolls(at)) return true; return false })()
    if (element.matches('button, a, input, select, textarea, [tabindex]') && !isHeld && (left < -1 || right > innerWidth + 1)) {
      found.push(`outside of the window, ${Math.round(left)} to ${Math.round(right)} of ${innerWidth}: ${told(element)}`)
    }
  }

  for (const control of root.querySelectorAll('button, a, input, select, textarea, summary, [role=button], [role=slider], [role=option], [tabindex="0"]')) {
    if (!visible(control)) continue
    const labelled = (control.getAttribute('aria-labelledby') ?? '').split(' ').map(id => document.getElementById(id)?.textContent ?? '').join('')
    const name = control.getAttribute('aria-label') || labelled || control.textContent.trim() || control.title || [...control.labels ?? []].map(label => label.textContent).join('') || control.getAttribute('placeholder')
    if (!name) found.push(`no name: ${told(control)}`)
    // A tick is set by its words, too.
    const { width, height } = (control.closest('label') ?? control).getBoundingClientRect()
    const isInText = getComputedStyle(control).display === 'inline'
    if (!(control instanceof SVGElement) && !isInText && (width < 23.5 || height < 23.5)) found.push(`${Math.round(width)} by ${Math.round(height)} px, less than 24, is ${told(control)}`)
  }
  for (const image of root.querySelectorAll('img')) if (visible(image) && (!image.hasAttribute('alt') || !image.complete || !image.naturalWidth)) found.push(`a picture without words or pixels: ${image.src}`)
  return [...new Set(found)]
})()
