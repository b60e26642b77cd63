'use strict';
// The steps: what each shows for the state that the server tells, and what its buttons ask for.

const STEPS = ['rig', 'board', 'object', 'look', 'show'];
let step = '';

// The steps are the browser's history, too.
function showStep(name, again = false) {
  const place = platform.served ? ['#' + name] : []; // a frame has no address
  if (!again && step && step !== name) history.pushState({step: name}, '', ...place);
  else history.replaceState({step: name}, '', ...place);
  step = name;
  const section = name === 'show' ? 'look' : name; // the same viewer, large
  for (const id of STEPS.slice(0, -1)) $(id).hidden = id !== section;
  document.body.classList.toggle('show', name === 'show');
  for (const button of document.querySelectorAll('#steps button'))
    if (button.dataset.step === name) button.setAttribute('aria-current', 'step'); else button.removeAttribute('aria-current');
  if (studio.state) drawState(studio.state);
  if (name === 'rig' && webcam.stream) watchLive();
}

// The codes on the object say where camera and projector stand: there is no board.
const alone = () => !!studio.state.settings.without_board;
const complete = (set) => set.count > 0 && set.done === set.count;
const objectNow = (state) => state.objects.find((object) => object.name === state.settings.object);
const isRunning = (state, name) => state.job.end === 'running' && (!name || state.job.name === name);

// Where one goes on when the page is opened.
function firstOpen(state) {
  const object = objectNow(state);
  if (state.patterns.length === 0) return 'rig';
  if (!alone() && !state.axis) return 'board';
  return object && object.view ? 'look' : 'object';
}

function drawSteps(state) {
  const object = objectNow(state), boards = state.sets.filter(complete).length;
  const done = {rig: state.patterns.length > 0, board: state.calibrated && state.axis, object: !!object && object.sets.every(complete), look: !!object && object.view, show: false};
  const says = {rig: done.rig ? `${state.settings.projector.join(' x ')}` : 'camera, projector, patterns',
    board: done.board ? 'done' : `${boards} of ${state.sets.length}`,
    object: object ? `${object.name}: ${object.sets.filter(complete).length} of ${object.sets.length}` : 'photograph it',
    look: done.look ? 'light it as you like' : 'not yet', show: done.look ? 'windows, cues, GO' : 'not yet'};
  let count = 0;
  for (const button of document.querySelectorAll('#steps button')) {
    button.hidden = button.dataset.step === 'board' && alone();
    if (!button.hidden) button.querySelector('b').textContent = ++count;
    button.classList.toggle('done', done[button.dataset.step]);
    button.querySelector('small').textContent = says[button.dataset.step];
  }
}

// The reason why a button is grey, with one that leads to the step where it is mended.
function tellWhy(id, text, target) {
  const told = text + (target || '');
  if ($(id).dataset.told === told) return;
  $(id).dataset.told = told;
  const name = target && document.querySelector(`#steps button[data-step=${target}]`).innerText.replace(/\s+/g, ' ').trim().split(' ').slice(0, 2).join(': ');
  $(id).replaceChildren(text, ...(target ? [' ', element('button', {className: 'small', textContent: `Step ${name}`, onclick: () => showStep(target)})] : []));
}

// --- 1: the rig. ---

const setTo = (settings) => attempt(() => doIt({verb: 'set', settings}));
const number = (id) => Number($(id).value);

function fill(id, value) {
  if (document.activeElement !== $(id) && $(id).value !== String(value)) $(id).value = value;
}

