// Everything is drawn once; what depends on the width is drawn again when that changes.

drawLight()
drawHead()
$('main').hidden = !sheep.length
if (sheep.length) {
  drawPanel()
  drawWeighing()
  drawGraph()
  drawZoom()
  drawShares()
  drawReturns()
  drawDay()
  drawSuggested()
  drawJoins()
  drawCredits()
  drawTable()
  looking.tellers.push(markShares, markTable)
  let drawn = innerWidth
  addEventListener('resize', () => {
    if (innerWidth === drawn) return
    drawn = innerWidth
    drawGraph()
    drawReturns()
  })
}
