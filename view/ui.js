'use strict';
// The panel, the tools, the keyboard, dropping and pasting, and messages.

const $ = (id) => document.getElementById(id);

function element(tag, properties = {}, children = []) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

let sayTimer = 0;
function say(text, stays = false) {
  const toast = $('toast');
  toast.textContent = text;
  toast.classList.add('shown');
  clearTimeout(sayTimer);
  toast.onclick = () => toast.classList.remove('shown');
  if (!stays) sayTimer = setTimeout(() => toast.classList.remove('shown'), 6000);
}

// The page cannot work at all.
function showFailure(error) {
  const box = $('failure');
  box.querySelector('p').textContent = error.message;
  box.hidden = false;
  document.body.classList.add('failed');
}

// Runs an action of the user; if it fails, a message says so and the page stays as it was.
function attempt(work) {
  return async (...given) => {
    try {
      return await work(...given);
    } catch (error) {
      say(error instanceof Message ? error.message : `That did not work: ${error.message}`, error.stays);
      if (!(error instanceof Message)) console.warn(error);
    }
  };
}

function drawTile(canvas, source) {
  const {width, height} = canvas, layer = new Layer(source, {fit: 'cover'}), context = canvas.getContext('2d');
  context.clearRect(0, 0, width, height);
  drawStraight(context, layer, layer.frame(width, height));
}

async function thumbnail(scene, entry, size = 96) {
  const bitmap = await readPicture(scene, entry), canvas = makeCanvas(size, size);
  if (!bitmap) return canvas;
  drawTile(canvas, new PictureContent('', bitmap));
  bitmap.close();
  return canvas;
}

// Marks one of several as selected, visibly and for screen readers.
function choose(button, chosen) {
  button.classList.toggle('chosen', chosen);
  button.setAttribute('aria-pressed', chosen);
  return button;
}

const shortName = (id) => id.replace(/_/g, ' ');

// "path_0_theta180", "view-180": "180°"; "path_1_theta090": "90°, path 1".
function viewName({id, new: another}) {
  const [, path, angle] = /^(?:view-|path_(\d+)_theta)0*(\d+)$/.exec(id) || [];
  return (angle === undefined ? shortName(id) : `${angle}°${Number(path) ? `, path ${path}` : ''}`) + (another ? ' (new pose)' : '');
}

function buildViews(app) {
  const {scene} = app;
  scene.views.forEach((view, index) => {
    const white = view.photographs.find((p) => p.size && scene.patterns[p.pattern].role === 'white') || view.photographs.find((p) => p.size);
    const button = element('button', {className: 'tile', title: viewName(view)});
    button.append(element('span', {textContent: index + 1}));
    button.setAttribute('aria-label', `View ${viewName(view)}`);
    button.dataset.view = index; // poses of another file may have the same ids
    thumbnail(scene, white).then((canvas) => button.prepend(canvas));
    button.onclick = () => jumpTo(app, view);
    $('views').append(button);
  });
  app.listeners.push((what) => {
    if (what === 'view')
      for (const tile of $('views').children) choose(tile, scene.views[tile.dataset.view] === app.at);
  });
}

function jumpTo(app, view) {
  const compare = !!app.photograph;
  if (compare) app.showPhotograph(false);
  app.jump(view, $('bring').checked && !app.show.armed); // a show's projectors stay
  if (compare && view.photographs.length) attempt(() => app.showPhotograph(true))();
}

function addTile(box, name, canvas, show, key) {
  const button = element('button', {className: 'tile', title: shortName(name)}, [canvas]);
  button.setAttribute('aria-label', `Show ${shortName(name)}`);
  button.dataset.content = key;
  button.onclick = attempt(show);
  box.append(button);
}

