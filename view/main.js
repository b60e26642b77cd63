'use strict';
// The state of the page, and when it is drawn.

// Samples per side of a pixel and share of the resolution, from the best down; while things move, the page uses the
// best that is fast enough.
const QUALITIES = [{scale: 1, coarse: false}, {scale: 1, coarse: true}, {scale: 0.6, coarse: true}, {scale: 0.35, coarse: true}];
const SLOW = 55, FAST = 18; // milliseconds a frame
const DRIVER_FAILED = 'ffprocams graphics driver failed', BEGIN_AGAIN = 20000; // ms
const FILLED = 0.88;       // share of the free part that the view's frame takes
const OBJECT_SHARE = 0.42; // of the free height, while layers are placed in the projector's picture below

// The settings for comparison with a photograph: without anything that the camera did not see.
const NEUTRAL = {exposure: 0, ambient: true, map: null, black: 0}, NEUTRAL_PROJECTOR = {stops: 0, correction: 'none', painted: false};

// Puts values into an object and returns those that existed.
function exchange(object, values) {
  const before = Object.fromEntries(Object.keys(values).map((name) => [name, object[name]]));
  Object.assign(object, values);
  return before;
}

class App {
  constructor(scene, canvas, overlay) {
    this.scene = scene, this.canvas = canvas, this.overlay = overlay;
    this.graphics = new Graphics(canvas);
    this.renderer = new Renderer(this.graphics, scene);
    this.compensator = new Compensator(this.renderer);
    this.library = new Library(this);
    this.show = new Show(this);
    this.listeners = [];
    this.windows = new Windows(this);
    this.midi = new Midi(this);
    this.up = this.findUp();
    this.relief = new Relief(this.renderer, this.up);
    this.exposure = 0, this.ambient = true, this.map = null;
    this.black = 0;           // the share of their white that dark projectors give
    this.dark = this.test = false; // blackout and test picture of the projector windows
    this.mode = 'camera', this.frusta = true;
    this.brush = {colour: '#ffffff', size: 14, erase: false};
    this.projectors = [], this.projector = null, this.numbers = 0;
    this.photograph = null, this.comparisons = 0;
    this.quality = 1, this.lastChange = 0, this.pending = false;
    document.addEventListener('visibilitychange', () => this.reschedule());
    addEventListener('beforeunload', (event) => this.leave(event));
    canvas.addEventListener('webglcontextlost', (event) => {
      event.preventDefault();
      this.lost = true;
      this.beginAgain();
    });
  }

  // The cameras' own idea of up, on average.
  findUp() {
    const sum = this.scene.views.reduce((s, view) => sub3(s, axisOf(view.camera.pose, 1)), [0, 0, 0]);
    return length3(sum) > 0.1 ? normalise3(sum) : scale3(axisOf(this.scene.views[0].camera.pose, 1), -1);
  }

  // Refuses what changes the picture of a show by mistake, and why.
  inShow(why) { if (this.show.armed) throw new Message(`Armed: ${why}. Switch Armed off first.`); }

  // A show does not end by mistake: the browser asks first.
  leave(event) {
    if (this.store) this.store.keep();
    if (this.reloads || !(this.show.armed || this.windows.open.length)) return;
    event.preventDefault();
    event.returnValue = true; // browsers before 2024
  }

  // After the graphics driver has failed, once in a while; the projector windows keep their pictures meanwhile.
  async beginAgain() {
    say('The graphics driver stopped working. Reload the page to continue.', true);
    if (!this.store || this.fresh || Date.now() - Number(sessionStorage.getItem(DRIVER_FAILED) || 0) < BEGIN_AGAIN) return;
    sessionStorage.setItem(DRIVER_FAILED, Date.now());
    await this.store.keep();
    this.reloads = true;
    location.reload();
  }

  changed(what) { for (const listener of this.listeners) listener(what); }

  // --- The camera. ---

  jump(view, bring) {
    this.base = view.camera, this.pose = view.camera.pose, this.at = view;
    this.target = this.scene.centre;
    if (bring && this.projector && !this.projector.found) this.setProjectorPose(view.projector.pose, view.projector); // one that was measured stays
    this.invalidate(true);
    this.changed('view');
  }

  home() { this.jump(this.at || this.scene.views[0], false); }

  setCamera(pose) {
    this.pose = pose;
    this.endComparison();
    this.invalidate(true);
  }

