// The report as a reader meets it: built by the program, opened in Chromium without a network. Run by ctest from the root of the repository.
// DRAGVAL and REPORT_REFERENCES name the two programs, WASM the library for JavaScript; it is empty where there is no Emscripten.
import assert from 'node:assert/strict';
import {execFileSync, spawnSync} from 'node:child_process';
import {cpSync, existsSync, mkdirSync, mkdtempSync, rmSync, statSync, writeFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, describe, test} from 'node:test';
import {pathToFileURL} from 'node:url';

const {chromium} = createRequire(join(process.cwd(), 'compare/report/package.json'))('playwright-core');
const {DRAGVAL, REPORT_REFERENCES, WASM} = process.env;
const folder = mkdtempSync(join(tmpdir(), 'report-test-'));
const lawStore = join(folder, 'law.h5');
const chromiumPath = process.env.CHROMIUM ?? '/usr/bin/chromium';
let browser;

before(async () => {
  execFileSync(REPORT_REFERENCES, [lawStore]);
  assert.ok(existsSync(chromiumPath), `${chromiumPath} is missing; install Debian's package chromium or set CHROMIUM`);
  browser = await chromium.launchPersistentContext(join(folder, 'profile'), {
    executablePath: chromiumPath,
    viewport: {width: 1280, height: 900},
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'],
  });
});

after(async () => {
  await browser?.close();
  rmSync(folder, {recursive: true});
});

const report = (...options) => spawnSync(DRAGVAL, ['report', '--quick-cost', ...options], {encoding: 'utf8'});

function build(store, name, ...options) {
  const output = join(folder, name, 'index.html');
  const run = report('--store', store, '--output', output, ...options);
  assert.equal(run.status, 0, run.stderr);
  return output;
}

/// Opens a page and notes every complaint of the browser and every address it asks for.
/// @param prepare  runs in the page before anything of its own
async function open(file, prepare = '') {
  const page = await browser.newPage();
  const faults = [], requests = [];
  page.on('console', (message) => { if (['error', 'warning'].includes(message.type())) faults.push(message.text()); });
  page.on('pageerror', (error) => faults.push(error.message));
  page.on('request', (request) => { if (!request.url().startsWith('blob:')) requests.push(request.url()); });  // a blob is of the page itself
  await page.addInitScript(prepare);
  await page.goto(pathToFileURL(file).href);
  await page.waitForSelector('html[data-complete][data-bodies]', {state: 'attached'});
  return {page, faults, requests, file};
}

/// Text of the body cells of a table, row by row.
const rows = (page, id) => page.$$eval(`[id="${id}"] tbody tr`, (lines) => lines.map((line) => [...line.cells].map((cell) => cell.textContent)));

async function checkPage({page, faults, requests, file}) {
  assert.deepEqual(faults, [], 'the browser complained');
  assert.deepEqual(requests, [pathToFileURL(file).href], 'the page asked for more than itself');
  const plots = await page.$$eval('[data-figure]', (list) => list.map((plot) => {
    const svg = plot.querySelector('svg');
    const frame = svg?.getBoundingClientRect();
    const clipped = [...(svg?.querySelectorAll('text') ?? [])].filter((text) => {
      const box = text.getBoundingClientRect();
      // Two pixels: a glyph's box is a little larger than its ink.
      return box.width > 0 && (box.left < frame.left - 2 || box.right > frame.right + 2 || box.top < frame.top - 2 || box.bottom > frame.bottom + 2);
    });
    return {name: plot.dataset.figure, shown: plot.dataset.shown, marks: svg?.querySelectorAll('.role-mark path').length ?? 0, clipped: clipped.map((text) => text.textContent)};
  }));
  assert.ok(plots.length >= 5, `${plots.length} figures; three bodies, the face pressures and the cost are needed`);
  for (const plot of plots) {
    assert.equal(plot.shown, 'yes', plot.name);
    assert.ok(plot.marks > 5, `${plot.name} has ${plot.marks} marks`);
    assert.deepEqual(plot.clipped, [], `labels of ${plot.name} are cut off`);
  }
  const width = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(width <= 1280, `the page is ${width} px wide, 1280 are there`);
  const dangling = await page.$$eval('nav a', (links) => links.filter((link) => !document.querySelector(link.getAttribute('href'))).map((link) => link.textContent));
  assert.deepEqual(dangling, []);
  assert.equal(await page.locator('nav a').count(), await page.locator('main > section').count());
  const text = await page.locator('main').innerText();
  assert.doesNotMatch(text, /\b(nan|inf|undefined|null)\b/i, 'a number is missing');
}

