'use strict';
// Placing layers by hand: the projector's picture, flat, with handles; the list of layers and their numbers in the panel.

const GRIP = 7, REACH = 14, TURN_REACH = 26, FLAT_MARGIN = 30, BAR = 50; // CSS pixels
const BEHIND_SIDE = 480, BEHIND = 0.7, BEFORE = 0.7; // the object behind the layers: its longer side, pixels; how opaque both are

// The projector's picture lies below the object while layers are placed.
class FlatPicture {
  constructor(app) {
    this.app = app, this.what = 'size', this.pointers = new Map();
    this.canvas = $('flat');
    this.canvas.addEventListener('pointerdown', (event) => this.down(event));
    this.canvas.addEventListener('pointermove', (event) => this.move(event));
    for (const end of ['pointerup', 'pointercancel']) this.canvas.addEventListener(end, (event) => this.up(event));
    this.canvas.addEventListener('wheel', (event) => this.wheel(event), {passive: false});
    this.canvas.addEventListener('dblclick', (event) => this.removePoint(this.at(event)));
    app.listeners.push((what) => { if (what !== 'history' && what !== 'view') this.draw(); });
  }

  get shown() { return this.app.mode === 'place'; }

  get device() { return this.app.frameOf(this.app.projector); }

  // The object in that frame, drawn again when the device has moved.
  object() {
    const device = shadowDevice(this.device, BEHIND_SIDE), key = JSON.stringify(device), {width, height} = device;
    if (key !== this.objectKey) {
      this.behind = makeCanvas(width, height);
      this.behind.getContext('2d').putImageData(new ImageData(this.app.renderer.albedoSeen(device), width, height), 0, 0);
      this.objectKey = key;
    }
    return this.behind;
  }

  // Its place on the screen: {left, top, width, height}, CSS pixels.
  box() {
    const {app} = this, [width, height] = app.windowSize(), top = height * OBJECT_SHARE, foot = height < innerHeight ? 8 : 70;
    const shape = this.device;
    const room = [width - 2 * FLAT_MARGIN, height - top - BAR - FLAT_MARGIN - foot], s = Math.max(0.01, Math.min(room[0] / shape.width, room[1] / shape.height));
    const [w, h] = [shape.width * s, shape.height * s];
    return {left: (width - w) / 2, top: top + BAR + (room[1] - h) / 2, width: w, height: h, all: {top, width, height: height - top}};
  }

  frame(layer = this.app.projector.layer) {
    const {width, height} = this.box();
    return layer.frame(width, height);
  }

  // A pointer's position in the picture.
  at(event) {
    const {left, top} = this.box();
    return [event.clientX - left, event.clientY - top];
  }

  handles() { return this.what === 'surface' ? [] : handlesOf(this.frame(), this.what, TURN_REACH); }

