'use strict';
// The words of a look at the show. Run by node.
const assert = require('assert'), fs = require('fs'), path = require('path'), {runInThisContext} = require('vm');
for (const name of ['math', 'studio_watch']) runInThisContext(fs.readFileSync(path.join(__dirname, `../../../view/${name}.js`), 'utf8'), {filename: `${name}.js`});
const {shiftBetween, degreesBetween, watchVerdict, beginAgain, looksAlike, project} = runInThisContext('({shiftBetween, degreesBetween, watchVerdict, beginAgain, looksAlike, project})');

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
console.log('watch: all passed');
