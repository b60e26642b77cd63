'use strict';
// The page's logic without a page, in Node or in a browser that has the page's scripts: `testsOfPlace()` is a promise of the
// failures, a line each.
//
//     node test_place.js

if (typeof document === 'undefined') {
  const {readFileSync} = require('node:fs'), {runInThisContext} = require('node:vm');
  for (const name of ['math', 'place', 'history'])
    runInThisContext(readFileSync(`${__dirname}/../../../view/${name}.js`, 'utf8'), {filename: `${name}.js`});
}

var testsOfPlace = async () => {
  const failures = [];
  const check = (what, good, told = '') => { if (!good) failures.push(`${what}: ${told}`); };

  const near = (a, b, most = 1e-9) => a.flat().every((value, i) => Math.abs(value - b.flat()[i]) <= most);

  // --- Places. ---
  const place = {...newPlace(), x: 0.1, y: -0.2, width: 0.5, height: 0.7, turn: 30, pull: [[0.1, 0], [0, -0.2], [0.05, 0.1], [0, 0]]};
  const frame = layerFrame(place, [200, 100], 'contain', 800, 600), corners = cornersOf(frame), map = homographyOf(frame);
  const withPlace = (changed) => ({...frame, place: changed});
  check('what fits', near([fittedSize([200, 100], 800, 600, 'contain'), fittedSize([200, 100], 800, 600, 'cover'), fittedSize(null, 8, 6)],
    [[800, 400], [1200, 600], [8, 6]]));
  check('the homography leads to the corners', near(UNIT.map((unit) => throughHomography(map, unit)), corners, 1e-9), corners);
  check('and back', near([0.3, 0.8], toUnit(frame, throughHomography(map, [0.3, 0.8]))));
  const straight = [0.2, 0.5, 0.9].map((u) => throughHomography(map, [u, 0.4 + 0.3 * u])), [p, q, r] = straight;
  check('straight lines stay straight', Math.abs((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])) < 1e-8);
  const quad = [[0, 0], [4, 0], [4, 4], [0, 4]], trapezium = [[1, 0], [3, 0], [4, 4], [0, 4]];
  check('a square is mapped evenly', near(throughHomography(homographyTo(quad), [0.5, 0.25]), [2, 1]));
  check('a trapezium as perspective has it', near(throughHomography(homographyTo(trapezium), [0.5, 0.5]), [2, 4 / 3]), throughHomography(homographyTo(trapezium), [0.5, 0.5]));
  for (const [name, k] of [[0, 0], [2, 2]]) {
    const to = [corners[k][0] + 17, corners[k][1] - 9], pulled = withPlace(dragHandle(frame, 'corners', name, to, false));
    check(`corner ${k} follows the pointer`, near(cornersOf(pulled)[k], to) && near(cornersOf(pulled)[(k + 1) % 4], corners[(k + 1) % 4]));
    const free = withPlace(dragHandle(frame, 'size', name, to, true)), opposite = (k + 2) % 4;
    check(`corner ${k} scales, the opposite one stays`, near(cornersOf(free)[opposite], corners[opposite], 1e-8) && near(cornersOf(free)[k], to, 1e-8));
    const even = dragHandle(frame, 'size', name, to, false);
    check('and keeps the shape', Math.abs(even.width / even.height - place.width / place.height) < 1e-12 && even.width !== place.width);
  }
  const fold = dragHandle(frame, 'corners', 0, corners[2], false);
  check('a corner that would fold the layer stays', fold === place);
  const wide = withPlace(dragHandle(frame, 'size', 5, [corners[1][0] + 90, corners[1][1] + 50], false));
  check('an edge changes one side', wide.place.height === place.height && wide.place.width > place.width &&
    near(between(cornersOf(wide)[0], cornersOf(wide)[3]), between(corners[0], corners[3]), 1e-8));
  const m = middleOf(frame), turn = dragHandle(frame, 'size', 'turn', [m[0] + 100, m[1] + 3], true);
  check('the handle turns in steps', turn.turn === 90, turn.turn);
  check('moving moves all corners alike', near(cornersOf(withPlace(movedBy(frame, 8, -6))), corners.map(([x, y]) => [x + 8, y - 6])));
  const [a, b] = [[300, 300], [400, 320]], [c, d] = [[310, 250], [380, 420]], pinch = withPlace(pinched(frame, [a, b], [c, d]));
  const held = [a, b].map((at) => fromBox(pinch, toBox(frame, at)));
  check('two fingers hold what they touch', near(held, [c, d], 1e-6), held);

  // --- Hits, crop and mask. ---
  const cut = withPlace(dragHandle(frame, 'crop', 7, throughHomography(map, [0.25, 0.6]), false));
  check('an edge crops', near([cut.place.crop], [[0.25, 0, 0, 0]]), cut.place.crop);
  check('what is cropped is not hit', covers(frame, throughHomography(map, [0.2, 0.5])) && !covers(cut, throughHomography(map, [0.2, 0.5])) && covers(cut, throughHomography(map, [0.3, 0.5])));
  const far = withPlace(dragHandle(cut, 'crop', 5, throughHomography(map, [-3, 0.5]), false));
  check('a crop leaves something', far.place.crop[0] + far.place.crop[2] < 1);
  const masked = withPlace({...place, mask: [[0, 0], [1, 0], [0, 1]]});
  check('what is masked is not hit', covers(masked, throughHomography(map, [0.2, 0.2])) && !covers(masked, throughHomography(map, [0.8, 0.8])));
  const moved = withPlace(dragHandle(masked, 'mask', 'mask 1', throughHomography(map, [0.9, 0.9]), false));
  check('a point of the mask moves', near(moved.place.mask, [[0, 0], [0.9, 0.9], [0, 1]], 1e-9), moved.place.mask);
  const handles = handlesOf(frame, 'size', 24), under = handleUnder(handles, [corners[1][0] + 3, corners[1][1] + 4], 12);
  check('the nearest handle is hit', under && under.name === 1 && !handleUnder(handles, [corners[1][0] + 30, corners[1][1] - 40], 12), under && under.name);

  // --- Undo. ---
  const work = {value: 0}, undo = () => new Undo({take: () => work.value, same: (a, b) => a === b, put: async (state) => { work.value = state; }});
  let history = undo();
  history.begin(1);
  work.value = 1;
  history.note(); // as a frame or a timer might
  work.value = 2;
  history.end(1);
  check('a gesture is one step', String(history.states) === '0,2', history.states);
  work.value = 3; // something that came by itself
  history.begin(1);
  work.value = 4;
  history.begin(2); // a second finger
  work.value = 5;
  history.end(1);
  work.value = 6;
  history.end(2);
  check('what was before a gesture is a step by itself, and two fingers are one gesture', String(history.states) === '0,2,3,6', history.states);
  await history.go(-1);
  await history.go(-1);
  check('steps are taken back in order', work.value === 2, work.value);
  await history.go(1);
  check('and brought again', work.value === 3, work.value);
  work.value = 7;
  history.note();
  await history.go(1);
  check('after something new nothing is brought again', work.value === 7 && String(history.states) === '0,2,3,7', history.states);
  let late = false;
  history.begin(1);
  work.value = 8;
  const arrives = history.rest().then(() => { late = true; work.value = 9; history.note(); });
  await Promise.resolve();
  check('what arrives waits for the gesture', !late);
  history.end(1);
  await arrives;
  check('and is a step by itself', String(history.states) === '0,2,3,7,8,9', history.states);
  history = undo();
  for (let i = 0; i < 2 * UNDO_MAX; i++) work.value = 100 + i, history.note();
  check('steps are bounded', history.states.length === UNDO_MAX && history.at === UNDO_MAX - 1, history.states.length);
  const fit = placeInPart(frame, [0.5, 0.25, 0.75, 0.75]); // 200 of 800 pixels for 800, 300 of 600 for 400
  check('as large as a part', near([[fit.x, fit.y, fit.width, fit.height, fit.turn], ...fit.pull], [[0.125, 0, 0.25, 0.25, 0], [0, 0], [0, 0], [0, 0], [0, 0]]), JSON.stringify(fit));
  const tall = cornersOf(withPlace(placeInPart(frame, [0.1, 0.4, 0.9, 0.6]))); // 120 pixels high
  check('it lies there', near(tall, [[280, 240], [520, 240], [520, 360], [280, 360]], 1e-6), JSON.stringify(tall));
  return failures;
};

if (typeof document === 'undefined')
  testsOfPlace().then((failures) => {
    for (const failure of failures) console.log(failure);
    process.exitCode = failures.length ? 1 : 0;
  });
