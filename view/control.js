'use strict';
// Control from outside: addresses with values, as OSC messages and MIDI controls ask for them. No document, no drawing, down
// to applyControl: tests run it alone.

// '#' stands for a number from 1. The meaning of a message's first value (none: nothing, nil or an impulse was sent):
//            none     number, true, false     text
//   press    acts     acts unless 0, false    acts unless '0', 'off' and the like
//   switch   turns    on unless 0, false      'on', '1', 'off', '0' and the like
//   range    -        that number, in range   the number that it holds
//   cue      -        whole: that cue         the cue of that name
// Anything else is not understood. MIDI's values span a range; its keys act when pressed, its faders as valuesOfMidi says.
const CONTROLS = {
  '/go': 'press', '/hold': 'press', '/back': 'press', '/cue': 'cue', '/cue/#': 'press', '/fade': [0, 60], '/blackout': 'switch', '/test': 'switch', '/level': [0, 1],
  '/projector/#/on': 'switch', '/projector/#/brightness': [-4, 4], '/projector/#/gain': [-4, 4], '/projector/#/layer/#/opacity': [0, 1],
  '/projector/#/layer/#/x': [-1, 1], '/projector/#/layer/#/y': [-1, 1], '/projector/#/layer/#/scale': [0.05, 4],
  '/projector/#/layer/#/turn': [-180, 180], '/projector/#/layer/#/speed': [-2, 2], '/projector/#/layer/#/size': [0, 1], '/projector/#/layer/#/volume': [0, 1], '/projector/#/layer/#/play': 'switch',
};
const BINDINGS_MAX = 200;

// {path, numbers, kind} of an address, numbers counted from 0; null: there is no such control.
function controlAt(address) {
  const numbers = [], path = String(address).replace(/\/([1-9][0-9]{0,3})(?=\/|$)/g, (_, n) => { numbers.push(n - 1); return '/#'; });
  return Object.hasOwn(CONTROLS, path) && numbers.length === path.split('#').length - 1 ? {path, numbers, kind: CONTROLS[path]} : null;
}

const WORDS = {1: true, on: true, true: true, yes: true, 0: false, off: false, false: false, no: false, '': false};

// True, false, or null: neither.
function truth(given) {
  if (typeof given === 'boolean') return given;
  if (typeof given === 'number') return given !== 0;
  const word = String(given).trim().toLowerCase();
  return typeof given === 'string' && Object.hasOwn(WORDS, word) ? WORDS[word] : null;
}

// The meaning of a value for each kind of control; undefined: it is not understood, null: a button is released.
const MEANINGS = {
  press: (given) => {
    const is = given === undefined ? true : truth(given);
    if (is === null) return typeof given === 'string' ? true : undefined; // a name, as some desks send first
    return is || null;
  },
  switch: (given) => given === undefined ? 'turn' : truth(given) ?? undefined,
  cue: (given) => typeof given === 'string' || Number.isInteger(given) ? given : undefined,
  range: (given, [least, most]) => {
    const number = typeof given === 'string' && given.trim() ? Number(given) : given;
    return typeof number === 'number' && Number.isFinite(number) ? Math.min(Math.max(number, least), most) : undefined;
  },
};

// The request of a message: {path, numbers, value}; null: none. A switch without a value has null, and turns.
function readControl(address, values) {
  const asked = understand(address, values);
  return asked && !asked.why && asked.value !== null ? {...asked, value: asked.value === 'turn' ? null : asked.value} : null;
}

// The same with the value as MEANINGS has it, or {why} if the message is not understood.
function understand(address, values) {
  const found = controlAt(address), [given] = values || [];
  if (!found) return {why: 'there is no such control'};
  const {path, numbers, kind} = found, value = MEANINGS[Array.isArray(kind) ? 'range' : kind](given, kind);
  return value === undefined ? {why: given === undefined ? 'it lacks a value' : `it cannot be ${JSON.stringify(given)}`} : {path, numbers, value};
}

