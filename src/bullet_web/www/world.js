/* The simulated world in three.js: models, light, cameras, marks. Used by the live page and by replays.

   Lengths in m, angles in rad, quaternions (x, y, z, w), z up. A scene is what scene.py makes of
   /gazebo/scene; a state is a row of /gazebo/view: key, position, quaternion, joint positions. */
"use strict";

const CHASE = { back: 1.6, up: 0.75 }; // the camera behind a model, in lengths of the model
const PATH_POINTS = 20000;
const PATH_STEP = 0.02; // [m] between two points of the path
const NORMAL = 0.05; // length of a contact's normal, of the distance to the camera
const NAME = 0.017; // height of a frame's name, of the page at a distance of 1
const SAME_PLACE = 0.03; // [m] between two frames whose names would cover each other
const SHADOW_PIXELS = 2048;
const LAYER_HEIGHTS = { grid: 0.012, path: 0.04, poses: 0.05 }; // [m] above the ground
const POSE_LENGTH = 0.2; // [m] of a pose's line
const SLOW_FRAME = 80; // [ms] the median between two frames above which shadows are switched off
const FRAMES = 30; // that are looked at
const HIDDEN = 1000; // [ms] a longer time: the page was in the background

class World {
  /* canvas: where it is drawn; loadMesh(name): Promise of an ArrayBuffer (see mesh_asset);
     loadImage(name): an address. */
  constructor(canvas, loadMesh, loadImage) {
    this.canvas = canvas;
    this.loadMesh = loadMesh;
    this.loadImage = loadImage;
    const attributes = { antialias: true, powerPreference: "high-performance" };
    const context = canvas.getContext("webgl2", attributes) || canvas.getContext("webgl", attributes);
    if (!context) throw new Error("this browser has no WebGL, which the page needs");
    this.renderer = new THREE.WebGLRenderer({ canvas, context });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.three = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(45, 1, 0.05, 500);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.enableKeys = false; // the arrow keys drive
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.2;
    this.controls.minDistance = 0.1;
    this.controls.maxDistance = 300;
    this.controls.addEventListener("change", () => this.touch());
    this.controls.addEventListener("start", () => { this.moved = true; });
    this.content = new THREE.Group();
    this.lights = new THREE.Group();
    this.three.add(this.content, this.lights);
    this.sky = this.makeSky();
    this.meshes = new Map();
    this.images = new Map();
    this.bodies = new Map(); // key -> body
    this.followed = null;
    this.mode = "follow";
    this.moved = false; // whether somebody has turned the camera
    this.dirty = true;
    this.frameTimes = [];
    this.shadowsOn = true;
    this.onslow = () => {}; // called when shadows were switched off
    this.anchor = null; // pose of the followed body when the camera was last moved with it
    this.path = this.makePath();
    this.cloud = null;
    this.contacts = null;
    this.axes = [];
    this.marks = new THREE.Group();
    this.three.add(this.marks);
    this.frames = new Map(); // of navigation: name -> group
    this.layers = new Map(); // topic -> object in one of them
    this.newest = new Map(); // topic -> head of its newest message
    this.resize();
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  touch() { this.dirty = true; }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.fov = width < height ? 60 : 45;
    this.camera.updateProjectionMatrix();
    this.touch();
  }

  /* Draws if something has changed; call it for each frame of the browser. */
  render() {
    this.measure();
    this.controls.update();
    if (!this.dirty) return;
    this.dirty = false;
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = Math.min(1, Math.max(0.01, 0.02 * distance));
    this.camera.far = Math.max(200, 20 * distance);
    this.camera.updateProjectionMatrix();
    this.sky.position.copy(this.camera.position);
    this.sky.scale.setScalar(0.5 * this.camera.far);
    this.aimShadow();
    this.renderer.render(this.three, this.camera);
  }

  /* Switches shadows off where they are not cheap: a slow graphics driver delays the next frame. */
  measure() {
    const now = performance.now();
    const past = now - (this.lastFrame || now);
    this.lastFrame = now;
    if (!this.shadowsOn || !past || past > HIDDEN) return;
    this.frameTimes.push(past);
    if (this.frameTimes.length < FRAMES) return;
    const times = this.frameTimes.splice(0).sort((a, b) => a - b);
    if (times[times.length >> 1] <= SLOW_FRAME) return;
    this.setShadows(false);
    this.onslow();
  }

