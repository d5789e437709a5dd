// The sections "In three dimensions" and "Try it". Frames: docs/conventions.md; wind along +x, z up. `data-bodies` tells a test when all
// is drawn.
const {shapes, cases, errors} = JSON.parse(await unpacked('bodies'));
const find = (selector) => document.querySelector(selector);
const say = (name, text) => { find(`[data-text="${name}"]`).textContent = text; };

// --- Libraries, which this page holds as text ------------------------------------------------------------------------------------------

const address = (text) => URL.createObjectURL(new Blob([text], {type: 'text/javascript'}));
const core = address(await unpacked('three.core.min.js'));
const THREE = await import(address((await unpacked('three.module.min.js')).replaceAll('./three.core.min.js', core)));

// --- Vectors ---------------------------------------------------------------------------------------------------------------------------

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const scaled = (a, k) => a.map((x) => k * x);
const plus = (a, b) => a.map((x, i) => x + b[i]);
const length = (a) => Math.hypot(...a);
/// Rotation, row by row, times a vector; and its inverse times one.
const turned = (r, v) => [0, 3, 6].map((i) => dot(r.slice(i, i + 3), v));
const turnedBack = (r, v) => [0, 1, 2].map((i) => r[i] * v[0] + r[i + 3] * v[1] + r[i + 6] * v[2]);
/// Rz(yaw) Ry(incidence) Rx(roll), angles in degrees.
function rotationOf(incidence, yaw, roll) {
  const [a, b, g] = [incidence, yaw, roll].map((angle) => angle * Math.PI / 180);
  const [ca, cb, cg, sa, sb, sg] = [Math.cos(a), Math.cos(b), Math.cos(g), Math.sin(a), Math.sin(b), Math.sin(g)];
  return [
    cb * ca, cb * sa * sg - sb * cg, cb * sa * cg + sb * sg,
    sb * ca, sb * sa * sg + cb * cg, sb * sa * cg - cb * sg,
    -sa, ca * sg, ca * cg,
  ];
}

// --- Colours: blue for suction, orange for pressure, told apart by every kind of eye ---------------------------------------------------

const unknown = [0.6, 0.6, 0.6];
const ends = {suction: [0.13, 0.40, 0.67], none: [0.96, 0.96, 0.96], pressure: [0.85, 0.37, 0.01]};
function colourOf(value, range) {
  const share = Math.min(1, Math.abs(value) / range), end = value < 0 ? ends.suction : ends.pressure;
  return ends.none.map((x, i) => x + share * (end[i] - x));
}
const css = (colour) => `rgb(${colour.map((x) => Math.round(255 * x)).join(' ')})`;
const digits = (x) => (Math.abs(x) >= 100 || x === 0 ? x.toFixed(0) : x.toPrecision(3)).replace('-', '−');
/// What is below 1e-9 of a force, or of it times an arm, is the rounding of a zero.
const withoutRounding = (force, arm) => (x) => digits(Math.abs(x) < 1e-9 * length(force) * arm ? 0 : x);
const fixed = (x) => ((text) => (/[1-9]/.test(text) ? text.replace('-', '−') : text.replace('-', '')))(x.toFixed(3));

function showScale(name, range) {
  const scale = find(`[data-scale="${name}"]`);
  scale.innerHTML = '<span></span><span class="bar"></span><span></span>';
  scale.firstChild.textContent = 'Cp ' + digits(-range);
  scale.lastChild.textContent = '+' + digits(range);
  scale.children[1].style.background = `linear-gradient(to right, ${css(ends.suction)}, ${css(ends.none)}, ${css(ends.pressure)})`;
}

// --- A picture of a body ---------------------------------------------------------------------------------------------------------------

class Picture {
  /// null where the browser has no WebGL; the words stand in place of the picture then.
  static on(canvas) {
    const context = canvas.getContext('webgl2', {antialias: true, alpha: true, preserveDrawingBuffer: true});  // kept for print
    if (context) return new Picture(canvas, context);
    const words = document.createElement('p');
    words.className = 'bad';
    words.textContent = 'This browser shows no WebGL, which the picture needs; the numbers do without.';
    canvas.replaceWith(words);
    return null;
  }

