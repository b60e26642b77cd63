'use strict';
// Surfaces of the object: regions of what a device sees that grow from points, as long as normal and albedo stay near to those of
// the point and nothing jumps in depth. A surface is kept by its points in the world, so that other devices find it again:
// {id, name, parts: [{points, normal, albedo, tolerance, take}]}; a part with `take` is taken away from those before it.
// No document, no drawing: tests run it alone.
//
// A field is {width, height, device, centre, radius, place, normal, albedo}: four floats a pixel; place is relative to the centre,
// in radii, and its fourth value the opacity; normal's fourth is the size of a pixel there; albedo is square-rooted.

const SURFACES_MAX = 40, PARTS_MAX = 40, POINTS_MAX = 12, TOLERANCE = 0.25, SURFACE_NAME_MAX = 40;
const SOLID = 0.5, JUMP = 5, NEAR_POINT = 0.04; // opacity; pixels by which neighbours may lie apart; radii
const HOLE_SHARE = 0.01, HOLE_LEAST = 40;       // holes up to this share of a region, or pixels, belong to it
const AROUND = 3, NECK = 4;                     // pixels: around a point, whose mean it is compared by; a narrower neck does not join
const ROUNDED = [5, 3, 1], ROUND_KEEPS = 0.94;   // reach of rounding off, pixels, and the share of a region that it has to leave

// How far normals (radians) and albedos may be from a part's, from a tolerance of 0 to 1, at which all that is connected belongs to it.
const limitsOf = (tolerance) => tolerance >= 1 ? null : [(10 + 170 * tolerance ** 1.3) * Math.PI / 180, 0.05 + 1.6 * tolerance ** 2];

const isSolid = ({place}, i) => place[4 * i + 3] >= SOLID;
const placeAt = ({place}, i) => [place[4 * i], place[4 * i + 1], place[4 * i + 2]];

function isNear({normal, albedo}, i, part, limits) {
  if (!limits) return true;
  const n = part.normal, a = part.albedo, cosine = normal[4 * i] * n[0] + normal[4 * i + 1] * n[1] + normal[4 * i + 2] * n[2];
  const angle = Math.acos(Math.min(Math.max(cosine, -1), 1)) / limits[0];
  const away = Math.hypot(albedo[4 * i] - a[0], albedo[4 * i + 1] - a[1], albedo[4 * i + 2] - a[2]) / limits[1];
  return angle * angle + away * away <= 1;
}

// True if nothing jumps in depth between two neighbours.
function isJoined({place, normal}, i, j) {
  const most = JUMP * normal[4 * i + 3];
  return Math.hypot(place[4 * i] - place[4 * j], place[4 * i + 1] - place[4 * j + 1], place[4 * i + 2] - place[4 * j + 2]) <= most;
}

// The pixels around one of a field, without it.
function neighbours({width, height}, i, reach = 1) {
  const x = i % width, y = (i - x) / width, out = [];
  for (let v = Math.max(0, y - reach); v <= Math.min(height - 1, y + reach); v++)
    for (let u = Math.max(0, x - reach); u <= Math.min(width - 1, x + reach); u++) if (u !== x || v !== y) out.push(v * width + u);
  return out;
}

// The field's pixel that shows a point of the world, -1 where the device does not see it.
function pixelOf(field, point) {
  const [x, y, z] = project(field.device, point), u = Math.floor(x), v = Math.floor(y), at = scale3(sub3(point, field.centre), 1 / field.radius);
  if (!(z > 0 && u >= 0 && v >= 0 && u < field.width && v < field.height)) return -1;
  let best = -1, least = NEAR_POINT;
  for (const i of [v * field.width + u, ...neighbours(field, v * field.width + u)]) {
    const away = isSolid(field, i) ? length3(sub3(placeAt(field, i), at)) : Infinity;
    if (away < least) best = i, least = away;
  }
  return best;
}

// Pixels around one of the object that are about as deep.
const around = (field, i) => neighbours(field, i, AROUND).filter((j) => isSolid(field, j) && length3(sub3(placeAt(field, j), placeAt(field, i))) < 2 * AROUND * JUMP * field.normal[4 * i + 3]);

