/** What maps draw: {paths: [{name, color, p: [x[], y[], z[]], width}], points: [x[], y[], z[]],
 *  anchors: [{id, p, axes, mirror, truth}], robots: [{t, p, yaw, sigma}]}; all in metres, z up. */

/** Smallest box around all paths and anchors: [middle, half the longest edge]. */
function sceneBox(scene) {
  const low = [Infinity, Infinity, Infinity], high = low.map((v) => -v);
  const take = (p) => {
    for (let k = 0; k < 3; ++k) {
      if (p[k] === null || !isFinite(p[k])) return;
      low[k] = Math.min(low[k], p[k]); high[k] = Math.max(high[k], p[k]);
    }
  };
  for (const path of scene.paths) {
    for (let i = 0; i < path.p[0].length; ++i) take([path.p[0][i], path.p[1][i], path.p[2][i]]);
  }
  const size = Math.max(...high.map((v, k) => v - low[k]), 1), middle = high.map((v, k) => (v + low[k]) / 2);
  for (const a of scene.anchors) {
    const far = Math.hypot(...a.p.map((v, k) => v - middle[k])) > 10 * size;
    if (!far) take(a.p);
  }
  if (!(low[0] <= high[0])) return [[0, 0, 0], 1];
  return [high.map((v, k) => (v + low[k]) / 2), Math.max(...high.map((v, k) => v - low[k]), 0.5) / 2];
}

