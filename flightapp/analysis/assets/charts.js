// Charts are drawn when they come into sight. Those on the page's time line share its range and show its cursor.
class Charts {
  constructor(figures, shared) {
    this.figures = figures;
    this.shared = new Set(shared);
    this.onTime = null;
    this.t = null;
    this.range = null;
    this.follows = false;
    const watcher = new IntersectionObserver((entries) => {
      for (const entry of entries) if (entry.isIntersecting) { watcher.unobserve(entry.target); this.show(entry.target); }
    }, { rootMargin: "600px" });
    this.places = Object.keys(figures).map((id) => document.getElementById(id));
    for (const place of this.places) {
      place.classList.add("plot");
      place.style.minHeight = `${figures[place.id].layout.height ?? 230}px`;
      watcher.observe(place);
    }
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      for (const place of this.places) if (place.data) Plotly.relayout(place, this.colours(place.id));
    });
  }

  colours(id) {
    const [ink, line, edge, paper] = ["--ink", "--line", "--edge", "--paper"].map(colourOf);
    const update = { paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", "font.color": ink, "hoverlabel.bgcolor": paper, "hoverlabel.font.color": ink, "legend.bgcolor": "rgba(0,0,0,0)" };
    for (const axis of Object.keys(this.figures[id].layout).filter((name) => /^[xy]axis/.test(name))) {
      for (const [name, colour] of [["gridcolor", line], ["zerolinecolor", edge], ["linecolor", edge], ["tickcolor", edge]]) update[`${axis}.${name}`] = colour;
    }
    return update;
  }

  async show(place) {
    const figure = this.figures[place.id], isShared = this.shared.has(place.id);
    await Plotly.newPlot(place, figure.data, figure.layout, { responsive: true, displaylogo: false, displayModeBar: false });
    await Plotly.relayout(place, this.colours(place.id));
    if (!isShared) return;
    const cursor = place.appendChild(document.createElement("div"));
    cursor.className = "cursor";
    if (this.range) await Plotly.relayout(place, this.range);
    this.place(place);
    place.on("plotly_relayout", (change) => this.relayout(place, change));
    place.on("plotly_afterplot", () => this.place(place));
    place.on("plotly_click", (click) => this.onTime?.(click.points[0].x));
  }

  relayout(source, change) {
    const names = Object.keys(change).filter((name) => name.startsWith("xaxis.range") || name === "xaxis.autorange");
    if (this.follows || names.length === 0) return;
    const full = this.figures[source.id].layout.xaxis.range;
    this.range = change["xaxis.autorange"] ? { "xaxis.range": full } : { "xaxis.range": [...source.layout.xaxis.range] };
    this.follows = true;
    const others = this.places.filter((place) => place.data && this.shared.has(place.id) && (place !== source || change["xaxis.autorange"]));
    Promise.all(others.map((place) => Plotly.relayout(place, this.range))).finally(() => { this.follows = false; });
  }

  cursorAt(t) {
    this.t = t;
    for (const place of this.places) this.place(place);
  }

  place(place) {
    const cursor = place.querySelector(":scope > .cursor"), axis = place._fullLayout?.xaxis;
    if (cursor === null || !axis || this.t === null) return;
    const pixel = axis.d2p(this.t), seen = pixel >= 0 && pixel <= axis._length;
    cursor.style.display = seen ? "block" : "none";
    cursor.style.left = `${axis._offset + pixel}px`;
    cursor.style.top = `${place._fullLayout.yaxis._offset}px`;
    cursor.style.bottom = `${place._fullLayout.height - place._fullLayout.yaxis._offset - place._fullLayout.yaxis._length}px`;
  }
}
