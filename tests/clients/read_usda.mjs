// Reads .usda files by three.js: prints attributes by their paths, and the layers' metadata, as JSON.
// usage: node read_usda.mjs FILE…    in a folder whose node_modules has three
import fs from 'node:fs';
import { USDAParser } from 'three/examples/jsm/loaders/usd/USDAParser.js';

const told = {};
for (const file of process.argv.slice(2)) {
  // clips are layers of overs, which this parser walks by only as definitions
  const text = fs.readFileSync(file, 'utf8').replace(/^( *)over "/gm, '$1def "');
  const { specsByPath } = new USDAParser().parseData(text);
  told[file] = Object.fromEntries(Object.entries(specsByPath).map(([path, spec]) => [path, spec.fields]));
}
console.log(JSON.stringify(told));
