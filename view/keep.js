'use strict';
// A person's work as plain data: projectors, their layers, paint, cues and the view. From it come undo,
// the stage's file, and what the browser keeps.

const STAGE_FORMAT = 'ffprocams stage', PROJECTORS_MAX = 16, CUES_MAX = 200, CORRECTIONS = ['none', 'paint', 'colours'], KEEP_AFTER = 1500, SHOW_KEPT_AFTER = 50, FILMS_KEPT = 2000; // ms
const FILES = ' files'; // beside a stage in the store: they are written only when others come
const BLACK_MOST = 0.1;

// Pictures and films that were brought in, the webcam and screens: each keeps its tile, and its file.
class Library {
  constructor(app) {
    this.app = app;
    this.entries = []; // {id, name, content, blob (a file's) or live ('camera', 'screen')}
  }

  // The content of a file, which belongs to the library from now on.
  async take(file, id = null) {
    const content = await contentOfFile(file);
    return this.add({id, name: content.name, blob: file, content});
  }

  addStream(content, id = null) { return this.add({id, name: content.name, live: content.kind, content}); }

  // The camera, of which there is one, or a new stream, which becomes the library's once it runs.
  async startStream(kind) {
    const camera = kind === 'camera' && this.entries.find((entry) => entry.live === kind), content = camera ? camera.content : new StreamContent(kind);
    if (!content.running) await content.start();
    return content.file === undefined ? this.addStream(content) : content;
  }

  add(entry) {
    const {content} = entry;
    if (!entry.id || this.find(entry.id)) entry.id = this.freeId(); // it may have been given away while a file was read
    content.shared = true, content.file = entry.id;
    this.entries.push(entry);
    this.app.changed('library');
    return content;
  }

  freeId() {
    let n = this.entries.length + 1;
    while (this.find(String(n))) n++;
    return String(n);
  }

  find(id) { return this.entries.find((entry) => entry.id === id); }
}

// The data that a content can be made from again.
function describeContent(app, content) {
  if (content instanceof TestContent) return {test: content.name};
  if (content instanceof TextContent) return {text: content.text, colour: content.colour, font: content.font};
  if (content instanceof SolidContent) return {colour: content.colour};
  if (content instanceof EffectContent) return content.description;
  if (content.pattern !== undefined) return {pattern: app.scene.patterns[content.pattern].name};
  return {file: content.file};
}

async function contentOf(app, described) {
  const {test, text, colour, font, pattern, file, effect} = described || {};
  if (test !== undefined && Object.hasOwn(TEST_PATTERNS, test)) return new TestContent(test);
  if (text !== undefined) return new TextContent(clipText(String(text)), checkColour(colour), FONT_NAME.test(font) ? font : FONTS[0]);
  if (effect !== undefined && Object.hasOwn(EFFECTS, effect)) return new EffectContent(effect, checkColour(colour), described);
  if (colour !== undefined) return new SolidContent(checkColour(colour));
  if (file !== undefined && app.library.find(file)) return app.library.find(file).content;
  const index = app.scene.patterns.findIndex((p) => p.name === pattern);
  const found = index >= 0 && await patternContent(app.scene, index), lost = file === undefined ? pattern || effect || test : 'a picture or film';
  if (!found && lost) say(`Not here, and white in its place: ${String(lost).slice(0, 80)}.`);
  return found || new TestContent('White');
}

const checkColour = (colour) => /^#[0-9a-f]{6}$/i.test(colour) ? colour : '#ffffff';

const describeLayers = (app, layers) => layers.map(({source, fit, place, film, on}) => ({source: describeContent(app, source), fit, place: structuredClone(place), film: {...film}, on}));

// Layers as they were described; sources that `present` layers have are theirs, each of them once.
async function layersOf(app, described, present = []) {
  const used = new Set(), layers = [];
  for (const layer of described) {
    const text = JSON.stringify(layer.source), same = present.find(({source}) => !used.has(source) && JSON.stringify(describeContent(app, source)) === text);
    let source = same ? same.source : await contentOf(app, layer.source);
    if (used.has(source) && source.twin) source = await source.twin();
    used.add(source);
    layers.push(new Layer(source, layer));
  }
  return layers;
}

