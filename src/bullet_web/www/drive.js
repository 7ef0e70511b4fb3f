/* What drives on the live page: keys, two pads for thumbs, the slider with cruise.

   A command is (speed, steering), both -1..1 of the top speed and the largest steering; steering to
   the right is positive. While it is not zero it is repeated, so that the server's watchdog knows that
   the page is there; at the end one zero is sent. */
"use strict";

const REPEAT = 100; // [ms]
const KEYS = {
  ArrowUp: [1, 0], KeyW: [1, 0], ArrowDown: [-1, 0], KeyS: [-1, 0],
  ArrowLeft: [0, -1], KeyA: [0, -1], ArrowRight: [0, 1], KeyD: [0, 1],
};
const KEY_STEERING = 0.6; // of a held key
const DEAD = 0.08; // of a pad

const limited = (value) => Math.max(-1, Math.min(1, value));

class Hands {
  /* send(speed, steering) is called at each change and while the command is not zero. */
  constructor(send) {
    this.send = send;
    this.held = new Set();
    this.pads = { speed: 0, steering: 0 };
    this.resets = []; // of the pads
    this.last = [0, 0];
    this.watchKeys();
    this.watchPad(byId("speedpad"), (x, y) => { this.pads.speed = -y; });
    this.watchPad(byId("steerpad"), (x) => { this.pads.steering = x; });
    byId("steer").oninput = () => this.update();
    byId("steer").ondblclick = () => { byId("steer").value = 0; this.update(); };
    byId("cruise").onchange = () => this.update();
    byId("top").oninput = () => this.update();
    window.addEventListener("blur", () => this.letGo());
    window.addEventListener("pagehide", () => this.letGo());
    document.addEventListener("visibilitychange", () => { if (document.hidden) this.letGo(); });
    const showPads = () => document.body.classList.add("pads");
    if (matchMedia("(pointer: coarse)").matches) showPads();
    window.addEventListener("touchstart", showPads, { once: true, passive: true });
    setInterval(() => { if (this.last[0] || this.last[1]) this.send(...this.last); }, REPEAT);
  }

  watchKeys() {
    window.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey) return;
      if (/^(SELECT|TEXTAREA)$/.test(event.target.tagName) || event.target.type === "number") return;
      if (event.code === "Space") {
        if (event.target.tagName === "BUTTON") return; // it clicks
        event.preventDefault();
        this.letGo();
        return;
      }
      if (!(event.code in KEYS)) return;
      if (event.target.type === "range" && event.code.startsWith("Arrow")) return;
      event.preventDefault();
      if (event.repeat) return; // after a stop it has to be pressed again
      this.held.add(event.code);
      this.update();
    });
    window.addEventListener("keyup", (event) => {
      if (this.held.delete(event.code)) this.update();
    });
  }

  watchPad(pad, set) {
    const knob = pad.firstElementChild;
    let finger = null;
    const move = (event) => {
      if (event.pointerId !== finger) return;
      const box = pad.getBoundingClientRect();
      const at = (value) => (Math.abs(value) < DEAD ? 0 : limited(value));
      const x = at((event.clientX - box.left - box.width / 2) / (0.4 * box.width));
      const y = at((event.clientY - box.top - box.height / 2) / (0.4 * box.height));
      set(x, y);
      knob.style.transform = pad.id === "speedpad" ? `translateY(${40 * y}px)` : `translateX(${40 * x}px)`;
      this.update();
    };
    const reset = () => {
      finger = null;
      set(0, 0);
      knob.style.transform = "";
    };
    const release = (event) => {
      if (event.pointerId !== finger) return;
      reset();
      this.update();
    };
    this.resets.push(reset);
    pad.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      finger = event.pointerId;
      pad.setPointerCapture(finger);
      move(event);
    });
    pad.addEventListener("pointermove", move);
    for (const name of ("pointerup pointercancel lostpointercapture").split(" ")) pad.addEventListener(name, release);
    pad.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /* Lets everything go: one zero follows. */
  letGo() {
    this.held.clear();
    byId("cruise").checked = false;
    for (const reset of this.resets) reset();
    this.update();
  }

  update() {
    const keys = { speed: 0, steering: 0 };
    for (const code of this.held) {
      keys.speed += KEYS[code][0];
      keys.steering += KEYS[code][1];
    }
    // Two keys of one direction count once.
    keys.speed = limited(keys.speed);
    keys.steering = KEY_STEERING * limited(keys.steering);
    const top = Number(byId("top").value);
    const cruising = byId("cruise").checked;
    const speed = limited(keys.speed + this.pads.speed) || (cruising ? 1 : 0);
    const slider = Number(byId("steer").value);
    const steering = limited(keys.steering + this.pads.steering) || (cruising || speed ? slider : 0);
    const command = [top * speed, steering];
    const changed = command[0] !== this.last[0] || command[1] !== this.last[1];
    this.last = command;
    if (changed) this.send(...command);
  }
}
