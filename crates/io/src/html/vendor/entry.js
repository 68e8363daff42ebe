// The parts of three.js that pages use: see scripts/vendor-three.
export {
  Box3, BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, DirectionalLight, DoubleSide, EdgesGeometry,
  Float32BufferAttribute, FrontSide, Group, HemisphereLight, LineBasicMaterial, LineSegments, Mesh, MeshStandardMaterial,
  NeutralToneMapping, PCFShadowMap, PMREMGenerator, PerspectiveCamera, Quaternion, Scene, SphereGeometry, Vector3,
  WebGLRenderer,
} from 'three';
export { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
export { RoomEnvironment } from 'three/examples/jsm/environments/RoomEnvironment.js';