  setShadows(on) {
    this.shadowsOn = on;
    this.frameTimes.length = 0;
    for (const light of this.lights.children) {
      if (light.userData.casts) light.castShadow = on;
    }
    this.touch();
  }

  // the scene ----------------------------------------------------------------------------------
  /* Shows another scene; what both have in common is not loaded again. */
  async setScene(scene) {
    const names = new Set();
    const images = new Set();
    for (const body of scene.bodies) for (const link of body.links) for (const each of link.instances) {
      names.add(each.mesh);
      if (each.image) images.add(each.image);
    }
    const loaded = await Promise.all([...names].map((name) => this.geometry(name)));
    this.built = new Map([...names].map((name, index) => [name, loaded[index]]));
    this.forget(this.meshes, names);
    this.forget(this.images, images);
    const before = this.bodies;
    this.bodies = new Map();
    this.showCloud(null);
    for (const axes of this.axes) this.unmark(axes);
    this.axes = [];
    this.dispose(this.content);
    for (const fields of scene.bodies) {
      const body = this.makeBody(fields);
      this.bodies.set(fields.key, body);
      this.content.add(body.root);
      const old = before.get(fields.key);
      this.place(body, old ? old.state : fields.state);
    }
    this.setLight(scene.light, scene.sky);
    if (!this.followed || !this.bodies.has(this.followed.key)) this.follow(this.firstMoving());
    else this.followed = this.bodies.get(this.followed.key);
    this.showAxes(this.axesShown, this.axesNamed);
    this.touch();
  }

  forget(cache, names) {
    for (const [name, value] of cache) {
      if (names.has(name)) continue;
      Promise.resolve(value).then((each) => each.dispose());
      cache.delete(name);
    }
  }

  geometry(name) {
    if (!this.meshes.has(name)) {
      this.meshes.set(name, this.loadMesh(name).then((data) => World.parseMesh(data)));
    }
    return this.meshes.get(name);
  }