function buildContents(app) {
  const {scene} = app, box = $('contents');
  scene.patterns.forEach((pattern, index) => {
    if (!pattern.size || pattern.role === 'black') return;
    const canvas = makeCanvas(96, 96);
    addTile(box, pattern.name, canvas, () => app.bring(patternContent(scene, index)), index);
    thumbnail(scene, pattern).then((picture) => canvas.getContext('2d').drawImage(picture, 0, 0));
  });
  const white = scene.patterns.some((p) => p.size && p.role === 'white');
  for (const name of Object.keys(TEST_PATTERNS)) {
    if (name === 'White' && white) continue; // the capture's is the same
    const canvas = makeCanvas(96, 96), context = canvas.getContext('2d');
    context.fillRect(0, 0, 96, 96);
    TEST_PATTERNS[name](context, 96, 96);
    addTile(box, name, canvas, () => app.setContent(new TestContent(name)), name);
  }
  for (const effect of Object.keys(EFFECTS)) {
    const canvas = makeCanvas(96, 96), made = () => new EffectContent(effect, '#ffffff');
    drawTile(canvas, made());
    addTile(box, EFFECTS[effect].name, canvas, () => app.setContent(made()), `effect ${effect}`);
  }
  const addFile = ({id, name, content, live}) => {
    const canvas = makeCanvas(96, 96), draw = (source) => drawTile(canvas, source), drawFilm = () => filmTile(content, draw).catch(() => {});
    if (live && !content.running) draw(new TextContent(name, '#ffffff'));
    else if (content.video) drawFilm();
    else draw(content);
    addTile(box, name, canvas, async () => {
      if (live && !content.running) await content.start(), drawFilm();
      await app.bring(content);
    }, `file ${id}`);
    box.lastChild.scrollIntoView({block: 'nearest', inline: 'nearest'});
  };
  let added = 0;
  app.listeners.push((what) => {
    if (what === 'library') app.library.entries.slice(added).forEach(addFile), added = app.library.entries.length;
    if (what !== 'content' && what !== 'projector') return;
    const {content} = app.projector;
    const test = white && content.name === 'White' ? String(scene.patterns.findIndex((p) => p.role === 'white')) : content.name;
    const key = content instanceof TestContent ? test : content instanceof EffectContent ? `effect ${content.effect}` : content.file !== undefined ? `file ${content.file}` : String(content.pattern); // names may be those of patterns or files
    for (const tile of box.children) choose(tile, tile.dataset.content === key);
    $('content-name').textContent = shortName(content.name);
  });
}

function buildProjectors(app) {
  const show = () => {
    $('projectors').replaceChildren(...app.projectors.map((projector) => {
      const button = choose(element('button', {textContent: projector.number}), projector === app.projector);
      button.style.setProperty('--dot', projector.colour);
      button.classList.toggle('off', !projector.on);
      button.setAttribute('aria-label', `Projector ${projector.number}`);
      button.onclick = () => app.select(projector);
      return button;
    }));
    $('remove').disabled = app.projectors.length < 2;
  };
  $('add').onclick = attempt(() => anotherProjector(app));
  $('remove').onclick = attempt(() => app.removeProjector());
  app.listeners.push((what) => { if (what === 'projector') show(); });
  show();
}

function anotherProjector(app) {
  app.inShow('another projector would change what the others show');
  return app.addProjector();
}

// Gives all projectors the selected one's layers and correction: corrected, they share the light.
function showEverywhere(app) {
  const {layers, correction, watcher, gain} = app.projector;
  for (const projector of app.projectors.filter((p) => p !== app.projector)) {
    Object.assign(projector, {correction, watcher, gain});
    app.setLayers(layers.map((layer) => new Layer(layer.source, layer)), projector);
  }
}

// A control and the state behind it: `get` reads the state to show it, `set` changes it.
function bind(app, id, get, set, shown = null) {
  const input = $(id), property = input.type === 'checkbox' ? 'checked' : 'value';
  const refresh = () => {
    if (document.activeElement !== input || input.type === 'checkbox') input[property] = get();
    const output = input.parentElement.querySelector('output');
    if (output) output.textContent = shown ? shown() : '';
  };
  input.addEventListener('input', () => {
    set(input.type === 'checkbox' ? input.checked : input.type === 'range' ? Number(input.value) : input.value);
    refresh();
  });
  app.listeners.push((what) => { if (what !== 'drawn') refresh(); });
  refresh();
}

const stopsText = (stops) => `${2 ** stops >= 10 ? (2 ** stops).toFixed(0) : (2 ** stops).toFixed(2)} ×`;
const fieldOf = (d) => 360 / Math.PI * Math.atan(d.width / (2 * d.fx));

