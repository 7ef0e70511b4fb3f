/* The live page: a WebSocket to the server, the driver's seat, what can be done to the world. */
"use strict";

const RETRY = 1500; // [ms]
const ARROW = 0.15; // [m] of a drag from which on it is a direction

class Live {
  constructor() {
    this.world = new World(byId("world"), (name) => this.load(name), (name) => `asset/${name}`);
    this.panels = new Panels(this.world);
    this.hands = new Hands((speed, steering) => this.drive(speed, steering));
    this.status = { driver: null, you: null, drives: [], cameras: [], lidars: [] };
    this.sceneNumber = 0;
    this.loading = Promise.resolve();
    this.rates = [];
    this.extra = {};
    this.tool = null;
    this.bind();
    this.connect();
    const frame = () => { this.panels.frame(); requestAnimationFrame(frame); };
    frame();
  }

  async load(name) {
    const response = await fetch(`asset/${name}`);
    if (!response.ok) throw new Error(`asset ${name}: ${response.status}`);
    return response.arrayBuffer();
  }

  // the connection -------------------------------------------------------------------------------
  connect() {
    const address = new URL("socket", location.href);
    address.protocol = address.protocol.replace("http", "ws");
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => { this.want(); };
    this.socket.onmessage = (event) => this.receive(event.data);
    this.socket.onclose = () => {
      this.hands.letGo();
      this.sceneNumber = 0;
      cover("The connection is lost. If the world was started again, open its new address.");
      setTimeout(() => this.connect(), RETRY);
    };
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  /* Each message is acknowledged: the server sends no more than the page takes. */
  receive(data) {
    this.send({ type: "ack" });
    if (typeof data !== "string") { this.receiveBinary(data); return; }
    const message = JSON.parse(data);
    if (message.type === "view") this.show(message.view);
    else if (message.type === "status") this.setStatus(message);
    else if (message.type === "scene") this.setScene(message.number);
    else if (message.type === "data") this.setData(message);
    else if (message.type === "contacts") this.world.showContacts(byId("contacts").checked ? message.rows : []);
    else if (message.type === "frames") this.world.setFrames(message.frames);
    else if (message.type === "waiting") cover(message.text);
    else if (message.type === "notice") notice(message.text, message.good);
  }

  receiveBinary(data) {
    const length = new Uint32Array(data, 0, 1)[0];
    const head = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
    const payload = data.slice(4 + length);
    if (head.type === "image") {
      const before = byId("picture").src;
      byId("picture").src = URL.createObjectURL(new Blob([payload], { type: "image/jpeg" }));
      if (before) URL.revokeObjectURL(before);
      byId("picture").hidden = !byId("camera").value;
    } else if (head.type === "points") {
      const shown = byId("lidar").value ? new Float32Array(payload) : null;
      if (!this.world.showCloud(shown, head.hits, head.frame, byId("rays").checked) && this.missing !== head.frame) {
        this.missing = head.frame;
        notice(`The lidar's frame ${head.frame} is no link of a model: its points cannot be shown.`);
      }
    } else if (this.layers().includes(head.topic)) this.world.showLayer(head.topic, head, payload);
  }

  setScene(number) {
    this.loading = this.loading.then(async () => {
      const response = await fetch(`scene/${number}`);
      if (!response.ok) return; // another one has come
      const scene = await response.json();
      await this.world.setScene(scene);
      this.sceneNumber = number;
      this.panels.listModels();
      for (const problem of scene.problems) notice(problem);
      cover("");
    }).catch((error) => notice(`The scene cannot be loaded: ${error.message}`));
  }

  show(view) {
    byId("pace").textContent = view.paused ? "paused" : this.pace(view.time);
    if (view.scene !== this.sceneNumber) return;
    const body = this.world.followed;
    if (this.goal && body) {
      this.extra["to the goal"] = [Math.hypot(body.state[1] - this.goal[0], body.state[2] - this.goal[1]), "m"];
    }
    this.panels.apply(view.time, view.bodies, this.extra);
  }

  /* Simulated seconds per second over the last second, as text. */
  pace(time) {
    const now = performance.now() / 1000;
    if (this.rates.length && time < this.rates[this.rates.length - 1][1]) this.rates = [];
    this.rates.push([now, time]);
    while (this.rates[0][0] < now - 1) this.rates.shift();
    const [then, before] = this.rates[0];
    return now - then < 0.8 ? "" : `x ${((time - before) / (now - then)).toFixed(2)}`;
  }

  // status ---------------------------------------------------------------------------------------
  setStatus(status) {
    this.status = status;
    const mine = status.driver !== null && status.driver === status.you;
    byId("who").textContent = mine ? "You drive." : status.driver === null ? "Nobody drives." : `Page ${status.driver} drives.`;
    byId("take").textContent = mine ? "Let go" : status.driver === null ? "Drive" : "Take over";
    byId("take").classList.toggle("on", mine);
    document.body.dataset.driver = mine ? "me" : status.driver === null ? "nobody" : "other";
    this.options(byId("camera"), [["", "none"], ...status.cameras.map((name) => [name, name])]);
    this.options(byId("lidar"), [["", "none"], ...status.lidars.map((name) => [name, name])]);
    this.listLayers(status.layers);
    this.options(byId("topic"), status.drives.map((each) => [each.topic, each.topic]));
    byId("topic").hidden = status.drives.length < 2;
    byId("topic").value = status.topic || "";
    byId("goal").hidden = byId("cancel").hidden = !status.goal;
    byId("factor").value = String(status.pace);
    const drive = status.drives.find((each) => each.topic === status.topic);
    this.topSpeed = drive || null;
    this.showTop();
  }

  /* A box to tick for each topic of navigation: maps, costmaps, plans, particles. */
  listLayers(topics) {
    const list = byId("layers");
    if (list.dataset.topics === topics.join(" ")) return;
    list.dataset.topics = topics.join(" ");
    const ticked = this.layers();
    list.hidden = !topics.length;
    list.replaceChildren(...topics.map((topic) => {
      const label = document.createElement("label");
      const box = document.createElement("input");
      box.type = "checkbox";
      box.value = topic;
      box.checked = ticked.includes(topic);
      box.onchange = () => {
        if (!box.checked) this.world.showLayer(topic, null);
        this.want();
      };
      label.append(box, ` ${topic}`);
      return label;
    }));
    for (const topic of ticked) if (!topics.includes(topic)) this.world.showLayer(topic, null);
  }

  /* Topics that are ticked. */
  layers() {
    return [...byId("layers").querySelectorAll("input:checked")].map((box) => box.value);
  }

  showTop() {
    const drive = this.topSpeed;
    byId("topvalue").textContent = drive ? `${(byId("top").value * drive.speed).toPrecision(2)} ${drive.unit}` : "no topic to drive";
  }

  /* Sets the options of a select, and keeps what is chosen. */
  options(select, wanted) {
    const present = [...select.options].map((option) => option.value).join("\n");
    if (present === wanted.map(([value]) => value).join("\n")) return;
    const chosen = select.value;
    select.replaceChildren(...wanted.map(([value, text]) => new Option(text, value)));
    if (wanted.some(([value]) => value === chosen)) select.value = chosen;
  }

  setData(data) {
    this.extra = {};
    if ("lateral_error" in data) this.extra["to the center line"] = [data.lateral_error, "m"];
    this.goal = data.goal || null;
    this.world.showGoal(this.goal);
    byId("lap").textContent = data.lap || "";
  }

  // driving --------------------------------------------------------------------------------------
  drive(speed, steering) {
    const mine = this.status.driver === this.status.you;
    if (!mine && this.status.driver !== null) {
      if ((speed || steering) && !this.refused) notice(`Page ${this.status.driver} drives: press Take over.`);
      this.refused = Boolean(speed || steering);
      return;
    }
    this.send({ type: "drive", speed, steering });
  }

  bind() {
    byId("take").onclick = (event) => {
      const mine = this.status.driver === this.status.you;
      if (mine) this.hands.letGo();
      this.send({ type: mine ? "release" : "take" });
      event.target.blur();
    };
    byId("top").addEventListener("input", () => this.showTop());
    byId("topic").onchange = (event) => { this.hands.letGo(); this.send({ type: "topic", topic: event.target.value }); };
    byId("camera").onchange = () => {
      byId("picture").hidden = true;
      this.want();
    };
    byId("lidar").onchange = () => {
      this.world.showCloud(null);
      this.want();
    };
    byId("contacts").onchange = () => {
      this.world.showContacts([]);
      this.want();
    };
    this.panels.onpanel = () => this.want();
    for (const button of document.querySelectorAll("[data-do]")) {
      button.onclick = () => { button.blur(); this.act(button.dataset.do); };
    }
    byId("factor").onchange = (event) => this.act("pace", { factor: Number(event.target.value) });
    for (const button of document.querySelectorAll("[data-tool]")) {
      button.onclick = () => { button.blur(); this.setTool(this.tool === button.dataset.tool ? null : button.dataset.tool); };
    }
    this.watchTool();
  }

  want() {
    const looking = !byId("look").hidden;
    this.send({
      type: "want",
      camera: looking ? byId("camera").value : "",
      lidar: byId("lidar").value,
      data: !byId("plots").hidden,
      contacts: byId("contacts").checked,
      layers: this.layers().join(" "),
    });
  }

  act(action, values = {}) {
    if (action === "step") values = { count: Number(byId("steps").value) };
    if (action === "remove") values = { model: this.panels.chosen };
    if (action === "goal" && this.world.followed) values = { ...values, model: this.world.followed.name };
    this.send({ type: "do", action, ...values });
  }

  // tools: a click or a drag on the ground ---------------------------------------------------------
  setTool(tool) {
    this.tool = tool;
    for (const button of document.querySelectorAll("[data-tool]")) {
      button.classList.toggle("on", button.dataset.tool === tool);
    }
    byId("hint").textContent = !tool ? "Click a model to choose it."
      : tool === "place" ? `Click where ${this.placed() || "the model"} shall be; drag for its heading.`
        : "Click the place; drag for a heading.";
  }

  placed() {
    const chosen = this.panels.chosen && this.world.body(this.panels.chosen);
    const body = chosen && !chosen.fixed ? chosen : this.world.followed;
    return body && body.name;
  }

  watchTool() {
    let from = null;
    let yaw = null;
    const end = () => { from = yaw = null; this.world.controls.enabled = true; this.world.showArrow(null); };
    this.panels.ondown = (event) => {
      if (!this.tool) return;
      const hit = this.world.pick(event.clientX, event.clientY);
      if (!hit) return;
      from = hit.point;
      this.world.controls.enabled = false;
    };
    this.panels.onmove = (event) => {
      if (!from) return;
      const hit = this.world.pick(event.clientX, event.clientY);
      if (!hit || Math.hypot(hit.point.x - from.x, hit.point.y - from.y) < ARROW) return;
      yaw = Math.atan2(hit.point.y - from.y, hit.point.x - from.x);
      this.world.showArrow(from, yaw);
    };
    this.panels.onup = () => {
      if (!from) return false;
      const place = { x: from.x, y: from.y, z: from.z };
      if (yaw !== null) place.yaw = yaw;
      if (this.tool === "place") this.act("place", { model: this.placed(), ...place });
      else if (this.tool === "goal") this.act("goal", place);
      else this.act("spawn", { kind: this.tool, ...place });
      this.setTool(null);
      end();
      return true;
    };
    this.panels.oncancel = end;
  }
}

window.page = new Live();
