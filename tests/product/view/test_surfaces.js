'use strict';
// Regions that grow from points, and effects' values, without a page. Run by node.
const assert = require('assert'), fs = require('fs'), path = require('path'), {runInThisContext} = require('vm');

const said = [];
Object.assign(globalThis, {say: (text) => said.push(text), Message: Error});
for (const name of ['math', 'surfaces', 'effects', 'choosing'])
  runInThisContext(fs.readFileSync(path.join(__dirname, `../../../view/${name}.js`), 'utf8'), {filename: `${name}.js`});
const {project, pointAt, add3, placeAt, poseOf, lookAt, partAt, growPart, growSurface, withPoints, pixelOf, boxOf, rimOf, softMask, countOf, isSolid, EffectContent, EFFECTS, POINTS_MAX, TOLERANCE, Choosing} =
  runInThisContext('({project, pointAt, add3, placeAt, poseOf, lookAt, partAt, growPart, growSurface, withPoints, pixelOf, boxOf, rimOf, softMask, countOf, isSolid, EffectContent, EFFECTS, POINTS_MAX, TOLERANCE, Choosing})');

// --- A house in front of a device: a wall left of x = 0, one that turns away by 60 degrees right of it, both 2 high, and a chimney
// half a unit before the left one. ---
const turn = Math.PI / 3, [width, height] = [320, 240];
const wall = (x, z, normal, low, high, top, grey) => ({through: [x, 0, z], normal, low, high, top, grey});
const walls = [wall(0, 4, [0, 0, -1], -1.2, 0, 1, 0.6), wall(0, 4, [Math.sin(turn), 0, -Math.cos(turn)], 0, 1, 1, 0.6), wall(0, 3.5, [0, 0, -1], -0.85, -0.55, 0.6, 0.6)];
const device = (pose) => ({width, height, fx: 300, fy: 300, cx: width / 2, cy: height / 2, pose});

// A device's picture: rays through its pixels; `albedo(point)` paints the walls, `gone(point)` leaves holes.
function fieldOf(device, {albedo = () => 0, gone = () => false} = {}) {
  const field = {width: device.width, height: device.height, device, centre: [0, 0, 4], radius: 1};
  for (const name of ['place', 'normal', 'albedo']) field[name] = new Float32Array(4 * device.width * device.height);
  for (let i = 0; i < device.width * device.height; i++) {
    const x = i % device.width + 0.5, y = Math.floor(i / device.width) + 0.5, from = pointAt(device, x, y, 0), to = pointAt(device, x, y, 1), ray = to.map((v, k) => v - from[k]);
    let nearest = Infinity;
    for (const {through, normal, low, high, top, grey} of walls) {
      const t = normal.reduce((sum, n, k) => sum + n * (through[k] - from[k]), 0) / normal.reduce((sum, n, k) => sum + n * ray[k], 0), point = ray.map((v, k) => from[k] + t * v);
      if (!(t > 0 && t < nearest && point[0] >= low && point[0] <= high && Math.abs(point[1]) <= top) || gone(point)) continue;
      nearest = t;
      field.place.set([...point.map((v, k) => v - field.centre[k]), 1], 4 * i);
      field.normal.set([...normal, t / device.fx], 4 * i);
      field.albedo.set(Array(3).fill(grey + albedo(point)), 4 * i);
    }
  }
  return field;
}
const share = (field, inside, within) => { // of the pixels that should belong to a region, and of those that should not
  const counts = [0, 0, 0, 0];
  inside.forEach((one, i) => {
    if (!isSolid(field, i)) return assert.ok(!one, 'nothing beyond the object');
    const wanted = within([0, 1, 2].map((k) => field.place[4 * i + k] + field.centre[k])) ? 0 : 2;
    counts[wanted] += one, counts[wanted + 1]++;
  });
  return [counts[0] / counts[1], counts[2] / counts[3]];
};
const takes = (what, field, surface, within) => {
  const [inner, outer] = share(field, growSurface(field, surface), within);
  assert.ok(inner > 0.9 && outer < 0.03, `${what}: ${inner.toFixed(3)} of it, ${outer.toFixed(3)} of the rest`);
};
const isLeft = ([x, , z]) => x < 0 && z > 3.8, isRight = ([x]) => x > 0, isChimney = ([x, , z]) => x < 0 && z < 3.8;

