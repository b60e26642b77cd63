'use strict';
// Taking a set of photographs: the server says what is due, the projector shows it, the camera takes it. Whatever
// ends this in the middle, the next photograph is the first that is not on disk.

const shooting = {running: false, pause: false, go: null, asked: false, at: null}; // asked: a person has just said that all is ready; at: degrees to which the table was turned

const DARK = 8, CLIPPED = 250; // of 255
const isVirtual = () => studio.state.settings.camera === 'virtual';

// "calibration/attitude-03": "Board 4"
function titleOf({name, kind}) {
  const titles = {table: 'On the turntable', empty: 'Empty stage', trial: 'As it is now'}, number = Number(name.slice(name.lastIndexOf('-') + 1));
  if (kind === 'attitude') return `Board ${number + 1}`;
  return titles[kind] || `${number}\u00b0${kind === 'second' ? ', projector 2' : ''}`;
}

// Instructions for a person before a set, or before each photograph of the board on the turntable.
function wishFor(set) {
  if (set.kind === 'attitude') return set.done === 0 ? 'Hold the board still, tilted another way than before' + (studio.state.settings.camera === 'browser' ? ': it begins as soon as it is still.' : '.') : '';
  if (set.kind === 'table') return `Turn the table with the board on it to ${set.angle}\u00b0.`;
  if (isSecond(set) && shooting.at === set.angle) return ''; // it has been turned
  if (set.kind === 'empty') return set.done === 0 ? 'Take the object off the stage.' : '';
  return set.done === 0 ? `Turn the table with the object on it to ${set.angle}\u00b0.${set.kind === 'trial' ? ' What was moved stays as it is.' : ''}` : '';
}

// A picture to compare with others: 160 x 120.
function smallOf(image) {
  const context = element('canvas', {width: 160, height: 120}).getContext('2d', {willReadFrequently: true});
  context.drawImage(image, 0, 0, 160, 120);
  return context.getImageData(0, 0, 160, 120).data;
}

// Mean absolute difference of two of them, of 255.
function difference(a, b) {
  let sum = 0;
  for (let i = 0; i < a.length; i += 4) for (let k = 0; k < 3; k++) sum += Math.abs(a[i + k] - b[i + k]);
  return sum / (a.length / 4 * 3);
}

const MOVED = 2.5, STILL = 1.2, HELD = 1500; // of 255; ms

// Under white: true once something has moved before the camera and then kept still. Whoever holds a board has no hand for a button.
async function heldStill(over) {
  await project({colour: '#fff'});
  await sleep(webcam.latency);
  for (let before = null, moved = false, since = 0; !over() && webcam.stream; await sleep(200)) {
    const now = smallOf($('preview')), differs = before ? difference(before, now) : 0;
    before = now;
    moved ||= differs > MOVED;
    if (!moved || differs > STILL) since = performance.now();
    else if (performance.now() - since > HELD) return true;
  }
  return false;
}

async function waitForHand(wish, isBoard) {
  let over = false;
  $('shooting-ask').hidden = false;
  $('shooting-ask').firstElementChild.textContent = wish;
  $('shooting-go').focus();
  const pressed = new Promise((done) => { shooting.go = done; });
  const held = isBoard && studio.state.settings.camera === 'browser' ? heldStill(() => over) : pressed;
  try {
    await Promise.race([pressed, held.then((still) => still === false ? pressed : still)]);
  } finally {
    over = true;
    $('shooting-ask').hidden = true, shooting.go = null;
  }
}

async function takeOne(active) {
  const {name, next} = active;
  if (isVirtual()) {
    const state = await doIt({verb: 'take', set: name, number: next.number});
    if (state.active && state.active.name === name && state.active.done === active.done) await sleep(400); // being simulated
    return;
  }
  const {settings} = studio.state, size = active.panel || settings.projector;
  const {panel} = await project({image: await platform.blob(next.pattern)}, active.panel ? secondProjector : projector);
  if (!settings.virtual && panel.some((side, i) => side !== size[i]))
    throw new Error(`The projector window has ${panel.join(' x ')} pixels, the patterns ${size.join(' x ')}: put it full screen on the projector's display (F), at 100 %.`);
  if (settings.camera === 'folder') {
    await doIt({verb: 'show', set: name, number: next.number});
    while (!shooting.pause && studio.state.active && studio.state.active.name === name && studio.state.active.done === active.done) await sleep(100);
    return;
  }
  await sleep(webcam.latency);
  const photograph = await grab();
  await ask(`photograph?set=${name}&number=${next.number}`, photograph);
}

