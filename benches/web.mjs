// Times of the page to play with, without a browser: simulation, and volume correction with the surface.
//
//     ./scripts/web && node benches/web.mjs [MODEL.obj [LATTICE_VERTICES]]
//
// Without a model, it makes a torus of 30,000 vertices with bumps. Its top is pulled to and fro. Times are those of the
// processor for a frame of 1/60 s, as means over 300 frames after 300 others. Before the table a playground runs for 600
// frames, in which code is still being compiled.

import { readFileSync } from "node:fs";

const [path, vertices = "1000"] = process.argv.slice(2);
const web = new URL("../target/web/", import.meta.url);
const { initSync, Playground, Settings } = await import(new URL("supple_web.js", web));
initSync({ module: readFileSync(new URL("supple_web_bg.wasm", web)) });

// Returns a torus with bumps as OBJ.
function torus(around, across) {
  const lines = [];
  for (let i = 0; i < around; i++) {
    for (let j = 0; j < across; j++) {
      const u = (2 * Math.PI * i) / around,
        v = (2 * Math.PI * j) / across,
        r = 0.28 * (1 + 0.15 * Math.sin(5 * u + 3 * v));
      lines.push(
        `v ${(0.7 + r * Math.cos(v)) * Math.cos(u)} ${1.6 * r * Math.sin(v)} ${(0.7 + r * Math.cos(v)) * Math.sin(u)}`,
      );
    }
  }
  const at = (i, j) => (i % around) * across + (j % across) + 1;
  for (let i = 0; i < around; i++) {
    for (let j = 0; j < across; j++) lines.push(`f ${at(i, j)} ${at(i, j + 1)} ${at(i + 1, j + 1)} ${at(i + 1, j)}`);
  }
  return Buffer.from(lines.join("\n"));
}

const model = path ? readFileSync(path) : torus(250, 120);

// Pulls the body to and fro for 600 frames. Returns the times of the last 300, and what the table shows of the body.
function measure(material, volume) {
  const settings = new Settings();
  settings.set_material(material);
  settings.volume = volume;
  settings.lattice_vertices = Number(vertices);
  const playground = new Playground("model.obj", model, settings),
    times = [0, 0];
  settings.free();
  // Runs something, and adds the milliseconds of the processor that it takes.
  const timed = (k, action) => {
    const begin = process.cpuUsage();
    action();
    const { user, system } = process.cpuUsage(begin);
    times[k] += (user + system) / 1000;
  };
  playground.grab(1, 0, 1, 0);
  for (let frame = 0; frame < 600; frame++) {
    if (frame === 300) times.fill(0);
    playground.drag(1, 0.2 * Math.sin(frame / 20), 0.2 * Math.sin(frame / 31), 0);
    timed(0, () => playground.advance(1));
    timed(1, () => playground.evaluate());
  }
  const sizes = [playground.steps_per_frame(), playground.lattice_vertices(), playground.mesh_vertices()];
  playground.free();
  return [...sizes, ...times.map((time) => `${(time / 300).toFixed(2)} ms`)];
}

measure("flesh", true);
console.log("material  volume  steps  lattice   mesh  simulation  surface");
for (const material of ["jelly", "flesh", "rubber", "firm"]) {
  for (const volume of [true, false]) {
    const columns = [volume ? "on" : "off", ...measure(material, volume)];
    console.log(material.padEnd(8) + columns.map((x, k) => String(x).padStart([8, 7, 9, 7, 12, 9][k])).join(""));
  }
}