// OSC's patterns: ? * [a-c] [!a] {this,that} within a part of the address.
function isPattern(address) { return /[*?[{]/.test(address); }
// The ends of what a part of a pattern may match of an address from there on.
function patternEnds(part, address, at) {
  const next = address[at], rest = address.slice(at);
  if (part === '*') return Array.from({length: rest.split('/')[0].length + 1}, (_, i) => at + i);
  if (part[0] === '{' && part.length > 1) return part.slice(1, -1).split(',').filter((word) => rest.startsWith(word)).map((word) => at + word.length);
  if (next === undefined || (next === '/' && part !== '/')) return [];
  if (part === '?' || part === next) return [at + 1];
  if (part[0] !== '[' || part.length < 3) return [];
  const not = part[1] === '!', set = part.slice(not ? 2 : 1, -1).match(/[^]-[^]|[^]/g) || [];
  return set.some((of) => of[0] <= next && next <= of[of.length - 1]) !== not ? [at + 1] : [];
}
// Without regular expressions: a pattern comes from anybody.
function matchesPattern(pattern, address) {
  const parts = pattern.match(/\[[^\]]*\]|\{[^}]*\}|[^]/g) || [];
  let ends = new Set([0]);
  for (const part of parts) ends = new Set([...ends].flatMap((at) => patternEnds(part, address, at)));
  return ends.has(address.length);
}

const lastShares = new Map();

// A MIDI message, bytes, as {key, share, before, alone}: the control's name, its value from 0 to 1, the one before it, and
// whether it has never had another than 1; null: clocks and the like. A control that is heard for the first time stood where
// it is now, but for a button.
function readMidi(bytes, shares = lastShares) {
  const heard = shareOfMidi(bytes);
  if (!heard) return null;
  const {share} = heard, last = shares.get(heard.key) || {share: share === 1 ? 0 : share, alone: true}, alone = last.alone && share === 1;
  shares.set(heard.key, {share, alone});
  return {...heard, before: last.share, alone};
}

function shareOfMidi([status, first, second = 0]) {
  const channel = (status & 15) + 1, data = [first & 127, second & 127];
  switch (status & 0xf0) {
  case 0x80: return {key: `note ${channel} ${data[0]}`, share: 0};
  case 0x90: return {key: `note ${channel} ${data[0]}`, share: data[1] / 127};
  case 0xb0: return {key: `control ${channel} ${data[0]}`, share: data[1] / 127};
  case 0xc0: return {key: `program ${channel} ${data[0]}`, share: 1};
  case 0xe0: return {key: `bend ${channel}`, share: (data[0] + 128 * data[1]) / 16383};
  default: return null;
  }
}

// The values that a MIDI control sends to an address. Keys and pads turn a switch when they are pressed, faders set it; a
// fader or pedal presses once each time it passes the middle upwards, a wheel, which rests there, three quarters. A button
// that does not tell of its release presses each time with the same value, all of it.
function valuesOfMidi(address, {key, share, before = 0, alone = false}) {
  const found = controlAt(address), fader = /^(control|bend)/.test(key);
  if (!found) return null;
  if (Array.isArray(found.kind)) return [found.kind[0] + share * (found.kind[1] - found.kind[0])];
  if (found.kind === 'switch') return fader ? [share >= 0.5] : share > 0 ? [] : null;
  const wheel = key.startsWith('bend'), least = wheel ? 0.75 : 0.5;
  return [fader ? share >= least && (before < least || (alone && !wheel)) : share > 0];
}

function checkBindings(bindings) {
  const checked = {};
  for (const [key, address] of Object.entries(bindings || {}).slice(0, BINDINGS_MAX))
    if (/^(note|control|program) [0-9]{1,2} [0-9]{1,3}$|^bend [0-9]{1,2}$/.test(key) && controlAt(address)) checked[key] = String(address);
  return checked;
}

// --- What the controls do. ---

function turnLayer(app, [p, l], work) {
  const projector = app.projectors[p], layer = projector && projector.layers[l];
  if (!layer) return;
  work(layer);
  app.endComparison(projector);
  projector.dirty = true;
  app.invalidate(true);
  app.changed('layers');
}
const place = (change) => (app, numbers, value) => turnLayer(app, numbers, (layer) => { layer.place = {...layer.place, ...change(value)}; });
const onProjector = (change) => (app, [p], value) => {
  if (!app.projectors[p]) return;
  change(app.projectors[p], value);
  app.projectors[p].window.stale = true;
  app.invalidate();
  app.changed('projector');
};