// With the codes done: is everything where it was at the first black?
async function checkStill(name, ending) {
  if (studio.state.settings.camera !== 'browser' || !projector.isOpen) return;
  await project({colour: '#000'});
  await sleep(webcam.latency);
  const [before, after] = await Promise.all([
    imageOf(`${name}/001.${ending}`), grab().then(createImageBitmap)]);
  const mean = difference(smallOf(before), smallOf(after));
  if (mean > 3) say(`Something moved, or the light changed, while this was photographed (${mean.toFixed(1)} of 255 between the first black and now): take it again.`);
}

// The board in the photograph under white, as soon as there is one; null: it cannot be looked for (a build without OpenCV).
async function lookForBoard(name) {
  for (let begun = false; ;) {
    const {active, eye} = studio.state;
    if (!active || active.name !== name) return null;
    if (active.looked) return boardOf(name);
    if (eye.end !== 'running') {
      if (begun) return null;
      begun = true;
      await doIt({verb: 'look', set: name});
    }
    await sleep(150);
    await refresh();
  }
}

// True if this board is worth its codes. Without a board in it the set begins again; what was photographed is kept in discarded/.
async function isBoardGood(name) {
  const seen = await lookForBoard(name);
  if (!seen) return true;
  if (seen.found && seen.clipped > 0.05) say(`${share(seen.clipped)} of the board is overexposed under white: expose for less long, and take it again.`);
  if (seen.found) return true;
  await doIt({verb: 'discard', set: name});
  await doIt({verb: 'shoot', set: name});
  await waitForHand(`This cannot be used: ${seen.problem}. Hold the whole board into the light of the projector, before the camera.`, true);
  return false;
}

async function shootSet({name, kind}) {
  const isBoard = kind === 'attitude';
  await darken(kind === 'second');
  let state = await doIt({verb: 'shoot', set: name}), ending = 'png', looked = !isBoard;
  while (state.active && state.active.name === name && !shooting.pause) {
    const wish = isVirtual() ? '' : wishFor(state.active);
    if (wish && !shooting.asked) await waitForHand(wish, !looked);
    shooting.asked = false;
    if (shooting.pause) break;
    if (isStop({kind}) || isSecond({kind})) shooting.at = state.active.angle;
    await takeOne(studio.state.active);
    state = studio.state;
    if (state.active) ending = state.active.ending || ending;
    if (looked || !state.active || !state.active.shots.some((shot) => shot.there && shot.white)) continue;
    looked = await isBoardGood(name);
    shooting.asked = !looked;
    state = studio.state;
  }
  if (shooting.pause) return;
  if (isBoard) await checkStill(name, ending);
  // How well the rig is known by now, while the table is turned; a page that would wait for it looks after the last stop.
  const known = alone() && isStop({kind}) ? stopsOf(objectNow(state)).length : 0;
  if (known >= 3 && (platform.served || objectNow(state).sets.every(complete))) await doIt({verb: 'look', set: name});
}

// Sets one after the other, as far as they are not complete.
async function shootAll(sets) {
  if (shooting.running) return;
  shooting.running = true, shooting.pause = shooting.asked = false, shooting.at = null;
  await attempt(async () => {
    const last = sets[sets.length - 1];
    if (!isVirtual() && sets.some((set) => !(isSecond(set) ? secondProjector : projector).isOpen)) throw new Error('Open the projector window first (step 1; the second one\u2019s in step Look, or Object).');
    if (studio.state.settings.camera === 'browser' && !webcam.stream) throw new Error('Open the camera first (step 1).');
    for (const set of sets) if (!shooting.pause) await shootSet(set);
    if (!shooting.pause && last.kind === 'trial') await doIt({verb: 'run', step: 'now'});
    if (!shooting.pause && isSecond(last) && objectNow(studio.state).second.view !== 'every') await findSecond();
  });
  shooting.running = false;
  for (const listener of studio.listeners) listener(studio.state);
}

