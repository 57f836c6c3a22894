/** The same scene in space, by WebGL. Throws where there is none. */
class Space {
  constructor(clock, scene) {
    Object.assign(this, {clock, scene, yaw: -0.7, pitch: 0.6});
    this.canvas = element('canvas', {role: 'img', ariaLabel: 'the path in space'});
    this.names = element('canvas');
    this.gl = this.canvas.getContext('webgl', {antialias: true, preserveDrawingBuffer: true});
    if (!this.gl) throw new Error('no WebGL');
    this.panel = element('div', {className: 'panel space'},
                         element('h3', {textContent: 'In space: drag turns, wheel zooms, shift drags along'}),
                         element('div', {className: 'stage'}, this.canvas, this.names));
    this.program = this.compile();
    [this.middle, this.size] = sceneBox(scene);
    this.parts = this.build();
    this.reset();
    follow(this.canvas, {
      move: (dx, dy, e) => (e.shiftKey ? this.pan(dx, dy) : this.turn(dx, dy)),
      drag: (dx) => this.turn(dx, 0),
      wheel: (factor) => { this.distance *= factor; this.draw(); },
      reset: () => { this.reset(); this.draw(); },
    });
    clock.listen(() => this.draw());
    whenResized(this.panel, () => this.draw());
  }
  reset() {
    this.target = this.middle.slice();
    this.distance = 3.2 * this.size;
  }
  turn(dx, dy) {
    this.yaw -= 0.008 * dx;
    this.pitch = Math.min(1.55, Math.max(-1.55, this.pitch + 0.008 * dy));
    this.draw();
  }
  pan(dx, dy) {
    const scale = this.distance / 400, right = [-Math.sin(this.yaw), Math.cos(this.yaw), 0];
    for (let k = 0; k < 3; ++k) this.target[k] -= right[k] * dx * scale;
    this.target[2] += dy * scale;
    this.draw();
  }
  compile() {
    const gl = this.gl, program = gl.createProgram();
    const add = (kind, text) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    };
    add(gl.VERTEX_SHADER, 'attribute vec3 p; uniform mat4 M; uniform float size;' +
        'void main() { gl_Position = M * vec4(p, 1.0); gl_PointSize = size; }');
    add(gl.FRAGMENT_SHADER, 'precision mediump float; uniform vec4 ink; void main() { gl_FragColor = ink; }');
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    return program;
  }
  /** {mode, color, alpha, size, count, buffer} for each part, uploaded once. */
  part(mode, ink, numbers, alpha, size) {
    const gl = this.gl, buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.DYNAMIC_DRAW);
    return {mode, ink, alpha: alpha || 1, size: size || 3, count: numbers.length / 3, buffer};
  }
  build() {
    const gl = this.gl, parts = [this.part(gl.LINES, 'line', this.floor())];
    const points = [];
    const all = this.scene.points;
    for (let i = 0; i < all[0].length; ++i) points.push(all[0][i], all[1][i], all[2][i]);
    if (points.length) parts.push(this.part(gl.POINTS, 'faint', points, 0.6, 2));
    for (const path of this.scene.paths) {
      let piece = [];
      const close = () => {
        if (piece.length > 3) parts.push(this.part(gl.LINE_STRIP, path.color, piece));
        piece = [];
      };
      for (let i = 0; i < path.p[0].length; ++i) {
        if (path.p[0][i] === null) close(); else piece.push(path.p[0][i], path.p[1][i], path.p[2][i]);
      }
      close();
    }
    for (const anchor of this.scene.anchors) {
      parts.push(this.part(gl.POINTS, 'c1', anchor.p, 1, 8));
      parts.push(this.part(gl.LINES, 'c1', this.ellipsoid(anchor), 0.6));
      if (anchor.mirror) parts.push(this.part(gl.POINTS, 'c3', anchor.mirror, 1, 7));
      if (anchor.truth) parts.push(this.part(gl.POINTS, 'ink', anchor.truth, 1, 5));
    }
    return parts;
  }
  /** A grid below everything. */
  floor() {
    const [m, s] = [this.middle, this.size], out = [], z = m[2] - s * 0.6;
    const step = ticks(-s, s, 8).at, pitch = step.length > 1 ? step[1] - step[0] : s;
    const from = (k) => Math.floor((m[k] - 1.3 * s) / pitch) * pitch, n = Math.ceil(2.6 * s / pitch) + 1;
    for (let i = 0; i <= n; ++i) {
      const x = from(0) + i * pitch, y = from(1) + i * pitch;
      out.push(x, from(1), z, x, from(1) + n * pitch, z, from(0), y, z, from(0) + n * pitch, y, z);
    }
    return out;
  }
  /** Three rings around the ellipsoid of three standard deviations. */
  ellipsoid(anchor) {
    const out = [], S = anchor.axes;
    const at = (u) => [0, 1, 2].map((k) => anchor.p[k] + 3 * dot(S[k], u));
    for (let plane = 0; plane < 3; ++plane) {
      for (let i = 0; i < 36; ++i) {
        for (const j of [i, i + 1]) {
          const u = [0, 0, 0], angle = j * Math.PI / 18;
          u[plane] = Math.cos(angle);
          u[(plane + 1) % 3] = Math.sin(angle);
          out.push(...at(u));
        }
      }
    }
    return out;
  }
  /** World to the picture, column by column. */
  matrix(aspect) {
    const cy = Math.cos(this.yaw), sy = Math.sin(this.yaw), cp = Math.cos(this.pitch), sp = Math.sin(this.pitch);
    const right = [-sy, cy, 0], up = [-cy * sp, -sy * sp, cp], back = [cy * cp, sy * cp, sp], f = 1.8;
    const near = this.distance / 100, far = this.distance * 20;
    const eye = back.map((v, k) => this.target[k] + v * this.distance);
    const A = (near + far) / (near - far), B = 2 * near * far / (near - far), M = new Float32Array(16);
    for (let k = 0; k < 3; ++k) {
      M[4 * k] = f / aspect * right[k];
      M[4 * k + 1] = f * up[k];
      M[4 * k + 2] = A * back[k];
      M[4 * k + 3] = -back[k];
    }
    M[12] = -f / aspect * dot(right, eye);
    M[13] = -f * dot(up, eye);
    M[14] = -A * dot(back, eye) + B;
    M[15] = dot(back, eye);
    return M;
  }
  /** Body axes of each robot at the clock's time, as lines. */
  robots() {
    const out = [];
    for (const r of this.scene.robots) {
      const i = indexAt(r.t, this.clock.now);
      if (r.t.length && r.p[0][i] !== null) out.push([0, 1, 2].map((k) => r.p[k][i]).concat(r.yaw ? r.yaw[i] : 0));
    }
    return out;
  }
  draw() {
    const over = sharp(this.names, 360), gl = this.gl, ratio = window.devicePixelRatio || 1;
    const width = this.canvas.clientWidth || over.width;
    this.canvas.style.height = '360px';
    if (this.canvas.width !== Math.round(width * ratio)) this.canvas.width = Math.round(width * ratio);
    if (this.canvas.height !== Math.round(360 * ratio)) this.canvas.height = Math.round(360 * ratio);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(this.program);
    const M = this.matrix(width / 360);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.program, 'M'), false, M);
    for (const part of this.parts) this.show(part, ratio);
    for (const [x, y, z, yaw] of this.robots()) {
      const l = 0.06 * this.distance, forward = this.part(gl.LINES, 'ink',
          [x, y, z, x + l * Math.cos(yaw), y + l * Math.sin(yaw), z, x, y, z, x, y, z + 0.6 * l]);
      const body = this.part(gl.POINTS, 'ink', [x, y, z], 1, 9);
      for (const part of [forward, body]) { this.show(part, ratio); gl.deleteBuffer(part.buffer); }
    }
    over.c.fillStyle = color('c1');
    for (const anchor of this.scene.anchors) {
      const w = (k) => M[k] * anchor.p[0] + M[4 + k] * anchor.p[1] + M[8 + k] * anchor.p[2] + M[12 + k];
      if (w(3) > 0) over.c.fillText(anchor.id, (w(0) / w(3) + 1) / 2 * width + 6, (1 - w(1) / w(3)) / 2 * 360 - 6);
    }
  }
  show(part, ratio) {
    const gl = this.gl, place = gl.getAttribLocation(this.program, 'p'), ink = rgb(color(part.ink));
    gl.bindBuffer(gl.ARRAY_BUFFER, part.buffer);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 0, 0);
    gl.uniform4f(gl.getUniformLocation(this.program, 'ink'), ...ink, part.alpha);
    gl.uniform1f(gl.getUniformLocation(this.program, 'size'), part.size * ratio);
    gl.drawArrays(part.mode, 0, part.count);
  }
}

/** #rrggbb as three numbers from 0 to 1. */
function rgb(text) {
  const n = parseInt(text.slice(1), 16);
  return [(n >> 16) / 255, ((n >> 8) & 255) / 255, (n & 255) / 255];
}