  down(event) {
    const {app} = this, {projector} = app, at = this.at(event);
    event.preventDefault();
    app.blurPanel();
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, at);
    if (this.pointers.size > 1) return;
    if (this.what === 'surface') return void attempt(() => app.choosing.choose(this.pointUnder(at), event))();
    this.held = handleUnder(this.handles(), at, event.pointerType === 'touch' ? 2 * REACH : REACH);
    if (this.held) return;
    if (this.what === 'mask') return this.addPoint(at);
    const over = projector.layers.findLastIndex((layer) => covers(this.frame(layer), at));
    if (over >= 0 && over !== projector.at && !covers(this.frame(), at)) selectLayer(app, over);
    this.held = covers(this.frame(), at) ? {name: 'move'} : null;
  }

  move(event) {
    const before = this.pointers.get(event.pointerId), at = this.at(event), {app} = this;
    if (!before) return this.point(at);
    const other = [...this.pointers].find(([id]) => id !== event.pointerId), frame = this.frame();
    this.pointers.set(event.pointerId, at);
    if (other) return app.placed(pinched(frame, [before, other[1]], [at, other[1]]));
    if (!this.held) return;
    const {name} = this.held;
    app.placed(name === 'move' ? movedBy(frame, at[0] - before[0], at[1] - before[1]) : dragHandle(frame, this.what, name, at, event.shiftKey));
  }

  up(event) {
    this.pointers.delete(event.pointerId);
    this.held = null;
  }

  wheel(event) {
    event.preventDefault();
    const s = Math.exp(-clamp(event.deltaY, -200, 200) * 0.0012), frame = this.frame();
    this.app.placed(event.shiftKey ? turnedAbout(frame, middleOf(frame), 20 * Math.log(s)) : scaledAbout(frame, middleOf(frame), s, s));
  }

  // The point of the object that is shown there.
  pointUnder([x, y]) {
    const {width, height} = this.box();
    return this.app.choosing.pointInPicture([x / width, y / height]);
  }

  point(at) {
    if (this.what === 'surface') return this.app.choosing.hover(this.pointUnder(at));
    this.canvas.style.cursor = handleUnder(this.handles(), at, REACH) ? 'pointer' : covers(this.frame(), at) ? 'move' : 'default';
  }

  // A point of the mask, between the two whose line is nearest, and held from then on.
  addPoint(at) {
    const frame = this.frame(), mask = [...(frame.place.mask || [])], unit = toUnit(frame, at), away = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
    if (mask.length >= MASK_MAX) return;
    const longer = mask.map((p, k) => away(p, unit) + away(unit, mask[(k + 1) % mask.length]) - away(p, mask[(k + 1) % mask.length]));
    const after = mask.length < 3 ? mask.length : longer.indexOf(Math.min(...longer)) + 1;
    mask.splice(after, 0, unit);
    this.app.placed({...frame.place, mask});
    this.held = {name: `mask ${after}`};
  }

  removePoint(at) {
    const held = this.what === 'mask' && handleUnder(this.handles(), at, REACH), {place} = this.app.projector.layer;
    if (!held) return;
    const mask = place.mask.filter((_, k) => held.name !== `mask ${k}`);
    this.app.placed({...place, mask: mask.length ? mask : null});
  }

  draw() {
    const {app, canvas} = this;
    $('place').hidden = !this.shown;
    if (!this.shown || !app.projector) return;
    const box = this.box(), {all} = box, ratio = devicePixelRatio || 1, context = canvas.getContext('2d');
    $('place').style.cssText = `top:${all.top}px;width:${all.width}px;height:${all.height}px`;
    const [width, height] = [all.width, all.height].map((side) => Math.max(1, Math.round(side * ratio)));
    if (canvas.width !== width || canvas.height !== height) canvas.width = width, canvas.height = height;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, width, height);
    const [w, h] = [box.width, box.height].map((side) => Math.max(1, Math.round(side * ratio))), picture = scratch('picture', w, h);
    const at = [Math.round(box.left * ratio), Math.round((box.top - all.top) * ratio)];
    app.projector.draw(picture, w, h, this.device);
    context.fillStyle = '#000';
    context.fillRect(...at, w, h);
    context.globalAlpha = BEHIND;
    context.drawImage(this.object(), ...at, w, h);
    context.globalAlpha = BEFORE;
    context.drawImage(picture.canvas, ...at);
    context.globalAlpha = 1;
    context.setTransform(ratio, 0, 0, ratio, box.left * ratio, (box.top - all.top) * ratio);
    context.strokeStyle = '#8a8a8a', context.lineWidth = 1;
    context.strokeRect(0, 0, box.width, box.height);
    app.projector.layers.forEach((layer) => { if (layer !== app.projector.layer) outline(context, cornersOf(this.frame(layer)), 0.5); });
    const {outlines} = app.choosing, {field} = outlines[0] || {};
    app.choosing.drawOutlines(context, ([x, y]) => [x * box.width / field.width, y * box.height / field.height], outlines);
    this.drawHandles(context);
  }

  drawHandles(context) {
    const frame = this.frame(), map = homographyOf(frame), {mask} = frame.place, through = (points) => points.map((unit) => throughHomography(map, unit));
    const handles = this.handles(), turn = handles.find(({name}) => name === 'turn');
    outline(context, cornersOf(frame), 1);
    if (frame.place.crop.some(Boolean)) outline(context, through(cropped(frame.place)), 1, [5, 4]);
    if (mask && mask.length > 1) outline(context, through(mask), 1, [2, 3]);
    if (turn) outline(context, [between(...cornersOf(frame)), turn.at], 1);
    for (const {name, at} of handles) {
      context.beginPath();
      if (name === 'turn' || this.what === 'mask') context.arc(...at, GRIP, 0, 2 * Math.PI);
      else context.rect(at[0] - GRIP + 1, at[1] - GRIP + 1, 2 * GRIP - 2, 2 * GRIP - 2);
      context.fillStyle = this.app.projector.colour, context.strokeStyle = '#000', context.lineWidth = 1.5;
      context.fill(), context.stroke();
    }
  }
}