// --- The state. ---

// A copy of a projector's paint, the same as long as nobody paints; null: none.
function paintOf(projector) {
  if (!projector.painted) return null;
  if (projector.paintCopied !== projector.paintVersion) {
    const copy = makeCanvas(projector.paint.width, projector.paint.height);
    copy.getContext('2d').drawImage(projector.paint, 0, 0);
    projector.paintCopy = copy, projector.paintCopied = projector.paintVersion;
  }
  return projector.paintCopy;
}

function stateOf(app) {
  const projectors = app.projectors.map((p) => ({
    device: p.device, on: p.on, stops: p.stops, correction: p.correction, watcher: p.watcher, gain: p.gain,
    layers: describeLayers(app, p.layers), at: p.at, paint: paintOf(p), pixels: p.pixels, found: p.found, window: p.window.where && {...p.window.where, id: p.window.id},
  }));
  return {
    projectors, selected: app.projectors.indexOf(app.projector), exposure: app.exposure, ambient: app.ambient, black: app.black,
    surfaces: app.relief.surfaces, cues: structuredClone(app.show.cues), midi: app.midi.bindings, view: app.scene.views.indexOf(app.at), pose: app.pose, target: app.target,
  };
}

// Two states are the same to undo if they differ in the view and in what is selected only.
function sameWork(a, b) {
  const work = (s) => JSON.stringify([s.projectors.map((p) => ({...p, paint: null, at: 0, window: null})), s.exposure, s.ambient, s.black, s.surfaces, s.cues, s.midi]);
  return work(a) === work(b) && a.projectors.every((p, i) => p.paint === b.projectors[i].paint);
}

// Makes the page show a state; of undo and redo the view stays.
async function applyState(app, state, withView) {
  if (state.projectors.length !== app.projectors.length) app.inShow('there would be another number of projectors');
  const layers = await Promise.all(state.projectors.map((p, i) => layersOf(app, p.layers, app.projectors[i] && app.projectors[i].layers)));
  app.endComparison();
  while (app.projectors.length < state.projectors.length) app.addProjector();
  while (app.projectors.length > state.projectors.length) {
    app.select(app.projectors[app.projectors.length - 1]);
    app.removeProjector();
  }
  state.projectors.forEach((kept, i) => {
    const p = app.projectors[i];
    const {on, stops, correction, watcher, gain} = kept;
    p.device = {...kept.device};
    p.setFound(kept.found || null, app.scene.panel);
    p.setPixels(kept.pixels || null);
    app.setLayers(layers[i], p);
    Object.assign(p, {on, stops, correction, watcher, gain, device: {...kept.device}, at: clamp(kept.at, 0, layers[i].length - 1)});
    if (paintOf(p) !== kept.paint) {
      p.clearPaint();
      if (kept.paint) {
        p.paint.getContext('2d').drawImage(kept.paint, 0, 0, p.paint.width, p.paint.height);
        p.painted = true, p.paintCopy = kept.paint, p.paintCopied = ++p.paintVersion; // the same paint, not another
      }
    }
    p.dirty = true, p.pulls = [];
  });
  app.exposure = state.exposure, app.ambient = state.ambient, app.black = state.black;
  app.relief.surfaces = state.surfaces; // nobody changes them in place
  app.show.cues = structuredClone(state.cues);
  app.midi.bindings = {...state.midi};
  app.show.at = Math.min(app.show.at, app.show.cues.length - 1);
  app.select(app.projectors[clamp(state.selected, 0, app.projectors.length - 1)]);
  if (withView && app.scene.views[state.view]) {
    app.jump(app.scene.views[state.view], false);
    app.pose = state.pose, app.target = state.target;
    if (app.show.armed) app.show.seat = app.seat();
    state.projectors.forEach(({window: kept}, i) => {
      const {id, ...where} = kept || {}, own = app.projectors[i].window;
      if (kept && !own.isOpen) Object.assign(own, {id, where});
    });
  }
  for (const what of ['surfaces', 'content', 'device', 'settings', 'cues', 'midi']) app.changed(what);
  app.invalidate();
}

// --- Undo. ---