function buildSettings(app) {
  const redraw = () => app.invalidate();
  bind(app, 'on', () => app.projector.on, (on) => { app.projector.on = on; app.changed('projector'); app.projector.window.stale = true; redraw(); });
  bind(app, 'fit', () => app.projector.layer.fit, (fit) => { app.projector.layer.fit = fit; app.projector.dirty = true; redraw(); });
  bind(app, 'brightness', () => app.projector.stops, (stops) => { app.projector.stops = stops; redraw(); }, () => stopsText(app.projector.stops));
  bind(app, 'lens', () => fieldOf(app.projector.device), (degrees) => {
    const d = app.projector.device;
    app.zoomProjector(d.width / (2 * Math.tan(degrees * Math.PI / 360)) / d.fx);
  }, () => `${fieldOf(app.projector.device).toFixed(0)}°`);
  const distance = () => length3(sub3(positionOf(app.projector.device.pose), app.scene.centre));
  const radius = app.scene.radius || 1;
  Object.assign($('distance'), {min: app.nearest, max: 8 * radius, step: radius / 100});
  bind(app, 'distance', distance, (wanted) => app.moveProjectorAway(wanted / distance()), () => `${(distance() / radius).toFixed(1)} r`);
  let roll = 0;
  bind(app, 'roll', () => roll, (degrees) => {
    const {pose} = app.projector.device;
    app.setProjectorPose(turnPose(pose, axisOf(pose, 2), (degrees - roll) * Math.PI / 180, positionOf(pose)));
    roll = degrees;
  }, () => `${roll}°`);
  app.listeners.push((what) => { if (what === 'projector' || what === 'view') { roll = 0; $('roll').value = 0; } });
  $('aim').onclick = () => {
    const p = app.projector, eye = positionOf(p.device.pose);
    app.setProjectorPose(lookAt(eye, app.scene.centre, app.up));
  };
  bind(app, 'exposure', () => app.exposure, (stops) => { app.exposure = stops; redraw(); }, () => stopsText(app.exposure));
  bind(app, 'ambient', () => app.ambient, (on) => { app.ambient = on; redraw(); });
  bind(app, 'frusta', () => app.frusta, (on) => { app.frusta = on; redraw(); });
  bind(app, 'map', () => app.map === null ? 'light' : String(app.map), (map) => { app.map = map === 'light' ? null : Number(map); redraw(); });
  bind(app, 'brush-colour', () => app.brush.colour, (colour) => { app.brush.colour = colour; app.brush.erase = false; setMode(app, 'brush'); });
  bind(app, 'brush-size', () => app.brush.size, (size) => { app.brush.size = size; }, () => `${app.brush.size}`);
  bind(app, 'erase', () => app.brush.erase, (on) => { app.brush.erase = on; setMode(app, 'brush'); });
  $('clear').onclick = () => { app.projector.clearPaint(); app.invalidate(); };
}

function buildCorrection(app) {
  app.scene.views.forEach((view, index) => {
    $('watcher').append(element('option', {value: index, textContent: viewName(view)}));
  });
  bind(app, 'correction', () => app.projector.correction, (how) => { app.projector.correction = how; app.changed('content'); app.invalidate(); });
  bind(app, 'watcher', () => app.projector.watcher, (which) => { app.projector.watcher = which; app.invalidate(); });
  bind(app, 'gain', () => app.projector.gain, (stops) => { app.projector.gain = stops; app.invalidate(); }, () => stopsText(app.projector.gain));
  $('send').onclick = attempt(() => app.window.open());
  $('same').onclick = () => { showEverywhere(app); app.invalidate(); };
  bind(app, 'black', () => 100 * app.black, (percent) => { app.black = clamp(Number(percent) || 0, 0, 100 * BLACK_MOST) / 100; app.invalidate(); });
  $('export').onclick = attempt(() => savePattern(app));
  buildPixels(app);
  app.listeners.push((what) => {
    if (what === 'drawn') return;
    $('gain-row').hidden = app.projector.correction !== 'colours';
    $('watcher-row').hidden = !app.projector.corrected;
    const which = app.projectors.length < 2 ? 'the projector window' : `projector ${app.projector.number}'s window`;
    $('send').textContent = app.window.isOpen ? `${which[0].toUpperCase()}${which.slice(1)} is open` : `Open ${which}`;
    $('same').hidden = $('black-row').hidden = app.projectors.length < 2;
  });
}

