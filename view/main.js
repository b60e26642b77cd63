'use strict';
const TESTING = true;
async function start() {
  const scene = readScene();
  const canvas = document.getElementById('stage');
  const graphics = new Graphics(canvas);
  const renderer = new Renderer(graphics, scene);
  const view = scene.views[0];
  const projector = {device: view.projector, brightness: 1};
  projector.pattern = new PatternTexture(graphics, view.projector.width, view.projector.height);
  window.viewer = {scene, renderer, async draw(id, pattern, width, height) {
    const v = scene.views.find((x) => x.id === id);
    projector.device = v.projector;
    const bitmap = await readPicture(scene, scene.patterns.find((p) => p.name === pattern));
    const c = document.createElement('canvas'); c.width = projector.device.width; c.height = projector.device.height;
    c.getContext('2d').drawImage(bitmap, 0, 0, c.width, c.height);
    projector.pattern.set(c);
    const t0 = performance.now();
    const bytes = renderer.picture(fitDevice(v.camera, width, height), scene.drawing.samples, [projector], true, 1);
    window.viewer.ms = performance.now() - t0;
    let s = '';
    for (let i = 0; i < bytes.length; i += 8192) s += String.fromCharCode(...bytes.subarray(i, i + 8192));
    return btoa(s);
  }};
}
window.ready = start().then(() => 'ready');
