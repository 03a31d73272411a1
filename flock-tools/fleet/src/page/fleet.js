// Asks for this page again, and puts the newer one in its place: what has the focus keeps it, and nothing scrolls.
const SECONDS = 10

async function look() {
  const offline = document.getElementById('offline')
  try {
    const answer = await fetch('./', { cache: 'no-store' })
    if (!answer.ok) throw new Error(answer.statusText)
    const page = new DOMParser().parseFromString(await answer.text(), 'text/html')
    const newer = page.getElementById('fleet')
    const older = document.getElementById('fleet')
    if (newer.textContent !== older.textContent || newer.querySelectorAll('img').length !== older.querySelectorAll('img').length) {
      const focused = document.activeElement?.id
      older.replaceWith(newer)
      if (focused) document.getElementById(focused)?.focus({ preventScroll: true })
    }
    document.title = page.title
    offline.hidden = true
  } catch {
    offline.hidden = false
  }
  setTimeout(look, SECONDS * 1000)
}

setTimeout(look, SECONDS * 1000)