// A part around a point that the field shows; null: it shows none there.
function partAt(field, point, tolerance, take = false) {
  const i = pixelOf(field, point);
  if (i < 0) return null;
  const same = [i, ...around(field, i)], mean = (values) => [0, 1, 2].map((k) => same.reduce((sum, j) => sum + values[4 * j + k], 0) / same.length);
  return {points: [point], normal: normalise3(mean(field.normal)), albedo: mean(field.albedo), tolerance, take};
}

// The four neighbours of a pixel; -1 beyond the picture.
const sides = ({width, height}, i) => [i % width > 0 ? i - 1 : -1, i % width < width - 1 ? i + 1 : -1, i >= width ? i - width : -1, i < width * (height - 1) ? i + width : -1];

// All pixels that `first` ones lead to over neighbours which may `follow`, 1 each.
function flood(field, first, follow) {
  const inside = new Uint8Array(field.width * field.height), stack = first.slice();
  for (const i of first) inside[i] = 1;
  while (stack.length) {
    const i = stack.pop();
    for (const j of sides(field, i)) if (j >= 0 && !inside[j] && follow(i, j)) inside[j] = 1, stack.push(j);
  }
  return inside;
}

// A region without what hangs on it by a neck narrower than NECK pixels; as it is where the first pixel, which was clicked, lies in a narrow place.
function withoutNecks(field, inside, first) {
  const far = new Uint8Array(inside), kept = far.map((one) => one * (NECK + 1)); // steps to the end of the region, NECK + 1 at most
  let wave = [];
  far.forEach((one, i) => { if (one && sides(field, i).some((j) => j < 0 || !inside[j] || !isJoined(field, i, j))) wave.push(i), kept[i] = 1; });
  for (let step = 2; step <= NECK; step++) {
    const next = [];
    for (const i of wave) for (const j of sides(field, i)) if (j >= 0 && kept[j] > step) kept[j] = step, next.push(j);
    wave = next;
  }
  if (!(kept[first[0]] > NECK)) return inside;
  const core = first.filter((i) => kept[i] > NECK);
  const whole = flood(field, core, (_, j) => kept[j] > NECK);
  wave = [];
  whole.forEach((one, i) => { if (one) wave.push(i); });
  for (let step = 0; step < 2 * NECK; step++) { // back to where the region ends, into corners too
    const next = [];
    for (const i of wave) for (const j of sides(field, i)) if (j >= 0 && inside[j] && !whole[j] && isJoined(field, i, j)) whole[j] = 1, next.push(j);
    wave = next;
  }
  return whole;
}

// The pixels of one part, 1 each. Where depths are noisy, jumps may cut off the place that was clicked: then it grows from those around it.
function growPart(field, part) {
  const limits = limitsOf(part.tolerance), first = part.points.map((point) => pixelOf(field, point)).filter((i) => i >= 0 && (isNear(field, i, part, limits) || part.points.length === 1));
  const grow = (from) => withoutNecks(field, flood(field, from, (i, j) => isSolid(field, j) && isJoined(field, i, j) && isNear(field, j, part, limits)), from);
  const inside = grow(first);
  return countOf(inside) >= HOLE_LEAST ? inside : grow([...first, ...first.flatMap((i) => around(field, i).filter((j) => isNear(field, j, part, limits)))]);
}

const countOf = (inside) => inside.reduce((sum, one) => sum + one, 0);

// Small islands of pixels outside, wholly within the region, come to belong to it (value 0), or those of the region leave it (1).
function dropIslands(field, inside, value) {
  const most = Math.max(value ? 0 : HOLE_LEAST, HOLE_SHARE * countOf(inside)), seen = new Uint8Array(inside.length); // 2: of a large one
  for (const [i, j] of rimOf(field, inside)) {
    const first = value ? i : j, island = [first];
    if (first < 0 || seen[first]) continue;
    let large = false;
    seen[first] = 1;
    for (let k = 0; k < island.length && !large; k++) {
      for (const n of sides(field, island[k])) {
        if (n < 0) large ||= value === 0; // what goes on beyond the picture
        else if (inside[n] === value && seen[n] !== 1) large ||= seen[n] === 2, seen[n] = 1, island.push(n);
      }
      large ||= island.length > most;
    }
    for (const n of island) if (large) seen[n] = 2; else inside[n] = 1 - value;
  }
}