  constructor(canvas, context) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({canvas, context});
    this.scene = new THREE.Scene();
    const sun = new THREE.DirectionalLight(0xffffff, 1);
    sun.position.set(-1, -3, 4);
    this.scene.add(new THREE.AmbientLight(0xffffff, 2.2), sun);
    this.camera = new THREE.PerspectiveCamera(30, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.look = {azimuth: -118, elevation: 20, distance: 5.4};  // from the windward side, which pictures of the law are about
    this.things = new THREE.Group();
    this.scene.add(this.things);
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  /// @param corners  of triangles, nine numbers each, body frame; colours: three numbers for each triangle; arrows: {from, along, colour,
  ///                 width}; lengths in radii of the body
  show(corners, colours, rotation, radius, arrows) {
    this.things.traverse((thing) => { thing.geometry?.dispose(); thing.material?.dispose(); });
    this.things.clear();
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(Float32Array.from(corners, (x) => x / radius), 3));
    const shade = new THREE.Color();
    const byCorner = new Float32Array(corners.length);
    for (let i = 0; i < colours.length; ++i) {
      shade.setRGB(...colours[i], THREE.SRGBColorSpace);
      for (let corner = 0; corner < 3; ++corner) byCorner.set([shade.r, shade.g, shade.b], 9 * i + 3 * corner);
    }
    geometry.setAttribute('color', new THREE.BufferAttribute(byCorner, 3));
    geometry.computeVertexNormals();
    const body = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({vertexColors: true, side: THREE.DoubleSide}));
    body.add(new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 25), new THREE.LineBasicMaterial({color: 0x555555})));
    const r = rotation;
    body.matrix.set(r[0], r[1], r[2], 0, r[3], r[4], r[5], 0, r[6], r[7], r[8], 0, 0, 0, 0, 1);
    body.matrixAutoUpdate = false;
    this.things.add(body);
    for (const arrow of arrows) this.addArrow(arrow);
    this.draw();
  }

  /// @param line  drawn along the whole of it too, and all of it before the body, which would hide most of a force
  addArrow({from, along, colour, width, line}) {
    const size = length(along);
    if (!(size > 1e-6)) return;
    const material = new THREE.MeshBasicMaterial({color: colour, depthTest: !line, transparent: Boolean(line), opacity: 0.85});
    const head = Math.min(4 * width, size / 2);
    const up = new THREE.Vector3(0, 1, 0), direction = new THREE.Vector3(...along).normalize();
    const piece = (shape, at) => {
      const mesh = new THREE.Mesh(shape, material);
      mesh.position.set(...plus(from, scaled(along, at / size)));
      mesh.quaternion.setFromUnitVectors(up, direction);
      this.things.add(mesh);
    };
    piece(new THREE.CylinderGeometry(width, width, size - head, 12), (size - head) / 2);
    piece(new THREE.ConeGeometry(2.5 * width, head, 16), size - head / 2);
    if (line) piece(new THREE.CylinderGeometry(width / 5, width / 5, 6, 6), 0);
  }

  draw() {
    const {clientWidth: width, clientHeight: height} = this.canvas;
    if (!width || !height) return;
    const [azimuth, elevation] = [this.look.azimuth, this.look.elevation].map((angle) => angle * Math.PI / 180);
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    // A narrow picture shows as much to the sides as a square one.
    const away = this.look.distance / Math.min(1, this.camera.aspect);
    const aside = away * Math.cos(elevation);
    this.camera.position.set(aside * Math.cos(azimuth), aside * Math.sin(azimuth), away * Math.sin(elevation));
    this.camera.lookAt(0, 0, 0);
    this.camera.updateProjectionMatrix();
    this.renderer.render(this.scene, this.camera);
  }
}