  // By a drag of so many radians: around the object, or, in a whole scene, as if the picture were taken hold of.
  turn(across, over) {
    if (this.scene.whole) this.setCamera(lookAround(this.pose, this.up, across / 2, over / 2));
    else this.setCamera(orbit(this.pose, this.target, this.up, -across, -over));
  }

  // In a whole scene: so many radii forward and to the right, at the same height.
  walk(ahead, aside) {
    const level = (axis) => normalise3(sub3(axis, scale3(this.up, dot3(axis, this.up))));
    const right = level(axisOf(this.pose, 0)), forward = cross3(this.up, right), radius = this.scene.radius || 1;
    this.setCamera(movePose(this.pose, add3(scale3(forward, ahead * radius), scale3(right, aside * radius))));
  }

  // Closer to the object or farther from it; forward and back in a whole scene.
  dolly(factor) {
    if (this.scene.whole) return this.walk(-Math.log(factor), 0);
    const away = sub3(positionOf(this.pose), this.target), distance = length3(away), radius = this.scene.radius || 1;
    const next = clamp(distance * factor, 0.2 * radius, 40 * radius);
    this.setCamera(movePose(this.pose, scale3(away, next / distance - 1)));
  }

  pan(dx, dy) {
    const {whole} = this.scene, camera = this.screenCamera(), depth = whole ? this.scene.radius || 1 : length3(sub3(positionOf(this.pose), this.target));
    const by = add3(scale3(axisOf(this.pose, 0), -dx * depth / camera.fx), scale3(axisOf(this.pose, 1), -dy * depth / camera.fy));
    if (!whole) this.target = add3(this.target, by);
    this.setCamera(movePose(this.pose, by));
  }

  // The part of the window that the panel leaves free, CSS pixels.
  freeSize() {
    const [width, height] = this.windowSize();
    return [width, this.mode === 'place' ? height * OBJECT_SHARE : height]; // the projector's picture has the rest
  }

  // The part that the panel leaves free, with what lies flat in it.
  windowSize() {
    const panel = document.getElementById('panel'), shown = document.body.classList.contains('with-panel');
    if (!shown) return [innerWidth, innerHeight];
    // its final place: offsets ignore the transform that slides it in
    return innerWidth > 700 ? [Math.max(panel.offsetLeft, 80), innerHeight] : [innerWidth, Math.max(panel.offsetTop, 80)];
  }

  // The camera for the whole window, whose view is centred in the free part.
  cameraOf(ratio) {
    const [freeWidth, freeHeight] = this.freeSize();
    const fitted = fitDevice({...this.base, pose: this.pose}, freeWidth * ratio, freeHeight * ratio, FILLED);
    return {...fitted, width: Math.max(1, Math.round(innerWidth * ratio)), height: Math.max(1, Math.round(innerHeight * ratio))};
  }

  screenCamera() { return this.cameraOf(1); }

  // --- Projectors. ---

  // The selected projector's.
  get window() { return this.projector.window; }

  // Those that share the light of a corrected one where they overlap.
  partnersOf(projector) { return projector.on ? this.lit.filter((other) => other !== projector && other.corrected) : []; }

  // Beside a photograph only the projector that it was taken under shines.
  get lit() { return this.photograph ? [this.photograph.projector] : this.projectors.filter((projector) => projector.on); }

  addProjector() {
    const like = this.projector && !this.projector.found ? this.projector.device : (this.at || this.scene.views[0]).projector;
    const projector = new Projector(this.graphics, {...like}, this.scene.panel, ++this.numbers);
    projector.window = new ProjectorWindow(this, projector), projector.relief = this.relief;
    if (this.projectors.length) projector.device = {...like, pose: orbit(like.pose, this.scene.centre, this.up, 0.8, 0)};
    projector.original = (this.at || this.scene.views[0]).projector;
    this.projectors.push(projector);
    this.select(projector);
    this.invalidate();
    return projector;
  }

  // The projector that was measured at a view, where it shines with the first one; one that was measured before moves there.
  placeFound(view, device) {
    this.inShow('a projector would be moved');
    const known = this.projectors.find((projector) => projector.found);
    this.select(this.projectors.find((projector) => projector !== known) || this.addProjector());
    if (view) this.jump(view, true);
    const projector = known || this.addProjector();
    projector.setFound(device, this.scene.panel);
    projector.device = {...device};
    this.select(projector);
    this.invalidate(true);
    this.changed('device');
  }

