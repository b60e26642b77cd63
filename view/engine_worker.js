'use strict';
// In the worker, behind emscripten's script: files of the page go to the engine's memory, its answers back. One request at a time
// (view/engine.js).

let Module = null;
const lines = []; // that the engine wrote to stderr

async function start({ wasm, weights }) {
  Module = await makeEngine({
    wasmBinary: wasm,
    print: (text) => postMessage({ kind: 'log', text }),
    printErr: (text) => lines.push(text),
  });
  Module.FS.mkdir('/models');
  Module.FS.writeFile('/models/small.safetensors', weights);
  return {};
}

// Calls a function of the engine that returns text; "error: ..." becomes an error.
function call(name, types, values) {
  const text = Module.ccall(name, 'string', types, values);
  if (text.startsWith('error: ')) throw new Error(text.slice(7));
  return text;
}

function removeFolder(path) {
  for (const name of Module.FS.readdir(path)) {
    if (name === '.' || name === '..') continue;
    const child = `${path}/${name}`;
    if (Module.FS.isDir(Module.FS.stat(child).mode)) removeFolder(child); else Module.FS.unlink(child);
  }
  Module.FS.rmdir(path);
}

function open({ files, root }) {
  if (Module.FS.analyzePath('/capture').exists) removeFolder('/capture');
  Module.FS.mkdir('/capture');
  for (const { path, bytes } of files) {
    const folder = `/capture/${path}`.replace(/\/[^/]*$/, '');
    if (!Module.FS.analyzePath(folder).exists) Module.FS.mkdirTree(folder);
    Module.FS.writeFile(`/capture/${path}`, bytes);
  }
  call('engine_open', ['string'], [root ? `/capture/${root}` : '/capture']);
  return {};
}

function save(name) {
  call('engine_save', ['string'], [`/${name}`]);
  const bytes = Module.FS.readFile(`/${name}`);
  Module.FS.unlink(`/${name}`);
  return { bytes };
}

function run({ polish, force }) {
  const begin = performance.now();
  const stats = JSON.parse(call('engine_run', ['number', 'number'], [polish, force ? 1 : 0]));
  stats.seconds = (performance.now() - begin) / 1000;
  stats.memory = Module.ccall('engine_peak', 'number', [], []);
  return { stats, page: save('view.html').bytes };
}

const requests = { start, open, run, save: ({ name }) => save(name) };

self.onmessage = async ({ data }) => {
  try {
    postMessage({ kind: 'answer', ...await requests[data.kind](data) });
  } catch (error) {
    postMessage({ kind: 'answer', error: [error.message || error, ...lines.splice(0)].join(' ') });
  }
};
