'use strict';
// The page that reconstructs: drop a capture, watch, look, save. The engine works in a worker (engine_worker.js), so that the page stays
// alive and cancelling is ending the worker.

const $ = (id) => document.getElementById(id);

function payload(id) {
  const text = $(id).textContent;
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  return Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
}

async function unpacked(id) {
  const stream = new Blob([payload(id)]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

class Engine {
  constructor() {
    this.worker = null;
    this.waiting = null;
    this.stops = 0;
    this.last = Promise.resolve(); // of the requests: the next is sent when it is answered
    this.tell = (said) => {};
    this.ended = () => {};
  }

  async start() {
    if (document.readyState === 'loading') await new Promise((done) => addEventListener('DOMContentLoaded', done)); // the engine stands at the page's end
    // Memory may be shared among threads where the page is isolated; opened from disk it is not.
    const many = self.crossOriginIsolated && navigator.hardwareConcurrency > 1 && $('threads.wasm'), module = many ? 'threads' : 'module';
    const { stops } = this, wasm = this.worker ? null : await unpacked(`${module}.wasm`);
    if (stops !== this.stops) throw new Message('Cancelled.');
    if (this.worker) return;
    const script = new Blob([payload(`${module}.js`), $('engine_worker.js').textContent], { type: 'text/javascript' });
    this.worker = new Worker(URL.createObjectURL(script));
    this.worker.onmessage = ({ data }) => {
      if (data.kind !== 'answer') { this.tell(data); return; }
      const { done, fail } = this.waiting;
      this.waiting = null;
      // Paths as they were dropped.
      if (data.error) fail(Object.assign(new Message(data.error.replaceAll(/(?<![\w.-])\/(dropped|made)\//g, '')), { fault: data.fault }));
      else done(data);
    };
    this.worker.onerror = (event) => {
      if (this.waiting) this.waiting.fail(new Message(`The engine stopped: ${event.message}`));
      this.stop();
    };
    const threads = many ? { script: payload('threads.js'), worker: payload('threads.worker.js') } : null;
    document.body.dataset.threads = many ? navigator.hardwareConcurrency : 1;
    await this.ask({ kind: 'start', wasm, weights: payload('small.safetensors'), threads });
  }

  // One request at a time, in their order.
  ask(message, moved = []) {
    const { worker } = this, send = () => new Promise((done, fail) => {
      if (!this.worker || this.worker !== worker) { fail(new Message('Cancelled.')); return; }
      this.waiting = { done, fail };
      worker.postMessage(message, moved);
    });
    this.last = this.last.then(send, send);
    return this.last;
  }

  stop() {
    this.stops++;
    if (this.worker) this.worker.terminate();
    if (this.waiting) this.waiting.fail(new Message('Cancelled.'));
    this.worker = this.waiting = null;
    this.ended();
  }
}

const engine = new Engine();
window.engine = engine; // the studio's, too, which is a frame of this page (studio_page.js)
const state = { name: '', files: null, fault: null };
const TRUTH = ['depth', 'normal', 'albedo', 'roughness', 'direct_white']; // of a view in scene.json

function note(text) {
  const line = document.createElement('li');
  line.className = 'note';
  line.textContent = text;
  $('notes').append(line);
}

// A bar of unknown length would be drawn sixty times a second, in software where there is no GPU: it is an empty one.
engine.tell = (data) => {
  if (data.kind === 'log') { note(data.text); return; }
  if (data.kind === 'finding') {
    const finding = JSON.parse(data.finding);
    if (finding.severity === 'fault') state.fault = finding; // told with the error that it is
    else if (!isPassed(finding) && !document.querySelector(`#notes [data-code="${finding.code}"]`)) $('notes').append(findingItem(finding));
    return;
  }
  $('stage').textContent = data.stage ? data.stage[0].toUpperCase() + data.stage.slice(1) : 'Working';
  $('bar').value = data.total > 0 ? data.done / data.total : 0;
  $('detail').textContent = (data.total > 0 ? `${data.done} of ${data.total}` : '') + (data.left > 1 ? `, about ${Math.ceil(data.left)} s left` : '');
};

function showWork(text) {
  $('problem').hidden = $('force').hidden = true;
  $('work').hidden = false;
  $('stage').textContent = text;
  $('detail').textContent = '';
  $('bar').value = 0;
}

function showProblem(error) {
  $('work').hidden = true;
  $('problem').hidden = false;
  $('why').textContent = error instanceof Message ? error.message : `That did not work: ${error.message}`;
  if (error.fault && state.fault) $('why').replaceChildren(...faultSaid(error.message, state.fault));
  $('problem').scrollIntoView({ block: 'nearest' });
  if (!(error instanceof Message)) console.warn(error);
}

// The folder nearest to the top that has one of the files by which a capture is known (docs/reference/formats/capture.md); null: none has.
function captureRoot(files) {
  const scenes = files.map(({ path }) => path).filter((path) => /(^|\/)(scene|render_poses)\.json$/.test(path));
  scenes.sort((a, b) => a.split('/').length - b.split('/').length || (a < b ? -1 : 1));
  return scenes.length ? scenes[0].replace(/\/?[a-z_]+\.json$/, '') : null;
}

// The output of `ffprocams info` on the capture, behind a button; its advice is among the messages.
function showChecks(text) {
  const doubts = document.querySelectorAll('#notes [data-code]').length;
  $('checks-text').textContent = text;
  $('checks').textContent = doubts ? `Checks (${doubts})\u2026` : 'Checks\u2026';
}

function showResult({ stats, page }) {
  const seconds = stats.initialisation + stats.network + stats.polish + stats.noise;
  $('title').textContent = state.name;
  $('figures').textContent = `${stats.gaussians.toLocaleString('en')} splats, ${stats.psnr.toFixed(1)} dB on the photographs, ${seconds.toFixed(1)} s`;
  $('start').hidden = true;
  $('result').hidden = false;
  $('viewer').srcdoc = new TextDecoder().decode(page);
  document.body.dataset.stats = JSON.stringify(stats);
}

// Depth and the like, by which results are judged, the engine does not need: where they are files that a page cannot read, they are left out.
function withoutTruth(files, root) {
  const scene = files.find(({ path }) => path === (root ? `${root}/scene.json` : 'scene.json'));
  if (!scene) return files;
  const left = new Set();
  let description;
  try {
    description = JSON.parse(new TextDecoder().decode(scene.bytes));
    for (const view of description.views) {
      for (const key of TRUTH.filter((one) => /\.(exr|tiff?)$/i.test(view[one]))) {
        left.add(key.replace('_', ' '));
        delete view[key];
      }
    }
  } catch {
    return files; // the engine says what is wrong with it
  }
  if (!left.size) return files;
  note(`Left out, because a page reads no EXR or TIFF: ${[...left].join(', ')} (true values, to compare with; the reconstruction needs none)`);
  const bytes = new TextEncoder().encode(JSON.stringify(description));
  return files.map((file) => (file === scene ? { path: file.path, bytes } : file));
}

async function reconstruct(force) {
  const { files, folder } = state;
  try {
    showWork('Starting the engine');
    await engine.start();
    showWork('Reading the capture');
    if (state.put !== engine.worker) await engine.ask({ kind: 'put', files });
    state.put = engine.worker;
    const { text } = await engine.ask({ kind: 'open', folder });
    showChecks(text);
    const answer = await engine.ask({ kind: 'run', polish: $('polish').checked ? -1 : 0, force });
    $('work').hidden = true;
    showResult(answer);
  } catch (error) {
    showProblem(error);
    // The engine refuses captures with a fault; whoever knows better goes on.
    $('force').hidden = !error.fault;
  }
}

// Photographs become a capture first.
async function makeCapture(choices) {
  try {
    $('photographs').hidden = true;
    $('notes').textContent = '';
    showWork('Starting the engine');
    await engine.start();
    await engine.ask({ kind: 'put', files: state.files });
    state.put = engine.worker;
    showWork('Making a capture of the photographs');
    await engine.ask({ kind: 'command', words: captureWords(choices) });
    state.folder = CAPTURE;
    await reconstruct(false);
  } catch (error) {
    $('photographs').hidden = false;
    showProblem(error);
  }
}

async function take(reading) {
  if (!$('work').hidden) return;
  $('photographs').hidden = true;
  try {
    showWork('Reading the files');
    const files = await reading(), root = captureRoot(files);
    $('notes').textContent = '';
    state.files = root === null ? files : withoutTruth(files, root);
    state.put = null;
    state.name = (root ?? state.files[0]?.path.split('/')[0])?.split('/').pop() || 'object';
    state.folder = `/dropped/${root}`;
    if (root !== null) {
      await reconstruct(false);
    } else {
      askAboutPhotographs(state.files);
      $('work').hidden = true;
    }
  } catch (error) {
    showProblem(error);
  }
}

// The patterns in a window of their own, which has to be opened while the button is being pressed.
async function showPatterns() {
  if (!$('work').hidden) return;
  const size = $('projector').value.trim(), beside = window.open('', '_blank');
  try {
    showWork('Drawing the patterns');
    await engine.start();
    await engine.ask({ kind: 'command', words: ['patterns', '--projector', size, '-o', '/made/patterns'] });
    const { bytes } = await engine.ask({ kind: 'read', path: '/made/patterns/show.html' });
    $('panel').value = size;
    $('work').hidden = true;
    if (!beside) throw new Message('The browser does not let this page open a window: allow it, and try again.');
    beside.location = URL.createObjectURL(new Blob([bytes], { type: 'text/html' }));
  } catch (error) {
    if (beside) beside.close();
    showProblem(error);
  }
}

// The studio takes this page's place; its folder is the browser's own, which one page at a time works in.
async function openStudio() {
  if (!$('work').hidden) return; // something is being read or made
  const alone = await new Promise((done) => {
    if (!navigator.locks) done(true);
    else navigator.locks.request('ffprocams studio', { ifAvailable: true }, (lock) => { done(!!lock); return lock ? new Promise(() => {}) : null; }).catch(() => done(true));
  });
  if (!alone) { showProblem(new Message('The studio is open in another window of this browser.')); return; }
  if (navigator.storage && navigator.storage.persist) navigator.storage.persist().catch(() => {}); // asked for: what is photographed stays
  engine.stop();
  $('start').hidden = true;
  $('studio').hidden = false;
  $('studio').srcdoc = $('studio.html').textContent.replaceAll('<\\/script', '</script');
}

async function save(kind) {
  const bytes = (await engine.ask({ kind: 'save', name: `${state.name}.${kind}` })).bytes;
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([bytes]));
  link.download = `${state.name}.${kind}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

addEventListener('dragover', (event) => { event.preventDefault(); $('drop').classList.add('over'); });
addEventListener('dragleave', () => $('drop').classList.remove('over'));
addEventListener('drop', (event) => {
  event.preventDefault();
  $('drop').classList.remove('over');
  const reading = readDropped(event.dataTransfer); // now: afterwards the browser forgets what was dropped
  reading.catch(() => {});
  take(() => reading);
});
$('folder').onclick = () => $('folder-input').click();
$('zip').onclick = () => $('zip-input').click();
$('folder-input').onchange = ({ target }) => {
  const files = [...target.files].map((file) => ({ path: file.webkitRelativePath || file.name, file }));
  target.value = '';
  take(() => readFiles(files));
};
$('zip-input').onchange = ({ target }) => {
  const [file] = target.files;
  target.value = '';
  if (file) take(() => readZip(file));
};
$('photographs').onsubmit = (event) => {
  event.preventDefault();
  try {
    makeCapture(photographChoices(state.files));
  } catch (error) {
    showProblem(error);
  }
};
$('calibration').onchange = $('shown').onchange = showFields;
$('draw').onclick = showPatterns;
$('open-studio').onclick = openStudio;
$('checks').onclick = () => $('checks-dialog').showModal();
$('cancel').onclick = () => engine.stop();
$('force').onclick = () => reconstruct(true);
$('again').onclick = () => {
  $('viewer').removeAttribute('srcdoc');
  $('result').hidden = true;
  $('start').hidden = false;
  $('notes').textContent = '';
};
for (const button of document.querySelectorAll('[data-save]'))
  button.onclick = () => save(button.dataset.save).catch((error) => alert(error.message));
