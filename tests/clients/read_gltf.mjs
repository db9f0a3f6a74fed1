// Validates glTF files by the official validator and reads them by glTF Transform: prints what each says as JSON.
// usage: node read_gltf.mjs FILE…    in a folder whose node_modules has both
import fs from 'node:fs';
import path from 'node:path';
import { NodeIO } from '@gltf-transform/core';
import validator from 'gltf-validator';

const told = {};
for (const file of process.argv.slice(2)) {
  const beside = uri => new Uint8Array(fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(uri))));
  const report = await validator.validateBytes(
      new Uint8Array(fs.readFileSync(file)), {uri: path.basename(file), externalResourceFunction: async uri => beside(uri)});
  const { numErrors, numWarnings, messages } = report.issues;
  const document = await new NodeIO().read(file);
  const root = document.getRoot();
  const node = root.listNodes().find(n => n.getMesh());
  const primitives = node.getMesh().listPrimitives();  // of each material
  const primitive = primitives[0];
  const numbers = accessor => accessor ? Array.from(accessor.getArray()) : null;
  const sampler = root.listAnimations()[0]?.listSamplers()[0];
  const camera = root.listNodes().find(n => n.getCamera());
  told[file] = {
    numErrors, numWarnings, messages: messages.slice(0, 5), name: node.getName(),
    indices: primitives.flatMap(part => numbers(part.getIndices())),
    materials: primitives.map(part => part.getMaterial().getName()),
    positions: numbers(primitive.getAttribute('POSITION')),
    coordinates: numbers(primitive.getAttribute('TEXCOORD_0')),
    colors: numbers(primitive.getAttribute('COLOR_0')),
    targets: primitive.listTargets().map(target => numbers(target.getAttribute('POSITION'))),
    times: numbers(sampler?.getInput()), weights: numbers(sampler?.getOutput()),
    texture: primitive.getMaterial().getBaseColorTexture()?.getImage()?.byteLength,
    baseColor: primitive.getMaterial().getBaseColorFactor(),
    camera: camera && {translation: camera.getTranslation(), yfov: camera.getCamera().getYFov()},
  };
}
console.log(JSON.stringify(told));
