'use strict';
// Choosing surfaces by hand, in the view and in the projector's picture; their list, and the controls of effects, in the panel.

const CLICK = 4; // CSS pixels that a click may move
const TINY = 100; // pixels of a field: below this, a message says that the surface is tiny

class Choosing {
  constructor(app) { Object.assign(this, {app, selected: null, tolerance: TOLERANCE, hovered: null}); }

  get on() { return this.app.mode === 'surface' || (this.app.mode === 'place' && this.app.flat.what === 'surface'); }
  get device() { return this.app.flat.device; } // in whose picture surfaces are looked for
  get field() { return this.app.relief.field(this.device); }
  get surface() { return this.app.relief.find(this.selected); }

  // The point of the object under a place on the screen, or under shares of the projector's picture; null: there is none.
  pointUnder([x, y]) {
    const {view} = this.app.renderer, ratio = view.camera.width / innerWidth, depth = view.depthUnder(x * ratio, y * ratio);
    return depth ? pointAt(view.camera, x * ratio, y * ratio, depth) : null;
  }
  pointInPicture([u, v]) {
    const {field} = this, i = Math.floor(v * field.height) * field.width + Math.floor(u * field.width);
    return u >= 0 && v >= 0 && u < 1 && v < 1 && isSolid(field, i) ? add3(field.centre, scale3(placeAt(field, i), field.radius)) : null;
  }

  // Shows the region that a click would choose.
  hover(point) {
    const {field, hovered} = this, i = point ? pixelOf(field, point) : -1;
    if (i >= 0 ? hovered && hovered.field === field && hovered.inside[i] : !hovered) return;
    const part = i >= 0 ? partAt(field, point, this.tolerance) : null;
    this.hovered = part && {field, inside: growSurface(field, {parts: [part]})};
    this.app.redrawOverlay();
    this.app.changed('hovered');
  }

  // Puts other surfaces in place of those of now, and draws what lies on them again.
  put(surfaces) {
    const {app} = this;
    app.relief.surfaces = surfaces, this.hovered = null;
    for (const projector of app.projectors) if (projector.isOnObject) projector.dirty = true;
    app.invalidate();
    app.changed('surfaces');
  }

  change(surface) { this.put(this.app.relief.surfaces.map((old) => old.id === surface.id ? surface : old)); }

  // A click: a known surface, or a new one; `add` (Shift) and `take` (Alt) change the selected one.
  choose(point, {shiftKey: add, altKey: take}) {
    const {app, field, surface} = this, {surfaces} = app.relief, part = point && partAt(field, point, this.tolerance, take);
    if (!point) return this.select(null);
    if (!part) throw new Message(`Projector ${app.projector.number} does not reach this place.`);
    const i = pixelOf(field, point), known = surfaces.find((one) => app.relief.region(one, this.device).inside[i]), changes = (add || take) && surface;
    if (known && !changes) return this.select(known.id);
    if (!countOf(growSurface(field, {parts: [{...part, take: false}]}))) throw new Message('No surface can be grown from this place: click beside it.');
    if (changes) {
      if (surface.parts.length >= PARTS_MAX) throw new Message(`A surface has at most ${PARTS_MAX} parts.`);
      return this.change({...surface, parts: [...surface.parts, withPoints(field, part)]});
    }
    if (surfaces.length >= SURFACES_MAX) throw new Message(`There are at most ${SURFACES_MAX} surfaces.`);
    const id = Math.max(0, ...surfaces.map((one) => one.id)) + 1;
    this.selected = id;
    this.put([...surfaces, {id, name: `Surface ${id}`, parts: [{...withPoints(field, part), take: false}]}]);
    const count = countOf(app.relief.region(this.surface, this.device).inside), pixels = count === 1 ? 'pixel' : 'pixels';
    say(count < TINY ? `Surface ${id} is tiny, ${count} ${pixels}: a higher Tolerance makes it larger.`
      : 'Shift-click adds to the surface, Alt-click takes away; Tolerance changes what was clicked last.');
  }

  select(id) {
    this.selected = id;
    this.app.redrawOverlay();
    this.app.changed('surfaces');
  }

