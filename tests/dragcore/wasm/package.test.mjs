// The package for JavaScript against the program: the same STL files, winds, laws, spins and viscosities through both. Run by ctest.
// DRAGVAL names the program, PACKAGE the folder.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, test} from 'node:test';
import {pathToFileURL} from 'node:url';

const {DRAGVAL, PACKAGE} = process.env;
const {load} = await import(pathToFileURL(join(PACKAGE, 'dragcore.mjs')).href);
const dragcore = await load();
const folder = mkdtempSync(join(tmpdir(), 'dragcore-package-'));
after(() => rmSync(folder, {recursive: true}));

/// An ascii STL file with every digit: both sides then read the same numbers.
function stlOf(corners) {
  let text = 'solid body\n';
  for (let i = 0; i < corners.length; i += 9) {
    text += 'facet normal 0 0 0\nouter loop\n';
    for (let k = 0; k < 9; k += 3) text += `vertex ${corners[i + k]} ${corners[i + k + 1]} ${corners[i + k + 2]}\n`;
    text += 'endloop\nendfacet\n';
  }
  return new TextEncoder().encode(text + 'endsolid body\n');
}

const norm = (v) => Math.hypot(...v);
const difference = (a, b) => norm(a.map((x, k) => x - b[k]));

// Sheets, sharp and round bodies; one without thickness, and one small.
const bodies = [
  ['cube', {side: 1}], ['plate', {chord: 1, span: 2}], ['plate', {thickness: 0}], ['cone', {}, 8], ['sphere', {diameter: 0.02}, 8],
  ['cylinder', {length: 3}, 8], ['teardrop', {}, 8], ['prism', {}],
];

// The native program has kernels, which sum in single precision within a block of triangles: within 1e-6 of the dynamic pressure times the
// area of both sides. What another compiler and libm make of the same formulas is far below that.
const tolerance = 1e-6;

for (const [kind, parameters, divisions] of bodies)
  test(`${kind} ${JSON.stringify(parameters)}: force and torque as the program has them`, () => {
    const shape = dragcore.shape(kind, parameters, divisions);
    const bytes = stlOf(shape.corners()), file = join(folder, 'body.stl');
    shape.free();
    writeFileSync(file, bytes);
    const body = dragcore.fromStl(bytes);
    for (const law of ['class', 'note', 'consistent'])
      for (const [viscosity, angularVelocity] of [[0, [0, 0, 0]], [0, [3, -7, 20]], [0.05, [3, -7, 20]]]) {
        const run = JSON.parse(execFileSync(DRAGVAL, [
          'drag', file, '--law', law, '--sweep', 'incidence', '0:180:20', '--yaw', '25', '--speed', '10', '--centre', '0.1', '0', '0',
          '--viscosity', String(viscosity), '--spin', ...angularVelocity.map(String), '--format', 'json'], {encoding: 'utf8'}));
        assert.equal(run.rows.length, 10);
        assert.ok(norm(run.rows[3].force_N) > 0);
        for (const row of run.rows) {
          const flow = {wind: row.wind_m_s, angularVelocity, referencePoint: [0.1, 0, 0], viscosity};
          const found = body.wrench(flow, {law});
          const speed = 10 + norm(angularVelocity) * body.radius;
          const scale = 0.5 * 1.225 * speed ** 2 * 2 * body.area * (viscosity > 0 ? 1 + 24 * viscosity / (speed * body.radius) : 1);
          assert.ok(difference(found.force, row.force_N) < tolerance * scale, `${law}: ${found.force} N, natively ${row.force_N}`);
          const arm = body.radius + 0.1;
          assert.ok(difference(found.torque, row.torque_N_m) < tolerance * scale * arm, `${law}: ${found.torque} N m, natively ${row.torque_N_m}`);
        }
      }
    body.free();
  });

test('the forces of terms and of triangles add up to the whole', () => {
  const body = dragcore.shape('cylinder', {length: 2}, 8);
  const flow = {wind: [8, 3, -2], velocity: [-1, 0, 2], angularVelocity: [1, 2, 3], viscosity: 1e-3};
  const whole = body.wrench(flow);
  const sum = (vectors) => [0, 1, 2].map((k) => vectors.reduce((all, v) => all + v[k], 0));
  const {force, torque} = body.triangleForces(flow);
  assert.equal(force.length, 3 * body.triangles);
  const triangles = (numbers) => Array.from({length: body.triangles}, (_, i) => [...numbers.subarray(3 * i, 3 * i + 3)]);
  for (const [parts, total] of [[triangles(force), whole.force], [triangles(torque), whole.torque]])
    assert.ok(difference(sum(parts), total) < 1e-12 * norm(whole.force), 'rounding of as many sums');
  const terms = Object.values(whole.terms);
  assert.equal(terms.length, dragcore.terms.length);
  assert.ok(difference(sum(terms.map((term) => term.force)), whole.force) < 1e-12 * norm(whole.force));
  body.free();
});