describe('references made by a law with scale 0.9 and base suction 0.3', () => {
  let opened;
  before(async () => {
    opened = await open(build(lawStore, 'law'));
  });

  test('the page opens without a fault, a request or a clipped label', () => checkPage(opened));

  test('drag is drawn against the Reynolds number, four bodies with their law, correlations and published values', async () => {
    const words = await opened.page.$$eval('[data-figure="drag_against_reynolds"] text', (list) => list.map((text) => text.textContent));
    for (const word of ['C_D, ball', 'C_D, cube, face-on', 'C_D, disc, face-on', 'C_D, plate at 30°', 'drag crisis', 'Ganser', 'law by class', 'published'])
      assert.ok(words.includes(word), `${word} is missing among ${words}`);
  });

  test('the plate normal to the flow has C_D 1.02 (0.9 + 0.3), the note says 1', async () => {
    const table = await rows(opened.page, 'errors-plate-Re-100000-k-omega-sst-C_D');
    assert.equal(table.length, 7);
    const normal = table.find((row) => row[0] === '90°');
    // OpenFOAM ± u (0.010 of the run, 4 % of the method), published, then value, error and percentage of the note's law.
    assert.deepEqual(normal.slice(1, 6), ['1.224 ± 0.050*', '1.170', '1.000', '−0.224', '−18\u2009%']);
  });

  test('the calibrated law is right within the noise, the note\'s is not', async () => {
    const verdict = await rows(opened.page, 'verdict-table');
    assert.equal(verdict.length, 5);  // cone, cube and plate; plate of span 2 and sphere at Re 100
    for (const row of verdict) {
      assert.ok(Number(row[2]) > 0.1, `note's law on ${row[0]}: rms ${row[2]}`);
      // The finest mesh of one cube is nearer to the truth by 0.02 (1 - 3^(-2/3)) of its C_D than the others.
      assert.ok(Number(row[5]) < 0.01, `calibrated law on ${row[0]}: rms ${row[5]}`);
    }
  });

  test('a diverged case keeps its row, with its reason', async () => {
    for (const channel of ['C_D', 'C_L', 'C_m']) {
      const table = await rows(opened.page, `errors-cone-Re-100000-k-omega-sst-${channel}`);
      assert.equal(table.length, 7);
      assert.deepEqual(table.find((row) => row[0] === '150°'), ['150°', 'diverged: C_D -2e4 after 37 iterations <seeded>']);
    }
  });

  test('the figure of the cone has a line per law, a point per usable case and one published value', async () => {
    const plot = opened.page.locator('[data-figure="sweep-cone-Re-100000-k-omega-sst"]');
    // Four laws in C_D and C_L; in C_m also patch and tilt pillow on two of them, and tilt on the laws by class.
    assert.equal(await plot.locator('.mark-line.role-mark path').count(), 4 + 4 + 9);
    assert.equal(await plot.locator('.mark-symbol.role-mark path').count(), 3 * 6 + 1);
    assert.equal(await plot.locator('.mark-rule.role-mark line').count(), 3 * 6);
  });

  /// How many pixels of a canvas have another colour than its ground, and how many of these are orange and blue.
  const inked = (page, view) => page.$eval(`[data-view="${view}"]`, (canvas) => {
    const copy = document.createElement('canvas');
    [copy.width, copy.height] = [canvas.width, canvas.height];
    const context = copy.getContext('2d');
    context.drawImage(canvas, 0, 0);
    const {data} = context.getImageData(0, 0, copy.width, copy.height);
    const count = {all: 0, orange: 0, blue: 0, sum: 0, pixels: data.length / 4};
    for (let i = 0; i < data.length; i += 4) {
      if (data[i + 3] === 0) continue;
      ++count.all;
      if (data[i] > data[i + 2] + 40) ++count.orange;
      if (data[i + 2] > data[i] + 40) ++count.blue;
      count.sum = (count.sum * 31 + data[i] + 256 * data[i + 1] + 65536 * data[i + 2]) % 2147483647;
    }
    return count;
  });

  test('both pictures of the surface pressure are drawn, and the keys turn them', async () => {
    const {page} = opened;
    for (const view of ['reference', 'law']) {
      const before = await inked(page, view);
      assert.ok(before.all > 0.05 * before.pixels, `${view}: ${before.all} of ${before.pixels} pixels drawn`);
      assert.ok(before.orange > 500 && before.blue > 500, `${view}: pressure, and the arrow of the law; ${JSON.stringify(before)}`);
      await page.locator(`[data-view="${view}"]`).focus();
      await page.keyboard.press('ArrowLeft');
      assert.notEqual((await inked(page, view)).sum, before.sum, view);
    }
  });

  test('beside the pictures stand the coefficients of body and pose that are chosen, as the table of errors has them', async () => {
    const {page} = opened;
    await page.locator('[data-controls="patches"] [name=flow]').selectOption({label: 'plate at Re 10\u2075, k-\u03c9 SST'});
    await page.locator('[data-controls="patches"] [name=pose]').selectOption({label: 'incidence 90\u00b0'});
    await page.locator('[data-controls="patches"] [name=law]').selectOption({label: "note's law"});
    const [drag] = await rows(page, 'patch-forces');
    assert.deepEqual(drag, ['CD', '1.224 \u00b1 0.050', '1.000', '\u22120.224']);
  });

  const trial = {skip: WASM ? false : 'the build has no Emscripten'};
  const resultsOf = (page) => page.$eval('#trial-forces', ({dataset}) => ({force: JSON.parse(dataset.force), torque: JSON.parse(dataset.torque), flow: JSON.parse(dataset.flow)}));

  test('the library in the page gives a dropped STL file what the program gives it', trial, async () => {
    const {page} = opened;
    // A wedge of unequal sides, so that no component is zero; in millimetres, which the page guesses.
    const corners = [[0, 0, 0], [1200, 0, 0], [0, 900, 0], [100, 200, 700]];
    const facet = (a, b, c) => `facet normal 0 0 0\nouter loop\n${[a, b, c].map((i) => 'vertex ' + corners[i].join(' ')).join('\n')}\nendloop\nendfacet\n`;
    const stl = `solid wedge\n${facet(0, 2, 1)}${facet(0, 1, 3)}${facet(1, 2, 3)}${facet(2, 0, 3)}endsolid wedge\n`;
    const file = join(folder, 'wedge.stl');
    writeFileSync(file, stl);
    const transfer = await page.evaluateHandle((text) => {
      const given = new DataTransfer();
      given.items.add(new File([text], 'wedge.stl'));
      return given;
    }, stl);
    await page.dispatchEvent('#try-it', 'drop', {dataTransfer: transfer});
    await page.waitForFunction(() => document.querySelector('[data-text=library]').textContent.startsWith('wedge.stl: 4 triangles, read in millimetres'));

    const form = page.locator('[data-controls="trial"]');
    const set = (name, value) => form.locator(`[name=${name}]`).fill(String(value));
    for (const [name, value] of Object.entries({speed: 12, incidence: 35, yaw: -20, roll: 10, spin_x: 1, spin_y: -2, spin_z: 4})) await set(name, value);
    for (const [law, reynolds] of [['class', '0'], ['note', '0'], ['consistent', '0'], ['class', '100']]) {
      await form.locator('[name=law]').selectOption(law);
      await form.locator('[name=reynolds]').selectOption(reynolds);
      const found = await resultsOf(page);
      const run = JSON.parse(execFileSync(DRAGVAL, ['drag', file, '--unit', 'mm', '--law', law, '--wind', ...found.flow.wind.map(String), '--spin', ...found.flow.angularVelocity.map(String),
        '--centre', ...found.flow.referencePoint.map(String), '--viscosity', String(found.flow.viscosity), '--density', String(found.flow.density), '--format', 'json'], {encoding: 'utf8'}));
      const [row] = run.rows;
      const size = Math.hypot(...row.force_N);
      assert.ok(size > 1, `${size} N`);
      // The kernels of the native program sum in single precision within blocks: 1e-6 of the dynamic pressure times the area.
      for (let k = 0; k < 3; ++k) {
        assert.ok(Math.abs(found.force[k] - row.force_N[k]) < 1e-6 * size, `${law}: ${found.force} N, natively ${row.force_N}`);
        assert.ok(Math.abs(found.torque[k] - row.torque_N_m[k]) < 1e-6 * size, `${law}: ${found.torque} N m, natively ${row.torque_N_m}`);
      }
    }
  });

  test('a body is turned by keys on its picture, and what is known of its force changes with it', trial, async () => {
    const {page} = opened;
    const form = page.locator('[data-controls="trial"]');
    for (const name of ['spin_x', 'spin_y', 'spin_z', 'incidence', 'yaw', 'roll']) await form.locator(`[name=${name}]`).fill('0');
    await form.locator('[name=shape]').selectOption('plate');
    await form.locator('[name=law]').selectOption('class');
    await form.locator('[name=reynolds]').selectOption('0');
    const edgeOn = await page.locator('[data-list=doubts]').innerText();
    assert.match(edgeOn, /edge-on/);
    const before = await resultsOf(page), picture = await inked(page, 'trial');
    assert.ok(picture.all > 0.03 * picture.pixels, JSON.stringify(picture));
    await page.locator('[data-view="trial"]').focus();
    for (let i = 0; i < 6; ++i) await page.keyboard.press('ArrowDown');
    assert.equal(await form.locator('[name=incidence]').inputValue(), '30');
    const after = await resultsOf(page);
    assert.ok(Math.hypot(...after.force) > 3 * Math.hypot(...before.force));
    assert.match(await page.locator('[data-list=doubts]').innerText(), /17 and 48/);
    assert.match(await page.locator('[data-text=expected]').innerText(), /Error of drag to expect: \d+ % rms on \d+ cases/);
    await form.locator('[name=effect][value="friction"]').uncheck();
    assert.match(await page.locator('[data-text=expected]').innerText(), /effects are off/);
    assert.ok(Math.hypot(...(await resultsOf(page)).force) < Math.hypot(...after.force));
    await form.locator('[name=effect][value="friction"]').check();
  });

  test('a file that is no mesh is refused in words, and the body before stays', trial, async () => {
    const {page} = opened;
    const before = await resultsOf(page);
    await page.setInputFiles('[data-controls="trial"] [name=file]', {name: 'letter.stl', mimeType: 'model/stl', buffer: Buffer.from('Dear reader')});
    await page.waitForFunction(() => document.querySelector('[data-text=library]').textContent.startsWith('letter.stl: dragcore: '));
    assert.deepEqual((await resultsOf(page)).force, before.force);
    assert.deepEqual(opened.faults, [], 'the browser complained');
  });

  test('on a phone nothing of both sections is wider than the screen, and pictures stack', async () => {
    const {page} = opened;
    await page.setViewportSize({width: 390, height: 800});
    const boxes = await page.$$eval('#three-d canvas', (list) => list.map((canvas) => canvas.getBoundingClientRect().toJSON()));
    assert.ok(boxes[1].top >= boxes[0].bottom, 'one under the other');
    const wide = await page.$$eval('#three-d *, #try-it *', (list) => list.filter((part) => !part.closest('.wide') && part.getBoundingClientRect().right > 391).map((part) => part.outerHTML.slice(0, 80)));
    assert.deepEqual(wide, []);
    await page.setViewportSize({width: 1280, height: 900});
  });

  test('without WebGL words stand in place of the pictures, and the numbers are there', async () => {
    const without = await open(opened.file, () => { HTMLCanvasElement.prototype.getContext = () => null; });
    assert.deepEqual(without.faults, []);
    assert.equal(await without.page.locator('canvas.view').count(), 0);
    assert.match(await without.page.locator('#three-d').innerText(), /no WebGL/);
    assert.equal((await rows(without.page, 'patch-forces')).length, 6);
    if (WASM) assert.ok((await rows(without.page, 'trial-forces')).length > 3);
    await without.page.close();
  });

  test('all bodies of the note\'s table are there, and the calibration gives the coefficients back', async () => {
    const bodies = (await rows(opened.page, 'note-table')).map((row) => row[0]);
    assert.deepEqual(bodies, ['Ball', 'Cube', 'Cube at 45 deg', 'Cone', 'Teardrop']);
    const [scale, suction] = await rows(opened.page, 'estimates-table');
    // Meshes of 12,000 cells are 2 % high.
    assert.ok(Math.abs(Number(scale[4]) - 1.02 * 0.9) < 0.01, scale.join(' '));
    assert.ok(Math.abs(Number(suction[4]) - 1.02 * 0.3) < 0.01, suction.join(' '));
  });
});

