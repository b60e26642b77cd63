'use strict';
// The object's shape as devices see it, for surfaces (surfaces.js) and effects (effects.js). A projector's layers lie in the
// picture of a device: of the projector itself, or, where it is corrected, of the camera that it is corrected for. Masks and
// effects are made for that device, so that they lie on the same places of the object either way.

const SURFACE_SIDE = 800, EFFECT_SIDE = 2048, ROUGH_SIDE = 400; // longer sides, pixels; while things move
const RELIEFS = 8, MASKS = 128;               // kept: of each surface for three devices
const BEND_SHARE = 0.016, BENDS = [0.1, 0.3]; // of the longer side; 1 - cosine of the angle across it: where a crease goes on, where there is one
const OUTLINE = 2;                            // of crease.frag
const CREASE_SHARE = 0.035;                   // of the longer side: shorter ones are noise
const CREASE_REACH = 0.035;                   // radii to which lines on creases reach

// Of a map's lines (ridge.frag) the outlines, and creases that are long, somewhere sharp, and `apart` pixels from any outline: bytes
// for near.frag.
function clearLines(texels, width, height, apart) {
  const bytes = new Uint8Array(texels.length), seen = new Uint8Array(width * height), least = CREASE_SHARE * Math.max(width, height), size = {width, height};
  const beside = new Uint8Array(width * height); // an outline
  let wave = [];
  for (let i = 0; i < beside.length; i++) if (texels[4 * i] >= OUTLINE) beside[i] = 1, wave.push(i);
  for (let step = 0; step < apart; step++) {
    const next = [];
    for (const i of wave) for (const j of sides(size, i)) if (j >= 0 && !beside[j]) beside[j] = 1, next.push(j);
    wave = next;
  }
  const isLine = (i) => texels[4 * i + 3] === 1 && (!beside[i] || texels[4 * i] >= OUTLINE);
  for (let first = 0; first < seen.length; first++) {
    if (texels[4 * first + 3] > 0 && !isLine(first)) bytes[4 * first + 3] = 128;
    if (seen[first] || !isLine(first)) continue;
    const line = [first];
    seen[first] = 1;
    for (let k = 0; k < line.length; k++) for (const j of neighbours(size, line[k], 2)) if (!seen[j] && isLine(j)) seen[j] = 1, line.push(j);
    const clear = line.length >= least && line.some((i) => texels[4 * i] >= BENDS[1]);
    for (const i of line) bytes[4 * i + 3] = clear ? 255 : 128;
  }
  return bytes;
}

// From where to where values go, without this share of them at each end.
function endsOf(values, share) {
  values.sort((a, b) => a - b);
  const [low, high] = [share, 1 - share].map((at) => values[Math.floor(at * (values.length - 1))] || 0);
  return high > low ? [low, high] : [low, low + 1];
}

// The entry of a list that is wanted, first in it from now on; null: there is none.
function keptIn(list, is) {
  const at = list.findIndex(is);
  if (at > 0) list.unshift(...list.splice(at, 1));
  return at < 0 ? null : list[0];
}

class Relief {
  constructor(renderer, up) {
    Object.assign(this, {renderer, up, views: [], masks: [], surfaces: [], sound: new Sound(), rough: false});
    this.heights = this.heightsOf(renderer.scene);
  }

  // The show's time in seconds, which a page that is loaded again goes on with.
  clock() { return (performance.timeOrigin + performance.now()) / 1000; }

  // From where to where the splats go, relative to the centre, in radii.
  heightsOf({splats: {count, centre, opacity}, centre: middle, radius}) {
    const values = [];
    for (let i = 0; i < count; i += Math.floor(count / 8000) + 1)
      if (opacity[i] >= SOLID) values.push(dot3(this.up, [0, 1, 2].map((k) => (centre[3 * i + k] - middle[k]) / (radius || 1))));
    return endsOf(values, 0.005);
  }

  // A device's picture in pixels of about this many on the longer side: textures of relief.frag, kept while it does not move.
  view(device, side) {
    const most = Math.min(side, this.rough ? ROUGH_SIDE : side), key = JSON.stringify([device, most]), kept = keptIn(this.views, (view) => view.key === key);
    if (kept) return kept;
    const {renderer} = this, {graphics, scene} = renderer, {gl} = graphics, small = shadowDevice(device, most), depth = renderer.centreDepth(small);
    const sums = graphics.target(small.width, small.height, renderer.sumFormats);
    const target = graphics.target(small.width, small.height, [gl.RGBA32F, gl.RGBA16F, gl.RGBA16F]);
    renderer.rasterise(sums, small, depth, 'splats.frag');
    graphics.fill(target, ['gbuffer.glsl', 'relief.frag'], {...sumUniforms(sums, depth), ...deviceUniforms('camera', small), u_centre: scene.centre, u_radius: scene.radius || 1});
    graphics.free(sums);
    const view = {key, device: small, target};
    this.views.unshift(view);
    for (const old of this.views.splice(RELIEFS)) for (const each of [old.target, old.near]) graphics.free(each);
    return view;
  }

  // True if that takes no time.
  knows(device) { return this.views.some(({key}) => key === JSON.stringify([device, SURFACE_SIDE])); }

