'use strict';
// Where a layer lies in a projector's picture. Places are {x, y, width, height, turn, pull, crop, mask, opacity, feather}: the
// middle's distance from the picture's middle in shares of the picture; factors of the fitted size; degrees clockwise; how far
// each corner is pulled, in shares of the layer's own width and height; shares cut away; a polygon that is shown, or null; the
// width of the edge that crop and mask leave, a share of the layer's shorter side.
// Corners begin at the top left and go clockwise; crop and mask are in the layer's unit square, u to the right and v down.
// No document, no drawing: tests run it alone.

const CORNERS = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]], UNIT = [[0, 0], [1, 0], [1, 1], [0, 1]];
const FACTOR = [0.01, 50], SHIFT_MAX = 5, PULL_MAX = 5, CROP_LEAST = 0.01, MASK_MAX = 200, FEATHER_MAX = 0.5;

const newPlace = () => ({x: 0, y: 0, width: 1, height: 1, turn: 0, pull: [[0, 0], [0, 0], [0, 0], [0, 0]], crop: [0, 0, 0, 0], mask: null, opacity: 1, feather: 0});

// The size at which a source, [width, height] or null (any), fits into a picture before it is placed.
function fittedSize(size, width, height, fit) {
  if (!size || fit === 'stretch') return [width, height];
  const s = (fit === 'cover' ? Math.max : Math.min)(width / size[0], height / size[1]);
  return [size[0] * s, size[1] * s];
}

// A layer in a picture: {place, fitted: [w, h], width, height}, all in the picture's pixels.
const layerFrame = (place, size, fit, width, height) => ({place, fitted: fittedSize(size, width, height, fit), width, height});

function turned([x, y], degrees) {
  const a = degrees * Math.PI / 180, c = Math.cos(a), s = Math.sin(a);
  return [c * x - s * y, s * x + c * y];
}

const middleOf = ({place, width, height}) => [(0.5 + place.x) * width, (0.5 + place.y) * height];

// From shares of the layer's own box, (0, 0) in its middle, to the picture's pixels; and back.
function fromBox(frame, [a, b]) {
  const {place, fitted} = frame, [x, y] = turned([a * place.width * fitted[0], b * place.height * fitted[1]], place.turn), m = middleOf(frame);
  return [m[0] + x, m[1] + y];
}
function toBox(frame, at) {
  const {place, fitted} = frame, m = middleOf(frame), [x, y] = turned([at[0] - m[0], at[1] - m[1]], -place.turn);
  return [x / (place.width * fitted[0]), y / (place.height * fitted[1])];
}

const cornersOf = (frame) => CORNERS.map(([a, b], k) => fromBox(frame, [a + frame.place.pull[k][0], b + frame.place.pull[k][1]]));

// --- Homographies, row-major 3 x 3. ---

// From the unit square to a quadrilateral (Heckbert 1989, "Fundamentals of texture mapping", 2.2.3).
function homographyTo([[x0, y0], [x1, y1], [x2, y2], [x3, y3]]) {
  const dx1 = x1 - x2, dx2 = x3 - x2, sx = x0 - x1 + x2 - x3, dy1 = y1 - y2, dy2 = y3 - y2, sy = y0 - y1 + y2 - y3;
  const d = dx1 * dy2 - dx2 * dy1, g = (sx * dy2 - dx2 * sy) / d, h = (dx1 * sy - sx * dy1) / d;
  return [x1 - x0 + g * x1, x3 - x0 + h * x3, x0, y1 - y0 + g * y1, y3 - y0 + h * y3, y0, g, h, 1];
}

function throughHomography(m, [u, v]) {
  const w = m[6] * u + m[7] * v + m[8];
  return [(m[0] * u + m[1] * v + m[2]) / w, (m[3] * u + m[4] * v + m[5]) / w];
}