const DOES = {
  '/go': (app) => app.show.go(), '/hold': (app) => app.show.stop(), '/back': (app) => app.show.go(Math.max(0, app.show.here - 1)),
  '/cue': (app, _, value) => app.show.go(typeof value === 'string' ? app.show.find(value) : value - 1), '/cue/#': (app, [n]) => app.show.go(n),
  '/fade': (app, _, value) => { app.show.fade = value; },
  '/blackout': (app, _, value) => blackout(app, value === null ? !app.dark : value),
  '/test': (app, _, value) => { if (value === null || value !== app.test) testPicture(app); },
  '/level': (app, _, level) => {
    const {sound} = app.relief, {told} = sound;
    sound.set(level);
    if (told !== sound.told) app.changed('layers'); // the panel's line; what pulses is drawn anyway
  },
  '/projector/#/on': onProjector((p, on) => { p.on = on === null ? !p.on : on; }),
  '/projector/#/brightness': onProjector((p, stops) => { p.stops = stops; }), '/projector/#/gain': onProjector((p, gain) => { p.gain = gain; }),
  '/projector/#/layer/#/opacity': place((opacity) => ({opacity})), '/projector/#/layer/#/x': place((x) => ({x})), '/projector/#/layer/#/y': place((y) => ({y})),
  '/projector/#/layer/#/scale': place((scale) => ({width: scale, height: scale})), '/projector/#/layer/#/turn': place((turn) => ({turn})),
  '/projector/#/layer/#/volume': (app, numbers, volume) => turnLayer(app, numbers, (layer) => { layer.film = {...layer.film, volume}; }),
  '/projector/#/layer/#/speed': (app, [p, l], speed) => turnLayer(app, [p, l], (layer) => turnEffect(app, app.projectors[p], layer, {speed})),
  '/projector/#/layer/#/size': (app, [p, l], size) => turnLayer(app, [p, l], (layer) => turnEffect(app, app.projectors[p], layer, {size})),
  '/projector/#/layer/#/play': (app, numbers, on) => turnLayer(app, numbers, ({source}) => { if (source.toggle && (on === null || on !== source.live)) source.toggle(); }),
};

// Keeps the last message from outside for the panel's line.
function noteHeard(app, from, address, why) {
  const heard = app.heard ||= {passed: 0, unread: 0};
  heard.last = `${from}${address}`;
  if (why) heard.passed++, heard.why = `${address}: ${why}`;
  heard.drawn ||= setTimeout(() => { heard.drawn = 0; drawHeard(app); }, 200); // faders send many
}

function drawHeard(app) {
  const {osc, last, passed = 0, unread = 0, why} = app.heard || {}, bad = passed + unread;
  const parts = [osc ? `OSC: ${osc}` : 'OSC: by the studio, with --osc', last && `last ${last}`, bad && `${bad} not understood (${why})`];
  $('osc').textContent = parts.filter(Boolean).join(' · ');
}

// Several changes that come at once are one step of undo.
const applyControl = attempt(async (app, address, values, from = '') => {
  if (isPattern(address)) {
    const meant = [...addressesOf(app)].filter((one) => matchesPattern(address, one));
    for (const one of meant) await applyControl(app, one, values, from);
    if (!meant.length) noteHeard(app, from, address, 'there is no such control');
    return;
  }
  const {why, path, numbers, value} = understand(address, values);
  noteHeard(app, from, address, why);
  if (why || value === null) return;
  await DOES[path](app, numbers, value === 'turn' ? null : value);
  clearTimeout(app.controlled);
  app.controlled = setTimeout(() => app.history.note(), 500);
});

let bundled = null; // a promise, until all bundles that have come are done

// Messages in the order in which they came. Those of a bundle wait for each other, and what comes later waits for the bundle;
// nothing waits for a film that a single message loads, and a blackout for nothing.
function applyEvents(events, apply) {
  for (const {address, values, bundle} of events) {
    const work = () => { const done = apply(address, values); return bundle === undefined ? undefined : done; };
    if (bundle === undefined && (!bundled || address === '/blackout')) {
      work();
      continue;
    }
    const last = bundled = bundled ? bundled.then(work) : Promise.resolve(work());
    last.then(() => { if (bundled === last) bundled = null; });
  }
}

// OSC messages, which the studio receives: asked for again as soon as an answer comes, which waits until there are some.
async function followStudio(app) {
  const studio = /^(\/[0-9a-f]{32}\/)file\//.exec(location.pathname);
  if (!studio || !/^https?:$/.test(location.protocol)) return;
  for (let known = null, failed = 0; failed < 30;) {
    const began = performance.now();
    try {
      const answer = await (await fetch(`${studio[1]}control${known === null ? '' : `?known=${known}`}`)).json();
      if (!answer.osc) return;
      const heard = app.heard ||= {passed: 0, unread: 0};
      if (heard.osc !== answer.osc || heard.unread !== answer.passed_over) {
        Object.assign(heard, {osc: answer.osc, unread: answer.passed_over}, answer.passed_over ? {why: `${answer.passed_last || 'a packet'}: it cannot be read`} : {});
        drawHeard(app);
      }
      applyEvents(answer.events, (address, values) => applyControl(app, address, values));
      known = answer.number, failed = 0;
      if (answer.events.length || performance.now() - began > 100) continue;
    } catch {
      failed++; // the studio has ended, or begins again
    }
    await new Promise((done) => setTimeout(done, failed ? 1000 : 100));
  }
  if (!app.heard) return;
  app.heard.osc = 'no more, the studio does not answer';
  drawHeard(app);
}

