// Colors, materials and lights.

// Colors of the bodies; further bodies have other hues.
const PALETTE = [
  "#cb6a4a",
  "#3b9a96",
  "#dba93f",
  "#5f7fc9",
  "#a9638f",
  "#74a05a",
  "#e08a93",
  "#7d6fc4",
  "#4fa3d1",
  "#b98354",
];

function bodyColor(index) {
  if (index < PALETTE.length) return PALETTE[index];
  // Steps of the golden angle spread the hues.
  return `hsl(${Math.round(index * 137.508) % 360}, 48%, ${index % 2 ? 58 : 50}%)`;
}

// Colors of the other objects, light and dark.
const THEMES = {
  light: {
    plane: "#d8d5cc",
    planeOpacity: 0.9,
    grid: "#77746b",
    gridOpacity: 0.5,
    collider: "#9aa3ad",
    colliderEdge: "#59616b",
    edge: "#1c1e22",
    lattice: "#14566e",
    sky: "#ffffff",
    floor: "#c9c2b4",
    environment: 0.34,
  },
  dark: {
    plane: "#3a3f49",
    planeOpacity: 0.85,
    grid: "#aab2c0",
    gridOpacity: 0.28,
    collider: "#7f8a97",
    colliderEdge: "#c3cad3",
    edge: "#0d0e11",
    lattice: "#9fe0f3",
    sky: "#dfe7f5",
    floor: "#4a4640",
    environment: 0.3,
  },
};

// Materials that the views share.
class Materials {
  constructor() {
    const line = (options) => new THREE.LineBasicMaterial({ transparent: true, ...options });
    this.plane = new THREE.MeshStandardMaterial({
      vertexColors: true,
      transparent: true,
      roughness: 1,
      depthWrite: false,
      side: THREE.DoubleSide,
      envMapIntensity: 0.6,
    });
    this.grid = line({ vertexColors: true, depthWrite: false });
    this.collider = new THREE.MeshStandardMaterial({
      transparent: true,
      opacity: 0.4,
      roughness: 0.7,
      depthWrite: false,
      side: THREE.DoubleSide,
    });
    this.solid = new THREE.MeshStandardMaterial({
      transparent: true,
      opacity: 0.62,
      roughness: 0.7,
      side: THREE.FrontSide,
    });
    this.colliderEdge = line({ opacity: 0.55 });
    this.edge = line({ opacity: 0.55 });
    this.lattice = line({ opacity: 0.5 });
    this.bodies = [];
    this.caps = [];
  }

  // Returns the material of the body with an index.
  body(index) {
    this.bodies[index] ??= new THREE.MeshStandardMaterial({
      color: bodyColor(index),
      roughness: 0.58,
      metalness: 0,
      side: THREE.DoubleSide,
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    });
    return this.bodies[index];
  }

  // Returns the material of the surfaces of the cracks of a body: its own, and lighter.
  cap(index) {
    if (!this.caps[index]) {
      this.caps[index] = this.body(index).clone();
      const { color } = this.caps[index];
      color.lerp(color.clone().set("#ffffff"), 0.45);
    }
    return this.caps[index];
  }

  setTheme(theme) {
    for (const name of ["plane", "grid", "collider", "colliderEdge", "edge", "lattice"])
      this[name].color.set(theme[name]);
    this.solid.color.set(theme.collider);
    this.plane.opacity = theme.planeOpacity;
    this.grid.opacity = theme.gridOpacity;
  }

  // Makes the bodies transparent, so that their lattices are seen.
  setTransparent(isTransparent) {
    for (const material of [...this.bodies, ...this.caps.filter(Boolean)]) {
      material.transparent = isTransparent;
      material.opacity = isTransparent ? 0.35 : 1;
      material.depthWrite = !isTransparent;
      material.needsUpdate = true;
    }
  }
}

// The lights of a view. The shadows of the key light cover the scene.
class Lights {
  constructor(extent, up) {
    const { center, radius } = extent;
    this.object = new THREE.Group();
    this.sky = new THREE.HemisphereLight(0xffffff, 0xffffff, 0.35);
    this.sky.position.copy(up.up);
    this.key = new THREE.DirectionalLight(0xfff4e4, 1.65);
    const from = up.up.clone().multiplyScalar(2.6).addScaledVector(up.right, 1.1).addScaledVector(up.front, 1.5);
    this.key.position.copy(center).addScaledVector(from, radius);
    this.key.target.position.copy(center);
    this.key.castShadow = true;
    this.key.shadow.mapSize.set(2048, 2048);
    const camera = this.key.shadow.camera,
      reach = 1.5 * radius;
    camera.left = camera.bottom = -reach;
    camera.right = camera.top = reach;
    camera.near = 0.1 * radius;
    camera.far = 8 * radius;
    this.key.shadow.normalBias = 0.006 * radius;
    this.key.shadow.radius = 5;
    const fill = new THREE.DirectionalLight(0xdfe9ff, 0.3);
    fill.position
      .copy(center)
      .addScaledVector(up.right, -3 * radius)
      .addScaledVector(up.up, radius)
      .addScaledVector(up.front, radius);
    fill.target.position.copy(center);
    this.object.add(this.sky, this.key, this.key.target, fill, fill.target);
  }

  setTheme(theme) {
    this.sky.color.set(theme.sky);
    this.sky.groundColor.set(theme.floor);
  }
}
