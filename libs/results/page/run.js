/** The page of a run: reads the data, and puts plots and maps where the still pictures are. */
function sceneOf(data) {
  const paths = [], f = data.frames;
  if (data.truth.t.length) {
    paths.push({name: 'truth', color: 'truth', width: 3, p: [data.truth.x, data.truth.y, data.truth.z]});
  }
  paths.push({name: 'estimate at its time', color: 'c0', p: [f.x, f.y, f.z]});
  if (data.smoothed.t.length) {
    paths.push({name: 'keyframes as last seen', color: 'c2', width: 1, p: [data.smoothed.x, data.smoothed.y, data.smoothed.z]});
  }
  for (const [name, ink, l] of [['refused', 'faint', data.loops_refused], ['places seen twice', 'c4', data.loops]]) {
    if (l.x.length) paths.push({name, color: ink, width: 1, p: [l.x, l.y, l.z]});
  }
  return {
    paths, points: data.landmarks, anchors: data.anchors.filter((a) => a.p).map(anchorOf),
    robots: [{t: f.t, p: [f.x, f.y, f.z], yaw: f.heading.map((v) => v * Math.PI / 180), sigma: [f.sx, f.sy, f.sz]}],
  };
}

function errorCharts(data) {
  const f = data.frames, note = data.error_frame, out = [];
  if (!f.ex) return out;
  for (const [key, sigma, name] of [['ex', 'sx', 'x'], ['ey', 'sy', 'y'], ['ez', 'sz', 'z']]) {
    out.push({title: 'Position error in ' + name, unit: 'm', note, zero: true,
              lines: [{name: 'error', color: 'c1', t: f.t, y: f[key]}], bands: [threeSigma(f, sigma)]});
  }
  if (!f.erx) return out;
  for (const [key, sigma, name] of [['erx', 'srx', 'x'], ['ery', 'sry', 'y'], ['erz', 'srz', 'z']]) {
    out.push({title: 'Attitude error about the body\'s ' + name, unit: 'deg', note, zero: true,
              lines: [{name: 'error', color: 'c1', t: f.t, y: f[key]}], bands: [threeSigma(f, sigma)]});
  }
  return out;
}

function rangeCharts(data) {
  const r = data.ranges, out = [], inks = ['c1', 'c3', 'c4', 'c5', 'faint'];
  for (const id of [...new Set(r.id)].sort((a, b) => a - b)) {
    const dots = [], mine = r.t.map((t, i) => i).filter((i) => r.id[i] === id && r.residual[i] !== null);
    if (!mine.length) continue;
    data.decisions.forEach((name, d) => {
      const i = mine.filter((k) => r.decision[k] === d);
      const ink = name === 'accepted' ? 'c0' : inks[d % inks.length];
      if (i.length) dots.push({name: name + ' (' + i.length + ')', color: ink, t: i.map((k) => r.t[k]), y: i.map((k) => r.residual[k])});
    });
    const t = mine.map((k) => r.t[k]), band = mine.map((k) => (r.sigma[k] > 0 ? 3 * r.sigma[k] : null));
    out.push({title: 'Ranges to anchor ' + id + ': measured less predicted', unit: 'm', zero: true, dots,
              note: 'band: 3 sigma of prediction and range together',
              bands: [{t, low: band.map((v) => v && -v), high: band}]});
  }
  return out;
}

function calibrationCharts(data) {
  const k = data.calibration, out = [];
  if (!k.t.length) return out;
  const inks = ['c0', 'c1', 'c2'];
  for (const group of data.calibration_groups) {
    out.push({title: 'Calibration: ' + group.name + ', less what was given', unit: group.unit, zero: true,
              lines: group.keys.map((key, i) => ({name: key, color: inks[i], t: k.t, y: k[key]})),
              bands: group.keys.map((key, i) => ({
                t: k.t, color: inks[i], low: k[key].map((v, n) => (v === null ? null : v - 3 * k.sigma[group.sigma][n])),
                high: k[key].map((v, n) => (v === null ? null : v + 3 * k.sigma[group.sigma][n]))}))});
  }
  return out;
}

