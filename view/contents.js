'use strict';
// Contents for a projector: pictures, films, the webcam, screens, text, test patterns. Each has a `size`, [width, height] or
// null for any, `paint(context, width, height)`, which fills a box at the origin, and `live` if it changes over time.

const PICTURE_SIDE_MAX = 16384, PICTURE_PIXELS_MAX = 100e6;

class Message extends Error {} // an error whose text is shown to the user

const HEAD = 65536, SVG_SIDE = 2048, JPEG_SEGMENTS_MAX = 4096;

// The size given by the header of a PNG, GIF, WebP, BMP or AVIF file; null for other files.
function sizeInHead(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength), n = bytes.length;
  const text = (at, length) => String.fromCharCode(...bytes.subarray(at, at + length));
  if (n >= 24 && text(1, 3) === 'PNG') return [view.getUint32(16), view.getUint32(20)];
  if (n >= 10 && text(0, 3) === 'GIF') return [view.getUint16(6, true), view.getUint16(8, true)];
  if (n >= 26 && text(0, 2) === 'BM') return [view.getInt32(18, true), Math.abs(view.getInt32(22, true))];
  if (n >= 30 && text(0, 4) === 'RIFF' && text(8, 7) === 'WEBPVP8') {
    if (text(15, 1) === 'X')
      return [1 + (view.getUint32(24, true) & 0xffffff), 1 + (view.getUint16(27, true) | bytes[29] << 16)];
    if (text(15, 1) === 'L') {
      const bits = view.getUint32(21, true);
      return [1 + (bits & 0x3fff), 1 + (bits >>> 14 & 0x3fff)];
    }
    return [view.getUint16(26, true) & 0x3fff, view.getUint16(28, true) & 0x3fff];
  }
  if (n >= 12 && text(4, 8).startsWith('ftypavi')) { // of all the file's pictures the largest
    let largest = null;
    for (let at = 12; at + 16 <= n; at++) {
      if (bytes[at] !== 0x69 || text(at, 4) !== 'ispe') continue;
      const size = [view.getUint32(at + 8), view.getUint32(at + 12)];
      if (!largest || size[0] * size[1] > largest[0] * largest[1]) largest = size;
    }
    return largest;
  }
  return null;
}

// A JPEG's size comes after its metadata, which may be long: walks from segment to segment.
async function sizeOfJpeg(file) {
  for (let at = 2, i = 0; i < JPEG_SEGMENTS_MAX; i++) {
    const view = new DataView(await file.slice(at, at + 9).arrayBuffer());
    if (view.byteLength < 9 || view.getUint8(0) !== 0xff) return null;
    const marker = view.getUint8(1);
    if (marker === 0xff) { // filling
      at++;
      continue;
    }
    if (marker >= 0xc0 && marker <= 0xcf && ![0xc4, 0xc8, 0xcc].includes(marker)) return [view.getUint16(7), view.getUint16(5)];
    at += 2 + view.getUint16(2);
  }
  return null;
}

// The size that a picture file gives, so that huge pictures are refused before they are decoded; null: none.
async function sizeOfFile(file) {
  const bytes = new Uint8Array(await file.slice(0, HEAD).arrayBuffer());
  return bytes[0] === 0xff && bytes[1] === 0xd8 ? sizeOfJpeg(file) : sizeInHead(bytes);
}

function checkSize(name, size) {
  const [width, height] = size;
  if (width > PICTURE_SIDE_MAX || height > PICTURE_SIDE_MAX || width * height > PICTURE_PIXELS_MAX)
    throw new Message(`${name} has ${width} × ${height} pixels, which is more than a projector shows and this page ` +
                      `accepts (100 million, ${PICTURE_SIDE_MAX} per side).`);
}

class PictureContent {
  constructor(name, bitmap) { this.name = name, this.bitmap = bitmap; }
  get size() { return [this.bitmap.width, this.bitmap.height]; }
  paint(context, width, height) {
    const {a, b, e, f} = context.getTransform(), exact = a === 1 && b === 0 && e % 1 === 0 && f % 1 === 0;
    context.imageSmoothingQuality = 'high';
    context.imageSmoothingEnabled = !exact || this.bitmap.width !== width || this.bitmap.height !== height;
    context.drawImage(this.bitmap, 0, 0, width, height);
  }
  free() { if (!this.shared) this.bitmap.close(); }
}

