/** The page of robots that met. */
function meetingCharts(pair) {
  const charts = [{title: pair.name + ': yaw', unit: 'deg', lines: lines(pair, [['yaw', 'yaw', 'c0']]),
                   bands: [around(pair, 'yaw', 'syaw')]}];
  [['x', 'sx', 'c0'], ['y', 'sy', 'c1'], ['z', 'sz', 'c2']].forEach(([key, sigma, ink]) => {
    charts.push({title: pair.name + ': ' + key + ' of the offset', unit: 'm', lines: lines(pair, [[key, key, ink]]),
                 bands: [around(pair, key, sigma)]});
  });
  return charts;
}

/** Three standard deviations about a curve. */
function around(pair, key, sigma) {
  const of = (sign) => pair[key].map((v, i) => (v === null || pair[sigma][i] === null ? null : v + sign * 3 * pair[sigma][i]));
  return {t: pair.t, low: of(-1), high: of(1)};
}

function showMeeting(data) {
  const times = data.robots.flatMap((r) => [r.path.t[0], r.path.t[r.path.t.length - 1]]).filter((t) => t !== undefined);
  const clock = new Clock(Math.min(0, ...times), Math.max(1, ...times)), place = document.getElementById('live');
  const p = (r) => [r.path.x, r.path.y, r.path.z];
  const scene = {
    paths: data.robots.map((r) => ({name: 'robot ' + r.name, color: r.color, p: p(r)})), points: data.landmarks,
    anchors: data.anchors.filter((a) => a.p).map(anchorOf), robots: data.robots.map((r) => ({t: r.path.t, p: p(r)})),
  };
  const top = maps(clock, scene);
  if (data.events.length) top.append(eventPanel(clock, data.events));
  place.append(top);
  for (const pair of data.pairs) place.append(...section(clock, 'Transform ' + pair.name + ', 3 sigma', meetingCharts(pair)));
  finish(clock, data, data.robots.length > 0);
}

showMeeting(JSON.parse(document.getElementById('data').textContent));