const front = device(poseOf([[1, 0, 0], [0, 1, 0], [0, 0, 1]], [0, 0, 0])), seen = fieldOf(front);
const on = (point, field = seen, tolerance = TOLERANCE, take = false) => withPoints(field, partAt(field, point, tolerance, take));
const left = on([-0.3, 0.2, 4]), right = on([0.3, 0, 4 + 0.3 * Math.tan(turn)]), chimney = on([-0.7, 0, 3.5]);

// A crease ends a region, and so does a jump in depth; parts are added and taken away in their order.
takes('the left wall', seen, {parts: [left]}, isLeft);
takes('the right wall', seen, {parts: [right]}, isRight);
takes('the chimney', seen, {parts: [chimney]}, isChimney);
takes('two walls', seen, {parts: [left, right]}, (at) => isLeft(at) || isRight(at));
takes('one of them taken away', seen, {parts: [left, right, {...left, take: true}]}, isRight);
takes('and added again', seen, {parts: [left, {...left, take: true}, left]}, isLeft);
takes('everything that is connected', seen, {parts: [{...left, tolerance: 1}]}, (at) => isLeft(at) || isRight(at));
assert.strictEqual(partAt(seen, [-0.3, 0.2, 5], TOLERANCE), null); // no surface there
assert.strictEqual(partAt(seen, [9, 0, 4], TOLERANCE), null); // nor in its picture

// Colours end a region too, unless the tolerance is large; small holes and specks do not stay; a narrow bridge does not lead on.
const isPainted = ([x, y]) => x > -0.45 && x < -0.1 && y > -0.3 && y < 0.5, painted = fieldOf(front, {albedo: (at) => isPainted(at) ? 0.2 : 0});
takes('a painted door', painted, {parts: [on([-0.3, 0.2, 4], painted)]}, (at) => isPainted(at) && isLeft(at));
takes('the wall with it', painted, {parts: [on([-0.3, 0.2, 4], painted, 0.5)]}, isLeft);
const spotted = fieldOf(front, {albedo: ([x, y]) => Math.hypot(x + 0.3, y + 0.5) < 0.075 ? 0.4 : 0});
takes('a wall with a stain', spotted, {parts: [on([-0.3, 0.2, 4], spotted)]}, isLeft);
const isBridge = ([x, y]) => Math.abs(y - 0.3) > 0.05 && Math.abs(x + 0.28) < 0.1, bridged = fieldOf(front, {albedo: (at) => isBridge(at) ? 0.4 : 0});
takes('no farther than a narrow bridge', bridged, {parts: [on([-0.1, 0.3, 4], bridged)]}, (at) => isLeft(at) && at[0] > -0.18);
// A click on a narrow place keeps it, though the points put around it lie in wide ones.
const onBridge = on([-0.28, 0.3, 4], bridged);
assert.ok(onBridge.points.length > 3 && growPart(bridged, onBridge)[pixelOf(bridged, onBridge.points[0])], 'what was clicked');

// A click that gives a handful of pixels says so, and how there are more.
const knobbed = fieldOf(front, {albedo: ([x, y]) => Math.hypot(x + 0.3, y - 0.2) < 0.06 ? 0.4 : 0}), regionIn = (surface) => ({field: knobbed, inside: growSurface(knobbed, surface)});
const relief = {surfaces: [], field: () => knobbed, region: regionIn, find: (id) => relief.surfaces.find((surface) => surface.id === id)};
const choosing = new Choosing({relief, flat: {device: front}, projectors: [], invalidate() {}, changed() {}, redrawOverlay() {}});
choosing.choose([-0.3, 0.2, 4], {}), choosing.choose([-0.6, 0.8, 4], {});
const knob = countOf(regionIn(relief.surfaces[0]).inside);
assert.ok(knob > 5 && knob < 100 && said[0] === `Surface 1 is tiny, ${knob} pixels: a higher Tolerance makes it larger.`, said[0]);
assert.ok(said.length === 2 && said[1].startsWith('Shift-click adds'), said[1]);
choosing.select(1), choosing.setTolerance(0.9);
assert.ok(countOf(regionIn(relief.surfaces[0]).inside) > 20 * knob);