const WHEEL_REST = 350; // ms after which the wheel has come to rest

const makeHistory = (app) => new Undo({
  take: () => stateOf(app), same: sameWork, put: (state) => applyState(app, state, false),
  ready: () => !app.show.playing && !app.photograph, told: () => app.changed('history'),
});

// Undo (-1) or redo; a show does not go on behind it.
function unwind(app, step) {
  app.show.stop();
  return app.history.go(step);
}

// Gestures are those of pointers, keys, controls and the wheel; each ends after what it does has been done.
function followGestures(history) {
  const on = (name, work) => addEventListener(name, work, true), later = (work) => setTimeout(work);
  let wheel = 0;
  const rest = () => {
    clearTimeout(wheel);
    if (wheel) wheel = 0, history.end('wheel');
  };
  on('pointerdown', (event) => {
    rest();
    history.begin(event.pointerId);
  });
  for (const name of ['pointerup', 'pointercancel']) on(name, (event) => later(() => history.end(event.pointerId)));
  for (const name of ['click', 'change']) on(name, () => later(() => history.note()));
  on('keyup', (event) => { if (!isText(event.target)) later(() => history.note()); }); // typing ends with its 'change'
  on('wheel', () => {
    if (!wheel) history.begin('wheel');
    clearTimeout(wheel);
    wheel = setTimeout(rest, WHEEL_REST);
  });
}

// --- Files. ---

function bytesToText(bytes) {
  let text = '';
  for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
  return btoa(text);
}

const textOf = async (blob) => bytesToText(new Uint8Array(await blob.arrayBuffer()));

// Paint as PNG in base64, so that it can be written down.
function plainState(state) {
  const text = (paint) => paint.text = paint.text || paint.toDataURL('image/png').split(',')[1]; // a copy stays as it is (paintOf)
  return {...state, projectors: state.projectors.map((p) => ({...p, paint: p.paint && text(p.paint)}))};
}

async function stageText(app) {
  const files = [];
  for (const {id, name, blob, live} of app.library.entries)
    files.push(live ? {id, name, live} : {id, name, type: blob.type, data: await textOf(blob)});
  return JSON.stringify({format: STAGE_FORMAT, object: app.scene.name, ...plainState(stateOf(app)), files});
}

// Checks of what comes from outside, by the name of the field.
const number = (field, value, low, high) => {
  if (!(typeof value === 'number' && value >= low && value <= high)) throw new Message(`The stage's ${field} is not a number from ${low} to ${high}.`);
  return value;
};
const list = (field, value, most) => {
  if (!Array.isArray(value) || value.length > most) throw new Message(`The stage's ${field} is not a list of up to ${most}.`);
  return value;
};
const oneOf = (field, value, words) => {
  if (!words.includes(value)) throw new Message(`The stage's ${field} must be one of ${words.join(', ')}.`);
  return value;
};

function checkDevice(device, size) {
  const d = device || {}, out = {width: size.width, height: size.height};
  for (const name of ['fx', 'fy']) out[name] = number(`projectors: ${name}`, d[name], 1e-3, 1e7);
  for (const name of ['cx', 'cy']) out[name] = number(`projectors: ${name}`, d[name], -1e7, 1e7);
  out.pose = list('projectors: pose', d.pose, 16).map((x) => number('projectors: pose', x, -1e9, 1e9));
  if (out.pose.length !== 16) throw new Message("The stage's projectors: pose has not 16 numbers.");
  return out;
}

async function checkPaint(paint, size) {
  if (!paint) return null;
  const bytes = readBytes(String(paint)), bitmap = await createImageBitmap(new Blob([bytes], {type: 'image/png'}));
  checkSize('The paint', [bitmap.width, bitmap.height]);
  const canvas = makeCanvas(size.width, size.height);
  canvas.getContext('2d').drawImage(bitmap, 0, 0, size.width, size.height);
  bitmap.close();
  return canvas;
}

const pairs = (field, value, most) => list(field, value, most).map((pair) => list(field, pair, 2).map((x) => number(field, x, -1e3, 1e3)));