function drawRig(state) {
  const {settings} = state, virtual = !!settings.virtual;
  $('rig-lead').textContent = virtual
    ? 'This rig is simulated: nothing has to be built or held. Draw the patterns, and go on.'
    : 'Camera and projector stay where they are from now on: focus, aperture and zoom fixed, no keystone correction.';
  for (const button of document.querySelectorAll('#cameras button')) {
    button.hidden = (button.dataset.camera === 'virtual' && !virtual) || (button.dataset.camera === 'folder' && !platform.served);
    button.setAttribute('aria-pressed', button.dataset.camera === settings.camera);
  }
  for (const kind of ['browser', 'folder', 'virtual']) $('camera-' + kind).hidden = settings.camera !== kind;
  $('projector-card').hidden = settings.camera === 'virtual';
  $('latency-row').hidden = settings.camera !== 'browser';
  $('latency-is').textContent = `${webcam.latency} ms between showing and photographing`;
  const fits = projector.isOpen && projector.panel.every((side, i) => side === settings.projector[i]);
  $('projector-size').textContent = !projector.isOpen ? 'Put it on the projector’s display, and press F there.'
    : `The window has ${projector.panel.join(' x ')} pixels` + (fits ? ', as the patterns have.' : `, the patterns ${settings.projector.join(' x ')}: full screen on the projector's display, at 100 %?`);
  fill('watched', settings.watched || '');
  fill('panel-w', settings.projector[0]), fill('panel-h', settings.projector[1]);
  for (const button of document.querySelectorAll('#boards-or-not button')) {
    button.setAttribute('aria-pressed', !button.dataset.board === alone());
    button.disabled = state.photographed;
  }
  $('why-board').textContent = alone() ? 'Nothing is printed or measured: the Gray codes on the object say where camera and projector stand. Lengths are in units of the distance between the two lenses; the object must not look the same from all sides.'
    : 'For millimetres, and for objects that look the same from all sides: print the board, glue it to something flat, photograph it in some attitudes.';
  $('board-measures').hidden = alone();
  fill('board-c', settings.board[0]), fill('board-r', settings.board[1]);
  fill('square', settings.square), fill('attitudes', settings.attitudes), fill('angles', settings.board_angles.join(', '));
  for (const id of ['panel-w', 'panel-h']) $(id).disabled = state.photographed;
  for (const id of ['board-c', 'board-r', 'square', 'attitudes', 'angles']) $(id).disabled = virtual;
  $('draw').disabled = state.photographed || isRunning(state);
  $('paper').hidden = virtual || alone() || state.patterns.length === 0;
  $('drawn').textContent = state.patterns.length > 0 ? `${state.patterns.length} patterns in patterns/` : '';
}

for (const button of document.querySelectorAll('#cameras button'))
  button.addEventListener('click', () => setTo({camera: button.dataset.camera}));
for (const button of document.querySelectorAll('#boards-or-not button'))
  button.addEventListener('click', () => setTo({without_board: !button.dataset.board}));
$('watched').addEventListener('change', () => setTo({watched: $('watched').value.trim()}));
for (const id of ['panel-w', 'panel-h']) $(id).addEventListener('change', () => setTo({projector: [number('panel-w'), number('panel-h')]}));
for (const id of ['board-c', 'board-r']) $(id).addEventListener('change', () => setTo({board: [number('board-c'), number('board-r')]}));
$('square').addEventListener('change', () => setTo({square: number('square')}));
$('attitudes').addEventListener('change', () => setTo({attitudes: number('attitudes')}));
$('angles').addEventListener('change', () => setTo({board_angles: $('angles').value.split(/[\s,;]+/).filter(Boolean).map(Number)}));
$('open-camera').addEventListener('click', () => attempt(openCamera));
$('projector-open').addEventListener('click', () => attempt(() => openProjector()));
$('latency').addEventListener('click', () => attempt(async () => {
  $('latency').disabled = true;
  try { await measureLatency(); } finally { $('latency').disabled = false; }
  drawRig(studio.state);
}));
const runStep = (name) => attempt(() => doIt({verb: 'run', step: name}));
$('draw').addEventListener('click', () => runStep('patterns'));

// --- Sets of photographs. ---

// The photograph that shows a set: under white.
function pictureOf(set) {
  if (set.done < 3 && !set.name.endsWith('turntable')) return '';
  return `${set.name}/${set.name.endsWith('turntable') ? '000' : '002'}.${set.ending}`;
}