// Light on dark, so that it is seen over any picture.
function outline(context, points, alpha, dashes = []) {
  context.beginPath();
  points.forEach(([x, y], k) => k ? context.lineTo(x, y) : context.moveTo(x, y));
  context.closePath();
  context.globalAlpha = alpha;
  for (const [colour, width] of [['#000', 3], ['#fff', 1]]) {
    context.strokeStyle = colour, context.lineWidth = width;
    context.setLineDash(dashes);
    context.stroke();
  }
  context.setLineDash([]);
  context.globalAlpha = 1;
}

// --- The panel. ---

function selectLayer(app, index) {
  app.projector.at = index;
  app.changed('content');
}

function editLayers(app, work) {
  const {projector} = app;
  app.reshow(projector, () => projector.change(() => work(projector.layers)));
}

// The layers of the selected projector, the one on top first.
function buildLayers(app) {
  const box = $('layers');
  const press = (text, title, work, disabled) => element('button', {textContent: text, title, className: 'small', onclick: attempt(work), disabled});
  const row = (layer, i) => {
    const {projector} = app, {layers} = projector, surface = app.relief.find(layer.on), on = surface ? ` on ${surface.name}` : '', name = shortName(layer.source.name);
    const pick = choose(press(layer.source.text ? layer.source.text.split('\n')[0] : name, `Select layer ${i + 1}, ${name}${on}`, () => selectLayer(app, i)), i === projector.at);
    pick.classList.add('name');
    pick.append(element('small', {textContent: on}));
    const raise = () => editLayers(app, () => { layers.splice(i + 1, 0, layers.splice(i, 1)[0]); projector.at = i + 1; });
    const remove = () => editLayers(app, () => { layers.splice(i, 1); projector.at = Math.min(projector.at, layers.length - 1); });
    return element('li', {className: 'row'}, [pick, press('↑', `Bring layer ${i + 1} forward`, raise, i === layers.length - 1), press('×', `Remove layer ${i + 1}`, remove, layers.length < 2)]);
  };
  app.listeners.push((what) => { if (what === 'content' || what === 'projector' || what === 'surfaces') box.replaceChildren(...app.projector.layers.map(row).reverse()); });
  $('add-layer').onclick = attempt(() => {
    if (app.projector.layers.length >= LAYERS_MAX) throw new Message(`A projector shows at most ${LAYERS_MAX} layers.`);
    editLayers(app, (layers) => { app.projector.at = layers.push(new Layer(new TextContent('Text', '#ffffff'))) - 1; });
    $('text').focus();
    $('text').select();
  });
}

// The part of a device's picture in which splats lie, shares of it: [left, top, right, bottom]; the outermost ones do not count.
function partOf({count, centre, opacity}, device) {
  const across = [], down = [];
  for (let i = 0; i < count; i += Math.floor(count / 20000) + 1) {
    if (opacity[i] < 0.5) continue;
    const [x, y, z] = project(device, [centre[3 * i], centre[3 * i + 1], centre[3 * i + 2]]);
    if (z > 0) across.push(x / device.width), down.push(y / device.height);
  }
  if (!across.length) return [0, 0, 1, 1];
  const ends = (values) => { values.sort((a, b) => a - b); return [0.01, 0.99].map((share) => clamp(values[Math.floor(share * (values.length - 1))], 0, 1)); };
  const [left, right] = ends(across), [top, bottom] = ends(down);
  return [left, top, right, bottom];
}

// The part that a layer is to fill: of its surface, or of the object; null: the device does not see the surface.
function partFor(app, layer, device) {
  const surface = app.relief.find(layer.on), region = surface && app.relief.region(surface, device);
  return region ? boxOf(region.field, region.inside) : partOf(app.scene.splats, device);
}

// Numbers of a place: [name, unit, how it is read, the place with another].
const PLACE_FIELDS = [
  ['Across', '%', (place) => 100 * place.x, (place, v) => ({...place, x: shifted(v / 100)})],
  ['Down', '%', (place) => 100 * place.y, (place, v) => ({...place, y: shifted(v / 100)})],
  ['Width', '%', (place) => 100 * place.width, (place, v) => ({...place, width: within(v / 100, FACTOR)})],
  ['Height', '%', (place) => 100 * place.height, (place, v) => ({...place, height: within(v / 100, FACTOR)})],
  ['Turn', '°', (place) => place.turn, (place, v) => ({...place, turn: within(v, [-180, 180])})],
  ['Opacity', '%', (place) => 100 * place.opacity, (place, v) => ({...place, opacity: within(v / 100, [0, 1])})],
  ...['left', 'top', 'right', 'bottom'].map((side, k) => [`Crop ${side}`, '%', (place) => 100 * place.crop[k], (place, v) => ({
    ...place, crop: place.crop.map((old, i) => i === k ? within(v / 100, [0, 1 - CROP_LEAST - place.crop[(k + 2) % 4]]) : old),
  })]),
  ...['Top left', 'Top right', 'Bottom right', 'Bottom left'].flatMap((corner, k) => [0, 1].map((i) => [`${corner}, ${['across', 'down'][i]}`, '%', (place) => 100 * place.pull[k][i], (place, v) => {
    const pull = place.pull.map((old, j) => j === k ? old.map((o, axis) => axis === i ? within(v / 100, [-PULL_MAX, PULL_MAX]) : o) : old), next = {...place, pull};
    return isConvex(cornersOf(layerFrame(next, null, 'contain', 1, 1))) ? next : place;
  }])),
  ['Soft edge of crop and mask', '%', (place) => 100 * place.feather, (place, v) => ({...place, feather: within(v / 100, [0, FEATHER_MAX])})],
];