/// Calls turn(degrees to the right, degrees up) and zoom(factor) as the pointer or the keys ask.
function onTurn(canvas, turn, zoom) {
  canvas.addEventListener('pointerdown', (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener('pointermove', (event) => {
    if (canvas.hasPointerCapture(event.pointerId)) turn(event.movementX / 2, event.movementY / 2);
  });
  const keys = {ArrowLeft: [-5, 0], ArrowRight: [5, 0], ArrowUp: [0, -5], ArrowDown: [0, 5]};
  canvas.addEventListener('keydown', (event) => {
    if (keys[event.key]) turn(...keys[event.key]);
    else if (event.key === '+') zoom(1 / 1.1);
    else if (event.key === '-') zoom(1.1);
    else return;
    event.preventDefault();
  });
}

/// The arrow of a force on its line of action.
/// @param load     {force, torque about the origin}, wind frame
/// @param longest  a force that is drawn 1.15 radii long
function forceArrow({force, torque}, longest, radius, colour, width) {
  const size = length(force);
  const point = size > 0 ? scaled(cross(force, torque), 1 / (size * size * radius)) : [0, 0, 0];
  const inView = Math.min(1, 2 / (length(point) || 1));  // a line of action far off is drawn at the edge
  return {from: scaled(point, inView), along: scaled(force, 1.15 / (longest || 1)), colour, width, line: true};
}
const windArrow = {from: [-2.1, 0, 0], along: [0.8, 0, 0], colour: 0x888888, width: 0.03};
const dark = matchMedia('(prefers-color-scheme: dark)');
const colours = () => ({reference: dark.matches ? 0xeeeeee : 0x222222, law: 0x0072b2});

function fillTable(id, head, rows) {
  const table = document.getElementById(id);
  const line = (cells, tag) => {
    const row = document.createElement('tr');
    cells.forEach((text, i) => {
      const cell = row.appendChild(document.createElement(tag));
      cell.textContent = text;
      if (i === 0) cell.className = 'text';
    });
    return row;
  };
  table.tHead.replaceChildren(line(head, 'th'));
  table.tBodies[0].replaceChildren(...rows.map((cells) => line(cells, 'td')));
}

function fillSelect(select, texts) {
  select.replaceChildren(...texts.map((text, i) => new Option(text, i)));
}

// --- In three dimensions ---------------------------------------------------------------------------------------------------------------

function startPatches() {
  const {flow, pose, law} = find('[data-controls="patches"]').elements;
  const byFlow = new Map(cases.map((one) => [one.flow, []]));
  for (const one of cases) byFlow.get(one.flow).push(one);
  const flows = [...byFlow];
  for (const [, poses] of flows) poses.sort((a, b) => a.pose.localeCompare(b.pose, 'en', {numeric: true}));
  if (flows.length === 0) {
    say('patches', 'None of these references keeps the pressure on its surface.');
    return;
  }
  const pictures = ['reference', 'law'].map((name) => Picture.on(find(`[data-view="${name}"]`)));
  fillSelect(flow, flows.map(([name]) => name));
  fillSelect(law, cases[0].models.map((model) => model.label));

  const show = () => {
    const one = flows[flow.value][1][pose.value], model = one.models[law.value], shape = shapes[one.shape];
    const corners = shape.triangles.flatMap((corner) => shape.vertices.slice(3 * corner, 3 * corner + 3));
    const radius = Math.max(...shape.triangles.map((corner) => length(shape.vertices.slice(3 * corner, 3 * corner + 3))));
    const all = [...one.pressures, ...model.pressures].filter((value) => value !== null);
    const range = Math.max(...all.map(Math.abs));
    const loads = [one, model].map(({coefficients: c}) => ({force: c.slice(0, 3), torque: scaled(c.slice(3), one.length)}));
    const longest = Math.max(...loads.map(({force}) => length(force)));
    const {reference: ink, law: blue} = colours();
    pictures.forEach((picture, side) => {
      const values = shape.patch.map((patch) => [one, model][side].pressures[patch]);
      const arrows = [ink, blue].map((colour, i) => forceArrow(loads[i], longest, radius, colour, side === i ? 0.05 : 0.025));
      picture?.show(corners, values.map((value) => value == null ? unknown : colourOf(value, range)), one.rotation, radius, [windArrow, ...arrows]);
    });
    showScale('patches', range);
    say('law', model.label);
    say('patches', `${shape.name}, ${one.pose}: case ${one.case}. Of pressures the law knows no more than differences: ${digits(model.gauge)} ` +
        `was taken off its Cp everywhere, so that the mean over the surface is OpenFOAM's; on a closed body that changes no force.`);
    const names = ['CD', 'CS', 'CL', 'Cl', 'Cm', 'Cn'];
    fillTable('patch-forces', ['', 'OpenFOAM', model.label, 'error'], names.map((name, k) => [
      name, fixed(one.coefficients[k]) + (k === 0 ? ' ± ' + fixed(one.u) : ''), fixed(model.coefficients[k]),
      fixed(model.coefficients[k] - one.coefficients[k])]));
  };
  const choosePoses = () => {
    fillSelect(pose, flows[flow.value][1].map((one) => one.pose));
    pose.value = Math.max(0, flows[flow.value][1].findIndex((one) => /^\w+ 30°$/.test(one.pose)));  // symmetric poses tell less
    show();
  };
  flow.addEventListener('change', choosePoses);
  pose.addEventListener('change', show);
  law.addEventListener('change', show);
  dark.addEventListener('change', show);
  const shown = pictures.filter((picture) => picture);
  for (const picture of shown)
    onTurn(picture.canvas,
        (right, down) => {
          for (const {look} of shown) look.azimuth -= right, look.elevation = Math.max(-85, Math.min(85, look.elevation + down));
          for (const each of shown) each.draw();
        },
        (factor) => { for (const each of shown) each.look.distance *= factor, each.draw(); });
  const turbulentCube = flows.findIndex(([name]) => name.startsWith('cube at Re 10⁵'));
  flow.value = Math.max(0, turbulentCube);
  choosePoses();
}

// --- Try it ----------------------------------------------------------------------------------------------------------------------------

async function startTrial() {
  const form = find('[data-controls="trial"]');
  if (!document.getElementById('dragcore.mjs')) {
    for (const part of document.querySelectorAll('#try-it form, #try-it .views')) part.hidden = true;
    say('library', 'Here the library itself would run, compiled to WebAssembly. This page was written without it, for want of Emscripten: ' +
        'apt-get install emscripten, then cmake --build build/release --target dragcore_wasm, then dragval report.');
    return;
  }
  const dragcore = await (await import(address(await unpacked('dragcore.mjs')))).load();
  const picture = Picture.on(find('[data-view="trial"]'));
  const fields = form.elements;
  const list = find('[data-list="effects"]');
  for (const effect of dragcore.effects) {
    const label = list.appendChild(document.createElement('label'));
    label.append(Object.assign(document.createElement('input'), {type: 'checkbox', name: 'effect', value: effect, checked: true}), ' ' + effect);
  }
  const results = document.getElementById('trial-forces');
  let body, corners, file;

  function replaceBody(made) {
    body?.free();
    body = made;
    corners = body.corners();
  }

  /// A body is centred where its area is, so that it turns about its middle.
  function chooseShape() {
    if (fields.shape.value === 'file') return openFile();
    const [kind, ...parameters] = fields.shape.value.split(' ');
    const sizes = Object.fromEntries(parameters.map((text) => text.split('=')).map(([name, value]) => [name, Number(value)]));
    replaceBody(dragcore.shape(kind, sizes, ['cube', 'box', 'plate', 'prism'].includes(kind) ? 2 : 16));
    show();
  }

  function openFile() {
    try {
      const read = file.name.toLowerCase().endsWith('.obj') ? dragcore.fromObj : dragcore.fromStl;
      let unit = Number(fields.unit.value) || 1, made = read(file.bytes, unit);
      if (fields.unit.value === '0' && made.radius > 10) {  // drawings are in millimetres, and few bodies this long
        made.free();
        made = read(file.bytes, unit = 0.001);
      }
      replaceBody(made);
      fields.shape.querySelector('[value=file]').disabled = false;
      fields.shape.value = 'file';
      show();
      const units = {1: 'metres', 0.01: 'centimetres', 0.001: 'millimetres'};
      say('library', `${file.name}: ${body.triangles} triangles, read in ${units[unit]}. ${body.notes.join(' ')}`);
    } catch (fault) {
      say('library', `${file.name}: ${fault.message}`);
    }
  }

  async function take(given) {
    if (!given) return;
    file = {name: given.name, bytes: new Uint8Array(await given.arrayBuffer())};
    openFile();
  }

  function show() {
    const number = (name) => Number(fields[name].value) || 0;
    for (const name of ['incidence', 'yaw', 'roll'])
      fields[name].nextElementSibling.textContent = `${fields[name].value}°`.replace('-', '−');
    const speed = number('speed'), spin = [number('spin_x'), number('spin_y'), number('spin_z')];
    const rotation = rotationOf(number('incidence'), number('yaw'), number('roll'));
    const toWind = (v) => turned(rotation, v);
    const reynoldsLength = body.referenceLength || 2 * body.radius, density = 1.225;
    const reynolds = number('reynolds'), viscosity = reynolds > 0 ? density * speed * reynoldsLength / reynolds : 0;
    const toBody = (v) => turnedBack(rotation, v);
    const flow = {wind: toBody([speed, 0, 0]), angularVelocity: toBody(spin), referencePoint: body.centre, density, viscosity};
    const boxes = [...form.querySelectorAll('[name=effect]')];
    const model = {law: fields.law.value, effects: boxes.filter((box) => box.checked).map((box) => box.value)};
    const wrench = body.wrench(flow, model), validity = body.validity(flow, model);
    const {force: byTriangle} = body.triangleForces(flow, model);

    const area = body.referenceArea || body.windwardArea(flow.wind), q = density * speed * speed / 2;
    const force = toWind(wrench.force), torque = toWind(wrench.torque);
    const coefficient = (x) => area * q > 0 ? fixed(x / (area * q)) : '–';
    fillTable('trial-forces', ['wind frame', 'x', 'y', 'z'], [
      ['force [N]', ...force.map(withoutRounding(force, 1))],
      ['torque about the middle [N m]', ...torque.map(withoutRounding(force, body.radius))],
      ['CD, CS, CL', ...force.map(coefficient)],
      ...dragcore.terms.map((term) => [`of these: ${term}`, ...toWind(wrench.terms[term].force).map(coefficient)]),
    ]);
    say('trial', `${body.bodyClass === 'sheet' ? 'A sheet' : `A ${body.bodyClass} body`} of ${body.triangles} triangles. ` +
        `Coefficients on ${digits(area)} m², ${body.referenceArea ? 'the reference area of its kind' : 'what faces the wind'}.`);
    // With every digit, for whoever wants to compare.
    results.dataset.force = JSON.stringify(wrench.force);
    results.dataset.torque = JSON.stringify(wrench.torque);
    results.dataset.flow = JSON.stringify(flow);

    const law = fields.law.selectedOptions[0].textContent;
    say('expected', expectedError(reynolds || 1e5, law, length(spin) > 0, boxes.every((box) => box.checked)));
    const items = validity.reasons.map((reason) => Object.assign(document.createElement('li'), {textContent: reason}));
    find('[data-list="doubts"]').replaceChildren(...items);

    if (!picture) return;
    const pressures = Array.from({length: body.triangles}, (_, i) => {
      const at = (k) => [...corners.subarray(9 * i + 3 * k, 9 * i + 3 * k + 3)];
      const [a, b, c] = [at(0), at(1), at(2)], normal = cross(plus(b, scaled(a, -1)), plus(c, scaled(a, -1)));
      return q > 0 ? -2 * dot(normal, byTriangle.subarray(3 * i, 3 * i + 3)) / (dot(normal, normal) * q) : 0;
    });
    const range = Math.max(1, ...pressures.map(Math.abs));
    const drawn = Float32Array.from(corners, (x, i) => x - body.centre[i % 3]);
    const arrows = [forceArrow({force, torque}, length(force), body.radius, colours().law, 0.05)];
    if (speed > 0) arrows.push(windArrow);
    if (length(spin) > 0) arrows.push({from: [0, 0, 0], along: scaled(spin, 1.25 / length(spin)), colour: 0xcc79a7, width: 0.03});
    picture.show(drawn, pressures.map((value) => colourOf(value, range)), rotation, body.radius, arrows);
    showScale('trial', range);
  }

  function expectedError(reynolds, law, spins, whole) {
    const known = errors.filter((row) => row.law === law && row.class === body.bodyClass && reynolds >= row.from && reynolds < row.to);
    const part = (unseen, words) => known.filter((row) => row.unseen === unseen)
        .map((row) => `${(100 * row.rms).toFixed(0)} % rms on ${row.n} ${words}`);
    const parts = [...part(false, 'cases that it may have been fitted to'), ...part(true, 'that no fit has seen')];
    if (parts.length === 0) return `No reference of this class near this Reynolds number says how wrong the ${law} is here.`;
    const where = known[0].to > 1e8 ? 'above Re 10⁴' : `from Re ${known[0].from} to ${known[0].to}`;
    return `Error of drag to expect: ${parts.join(', ')}; ${body.bodyClass} bodies ${where}, ${law}.` +
        (spins ? ' Those did not spin.' : '') + (whole ? '' : ' That is of the whole law: effects are off here.');
  }

  form.addEventListener('submit', (event) => event.preventDefault());
  form.addEventListener('input', (event) => { if (!['shape', 'file', 'unit'].includes(event.target.name)) show(); });
  fields.shape.addEventListener('change', chooseShape);
  fields.unit.addEventListener('change', () => { if (file) openFile(); });
  fields.file.addEventListener('change', () => take(fields.file.files[0]));
  const section = document.getElementById('try-it');
  section.addEventListener('dragover', (event) => event.preventDefault());
  section.addEventListener('drop', (event) => {
    event.preventDefault();
    take(event.dataTransfer.files[0]);
  });
  if (picture) onTurn(picture.canvas, (right, down) => {
    const wrapped = (angle) => ((angle + 540) % 360) - 180;
    fields.yaw.value = wrapped(Number(fields.yaw.value) + right);
    fields.incidence.value = wrapped(Number(fields.incidence.value) + down);
    show();
  }, (factor) => { picture.look.distance *= factor; picture.draw(); });
  chooseShape();
}

startPatches();
await startTrial();
document.documentElement.dataset.bodies = 'yes';
