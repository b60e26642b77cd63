'use strict';
// A projector shows layers, the last one on top: each has a source (contents.js), a place (place.js), and of a film
// the sound and the part that is played; `on` is the surface (surfaces.js) that it is confined to, by its id, or null.

const LAYERS_MAX = 16, WARP_MAX = 4096; // of a pulled source, pixels a side
const newFilm = () => ({volume: 1, from: 0, to: 0}); // seconds; to 0: to its end

class Layer {
  constructor(source, {fit = 'contain', place = newPlace(), film = newFilm(), on = null} = {}) {
    this.source = source, this.fit = fit, this.place = structuredClone(place), this.film = {...film}, this.on = on;
  }
  frame(width, height) { return layerFrame(this.place, this.source.size, this.fit, width, height); }
}

// An empty canvas by its name, made again only for another size.
const scratches = {};
function scratch(name, width, height) {
  const kept = scratches[name];
  if (!kept || kept.width !== width || kept.height !== height) scratches[name] = makeCanvas(width, height);
  const context = scratches[name].getContext('2d');
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.clearRect(0, 0, width, height);
  return context;
}

// The source in a box at the origin, without what crop and mask take away.
function paintCut(context, {source, place}, width, height) {
  const parts = [...(place.crop.some(Boolean) ? [cropped(place)] : []), ...(place.mask && place.mask.length > 2 ? [place.mask] : [])];
  if (parts.length && place.feather > 0) return paintFeathered(context, source, parts, place.feather * Math.min(width, height), width, height);
  context.save();
  for (const points of parts) context.clip(polygonOf(points, width, height));
  source.paint(context, width, height);
  context.restore();
}

function polygonOf(points, width, height) {
  const path = new Path2D();
  points.forEach(([u, v], k) => k ? path.lineTo(u * width, v * height) : path.moveTo(u * width, v * height));
  path.closePath();
  return path;
}

// A part whose points on the box's edge lie outside it: there nothing is cut.
function reachingOut(points, u, v) {
  const out = (x, by) => x <= 0 ? x - by : x >= 1 ? x + by : x;
  return points.map(([x, y]) => [out(x, u), out(y, v)]);
}

// The same with soft edges where something is cut, `wide` pixels: the parts are blurred, and what they leave is kept. Where a
// browser has no blur they stay hard.
function paintFeathered(context, source, parts, wide, width, height) {
  const [w, h] = [width, height].map((side) => clamp(Math.ceil(side), 1, WARP_MAX)), whole = scratch('feathered', w, h), mask = scratch('mask', w, h);
  source.paint(whole, w, h);
  for (const points of parts) {
    mask.clearRect(0, 0, w, h);
    mask.filter = `blur(${wide * Math.max(w / width, h / height) / 4}px)`; // four deviations
    mask.fill(polygonOf(reachingOut(points, wide / width, wide / height), w, h));
    mask.filter = 'none';
    whole.globalCompositeOperation = 'destination-in';
    whole.drawImage(mask.canvas, 0, 0);
  }
  whole.globalCompositeOperation = 'source-over';
  context.drawImage(whole.canvas, 0, 0, width, height);
}

// A layer whose corners are pulled is drawn by the graphics driver, as a picture in perspective.
function drawPulled(graphics, context, layer, frame) {
  const {gl} = graphics, corners = cornersOf(frame), border = 2, {width, height} = frame;
  const long = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
  const [w, h] = [Math.max(long(corners[0], corners[1]), long(corners[3], corners[2])), Math.max(long(corners[0], corners[3]), long(corners[1], corners[2]))]
    .map((side) => clamp(Math.ceil(side), 1, WARP_MAX));
  const flat = scratch('flat', w + 2 * border, h + 2 * border);
  flat.translate(border, border);
  paintCut(flat, layer, w, h);
  graphics.warped = graphics.warped || gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, graphics.warped);
  graphics.unpack(true, () => gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, flat.canvas));
  gl.generateMipmap(gl.TEXTURE_2D);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
  graphics.warpTarget = graphics.fit(graphics.warpTarget, width, height, [gl.RGBA8]);
  graphics.clear(graphics.warpTarget);
  gl.viewport(0, 0, width, height);
  gl.bindVertexArray(graphics.empty);
  const m = homographyTo(corners);
  graphics.use(graphics.program('warp.vert', ['warp.frag']), {
    u_map: [m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]], u_size: [width, height], u_border: [border / w, border / h], u_source: graphics.warped,
  });
  gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  const drawn = scratch('warped', width, height);
  drawn.putImageData(new ImageData(graphics.readBytes(graphics.warpTarget), width, height), 0, 0);
  context.drawImage(drawn.canvas, 0, 0);
}

function drawStraight(context, layer, frame) {
  const {place} = layer, [w, h] = [frame.fitted[0] * place.width, frame.fitted[1] * place.height];
  context.save();
  context.translate(...middleOf(frame));
  context.rotate(place.turn * Math.PI / 180);
  context.translate(-w / 2, -h / 2);
  paintCut(context, layer, w, h);
  context.restore();
}

// An effect lies where the object is: of its place only what is cut away and how opaque it is count.
const unmoved = ({crop, mask, opacity, feather}) => ({...newPlace(), crop, mask, opacity, feather});

// An effect's layer as a picture for a device.
function effectLayer({source, place}, relief, device, width, height) {
  const picture = relief.effect(source, device, width, height);
  return new Layer({size: null, paint: (context, w, h) => context.drawImage(picture, 0, 0, w, h)}, {place: unmoved(place)});
}

// Draws layers over what a canvas shows, which is the picture of a device. `sound`: the share of their films' volumes.
function drawLayers(graphics, context, layers, width, height, relief, device, sound = 1) {
  for (const given of layers) {
    const layer = given.source instanceof EffectContent ? effectLayer(given, relief, device, width, height) : given;
    const frame = layer.frame(width, height), {opacity} = layer.place, surface = given.on === null ? null : relief.find(given.on);
    if (layer.source.video) layer.source.follow(layer.film, sound);
    const own = opacity < 1 || surface ? scratch('layer', width, height) : context; // patterns draw over themselves
    if (isPulled(layer.place)) drawPulled(graphics, own, layer, frame);
    else drawStraight(own, layer, frame);
    if (own === context) continue;
    if (surface) {
      own.globalCompositeOperation = 'destination-in';
      own.drawImage(relief.mask(surface, device, width, height), 0, 0);
      own.globalCompositeOperation = 'source-over';
    }
    context.save();
    context.globalAlpha = opacity;
    context.drawImage(own.canvas, 0, 0);
    context.restore();
  }
}