function drawSets(id, sets, state) {
  const place = $(id);
  while (place.children.length > sets.length) place.lastChild.remove();
  sets.forEach((set, i) => {
    if (!place.children[i]) {
      const tile = element('div', {className: 'set'}, element('div', {className: 'none'}), element('div', {className: 'text'}, element('b'), element('small')));
      tile.append(element('button', {className: 'again', textContent: 'Again', onclick: () => attempt(() => doIt({verb: 'discard', set: tile.dataset.set}))}));
      place.append(tile);
    }
    const tile = place.children[i], picture = set.done > 0 ? pictureOf(set) : '';
    tile.dataset.set = set.name;
    tile.classList.toggle('active', !!state.active && state.active.name === set.name);
    tile.querySelector('b').textContent = titleOf(set);
    const board = boards.get(set.name);
    tile.querySelector('small').textContent = complete(set) ? board && board.found ? `tilted by ${Math.round(board.tilt)}\u00b0` : 'done' : set.done > 0 ? `${set.done} of ${set.count}` : set.count > 0 ? `${set.count} photographs` : '';
    tile.querySelector('.again').hidden = set.done === 0 || shooting.running;
    if ((tile.dataset.picture || '') === picture) return;
    tile.dataset.picture = picture;
    tile.firstChild.replaceWith(element(picture ? 'img' : 'div', picture ? {alt: ''} : {className: 'none'}));
    if (picture) platform.put(tile.firstChild, picture);
  });
}

function drawShoot(id, sets, state) {
  const missing = sets.filter((set) => !complete(set));
  $(id).hidden = missing.length === 0 || (!!state.active && !shooting.running && missing[0].name === state.active.name); // "Go on" does it
  $(id).disabled = missing.length === 0 || shooting.running || missing[0].count === 0 || isRunning(state);
  if (missing.length > 0) $(id).textContent = isVirtual() ? `Photograph ${missing.length === sets.length ? 'all' : 'the rest'}` : `Photograph: ${titleOf(missing[0])}`;
}

// The simulated rig changes the board and turns the table by itself.
function shootMissing(sets) {
  const missing = sets.filter((set) => !complete(set));
  shootAll(isVirtual() ? missing : missing.slice(0, missing[1] && isSecond(missing[1]) && !isSecond(missing[0]) ? 2 : 1)); // both at a stop
}

// --- 2: the chessboard. ---

const boards = new Map(); // by set: where the board is in its photograph under white, as `calibrate --seen` found it

async function boardOf(name) {
  if (!boards.has(name)) boards.set(name, JSON.parse(await textOf(name + '/board.json')).photographs[0]);
  return boards.get(name);
}

const SIDES = [['left', -1, 0], ['right', 1, 0], ['top', 0, -1], ['bottom', 0, 1]];

// Gaps that the boards so far leave: parts of the picture that no corner has reached, and sides that were never the nearer one.
function openBoards(seen) {
  const cells = new Set(seen.flatMap((b) => b.corners.map(([x, y]) => Math.floor(3 * y / b.height) * 3 + Math.floor(3 * x / b.width))));
  const parts = ['the left top', 'the top', 'the right top', 'the left', 'the middle', 'the right', 'the left bottom', 'the bottom', 'the right bottom'];
  const tilted = seen.filter((b) => b.tilt > 12);
  const all = seen.flatMap((b) => b.corners.map(([x, y]) => [x / b.width, y / b.height])), far = 0.15;
  const edges = [['left', ([x]) => x], ['right', ([x]) => 1 - x], ['top', ([, y]) => y], ['bottom', ([, y]) => 1 - y]];
  return {parts: parts.filter((_, i) => !cells.has(i)), edges: edges.filter(([, from]) => all.every((corner) => from(corner) > far)).map(([name]) => name),
    sides: SIDES.filter(([, x, y]) => !tilted.some((b) => b.towards[0] * x + b.towards[1] * y > 0.15)).map(([name]) => name)};
}

