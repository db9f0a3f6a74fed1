// A body on the screen: its surface, tied to the cage's nodes in the vertex shader, and the lines of the cage.
'use strict';

const textureWidth = 256;

function dataTexture(count, type) {
  const height = Math.max(1, Math.ceil(count / textureWidth));
  const data = new (type === THREE.FloatType ? Float32Array : Uint8Array)(4 * textureWidth * height);
  const texture = new THREE.DataTexture(data, textureWidth, height, THREE.RGBAFormat, type);
  texture.needsUpdate = true;
  return texture;
}

const cageShader = `
uniform sampler2D nodeMap, hexMap, heatMap;
uniform float nodeRows, hexRows, heatRows, heatPart;
attribute float hex;
attribute vec4 tint;
varying vec3 ownColor;
varying float heat;
varying float pushed;
vec4 texel(sampler2D map, float i, float rows) {
  float row = floor((i + 0.5) / ${textureWidth}.0);
  return texture2D(map, vec2((i - row * ${textureWidth}.0 + 0.5) / ${textureWidth}.0, (row + 0.5) / rows));
}
vec3 nodeAt(float i) { return texel(nodeMap, i, nodeRows).xyz; }
// s: coordinates in the hex; gives the place, and the cofactors of its gradient times n
vec3 carried(vec3 s, vec3 n, out vec3 turned) {
  vec4 low = texel(hexMap, 2.0 * hex, hexRows), high = texel(hexMap, 2.0 * hex + 1.0, hexRows);
  vec3 p0 = nodeAt(low.x), p1 = nodeAt(low.y), p2 = nodeAt(low.z), p3 = nodeAt(low.w);
  vec3 p4 = nodeAt(high.x), p5 = nodeAt(high.y), p6 = nodeAt(high.z), p7 = nodeAt(high.w);
  vec3 a = mix(mix(p4 - p0, p5 - p1, s.z), mix(p6 - p2, p7 - p3, s.z), s.y);
  vec3 b = mix(mix(p2 - p0, p3 - p1, s.z), mix(p6 - p4, p7 - p5, s.z), s.x);
  vec3 c = mix(mix(p1 - p0, p3 - p2, s.y), mix(p5 - p4, p7 - p6, s.y), s.x);
  turned = normalize(n.x * cross(b, c) + n.y * cross(c, a) + n.z * cross(a, b));
  vec4 hot = texel(heatMap, hex, heatRows);
  heat = heatPart < 1.5 ? hot.x : heatPart < 2.5 ? hot.y : hot.z;
  pushed = hot.z;
  ownColor = tint.rgb * tint.rgb;
  return mix(mix(mix(p0, p1, s.z), mix(p2, p3, s.z), s.y), mix(mix(p4, p5, s.z), mix(p6, p7, s.z), s.y), s.x);
}
`;

function carriedMaterial(material, uniforms) {
  material.onBeforeCompile = shader => {
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = cageShader + shader.vertexShader
      .replace('#include <beginnormal_vertex>', 'vec3 objectNormal; vec3 place = carried(position, normal, objectNormal);')
      .replace('#include <begin_vertex>', shader.vertexShader.includes('#include <beginnormal_vertex>') && !material.isMeshDepthMaterial
        ? 'vec3 transformed = place;' : 'vec3 unused; vec3 transformed = carried(position, vec3(0.0, 1.0, 0.0), unused);');
    shader.fragmentShader = 'uniform sampler2D rampMap; uniform float heatPart, showHeld; varying float heat; varying float pushed; varying vec3 ownColor;\n' +
      shader.fragmentShader.replace('#include <color_fragment>', `
        diffuseColor.rgb = ownColor;
        if (heatPart > 0.5) {
          float share = heatPart < 1.5 ? heat * 255.0 / 200.0 : heat;
          diffuseColor.rgb = texture2D(rampMap, vec2(clamp(share, 0.002, 0.998), 0.5)).rgb;
        }
        if (showHeld > 0.5 && pushed > 0.0) diffuseColor.rgb = mix(diffuseColor.rgb, vec3(1.0, 0.22, 0.02), 0.75);`);
  };
  return material;
}

class Body {
  // bytes: as tools/live/wire.h has them; about: the scene's words on it
  constructor(bytes, about, ramp) {
    const [magic, numVertices, numTriangles, numHexes, numNodes] = new Uint32Array(bytes, 0, 5);
    if (magic !== 0x42584d55) throw new Error('no body');
    this.about = about;
    this.numNodes = numNodes, this.numHexes = numHexes;
    this.hexes = new Uint32Array(bytes, 20, 8 * numHexes);
    this.readVertices(bytes, 20 + 32 * numHexes, numVertices);
    this.triangles = new Uint32Array(bytes, 20 + 32 * numHexes + 16 * numVertices, 3 * numTriangles);
    this.nodes = new Float32Array(3 * numNodes);
    this.makeTextures(ramp);
    this.group = new THREE.Group();
    this.group.add(this.makeSurface(), this.cage = this.makeCage());
  }

  readVertices(bytes, at, count) {
    this.vertexHex = new Uint32Array(count);
    this.local = new Uint16Array(4 * count);
    this.colors = new Uint8Array(4 * count);
    this.normals = new Int8Array(4 * count);
    const longs = new Uint32Array(bytes, at, 4 * count), shorts = new Uint16Array(bytes, at, 8 * count), chars = new Int8Array(bytes, at, 16 * count), codes = new Uint8Array(bytes, at, 16 * count);
    for (let v = 0; v < count; ++v) {
      this.vertexHex[v] = longs[4 * v];
      for (let k = 0; k < 3; ++k) this.local[4 * v + k] = shorts[8 * v + 2 + k], this.normals[4 * v + k] = chars[16 * v + 12 + k];
      this.colors.set([codes[16 * v + 10], codes[16 * v + 11], codes[16 * v + 15], 255], 4 * v);
    }
  }

