'use strict';
// In the worker, behind emscripten's script: files of the page go to the engine's memory, its answers back. One request at a time
// (view/engine.js).

let Module = null;
const lines = []; // that the engine wrote to stderr

// `threads`: the scripts of the module and of its threads, where it has some.
async function start({ wasm, weights, threads }) {
  Module = await makeEngine({
    wasmBinary: wasm,
    mainScriptUrlOrBlob: threads ? new Blob([threads.script]) : undefined,
    locateFile: (name) => (threads && name.endsWith('.worker.js') ? URL.createObjectURL(new Blob([threads.worker])) : name),
    print: (text) => postMessage({ kind: 'log', text }),
    printErr: (text) => lines.push(text),
  });
  Module.FS.mkdir('/models');
  Module.FS.writeFile('/models/small.safetensors', weights);
  return {};
}

// Calls a function of the engine that returns text; "error: ..." becomes an error, and "fault: ..." one that can be forced.
function call(name, types, values) {
  const text = Module.ccall(name, 'string', types, values), kind = text.slice(0, 7);
  if (kind === 'error: ' || kind === 'fault: ') throw Object.assign(new Error(text.slice(7)), { fault: kind === 'fault: ' });
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

function put({ files }) {
  if (Module.FS.analyzePath('/dropped').exists) removeFolder('/dropped');
  Module.FS.mkdir('/dropped');
  for (const { path, bytes } of files) {
    const folder = `/dropped/${path}`.replace(/\/[^/]*$/, '');
    if (!Module.FS.analyzePath(folder).exists) Module.FS.mkdirTree(folder);
    Module.FS.writeFile(`/dropped/${path}`, bytes);
  }
  return {};
}

// A capture from what was dropped; its folder takes its place. Paths are those of the dropped files.
function make({ calibration, turntable, angles, shown, images, width, response, name }) {
  const at = (path) => (path ? `/dropped/${path}` : '');
  const folder = `/made/${name}`, numbers = new Uint8Array(new Float64Array(angles).buffer);
  if (Module.FS.analyzePath('/made').exists) removeFolder('/made');
  Module.FS.mkdir('/made');
  call('engine_import', ['string', 'string', 'array', 'number', 'string', 'string', 'number', 'number', 'string'],
    [at(calibration), at(turntable), numbers, angles.length, at(shown), at(images), width, response ? 1 : 0, folder]);
  return { folder };
}

function open({ folder }) {
  return { text: call('engine_open', ['string'], [folder]) };
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

const requests = { start, put, make, open, run, save: ({ name }) => save(name) };

self.onmessage = async ({ data }) => {
  try {
    postMessage({ kind: 'answer', ...await requests[data.kind](data) });
  } catch (error) {
    postMessage({ kind: 'answer', fault: !!error.fault, error: [error.message || error, ...lines.splice(0)].join(' ') });
  }
};