function drawBoards(state) {
  for (const set of state.sets) {
    if (!set.looked) boards.delete(set.name);
    else if (!boards.has(set.name)) boardOf(set.name).then(() => drawBoard(studio.state), () => {});
  }
  const seen = state.sets.map((set) => boards.get(set.name)).filter((b) => b && b.found);
  $('seen').hidden = seen.length === 0;
  if (seen.length === 0) return;
  const canvas = $('seen-map'), context = canvas.getContext('2d'), scale = 320 / seen[0].width;
  canvas.height = Math.round(seen[0].height * scale);
  seen.forEach((b, i) => {
    context.fillStyle = `hsl(${i * 47 % 360} 70% 62%)`;
    for (const [x, y] of b.corners) context.fillRect(x * scale - 1.5, y * scale - 1.5, 3, 3);
  });
  const open = openBoards(seen), tilts = seen.map((b) => b.tilt), says = [];
  says.push(['', `tilted by ${Math.round(Math.min(...tilts))} to ${Math.round(Math.max(...tilts))} degrees`]);
  if (open.sides.length > 0) says.push(['doubt', `never nearer to the camera: its ${open.sides.join(', ')}`]);
  if (open.parts.length > 0) says.push(['doubt', `no corner yet in ${open.parts.join(', ')} of the picture`]);
  if (open.edges.length > 0) says.push(['doubt', `no corner yet near the picture's ${open.edges.join(', ')} edge: what a lens bends there is then a guess`]);
  if (open.sides.length + open.parts.length + open.edges.length === 0) says.push(['', 'corners in every part of the picture, tilts to every side']);
  $('seen-says').replaceChildren(...says.map(([className, textContent]) => element('li', {className, textContent})));
}

function drawBoard(state) {
  const boards = state.sets.filter((set) => set.kind === 'attitude' && complete(set)).length;
  drawSets('board-sets', state.sets, state);
  drawShoot('board-shoot', state.sets, state);
  $('calibrate').disabled = boards < 3 || isRunning(state) || shooting.running;
  $('calibrate').classList.toggle('primary', state.sets.every(complete) && !state.axis);
  if (state.patterns.length === 0) tellWhy('board-note', 'The patterns are not drawn yet:', 'rig');
  else tellWhy('board-note', boards < 3 ? 'Three attitudes are the least to calibrate with.' : state.sets.every(complete) ? '' : 'More attitudes determine more; the turntable needs its own.');
  drawBoards(state);
  $('calibration').hidden = !state.calibrated;
  if (state.calibrated && !isRunning(state, 'calibrate') && told.calibrate !== stamp(state, 'calibrate')) tellCalibration(state); // its log comes last
}

// A job's log is read again when one has ended.
const told = {};
const stamp = (state, name) => `${state.settings.object} ${state.job.name === name ? state.job.end + state.job.seconds + pagesOf(state) : 'before'}`;
// Pages that the job has written: of a reconstruction first the draft's.
const pagesOf = ({job}) => job.commands.slice(0, job.current).filter((line) => line.startsWith('ffprocams view ')).length;

// The calibration's files: OpenCV's FileStorage, and the axis' JSON.
const fitOf = async (file) => new DOMParser().parseFromString(await textOf(file), 'text/xml').documentElement;
const fieldOf = (fit, name) => [...fit.children].find((child) => child.tagName === name);

async function calibrationFigures() {
  const fit = await fitOf('calibration/calibration.xml'), own = (name) => fieldOf(fit, name);
  const value = (name) => Number(own(name).textContent).toFixed(3), count = (name) => own(name) ? own(name).children.length : 0;
  const figures = [];
  if (own('rms') && own('cam_rms') && own('proj_rms'))
    figures.push(['attitudes used', `${count('attitudes')} of ${count('attitudes') + count('left_out')}`], ['error of all corners', `${value('rms')} pixels`],
      ['camera alone, projector alone', `${value('cam_rms')}, ${value('proj_rms')} pixels`]);
  const axis = studio.state.axis ? JSON.parse(await textOf('calibration/axis.json')) : {};
  if (axis.tilt !== undefined) figures.push(['the turntable’s axis', `known to ${axis.tilt.toFixed(3)} degrees`]);
  return figures;
}

// The findings of a step's commands when they ran last; none, if they were another object's.
async function findingsOf(name, object) {
  const log = JSON.parse(await textOf(`logs/${name}.json`) || '{"commands": [], "findings": []}');
  return !object || log.commands.some((command) => command.includes(`objects/${object.name}/`)) ? log.findings : [];
}

