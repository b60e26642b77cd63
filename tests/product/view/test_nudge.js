'use strict';
// Pulls at points of an object find a projector's pose. Run by node.
const assert = require('assert'), fs = require('fs'), path = require('path'), {runInThisContext} = require('vm');
for (const name of ['math', 'nudge']) runInThisContext(fs.readFileSync(path.join(__dirname, `../../../view/${name}.js`), 'utf8'), {filename: `${name}.js`});
const {poseOfPulls, movedPose, missOf, solveLinear, project, lookAt, length3} = runInThisContext('({poseOfPulls, movedPose, missOf, solveLinear, project, lookAt, length3})');

assert.deepStrictEqual(solveLinear([[0, 2], [4, 1]], [6, 11]).map((x) => Math.round(x * 1e9) / 1e9), [2, 3]);

let seed = 7; // a generator of its own: the same numbers everywhere
const random = () => { seed = (seed * 48271) % 2147483647; return 2 * seed / 2147483647 - 1; };
const device = {width: 1920, height: 1080, fx: 2000, fy: 2000, cx: 960, cy: 540, pose: lookAt([0.4, -1, 3.2], [0, 0, 0], [0, 0, 1])}, distance = length3([0.4, -1, 3.2]);
const points = () => Array.from({length: 200}, () => [random(), random(), random() * 0.6]);
const apart = (a, b) => { const all = points(); return all.reduce((sum, p) => { const u = project({...device, pose: a}, p), v = project({...device, pose: b}, p); return sum + Math.hypot(u[0] - v[0], u[1] - v[1]); }, 0) / all.length; };

const rest = {1: [], 2: [], 3: [], 6: []};
for (let trial = 0; trial < 40; trial++) { // up to three degrees and two hundredths of the distance
  const truth = movedPose(device.pose, [0.05 * random(), 0.05 * random(), 0.05 * random(), 0.02 * random(), 0.02 * random(), 0.02 * random()], distance);
  const before = apart(device.pose, truth);
  for (const count of [1, 2, 3, 6]) {
    // as in the page: the pixel is that which is believed to light another place
    const pulls = points().slice(0, count).map((point) => ({point, pixel: project({...device, pose: truth}, point).slice(0, 2)}));
    const found = poseOfPulls(device, pulls, distance);
    assert.ok(missOf({...device, pose: found}, pulls) < 1, `${count} pulls`);
    rest[count].push(apart(found, truth) / before);
  }
}
const median = (list) => list.sort((a, b) => a - b)[list.length >> 1];
const [one, two, three, six] = [1, 2, 3, 6].map((count) => median(rest[count]));
console.log(`left of the error, medians: one pull ${one.toFixed(3)}, two ${two.toFixed(3)}, three ${three.toFixed(4)}, six ${six.toFixed(5)}`);
assert.ok(one < 0.7 && two < 0.35 && three < 0.02 && six < 0.002);
assert.strictEqual(poseOfPulls(device, [{point: [0.8, -2, 6.4], pixel: [0, 0]}], distance), null); // behind it