// --- MIDI. ---

class Midi {
  constructor(app) { this.app = app, this.bindings = {}, this.learns = null, this.access = this.opening = null; }

  // Once, whoever asks: two accesses would hear every message twice.
  open() {
    this.opening ||= this.begin().catch((error) => { this.opening = null; throw error; });
    return this.opening;
  }

  async begin() {
    if (!navigator.requestMIDIAccess) throw new Message('This browser has no MIDI. Chromium, Edge and Firefox have it.');
    this.access = await navigator.requestMIDIAccess().catch((error) => { throw new Message(`MIDI cannot be used: ${error.message || error.name}.`); });
    const listen = () => { for (const input of this.access.inputs.values()) input.onmidimessage = ({data}) => this.hear(data); };
    this.access.onstatechange = () => { listen(); this.app.changed('midi'); };
    listen();
  }

  // Controls that a stage, or the page as it was left, says the meaning of are heard without another Learn.
  async wake() {
    if (this.access || this.asked || !Object.keys(this.bindings).length) return;
    this.asked = true;
    await this.open().catch((error) => say(`MIDI controls do nothing yet: ${error.message} Learn tries again.`));
  }

  // The next control that is moved will be this address'.
  async learn(address) {
    await this.open();
    this.learns = address;
    say(this.access.inputs.size ? 'Move the control, or press the key, that is to do this.' : 'No MIDI device is connected yet: plug one in, then move its control.');
    this.app.changed('midi');
  }

  hear(data) {
    const heard = readMidi(data);
    if (!heard) return;
    if (this.learns) {
      if (!heard.share) return;
      if (Object.keys(this.bindings).length < BINDINGS_MAX) this.bindings = {...this.bindings, [heard.key]: this.learns};
      this.learns = null;
      this.app.changed('midi');
      this.app.history.note();
      return;
    }
    const address = this.bindings[heard.key], values = address && valuesOfMidi(address, heard);
    if (values) applyControl(this.app, address, values, `${heard.key} `);
  }

  forget(key) {
    const {[key]: _, ...rest} = this.bindings;
    this.bindings = rest;
    this.app.changed('midi');
  }
}

// All addresses that there are now, for the list to learn from.
function addressesOf(app) {
  const each = (path) => path === '/cue/#' ? app.show.cues.map((_, i) => `/cue/${i + 1}`)
    : app.projectors.flatMap((p, i) => path.includes('layer') ? p.layers.map((_, l) => path.replace('#', i + 1).replace('#', l + 1)) : [path.replace('#', i + 1)]);
  return Object.keys(CONTROLS).filter((path) => path !== '/cue').flatMap((path) => path.includes('#') ? each(path) : [path]);
}

function buildControl(app) {
  const {midi} = app, refresh = (what) => {
    if (what === 'drawn') return;
    const addresses = addressesOf(app), select = $('learn-address');
    if (select.dataset.shown !== addresses.join()) {
      const before = select.value;
      select.dataset.shown = addresses.join();
      select.replaceChildren(...addresses.map((address) => element('option', {value: address, textContent: address})));
      if (addresses.includes(before)) select.value = before;
    }
    $('learn').textContent = midi.learns ? 'Listening…' : 'Learn';
    if (what && what !== 'midi') return;
    midi.wake();
    $('bindings').replaceChildren(...Object.entries(midi.bindings).map(([key, address]) => {
      const remove = element('button', {textContent: '×', className: 'small', title: `Forget ${key}`, onclick: () => { midi.forget(key); app.history.note(); }});
      remove.setAttribute('aria-label', remove.title);
      return element('li', {className: 'row'}, [element('span', {textContent: `${key}: ${address}`}), element('span', {className: 'push'}), remove]);
    }));
  };
  $('learn').onclick = attempt(() => midi.learn($('learn-address').value));
  app.listeners.push(refresh);
  refresh();
  followStudio(app);
}