async function tellCalibration(state) {
  told.calibrate = stamp(state, 'calibrate');
  const doubts = (await findingsOf('calibrate')).filter((finding) => !isPassed(finding)), figures = await calibrationFigures();
  const holds = doubts.filter(({code}) => code === 'lens-terms-to-fix');
  $('fix').hidden = holds.length === 0;
  $('fix').dataset.terms = holds.map(({setting}) => setting.slice(setting.indexOf('=') + 1)).join(' ');
  $('calibration-figures').replaceChildren(...figures.flatMap(([name, value]) => [element('dt', {textContent: name}), element('dd', {textContent: value})]));
  $('calibration-says').replaceChildren(...doubts.map(findingItem),
    ...(doubts.length === 0 && figures.length > 0 ? [element('li', {textContent: 'The photographs determine all terms.'})] : []));
}

$('board-shoot').addEventListener('click', () => shootMissing(studio.state.sets));
$('calibrate').addEventListener('click', () => runStep('calibrate'));
$('fix').addEventListener('click', () => attempt(async () => {
  const fix = [...new Set([...studio.state.settings.fix, ...$('fix').dataset.terms.split(' ')])];
  await doIt({verb: 'set', settings: {fix}});
  await doIt({verb: 'run', step: 'calibrate'});
}));

// --- 3: the object. ---

// Only when they change: a press or a focus would get lost.
function drawTabs({objects, settings}, object) {
  const shown = JSON.stringify([objects.map(({name}) => name), settings.object]);
  if ($('object-tabs').dataset.shown === shown) return;
  $('object-tabs').dataset.shown = shown;
  $('object-tabs').replaceChildren(...objects.map(({name}) => {
    const tab = element('button', {className: 'small', textContent: name, onclick: () => attempt(() => doIt({verb: 'object', name}))});
    tab.setAttribute('aria-pressed', name === settings.object);
    return tab;
  }), ...(object ? [element('button', {className: 'small', textContent: 'Another', onclick: () => { $('object-new').dataset.wanted = 'yes'; drawObject(studio.state); }})] : []));
}

function drawObject(state) {
  const object = objectNow(state);
  $('object-lead').textContent = isVirtual() ? 'The simulated turntable turns by itself.'
    : 'Put the object on the turntable. At each stop the patterns are photographed; then turn it to the next angle.';
  $('object-coded-field').hidden = alone();
  $('object-new').hidden = !!object && !$('object-new').dataset.wanted;
  drawTabs(state, object);
  drawSets('object-sets', object ? object.sets : [], state);
  $('object-shoot').hidden = $('make').hidden = $('quality').hidden = !object;
  if (!object) return state.patterns.length === 0 ? tellWhy('object-note', 'The patterns are not drawn yet:', 'rig') : tellWhy('object-note', '');
  drawShoot('object-shoot', object.sets, state);
  const all = object.sets.filter((set) => !isSecond(set)).every(complete);
  $('make').disabled = !all || (!alone() && !state.axis) || isRunning(state) || shooting.running;
  $('make').classList.toggle('primary', all && !object.view);
  drawQuality(state, object);
  drawKnown(state, object);
  if (state.patterns.length === 0) tellWhy('object-note', 'The patterns are not drawn yet:', 'rig');
  else if (!alone() && !state.axis) tellWhy('object-note', 'The rig is not calibrated yet:', 'board');
  else tellWhy('object-note', all ? '' : 'Photograph all stops before you reconstruct it.');
}

function drawQuality({settings}, {expected}) {
  for (const input of document.querySelectorAll('#quality input')) {
    const seconds = expected[input.value];
    input.parentElement.lastElementChild.textContent = (input.value === 'fine' ? 'Fine' : 'Draft') + (seconds < 1 ? '' : seconds < 90 ? `, about ${Math.ceil(seconds / 5) * 5} s` : `, about ${Math.round(seconds / 60)} minutes`);
    input.checked = (input.value === 'draft') === !!settings.draft;
  }
}
for (const input of document.querySelectorAll('#quality input'))
  input.addEventListener('change', () => setTo({draft: input.value === 'draft'}));

// --- How well the stops so far determine the rig. ---

const GOOD = {focal: 0.02, tilt: 1.5, surface: 0.5}; // share, degrees, pixels

