// The page of umax live: draws what the server sends, and tells it what is wished.
'use strict';

const plotSeconds = 8, mostSamples = 4000;
const statusNames = ['converged', 'iteration limit', 'infeasible'], statusClasses = ['good', 'warn', 'bad'];

const live = {socket: null, hello: null, bodies: [], obstacles: [], sliders: [], fields: [], turn: 0, samples: [], frame: null, isNew: false, steers: false, plays: false, pull: null, retry: 500};
window.umaxLive = live;  // for tests of this page

// ---- the picture

// False: another session's meshes have been asked for in the meantime.
async function build(hello, turn) {
  const bodies = [], obstacles = [];
  for (let i = 0; i < hello.bodies.length; ++i) bodies.push(new Body(await fetchBytes('/body/' + i), hello.bodies[i], ramp));
  for (let i = 0; i < hello.obstacles.length; ++i) {
    const about = hello.obstacles[i], thing = about.plane ? groundOf(about) : await meshOf(about, i);
    thing.matrixAutoUpdate = false;
    thing.matrix.copy(matrixOf(about.turn, about.place));
    thing.updateMatrixWorld(true);
    thing.visible = about.visible && !about.deforms;
    obstacles.push(thing);
  }
  for (const about of hello.pins) obstacles.push(pinOf(about));
  if (turn !== live.turn) return false;
  for (const thing of [...live.bodies.map(body => body.group), ...live.obstacles]) scene.remove(thing);
  live.bodies = bodies, live.obstacles = obstacles;
  for (const thing of [...bodies.map(body => body.group), ...obstacles]) scene.add(thing);
  const animated = hello.obstacles.filter(about => about.deforms).map(about => about.name);
  if (animated.length) toast('not drawn here, since they are animated by other programs: ' + animated.join(', '), false);
  showLooks();
  return true;
}

function showPicture(frame) {
  frame.bodies.forEach((part, b) => live.bodies[b].move(part.nodes, part.heat));
  touchPoints.geometry.dispose();
  touchPoints.geometry = new THREE.BufferGeometry();
  touchPoints.geometry.setAttribute('position', new THREE.BufferAttribute(frame.points, 3));
  touchPoints.visible = $('touch').checked && frame.points.length > 0;
  for (const {obstacle, matrix} of frame.moving) live.obstacles[obstacle].matrix.copy(matrix), live.obstacles[obstacle].updateMatrixWorld(true);
  const grabbed = (frame.flags & 4) !== 0;
  spring.visible = hand.visible = grabbed;
  if (grabbed) {
    const goal = live.pull ? live.pull.point : new THREE.Vector3(...frame.goal);
    spring.geometry.setFromPoints([new THREE.Vector3(...frame.held), goal]);
    hand.position.copy(goal);
    hand.scale.setScalar(0.006 * camera.position.distanceTo(goal));
  }
}

// ---- what is said beside it

const plots = [
  new Plot($('plot_ratio'), [{color: '#e59b3a', of: s => s.ratio}], 1.15, 1),
  new Plot($('plot_energy'), [{color: '#6aa5e3', of: s => s.kinetic}, {color: '#e59b3a', of: s => s.elastic}], 1e-6),
  new Plot($('plot_count'), [{color: '#6aa5e3', of: s => s.contacts}, {color: '#e59b3a', of: s => s.limits}], 10)];

function keepSample(frame) {
  if (frame.flags & 2) return;
  while (live.samples.length && live.samples[live.samples.length - 1].time >= frame.time) live.samples.pop();
  live.samples.push({time: frame.time, ratio: frame.ratio, kinetic: frame.kinetic, elastic: frame.elastic, limits: frame.limits, contacts: frame.contacts});
  if (live.samples.length > mostSamples) live.samples.splice(0, mostSamples / 4);
}

function tell(frame) {
  const past = (frame.flags & 2) !== 0;
  live.plays = (frame.flags & 1) !== 0;
  $('status').textContent = past ? 'looking back' : statusNames[frame.status];
  $('status').className = 'chip ' + (past ? '' : statusClasses[frame.status]);
  $('ratio').textContent = frame.ratio > 0 ? 'U/Umax ' + frame.ratio.toFixed(4) : '';
  $('ratio').className = 'chip' + (frame.ratio > 1 + live.hello.tolerance ? ' bad' : '');
  $('missed').textContent = frame.missed ? frame.missed + ' steps not converged' : '';
  $('missed').className = 'chip warn';
  $('pace').textContent = !live.plays ? (past ? '' : 'paused')
    : frame.flags & 8 ? 'slowed to ' + frame.rate.toFixed(2) + ' × real time: steps take ' + frame.stepMs.toFixed(0) + ' ms'
      : frame.rate.toFixed(2) + ' × real time, steps ' + frame.stepMs.toFixed(1) + ' ms';
  $('pace').className = 'chip' + (frame.flags & 8 ? ' warn' : '');
  $('play').innerHTML = live.plays ? '&#10074;&#10074; Pause' : '&#9654; Play';
  $('clock').textContent = frame.time.toFixed(3) + ' s · ' + frame.frame;
  $('goon').hidden = !past || !live.steers;
  $('scrub').min = frame.firstKept, $('scrub').max = Math.max(frame.lastKept, frame.firstKept + 1);
  if (document.activeElement !== $('scrub') || live.plays) $('scrub').value = frame.frame;
  $('now_ratio').textContent = frame.ratio.toFixed(3);
  $('now_count').textContent = frame.limits + ' · ' + frame.contacts;
  tellLegend(frame);
}

