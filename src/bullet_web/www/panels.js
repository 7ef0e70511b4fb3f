/* What surrounds the world on both pages, live and replay: cameras, what is chosen, plots. */
"use strict";

const WINDOW = 30; // [s] of simulated time that the plots show
const SPEED_OVER = 0.1; // [s] of simulated time that a speed is the mean of
const ONE_PANEL = "(max-width: 899px), (max-height: 480px)"; // a page that has room for one alone
const byId = (id) => document.getElementById(id);

/* Says something for a while. */
function notice(text, good = false) {
  const line = document.createElement("div");
  line.textContent = text;
  line.className = good ? "good" : "";
  byId("notices").append(line);
  while (byId("notices").children.length > 4) byId("notices").firstChild.remove();
  setTimeout(() => line.remove(), 6000);
}

/* Covers the page with a message; empty: uncovers it. */
function cover(text) {
  byId("cover").hidden = !text;
  byId("cover").firstElementChild.textContent = text;
}

/* Speeds of bodies from their places: key -> [m/s] along the ground. */
class Speeds {
  constructor() { this.clear(); }

  clear() { this.places = new Map(); this.values = new Map(); }

  add(time, rows) {
    for (const row of rows) {
      const before = this.places.get(row[0]);
      if (!before || time < before.time) {
        this.places.set(row[0], { time, x: row[1], y: row[2] });
        if (before) this.values.delete(row[0]);
        continue;
      }
      const past = time - before.time;
      if (past < SPEED_OVER) continue;
      this.values.set(row[0], Math.hypot(row[1] - before.x, row[2] - before.y) / past);
      this.places.set(row[0], { time, x: row[1], y: row[2] });
    }
  }

  of(body) { return this.values.get(body.key) || 0; }
}

/* Curves over the last seconds of simulated time, one below the other. */
class Plots {
  constructor(canvas) {
    this.canvas = canvas;
    this.curves = new Map(); // name -> {unit, points: [[time, value]]}
  }

  clear() { this.curves.clear(); }

  add(time, values) {
    for (const [name, [value, unit]] of Object.entries(values)) {
      if (!Number.isFinite(value)) continue;
      if (!this.curves.has(name)) this.curves.set(name, { unit, points: [] });
      const points = this.curves.get(name).points;
      const last = points[points.length - 1];
      if (last && time < last[0]) points.length = 0; // time was reset
      else if (last && time - last[0] < 0.03) continue;
      points.push([time, value]);
      while (points[0][0] < time - WINDOW) points.shift();
    }
  }

  draw(time) {
    const { canvas } = this;
    const scale = window.devicePixelRatio || 1;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width) return;
    if (canvas.width !== Math.round(width * scale)) canvas.width = Math.round(width * scale);
    if (canvas.height !== Math.round(height * scale)) canvas.height = Math.round(height * scale);
    const context = canvas.getContext("2d");
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = "12px system-ui, sans-serif";
    const shown = [...this.curves].filter(([, curve]) => curve.points.length > 1);
    const part = height / Math.max(1, shown.length);
    shown.forEach(([name, curve], index) => {
      const top = index * part, floor = top + part - 6, ceiling = top + 18;
      const values = curve.points.map((point) => point[1]);
      let low = Math.min(0, ...values), high = Math.max(0, ...values);
      if (high - low < 0.02) { high += 0.01; low -= 0.01; }
      const y = (value) => floor - ((value - low) / (high - low)) * (floor - ceiling);
      const x = (at) => width - ((time - at) / WINDOW) * width;
      context.strokeStyle = "rgba(255, 255, 255, 0.25)";
      context.beginPath();
      context.moveTo(0, y(0));
      context.lineTo(width, y(0));
      context.stroke();
      context.strokeStyle = "#4cc2ff";
      context.lineWidth = 1.5;
      context.beginPath();
      curve.points.forEach(([at, value], n) => (n ? context.lineTo(x(at), y(value)) : context.moveTo(x(at), y(value))));
      context.stroke();
      context.lineWidth = 1;
      context.fillStyle = "#f2f4f7";
      context.fillText(`${name}  ${values[values.length - 1].toFixed(2)} ${curve.unit}`, 2, top + 13);
    });
  }
}

/* Binds the widgets that both pages have to a World. */
class Panels {
  constructor(world) {
    this.world = world;
    this.speeds = new Speeds();
    this.plots = new Plots(byId("graphs"));
    this.chosen = null;
    this.time = 0;
    for (const button of document.querySelectorAll("[data-panel]")) {
      button.onclick = () => this.toggle(button);
    }
    for (const button of document.querySelectorAll("[data-view]")) {
      button.onclick = () => this.look(button.dataset.view);
    }
    byId("model").onchange = (event) => {
      world.follow(world.body(event.target.value));
      event.target.blur();
    };
    byId("frames").onchange = (event) => world.showAxes(event.target.checked, this.chosen);
    world.onslow = () => { byId("shadows").checked = false; };
    byId("shadows").onchange = (event) => world.setShadows(event.target.checked);
    byId("path").onchange = (event) => { world.path.visible = event.target.checked; world.touch(); };
    this.watchClicks();
  }

