'use strict';
// The words of a look at the show. Run by node.
const assert = require('assert'), fs = require('fs'), path = require('path'), {runInThisContext} = require('vm');
for (const name of ['math', 'studio_watch']) runInThisContext(fs.readFileSync(path.join(__dirname, `../../../view/${name}.js`), 'utf8'), {filename: `${name}.js`});
const {shiftBetween, degreesBetween, watchVerdict, beginAgain, project} = runInThisContext('({shiftBetween, degreesBetween, watchVerdict, beginAgain, project})');

const pose = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], device = {width: 400, height: 300, fx: 500, fy: 500, cx: 200, cy: 150, pose};
const aside = [...pose];
aside[3] = 0.02;
assert.ok(Math.abs(shiftBetween(project, device, pose, aside, [[0, 0, 5], [0.3, 0.2, 5]]) - 2) < 1e-9); // 500 * 0.02 / 5
const a = 3 * Math.PI / 180, turned = [Math.cos(a), 0, Math.sin(a), 0, 0, 1, 0, 0, -Math.sin(a), 0, Math.cos(a), 0, 0, 0, 0, 1];
assert.ok(Math.abs(degreesBetween(pose, turned) - 3) < 1e-6 && degreesBetween(pose, pose) === 0);

const look = (camera, projector, difference) => ({camera: {degrees: 1, pixels: camera, width: 400}, projector: {degrees: 2, pixels: projector, width: 1000}, difference});
assert.deepStrictEqual(watchVerdict(look(0.5, 1.4, 0.002), 0.002), {moved: false, found: true, text: 'Nothing has moved.'});
assert.match(watchVerdict(look(0.5, 17.25, 0.002), 0.002).text, /^The projector has moved .*projector by 2\.00°, 17\.3 pixels/);
assert.match(watchVerdict(look(3, 0, 0.002), 0.002).text, /^The camera has moved/);
assert.match(watchVerdict(look(3, 9, 0.002), null).text, /^The object, or camera and projector, have moved/);
const lost = watchVerdict(look(0, 0, 0.0041), 0.002);
assert.ok(lost.moved && !lost.found && /could not be found again/.test(lost.text));

const watching = {view: null, poses: null, pixels: null, least: null}, stops = [{}, {}], red = Uint32Array.of(1, 2), blue = Uint32Array.of(1, 3);
const begun = (view, pixels) => {
  beginAgain(watching, view, pixels);
  const kept = [watching.poses, watching.least];
  watching.poses = 'poses', watching.least = 0.002;
  return kept;
};
assert.deepStrictEqual([begun(stops[0], red), begun(stops[0], red.slice()), begun(stops[0], blue), begun(stops[1], blue), begun(stops[1], blue)],
  [[null, null], ['poses', 0.002], ['poses', null], [null, null], ['poses', 0.002]]);
console.log('watch: all passed');
