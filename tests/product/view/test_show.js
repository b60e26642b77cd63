'use strict';
// The page's contents, cues, stages and findings without a page: what is checked, in which order things come, what is let go. Run by node.
const assert = require('assert'), fs = require('fs'), path = require('path'), {runInThisContext} = require('vm');

// Stand-ins for the page; messages to the user are kept.
const said = [], waiting = [];
Object.assign(globalThis, {
  say: (text) => said.push(text), attempt: (work) => work, shortName: (id) => id.replace(/_/g, ' '),
  setTimeout: (work, ms) => waiting.push({work, ms}), clearTimeout: (number) => { if (number) waiting[number - 1].work = null; },
  document: {createElement: (tag) => ({tag, dataset: {}, children: [], append(child) { this.children.push(child); }})},
});
for (const name of ['math', 'place', 'surfaces', 'layers', 'contents', 'effects', 'control', 'history', 'keep', 'show', 'findings'])
  runInThisContext(fs.readFileSync(path.join(__dirname, `../../../view/${name}.js`), 'utf8'), {filename: `${name}.js`});
const {Show, checkCue, checkState, checkLayers, checkWindow, sizeInHead, sizeOfFile, checkSize, Message, SolidContent, Layer, describeLayers, findingItem, isPassed, newPlace, PROJECTORS_MAX, LAYERS_MAX,
  CUES_MAX, FADE_MAX, FOLLOW_MAX, MASK_MAX, applyState, reachingOut, faultSaid, checkSurfaces, contentOf, describeContent, SURFACES_MAX, PARTS_MAX, POINTS_MAX, Library, loadStage, STAGE_FORMAT} = runInThisContext('({Show, checkCue, checkState, checkLayers, checkWindow, sizeInHead, sizeOfFile, checkSize, Message, SolidContent, Layer, describeLayers, findingItem, '
  + 'isPassed, newPlace, PROJECTORS_MAX, LAYERS_MAX, CUES_MAX, FADE_MAX, FOLLOW_MAX, MASK_MAX, applyState, reachingOut, faultSaid, checkSurfaces, contentOf, describeContent, SURFACES_MAX, PARTS_MAX, POINTS_MAX, Library, loadStage, STAGE_FORMAT})');
const refuses = (work, field) => assert.throws(work, (error) => error instanceof Message && error.message.includes(field), field);

// --- The sizes that picture files give. ---
const bytes = (...parts) => Uint8Array.from(parts.flatMap((part) => typeof part === 'string' ? [...part].map((c) => c.charCodeAt(0)) : part));
const heads = {
  png: bytes(0x89, 'PNG\r\n\x1a\n', [0, 0, 0, 13], 'IHDR', [0, 0, 1, 2], [0, 0, 0, 7]),
  gif: bytes('GIF89a', [0x02, 0x01], [0x07, 0x00]),
  bmp: bytes('BM', new Array(16).fill(0), [0x02, 0x01, 0, 0], [0xf9, 0xff, 0xff, 0xff]),
  webp: bytes('RIFF', [0, 0, 0, 0], 'WEBPVP8 ', new Array(10).fill(0), [0x02, 0x41], [0x07, 0x00]),
  lossless: bytes('RIFF', [0, 0, 0, 0], 'WEBPVP8L', [0, 0, 0, 0, 0x2f], [0x01, 0x81, 0x01, 0x00], new Array(5).fill(0)),
  extended: bytes('RIFF', [0, 0, 0, 0], 'WEBPVP8X', [10, 0, 0, 0], [0, 0, 0, 0], [0x01, 0x01, 0], [6, 0, 0]),
  avif: bytes([0, 0, 0, 8], 'ftypavif', 'ispe', [0, 0, 0, 0], [0, 0, 0, 3], [0, 0, 0, 4], 'ispe', [0, 0, 0, 0], [0, 0, 1, 2], [0, 0, 0, 7]),
};
for (const [kind, head] of Object.entries(heads)) assert.deepStrictEqual(sizeInHead(head), [258, 7], kind);
for (const head of Object.values(heads)) assert.strictEqual(sizeInHead(head.subarray(0, 8)), null);
assert.strictEqual(sizeInHead(bytes('<svg xmlns="http://www.w3.org/2000/svg"/>')), null);
checkSize('It', [16384, 6103]);
for (const huge of [[16385, 1], [1, 16385], [10001, 10000]]) refuses(() => checkSize('It', huge), 'more than a projector shows');

