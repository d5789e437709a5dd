// The report as a reader meets it: built by the program, opened in Chromium without a network. Run by ctest from the root of the repository.
// DRAGVAL and REPORT_REFERENCES name the two programs.
import assert from 'node:assert/strict';
import {execFileSync, spawnSync} from 'node:child_process';
import {cpSync, existsSync, mkdirSync, mkdtempSync, rmSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, describe, test} from 'node:test';
import {pathToFileURL} from 'node:url';

const {chromium} = createRequire(join(process.cwd(), 'compare/report/package.json'))('playwright-core');
const {DRAGVAL, REPORT_REFERENCES} = process.env;
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
    args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'],
  });
});

after(async () => {
  await browser?.close();
  rmSync(folder, {recursive: true});
});

const report = (...options) => spawnSync(DRAGVAL, ['report', '--quick-cost', ...options], {encoding: 'utf8'});

function build(store, name) {
  const output = join(folder, name, 'index.html');
  const run = report('--store', store, '--output', output);
  assert.equal(run.status, 0, run.stderr);
  return output;
}

/// Opens a page and notes every complaint of the browser and every address it asks for.
async function open(file) {
  const page = await browser.newPage();
  const faults = [], requests = [];
  page.on('console', (message) => { if (['error', 'warning'].includes(message.type())) faults.push(message.text()); });
  page.on('pageerror', (error) => faults.push(error.message));
  page.on('request', (request) => requests.push(request.url()));
  await page.goto(pathToFileURL(file).href);
  await page.waitForSelector('html[data-complete]', {state: 'attached'});
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
  const table = JSON.parse(execFileSync(DRAGVAL, ['compare', '--store', store, '--format', 'json', '--output', ''], {encoding: 'utf8'}));
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
  for (const file of ['page.html', 'style.css', 'show.js']) cpSync(join('compare/report', file), join(assets, file));
  const run = report('--store', lawStore, '--output', join(folder, 'none.html'), '--assets', assets);
  assert.equal(run.status, 3, run.stderr);
  assert.match(run.stderr, /vega\.min\.js is missing.*npm ci --prefix compare\/report/);
});
