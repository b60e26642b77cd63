'use strict';
// Dropped or chosen files, as a list of {path, bytes}: a folder, or a ZIP file (PKWARE's APPNOTE 6.3.10, sections 4.3 and 4.4).

class Message extends Error {}

const FILES_MOST = 20000, BYTES_MOST = 2 ** 31;

// "a/b.png" or null: what leads out of its folder, or would be hidden, is left alone.
function cleanPath(path) {
  const parts = path.replaceAll('\\', '/').split('/').filter((part) => part && part !== '.');
  return parts.length && !parts.some((part) => part === '..' || part.startsWith('.') || part === '__MACOSX') ? parts.join('/') : null;
}

function checkAmount(count, bytes) {
  if (count > FILES_MOST) throw new Message(`These are more than ${FILES_MOST} files.`);
  if (bytes > BYTES_MOST) throw new Message('This is more than the 2 GB that a page can hold.');
}

async function readFiles(files) {
  const list = [];
  checkAmount(files.length, files.reduce((sum, { file }) => sum + file.size, 0));
  for (const { path, file } of files) {
    const clean = cleanPath(path);
    if (clean) list.push({ path: clean, bytes: new Uint8Array(await file.arrayBuffer()) });
  }
  return list;
}

async function inflate(bytes, size, name) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  const out = new Uint8Array(size), reader = stream.getReader();
  for (let at = 0; ;) {
    const { value, done } = await reader.read().catch(() => { throw new Message(`${name}: damaged`); });
    if (done) {
      if (at !== size) throw new Message(`${name}: damaged, it ends early`);
      return out;
    }
    if (at + value.length > size) throw new Message(`${name}: damaged, it is longer than the ZIP file says`);
    out.set(value, at);
    at += value.length;
  }
}

// The central directory's entries.
function zipEntries(view, name) {
  const entries = [];
  let end = view.byteLength - 22;
  while (end >= 0 && end > view.byteLength - 65558 && view.getUint32(end, true) !== 0x06054b50) end--;
  if (end < 0 || view.getUint32(end, true) !== 0x06054b50) throw new Message(`${name}: not a ZIP file`);
  let at = view.getUint32(end + 16, true);
  for (let count = view.getUint16(end + 10, true); count > 0; count--) {
    if (at + 46 > view.byteLength || view.getUint32(at, true) !== 0x02014b50) throw new Message(`${name}: its directory is damaged`);
    const length = view.getUint16(at + 28, true);
    if (at + 46 + length > view.byteLength) throw new Message(`${name}: its directory is damaged`);
    entries.push({
      path: new TextDecoder().decode(new Uint8Array(view.buffer, at + 46, length)),
      sealed: view.getUint16(at + 8, true) & 1, method: view.getUint16(at + 10, true),
      packed: view.getUint32(at + 20, true), size: view.getUint32(at + 24, true), from: view.getUint32(at + 42, true),
    });
    at += 46 + length + view.getUint16(at + 30, true) + view.getUint16(at + 32, true);
  }
  return entries;
}

async function readZip(file) {
  checkAmount(1, file.size);
  const buffer = await file.arrayBuffer(), view = new DataView(buffer), list = [];
  const entries = zipEntries(view, file.name);
  checkAmount(entries.length, entries.reduce((sum, entry) => sum + entry.size, 0));
  for (const entry of entries) {
    const path = cleanPath(entry.path);
    if (!path || entry.path.endsWith('/')) continue;
    if (entry.sealed) throw new Message(`${file.name}: ${path} is encrypted`);
    if (entry.from + 30 > buffer.byteLength) throw new Message(`${file.name}: ${path} is damaged`);
    const begin = entry.from + 30 + view.getUint16(entry.from + 26, true) + view.getUint16(entry.from + 28, true);
    if (begin + entry.packed > buffer.byteLength) throw new Message(`${file.name}: ${path} is damaged`);
    const bytes = new Uint8Array(buffer, begin, entry.packed);
    if (entry.method !== 0 && entry.method !== 8) throw new Message(`${file.name}: ${path} is packed by method ${entry.method}; 0 and 8 (deflate) are read`);
    list.push({ path, bytes: entry.method === 8 ? await inflate(bytes, entry.size, path) : bytes.slice() });
  }
  return list;
}