  // Of the part that was clicked last.
  setTolerance(tolerance) {
    const {surface, field} = this, part = surface && surface.parts.at(-1);
    this.tolerance = tolerance;
    if (!part) return;
    const next = {...part, tolerance};
    this.change({...surface, parts: [...surface.parts.slice(0, -1), pixelOf(field, part.points[0]) < 0 ? next : withPoints(field, {...next, points: part.points.slice(0, 1)})]});
  }

  // Its layers lie on everything from now on.
  remove(id) {
    const {app} = this, free = (layer) => { if (layer.on === id) layer.on = null; };
    if (app.show.cues.some(({shown}) => shown.some(({layers}) => layers.some(({on}) => on === id)))) app.inShow('layers of its cues lie on this surface');
    for (const projector of app.projectors) {
      if (!projector.layers.some(({on}) => on === id)) continue;
      app.inShow('layers lie on this surface');
      projector.layers.forEach(free), projector.dirty = true;
    }
    for (const cue of app.show.cues) for (const {layers} of cue.shown) layers.forEach(free);
    this.put(app.relief.surfaces.filter((surface) => surface.id !== id));
    app.changed('content');
  }

  // Outlines to draw: {field, rim, colour, wide}.
  get outlines() {
    const {app, hovered} = this;
    if (!this.on) return [];
    if (app.dragged && !app.relief.knows(this.device)) { // until it rests
      clearTimeout(this.later);
      this.later = setTimeout(() => app.redrawOverlay(), 300);
      return [];
    }
    const of = (region, colour, wide) => {
      region.rim = region.rim || rimOf(region.field, region.inside);
      return {...region, colour, wide};
    };
    return [...app.relief.surfaces.map((surface) => of(app.relief.region(surface, this.device), surface.id === this.selected ? app.projector.colour : '#fff', surface.id === this.selected ? 3 : 1.5)),
      ...(hovered && hovered.field === this.field ? [of(hovered, '#fff', 2)] : [])];
  }

  // Draws them; `place` leads from the field's pixel positions, with a pixel beside them, to the canvas.
  drawOutlines(context, place, outlines = this.outlines) {
    for (const {field: {width}, inside, rim, colour, wide} of outlines) {
      const path = new Path2D();
      for (const [i, j] of rim) {
        if (j < 0) continue; // there the picture ends, not the surface
        const x = i % width, y = (i - x) / width, across = j === i - 1 || j === i + 1; // where they touch
        const from = across ? [j === i + 1 ? x + 1 : x, y] : [x, j === i + width ? y + 1 : y], to = across ? [from[0], y + 1] : [x + 1, from[1]];
        const within = inside[4 * i - 3 * j] ? 4 * i - 3 * j : i, [a, b] = place(from, within), [c, d] = place(to, within); // at the very end depths are uncertain
        path.moveTo(a, b), path.lineTo(c, d);
      }
      context.lineCap = 'round';
      for (const [style, w] of [['#000a', wide + 2], [colour, wide]]) {
        context.strokeStyle = style, context.lineWidth = w;
        context.stroke(path);
      }
      context.lineCap = 'butt';
    }
  }

  // Over the view, at their places on the object.
  drawInView(context) {
    const camera = this.app.screenCamera(), {outlines} = this, {field} = outlines[0] || {};
    if (!field) return;
    const eye = positionOf(field.device.pose), axis = axisOf(field.device.pose, 2);
    this.drawOutlines(context, ([x, y], i) => {
      const depth = dot3(axis, sub3(add3(field.centre, scale3(placeAt(field, i), field.radius)), eye));
      return project(camera, pointAt(field.device, x, y, depth)).slice(0, 2);
    }, outlines);
  }
}

