// Colliders as three.js objects.

// Returns the rotation by angles in degrees about the fixed axes x, then y, then z.
function eulerDegrees([x, y, z]) {
  const turn = (axis, degrees) =>
    new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(...axis), (degrees * Math.PI) / 180);
  return turn([0, 0, 1], z)
    .multiply(turn([0, 1, 0], y))
    .multiply(turn([1, 0, 0], x));
}

// Returns a disc of a radius in the plane z = 0 that fades towards its rim, or with a spacing its grid of lines.
function fadingDisc(radius, spacing) {
  const rings = 24,
    sectors = 64,
    positions = [],
    colors = [],
    index = [];
  const add = (x, y, strength) => {
    const r = Math.min(Math.hypot(x, y) / radius, 1),
      fade = (1 - r) * (1 - r);
    positions.push(x, y, 0);
    colors.push(1, 1, 1, strength * fade);
  };
  if (spacing) {
    const lines = Math.floor(radius / spacing),
      pieces = 16;
    for (let line = -lines; line <= lines; line++) {
      const half = Math.sqrt(Math.max(radius * radius - (line * spacing) ** 2, 0)),
        strength = line % 5 === 0 ? 1 : 0.45;
      for (let piece = 0; piece < pieces; piece++) {
        const ends = [piece, piece + 1].map((k) => half * ((2 * k) / pieces - 1));
        for (const end of ends) add(line * spacing, end, strength);
        for (const end of ends) add(end, line * spacing, strength);
      }
    }
  } else {
    for (let ring = 0; ring <= rings; ring++) {
      for (let sector = 0; sector < sectors; sector++) {
        const angle = (2 * Math.PI * sector) / sectors,
          r = (radius * ring) / rings;
        add(r * Math.cos(angle), r * Math.sin(angle), 1);
        const next = (sector + 1) % sectors,
          inner = (ring - 1) * sectors,
          outer = ring * sectors;
        if (ring > 0)
          index.push(inner + sector, outer + sector, outer + next, inner + sector, outer + next, inner + next);
      }
    }
  }
  const geometry = new THREE.BufferGeometry();
  if (!spacing) geometry.setIndex(index);
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(positions, 3));
  geometry.setAttribute(
    "normal",
    new THREE.Float32BufferAttribute(
      positions.map((_, i) => (i % 3 === 2 ? 1 : 0)),
      3,
    ),
  );
  geometry.setAttribute("color", new THREE.Float32BufferAttribute(colors, 4));
  return geometry;
}

// Returns a round number near a length: 1, 2 or 5 times a power of ten.
function roundLength(length) {
  const power = 10 ** Math.floor(Math.log10(length)),
    digit = length / power;
  return power * (digit < 1.5 ? 1 : digit < 3.5 ? 2 : digit < 7.5 ? 5 : 10);
}

// Returns the radius of the part of a plane that is drawn around the bounding box of the bodies. That of a floor is twice
// as wide as the bodies, and has room for their shadows, which are 0.72 times as long as the bodies are high.
function planeRadius(box, normal, isWall) {
  const half = box.getSize(new THREE.Vector3()).multiplyScalar(0.5);
  let across = 0,
    along = 0;
  for (let k = 0; k < 4; k++) {
    const corner = half.clone().multiply(new THREE.Vector3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, 1)),
      height = corner.dot(normal);
    along = Math.max(along, Math.abs(height));
    across = Math.max(across, corner.addScaledVector(normal, -height).length());
  }
  return isWall ? 1.2 * across + 0.1 * along : 2 * across + 1.6 * along;
}

// Returns a plane with a grid, which fades around the origin; its free side is +z. Walls have a grid only.
function planeObject(radius, isWall, materials) {
  const group = new THREE.Group();
  const disc = new THREE.Mesh(fadingDisc(radius), materials.plane);
  disc.receiveShadow = true;
  disc.visible = !isWall;
  const grid = new THREE.LineSegments(fadingDisc(radius, roundLength(radius / 14)), materials.grid);
  grid.position.z = radius * 2e-4;
  disc.renderOrder = -2;
  grid.renderOrder = -1;
  group.add(disc, grid);
  return group;
}

