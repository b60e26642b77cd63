'use strict';
// The projector window: a second window, moved to the real projector and made full screen there, that shows
// the picture for it.

class ProjectorWindow {
  constructor(app) {
    this.app = app;
    this.kept = {};
    this.window = null;
    this.projector = null;
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
    this.canvas.style.cssText = 'display:block;width:100vw;height:100vh;object-fit:contain';
    const hint = page.createElement('p');
    hint.textContent = 'Move this window to the projector, then click it, or press F: full screen.';
    hint.style.cssText = 'position:fixed;left:0;right:0;bottom:8vh;margin:auto;text-align:center;color:#fff;' +
                         'font:16px system-ui;text-shadow:0 0 6px #000;pointer-events:none';
    page.body.replaceChildren(this.canvas, hint);
    const full = () => {
      hint.remove();
      if (page.fullscreenElement) page.exitFullscreen(); else page.documentElement.requestFullscreen().catch(() => {});
    };
    page.addEventListener('click', full);
    page.addEventListener('keydown', (event) => { if (event.key === 'f' || event.key === 'F') full(); });
  }

  // After the projector's pattern has changed.
  show() {
    if (!this.isOpen || !this.projector) return;
    if (!this.app.projectors.includes(this.projector)) this.projector = this.app.projectors[0];
    if (!this.projector) return;
    const {width, height, data} = panelPicture(this.app.graphics, this.projector, this.app.scene.panel, this.kept);
    if (this.canvas.width !== width || this.canvas.height !== height)
      this.canvas.width = width, this.canvas.height = height;
    if (this.projector.on) this.canvas.getContext('2d').putImageData(new ImageData(data, width, height), 0, 0);
    else this.canvas.getContext('2d').clearRect(0, 0, width, height);
  }

  close() { if (this.isOpen) this.window.close(); }
}