// Up to a factor, the adjugate.
function inverseHomography([a, b, c, d, e, f, g, h, i]) {
  return [e * i - f * h, c * h - b * i, b * f - c * e, f * g - d * i, a * i - c * g, c * d - a * f, d * h - e * g, b * g - a * h, a * e - b * d];
}

// Upright and whole, as large as a part of the picture allows, [left, top, right, bottom] in shares of it.
function placeInPart({place, fitted, width, height}, [left, top, right, bottom]) {
  const factor = within(Math.min((right - left) * width / fitted[0], (bottom - top) * height / fitted[1]), FACTOR), {pull} = newPlace();
  return {...place, x: (left + right - 1) / 2, y: (top + bottom - 1) / 2, width: factor, height: factor, turn: 0, pull};
}

const homographyOf = (frame) => homographyTo(cornersOf(frame));
const toUnit = (frame, at) => throughHomography(inverseHomography(homographyOf(frame)), at);
const isPulled = (place) => place.pull.some(([a, b]) => a !== 0 || b !== 0);

// True if the corners go round clockwise without a dent: other quadrilaterals have no homography to show.
function isConvex(corners) {
  return corners.every((p, k) => {
    const q = corners[(k + 1) % 4], r = corners[(k + 2) % 4];
    return (q[0] - p[0]) * (r[1] - q[1]) - (q[1] - p[1]) * (r[0] - q[0]) > 1e-9;
  });
}

// The part of the unit square that is shown: the mask within what the crop leaves.
function cropped({crop: [left, top, right, bottom]}) { return UNIT.map(([u, v]) => [u ? 1 - right : left, v ? 1 - bottom : top]); }

function insidePolygon(at, points) {
  let inside = false;
  points.forEach(([x, y], k) => {
    const [p, q] = points[(k + 1) % points.length];
    if ((y > at[1]) !== (q > at[1]) && at[0] < x + (at[1] - y) / (q - y) * (p - x)) inside = !inside;
  });
  return inside;
}

// True if a position of the picture is on the layer that is shown there.
function covers(frame, at) {
  const unit = toUnit(frame, at), {mask} = frame.place;
  return insidePolygon(unit, cropped(frame.place)) && (!mask || mask.length < 3 || insidePolygon(unit, mask));
}

// --- Handles. ---

const between = (a, b) => [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];

// [{name, at}] of a frame: corners 0 to 3, edges 4 (top) to 7 (left), 'turn', points of the mask 'mask K'. `reach`: how far
// the handle that turns is from the box, pixels.
function handlesOf(frame, what, reach) {
  const map = homographyOf(frame), at = (unit) => throughHomography(map, unit), {mask} = frame.place;
  if (what === 'mask') return (mask || []).map((unit, k) => ({name: `mask ${k}`, at: at(unit)}));
  const ends = (what === 'crop' ? cropped(frame.place) : UNIT).map(at), corners = ends.map((p, k) => ({name: k, at: p}));
  if (what === 'corners') return corners;
  const edges = ends.map((p, k) => ({name: 4 + k, at: between(p, ends[(k + 1) % 4])}));
  if (what === 'crop') return edges;
  const top = edges[0].at, [x, y] = turned([0, -reach], frame.place.turn);
  return [...corners, ...edges, {name: 'turn', at: [top[0] + x, top[1] + y]}];
}

// The handle nearest to a position and within reach of it, or null.
function handleUnder(handles, at, reach) {
  let best = null, least = reach;
  for (const handle of handles) {
    const away = Math.hypot(handle.at[0] - at[0], handle.at[1] - at[1]);
    if (away <= least) best = handle, least = away;
  }
  return best;
}

const within = (value, [low, high]) => Math.min(Math.max(value, low), high);
const shifted = (share) => within(share, [-SHIFT_MAX, SHIFT_MAX]);

// The place with its middle at a position of the picture.
const withMiddle = ({place, width, height}, [x, y]) => ({...place, x: shifted(x / width - 0.5), y: shifted(y / height - 0.5)});

