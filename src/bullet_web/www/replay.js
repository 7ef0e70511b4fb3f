/* A recording: the world, a time bar, the same cameras and plots as on the live page. */
"use strict";

function bytesOf(text) {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let at = 0; at < raw.length; at += 1) bytes[at] = raw.charCodeAt(at);
  return bytes.buffer;
}

/* Index of the last of some times, which grow, that is not after another one; 0 if all are. */
function lastUntil(time, count, timeOf) {
  let low = 0, high = count - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (timeOf(middle) <= time) low = middle; else high = middle - 1;
  }
  return low;
}

class Replay {
  constructor(data) {
    this.data = data;
    document.title = data.title;
    const load = async (name) => bytesOf(data.assets[name].split(",")[1]);
    this.world = new World(byId("world"), load, (name) => data.assets[name]);
    this.panels = new Panels(this.world);
    byId("camera").parentElement.hidden = byId("lidar").parentElement.hidden = true;
    byId("lap").textContent = data.text;
    this.offsets = [];
    let total = 0;
    let scene = null;
    this.parts = data.parts.map((part) => {
      scene = part.scene || scene;
      const times = new Float64Array(bytesOf(part.times));
      const width = part.bodies.reduce((sum, [, count]) => sum + count, 0);
      this.offsets.push(total - times[0]);
      total += times[times.length - 1] - times[0];
      return { ...part, scene, times, width, rows: new Float32Array(bytesOf(part.rows)) };
    });
    this.length = total;
    this.at = 0;
    this.playing = true;
    this.shown = -1;
    byId("bar").max = String(total);
    byId("bar").oninput = () => { this.at = Number(byId("bar").value); this.show(); };
    byId("play").onclick = () => this.play(!this.playing);
    window.addEventListener("keydown", (event) => {
      if (event.code !== "Space" || event.target.tagName === "BUTTON") return;
      event.preventDefault();
      this.play(!this.playing);
    });
    let before = performance.now();
    const frame = (now) => {
      const past = Math.min(0.25, Math.max(0, (now - before) / 1000));
      before = now;
      if (this.playing && this.shown >= 0) this.advance(past * Number(byId("rate").value));
      this.panels.frame();
      requestAnimationFrame(frame);
    };
    this.show().then(() => { cover(""); requestAnimationFrame(frame); });
  }

  play(on) {
    if (on && this.at >= this.length) this.at = 0;
    this.playing = on;
    byId("play").textContent = on ? "Pause" : "Play";
  }

  advance(seconds) {
    this.at = Math.min(this.length, this.at + seconds);
    if (this.at >= this.length) this.play(false);
    this.show();
  }

  /* Shows the moment `at` of the time bar. */
  async show() {
    byId("bar").value = String(this.at);
    byId("at").textContent = `${this.at.toFixed(1)} / ${this.length.toFixed(1)} s`;
    let index = this.parts.length - 1;
    while (index > 0 && this.at < this.offsets[index] + this.parts[index].times[0]) index -= 1;
    const part = this.parts[index];
    if (index !== this.shown) {
      if (this.changing) return;
      this.changing = true;
      await this.world.setScene(part.scene);
      this.changing = false;
      this.shown = index;
      this.panels.listModels();
    }
    const time = this.at - this.offsets[index];
    this.panels.apply(time, this.state(part, time), this.curves(time));
  }

  /* Rows of the bodies at a time, between two frames. */
  state(part, time) {
    const { times, rows, width, bodies } = part;
    const low = lastUntil(time, times.length, (index) => times[index]);
    const next = Math.min(low + 1, times.length - 1);
    const gap = times[next] - times[low];
    const share = gap > 0 ? Math.min(1, Math.max(0, (time - times[low]) / gap)) : 0;
    const state = [];
    let at = 0;
    for (const [key, count] of bodies) {
      const row = [key];
      let same = 0; // cosine between the quaternions: q and -q are one rotation
      for (let k = 3; k < 7; k += 1) same += rows[low * width + at + k] * rows[next * width + at + k];
      for (let k = 0; k < count; k += 1) {
        const a = rows[low * width + at + k];
        const b = rows[next * width + at + k] * (k >= 3 && k < 7 && same < 0 ? -1 : 1);
        row.push(a + share * (b - a));
      }
      const length = Math.hypot(row[4], row[5], row[6], row[7]) || 1;
      for (let k = 4; k < 8; k += 1) row[k] /= length;
      state.push(row);
      at += count;
    }
    return state;
  }

  curves(time) {
    const found = {};
    for (const [name, { unit, points }] of Object.entries(this.data.curves)) {
      const low = lastUntil(time, points.length, (index) => points[index][0]);
      if (points.length && points[low][0] <= time) found[name] = [points[low][1], unit];
    }
    return found;
  }
}

window.page = new Replay(window.REPLAY);