async function knownFigures(folder) {
  const fit = await fitOf(`${folder}/calibration.xml`), axis = JSON.parse(await textOf(`${folder}/axis.json`));
  const numbers = (name) => fieldOf(fit, name).querySelector('data').textContent.trim().split(/\s+/).map(Number);
  const focal = ['cam', 'proj'].map((device) => numbers(device + '_deviations')[0] / numbers(device + '_int')[0]);
  return {focal, axis, good: Math.max(...focal) < GOOD.focal && axis.tilt < GOOD.tilt && axis.rms < GOOD.surface};
}

async function tellKnown(state, object) {
  const stamp = told.known = stampOf(state.eye, object);
  const findings = JSON.parse(await textOf('logs/known.json') || '{"findings": []}').findings.filter((finding) => !isPassed(finding));
  $('known').hidden = false;
  $('known-says').replaceChildren(...findings.map(findingItem));
  $('known-figures').replaceChildren();
  if (state.eye.end !== 'done') {
    $('known-verdict').textContent = `Not known yet: ${state.eye.error || 'more stops are needed'}`;
    return;
  }
  const {focal, axis, good} = await knownFigures(`objects/${object.name}/known`), percent = (part) => (100 * part).toFixed(1) + ' %';
  const figures = [['focal lengths, camera and projector', `to ${percent(focal[0])} and ${percent(focal[1])}`], ['the turntable\u2019s axis', `to ${axis.tilt.toFixed(2)} degrees`],
    ['surfaces of the stops agree', `within ${axis.rms.toFixed(2)} pixels`], ['by stops', '']];
  $('known-verdict').textContent = good ? 'Camera, projector and axis are known well enough: go on' : 'Camera, projector and axis are known roughly: further stops tell more';
  told.used = {...axis, name: object.name, stamp};
  $('known-figures').replaceChildren(...figures.flatMap(([name, value]) => [element('dt', {textContent: name}), element('dd', {textContent: value})]));
  const now = objectNow(studio.state);
  if (now && isUsedOf(now)) drawKnown(studio.state, now);
}

const isUsedOf = ({name}) => !!told.used && told.used.name === name; // not another object's
const stopsOf = (object) => object.sets.filter((set) => isStop(set) && complete(set));

// "4 of 9": of those that are photographed by now, which change after this was found, the stops that it was found from.
function usedStops({views, left_out}, object) {
  const done = stopsOf(object).length, used = views.length - left_out.length;
  const since = done > views.length ? `, ${done - views.length} photographed since` : done < views.length ? `, ${views.length - done} discarded since` : '';
  return `${used} of ${Math.max(done, views.length)}${left_out.length ? `, ${left_out.length} left out` : ''}${since}`;
}

function tellUsed(object) {
  if (!isUsedOf(object)) return;
  const line = $('known-figures').lastElementChild, text = line && usedStops(told.used, object);
  if (line && line.textContent !== text) line.textContent = text;
}

const stampOf = (eye, object) => `${object.name} ${eye.end} ${eye.seconds}`;

function drawKnown(state, object) {
  const {eye} = state;
  if (!alone() || eye.name !== 'known' || eye.end === 'none' || object.sets.every((set) => set.done === 0)) $('known').hidden = true;
  else if (eye.end !== 'running' && told.known !== stampOf(eye, object)) tellKnown(state, object);
  else tellUsed(object);
  // once more after a look, for stops that were completed while it ran
  const stamp = stampOf(eye, object);
  if (platform.served && isUsedOf(object) && told.used.stamp === stamp && eye.end === 'done' && !shooting.running && !isRunning(state) && stopsOf(object).length > told.used.views.length && told.late !== stamp) {
    told.late = stamp;
    attempt(() => doIt({verb: 'look', set: object.sets[object.sets.length - 1].name}));
  }
}

$('object-add').addEventListener('click', () => attempt(async () => {
  const size = $('object-second').checked ? secondSize() : null;
  await doIt({verb: 'object', name: $('object-name').value.trim(), stops: number('object-stops'), coded: $('object-coded').checked, empty: $('object-empty').checked});
  if (size) await beginSecond('every', size);
  delete $('object-new').dataset.wanted;
  drawObject(studio.state);
}));
$('object-shoot').addEventListener('click', () => shootMissing(objectNow(studio.state).sets));
$('make').addEventListener('click', () => runStep('make'));

// --- 4: the relit object. ---

