// Reads the data of a run: see run.rs, frame.rs and points.rs.

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
  // `largest` is the largest value of a coordinate.
  constructor(points, frames, largest) {
    this.points = points;
    this.largest = largest;
    this.bounds = new Float32Array(6 * frames);
    this.values = new Uint16Array(3 * points * frames);
    this.last = null;
    this.secondLast = null;
  }

  // Unpacks the values of the next frame.
  unpack(frame, bytes, at) {
    const count = this.points,
      start = 3 * count * frame,
      high = at + 3 * count;
    const [low, step] = this.grid(frame);
    const positions = new Float64Array(3 * count);
    for (let axis = 0; axis < 3; axis++) {
      let error = 0;
      for (let point = 0; point < count; point++) {
        const k = axis * count + point,
          i = 3 * point + axis;
        const word = bytes[at + k] | (bytes[high + k] << 8);
        error = (error + ((word >>> 1) ^ -(word & 1))) & 65535;
        let predicted = 0;
        if (this.last && step[axis] > 0) {
          const last = this.last[i];
          const next = this.secondLast ? last + (last - this.secondLast[i]) : last;
          predicted = Math.min(Math.max(Math.floor((next - low[axis]) / step[axis] + 0.5), 0), this.largest);
        }
        const value = (predicted + error) & 65535;
        this.values[start + i] = value;
        positions[i] = low[axis] + value * step[axis];
      }
    }
    this.secondLast = this.last;
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
      start = 3 * this.points * frame;
    for (let i = 0; i < 3 * this.points; i += 3) {
      for (let axis = 0; axis < 3; axis++) out[i + axis] = low[axis] + this.values[start + i + axis] * step[axis];
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
    for (const set of sets) {
      set.unpack(frame, bytes, at);
      at += 6 * set.points;
    }
    if (performance.now() - paused > 50) {
      showMessage(`Unpacking ${run.name}: frame ${frame + 1} of ${run.frames}`);
      await new Promise((resolve) => setTimeout(resolve));
      paused = performance.now();
    }
  }
  for (const set of sets) set.last = set.secondLast = null;
  return run;
}