// The list of surfaces, and the one that the selected layer is confined to.
function buildSurfaces(app) {
  const choosing = app.choosing = new Choosing(app), box = $('surfaces'), confined = $('surface-on');
  const press = (text, title, work) => element('button', {textContent: text, title, className: 'small', onclick: attempt(work)});
  const addLayer = (surface) => {
    if (app.projector.layers.length >= LAYERS_MAX) throw new Message(`A projector shows at most ${LAYERS_MAX} layers.`);
    const layer = new Layer(new SolidContent(PROJECTOR_COLOURS[surface.id % PROJECTOR_COLOURS.length]), {on: surface.id});
    layer.added = true, layer.given = JSON.stringify(layer.place);
    editLayers(app, (layers) => { app.projector.at = layers.push(layer) - 1; });
    choosing.select(surface.id);
  };
  const row = (surface) => {
    const name = element('input', {type: 'text', value: surface.name, maxLength: SURFACE_NAME_MAX, onfocus: () => { if (choosing.selected !== surface.id) choosing.select(surface.id); }});
    name.setAttribute('aria-label', `Name of surface ${surface.id}`);
    name.onchange = () => choosing.change({...app.relief.find(surface.id), name: name.value || `Surface ${surface.id}`});
    const item = element('li', {className: 'row'}, [name, press('+ layer', `A layer on ${surface.name}`, () => addLayer(surface)), press('×', `Remove ${surface.name}`, () => choosing.remove(surface.id))]);
    item.classList.toggle('chosen', surface.id === choosing.selected);
    return item;
  };
  const refresh = (what) => {
    if (what === 'surfaces' && !box.contains(document.activeElement)) box.replaceChildren(...app.relief.surfaces.map(row));
    else if (what === 'surfaces') app.relief.surfaces.forEach((surface, k) => { if (box.children[k]) box.children[k].classList.toggle('chosen', surface.id === choosing.selected); });
    if (what === 'surfaces' || what === 'content' || what === 'projector' || what === 'layers') {
      confined.replaceChildren(element('option', {value: '', textContent: 'everything'}), ...app.relief.surfaces.map(({id, name}) => element('option', {value: id, textContent: name})));
      confined.value = app.relief.find(app.projector.layer.on) ? app.projector.layer.on : '';
    }
  };
  confined.onchange = () => {
    const {projector} = app;
    projector.layer.on = confined.value === '' ? null : Number(confined.value), projector.dirty = true;
    app.endComparison(projector);
    app.invalidate();
    app.changed('content');
  };
  bind(app, 'tolerance', () => choosing.surface ? choosing.surface.parts.at(-1).tolerance : choosing.tolerance, (tolerance) => choosing.setTolerance(tolerance), () => `${Math.round(100 * $('tolerance').value)} %`);
  app.listeners.push(refresh);
  refresh('surfaces');
}

// Other values for an effect, as a layer's `film` has them for its film.
function turnEffect(app, projector, layer, values) {
  if (!(layer.source instanceof EffectContent)) return;
  layer.source = layer.source.with(values, app.relief.clock()), projector.dirty = true;
  app.endComparison(projector);
  app.invalidate();
  app.changed('layers');
}

function buildEffect(app) {
  const {sound} = app.relief, effect = () => app.projector.content instanceof EffectContent ? app.projector.content : null;
  const turn = (values) => turnEffect(app, app.projector, app.projector.layer, values);
  const shown = {
    speed: () => effect() && (effect().effect === 'pulse' ? stopsText(effect().values.speed) : `${effect().values.speed.toFixed(2)} /s`),
    size: () => effect() && `${Math.round(100 * effect().values.size)} %`,
  };
  for (const name of ['speed', 'size']) bind(app, `effect-${name}`, () => effect() ? effect().values[name] : 0, (value) => turn({[name]: value}), shown[name]);
  bind(app, 'effect-colour', () => effect() ? effect().colour : '#ffffff', (colour) => turn({colour}));
  $('microphone').onclick = attempt(async () => {
    if (sound.running) sound.stop(); else await sound.start();
    app.changed('layers');
  });
  app.listeners.push((what) => {
    if (what === 'drawn') return;
    $('effect').hidden = !effect();
    if (!effect()) return;
    EFFECTS[effect().effect].controls.forEach((label, k) => { $(['effect-speed', 'effect-size'][k]).previousElementSibling.textContent = label; });
    $('sound').hidden = effect().effect !== 'pulse';
    $('microphone').setAttribute('aria-pressed', sound.running);
    $('sound-told').textContent = {none: 'No sound: press it, or send /level', '/level': 'By /level', microphone: 'By the microphone'}[sound.told];
  });
}
