'use strict';
// Draws a view: splats into G-buffers, shadow maps, each projector's light, the picture. The steps and their
// names are those of engine/render/pass.c; the shaders contain the formulas.

const SAMPLES_MAX = 1 << 24; // of a frame, 64 bytes each: 1 GB

// Samples per side of a pixel and share of the resolution for a picture of this size: first the number of samples
// is reduced, then that of pixels.
function affordable(width, height, side, sideMax) {
  const fits = (n) => Math.max(width, height) * n <= sideMax && width * height * n * n <= SAMPLES_MAX;
  while (side > 1 && !fits(side)) side--;
  return {side, scale: fits(side) ? 1 : Math.min(sideMax / width, sideMax / height, Math.sqrt(SAMPLES_MAX / (width * height)))};
}

// The pattern that a projector shows, with its mip map.
class PatternTexture {
  constructor(graphics, width, height) {
    const {gl} = graphics;
    this.graphics = graphics;
    this.width = width, this.height = height;
    this.levels = Math.floor(Math.log2(Math.max(width, height))) + 1;
    this.texture = graphics.texture(width, height, gl.SRGB8_ALPHA8, this.levels);
    this.version = 0; // counts its changes
  }

  // After its pixels were drawn.
  changed() {
    const {gl} = this.graphics;
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.generateMipmap(gl.TEXTURE_2D);
    this.version++;
  }

  // `source`: a canvas of the texture's size. Colours are multiplied by alpha, or stay as they are.
  set(source, premultiply = true) {
    const {graphics} = this, {gl} = graphics;
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    graphics.unpack(premultiply, () => gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, gl.RGBA, gl.UNSIGNED_BYTE, source));
    this.changed();
  }

  // Draws a program over it.
  draw(fragments, values) {
    const {graphics, width, height} = this, {gl} = graphics, framebuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.texture, 0);
    graphics.fill({framebuffer, width, height}, fragments, values);
    gl.deleteFramebuffer(framebuffer);
    this.changed();
  }

  // Draws another one of its size over it, by a share.
  lay(other, share) {
    const {gl} = this.graphics;
    gl.enable(gl.BLEND);
    gl.blendColor(0, 0, 0, share);
    gl.blendFunc(gl.CONSTANT_ALPHA, gl.ONE_MINUS_CONSTANT_ALPHA);
    this.draw(['copy.frag'], {u_source: other.texture});
    gl.disable(gl.BLEND);
  }

  free() { this.graphics.gl.deleteTexture(this.texture); }
}

// ffp_outline_deviation: how far outlines are smoothed, in pixels; 0 where these are about as coarse as the photographs'.
function outlineDeviation({count, centre, scale}, {pose, fx}) {
  const axis = axisOf(pose, 2), offset = dot3(axis, positionOf(pose)), sizes = [];
  for (let i = 0; i < count; i += Math.floor(count / 4096) + 1) {
    const z = axis[0] * centre[3 * i] + axis[1] * centre[3 * i + 1] + axis[2] * centre[3 * i + 2] - offset;
    const [a, b, c] = scale.map((column) => column[i]);
    if (z > 0) sizes.push(Math.max(Math.min(a, b), Math.min(Math.max(a, b), c)) * fx / z);
  }
  const deviation = sizes.length ? 2 / 3 * sizes.sort((a, b) => a - b)[sizes.length >> 1] : 0;
  return deviation < 0.4 ? 0 : Math.min(deviation, 4);
}

// A G-buffer's uniforms for gbuffer.glsl.
function sumUniforms({textures: [u_g0, u_g1, u_g2, u_g3, u_g4 = null]}, u_depth) { return {u_g0, u_g1, u_g2, u_g3, u_g4, u_depth}; }

// The view of one camera, rasterised once: the samples' G-buffer and its means. Kept while nothing changes.
class GbufferView {
  constructor(renderer) { this.renderer = renderer, this.targets = []; }

