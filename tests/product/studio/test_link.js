'use strict';
// The order of the studio's states. Run by node.
const assert = require('assert'), fs = require('fs'), path = require('path'), {runInThisContext} = require('vm');
runInThisContext(fs.readFileSync(path.join(__dirname, '../../../view/studio_link.js'), 'utf8'), {filename: 'studio_link.js'});
const {accept, studio} = runInThisContext('({accept, studio})'), heard = [];
studio.listeners.push(({version}) => heard.push(version));

for (const state of [{run: 7, version: 1}, {run: 7, version: 3}, {run: 7, version: 2}, {}, {run: 7, version: 3}, {run: 8, version: 1}]) accept(state);
assert.deepStrictEqual(heard, [1, 3, 3, 1]); // an answer that another overtook changes nothing; a server that was started again begins from 1
assert.strictEqual(studio.state.run, 8);

// A file that is not there is an error that names it; text that is not there is none.
runInThisContext(fs.readFileSync(path.join(__dirname, '../../../view/studio_server.js'), 'utf8'), {filename: 'studio_server.js'});
const {platform, textOf} = runInThisContext('({platform, textOf})');
globalThis.fetch = async () => ({ok: false, status: 404});
(async () => {
  await assert.rejects(platform.blob('now/001.png'), /now\/001\.png cannot be read \(404\)/);
  assert.strictEqual(await textOf('scores.json'), '');
})();