function stateCharts(data) {
  const f = data.frames, xyz = (a, names) => lines(f, a.map((key, i) => [key, names[i], 'c' + i]));
  return [
    {title: 'Position', unit: 'm', lines: xyz(['x', 'y', 'z'], ['x', 'y', 'z'])},
    {title: 'Attitude', unit: 'deg', lines: xyz(['yaw', 'pitch', 'roll'], ['yaw', 'pitch', 'roll'])},
    {title: 'Velocity', unit: 'm/s', lines: xyz(['vx', 'vy', 'vz'], ['x', 'y', 'z'])},
    {title: 'Bias of the gyro', unit: 'rad/s', lines: xyz(['bgx', 'bgy', 'bgz'], ['x', 'y', 'z'])},
    {title: 'Bias of the accelerometer', unit: 'm/s2', lines: xyz(['bax', 'bay', 'baz'], ['x', 'y', 'z'])},
    {title: 'Standard deviation of the position', unit: 'm', zero: true, lines: xyz(['sx', 'sy', 'sz'], ['x', 'y', 'z'])},
    {title: 'Tracks and landmarks', unit: '', zero: true,
     lines: lines(f, [['tracks', 'tracks', 'c0'], ['landmarks', 'landmarks with depth', 'c2']])},
    {title: 'How readings fit', unit: 'sigma', zero: true,
     lines: lines(f, [['reprojection', 'sights', 'c0'], ['inertial', 'IMU', 'c3']])},
    {title: 'CPU time per image', unit: 'ms', zero: true, lines: lines(f, [['ms', 'all stages', 'c4']])},
  ];
}

function photo(clock, images) {
  const canvas = element('canvas', {role: 'img', ariaLabel: 'image with tracks'}), times = images.map((i) => i.t);
  const note = element('div', {className: 'small'}), loaded = new Map();
  const draw = () => {
    const i = indexAt(times, clock.now), image = images[i];
    note.textContent = image.t.toFixed(1) + ' s: ' + image.tracks.length / 2 + ' tracks' + (image.why ? ', ' + image.why : '');
    let picture = loaded.get(i);
    if (!picture) {
      picture = new Image();
      picture.onload = draw;
      picture.src = image.src;
      loaded.set(i, picture);
    }
    const width = canvas.clientWidth || 300, {c, height} = sharp(canvas, Math.round(width * image.h / image.w));
    if (picture.complete && picture.naturalWidth) c.drawImage(picture, 0, 0, width, height);
    c.fillStyle = '#3fd16b';
    for (let k = 0; k + 1 < image.tracks.length; k += 2) {
      c.fillRect(image.tracks[k] / image.w * width - 1.5, image.tracks[k + 1] / image.h * height - 1.5, 3, 3);
    }
  };
  clock.listen(draw);
  const panel = element('div', {className: 'panel photo'}, element('h3', {textContent: 'Images'}), note, canvas);
  whenResized(panel, draw);
  return panel;
}

function show(data) {
  const times = data.frames.t, first = Math.max(0, data.frames.x.findIndex((v) => v !== null));
  const clock = new Clock(times[0] || 0, times[times.length - 1] || 1), place = document.getElementById('live');
  if (times.length) {
    place.append(maps(clock, sceneOf(data)));
  } else {
    place.append(element('div', {className: 'grid'}));
  }
  const top = place.firstChild;
  if (data.images.length) top.append(photo(clock, data.images));
  if (data.events.length) top.append(eventPanel(clock, data.events));
  place.append(...section(clock, 'Errors', errorCharts(data)), ...section(clock, 'Ranges', rangeCharts(data)),
               ...section(clock, 'State', stateCharts(data)),
               ...section(clock, 'Calibration as it was found', calibrationCharts(data)));
  finish(clock, data, times.length > 0, times[first]);
}

show(JSON.parse(document.getElementById('data').textContent));