function checkPlace(p) {
  const amount = (name, low, high) => number(`layers: ${name}`, p[name], low, high);
  const place = {
    x: amount('x', -SHIFT_MAX, SHIFT_MAX), y: amount('y', -SHIFT_MAX, SHIFT_MAX), width: amount('width', ...FACTOR), height: amount('height', ...FACTOR),
    turn: amount('turn', -360, 360), pull: pairs('layers: pull', p.pull, 4), crop: list('layers: crop', p.crop, 4).map((x) => number('layers: crop', x, 0, 1)),
    mask: p.mask ? pairs('layers: mask', p.mask, MASK_MAX) : null, opacity: amount('opacity', 0, 1), feather: amount('feather', 0, FEATHER_MAX),
  };
  if (place.pull.length !== 4 || place.pull.some((pair) => pair.length !== 2) || place.crop.length !== 4) throw new Message("The stage's layers: pull or crop has not four corners or sides.");
  if (!isConvex(cornersOf(layerFrame(place, null, 'contain', 1, 1)))) throw new Message("The stage's layers: pull folds a layer.");
  return place;
}

const triple = (field, value, low, high) => {
  const three = list(field, value, 3).map((x) => number(field, x, low, high));
  if (three.length !== 3) throw new Message(`The stage's ${field} has not three numbers.`);
  return three;
};

function checkSurface(surface) {
  const {id, name, parts} = surface || {};
  return {
    id: Math.round(number('surfaces: id', id, 1, 1e6)), name: String(name || 'Surface').slice(0, SURFACE_NAME_MAX),
    parts: list('surfaces: parts', parts, PARTS_MAX).map((part) => ({
      points: list('surfaces: points', part && part.points, POINTS_MAX).map((point) => triple('surfaces: points', point, -1e9, 1e9)),
      normal: triple('surfaces: normal', part.normal, -1, 1), albedo: triple('surfaces: albedo', part.albedo, 0, 1),
      tolerance: number('surfaces: tolerance', part.tolerance, 0, 1), take: part.take === true,
    })),
  };
}

// Those of a stage; every id is one surface's.
function checkSurfaces(surfaces) {
  const checked = list('surfaces', surfaces, SURFACES_MAX).map(checkSurface);
  if (new Set(checked.map(({id}) => id)).size !== checked.length) throw new Message("The stage's surfaces: id is there twice.");
  if (checked.some(({parts}) => !parts.length || parts.some(({points}) => !points.length))) throw new Message("The stage's surfaces: parts or points are none.");
  return checked;
}

// Layers of a projector or a cue; stages once had one content in their place.
function checkLayers({layers, content, fit = 'contain'}) {
  const checked = list('layers', layers || [{source: content, fit}], LAYERS_MAX).map((layer) => {
    const film = {...newFilm(), ...layer.film};
    return {
      source: layer.source || null, fit: oneOf('layers: fit', layer.fit, ['contain', 'cover', 'stretch']), place: checkPlace({...newPlace(), ...layer.place}),
      film: {volume: number('layers: volume', film.volume, 0, 1), from: number('layers: from', film.from, 0, 1e6), to: number('layers: to', film.to, 0, 1e6)},
      on: layer.on === null || layer.on === undefined ? null : number('layers: on', layer.on, 1, 1e6),
    };
  });
  if (!checked.length) throw new Message("The stage's layers are none.");
  return checked;
}

const PIXELS = [64, 8192]; // of a panel's side
function checkPixels(pixels) {
  const checked = list('projectors: pixels', pixels, 2).map((side) => Math.round(number('projectors: pixels', side, ...PIXELS)));
  if (checked.length !== 2) throw new Message("The stage's projectors: pixels are not two.");
  return checked;
}

const checkWindow = ({left, top, width, height, full, id}) => ({
  left: number('window: left', left, -1e5, 1e5), top: number('window: top', top, -1e5, 1e5),
  width: number('window: width', width, 1, 1e5), height: number('window: height', height, 1, 1e5), full: full === true,
  id: /^[0-9a-z]{1,32}$/.test(id) ? id : null,
});