  static parseMesh(data) {
    const count = new Uint32Array(data, 0, 1)[0];
    const corners = new THREE.InterleavedBuffer(new Float32Array(data, 4, 8 * count), 8);
    const triangles = new Uint32Array(data, 4 + 32 * count);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.InterleavedBufferAttribute(corners, 3, 0));
    geometry.setAttribute("normal", new THREE.InterleavedBufferAttribute(corners, 3, 3));
    geometry.setAttribute("uv", new THREE.InterleavedBufferAttribute(corners, 2, 6));
    geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
    geometry.computeBoundingSphere();
    geometry.computeBoundingBox();
    return geometry;
  }

  texture(name) {
    if (!this.images.has(name)) {
      const texture = new THREE.TextureLoader().load(this.loadImage(name), () => this.touch());
      texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
      texture.anisotropy = Math.min(8, this.renderer.capabilities.getMaxAnisotropy());
      this.images.set(name, texture);
    }
    return this.images.get(name);
  }

  makeBody(fields) {
    const root = new THREE.Group();
    const links = [];
    const moving = []; // of the links with a joint that moves
    for (const link of fields.links) {
      const group = new THREE.Group();
      const origin = new THREE.Vector3(...link.origin.position);
      const turn = new THREE.Quaternion(...link.origin.orientation);
      group.position.copy(origin);
      group.quaternion.copy(turn);
      if (link.parent < 0) { group.position.set(0, 0, 0); group.quaternion.set(0, 0, 0, 1); }
      (link.parent < 0 ? root : links[link.parent]).add(group);
      for (const each of link.instances) group.add(this.makeMesh(each));
      links.push(group);
      if (link.kind !== "fixed") {
        moving.push({ group, origin, turn, axis: new THREE.Vector3(...link.axis), kind: link.kind, joint: link.joint });
      }
    }
    const body = { key: fields.key, name: fields.name, fixed: fields.static, frames: fields.frames, root, links, moving, state: fields.state };
    root.traverse((object) => { object.userData.body = body; });
    root.updateMatrixWorld(true);
    const size = new THREE.Box3().setFromObject(root).getSize(new THREE.Vector3());
    body.size = Math.min(20, Math.max(0.3, size.x, size.y)); // [m] for cameras
    return body;
  }

  makeMesh(each) {
    const mesh = new THREE.Mesh(this.built.get(each.mesh), this.material(each));
    mesh.matrixAutoUpdate = false;
    mesh.matrix.fromArray(each.matrix);
    mesh.receiveShadow = each.lit;
    const box = mesh.geometry.boundingBox.clone().applyMatrix4(mesh.matrix);
    mesh.castShadow = each.casts && box.max.z - box.min.z > 0.02; // a floor casts none
    return mesh;
  }

  material(each) {
    const [red, green, blue, alpha] = each.color;
    const options = {
      color: new THREE.Color(red, green, blue),
      map: each.image ? this.texture(each.image) : null,
      opacity: alpha,
      transparent: each.transparent,
      side: each.double_sided ? THREE.DoubleSide : THREE.FrontSide,
    };
    if (!each.lit) return new THREE.MeshBasicMaterial(options);
    return new THREE.MeshPhongMaterial({
      ...options,
      specular: new THREE.Color(...each.specular),
      emissive: new THREE.Color(...each.emissive),
      shininess: each.shininess,
    });
  }

  /* Lights add up as in Gazebo: in the colors' space, without gamma (three.js r111 does the same). */
  setLight(light, sky) {
    this.dispose(this.lights);
    this.lights.add(new THREE.AmbientLight(new THREE.Color(...light.ambient)));
    this.sun = null;
    for (const each of light.lights) {
      const color = new THREE.Color(...each.diffuse);
      const away = new THREE.Vector3(...each.direction).normalize();
      let lamp;
      if (each.kind === "directional") {
        lamp = new THREE.DirectionalLight(color);
        lamp.userData.away = away;
        lamp.position.copy(away).multiplyScalar(-1);
        if (light.shadows && each.cast_shadows && !this.sun) this.castShadows(lamp);
      } else {
        const spot = each.kind === "spot";
        lamp = spot ? new THREE.SpotLight(color) : new THREE.PointLight(color);
        lamp.position.set(...each.position);
        lamp.distance = each.reach;
        if (spot) {
          lamp.angle = Math.min(0.5 * each.outer, 1.5);
          lamp.penumbra = each.outer > 0 ? 1 - Math.min(1, each.inner / each.outer) : 0;
          lamp.target.position.set(...each.position).add(away);
        }
      }
      this.lights.add(lamp);
      if (lamp.target) this.lights.add(lamp.target);
    }
    this.sky.visible = !light.background;
    this.three.background = light.background ? new THREE.Color(...light.background) : null;
    this.sky.material.uniforms.horizon.value.set(...sky[0]);
    this.sky.material.uniforms.zenith.value.set(...sky[1]);
    const fog = light.fog;
    if (!fog) this.three.fog = null;
    else if (fog.kind === "linear") this.three.fog = new THREE.Fog(new THREE.Color(...fog.color), fog.start, fog.end);
    else this.three.fog = new THREE.FogExp2(new THREE.Color(...fog.color), fog.density);
  }

  castShadows(lamp) {
    this.sun = lamp;
    lamp.castShadow = this.shadowsOn;
    lamp.userData.casts = true;
    this.shadowHalf = 0; // its camera is not aimed yet
    lamp.shadow.mapSize.set(SHADOW_PIXELS, SHADOW_PIXELS);
    lamp.shadow.bias = -0.0005;
  }

  /* Puts the sun's shadow map around what the camera looks at. */
  aimShadow() {
    if (!this.sun || !this.sun.castShadow) return;
    const target = this.controls.target;
    const half = Math.min(40, Math.max(1.5, 1.2 * this.camera.position.distanceTo(target)));
    if (Math.abs(half - this.shadowHalf) > 0.2 * half) {
      const camera = this.sun.shadow.camera;
      camera.left = camera.bottom = -half;
      camera.right = camera.top = half;
      camera.near = 0.1;
      camera.far = 80 + 2 * half;
      camera.updateProjectionMatrix();
      this.shadowHalf = half;
    }
    this.sun.target.position.copy(target);
    this.sun.position.copy(target).addScaledVector(this.sun.userData.away, -40 - half);
  }

  makeSky() {
    const material = new THREE.ShaderMaterial({
      uniforms: { horizon: { value: new THREE.Vector3() }, zenith: { value: new THREE.Vector3() } },
      vertexShader: `varying vec3 direction;
        void main() { direction = position; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }`,
      fragmentShader: `varying vec3 direction; uniform vec3 horizon; uniform vec3 zenith;
        void main() { gl_FragColor = vec4(mix(horizon, zenith, clamp(2.0 * normalize(direction).z, 0.0, 1.0)), 1.0); }`,
      side: THREE.BackSide, depthWrite: false, depthTest: false, fog: false,
    });
    const sky = new THREE.Mesh(new THREE.SphereBufferGeometry(1, 32, 16), material);
    sky.renderOrder = -1;
    sky.frustumCulled = false;
    this.three.add(sky);
    return sky;
  }

  /* Takes everything out of a group and frees what is its own: materials; meshes are shared. */
  dispose(group) {
    group.traverse((object) => {
      if (object.material && object.material.dispose) object.material.dispose();
      if (object.shadow && object.shadow.map) { object.shadow.map.dispose(); object.shadow.map = null; }
    });
    group.remove(...group.children);
  }

  // states -------------------------------------------------------------------------------------
  /* Puts bodies where rows of a view have them. */
  apply(rows) {
    for (const row of rows) {
      const body = this.bodies.get(row[0]);
      if (body) this.place(body, row);
    }
    this.moveCamera();
    this.extendPath();
    this.touch();
  }

  place(body, row) {
    body.state = row;
    body.root.position.set(row[1], row[2], row[3]);
    body.root.quaternion.set(row[4], row[5], row[6], row[7]);
    body.moving.forEach((joint, index) => {
      const value = row[8 + index] || 0;
      if (joint.kind === "prismatic") {
        joint.group.position.copy(joint.axis).multiplyScalar(value).applyQuaternion(joint.turn).add(joint.origin);
      } else {
        joint.group.quaternion.setFromAxisAngle(joint.axis, value).premultiply(joint.turn);
      }
    });
  }

  /* Positions of joints by name, of a body. */
  joints(body) {
    const all = body.moving.map((joint, index) => [joint.joint, body.state[8 + index]]);
    return Object.fromEntries(all.filter(([name]) => name));
  }

  yaw(body) {
    const [, , , , x, y, z, w] = body.state;
    return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
  }

  /* The models that can move, those with joints first. */
  movingBodies() {
    const found = [...this.bodies.values()].filter((body) => !body.fixed);
    return found.sort((a, b) => Math.sign(b.moving.length) - Math.sign(a.moving.length));
  }

  firstMoving() { return this.movingBodies()[0] || null; }

  body(name) { return [...this.bodies.values()].find((each) => each.name === name) || null; }

  // cameras ------------------------------------------------------------------------------------
  follow(body) {
    this.followed = body;
    this.clearPath();
    this.view(this.mode);
  }

  /* mode: "follow" (behind the model, turns with it), "free" or "above". */
  view(mode) {
    this.mode = mode;
    this.controls.enableRotate = mode !== "above";
    this.controls.screenSpacePanning = mode === "above";
    const target = this.controls.target;
    const size = this.followed ? this.followed.size : 2;
    if (this.followed) target.copy(this.followed.root.position);
    if (mode === "follow" && this.followed) {
      const yaw = this.yaw(this.followed);
      const back = CHASE.back * size + 0.5;
      this.camera.position.set(
        target.x - back * Math.cos(yaw), target.y - back * Math.sin(yaw), target.z + CHASE.up * size + 0.3);
    } else if (mode === "above") {
      this.camera.position.set(target.x, target.y - 0.001, target.z + Math.max(8, 6 * size));
    }
    this.anchor = null;
    this.moveCamera();
    this.controls.update();
    this.touch();
  }

  /* Moves the camera with the followed model, and turns it in the mode "follow". */
  moveCamera() {
    const body = this.followed;
    if (!body || this.mode === "free") { this.anchor = null; return; }
    const now = { position: body.root.position.clone(), yaw: this.yaw(body) };
    if (this.anchor) {
      const arm = this.camera.position.clone().sub(this.controls.target);
      if (this.mode === "follow") arm.applyAxisAngle(this.camera.up, now.yaw - this.anchor.yaw);
      this.controls.target.add(now.position.clone().sub(this.anchor.position));
      this.camera.position.copy(this.controls.target).add(arm);
    }
    this.anchor = now;
  }

  /* A camera as the simulator's: position, quaternion of a frame with x forward, horizontal angle. */
  setCamera(position, quaternion, fov) {
    this.view("free");
    const turn = new THREE.Quaternion(...quaternion);
    this.camera.position.set(...position);
    this.controls.target.copy(this.camera.position).add(new THREE.Vector3(1, 0, 0).applyQuaternion(turn));
    this.camera.fov = (2 * Math.atan(Math.tan(fov / 2) / this.camera.aspect) * 180) / Math.PI;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.touch();
  }

  // what is clicked, marks -----------------------------------------------------------------------
  /* What is at a place of the page [px]: {body, point} or null. */
  pick(clientX, clientY) {
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(
      (2 * (clientX - box.left)) / box.width - 1, 1 - (2 * (clientY - box.top)) / box.height);
    this.camera.updateMatrixWorld();
    const caster = new THREE.Raycaster();
    caster.setFromCamera(at, this.camera);
    const hit = caster.intersectObject(this.content, true).find((each) => each.object.isMesh);
    return hit ? { body: hit.object.userData.body, point: hit.point } : null;
  }

  /* Where a point of the world is on the page [px], or null behind the camera. */
  toPage(point) {
    this.camera.updateMatrixWorld();
    const seen = point.clone().project(this.camera);
    if (seen.z > 1) return null;
    const box = this.canvas.getBoundingClientRect();
    return { x: box.left + 0.5 * (1 + seen.x) * box.width, y: box.top + 0.5 * (1 - seen.y) * box.height };
  }

  makePath() {
    const geometry = new THREE.BufferGeometry();
    const places = new THREE.BufferAttribute(new Float32Array(3 * PATH_POINTS), 3);
    places.usage = THREE.DynamicDrawUsage;
    geometry.setAttribute("position", places);
    geometry.setDrawRange(0, 0);
    const line = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: 0xff9500 }));
    line.frustumCulled = false;
    line.visible = false;
    this.three.add(line);
    return line;
  }

  clearPath() {
    this.path.geometry.setDrawRange(0, 0);
    this.lastPoint = null;
    this.touch();
  }

  extendPath() {
    if (!this.followed) return;
    const place = this.followed.root.position;
    if (this.lastPoint && this.lastPoint.distanceTo(place) < PATH_STEP) return;
    if (this.lastPoint && this.lastPoint.distanceTo(place) > 1) this.clearPath(); // it was put there
    const count = this.path.geometry.drawRange.count;
    if (count >= PATH_POINTS) return;
    this.path.geometry.attributes.position.setXYZ(count, place.x, place.y, place.z + 0.02);
    this.path.geometry.attributes.position.needsUpdate = true;
    this.path.geometry.setDrawRange(0, count + 1);
    this.lastPoint = place.clone();
  }

  /* Points or lines of places (n, 3), drawn wherever they are, not just in the camera's view. */
  marked(Kind, places, material) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
    const found = new Kind(geometry, material);
    found.frustumCulled = false;
    return found;
  }

  /* Takes an object of marked() out of the scene, with what is below it. */
  unmark(object) {
    object.parent.remove(object);
    object.traverse((each) => {
      if (each.geometry && !each.isSprite) each.geometry.dispose(); // sprites share theirs
      if (each.material) {
        if (each.material.map) each.material.map.dispose();
        each.material.dispose();
      }
    });
  }

  /* Shows the ends (n, 3) of a sensor's rays in a link's frame; null: none.
     hits: how many have an echo; they come first. rays: whether the rays are shown, too.
     Returns whether a model has that frame. */
  showCloud(ends, hits, frame, rays) {
    if (this.cloud) this.unmark(this.cloud);
    this.cloud = null;
    this.touch();
    if (!ends) return true;
    for (const body of this.bodies.values()) {
      const place = body.frames[frame];
      if (!place) continue;
      this.cloud = new THREE.Group();
      this.cloud.position.set(...place.slice(1, 4));
      this.cloud.quaternion.set(...place.slice(4, 8));
      this.cloud.add(this.marked(THREE.Points, ends.slice(0, 3 * hits),
        new THREE.PointsMaterial({ color: 0xff2d55, size: 4, sizeAttenuation: false })));
      if (rays) {
        const lines = new Float32Array(2 * ends.length); // from the frame's origin to each end
        for (let at = 0; at < ends.length; at += 3) lines.set(ends.subarray(at, at + 3), 2 * at + 3);
        this.cloud.add(this.marked(THREE.LineSegments, lines,
          new THREE.LineBasicMaterial({ color: 0x2878ff, transparent: true, opacity: 0.35 })));
      }
      body.links[place[0]].add(this.cloud);
      return true;
    }
    return false;
  }

  // navigation -----------------------------------------------------------------------------------
  /* Puts the frames of navigation (map, odom) where they are in the world: name -> [x, y, yaw].
     Of others it is not known: what is in them is not shown. */
  setFrames(places) {
    for (const name of Object.keys(places)) this.frame(name);
    for (const [name, group] of this.frames) {
      const place = places[name];
      group.visible = Boolean(place);
      if (place) { group.position.set(place[0], place[1], 0); group.rotation.z = place[2]; }
    }
    this.touch();
  }

  frame(name) {
    if (!this.frames.has(name)) {
      const group = new THREE.Group();
      group.visible = false;
      this.frames.set(name, group);
      this.three.add(group);
    }
    return this.frames.get(name);
  }

  /* Shows what a topic of navigation has, by the head and the payload of its message; no head: none. */
  showLayer(topic, head, payload) {
    const shown = (object) => {
      if (this.layers.has(topic)) this.unmark(this.layers.get(topic));
      this.layers.delete(topic);
      if (object) { this.layers.set(topic, object); this.frame(head.frame).add(object); }
      this.touch();
    };
    this.newest.set(topic, head);
    if (!head) { shown(null); return; }
    if (head.type !== "grid") {
      shown(this.lineLayer(topic, head.type, new Float32Array(payload)));
      return;
    }
    const image = new Image();
    image.onload = () => {
      URL.revokeObjectURL(image.src);
      if (this.newest.get(topic) === head) shown(this.gridLayer(topic, head, image));
    };
    image.src = URL.createObjectURL(new Blob([payload], { type: "image/png" }));
  }

  gridLayer(topic, head, image) {
    const map = new THREE.Texture(image);
    map.magFilter = THREE.NearestFilter;
    map.minFilter = THREE.LinearFilter; // sizes are no powers of two
    map.needsUpdate = true;
    const [width, height] = head.size;
    const material = new THREE.MeshBasicMaterial({ map, transparent: true, depthWrite: false, fog: false });
    const mesh = new THREE.Mesh(new THREE.PlaneBufferGeometry(width, height), material);
    const rank = /costmap/.test(topic) ? (/local/.test(topic) ? 3 : 2) : 1;
    mesh.renderOrder = rank;
    mesh.position.set(head.at[0] + width / 2, head.at[1] + height / 2, rank * LAYER_HEIGHTS.grid);
    const group = new THREE.Group();
    group.position.set(head.origin[0], head.origin[1], 0);
    group.rotation.z = head.origin[2];
    group.add(mesh);
    return group;
  }

  lineLayer(topic, type, numbers) {
    const height = LAYER_HEIGHTS[type];
    const places = [];
    if (type === "path") {
      for (let at = 0; at < numbers.length; at += 2) places.push(numbers[at], numbers[at + 1], height);
    } else {
      for (let at = 0; at < numbers.length; at += 3) {
        const [x, y, yaw] = numbers.subarray(at, at + 3);
        places.push(x, y, height, x + POSE_LENGTH * Math.cos(yaw), y + POSE_LENGTH * Math.sin(yaw), height);
      }
    }
    const color = type === "poses" ? 0x50a0ff : /local/.test(topic) ? 0xffbe28 : 0x3cdc3c;
    const material = new THREE.LineBasicMaterial({ color, depthTest: false, transparent: true });
    const lines = this.marked(type === "path" ? THREE.Line : THREE.LineSegments, new Float32Array(places), material);
    lines.renderOrder = 4;
    return lines;
  }

  /* Shows contact points with their normals, in front of everything: rows of position, unit normal
     and force, as in /gazebo/contacts. */
  showContacts(rows) {
    if (this.contacts) this.unmark(this.contacts);
    this.contacts = null;
    this.touch();
    if (!rows.length) return;
    const places = new Float32Array(3 * rows.length);
    const normals = new Float32Array(6 * rows.length);
    const eye = this.camera.position;
    rows.forEach(([x, y, z, ...normal], index) => {
      const length = NORMAL * Math.hypot(x - eye.x, y - eye.y, z - eye.z);
      places.set([x, y, z], 3 * index);
      normals.set([x, y, z, x + length * normal[0], y + length * normal[1], z + length * normal[2]], 6 * index);
    });
    const look = { color: 0xffaa00, depthTest: false, transparent: true };
    this.contacts = new THREE.Group();
    this.contacts.add(
      this.marked(THREE.Points, places, new THREE.PointsMaterial({ ...look, size: 6, sizeAttenuation: false })),
      this.marked(THREE.LineSegments, normals, new THREE.LineBasicMaterial(look)));
    this.three.add(this.contacts);
  }

  /* Shows the frames of all links of the models that can move: x red, y green, z blue.
     named: name of a model whose frames show their names. */
  showAxes(on, named) {
    this.axesShown = Boolean(on);
    this.axesNamed = named;
    for (const axes of this.axes) this.unmark(axes);
    this.axes = [];
    const places = []; // places of the names so far, of the model as it is now
    if (on) for (const body of this.movingBodies()) for (const [name, place] of Object.entries(body.frames)) {
      const axes = new THREE.AxesHelper(0.12);
      axes.position.set(...place.slice(1, 4));
      axes.quaternion.set(...place.slice(4, 8));
      axes.material.depthTest = false;
      axes.renderOrder = 1;
      body.links[place[0]].add(axes);
      if (body.name === named) {
        const at = axes.getWorldPosition(new THREE.Vector3());
        axes.add(this.nameSprite(name, places.filter((each) => each.distanceTo(at) < SAME_PLACE).length));
        places.push(at);
      }
      this.axes.push(axes);
    }
    this.touch();
  }

  /* A text of the same size at any distance, to the right of its place; below others that are there. */
  nameSprite(text, above) {
    const canvas = document.createElement("canvas");
    const context = canvas.getContext("2d");
    const font = "28px system-ui, sans-serif";
    context.font = font;
    canvas.width = Math.ceil(context.measureText(text).width) + 12;
    canvas.height = 36;
    context.font = font; // a canvas forgets it with its size
    context.fillStyle = "rgba(12, 14, 18, 0.6)";
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.fillStyle = "#fff";
    context.fillText(text, 6, 27);
    const map = new THREE.CanvasTexture(canvas);
    map.minFilter = THREE.LinearFilter; // sizes are no powers of two
    const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map, depthTest: false, sizeAttenuation: false }));
    sprite.center.set(0, 1.05 * above);
    sprite.scale.set((NAME * canvas.width) / canvas.height, NAME, 1);
    sprite.renderOrder = 2;
    return sprite;
  }

  /* Shows a goal (x, y) as a ring on the ground, or none. */
  showGoal(goal) {
    const text = JSON.stringify(goal || null);
    if (text === this.goalShown) return;
    this.goalShown = text;
    if (!this.ring) {
      const material = new THREE.MeshBasicMaterial({ color: 0x34c759, side: THREE.DoubleSide });
      this.ring = new THREE.Mesh(new THREE.RingBufferGeometry(0.2, 0.28, 48), material);
      this.three.add(this.ring);
    }
    this.ring.visible = Boolean(goal);
    if (goal) this.ring.position.set(goal[0], goal[1], 0.03);
    this.touch();
  }

  /* Shows an arrow on the ground, or none. */
  showArrow(from, yaw) {
    this.dispose(this.marks);
    if (from) {
      const direction = new THREE.Vector3(Math.cos(yaw), Math.sin(yaw), 0);
      this.marks.add(new THREE.ArrowHelper(direction, from.clone().setZ(from.z + 0.05), 0.6, 0x34c759, 0.18, 0.12));
    }
    this.touch();
  }
}