// Browsers do not let a page sound before it is touched: a film that may not begins mute and is heard from then on.
function playVideo(video) {
  video.play().catch((error) => {
    if (error.name !== 'NotAllowedError' || video.muted) return;
    video.muted = true;
    video.play().catch(() => {});
    addEventListener('pointerdown', () => { video.muted = false; }, {once: true});
  });
}

// A film.
class VideoContent {
  constructor(name, video, release) { this.name = name, this.video = video, this.release = release; }
  get live() { return !this.video.paused && !this.video.ended; }
  get size() { return [this.video.videoWidth || 16, this.video.videoHeight || 9]; }
  paint(context, width, height) { if (this.video.videoWidth) context.drawImage(this.video, 0, 0, width, height); }
  free() { if (this.shared) this.video.pause(); else this.release(); } // shared: it is the library's
  toggle() { if (this.video.paused) playVideo(this.video); else this.video.pause(); }

  // The same film with a player of its own.
  async twin() {
    const video = document.createElement('video');
    video.src = this.video.src;
    return Object.assign(new VideoContent(this.name, await loadVideo(video, this.name), () => video.pause()), {file: this.file});
  }

  // Plays the part of the film that its layer asks for, as loud as it asks.
  follow({volume, from, to}, sound) {
    const {video} = this, end = to > from ? to : Infinity;
    video.volume = clamp(volume * sound, 0, 1);
    if (!video.seeking && (video.currentTime >= end || video.currentTime < from - 0.05)) video.currentTime = from;
  }
}

const FONTS = ['system-ui', 'sans-serif', 'serif', 'monospace', 'cursive'], FONT_NAME = /^[\p{L}\p{N} ._-]{1,80}$/u, LINE = 1.15, TEXT_MAX = 2000;

// The way a line runs, by its first strong letter (Unicode UAX #9, P2).
const RIGHT_TO_LEFT = /[\u200f\p{Script=Hebrew}\p{Script=Arabic}\p{Script=Syriac}\p{Script=Thaana}\p{Script=Nko}\p{Script=Samaritan}\p{Script=Mandaic}\p{Script=Adlam}\p{Script=Hanifi_Rohingya}]/u;
function directionOf(line) {
  const [letter] = /[\p{L}\u200e\u200f]/u.exec(line) || [''];
  return RIGHT_TO_LEFT.test(letter) ? 'rtl' : 'ltr';
}

// The first characters of a text, none of them cut in two.
const clipText = (text) => text.slice(0, TEXT_MAX).replace(/[\ud800-\udbff]$/, '');

// False if the browser draws a font as whatever it falls back to.
function hasFont(name) {
  const context = scratch('measure', 1, 1);
  const width = (font) => {
    context.font = `100px ${font}`;
    return context.measureText('mmmiiiWWW 0123 אבג مرح あ漢 한 ก').width;
  };
  return FONTS.includes(name) || ['monospace', 'serif'].some((other) => width(`"${name}", ${other}`) !== width(other));
}

class TextContent {
  constructor(text, colour, font = FONTS[0]) {
    this.name = 'Text', this.text = text, this.colour = colour, this.font = font;
    this.lines = (text || ' ').split('\n');
    const context = scratch('measure', 1, 1);
    context.font = TextContent.style(100, font);
    context.textBaseline = 'middle';
    const sizes = this.lines.map((line) => context.measureText(line)), widest = Math.max(1, ...sizes.map(({width}) => width));
    const half = Math.max(...sizes.map((size) => Math.max(size.actualBoundingBoxAscent, size.actualBoundingBoxDescent))); // of marks above one another, too
    this.line = Math.max(LINE, 2 * 0.9 * half / 100);
    this.size = [widest / 0.9, 100 * this.line * this.lines.length / 0.9];
  }
  static style(pixels, font) { return `700 ${pixels}px ${FONTS.includes(font) ? font : `"${font}"`}, system-ui, sans-serif`; }
  paint(context, width, height) {
    const s = 100 * height / this.size[1], {lines} = this;
    context.scale(width / this.size[0] * this.size[1] / height, 1);
    context.textAlign = 'center', context.textBaseline = 'middle', context.fillStyle = this.colour;
    context.font = TextContent.style(s, this.font);
    lines.forEach((line, i) => {
      context.direction = directionOf(line);
      context.fillText(line, s * this.size[0] / 200, height / 2 + (i - (lines.length - 1) / 2) * this.line * s);
    });
  }
  free() {}
}