// A collider of a run. `extent` has the center and the radius of the scene, `axes` those of the picture.
class ColliderObject {
  constructor(collider, extent, axes, materials) {
    this.collider = collider;
    this.center = new THREE.Vector3(...collider.center);
    this.object = new THREE.Group();
    this.isPlane = collider.shape === "plane";
    // The normal of a plane, and whether it is a floor, shown in some frame, and no wall.
    this.normal = new THREE.Vector3(...(collider.normal ?? [0, 0, 0])).normalize();
    this.isFloor = this.normal.dot(axes.up) > 0.7 && !collider.poses.every(Number.isNaN);
    this.content = this.shape(extent, materials);
    this.object.add(this.content);
  }

  shape(extent, materials) {
    const { collider, center } = this;
    const solid = (geometry) => {
      const group = new THREE.Group();
      const faces = new THREE.Mesh(geometry, materials.collider);
      faces.receiveShadow = true;
      group.add(faces, new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 35), materials.colliderEdge));
      return group;
    };
    const towards = (object, axis, direction) => {
      object.quaternion.setFromUnitVectors(axis, direction.normalize());
      return object;
    };
    switch (collider.shape) {
      case "plane": {
        const { normal } = this,
          radius = planeRadius(extent.box, normal, !this.isFloor);
        const plane = towards(
          planeObject(radius, !this.isFloor, materials),
          new THREE.Vector3(0, 0, 1),
          normal.clone(),
        );
        // The disc is around the point of the plane nearest to the scene.
        const offset = extent.center.clone().sub(center);
        plane.position.copy(offset.addScaledVector(normal, -offset.dot(normal)));
        return plane;
      }
      case "sphere":
        return solid(new THREE.SphereGeometry(collider.radius, 64, 40));
      case "box": {
        const box = solid(new THREE.BoxGeometry(...collider.half_extents.map((half) => 2 * half)));
        box.quaternion.copy(eulerDegrees(collider.rotate));
        return box;
      }
      case "capsule": {
        const axis = new THREE.Vector3(...collider.b).sub(new THREE.Vector3(...collider.a));
        const capsule = solid(new THREE.CapsuleGeometry(collider.radius, axis.length(), 16, 40));
        return axis.length() > 0 ? towards(capsule, new THREE.Vector3(0, 1, 0), axis) : capsule;
      }
      default: {
        const positions = collider.positions
          ? collider.positions.slice()
          : new Float32Array(3 * collider.surface.vertices);
        if (collider.points) collider.points.positions(0, positions);
        this.geometry = new SurfaceGeometry(collider.surface, positions);
        const material = collider.is_closed ? materials.solid : materials.collider;
        const faces = new THREE.Mesh(this.geometry.faces, material);
        faces.receiveShadow = true;
        faces.frustumCulled = false;
        const group = new THREE.Group();
        group.add(faces);
        // The edges of a fine mesh would hide what is behind it.
        if (!collider.is_closed && collider.surface.sizes.length < 2000) {
          const edges = new THREE.LineSegments(this.geometry.edges, materials.colliderEdge);
          edges.frustumCulled = false;
          group.add(edges);
        }
        // Its positions are in world space, and those of other shapes are relative to the center.
        group.position.copy(center).negate();
        return group;
      }
    }
  }

  // Returns whether the collider is a wall that is seen from behind, where it would hide the bodies.
  isSeenFromBehind(camera) {
    if (!this.isPlane || this.isFloor) return false;
    const normal = this.normal.clone().applyQuaternion(this.object.quaternion);
    return camera.position.clone().sub(this.object.position).dot(normal) < 0;
  }

  // Returns the bounding box in some frames.
  box() {
    const box = new THREE.Box3(),
      frames = this.collider.poses.length / 6;
    for (const frame of new Set([0, 1, 2, 3, 4].map((k) => Math.round((k * (frames - 1)) / 4)))) {
      this.show(frame);
      if (!this.isShown) continue;
      this.object.updateMatrixWorld(true);
      box.expandByObject(this.object);
    }
    return box;
  }

  // Shows a frame. Poses of disabled colliders, which are not drawn, are NaN.
  show(frame) {
    const pose = this.collider.poses.subarray(6 * frame, 6 * frame + 6);
    this.isShown = !Number.isNaN(pose[0]);
    if (!this.isShown) return;
    this.object.position.set(pose[0], pose[1], pose[2]).add(this.center);
    this.object.quaternion.copy(eulerDegrees(pose.subarray(3)));
    if (this.collider.points) {
      this.collider.points.positions(frame, this.geometry.positions);
      this.geometry.update();
    }
  }
}
