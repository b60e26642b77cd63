'use strict';
// Cameras, and the window on the projector.

// --- The projectors' windows, each by a channel that only pages of this studio share. ---

class ProjectorChannel {
  constructor(number) {
    this.number = number, this.window = this.panel = null, this.waiting = new Map(), this.last = 0;
    this.wire = new Wire(`studio ${platform.served ? location.pathname : ''}${number}`, (data) => { if (data.from === 'projector') this.hear(data); });
    this.wire.post({from: 'studio'}); // one that was open before a reload answers
  }

  get isOpen() { return !!this.panel; }

  hear(data) {
    this.panel = data.closed ? null : data.panel;
    const wait = this.waiting.get(data.id);
    if (wait) {
      this.waiting.delete(data.id);
      if (data.failed) wait.fail(new Error(`The projector window cannot show the pattern: ${data.failed}`)); else wait.done(data);
    }
    if (data.closed) {
      for (const w of this.waiting.values()) w.fail(new Error('The projector window was closed: open it again.'));
      this.waiting.clear();
    }
    for (const listener of studio.listeners) if (studio.state) listener(studio.state);
  }
}

const projector = new ProjectorChannel(1), secondProjector = new ProjectorChannel(2);

function project(what, on = projector) {
  const id = ++on.last;
  return new Promise((done, fail) => {
    if (!on.isOpen) return fail(new Error('Open the projector window first.'));
    on.waiting.set(id, {done, fail});
    on.wire.post({from: 'studio', id, ...what});
    setTimeout(() => on.waiting.delete(id) && fail(new Error('The projector window does not answer: is it hidden, or closed? Open it again.')), 5000);
  });
}

// On another display where the browser tells of one (Window Management API): the second projector on the last.
async function openProjector(on = projector) {
  let place = 'popup,width=960,height=600';
  if (window.getScreenDetails && screen.isExtended) {
    const details = await getScreenDetails().catch(() => null);
    const others = details ? details.screens.filter((s) => s !== details.currentScreen) : [], other = others[Math.min(on.number, others.length) - 1];
    if (other) place = `popup,left=${other.availLeft},top=${other.availTop},width=${other.availWidth},height=${other.availHeight}`;
  }
  on.window = platform.projector(on.number, place);
  if (!on.window) throw new Error('The browser blocked the projector window: allow this page to open windows.');
  on.wire.peers.add(on.window); // where there is no channel, one that was open before a reload
  on.wire.post({from: 'studio'});
}

// --- This browser's camera. ---

const AVERAGED = 4; // frames of one photograph

const webcam = {stream: null, held: '', latency: 250};

async function listCameras() {
  const devices = (await navigator.mediaDevices.enumerateDevices()).filter((d) => d.kind === 'videoinput');
  $('devices').replaceChildren(...devices.map((d, i) => new Option(d.label || `Camera ${i + 1}`, d.deviceId)));
  if (webcam.stream) $('devices').value = webcam.stream.getVideoTracks()[0].getSettings().deviceId;
}

// Holds all settings that the browser can hold: with exposure, white balance and focus on their own, codes cannot be read.
async function holdStill(track) {
  const can = track.getCapabilities ? track.getCapabilities() : {}, held = [];
  for (const mode of ['exposureMode', 'whiteBalanceMode', 'focusMode']) {
    if (!can[mode] || !can[mode].includes('manual')) continue;
    await track.applyConstraints({advanced: [{[mode]: 'manual'}]}).then(() => held.push(mode), () => {});
  }
  const names = {exposureMode: 'exposure', whiteBalanceMode: 'white balance', focusMode: 'focus'};
  const free = Object.keys(names).filter((mode) => !held.includes(mode)).map((mode) => names[mode]);
  return free.length === 0 ? 'Exposure, white balance and focus are held.'
    : `This browser cannot hold ${free.join(', ')}: switch the automatic off in the camera's own program.`;
}

async function openCamera() {
  if (webcam.stream) for (const track of webcam.stream.getTracks()) track.stop();
  const device = $('devices').value;
  const video = {width: {ideal: 4096}, height: {ideal: 2160}, ...(device ? {deviceId: {exact: device}} : {})};
  try {
    webcam.stream = await navigator.mediaDevices.getUserMedia({video, audio: false});
  } catch (error) {
    webcam.stream = null;
    throw new Error(`The camera cannot be opened: ${error.message}`);
  }
  const track = webcam.stream.getVideoTracks()[0];
  track.addEventListener('ended', () => { webcam.stream = null; $('live').hidden = true; say('The camera is gone: plug it in, and open it again.'); });
  webcam.held = await holdStill(track);
  $('preview').srcObject = webcam.stream;
  $('preview').hidden = false;
  await $('preview').play();
  $('camera-size').textContent = `${$('preview').videoWidth} x ${$('preview').videoHeight} pixels`;
  $('camera-held').textContent = webcam.held;
  $('live').hidden = false;
  watchLive();
  await listCameras();
}

const nextFrame = (video) => new Promise((done, fail) => {
  if (!video.requestVideoFrameCallback) return setTimeout(done, 40);
  const late = setTimeout(() => fail(new Error('The camera gives no new picture: is it unplugged, in use elsewhere, or this page hidden?')), 6000);
  video.requestVideoFrameCallback(() => { clearTimeout(late); done(); });
});

function frameOf(video) {
  const canvas = element('canvas', {width: video.videoWidth, height: video.videoHeight});
  const context = canvas.getContext('2d', {willReadFrequently: true});
  context.drawImage(video, 0, 0);
  return {canvas, context, pixels: context.getImageData(0, 0, canvas.width, canvas.height)};
}

