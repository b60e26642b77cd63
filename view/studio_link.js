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

// What the server said last; everything on the page follows from it.
const studio = {state: null, gone: false, listeners: []};

function accept(state) {
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

async function refresh() {
  const answer = await fetch('state');
  accept(await answer.json());
}

// Every change is told as it happens; a connection that ends is made again by the browser.
function follow() {
  const events = new EventSource('events');
  events.onmessage = ({data}) => {
    accept(JSON.parse(data));
    if (studio.gone) say('The studio is there again.');
    studio.gone = false;
  };
  events.onerror = () => {
    if (!studio.gone) say('The studio does not answer: it has ended. Start it again with the same folder; nothing is lost.');
    studio.gone = true;
  };
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
