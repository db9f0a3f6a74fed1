// The stage: canvas, camera, lights and marks, and the things that stand there beside bodies.
'use strict';

const $ = id => document.getElementById(id);

const renderer = new THREE.WebGLRenderer({canvas: $('view'), antialias: true});
renderer.setClearColor(0x1b1c1f);
renderer.gammaOutput = true;
renderer.gammaFactor = 2.2;
renderer.shadowMap.enabled = true;
renderer.shadowMap.type = THREE.PCFSoftShadowMap;
const scene = new THREE.Scene();
scene.fog = new THREE.Fog(0x1b1c1f, 9, 30);
const camera = new THREE.PerspectiveCamera(35, 1, 0.01, 200);
camera.position.set(2.4, 1.7, 5.2);
const controls = new THREE.OrbitControls(camera, $('view'));
controls.enableDamping = true;
controls.dampingFactor = 0.12;
controls.target.set(0, 1, 0);
const sun = new THREE.DirectionalLight(0xfff1e0, 0.95);
sun.castShadow = true;
sun.shadow.mapSize.set(2048, 2048);
sun.shadow.bias = -0.0006;
sun.shadow.radius = 3;
scene.add(sun, sun.target, new THREE.HemisphereLight(0xc9d6ea, 0x3a352f, 0.42));
const rim = new THREE.DirectionalLight(0x9fc0ff, 0.3);
rim.position.set(-3, 2, -4);
scene.add(rim);
const ramp = heatRamp();
paintRamp($('ramp'));
const touchPoints = new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({color: 0x5ad1ff, size: 7, sizeAttenuation: false, depthTest: false, transparent: true}));
touchPoints.frustumCulled = false;
const spring = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({color: 0xffb04a, depthTest: false, transparent: true}));
spring.frustumCulled = false;
const hand = new THREE.Mesh(new THREE.SphereBufferGeometry(1, 20, 14), new THREE.MeshBasicMaterial({color: 0xffb04a, depthTest: false, transparent: true, opacity: 0.9}));
scene.add(touchPoints, spring, hand);
spring.visible = hand.visible = touchPoints.visible = false;

const handles = new THREE.TransformControls(camera, $('view')), handle = new THREE.Object3D();
handles.setSize(0.7);
scene.add(handle, handles);

async function fetchBytes(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error(path + ': ' + answer.status);
  return answer.arrayBuffer();
}

function groundOf(about) {
  const mesh = new THREE.Mesh(new THREE.CircleBufferGeometry(60, 64), new THREE.MeshStandardMaterial({color: new THREE.Color().setRGB(0.07, 0.072, 0.078), roughness: 0.95}));
  const group = new THREE.Group(), grid = new THREE.GridHelper(24, 48, 0x8a8e96, 0x6b6f77);
  mesh.rotation.x = -Math.PI / 2;
  mesh.receiveShadow = true;
  grid.position.y = 0.002;
  grid.material.transparent = true, grid.material.opacity = 0.22;
  group.add(mesh, grid);
  return group;
}

async function meshOf(about, i) {
  const bytes = await fetchBytes('/obstacle/' + i), [, numVertices, numTriangles] = new Uint32Array(bytes, 0, 3);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(bytes, 12, 3 * numVertices), 3));
  geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(bytes, 12 + 12 * numVertices, 3 * numTriangles), 1));
  const mesh = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({color: new THREE.Color().setRGB(...about.color), roughness: 0.7, flatShading: true, side: THREE.DoubleSide}));
  mesh.castShadow = mesh.receiveShadow = true;
  return mesh;
}

// The mark of a pin, seen through its body.
function pinOf(about) {
  const mark = new THREE.Mesh(new THREE.SphereBufferGeometry(about.radius, 20, 14), new THREE.MeshBasicMaterial({color: 0x5fd0ff, depthTest: false, transparent: true, opacity: 0.8}));
  mark.renderOrder = 2;
  mark.matrixAutoUpdate = false;
  mark.matrix.makeTranslation(...about.place);
  mark.updateMatrixWorld(true);
  mark.visible = about.movable;
  return mark;
}

// Looks at a picture so that bodies and ground are seen; obstacles: what the server tells of them.
function frameView(frame, obstacles) {
  const low = new THREE.Vector3(Infinity, Infinity, Infinity), high = low.clone().negate();
  for (const body of frame.bodies) {
    const a = new THREE.Vector3(...body.low);
    low.min(a), high.max(a.clone().add(new THREE.Vector3(...body.extent)));
  }
  const size = high.distanceTo(low), middle = low.clone().add(high).multiplyScalar(0.5);
  const floor = obstacles.filter(about => about.plane && about.visible).map(about => about.place[1]).filter(y => y <= low.y + 1e-3);
  const bottom = floor.length ? Math.max(Math.max(...floor), low.y - 2 * size) : low.y;
  middle.y = (bottom + high.y) / 2;
  const reach = Math.max(size, high.y - bottom) * 1.35;
  controls.target.copy(middle);
  camera.position.copy(middle).add(new THREE.Vector3(0.42, 0.2, 0.9).normalize().multiplyScalar(reach / Math.tan(0.5 * camera.fov * Math.PI / 180) * 0.62));
  camera.near = reach / 200, camera.far = reach * 60;
  camera.updateProjectionMatrix();
  scene.fog.near = reach * 2.2, scene.fog.far = reach * 7;
  sun.position.copy(middle).add(new THREE.Vector3(0.5, 1, 0.45).normalize().multiplyScalar(3 * reach));
  sun.target.position.copy(middle);
  Object.assign(sun.shadow.camera, {left: -1.5 * reach, right: 1.5 * reach, top: 1.5 * reach, bottom: -1.5 * reach, near: 0.1 * reach, far: 7 * reach});
  sun.shadow.camera.updateProjectionMatrix();
  controls.update();
}

function fit() {
  const width = $('stage').clientWidth, height = $('stage').clientHeight, scale = Math.min(2, window.devicePixelRatio || 1);
  const size = renderer.getDrawingBufferSize(new THREE.Vector2());
  if (Math.abs(size.x - width * scale) < 2 && Math.abs(size.y - height * scale) < 2) return;
  renderer.setPixelRatio(scale);
  renderer.setSize(width, height, false);
  camera.aspect = width / height;
  const below = document.body.clientWidth > 860 ? 64 : 0;  // what stands on plots is seen
  camera.setViewOffset(width, height, 0, below, width, height);
  camera.updateProjectionMatrix();
}