// The mean of some frames, as a PNG.
async function grab() {
  const video = $('preview');
  if (!webcam.stream) throw new Error('Open the camera first.');
  await nextFrame(video); // the one that is there may be older than the pattern
  const first = frameOf(video), sum = new Uint16Array(first.pixels.data);
  for (let n = 1; n < AVERAGED; n++) {
    await nextFrame(video);
    const more = frameOf(video).pixels.data;
    for (let i = 0; i < sum.length; i++) sum[i] += more[i];
  }
  for (let i = 0; i < sum.length; i++) first.pixels.data[i] = Math.round(sum[i] / AVERAGED);
  first.context.putImageData(first.pixels, 0, 0);
  return new Promise((done, fail) => first.canvas.toBlob((blob) => blob ? done(blob) : fail(new Error('No memory.')), 'image/png'));
}

const brightness = (video) => {
  const canvas = element('canvas', {width: 64, height: 48}), context = canvas.getContext('2d', {willReadFrequently: true});
  context.drawImage(video, 0, 0, 64, 48);
  const data = context.getImageData(0, 0, 64, 48).data;
  let sum = 0;
  for (let i = 0; i < data.length; i += 4) sum += data[i] + data[i + 1] + data[i + 2];
  return sum / (data.length / 4 * 3);
};

// From the pattern on the screen until the camera's picture has settled: flashes, the slowest of which counts.
async function measureLatency() {
  const video = $('preview');
  if (!webcam.stream) throw new Error('Open the camera first.');
  let slowest = 0;
  for (let flash = 0; flash < 3; flash++) {
    await project({colour: '#000'});
    await sleep(1200);
    const dark = brightness(video);
    await project({colour: '#fff'});
    const start = performance.now(), seen = [];
    while (performance.now() - start < 1500) {
      await nextFrame(video);
      seen.push([performance.now() - start, brightness(video)]);
    }
    const light = seen[seen.length - 1][1];
    if (light - dark < 3) throw new Error('The camera does not see the projector flash: is its window on the projector, and the camera turned to it?');
    const settled = seen.findIndex(([, value]) => value > dark + 0.95 * (light - dark));
    slowest = Math.max(slowest, seen[settled][0]);
  }
  webcam.latency = Math.round(slowest * 1.25 + 34);
  return webcam.latency;
}

// --- What the camera sees now, before anything is photographed. ---

const live = {best: 0, means: [], running: false};

// Mean square of the Laplacian of the middle of the picture, at full resolution: relative to the best so far it tells how
// sharp the picture is (Pertuz et al. 2013, LAPM).
function sharpness(video) {
  const side = Math.min(384, video.videoWidth, video.videoHeight), canvas = element('canvas', {width: side, height: side});
  const context = canvas.getContext('2d', {willReadFrequently: true});
  context.drawImage(video, (video.videoWidth - side) / 2, (video.videoHeight - side) / 2, side, side, 0, 0, side, side);
  const data = context.getImageData(0, 0, side, side).data, green = (x, y) => data[4 * (y * side + x) + 1];
  let sum = 0;
  for (let y = 1; y < side - 1; y++)
    for (let x = 1; x < side - 1; x++) {
      const l = 4 * green(x, y) - green(x - 1, y) - green(x + 1, y) - green(x, y - 1) - green(x, y + 1);
      sum += l * l;
    }
  return sum / (side * side);
}

// Standard deviation of the brightness of the last frames, relative to their mean: lamps and projectors flicker.
function flicker(means) {
  const mean = means.reduce((a, b) => a + b, 0) / means.length;
  return mean > 0 ? Math.sqrt(means.reduce((a, b) => a + (b - mean) ** 2, 0) / means.length) / mean : 0;
}

function tellLive(video) {
  const canvas = element('canvas', {width: 320, height: 240}), context = canvas.getContext('2d', {willReadFrequently: true});
  context.drawImage(video, 0, 0, 320, 240);
  const {clipped, dark} = drawHistogram($('live-histogram'), context.getImageData(0, 0, 320, 240).data);
  const sharp = sharpness(video), shake = live.means.length === 30 ? flicker(live.means) : 0;
  live.best = Math.max(live.best, sharp);
  const says = [[`${share(clipped)} clipped`, clipped > 0.02 && 'expose for less long'], [`${share(dark)} too dark`, dark > 0.9 && 'hardly any light arrives'],
    [`${Math.round(100 * sharp / Math.max(live.best, 1e-9))} % as sharp as at best so far`, sharp < 0.7 * live.best && 'turn the focus back'],
    [`brightness varies by ${(100 * shake).toFixed(1)} %`, shake > 0.01 && 'the light flickers: expose for a multiple of 1/100 or 1/120 s, or of the projector\u2019s frame']];
  $('live-says').replaceChildren(...says.map(([text, advice]) => element('li', {className: advice ? 'doubt' : '', textContent: advice ? `${text} \u2013 ${advice}` : text})));
}

// While the first step is on the screen.
async function watchLive() {
  if (live.running) return;
  live.running = true, live.best = 0, live.means = [];
  const video = $('preview');
  for (let told = 0; webcam.stream && !$('rig').hidden;) {
    try { await nextFrame(video); } catch { continue; }
    live.means = [...live.means.slice(-29), brightness(video)];
    if (performance.now() - told > 250) told = performance.now(), tellLive(video);
    await sleep(20);
  }
  live.running = false;
}

async function showForLive(what) {
  await project(what);
  live.best = 0, live.means = []; // of another picture
}
$('live-white').addEventListener('click', () => attempt(() => showForLive({colour: '#fff'})));
$('live-black').addEventListener('click', () => attempt(() => showForLive({colour: '#000'})));
$('live-chart').addEventListener('click', () => attempt(() => platform.blob('patterns/000_focus.png').then((image) => showForLive({image}))));
