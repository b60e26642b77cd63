'use strict';
// A projector of the scene: where it is, the layers it shows, and the paint on top of them. These are either
// the pattern itself, or a target in a camera's frame for which the pattern is found (compensate.js). A pattern is at least
// as fine as the real projector's panel, where the scene has one.

const PATTERN_MAX = 1 << 24; // pixels

const PROJECTOR_COLOURS = ['#f5a524', '#3aa0ff', '#e0569b', '#45c46b', '#9d7bff', '#ff6b4a', '#18b8b0', '#c9c239'];

function makeCanvas(width, height) {
  const canvas = document.createElement('canvas');
  canvas.width = width, canvas.height = height;
  return canvas;
}

// The pattern's size: the device's, or larger by as much as a panel (none: null) is finer.
function patternSize(device, panel, sideMax) {
  const {width, height} = device, finer = panel ? Math.max(panel.fx / device.fx, panel.fy / device.fy, 1) : 1;
  const most = Math.max(1, Math.min(Math.sqrt(PATTERN_MAX / (width * height)), sideMax / Math.max(width, height)));
  return [width, height].map((side) => Math.round(side * Math.min(finer, most)));
}

// A panel of which a person knows the pixels alone: the pattern lies in its middle, as large as there is room.
function panelOfPixels({width, height, fx, fy, cx, cy}, [w, h]) {
  const s = Math.min(w / width, h / height);
  return {width: w, height: h, fx: fx * s, fy: fy * s, cx: w / 2 + (cx - width / 2) * s, cy: h / 2 + (cy - height / 2) * s};
}

class Projector {
  constructor(graphics, device, panel, number) {
    this.graphics = graphics;
    this.known = panel;  // the capture's, or null
    this.found = null;   // as setFound has it
    this.pixels = null;  // [width, height] of the panel, if a person gave them
    this.number = number;
    this.colour = PROJECTOR_COLOURS[(number - 1) % PROJECTOR_COLOURS.length];
    this.device = device;
    this.spread = (panel && panel.spread) || null; // {share, deviation}: of what it sends, pixels of its device
    this.on = true;
    this.stops = 0; // brightness, in doublings of the capture's
    this.layers = [new Layer(new TestContent('White'))];
    this.at = 0;       // the layer that is selected
    this.fade = null;  // {from: the layers before, seconds, began, still: the pattern before, where it was corrected otherwise}
    this.asked = 0; // number of requests to show content, so that a late one is not shown
    this.correction = 'none'; // 'paint' and 'colours': see compensate.js
    this.watcher = 'now';     // the viewpoint that a correction is for: 'now' or a view's number from 0
    this.gain = 0;            // of a target's light, in doublings
    this.painted = false;
    this.paintVersion = 0; // counts its changes
    this.maps = {}; // of a correction
    this.measure();
    this.pulls = []; // of a nudge
    this.dirty = true;
  }

  // The real projector's: {width, height, fx, fy, cx, cy ..}; null: nothing is known of it.
  get panel() { return this.pixels && !this.known ? panelOfPixels(this.original || this.device, this.pixels) : this.known; }

  // A place and lens that were measured, {width, height, fx, fy, cx, cy, pose}: its panel is its own; null: the capture's is.
  setFound(found, panel) {
    if (JSON.stringify(found) === JSON.stringify(this.found)) return;
    this.found = this.original = found, this.known = found || panel;
    this.spread = found ? null : (panel && panel.spread) || null;
    if (found) this.device = {...found};
    this.measure();
  }

  setPixels(pixels) {
    if (JSON.stringify(pixels) === JSON.stringify(this.pixels)) return;
    this.pixels = pixels;
    this.measure();
  }

  // Canvases and textures of the pattern's size; paint is kept.
  measure() {
    const size = patternSize(this.device, this.panel, this.graphics.sideMax), {paint} = this;
    if (this.canvas && this.canvas.width === size[0] && this.canvas.height === size[1]) return;
    this.canvas = makeCanvas(...size);
    this.context = this.canvas.getContext('2d', {alpha: false});
    this.paint = makeCanvas(...size);
    if (paint) this.paint.getContext('2d').drawImage(paint, 0, 0, size[0], size[1]), this.paintVersion++;
    this.endFade();
    this.freeMaps();
    if (this.pattern) this.pattern.free();
    this.pattern = new PatternTexture(this.graphics, ...size);
    this.patternKey = this.spreadKey = '';
    this.dirty = true;
  }

  // True if its light spreads on the way: that of the capture's projector does, and the capture's own patterns hold it.
  get spreads() {
    return !!this.spread && (this.corrected || this.painted || !this.sources.every((source) => source.pattern !== undefined));
  }

