'use strict';
// A second projector: photographed while it shines alone, found by the object as it is known, and added to the viewer.

const isSecond = ({kind}) => kind === 'second';
const isStop = ({kind}) => kind === 'stop';
const secondFolder = (object) => `objects/${object.name}/projector-2`;

function drawSecond(state, object) {
  const busy = isRunning(state) || shooting.running, {second} = object, all = !!second && complete(second), found = all && second.found;
  refill($('second-view'), object.sets.filter(isStop).map((set) => [set.name.slice(set.name.lastIndexOf('/') + 1), titleOf(set)]));
  $('second-open').hidden = isVirtual(), $('second-pixels').hidden = !isVirtual();
  $('second-size').textContent = secondProjector.isOpen ? `The window has ${secondProjector.panel.join(' x ')} pixels.` : '';
  $('second-go').disabled = $('second-find').disabled = $('second-show').disabled = busy;
  $('second-find').hidden = !all || found, $('second-show').hidden = !found;
  if (!found) $('second-says').textContent = '';
  const mark = found && !busy ? `${object.name} ${stamp(state, 'second')}` : '';
  if (mark && told.second !== mark) told.second = mark, tellSecond(state).catch(() => {});
}

// The figures of `align --second-projector --json` in words.
function secondVerdict({distance, deviations: {turned, moved, focal}, rms, used, points}) {
  const share = moved / distance, percent = (part) => (100 * part).toFixed(1) + ' %';
  const how = share < 0.02 && focal < 0.03 ? 'well' : share < 0.1 ? 'roughly: light more of the object, or another side of it' : 'badly: the object is too shallow from there; choose another stop';
  return `Known ${how}: its place to ${percent(share)} of its distance, its direction to ${turned.toFixed(2)}\u00b0, its focal length to ${percent(focal)}; ` +
    `${used} of ${points} points of the surface lie within ${rms.toFixed(2)} of its pixels.`;
}

async function tellSecond({job}) {
  const log = job.name === 'second' ? job.log : await textOf('logs/second.txt');
  $('second-says').textContent = secondVerdict(JSON.parse(log.slice(log.lastIndexOf('\n{') + 1)));
}

// The viewer, once it has the object.
async function viewerReady() {
  for (let tries = 0; tries < 300; tries++, await sleep(100)) {
    const page = viewerOf();
    if (!$('viewer').hidden && page && page.viewer && page.ready) return await page.ready, page;
  }
  throw new Error('The viewer does not open: open step Look, and show the second projector there.');
}

// In the viewer, at the stop at which it was photographed, where the first one then is, too.
async function showSecond() {
  const object = objectNow(studio.state), page = await viewerReady(), {projector: lens, views: [{id, p2w}]} = JSON.parse(await textOf(`${secondFolder(object)}/found/scene.json`));
  const {width, height, fx, fy, cx, cy} = lens;
  page.viewer.placeFound(page.viewer.scene.views.find((view) => view.id === id), {width, height, fx, fy, cx, cy, pose: p2w.flat()});
  say(`Projector 2 is in the viewer, with the object at ${Number(id.replace(/^view-/, ''))}\u00b0: leave the turntable there.`);
}

async function findSecond() {
  await doIt({verb: 'run', step: 'second'});
  await jobEnds('second');
  await showSecond();
}

// The pixels of its panel: those of its window, or of the simulated one.
function secondSize() {
  const size = isVirtual() ? [number('second-w'), number('second-h')] : secondProjector.panel;
  if (!size) throw new Error('Open the second projector\u2019s window first, and put it full screen on its display (F).');
  return size;
}

async function beginSecond(view, size) {
  await doIt({verb: 'second', view, size});
  await jobEnds('draw');
}

async function photographSecond() {
  const view = $('second-view').value;
  await beginSecond(view, secondSize());
  await shootAll([{name: `${secondFolder(objectNow(studio.state))}/${view}`, kind: 'second'}]);
}

// While one projector is photographed, the others are black.
async function darken(second) {
  const other = second ? projector : secondProjector, {viewer, blackout} = viewerOf() || {};
  if (other.isOpen) await project({colour: '#000'}, other);
  if (viewer && viewer.windows.open.length && !viewer.dark) blackout(viewer, true);
}

if (typeof document !== 'undefined') {
  $('object-second').addEventListener('change', () => { $('object-second-open').hidden = isVirtual() || !$('object-second').checked; });
  $('object-second-open').addEventListener('click', () => attempt(() => openProjector(secondProjector)));
  $('second-open').addEventListener('click', () => attempt(() => openProjector(secondProjector)));
  $('second-go').addEventListener('click', () => attempt(photographSecond));
  $('second-find').addEventListener('click', () => attempt(findSecond));
  $('second-show').addEventListener('click', () => attempt(showSecond));
}
