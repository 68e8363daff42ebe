// The worker: runs the simulation, so that the page answers while a body is built or a frame takes long.
//
// Messages from the page are { kind, id, ... }. Each is answered by { id, error } or by { id, ... }.

import { initSync, Playground, Settings } from "./supple_web.js";
import { Pace } from "./pace.js";

let memory, playground;
const pace = new Pace();
// Whether the surface differs from that of the last answer with positions.
let isChanged = false;

// Returns the settings of the page as those of the playground.
function read(values) {
  const settings = Settings.new();
  settings.lattice_vertices = values.resolution;
  settings.gravity = values.gravity;
  for (const name of ["volume", "floor", "base"]) settings[name] = values[name];
  for (const name of ["inflate", "wind", "grip"]) settings[name] = values[name];
  settings.set_material(values.material);
  // Without a number it is the one of the material.
  if (values.poisson !== null) settings.poisson_ratio = values.poisson;
  settings.set_up(values.up);
  return settings;
}

// Runs an action with the settings of the page, and frees them. After an error the garbage collector does so: a panic
// may have left them in use.
function withSettings(values, action) {
  const settings = read(values),
    result = action(settings);
  settings.free();
  return result;
}

// Returns numbers in the memory of the simulation, valid until it next runs.
function numbers(address, vertices) {
  return new Float32Array(memory.buffer, address, 3 * vertices);
}

// Returns positions, normals and lattice positions in one buffer, that of an earlier answer if it has the size.
function copyOut(buffer) {
  const mesh = playground.mesh_vertices(),
    lattice = playground.lattice_vertices(),
    bytes = 12 * (2 * mesh + lattice);
  const out = new Float32Array(buffer?.byteLength === bytes ? buffer : new ArrayBuffer(bytes));
  out.set(numbers(playground.positions(), mesh), 0);
  out.set(numbers(playground.normals(), mesh), 3 * mesh);
  out.set(numbers(playground.lattice_positions(), lattice), 6 * mesh);
  return out.buffer;
}

function figures() {
  return {
    volumeError: playground.volume_error(),
    volumeErrorBefore: playground.volume_error_before(),
    volumeRatio: playground.rest_volume_ratio(),
    isAtRest: playground.is_at_rest(),
    steps: playground.steps_per_frame(),
  };
}

// Returns what the page needs to know of a new body.
function description() {
  return {
    surface: {
      vertices: playground.mesh_vertices(),
      sizes: playground.face_sizes(),
      corners: playground.face_corners(),
      triangles: playground.triangles(),
      weld: playground.weld(),
    },
    links: playground.links(),
    lattice: playground.lattice_vertices(),
    isClosed: playground.is_closed(),
    buffer: copyOut(),
    ...figures(),
  };
}

const actions = {
  start({ module }) {
    memory = initSync({ module }).memory;
    return {};
  },

  load({ name, bytes, settings }) {
    const [next, poisson] = withSettings(settings, (read) => [
      Playground.new(name, new Uint8Array(bytes), read),
      read.poisson_ratio,
    ]);
    playground?.free();
    playground = next;
    return { poisson, ...description() };
  },

  reset() {
    playground.reset();
    return description();
  },

  apply({ settings, isRebuilt }) {
    const poisson = withSettings(settings, (read) => {
      playground.apply(read);
      return read.poisson_ratio;
    });
    isChanged = true;
    return { poisson, ...(isRebuilt ? description() : {}) };
  },

  grab({ pointer, point }) {
    playground.grab(pointer, ...point);
    return {};
  },

  release({ pointer }) {
    playground.release(pointer);
    return {};
  },

  // Advances by `elapsed` seconds, and evaluates the surface. `drags` has the displacements of the pointers.
  frame({ elapsed, drags, buffer }) {
    for (const [pointer, displacement] of drags) playground.drag(pointer, ...displacement);
    const frames = pace.frames(elapsed),
      wasAtRest = playground.is_at_rest(),
      begin = performance.now();
    playground.advance(frames);
    const stepped = performance.now();
    pace.measure(frames, stepped - begin);
    // A body that falls asleep in these frames is shown once more.
    if (frames > 0 && !(wasAtRest && playground.is_at_rest())) isChanged = true;
    if (!isChanged) return { frames, buffer: null, returned: buffer, ...figures() };
    isChanged = false;
    playground.evaluate();
    const evaluated = performance.now();
    return {
      frames,
      stepTime: stepped - begin,
      surfaceTime: evaluated - stepped,
      buffer: copyOut(buffer),
      ...figures(),
    };
  },
};

addEventListener("message", ({ data }) => {
  const { id, kind } = data;
  try {
    const answer = { id, ...actions[kind](data) };
    const buffers = [answer.buffer, answer.returned].filter((buffer) => buffer);
    postMessage(answer, buffers);
  } catch (error) {
    // A panic, or a lack of memory, leaves the simulation in a state in which it cannot go on.
    const isFatal =
      error instanceof WebAssembly.RuntimeError ||
      error instanceof RangeError ||
      !(error instanceof Error) ||
      error.message.startsWith("panicked at ");
    postMessage({ id, error: error.message ?? String(error), isFatal });
  }
});