function drawLook(state) {
  const object = objectNow(state), busy = isRunning(state, 'make'), making = busy && pagesOf(state) === 0;
  $('viewer').hidden = !object || !object.view || making;
  for (const card of document.querySelectorAll('#look > .row, #look > .card')) card.classList.toggle('waits', !object || !object.view);
  if (object && object.view) tellWhy('look-note', '');
  else if (making) tellWhy('look-note', 'The object is being reconstructed.');
  else tellWhy('look-note', object ? 'The object is not reconstructed yet:' : 'There is no object yet:', 'object');
  if (!object || !object.view || making) return;
  const page = `objects/${object.name}/view.html`, mark = page + stamp(state, 'make');
  drawMade(state, object, busy);
  if ((step === 'look' || step === 'show') && $('viewer').dataset.mark !== mark) showPage(page, mark);
  openGroup(step === 'show' ? 'show' : '');
  platform.put($('viewer-alone'), page);
  if (!platform.served) $('viewer-alone').download = object.name + '.html', $('viewer-alone').textContent = 'The live page, to open from disk: projector windows, a show';
  $('download').download = object.name + '.ply';
  platform.put($('download'), `objects/${object.name}/object.ply`);
  $('evaluate').disabled = isRunning(state);
  if (!busy && told.make !== stamp(state, 'make')) tellChecks(state, object); // the log is written at the job's end
  if (told.evaluate !== stamp(state, 'evaluate')) tellScores(state, object);
  drawNow(state, object);
  drawSecond(state, object);
}

// A projected picture stays until the person says otherwise.
function showPage(page, mark, now = false) {
  const {viewer} = viewerOf(), waits = !now && !!viewer && $('viewer').dataset.page === page && viewer.projectors.some((projector) => projector.window.isOpen);
  $('newer').hidden = !waits;
  $('newer').onclick = () => showPage(page, mark, true);
  if (waits) return;
  $('viewer').dataset.mark = mark, $('viewer').dataset.page = page;
  platform.put($('viewer'), page);
}

function drawMade({settings, job}, {pixels}, busy) {
  const draft = busy || (job.name === 'make' ? pagesOf({job}) === 1 : !!settings.draft);
  $('made').firstElementChild.textContent = (draft ? `A draft, from pictures ${settings.width} pixels wide` : pixels ? `Made at ${pixels[0]} of ${pixels[1]} pixels, the object's longer side` : '')
    + (busy ? "; the fine one is being made, and follows." : "");
}

// In the viewer's panel: opens the group for a show when its step is entered.
function openGroup(name) {
  const page = viewerOf(), mark = name + $('viewer').dataset.mark;
  if ($('viewer').dataset.group === mark || !page.viewer || !page.document.body.classList.contains('ready')) return;
  $('viewer').dataset.group = mark;
  if (name) page.openShow();
}
$('viewer').addEventListener('load', async () => { if (await viewerOf().ready) drawLook(studio.state); }); // it can be opened from now on

// A verdict on the photographs, in words.
function tellVerdict(doubts, count) {
  const worst = doubts.find(({severity}) => severity === 'fault') || doubts[0], more = doubts.length - 1;
  $('verdict').textContent = !count ? '' : !worst ? `Good: ${count} checks found nothing to mend.`
    : `${worst.severity === 'fault' ? 'Photograph it again' : 'Usable; better photographed again'}, because of its ${worst.subject}: ${worst.text}${worst.advice ? ` (${worst.advice})` : ''}.${more ? ` ${more} more below.` : ''}`;
}

async function tellChecks(state, object) {
  told.make = stamp(state, 'make');
  const findings = await findingsOf('make', object), doubts = findings.filter(isDoubt), passed = findings.filter((finding) => !isDoubt(finding));
  $('checks-card').hidden = findings.length === 0;
  $('doubts').replaceChildren(...doubts.map(findingItem));
  $('checks').replaceChildren(...passed.map(findingItem));
  $('passed').textContent = `${passed.length} of ${findings.length} checks found nothing to mend`;
  tellVerdict(doubts, findings.length);
  $('masks-card').hidden = false;
  $('masks').onerror = () => { $('masks-card').hidden = true; };
  platform.put($('masks'), `objects/${object.name}/capture/masks.png`);
}