// The real projector's pixels, if its capture does not tell them.
function buildPixels(app) {
  const inputs = [$('pixels-w'), $('pixels-h')];
  const refresh = () => {
    const {panel, known, pixels} = app.projector;
    inputs.forEach((input, k) => {
      input.disabled = !!known;
      if (document.activeElement !== input) input.value = panel ? panel[k ? 'height' : 'width'] : pixels ? pixels[k] : '';
    });
  };
  for (const input of inputs)
    input.onchange = () => {
      const sides = inputs.map(({value}) => value === '' ? 0 : clamp(Math.round(Number(value)) || 0, ...PIXELS));
      if (sides.some((side) => !side) && inputs.some(({value}) => value !== '')) return;
      app.projector.setPixels(sides[0] ? sides : null);
      app.projector.window.stale = true;
      app.invalidate();
      app.changed('settings');
    };
  app.listeners.push((what) => { if (what !== 'drawn') refresh(); });
}

function setMode(app, mode) {
  app.mode = mode;
  for (const button of document.querySelectorAll('[data-mode]'))
    button.setAttribute('aria-pressed', button.dataset.mode === mode);
  app.canvas.style.cursor = mode === 'brush' || mode === 'nudge' || mode === 'surface' ? 'crosshair' : 'grab';
  if (mode === 'nudge') {
    app.projector.pulls = [];
    say('Pull a projected point from where you see it on the object to where it belongs.');
  }
  if ((mode === 'place' || mode === 'nudge') && innerWidth <= 700) document.body.classList.remove('with-panel'); // there is room for one of them
  if (mode === 'surface') say('Click a wall, a roof, a column: it becomes a surface.');
  app.changed('mode');
  app.invalidate();
}

function savePicture(app) {
  const {width, height} = app.drawn.camera, {ratio, side} = app.detail(QUALITIES[0]);
  const camera = app.cameraOf(ratio), data = app.renderer.picture(camera, side, app.lit, app.ambient, 2 ** app.exposure, app.map);
  for (let i = 3; i < data.length; i += 4) data[i] = 255; // over black, as files are
  const canvas = makeCanvas(camera.width, camera.height);
  canvas.getContext('2d').putImageData(new ImageData(data, camera.width, camera.height), 0, 0);
  canvas.toBlob((blob) => {
    const link = element('a', {href: URL.createObjectURL(blob), download: `${app.scene.name || 'view'}.png`});
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    say(`Saved ${link.download}, ${canvas.width} × ${canvas.height}`);
    app.saved = (app.saved || 0) + 1;
  }, 'image/png');
  app.invalidate();
  return [width, height];
}

function toggleFull() {
  if (document.fullscreenElement) document.exitFullscreen();
  else document.documentElement.requestFullscreen().catch(() => say('This browser cannot show the page full screen.'));
}

// The panel with its group for a show alone (the studio's last step).
function openShow() {
  const group = $('cues').closest('details');
  document.body.classList.add('with-panel');
  for (const details of document.querySelectorAll('#panel > details')) details.open = details === group || details.contains($('send'));
  group.scrollIntoView();
  window.viewer.invalidate();
}

function togglePanel(app) {
  document.body.classList.toggle('with-panel');
  app.invalidate();
}

function buildTools(app) {
  for (const button of document.querySelectorAll('[data-mode]')) button.onclick = () => setMode(app, button.dataset.mode);
  $('compare').onclick = attempt(() => app.showPhotograph(!app.photograph));
  $('shot').onclick = attempt(() => savePicture(app));
  $('full').onclick = toggleFull;
  $('help').onclick = () => $('keys').showModal();
  $('keys').onclick = () => $('keys').close();
  $('toggle').onclick = () => togglePanel(app);
  $('undo').onclick = attempt(() => unwind(app, -1));
  $('redo').onclick = attempt(() => unwind(app, 1));
  $('save-stage').onclick = attempt(() => saveStage(app));
  $('load-stage').onclick = () => $('file').click();
  app.listeners.push((what) => {
    if (what === 'history') $('undo').disabled = app.history.at === 0, $('redo').disabled = app.history.at === app.history.states.length - 1;
  });
  setMode(app, 'camera');
}