const SHORT = {'Soft edge of crop and mask': 'Soft edge', ...Object.fromEntries(['Top left ↖', 'Top right ↗', 'Bottom right ↘', 'Bottom left ↙'].flatMap((text) =>
  [['across', '↔'], ['down', '↕']].map(([axis, arrow]) => [`${text.slice(0, -2)}, ${axis}`, `${text.slice(-1)} ${arrow}`])))};

function buildPlace(app) {
  const flat = app.flat = new FlatPicture(app);
  for (const [label, unit, get, set] of PLACE_FIELDS) {
    const input = element('input', {type: 'number', step: 'any'});
    $('numbers').append(element('label', {title: label}, [element('span', {textContent: SHORT[label] || label}), input, unit]));
    input.setAttribute('aria-label', label);
    input.addEventListener('input', () => { if (input.value !== '') app.placed(set(app.projector.layer.place, Number(input.value)), false); });
    const show = () => { if (document.activeElement !== input) input.value = Math.round(10 * get(app.projector.layer.place)) / 10; };
    input.addEventListener('blur', show);
    app.listeners.push((what) => { if (what === 'layers' || what === 'content' || what === 'projector') show(); });
  }
  const choices = [...document.querySelectorAll('[data-what]')];
  const pick = (what) => {
    flat.what = what;
    flat.canvas.style.cursor = what === 'surface' ? 'crosshair' : 'default';
    for (const button of choices) button.setAttribute('aria-pressed', button.dataset.what === what);
    flat.draw();
  };
  for (const button of choices) button.onclick = () => pick(button.dataset.what);
  $('reset-place').onclick = () => {
    const {place} = app.projector.layer, kept = newPlace();
    app.placed(flat.what === 'mask' ? {...place, mask: null} : flat.what === 'crop' ? {...place, crop: kept.crop} : flat.what === 'corners' ? {...place, pull: kept.pull}
      : {...place, x: 0, y: 0, width: 1, height: 1, turn: 0}, false);
  };
  $('fit-object').onclick = attempt(() => {
    const {projector} = app, {layer} = projector, {device} = flat, part = partFor(app, layer, device);
    if (!part) throw new Message(`Projector ${projector.number} does not reach ${app.relief.find(layer.on).name}.`);
    app.placed(placeInPart(layer.frame(device.width, device.height), part), false);
  });
  pick('size');
}

// Arrows move the selected layer by a pixel of the pattern, with Shift by ten.
function nudge(app, [x, y], far) {
  const {canvas, layer} = app.projector, step = far ? 10 : 1;
  app.placed(movedBy(layer.frame(canvas.width, canvas.height), x * step, y * step));
}

// --- Text and films. ---

const ROWS = 48;

// Where in a device's picture a box of this shape (width / height) is largest on the object: shares of it, [left, top, right, bottom].
function widestPart({count, centre, opacity}, device, shape) {
  const ends = Array.from({length: ROWS}, () => [1, 0]), wide = device.width / device.height;
  for (let i = 0; i < count; i++) {
    if (opacity[i] < 0.5) continue;
    const [x, y, z] = project(device, [centre[3 * i], centre[3 * i + 1], centre[3 * i + 2]]), u = x / device.width, row = ends[Math.floor(y / device.height * ROWS)];
    if (z > 0 && row && u >= 0 && u <= 1) row[0] = Math.min(row[0], u), row[1] = Math.max(row[1], u);
  }
  let best = [0, 0, 1, 1], most = 0;
  for (let first = 0; first < ROWS; first++) {
    let [left, right] = [0, 1];
    for (let last = first; last < ROWS; last++) {
      left = Math.max(left, ends[last][0]), right = Math.min(right, ends[last][1]);
      if (!(right > left)) break;
      const size = Math.min((right - left) * wide, (last + 1 - first) / ROWS * shape); // of the box, heights of the picture across
      if (size > most) most = size, best = [left, first / ROWS, right, (last + 1) / ROWS];
    }
  }
  return best;
}

