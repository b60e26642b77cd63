'use strict';
// A projector's window: moved to the real projector and made full screen there, it shows the picture for it.

// Tells which projector this is, where its picture ends and whether its pixels are the screen's: a frame one pixel wide, a
// field of single pixels, a grid, the number and the size.
function drawTest(context, width, height, projector) {
  const step = Math.max(16, Math.round(height / 12)), middle = [width / 2, height / 2];
  context.fillStyle = '#000', context.fillRect(0, 0, width, height);
  context.fillStyle = '#666';
  for (let x = step; x < width; x += step) context.fillRect(x, 0, 1, height);
  for (let y = step; y < height; y += step) context.fillRect(0, y, width, 1);
  context.fillStyle = '#fff';
  for (const [x, y, w, h] of [[0, 0, width, 1], [0, height - 1, width, 1], [0, 0, 1, height], [width - 1, 0, 1, height]]) context.fillRect(x, y, w, h);
  for (let y = step; y < 2 * step; y++)
    for (let x = step + y % 2; x < 2 * step; x += 2) context.fillRect(x, y, 1, 1);
  context.fillStyle = projector.colour, context.textAlign = 'center', context.textBaseline = 'middle';
  context.font = `700 ${4 * step}px system-ui, sans-serif`;
  context.fillText(projector.number, ...middle);
  context.font = `${step / 2}px system-ui, sans-serif`;
  context.fillText(`${width} × ${height}`, middle[0], middle[1] + 2.5 * step);
}

const showWindows = (app) => app.projectors.forEach((projector) => projector.window.show());

// Blackout of all projector windows, and back: the show goes on behind it.
function blackout(app, on = !app.dark) {
  app.dark = on;
  say(on ? 'Blackout: the projector windows are black until you press . or Blackout again.' : 'The projector windows show their pictures again.');
  app.changed('windows');
  showWindows(app);
}

// The test picture in place of the content, and back.
function testPicture(app) {
  app.test = !app.test;
  app.changed('windows');
  if (!app.projectors.some((projector) => projector.window.isOpen)) say('The test picture appears in the projector windows, none of which is open yet.');
  showWindows(app);
}

class ProjectorWindow {
  constructor(app, projector) {
    this.app = app, this.projector = projector;
    this.kept = {};
    this.window = null;
    this.where = null; // {left, top, width, height, full}: the window's place, to which it comes back
  }

  get isOpen() { return !!this.window && !this.window.closed; }

  async open() {
    if (!this.isOpen) {
      const {left, top, width = 800, height = 600, full} = this.where || {};
      // other screens are open to pages that may know of them
      if (this.where && screen.isExtended && window.getScreenDetails) await getScreenDetails().catch(() => {});
      this.window = window.open('', '', `popup,width=${width},height=${height}${this.where ? `,left=${left},top=${top}` : ''}`);
      if (!this.window) throw new Message('The browser blocked the projector window: allow this page to open windows.');
      this.furnish(this.window.document, full);
    }
    this.show();
  }

  // Where the window is; one that fills its screen keeps the size that it had.
  notePlace() {
    const {screenX: left, screenY: top, innerWidth, innerHeight, document: {fullscreenElement}} = this.window, {width, height} = this.where || {};
    this.where = {left, top, ...(fullscreenElement ? {width: width || 800, height: height || 600} : {width: innerWidth, height: innerHeight}), full: !!fullscreenElement};
  }

  furnish(page, full) {
    page.title = `Projector ${this.projector.number}`;
    page.body.style.cssText = 'margin:0;background:#000;height:100vh;overflow:hidden;cursor:none';
    this.canvas = page.createElement('canvas');
    const hint = page.createElement('p');
    hint.textContent = full ? 'Click this window, or press F: full screen again.' : 'Move this window to the projector, then click it, or press F: full screen.';
    hint.style.cssText = 'position:fixed;left:0;right:0;bottom:8vh;margin:auto;text-align:center;color:#fff;' +
                         'font:16px system-ui;text-shadow:0 0 6px #000;pointer-events:none';
    page.body.replaceChildren(this.canvas, hint);
    const fill = () => {
      hint.remove();
      if (page.fullscreenElement) page.exitFullscreen(); else page.documentElement.requestFullscreen().catch(() => {});
    };
    this.window.addEventListener('resize', () => {
      this.notePlace();
      this.place();
    });
    this.window.addEventListener('pagehide', () => {
      this.notePlace();
      if (this.app.store) this.app.store.soon();
      if (this.app.projectors.includes(this.projector)) say('The projector window was closed. Press W: it comes back where it was.');
    });
    page.addEventListener('click', fill);
    if (full) page.documentElement.requestFullscreen().then(() => hint.remove(), () => {}); // some browsers ask for a click
    page.addEventListener('keydown', (event) => {
      if (event.key === 'f' || event.key === 'F') fill();
      if ((event.key === ' ' || event.key === 'Enter') && !event.repeat) go(this.app);
      if (event.key === '.') blackout(this.app);
      if (event.key === 't' || event.key === 'T') testPicture(this.app);
    });
  }

  // A panel's picture lies pixel on pixel, whatever the screen's scale, where the window has room for it; otherwise, as a
  // pattern for no known panel always, it fills the window.
  place() {
    const {width, height} = this.canvas, {devicePixelRatio: ratio, innerWidth, innerHeight} = this.window, pixel = 1 / ratio;
    const exact = !!this.app.scene.panel && width <= (innerWidth + 1) * ratio && height <= (innerHeight + 1) * ratio;
    const middle = (free, side) => Math.max(0, Math.floor((free * ratio - side) / 2)) * pixel;
    this.canvas.style.cssText = 'display:block;position:absolute;' + (exact
      ? `left:${middle(innerWidth, width)}px;top:${middle(innerHeight, height)}px;width:${width * pixel}px;height:${height * pixel}px;image-rendering:pixelated`
      : 'left:0;top:0;width:100vw;height:100vh;object-fit:contain');
  }

  // After the projector's pattern has changed.
  show() {
    this.stale = false;
    if (!this.isOpen) return;
    const {app: {dark, test}} = this;
    const {width, height, data} = panelPicture(this.app.graphics, this.projector, this.app.scene.panel, this.kept);
    if (this.canvas.width !== width || this.canvas.height !== height)
      this.canvas.width = width, this.canvas.height = height;
    this.place();
    const context = this.canvas.getContext('2d');
    if (dark || !(this.projector.on || test)) context.clearRect(0, 0, width, height);
    else if (test) drawTest(context, width, height, this.projector);
    else context.putImageData(new ImageData(data, width, height), 0, 0);
  }

  close() { if (this.isOpen) this.window.close(); }
}
