'use strict';
// Keeping watch over a show: the picture that it projects is photographed as it is, and camera and projector are found again
// by it (`align --gaussians --pattern own`). The viewer follows.

const SHIFTED = 0.0015, LOST = 2, WATCH_EVERY = 1500; // mean shift of the object in a picture, shares of its width; times the
// difference that there was; ms from look to look

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

// The findings of a look in words. `least`: the least difference of picture and prediction that there was (null: none yet).
function watchVerdict({camera, projector, difference}, least) {
  const devices = [['camera', camera], ['projector', projector]], moved = devices.filter(([, {pixels, width}]) => pixels > SHIFTED * width);
  if (least !== null && difference > LOST * least)
    return {moved: true, found: false, text: 'Something has moved, or the light has changed, and camera and projector could not be found again.'};
  if (!moved.length) return {moved: false, found: true, text: 'Nothing has moved.'};
  const how = devices.map(([name, {degrees, pixels}]) => `${name} by ${degrees.toFixed(2)}°, ${pixels.toFixed(1)} pixels`).join(', ');
  const what = moved.length === 2 ? 'The object, or camera and projector, have moved' : `The ${moved[0][0]} has moved`;
  return {moved: true, found: true, text: `${what} (${how}). Found again; the picture follows.`};
}

// Poses hold for one view of one viewer, the least difference for one picture of the show.
function beginAgain(watching, view, pixels) {
  if (watching.view !== view) watching.view = view, watching.poses = watching.pixels = null;
  if (!watching.pixels || pixels.some((value, i) => value !== watching.pixels[i])) watching.pixels = pixels, watching.least = null;
}

const watching = {on: false, busy: false, view: null, poses: null, pixels: null, least: null};

const viewerOf = () => $('viewer').contentWindow;

async function pictureOfShow(page) {
  const {viewer} = page, projector = viewer.projectors.find((p) => p.window.isOpen) || viewer.projectors[0];
  viewer.updatePatterns();
  const {width, height, data} = page.panelPicture(viewer.graphics, projector, viewer.scene.panel, watching.kept = watching.kept || {});
  const canvas = element('canvas', {width, height}), copy = new Uint8ClampedArray(data);
  canvas.getContext('2d', {alpha: false}).putImageData(new ImageData(copy, width, height), 0, 0);
  return {projector, pixels: new Uint32Array(copy.buffer), blob: await new Promise((done) => canvas.toBlob(done, 'image/png'))};
}

// The one photograph of the set; the viewer's projector window shows the picture already.
async function photographShow(name) {
  let state = await doIt({verb: 'shoot', set: name});
  while (state.active && state.active.name === name) {
    if (isVirtual()) await takeOne(state.active);
    else await ask(`photograph?set=${name}&number=${state.active.next.number}`, await grab());
    state = studio.state;
  }
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

async function lookOnce() {
  const page = viewerOf(), object = objectNow(studio.state);
  if (!page.viewer || page.viewer.playing) return 'A film or a fade is running: the next look waits for its end.';
  if (!isVirtual() && !(studio.state.settings.camera === 'browser' && webcam.stream)) throw new Error('Watching needs the browser’s camera: open it (step 1).');
  const {projector, pixels, blob} = await pictureOfShow(page), stop = $('now-view').value;
  await ask('own?watch=true', blob);
  await doIt({verb: 'try', view: stop, pattern: 'own', turned: isVirtual() ? Math.round(number('now-turned')) : 0, watch: true});
  await photographShow(`objects/${object.name}/now`);
  const taken = performance.now();
  await doIt({verb: 'run', step: 'watch'});
  await jobEnds('watch');
  const found = JSON.parse(await textOf(`objects/${object.name}/now/aligned/scene.json`)).views[0], now = {camera: found.c2w.flat(), projector: found.p2w.flat()};
  const view = page.viewer.scene.views.find(({id}) => id === found.id), {centre, radius} = page.viewer.scene;
  if (!view) throw new Error(`The viewer has no view ${found.id}.`);
  beginAgain(watching, view, pixels);
  const before = watching.poses || {camera: view.camera.pose, projector: view.projector.pose};
  const points = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]].map((side) => side.map((x, k) => centre[k] + 0.8 * x * radius));
  const since = (name, device) => ({degrees: degreesBetween(before[name], now[name]), pixels: shiftBetween(page.project, device, before[name], now[name], points), width: device.width});
  const {log} = studio.state.job, difference = JSON.parse(log.slice(log.lastIndexOf('\n{') + 1)).after; // align's figures are its end
  const told = watchVerdict({camera: since('camera', view.camera), projector: since('projector', view.projector), difference}, watching.least);
  if (told.found) {
    if (told.moved) followPoses(page, view, projector, before, now);
    if (told.moved || !watching.poses) watching.poses = now;
    watching.least = watching.least === null ? difference : Math.min(watching.least, difference);
  }
  return `${told.text} (${new Date().toLocaleTimeString()}, ${((performance.now() - taken) / 1000).toFixed(1)} s)`;
}

function setWatch(on) {
  watching.on = on;
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