const movedBy = (frame, dx, dy) => ({...frame.place, x: shifted(frame.place.x + dx / frame.width), y: shifted(frame.place.y + dy / frame.height)});

// Larger by the factors along its own axes, while a point `about` of the picture stays.
function scaledAbout(frame, about, across, down) {
  const {place} = frame, width = within(place.width * across, FACTOR), height = within(place.height * down, FACTOR);
  const [a, b] = toBox(frame, about), larger = {...frame, place: {...place, width, height}}, stays = fromBox(larger, [a, b]), m = middleOf(frame);
  return withMiddle(larger, [m[0] + about[0] - stays[0], m[1] + about[1] - stays[1]]);
}

// Turned by degrees while a point of the picture stays.
function turnedAbout(frame, about, degrees) {
  const m = middleOf(frame), [x, y] = turned([m[0] - about[0], m[1] - about[1]], degrees), turn = frame.place.turn + degrees;
  return withMiddle({...frame, place: {...frame.place, turn: turn - 360 * Math.round(turn / 360)}}, [about[0] + x, about[1] + y]);
}

// The place after a handle was dragged to a position. `other` (Shift): a corner changes the shape, turns are multiples of 15 degrees.
function dragHandle(frame, what, name, to, other) {
  const {place} = frame;
  if (name === 'turn') {
    const m = middleOf(frame), bearing = 90 + Math.atan2(to[1] - m[1], to[0] - m[0]) * 180 / Math.PI;
    return turnedAbout(frame, m, (other ? 15 * Math.round(bearing / 15) : bearing) - place.turn);
  }
  if (what === 'mask') return {...place, mask: place.mask.map((unit, k) => name === `mask ${k}` ? toUnit(frame, to) : unit)};
  if (what === 'crop') return croppedTo(frame, name - 4, toUnit(frame, to));
  if (what === 'corners') {
    const box = toBox(frame, to), pull = place.pull.map((old, k) => k !== name ? old : [0, 1].map((i) => within(box[i] - CORNERS[k][i], [-PULL_MAX, PULL_MAX])));
    return isConvex(cornersOf({...frame, place: {...place, pull}})) ? {...place, pull} : place;
  }
  const corners = cornersOf(frame), edge = name >= 4, k = name % 4;
  const from = edge ? between(corners[k], corners[(k + 1) % 4]) : corners[k];
  const about = edge ? between(corners[(k + 2) % 4], corners[(k + 3) % 4]) : corners[(k + 2) % 4];
  const [a, b] = turned([to[0] - about[0], to[1] - about[1]], -place.turn), [c, d] = turned([from[0] - about[0], from[1] - about[1]], -place.turn);
  if (edge) return k % 2 ? scaledAbout(frame, about, a / c, 1) : scaledAbout(frame, about, 1, b / d);
  if (other) return scaledAbout(frame, about, a / c, b / d);
  const s = (a * c + b * d) / (c * c + d * d);
  return scaledAbout(frame, about, s, s);
}

function croppedTo({place}, edge, [u, v]) {
  const crop = [...place.crop], side = [1, 2, 3, 0][edge], wanted = [u, v, 1 - u, 1 - v][side];
  crop[side] = within(wanted, [0, 1 - CROP_LEAST - crop[(side + 2) % 4]]);
  return {...place, crop};
}

// Two fingers from [a, b] to [c, d]: moved, turned and scaled with them.
function pinched(frame, [a, b], [c, d]) {
  const was = between(a, b), now = between(c, d), before = [b[0] - a[0], b[1] - a[1]], after = [d[0] - c[0], d[1] - c[1]];
  const s = Math.hypot(...after) / Math.max(Math.hypot(...before), 1);
  const degrees = (Math.atan2(after[1], after[0]) - Math.atan2(before[1], before[0])) * 180 / Math.PI;
  const step = (place) => ({...frame, place});
  return turnedAbout(step(scaledAbout(step(movedBy(frame, now[0] - was[0], now[1] - was[1])), now, s, s)), now, degrees);
}
