'use strict';
/** The time that all parts of the page show, and the stretch that is zoomed in on [s]. */
class Clock {
  constructor(from, to) {
    this.whole = [from, to > from ? to : from + 1];
    this.span = this.whole.slice();
    this.now = from;
    this.listeners = [];
    this.waiting = false;
  }
  listen(f) { this.listeners.push(f); }
  set(t) {
    this.now = Math.min(Math.max(t, this.whole[0]), this.whole[1]);
    this.changed();
  }
  /** Shows the stretch from a to b, as far as there is one. */
  zoom(a, b) {
    const least = (this.whole[1] - this.whole[0]) / 2000;
    if (b - a < least) b = a + least;
    if (b - a > this.whole[1] - this.whole[0]) [a, b] = this.whole;
    const shift = Math.max(this.whole[0] - a, 0) + Math.min(this.whole[1] - b, 0);
    this.span = [a + shift, b + shift];
    this.changed();
  }
  /** Once per picture that the screen shows, however many changes there were. */
  changed() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      for (const f of this.listeners) f();
    });
  }
}

/** Index of the last of the ascending `times` that is not after t; 0 if all are. */
function indexAt(times, t) {
  let low = 0, high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle + 1; else high = middle;
  }
  return Math.max(0, low - 1);
}

/** A colour of the style sheet. */
function color(name) { return getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim(); }

/** Not at once: drawing may change the size again. */
function whenResized(panel, draw) { new ResizeObserver(() => requestAnimationFrame(draw)).observe(panel); }

function element(kind, attributes, ...children) {
  const e = document.createElement(kind);
  for (const [key, value] of Object.entries(attributes || {})) {
    if (key in e) e[key] = value; else e.setAttribute(key, value);
  }
  e.append(...children);
  return e;
}

/** About n round numbers between a and b. */
function ticks(a, b, n) {
  const raw = (b - a) / Math.max(1, n), power = Math.pow(10, Math.floor(Math.log10(raw)));
  const step = power * ([1, 2, 5].find((m) => m * power >= raw) || 10);
  const out = [];
  for (let i = Math.ceil(a / step); i * step <= b + 1e-9 * step; ++i) out.push(i * step);
  return {at: out, decimals: Math.max(0, -Math.floor(Math.log10(step) + 1e-9))};
}

/** A canvas as sharp as the screen; returns its context, to be drawn on in CSS pixels. */
function sharp(canvas, height) {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth || 300;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    canvas.style.height = height + 'px';
  }
  const c = canvas.getContext('2d');
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  c.clearRect(0, 0, width, height);
  c.font = '11px Helvetica, Arial, sans-serif';
  return {c, width, height};
}

function shown(v, unit) {
  if (v === null || v === undefined || !isFinite(v)) return '-';
  const size = Math.abs(v), digits = size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : size >= 0.01 ? 3 : 4;
  return (size > 0 && size < 1e-3 ? v.toExponential(1) : v.toFixed(digits)) + (unit ? ' ' + unit : '');
}

/** Drags and wheels of one canvas: f.move(dx, dy), f.wheel(factor, x, y), f.hover(x, y), f.reset(). */
function follow(canvas, f) {
  const pointers = new Map();
  const at = (e) => {
    const box = canvas.getBoundingClientRect();
    return [e.clientX - box.left, e.clientY - box.top];
  };
  canvas.addEventListener('pointerdown', (e) => {
    pointers.set(e.pointerId, at(e));
    canvas.setPointerCapture(e.pointerId);
  });
  canvas.addEventListener('pointermove', (e) => {
    const now = at(e), before = pointers.get(e.pointerId);
    if (before && pointers.size === 2) {
      const other = [...pointers].find(([id]) => id !== e.pointerId)[1];
      const length = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
      f.wheel(length(before) / length(now), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
    } else if (before && e.pointerType !== 'touch') {
      f.move(now[0] - before[0], now[1] - before[1], e);
    } else if (before && f.drag) {
      f.drag(now[0] - before[0], now[1] - before[1]);
    }
    if (before) pointers.set(e.pointerId, now);
    if (f.hover && (!before || e.pointerType === 'touch')) f.hover(...now);
  });
  const end = (e) => pointers.delete(e.pointerId);
  canvas.addEventListener('pointerup', end);
  canvas.addEventListener('pointercancel', end);
  canvas.addEventListener('wheel', (e) => {
    e.preventDefault();
    f.wheel(Math.exp(0.0015 * e.deltaY), ...at(e));
  }, {passive: false});
  canvas.addEventListener('dblclick', () => f.reset());
}