// --- Cues. ---
const place = newPlace(), layer = (fit = 'cover') => ({source: {kind: 'solid', colour: '#ff0000'}, fit, place, film: {volume: 1, from: 0, to: 0}, on: null});
const cue = (changes) => checkCue({name: 'One', fade: 2, follow: null, shown: [{layers: [layer()], correction: 'paint', watcher: 'v'}], ...changes});
assert.deepStrictEqual(JSON.parse(JSON.stringify(cue())), {name: 'One', fade: 2, follow: null, pose: null, shown: [{layers: [layer()], correction: 'paint', watcher: 'v'}]});
assert.strictEqual(cue({name: ''}).name, 'Cue');
assert.strictEqual(cue({name: 'x'.repeat(99)}).name.length, 80);
assert.strictEqual(cue({follow: undefined, hold: 3}).follow, 3); // stages once had `hold`
assert.deepStrictEqual(JSON.parse(JSON.stringify(cue({shown: [{kind: 'solid'}]}).shown[0].layers[0].source)), {kind: 'solid'}); // and one content
for (const [changes, field] of [[{fade: -1}, 'cues: fade'], [{fade: FADE_MAX + 1}, 'cues: fade'], [{fade: '2'}, 'cues: fade'], [{follow: FOLLOW_MAX + 1}, 'cues: follow'], [{follow: NaN}, 'cues: follow'],
  [{pose: 'first'}, 'cues: pose'], [{shown: {}}, 'cues: shown'], [{shown: new Array(PROJECTORS_MAX + 1).fill({})}, 'cues: shown'], [{shown: [{layers: [layer()], correction: 'all'}]}, 'cues: correction'],
  [{shown: [{layers: []}]}, 'layers'], [{shown: [{layers: [layer('any')]}]}, 'layers: fit']]) refuses(() => cue(changes), field);

const layered = (changes) => checkLayers({layers: [{...layer(), ...changes}]});
for (const [changes, field] of [[{place: {...place, turn: 'round'}}, 'layers: turn'], [{place: {...place, opacity: 2}}, 'layers: opacity'], [{place: {...place, width: 0}}, 'layers: width'],
  [{place: {...place, pull: [[0, 0]]}}, 'four corners'], [{place: {...place, pull: [[0.9, 0.9], [0, 0], [0, 0], [0, 0]]}}, 'folds'], [{place: {...place, crop: [0, 0, 2, 0]}}, 'layers: crop'],
  [{place: {...place, mask: new Array(MASK_MAX + 1).fill([0, 0])}}, 'layers: mask'], [{film: {volume: 7}}, 'layers: volume'], [{on: 'roof'}, 'layers: on'], [{on: -1}, 'layers: on'], [{on: {}}, 'layers: on']]) refuses(() => layered(changes), field);
refuses(() => checkLayers({layers: new Array(LAYERS_MAX + 1).fill(layer())}), 'layers');
// Points on the box's edge go outwards, where a soft edge would show that is not cut.
assert.deepStrictEqual(reachingOut([[0.25, 0], [1, 0], [1, 1], [0.25, 1]], 0.5, 2), [[0.25, -2], [1.5, -2], [1.5, 3], [0.25, 3]]);
assert.deepStrictEqual([layered({on: undefined})[0].on, layered({on: 3})[0].on], [null, 3]); // stages once had none
refuses(() => checkWindow({left: 0, top: 0, width: 0, height: 9}), 'window: width');

// --- Surfaces of a stage. ---
const part = {points: [[1, 2, 3]], normal: [0, 0, 1], albedo: [0.5, 0.5, 0.5], tolerance: 0.3, take: false}, surface = (changes = {}) => ({id: 1, name: 'Roof', parts: [part], ...changes});
const withPart = (changes) => [surface({parts: [{...part, ...changes}]})], plainly = (value) => JSON.parse(JSON.stringify(value));
assert.deepStrictEqual(plainly(checkSurfaces([surface(), surface({id: 2, name: 'W'.repeat(99), parts: [{...part, take: true, more: 1}]})])),
  [surface(), surface({id: 2, name: 'W'.repeat(40), parts: [{...part, take: true}]})]);
for (const [surfaces, field] of [[{}, 'surfaces'], [Array.from({length: SURFACES_MAX + 1}, (_, i) => surface({id: i + 1})), 'surfaces'], [[null], 'surfaces: id'], [[surface({id: 'x'})], 'surfaces: id'],
  [[surface(), surface()], 'id is there twice'], [[surface({parts: []})], 'parts or points are none'], [[surface({parts: new Array(PARTS_MAX + 1).fill(part)})], 'surfaces: parts'], [[surface({parts: [null]})], 'surfaces: points'],
  [withPart({points: []}), 'parts or points are none'], [withPart({points: new Array(POINTS_MAX + 1).fill([0, 0, 0])}), 'surfaces: points'], [withPart({points: [[1, 2]]}), 'surfaces: points has not three'],
  [withPart({points: [[1, 2, NaN]]}), 'surfaces: points'], [withPart({normal: [0, 0, 2]}), 'surfaces: normal'], [withPart({albedo: [0, 0, '0']}), 'surfaces: albedo'], [withPart({tolerance: 2}), 'surfaces: tolerance']])
  refuses(() => checkSurfaces(surfaces), field);

