'use strict';
// The projector window: a second window, moved to the real projector and made full screen there, that shows
// the picture for it.

class ProjectorWindow {
  constructor(app) {
    this.app = app;
    this.kept = {};
    this.window = null;
    this.projector = null;
    this.dark = false;
    addEventListener('pagehide', () => this.close());
    document.addEventListener('visibilitychange', () => app.reschedule());
  }

  get isOpen() { return !!this.window && !this.window.closed; }

  open(projector) {
    this.projector = projector;
    if (!this.isOpen) {
      this.window = window.open('', '', 'popup,width=800,height=600');
      if (!this.window) throw new Message('The browser blocked the projector window: allow this page to open windows.');
      this.furnish(this.window.document);
    }
    this.show();
  }

  furnish(page) {
    page.title = 'Projector';
    page.body.style.cssText = 'margin:0;background:#000;height:100vh;overflow:hidden;cursor:none';
    this.canvas = page.createElement('canvas');
    const hint = page.createElement('p');
    hint.textContent = 'Move this window to the projector, then click it, or press F: full screen.';
    hint.style.cssText = 'position:fixed;left:0;right:0;bottom:8vh;margin:auto;text-align:center;color:#fff;' +
                         'font:16px system-ui;text-shadow:0 0 6px #000;pointer-events:none';
    page.body.replaceChildren(this.canvas, hint);
    const full = () => {
      hint.remove();
      if (page.fullscreenElement) page.exitFullscreen(); else page.documentElement.requestFullscreen().catch(() => {});
    };
    this.window.addEventListener('resize', () => this.place());
    page.addEventListener('click', full);
    page.addEventListener('keydown', (event) => {
      if (event.key === 'f' || event.key === 'F') full();
      if (event.key === '.') this.black();
    });
  }

  // Blackout, and back: the show goes on behind it.
  black() {
    this.dark = !this.dark;
    if (this.dark) say('Blackout: the projector window is black until you press . again.');
    else say('The projector window shows its picture again.');
    this.show();
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
    if (!this.isOpen || !this.projector) return;
    if (!this.app.projectors.includes(this.projector)) this.projector = this.app.projectors[0];
    if (!this.projector) return;
    const {width, height, data} = panelPicture(this.app.graphics, this.projector, this.app.scene.panel, this.kept);
    if (this.canvas.width !== width || this.canvas.height !== height)
      this.canvas.width = width, this.canvas.height = height;
    this.place();
    if (this.projector.on && !this.dark) this.canvas.getContext('2d').putImageData(new ImageData(data, width, height), 0, 0);
    else this.canvas.getContext('2d').clearRect(0, 0, width, height);
  }

  close() { if (this.isOpen) this.window.close(); }
}
