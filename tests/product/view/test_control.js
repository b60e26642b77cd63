'use strict';
// Control from outside: which addresses there are, what their values become, MIDI messages. Run by node.
const assert = require('assert'), fs = require('fs'), path = require('path'), vm = require('vm');

const line = {}, sandbox = {attempt: (work) => work, $: () => line};
vm.createContext(sandbox);
vm.runInContext(fs.readFileSync(path.join(__dirname, '../../../view/control.js'), 'utf8') +
                '\nglobalThis.api = {understand, matchesPattern, CONTROLS, DOES, controlAt, readControl, readMidi, valuesOfMidi, checkBindings, applyEvents, followStudio, Midi, BINDINGS_MAX};', sandbox);
const {understand, matchesPattern, CONTROLS, DOES, controlAt, readControl, readMidi, valuesOfMidi, checkBindings, applyEvents, followStudio, Midi, BINDINGS_MAX} = sandbox.api;
const plain = (value) => JSON.parse(JSON.stringify(value === undefined ? null : value)); // objects of this realm
const same = (a, b) => assert.deepStrictEqual(plain(a), b);

// Every control does something, and nothing else does.
same(Object.keys(CONTROLS).sort(), Object.keys(DOES).sort());

same(controlAt('/projector/2/layer/13/opacity'), {path: '/projector/#/layer/#/opacity', numbers: [1, 12], kind: [0, 1]});
for (const wrong of ['', '/', 'go', '/go/', '/go/1', '/cue/0', '/cue/01', '/cue/-1', '/cue/1.5', '/cue/99999', '/projector/#/on', '/projector/1/layer/x/opacity',
  '/constructor', '/__proto__', '/toString', null, undefined, {}]) same(controlAt(wrong), null);

// Presses act once, not on release; switches know both states or turn; ranges are held.
same(readControl('/go', []), {path: '/go', numbers: [], value: true});
same(readControl('/go', [1]).value, true);
same(readControl('/go', [0]), null);
same(readControl('/go', [false]), null);
same(readControl('/cue/3', [1]), {path: '/cue/#', numbers: [2], value: true});
same(readControl('/cue', ['Act 1']).value, 'Act 1');
same(readControl('/cue', [2]).value, 2);
for (const wrong of [[], [1.5], [true], [null]]) same(readControl('/cue', wrong), null);
same([[], [1], [0], [true], [false]].map((values) => readControl('/blackout', values).value), [null, true, false, true, false]);
same([[0.25], [7], [-7]].map((values) => readControl('/projector/1/layer/1/opacity', values).value), [0.25, 1, 0]);
for (const wrong of [[], ['loud'], [''], [NaN], [Infinity], [null], [true], [[0.5]]]) same(readControl('/projector/1/layer/1/opacity', wrong), null);
same(readControl('/projector/1/layer/1/opacity', ['0.5']).value, 0.5);

// Each kind beside whatever arrives: none, true, false, 0, 1, 0.5, texts, and null for values that no control has a meaning for.
const arrives = [[], [true], [false], [0], [1], [0.5], ['on'], ['0'], ['off'], ['Act 1'], ['2'], [null]], no = '-';
const row = (address) => arrives.map((values) => { const {why, value} = understand(address, values); return why ? no : value; });
same(row('/go'), [true, true, null, null, true, true, true, null, null, true, true, no]);
same(row('/blackout'), ['turn', true, false, false, true, true, true, false, false, no, no, no]);
same(row('/level'), [no, no, no, 0, 1, 0.5, no, 0, no, no, 1, no]);
same(row('/cue'), [no, no, no, 0, 1, no, 'on', '0', 'off', 'Act 1', '2', no]);
same(understand('/gone', []).why, 'there is no such control');
same(understand('/level', [null]).why, 'it cannot be null');

// Patterns of addresses.
const matches = (pattern, ...addresses) => addresses.map((address) => matchesPattern(pattern, address));
same(matches('/projector/*/on', '/projector/1/on', '/projector/12/on', '/projector/1/layer/1/on', '/go'), [true, true, false, false]);
same(matches('/projector/[1-3]/{on,gain}', '/projector/2/on', '/projector/4/on', '/projector/3/gain', '/projector/3/brightness'), [true, false, true, false]);
same(matches('/projector/[!1]/o?', '/projector/1/on', '/projector/2/on', '/projector//on'), [false, true, false]);
same(matches(`/${'{,,,,}'.repeat(19)}x`, '/go'), [false]); // and at once
same(matches(`/${'*?'.repeat(59)}`, '/projector/1/layer/1/opacity'), [false]);
for (const broken of ['/projector/[3-1]/on', '/projector/[/on', '/{go', '/(go)', '/g+o', '/[]', '/****************************x']) same(matches(broken, '/go', '/projector/1/on'), [false, false]);

same([['/level', 7], ['/projector/1/layer/2/speed', -9], ['/projector/1/layer/2/size', 0.5]].map(([address, value]) => readControl(address, [value]).value), [1, -2, 0.5]);
for (const [address, value] of [['/level', 'loud'], ['/projector/1/layer/2/speed', NaN], ['/projector/1/layer/2/size', null]]) same(readControl(address, [value]), null);

// MIDI 1.0, table of channel messages.
same(readMidi([0x90, 60, 127]), {key: 'note 1 60', share: 1, before: 0, alone: true});
same(readMidi([0x9f, 60, 0]), {key: 'note 16 60', share: 0, before: 0, alone: false});
same(readMidi([0x82, 60, 64]), {key: 'note 3 60', share: 0, before: 0, alone: false});
same(readMidi([0xb0, 7, 127]), {key: 'control 1 7', share: 1, before: 0, alone: true});
same(readMidi([0xc1, 5]), {key: 'program 2 5', share: 1, before: 0, alone: true});
same(readMidi([0xe0, 127, 127]), {key: 'bend 1', share: 1, before: 0, alone: true});
for (const other of [[0xf8], [0xf0, 1, 2], [0xa0, 60, 1], [0x30, 1, 1]]) same(readMidi(other), null);

