// Draws the plan of a report, and its charts with Chart.js. The data are described in evaluation_pictures.h and evaluation_report.h.
(function () {
  'use strict';
  const {plan, charts: data} = JSON.parse(document.getElementById('data').textContent);
  const charts = document.getElementById('charts'), FIRST = 3;  // shown at once, the rest unfolded
  const BLUE = '#1f77b4', GREEN = '#2ca02c', ORANGE = '#ff7f0e', RED = '#c82828', GREY = '#888888';
  const COLOURS = [BLUE, GREEN, ORANGE, '#9467bd', '#8c564b', '#e377c2', '#17becf'];

  /** An element of SVG, put into another one. */
  function shape(parent, name, attributes) {
    const made = document.createElementNS('http://www.w3.org/2000/svg', name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    return parent.appendChild(made);
  }

  /** The map from above, and where the images are, in the colours of their answers. Nearly all ends of segments are in the picture: segments
      far outside, as through windows, do not count. */
  function drawPlan({tall = [], low = [], models = [], answers = {}}) {
    const WIDTH = 720, HIGHEST = 520, MARGIN = 12, BAR = 24, RADIUS = 4, NEEDLE = 9;  // [px]
    const LEAST = 500, OUTSIDE = 0.02, MOST = 0.25;  // [mm], share of the ends, [px/mm]
    const COLOUR = {sure: '#009e73', doubtful: '#e69f00', unknown: '#8a8f99', 'sure and wrong': '#d62728'};
    const CAPTION = 'The map from above, and its answers.';
    const shown = Object.keys(COLOUR).filter((state) => answers[state]);
    const range = (axis) => {
      const every = (values, n) => values.filter((_, i) => i % n === axis);
      const ends = every([...tall, ...low], 2).sort((a, b) => a - b), cut = Math.floor(OUTSIDE * (ends.length - 1));
      const inside = [...ends.slice(cut, ends.length - cut), ...every(models, 2), ...shown.flatMap((state) => every(answers[state], 4))];
      const least = inside.reduce((a, b) => Math.min(a, b)), most = inside.reduce((a, b) => Math.max(a, b));
      return {middle: (least + most) / 2, size: most - least};
    };
    const x = range(0), y = range(1), scale = Math.min(WIDTH / Math.max(x.size, LEAST), HIGHEST / Math.max(y.size, LEAST), MOST);
    const height = Math.max(120, Math.ceil(scale * y.size));
    const right = (value) => MARGIN + WIDTH / 2 + scale * (value - x.middle), down = (value) => MARGIN + height / 2 - scale * (value - y.middle);
    const place = (values, i) => right(values[i]).toFixed(1) + ' ' + down(values[i + 1]).toFixed(1);
    const lines = (ends) => {
      const path = [];
      for (let i = 0; i < ends.length; i += 4) path.push('M' + place(ends, i) + 'L' + place(ends, i + 2));
      return path.join('');
    };

    const figure = document.createElement('figure'), legend = document.createElement('p');
    const svg = shape(figure, 'svg', {viewBox: `0 0 ${WIDTH + 2 * MARGIN} ${height + 2 * MARGIN + BAR}`, role: 'img', 'aria-label': CAPTION});
    shape(svg, 'path', {class: 'low', d: lines(low)});
    shape(svg, 'path', {class: 'wall', d: lines(tall)});
    for (const state of shown) {
      const poses = answers[state], colour = COLOUR[state];
      for (let i = 0; i < poses.length; i += 4) {
        const ahead = Math.hypot(poses[i + 2], poses[i + 3]), needle = (k) => (NEEDLE * poses[i + k] / ahead).toFixed(1);
        if (ahead > 100) shape(svg, 'path', {d: `M${place(poses, i)}l${needle(2)} ${-needle(3)}`, stroke: colour, 'stroke-width': 2});
        shape(svg, 'circle', {cx: right(poses[i]), cy: down(poses[i + 1]), r: RADIUS, fill: colour});
      }
      const entry = legend.appendChild(document.createElement('span'));
      entry.appendChild(document.createElement('i')).style.background = colour;
      entry.append(`${state} (${poses.length / 4})`);
      legend.append(' ');
    }
    const power = Math.pow(10, Math.floor(Math.log10(120 / scale))), length = [5, 2, 1].find((f) => f * power <= 120 / scale) * power;
    const end = MARGIN + WIDTH, level = MARGIN + height + 10;
    shape(svg, 'path', {class: 'bar', d: `M${end - scale * length} ${level}H${end}`});
    shape(svg, 'text', {x: end, y: level + 15, 'text-anchor': 'end'}).textContent = Number((length / 1000).toPrecision(1)) + ' m';
    legend.className = 'legend';
    if (shown.length > 0) figure.appendChild(legend);
    figure.appendChild(document.createElement('figcaption')).textContent = CAPTION;
    document.getElementById('plan').replaceChildren(figure);
  }

  function applyColours() {
    const style = getComputedStyle(document.documentElement);
    Chart.defaults.color = style.getPropertyValue('--soft');
    Chart.defaults.borderColor = style.getPropertyValue('--line');
  }

  /** Points of two columns. */
  const columns = (rows, x, y) => rows.map((row) => ({x: row[x], y: row[y]}));
  const most = (points) => points.reduce((found, p) => Math.max(found, p.y), 0);
  const last = (rows) => rows[rows.length - 1];

  /** A line through points; without a label it is not in the legend. */
  const curve = (label, colour, points, options) =>
      ({label, data: points, borderColor: colour, backgroundColor: colour, borderWidth: 2, pointRadius: 0, ...options});
  const MARKED = {pointRadius: 4};
  const guide = (label, colour, points) => curve(label, colour, points, {borderWidth: 1.5, borderDash: [6, 4]});
  const axis = (title, min, max, options, ticks) =>
      ({type: 'linear', title: {display: true, text: title}, min, max, ticks: {includeBounds: false, ...ticks}, ...options});

  /** Where the charts are that show at a click. */
  function more() {
    const found = document.getElementById('more');
    if (found) return found;
    const folded = document.createElement('details'), inside = document.createElement('div');
    folded.appendChild(document.createElement('summary')).textContent = 'More charts';
    inside.id = 'more';
    charts.after(folded);
    return folded.appendChild(inside);
  }

  function draw(title, scales, datasets, options) {
    const figure = document.createElement('figure'), frame = document.createElement('div'), canvas = document.createElement('canvas');
    figure.className = 'chart';
    figure.appendChild(document.createElement('figcaption')).textContent = title;
    figure.appendChild(frame).appendChild(canvas);
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', title);
    if (charts.children.length < FIRST) charts.appendChild(figure); else more().appendChild(figure);
    return new Chart(canvas, {
      type: 'line',
      data: {datasets},
      options: {
        animation: false,
        maintainAspectRatio: false,
        interaction: {mode: 'nearest', intersect: false},
        scales,
        plugins: {legend: {position: 'bottom', labels: {boxWidth: 14, boxHeight: 2, filter: (item) => item.text}}},
        ...options
      }
    });
  }

  function drawReliability(of) {
    const answered = of.bins.filter((bin) => bin[2] > 0), counts = columns(of.bins, 0, 2);
    counts.push({x: 1, y: last(counts).y});
    draw(
        'Reliability of the probability, ' + of.images, {
          x: axis('Probability of rank 1', 0, 1),
          y: axis('Share of images where it is correct', 0, 1.02),
          n: axis('Images', 0, 4 * Math.max(1, most(counts)), {position: 'right', grid: {drawOnChartArea: false}}, {precision: 0})
        },
        [
          curve('rank 1, Brier score ' + of.brier.toFixed(3), BLUE, columns(answered, 3, 4), {borderWidth: 1.5}),
          curve('of ' + of.enough + ' images or more', BLUE, columns(answered.filter((bin) => bin[2] >= of.enough), 3, 4), {...MARKED, showLine: false}),
          guide('ideal, and 0.1 from it', GREY, [{x: 0, y: 0}, {x: 1, y: 1}]),
          guide('', GREY, [{x: 0, y: 0.1}, {x: 0.9, y: 1}]),
          guide('', GREY, [{x: 0.1, y: 0}, {x: 1, y: 0.9}]),
          curve('images', '#88888866', counts, {yAxisID: 'n', stepped: 'before', fill: true, borderWidth: 1})
        ]);
  }

  /** Shares of images with at most an error, and 99 % marks. */
  function drawErrors(title, xTitle, unit, decimals, of) {
    const curves = of.sets.map((set, k) => {
      const n = set.errors.length, points = set.errors.map((error, i) => ({x: error, y: (i + 1) / n}));
      // The first one shows beside the others where they coincide.
      return curve(
          set.name + ' (' + n + ')', COLOURS[k % COLOURS.length], [{x: 0, y: 0}, ...points, {x: of.limit, y: 1}],
          {stepped: 'before', borderWidth: k > 0 ? 2 : 5, order: of.sets.length - k});
    });
    const marks = Object.entries(of.marks).map(
        ([label, bound], k) => guide(
            label + ': ' + bound.toFixed(decimals) + ' ' + unit, k > 0 ? GREY : RED,
            [{x: 0, y: 0.99}, {x: bound, y: 0.99}, {x: bound, y: 0}]));
    draw(title, {x: axis(xTitle, 0, of.limit), y: axis('Share of images', 0, 1.02)}, [...marks, ...curves]);
  }

  function drawShares(title, xTitle, rows) {
    const share = (column) => rows.map((row) => ({x: row[0], y: row[column] / row[1], n: row[1]}));
    draw(
        title, {x: axis(xTitle, 0, 1.05 * Math.max(1, last(rows)[0])), y: axis('Share of images', 0, 1.05)},
        [curve('correct anywhere', BLUE, share(2), MARKED), curve('correct at rank 1', ORANGE, share(3), MARKED)]);
  }

  function drawStarts(xTitle, rows) {
    const points = (share) => rows.map((row) => ({x: row[0], y: share(row)}));
    draw(
        'Recall and precision from any start', {x: axis(xTitle, 0, Math.max(1, last(rows)[0])), y: axis('Share', 0, 1.05)}, [
          curve('sure and right, of all starts', BLUE, points((row) => row[1] > 0 ? row[3] / row[1] : 0)),
          guide('right, of the sure ones', GREEN, points((row) => row[2] > 0 ? row[3] / row[2] : 1))
        ]);
  }

  /** Gives both axes of a plan the same scale. */
  function level(chart) {
    if (!chart.chartArea) return;
    const points = chart.data.datasets.flatMap((set) => set.data), sides = {x: 'width', y: 'height'}, centre = {}, size = {};
    for (const name of ['x', 'y']) {
      const low = points.reduce((found, p) => Math.min(found, p[name]), Infinity);
      const high = points.reduce((found, p) => Math.max(found, p[name]), -Infinity);
      centre[name] = (low + high) / 2;
      size[name] = Math.max(high - low, 0.1);
    }
    for (let i = 0; i < 2; ++i) {  // labels of ticks, and so the area, depend on the limits
      const area = chart.chartArea, metres = 1.1 * Math.max(size.x / area.width, size.y / area.height);  // in a pixel
      for (const name of ['x', 'y']) {
        const half = metres * area[sides[name]] / 2, scale = chart.options.scales[name];
        scale.min = centre[name] - half;
        scale.max = centre[name] + half;
      }
      chart.update('none');
    }
  }

  function drawTrajectory(of) {
    level(draw(
        'From above', {x: axis('[m]'), y: axis('[m]')},
        [curve('estimated', BLUE, columns(of.estimated, 0, 1)), curve('true', GREY, columns(of.true, 0, 1), {borderWidth: 4})],
        {onResize: (chart) => setTimeout(level, 0, chart)}));
  }

  function drawTrajectoryError(title, yTitle, column, colour) {
    draw(
        title, {x: axis('True distance travelled [m]', 0, Math.max(0.1, last(data.errors)[0])), y: axis(yTitle, 0)},
        [curve('', colour, columns(data.errors, 0, column))]);
  }

  if (plan) drawPlan(plan);
  if (!data) return;
  applyColours();
  charts.textContent = '';
  if (data.starts && data.starts.images) drawStarts('Images since the start', data.starts.images);
  if (data.position) drawErrors('Error in position', 'Translation error [mm]', 'mm', 0, data.position);
  if (data.distance) drawShares('Correct by the distance to the map', 'Distance to the nearest local model [m]', data.distance);
  if (data.reliability) drawReliability(data.reliability);
  if (data.orientation) drawErrors('Error in orientation', 'Orientation error [deg]', 'deg', 1, data.orientation);
  if (data.planes) drawShares('Correct by what is in view', 'True planes in view', data.planes);
  if (data.starts && data.starts.metres) drawStarts('Distance travelled since the start [m]', data.starts.metres);
  if (data.plan) drawTrajectory(data.plan);
  if (data.errors) {
    drawTrajectoryError('Error of the position after alignment', '[mm]', 1, BLUE);
    drawTrajectoryError('Error of the orientation after alignment', '[deg]', 2, ORANGE);
  }

  const all = Object.values(Chart.instances);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
    applyColours();
    for (const chart of all) chart.update('none');
  });
  for (const type of ['beforeprint', 'afterprint']) addEventListener(type, () => all.forEach((chart) => chart.resize()));
})();
