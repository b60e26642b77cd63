'use strict';
// In the worker, behind emscripten's script: files of the page go to the engine's memory, its answers back. One request at a time
// (view/engine.js).

let Module = null;
const lines = []; // that the engine wrote to stderr
let working = false; // at the studio's jobs: what is written is theirs

// `threads`: the scripts of the module and of its threads, where it has some.
async function start({ wasm, weights, threads }) {
  Module = await makeEngine({
    wasmBinary: wasm,
    mainScriptUrlOrBlob: threads ? new Blob([threads.script]) : undefined,
    locateFile: (name) => (threads && name.endsWith('.worker.js') ? URL.createObjectURL(new Blob([threads.worker])) : name),
    print: (text) => (working ? hearLine(0, text) : postMessage({ kind: 'log', text })),
    printErr: (text) => (working ? hearLine(0, text) : lines.push(text)),
    preRun: [(module) => { module.ENV.FFPROCAMS_MODELS = '/models'; }],
  });
  Module.FS.mkdir('/models');
  openEvents();
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

// Events of a running command (--events): lines of JSON, in pieces.
const events = { file: 0, rest: '', error: null, text: new TextDecoder() };

function hear(bytes) {
  const told = (events.rest + events.text.decode(bytes, { stream: true })).split('\n');
  events.rest = told.pop();
  if (working) { told.forEach((line) => hearLine(1, line)); return; }
  for (const { event, finding, text, ...more } of told.map((line) => JSON.parse(line))) {
    if (event === 'progress') postMessage({ kind: 'progress', ...more });
    else if (event === 'finding') postMessage({ kind: 'finding', finding: JSON.stringify(finding) });
    else if (event === 'error') events.error = { text, fault: more.fault };
    else postMessage({ kind: 'log', text });
  }
}

function openEvents() {
  const device = Module.FS.makedev(64, 0);
  Module.FS.registerDevice(device, { write: (stream, memory, from, length) => { hear(memory.slice(from, from + length)); return length; } });
  Module.FS.mkdev('/dev/events', device);
  events.file = Module.FS.open('/dev/events', 'w').fd;
}

// A command line of the program; what it makes is below /made, which is empty before.
function command({ words }) {
  if (Module.FS.analyzePath('/made').exists) removeFolder('/made');
  Module.FS.mkdir('/made');
  events.error = null;
  const all = ['ffprocams', '--events', String(events.file), ...words];
  const status = Module.ccall('engine_command', 'number', ['string'], [all.map((word) => `${word}\n`).join('')]);
  const said = lines.splice(0).filter((line) => !line.includes(': see: ')).map((line) => line.replace(/^ffprocams: (error: )?/, '')).join(' '), { error } = events;
  if (status !== 0) throw Object.assign(new Error(error ? error.text : said), { fault: !!error && error.fault });
  return {};
}

// --- The studio (wasm/product/studio/page.c): its folder is in the browser's storage, too, where every request's changes are one
// transaction, complete before it is answered. ---

const kept = { base: null, stamps: new Map() }; // by path: what is stored

const done = (request) => new Promise((resolve, reject) => { request.onsuccess = () => resolve(request.result); request.onerror = () => reject(request.error); });

async function loadFolder() {
  const opening = indexedDB.open('ffprocams studio', 1);
  opening.onupgradeneeded = () => opening.result.createObjectStore('files');
  kept.base = await done(opening).catch(({ message }) => { throw new Error(`The browser keeps nothing for this page (a private window, or blocked site data): ${message}`); });
  const files = kept.base.transaction('files').objectStore('files'), paths = await done(files.getAllKeys());
  for (const path of paths) {
    const bytes = await done(kept.base.transaction('files').objectStore('files').get(path));
    Module.FS.mkdirTree(path.replace(/\/[^/]*$/, ''));
    Module.FS.writeFile(path, bytes);
    kept.stamps.set(path, stampOf(Module.FS.stat(path)));
  }
}

const stampOf = ({ ino, mtime, size }) => `${ino} ${mtime.getTime()} ${size}`;

function* filesBelow(folder) {
  for (const name of Module.FS.readdir(folder)) {
    if (name === '.' || name === '..') continue;
    const path = `${folder}/${name}`, stat = Module.FS.stat(path);
    if (Module.FS.isDir(stat.mode)) yield* filesBelow(path); else yield [path, stampOf(stat)];
  }
}

// A disk that is full, or a person who allows no storage, is an error, and nothing of the changes is stored.
async function keepFolder() {
  const now = new Map(filesBelow('/studio')), gone = [...kept.stamps.keys()].filter((path) => !now.has(path));
  const changed = [...now].filter(([path, stamp]) => kept.stamps.get(path) !== stamp);
  if (!gone.length && !changed.length) return;
  const change = kept.base.transaction('files', 'readwrite', { durability: 'strict' }), files = change.objectStore('files');
  const stored = new Promise((resolve, reject) => {
    change.oncomplete = resolve;
    change.onabort = () => reject(new Error(`The browser does not store this (${change.error ? change.error.name : 'aborted'}): is the disk full?`));
  });
  try {
    for (const path of gone) files.delete(path);
    for (const [path] of changed) files.put(Module.FS.readFile(path), path);
  } catch (error) {
    stored.catch(() => {});
    change.abort();
    throw error;
  }
  await stored;
  kept.stamps = now;
}

const stateNow = () => ({ state: JSON.parse(Module.ccall('studio_state', 'string', [], [])) });

async function studioOpen({ run }) {
  Module.FS.mkdir('/studio');
  await loadFolder();
  const wrong = Module.ccall('studio_open', 'string', ['number'], [run]);
  if (wrong) throw new Error(wrong);
  await keepFolder();
  return stateNow();
}

async function studioPost({ path, set = '', number = '', watch = '', bytes }) {
  const at = Module._malloc(bytes.length + 1) >>> 0;
  if (!at) throw new Error('There is no memory for this.');
  Module.HEAPU8.set(bytes, at);
  const text = Module.ccall('studio_post', 'string', ['string', 'string', 'string', 'string', 'number', 'number'], [path, set, number, watch, at, bytes.length]);
  Module._free(at);
  await keepFolder();
  return { state: JSON.parse(text) };
}

function studioFiles() {
  return { files: [...filesBelow('/studio')].map(([path]) => ({ path: path.slice('/studio/'.length), bytes: Module.FS.readFile(path) })) };
}

// Keeps other files in place of all before; the page starts another worker, which opens them.
async function studioReplace({ files }) {
  removeFolder('/studio');
  for (const { path, bytes } of files) {
    Module.FS.mkdirTree(`/studio/${path}`.replace(/\/[^/]*$/, ''));
    Module.FS.writeFile(`/studio/${path}`, bytes);
  }
  if (!files.length) Module.FS.mkdir('/studio');
  await keepFolder();
  return {};
}

let toldLast = 0;

function hearLine(isEvent, line) {
  Module.ccall('studio_hear', null, ['number', 'string'], [isEvent, line]);
  if (performance.now() - toldLast < 200) return;
  toldLast = performance.now();
  postMessage({ kind: 'studio', ...stateNow() });
}

async function studioWork() {
  postMessage({ kind: 'studio', ...stateNow() });
  working = true;
  try {
    Module.ccall('studio_work', 'number', ['number'], [events.file]);
  } finally {
    working = false;
  }
  await keepFolder();
  return stateNow();
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

const read = ({ path }) => ({ bytes: Module.FS.readFile(path) });

const requests = { start, put, command, read, open, run, save: ({ name }) => save(name), studioOpen, studioPost, studioState: stateNow, studioWork, studioFiles, studioReplace };

self.onmessage = async ({ data }) => {
  try {
    postMessage({ kind: 'answer', ...await requests[data.kind](data) });
  } catch (error) {
    postMessage({ kind: 'answer', fault: !!error.fault, error: [error.message || error, ...lines.splice(0)].join(' ') });
  }
};