test('what an effect adds is gone without it', () => {
  const body = dragcore.shape('plate');
  const flow = {wind: [8, 0, 3]};
  const without = (name) => dragcore.effects.filter((effect) => effect !== name);
  const pillow = difference(body.wrench(flow).torque, body.wrench(flow, {effects: without('pillow')}).torque);
  assert.ok(pillow > 0.1, `the pillow moves the force of a plate: ${pillow} N m`);
  const {terms} = body.wrench(flow, {effects: without('base suction')});
  assert.equal(norm(terms['base suction'].force), 0);
  body.free();
});

test('a mesh with faults is mended, with words on what was found', () => {
  // A cube of which one triangle is wound the wrong way round.
  const vertices = [0, 1].flatMap((x) => [0, 1].flatMap((y) => [0, 1].flatMap((z) => [x, y, z])));
  const triangles = [0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 3, 7];
  const body = dragcore.fromTriangles(vertices, triangles);
  assert.equal(body.bodyClass, 'sharp');
  assert.ok(Math.abs(body.volume - 1) < 1e-12);
  assert.match(body.notes.join('\n'), /reversed/);
  body.free();
});

test('what cannot be is refused with a sentence, and no memory is lost', () => {
  const refused = (act, words) => assert.throws(act, (fault) => words.test(fault.message), String(words));
  const body = dragcore.shape('cube');
  refused(() => dragcore.shape('cubee'), /did you mean cube/);
  refused(() => dragcore.shape('cube', {side: -1}), /must be/);
  refused(() => dragcore.fromStl(new Uint8Array(0)), /empty/);
  refused(() => dragcore.fromStl(new TextEncoder().encode('no mesh at all')), /it is no STL file/);
  refused(() => dragcore.fromTriangles([0, 0, 0], [0, 1, 2]), /refers to vertex 1,/);
  refused(() => body.wrench({wind: [10, 0]}), /wind has 2 numbers, 3 are needed/);
  refused(() => body.wrench({win: [10, 0, 0]}), /no 'win'; known: wind/);
  refused(() => body.wrench({wind: [NaN, 0, 0]}), /wind/);
  refused(() => body.wrench({wind: [1, 0, 0]}, {law: 'clas'}), /clas/);
  refused(() => body.wrench({wind: [1, 0, 0]}, {effects: ['magic']}), /no effect 'magic'/);
  refused(() => body.wrench({wind: [1, 0, 0]}, {quadrature: 2}), /quadrature = 2/);
  assert.ok(body.wrench({wind: [10, 0, 0]}).force[0] > 0, 'it goes on after faults');
  body.free();
  refused(() => body.wrench({wind: [10, 0, 0]}), /used after free/);
  body.free();
});

test('a thousand bodies made and given back need no more memory than ten', async () => {
  const one = await load();
  const make = (count) => {
    for (let i = 0; i < count; ++i) {
      const body = one.shape('sphere', {}, 16);
      body.wrench({wind: [i, 1, 0]});
      body.free();
    }
  };
  make(10);
  const before = one.memoryBytes();
  make(1000);
  assert.equal(one.memoryBytes(), before);
});

test('a baked body is as near as its maps say', () => {
  const body = dragcore.shape('cube');
  const baked = body.bake();
  assert.ok(baked.bytes > 0 && baked.rmsForceError <= 0.01);
  const flow = {wind: [9, 2, -3]};
  const exact = body.wrench(flow).force;
  // Four times the rms: one direction is not the worst, but may be worse than most.
  assert.ok(difference(baked.wrench(flow).force, exact) < 4 * baked.rmsForceError * norm(exact));
  baked.free();
  body.free();
});

test('the folder is one that npm can pack: every file that it names is there', () => {
  const description = JSON.parse(readFileSync(join(PACKAGE, 'package.json'), 'utf8'));
  assert.equal(description.name, 'dragcore');
  for (const file of description.files) assert.ok(readFileSync(join(PACKAGE, file)).length > 100, file);
  const code = readFileSync(join(PACKAGE, 'dragcore.mjs'), 'utf8');
  assert.ok(code.length < 1e6, `${code.length} bytes; a page that holds it is to stay small`);
  assert.doesNotMatch(code, /<\/script/i, 'it goes into pages as it is');
});
