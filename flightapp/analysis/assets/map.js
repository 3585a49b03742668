// The map: a canvas with north up. What does not move is drawn once a view, the rest at every time.
class FlightMap {
  constructor(canvas, run) {
    this.canvas = canvas;
    this.run = run;
    this.t = run.span_s[0];
    this.shown = { tracks: true, discs: true, estimate: true, arrows: true, circles: true, ghosts: true };
    this.still = document.createElement("canvas");
    this.home();
    this.listen();
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  home() {
    const { low_m, high_m } = this.run.ground;
    this.centre = [(low_m[0] + high_m[0]) / 2, (low_m[1] + high_m[1]) / 2];
    this.zoom = 1;
  }

  resize() {
    const box = this.canvas.getBoundingClientRect(), density = window.devicePixelRatio || 1;
    this.width = Math.max(box.width, 1);
    this.height = Math.max(box.height, 1);
    for (const canvas of [this.canvas, this.still]) {
      canvas.width = Math.round(this.width * density);
      canvas.height = Math.round(this.height * density);
      canvas.getContext("2d").setTransform(density, 0, 0, density, 0, 0);
    }
    this.redraw();
  }

  get scale() {
    const { low_m, high_m } = this.run.ground;
    const fit = Math.min((this.height - 60) / (high_m[0] - low_m[0]), (this.width - 70) / (high_m[1] - low_m[1]));
    return this.zoom * Math.max(fit, 1e-3);
  }

  x(east) { return this.width / 2 + (east - this.centre[1]) * this.scale; }
  y(north) { return this.height / 2 - (north - this.centre[0]) * this.scale; }

  redraw() {
    this.drawStill();
    this.draw(this.t);
  }

  line(context, points, closed) {
    context.beginPath();
    for (const [north, east] of points) context.lineTo(this.x(east), this.y(north));
    if (closed) context.closePath();
  }

  drawStill() {
    const context = this.still.getContext("2d"), { ground } = this.run;
    context.clearRect(0, 0, this.width, this.height);
    this.drawGrid(context);
    context.lineWidth = 1.2;
    for (const [outlines, colour] of [[ground.obstacles, colourOf("--stone")], [ground.known, colourOf("--known")]]) {
      for (const outline of outlines) {
        this.line(context, outline, true);
        context.fillStyle = colour + "40";
        context.fill();
        context.strokeStyle = colour;
        context.stroke();
      }
    }
    for (const way of ground.ways) this.stroke(context, way, colourOf("--known"), 1.4, [6, 4]);
    if (ground.fence) this.stroke(context, ground.fence, colourOf("--fence"), 1.4, [3, 4]);
    if (ground.boundary) this.stroke(context, ground.boundary, colourOf("--boundary"), 3, []);
    if (this.shown.ghosts) for (const ghost of this.run.ghosts) for (const one of ghost.vehicles) this.drawWay(context, one.way, colourOf("--ghost"), 1.2, [6, 4]);
    if (this.shown.tracks) for (const one of this.run.vehicles) if (one.way) this.drawWay(context, one.way, one.colour + "66", 1.2, []);
    if (this.run.capture) this.drawStar(context, this.run.capture);
  }

  stroke(context, points, colour, width, dash) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.setLineDash(dash);
    this.line(context, points, false);
    context.stroke();
    context.setLineDash([]);
  }

