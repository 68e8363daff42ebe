// Tests of GLB files: the validator of Khronos finds no problem, and three.js plays them back to the OBJ frames.
// scripts/test-tools writes the runs to the folder RUNS, and starts these tests.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import validator from 'gltf-validator';
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const folder = join(process.env.RUNS, 'export');
const read = (name) => readFileSync(join(folder, name));
const LAST = 40,
  FPS = 30,
  ERROR = 1e-3;

for (const name of ['supple.glb', 'bust_vat/bust.glb']) {
  test(`the validator finds no problem in ${name}`, async () => {
    const { issues } = await validator.validateBytes(new Uint8Array(read(name)));
    assert.deepEqual([issues.numErrors, issues.numWarnings], [0, 0], JSON.stringify(issues.messages));
  });
}

// Returns the points of an OBJ frame.
function objPoints(frame) {
  const text = read(`bust_${String(frame).padStart(4, '0')}.obj`).toString();
  const lines = text.split('\n').filter((line) => line.startsWith('v '));
  return lines.map((line) => new THREE.Vector3(...line.split(' ').slice(1, 4).map(Number)));
}

test('three.js plays the frames of a run within the error', async () => {
  const bytes = read('supple.glb');
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const gltf = await new GLTFLoader().parseAsync(buffer, '');
  const mixer = new THREE.AnimationMixer(gltf.scene);
  const clip = gltf.animations[0];
  mixer.clipAction(clip).setLoop(THREE.LoopOnce).play();
  mixer.clipAction(clip).clampWhenFinished = true;
  assert.ok(Math.abs(clip.duration - LAST / FPS) < 1e-6, `${clip.duration} s`);
  const meshes = [];
  gltf.scene.getObjectByName('bust').traverse((object) => object.isMesh && meshes.push(object));
  // The ground.
  assert.deepEqual(
    gltf.scene.getObjectByName('supple_colliders').children.map((object) => object.name),
    ['plane_0'],
  );
  const first = new THREE.Box3().setFromPoints(objPoints(0)).getSize(new THREE.Vector3());
  const size = Math.max(first.x, first.y, first.z);
  for (const frame of [0, 1, 17, LAST]) {
    mixer.setTime(frame / FPS);
    gltf.scene.updateMatrixWorld(true);
    // The vertices of the file are those of the mesh, some of them several times; each is near one of the frame.
    const points = objPoints(frame);
    const cells = new Map();
    const key = (x, y, z) => `${x},${y},${z}`;
    const cell = size / 50;
    for (const point of points) {
      const at = key(...point.toArray().map((number) => Math.floor(number / cell)));
      cells.set(at, [...(cells.get(at) ?? []), point]);
    }
    let largest = 0;
    const place = new THREE.Vector3();
    for (const mesh of meshes) {
      for (let vertex = 0; vertex < mesh.geometry.attributes.position.count; vertex++) {
        mesh.getVertexPosition(vertex, place).applyMatrix4(mesh.matrixWorld);
        const [x, y, z] = place.toArray().map((number) => Math.floor(number / cell));
        let nearest = Infinity;
        for (const dx of [-1, 0, 1])
          for (const dy of [-1, 0, 1])
            for (const dz of [-1, 0, 1])
              for (const point of cells.get(key(x + dx, y + dy, z + dz)) ?? [])
                nearest = Math.min(nearest, point.distanceTo(place));
        largest = Math.max(largest, nearest);
      }
    }
    // Times of 32 bits move a vertex by less than a thousandth of its way between frames.
    assert.ok(largest <= 1.1 * ERROR * size, `frame ${frame}: ${largest / size} of the size`);
  }
});
