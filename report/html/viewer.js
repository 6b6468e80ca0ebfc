// The 3D views: turning, zooming, playing, by mouse, touch and keyboard. Views of one group turn
// and play together.
class Viewer {
  constructor(root, groups) {
    this.root = root;
    const part = (name) => root.querySelector(`[data-part="${name}"]`);
    this.part = part;
    this.data = new AnimationData(JSON.parse(part("about").textContent), part("data").textContent);
    this.canvas = part("canvas");
    this.painter = new MeshPainter(this.canvas, this.data);
    this.show = { edges: this.data.vertices <= 20000, points: this.data.vertices <= 1500 };
    const name = this.data.group || `alone ${groups.size}`;
    if (!groups.has(name)) {
      groups.set(name, { members: [], yaw: 0, pitch: 0, zoom: 1, step: 0, playing: false, speed: 1 });
    }
    this.group = groups.get(name);
    this.group.members.push(this);
    this.listenToControls();
    this.listenToPointers();
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    this.setField(this.data.fields.length - 1);
    this.goTo(0);
  }
  // Steps of the group are frames of its first member.
  get first() { return this.group.members[0]; }
  get lastStep() {
    const { timeline, frames } = this.first.data;
    return (timeline ? timeline.length : frames) - 1;
  }
  get frame() {
    const { timeline, frames, rate } = this.data, step = this.group.step;
    let frame = step;
    if (timeline) {
      const i = Math.min(Math.floor(step), timeline.length - 1);
      const next = timeline[Math.min(i + 1, timeline.length - 1)];
      frame = timeline[i] + (step - i) * (next - timeline[i]);
    } else if (this.first.data.rate > 0 && rate > 0) {
      frame = step * rate / this.first.data.rate;
    }
    return Math.min(Math.max(frame, 0), frames - 1);
  }
  goTo(step) {
    this.group.step = Math.min(Math.max(step, 0), this.lastStep);
    for (const member of this.group.members) member.update();
  }
  update() {
    const { data, painter } = this, frame = this.frame, whole = Math.round(frame);
    data.moveTo(frame);
    data.filledAt(whole, painter.markValues);
    if (this.field) data.fieldAt(this.field, frame, painter.levelValues);
    const slider = this.part("slider"), output = this.part("output");
    slider.max = this.lastStep;
    slider.value = this.group.step;
    let text = `frame ${data.firstFrame + whole}`;
    if (data.rate > 0) text += ` · ${(frame / data.rate).toFixed(2)} s`;
    output.textContent = text;
    slider.setAttribute("aria-valuetext", text);
    this.draw();
  }
  axes() {
    const { yaw, pitch } = this.group, { front, up } = this.data;
    const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    const side = cross(up, front);
    const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    const right = side.map((s, i) => cy * s - sy * front[i]);
    const towards = front.map((f, i) => cp * (cy * f + sy * side[i]) + sp * up[i]);
    return [right, cross(towards, right), towards];
  }
  draw() {
    this.painter.draw(this.axes(), this.data.centre, this.data.radius / this.group.zoom, this.show);
  }
  drawGroup() { for (const member of this.group.members) member.draw(); }
  turn(yaw, pitch) {
    this.group.yaw += yaw;
    this.group.pitch = Math.min(Math.max(this.group.pitch + pitch, -1.5), 1.5);
    this.drawGroup();
  }
  zoomBy(factor) {
    this.group.zoom = Math.min(Math.max(this.group.zoom * factor, 0.3), 30);
    this.drawGroup();
  }
  look(yaw, pitch) {
    Object.assign(this.group, { yaw, pitch, zoom: 1 });
    this.drawGroup();
  }
  play(on) {
    const group = this.group;
    group.playing = on;
    for (const member of group.members) {
      member.part("play").textContent = on ? "Pause" : "Play";
      member.part("play").setAttribute("aria-pressed", on);
    }
    if (!on) return;
    if (group.step >= this.lastStep) group.step = 0;
    let before = performance.now();
    const tick = (now) => {
      if (!group.playing) return;
      const step = group.step + (now - before) / 1000 * (this.first.data.rate || 25) * group.speed;
      before = now;
      this.goTo(step > this.lastStep ? 0 : step);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }
  setField(index) {
    this.field = this.data.fields[index] || null;
    const bar = this.part("scale");
    if (bar) bar.classList.toggle("plain", !this.field);
    if (!this.field) return this.painter.setColours(null);
    const raw = atob(this.field.table), table = new Uint8Array(768);
    for (let i = 0; i < 768; ++i) table[i] = raw.charCodeAt(i);
    this.painter.setColours(table);
    this.data.fieldAt(this.field, this.frame, this.painter.levelValues);
    const stops = [];
    for (let i = 0; i < 255; i += 15) stops.push(`rgb(${table[3 * i]},${table[3 * i + 1]},${table[3 * i + 2]})`);
    bar.querySelector(".bar").style.background = `linear-gradient(90deg, ${stops.join(",")})`;
    bar.querySelector(".low").textContent = this.field.lowText;
    bar.querySelector(".high").textContent = this.field.highText;
    bar.querySelector(".name").textContent = this.field.label;
  }
  // The other views of the group follow where they have the same field.
  chooseField(index) {
    const label = this.data.fields[index]?.label;
    for (const member of this.group.members) {
      const own = index < 0 ? -1 : member.data.fields.findIndex((field) => field.label === label);
      if (member !== this && index >= 0 && own < 0) continue;
      const select = member.part("field");
      if (select) select.value = own;
      member.setField(own);
      member.draw();
    }
  }
  listenToControls() {
    const on = (name, event, action) => {
      const target = this.part(name);
      if (target) target.addEventListener(event, () => action(target));
    };
    const toggle = (name) => {
      const button = this.part(name);
      button.setAttribute("aria-pressed", this.show[name]);
      on(name, "click", () => {
        this.show[name] = !this.show[name];
        button.setAttribute("aria-pressed", this.show[name]);
        this.draw();
      });
    };
    on("play", "click", () => this.play(!this.group.playing));
    on("slider", "input", (slider) => { this.play(false); this.goTo(Number(slider.value)); });
    on("speed", "change", (select) => { this.group.speed = Number(select.value); });
    on("front", "click", () => this.look(0, 0));
    on("side", "click", () => this.look(Math.PI / 2, 0));
    on("oblique", "click", () => this.look(0.6, 0.25));
    on("field", "change", (select) => this.chooseField(Number(select.value)));
    toggle("edges");
    toggle("points");
  }
  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const actions = {
      ArrowLeft: () => this.turn(0.1, 0), ArrowRight: () => this.turn(-0.1, 0),
      ArrowUp: () => this.turn(0, -0.1), ArrowDown: () => this.turn(0, 0.1),
      "+": () => this.zoomBy(1.15), "=": () => this.zoomBy(1.15), "-": () => this.zoomBy(1 / 1.15),
      " ": () => this.play(!this.group.playing), Home: () => this.look(0, 0),
      ",": () => this.goTo(Math.ceil(this.group.step) - 1), ".": () => this.goTo(Math.floor(this.group.step) + 1),
    };
    if (!actions[event.key]) return;
    event.preventDefault();
    actions[event.key]();
  }
  listenToPointers() {
    const canvas = this.canvas, held = new Map();
    const spread = () => {
      const [a, b] = [...held.values()];
      return Math.hypot(a.x - b.x, a.y - b.y);
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      held.set(event.pointerId, { x: event.clientX, y: event.clientY });
    });
    canvas.addEventListener("pointermove", (event) => {
      const last = held.get(event.pointerId);
      if (!last) return this.nameAt(event.offsetX, event.offsetY);
      const before = held.size === 2 ? spread() : 0;
      const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
      Object.assign(last, { x: event.clientX, y: event.clientY });
      if (held.size === 2) this.zoomBy(spread() / Math.max(before, 1));
      else this.turn(-0.008 * dx, 0.008 * dy);
    });
    const release = (event) => held.delete(event.pointerId);
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    // The wheel scrolls the page until the view has been chosen.
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas && !event.ctrlKey) return;
      event.preventDefault();
      this.zoomBy(Math.exp(-0.0015 * event.deltaY));
    }, { passive: false });
  }
  // Names the vertex nearest to the viewer within 10 pixels of the pointer.
  nameAt(x, y) {
    const { data, canvas } = this, rows = this.axes();
    if (!data.names) return;
    const { clientWidth: wide, clientHeight: high } = canvas;
    const scale = Math.min(wide, high) / 2 / (data.radius / this.group.zoom);
    let best = -1, nearest = -Infinity;
    for (let v = 0; v < data.vertices; ++v) {
      const d = [0, 1, 2].map((i) => data.positions[3 * v + i] - data.centre[i]);
      const [vx, vy, vz] = rows.map((row) => row[0] * d[0] + row[1] * d[1] + row[2] * d[2]);
      if (Math.hypot(wide / 2 + vx * scale - x, high / 2 - vy * scale - y) < 10 && vz > nearest) {
        best = v;
        nearest = vz;
      }
    }
    const marked = best >= 0 && this.painter.markValues[best] ? " (filled)" : "";
    this.part("hint").textContent = best < 0 ? this.data.hint : data.names[best] + marked;
  }
}
window.kinemeshViewers = [];
{
  const groups = new Map();
  for (const root of document.querySelectorAll(".viewer")) {
    try {
      window.kinemeshViewers.push(new Viewer(root, groups));
    } catch (error) {
      const text = document.createElement("p");
      text.className = "failed";
      text.textContent = `The 3D view needs WebGL, which this browser does not offer (${error.message}).`;
      root.replaceChildren(text);
    }
  }
}