// True if nobody has placed the layer since the page did, on which content is put.
function isFree({place, given, source, on}, content) {
  const first = on !== null || (content instanceof TextContent && !(source instanceof TextContent)), now = JSON.stringify(place);
  return now === given || (first && now === JSON.stringify(newPlace()));
}

// Places a layer where its source is seen: on its surface, a text otherwise where the object is widest. Patterns of the capture
// and what has no shape of its own fill the picture.
function putWhereSeen(app, projector, layer) {
  const {source, on} = layer, {size} = source, device = app.frameOf(projector), isText = source instanceof TextContent, onSurface = !!app.relief.find(on);
  layer.place = newPlace();
  if (size && source.pattern === undefined && (onSurface || (!app.scene.whole && (isText || layer.added)))) {
    const part = isText && !onSurface ? widestPart(app.scene.splats, device, size[0] / size[1]) : partFor(app, layer, device);
    if (part) layer.place = placeInPart(layer.frame(device.width, device.height), part);
  }
  layer.given = JSON.stringify(layer.place);
}

const seconds = (t) => `${Math.floor(t / 60)}:${(t % 60).toFixed(1).padStart(4, '0')}`;

function buildText(app) {
  const text = $('text'), font = $('font'), colour = $('text-colour');
  const write = () => {
    if (text.value || app.projector.content instanceof TextContent) app.setContent(new TextContent(text.value, colour.value, font.value));
  };
  for (const name of FONTS) font.append(element('option', {value: name, textContent: name}));
  const more = element('option', {value: '', textContent: 'all fonts…'});
  if ('queryLocalFonts' in window) font.append(more);
  font.onchange = attempt(async () => {
    if (font.value) return write();
    const names = new Set((await queryLocalFonts()).map(({family}) => family).filter((name) => FONT_NAME.test(name)));
    more.remove();
    for (const name of names) font.append(element('option', {value: name, textContent: name}));
    say(`${names.size} fonts of this computer are in the list.`);
  });
  text.oninput = colour.oninput = write;
  app.listeners.push((what) => {
    const {content} = app.projector;
    if ((what !== 'content' && what !== 'projector') || !(content instanceof TextContent)) return;
    if (![...font.options].some(({value}) => value === content.font)) font.prepend(element('option', {value: content.font, textContent: content.font}));
    font.value = content.font, colour.value = content.colour;
    if (document.activeElement !== text) text.value = content.text;
  });
  return (value) => { text.value = clipText(value); write(); };
}

// Sound, part and position of the selected layer's film.
function buildFilm(app) {
  const film = () => app.projector.layer.film, video = () => app.projector.content.video;
  const of = (name) => ({get: () => film()[name], set: (value) => {
    film()[name] = value;
    app.projector.dirty = true;
    app.invalidate();
  }});
  const isFilm = () => !!video() && !(app.projector.content instanceof StreamContent);
  const volume = of('volume');
  bind(app, 'volume', volume.get, volume.set, () => `${Math.round(100 * film().volume)} %`);
  for (const [id, name] of [['film-from', 'from'], ['film-to', 'to']]) {
    const {get, set} = of(name), input = $(id), show = () => { if (document.activeElement !== input) input.value = get() ? Math.round(1000 * get()) / 1000 : ''; };
    input.oninput = () => set(clamp(Number(input.value) || 0, 0, 1e6));
    $(`${id}-now`).onclick = () => { set(video().currentTime); app.changed('layers'); };
    app.listeners.push((what) => { if (what !== 'drawn') show(); });
  }
  const seek = $('seek'), toggle = $('film-toggle');
  seek.oninput = () => { video().currentTime = Number(seek.value) / 1000 * (video().duration || 0); };
  toggle.onclick = () => app.projector.content.toggle();
  app.listeners.push(() => {
    $('film').hidden = !isFilm();
    if (!isFilm()) return;
    const {currentTime, duration, paused} = video();
    if (document.activeElement !== seek) seek.value = 1000 * currentTime / (duration || 1);
    seek.nextElementSibling.textContent = seconds(currentTime);
    toggle.textContent = paused ? 'Play' : 'Pause';
  });
}