  toggle(button) {
    const panel = byId(button.dataset.panel);
    panel.hidden = !panel.hidden;
    for (const other of document.querySelectorAll("[data-panel]")) {
      if (other !== button && matchMedia(ONE_PANEL).matches) byId(other.dataset.panel).hidden = true;
      other.classList.toggle("on", !byId(other.dataset.panel).hidden);
    }
    button.blur();
    this.onpanel();
  }

  onpanel() {}

  look(mode) {
    for (const button of document.querySelectorAll("[data-view]")) {
      button.classList.toggle("on", button.dataset.view === mode);
      button.blur();
    }
    this.world.view(mode);
  }

  /* Lists the models after another scene was set. */
  listModels() {
    const names = this.world.movingBodies().map((body) => body.name);
    const select = byId("model");
    select.replaceChildren(...names.map((name) => new Option(name)));
    select.hidden = names.length < 2;
    if (this.world.followed) select.value = this.world.followed.name;
    this.choose(this.chosen && this.world.body(this.chosen));
  }

  /* A click chooses a model, unless a tool takes it; a drag turns the camera. */
  watchClicks() {
    const { canvas } = this.world;
    let down = null;
    canvas.addEventListener("pointerdown", (event) => {
      down = event.isPrimary ? { x: event.clientX, y: event.clientY } : null;
      if (down) this.ondown(event);
    });
    canvas.addEventListener("pointermove", (event) => { if (event.isPrimary) this.onmove(event); });
    canvas.addEventListener("pointerup", (event) => {
      if (!event.isPrimary || !down) return;
      const still = Math.hypot(event.clientX - down.x, event.clientY - down.y) < 6;
      down = null;
      if (this.onup(event)) return;
      if (!still) return;
      const hit = this.world.pick(event.clientX, event.clientY);
      this.choose(hit && hit.body);
    });
    canvas.addEventListener("pointercancel", () => { down = null; this.oncancel(); });
  }

  ondown() {}
  onmove() {}
  onup() { return false; }
  oncancel() {}

  choose(body) {
    this.chosen = body ? body.name : null;
    byId("remove").disabled = !body;
    if (this.world.axesShown) this.world.showAxes(true, this.chosen);
    this.showChosen();
  }

  showChosen() {
    const body = this.chosen && this.world.body(this.chosen);
    byId("label").hidden = !body;
    byId("chosen").textContent = "";
    if (!body) return;
    const [, x, y, z] = body.state;
    const degrees = (this.world.yaw(body) * 180) / Math.PI;
    const pose = `x ${x.toFixed(2)}  y ${y.toFixed(2)}  z ${z.toFixed(2)} m, ${degrees.toFixed(0)}°`;
    const speed = body.fixed ? "fixed" : `${this.speeds.of(body).toFixed(2)} m/s`;
    byId("label").textContent = `${body.name}\n${pose}\n${speed}`;
    byId("chosen").textContent = byId("label").textContent;
    const at = this.world.toPage(body.root.position);
    byId("label").hidden = !at;
    if (at) { byId("label").style.left = `${at.x}px`; byId("label").style.top = `${at.y}px`; }
  }

  /* Follows a state: bodies, clock, plots. more: further curves, name -> [value, unit]. */
  apply(time, rows, more = {}) {
    if (time < this.time) { this.speeds.clear(); this.plots.clear(); this.world.clearPath(); }
    this.time = time;
    this.world.apply(rows);
    this.speeds.add(time, rows);
    byId("clock").textContent = `${time.toFixed(2)} s`;
    const body = this.world.followed;
    if (!body) return;
    const curves = { speed: [this.speeds.of(body), "m/s"] };
    const joints = this.world.joints(body);
    const names = Object.keys(joints).filter((name) => /steer/i.test(name));
    if (names.length) {
      const mean = names.reduce((sum, name) => sum + joints[name], 0) / names.length;
      curves.steering = [(mean * 180) / Math.PI, "°"];
    }
    if ("hitch_yaw_joint" in joints) curves["trailer angle"] = [(joints.hitch_yaw_joint * 180) / Math.PI, "°"];
    this.plots.add(time, { ...curves, ...more });
  }

  /* For each frame of the browser. */
  frame() {
    this.world.render();
    this.showChosen();
    if (!byId("plots").hidden) this.plots.draw(this.time);
  }
}
