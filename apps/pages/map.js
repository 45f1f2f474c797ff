// The scene of a map: its segments, local models, links and trajectories, and where images were localized in it. Everything is
// drawn in the coordinates of the map, below a group that turns its upward direction to z.
(function () {
  'use strict';
  const data = JSON.parse(document.getElementById('data').textContent);
  const byId = (id) => document.getElementById(id);
  const dark = window.matchMedia && window.matchMedia('(prefers-color-scheme: dark)').matches;
  const COLOURS = {sure: '#009e73', doubtful: '#e69f00', wrong: '#d62728', unknown: '#8a8f99', truth: '#1f77b4', model: '#4c6a92', link: '#b88a2c'};
  const SEGMENT_COLOURS = ['#0072b2', '#e69f00', '#009e73', '#cc79a7', '#56b4e9', '#d55e00', '#f0e442', '#6a5acd', '#999933', '#aa4488', '#44aa99', '#ddcc77'];
  const OWN_COLOURS = {sure: COLOURS.sure, right: COLOURS.doubtful, wrong: COLOURS.wrong, unknown: COLOURS.unknown};  // own images
  const OWN_WORDS = {sure: 'sure', right: 'right, not sure', wrong: 'wrong', unknown: 'unknown'};
  const ELLIPSOID = 2.7955;  // square root of the 95 % quantile of chi-square with 3 degrees of freedom

  // ---- what the data holds ----
  const bytesOf = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const sizes = bytesOf(data.sizes);
  const corners = new Uint16Array(bytesOf(data.corners).buffer);
  const models = data.models, answers = data.answers;
  const segments = [];  // {model, index, corners: [Vector3]}
  (function () {
    let next = 0, k = 0;
    models.forEach((model, m) => {
      model.segments = [];
      for (let s = 0; s < model.n; ++s, ++k) {
        const hull = [];
        for (let i = 0; i < sizes[k]; ++i, next += 3)
          hull.push(new THREE.Vector3(
              data.low[0] + corners[next] * data.quantum, data.low[1] + corners[next + 1] * data.quantum, data.low[2] + corners[next + 2] * data.quantum));
        model.segments.push({model: m, index: s, corners: hull});
        if (hull.length > 2) segments.push(model.segments[s]);
      }
    });
  })();
  const verdictOf = (answer) => answer.wrong ? 'wrong' : answer.state;

  // ---- the scene ----
  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({canvas: byId('scene'), antialias: true, preserveDrawingBuffer: true});
  } catch (error) {
    byId('fault').textContent = 'This browser shows no 3D graphics (WebGL).';
    byId('fault').hidden = false;
    return;
  }
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(dark ? '#14171c' : '#f3f4f6');
  const world = new THREE.Group();
  world.matrixAutoUpdate = false;
  const up = data.up;  // rows of the rotation to z upwards
  world.matrix.set(up[0], up[1], up[2], 0, up[3], up[4], up[5], 0, up[6], up[7], up[8], 0, 0, 0, 0, 1);
  scene.add(world);
  world.updateMatrixWorld(true);
  const camera = new THREE.PerspectiveCamera(45, 1, 0.05, 1000);
  camera.up.set(0, 0, 1);
  const controls = new THREE.OrbitControls(camera, renderer.domElement);

  function normalOf(hull) {  // of the side that the camera saw
    const normal = new THREE.Vector3();
    for (let i = 0; i < hull.length; ++i) {
      const a = hull[i], b = hull[(i + 1) % hull.length];
      normal.x += (a.y - b.y) * (a.z + b.z);
      normal.y += (a.z - b.z) * (a.x + b.x);
      normal.z += (a.x - b.x) * (a.y + b.y);
    }
    return normal.normalize().negate();
  }

  const poseOf = (pose) => new THREE.Matrix4().compose(
      new THREE.Vector3(pose[0], pose[1], pose[2]), new THREE.Quaternion(pose[3], pose[4], pose[5], pose[6]), new THREE.Vector3(1, 1, 1));
  const placeOf = (pose) => new THREE.Vector3(pose[0], pose[1], pose[2]);
  // Where nearly everything is: a few segments far outside, as through windows, do not count, and are drawn lightly.
  const box = new THREE.Box3();
  for (const axis of ['x', 'y', 'z']) {
    const values = segments.flatMap(({corners}) => corners.map((p) => p.clone().applyMatrix4(world.matrix)[axis])).sort((a, b) => a - b);
    if (!values.length) continue;
    box.min[axis] = values[Math.floor(0.02 * (values.length - 1))];
    box.max[axis] = values[Math.ceil(0.98 * (values.length - 1))];
  }
  for (const model of models) box.expandByPoint(placeOf(model.pose).applyMatrix4(world.matrix));
  for (const segment of segments) {
    segment.normal = normalOf(segment.corners);
    segment.colour = directionColour(segment.normal);
    segment.upright = Math.abs(segment.normal.clone().transformDirection(world.matrix).z) < Math.SQRT1_2;
    segment.outside = !box.intersectsBox(new THREE.Box3().setFromPoints(segment.corners.map((p) => p.clone().applyMatrix4(world.matrix))));
  }
  const extent = Math.max(box.getSize(new THREE.Vector3()).length(), 0.5);
  const glyph = Math.min(0.28, Math.max(0.012 * extent, 0.03));  // length of a camera [m]

  // Upright segments have the hue of their direction, from blue to orange, without the green of answers; the more level, the greyer.
  function directionColour(normal) {
    const n = normal.clone().transformDirection(world.matrix);
    const hue = (0.83 + 0.25 * Math.sin(Math.atan2(n.y, n.x) + Math.PI / 8)) % 1;
    const upright = Math.sqrt(Math.max(0, 1 - n.z * n.z));
    return new THREE.Color().setHSL(hue, 0.24 * upright, (dark ? 0.46 : 0.60) + (dark ? -0.16 : 0.26) * n.z * (1 - upright) + 0.05 * n.x * upright);
  }

  function meshOf(positions, colours, side) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.Float32BufferAttribute(positions, 3));
    geometry.setAttribute('color', new THREE.Float32BufferAttribute(colours, 3));
    return new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({vertexColors: THREE.VertexColors, side: side}));
  }
  function linesOf(points, colour, opacity) {
    const geometry = new THREE.BufferGeometry().setFromPoints(points);
    return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({color: colour, transparent: opacity < 1, opacity: opacity}));
  }

  /** sidesOf(segment): whether its front, which the camera saw, and its back are in the mesh. */
  function segmentMesh(sidesOf) {
    const positions = [], colours = [], owners = [];  // the segment of each triangle
    const add = (segment, ...triangle) => {
      for (const p of triangle) {
        positions.push(p.x, p.y, p.z);
        colours.push(segment.colour.r, segment.colour.g, segment.colour.b);
      }
      owners.push(segment);
    };
    for (const segment of segments) {
      const hull = segment.corners, [front, back] = sidesOf(segment);
      for (let i = 1; i + 1 < hull.length; ++i) {
        if (front) add(segment, hull[0], hull[i + 1], hull[i]);
        if (back) add(segment, hull[0], hull[i], hull[i + 1]);
      }
    }
    return Object.assign(meshOf(positions, colours, THREE.FrontSide), {owners});
  }
  /** Light over all that is behind it. Its depth comes first, and each pixel is drawn once, so that of several layers one shows. */
  function lightened(mesh) {
    const depth = new THREE.Mesh(mesh.geometry, new THREE.MeshBasicMaterial({colorWrite: false, transparent: true}));
    Object.assign(mesh.material, {
      transparent: true, opacity: 0.3, stencilWrite: true, stencilRef: 1, stencilFunc: THREE.NotEqualStencilFunc, stencilZPass: THREE.ReplaceStencilOp
    });
    depth.renderOrder = 1;
    mesh.renderOrder = 2;
    return [depth, mesh];
  }
  // Upright segments have outlines on the side that the camera saw; those of floors would be a tangle.
  function outlineLines() {
    const positions = [], facing = [];
    for (const {corners: hull, normal: n} of segments.filter((segment) => segment.upright && !segment.outside))
      for (let i = 0; i < hull.length; ++i)
        for (const p of [hull[i], hull[(i + 1) % hull.length]]) {
          positions.push(p.x, p.y, p.z);
          facing.push(n.x, n.y, n.z);
        }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.Float32BufferAttribute(positions, 3));
    geometry.setAttribute('facing', new THREE.Float32BufferAttribute(facing, 3));
    return new THREE.LineSegments(geometry, new THREE.ShaderMaterial({
      transparent: true,
      uniforms: {colour: {value: new THREE.Vector4(0.1, 0.12, 0.18, dark ? 0.5 : 0.2)}},
      vertexShader: `attribute vec3 facing; varying float front;
        void main() {
          vec4 p = modelMatrix * vec4(position, 1.0);
          front = dot((modelMatrix * vec4(facing, 0.0)).xyz, cameraPosition - p.xyz);
          gl_Position = projectionMatrix * viewMatrix * p;
        }`,
      fragmentShader: `uniform vec4 colour; varying float front;
        void main() { if (front < 0.0) discard; gl_FragColor = colour; }`
    }));
  }

  function addCamera(pose, colour, size, positions, colours) {
    const T = poseOf(pose), x = 0.62 * size, y = 0.46 * size, z = size;
    const tip = new THREE.Vector3().applyMatrix4(T);
    const base = [[-x, -y], [x, -y], [x, y], [-x, y]].map(([a, b]) => new THREE.Vector3(a, b, z).applyMatrix4(T));
    const shade = [1, 0.86, 0.72, 0.86], c = new THREE.Color(colour);
    const add = (triangle, light) => triangle.forEach((p) => {
      positions.push(p.x, p.y, p.z);
      colours.push(c.r * light, c.g * light, c.b * light);
    });
    for (let i = 0; i < 4; ++i) add([tip, base[i], base[(i + 1) % 4]], shade[i]);
    add([base[0], base[1], base[2]], 0.6);
    add([base[0], base[2], base[3]], 0.6);
  }
  function camerasOf(poses) {  // [{pose, colour, size}]
    const positions = [], colours = [];
    for (const {pose, colour, size} of poses) addCamera(pose, colour, size, positions, colours);
    return meshOf(positions, colours, THREE.DoubleSide);
  }

  const sphere = new THREE.SphereBufferGeometry(1, 20, 14);
  function ellipsoid(place, axes, colour, opacity) {
    const mesh = new THREE.Mesh(sphere, new THREE.MeshBasicMaterial({color: colour, transparent: true, opacity: opacity, depthWrite: false}));
    mesh.matrixAutoUpdate = false;
    mesh.matrix.set(
        axes[0], axes[1], axes[2], place.x, axes[3], axes[4], axes[5], place.y, axes[6], axes[7], axes[8], place.z, 0, 0, 0, 1);
    return mesh;
  }
  const scaled = (axes, factor) => axes.map((a) => factor * a);
  const ball = (radius) => [radius, 0, 0, 0, radius, 0, 0, 0, radius];

  /** The measured depths of the local models, each in the colour of its height. */
  function pointsLayer() {
    const group = new THREE.Group();
    group.fill = () => {
      const positions = [], colours = [], [fx, fy, cx, cy] = data.camera;
      for (const model of models) {
        if (!model.points) continue;
        const {columns, step, inverse} = model.points, T = poseOf(model.pose);
        new Uint16Array(bytesOf(inverse).buffer).forEach((q, k) => {
          if (!q) return;
          const z = data.inverse_quantum / q, u = (k % columns) * step, v = Math.floor(k / columns) * step / data.shape;
          const p = new THREE.Vector3((u - cx) / fx * z, (v - cy) / fy * z, z).applyMatrix4(T);
          const share = (p.clone().applyMatrix4(world.matrix).z - box.min.z) / Math.max(box.max.z - box.min.z, 0.1);
          const colour = new THREE.Color().setHSL(0.62 - 0.5 * Math.min(1, Math.max(0, share)), 0.55, dark ? 0.62 : 0.42);
          positions.push(p.x, p.y, p.z);
          colours.push(colour.r, colour.g, colour.b);
        });
      }
      const {geometry} = meshOf(positions, colours, THREE.FrontSide);
      group.add(new THREE.Points(geometry, new THREE.PointsMaterial({vertexColors: THREE.VertexColors, size: 1.6, sizeAttenuation: false})));
    };
    return group;
  }

  const roundLength = (length) => {  // the largest of 1, 2, 5, 10, ... that does not exceed it
    const power = Math.pow(10, Math.floor(Math.log10(length)));
    return Number(([5, 2].find((f) => f * power <= length) * power || power).toPrecision(1));
  };
  /** Level lines on the floor, and the axes of the map at their corner that is nearest at first. */
  function gridLayer(step) {
    const group = new THREE.Group(), points = [], back = bestView();
    const low = box.min.clone().divideScalar(step).floor(), high = box.max.clone().divideScalar(step).ceil();
    const z = box.min.z - 0.002 * extent;  // below the floor, which shows
    const at = (x, y) => points.push(new THREE.Vector3(x * step, y * step, z));
    for (let x = low.x; x <= high.x; ++x) at(x, low.y), at(x, high.y);
    for (let y = low.y; y <= high.y; ++y) at(low.x, y), at(high.x, y);
    group.add(linesOf(points, dark ? '#3a404b' : '#c6cbd4', 1));
    const letters = [[[0, 0, 1, 1], [1, 0, 0, 1]], [[0, 0, 0.5, 0.5], [1, 0, 0, 1]], [[0, 0, 1, 0], [1, 0, 0, 1], [0, 1, 1, 1]]];
    letters.forEach((strokes, i) => {  // x, y and z, in no font
      const axis = new THREE.Vector3().setComponent(i, 1).transformDirection(world.matrix), colour = ['#d62728', '#2ca02c', '#1f77b4'][i];
      const corner = new THREE.Vector3((back.x < 0 ? low : high).x * step, (back.y < 0 ? low : high).y * step, z);
      group.add(new THREE.ArrowHelper(axis, corner, step, colour, 0.25 * step, 0.12 * step));
      const canvas = document.createElement('canvas'), context = canvas.getContext('2d');
      canvas.width = canvas.height = 64;
      context.lineWidth = 9;
      context.strokeStyle = colour;
      for (const [x0, y0, x1, y1] of strokes) {
        context.moveTo(16 + 32 * x0, 14 + 36 * y0);
        context.lineTo(16 + 32 * x1, 14 + 36 * y1);
      }
      context.stroke();
      const label = new THREE.Sprite(new THREE.SpriteMaterial({map: new THREE.CanvasTexture(canvas), sizeAttenuation: false}));
      label.scale.setScalar(0.026);
      label.position.copy(corner).addScaledVector(axis, 1.2 * step);
      group.add(label);
    });
    scene.add(group);  // whose z is up
    return group;
  }

  const layers = {};
  function addLayer(name, words, object, visible, key) {
    layers[name] = object;
    object.visible = visible;
    if (!object.parent) world.add(object);
    const label = document.createElement('label'), input = document.createElement('input');
    input.type = 'checkbox';
    input.checked = visible;
    input.id = 'layer-' + name;
    input.addEventListener('change', () => {
      if (object.fill) object.fill();
      object.fill = null;
      object.visible = input.checked;
      draw();
    });
    label.append(input);
    for (const colour of key || []) {
      const dot = document.createElement('span');
      dot.className = 'key';
      dot.style.background = colour;
      label.append(dot);
    }
    label.append(words);
    byId('layers').append(label);
  }

  const surface = new THREE.Group();
  const surfaces = segmentMesh((s) => [!s.outside, false]), backs = segmentMesh((s) => [s.outside, s.upright]);
  surface.add(surfaces, ...lightened(backs));
  if (segments.length < 20000) surface.add(outlineLines());
  addLayer('segments', 'segments', surface, true);
  if (models.some((m) => m.points)) addLayer('points', 'points', pointsLayer(), false);
  const step = roundLength(extent / 10);
  const grid = gridLayer(step);
  addLayer('grid', 'grid of ' + step + ' m', grid, true);
  const colourOf = (model) => model.own ? OWN_COLOURS[model.own.verdict] : COLOURS.model;
  const asked = models.some((m) => m.own);
  addLayer('models', 'local models', camerasOf(models.map((m) => ({pose: m.pose, colour: colourOf(m), size: glyph}))), answers.length === 0, asked ? [] : [COLOURS.model]);
  if (data.links.length) {
    const points = [];
    for (const [a, b] of data.links) points.push(placeOf(models[a].pose), placeOf(models[b].pose));
    addLayer('links', 'links', linesOf(points, COLOURS.link, 1), data.links.length <= data.most_links, [COLOURS.link]);
  }
  data.runs.forEach((run, r) => {
    const points = [];
    for (let i = 3; i + 2 < run.points.length; i += 3)
      points.push(new THREE.Vector3(...run.points.slice(i - 3, i)), new THREE.Vector3(...run.points.slice(i, i + 3)));
    if (points.length) addLayer('run' + r, run.name, linesOf(points, run.colour, 1), true, [run.colour]);
  });
  const changes = data.changes || [], CHANGE_COLOURS = {removed: COLOURS.wrong, new: COLOURS.sure};
  for (const kind of ['removed', 'new']) {
    const positions = [], colours = [], colour = new THREE.Color(CHANGE_COLOURS[kind]);
    for (const change of changes.filter((c) => c.kind === kind)) {
      const hull = change.outline.map((p) => new THREE.Vector3(...p));
      for (let i = 1; i + 1 < hull.length; ++i)
        for (const p of [hull[0], hull[i], hull[i + 1]]) {
          positions.push(p.x, p.y, p.z);
          colours.push(colour.r, colour.g, colour.b);
        }
    }
    if (!positions.length) continue;
    const mesh = meshOf(positions, colours, THREE.DoubleSide);
    Object.assign(mesh.material, {transparent: true, opacity: 0.6, polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -2});
    addLayer(kind, kind + ' surfaces', mesh, true, [CHANGE_COLOURS[kind]]);
  }
  const counts = {sure: 0, doubtful: 0, wrong: 0, unknown: 0};
  for (const answer of answers) ++counts[verdictOf(answer)];
  if (answers.length) {
    const group = new THREE.Group(), placed = answers.filter((answer) => answer.places.length);
    const isSure = (answer) => answer.state === 'sure';
    const cameraOf = (answer) => {
      const verdict = verdictOf(answer);
      return {pose: answer.places[0].pose, colour: COLOURS[verdict], size: glyph * (verdict === 'wrong' ? 1.5 : 1)};
    };
    const light = camerasOf(placed.filter((answer) => !isSure(answer)).map(cameraOf));
    Object.assign(light.material, {transparent: true, opacity: 0.35});
    group.add(camerasOf(placed.filter(isSure).map(cameraOf)), light);
    addLayer('answers', 'answers', group, true);
    const clouds = new THREE.Group();
    for (const answer of placed)
      if (answer.axes && isSure(answer))
        clouds.add(ellipsoid(placeOf(answer.places[0].pose), scaled(answer.axes, ELLIPSOID), COLOURS[verdictOf(answer)], 0.25));
    addLayer('ellipsoids', '95 % ellipsoids', clouds, true);
  }
  const chosen = new THREE.Group();  // what is clicked, or the image of the moment
  world.add(chosen);

  // ---- the view ----
  /** The direction to the eye from which most upright area shows the side that the camera saw. */
  function bestView() {
    const seen = (back) => segments.reduce((sum, s) => sum + (s.upright ? areaOf(s.corners) * Math.max(0, s.normal.clone().transformDirection(world.matrix).dot(back)) : 0), 0);
    const views = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => new THREE.Vector3(-0.35, -0.62, 0.78).normalize().applyAxisAngle(camera.up, k * Math.PI / 4));
    return views.map((back) => [seen(back), back]).reduce((best, next) => next[0] > 1.01 * best[0] ? next : best)[1];
  }
  /** Everything fills what the panes leave free. */
  function fit() {
    const shown = new THREE.Box3().setFromObject(grid).union(box);
    const wide = (id) => {
      const pane = byId(id).getBoundingClientRect();
      return pane.width > 0.6 * window.innerWidth ? pane : {height: 0};
    };
    const top = wide('about').height, bottom = wide('time').height, height = window.innerHeight;
    const back = bestView();
    const right = new THREE.Vector3().crossVectors(camera.up, back).normalize(), above = back.clone().cross(right);
    const steep = Math.tan(camera.fov * Math.PI / 360), target = shown.getCenter(new THREE.Vector3());
    let distance = 0.5;
    for (let i = 0; i < 8; ++i) {
      const p = new THREE.Vector3(...['x', 'y', 'z'].map((axis, k) => shown[i >> k & 1 ? 'max' : 'min'][axis])).sub(target);
      const needed = Math.max(Math.abs(p.dot(right)) * height / window.innerWidth, Math.abs(p.dot(above)) * height / Math.max(height - top - bottom, 1));
      distance = Math.max(distance, p.dot(back) + 1.03 * needed / steep);
    }
    camera.setViewOffset(window.innerWidth, height, 0, (bottom - top) / 2, window.innerWidth, height);
    controls.target.copy(target);
    camera.position.copy(target).addScaledVector(back, distance);
    camera.near = distance / 1000;
    camera.far = distance * 20;
    controls.maxDistance = 8 * distance;
    controls.update();
  }
  function showScale() {  // where the view turns about
    const pixels = window.innerHeight / (2 * camera.position.distanceTo(controls.target) * Math.tan(camera.fov * Math.PI / 360));
    const length = roundLength(120 / pixels), bar = byId('scale');
    bar.style.width = length * pixels + 'px';
    bar.textContent = length + ' m';
  }
  let waiting = false, untouched = true;
  controls.addEventListener('start', () => { untouched = false; });
  function draw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      showScale();
      renderer.render(scene, camera);
    });
  }
  function resize() {
    renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    renderer.setSize(window.innerWidth, window.innerHeight, false);
    camera.aspect = window.innerWidth / window.innerHeight;
    if (untouched) fit();
    camera.updateProjectionMatrix();
    drawStates();
    draw();
  }
  controls.addEventListener('change', draw);

  // ---- cards ----
  function element(tag, words, parent) {
    const e = document.createElement(tag);
    if (words !== undefined) e.textContent = words;
    if (parent) parent.append(e);
    return e;
  }
  const metres = (x) => x < 0.1 ? (1000 * x).toFixed(x < 0.01 ? 1 : 0) + ' mm' : x.toFixed(2) + ' m';
  const percent = (share) => (100 * share).toFixed(0) + ' %';
  const position = (pose) => pose.slice(0, 3).map((x) => x.toFixed(2)).join(', ') + ' m';
  const plural = (n, word) => n + ' ' + word + (n === 1 ? '' : 's');

  function openCard(title) {
    const card = byId('card');
    card.textContent = '';
    card.hidden = false;
    const close = element('button', '\u00d7', card);
    close.type = 'button';
    close.className = 'close';
    close.title = 'Close';
    close.addEventListener('click', () => { card.hidden = true; chosen.children.slice().forEach((c) => chosen.remove(c)); draw(); });
    element('h2', title, card);
    return card;
  }
  function rows(card, lines) {
    const table = element('table', undefined, card);
    for (const [name, value] of lines) {
      if (value === undefined) continue;
      const row = element('tr', undefined, table);
      element('th', name, row);
      const cell = element('td', undefined, row);
      if (value instanceof Node) cell.append(value); else cell.textContent = value;
    }
  }
  function badge(words, colour) {
    const e = element('span', words);
    e.className = 'badge';
    e.style.background = colour;
    return e;
  }

  // Outlines are in permille of width and height of the image.
  function paint(figure, image, outlines) {
    const canvas = element('canvas', undefined, figure), scale = 2;
    canvas.width = 160 * scale;
    canvas.height = Math.round(160 * scale * (data.shape || 0.75));
    const context = canvas.getContext('2d');
    const finish = () => {
      context.lineWidth = 2.5;
      context.font = 'bold 20px sans-serif';
      context.textAlign = 'center';
      context.textBaseline = 'middle';
      for (const {points, colour, words} of outlines) {
        if (points.length < 6) continue;
        context.beginPath();
        let x = 0, y = 0;
        for (let i = 0; i < points.length; i += 2) {
          const u = points[i] * canvas.width / 1000, v = points[i + 1] * canvas.height / 1000;
          x += 2 * u / points.length, y += 2 * v / points.length;
          if (i) context.lineTo(u, v); else context.moveTo(u, v);
        }
        context.closePath();
        context.globalAlpha = 0.35;
        context.fillStyle = colour;
        context.fill();
        context.globalAlpha = 1;
        context.strokeStyle = colour;
        context.stroke();
        if (!words) continue;
        context.lineWidth = 4;
        context.strokeStyle = '#000';
        context.strokeText(words, x, y);
        context.fillStyle = '#fff';
        context.fillText(words, x, y);
        context.lineWidth = 2.5;
      }
    };
    if (!image) return finish();
    const img = new Image();
    img.onload = () => { context.drawImage(img, 0, 0, canvas.width, canvas.height); finish(); };
    img.src = 'data:image/jpeg;base64,' + image;
  }
  function outlineIn(model, s) {  // a segment as its local model's camera sees it
    const segment = model.segments[s];
    if (!segment) return [];
    const inverse = new THREE.Matrix4().getInverse(poseOf(model.pose)), points = [];
    for (const corner of segment.corners) {
      const p = corner.clone().applyMatrix4(inverse);
      if (p.z < 0.05) return [];
      points.push(1000 * (data.camera[0] * p.x / p.z + data.camera[2]), 1000 * (data.camera[1] * p.y / p.z + data.camera[3]));
    }
    return points;
  }
  function figureOf(parent, caption, image, outlines) {
    const figure = element('figure', undefined, parent);
    paint(figure, image, outlines);
    element('figcaption', caption, figure);
  }
  function linkTo(m) {
    const button = element('button', models[m].name || plural(m + 1, 'local model'));
    button.type = 'button';
    button.className = 'go';
    button.addEventListener('click', () => showModel(m));
    return button;
  }

  function mark(objects) {
    chosen.children.slice().forEach((c) => chosen.remove(c));
    objects.forEach((o) => chosen.add(o));
    draw();
  }
  function halo(place, radius, colour) { return ellipsoid(place, ball(radius), colour, 0.35); }

  function showModel(m, segment) {
    const model = models[m], own = model.own;
    const card = openCard('Local model ' + model.name);
    const lines = [
      ['position', position(model.pose)], ['segments', String(model.n)],
      ['links', String(data.links.filter(([a, b]) => a === m || b === m).length)],
      ['pose', model.by_links ? 'from its links' : 'given'],
      ['segment', segment ? (segment.index + 1) + ', ' + areaOf(segment.corners).toFixed(2) + ' m\u00b2' : undefined]
    ];
    if (own) lines.push(
      ['in the map without it', badge(OWN_WORDS[own.verdict], OWN_COLOURS[own.verdict])], ['probability', own.p.toFixed(3)],
      ['95 % ellipsoid', own.inside === undefined ? undefined : own.inside ? 'holds its pose' : 'misses its pose'],
      ['taken for', own.taken_for >= 0 ? linkTo(own.taken_for) : own.taken_for === undefined ? undefined : 'a local model that is not shown'],
      ['distance', own.off === undefined ? undefined : metres(own.off)],
      ['reason', own.reason || undefined]);
    rows(card, lines);
    const pair = element('div', undefined, card);
    pair.className = 'pair';
    const outlines = model.segments.map((s, i) => ({
      points: outlineIn(model, i), colour: s.colour ? '#' + s.colour.getHexString() : '#888', words: segment && segment.index === i ? String(i + 1) : ''}));
    figureOf(pair, 'depth of the local model, its segments by direction', model.image, outlines);
    mark([camerasOf([{pose: model.pose, colour: colourOf(model), size: 1.6 * glyph}]), halo(placeOf(model.pose), 0.8 * glyph, colourOf(model))]);
  }
  function showChange(change) {
    rows(openCard(change.kind === 'new' ? 'New surface' : 'Removed surface'), [
      ['area', change.area.toFixed(2) + ' m\u00b2'], ['probability', change.p.toFixed(3)], ['looks', String(change.looks)],
      ['seen by', change.seen_by], ['centre', position(change.centre)]
    ]);
    mark([halo(placeOf(change.centre), Math.max(glyph, Math.sqrt(change.area)), CHANGE_COLOURS[change.kind])]);
  }
  function areaOf(hull) {
    const sum = new THREE.Vector3();
    for (let i = 1; i + 1 < hull.length; ++i)
      sum.add(new THREE.Vector3().crossVectors(hull[i].clone().sub(hull[0]), hull[i + 1].clone().sub(hull[0])));
    return sum.length() / 2;
  }

  function showAnswer(a) {
    const answer = answers[a], verdict = verdictOf(answer), best = answer.places[0];
    const card = openCard('Image ' + answer.name);
    const others = answer.places.length - 1;
    rows(card, [
      ['answer', badge(verdict === 'wrong' ? 'sure, and wrong' : verdict, COLOURS[verdict])], ['probability', best && best.p.toFixed(3)], ['position', best && position(best.pose)],
      ['standard deviation', best && metres(best.sd_m) + ', ' + best.sd_deg.toFixed(2) + '\u00b0'],
      ['from the truth', answer.error && metres(answer.error[0]) + ', ' + answer.error[1].toFixed(2) + '\u00b0' + (answer.relative ? ' (in its local model)' : '')],
      ['local model', best && best.model >= 0 ? linkTo(best.model) : undefined],
      ['other places', others > 0 ? others + (answer.more ? ' and ' + answer.more + ' more' : '') + ', the next with ' + answer.places[1].p.toFixed(3) : undefined],
      ['view', answer.shares && ['explained', 'hiding', 'new'].map((s) => percent(answer.shares[s]) + ' ' + s).join(', ')],
      ['map in view', answer.shares && percent(answer.shares.missing) + ' missing'],
      ['reason', answer.reason || undefined]
    ]);
    if (answer.image || (best && best.model >= 0)) {
      const pair = element('div', undefined, card);
      pair.className = 'pair';
      const colour = (i) => SEGMENT_COLOURS[i % SEGMENT_COLOURS.length], matches = answer.matches || [];
      if (answer.image)
        figureOf(pair, 'the image, ' + plural(matches.length, 'matched segment'), answer.image,
                 matches.map((m, i) => ({points: m.outline, colour: colour(i), words: String(i + 1)})));
      if (best && best.model >= 0)
        figureOf(pair, 'local model ' + models[best.model].name, models[best.model].image,
                 matches.map((m, i) => ({points: outlineIn(models[best.model], m.model), colour: colour(i), words: String(i + 1)})));
    }
    const objects = [], cameras = [];
    answer.places.forEach((place, i) => {
      const colour = COLOURS[i === 0 ? verdict : 'doubtful'], opacity = 0.15 + 0.5 * Math.min(1, place.p);
      const axes = i === 0 && answer.axes ? scaled(answer.axes, ELLIPSOID) : ball(2 * place.sd_m);
      objects.push(ellipsoid(placeOf(place.pose), axes, colour, opacity));
      cameras.push({pose: place.pose, colour: colour, size: glyph * (i === 0 ? 1.8 : 0.6 + Math.min(1, place.p))});
    });
    objects.push(camerasOf(cameras));
    if (answer.truth) objects.push(crossAt(placeOf(answer.truth)));
    mark(objects);
    if (moment.value !== String(a)) moment.value = String(a);
    showNow(a);
  }
  function crossAt(p) {
    const points = [], s = 1.4 * glyph;
    for (const d of [[s, 0, 0], [0, s, 0], [0, 0, s]])
      points.push(p.clone().add(new THREE.Vector3(...d)), p.clone().sub(new THREE.Vector3(...d)));
    return linesOf(points, COLOURS.truth, 1);
  }

  // ---- picking: cameras by their distance on the screen, else the segment under the pointer ----
  function onScreen(place) {
    camera.updateMatrixWorld();  // may have moved since the last frame
    const p = place.clone().applyMatrix4(world.matrix).project(camera);
    return p.z > 1 ? null : [(p.x + 1) / 2 * window.innerWidth, (1 - p.y) / 2 * window.innerHeight];
  }
  function nearest(places, x, y, reach) {
    let best = -1, least = reach;
    places.forEach((place, i) => {
      const at = place && onScreen(place);
      if (!at) return;
      const distance = Math.hypot(at[0] - x, at[1] - y);
      if (distance < least) { least = distance; best = i; }
    });
    return best;
  }
  const raycaster = new THREE.Raycaster();
  function pick(x, y, reach) {
    if (layers.answers && layers.answers.visible) {
      const a = nearest(answers.map((answer) => answer.places.length ? placeOf(answer.places[0].pose) : null), x, y, reach);
      if (a >= 0) return showAnswer(a);
    }
    if (layers.models.visible) {
      const m = nearest(models.map((model) => placeOf(model.pose)), x, y, reach);
      if (m >= 0) return showModel(m);
    }
    if (!layers.segments.visible) return;
    raycaster.setFromCamera(new THREE.Vector2(2 * x / window.innerWidth - 1, 1 - 2 * y / window.innerHeight), camera);
    for (const mesh of [surfaces, backs]) {
      const [hit] = raycaster.intersectObject(mesh);
      if (!hit) continue;
      const segment = mesh.owners[hit.faceIndex];
      return showModel(segment.model, segment);
    }
  }
  let pressed = null;
  renderer.domElement.addEventListener('pointerdown', (e) => { pressed = [e.clientX, e.clientY]; });
  renderer.domElement.addEventListener('pointerup', (e) => {
    const still = pressed && Math.hypot(e.clientX - pressed[0], e.clientY - pressed[1]) < 5;
    pressed = null;
    if (still) pick(e.clientX, e.clientY, e.pointerType === 'touch' ? 24 : 12);
  });

  // ---- time ----
  const moment = byId('moment');
  let timer = null;
  function showNow(a) { byId('now').textContent = (a + 1) + '/' + answers.length + ' ' + answers[a].name; }
  function drawStates() {
    if (!answers.length) return;
    const canvas = byId('states'), width = canvas.width = canvas.clientWidth || 300, context = canvas.getContext('2d');
    answers.forEach((answer, i) => {
      context.fillStyle = COLOURS[verdictOf(answer)];
      const from = Math.floor(i * width / answers.length);
      context.fillRect(from, 0, Math.max(1, Math.ceil((i + 1) * width / answers.length) - from), 10);
    });
  }
  function stop() { clearInterval(timer); timer = null; byId('play').textContent = '\u25b6'; }
  if (answers.length) {
    byId('time').hidden = false;
    moment.max = String(answers.length - 1);
    moment.addEventListener('input', () => { stop(); showAnswer(Number(moment.value)); });
    byId('play').addEventListener('click', () => {
      if (timer) return stop();
      byId('play').textContent = '\u23f8';
      timer = setInterval(() => {
        const next = (Number(moment.value) + 1) % answers.length;
        moment.value = String(next);
        showAnswer(next);
      }, 250);
    });
    showNow(0);
  }

  const words = [plural(models.length, 'local model'), plural(segments.length, 'segment')];
  if (data.links.length) words.push(plural(data.links.length, 'link'));
  byId('counts').textContent = words.join(', ') + (data.left_out ? '; ' + data.left_out : '');
  if (data.findings) {
    const findings = element('details');
    element('summary', plural(data.findings.length, 'finding'), findings);
    for (const words of data.findings) element('p', words, findings);
    byId('layers').before(findings);
  }
  if (changes.length) {
    const list = element('details');
    list.id = 'changes';
    element('summary', plural(changes.length, 'changed surface'), list);
    for (const change of changes) {
      const line = element('p', undefined, list), button = element('button', change.kind, line);
      button.type = 'button';
      button.className = 'go';
      button.addEventListener('click', () => showChange(change));
      line.append(' ' + change.area.toFixed(2) + ' m\u00b2, probability ' + change.p.toFixed(3));
    }
    byId('layers').before(list);
  }
  function legend(id, entries) {  // [[colour, number, words]]
    const line = element('p');
    line.id = id;
    line.style.margin = '0 0 4px';
    for (const [colour, n, words] of entries) {
      if (!n) continue;
      const key = element('span', undefined, line);
      key.className = 'key';
      key.style.background = colour;
      line.append(n + ' ' + words + '\u2003');
    }
    byId('layers').before(line);
    return line;
  }
  if (answers.length)
    legend('verdicts', ['sure', 'wrong', 'doubtful', 'unknown'].map((v) => [COLOURS[v], counts[v], v === 'wrong' ? 'sure and wrong' : v]));
  if (asked) {
    const entries = Object.keys(OWN_WORDS).map((v) => [OWN_COLOURS[v], models.filter((m) => m.own && m.own.verdict === v).length, OWN_WORDS[v]]);
    legend('own', [...entries, [COLOURS.model, models.filter((m) => !m.own).length, 'not asked']]).prepend('own images without themselves: ');
  }
  window.addEventListener('resize', resize);
  resize();

  // For programs that look at the page: where things are on the screen, and what was drawn.
  window.facetloc = {
    answerOnScreen: (a) => onScreen(placeOf(answers[a].places[0].pose)),
    modelOnScreen: (m) => onScreen(placeOf(models[m].pose)),
    turn: (degrees) => {
      camera.position.sub(controls.target).applyAxisAngle(camera.up, degrees * Math.PI / 180).add(controls.target);
      controls.update();
    },
    triangles: () => { renderer.render(scene, camera); return renderer.info.render.triangles; }
  };
})();
