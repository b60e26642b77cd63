'use strict';
// The window on the projector: shows each pattern pixel for pixel, and says so when it is on the screen.

const canvas = document.querySelector('canvas'), hint = document.querySelector('p');
const place = location.protocol.startsWith('http') ? location.pathname.replace(/[^/]*$/, '') : '';
const wire = new Wire(`studio ${place}${window.name.split('-').pop() || 1}`, hear);
const painted = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));

// The window's size in the display's own pixels.
const panel = () => [Math.round(innerWidth * devicePixelRatio), Math.round(innerHeight * devicePixelRatio)];

const tell = (more) => wire.post({from: 'projector', panel: panel(), ...more});

async function show(id, picture) {
  const image = await createImageBitmap(picture);
  canvas.width = image.width, canvas.height = image.height;
  canvas.style.width = image.width / devicePixelRatio + 'px', canvas.style.height = image.height / devicePixelRatio + 'px';
  canvas.getContext('2d', {alpha: false}).drawImage(image, 0, 0);
  hint.hidden = true;
  await painted();
  tell({id, shown: [image.width, image.height]});
}

async function fill(id, colour) {
  const context = canvas.getContext('2d', {alpha: false});
  context.fillStyle = colour;
  context.fillRect(0, 0, canvas.width, canvas.height);
  await painted();
  tell({id, shown: [canvas.width, canvas.height]});
}

function fullScreen() {
  if (document.fullscreenElement) document.exitFullscreen();
  else document.documentElement.requestFullscreen().catch(() => {});
}

function hear(data) {
  if (data.from !== 'studio') return;
  if (data.image) show(data.id, data.image).catch((error) => tell({id: data.id, failed: String(error)}));
  else if (data.colour) fill(data.id, data.colour);
  else tell({});
}
document.addEventListener('click', fullScreen);
document.addEventListener('keydown', (event) => { if (event.key === 'f' || event.key === 'F') fullScreen(); });
addEventListener('resize', () => tell({}));
addEventListener('pagehide', () => tell({closed: true}));
stayAwake();
tell({});
