// dragcore: force and torque of the air on rigid bodies of triangles. SI units; everything in the body's frame, turn vectors into it first.
// What the numbers mean, and how wrong they are: README.md and docs/ of the project.

export type Vector = ArrayLike<number>;  // x y z

/** A rigid body in moving air. What is left out is zero, and the density that of air. */
export interface Flow {
  wind?: Vector;             // velocity of the undisturbed air at referencePoint [m/s]
  velocity?: Vector;         // of the body there [m/s]
  angularVelocity?: Vector;  // of the body [rad/s]
  referencePoint?: Vector;   // where velocity holds and about which torque is taken: the centre of mass, say [m]
  windGradient?: Vector;     // nine numbers, row by row: 3 i + j is the change of component i along axis j [1/s]
  density?: number;          // default 1.225 [kg/m^3]
  viscosity?: number;        // dynamic, 1.8e-5 of air at 15 C; 0, the default: not known, for Re of 1e4 and more only [Pa s]
}

export type Law = 'class' | 'note' | 'consistent' | 'sheet' | 'closed';
export type Pillow = 'class' | 'none' | 'triangle' | 'patch' | 'tilt' | 'eccentricity';

/** Which law, with what. The default is what validation found best: law and pillow by the class of the body. */
export interface Model {
  law?: Law;              // default 'class'
  pillow?: Pillow;        // default 'class' where the law is, else 'none'
  pillowFactor?: number;  // of any other pillow
  effects?: string[];     // those to take into account, names as in Dragcore.effects; default: all
  quadrature?: 0 | 1 | 3 | 6;  // points per triangle where the velocity varies over it, 0 for adaptive; default 3
}

export interface Wrench {
  force: number[];   // [N]
  torque: number[];  // about referencePoint [N m]
}

export interface WrenchByTerm extends Wrench {
  terms: Record<string, Wrench>;  // what causes it, names as in Dragcore.terms; they add up to the whole
}

export interface Validity {
  inRange: boolean;   // nothing is known to make the result doubtful
  doubts: string[];   // 'spin', 'smooth body', ...
  reasons: string[];  // a sentence for each
}

/** Lives in the library's memory: free() gives that back at once, the garbage collector some time. */
export interface Held {
  free(): void;
}

/** A mesh ready for forces. Methods throw an Error that says what was found and what is needed. */
export interface Body extends Held {
  readonly bodyClass: 'sheet' | 'sharp' | 'smooth';
  readonly triangles: number;        // those with an area
  readonly area: number;             // of one side [m^2]
  readonly volume: number;           // [m^3]
  readonly centre: number[];         // centroid of the area [m]
  readonly radius: number;           // from there to the farthest corner [m]
  readonly convex: boolean;
  readonly referenceArea: number;    // of a shape's coefficients, docs/conventions.md; 0 for any other mesh [m^2]
  readonly referenceLength: number;  // [m]
  readonly notes: string[];          // what the reader and the preparation of a mesh found and changed

  /** Nine numbers for each triangle, x y z of its corners, in the order of triangleForces() [m]. */
  corners(): Float64Array;
  /** Area that faces the wind, a sum: of a body that is not convex, what stands behind something counts too [m^2]. */
  windwardArea(direction: Vector): number;

  wrench(flow: Flow, model?: Model): WrenchByTerm;
  /** Three numbers for each triangle; their sums are wrench(). */
  triangleForces(flow: Flow, model?: Model): {force: Float64Array, torque: Float64Array};
  validity(flow: Flow, model?: Model): Validity;

  /** Maps over direction that cost the same whatever the mesh: hundreds of milliseconds to make, a microsecond to use. */
  bake(model?: Model, options?: {rmsError?: number, mostBytes?: number}): BakedBody;
}

/** Of a wind that does not vary, in air whose viscosity is not given. */
export interface BakedBody extends Held {
  readonly bytes: number;
  readonly rmsForceError: number;   // of the rms force, without spin
  readonly rmsTorqueError: number;
  wrench(flow: Flow): Wrench;
}

export interface Dragcore {
  readonly laws: string[];     // besides 'class'
  readonly terms: string[];
  readonly effects: string[];

  /** 'plate', 'box', 'cube', 'cone', 'sphere', 'cylinder', 'ellipsoid', 'teardrop', 'prism'; lengths in metres, angles in degrees.
   *  What is left out keeps its default. divisions: of a side, or of a quarter turn of a round body. */
  shape(kind: string, parameters?: Record<string, number>, divisions?: number): Body;
  /** Three coordinates for each vertex, three indices for each triangle, counterclockwise from outside. It is made sound: Body.notes. */
  fromTriangles(vertices: ArrayLike<number>, triangles: ArrayLike<number>): Body;
  /** Bytes of a file; unit: 0.001 for millimetres. */
  fromStl(bytes: Uint8Array, unit?: number): Body;
  fromObj(bytes: Uint8Array, unit?: number): Body;

  /** That the library holds; it grows and never shrinks. */
  memoryBytes(): number;
}

/** Each call makes a library with a memory of its own. */
export function load(): Promise<Dragcore>;
