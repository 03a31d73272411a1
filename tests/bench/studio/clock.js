// The page's clock for the measurements: see `main.rs`.
window.drawnMs = null
window.took = null
window.all = []

// Runs `then` with the time once the frame that is drawn next is on its way to the screen.
const afterFrame = then => requestAnimationFrame(() => {
  const { port1, port2 } = new MessageChannel()
  port1.onmessage = () => then(performance.now())
  port2.postMessage(0)
})

const watchWall = () => {
  const wall = document.querySelector('.view.wall')
  const strips = [...document.querySelectorAll('.view.wall [data-sheep] .strip')].filter(strip => {
    const { top, bottom } = strip.getBoundingClientRect()
    return bottom > 0 && top < innerHeight
  })
  const isDrawn = wall?.dataset.state === 'ready' && strips.length > 0 && strips.every(strip => strip.style.backgroundImage)
  if (isDrawn) afterFrame(now => { window.drawnMs = now })
  else requestAnimationFrame(watchWall)
}
requestAnimationFrame(watchWall)

let pressed = 0
addEventListener('keydown', event => { pressed = event.timeStamp }, true)

const watch = (element, options) => {
  window.took = null
  const observer = new MutationObserver(() => {
    observer.disconnect()
    afterFrame(now => { window.took = now - pressed })
  })
  observer.observe(element, options)
}
// The cell of the sheep that has the focus has another class when it is marked.
window.watchMark = () => watch(document.activeElement.closest('[data-sheep]'), { attributeFilter: ['class'] })
window.watchFigures = () => watch(document.querySelector('#lead'), { childList: true, subtree: true, characterData: true })

window.scrolling = forMs => new Promise(done => {
  const scroller = [...document.querySelectorAll('.view.wall *')].find(one => one.scrollHeight > one.clientHeight + 100 && /auto|scroll/.test(getComputedStyle(one).overflowY))
  const frames = []
  const began = performance.now()
  let last = began, by = 24
  const step = now => {
    frames.push(now - last)
    last = now
    const before = scroller.scrollTop
    scroller.scrollBy(0, by)
    if (scroller.scrollTop === before) by = -by
    if (now - began < forMs) requestAnimationFrame(step)
    else done(frames.slice(2))
  }
  requestAnimationFrame(step)
})