  drawWay(context, way, colour, width, dash, from = 0, to = way.t.length - 1) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.lineJoin = "round";
    context.setLineDash(dash);
    context.beginPath();
    let x = NaN, y = NaN;
    for (let index = from; index <= to; index++) {
      const nextX = this.x(way.east[index]), nextY = this.y(way.north[index]);
      if (index < to && Math.abs(nextX - x) < 0.7 && Math.abs(nextY - y) < 0.7) continue;
      context.lineTo(x = nextX, y = nextY);
    }
    context.stroke();
    context.setLineDash([]);
  }

  drawGrid(context) {
    const least = 70 / this.scale, power = 10 ** Math.floor(Math.log10(least));
    const step = [1, 2, 5, 10].map((factor) => factor * power).find((one) => one >= least);
    context.font = "12px system-ui, sans-serif";
    context.lineWidth = 1;
    context.strokeStyle = colourOf("--line");
    context.fillStyle = colourOf("--soft");
    const low = [this.centre[0] - this.height / 2 / this.scale, this.centre[1] - this.width / 2 / this.scale];
    const high = [this.centre[0] + this.height / 2 / this.scale, this.centre[1] + this.width / 2 / this.scale];
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const ticks = (axis) => Array.from({ length: Math.floor(high[axis] / step) - Math.ceil(low[axis] / step) + 1 }, (_, index) => (Math.ceil(low[axis] / step) + index) * step);
    context.textAlign = "left";
    for (const north of ticks(0)) {
      this.segment(context, 0, this.y(north), this.width, this.y(north));
      if (this.y(north) > 46 && this.y(north) < this.height - 24) context.fillText(north.toFixed(digits), 6, this.y(north) - 4);
    }
    context.textAlign = "center";
    for (const east of ticks(1)) {
      this.segment(context, this.x(east), 0, this.x(east), this.height);
      if (this.x(east) > 60 && this.x(east) < this.width - 75) context.fillText(east.toFixed(digits), this.x(east), this.height - 7);
    }
    context.textAlign = "left";
    context.fillText("north, m", 6, 16);
    context.textAlign = "right";
    context.fillText("east, m", this.width - 6, this.height - 7);
  }

  segment(context, fromX, fromY, toX, toY) {
    context.beginPath();
    context.moveTo(fromX, fromY);
    context.lineTo(toX, toY);
    context.stroke();
  }

  drawStar(context, capture) {
    const x = this.x(capture.east), y = this.y(capture.north);
    context.beginPath();
    for (let corner = 0; corner < 10; corner++) {
      const radius = corner % 2 ? 4 : 10, angle = (corner * Math.PI) / 5;
      context.lineTo(x + radius * Math.sin(angle), y - radius * Math.cos(angle));
    }
    context.closePath();
    context.fillStyle = colourOf("--boundary");
    context.fill();
    context.strokeStyle = colourOf("--map");
    context.lineWidth = 1;
    context.stroke();
  }

  draw(t) {
    this.t = t;
    this.drawn = {};
    const context = this.canvas.getContext("2d");
    context.clearRect(0, 0, this.width, this.height);
    context.drawImage(this.still, 0, 0, this.width, this.height);
    for (const one of this.run.vehicles) this.drawBeliefs(context, one, t);
    if (this.shown.ghosts) for (const ghost of this.run.ghosts) for (const one of ghost.vehicles) this.drawGhost(context, one, t);
    for (const one of this.run.vehicles) this.drawVehicle(context, one, t);
  }

  drawBeliefs(context, one, t) {
    if (this.shown.discs) for (const [north, east, radius] of circlesAt(one.discs, t, 2)) this.circle(context, north, east, radius, colourOf("--disc"), "26", []);
    if (this.shown.circles) for (const [north, east, radius] of circlesAt(one.circles, t, 1.5)) this.circle(context, north, east, radius, colourOf("--circle"), "12", [5, 4]);
    const estimate = this.shown.estimate ? sampleAt(one.estimate, t, 2) : null;
    if (estimate === null) return;
    this.circle(context, estimate.north, estimate.east, Math.max(2 * estimate.sigma, 0), one.colour, "18", [2, 3]);
    const x = this.x(estimate.east), y = this.y(estimate.north);
    context.strokeStyle = one.colour;
    context.lineWidth = 1.8;
    this.segment(context, x - 7, y - 7, x + 7, y + 7);
    this.segment(context, x - 7, y + 7, x + 7, y - 7);
  }

  circle(context, north, east, radius, colour, opacity, dash) {
    context.beginPath();
    context.arc(this.x(east), this.y(north), Math.max(radius * this.scale, 0), 0, 2 * Math.PI);
    context.fillStyle = colour + opacity;
    context.fill();
    context.setLineDash(dash);
    context.lineWidth = 1.3;
    context.strokeStyle = colour;
    context.stroke();
    context.setLineDash([]);
  }

  drawGhost(context, one, t) {
    const state = stateAt(one.way, t, ["north", "east"]);
    if (state === null) return;
    context.beginPath();
    context.arc(this.x(state.east), this.y(state.north), 5, 0, 2 * Math.PI);
    context.strokeStyle = colourOf("--ghost");
    context.lineWidth = 2;
    context.stroke();
    this.label(context, one.name, this.x(state.east), this.y(state.north) + 18, colourOf("--ghost"));
  }

  drawVehicle(context, one, t) {
    const state = stateAt(one.way, t, ["north", "east", "heading"]);
    if (state === null) return;
    this.drawn[one.name] = [state.north, state.east];
    const to = newest(one.way.t, t), from = Math.max(newest(one.way.t, t - 8), 0);
    if (this.shown.tracks && to > from) this.drawWay(context, one.way, one.colour, 2.6, [], from, to);
    const x = this.x(state.east), y = this.y(state.north);
    if (this.shown.arrows) this.drawIntent(context, one, t, x, y);
    context.save();
    context.translate(x, y);
    context.rotate(state.heading);
    context.beginPath();
    for (const [right, up] of [[0, 12], [8, -9], [0, -4], [-8, -9]]) context.lineTo(right, -up);
    context.closePath();
    context.fillStyle = one.colour;
    context.fill();
    context.strokeStyle = colourOf("--map");
    context.lineWidth = 1.5;
    context.stroke();
    context.restore();
    this.label(context, one.name, x, y - 17, one.colour);
  }

  drawIntent(context, one, t, x, y) {
    const goal = sampleAt(one.goal, t, 1.5), setpoint = sampleAt(one.setpoint, t, 1);
    if (goal !== null && Number.isFinite(goal.north)) {
      context.strokeStyle = one.colour + "88";
      context.lineWidth = 1;
      context.setLineDash([2, 4]);
      this.segment(context, x, y, this.x(goal.east), this.y(goal.north));
      context.setLineDash([]);
      context.strokeRect(this.x(goal.east) - 4, this.y(goal.north) - 4, 8, 8);
    }
    if (setpoint === null || Math.hypot(setpoint.north, setpoint.east) < 0.05) return;
    const toX = x + setpoint.east * this.scale, toY = y - setpoint.north * this.scale, angle = Math.atan2(toY - y, toX - x);
    context.strokeStyle = context.fillStyle = one.colour;
    context.lineWidth = 2;
    this.segment(context, x, y, toX, toY);
    context.beginPath();
    context.moveTo(toX + 4 * Math.cos(angle), toY + 4 * Math.sin(angle));
    for (const turn of [2.6, -2.6]) context.lineTo(toX + 8 * Math.cos(angle + turn), toY + 8 * Math.sin(angle + turn));
    context.fill();
  }

  label(context, text, x, y, colour) {
    context.font = "600 12px system-ui, sans-serif";
    context.textAlign = "center";
    context.lineWidth = 4;
    context.lineJoin = "round";
    context.strokeStyle = colourOf("--map");
    context.strokeText(text, x, y);
    context.fillStyle = colour;
    context.fillText(text, x, y);
  }

  listen() {
    const pointers = new Map();
    const move = (event) => {
      const before = pointers.get(event.pointerId);
      if (before === undefined) return;
      const spread = () => { const [a, b] = [...pointers.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
      const old = pointers.size === 2 ? spread() : 0;
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      if (pointers.size === 2) this.zoom = Math.min(Math.max((this.zoom * spread()) / Math.max(old, 1), 0.3), 200);
      else this.centre = [this.centre[0] + (event.clientY - before[1]) / this.scale, this.centre[1] - (event.clientX - before[0]) / this.scale];
      this.redraw();
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointermove", move);
    for (const name of ["pointerup", "pointercancel"]) this.canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
    this.canvas.addEventListener("dblclick", () => { this.home(); this.redraw(); });
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const box = this.canvas.getBoundingClientRect(), dx = event.clientX - box.left - this.width / 2, dy = event.clientY - box.top - this.height / 2;
      const at = [this.centre[0] - dy / this.scale, this.centre[1] + dx / this.scale];
      this.zoom = Math.min(Math.max(this.zoom * Math.exp(-event.deltaY * 0.0015), 0.3), 200);
      this.centre = [at[0] + dy / this.scale, at[1] - dx / this.scale];
      this.redraw();
    }, { passive: false });
  }
}