  draw(camera, side) {
    const key = JSON.stringify([camera, side]);
    if (key === this.key) return;
    const {renderer, targets} = this;
    this.key = ''; // until all is drawn
    // one for each number of samples, so that moving and resting do not take turns at allocating
    targets[side] = renderer.graphics.fit(targets[side], camera.width * side, camera.height * side, renderer.sumFormats);
    this.samples = targets[side];
    this.device = sampleDevice(camera, side), this.camera = camera, this.side = side;
    this.depth = renderer.centreDepth(camera);
    this.deviation = side > 1 && renderer.settings.smooth ? outlineDeviation(renderer.scene.splats, camera) : 0;
    renderer.counts.splats = renderer.rasterise(this.samples, this.device, this.depth, 'splats.frag');
    renderer.counts.samples = this.samples.width * this.samples.height;
    this.key = key;
    this.averaged = false;
  }

  // Of the samples, or of the means.
  uniforms(target = this.samples) {
    return {...sumUniforms(target, this.depth), u_side: target === this.samples ? this.side : 1};
  }

  // ffp_view_pass_gbuffer: means over the samples of each pixel.
  mean() {
    const {renderer, camera} = this, format = renderer.sumFormat;
    if (this.side === 1) return this.samples;
    if (!this.averaged) {
      this.means = renderer.graphics.fit(this.means, camera.width, camera.height, [format, format, format, format]);
      renderer.graphics.fill(this.means, ['average.frag'], this.uniforms());
      this.averaged = true;
    }
    return this.means;
  }

  // The depth of what pixel (x, y) shows, 0 where there is nothing.
  depthUnder(x, y) {
    if (!this.samples || !(x >= 0 && y >= 0 && x < this.camera.width && y < this.camera.height)) return 0;
    const at = (v) => Math.floor(v * this.side);
    const texel = this.renderer.graphics.readFloats(this.samples, 0, at(x), at(y), 1, 1);
    return texel[3] >= 0.5 ? texel[0] / texel[3] + this.depth : 0;
  }
}

// A pattern through a Gaussian of this deviation, pixels of it, in a smaller picture: from the mip level whose texels are at most
// two thirds of the deviation. Means over a texel have a twelfth of its square as variance, and the straight lines between them
// twice that.
function drawWide(graphics, pattern, deviation, kept) {
  const {gl} = graphics, u_mip = clamp(Math.floor(Math.log2(deviation / 1.5)), 0, pattern.levels - 1), texel = 2 ** u_mip;
  const size = [pattern.width, pattern.height].map((side) => Math.max(1, side >> u_mip)), u_deviation = Math.sqrt(deviation ** 2 - texel ** 2 / 4) / texel;
  const wide = graphics.fit(kept, ...size, [gl.RGBA16F]), across = graphics.target(...size, [gl.RGBA16F]);
  graphics.fill(across, ['wide.frag'], {u_from: pattern.texture, u_mip, u_along: [1, 0], u_deviation});
  graphics.fill(wide, ['wide.frag'], {u_from: across.textures[0], u_mip: 0, u_along: [0, 1], u_deviation});
  graphics.free(across);
  gl.bindTexture(gl.TEXTURE_2D, wide.textures[0]);
  for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.LINEAR);
  return wide;
}

class Renderer {
  constructor(graphics, scene) {
    this.graphics = graphics;
    this.scene = scene;
    this.settings = scene.drawing;
    this.sorter = new DepthSorter(scene.splats);
    this.counts = {};
    this.sumFormat = graphics.float32 ? graphics.gl.RGBA32F : graphics.gl.RGBA16F;
    this.scatters = !!scene.splats.scattered && this.findFifth();
    graphics.defines = this.scatters ? '#define SCATTERS\n' : '';
    this.view = new GbufferView(this);
    this.upload(scene.splats);
  }