// Patterns drawn here; their names say what they consist of.
const TEST_PATTERNS = {
  White(context, width, height) {
    context.fillStyle = '#fff';
    context.fillRect(0, 0, width, height);
  },
  Grid(context, width, height) {
    const step = Math.max(width, height) / 20;
    context.strokeStyle = '#fff', context.lineWidth = Math.max(1, step / 12);
    context.beginPath();
    for (let x = width / 2 % step; x <= width; x += step) context.moveTo(x, 0), context.lineTo(x, height);
    for (let y = height / 2 % step; y <= height; y += step) context.moveTo(0, y), context.lineTo(width, y);
    context.stroke();
    context.strokeStyle = '#ff5a36', context.lineWidth *= 2;
    context.beginPath();
    context.moveTo(width / 2, 0), context.lineTo(width / 2, height);
    context.moveTo(0, height / 2), context.lineTo(width, height / 2);
    context.stroke();
  },
  Checker(context, width, height) {
    const step = Math.max(width, height) / 24;
    context.fillStyle = '#fff';
    for (let y = 0; y * step < height; y++)
      for (let x = y & 1; x * step < width; x += 2) context.fillRect(x * step, y * step, step, step);
  },
  // To be admired: a sky, the sun and its light on water.
  Sunset(context, width, height) {
    const sky = context.createLinearGradient(0, 0, 0, height), x = width / 2, y = 0.5 * height, side = Math.min(width, height);
    [[0, '#1a1450'], [0.22, '#5b2a86'], [0.38, '#d8436e'], [0.5, '#ff9a3d'], [0.56, '#ffd56b'], [0.57, '#b8455f'], [0.75, '#47307a'],
     [1, '#101a4a']].forEach((stop) => sky.addColorStop(...stop));
    context.fillStyle = sky;
    context.fillRect(0, 0, width, height);
    const glow = context.createRadialGradient(x, y, 0, x, y, 0.45 * side);
    [[0, '#fff6d8'], [0.22, '#ffe9a0'], [0.26, '#ffb45299'], [1, '#ff7a4000']].forEach((stop) => glow.addColorStop(...stop));
    context.fillStyle = glow;
    context.fillRect(0, 0, width, 0.565 * height);
    context.fillStyle = '#ffd98acc';
    for (let i = 0; i < 14; i++) {
      const half = side * (0.16 - 0.009 * i) * (1 + 0.35 * Math.sin(2.4 * i));
      context.fillRect(x - half + 0.03 * side * Math.sin(5.1 * i), height * (0.585 + 0.029 * i), 2 * half, 0.012 * height);
    }
  },
  // Rings and sectors of strong colours, as the structured light of the captures.
  Lollipop(context, width, height) {
    const radius = Math.min(width, height) / 2, rings = 30, sectors = 8;
    for (let ring = rings; ring >= 1; ring--)
      for (let sector = 0; sector < sectors; sector++) {
        context.fillStyle = `hsl(${(ring * 137.508 + sector * 97) % 360} 85% ${35 + (ring * 29 + sector * 61) % 45}%)`;
        context.beginPath();
        context.moveTo(width / 2, height / 2);
        context.arc(width / 2, height / 2, radius * ring / rings, sector * Math.PI / 4, (sector + 1) * Math.PI / 4);
        context.fill();
      }
  },
  Rainbow(context, width, height) {
    const ramp = context.createLinearGradient(0, 0, width, 0);
    for (let k = 0; k <= 12; k++) ramp.addColorStop(k / 12, `hsl(${30 * k} 90% 55%)`);
    context.fillStyle = ramp;
    context.fillRect(0, 0, width, height);
  },
};

