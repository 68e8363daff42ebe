// Surfaces as three.js geometries whose positions and normals follow the frames.

// Two faces whose normals differ by more than this angle meet in a crease: 40 degrees.
const CREASE = Math.cos((40 * Math.PI) / 180);

// Returns the triangles of a surface, which are fans of its faces unless it lists others, and the ends of its edges.
// `caps` is the number of corners of the triangles before those of caps: the last faces of the pieces of a body, which
// belong to no face of the whole body.
function triangulate(surface) {
  const triangles = [],
    edges = [],
    known = new Set(),
    uncut = surface.sources?.length ?? surface.sizes.length;
  let first = 0,
    caps = 0;
  for (let face = 0; face < surface.sizes.length; face++) {
    const size = surface.sizes[face];
    for (let k = 0; k < size; k++) {
      const a = surface.corners[first + k],
        b = surface.corners[first + ((k + 1) % size)];
      const [low, high] = [surface.weld[a], surface.weld[b]].sort((x, y) => x - y);
      const key = low * surface.vertices + high;
      if (!known.has(key)) {
        known.add(key);
        edges.push(a, b);
      }
      if (k === 0 || k + 1 === size) continue;
      // Each corner of a face but two has a triangle.
      const next = triangles.length;
      if (surface.triangles.length > 0) triangles.push(...surface.triangles.subarray(next, next + 3));
      else triangles.push(surface.corners[first], a, b);
    }
    first += size;
    if (face < uncut) caps = triangles.length;
  }
  return { triangles: Uint32Array.from(triangles), edges: Uint32Array.from(edges), caps };
}

// Returns the normals of the faces of a surface, with the length of twice their areas.
function faceNormals({ sizes, corners }, positions) {
  const normals = new Float64Array(3 * sizes.length),
    sum = new THREE.Vector3();
  const corner = (index) => new THREE.Vector3().fromArray(positions, 3 * corners[index]);
  let first = 0;
  for (let face = 0; face < sizes.length; face++) {
    const origin = corner(first);
    sum.set(0, 0, 0);
    for (let k = 2; k < sizes[face]; k++) {
      const side = corner(first + k - 1).sub(origin);
      sum.add(side.cross(corner(first + k).sub(origin)));
    }
    sum.toArray(normals, 3 * face);
    first += sizes[face];
  }
  return normals;
}

// Replaces the normals of the triangles of pieces by those of the faces of the whole body to which they belong, except
// those of caps.
function takeNormals({ sizes, sources }, ofFaces, out) {
  let t = 0;
  for (let face = 0; face < sources.length; face++) {
    const from = 3 * sources[face];
    for (let k = 2; k < sizes[face]; k++, t += 3) out.set(ofFaces.subarray(from, from + 3), t);
  }
}

// Computes the normals of triangles, with the length of twice their areas.
function triangleNormals(triangles, positions, out) {
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t],
      b = 3 * triangles[t + 1],
      c = 3 * triangles[t + 2];
    const ux = positions[b] - positions[a],
      uy = positions[b + 1] - positions[a + 1],
      uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a],
      vy = positions[c + 1] - positions[a + 1],
      vz = positions[c + 2] - positions[a + 2];
    out[t] = uy * vz - uz * vy;
    out[t + 1] = uz * vx - ux * vz;
    out[t + 2] = ux * vy - uy * vx;
  }
}

// Divides the corners of the triangles into groups with a common normal: corners at one vertex, connected across edges
// that are no creases. `normals` decide where creases are; caps, which begin at corner `caps`, have creases all around.
// Returns the group of each corner and the vertex of each group.
function smoothGroups(triangles, weld, normals, caps) {
  const parent = Uint32Array.from(triangles, (_, corner) => corner);
  const find = (corner) => {
    while (parent[corner] !== corner) corner = parent[corner] = parent[parent[corner]];
    return corner;
  };
  const isSmooth = (s, t) => {
    const dot = normals[s] * normals[t] + normals[s + 1] * normals[t + 1] + normals[s + 2] * normals[t + 2];
    const lengths =
      Math.hypot(normals[s], normals[s + 1], normals[s + 2]) * Math.hypot(normals[t], normals[t + 1], normals[t + 2]);
    return s < caps === t < caps && dot >= CREASE * lengths;
  };
  // The last corner from which each edge leaves, by its welded ends.
  const count = weld.length,
    leaving = new Map();
  const visit = (from, to) => {
    const a = weld[triangles[from]],
      b = weld[triangles[to]],
      low = Math.min(a, b),
      high = Math.max(a, b);
    const other = leaving.get(low * count + high);
    leaving.set(low * count + high, [from, to]);
    if (!other || !isSmooth(3 * Math.floor(other[0] / 3), 3 * Math.floor(from / 3))) return;
    const isOpposite = weld[triangles[other[1]]] === a;
    parent[find(other[isOpposite ? 1 : 0])] = find(from);
    parent[find(other[isOpposite ? 0 : 1])] = find(to);
  };
  for (let t = 0; t < triangles.length; t += 3) {
    visit(t, t + 1);
    visit(t + 1, t + 2);
    visit(t + 2, t);
  }
  const groups = new Uint32Array(triangles.length),
    vertices = [],
    numbers = new Map();
  for (let corner = 0; corner < triangles.length; corner++) {
    const root = find(corner);
    if (!numbers.has(root)) {
      numbers.set(root, vertices.length);
      vertices.push(triangles[corner]);
    }
    groups[corner] = numbers.get(root);
  }
  return { groups, vertices: Uint32Array.from(vertices) };
}

