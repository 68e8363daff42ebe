// The views: one scene for each run, and one camera for all of them.

// Returns the axes of the picture for a direction up: right and front are horizontal, front points to the viewer.
function axesOf(direction) {
  const up = new THREE.Vector3(...direction).normalize();
  const front = Math.abs(up.z) > 0.8 ? new THREE.Vector3(0, -Math.sign(up.z), 0) : new THREE.Vector3(0, 0, 1);
  front.addScaledVector(up, -front.dot(up)).normalize();
  return { up, front, right: new THREE.Vector3().crossVectors(up, front) };
}

// Returns the bounding box of all bodies of the runs in all frames, and its sphere.
function extentOf(runs) {
  const box = new THREE.Box3();
  for (const { mesh } of runs.flatMap((run) => run.bodies)) {
    for (let i = 0; i < mesh.bounds.length; i += 3)
      box.expandByPoint(new THREE.Vector3(...mesh.bounds.subarray(i, i + 3)));
  }
  const center = box.getCenter(new THREE.Vector3()),
    radius = box.getSize(new THREE.Vector3()).length() / 2;
  return { box, center, radius: radius || 1 };
}

// Returns the geometry of a shape of a body and that of its lattice. Shape 0 is the whole body, and others are its
// pieces.
function shapeGeometry(body, index) {
  const { surface, lattice, links, frame } = body.shapes?.[index] ?? body;
  const positionsIn = (frame, { vertices }) => {
    const positions = new Float32Array(3 * vertices);
    body.mesh.positions(frame, positions);
    return positions;
  };
  const ofFaces = surface.sources && faceNormals(body.surface, positionsIn(0, body.surface));
  const lines = new THREE.BufferGeometry();
  lines.setIndex(new THREE.BufferAttribute(links, 1));
  lines.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * lattice), 3));
  return { geometry: new SurfaceGeometry(surface, positionsIn(frame ?? 0, surface), ofFaces), links: lines };
}

// The scene of a run.
class View {
  constructor(run, extent, axes, materials, environment) {
    this.run = run;
    this.scene = new THREE.Scene();
    this.scene.environment = environment;
    this.lights = new Lights(extent, axes);
    this.scene.add(this.lights.object);
    this.materials = materials;
    this.bodies = run.bodies.map((body, index) => this.bodyObject(body, index));
    this.colliders = run.colliders.map((collider) => new ColliderObject(collider, extent, axes, materials));
    this.colliderGroup = new THREE.Group();
    this.ground = new THREE.Group();
    for (const collider of this.colliders) this.colliderGroup.add(collider.object);
    if (!this.colliders.some((collider) => collider.isFloor)) this.addGround(extent, axes);
    this.scene.add(this.colliderGroup, this.ground);
  }

  bodyObject(body, index) {
    const whole = shapeGeometry(body, 0);
    const material = this.materials.body(index);
    const canBreak = body.shapes?.length > 1;
    const faces = new THREE.Mesh(whole.geometry.faces, canBreak ? [material, this.materials.cap(index)] : material);
    faces.castShadow = faces.receiveShadow = true;
    const edges = new THREE.LineSegments(whole.geometry.edges, this.materials.edge);
    const lattice = new THREE.LineSegments(whole.links, this.materials.lattice);
    for (const object of [faces, edges, lattice]) {
      object.frustumCulled = false;
      this.scene.add(object);
    }
    edges.visible = lattice.visible = false;
    // `shapes` has the geometries of the shapes that were shown.
    return { body, geometry: whole.geometry, shapes: [whole], faces, edges, lattice };
  }

  // Shows the shape of a body in a frame: the whole body, or its pieces.
  showShape(object, frame) {
    const { body, shapes } = object,
      index = body.shapeOf?.[frame] ?? 0;
    const { geometry, links } = (shapes[index] ??= shapeGeometry(body, index));
    if (geometry === object.geometry) return;
    object.geometry = geometry;
    const shown = [
      [object.faces, geometry.faces],
      [object.edges, geometry.edges],
      [object.lattice, links],
    ];
    for (const [lines, next] of shown) {
      // Frees the memory of the graphics card; the geometry is loaded again when it is shown again.
      lines.geometry.dispose();
      lines.geometry = next;
    }
  }

  // Adds a grid below the bodies to a scene without a plane, for the shadows.
  addGround(extent, { up }) {
    const corners = [extent.box.min, extent.box.max];
    const heights = corners.flatMap((a) =>
      corners.flatMap((b) => corners.map((c) => new THREE.Vector3(a.x, b.y, c.z).dot(up))),
    );
    const ground = planeObject(planeRadius(extent.box, up, false), false, this.materials);
    ground.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), up);
    ground.position
      .copy(extent.center)
      .addScaledVector(up, Math.min(...heights) - 0.02 * extent.radius - extent.center.dot(up));
    this.ground.add(ground);
  }

  // Shows a frame; a run that has ended shows its last one.
  show(frame) {
    const shown = Math.min(frame, this.run.frames - 1);
    for (const object of this.bodies) {
      this.showShape(object, shown);
      const { body, geometry, lattice } = object;
      body.mesh.positions(shown, geometry.positions);
      geometry.update(body.mesh.normals);
      if (lattice.visible) {
        const place = lattice.geometry.attributes.position;
        body.latticePoints.positions(shown, place.array);
        place.needsUpdate = true;
      }
    }
    for (const collider of this.colliders) collider.show(shown);
  }

  // Hides disabled colliders, and the walls between the bodies and the camera.
  hideColliders(camera) {
    for (const collider of this.colliders)
      collider.content.visible = collider.isShown && !collider.isSeenFromBehind(camera);
  }

  setVisible(options) {
    for (const { edges, lattice } of this.bodies) {
      edges.visible = options.wireframe;
      lattice.visible = options.lattice;
    }
    for (const collider of this.colliders) {
      collider.object.visible = collider.isFloor ? options.ground : options.colliders;
    }
    this.ground.visible = options.ground;
  }

  // Frees the memory of the graphics card.
  dispose() {
    this.scene.traverse((object) => object.geometry?.dispose());
    this.lights.key.dispose();
  }
}