function buildSources(app) {
  $('open').onclick = () => $('file').click();
  $('file').onchange = attempt(async () => {
    const [file] = $('file').files;
    $('file').value = '';
    if (file) await showFile(app, file);
  });
  $('webcam').onclick = attempt(() => app.bring(app.library.startStream('camera')));
  $('screen').onclick = attempt(() => app.bring(app.library.startStream('screen')));
  $('solid').oninput = () => app.setContent(new SolidContent($('solid').value));
  const write = buildText(app);
  addEventListener('dragover', (event) => { event.preventDefault(); document.body.classList.add('dropping'); });
  addEventListener('dragleave', (event) => { if (!event.relatedTarget) document.body.classList.remove('dropping'); });
  addEventListener('drop', (event) => {
    event.preventDefault();
    document.body.classList.remove('dropping');
    const [file] = event.dataTransfer.files;
    if (file) attempt(showFile)(app, file); else say('Drop a picture or a film file here.');
  });
  addEventListener('paste', (event) => {
    if (isText(event.target)) return;
    const [file] = event.clipboardData.files, text = event.clipboardData.getData('text');
    if (file) attempt(showFile)(app, file);
    else if (text && !app.show.armed) write(text);
    else say('There is no picture in the clipboard.');
  });
}

// A picture or a film is projected, a stage takes the place of what is here.
async function showFile(app, file) {
  if (/\.json$/i.test(file.name) || file.type === 'application/json') {
    app.inShow('a stage would take the place of the show');
    return loadStage(app, await file.text());
  }
  if (app.show.armed) {
    const {name} = await app.library.take(file);
    return say(`Armed: ${name} is among the contents now. Press its tile to show it.`);
  }
  if (await app.bring(app.library.take(file))) app.shown = (app.shown || 0) + 1;
}

// The GO key.
const go = attempt(async (app) => { if (app.show.armed) await app.show.go(), app.history.note(); });

const KEYS = {
  c: (app) => setMode(app, 'camera'), p: (app) => setMode(app, 'projector'), b: (app) => setMode(app, 'brush'), u: (app) => setMode(app, 'nudge'), r: (app) => setMode(app, 'surface'), l: (app) => setMode(app, 'place'),
  a: (app) => { app.ambient = !app.ambient; app.changed('settings'); app.invalidate(); },
  g: (app) => { app.map = app.map === null ? 0 : app.map === 5 ? null : app.map + 1; app.changed('settings'); app.invalidate(); },
  x: (app) => { app.frusta = !app.frusta; app.changed('settings'); app.invalidate(); },
  v: (app) => attempt(() => app.showPhotograph(!app.photograph))(), s: attempt((app) => savePicture(app)), f: toggleFull, h: togglePanel,
  o: () => $('file').click(), '?': () => $('keys').showModal(), n: attempt(anotherProjector),
  w: (app) => attempt(() => app.window.open())(), '.': pressBlackout, t: testPicture, Home: (app) => app.home(),
  '+': (app) => app.dolly(0.9), '=': (app) => app.dolly(0.9), '-': (app) => app.dolly(1 / 0.9),
  '[': (app) => { app.brush.size = Math.max(2, app.brush.size - 2); app.changed('brush'); app.redrawOverlay(); },
  ']': (app) => { app.brush.size = Math.min(120, app.brush.size + 2); app.changed('brush'); app.redrawOverlay(); },
  k: (app) => app.show.press(), Escape: (app) => app.show.stop(),
  e: (app) => { app.brush.erase = !app.brush.erase; app.changed('brush'); app.redrawOverlay(); },
  ' ': (app) => { if (app.projector.content.toggle) { app.projector.content.toggle(); app.invalidate(); } },
};
const REPEATED = /^[-+=[\]]$/; // keys that act again and again while they are held
const ARROWS = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};

const isText = (target) => target instanceof Element && target.matches('textarea, input[type=text], input[type=number]');

// True if a control uses a key itself: to type into it, to move it or to press it.
function takesKey(target, key) {
  if (isText(target) || target instanceof HTMLSelectElement) return true;
  if (target instanceof HTMLInputElement && target.type === 'range') return !!ARROWS[key] || key === 'Home';
  return key === ' ' && !!target.closest && !!target.closest('input, button, summary');
}

// Turns, or moves what is chosen; in a whole scene the camera walks ahead and back.
function arrow(app, controls, event) {
  const [x, y] = ARROWS[event.key].map((d) => 16 * d), {whole} = app.scene;
  if (app.mode === 'place') nudge(app, ARROWS[event.key], event.shiftKey);
  else if (app.mode === 'projector') controls.drag(event.shiftKey ? 'aim' : 'projector', x, y);
  else if (whole && !event.shiftKey && y) app.walk(-y / 200, 0);
  else if (whole && event.shiftKey && x) app.walk(0, x / 200);
  else controls.drag(event.shiftKey ? 'pan' : 'orbit', whole && !event.shiftKey ? -x : x, y);
}

