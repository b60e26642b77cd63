'use strict';
// Prediction against reality, now: the object as it stands under a pattern on the real projector, beside what was predicted.

const tried = []; // a line of the table for each comparison since the page was opened

const patternName = (file) => file.replace(/^.*\/|^\d+_|\.png$/g, '').replace(/^\d+_/, '');

function refill(select, options) {
  const wanted = options.map(([value]) => value).join();
  if (select.dataset.options === wanted) return;
  const before = select.value;
  select.dataset.options = wanted;
  select.replaceChildren(...options.map(([value, text]) => new Option(text, value)));
  if (options.some(([value]) => value === before)) select.value = before;
}

function drawNow(state, object) {
  const views = object.sets.filter(isStop), busy = isRunning(state) || shooting.running;
  refill($('now-view'), views.map((set) => [set.name.slice(set.name.lastIndexOf('/') + 1), titleOf(set)]));
  const shown = state.patterns.filter((file) => /^\d{3}_/.test(file) && !/^000_|_(black|white)\.png$|gray/.test(file)); // codes are not pictures
  refill($('now-pattern'), [...shown.map((file) => [file, patternName(file)]), ['own', 'A picture of your own\u2026']]);
  $('now-turned-field').hidden = !isVirtual();
  $('now-go').disabled = busy;
  $('now-register').hidden = !object.now || object.aligned;
  $('now-register').disabled = busy;
  const mark = object.now && !busy ? `${object.name} ${object.aligned} ${JSON.stringify(state.settings.trial)} ${stamp(state, 'now')}` : '';
  if (!object.now) $('now-pictures').hidden = true;
  if (mark && told.now !== mark) told.now = mark, tellNow(state, object);
}

async function overBlack(canvas, path) {
  const image = await imageOf(path);
  canvas.width = image.width, canvas.height = image.height;
  const context = canvas.getContext('2d', {alpha: false, willReadFrequently: true});
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, image.width, image.height);
}

const ENLARGED = 4; // the difference that is shown

// Degrees between the devices' poses before and after they were found again.
async function turnedSince(object) {
  const [before, after] = await Promise.all(['capture', 'aligned'].map(async (which) =>
    JSON.parse(await textOf(`objects/${object.name}/now/${which}/scene.json`)).views[0]));
  return {camera: degreesBetween(before.c2w.flat(), after.c2w.flat()), projector: degreesBetween(before.p2w.flat(), after.p2w.flat())};
}

async function tellNow(state, object) {
  const {trial} = state.settings, id = alone() ? trial.view : trial.view.slice(5), name = trial.pattern === 'own' ? 'own' : patternName(trial.pattern);
  const folder = `objects/${object.name}/now/${object.aligned ? 'aligned' : 'capture'}`;
  const real = await overBlack($('now-real'), `${folder}/${id}_${name}.png`);
  const told = await overBlack($('now-told'), `${folder}/predicted/${object.name}/${id}_${name}.png`);
  const canvas = $('now-difference'), context = canvas.getContext('2d', {alpha: false}), apart = new ImageData(real.width, real.height);
  for (let i = 0; i < apart.data.length; i++) apart.data[i] = i % 4 === 3 ? 255 : Math.min(255, ENLARGED * Math.abs(real.data[i] - told.data[i]));
  canvas.width = real.width, canvas.height = real.height;
  context.putImageData(apart, 0, 0);
  const {rows} = JSON.parse(await textOf(folder + '/scores.json')), row = rows.find(({protocol}) => protocol === 'rendering');
  const found = object.aligned ? await turnedSince(object) : null;
  const what = found ? `devices found again: camera turned by ${found.camera.toFixed(2)}\u00b0, projector by ${found.projector.toFixed(2)}\u00b0` : `${Number(trial.view.slice(5))}\u00b0, ${name}${trial.turned ? `, table off by ${trial.turned}\u00b0` : ''}`;
  tried.push([what, row.psnr.toFixed(2), row.psnr_foreground.toFixed(2)]);
  $('now-scores').tBodies[0].replaceChildren(...tried.slice(-8).map((cells) => element('tr', {}, ...cells.map((text) => element('td', {textContent: text})))));
  platform.put($('now-report'), `${folder}/report.html`);
  $('now-pictures').hidden = false;
}

// A picture of any shape, cut to the projector's.
async function sendOwn(file) {
  const [width, height] = studio.state.settings.projector, image = await createImageBitmap(file);
  const canvas = element('canvas', {width, height}), scale = Math.max(width / image.width, height / image.height);
  canvas.getContext('2d', {alpha: false}).drawImage(image, (width - scale * image.width) / 2, (height - scale * image.height) / 2, scale * image.width, scale * image.height);
  await ask('own', await new Promise((done) => canvas.toBlob(done, 'image/png')));
}

async function compareNow() {
  const object = objectNow(studio.state), turned = isVirtual() ? Math.round(number('now-turned')) : 0;
  await doIt({verb: 'try', view: $('now-view').value, pattern: $('now-pattern').value, turned});
  await shootAll([{name: `objects/${object.name}/now`, kind: 'trial'}]);
}

$('now-go').addEventListener('click', () => attempt(compareNow));
$('now-register').addEventListener('click', () => runStep('register'));
$('now-pattern').addEventListener('change', () => { if ($('now-pattern').value === 'own') $('now-file').click(); });
$('now-file').addEventListener('change', () => attempt(async () => {
  if ($('now-file').files.length > 0) await sendOwn($('now-file').files[0]);
}));
