// The bytes of a picture, as the server writes them.
'use strict';

const headerSize = 108;

const pad = size => (size + 3) & ~3;

function matrixOf(turn, place) {
  return new THREE.Matrix4().set(turn[0], turn[1], turn[2], place[0], turn[3], turn[4], turn[5], place[1], turn[6], turn[7], turn[8], place[2], 0, 0, 0, 1);
}

// Everything that a picture holds; bodies: those that it shows.
function decode(bytes, bodies) {
  const view = new DataView(bytes), f = at => view.getFloat32(at, true), u = at => view.getUint32(at, true), h = at => view.getUint16(at, true);
  const frame = {
    status: view.getUint8(1), flags: view.getUint8(2), number: u(4), frame: u(8), step: u(12), firstKept: u(16), lastKept: u(20), missed: u(24),
    time: f(28), rate: f(32), stepMs: f(36), ratio: f(40), kinetic: f(44), elastic: f(48), potential: f(52), penetration: f(56), residual: f(60),
    limits: h(64), contacts: h(66), iterations: h(68), retries: h(70), largestStretch: f(72), largestMultiplier: f(76),
    goal: [f(80), f(84), f(88)], held: [f(92), f(96), f(100)], bodies: [], points: null, moving: []};
  let at = headerSize;
  for (const body of bodies) {
    const low = [f(at), f(at + 4), f(at + 8)], extent = [f(at + 12), f(at + 16), f(at + 20)];
    const places = new Uint16Array(bytes, at + 24, 3 * body.numNodes), nodes = new Float32Array(3 * body.numNodes);
    for (let i = 0; i < nodes.length; ++i) nodes[i] = low[i % 3] + extent[i % 3] * places[i] / 65535;
    frame.bodies.push({low, extent, nodes, heat: []});
    at += 24 + pad(6 * body.numNodes);
  }
  const numHexes = bodies.reduce((sum, body) => sum + body.numHexes, 0), parts = frame.flags & 16 ? 3 : 2;
  for (let part = 0; part < parts; ++part)
    for (let b = 0, from = at + part * numHexes; b < bodies.length; from += bodies[b++].numHexes)
      frame.bodies[b].heat.push(new Uint8Array(bytes, from, bodies[b].numHexes));
  at += pad(parts * numHexes);
  frame.points = decodePoints(bytes, at, h(104), frame.bodies);
  at += pad(6 * h(104));
  for (let i = 0; i < h(106); ++i, at += 52) {
    const numbers = Array.from({length: 12}, (unused, k) => f(at + 4 + 4 * k));
    frame.moving.push({obstacle: u(at), matrix: matrixOf(numbers.slice(0, 9), numbers.slice(9))});
  }
  return frame;
}

function decodePoints(bytes, at, count, bodies) {
  const low = [0, 1, 2].map(k => Math.min(...bodies.map(body => body.low[k])));
  const high = [0, 1, 2].map(k => Math.max(...bodies.map(body => body.low[k] + body.extent[k])));
  const places = new Uint16Array(bytes, at, 3 * count);
  return Float32Array.from(places, (value, i) => low[i % 3] + (high[i % 3] - low[i % 3]) * value / 65535);
}
