'use strict';
// The page's folder in the browser's storage: changes alone are stored, and an error is told and loses nothing. Run by node.
const assert = require('assert'), fs = require('fs'), path = require('path'), {runInThisContext} = require('vm');
const source = fs.readFileSync(path.join(__dirname, '../../../view/engine_worker.js'), 'utf8');
globalThis.self = {}, globalThis.postMessage = () => {};
runInThisContext(source, {filename: 'engine_worker.js'});
const {kept, keepFolder, setModule} = runInThisContext('({kept, keepFolder, setModule: (module) => { Module = module; }})');

// A folder of files, and a store that takes them or is full.
const files = new Map(), stored = new Map();
let full = false, puts = 0;
setModule({FS: {
  readdir: (folder) => ['.', '..', ...new Set([...files.keys()].filter((name) => name.startsWith(folder + '/')).map((name) => name.slice(folder.length + 1).split('/')[0]))],
  stat: (name) => ({ino: files.has(name) ? files.get(name).ino : 0, mode: files.has(name) ? 'file' : 'folder', mtime: new Date(0), size: 1}),
  isDir: (mode) => mode === 'folder',
  readFile: (name) => files.get(name).text,
}});
kept.base = {transaction() {
  const changes = [], change = {error: {name: 'QuotaExceededError'}, objectStore: () => ({
    put: (value, key) => { puts++; changes.push(() => stored.set(key, value)); },
    delete: (key) => changes.push(() => stored.delete(key)),
  })};
  setImmediate(() => {
    if (full) { change.onabort(); return; }
    changes.forEach((work) => work());
    change.oncomplete();
  });
  return change;
}};
let made = 0;
const write = (name, text) => files.set(name, {ino: ++made, text});

(async () => {
  write('/studio/studio.json', 'a'), write('/studio/patterns/001.png', 'b');
  await keepFolder();
  assert.deepStrictEqual([...stored], [['/studio/studio.json', 'a'], ['/studio/patterns/001.png', 'b']]);
  await keepFolder();
  assert.strictEqual(puts, 2); // nothing has changed
  full = true;
  write('/studio/studio.json', 'c');
  await assert.rejects(keepFolder(), /does not store this \(QuotaExceededError\): is the disk full\?/);
  assert.strictEqual(stored.get('/studio/studio.json'), 'a');
  full = false;
  files.delete('/studio/patterns/001.png');
  await keepFolder(); // what failed is stored with what came since
  assert.deepStrictEqual([...stored], [['/studio/studio.json', 'c']]);
})();
