// The animation: a mean shape and modes, and how much of each mode every key frame holds
// (written by report/html/animation_code.cpp).
class AnimationData {
  constructor(about, text) {
    Object.assign(this, about);
    const raw = atob(text);
    const bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; ++i) bytes[i] = raw.charCodeAt(i);
    let at = 0;
    const take = (Type, count) => {
      const part = new Type(bytes.buffer, at, count);
      at += count * Type.BYTES_PER_ELEMENT;
      return part;
    };
    const n = 3 * this.vertices;
    this.mean = take(Float32Array, n);
    this.modes = take(Int16Array, n * this.modeCount);
    this.scores = take(Int16Array, this.keys * this.modeCount);
    this.triangles = Uint32Array.from(this.longIndices ? this.longList(take, 3 * this.faces)
                                                       : take(Uint16Array, 3 * this.faces));
    for (const field of this.fields) field.levels = take(Uint8Array, field.keys * this.vertices);
    this.positions = new Float32Array(n);
    this.normals = new Float32Array(n);
    this.edges = this.findEdges();
  }
  longList(take, count) {  // 16-bit halves, low ones first: 32-bit words may lie unaligned here
    const halves = take(Uint16Array, 2 * count);
    return Array.from({ length: count }, (_, i) => halves[2 * i] + 65536 * halves[2 * i + 1]);
  }
  // Key frame before `frame`, the one after it, and how far it is from the first to the second.
  between(frame, step, keys) {
    const at = Math.min(Math.max(frame / step, 0), keys - 1);
    const before = Math.min(Math.floor(at), Math.max(keys - 2, 0));
    return [before, Math.min(before + 1, keys - 1), at - before];
  }
  moveTo(frame) {
    const [before, after, t] = this.between(frame, this.keyStep, this.keys);
    const { positions, modes, modeCount } = this;
    const n = positions.length;
    positions.set(this.mean);
    for (let k = 0; k < modeCount; ++k) {
      const a = this.scores[before * modeCount + k], b = this.scores[after * modeCount + k];
      const weight = (a + t * (b - a)) * this.scales[k];
      if (weight === 0) continue;
      for (let i = 0, m = k * n; i < n; ++i) positions[i] += weight * modes[m + i];
    }
    this.findNormals();
  }
  findNormals() {
    const p = this.positions, normals = this.normals, t = this.triangles;
    normals.fill(0);
    for (let i = 0; i < t.length; i += 3) {
      const a = 3 * t[i], b = 3 * t[i + 1], c = 3 * t[i + 2];
      const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
      const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
      const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
      for (const v of [a, b, c]) {
        normals[v] += x;
        normals[v + 1] += y;
        normals[v + 2] += z;
      }
    }
  }
  findEdges() {
    const seen = new Set(), edges = [], t = this.triangles;
    for (let i = 0; i < t.length; ++i) {
      const a = t[i], b = t[i % 3 === 2 ? i - 2 : i + 1];
      const key = Math.min(a, b) * this.vertices + Math.max(a, b);
      if (seen.has(key)) continue;
      seen.add(key);
      edges.push(a, b);
    }
    return new Uint32Array(edges);
  }
  // Levels 0…254 of a field at a frame, 255 where there is no value.
  fieldAt(field, frame, into) {
    const [before, after, t] = this.between(frame, field.keyStep, field.keys);
    const key = (t < 0.5 ? before : after) * this.vertices;
    into.set(field.levels.subarray(key, key + this.vertices));
  }
  // 1 where the sample of that frame was estimated.
  filledAt(frame, into) {
    into.fill(0);
    for (let i = 0; i < this.filled.length; i += 3) {
      if (frame >= this.filled[i + 1] && frame < this.filled[i + 2]) into[this.filled[i]] = 1;
    }
  }
}
