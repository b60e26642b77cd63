'use strict';
// ZIP files that the page writes are read again, and no part of a damaged one. Run by node.
const assert = require('assert'), fs = require('fs'), path = require('path'), {runInThisContext} = require('vm');
globalThis.Message = class extends Error {};
runInThisContext(fs.readFileSync(path.join(__dirname, '../../../view/engine_files.js'), 'utf8'), {filename: 'engine_files.js'});
const {zipOf, readZip, crc32} = runInThisContext('({zipOf, readZip, crc32})'), bytesOf = (text) => new TextEncoder().encode(text);

(async () => {
  assert.strictEqual(crc32(bytesOf('123456789')), 0xcbf43926); // its check value
  const files = [{path: 'studio.json', bytes: bytesOf('{}')}, {path: 'objects/a/ü.png', bytes: Uint8Array.from({length: 70000}, (_, i) => i * i)}, {path: 'empty', bytes: new Uint8Array()}];
  const packed = zipOf(files);
  assert.deepStrictEqual(await readZip(Object.assign(packed, {name: 'rig.zip'})), files);
  await assert.rejects(readZip(Object.assign(packed.slice(0, packed.size - 30), {name: 'rig.zip'})), /rig\.zip: /);
})();