  // The same as numbers, for surfaces.js.
  field(device) {
    const view = this.view(device, SURFACE_SIDE), {graphics, scene} = this.renderer, {width, height} = view.device;
    if (!view.field) {
      const [place, normal, albedo] = [0, 1, 2].map((k) => graphics.readFloats(view.target, k));
      view.field = {width, height, device: view.device, centre: scene.centre, radius: scene.radius || 1, place, normal, albedo};
    }
    return view.field;
  }

  find(id) { return this.surfaces.find((surface) => surface.id === id); }

  // A surface in a device's picture: {field, inside}, as growSurface has it.
  region(surface, device) {
    const key = JSON.stringify([device, this.rough]), kept = keptIn(this.masks, (mask) => mask.parts === surface.parts && mask.key === key);
    if (kept) return kept;
    const field = this.field(device), made = {parts: surface.parts, key, field, inside: growSurface(field, surface)};
    this.masks.unshift(made);
    this.masks.splice(MASKS);
    return made;
  }

  // A canvas whose alpha is how much of each pixel belongs to a surface.
  mask(surface, device, width, height) {
    const region = this.region(surface, device), {field, inside} = region, kept = region.canvas;
    if (kept && kept.width === width && kept.height === height) return kept;
    const small = makeCanvas(field.width, field.height), image = new ImageData(field.width, field.height);
    softMask(field, inside).forEach((share, i) => { image.data[4 * i + 3] = 255 * share; });
    small.getContext('2d').putImageData(image, 0, 0);
    region.canvas = makeCanvas(width, height);
    const context = region.canvas.getContext('2d', {willReadFrequently: true}), steeper = Math.max(1, 1.2 * width / field.width);
    context.imageSmoothingQuality = 'high';
    context.drawImage(small, 0, 0, width, height);
    const whole = context.getImageData(0, 0, width, height), {data} = whole; // edges as wide as the picture's pixels ask for
    for (let i = 3; i < data.length; i += 4) if (data[i] && data[i] < 255) data[i] = 127.5 + steeper * (data[i] - 127.5);
    context.putImageData(whole, 0, 0);
    return region.canvas;
  }

  // The nearest crease or outline of each pixel.
  nearCrease(view) {
    if (view.near) return view.near.textures[0];
    const {graphics} = this.renderer, {gl} = graphics, {width, height} = view.device, [u_place, u_normal] = view.target.textures, longer = Math.max(width, height);
    const bend = graphics.target(width, height, [gl.RGBA16F]), ridge = graphics.target(width, height, [gl.RGBA16F]);
    const apart = Math.max(2, Math.round(BEND_SHARE * longer));
    graphics.fill(bend, ['crease.frag'], {u_place, u_normal, u_reach: apart});
    graphics.fill(ridge, ['ridge.frag'], {u_place, u_bend: bend.textures[0], u_least: BENDS[0]});
    const lines = graphics.texture(width, height, gl.RGBA8);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, clearLines(graphics.readFloats(ridge), width, height, apart));
    const {fx} = view.device, depth = Math.max(this.renderer.centreDepth(view.device), 1e-6), reach = Math.max(4, CREASE_REACH * (this.renderer.scene.radius || 1) * fx / depth);
    view.near = findNear(graphics, lines, view.device, [reach, 4], null);
    gl.deleteTexture(lines);
    for (const each of [bend, ridge]) graphics.free(each);
    return view.near.textures[0];
  }

  // From where to where it goes away from an eye, in radii, of what a device sees.
  depthsOf({target}, eye) {
    const texels = this.renderer.graphics.readFloats(target), away = [];
    for (let i = 0; i < texels.length; i += 4 * 7) if (texels[i + 3] >= SOLID) away.push(Math.hypot(texels[i] - eye[0], texels[i + 1] - eye[1], texels[i + 2] - eye[2]));
    return endsOf(away, 0.002);
  }

  // A canvas with an effect's light in a device's picture.
  effect(content, device, width, height) {
    const view = this.view(device, Math.min(EFFECT_SIDE, Math.max(width, height))), {graphics, scene} = this.renderer, {width: w, height: h} = view.device, {values} = content;
    const eye = scale3(sub3(positionOf(device.pose), scene.centre), 1 / (scene.radius || 1)), [u_place, u_normal] = view.target.textures, {kind} = EFFECTS[content.effect];
    if (kind === EFFECTS.sweep.kind && !view.depths) view.depths = this.depthsOf(view, eye);
    this.target = graphics.fit(this.target, w, h, [graphics.gl.RGBA8]);
    graphics.fill(this.target, ['effect.frag'], {
      u_place, u_normal, u_near: kind === EFFECTS.creases.kind ? this.nearCrease(view) : null, u_kind: kind, u_phase: content.phaseAt(this.clock()), u_size: values.size,
      u_level: kind === EFFECTS.pulse.kind ? this.sound.level * 2 ** values.speed : 0, u_colour: [1, 3, 5].map((at) => parseInt(content.colour.slice(at, at + 2), 16) / 255),
      u_eye: eye, u_up: this.up, u_heights: this.heights, u_depths: view.depths || [0, 1],
    });
    const drawn = scratch('effect', w, h);
    drawn.putImageData(new ImageData(graphics.readBytes(this.target), w, h), 0, 0);
    return drawn.canvas;
  }
}