// Returns the corners whose vertex has several normals, and their groups.
function findCreases(triangles, groups, vertices, weld) {
  const count = new Uint32Array(weld.length),
    corners = [],
    creased = new Set();
  for (const vertex of vertices) count[weld[vertex]]++;
  for (let corner = 0; corner < groups.length; corner++) {
    if (count[weld[triangles[corner]]] < 2) continue;
    corners.push(corner);
    creased.add(groups[corner]);
  }
  return { corners: Uint32Array.from(corners), groups: Uint32Array.from(creased) };
}

// The geometry of a surface: its triangles with normals, and its edges.
class SurfaceGeometry {
  // `positions` are those at rest, which decide where creases are; of pieces, those of their first frame. Pieces have
  // the creases of the whole body, whose faces have the normals `ofFaces` at rest, and others on caps.
  constructor(surface, positions, ofFaces) {
    const { triangles, edges, caps } = triangulate(surface);
    const normals = new Float64Array(triangles.length);
    triangleNormals(triangles, positions, normals);
    if (surface.sources) takeNormals(surface, ofFaces, normals);
    const { groups, vertices } = smoothGroups(triangles, surface.weld, normals, caps);
    this.triangles = triangles;
    this.groups = groups;
    this.vertices = vertices;
    this.normals = normals;
    this.all = { corners: groups.map((_, corner) => corner), groups: vertices.map((_, group) => group) };
    this.creases = findCreases(triangles, groups, vertices, surface.weld);
    this.faces = new THREE.BufferGeometry();
    this.faces.setIndex(new THREE.BufferAttribute(groups, 1));
    // The faces and the caps have a material each.
    this.faces.addGroup(0, caps, 0);
    this.faces.addGroup(caps, triangles.length - caps, 1);
    this.faces.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * vertices.length), 3));
    this.faces.setAttribute("normal", new THREE.BufferAttribute(new Float32Array(3 * vertices.length), 3));
    this.positions = positions;
    this.edges = new THREE.BufferGeometry();
    this.edges.setIndex(new THREE.BufferAttribute(edges, 1));
    this.edges.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    this.update();
  }

  // Computes positions and normals of the triangles from `this.positions`. If the normals of the vertices are known, only
  // those at creases are computed.
  update(vertexNormals) {
    const { triangles, groups, vertices, normals, positions } = this;
    const place = this.faces.attributes.position,
      normal = this.faces.attributes.normal;
    for (let i = 0; i < vertices.length; i++) {
      const v = 3 * vertices[i];
      place.array[3 * i] = positions[v];
      place.array[3 * i + 1] = positions[v + 1];
      place.array[3 * i + 2] = positions[v + 2];
    }
    if (vertexNormals) {
      for (let i = 0; i < vertices.length; i++) {
        const v = 3 * vertices[i];
        normal.array[3 * i] = vertexNormals[v];
        normal.array[3 * i + 1] = vertexNormals[v + 1];
        normal.array[3 * i + 2] = vertexNormals[v + 2];
      }
    }
    const computed = vertexNormals ? this.creases : this.all;
    if (computed.corners.length > 0) triangleNormals(triangles, positions, normals);
    for (const group of computed.groups) normal.array.fill(0, 3 * group, 3 * group + 3);
    for (const corner of computed.corners) {
      const g = 3 * groups[corner],
        t = 3 * Math.floor(corner / 3);
      normal.array[g] += normals[t];
      normal.array[g + 1] += normals[t + 1];
      normal.array[g + 2] += normals[t + 2];
    }
    for (const group of computed.groups) {
      const g = 3 * group;
      const length = Math.hypot(normal.array[g], normal.array[g + 1], normal.array[g + 2]) || 1;
      for (let axis = 0; axis < 3; axis++) normal.array[g + axis] /= length;
    }
    place.needsUpdate = normal.needsUpdate = this.edges.attributes.position.needsUpdate = true;
  }
}