// Draws the views side by side.
class Views {
  constructor(canvas, runs, materials) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setScissorTest(true);
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    this.renderer.toneMappingExposure = 0.92;
    const room = new THREE.RoomEnvironment();
    this.environment = new THREE.PMREMGenerator(this.renderer).fromScene(room, 0.04, 0.1, 100, { size: 64 }).texture;
    this.materials = materials;
    // Pixels of the picture for one pixel of the page.
    this.pixelRatio = Math.min(devicePixelRatio, 2);
    this.setRuns(runs);
    this.camera = new THREE.PerspectiveCamera(32, 1, this.extent.radius / 100, 60 * this.extent.radius);
    this.camera.up.copy(this.axes.up);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.isDefault = true;
    this.controls.addEventListener("start", () => {
      this.isDefault = false;
    });
    this.resetCamera();
  }

  // Shows runs in place of those before. The camera stays where it is.
  setRuns(runs) {
    for (const view of this.views ?? []) view.dispose();
    this.extent = extentOf(runs);
    this.axes = axesOf(runs[0].up);
    this.views = runs.map((run) => new View(run, this.extent, this.axes, this.materials, this.environment));
    this.columns = runs.length <= 3 ? runs.length : Math.ceil(Math.sqrt(runs.length));
    this.rows = Math.ceil(runs.length / this.columns);
    this.picture = this.pictureBox();
  }

  // Returns the box that the camera shows: the bodies in all frames, and the colliders that are not much larger.
  pictureBox() {
    const box = this.extent.box.clone(),
      size = new THREE.Vector3();
    for (const collider of this.views.flatMap((view) => view.colliders)) {
      if (collider.isPlane) continue;
      const around = collider.box();
      if (around.getSize(size).length() <= 4 * this.extent.radius) box.union(around);
    }
    return box;
  }

  setTheme(theme) {
    for (const view of this.views) {
      view.lights.setTheme(theme);
      view.scene.environmentIntensity = theme.environment;
    }
  }

  // Places the camera so that the bodies fill the picture in all frames.
  resetCamera() {
    const box = this.picture,
      center = box.getCenter(new THREE.Vector3()),
      { up, front, right } = this.axes;
    const direction = front.clone().addScaledVector(right, 0.55).addScaledVector(up, 0.36).normalize();
    const across = new THREE.Vector3().crossVectors(up, direction).normalize();
    const above = new THREE.Vector3().crossVectors(direction, across);
    const slope = Math.tan((this.camera.fov * Math.PI) / 360) * 0.86,
      corner = new THREE.Vector3();
    let distance = 0.5 * this.extent.radius;
    for (let k = 0; k < 8; k++) {
      corner
        .set(k & 1 ? box.max.x : box.min.x, k & 2 ? box.max.y : box.min.y, k & 4 ? box.max.z : box.min.z)
        .sub(center);
      const towards = corner.dot(direction);
      distance = Math.max(
        distance,
        towards + Math.abs(corner.dot(above)) / slope,
        towards + Math.abs(corner.dot(across)) / (slope * this.camera.aspect),
      );
    }
    this.controls.target.copy(center);
    this.camera.position.copy(center).addScaledVector(direction, distance);
    this.controls.update();
    this.isDefault = true;
  }

  // Turns the camera about the center, in degrees to the right and up, and moves it by a factor of its distance.
  turn(sideways, upwards, factor) {
    const { up } = this.axes,
      offset = this.camera.position.clone().sub(this.controls.target);
    offset.applyAxisAngle(up, (sideways * Math.PI) / 180);
    const angle = offset.angleTo(up),
      next = Math.min(Math.max(angle - (upwards * Math.PI) / 180, 0.02), Math.PI - 0.02);
    offset
      .applyAxisAngle(new THREE.Vector3().crossVectors(offset, up).normalize(), angle - next)
      .multiplyScalar(factor);
    this.camera.position.copy(this.controls.target).add(offset);
    this.isDefault = false;
    this.controls.update();
  }

  // Fits the picture to the canvas.
  resize() {
    const canvas = this.renderer.domElement,
      { clientWidth: width, clientHeight: height } = canvas;
    this.renderer.setPixelRatio(this.pixelRatio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / this.columns / (height / this.rows);
    this.camera.updateProjectionMatrix();
    if (this.isDefault) this.resetCamera();
  }

  draw() {
    const { clientWidth, clientHeight } = this.renderer.domElement;
    const width = clientWidth / this.columns,
      height = clientHeight / this.rows;
    this.views.forEach((view, index) => {
      const x = (index % this.columns) * width,
        y = clientHeight - (Math.floor(index / this.columns) + 1) * height;
      view.hideColliders(this.camera);
      this.renderer.setViewport(x, y, width, height);
      this.renderer.setScissor(x, y, width, height);
      this.renderer.render(view.scene, this.camera);
    });
  }
}