// A state from a file or from the browser's store.
async function checkState(app, plain) {
  const own = app.projectors.find(({found}) => !found) || app.projectors[0], size = own.found ? app.scene.views[0].projector : own.device, projectors = [];
  for (const p of list('projectors', plain.projectors, PROJECTORS_MAX)) {
    const [width, height] = p.found ? checkPixels([p.found.width, p.found.height]) : [size.width, size.height], found = p.found ? checkDevice(p.found, {width, height}) : null;
    projectors.push({
      device: checkDevice(p.device, {width, height}), found, on: p.on !== false, stops: number('projectors: stops', p.stops, -20, 20),
      gain: number('projectors: gain', p.gain, -20, 20), layers: checkLayers(p), at: number('projectors: at', p.at || 0, 0, LAYERS_MAX),
      correction: oneOf('projectors: correction', p.correction, CORRECTIONS),
      watcher: app.scene.views[p.watcher] ? p.watcher : 'now', paint: await checkPaint(p.paint, own.paint),
      pixels: p.pixels ? checkPixels(p.pixels) : null, window: p.window ? checkWindow(p.window) : null,
    });
  }
  if (!projectors.length) throw new Message('The stage has no projectors.');
  return {
    projectors, selected: number('selected', plain.selected, 0, PROJECTORS_MAX), exposure: number('exposure', plain.exposure, -20, 20),
    ambient: plain.ambient !== false, black: number('black', plain.black || 0, 0, BLACK_MOST), surfaces: checkSurfaces(plain.surfaces || []), cues: list('cues', plain.cues || [], CUES_MAX).map(checkCue), midi: checkBindings(plain.midi),
    view: number('view', plain.view, 0, 1e6), pose: checkDevice({...size, pose: plain.pose}, size).pose,
    target: list('target', plain.target, 3).map((x) => number('target', x, -1e9, 1e9)),
  };
}

// The library's entry of the same file as a stage's, or of the same camera or screen; undefined: there is none.
async function entryOf(library, id, live, data) {
  for (const entry of library.entries)
    if (live ? entry.live === live && (live === 'camera' || entry.id === id) : entry.blob && Math.ceil(entry.blob.size / 3) * 4 === data.length && await textOf(entry.blob) === data) return entry;
  return undefined;
}

// A file of stageText: it replaces what the page shows, or a message says why not and nothing changes.
async function loadStage(app, text) {
  let plain = null;
  try {
    plain = JSON.parse(text);
  } catch {
    // told below
  }
  if (!plain || plain.format !== STAGE_FORMAT) throw new Message('This file is not a stage that this page saved.');
  const state = await checkState(app, plain), renamed = new Map(); // other files may be here by the same names
  for (const {id: own, name, type, data, live} of list('files', plain.files || [], 200)) {
    const there = await entryOf(app.library, String(own), live, data), id = there ? there.id : app.library.find(String(own)) ? app.library.freeId() : String(own);
    renamed.set(String(own), id);
    if (there) continue;
    if (live) {
      app.library.addStream(new StreamContent(oneOf('files: live', live, ['camera', 'screen'])), id);
      continue;
    }
    renamed.set(String(own), (await app.library.take(new File([readBytes(String(data))], String(name), {type: String(type)}), id)).file);
  }
  for (const layer of [...state.projectors, ...state.cues.flatMap(({shown}) => shown)].flatMap(({layers}) => layers))
    if (layer.source && renamed.has(layer.source.file)) layer.source = {...layer.source, file: renamed.get(layer.source.file)};
  app.show.stop(); // a cue of before that still waits for its pictures
  await applyState(app, state, true);
  app.history.note();
  const missing = fontsOf(plain).filter((font) => !hasFont(font));
  if (missing.length) say(`Not on this computer: the font${missing.length > 1 ? 's' : ''} ${missing.join(', ')}. The text is shown in another.`);
}

// The fonts of a stage's texts, those of cues, too.
function fontsOf(stage) {
  const fonts = new Set();
  JSON.stringify({...stage, files: null}, (key, value) => {
    if (key === 'font' && FONT_NAME.test(value)) fonts.add(value);
    return value;
  });
  return [...fonts];
}