const fader = (share) => ({key: 'control 1 7', share}), pad = (share) => ({key: 'note 1 36', share});
same(valuesOfMidi('/projector/1/layer/1/turn', fader(0.75)), [90]);
same(valuesOfMidi('/blackout', fader(0.2)), [false]);
same([pad(0.3), pad(0)].map((heard) => valuesOfMidi('/blackout', heard)), [[], null]);
same([pad(0.3), pad(0)].map((heard) => readControl('/go', valuesOfMidi('/go', heard))), [{path: '/go', numbers: [], value: true}, null]);
same(valuesOfMidi('/nothing', pad(1)), null);
// A pedal that goes down and up again is one GO.
const pressed = [0, 30, 66, 90, 127, 100, 70, 40, 0, 80].map((value) => valuesOfMidi('/go', readMidi([0xb0, 64, value]))[0]);
same(pressed, [false, false, true, false, false, false, false, false, false, true]);
// So is a wheel that is pushed, which rests in the middle; and a button that does not tell of its release, each time.
const pushed = (...bytes) => bytes.map((value) => valuesOfMidi('/go', readMidi([0xe3, value & 127, value >> 7]))[0]);
same(pushed(8192, 16383, 8192, 0, 8192, 14000, 8192), [false, true, false, false, false, true, false]);
same([127, 127, 127].map((value) => valuesOfMidi('/go', readMidi([0xb4, 20, value]))[0]), [true, true, true]);
// Not a fader that stays at its top, as those of 14 bits do, nor one that stood high before the page listened.
same([90, 127, 127, 127].map((value) => valuesOfMidi('/go', readMidi([0xb4, 21, value]))[0]), [false, false, false, false]);
same([102, 103, 20, 103].map((value) => valuesOfMidi('/go', readMidi([0xb4, 22, value]))[0]), [false, false, false, true]);

// From a stage that somebody else wrote.
same(checkBindings({'note 1 60': '/go', 'bend 2': '/fade', 'note 1 60; x': '/go', 'control 1 7': '/nothing', 'program 1 2': null}), {'note 1 60': '/go', 'bend 2': '/fade'});
for (const wrong of [null, undefined, 3, 'note', []]) same(checkBindings(wrong), {});
same(Object.keys(checkBindings(Object.fromEntries(Array.from({length: 999}, (_, i) => [`note 1 ${i}`, '/go'])))).length, BINDINGS_MAX);

// Messages act in the order in which they came: a bundle's wait for each other, later ones for the bundle, in a later answer too.
const order = [], act = (address) => {
  const end = () => order.push(address);
  return address.startsWith('slow') ? new Promise((done) => setTimeout(() => { end(); done(); }, 50)) : end();
};
applyEvents([{address: 'slow alone'}, {address: 'first'}, {address: 'at once', bundle: 3}], act);
same(order, ['first', 'at once']); // nothing waits for a single one, and a bundle begins when it comes
applyEvents([{address: 'slow', bundle: 4}, {address: 'then', bundle: 4}, {address: 'alone'}, {address: 'other', bundle: 9}], act);
applyEvents([{address: 'later'}, {address: '/blackout'}], act);
same(order, ['first', 'at once', '/blackout']);
let midiTried = false;
// A page that comes back hears its controls; MIDI that is refused is reported once, and nobody is asked without need.
(async () => {
  const input = {}, heard = [];
  let asked = 0;
  Object.assign(sandbox, {say: (text) => heard.push(text), Message: Error, navigator: {requestMIDIAccess: async () => { asked++; return {inputs: new Map([['pedal', input]])}; }}});
  const midi = new Midi({changed() {}});
  await midi.wake();
  same([asked, heard], [0, []]);
  midi.bindings = {'note 1 60': '/go'};
  await midi.wake(), await midi.wake();
  same([asked, typeof input.onmidimessage, heard], [1, 'function', []]);
  const both = Object.assign(new Midi({changed() {}}), {bindings: {'note 1 60': '/go'}});
  await Promise.all([both.wake(), both.learn('/go')]);
  same(asked, 2); // one more, not two
  heard.length = 0, sandbox.navigator = {};
  const none = Object.assign(new Midi({changed() {}}), {bindings: {'note 1 60': '/go'}});
  await none.wake(), await none.wake();
  assert.ok(heard.length === 1 && /^MIDI controls do nothing yet: This browser has no MIDI\..* Learn tries again\.$/.test(heard[0]), heard.join());
  midiTried = true;
})();

// A studio that has ended is told: no GO comes from it any more.
const answers = [{osc: '127.0.0.1:9000', number: 0, events: [], passed_over: 0}];
Object.assign(sandbox, {location: {pathname: `/${'0'.repeat(32)}/file/page.html`, protocol: 'http:'}, performance, setTimeout: (work) => work(),
  fetch: async () => ({json: async () => { if (!answers.length) throw new Error(); return answers.shift(); }})});
followStudio({}).then(() => same(line.textContent, 'OSC: no more, the studio does not answer'));

setTimeout(() => {
  same(order, ['first', 'at once', '/blackout', 'slow alone', 'slow', 'then', 'alone', 'other', 'later']);
  applyEvents([{address: 'after all'}], act);
  same(order.at(-1), 'after all'); // at once again
  same(midiTried, true);
  console.log('control: all passed');
}, 200);
