'use strict';
// Messages between the page and its projector windows, and such a window itself: this same file, opened with
// #projector-NUMBER-ID behind its address. It shares nothing with the page but messages, and most browsers give it a process of
// its own, so that its picture stays whatever becomes of the page.

const WINDOW_PLACE = /^#projector-([0-9]+)-([0-9a-z]+)$/.exec(location.hash);
const WIRE = 'ffprocams projector windows';

const ORPHANED = 2500, BECOME = 600; // ms: without a word of the page; from the picture kept to that of a page that is back

// A projector's window. The page that `owns` it is the only one whose pictures it takes.
class FarWindow {
  constructor(number, id) {
    Object.assign(this, {number, id, owner: null, heard: -ORPHANED, armed: false, full: false, dark: false, exact: false, met: false, closing: false});
    window.stop(); // the rest of this file is the page's
    document.title = `Projector ${number}`;
    const body = document.body || document.documentElement.appendChild(document.createElement('body'));
    document.documentElement.style.background = '#000';
    body.style.cssText = 'margin:0;background:#000;height:100vh;overflow:hidden;cursor:none';
    [this.canvas, this.kept, this.hint] = ['canvas', 'canvas', 'p'].map((tag) => document.createElement(tag));
    this.hint.style.cssText = 'position:fixed;left:0;right:0;bottom:8vh;margin:auto;text-align:center;color:#fff;font:16px system-ui;text-shadow:0 0 6px #000;pointer-events:none';
    this.kept.hidden = true;
    body.replaceChildren(this.canvas, this.kept, this.hint);
    this.recall();
    this.wire = new Wire(WIRE, (message) => this.hear(message));
    this.listen();
    stayAwake();
    this.tell('here');
    setInterval(() => { if (performance.now() - this.heard > ORPHANED) this.tell('here'); }, 1000);
  }

  get fullScreen() { return !!document.fullscreenElement; }

  // In software, which a graphics driver that fails does not take away.
  context(canvas = this.canvas) { return canvas.getContext('2d', {alpha: false, willReadFrequently: true}); }

  tell(is, more = {}) {
    const {id, number, owner} = this, size = {width: innerWidth, height: innerHeight};
    this.wire.post({window: id, number, owner, is, place: {left: screenX, top: screenY, ...size, full: this.fullScreen}, ...more});
  }

  hear(message) {
    const {is, to, from} = message;
    if (message.window || (to !== '*' && to !== this.id)) return;
    if (is === 'who') return this.tell('here');
    if (is === 'claim') Object.assign(this, {owner: from, met: false});
    if (from !== this.owner) return;
    this.heard = performance.now();
    if (is === 'ping') this.tell('pong');
    if (is === 'claim' || is === 'state') this.setState(message);
    if (is === 'picture') this.take(message);
    if (is === 'tick') requestAnimationFrame(() => this.tell('tick'));
    if (is === 'close') {
      this.closing = true;
      this.tell('bye');
      window.close();
    }
  }

  setState({armed, dark, full}) {
    Object.assign(this, {armed, dark});
    document.body.style.visibility = dark ? 'hidden' : 'visible'; // its ground stays black
    this.tellHint(full);
  }

  // For whoever moves it to the projector; never over a show or a blackout.
  tellHint(again = this.again) {
    this.again = again;
    this.hint.textContent = again ? 'Click this window, or press F: full screen again.' : 'Move this window to the projector, then click it, or press F: full screen.';
    this.hint.hidden = this.armed || this.wasFull || !this.owner;
  }

  // The first picture of a page that is back takes the place of the one that was kept by and by.
  take({width, height, bytes, exact}) {
    const {canvas, kept} = this, returns = !this.met && this.drawn && canvas.width === width && canvas.height === height;
    this.met = true;
    if (returns) {
      kept.width = width, kept.height = height;
      this.context(kept).drawImage(canvas, 0, 0);
      kept.hidden = false;
      kept.animate([{opacity: 1}, {opacity: 0}], BECOME).onfinish = () => { kept.hidden = true; };
    }
    if (canvas.width !== width || canvas.height !== height) canvas.width = width, canvas.height = height;
    if (bytes) this.context().putImageData(new ImageData(new Uint8ClampedArray(bytes), width, height), 0, 0);
    else this.context().fillRect(0, 0, width, height);
    this.exact = exact, this.drawn = true;
    this.place();
    this.tell('drawn');
  }