  removeProjector() {
    if (this.projectors.length < 2) return;
    if (this.window.isOpen) this.inShow('this projector is in the show');
    const at = this.projectors.indexOf(this.projector);
    this.endComparison(this.projector);
    const [removed] = this.projectors.splice(at, 1);
    this.release(removed.sources);
    removed.window.close();
    removed.free();
    this.select(this.projectors[Math.min(at, this.projectors.length - 1)]);
    this.invalidate();
  }

  select(projector) {
    this.projector = projector;
    this.changed('projector');
    this.redrawOverlay();
  }

  setProjectorPose(pose, device = this.projector.device) {
    this.endComparison(this.projector);
    this.projector.pulls = [];
    this.projector.device = {...device, width: this.projector.device.width, height: this.projector.device.height, pose};
    if (device !== this.projector.device) this.projector.original = device;
    this.invalidate(true);
    this.changed('device');
  }

  // How near to the middle a projector may come: an object is solid, a whole scene is not.
  get nearest() { return (this.scene.whole ? 0.2 : 1.05) * (this.scene.radius || 1); }

  moveProjectorAway(factor) {
    const {pose} = this.projector.device, away = sub3(positionOf(pose), this.scene.centre), radius = this.scene.radius || 1;
    const next = clamp(length3(away) * factor, this.nearest, 30 * radius);
    this.setProjectorPose(movePose(pose, scale3(away, next / length3(away) - 1)));
  }

  zoomProjector(factor) {
    this.endComparison(this.projector);
    this.projector.zoom(factor);
    this.invalidate(true);
    this.changed('device');
  }

  // The source of a layer, the selected one unless another is given.
  setContent(content, projector = this.projector, layer = projector.layer) {
    const free = isFree(layer, content);
    this.reshow(projector, () => projector.change(() => {
      layer.source = content;
      if (free) putWhereSeen(this, projector, layer);
      if (content instanceof EffectContent) layer.place = unmoved(layer.place);
      projector.endFade();
    }));
  }

  // Layers instead of those that a projector has, faded in within some seconds.
  setLayers(layers, projector = this.projector, seconds = 0, still = false) { this.reshow(projector, () => projector.setLayers(layers, seconds, still)); }

  // `work` changes what a projector shows and returns the sources that it leaves.
  reshow(projector, work) {
    this.endComparison(projector);
    this.release(work());
    for (const source of projector.sources) this.watch(source, projector);
    this.invalidate();
    this.changed('content');
  }

  // Frees sources that no projector shows.
  release(sources) {
    for (const source of new Set(sources)) if (!this.projectors.some((p) => p.sources.includes(source))) source.free();
  }

  // After a layer was placed, by a hand if it is `moving`.
  placed(place, moving = true) {
    const {projector} = this;
    this.endComparison(projector);
    projector.layer.place = projector.content instanceof EffectContent ? unmoved(place) : place, projector.dirty = true;
    this.invalidate(moving);
    this.changed('layers');
  }

  // Fades that have come to their end leave what they led to.
  endFades() {
    for (const projector of this.projectors) {
      if (!projector.fade || projector.share < 1) continue;
      this.release(projector.setLayers(projector.layers));
      this.changed('content');
    }
  }

  // A film plays when it is shown, and a frame is drawn whenever it starts or stops.
  watch(content, projector) {
    if (!content.video) return;
    if (content.shared && content.video.paused) playVideo(content.video);
    if (content.watched && content.watched.has(projector)) return;
    (content.watched = content.watched || new Set()).add(projector);
    for (const event of ['play', 'pause', 'ended', 'seeked'])
      content.video.addEventListener(event, () => {
        if (!projector.sources.includes(content) || (event === 'seeked' && content.live)) return;
        projector.dirty = true;
        this.invalidate();
      });
  }

  // Shows content that is still being read or decoded, in the layer that is selected now; false if its projector has
  // received other content since then.
  async bring(promised, projector = this.projector) {
    const asked = ++projector.asked, {layer} = projector;
    let content = await promised;
    if (content && content.twin && projector.layers.some((other) => other !== layer && other.source === content)) content = await content.twin();
    if (!content) return false;
    await this.history.rest();
    if (asked === projector.asked && this.projectors.includes(projector)) {
      this.setContent(content, projector, layer);
      this.history.note();
      return true;
    }
    this.release([content]);
    return false;
  }

