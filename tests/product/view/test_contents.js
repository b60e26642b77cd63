'use strict';
// Texts and files that are dropped on the page, without a browser. Run by node.
const assert = require('assert'), fs = require('fs'), path = require('path'), {runInThisContext} = require('vm');

// A canvas of fonts with letters of their own width, of which "Here" alone is on this computer.
let drawn = [];
const widths = {monospace: 60, serif: 50, 'sans-serif': 55, 'system-ui': 55, Here: 40};
const context = {
  scale() {},
  measureText(text) {
    const name = this.font.replace(/^.*?px /, '').split(', ').map((one) => one.replaceAll('"', '')).find((one) => widths[one]);
    return {width: widths[name] * text.length, actualBoundingBoxAscent: /\u0301{3}/.test(text) ? 150 : 40, actualBoundingBoxDescent: 40};
  },
  fillText(text) { drawn.push([text, this.direction]); },
};
globalThis.scratch = () => context;
for (const name of ['films', 'contents']) runInThisContext(fs.readFileSync(path.join(__dirname, `../../../view/${name}.js`), 'utf8'), {filename: `${name}.js`});
const {TextContent, hasFont, clipText, refusalOf, nativeOf} = runInThisContext('({TextContent, hasFont, clipText, refusalOf, nativeOf})');

// --- Each line runs as its first strong letter does. ---
new TextContent('שלום עולם!\n3. مرحبا GO\nGO שלום\n12:30\n«܀ܐ»', '#ffffff').paint(context, 400, 300);
assert.deepStrictEqual(drawn.map(([, direction]) => direction), ['rtl', 'rtl', 'ltr', 'ltr', 'rtl']);

// --- Marks above one another do not leave the box; accents change nothing. ---
const high = (text) => Math.round(new TextContent(text, '#ffffff').size[1]);
assert.strictEqual(high('e'), 128);
assert.strictEqual(high('e\u0301\u0301\u0301'), 300);
assert.strictEqual(clipText('a'.repeat(1999) + '😀'), 'a'.repeat(1999));
assert.strictEqual(clipText('a'.repeat(1998) + '😀'), 'a'.repeat(1998) + '😀');

// --- Fonts that are not here. ---
assert.deepStrictEqual(['Here', 'serif', 'No Such Font'].map(hasFont), [true, true, false]);

// --- Files that a browser does not show are named. ---
assert.match(nativeOf('logo.KRA'), /^logo\.KRA is a Krita document: export it as PNG\.$/);
assert.strictEqual(nativeOf('logo.png'), null);
const box = (name, ...parts) => {
  const inner = Buffer.concat(parts), head = Buffer.alloc(8);
  head.writeUInt32BE(8 + inner.length), head.write(name, 4, 'latin1');
  return Buffer.concat([head, inner]);
};
const sample = (code) => box('stsd', Buffer.from([0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0]), Buffer.from(code, 'latin1'), Buffer.alloc(20));
(async () => {
  const film = new Blob([box('ftyp', Buffer.from('qt  \0\0\0\0qt  ', 'latin1')), box('moov', sample('mp4a'), sample('hvc1'))]);
  const {message, stays} = await refusalOf(film, 'phone.mov');
  assert.match(message, /^phone\.mov is HEVC \(H\.265\), which this browser cannot play\. In a terminal: ffmpeg -i "phone\.mov" .*"phone-page\.mp4"$/);
  assert.ok(stays);
})();