function tellLegend(frame) {
  const part = Number(document.querySelector('input[name=heat]:checked').value);
  $('legend').hidden = part === 0;
  $('title').textContent = ['', 'U / Umax', 'stretch [%]', 'λ / Umax'][part];
  $('high').textContent = part === 1 ? '1' : shownNumber(part === 2 ? frame.largestStretch : frame.largestMultiplier);
}

function showLooks() {
  const part = Number(document.querySelector('input[name=heat]:checked').value);
  for (const body of live.bodies) {
    body.uniforms.heatPart.value = part;
    body.uniforms.showHeld.value = $('held').checked ? 1 : 0;
    body.cage.visible = $('cage').checked;
  }
  if (live.frame) tellLegend(live.frame);
}

let toastTimer = 0;
function toast(text, isError) {
  $('toast').textContent = text;
  $('toast').className = isError ? 'error' : '';
  $('toast').hidden = false;
  clearTimeout(toastTimer);
  toastTimer = setTimeout(() => { $('toast').hidden = true; }, isError ? 6000 : 12000);
}

async function copy(text) {
  if (!text) return toast('nothing has been changed', false);
  try {
    await navigator.clipboard.writeText(text);
    toast('copied:\n' + text, false);
  } catch (error) {
    toast(text, false);
  }
}

function takeRole(role) {
  live.steers = role.steers;
  const others = role.watchers - 1;
  $('role').textContent = (role.steers ? 'you steer' : 'another browser steers') + (others > 0 ? ', ' + others + (others === 1 ? ' other watches' : ' others watch') : '');
  $('steer').hidden = role.steers;
  for (const id of ['restart', 'play', 'step', 'slower', 'scrub', 'save', 'render']) $(id).disabled = !role.steers;
  for (const control of [...live.sliders, ...live.fields]) control.enable(role.steers);
}

// ---- the connection

function wish(name, more) {
  if (live.socket && live.socket.readyState === 1) live.socket.send(JSON.stringify({wish: name, ...more}));
}

const answers = {
  hello: async hello => {
    const turn = ++live.turn;
    live.hello = null, live.frame = null, live.waiting = null, live.values = null, live.samples = [];
    handles.detach();
    $('name').textContent = hello.name;
    $('size').textContent = hello.bodies.map(body => body.hexes.toLocaleString('en') + ' hexes, ' + body.vertices.toLocaleString('en') + ' vertices').slice(0, 1) + (hello.bodies.length > 1 ? ' and ' + (hello.bodies.length - 1) + ' more bodies' : '');
    document.title = hello.name + ' · umax live';
    if (!await build(hello, turn)) return;
    const {sliders, fields} = makeSliders(hello, $('keys'), (key, value) => wish('set', {key, value}), (body, cells) => wish('cells', {body, cells}));
    live.sliders = sliders, live.fields = fields;
    if (live.values) answers.values(live.values);  // told while the meshes came
    if (live.role) for (const control of [...sliders, ...fields]) control.enable(live.role.steers);
    live.hello = hello;
    if (live.waiting) take(live.waiting);
  },
  values: told => {
    live.values = told;
    live.sliders.forEach((slider, i) => slider.show(told.values[i], told.goals[i]));
  },
  role: role => { live.role = role; takeRole(role); },
  note: told => toast(told.text, false),
  error: told => toast(told.text, true),
  lines: told => copy(told.text),
  invite: told => copy(told.text)};

function take(bytes) {
  if (!live.hello) {
    live.waiting = bytes;
    wish('seen', {frame: new DataView(bytes).getUint32(4, true)});
    return;
  }
  live.waiting = null;
  const first = !live.frame;
  live.frame = decode(bytes, live.bodies);
  live.isNew = true;
  keepSample(live.frame);
  if (first && !live.framed) frameView(live.frame, live.hello.obstacles);
  live.framed = true;
  wish('seen', {frame: live.frame.number});
}