  // Dabs of the brush along a path on the screen, drawn into the projector's pattern at the surface below it.
  stroke(at, before) {
    const {projector, brush} = this, camera = this.renderer.view.camera;
    if (!projector || !camera) return;
    this.endComparison(projector);
    const ratio = camera.width / innerWidth, steps = before ? Math.max(1, Math.ceil(Math.hypot(at[0] - before[0], at[1] - before[1]) / (brush.size / 2))) : 1;
    for (let i = 1; i <= steps; i++) {
      const s = before ? i / steps : 1, from = before || at;
      const x = (from[0] + (at[0] - from[0]) * s) * ratio, y = (from[1] + (at[1] - from[1]) * s) * ratio;
      const depth = this.renderer.view.depthUnder(x, y);
      if (!depth) continue;
      const {grid} = projector, [u, v, far] = project(grid, pointAt(camera, x, y, depth));
      if (!(far > 0)) continue;
      const radius = brush.size * ratio * depth / camera.fx * grid.fx / far;
      projector.dab(u, v, radius, brush.erase ? null : brush.colour);
    }
    this.invalidate(true);
  }

  // A pull leads from where a projected point is to where it belongs: the real projector lights its beginning by the pixel
  // that the page had for its end.
  endPull() {
    const {projector, pull} = this, camera = this.renderer.view.camera;
    if (!projector || !pull || !camera || Math.hypot(pull[0][0] - pull[1][0], pull[0][1] - pull[1][1]) < 1) return;
    const ratio = camera.width / innerWidth, [from, to] = pull.map(([x, y]) => {
      const depth = this.renderer.view.depthUnder(x * ratio, y * ratio);
      return depth ? pointAt(camera, x * ratio, y * ratio, depth) : null;
    });
    if (!from || !to) return say('Pull from a place of the object to another one.');
    const {device} = projector, pulls = [...projector.pulls.slice(1 - PULLS_MAX), {point: from, pixel: project(device, to).slice(0, 2)}];
    const pose = poseOfPulls(device, pulls, length3(sub3(positionOf(device.pose), this.scene.centre)));
    if (!pose) return say('These pulls do not fit together; choose Nudge again to start over.');
    this.setProjectorPose(pose);
    projector.pulls = pulls;
    const miss = missOf(projector.device, pulls), left = 3 - pulls.length;
    say(left > 0 ? `The projector has turned; ${left === 1 ? 'one more pull finds' : 'two more pulls, far apart, find'} its whole pose.`
      : `The projector's pose is found from ${pulls.length} pulls${pulls.length > 3 ? `, with a mean error of ${miss.toFixed(1)} pixels` : ''}.`);
  }

  // --- Photographs. ---

  // The one that belongs to the view and what the projector shows; null: there is none.
  findPhotograph() {
    const view = this.at;
    if (!view || !view.photographs.length) return null;
    const shown = this.projector && this.projector.content.pattern;
    const found = view.photographs.filter((p) => p.size);
    return found.find((p) => p.pattern === shown) || found.find((p) => this.scene.patterns[p.pattern].role === 'white') || found[0] || null;
  }

  // The photograph beside the prediction, which is drawn as the photograph was taken: under one projector's
  // uncorrected pattern, without changes of light. The settings are restored afterwards.
  async showPhotograph(on) {
    if (on) this.inShow('the photograph would come onto the object');
    const entry = on ? this.findPhotograph() : null, {projector} = this;
    this.endComparison();
    if (on && !entry) say('There is no photograph of this view in the page. Jump to a captured view first.');
    else if (on && projector.found) return say('The photographs are of the first projector\u2019s light: choose that one.');
    if (!entry) return;
    this.jump(this.at, true);
    const asked = this.comparisons, shown = projector.showsPattern(entry.pattern);
    const content = shown ? null : await patternContent(this.scene, entry.pattern);
    const bitmap = await readPicture(this.scene, entry);
    if (asked !== this.comparisons) { // there was another request since then
      bitmap.close();
      if (content) content.free();
      return;
    }
    if (content) this.setLayers([new Layer(content)], projector);
    this.photograph = {entry, bitmap, projector, kept: exchange(this, NEUTRAL), keptThere: exchange(projector, NEUTRAL_PROJECTOR)};
    this.compared();
  }

