'use strict';
// The page and what it stands on (platform, of studio_server.js or studio_page.js): requests, the state that comes back, messages.

const $ = (id) => document.getElementById(id);
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

let toastTimer = 0;
function say(text) {
  $('toast').textContent = text;
  $('toast').classList.add('shown');
  clearTimeout(toastTimer);
  toastTimer = setTimeout(() => $('toast').classList.remove('shown'), 7000);
}

// The last state; everything on the page follows from it.
const studio = {state: null, gone: false, listeners: []};

function accept(state) {
  const {state: now} = studio;
  if (state.version === undefined || (now && state.run === now.run && state.version < now.version)) return now; // nothing new, or overtaken on the way
  studio.state = state;
  for (const listener of studio.listeners) listener(state);
  return state;
}

// A request that changes something; throws what the server says against it.
async function ask(path, body) {
  const state = await platform.post(path, body);
  accept(state);
  if (state.error) throw new Error(state.error);
  return state;
}
const doIt = (request) => ask('do', JSON.stringify(request));

// The same for buttons: what is wrong is shown.
async function attempt(work) {
  try { return await work(); } catch (error) { say(error.message); return null; }
}

// A banner that stays, with the way back.
function tellGone(gone) {
  if (studio.gone && !gone) say('The studio is back.');
  studio.gone = gone;
  $('gone').hidden = !gone;
  const {folder, program} = studio.state || {}, quoted = (text) => `'${text.replace(/'/g, "'\\''")}'`;
  $('again').textContent = folder ? `${program ? quoted(program) : 'ffprocams'} studio ${quoted(folder)}` : '';
  document.body.classList.toggle('gone', gone);
}

async function refresh() {
  const known = studio.state ? studio.state.version : 0;
  try {
    accept(await platform.state(known));
    tellGone(false);
  } catch (error) {
    if (platform.served) tellGone(true);
    else say(error.message);
  }
}

async function follow() {
  for (;;) {
    await refresh();
    const busy = studio.state && (studio.state.job.end === 'running' || studio.state.active);
    await sleep(document.hidden ? 2000 : busy ? 200 : 600);
  }
}

// "" where there is no such file.
const textOf = (path) => platform.blob(path).then((blob) => blob.text(), () => '');
const imageOf = async (path) => createImageBitmap(await platform.blob(path));

function element(name, attributes, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes || {}))
    if (key in made) made[key] = value; else made.setAttribute(key, value);
  made.append(...children);
  return made;
}