test('the page of the committed references has every one of their cases', async () => {
  const store = 'results/reference.h5';
  assert.ok(existsSync(store), `${store} is part of the repository`);
  const opened = await open(build(store, 'committed'));
  await checkPage(opened);
  const size = statSync(opened.file).size;
  assert.ok(size <= 6e6, `${size} bytes; 6 MB is what a letter carries`);
  const table = JSON.parse(execFileSync(DRAGVAL, ['compare', '--store', store, '--format', 'json', '--output', ''], {encoding: 'utf8', maxBuffer: 1 << 26}));
  const {page} = opened;
  const expected = new Set(table.rows.map((row) => row.case));
  assert.ok(expected.size >= 100, `${expected.size} cases`);
  // On a sweep, or beside the sweeps with its whole name: the first cell of a row says which case it is.
  const shown = new Set(await page.$$eval('[id^="errors-"][id$="-C_D"] tbody td:first-child, [id$="-other"] tbody td:first-child', (cells) => cells.map((cell) => cell.title)));
  assert.deepEqual([...shown].sort(), [...expected].sort());

  // The cube by yaw: side force and yawing moment, seven poses; its lift belongs to the poses of other incidence, which are not among them.
  const cube = 'errors-cube-Re-100000-k-omega-sst';
  for (const channel of ['C_D', 'C_S', 'C_n']) {
    const angles = (await rows(page, `${cube}-${channel}`)).map((row) => row[0].replace(' held out', ''));
    assert.deepEqual(angles, ['0°', '7.5°', '15°', '22.5°', '30°', '37.5°', '45°'], channel);
  }
  for (const channel of ['C_L', 'C_m']) assert.equal(await page.locator(`[id="${cube}-${channel}"]`).count(), 0, channel);
  const others = await rows(page, `${cube}-other`);
  assert.deepEqual(others.map((row) => row[0]).filter((name) => name), ['cube_incidence-030_yaw-020_roll-010_re-1e5_fine']);
  assert.deepEqual(others.map((row) => row[2]), ['CD', 'CL', 'Cm', 'CS', 'Cn']);
  // The law by class has two thirds too little side force at 30 degrees of yaw, and none of the moment: both in plain sight.
  const lawByClass = (await rows(page, `${cube}-C_S`)).find((row) => row[0] === '30°');
  assert.ok(lawByClass.includes('−65\u2009%'), lawByClass.join(' '));
  const moments = await rows(page, 'moment-table');
  assert.deepEqual(moments.filter((row) => row[0] === 'cube at Re 10⁵, k-ω SST').map((row) => row[1]), ['Cn']);
});

test('without the library for JavaScript the page says how to make it', async () => {
  const opened = await open(build(lawStore, 'without-library', '--wasm', join(folder, 'no-such.mjs')));
  await checkPage(opened);
  assert.match(await opened.page.locator('#try-it').innerText(), /apt-get install emscripten/);
});

test('without a usable case nothing is written and the exit code is 5', () => {
  const store = join(folder, 'failed.h5'), output = join(folder, 'failed.html');
  execFileSync(REPORT_REFERENCES, [store, 'failed']);
  const run = report('--store', store, '--output', output);
  assert.equal(run.status, 5, run.stderr);
  assert.match(run.stderr, /dragval run/);
  assert.ok(!existsSync(output));
});

test('without the figure libraries the exit code is 3 and the message says how to get them', () => {
  const assets = join(folder, 'assets');
  mkdirSync(assets);
  for (const file of ['page.html', 'style.css', 'show.js', 'bodies.html', 'bodies.js']) cpSync(join('compare/report', file), join(assets, file));
  const run = report('--store', lawStore, '--output', join(folder, 'none.html'), '--assets', assets);
  assert.equal(run.status, 3, run.stderr);
  assert.match(run.stderr, /vega\.min\.js is missing.*npm ci --prefix compare\/report/);
});
