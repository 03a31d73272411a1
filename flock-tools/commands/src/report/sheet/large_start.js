// Everything is drawn once; what depends on the width is drawn again when that changes.

drawLight()
drawHead()
if (flock.more_faults) $('#faults ul').append(make('li', {}, `and ${digits(flock.more_faults)} more, which dreams check names`))
drawRatios()
drawWorst()
drawReturns()
drawSuggested()
drawJoins()
drawCredits()
$('#query').addEventListener('input', search)
search()
looking.tellers.push(showChosen)
let drawn = innerWidth
addEventListener('resize', () => {
  if (innerWidth === drawn) return
  drawn = innerWidth
  drawRatios()
  drawReturns()
})
