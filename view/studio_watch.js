'use strict';
// Keeping watch over a show: the picture that it projects is photographed as it is, and if the photograph is not like the last
// one, camera and projector are found again by it (`align --gaussians --pattern own`). The viewer follows.

const SHIFTED = 0.0015, WATCH_EVERY = 500; // mean shift of the object in a picture, shares of its width; ms from look to look
const LOST = 2, LOST_ANYWHERE = 3.5;       // times the least difference of photograph and prediction: under this picture, under any
const ALIKE = 1.5, NOISE = 0.1;            // times the least difference of two photographs of the same; of 255, at least
const SKIPPED = 4;                         // looks in a row that are content with that: small moves escape it

// The mean distance in a device's picture between points seen from one pose and from another. `project` is the page's.
function shiftBetween(project, device, from, to, points) {
  const apart = points.map((point) => {
    const [x, y] = project({...device, pose: from}, point), [u, v] = project({...device, pose: to}, point);
    return Math.hypot(x - u, y - v);
  });
  return apart.reduce((sum, d) => sum + d, 0) / apart.length;
}

// Degrees between two poses, row-major 4 x 4.
function degreesBetween(a, b) {
  let trace = 0;
  for (let i = 0; i < 3; i++) for (let k = 0; k < 3; k++) trace += a[4 * i + k] * b[4 * i + k];
  return Math.acos(Math.min(1, Math.max(-1, (trace - 1) / 2))) * 180 / Math.PI;
}

// The findings of a look in words. `difference` of photograph and prediction, and the photograph's `light`; `least`: the least
// difference under this picture of the show, `share`: the least one per light under any (null: none yet).
function watchVerdict({camera, projector, difference, light}, {least, share}) {
  const devices = [['camera', camera], ['projector', projector]], moved = devices.filter(([, {pixels, width}]) => pixels > SHIFTED * width);
  if ((least !== null && difference > LOST * least) || (share !== null && light > 0 && difference > LOST_ANYWHERE * share * light))
    return {moved: true, found: false, text: 'Something has moved, or the light has changed, and camera and projector could not be found again.'};
  if (!moved.length) return {moved: false, found: true, text: 'Nothing has moved.'};
  const how = devices.map(([name, {degrees, pixels}]) => `${name} by ${degrees.toFixed(2)}°, ${pixels.toFixed(1)} pixels`).join(', ');
  const what = moved.length === 2 ? 'The object, or camera and projector, have moved' : `The ${moved[0][0]} has moved`;
  return {moved: true, found: true, text: `${what} (${how}). Found again; the picture follows.`};
}

// Poses hold for one view of one viewer, what was photographed for one picture of the show.
function beginAgain(watching, view, pixels) {
  if (watching.view !== view) watching.view = view, watching.poses = watching.pixels = watching.share = null;
  if (!watching.pixels || pixels.some((value, i) => value !== watching.pixels[i])) watching.pixels = pixels, watching.least = watching.seen = watching.apart = null;
}

// True if a photograph, `differs` from the one by which devices were found last, shows that nothing has moved since.
function looksAlike({seen, apart}, differs) { return seen !== null && apart !== null && differs <= ALIKE * Math.max(apart, NOISE); }

// True if that spares the search, as it does a few times in a row.
function sparesSearch(watching, differs) {
  watching.skipped = looksAlike(watching, differs) && watching.skipped < SKIPPED ? watching.skipped + 1 : 0;
  return watching.skipped > 0;
}

const watching = {on: false, busy: false, view: null, poses: null, pixels: null, least: null, share: null, seen: null, apart: null, skipped: 0};

const viewerOf = () => $('viewer').contentWindow;

async function pictureOfShow(page) {
  const {viewer} = page, projector = viewer.projectors.find((p) => p.window.isOpen) || viewer.projectors[0];
  viewer.updatePatterns();
  const {width, height, data} = page.panelPicture(viewer.graphics, projector, projector.panel, watching.kept = watching.kept || {});
  const canvas = element('canvas', {width, height}), copy = new Uint8ClampedArray(data);
  canvas.getContext('2d', {alpha: false}).putImageData(new ImageData(copy, width, height), 0, 0);
  return {projector, pixels: new Uint32Array(copy.buffer), blob: await new Promise((done) => canvas.toBlob(done, 'image/png'))};
}

async function smallPhotograph(path) {
  const image = await imageOf(path);
  try {
    return smallOf(image);
  } finally {
    image.close();
  }
}

// The one photograph of the set, small; the viewer's projector window shows the picture already.
async function photographShow(name) {
  let state = await doIt({verb: 'shoot', set: name});
  const {number} = state.active.next;
  while (state.active && state.active.name === name) {
    if (isVirtual()) await takeOne(state.active);
    else await ask(`photograph?set=${name}&number=${number}`, await grab());
    state = studio.state;
  }
  return smallPhotograph(`${name}/${String(number).padStart(3, '0')}.png`);
}