// With the set that was begun, and on the simulated rig with those after it.
function goOn({active, sets, objects}) {
  const list = [sets, ...objects.map((object) => object.sets)].find((some) => some.some(({name}) => name === active.name)) || [active];
  const missing = list.filter((set) => set.done < set.count && set.name !== active.name);
  shootAll(isVirtual() ? [active, ...missing] : [active]);
}

$('shooting-go').addEventListener('click', () => shooting.go && shooting.go());
$('shooting-stop').addEventListener('click', () => {
  if (shooting.running) {
    shooting.pause = true;
    if (shooting.go) shooting.go();
  } else goOn(studio.state);
});

// --- What is seen meanwhile. ---

let drawn = '';

const share = (part) => (100 * part).toFixed(1) + ' %';

// Of the brightest channel of each pixel; the shares that are clipped and too dark.
function drawHistogram(canvas, pixels) {
  const counts = new Float64Array(256), context = canvas.getContext('2d'), number = pixels.length / 4;
  let clipped = 0, dark = 0;
  for (let i = 0; i < pixels.length; i += 4) {
    const most = Math.max(pixels[i], pixels[i + 1], pixels[i + 2]);
    counts[most]++;
    clipped += most >= CLIPPED, dark += most <= DARK;
  }
  const height = Math.sqrt(Math.max(...counts.subarray(1, 255)) || 1);
  context.clearRect(0, 0, 256, 120);
  for (let v = 0; v < 256; v++) {
    context.fillStyle = v >= CLIPPED ? '#e5484d' : v <= DARK ? '#5b7fde' : '#c9c5bd';
    const h = Math.min(120, 114 * Math.sqrt(counts[v]) / height);
    context.fillRect(v, 120 - h, 1, h);
  }
  return {clipped: clipped / number, dark: dark / number};
}

function tellExposure(pixels) {
  const {clipped, dark} = drawHistogram($('histogram'), pixels);
  $('exposure').textContent = `under white: ${share(clipped)} clipped, ${share(dark)} too dark` +
    (clipped > 0.02 ? ' \u2013 expose for less long' : dark > 0.9 ? ' \u2013 hardly any light arrives' : '');
}

// The newest photograph, and the histogram of the newest under white.
async function drawTaken(set, shot) {
  const path = `${set.name}/${String(shot.number).padStart(3, '0')}.${set.ending}`;
  if (drawn === path) return;
  drawn = path;
  const image = await imageOf(path), canvas = $('taken');
  canvas.width = 320, canvas.height = Math.max(1, Math.round(320 * image.height / image.width));
  const context = canvas.getContext('2d', {willReadFrequently: true});
  context.drawImage(image, 0, 0, canvas.width, canvas.height);
  $('taken-name').textContent = `photograph ${shot.number}, ${image.width} x ${image.height}`;
  if (shot.white) tellExposure(context.getImageData(0, 0, canvas.width, canvas.height).data);
}

studio.listeners.push((state) => {
  const active = state.active;
  $('shooting').hidden = !active;
  if (!active) return;
  $('shooting-what').textContent = `${titleOf(active)}: ${active.done} of ${active.count}`;
  $('shooting-bar').style.width = 100 * active.done / active.count + '%';
  $('shooting-stop').textContent = shooting.running ? 'Pause' : 'Go on';
  if ($('shown').dataset.file !== active.next.pattern) platform.put($('shown'), $('shown').dataset.file = active.next.pattern);
  $('shown-name').textContent = patternName(active.next.pattern);
  const there = active.shots.filter((shot) => shot.there);
  if (there.length > 0) drawTaken(active, there[there.length - 1]).catch(() => {});
});
