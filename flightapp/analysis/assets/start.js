// Puts the page together. `report` is for a person at the console, and for tests.
const dataOf = (id) => JSON.parse(document.getElementById(id)?.textContent ?? "null");
const plots = dataOf("figures");
const charts = new Charts(plots.figures, plots.shared);
listenToFilters();
const playback = dataOf("playback");
window.report = { charts };
if (playback !== null) {
  const run = unpacked(playback);
  window.report.map = new FlightMap(document.getElementById("map"), run);
  window.report.player = new Player(run, window.report.map, charts);
}