// Sums of 2 reach + 1 values across or down a field.
function sumAlong({width, height}, values, reach, down) {
  const out = new Float32Array(values.length), [rows, length, along, between] = down ? [width, height, width, 1] : [height, width, 1, width];
  for (let row = 0; row < rows; row++) {
    let sum = 0;
    for (let k = -reach, at = row * between - reach * along; k < length; k++, at += along) {
      if (k + reach < length) sum += values[at + reach * along];
      if (k > reach) sum -= values[at - (reach + 1) * along];
      if (k >= 0) out[at] = sum;
    }
  }
  return out;
}

// Pixels go with most of the object's around them, which rounds off what noise frays; less far where a region is narrow.
function smoothen(field, inside) {
  const before = new Float32Array(inside), least = ROUND_KEEPS * countOf(inside);
  field.spread ||= {}; // of what is solid, by reach
  for (const reach of ROUNDED) {
    const spread = (values) => [1, 2].reduce((sums) => sumAlong(field, sumAlong(field, sums, reach, false), reach, true), values), some = spread(before);
    const all = field.spread[reach] ||= spread(before.map((_, i) => isSolid(field, i) ? 1 : 0));
    for (let i = 0; i < inside.length; i++) inside[i] = 2 * some[i] > all[i] && isSolid(field, i) ? 1 : 0;
    if (countOf(inside) >= least) break;
  }
}

// The pixels of a surface, 1 each; its parts are added and taken away in their order.
function growSurface(field, {parts}) {
  const inside = new Uint8Array(field.width * field.height);
  for (const part of parts) growPart(field, part).forEach((one, i) => { if (one) inside[i] = part.take ? 0 : 1; });
  dropIslands(field, inside, 0);
  smoothen(field, inside);
  for (const value of [0, 1]) dropIslands(field, inside, value);
  return inside;
}

// A part with more points of its region, as far from each other as there are: others may not see the first.
function withPoints(field, part) {
  const inside = growPart(field, part), all = [];
  inside.forEach((one, i) => { if (one) all.push(i); });
  const step = Math.max(1, Math.floor(all.length / 500)), some = all.filter((_, k) => k % step === 0).map((i) => placeAt(field, i)), points = [...part.points];
  const away = some.map(() => Infinity), put = (at) => some.forEach((place, k) => { away[k] = Math.min(away[k], length3(sub3(place, at))); });
  put(scale3(sub3(part.points[0], field.centre), 1 / field.radius));
  while (points.length < POINTS_MAX && some.length) {
    const far = away.indexOf(Math.max(...away));
    if (away[far] < NEAR_POINT) break;
    points.push(add3(field.centre, scale3(some[far], field.radius)));
    put(some[far]);
  }
  return {...part, points: points.map((point) => point.map((x) => Math.round(1e6 * x) / 1e6))};
}

// The part of the picture in which pixels lie, shares of it: [left, top, right, bottom]; null: none.
function boxOf({width, height}, inside) {
  let [left, top, right, bottom] = [width, height, 0, 0];
  inside.forEach((one, i) => {
    if (!one) return;
    const x = i % width, y = (i - x) / width;
    left = Math.min(left, x), right = Math.max(right, x + 1), top = Math.min(top, y), bottom = Math.max(bottom, y + 1);
  });
  return right > left ? [left / width, top / height, right / width, bottom / height] : null;
}

// The outline: pairs of neighbouring pixels, the one inside first; -1 beyond the picture.
function rimOf(field, inside) {
  const pairs = [];
  inside.forEach((one, i) => { if (one) for (const j of sides(field, i)) if (j < 0 || !inside[j]) pairs.push([i, j]); });
  return pairs;
}

// How much of each pixel of a mask belongs to a region, 0 to 1: a pixel more beyond the object's outline, and softened.
function softMask(field, inside) {
  const {width, height} = field, wide = new Float32Array(inside), next = new Float32Array(inside.length);
  for (const [, j] of rimOf(field, inside)) if (j >= 0 && !isSolid(field, j)) wide[j] = 1;
  for (const step of [1, width]) { // 1 2 1 across and down
    const last = step === 1 ? width : height;
    for (let i = 0; i < wide.length; i++) {
      const at = step === 1 ? i % width : Math.floor(i / width);
      next[i] = (wide[at > 0 ? i - step : i] + 2 * wide[i] + wide[at < last - 1 ? i + step : i]) / 4;
    }
    wide.set(next);
  }
  return wide;
}