const CRC = Uint32Array.from({ length: 256 }, (_, n) => {
  let c = n;
  for (let bit = 0; bit < 8; bit++) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c;
});

function crc32(bytes) {
  let c = ~0;
  for (let i = 0; i < bytes.length; i++) c = CRC[(c ^ bytes[i]) & 255] ^ (c >>> 8);
  return ~c >>> 0;
}

// A ZIP file (APPNOTE.TXT 6.3, 4.3) of {path, bytes}, as they are: pictures are packed already.
function zipOf(files) {
  const parts = [], directory = [];
  let at = 0;
  for (const { path, bytes } of files) {
    const name = new TextEncoder().encode(path), about = new DataView(new ArrayBuffer(26));
    if (at + bytes.length > 0xffffffff || files.length > 0xffff) throw new Message('More than 4 GB or 65,535 files do not fit into a ZIP file.');
    [[0, 20], [2, 0x800], [8, 0x21], [22, name.length]].forEach(([offset, value]) => about.setUint16(offset, value, true)); // 2.0, UTF-8, 1980-01-01
    [[10, crc32(bytes)], [14, bytes.length], [18, bytes.length]].forEach(([offset, value]) => about.setUint32(offset, value, true));
    const local = about.buffer, central = new DataView(new ArrayBuffer(46));
    central.setUint32(0, 0x02014b50, true);
    central.setUint16(4, 20, true);
    new Uint8Array(central.buffer).set(new Uint8Array(local), 6);
    central.setUint32(42, at, true);
    parts.push(Uint8Array.of(0x50, 0x4b, 3, 4), local, name, bytes); // and behind its signature the same in both headers
    directory.push(central.buffer, name);
    at += 30 + name.length + bytes.length;
  }
  const end = new DataView(new ArrayBuffer(22)), size = directory.reduce((sum, part) => sum + part.byteLength, 0);
  end.setUint32(0, 0x06054b50, true);
  for (const offset of [8, 10]) end.setUint16(offset, files.length, true);
  end.setUint32(12, size, true);
  end.setUint32(16, at, true);
  return new Blob([...parts, ...directory, end.buffer], { type: 'application/zip' });
}

// All files under a dropped folder: by its handle, or by its entry in browsers that have none. (Chromium has entries too, but refuses to
// read them in a page that was opened from disk.)
async function walkHandle(handle, path, files) {
  if (handle.kind === 'file') {
    files.push({ path, file: await handle.getFile() });
    return;
  }
  for await (const child of handle.values()) await walkHandle(child, `${path}/${child.name}`, files);
}

async function walkEntry(entry, files) {
  if (entry.isFile) {
    files.push({ path: entry.fullPath, file: await new Promise((done, fail) => entry.file(done, fail)) });
    return;
  }
  const reader = entry.createReader();
  for (;;) {
    const some = await new Promise((done, fail) => reader.readEntries(done, fail));
    if (!some.length) return;
    for (const child of some) await walkEntry(child, files);
  }
}

async function readDropped(transfer) {
  const items = [...transfer.items].filter((item) => item.kind === 'file'), files = [];
  const all = items.map((item) => (item.getAsFileSystemHandle ? item.getAsFileSystemHandle() : item.webkitGetAsEntry()));
  for (const one of await Promise.all(all)) {
    if (!one) throw new Message('The browser does not hand over what was dropped: choose it with a button.');
    await (one.kind ? walkHandle(one, one.name, files) : walkEntry(one, files));
  }
  if (files.length === 1 && /\.zip$/i.test(files[0].path)) return readZip(files[0].file);
  return readFiles(files);
}