function connect() {
  const socket = new WebSocket('ws://' + location.host + '/live');
  socket.binaryType = 'arraybuffer';
  socket.onopen = () => { live.retry = 500; };
  socket.onmessage = event => {
    if (typeof event.data !== 'string') return take(event.data);
    const told = JSON.parse(event.data);
    if (answers[told.type]) answers[told.type](told);
  };
  socket.onclose = () => {
    $('status').textContent = 'not connected';
    $('status').className = 'chip bad';
    setTimeout(connect, live.retry);
    live.retry = Math.min(8000, 2 * live.retry);
  };
  live.socket = socket;
}

// ---- hands

const caster = new THREE.Raycaster();
function aimAt(event) {
  const box = $('view').getBoundingClientRect();
  caster.setFromCamera(new THREE.Vector2(2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height), camera);
}

function startPull(event) {
  if (event.button !== 0 || !live.steers || !live.hello || handles.axis) return;
  aimAt(event);
  let best = null;
  if (live.hello.can_grab) live.bodies.forEach((body, b) => {
    const hit = body.hit(caster.ray);
    if (hit && (!best || hit.distance < best.distance)) best = {...hit, body: b};
  });
  chooseObstacle(best ? best.distance : Infinity);
  if (!best || handles.object) return;
  event.stopImmediatePropagation();
  controls.enabled = false;
  const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(camera.getWorldDirection(new THREE.Vector3()), best.point);
  live.pull = {plane, point: best.point.clone()};
  $('view').classList.add('pulls');
  $('view').setPointerCapture(event.pointerId);
  $('hint').classList.add('gone');
  wish('grab', {body: best.body, vertex: best.vertex, place: best.point.toArray()});
}

// The handles of the pin under the cursor, or of the obstacle where one is nearer than what else is there.
function chooseObstacle(nearest) {
  const about = [...live.hello.obstacles, ...live.hello.pins], first = live.hello.obstacles.length;
  const movable = live.obstacles.map((thing, i) => ({thing, i})).filter(({thing, i}) => about[i].movable && thing.visible);
  const pin = caster.intersectObjects(movable.filter(({i}) => i >= first).map(({thing}) => thing))[0];
  const hit = pin || caster.intersectObjects(movable.filter(({i}) => i < first).map(({thing}) => thing))[0];
  if (!hit || (!pin && hit.distance >= nearest)) return handles.detach();
  live.chosen = live.obstacles.indexOf(hit.object);
  handle.position.setFromMatrixPosition(hit.object.matrix);
  handles.attach(handle);
}

function movePull(event) {
  if (!live.pull) return;
  aimAt(event);
  if (caster.ray.intersectPlane(live.pull.plane, live.pull.point)) live.pull.isNew = true;
}

function endPull() {
  if (!live.pull) return;
  live.pull = null;
  controls.enabled = true;
  $('view').classList.remove('pulls');
  wish('release');
}

$('view').addEventListener('pointerdown', startPull, true);
$('view').addEventListener('mousedown', event => { if (live.pull) event.stopImmediatePropagation(); }, true);
handles.addEventListener('dragging-changed', event => { controls.enabled = !event.value; live.places = event.value; });
handles.addEventListener('objectChange', () => { live.placed = true; });
window.addEventListener('pointermove', movePull);
window.addEventListener('pointerup', endPull);
window.addEventListener('pointercancel', endPull);
$('play').addEventListener('click', () => wish(live.plays ? 'pause' : 'play'));
$('step').addEventListener('click', () => wish('step'));
$('restart').addEventListener('click', () => { live.samples = []; wish('restart'); });
$('slower').addEventListener('change', () => wish('slower', {value: Number($('slower').value)}));
$('scrub').addEventListener('input', () => wish('show', {frame: Number($('scrub').value)}));
$('goon').addEventListener('click', () => { wish('rewind', {frame: live.frame.frame}); wish('play'); });
$('steer').addEventListener('click', () => wish('steer'));
for (const name of ['invite', 'lines', 'save', 'render']) $(name).addEventListener('click', () => wish(name));
for (const input of document.querySelectorAll('#looks input')) input.addEventListener('change', showLooks);
window.addEventListener('keydown', event => {
  if (/^(INPUT|SELECT|BUTTON)$/.test(event.target.tagName)) return;
  if (event.key === ' ') $('play').click();
  else if (event.key === '.') $('step').click();
  else if (event.key === 'r') $('restart').click();
  else return;
  event.preventDefault();
});

// ---- the beat

function draw() {
  requestAnimationFrame(draw);
  fit();
  controls.update();
  if (live.pull && live.pull.isNew) {
    live.pull.isNew = false;
    wish('move', {place: live.pull.point.toArray()});
  }
  if (live.placed && live.places) {
    live.placed = false;
    wish('place', {obstacle: live.chosen, place: handle.position.toArray()});
  }
  if (live.frame && live.isNew) {
    live.isNew = false;
    showPicture(live.frame);
    tell(live.frame);
    for (const plot of plots) plot.draw(live.samples, plotSeconds);
  }
  renderer.render(scene, camera);
}

connect();
draw();