// --- A show: an app of two projectors whose layers come when the test says so. ---
const arriving = [], events = [];
globalThis.layersOf = null; // the page's own is put aside
runInThisContext('layersOf = (app, described) => new Promise((done) => app.arriving.push(() => done(described.map((d) => ({source: d.source})))))');
const projector = () => ({correction: 'none', watcher: 'now', layers: [new Layer(new SolidContent('#000000'))], content: new SolidContent('#000000')});
const app = {
  arriving, scene: {views: {0: {id: 'first'}, v: {id: 'v'}}}, projectors: [projector(), projector()], library: {entries: []}, changed: (what) => events.push(what),
  windows: {open: [{}]}, relief: {surfaces: []}, jump: (view) => events.push(`jump ${view.id}`), seat: () => ({pose: app.pose}), invalidate: () => events.push('drawn'), release: (sources) => events.push(`released ${sources.length}`),
  setLayers: (layers, to, seconds, corrected) => events.push(`${app.projectors.indexOf(to)}: ${layers.map((l) => l.source.colour)} in ${seconds} s${corrected ? ', to be corrected again' : ''}`),
};
app.projector = app.projectors[0];
const happened = () => events.splice(0).filter((what) => what !== 'cues'), arrive = () => arriving.splice(0).forEach((work) => work());
const show = new Show(app), one = (colour, changes = {}) => ({...cue({shown: [{layers: [{...layer(), source: {colour}}], correction: 'none', watcher: 'now'}]}), ...changes});

