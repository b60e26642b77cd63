'use strict';
// Films: a picture of each for its tile, and the names of those that a browser cannot play.

const TILE_WAIT = 4000, FRAME_WAIT = 400, LIGHT = 40; // ms; of 255: a frame that tells something has a pixel as bright

// The next frame that a video shows; browsers that do not tell of frames, and hidden pages, wait a moment.
function nextFrame(video) {
  return new Promise((done) => {
    setTimeout(done, FRAME_WAIT);
    if (video.requestVideoFrameCallback) video.requestVideoFrameCallback(done);
  });
}

function seekTo(video, time) {
  const shown = nextFrame(video);
  return new Promise((done) => {
    setTimeout(done, TILE_WAIT);
    video.addEventListener('seeked', () => shown.then(done), {once: true});
    video.currentTime = time;
  });
}

// The largest value of a small copy.
function brightest(video) {
  const context = makeCanvas(16, 16).getContext('2d', {willReadFrequently: true});
  context.drawImage(video, 0, 0, 16, 16);
  return context.getImageData(0, 0, 16, 16).data.reduce((most, value, i) => i % 4 < 3 ? Math.max(most, value) : most, 0);
}

// Draws a frame that is not black, if there is one: films often begin so. A stream is waited for, a film is looked through in
// a player of its own.
async function filmTile(content, draw) {
  const {video} = content;
  if (content.kind) {
    for (let i = 0; i < 10; i++) {
      await nextFrame(video);
      draw(content);
      if (brightest(video) > LIGHT) return;
    }
    return;
  }
  const own = await loadVideo(Object.assign(document.createElement('video'), {src: video.src, muted: true}), content.name);
  const long = Number.isFinite(own.duration) ? own.duration : 0, looked = new VideoContent(content.name, own, () => {});
  let most = -1;
  for (const share of [0.02, 0.1, 0.25, 0.5, 0.75]) {
    await seekTo(own, share * (long || 4));
    const light = brightest(own);
    if (light > most) most = light, draw(looked);
    if (light > LIGHT) break;
  }
  own.removeAttribute('src'), own.load();
}

// --- What a film is made of. ---

const CODECS = [
  [/^ap(ch|cn|cs|co|4h|4x)$|^V_PRORES/, 'ProRes'], [/^(hvc1|hev1|dvh1|dvhe)$|^V_MPEGH|^(HEVC|H265)$/i, 'HEVC (H.265)'], [/^Hap[1-7AHMY]$/, 'HAP'], [/^AVd[nh1]$/, 'DNxHD'],
  [/^CFHD$/, 'CineForm'], [/^(av01)$|^V_AV1/, 'AV1'], [/^avc[1-4]$|^V_MPEG4.ISO.AVC|^H264$/i, 'H.264 in a form that it does not know'], [/^(v210|2vuy|yuv2|raw )$/i, 'uncompressed video'],
  [/^(jpeg|mjp[2ab]|MJPG)$/i, 'Motion JPEG'], [/^(dv|xd|mx)\w\w$/i, 'DV or XDCAM'], [/^rle $/, 'Animation'], [/^png $/, 'PNG frames'], [/^(mp4v|DIVX|XVID|DX50|FMP4)$|^V_MPEG4/i, 'MPEG-4 part 2'],
  [/^V_MPEG[12]$|^mpg[12]$/i, 'MPEG-2'],
];
const ALPHA = /^(ap4[hx]|Hap[5MA])$/, MOOV_MAX = 1 << 26;

const latin = (bytes) => { let text = ''; for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192)); return text; };

// The box of that name in a QuickTime or MP4 file, as bytes; null: there is none.
async function topBox(file, name) {
  for (let at = 0, i = 0; at + 16 <= file.size && i < 1000; i++) {
    const view = new DataView(await file.slice(at, at + 16).arrayBuffer()), kind = latin(new Uint8Array(view.buffer, 4, 4));
    const short = view.getUint32(0), size = short === 1 ? Number(view.getBigUint64(8)) : short || file.size - at;
    if (kind === name) return size > MOOV_MAX ? null : new Uint8Array(await file.slice(at, at + size).arrayBuffer());
    if (size < 8 || !/^[\w ]{4}$/.test(kind)) return null;
    at += size;
  }
  return null;
}

// The code that the file gives its video: of a track's sample description, of an AVI's header, of Matroska's tracks.
async function codeOfFilm(file) {
  const head = latin(new Uint8Array(await file.slice(0, HEAD).arrayBuffer()));
  if (head.startsWith('RIFF')) return (/vids(....)/s.exec(head) || [])[1];
  if (head.startsWith('\x1aE\xdf\xa3')) return (/V_[A-Z0-9_/]+/.exec(head) || [])[0];
  const moov = await topBox(file, 'moov'), text = moov ? latin(moov) : '';
  return [...text.matchAll(/stsd.{12}(....)/gs)].map(([, code]) => code).find((code) => CODECS.some(([pattern]) => pattern.test(code)));
}

// Why a browser does not play a film, and the line that makes one that it does.
async function refusalOf(file, name) {
  const code = await codeOfFilm(file).catch(() => undefined), [, codec] = (code && CODECS.find(([pattern]) => pattern.test(code))) || [];
  if (!code) return new Message(`This browser cannot play ${name}.`);
  const quoted = (text) => `"${text.replace(/["\\$`]/g, '_')}"`, stem = name.replace(/\.[^.]*$/, '');
  const how = ALPHA.test(code) ? `-c:v libvpx-vp9 -pix_fmt yuva420p -crf 18 -b:v 0 ${quoted(`${stem}-page.webm`)}` : `-c:v libx264 -pix_fmt yuv420p -crf 16 -c:a aac ${quoted(`${stem}-page.mp4`)}`;
  return Object.assign(new Message(`${name} is ${codec || code.trim()}, which this browser cannot play. In a terminal: ffmpeg -i ${quoted(name)} ${how}`), {stays: true});
}
