'use strict';
// The page and its server: requests, the state that comes back, messages.

const $ = (id) => document.getElementById(id);
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

let toastTimer = 0;
function say(text) {
  $('toast').textContent = text;
  $('toast').classList.add('shown');
  clearTimeout(toastTimer);
  toastTimer = setTimeout(() => $('toast').classList.remove('shown'), 7000);
}

// The server's last answer; everything on the page follows from it.
const studio = {state: null, gone: false, listeners: []};

function accept(state) {
  if (state.version === undefined) return studio.state; // nothing new
  studio.state = state;
  for (const listener of studio.listeners) listener(state);
  return state;
}

// A request that changes something; throws what the server says against it.
async function ask(path, body) {
  let answer;
  try {
    answer = await fetch(path, {method: 'POST', body});
  } catch {
    throw new Error('The studio does not answer: it has ended. Start it again with the same folder; nothing is lost.');
  }
  if (!answer.headers.get('Content-Type').startsWith('application/json')) throw new Error(await answer.text());
  const state = await answer.json();
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
  const folder = studio.state ? studio.state.folder : '';
  $('again').textContent = folder ? `ffprocams studio '${folder.replace(/'/g, "'\\''")}'` : '';
  document.body.classList.toggle('gone', gone);
}

async function refresh() {
  const known = studio.state ? studio.state.version : 0;
  try {
    const answer = await fetch('state?known=' + known);
    if (!answer.ok) throw new Error(await answer.text());
    accept(await answer.json());
    tellGone(false);
  } catch {
    tellGone(true);
  }
}

async function follow() {
  for (;;) {
    await refresh();
    const busy = studio.state && (studio.state.job.end === 'running' || studio.state.active);
    await sleep(document.hidden ? 2000 : busy ? 200 : 600);
  }
}

async function textOf(path) {
  const answer = await fetch('file/' + path);
  return answer.ok ? answer.text() : '';
}

function element(name, attributes, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes || {}))
    if (key in made) made[key] = value; else made.setAttribute(key, value);
  made.append(...children);
  return made;
}
