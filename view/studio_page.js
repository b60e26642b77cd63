'use strict';
// The studio inside the page that reconstructs (engine.js), in a frame of it: the engine's worker has the rules, the folder, which it
// keeps in the browser's storage, and the commands.

const TYPES = {html: 'text/html', png: 'image/png', jpg: 'image/jpeg', svg: 'image/svg+xml', pdf: 'application/pdf', json: 'application/json', xml: 'text/xml'};
const KEPT = 'What was photographed is kept; what was being made has to be made again.';

const platform = {
  served: false,
  engine: parent.engine,
  opening: null, // the opening of the folder by the worker that there is

  // A worker that was ended, by a person or because it ran out of memory, is followed by another.
  open() {
    this.opening ||= this.begin().catch((error) => { this.opening = null; throw error; });
    return this.opening;
  },

  async begin() {
    await this.engine.start();
    accept((await this.engine.ask({kind: 'studioOpen', run: Date.now() % 2 ** 31})).state);
  },

  async post(path, body) {
    const [name, query] = path.split('?'), {set, number, watch} = Object.fromEntries(new URLSearchParams(query));
    if (this.working && name === 'do' && JSON.parse(body).verb === 'cancel') return this.stop(`Stopped. ${KEPT}`);
    await this.open();
    const bytes = new Uint8Array(await new Blob([body]).arrayBuffer());
    const {state} = await this.engine.ask({kind: 'studioPost', path: name, set, number, watch, bytes}, [bytes.buffer]);
    this.work(state);
    return state;
  },

  // Runs the jobs that a request began, after its answer, a command at a time: other requests wait for a command's end.
  async work(state) {
    const runs = ({job, camera, eye}) => [job, camera, eye].some(({end}) => end === 'running');
    if (this.working || !runs(state)) return;
    this.working = true;
    for (let now = state; this.working && now && runs(now);) {
      now = await this.engine.ask({kind: 'studioWork'}).then((answer) => answer.state, (error) => this.working && attempt(() => this.stop(`${error.message} ${KEPT}`)) && null);
      if (this.working && now) accept(now);
    }
    this.working = false;
  },

  async stop(why) {
    this.working = false;
    this.engine.stop();
    await this.open();
    if (why) say(why);
    return studio.state;
  },

  // Later ones are told as they come.
  async state(known) {
    await this.open();
    return known ? {} : (await this.engine.ask({kind: 'studioState'})).state;
  },

  async blob(path) {
    await this.open();
    const {bytes} = await this.engine.ask({kind: 'read', path: `/studio/${path}`});
    return new Blob([bytes], {type: TYPES[path.split('.').pop()] || 'application/octet-stream'});
  },

  async put(node, path) {
    if (node.tagName === 'A') {
      node.href = '#';
      node.onclick = (event) => { event.preventDefault(); attempt(() => this.follow(node, path)); };
      return;
    }
    node.dataset.path = path;
    const blob = await this.blob(path).catch(() => null);
    if (node.dataset.path !== path) return; // another has been asked for meanwhile
    if (!blob) node.dispatchEvent(new Event('error'));
    else if (node.tagName === 'IFRAME') node.srcdoc = await blob.text(); // of this page's origin
    else node.src = URL.createObjectURL(blob), node.onload = () => URL.revokeObjectURL(node.src);
  },

  async follow({download}, path) {
    const url = URL.createObjectURL(await this.blob(path)), link = element('a', {href: url, target: '_blank', rel: 'noopener'});
    if (download) link.download = download;
    link.click();
    setTimeout(() => URL.revokeObjectURL(url), 60000);
  },

  projector(number, place) {
    const name = `ffp-projector-${number}`, opened = window.open('', name, place);
    if (opened && !opened.document.querySelector('canvas')) {
      opened.document.write(parent.document.getElementById('projector.html').textContent.replaceAll('<\\/script', '</script'));
      opened.document.close();
    } else if (opened) opened.focus();
    return opened;
  },
};

// --- What the browser keeps, and its way out of it and in again. ---