/** From above or from a side, to scale. */
class PathMap {
  constructor(clock, scene, title, axes) {
    Object.assign(this, {clock, scene, axes});
    this.canvas = element('canvas', {role: 'img', ariaLabel: title});
    const views = {'from above': [0, 1], 'from the front (x, z)': [0, 2], 'from the left (y, z)': [1, 2]};
    const choice = element('select', {ariaLabel: 'view'});
    for (const name of Object.keys(views)) choice.append(element('option', {textContent: name}));
    choice.selectedIndex = axes[1] === 1 ? 0 : axes[0] === 0 ? 1 : 2;
    choice.onchange = () => { this.axes = views[choice.value]; this.reset(); };
    this.legend = element('div', {className: 'legend'});
    this.panel = element('div', {className: 'panel map'}, element('div', {className: 'tools'}, choice),
                         element('h3', {textContent: title}), this.legend, this.canvas);
    follow(this.canvas, {
      move: (dx, dy) => this.pan(dx, dy), drag: (dx) => this.pan(dx, 0), reset: () => this.reset(),
      wheel: (factor, x, y) => {
        const before = [this.U(x), this.V(y)];
        this.half *= factor;
        this.middle[0] += before[0] - this.U(x);
        this.middle[1] += before[1] - this.V(y);
        this.draw();
      },
    });
    this.tellNames();
    this.reset();
    clock.listen(() => this.draw());
    whenResized(this.panel, () => this.draw());
  }
  tellNames() {
    for (const path of this.scene.paths) {
      const mark = element('i');
      mark.style.background = 'var(--' + path.color + ')';
      this.legend.append(element('span', {}, mark, path.name));
    }
    if (this.scene.anchors.length) {
      const mark = element('i');
      mark.style.background = 'var(--c1)';
      this.legend.append(element('span', {}, mark, 'anchors, 3 sigma (ring: mirror position, cross: truth)'));
    }
  }
  reset() {
    const [middle, half] = sceneBox(this.scene);
    this.middle = [middle[this.axes[0]], middle[this.axes[1]]];
    this.half = 1.1 * half;
    this.draw();
  }
  pan(dx, dy) {
    this.middle[0] -= dx / this.scale;
    this.middle[1] += dy / this.scale;
    this.draw();
  }
  X(u) { return this.width / 2 + (u - this.middle[0]) * this.scale; }
  Y(v) { return this.height / 2 - (v - this.middle[1]) * this.scale; }
  U(x) { this.measure(); return this.middle[0] + (x - this.width / 2) / this.scale; }
  V(y) { this.measure(); return this.middle[1] - (y - this.height / 2) / this.scale; }
  measure() { this.scale = Math.min(this.width, this.height) / 2 / this.half; }
  draw() {
    const drawn = sharp(this.canvas, 360), c = drawn.c, [a, b] = this.axes;
    Object.assign(this, {width: drawn.width, height: drawn.height});
    this.measure();
    this.grid(c);
    c.fillStyle = color('faint');
    c.globalAlpha = 0.5;
    const points = this.scene.points;
    for (let i = 0; i < points[0].length; ++i) c.fillRect(this.X(points[a][i]), this.Y(points[b][i]), 1.5, 1.5);
    c.globalAlpha = 1;
    for (const path of this.scene.paths) this.path(c, path);
    for (const anchor of this.scene.anchors) this.anchor(c, anchor);
    for (const robot of this.scene.robots) this.robot(c, robot);
  }
  grid(c) {
    c.strokeStyle = color('line');
    c.fillStyle = color('faint');
    const names = 'xyz', across = ticks(this.U(0), this.U(this.width), this.width / 90);
    const up = ticks(this.V(this.height), this.V(0), this.height / 70);
    c.beginPath();
    for (const u of across.at) { c.moveTo(this.X(u), 0); c.lineTo(this.X(u), this.height); }
    for (const v of up.at) { c.moveTo(0, this.Y(v)); c.lineTo(this.width, this.Y(v)); }
    c.stroke();
    for (const u of across.at) c.fillText(names[this.axes[0]] + ' ' + u.toFixed(across.decimals) + ' m', this.X(u) + 2, this.height - 4);
    for (const v of up.at) c.fillText(names[this.axes[1]] + ' ' + v.toFixed(up.decimals) + ' m', 3, this.Y(v) - 3);
  }
  path(c, path) {
    const u = path.p[this.axes[0]], v = path.p[this.axes[1]];
    c.strokeStyle = color(path.color);
    c.lineWidth = path.width || 1.5;
    c.beginPath();
    let down = false;
    for (let i = 0; i < u.length; ++i) {
      if (u[i] === null) { down = false; continue; }
      if (down) c.lineTo(this.X(u[i]), this.Y(v[i])); else c.moveTo(this.X(u[i]), this.Y(v[i]));
      down = true;
    }
    c.stroke();
  }
  anchor(c, anchor) {
    const [a, b] = this.axes, at = (p) => [this.X(p[a]), this.Y(p[b])], [x, y] = at(anchor.p);
    c.strokeStyle = c.fillStyle = color('c1');
    c.lineWidth = 1;
    c.beginPath();
    for (const p of ellipse(anchor, a, b)) c.lineTo(...at(p));
    c.closePath();
    c.stroke();
    c.beginPath();
    c.arc(x, y, 4, 0, 7);
    c.fill();
    c.fillText(anchor.id, x + 6, y - 6);
    if (anchor.mirror) {
      c.beginPath();
      c.arc(...at(anchor.mirror), 5, 0, 7);
      c.stroke();
    }
    if (!anchor.truth) return;
    const [tx, ty] = at(anchor.truth);
    c.strokeStyle = color('ink');
    c.beginPath();
    for (const s of [-1, 1]) { c.moveTo(tx - 5, ty - 5 * s); c.lineTo(tx + 5, ty + 5 * s); }
    c.stroke();
  }
  robot(c, robot) {
    const i = indexAt(robot.t, this.clock.now), [a, b] = this.axes;
    if (!robot.t.length || robot.p[0][i] === null) return;
    const x = this.X(robot.p[a][i]), y = this.Y(robot.p[b][i]);
    if (robot.sigma && robot.sigma[0][i] !== null) {
      c.fillStyle = color('band');
      c.beginPath();
      c.ellipse(x, y, 3 * robot.sigma[a][i] * this.scale, 3 * robot.sigma[b][i] * this.scale, 0, 0, 7);
      c.fill();
    }
    c.strokeStyle = c.fillStyle = color('ink');
    c.lineWidth = 2;
    c.beginPath();
    c.arc(x, y, 5, 0, 7);
    c.fill();
    if (b !== 1 || !robot.yaw) return;
    c.beginPath();
    c.moveTo(x, y);
    c.lineTo(x + 20 * Math.cos(robot.yaw[i]), y - 20 * Math.sin(robot.yaw[i]));
    c.stroke();
  }
}

/** Outline, three standard deviations, of the ellipsoid's shadow on the plane of axes a and b. */
function ellipse(anchor, a, b) {
  const out = [], A = anchor.axes[a], B = anchor.axes[b];
  // The shadow's covariance is S S^T of the two rows of the root; its own root is a triangle.
  const aa = dot(A, A), ab = dot(A, B), bb = dot(B, B), l = Math.sqrt(Math.max(aa, 1e-12)), k = ab / l;
  const m = Math.sqrt(Math.max(bb - k * k, 0));
  for (let i = 0; i < 48; ++i) {
    const angle = i * Math.PI / 24, p = anchor.p.slice();
    p[a] += 3 * l * Math.cos(angle);
    p[b] += 3 * (k * Math.cos(angle) + m * Math.sin(angle));
    out.push(p);
  }
  return out;
}
function dot(a, b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
