/**
 * Curves over time: {title, unit, note, lines: [{name, color, t, y}], bands: [{t, low, high, color}],
 * dots: [{name, color, t, y}], zero: true to keep 0 in sight}. All charts share the clock.
 */
class Chart {
  constructor(clock, content) {
    Object.assign(this, {clock, content});
    this.canvas = element('canvas', {role: 'img', ariaLabel: content.title});
    this.legend = element('div', {className: 'legend'});
    this.panel = element('div', {className: 'panel chart'},
                         element('h3', {textContent: content.title + (content.unit ? ' [' + content.unit + ']' : '')}));
    if (content.note) this.panel.append(element('div', {className: 'small', textContent: content.note}));
    this.panel.append(this.legend, this.canvas);
    follow(this.canvas, {
      move: (dx) => this.shift(dx), wheel: (factor, x) => this.wheel(factor, x),
      hover: (x) => clock.set(this.time(x)), reset: () => clock.zoom(...clock.whole),
    });
    clock.listen(() => this.draw());
    whenResized(this.panel, () => this.draw());
  }
  time(x) {
    const [a, b] = this.clock.span;
    return a + (x - this.left) / this.plotWidth * (b - a);
  }
  shift(dx) {
    const [a, b] = this.clock.span, dt = dx / this.plotWidth * (b - a);
    this.clock.zoom(a - dt, b - dt);
  }
  wheel(factor, x) {
    const t = this.time(x), [a, b] = this.clock.span;
    this.clock.zoom(t - (t - a) * factor, t + (b - t) * factor);
  }
  /** Lowest and highest of what is in sight; of dots and bands only what does not flatten the curves. */
  bounds() {
    const [a, b] = this.clock.span, values = [];
    const take = (t, y) => {
      for (let i = indexAt(t, a); i < t.length && t[i] <= b; ++i) if (y[i] !== null) values.push(y[i]);
    };
    for (const line of this.content.lines || []) take(line.t, line.y);
    const own = values.length;
    for (const dots of this.content.dots || []) take(dots.t, dots.y);
    if (own === 0 && values.length > 20) {
      values.sort((p, q) => p - q);
      values.splice(0, values.length, ...values.slice(values.length >> 6, values.length - (values.length >> 6)));
    }
    if (this.content.zero) values.push(0);
    let low = Infinity, high = -Infinity;
    for (const v of values) { low = Math.min(low, v); high = Math.max(high, v); }
    if (!(low <= high)) return [0, 1];
    const size = Math.max(high - low, 1e-9), bands = [];
    for (const band of this.content.bands || []) {
      for (let i = indexAt(band.t, a); i < band.t.length && band.t[i] <= b; ++i) bands.push(band.low[i], band.high[i]);
    }
    for (const v of bands) {
      if (v === null || v < low - 1.5 * size || v > high + 1.5 * size) continue;
      low = Math.min(low, v); high = Math.max(high, v);
    }
    const margin = 0.06 * (high - low) || 0.5 * Math.abs(high) || 1;
    return [low - margin, high + margin];
  }
  draw() {
    const {c, width, height} = sharp(this.canvas, 170);
    this.left = 52;
    this.plotWidth = width - this.left - 8;
    const top = 6, bottom = height - 20, [a, b] = this.clock.span, [low, high] = this.bounds();
    const X = (t) => this.left + (t - a) / (b - a) * this.plotWidth;
    const Y = (y) => bottom - (y - low) / (high - low) * (bottom - top);
    this.axes(c, X, Y, {a, b, low, high, top, bottom});
    c.save();
    c.beginPath();
    c.rect(this.left, top, this.plotWidth, bottom - top);
    c.clip();
    for (const band of this.content.bands || []) this.band(c, band, X, Y);
    for (const line of this.content.lines || []) this.line(c, line, X, Y);
    for (const dots of this.content.dots || []) this.dots(c, dots, X, Y);
    c.strokeStyle = color('ink');
    c.lineWidth = 1;
    c.beginPath();
    c.moveTo(X(this.clock.now), top);
    c.lineTo(X(this.clock.now), bottom);
    c.stroke();
    c.restore();
    this.tell();
  }
  axes(c, X, Y, box) {
    c.strokeStyle = color('line');
    c.fillStyle = color('faint');
    c.lineWidth = 1;
    const x = ticks(box.a, box.b, this.plotWidth / 80), y = ticks(box.low, box.high, 5);
    c.beginPath();
    for (const t of x.at) { c.moveTo(X(t), box.top); c.lineTo(X(t), box.bottom); }
    for (const v of y.at) { c.moveTo(this.left, Y(v)); c.lineTo(this.left + this.plotWidth, Y(v)); }
    c.stroke();
    c.textAlign = 'center';
    for (const t of x.at) c.fillText(t.toFixed(x.decimals) + ' s', X(t), box.bottom + 14);
    c.textAlign = 'right';
    for (const v of y.at) c.fillText(v.toFixed(y.decimals), this.left - 5, Y(v) + 4);
  }
  each(series, f) {
    const [a, b] = this.clock.span, n = series.t.length;
    for (let i = indexAt(series.t, a); i < n; ++i) {
      f(i);
      if (series.t[i] > b) break;
    }
  }
  line(c, line, X, Y) {
    c.strokeStyle = color(line.color);
    c.lineWidth = 1.4;
    c.beginPath();
    let down = false;
    this.each(line, (i) => {
      if (line.y[i] === null) { down = false; return; }
      if (down) c.lineTo(X(line.t[i]), Y(line.y[i])); else c.moveTo(X(line.t[i]), Y(line.y[i]));
      down = true;
    });
    c.stroke();
  }
  band(c, band, X, Y) {
    c.fillStyle = color(band.color || 'band');
    if (band.color) c.globalAlpha = 0.13;
    let piece = [];
    const close = () => {
      if (piece.length > 1) {
        c.beginPath();
        for (const i of piece) c.lineTo(X(band.t[i]), Y(band.high[i]));
        for (const i of piece.reverse()) c.lineTo(X(band.t[i]), Y(band.low[i]));
        c.fill();
      }
      piece = [];
    };
    this.each(band, (i) => { if (band.low[i] === null) close(); else piece.push(i); });
    close();
    c.globalAlpha = 1;
  }
  dots(c, dots, X, Y) {
    c.fillStyle = color(dots.color);
    this.each(dots, (i) => { if (dots.y[i] !== null) c.fillRect(X(dots.t[i]) - 1.5, Y(dots.y[i]) - 1.5, 3, 3); });
  }
  /** Values at the time of the clock. */
  tell() {
    this.legend.textContent = '';
    const series = [...(this.content.lines || []), ...(this.content.dots || [])];
    for (const s of series) {
      const mark = element('i');
      mark.style.background = color(s.color);
      const value = s.t.length ? shown(s.y[indexAt(s.t, this.clock.now)], this.content.unit) : '-';
      this.legend.append(element('span', {}, mark, s.name + ' ' + value));
    }
  }
}