  // The device with the pattern's pixels.
  get grid() { return scaleDevice(this.device, this.canvas.width, this.canvas.height); }
  get brightness() { return 2 ** this.stops; }
  get corrected() { return this.correction !== 'none'; }

  get layer() { return this.layers[this.at]; }
  get content() { return this.layer.source; }
  get sources() { return [...this.layers, ...(this.fade ? this.fade.from : [])].map((layer) => layer.source); }
  get live() { return !!this.fade || this.layers.some((layer) => layer.source.live); }
  // True if what it shows depends on where it is, whether it is corrected or not.
  get isOnObject() { return this.layers.some(({on, source}) => on !== null || source instanceof EffectContent); }

  // True if it shows a pattern of the capture and nothing else.
  showsPattern(index) {
    const {layers: [layer, ...others], fade} = this, plain = JSON.stringify(layer.place) === JSON.stringify(newPlace());
    return !others.length && !fade && plain && layer.on === null && layer.source.pattern === index;
  }

  // The sources that are not shown afterwards are returned.
  change(work) {
    const before = this.sources;
    work();
    this.at = clamp(this.at, 0, this.layers.length - 1);
    this.asked++;
    this.dirty = true;
    return before.filter((source) => !this.sources.includes(source));
  }

  // Layers instead of those there are, faded in within some seconds, from the pattern as it is now if it is to be a `still`; a
  // fade that is cut short goes on from its end.
  setLayers(layers, seconds = 0, still = false) {
    const kept = seconds > 0 && still ? new PatternTexture(this.graphics, this.pattern.width, this.pattern.height) : null;
    if (kept) kept.lay(this.pattern, 1);
    this.endFade();
    return this.change(() => {
      this.fade = seconds > 0 ? {from: this.layers, seconds, began: performance.now(), still: kept} : null;
      this.layers = layers;
    });
  }

  endFade() {
    if (this.fade && this.fade.still) this.fade.still.free();
    this.fade = null;
  }

  get share() { return clamp((performance.now() - this.fade.began) / (1000 * this.fade.seconds), 0, 1); }

  // The layers over an empty canvas, for this device's frame. In a fade both are drawn in full and added up by their shares, as
  // video mixers do.
  draw(context, width, height, device = this.device) {
    if (!this.fade || this.fade.still) return drawLayers(this.graphics, context, this.layers, width, height, this.relief, device);
    const {share} = this;
    for (const [layers, part] of [[this.fade.from, 1 - share], [this.layers, share]]) {
      const own = scratch('fade', width, height);
      drawLayers(this.graphics, own, layers, width, height, this.relief, device, part);
      context.save();
      context.globalCompositeOperation = 'lighter', context.globalAlpha = part;
      context.drawImage(own.canvas, 0, 0);
      context.restore();
    }
  }

  // Draws the uncorrected pattern; with a correction, only the paint is uncorrected.
  drawPattern() {
    const {context, canvas} = this;
    context.fillStyle = '#000';
    context.fillRect(0, 0, canvas.width, canvas.height);
    this.draw(context, canvas.width, canvas.height);
    if (this.painted) context.drawImage(this.paint, 0, 0);
    this.pattern.set(canvas);
  }

  // A dab of the brush at a pattern position; without a colour it erases.
  dab(u, v, radius, colour) {
    const context = this.paint.getContext('2d');
    context.globalCompositeOperation = colour ? 'source-over' : 'destination-out';
    context.fillStyle = colour || '#000';
    context.beginPath();
    context.arc(u, v, Math.max(radius, 0.5), 0, 2 * Math.PI);
    context.fill();
    this.painted = this.dirty = true;
    this.paintVersion++;
  }

  clearPaint() {
    this.paint.getContext('2d').clearRect(0, 0, this.paint.width, this.paint.height);
    this.painted = false, this.dirty = true;
    this.paintVersion++;
  }

  // The lens: a change of focal length about the pattern's principal point.
  zoom(factor) {
    const d = this.device, f = clamp(d.fx * factor, 0.15 * d.width, 20 * d.width) / d.fx;
    this.device = {...d, fx: d.fx * f, fy: d.fy * f};
  }

  freeMaps() {
    for (const maps of Object.values(this.maps)) maps.free();
    this.maps = {};
  }

  free() {
    this.endFade();
    this.pattern.free();
    this.freeMaps();
    if (this.feather) this.feather.free();
    for (const target of [this.shadow, this.wide, this.level]) this.graphics.free(target);
  }
}
