'use strict';
// The page's logic without a page, in Node or in a browser that has the page's scripts: `testsOfPlace()` is a promise of the
// failures, a line each.
//
//     node test_place.js

if (typeof document === 'undefined') {
  const {readFileSync} = require('node:fs'), {runInThisContext} = require('node:vm');
  for (const name of ['math', 'history'])
    runInThisContext(readFileSync(`${__dirname}/../../../view/${name}.js`, 'utf8'), {filename: `${name}.js`});
}

var testsOfPlace = async () => {
  const failures = [];
  const check = (what, good, told = '') => { if (!good) failures.push(`${what}: ${told}`); };

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
  return failures;
};

if (typeof document === 'undefined')
  testsOfPlace().then((failures) => {
    for (const failure of failures) console.log(failure);
    process.exitCode = failures.length ? 1 : 0;
  });