process.exitCode = 1; // until all of it has run: a promise that nothing resolves ends node, too
(async () => {
  await assert.rejects(show.go(), (error) => error instanceof Message && /no cues yet/.test(error.message));
  show.add(), show.add();
  assert.deepStrictEqual(show.cues.map(({name, fade, follow, shown}) => [name, fade, follow, shown.length]), [['Colour', 1, null, 2], ['Colour 2', 1, null, 2]]);
  show.cues = [one('red'), one('green', {fade: 3, pose: 0}), one('blue', {follow: 5})];
  await assert.rejects(show.go(7), (error) => /no cue 8/.test(error.message));

  // GO takes them in order, with their fades, and begins again after the last; a given fade is for one GO.
  const fade = async (work) => { const done = work; await Promise.resolve(); arrive(); await done; return happened(); };
  assert.deepStrictEqual(await fade(show.go()), ['0: red in 2 s']);
  show.fade = 0.5;
  assert.deepStrictEqual([await fade(show.go()), show.at], [['jump first', '0: green in 0.5 s'], 1]);
  assert.deepStrictEqual([await fade(show.go()), show.at, show.playing], [['0: blue in 2 s'], 2, true]);
  assert.strictEqual(waiting.at(-1).ms, 7000); // the fade, and then five seconds
  const follows = waiting.at(-1).work();
  assert.deepStrictEqual([await fade(follows), show.at, show.playing], [['0: red in 2 s'], 0, false]);

  // Of two GOs the later one is shown, and what came for the other is let go.
  const slow = show.go(1), quick = show.go(2);
  arriving.pop()();
  await quick;
  arrive();
  await slow;
  assert.deepStrictEqual([happened(), show.at], [['0: blue in 2 s', 'released 1'], 2]);

  // Two GOs go on by two cues, though the first still waits.
  const first = show.go(), second = show.go();
  arrive();
  await Promise.all([first, second]);
  assert.deepStrictEqual([show.at, show.here, happened().at(-1)], [1, 1, '0: green in 3 s']);
  await fade(show.go(2));
  // So do they whenever the second comes.
  for (let k = 0; k < 12; k++) {
    const one = show.go();
    arrive();
    for (let i = 0; i < k; i++) await null;
    const two = show.go();
    arrive();
    await Promise.all([one, two]);
    assert.deepStrictEqual([k, show.at], [k, 1]);
    await fade(show.go(2));
  }
  happened();

  // A stop lets the next cue not follow.
  show.stop();
  assert.ok(waiting.at(-1).work === null && !show.playing);

  // Another correction starts from scratch; a view that is not there is 'now'; projectors that are gone are left out.
  show.cues[0].shown = [{layers: [layer()], correction: 'paint', watcher: 'gone'}, {layers: [layer()], correction: 'none', watcher: 'v'}, {layers: [layer(), layer()], correction: 'none', watcher: 'now'}];
  assert.deepStrictEqual(await fade(show.go(0)), ['0: #ff0000 in 2 s, to be corrected again', '1: #ff0000 in 2 s, to be corrected again', 'released 2']);
  assert.deepStrictEqual(app.projectors.map((p) => [p.correction, p.watcher]), [['paint', 'now'], ['none', 'v']]);

  // Cues change places, and the one that is shown is known.
  show.at = 0, show.raise(0), show.raise(1);
  assert.deepStrictEqual([show.at, show.cues[1].shown.length], [1, 3]);
  show.remove(0);
  assert.deepStrictEqual([show.at, show.cues.length], [0, 2]);
  show.cues[1].name = 'Der Vorhang';
  assert.strictEqual(show.find('der vorhang'), 1);
  refuses(() => show.find('none'), 'There is no cue "none"');
  show.cues = new Array(CUES_MAX).fill(show.cues[0]);
  refuses(() => show.add(), `at most ${CUES_MAX}`);

  // Armed, it keeps the place that corrections are for, until a cue brings poses of its own.
  show.cues = [one('red'), one('green', {pose: 0})], show.at = -1, said.length = 0, app.pose = 'aside';
  show.arm(true);
  assert.ok(said.length === 1 && said[0].startsWith('Armed'));
  app.pose = 'elsewhere', said.length = 0;
  await fade(show.go());
  assert.deepStrictEqual(show.seat, {pose: 'aside'});
  await fade(show.go());
  assert.deepStrictEqual([show.seat, said], [{pose: 'elsewhere'}, []]);

  // Without a projector window it does the same and says so; cues that follow are not said again.
  app.windows.open = [];
  show.arm(true);
  assert.ok(show.armed && said.pop().endsWith(' No projector window is open.'));
  show.cues[0].follow = 1;
  assert.deepStrictEqual([await fade(show.go(0)), said.splice(0)], [['drawn', '0: red in 2 s'], ['Cue 1 is shown here alone: no projector window is open.']]);
  await fade(waiting.at(-1).work());
  assert.deepStrictEqual([show.at, said], [1, []]);
  show.cues[0].follow = null, app.windows.open = [{}];

  // Effects are made from their description again, whatever it says.
  for (const [told, made] of [[{effect: 'scan', colour: '#00ff00', speed: 1, size: 0.5, phase: 0.25}], [{effect: 'lamp', colour: 'red', speed: 1e9, size: '1', phase: -1}, {effect: 'lamp', colour: '#ffffff', speed: 2, size: 0.3, phase: 0}]])
    assert.deepStrictEqual(plainly(describeContent(app, await contentOf(app, told))), made || told);
  for (const effect of ['none', 'constructor', '__proto__', null, 7]) assert.deepStrictEqual(plainly(await contentOf({...app, scene: {patterns: []}, library: {find: () => null}}, {effect}).then(({name}) => name)), 'White');
  said.length = 0;
  await contentOf({scene: {patterns: []}, library: {find: () => null}}, {file: '3'});
  await contentOf({scene: {patterns: []}, library: {find: () => null}}, {pattern: 'stripes'});
  assert.deepStrictEqual(said.splice(0), ['Not here, and white in its place: a picture or film.', 'Not here, and white in its place: stripes.']);

  // A stage that is loaded brings its own; undo leaves the view, and the seat with it.
  const worn = {projectors: [], selected: 0, exposure: 0, ambient: true, black: 0, cues: [], midi: {}, view: 0, pose: 'stage', target: [0, 0, 0]};
  const open = {...app, show, midi: {}, projectors: [], select() {}, endComparison() {}, jump() {}, seat: () => ({pose: open.pose})};
  open.scene = {views: [{id: 'first'}]}, open.pose = 'around';
  await applyState(open, worn, false);
  assert.deepStrictEqual(show.seat, {pose: 'elsewhere'});
  await applyState(open, worn, true);
  assert.deepStrictEqual(show.seat, {pose: 'stage'});
  happened();
  show.arm(false);
  assert.deepStrictEqual([show.seat, happened()], [null, ['drawn']]);

  // Files of a stage come beside those of the same number that are here, and the same ones once.
  Object.assign(globalThis, {checkState: async (_, plain) => plain, applyState: async (to, state) => { to.applied = state; }, readBytes: (text) => Buffer.from(text, 'base64'),
    contentOfFile: async (file) => ({name: file.name})});
  const page = {library: new Library({changed() {}}), history: {note() {}}, show: {stop() {}}}, showing = (file) => ({layers: [{source: {file}}]});
  await page.library.take(new File(['mine'], 'mine.png'));
  const theirs = JSON.stringify({format: STAGE_FORMAT, projectors: [showing('1'), showing('2')], cues: [{shown: [showing('1')]}],
    files: [{id: '1', name: 'theirs.png', type: '', data: btoa('theirs')}, {id: '2', name: 'second.png', type: '', data: btoa('second')}, {id: '3', name: 'Camera', live: 'camera'}]});
  for (let i = 0; i < 2; i++) {
    await loadStage(page, theirs);
    assert.deepStrictEqual(page.library.entries.map(({id, name}) => [id, name]), [['1', 'mine.png'], ['2', 'theirs.png'], ['3', 'second.png'], ['4', 'Camera']]);
    assert.deepStrictEqual([...page.applied.projectors, ...page.applied.cues[0].shown].map(({layers}) => layers[0].source.file), ['2', '3', '2']);
  }

  // --- Findings. ---
  const item = findingItem({code: 'few-views', severity: 'doubt', subject: 'views', view: 'v2', text: 'seen from one side', advice: 'photograph all around'});
  assert.deepStrictEqual([item.className, item.dataset.code, item.textContent, item.children.map((child) => [child.className, child.textContent])],
    ['doubt', 'few-views', 'Views, view v2: seen from one side', [['remedy', 'photograph all around']]]);
  const plain = findingItem({code: 'views', severity: 'ok', subject: 'views', text: 'eight'});
  assert.deepStrictEqual([plain.textContent, plain.children.length, isPassed({severity: 'ok'}), isPassed({severity: 'note'})], ['Views: eight', 0, true, false]);

  const exchanged = {code: 'exchanged', severity: 'fault', subject: 'photographs', view: 'v2', text: 'black and white are exchanged', advice: 'exchange their files'};
  const [words, remedy, ...more] = faultSaid('v2: black and white are exchanged: exchange their files a line of the log', exchanged);
  assert.deepStrictEqual([words, remedy.textContent, more], ['v2: black and white are exchanged a line of the log', 'exchange their files', []]);
  assert.deepStrictEqual(faultSaid('a/b.png: too small', {severity: 'fault', subject: 'photographs', text: 'too small'}), ['a/b.png: too small']);

  // --- JPEG: its size comes after segments of any length. ---
  const jpeg = bytes([0xff, 0xd8], [0xff, 0xe1, 0x4e, 0x22], new Array(20000).fill(7), [0xff, 0xff, 0xc2, 0, 17, 8, 0, 7, 1, 2]);
  assert.deepStrictEqual(await sizeOfFile(new Blob([jpeg])), [258, 7]);
  assert.strictEqual(await sizeOfFile(new Blob([jpeg.subarray(0, 300)])), null);

  // --- A stage is refused by the field that is wrong, and nothing else is. ---
  const device = {width: 800, height: 600, fx: 900, fy: 900, cx: 400, cy: 300, pose: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]};
  const stage = {projectors: [{device, stops: 0, gain: 0, layers: [layer()], correction: 'none', watcher: 'v'}], selected: 0, exposure: 0, view: 0, pose: device.pose, target: [0, 0, 0]};
  const kept = {scene: app.scene, projectors: [{device, paint: null}]};
  const state = await checkState(kept, structuredClone(stage));
  assert.deepStrictEqual([state.projectors[0].watcher, state.black, state.cues, state.ambient, state.projectors[0].on], ['v', 0, [], true, true]);
  for (const [spoil, field] of [[(s) => { s.projectors = []; }, 'no projectors'], [(s) => { s.projectors[0].device.fx = 0; }, 'projectors: fx'], [(s) => { s.projectors[0].device.pose.pop(); }, 'projectors: pose'],
    [(s) => { s.black = 0.2; }, 'black'], [(s) => { s.cues = [{}]; }, 'cues: fade'], [(s) => { s.target = [0, 'x', 0]; }, 'target'], [(s) => { s.exposure = null; }, 'exposure'],
    [(s) => { s.projectors[0].correction = 'some'; }, 'projectors: correction'], [(s) => { s.projectors[0].at = -1; }, 'projectors: at']]) {
    const bad = structuredClone(stage);
    spoil(bad);
    await assert.rejects(checkState(kept, bad), (error) => error instanceof Message && error.message.includes(field), field);
  }
  process.exitCode = 0;
})().catch((error) => console.error(error));
