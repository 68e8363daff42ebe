// Reads the data of a run: see run.rs, frame.rs, pieces.rs and points.rs.

// Reads packed words: differences, zigzag-encoded, the lowest bytes of all words first.
function readWords(bytes, at, count) {
  const words = new Uint32Array(count);
  let before = 0;
  for (let i = 0; i < count; i++) {
    let word = 0;
    for (let byte = 0; byte < 4; byte++) word |= bytes[at + byte * count + i] << (8 * byte);
    before = (before + ((word >>> 1) ^ -(word & 1))) | 0;
    words[i] = before;
  }
  return words;
}

const MESH_VALUES = 65535,
  LATTICE_VALUES = 4095;

// A set of points in all frames.
class PointSet {
  // `points` is their number while no body is broken, `largest` the largest value of a coordinate.
  constructor(points, frames, largest) {
    this.points = points;
    this.largest = largest;
    this.bounds = new Float32Array(6 * frames);
    // For each frame, the coordinates of its points as numbers of steps of its grid.
    this.values = [];
    this.last = [];
    this.secondLast = [];
  }

  // Unpacks the values of `count` points of the next frame.
  unpack(frame, count, bytes, at) {
    const high = at + 3 * count,
      { last, secondLast } = this;
    const [low, step] = this.grid(frame);
    const values = new Uint16Array(3 * count),
      positions = new Float64Array(3 * count);
    for (let axis = 0; axis < 3; axis++) {
      let error = 0;
      for (let point = 0; point < count; point++) {
        const k = axis * count + point,
          i = 3 * point + axis;
        const word = bytes[at + k] | (bytes[high + k] << 8);
        error = (error + ((word >>> 1) ^ -(word & 1))) & 65535;
        let predicted = 0;
        if (i < last.length && step[axis] > 0) {
          const next = i < secondLast.length ? last[i] + (last[i] - secondLast[i]) : last[i];
          predicted = Math.min(Math.max(Math.floor((next - low[axis]) / step[axis] + 0.5), 0), this.largest);
        }
        const value = (predicted + error) & 65535;
        values[i] = value;
        positions[i] = low[axis] + value * step[axis];
      }
    }
    this.values[frame] = values;
    this.secondLast = last;
    this.last = positions;
  }

  // Returns the smallest coordinates and the steps of the grid of a frame.
  grid(frame) {
    const bounds = this.bounds.subarray(6 * frame, 6 * frame + 6);
    return [[...bounds.subarray(0, 3)], [0, 1, 2].map((axis) => (bounds[3 + axis] - bounds[axis]) / this.largest)];
  }

  // Writes the positions of a frame to `out`.
  positions(frame, out) {
    const [low, step] = this.grid(frame),
      values = this.values[frame];
    for (let i = 0; i < values.length; i += 3) {
      for (let axis = 0; axis < 3; axis++) out[i + axis] = low[axis] + values[i + axis] * step[axis];
    }
  }
}

// Reads the surfaces, links and positions, in the order of their first use.
function readArrays(header, bytes, start) {
  let at = start;
  const words = (count) => {
    const read = readWords(bytes, at, count);
    at += 4 * count;
    return read;
  };
  const surfaces = [];
  const surface = (index) => {
    if (index === surfaces.length) {
      const size = header.surfaces[index];
      surfaces.push({
        vertices: size.vertices,
        sizes: words(size.faces),
        corners: words(size.corners),
        weld: words(size.vertices),
        triangles: words(3 * size.triangles),
      });
    }
    return surfaces[index];
  };
  for (const body of header.bodies) {
    body.surface = surface(body.surface);
    body.links = words(2 * body.links);
  }
  for (const collider of header.colliders) {
    if (collider.shape !== "mesh") continue;
    collider.surface = surface(collider.surface);
    if (!collider.is_animated) collider.positions = new Float32Array(words(3 * collider.surface.vertices).buffer);
  }
}

// Reads the pieces of the broken bodies of a frame, and adds their shapes to the bodies. Returns the end of the pieces.
function readPieces(run, frame, bytes, view, start) {
  let at = start;
  const number = () => {
    at += 4;
    return view.getUint32(at - 4, true);
  };
  const words = (count) => {
    at += 4 * count;
    return readWords(bytes, at - 4 * count, count);
  };
  for (let bodies = number(); bodies > 0; bodies--) {
    const body = run.bodies[number()];
    // The identity of the faces and links is for programs that continue a run.
    at += 8;
    const vertices = number(),
      lattice = number();
    const [faces, caps, corners, triangles, links] = [number(), number(), number(), number(), number()];
    if (faces > 0) {
      const surface = {
        vertices,
        sizes: words(faces),
        sources: words(faces - caps),
        corners: words(corners),
        weld: words(vertices),
        triangles: words(3 * triangles),
      };
      body.shapes.push({ surface, lattice, links: words(2 * links), frame });
    }
    body.mesh.count = vertices;
    body.latticePoints.count = lattice;
    body.shapeOf[frame] = body.shapes.length - 1;
  }
  return at;
}

// Reads a run.
async function readRun(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const length = view.getUint32(0, true);
  const run = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  readArrays(run, bytes, 4 + length);
  for (const body of run.bodies) {
    body.mesh = new PointSet(body.surface.vertices, run.frames, MESH_VALUES);
    body.latticePoints = new PointSet(body.lattice, run.frames, LATTICE_VALUES);
    body.volumes = new Float64Array(3 * run.frames);
    // The body when it is whole, and then its pieces; and the index of the shape in each frame.
    body.shapes = [{ surface: body.surface, lattice: body.lattice, links: body.links, frame: 0 }];
    body.shapeOf = new Uint32Array(run.frames);
  }
  const animated = run.colliders.filter((collider) => collider.is_animated);
  for (const collider of animated) collider.points = new PointSet(collider.surface.vertices, run.frames, MESH_VALUES);
  for (const collider of run.colliders) collider.poses = new Float64Array(6 * run.frames);
  const sets = run.bodies
    .flatMap((body) => [body.mesh, body.latticePoints])
    .concat(animated.map((collider) => collider.points));
  let at = 4 + length + run.arrays,
    paused = performance.now();
  const numbers = (out, first, count, size) => {
    for (let i = 0; i < count; i++, at += size)
      out[first + i] = size === 8 ? view.getFloat64(at, true) : view.getFloat32(at, true);
  };
  for (let frame = 0; frame < run.frames; frame++) {
    for (const body of run.bodies) numbers(body.volumes, 3 * frame, 3, 8);
    for (const collider of run.colliders) numbers(collider.poses, 6 * frame, 6, 8);
    for (const set of sets) numbers(set.bounds, 6 * frame, 6, 4);
    for (const set of sets) set.count = set.points;
    if (run.version > 1) at = readPieces(run, frame, bytes, view, at);
    for (const set of sets) {
      set.unpack(frame, set.count, bytes, at);
      at += 6 * set.count;
    }
    if (performance.now() - paused > 50) {
      showMessage(`Unpacking ${run.name}: frame ${frame + 1} of ${run.frames}`);
      await new Promise((resolve) => setTimeout(resolve));
      paused = performance.now();
    }
  }
  for (const set of sets) set.last = set.secondLast = [];
  return run;
}