function offer(blob, name) {
  const link = element('a', {href: URL.createObjectURL(blob), download: name});
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

async function saveStage(app) {
  const name = `${app.scene.name || 'object'}.stage.json`;
  offer(new Blob([await stageText(app)], {type: 'application/json'}), name);
  say(`Saved ${name}: projectors, pictures, paint, cues and view. Open it here again, or drop it on the page.`);
}

// The picture for the real projector, as its window shows it.
function savePattern(app) {
  app.updatePatterns();
  const {width, height, data} = panelPicture(app.graphics, app.projector, app.projector.panel, app.exported = app.exported || {});
  const canvas = makeCanvas(width, height);
  canvas.getContext('2d').putImageData(new ImageData(data, width, height), 0, 0);
  const name = `${app.scene.name || 'object'}-projector-${app.projector.number}.png`;
  canvas.toBlob((blob) => {
    offer(blob, name);
    say(`Saved ${name}, ${width} × ${height}: send it to the projector pixel for pixel.`);
    app.exports = (app.exports || 0) + 1;
  }, 'image/png');
}

// --- The browser's store. ---

const STORE_PATIENCE = 10000; // ms

// Keeps the stage of each page by what it shows; where the browser stores nothing (private windows), nothing is kept.
class Store {
  constructor(app) {
    // the studio's object is drafted, made finer and made again under one name
    this.app = app, this.key = JSON.stringify([app.scene.name, ...(location.protocol === 'file:' ? [app.scene.splats.count, app.scene.high] : [])]);
    app.listeners.push((what) => {
      if (what === 'history') this.soon();
      if (what === 'cues' || what === 'windows') this.soon(SHOW_KEPT_AFTER);
    });
    setInterval(() => { if (app.show.armed && app.playing) this.keep(); }, FILMS_KEPT); // where films are
  }

  open() {
    return new Promise((resolve, reject) => {
      const request = indexedDB.open('ffprocams', 1);
      request.onupgradeneeded = () => request.result.createObjectStore('stages');
      request.onsuccess = () => resolve(request.result);
      request.onerror = () => reject(request.error);
      setTimeout(() => reject(new Error('The browser\u2019s store does not answer.')), STORE_PATIENCE); // as WebKit's at times
    });
  }

  async transact(mode, work) {
    const base = await this.open();
    try {
      return await new Promise((resolve, reject) => {
        const transaction = base.transaction('stages', mode), request = work(transaction.objectStore('stages'));
        transaction.oncomplete = () => resolve(request.result);
        transaction.onerror = transaction.onabort = () => reject(transaction.error);
      });
    } finally {
      base.close();
    }
  }

  soon(after = KEEP_AFTER) {
    const due = performance.now() + after;
    if (this.timer && this.due < due) return;
    clearTimeout(this.timer);
    this.due = due, this.timer = setTimeout(() => this.keep(), after);
  }

  async keep() {
    clearTimeout(this.timer), this.timer = 0;
    const {app} = this, files = app.library.entries.map(({id, name, blob, live}) => ({id, name, blob, live})), ids = files.map(({id}) => id).join();
    const text = JSON.stringify({...plainState(stateOf(app)), show: app.show.state});
    await this.transact('readwrite', (store) => {
      if (this.files !== ids) store.put(files, this.key + FILES);
      return store.put({text}, this.key);
    }).then(() => { this.files = ids, app.kept = (app.kept || 0) + 1; }, () => {});
  }

  // The page as it was left, if this browser kept it; false: it did not.
  async restore() {
    const [kept, files] = await Promise.all(['', FILES].map((part) => this.transact('readonly', (store) => store.get(this.key + part)).catch(() => null)));
    if (!kept) return false;
    const plain = JSON.parse(kept.text), state = await checkState(this.app, plain), show = plain.show && checkShow(plain.show);
    for (const {id, name, blob, live} of files || kept.files || []) // stages once had theirs with them
      if (live) this.app.library.addStream(new StreamContent(live), id);
      else await this.app.library.take(new File([blob], name, {type: blob.type}), id).catch(() => null);
    await applyState(this.app, state, true);
    if (show) this.app.show.resume(show);
    return true;
  }

  forget() {
    clearTimeout(this.timer);
    this.timer = 0, this.files = undefined;
    return this.transact('readwrite', (store) => { store.delete(this.key + FILES); return store.delete(this.key); }).catch(() => {});
  }
}