// A place that noisy depths cut off grows from those around it; a speck alone becomes no surface.
const raised = (pixels) => {
  const field = fieldOf(front), i = pixelOf(field, [-0.3, 0.2, 4]), point = add3(field.centre, placeAt(field, i)).map((x) => x * (1 - pixels / front.fx));
  field.place.set(point.map((x, k) => x - field.centre[k]), 4 * i);
  return [field, point];
};
const [noisy, cut] = raised(10), [specked, speck] = raised(100), many = relief.surfaces.length;
takes('a wall from a place that is cut off', noisy, {parts: [on(cut, noisy)]}, isLeft);
relief.field = () => specked, relief.region = () => ({inside: []});
for (const how of [{}, {shiftKey: true}]) assert.throws(() => choosing.choose(speck, how), /click beside it/);
assert.ok(relief.surfaces.length === many && relief.surfaces[0].parts.length === 1);

// Another device finds the same surface, though it does not see the point that was clicked; one behind it finds nothing.
assert.ok(left.points.length > 3 && left.points.length <= POINTS_MAX);
const aside = fieldOf(device(lookAt([-2, -1, 1], [0, 0, 4], [0, -1, 0])), {gone: ([x, y, z]) => z > 3.9 && Math.hypot(x + 0.3, y - 0.2) < 0.15});
assert.strictEqual(pixelOf(aside, left.points[0]), -1);
takes('the left wall from aside', aside, {parts: [left]}, isLeft);
assert.strictEqual(countOf(growPart(fieldOf(device(lookAt([0, 0, -3], [0, 0, -9], [0, -1, 0]))), left)), 0);
for (const point of right.points) assert.ok(pixelOf(seen, point) >= 0 && project(front, point)[2] > 0);

// Its box, its rim and its soft edge.
const inside = growSurface(seen, {parts: [right]}), [l, t, r, b] = boxOf(seen, inside), at = (x, z) => (width / 2 + 300 * x / z) / width;
assert.ok(Math.abs(l - 0.5) < 0.02 && Math.abs(r - at(1, 4 + Math.tan(turn))) < 0.02 && t > 0.1 && b < 0.9 && Math.abs(t + b - 1) < 0.02, `${[l, t, r, b]}`);
assert.strictEqual(boxOf(seen, new Uint8Array(width * height)), null);
for (const [i, j] of rimOf(seen, inside)) assert.ok(inside[i] && (j < 0 || !inside[j]));
const mask = softMask(seen, inside), row = Array.from(mask.subarray(width * height / 2, width * (height / 2 + 1)));
assert.ok(row.some((x) => x > 0 && x < 1) && Math.max(...row) === 1 && row[0] === 0 && row[Math.floor(0.52 * width)] === 1);
assert.ok(row.slice(width / 2 - 6, width / 2 + 6).every((x, k, all) => !k || x >= all[k - 1]), `${row.slice(width / 2 - 6, width / 2 + 6)}`);

// --- Effects: what a stage says of them is held; the time alone says where they are, and they go on from there when turned. ---
const values = (given) => new EffectContent('scan', '#ffffff', given).values;
assert.deepStrictEqual(values({speed: 99, size: -1, phase: 'x'}), {speed: 2, size: 0, phase: 0});
assert.deepStrictEqual(values({speed: NaN, size: null, phase: Infinity}), values({}));
assert.strictEqual(new EffectContent('pulse', '#ffffff').values.speed, 0);
for (const effect of Object.keys(EFFECTS)) {
  const content = new EffectContent(effect, '#ff0000', {speed: 0.5, size: 0.2}), again = new EffectContent(effect, content.colour, content.description);
  assert.deepStrictEqual(again.description, content.description);
  const turned = content.with({speed: -0.25}, 7.3), wrap = (x) => Math.abs(x - Math.round(x));
  assert.ok(wrap(turned.phaseAt(7.3) - content.phaseAt(7.3)) < 1e-3, effect);
  if (effect !== 'pulse') assert.ok(wrap(content.phaseAt(3) - 1.5) < 1e-9 && wrap(turned.phaseAt(8.3) - turned.phaseAt(7.3) + 0.25) < 1e-9, effect);
  assert.strictEqual(new EffectContent(effect, '#ff0000', {speed: 0}).live, effect === 'pulse');
}