class TestContent {
  constructor(name) { this.name = name, this.size = null; }
  paint(context, width, height) { TEST_PATTERNS[this.name](context, width, height); }
  free() {}
}

class SolidContent {
  constructor(colour) { this.name = 'Colour', this.colour = colour, this.size = null; }
  paint(context, width, height) {
    context.fillStyle = this.colour;
    context.fillRect(0, 0, width, height);
  }
  free() {}
}

// Resolves with its first frame; it plays when it is shown.
function loadVideo(video, name) {
  video.loop = true, video.playsInline = true;
  return new Promise((resolve, reject) => {
    const late = setTimeout(() => reject(new Message(`${name} does not start.`)), 20000);
    video.onloadeddata = () => { clearTimeout(late); resolve(video); };
    video.onerror = () => { clearTimeout(late); reject(new Message(`This browser cannot play ${name}.`)); };
  });
}

// A GIF, animated PNG or WebP, in the order of its frames; ends: when each does, in milliseconds.
class AnimationContent {
  constructor(name, frames, ends) { this.name = name, this.frames = frames, this.ends = ends, this.begun = performance.now(); }
  get live() { return this.stopped === undefined; }
  get size() { return [this.frames[0].width, this.frames[0].height]; }
  paint(context, width, height) {
    const at = (this.live ? performance.now() - this.begun : this.stopped) % this.ends.at(-1), frame = this.frames[this.ends.findIndex((end) => at < end)];
    context.drawImage(frame, 0, 0, width, height);
  }
  free() { if (!this.shared) this.frames.forEach((frame) => frame.close()); }
  toggle() {
    const now = performance.now();
    if (this.live) this.stopped = now - this.begun;
    else this.begun = now - this.stopped, this.stopped = undefined;
  }
}

const ANIMATED = /^image\/(gif|png|apng|webp)$/, FRAME_LEAST = 20; // ms

// Its frames, if the browser takes animations apart; null for a picture alone.
async function contentOfAnimation(file, name) {
  const type = file.type === 'image/apng' ? 'image/png' : file.type;
  if (typeof ImageDecoder === 'undefined' || !ANIMATED.test(type)) return null;
  const decoder = new ImageDecoder({data: await file.arrayBuffer(), type}), frames = [], ends = [];
  try {
    await Promise.all([decoder.tracks.ready, decoder.completed]);
    const count = decoder.tracks.selectedTrack.frameCount;
    for (let i = 0, end = 0; count > 1 && i < count; i++) {
      const {image} = await decoder.decode({frameIndex: i});
      if (count * image.displayWidth * image.displayHeight > PICTURE_PIXELS_MAX) {
        image.close();
        throw new Message(`${name} has ${count} frames, which are more than this page holds: make a film of it.`);
      }
      ends.push(end += Math.max(FRAME_LEAST, (image.duration || 0) / 1000));
      frames.push(await createImageBitmap(image));
      image.close();
    }
  } catch (error) {
    frames.splice(0).forEach((frame) => frame.close());
    if (error instanceof Message) throw error;
  } finally {
    decoder.close();
  }
  return frames.length ? new AnimationContent(name, frames, ends) : null;
}

async function contentOfFilm(file, name) {
  const url = URL.createObjectURL(file), video = document.createElement('video');
  video.src = url;
  try {
    await loadVideo(video, name);
    if (!video.videoWidth) throw new Error(); // it plays the sound alone
  } catch {
    URL.revokeObjectURL(url);
    throw await refusalOf(file, name);
  }
  return new VideoContent(name, video, () => { video.pause(); URL.revokeObjectURL(url); });
}