  // Called when a condition changes under which the photograph was taken. With a projector: only if it is the one
  // that the photograph was taken under.
  endComparison(projector = null) {
    this.comparisons++;
    const {photograph} = this;
    if (!photograph || (projector && projector !== photograph.projector)) return;
    exchange(this, photograph.kept);
    exchange(photograph.projector, photograph.keptThere);
    photograph.bitmap.close();
    this.photograph = null;
    this.compared(photograph);
  }

  compared({projector} = this.photograph) {
    projector.dirty = true;
    document.body.classList.toggle('comparing', !!this.photograph); // both lie over black
    this.changed('photograph');
    this.invalidate();
  }

  // --- Drawing. ---

  invalidate(moving = false) {
    if (moving) this.lastChange = performance.now();
    this.stale = true;
    this.schedule();
  }

  schedule() {
    if (this.pending || this.lost) return;
    this.pending = true;
    // a hidden page has no frames; what the projector shows goes on in those of its window
    const [open] = document.hidden ? this.windows.open : [], work = () => this.frame(performance.now());
    if (open) {
      this.cancel = open.window.frame(work);
      return;
    }
    const frame = requestAnimationFrame(work);
    this.cancel = () => cancelAnimationFrame(frame);
  }

  // The page was hidden or shown: requests a frame from the window that has any.
  reschedule() {
    if (!this.pending) return;
    this.cancel();
    this.pending = false;
    this.schedule();
  }

  // True if a film runs that can be seen, here or in the projector window.
  get playing() {
    const {lit} = this;
    return this.projectors.some((p) => p.live && (lit.includes(p) || (p.on && p.window.isOpen)));
  }

  get dragged() { return performance.now() - this.lastChange < 180; }
  get moving() { return this.dragged || this.playing; }

  frame(now) {
    this.pending = false;
    if (this.lost) return;
    this.endFades();
    const live = this.playing, moving = this.moving;
    if (this.stale || live || this.rough) {
      if (moving) this.adapt(now);
      else this.lastFrame = 0;
      this.tryDraw(moving ? QUALITIES[this.quality] : QUALITIES[0], this.dragged);
      this.rough = (moving && this.quality > 0) || this.projectors.some((projector) => projector.coarse);
      this.stale = false;
    }
    if (live || this.rough || this.moving) this.schedule();
  }

  // Slow frames make the next ones coarser.
  adapt(now) {
    const took = this.lastFrame ? now - this.lastFrame : 0;
    this.lastFrame = now;
    if (!took || took > 2000) return;
    this.average = this.average ? 0.6 * this.average + 0.4 * took : took;
    const step = this.average > SLOW ? 1 : this.average < FAST ? -1 : 0;
    const next = clamp(this.quality + step, 0, QUALITIES.length - 1);
    if (next !== this.quality) this.quality = next, this.average = 0;
  }

  // Device pixels per CSS pixel and samples per side, as the quality requires and the graphics memory allows.
  detail(quality) {
    const ratio = Math.min(devicePixelRatio || 1, 2) * quality.scale, wanted = quality.coarse ? 1 : this.scene.drawing.samples;
    const {side, scale} = affordable(Math.round(innerWidth * ratio), Math.round(innerHeight * ratio), wanted, this.graphics.sideMax);
    return {ratio: ratio * scale, side};
  }

  // The camera that a projector's corrected picture is for.
  watcherOf(projector) {
    const view = this.scene.views[projector.watcher];
    return view ? view.camera : this.show.seat || this.seat();
  }

  // The device in whose picture a projector's layers lie: itself, or the camera for which it is corrected.
  frameOf(projector) { return projector.corrected ? this.watcherOf(projector) : projector.device; }

  // The camera that looks now.
  seat() { return {...this.base, pose: this.pose}; }

