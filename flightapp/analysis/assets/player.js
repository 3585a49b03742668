// Time: the slider, playing, keys, the panel of states and the lanes. Everything that shows a time listens here.
class Player {
  constructor(run, map, charts) {
    this.run = run;
    this.map = map;
    this.charts = charts;
    this.slider = document.getElementById("slider");
    this.button = document.getElementById("play");
    this.speed = document.getElementById("speed");
    this.states = document.getElementById("states");
    this.playing = false;
    const [from, to] = run.span_s;
    Object.assign(this.slider, { min: from, max: to, step: Math.max((to - from) / 20000, 0.01) });
    this.rows = new Map(run.vehicles.map((one) => [one.name, this.panel(one)]));
    this.lanes = document.getElementById("lanes");
    this.listen();
    this.seek(Math.min(Math.max(run.capture ? run.capture.t - 1.5 : 0, from), to));
  }

  listen() {
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    this.button.addEventListener("click", () => (this.playing ? this.pause() : this.play()));
    this.charts.onTime = (t) => this.seek(t);
    document.addEventListener("click", (event) => {
      const target = event.target.closest("[data-t]");
      if (target === null) return;
      this.seek(Number(target.dataset.t));
      if (target.matches("button.time")) document.getElementById("map").scrollIntoView({ block: "nearest", behavior: "smooth" });
    });
    this.lanes.addEventListener("click", (event) => {
      const box = this.lanes.querySelector(".bar")?.getBoundingClientRect();
      if (!box) return;
      const part = (event.clientX - box.left) / box.width, [from, to] = this.run.span_s;
      if (part >= 0) this.seek(from + part * (to - from));
    });
    document.addEventListener("keydown", (event) => {
      if (event.target.matches("input[type=search], select") || event.ctrlKey || event.metaKey || event.altKey) return;
      const steps = { ArrowLeft: -0.2, ArrowRight: 0.2, PageUp: -10, PageDown: 10 }, [from, to] = this.run.span_s;
      if (event.key === " " && !event.target.matches("button, summary, input[type=checkbox]")) this.playing ? this.pause() : this.play();
      else if (event.key.startsWith("Arrow") && event.key in steps) this.seek(this.t + steps[event.key] * (event.shiftKey ? 10 : 1));
      else if (event.target === this.slider && event.key in steps) this.seek(this.t + steps[event.key]);
      else if (event.target === this.slider && event.key === "Home") this.seek(from);
      else if (event.target === this.slider && event.key === "End") this.seek(to);
      else return;
      event.preventDefault();
    });
    for (const box of document.querySelectorAll("[data-layer]")) {
      box.addEventListener("change", () => { this.map.shown[box.dataset.layer] = box.checked; this.map.redraw(); });
    }
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.map.redraw());
  }

  play() {
    if (this.t >= this.run.span_s[1]) this.seek(this.run.span_s[0]);
    this.playing = true;
    this.button.textContent = "Pause";
    let before = performance.now();
    const step = (now) => {
      if (!this.playing) return;
      this.seek(this.t + Math.min(Math.max(now - before, 0) / 1000, 0.25) * Number(this.speed.value));
      before = now;
      if (this.t >= this.run.span_s[1]) this.pause(); else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  pause() {
    this.playing = false;
    this.button.textContent = "Play";
  }

  seek(t) {
    const [from, to] = this.run.span_s;
    if (!Number.isFinite(t)) return;
    this.t = Math.min(Math.max(t, from), to);
    this.slider.value = this.t;
    document.getElementById("time").textContent = `${this.t.toFixed(1)} s`;
    this.map.draw(this.t);
    this.charts.cursorAt(this.t);
    this.lanes.style.setProperty("--part", (this.t - from) / (to - from));
    for (const one of this.run.vehicles) this.fill(one);
  }

  panel(one) {
    const list = this.states.appendChild(document.createElement("dl"));
    list.className = "state";
    const title = list.appendChild(document.createElement("h3"));
    title.textContent = `${one.name} (${one.role})`;
    title.style.color = `color-mix(in srgb, ${one.colour} 75%, var(--ink))`;
    const cells = {};
    for (const name of ["Phase", "Mode", "Speed", "Height", "To evader", "Guards"]) {
      if (one.role === "evader" && ["To evader"].includes(name)) continue;
      list.appendChild(document.createElement("dt")).textContent = name;
      cells[name] = list.appendChild(document.createElement("dd"));
    }
    return cells;
  }

  fill(one) {
    const cells = this.rows.get(one.name), t = this.t;
    const state = stateAt(one.way, t, ["north", "east", "height", "speed"]);
    const put = (name, text) => { if (cells[name] && cells[name].textContent !== text) cells[name].textContent = text; };
    put("Phase", spellsAt(one.phases, t).at(-1)?.name ?? "not known");
    put("Mode", spellsAt(one.modes, t).at(-1)?.name ?? "–");
    put("Speed", state ? `${state.speed.toFixed(1)} m/s` : "not known");
    put("Height", state ? `${state.height.toFixed(1)} m` : "not known");
    put("Guards", [...new Set(spellsAt(one.guards, t).map((spell) => spell.name))].join(", ") || "none acts");
    const evader = this.run.vehicles.find((other) => other.role === "evader");
    const prey = evader ? stateAt(evader.way, t, ["north", "east", "height"]) : null;
    const gap = state && prey ? Math.hypot(state.north - prey.north, state.east - prey.east, state.height - prey.height) : null;
    put("To evader", gap === null ? "not known" : `${gap.toFixed(2)} m`);
  }
}