// A drawing, with or without declarations before it, as large as projectors are.
async function bitmapOfSvg(file) {
  const head = await file.slice(0, HEAD).text();
  if (!/^\uFEFF?\s*<[?!s]/.test(head) || !/<svg[\s>]/.test(head)) return null;
  const url = URL.createObjectURL(new Blob([file], {type: 'image/svg+xml'})), image = new Image();
  try {
    image.src = url;
    await image.decode();
    const width = image.naturalWidth || 300, height = image.naturalHeight || 150, s = Math.max(1, SVG_SIDE / Math.max(width, height));
    checkSize(file.name, [width, height]);
    const canvas = new OffscreenCanvas(Math.round(width * s), Math.round(height * s));
    canvas.getContext('2d').drawImage(image, 0, 0, canvas.width, canvas.height);
    return canvas.transferToImageBitmap();
  } finally {
    URL.revokeObjectURL(url);
  }
}

// Decoded to sRGB, whatever its profile.
async function contentOfPicture(file, name) {
  const size = await sizeOfFile(file);
  if (size) checkSize(name, size);
  const animation = await contentOfAnimation(file, name);
  if (animation) return animation;
  const bitmap = await createImageBitmap(file).catch(() => bitmapOfSvg(file).catch((error) => { if (error instanceof Message) throw error; }));
  if (!bitmap) return null;
  try {
    checkSize(name, [bitmap.width, bitmap.height]);
  } catch (error) {
    bitmap.close();
    throw error;
  }
  return new PictureContent(name, bitmap);
}

// Drawing programs' own files, which no browser shows.
const NATIVE = {kra: 'a Krita document', ora: 'an OpenRaster document', procreate: 'a Procreate document', xcf: 'a GIMP document', clip: 'a Clip Studio document',
  psd: 'a Photoshop document', psb: 'a Photoshop document', afphoto: 'an Affinity document', afdesign: 'an Affinity document', af: 'an Affinity document',
  ai: 'an Illustrator document', eps: 'a PostScript drawing', pdf: 'a PDF document', tga: 'a TGA picture', exr: 'an EXR picture', tif: 'a TIFF picture',
  tiff: 'a TIFF picture', heic: 'a HEIC picture'};
function nativeOf(name) {
  const ending = name.replace(/^.*\./, '').toLowerCase(), what = Object.hasOwn(NATIVE, ending) && NATIVE[ending];
  return what ? `${name} is ${what}: export it as PNG.` : null;
}

// A file, dropped, pasted or chosen, as content. Systems do not know the type of every film.
async function contentOfFile(file) {
  const name = file.name || 'The picture';
  if (!file.size) throw new Message(`${name} is empty.`);
  if (file.type.startsWith('video/')) return contentOfFilm(file, name);
  const picture = await contentOfPicture(file, name);
  if (picture) return picture;
  return contentOfFilm(file, name).catch((error) => { throw error.stays ? error : new Message(nativeOf(name) || `${name} is neither a picture nor a film that this browser reads.`); });
}

// The webcam, or a screen, window or tab. Browsers give them only to a hand that asks: a stage that comes back has it dark
// until its tile is pressed.
class StreamContent extends VideoContent {
  constructor(kind) {
    super(kind === 'camera' ? 'Camera' : 'Screen', document.createElement('video'), () => {});
    this.kind = kind, this.video.muted = true;
  }

  follow() {}

  get running() { return !!this.video.srcObject && this.video.srcObject.active; }

  async start() {
    const {mediaDevices} = navigator, ask = this.kind === 'camera' ? 'getUserMedia' : 'getDisplayMedia';
    if (!mediaDevices || !mediaDevices[ask]) throw new Message(`This browser does not give a page opened from disk a ${this.kind}.`);
    const stream = await mediaDevices[ask]({video: this.kind === 'camera' ? {width: {ideal: 1280}} : true, audio: false}).catch((error) => {
      throw new Message(`The ${this.kind} cannot be used: ${error.message || error.name}.`);
    });
    this.video.srcObject = stream;
    for (const track of stream.getTracks()) track.onended = () => say(`${this.name} has ended; press its tile to start it again.`);
    await loadVideo(this.video, this.name).catch((error) => {
      stream.getTracks().forEach((track) => track.stop());
      throw error;
    });
    playVideo(this.video);
  }
}
