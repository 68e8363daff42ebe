// The picture: one body on a floor, drawn by the views of the recorded pages.

/* global Materials, THEMES, THREE, Views */

// Room around a body that the camera shows at the start, in m: at the sides and above.
const ROOM = [0.12, 0.3];

// Returns the corners of the part of the scene around a body.
function boundsOf(positions) {
  const low = [Infinity, 0, Infinity],
    high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; i++) {
    low[i % 3] = Math.min(low[i % 3], positions[i]);
    high[i % 3] = Math.max(high[i % 3], positions[i]);
  }
  const [side, above] = ROOM;
  return Float32Array.of(low[0] - side, 0, low[2] - side, high[0] + side, high[1] + above, high[2] + side);
}

// Returns the volume inside triangles, in m³.
function volumeInside(triangles, p) {
  let sum = 0;
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t],
      b = 3 * triangles[t + 1],
      c = 3 * triangles[t + 2];
    sum +=
      p[a] * (p[b + 1] * p[c + 2] - p[b + 2] * p[c + 1]) +
      p[a + 1] * (p[b + 2] * p[c] - p[b] * p[c + 2]) +
      p[a + 2] * (p[b] * p[c + 1] - p[b + 1] * p[c]);
  }
  return sum / 6;
}

// A body as the views expect it, with one frame, which changes.
export class LiveBody {
  constructor({ surface, links, lattice, isClosed, ...answer }) {
    Object.assign(this, { surface, links, lattice, isClosed });
    this.mesh = { bounds: null, normals: null, positions: (_, out) => out.set(this.positions) };
    this.latticePoints = { positions: (_, out) => out.set(this.latticePositions) };
    this.take(answer);
    // Positions in the start pose.
    this.start = this.positions.slice();
    this.mesh.bounds = boundsOf(this.start);
  }

  // Takes the positions, the normals and the ratio of the rest volume of an answer of the simulation.
  take({ buffer, volumeRatio }) {
    const count = 3 * this.surface.vertices;
    Object.assign(this, { buffer, volumeRatio });
    this.positions = new Float32Array(buffer, 0, count);
    this.mesh.normals = new Float32Array(buffer, 4 * count, count);
    this.latticePositions = new Float32Array(buffer, 8 * count, 3 * this.lattice);
  }
}

// What is drawn, from the best to the fastest. Most of the time goes into the light from the surroundings.
const QUALITIES = [
  { share: 1, hasShadows: true, hasSurroundings: true },
  { share: 0.7, hasShadows: true, hasSurroundings: false },
  { share: 0.4, hasShadows: false, hasSurroundings: false },
];

// Mean time between two pictures, in ms, above which less is drawn, and the longest time that counts, so that a single
// long one changes nothing.
const SLOW = 45,
  LONGEST_GAP = 100;

// Pictures that do not count after a change: the graphics card prepares for them.
const WARM_UP = 3;