  // The projectors' patterns, where they have changed; while things move, a correction may be `coarse`.
  updatePatterns(coarse = false) {
    for (const projector of this.projectors) {
      const watcher = projector.corrected ? this.watcherOf(projector) : null, others = projector.corrected ? this.partnersOf(projector) : [];
      const most = this.black && projector.corrected ? Math.max(1, ...[projector, ...others].map((p) => p.most || 1)) : 1;
      const key = JSON.stringify([watcher, projector.device, projector.correction, projector.gain, projector.stops, this.black, most,
        others.map(({device, stops}) => [device, stops])]);
      if (!projector.dirty && !projector.live && key === projector.patternKey && (coarse || !projector.coarse)) continue;
      const rough = coarse && projector.isOnObject;
      this.relief.rough = rough;
      projector.coarse = (projector.corrected && this.compensator.solve(projector, watcher, coarse, {others, black: this.black, most})) || rough;
      if (!projector.corrected) {
        projector.freeMaps();
        if (projector.dirty || projector.live || projector.wasCorrected || projector.isOnObject) projector.drawPattern();
      }
      if (projector.fade && projector.fade.still) projector.pattern.lay(projector.fade.still, 1 - projector.share);
      projector.dirty = false, projector.patternKey = key, projector.wasCorrected = projector.corrected;
      projector.window.stale = true;
    }
    this.relief.rough = false;
    if (this.black && this.projectors.some((p) => p.corrected && p.most !== p.knownMost)) {
      for (const p of this.projectors) p.knownMost = p.most;
      this.updatePatterns(coarse); // what one counted holds for all
    }
  }

  // If the driver runs out of memory, a message says so and the page stays as it was.
  tryDraw(quality, coarse) {
    try {
      this.draw(quality, coarse);
    } catch (error) {
      if (!(error instanceof Message)) throw error;
      say(error.message);
    }
  }

  draw(quality, coarse = false) {
    const began = performance.now(), {ratio, side} = this.detail(quality);
    const camera = this.cameraOf(ratio), {canvas} = this;
    this.renderer.black = this.black;
    this.updatePatterns(coarse);
    if (canvas.width !== camera.width || canvas.height !== camera.height)
      canvas.width = camera.width, canvas.height = camera.height;
    this.renderer.drawLight(camera, side, this.lit, this.ambient);
    if (this.map === null) this.renderer.resolve(null, 2 ** this.exposure);
    else this.renderer.showMap(null, this.map);
    for (const projector of this.projectors) if (projector.window.stale) projector.window.show();
    this.redrawOverlay();
    this.frames = (this.frames || 0) + 1;
    this.drawn = {camera, side, milliseconds: performance.now() - began};
    this.changed('drawn');
  }

  redrawOverlay() { if (this.base) drawOverlay(this); }
  blurPanel() { if (document.activeElement && document.activeElement !== document.body) document.activeElement.blur(); }

  // The picture that the page shows now, RGBA bytes with row 0 on top, at any size; for screenshots and tests.
  picture(width, height, camera = {...this.base, pose: this.pose}) {
    this.renderer.black = this.black;
    this.updatePatterns();
    const {side} = affordable(width, height, this.scene.drawing.samples, this.graphics.sideMax);
    return this.renderer.picture(fitDevice(camera, width, height), side, this.lit, this.ambient,
                                 2 ** this.exposure, this.map);
  }
}

async function patternContent(scene, index) {
  const pattern = scene.patterns[index], bitmap = await readPicture(scene, pattern);
  return bitmap && Object.assign(new PictureContent(pattern.name, bitmap), {pattern: index});
}

async function start() {
  const scene = readScene(), app = new App(scene, document.getElementById('stage'), document.getElementById('overlay'));
  window.viewer = app; // for scripts: tests/product/view
  app.at = scene.views[0], app.base = app.at.camera, app.pose = app.base.pose, app.target = scene.centre;
  app.addProjector();
  app.setContent(new TestContent('Sunset'));
  buildPage(app);
  app.jump(scene.views[0], false);
  app.draw(QUALITIES[0]);
  app.history = makeHistory(app), app.store = new Store(app);
  followGestures(app.history);
  app.fresh = new URLSearchParams(location.search).has('fresh');
  const kept = !app.fresh && await app.store.restore().catch((error) => say(`The page as this browser kept it cannot be read: ${error.message}`, true));
  const found = app.windows.find();
  if (kept) app.draw(QUALITIES[0]);
  await app.graphics.drawn();
  if (!kept) return;
  app.history.note();
  if (!app.show.armed) return say('As you left it. Undo brings the page as it came.');
  found.then(() => say(`As you left it: armed.${app.windows.open.length ? ' The projector windows are back.' : NO_WINDOW}`));
}

// The page is painted once before it is busy drawing.
const painted = new Promise((done) => (document.hidden ? setTimeout : requestAnimationFrame)(() => setTimeout(done)));
window.ready = painted.then(start).then(() => { document.body.classList.add('ready'); return true; }, (error) => {
  showFailure(error);
  if (!(error instanceof Message)) console.warn(error);
  return false;
});
