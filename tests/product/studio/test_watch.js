'use strict';
// The words of a look at the show. Run by node.
const assert = require('assert'), fs = require('fs'), path = require('path'), {runInThisContext} = require('vm');
for (const name of ['math', 'studio_watch']) runInThisContext(fs.readFileSync(path.join(__dirname, `../../../view/${name}.js`), 'utf8'), {filename: `${name}.js`});
const names = '{shiftBetween, degreesBetween, watchVerdict, beginAgain, looksAlike, sparesSearch, judge, setWatch, smallPhotograph, project, watching}';
const {shiftBetween, degreesBetween, watchVerdict, beginAgain, looksAlike, sparesSearch, judge, setWatch, smallPhotograph, project, watching: kept} = runInThisContext(`(${names})`);

const pose = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], device = {width: 400, height: 300, fx: 500, fy: 500, cx: 200, cy: 150, pose};
const aside = [...pose];
aside[3] = 0.02;
assert.ok(Math.abs(shiftBetween(project, device, pose, aside, [[0, 0, 5], [0.3, 0.2, 5]]) - 2) < 1e-9); // 500 * 0.02 / 5
const a = 3 * Math.PI / 180, turned = [Math.cos(a), 0, Math.sin(a), 0, 0, 1, 0, 0, -Math.sin(a), 0, Math.cos(a), 0, 0, 0, 0, 1];
assert.ok(Math.abs(degreesBetween(pose, turned) - 3) < 1e-6 && degreesBetween(pose, pose) === 0);

const look = (camera, projector, difference) => ({camera: {degrees: 1, pixels: camera, width: 400}, projector: {degrees: 2, pixels: projector, width: 1000}, difference, light: 0.1}), none = {least: null, share: null};
assert.deepStrictEqual(watchVerdict(look(0.5, 1.4, 0.002), {least: 0.002, share: 0.02}), {moved: false, found: true, text: 'Nothing has moved.'});
assert.match(watchVerdict(look(0.5, 17.25, 0.002), {least: 0.002, share: 0.02}).text, /^The projector has moved .*projector by 2\.00°, 17\.3 pixels/);
assert.match(watchVerdict(look(3, 0, 0.002), {least: 0.002, share: 0.02}).text, /^The camera has moved/);
assert.match(watchVerdict(look(3, 9, 0.002), none).text, /^The object, or camera and projector, have moved/);
for (const known of [{least: 0.002, share: null}, {least: null, share: 0.0117}]) { // under this picture; under others, as when it changes at every look
  const lost = watchVerdict(look(0, 0, 0.0041), known);
  assert.ok(lost.moved && !lost.found && /could not be found again/.test(lost.text));
}
assert.ok(watchVerdict(look(0, 0, 0.0041), {least: null, share: 0.0118}).found && watchVerdict(look(0, 0, 0.0041), none).found);
assert.deepStrictEqual([[{}, null, 0], [{}, 1, 1.4], [{}, 1, 1.6], [{}, 0, 0.14], [null, 1, 0]].map(([seen, apart, differs]) => looksAlike({seen, apart}, differs)),
  [false, true, false, true, false]);


// A small move may look alike: every fifth look searches all the same, and so does every one that differs.
const alike = {seen: {}, apart: 1, skipped: 0}, spared = (differs) => sparesSearch(alike, differs);
assert.deepStrictEqual([1, 1, 1, 1, 1, 1, 9, 1, 1, 1, 1, 1].map(spared), [true, true, true, true, false, true, false, true, true, true, true, false]);

// A black photograph says nothing of what is usual for its light.
assert.deepStrictEqual(watchVerdict({...look(0, 0, 0.001), light: 0}, {least: null, share: 0.01}).text, 'Nothing has moved.');
globalThis.difference = (a) => a[0];
const viewer = {scene: {centre: [0, 0, 5], radius: 1}}, there = {device, pose}, stop = {camera: {...device}, projector: {...device}};
const judged = (light) => judge({viewer, project}, stop, there, {now: {camera: pose, projector: pose}, left: 0.002}, [255 * light], null);
assert.deepStrictEqual([judged(0), kept.share, kept.least], ['Nothing has moved.', null, 0.002]);
assert.deepStrictEqual([judged(0.1), kept.share], ['Nothing has moved.', 0.02]);

// Where the light has changed for good, another start forgets what was usual before.
globalThis.$ = () => ({});
kept.seen = {}, kept.apart = 1;
setWatch(false);
assert.deepStrictEqual([kept.on, kept.least], [false, 0.002]);
setWatch(true);
assert.deepStrictEqual([kept.on, kept.least, kept.share, kept.seen, kept.apart], [true, null, null, null, null]);

const watching = {view: null, poses: null, pixels: null, least: null, share: null, seen: null, apart: null}, stops = [{}, {}], red = Uint32Array.of(1, 2), blue = Uint32Array.of(1, 3);
const begun = (view, pixels) => {
  beginAgain(watching, view, pixels);
  const kept = [watching.poses, watching.least, watching.seen, watching.apart, watching.share];
  watching.poses = 'poses', watching.least = 0.002, watching.seen = 'small', watching.apart = 0.2, watching.share = 0.01;
  return kept;
};
const nothing = [null, null, null, null, null], all = ['poses', 0.002, 'small', 0.2, 0.01];
assert.deepStrictEqual([begun(stops[0], red), begun(stops[0], red.slice()), begun(stops[0], blue), begun(stops[1], blue), begun(stops[1], blue)],
  [nothing, all, ['poses', null, null, null, 0.01], nothing, all]);

(async () => {
  // A photograph that is not there is an error that says so; its picture is let go, whatever happens to it.
  let open = 0;
  Object.assign(globalThis, {imageOf: async () => { throw new Error('now/001.png cannot be read (404).'); }, smallOf: () => 'small'});
  await assert.rejects(smallPhotograph('now/001.png'), /now\/001\.png cannot be read \(404\)/);
  globalThis.imageOf = async () => { open++; return {close: () => open--}; };
  assert.deepStrictEqual([await smallPhotograph('x'), open], ['small', 0]);
  globalThis.smallOf = () => { throw new Error('no memory'); };
  await assert.rejects(smallPhotograph('x'), /no memory/);
  assert.strictEqual(open, 0);
  console.log('watch: all passed');
})().catch((error) => { console.error(error); process.exitCode = 1; });