// Returns whether the processor draws, because there is no graphics card.
function drawsInSoftware(renderer) {
  const context = renderer.getContext(),
    info = context.getExtension("WEBGL_debug_renderer_info");
  const name = context.getParameter(info?.UNMASKED_RENDERER_WEBGL ?? context.RENDERER);
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

function runOf(body) {
  const floor = { shape: "plane", center: [0, 0, 0], normal: [0, 1, 0], poses: new Float64Array(6) };
  return { up: [0, 1, 0], frames: 1, bodies: [body], colliders: [floor] };
}

export class Picture {
  constructor(canvas, body) {
    this.canvas = canvas;
    this.body = body;
    this.materials = new Materials();
    this.views = new Views(canvas, [runOf(body)], this.materials);
    this.options = { wireframe: false, lattice: false, colliders: true, ground: true };
    this.raycaster = new THREE.Raycaster();
    this.markers = new Map();
    this.markerGeometry = new THREE.SphereGeometry(0.016, 20, 14);
    this.markerMaterial = new THREE.MeshStandardMaterial({ color: "#1f6f8b", transparent: true, depthTest: false });
    this.isDrawn = false;
    this.quality = drawsInSoftware(this.views.renderer) ? QUALITIES.length - 1 : 0;
    this.gap = { mean: 0, pictures: 0 };
    this.views.controls.addEventListener("change", () => this.invalidate());
    new ResizeObserver(() => {
      this.views.resize();
      this.invalidate();
      // Drawn at once, so that a canvas of another size is not empty for a moment.
      this.draw();
    }).observe(canvas);
    this.setBody(body, true);
  }

  get view() {
    return this.views.views[0];
  }

  get object() {
    return this.view.bodies[0];
  }

  // `isOtherShape`: whether the camera goes back to its start.
  setBody(body, isOtherShape) {
    if (body !== this.body) this.views.setRuns([runOf(body)]);
    if (isOtherShape) this.views.resetCamera();
    this.body = body;
    this.restVolume = volumeInside(this.object.geometry.triangles, body.start);
    this.markers.clear();
    this.setQuality(this.quality);
    this.setTheme(document.documentElement.dataset.theme);
    this.set({});
    this.show();
  }

  // Shows the positions that the body has.
  show() {
    this.view.show(0);
    this.invalidate();
  }

  // Returns the relative error of the volume of the triangles that are drawn.
  volumeError() {
    const { positions, volumeRatio } = this.body;
    return volumeInside(this.object.geometry.triangles, positions) / (volumeRatio * this.restVolume) - 1;
  }

  set(options) {
    Object.assign(this.options, options);
    this.materials.setTransparent(this.options.lattice);
    this.view.setVisible(this.options);
    this.show();
  }

  setTheme(name) {
    this.materials.setTheme(THEMES[name]);
    this.views.setTheme(THEMES[name]);
    this.invalidate();
  }

  setQuality(level) {
    const { share, hasShadows, hasSurroundings } = QUALITIES[level],
      { views, view } = this;
    this.quality = level;
    this.gap = { mean: 0, pictures: 0 };
    views.pixelRatio = share * Math.min(devicePixelRatio, 2);
    views.resize();
    view.lights.key.castShadow = hasShadows;
    view.scene.environment = hasSurroundings ? views.environment : null;
    view.lights.sky.intensity = hasSurroundings ? 0.35 : 1.4;
    this.invalidate();
  }

  // Draws less from now on if the pictures come slowly. `gap`: milliseconds since the picture before.
  adapt(gap) {
    this.gap.pictures++;
    if (this.gap.pictures <= WARM_UP) return;
    this.gap.mean += 0.2 * (Math.min(gap, LONGEST_GAP) - this.gap.mean);
    if (this.gap.mean > SLOW && this.quality + 1 < QUALITIES.length) this.setQuality(this.quality + 1);
  }

  invalidate() {
    this.isDrawn = false;
  }

  // Draws if something has changed. Returns whether it has.
  draw() {
    if (this.isDrawn) return false;
    this.isDrawn = true;
    this.views.draw();
    return true;
  }

  // Returns the ray through a point of the picture, in pixels of the page.
  ray({ clientX, clientY }) {
    const box = this.canvas.getBoundingClientRect();
    const x = (2 * (clientX - box.left)) / box.width - 1,
      y = 1 - (2 * (clientY - box.top)) / box.height;
    this.views.camera.updateMatrixWorld();
    this.raycaster.setFromCamera({ x, y }, this.views.camera);
    return this.raycaster.ray;
  }

  // Returns the point of the surface under a point of the picture: where it is, and where it was at the start.
  pick(event) {
    this.ray(event);
    const { geometry, faces } = this.object;
    geometry.faces.computeBoundingSphere();
    const [hit] = this.raycaster.intersectObject(faces, false);
    if (!hit) return null;
    const corners = [hit.face.a, hit.face.b, hit.face.c].map((group) => geometry.vertices[group]),
      shares = hit.barycoord.toArray();
    const start = [0, 1, 2].map((axis) =>
      corners.reduce((sum, vertex, k) => sum + shares[k] * this.body.start[3 * vertex + axis], 0),
    );
    return { point: hit.point, start };
  }

  // Returns the highest vertex as `pick` does.
  pickTop() {
    const { positions, start } = this.body;
    let top = 0;
    for (let vertex = 0; vertex < positions.length / 3; vertex++) {
      if (positions[3 * vertex + 1] > positions[3 * top + 1]) top = vertex;
    }
    const of = (array) => array.slice(3 * top, 3 * top + 3);
    return { point: new THREE.Vector3(...of(positions)), start: [...of(start)] };
  }

  // Returns the point under a point of the picture in the plane through `point` that faces the camera.
  inPlane(event, point) {
    const { origin, direction } = this.ray(event),
      normal = this.views.camera.getWorldDirection(new THREE.Vector3());
    const distance = point.clone().sub(origin).dot(normal) / direction.dot(normal);
    return direction.clone().multiplyScalar(distance).add(origin);
  }

  // Returns a vector of the picture plane, to the right and up, as a vector of the scene.
  across(right, up) {
    const { elements } = this.views.camera.matrixWorld;
    return new THREE.Vector3(...[0, 1, 2].map((k) => right * elements[k] + up * elements[4 + k]));
  }

  // Marks where a pointer pulls; `null` removes the mark.
  mark(pointer, point) {
    let marker = this.markers.get(pointer);
    if (!point) {
      marker?.removeFromParent();
      this.markers.delete(pointer);
    } else {
      if (!marker) {
        marker = new THREE.Mesh(this.markerGeometry, this.markerMaterial);
        marker.renderOrder = 1;
        this.view.scene.add(marker);
        this.markers.set(pointer, marker);
      }
      marker.position.copy(point);
    }
    this.invalidate();
  }
}