// The folder as a ZIP file, which the program opens, too: unpacked, `ffprocams studio FOLDER` goes on with it.
async function saveRig() {
  await platform.open();
  const {files} = await platform.engine.ask({kind: 'studioFiles'}), kept = files.filter(({path}) => !path.startsWith('discarded/'));
  const url = URL.createObjectURL(parent.zipOf(kept));
  element('a', {href: url, download: 'rig.zip'}).click();
  setTimeout(() => URL.revokeObjectURL(url), 60000);
}

const PLAIN = /^(\w[\w.-]*\/)*\w[\w.-]*$/; // a path that the studio reads (ffp_studio_path)

// Of a folder `studio`, or of what lies in one; null: it is not one.
function rigOf(files) {
  const root = files.map(({path}) => path).filter((path) => /(^|\/)studio\.json$/.test(path)).sort((a, b) => a.length - b.length)[0];
  if (root === undefined) return null;
  const before = root.slice(0, -'studio.json'.length), settings = files.find(({path}) => path === root);
  try {
    const {camera, projector, objects} = JSON.parse(new TextDecoder().decode(settings.bytes));
    if (typeof camera !== 'string' || !Array.isArray(projector) || typeof objects !== 'object') return null;
  } catch {
    return null;
  }
  return files.filter(({path}) => path.startsWith(before)).map(({path, bytes}) => ({path: path.slice(before.length), bytes})).filter(({path}) => PLAIN.test(path));
}

async function replaceRig(files) {
  if (platform.working) throw new Error('A job is running: wait for its end, or stop it.');
  if ((!studio.state || studio.state.photographed) && !confirm('This takes the place of the rig that is here, with all its photographs. Save that first, if it is to be kept.')) return;
  try {
    await platform.engine.start();
    await platform.engine.ask({kind: 'studioReplace', files});
  } finally {
    platform.engine.stop(); // whatever is stored is opened again
  }
  const frame = parent.document.getElementById('studio');
  frame.srcdoc = frame.srcdoc.slice(); // a page that has shown nothing of the rig before
}

async function openRig(file) {
  const files = rigOf(await parent.readZip(file));
  if (!files) throw new Error(`${file.name} holds no rig: there is no studio.json in it, or none that the studio wrote.`);
  if (files.some(({path}) => /\.(html|svg)$/.test(path)) && !confirm('Pages in this ZIP file will run as part of this one. Open only what you saved yourself, or what comes from somebody whom you trust.')) return;
  await replaceRig(files);
}

// A simulated rig, whose photographs the page has (wasm/rig).
const tryRig = async () => openRig(new File([parent.payload('rig.zip')], 'rig.zip'));

async function tellKept() {
  const {usage, quota} = navigator.storage ? await navigator.storage.estimate().catch(() => ({})) : {};
  const kept = navigator.storage && await navigator.storage.persisted().catch(() => false), gigabytes = (bytes) => (bytes / 1e9).toFixed(bytes < 1e9 ? 2 : 0);
  $('kept-says').textContent = (usage === undefined ? '' : `${gigabytes(usage)} GB of ${gigabytes(quota)} that this browser gives. `)
    + (kept ? 'It stays until you remove it.' : 'A browser that runs out of room, or is told to forget this page, may delete it: save what matters.');
}

$('kept').hidden = false;
$('kept-save').addEventListener('click', () => attempt(saveRig));
$('kept-open').addEventListener('click', () => $('kept-file').click());
$('kept-file').addEventListener('change', () => attempt(async () => { 
  const [file] = $('kept-file').files;
  $('kept-file').value = '';
  if (file) await openRig(file);
}));
$('kept-try').hidden = !parent.document.getElementById('rig.zip');
$('kept-try').addEventListener('click', () => attempt(tryRig));
$('kept-new').addEventListener('click', () => attempt(() => replaceRig([])));
studio.listeners.push(({active}) => { if (!active && !$('rig').hidden) tellKept(); });

parent.engine.ended = () => { platform.opening = null; };
parent.engine.tell = ({kind, state, text}) => {
  if (kind === 'studio') accept(state);
  else if (kind === 'log' && text) console.log(text);
};

stayAwake(); // it computes here, and a laptop that sleeps computes nothing