async function jobEnds(name) {
  while (isRunning(studio.state, name)) {
    await sleep(60);
    await refresh();
  }
  if (studio.state.job.end !== 'done') throw new Error(studio.state.job.error || `${name} has failed`);
}

// Moves what stands where it was believed to be.
function followPoses(page, view, projector, before, now) {
  const {viewer} = page, same = (pose) => pose.every((x, i) => Math.abs(x - before.projector[i]) < 1e-6);
  for (const p of viewer.projectors) if (p === projector || same(p.device.pose)) p.device = {...p.device, pose: now.projector};
  view.camera = {...view.camera, pose: now.camera}, view.projector = {...view.projector, pose: now.projector};
  viewer.invalidate(true);
  viewer.changed('device');
}

// Camera and projector by the photograph that was taken last, and how much of it is not as predicted.
async function findDevices(object) {
  await doIt({verb: 'run', step: 'watch'});
  await jobEnds('watch');
  const {c2w, p2w} = JSON.parse(await textOf(`objects/${object.name}/now/aligned/scene.json`)).views[0], {log} = studio.state.job;
  return {now: {camera: c2w.flat(), projector: p2w.flat()}, left: JSON.parse(log.slice(log.lastIndexOf('\n{') + 1)).after}; // align's figures are its end
}

// The verdict of a look at a photograph that `differs` from the last one; the viewer follows.
function judge(page, view, projector, {now, left}, small, differs) {
  const before = watching.poses || {camera: view.camera.pose, projector: view.projector.pose}, {centre, radius} = page.viewer.scene;
  const points = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]].map((side) => side.map((x, k) => centre[k] + 0.8 * x * radius));
  const since = (name, device) => ({degrees: degreesBetween(before[name], now[name]), pixels: shiftBetween(page.project, device, before[name], now[name], points), width: device.width});
  const light = difference(small, new Uint8ClampedArray(small.length)) / 255;
  const told = watchVerdict({camera: since('camera', view.camera), projector: since('projector', view.projector), difference: left, light}, watching);
  if (!told.found) return told.text;
  if (told.moved) followPoses(page, view, projector, before, now);
  else if (differs !== null) watching.apart = Math.min(differs, watching.apart ?? differs);
  if (told.moved || !watching.poses) watching.poses = now;
  watching.least = Math.min(left, watching.least ?? left);
  if (light > 0) watching.share = Math.min(left / light, watching.share ?? left / light);
  watching.seen = small;
  return told.text;
}

async function lookOnce() {
  const page = viewerOf(), object = objectNow(studio.state);
  if (!page.viewer || page.viewer.playing) return 'A film or a fade is running: the next look waits for its end.';
  if (!isVirtual() && !(studio.state.settings.camera === 'browser' && webcam.stream)) throw new Error('Watching needs the browser’s camera: open it (step 1).');
  const {projector, pixels, blob} = await pictureOfShow(page), stop = $('now-view').value;
  const view = page.viewer.scene.views.find(({id}) => stop === id || stop === `view-${id}`);
  if (!view) throw new Error(`The viewer has no view ${stop}.`);
  await ask('own?watch=true', blob);
  await doIt({verb: 'try', view: stop, pattern: 'own', turned: isVirtual() ? Math.round(number('now-turned')) : 0, watch: true});
  const small = await photographShow(`objects/${object.name}/now`), taken = performance.now();
  const when = () => `(${new Date().toLocaleTimeString()}, ${((performance.now() - taken) / 1000).toFixed(1)} s)`;
  beginAgain(watching, view, pixels);
  const differs = watching.seen && difference(watching.seen, small);
  const alike = looksAlike(watching, differs);
  if (sparesSearch(watching, differs)) return `Nothing has moved. ${when()}`;
  if (watching.apart !== null && !alike) $('watch-says').textContent = 'Something has moved, or the light has changed: looking for camera and projector…';
  return `${judge(page, view, projector, await findDevices(object), small, differs)} ${when()}`;
}

function setWatch(on) {
  watching.on = on;
  if (on) watching.least = watching.share = watching.seen = watching.apart = null; // the light may be another one now
  $('watch').textContent = on ? 'Stop watching' : 'Keep watch';
}

async function keepWatch() {
  setWatch(!watching.on);
  if (!watching.on || watching.busy) return;
  watching.busy = true;
  try {
    while (watching.on) {
      if (!shooting.running && !isRunning(studio.state)) $('watch-says').textContent = await lookOnce();
      await sleep(WATCH_EVERY);
    }
  } finally {
    watching.busy = false;
    setWatch(false);
  }
}

if (typeof document !== 'undefined') $('watch').addEventListener('click', () => attempt(keepWatch));
