/** What pages of a run and of a meeting have in common. */
function anchorOf(a) {
  return {id: String(a.id), p: a.p, axes: a.root, mirror: a.mirror, truth: a.truth};
}

/** A line for each name; no chart at all where there is no number. */
function lines(frames, names) {
  return names.map(([key, name, ink]) => ({name, color: ink, t: frames.t, y: frames[key]}))
      .filter((l) => l.y && l.y.some((v) => v !== null && v !== 0));
}

function threeSigma(frames, key) {
  const of = (sign) => frames[key].map((s) => (s === null || s === 0 ? null : sign * 3 * s));
  return {t: frames.t, low: of(-1), high: of(1)};
}

/** Map and space side by side. */
function maps(clock, scene) {
  const grid = element('div', {className: 'grid'}, new PathMap(clock, scene, 'Map', [0, 1]).panel);
  try {
    grid.append(new Space(clock, scene).panel);
  } catch (e) {
    grid.append(new PathMap(clock, scene, 'Map from the side (this browser has no WebGL)', [0, 2]).panel);
  }
  return grid;
}

/** A title with those of the charts that have something to show; nothing if none has. */
function section(clock, title, charts) {
  const useful = charts.filter((c) => (c.lines && c.lines.length) || (c.dots && c.dots.length));
  if (!useful.length) return [];
  return [element('h2', {textContent: title}),
          element('div', {className: 'grid'}, ...useful.map((c) => new Chart(clock, c).panel))];
}

function timeBar(clock) {
  const slider = element('input', {type: 'range', id: 'time', min: 0, max: 2000, value: 0, ariaLabel: 'time'});
  const out = element('output', {id: 'now'});
  const play = element('button', {id: 'play', textContent: 'play'});
  const whole = element('button', {textContent: 'whole', title: 'show the whole time'});
  let last = null;
  const step = (stamp) => {
    if (last === null) return;
    clock.set(clock.now + (stamp - last) / 1000);
    last = clock.now >= clock.whole[1] ? null : stamp;
    play.textContent = last === null ? 'play' : 'pause';
    if (last !== null) requestAnimationFrame(step);
  };
  play.onclick = () => {
    if (last !== null) { last = null; play.textContent = 'play'; return; }
    if (clock.now >= clock.whole[1]) clock.set(clock.whole[0]);
    last = performance.now();
    play.textContent = 'pause';
    requestAnimationFrame(step);
  };
  whole.onclick = () => clock.zoom(...clock.whole);
  const [a, b] = clock.whole;
  slider.oninput = () => clock.set(a + slider.value / 2000 * (b - a));
  clock.listen(() => {
    slider.value = (clock.now - a) / (b - a) * 2000;
    out.textContent = clock.now.toFixed(1) + ' s';
  });
  return element('div', {className: 'bar'}, play, slider, out, whole);
}

/** What changed, with its time; a click goes there. */
function eventList(clock, events) {
  const list = element('ul', {className: 'events'});
  for (const [t, text, bad] of events) {
    const button = element('button', {onclick: () => clock.set(t)}, element('b', {textContent: t.toFixed(1) + ' s'}), text);
    if (bad) button.classList.add('bad');
    list.append(element('li', {}, button));
  }
  return list;
}

function eventPanel(clock, events) {
  return element('div', {className: 'panel'}, element('h3', {textContent: 'What happened when'}), eventList(clock, events));
}

/** The script is in charge: still pictures away, clock to its first time. */
function finish(clock, data, timed, first) {
  if (timed) document.body.append(timeBar(clock));
  document.getElementById('still').hidden = true;
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => clock.changed());
  window.page = {data, clock};
  clock.set(first || clock.now);
}