const PROTOCOLS = {rendering: 'the photographs it was made from', novel_pattern: 'the pattern that was kept from it', novel_pose: 'views that were kept from it'};

async function tellScores(state, object) {
  told.evaluate = stamp(state, 'evaluate');
  $('scores').hidden = $('compared').hidden = true;
  if (!object.scores) return;
  const rows = JSON.parse(await textOf(`objects/${object.name}/scores.json`));
  $('scores').tBodies[0].replaceChildren(...(rows.rows || rows).filter((row) => PROTOCOLS[row.protocol]).map((row) => element('tr', {},
    ...[PROTOCOLS[row.protocol], row.images, row.psnr.toFixed(2), row.ssim.toFixed(4)].map((text) => element('td', {textContent: text})))));
  platform.put($('compared'), `objects/${object.name}/report.html`);
  $('scores').hidden = $('compared').hidden = false;
}

$('evaluate').addEventListener('click', () => runStep('evaluate'));

// --- What works, and the shell. ---

const WORK = {patterns: 'Drawing the patterns', calibrate: 'Calibrating', make: 'Making the capture, and reconstructing', evaluate: 'Comparing', now: 'Comparing with the photographs of now', register: 'Finding camera and projector again', watch: 'Keeping watch', draw: 'Drawing its patterns', second: 'Finding the second projector'};
let before = '', shownPages = 0;

function drawWork(state) {
  const {job} = state, running = job.end === 'running';
  $('working').hidden = !running;
  $('working-what').textContent = (WORK[job.name] || job.name) + (job.stage ? `: ${job.stage}` : '');
  $('working-bar').style.width = job.total > 0 ? 100 * job.done / job.total + '%' : 100 * job.current / Math.max(1, job.commands.length) + '%';
  $('working-left').textContent = job.total > 0 ? `${job.done} of ${job.total}` : '';
  $('commands').textContent = job.commands.join('\n');
  $('log').textContent = job.log;
  const ended = before === job.name + 'running' && !running, pages = running && job.name === 'make' ? pagesOf(state) : 0;
  const drafted = pages > shownPages;
  shownPages = pages, before = job.name + job.end; // showStep draws again
  if (drafted) showStep('look');
  if (ended) {
    if (job.end === 'failed') {
      say(job.error || `${job.name} has failed; the log below says why.`);
      $('shell').open = true;
    } else if (job.end === 'done' && job.name === 'make' && objectNow(state).second && objectNow(state).second.view === 'every' && complete(objectNow(state).second)) showStep('look'), attempt(findSecond);
    else if (job.end === 'done' && job.name === 'make' && pagesOf(state) === 1) showStep('look'); // the draft alone
    else if (job.end === 'done' && job.name === 'patterns') showStep(alone() ? 'object' : 'board');
  }
}

$('cancel').addEventListener('click', () => attempt(() => doIt({verb: 'cancel'})));

function drawState(state) {
  $('folder').textContent = platform.served ? state.folder.slice(state.folder.lastIndexOf('/') + 1) || '/' : 'in this browser';
  $('folder').title = state.folder;
  $('notice').hidden = !state.notice;
  $('notice').textContent = state.notice;
  drawWork(state);
  drawSteps(state);
  drawRig(state);
  drawBoard(state);
  drawObject(state);
  drawLook(state);
}
studio.listeners.push(drawState);

for (const button of document.querySelectorAll('#steps button'))
  button.addEventListener('click', () => showStep(button.dataset.step));

addEventListener('popstate', ({state}) => { if (state && STEPS.includes(state.step)) showStep(state.step, true); });
addEventListener('beforeunload', (event) => { if (shooting.running || watching.on || platform.working) event.preventDefault(); }); // the browser asks

for (const link of document.querySelectorAll('a[data-file]')) platform.put(link, link.dataset.file);
document.body.classList.toggle('served', platform.served);
refresh().then(() => {
  if (studio.state) showStep(STEPS.find((name) => '#' + name === location.hash) || firstOpen(studio.state), true);
  window.ready = true;
  if (navigator.mediaDevices) listCameras().catch(() => {});
  follow();
});