// Switches the page's texts to those for a whole scene in place of an object (data-whole, data-whole-title).
function nameWhole() {
  for (const told of document.querySelectorAll('[data-whole]')) told.textContent = told.dataset.whole;
  for (const told of document.querySelectorAll('[data-whole-title]')) told.title = told.dataset.wholeTitle;
}

function buildKeys(app, controls) {
  addEventListener('keydown', (event) => {
    if (app.show.armed && (event.key === 'F5' || ((event.ctrlKey || event.metaKey) && /^r$/i.test(event.key)))) {
      event.preventDefault();
      say('Armed: no key reloads the page.');
      return;
    }
    if ((event.ctrlKey || event.metaKey) && /^[zy]$/i.test(event.key) && !isText(event.target) && !$('keys').open) {
      attempt(() => unwind(app, event.key.toLowerCase() === 'y' || event.shiftKey ? 1 : -1))();
      event.preventDefault();
      return;
    }
    const goes = app.show.armed && (event.key === ' ' || event.key === 'Enter') && !isText(event.target);
    if ((!goes && takesKey(event.target, event.key)) || event.ctrlKey || event.metaKey || event.altKey || $('keys').open) return;
    if (goes) {
      app.blurPanel(); // its button would be pressed too
      if (!event.repeat) go(app);
    } else if (ARROWS[event.key]) {
      arrow(app, controls, event);
    } else if (/^[1-9]$/.test(event.key)) {
      const view = app.scene.views[Number(event.key) - 1];
      if (view) jumpTo(app, view);
    } else if (KEYS[event.key] || KEYS[event.key.toLowerCase()]) {
      if (!event.repeat || REPEATED.test(event.key)) (KEYS[event.key] || KEYS[event.key.toLowerCase()])(app, event);
    } else return;
    event.preventDefault();
  });
}

// The photograph over the left part of the picture, exactly where the prediction is.
function buildPhotograph(app) {
  const canvas = $('photograph'), split = $('split');
  const place = () => {
    const on = !!app.photograph;
    canvas.hidden = split.hidden = $('split-line').hidden = !on;
    $('compare').setAttribute('aria-pressed', on);
    if (!on) return;
    const camera = app.screenCamera(), s = camera.fx / app.base.fx, width = app.base.width * s, height = app.base.height * s;
    const left = camera.cx - app.base.cx * s, top = camera.cy - app.base.cy * s, x = left + width * split.value / 100;
    canvas.style.cssText = `left:${left}px;top:${top}px;width:${width}px;height:${height}px;clip-path:inset(0 ${100 - split.value}% 0 0)`;
    split.style.cssText = `left:${left}px;width:${width}px;top:${Math.min(top + height - 48, app.freeSize()[1] - 120)}px`;
    $('split-line').style.cssText = `left:${x}px;top:${top}px;height:${height}px`;
  };
  split.oninput = place;
  app.listeners.push((what) => {
    if (what === 'photograph' && app.photograph) {
      const {bitmap} = app.photograph;
      canvas.width = bitmap.width, canvas.height = bitmap.height;
      canvas.getContext('2d').drawImage(bitmap, 0, 0);
    }
    if (what === 'photograph' || what === 'drawn') place();
  });
}

function buildPage(app) {
  const {scene} = app;
  document.title = scene.name || 'FF-ProCams';
  $('name').textContent = scene.name || (scene.whole ? 'Scene' : 'Object');
  $('about').textContent = `${scene.splats.count.toLocaleString('en')} splats`;
  if (scene.whole) nameWhole();
  if (innerWidth > 700) document.body.classList.add('with-panel');
  buildViews(app);
  buildProjectors(app);
  buildContents(app);
  buildLayers(app);
  buildPlace(app);
  buildSurfaces(app);
  buildEffect(app);
  buildFilm(app);
  buildSettings(app);
  buildCorrection(app);
  buildShow(app);
  buildControl(app);
  buildSources(app);
  buildTools(app);
  buildPhotograph(app);
  const controls = new Controls(app, app.canvas);
  buildKeys(app, controls);
  addEventListener('resize', () => app.invalidate());
  app.changed('projector');
  app.changed('content');
}