  // A panel's picture lies pixel on pixel, whatever the screen's scale, where the window has room for it; otherwise, as a
  // pattern for no known panel always, it fills the window.
  place() {
    const {width, height} = this.canvas, ratio = devicePixelRatio, pixel = 1 / ratio;
    const exact = this.exact && width <= (innerWidth + 1) * ratio && height <= (innerHeight + 1) * ratio;
    const middle = (free, side) => Math.max(0, Math.floor((free * ratio - side) / 2)) * pixel;
    for (const canvas of [this.canvas, this.kept])
      canvas.style.cssText = 'position:absolute;' + (exact
        ? `left:${middle(innerWidth, width)}px;top:${middle(innerHeight, height)}px;width:${width * pixel}px;height:${height * pixel}px;image-rendering:pixelated`
        : 'left:0;top:0;width:100vw;height:100vh;object-fit:contain');
  }

  // The last picture outlives a reload of this window.
  remember() {
    const {width, height} = this.canvas, data = this.drawn ? [this.canvas.toDataURL(), this.canvas.toDataURL('image/jpeg', 0.95)] : [];
    for (const picture of data) { // the second if the first is too long
      try {
        sessionStorage.setItem(WIRE, JSON.stringify({width, height, picture, exact: this.exact, dark: this.dark}));
        return;
      } catch {
        // told by what follows: the window stays black until the page answers
      }
    }
  }

  recall() {
    const {picture, ...told} = JSON.parse(sessionStorage.getItem(WIRE) || '{}'), image = new Image();
    if (!picture) return;
    document.body.style.visibility = told.dark ? 'hidden' : 'visible';
    image.onload = () => {
      if (this.drawn) return; // the page was faster
      Object.assign(this.canvas, {width: told.width, height: told.height});
      this.context().drawImage(image, 0, 0);
      this.exact = told.exact, this.drawn = true;
      this.place();
    };
    image.src = picture;
  }

  // While a show is armed this only enters full screen.
  fill() {
    if (this.fullScreen && !this.armed) return document.exitFullscreen();
    if (!this.fullScreen) document.documentElement.requestFullscreen().then(() => this.held(), () => {});
  }

  // Browsers that can give Escape and those keys that close and reload to the page, while it fills the screen.
  held() {
    if (navigator.keyboard && navigator.keyboard.lock) navigator.keyboard.lock(['Escape', 'F5', 'F11', 'KeyR', 'KeyW']).catch(() => {});
  }

  listen() {
    addEventListener('resize', () => { this.place(); this.tell('place'); });
    document.addEventListener('fullscreenchange', () => { this.wasFull ||= this.fullScreen; this.tellHint(); this.tell('place'); });
    addEventListener('beforeunload', (event) => { if (this.armed && !this.closing) event.preventDefault(); }); // the browser asks
    addEventListener('pagehide', () => { this.tell('bye'); this.remember(); }); // a browser may not wait for the second
    for (const name of ['contextmenu', 'dragover', 'drop', 'selectstart', 'auxclick']) addEventListener(name, (event) => event.preventDefault());
    addEventListener('wheel', (event) => event.preventDefault(), {passive: false});
    addEventListener('drop', () => this.tell('dropped'));
    addEventListener('click', () => this.fill());
    addEventListener('keydown', (event) => {
      if (this.armed) event.preventDefault();
      if (event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
      if (/^f$/i.test(event.key)) this.fill();
      else this.tell('key', {key: event.key});
    });
  }
}

if (WINDOW_PLACE) window.far = new FarWindow(Number(WINDOW_PLACE[1]), WINDOW_PLACE[2]);