  makeTextures(ramp) {
    this.nodeMap = dataTexture(this.numNodes, THREE.FloatType);
    this.hexMap = dataTexture(2 * this.numHexes, THREE.FloatType);
    this.heatMap = dataTexture(this.numHexes, THREE.UnsignedByteType);
    for (let i = 0; i < 8 * this.numHexes; ++i) this.hexMap.image.data[i] = this.hexes[i];
    this.uniforms = {
      nodeMap: {value: this.nodeMap}, hexMap: {value: this.hexMap}, heatMap: {value: this.heatMap}, rampMap: {value: ramp},
      nodeRows: {value: this.nodeMap.image.height}, hexRows: {value: this.hexMap.image.height}, heatRows: {value: this.heatMap.image.height},
      heatPart: {value: 0}, showHeld: {value: 0}};
  }

  makeSurface() {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(this.local, 4, true));
    geometry.setAttribute('normal', new THREE.BufferAttribute(this.normals, 4, true));
    geometry.setAttribute('tint', new THREE.BufferAttribute(this.colors, 4, true));
    geometry.setAttribute('hex', new THREE.BufferAttribute(Float32Array.from(this.vertexHex), 1));
    geometry.setIndex(new THREE.BufferAttribute(this.triangles, 1));
    const mesh = new THREE.Mesh(geometry, carriedMaterial(new THREE.MeshStandardMaterial({color: 0xffffff, roughness: 0.62, metalness: 0, side: THREE.DoubleSide}), this.uniforms));
    mesh.customDepthMaterial = carriedMaterial(new THREE.MeshDepthMaterial({depthPacking: THREE.RGBADepthPacking, side: THREE.DoubleSide}), this.uniforms);
    mesh.frustumCulled = false;
    mesh.castShadow = mesh.receiveShadow = true;
    return mesh;
  }

  makeCage() {
    const edges = new Set();
    for (let e = 0; e < this.numHexes; ++e)
      for (let n = 0; n < 8; ++n)
        for (const bit of [1, 2, 4])
          if (!(n & bit)) {
            const a = this.hexes[8 * e + n], b = this.hexes[8 * e + (n | bit)];
            edges.add(Math.min(a, b) * this.numNodes + Math.max(a, b));
          }
    const ends = new Float32Array(2 * edges.size);
    let at = 0;
    for (const edge of edges) ends[at++] = Math.floor(edge / this.numNodes), ends[at++] = edge % this.numNodes;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * ends.length), 3));
    geometry.setAttribute('node', new THREE.BufferAttribute(ends, 1));
    const lines = new THREE.LineSegments(geometry, new THREE.ShaderMaterial({
      uniforms: this.uniforms, transparent: true, depthTest: false,
      vertexShader: `uniform sampler2D nodeMap; uniform float nodeRows; attribute float node;
        void main() { float row = floor((node + 0.5) / ${textureWidth}.0);
          vec3 p = texture2D(nodeMap, vec2((node - row * ${textureWidth}.0 + 0.5) / ${textureWidth}.0, (row + 0.5) / nodeRows)).xyz;
          gl_Position = projectionMatrix * viewMatrix * vec4(p, 1.0); }`,
      fragmentShader: 'void main() { gl_FragColor = vec4(0.85, 0.9, 1.0, 0.28); }'}));
    lines.frustumCulled = false;
    lines.visible = false;
    return lines;
  }

  // Nodes [m], and of each hex energy, stretch, multiplier (0 ... 255).
  move(nodes, heat) {
    this.nodes = nodes;
    const places = this.nodeMap.image.data, hot = this.heatMap.image.data;
    for (let i = 0; i < this.numNodes; ++i) places.set(nodes.subarray(3 * i, 3 * i + 3), 4 * i);
    for (let e = 0; e < this.numHexes; ++e) for (let k = 0; k < 3; ++k) hot[4 * e + k] = heat[k] ? heat[k][e] : 0;
    this.nodeMap.needsUpdate = this.heatMap.needsUpdate = true;
  }

  // Where a vertex is now, written to out from `at` on.
  place(v, out, at) {
    const base = 8 * this.vertexHex[v], x = this.local[4 * v] / 65535, y = this.local[4 * v + 1] / 65535, z = this.local[4 * v + 2] / 65535;
    out[at] = out[at + 1] = out[at + 2] = 0;
    for (let n = 0; n < 8; ++n) {
      const w = (n & 4 ? x : 1 - x) * (n & 2 ? y : 1 - y) * (n & 1 ? z : 1 - z), node = 3 * this.hexes[base + n];
      for (let k = 0; k < 3; ++k) out[at + k] += w * this.nodes[node + k];
    }
  }

  // The nearest hit of a ray: {distance, point, vertex}, or null.
  hit(ray) {
    const count = this.vertexHex.length, all = new Float32Array(3 * count);
    for (let v = 0; v < count; ++v) this.place(v, all, 3 * v);
    const corners = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()], point = new THREE.Vector3();
    let best = null;
    for (let t = 0; t < this.triangles.length; t += 3) {
      for (let k = 0; k < 3; ++k) corners[k].fromArray(all, 3 * this.triangles[t + k]);
      if (!ray.intersectTriangle(corners[0], corners[1], corners[2], false, point)) continue;
      const distance = point.distanceTo(ray.origin);
      if (best && best.distance <= distance) continue;
      const lengths = corners.map(corner => corner.distanceTo(point)), k = lengths.indexOf(Math.min(...lengths));
      best = {distance, point: point.clone(), vertex: this.triangles[t + k]};
    }
    return best;
  }
}
