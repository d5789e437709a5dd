// The library for JavaScript, appended to what Emscripten makes of it. dragcore.d.ts says what everything means.

const flowOrder = ['wind', 'velocity', 'angularVelocity', 'referencePoint', 'windGradient'];

/// Compiles the library, once for each call: 10 ms or so.
export async function load() {
  const wasm = await dragcore_module();

  /// Runs `use` with a place in the library's memory for each argument: text, arrays of numbers or bytes, or a number of bytes to be left
  /// as they are. All are given back at the end, whatever happens.
  function withMemory(arguments_, use) {
    const places = [];
    try {
      for (const given of arguments_) {
        const bytes = typeof given === 'number' ? null
            : typeof given === 'string'         ? new TextEncoder().encode(given + '\0')
                                                : new Uint8Array(given.buffer, given.byteOffset, given.byteLength);
        const place = wasm._malloc(Math.max(1, bytes?.length ?? given));
        if (!place) throw new RangeError('dragcore: out of memory');
        places.push(place);
        if (bytes) wasm.HEAPU8.set(bytes, place);
      }
      return use(...places);
    } finally {
      for (const place of places) wasm._free(place);
    }
  }

  const said = () => {
    const start = wasm._web_said();
    return new TextDecoder().decode(wasm.HEAPU8.subarray(start, wasm.HEAPU8.indexOf(0, start)));
  };
  const saidLines = () => said().split('\n').slice(0, -1);
  /// What a call came back with, or, where that is 0, its fault.
  function checked(result) {
    if (result) return result;
    throw new Error('dragcore: ' + said());
  }
  const numbersAt = (place, count) => new Float64Array(wasm.HEAPU8.buffer, place, count).slice();
  /// The numbers that a function writes to its last argument.
  const numbersOf = (count, call, ...given) => withMemory([8 * count, ...given], (out, ...places) => {
    call(out, ...places);
    return numbersAt(out, count);
  });

  wasm._web_words();
  const [laws, terms, effects] = said().trimEnd().split('\n\n').map((list) => list.split('\n'));

  function known(given, names, what) {
    for (const name of Object.keys(given))
      if (!names.includes(name)) throw new TypeError(`dragcore: ${what} has no '${name}'; known: ${names.join(', ')}`);
  }

  function flowNumbers(flow) {
    known(flow, [...flowOrder, 'density', 'viscosity'], 'a flow');
    const numbers = flowOrder.flatMap((name) => {
      const count = name === 'windGradient' ? 9 : 3;
      const given = flow[name] ?? new Array(count).fill(0);
      if (given.length !== count) throw new TypeError(`dragcore: ${name} has ${given.length} numbers, ${count} are needed`);
      return [...given];
    });
    return new Float64Array([...numbers, flow.density ?? 1.225, flow.viscosity ?? 0]);
  }

  /// Calls `use` with the address of a struct ModelChoice.
  function withModel(model, use) {
    known(model, ['law', 'pillow', 'pillowFactor', 'effects', 'quadrature'], 'a model');
    let bits = 0;
    for (const effect of model.effects ?? effects) {
      if (!effects.includes(effect)) throw new TypeError(`dragcore: no effect '${effect}'; known: ${effects.join(', ')}`);
      bits |= 1 << effects.indexOf(effect);
    }
    const law = model.law ?? 'class';
    return withMemory([law, model.pillow ?? (law === 'class' ? 'class' : 'none'), 24], (lawPlace, pillowPlace, choice) => {
      const view = new DataView(wasm.HEAPU8.buffer, choice, 24);
      view.setUint32(0, lawPlace, true);
      view.setUint32(4, pillowPlace, true);
      view.setFloat64(8, model.pillowFactor ?? 0, true);
      view.setUint32(16, bits, true);
      view.setInt32(20, model.quadrature ?? 3, true);
      return use(choice);
    });
  }

  // Who forgets free() leaks until the collector comes by.
  const forgotten = new FinalizationRegistry(([destroy, handle]) => destroy(handle));

  /// Something that lives in the library's memory.
  class Held {
    #handle;
    #destroy;
    constructor(handle, destroy) {
      this.#handle = handle;
      this.#destroy = destroy;
      forgotten.register(this, [destroy, handle], this);
    }
    get handle() {
      if (!this.#handle) throw new Error('dragcore: used after free()');
      return this.#handle;
    }
    free() {
      if (!this.#handle) return;
      forgotten.unregister(this);
      this.#destroy(this.#handle);
      this.#handle = 0;
    }
  }

  class Body extends Held {
    constructor(handle) {
      super(checked(handle), wasm._web_body_destroy);
      const n = numbersOf(10, (out) => wasm._web_body_numbers(this.handle, out));
      [this.triangles, this.area, this.volume] = n;
      this.centre = [...n.subarray(3, 6)];
      [this.radius, , this.referenceArea, this.referenceLength] = n.subarray(6);
      this.convex = n[7] === 1;
      wasm._web_body_class(this.handle);
      this.bodyClass = said();
      wasm._web_body_notes(this.handle);
      this.notes = saidLines();
    }

    corners() {
      return numbersOf(9 * this.triangles, (out) => wasm._web_body_corners(this.handle, out));
    }

    windwardArea(direction) {
      return withMemory([new Float64Array(direction)], (place) => wasm._web_windward_area(this.handle, place));
    }

    wrench(flow, model = {}) {
      const numbers = withModel(model, (choice) => numbersOf(6 * terms.length,
          (out, given) => checked(wasm._web_wrench_by_term(this.handle, given, choice, out)), flowNumbers(flow)));
      const result = {force: [0, 0, 0], torque: [0, 0, 0], terms: {}};
      terms.forEach((term, i) => {
        const force = [...numbers.subarray(6 * i, 6 * i + 3)], torque = [...numbers.subarray(6 * i + 3, 6 * i + 6)];
        result.terms[term] = {force, torque};
        for (let k = 0; k < 3; ++k) {
          result.force[k] += force[k];
          result.torque[k] += torque[k];
        }
      });
      return result;
    }

    triangleForces(flow, model = {}) {
      const count = 3 * this.triangles;
      const numbers = withModel(model, (choice) => numbersOf(2 * count,
          (out, given) => checked(wasm._web_forces_by_triangle(this.handle, given, choice, out)), flowNumbers(flow)));
      return {force: numbers.subarray(0, count), torque: numbers.subarray(count)};
    }

    validity(flow, model = {}) {
      withModel(model, (choice) => withMemory([flowNumbers(flow)], (given) => checked(wasm._web_doubts(this.handle, given, choice))));
      const lines = saidLines(), middle = lines.indexOf('');
      return {inRange: middle === 0, doubts: lines.slice(0, middle), reasons: lines.slice(middle + 1)};
    }

    bake(model = {}, {rmsError = 0.01, mostBytes = 65536} = {}) {
      return new BakedBody(withModel(model, (choice) => wasm._web_bake(this.handle, choice, rmsError, mostBytes)));
    }
  }

  class BakedBody extends Held {
    constructor(handle) {
      super(checked(handle), wasm._web_baked_destroy);
      [this.bytes, this.rmsForceError, this.rmsTorqueError] = numbersOf(3, (out) => wasm._web_baked_numbers(this.handle, out));
    }

    wrench(flow) {
      const n = numbersOf(6, (out, given) => checked(wasm._web_baked_wrench(this.handle, given, out)), flowNumbers(flow));
      return {force: [...n.subarray(0, 3)], torque: [...n.subarray(3)]};
    }
  }

  const roundBodies = ['cone', 'sphere', 'cylinder', 'ellipsoid', 'teardrop'];
  const fromFile = (bytes, isObj, unit) =>
      withMemory([bytes], (place) => new Body(wasm._web_body_of_file(place, bytes.byteLength, isObj, unit)));
  return {
    laws,
    terms,
    effects,
    shape(kind, parameters = {}, divisions = roundBodies.includes(kind) ? 32 : 2) {
      const names = Object.keys(parameters).map((name) => name + '\n').join('');
      return withMemory([kind, names, new Float64Array(Object.values(parameters))],
          (...places) => new Body(wasm._web_body_of_shape(...places, divisions)));
    },
    fromTriangles(vertices, triangles) {
      return withMemory([new Float64Array(vertices), new Int32Array(triangles)], (vertexPlace, trianglePlace) => new Body(
          wasm._web_body_of_triangles(vertexPlace, Math.floor(vertices.length / 3), trianglePlace, Math.floor(triangles.length / 3))));
    },
    memoryBytes: () => wasm.HEAPU8.byteLength,
    fromStl: (bytes, unit = 1) => fromFile(bytes, 0, unit),
    fromObj: (bytes, unit = 1) => fromFile(bytes, 1, unit),
  };
}
