// Events by level and by what is typed.
function filterEvents() {
  const levels = new Set([...document.querySelectorAll("[data-level-filter]:checked")].map((box) => box.dataset.levelFilter));
  const text = document.getElementById("event-text").value.toLowerCase();
  for (const row of document.querySelectorAll("#events tbody tr")) {
    row.hidden = !levels.has(row.dataset.level) || !row.textContent.toLowerCase().includes(text);
  }
}

function listenToFilters() {
  for (const box of document.querySelectorAll("[data-level-filter]")) box.addEventListener("change", filterEvents);
  document.getElementById("event-text")?.addEventListener("input", filterEvents);
}