  // A G-buffer with scattered light has a fifth texture; all are of 16 bits where the driver does not draw into so many of 32.
  findFifth() {
    const {graphics} = this, {gl} = graphics;
    for (const format of gl.getParameter(gl.MAX_DRAW_BUFFERS) < 5 ? [] : [this.sumFormat, gl.RGBA16F])
      if (graphics.draws(Array(5).fill(format))) {
        this.sumFormat = format;
        return true;
      }
    console.info('Scattered light is not shown: this graphics driver draws into fewer than five textures at once.');
    return false;
  }

  // Of a G-buffer's textures.
  get sumFormats() { return Array(this.scatters ? 5 : 4).fill(this.sumFormat); }

  upload(s) {
    const {graphics} = this, {gl} = graphics, n = s.count, rows = Math.ceil((n + 1) / ROW);
    if (rows > gl.getParameter(gl.MAX_TEXTURE_SIZE))
      throw new Error(`This graphics driver cannot hold ${n} splats.`);
    const put = (columns) => {
      const texels = new Float32Array(4 * ROW * rows);
      columns.forEach((column, k) => { for (let i = 0; i < n; i++) texels[4 * i + k] = column(i); });
      const texture = graphics.texture(ROW, rows, gl.RGBA32F);
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, ROW, rows, gl.RGBA, gl.FLOAT, texels);
      return texture;
    };
    const of = (column) => (i) => column[i];
    this.splats = {
      u_centres: put([0, 1, 2].map((k) => (i) => s.centre[3 * i + k]).concat(of(s.opacity))),
      u_scales: put([...s.scale, s.roughness].map(of)),
      u_rotations: put(s.rotation.map(of)),
      u_albedos: put(s.albedo.map(of)),
      u_ambients: put(s.ambient.map(of)),
      u_scattereds: this.scatters ? put(s.scattered.map(of)) : null,
    };
    this.order = graphics.texture(ROW, rows, gl.R32UI);
    this.makeQuads(n);
  }

  // Two triangles a splat in one draw: vertices 4 i to 4 i + 3 are the corners of the i-th of the order.
  makeQuads(n) {
    const {gl} = this.graphics, corners = new Uint32Array(6 * Math.max(1, n));
    for (let i = 0; i < n; i++)
      [0, 1, 2, 2, 1, 3].forEach((corner, k) => { corners[6 * i + k] = 4 * i + corner; });
    this.quads = gl.createVertexArray();
    gl.bindVertexArray(this.quads);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, corners, gl.STATIC_DRAW);
  }

  // Sorts for a device and hands the order to the shaders; returns how many splats are in front of it.
  putOrder(pose) {
    const {gl} = this.graphics, count = this.sorter.sort(pose), rows = Math.ceil(count / ROW);
    gl.bindTexture(gl.TEXTURE_2D, this.order);
    if (rows)
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, ROW, rows, gl.RED_INTEGER, gl.UNSIGNED_INT, this.sorter.order);
    return count;
  }

  // ffp_rasterise: sums of what `device` sees, depths counted from `depth`. Of a picture larger than the target, the part
  // that begins at `corner`.
  rasterise(target, device, depth, fragment, corner = [0, 0]) {
    const {graphics, settings} = this, {gl} = graphics;
    const count = this.putOrder(device.pose);
    graphics.clear(target);
    gl.viewport(-corner[0], -corner[1], device.width, device.height);
    gl.bindVertexArray(this.quads);
    graphics.use(graphics.program('splats.vert', [fragment]), {
      ...this.splats, u_order: this.order, ...deviceUniforms('camera', device), u_blur: settings.blur, u_firmness: settings.firmness,
      u_compensation: settings.compensation, u_depth: depth, u_corner: corner,
    });
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.drawElements(gl.TRIANGLES, 6 * count, gl.UNSIGNED_INT, 0);
    gl.disable(gl.BLEND);
    return count;
  }

  centreDepth(device) {
    return dot3(axisOf(device.pose, 2), sub3(this.scene.centre, positionOf(device.pose)));
  }

  // True if this projector casts shadows: those of one at the baked light are in the albedo (ffp_shadows_are_baked).
  castsShadows(projector) {
    const {baked} = this.scene;
    return this.settings.shadows &&
           !(baked && length3(sub3(positionOf(projector.device.pose), baked.light)) <= baked.within);
  }

  // ffp_shadow_map; `projector` keeps it while it stays where it is.
  drawShadow(projector) {
    const key = JSON.stringify(projector.device);
    if (!this.castsShadows(projector) || key === projector.shadowKey) return;
    const device = shadowDevice(projector.device, this.settings.shadow_side);
    projector.shadow = this.graphics.fit(projector.shadow, device.width, device.height, [this.sumFormat]);
    projector.shadowDepth = this.centreDepth(projector.device);
    this.rasterise(projector.shadow, device, projector.shadowDepth, 'shadow.frag');
    projector.shadowKey = key;
  }

  // ffp_lit_box: middle and size, in the pattern's pixels, of the box around the splats' centres.
  litBox(grid) {
    const {count, centre} = this.scene.splats, size = [grid.width, grid.height], low = [...size], high = [0, 0];
    const [right, down, ahead] = [0, 1, 2].map((k) => axisOf(grid.pose, k)), [x, y, z] = positionOf(grid.pose);
    for (let i = 0; i < 3 * count; i += 3) {
      const a = centre[i] - x, b = centre[i + 1] - y, c = centre[i + 2] - z, depth = ahead[0] * a + ahead[1] * b + ahead[2] * c;
      if (!(depth > 0)) continue;
      const u = grid.cx + grid.fx * (right[0] * a + right[1] * b + right[2] * c) / depth, v = grid.cy + grid.fy * (down[0] * a + down[1] * b + down[2] * c) / depth;
      low[0] = Math.min(low[0], u), high[0] = Math.max(high[0], u), low[1] = Math.min(low[1], v), high[1] = Math.max(high[1], v);
    }
    const box = [0, 1].map((k) => [Math.max(low[k], 0), Math.min(high[k], size[k])]);
    if (box.some(([from, to]) => !(to > from))) return [size[0] / 2, size[1] / 2, ...size];
    return [...box.map(([from, to]) => (from + to) / 2), ...box.map(([from, to]) => to - from)];
  }

  // The light that spreads around what a projector shows, and the level of what is scattered; kept while its pattern stays.
  drawSpread(projector) {
    const {graphics} = this, {gl} = graphics, {pattern, grid, spread, spreads} = projector;
    const key = JSON.stringify([pattern.version, spreads, this.scatters ? grid : null]);
    if (key === projector.spreadKey) return;
    projector.spreadKey = key;
    if (spreads) projector.wide = drawWide(graphics, pattern, spread.deviation * grid.width / projector.device.width, projector.wide);
    if (!this.scatters) return;
    const place = JSON.stringify(grid);
    if (projector.litPlace !== place) projector.litPlace = place, projector.lit = this.litBox(grid);
    projector.level = graphics.fit(projector.level, 1, 1, [gl.RGBA16F]);
    graphics.fill(projector.level, ['gbuffer.glsl', 'light.glsl', 'level.frag'], {...this.patternUniforms(projector), ...deviceUniforms('projector', grid), u_lit: projector.lit});
  }

  patternUniforms({pattern, spreads, spread, wide, level}) {
    return {
      u_pattern: pattern.texture, u_levels: pattern.levels, u_wide: spreads ? wide.textures[0] : null,
      u_spread: spreads ? spread.share : [0, 0, 0], u_level: level ? level.textures[0] : null,
    };
  }

  lightUniforms(projector, camera) {
    const shadows = this.castsShadows(projector);
    return {
      ...deviceUniforms('camera', camera), ...deviceUniforms('projector', projector.grid),
      u_shadow: shadows ? projector.shadow.textures[0] : null,
      u_shadow_depth: projector.shadowDepth || 0, u_shadow_bias: this.settings.shadow_bias,
      u_shadows: shadows, u_footprint: this.settings.footprint,
      ...this.patternUniforms(projector), u_brightness: projector.brightness,
      u_intensity: scale3(this.scene.intensity, projector.brightness), u_black: this.black || 0,
    };
  }

  // ffp_view_pass_draw and _shade for any number of projectors: the mean radiance of each pixel.
  drawLight(camera, side, projectors, ambient) {
    const {graphics} = this, {gl} = graphics;
    for (const projector of projectors) this.drawShadow(projector), this.drawSpread(projector);
    this.view.draw(camera, side);
    this.light = graphics.fit(this.light, camera.width, camera.height, [gl.RGBA16F]);
    graphics.fill(this.light, ['ambient.frag'], {...this.view.uniforms(), u_ambient: ambient ? 1 : 0});
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE);
    for (const projector of projectors)
      graphics.fill(this.light, ['gbuffer.glsl', 'light.glsl', 'shade.frag'],
                    {...this.view.uniforms(), ...this.lightUniforms(projector, this.view.device)});
    gl.disable(gl.BLEND);
  }

  // Into a target, or the canvas (null).
  resolve(target, exposure) {
    const {width, height} = this.view.camera;
    this.graphics.fill(target, ['resolve.frag'], {
      u_mean: this.light.textures[0], u_side: this.view.side, u_exposure: exposure, u_deviation: this.view.deviation, u_flip: !target, u_size: [width, height],
    }, width, height);
  }

  showMap(target, map) {
    const {width, height} = this.view.camera;
    const mean = this.view.mean(), radius = this.scene.radius || 1;
    const range = map === 1 ? this.depthRange(mean) : [this.view.depth - radius, this.view.depth + radius];
    this.graphics.fill(target, ['gbuffer.glsl', 'maps.frag'], {
      ...this.view.uniforms(mean), u_map: map, u_range: range, u_flip: !target, u_size: [width, height],
    }, width, height);
  }

  // Nearest and farthest depth, as depth_picture in product/api/relight.c finds them.
  depthRange(mean) {
    const texels = this.graphics.readFloats(mean);
    let near = Infinity, far = 0;
    for (let i = 0; i < texels.length; i += 4)
      if (texels[i + 3] >= 0.5) {
        const z = texels[i] / texels[i + 3] + this.view.depth;
        near = Math.min(near, z), far = Math.max(far, z);
      }
    return far > near ? [near, far] : [near, near + 1];
  }

  // The albedo that a device sees, RGBA bytes with row 0 on top.
  albedoSeen(device) {
    const {graphics} = this, {width, height} = device, u_depth = this.centreDepth(device);
    const sums = graphics.target(width, height, this.sumFormats), shot = graphics.target(width, height, [graphics.gl.RGBA8]);
    this.rasterise(sums, device, u_depth, 'splats.frag');
    graphics.fill(shot, ['gbuffer.glsl', 'maps.frag'], {...sumUniforms(sums, u_depth), u_map: 3, u_range: [0, 1], u_flip: false, u_size: [width, height]});
    const data = graphics.readBytes(shot);
    for (const target of [sums, shot]) graphics.free(target);
    return data;
  }

  // The picture as numbers: RGBA bytes, row 0 on top.
  picture(camera, side, projectors, ambient, exposure, map = null) {
    const {graphics} = this;
    this.drawLight(camera, side, projectors, ambient);
    this.shot = graphics.fit(this.shot, camera.width, camera.height, [graphics.gl.RGBA8]);
    if (map === null) this.resolve(this.shot, exposure); else this.showMap(this.shot, map);
    return graphics.readBytes(this.shot);
  }
}
