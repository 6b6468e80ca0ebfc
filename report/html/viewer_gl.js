// Draws one animated mesh with WebGL: shaded surface, edges, vertices.
class MeshPainter {
  constructor(canvas, data) {
    const gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
    if (!gl || !gl.getExtension("OES_element_index_uint")) throw new Error("WebGL is missing");
    this.gl = gl;
    this.canvas = canvas;
    this.data = data;
    this.surface = this.program(
      `attribute vec3 position, normal; attribute float level;
       uniform mat4 view; uniform mat3 turn; varying vec3 n; varying float value;
       void main() { gl_Position = view * vec4(position, 1.0); n = turn * normal; value = level; }`,
      `precision highp float; varying vec3 n; varying float value;
       uniform sampler2D colours; uniform float coloured;
       void main() {
         bool back = !gl_FrontFacing;
         vec3 base = back ? vec3(0.71, 0.54, 0.39) : vec3(0.80, 0.85, 0.90);
         if (coloured > 0.5) base = texture2D(colours, vec2((value + 0.5) / 256.0, 0.5)).rgb;
         vec3 unit = normalize(n) * (back ? -1.0 : 1.0);
         float light = max(0.0, dot(unit, normalize(vec3(-0.25, 0.35, 1.0))));
         gl_FragColor = vec4(base * (0.34 + 0.66 * light), 1.0);
       }`);
    this.flat = this.program(
      `attribute vec3 position; attribute float level; uniform mat4 view;
       uniform float size, lift; varying float value;
       void main() {
         gl_Position = view * vec4(position, 1.0); gl_Position.z -= lift;
         gl_PointSize = size * (level > 0.5 ? 1.9 : 1.0); value = level;
       }`,
      `precision mediump float; varying float value; uniform float round;
       void main() {
         if (round > 0.5 && length(gl_PointCoord - 0.5) > 0.5) discard;
         gl_FragColor = round < 0.5 ? vec4(0.13, 0.17, 0.22, 0.5)
                      : value > 0.5 ? vec4(0.88, 0.48, 0.0, 1.0) : vec4(0.17, 0.29, 0.40, 1.0);
       }`);
    this.positions = this.buffer(gl.ARRAY_BUFFER, data.positions.byteLength);
    this.normals = this.buffer(gl.ARRAY_BUFFER, data.normals.byteLength);
    this.levels = this.buffer(gl.ARRAY_BUFFER, data.vertices);
    this.marks = this.buffer(gl.ARRAY_BUFFER, data.vertices);
    this.triangles = this.buffer(gl.ELEMENT_ARRAY_BUFFER, data.triangles);
    this.edges = this.buffer(gl.ELEMENT_ARRAY_BUFFER, data.edges);
    this.colours = gl.createTexture();
    this.levelValues = new Uint8Array(data.vertices);
    this.markValues = new Uint8Array(data.vertices);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ZERO, gl.ONE);
    gl.clearColor(0.957, 0.965, 0.973, 1);
  }
  program(vertexText, fragmentText) {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertexText], [gl.FRAGMENT_SHADER, fragmentText]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    // One numbering for all programs, so that switching them needs no new set-up.
    ["position", "normal", "level"].forEach((name, i) => gl.bindAttribLocation(program, i, name));
    gl.linkProgram(program);
    const at = {};
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS);
    for (let i = 0; i < count; ++i) {
      const name = gl.getActiveUniform(program, i).name;
      at[name] = gl.getUniformLocation(program, name);
    }
    return { program, at };
  }
  buffer(kind, content) {
    const gl = this.gl, buffer = gl.createBuffer();
    gl.bindBuffer(kind, buffer);
    gl.bufferData(kind, content, typeof content === "number" ? gl.DYNAMIC_DRAW : gl.STATIC_DRAW);
    return buffer;
  }
  upload(buffer, values) {
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, values);
  }
  attribute(index, buffer, size, type) {
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(index);
    gl.vertexAttribPointer(index, size, type, false, 0, 0);
  }
  setColours(table) {  // 256 × rgb, or null for the plain surface
    const gl = this.gl;
    this.coloured = table !== null;
    gl.bindTexture(gl.TEXTURE_2D, this.colours);
    const bytes = table || new Uint8Array(768);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, bytes);
    for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, gl.NEAREST], [gl.TEXTURE_MAG_FILTER, gl.NEAREST],
      [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) {
      gl.texParameteri(gl.TEXTURE_2D, name, value);
    }
  }
  // rows: right, up, towards the viewer; half: mm from the middle to the nearer border.
  draw(rows, centre, half, show) {
    const gl = this.gl, canvas = this.canvas;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    gl.viewport(0, 0, width, height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const least = Math.min(width, height);
    const scale = [least / width / half, least / height / half, -0.1 / this.data.radius];
    const view = new Float32Array(16);
    view[15] = 1;
    for (let r = 0; r < 3; ++r) {
      for (let c = 0; c < 3; ++c) {
        view[4 * c + r] = scale[r] * rows[r][c];
        view[12 + r] -= scale[r] * rows[r][c] * centre[c];
      }
    }
    const turn = new Float32Array(9);
    for (let r = 0; r < 3; ++r) for (let c = 0; c < 3; ++c) turn[3 * c + r] = rows[r][c];
    this.upload(this.positions, this.data.positions);
    this.upload(this.normals, this.data.normals);
    this.upload(this.levels, this.levelValues);
    this.upload(this.marks, this.markValues);

    gl.useProgram(this.surface.program);
    gl.uniformMatrix4fv(this.surface.at.view, false, view);
    gl.uniformMatrix3fv(this.surface.at.turn, false, turn);
    gl.uniform1f(this.surface.at.coloured, this.coloured ? 1 : 0);
    this.attribute(0, this.positions, 3, gl.FLOAT);
    this.attribute(1, this.normals, 3, gl.FLOAT);
    this.attribute(2, this.levels, 1, gl.UNSIGNED_BYTE);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.triangles);
    gl.drawElements(gl.TRIANGLES, this.data.triangles.length, gl.UNSIGNED_INT, 0);

    gl.useProgram(this.flat.program);
    gl.disableVertexAttribArray(1);
    gl.uniformMatrix4fv(this.flat.at.view, false, view);
    this.attribute(2, this.marks, 1, gl.UNSIGNED_BYTE);
    if (show.edges) {
      gl.enable(gl.BLEND);
      gl.uniform1f(this.flat.at.round, 0);
      gl.uniform1f(this.flat.at.lift, 0.0008);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.edges);
      gl.drawElements(gl.LINES, this.data.edges.length, gl.UNSIGNED_INT, 0);
      gl.disable(gl.BLEND);
    }
    if (show.points) {
      gl.uniform1f(this.flat.at.round, 1);
      gl.uniform1f(this.flat.at.lift, 0.002);
      gl.uniform1f(this.flat.at.size, 4.5 * ratio);
      gl.drawArrays(gl.POINTS, 0, this.data.vertices);
    }
  }
}
