'use strict';
// The pattern that makes a camera see the projector's content on the object, in closed form (engine/apply/closed.c):
// 'colours' asks for the content's light times a gain, 'paint' for the look of the object between dark and full light.
// The Gaussians are drawn at the pattern's own pixels, as the projector sees them, and as the camera sees them; each pixel
// asks the target for what the camera should see where the pixel's ray meets the camera's surface. Several corrected
// projectors share the light where they overlap, by feathers.

const TILE = [2048, 1024];                 // pixels drawn at once, at most
const COARSE = 4;                          // pixels of the pattern a side for one of the maps, while things move
const TARGET_MAX = 2048, SEEN_SIDE = 1024; // longer sides, pixels: of the target, of the camera's G-buffer
const RIM_MAX = 64;                        // pixels of the pattern beyond the object's outline that take its levels
const REACH_SHARE = 20;                    // of the longer side, as far as levels go on where the camera sees none (engine/apply/unseen.c)
const FEATHER_SIDE = 512, FEATHER_SHARE = 20; // longer side of a feather; as many times its width, of engine/apply/surface.c
const ROUNDS = 2;      // more, where light is scattered or spread: each takes off what the one before does (engine/apply/closed.c)
const COUNT_SIDE = 64;                     // of the map in which projectors that overlap are counted

// Each pixel's nearest one that is LIT in a texture, within the limits of near.frag; `kept` is a target to use again.
function findNear(graphics, texture, {width, height}, limits, kept) {
  const {gl} = graphics;
  let near = graphics.fit(kept, width, height, [gl.RG16UI]), spare = graphics.target(width, height, [gl.RG16UI]);
  const pass = (u_step) => {
    graphics.fill(spare, ['near.frag'], {u_response: texture, u_near: near.textures[0], u_step, u_limits: limits});
    [near, spare] = [spare, near];
  };
  pass(0);
  for (let step = 2 ** Math.floor(Math.log2(Math.max(...limits))); step >= 1; step /= 2) pass(step);
  graphics.free(spare);
  return near;
}

// A projector's share where several light the same place, not yet divided by the sum of all: ffp_lit_surface_feather.
// Kept while the projector stays where it is.
class Feather {
  constructor(renderer) { this.renderer = renderer; }

  draw(grid) {
    const key = JSON.stringify(grid);
    if (key === this.key) return;
    this.key = '';
    const {renderer} = this, {graphics} = renderer, {gl} = graphics, device = shadowDevice(grid, FEATHER_SIDE), depth = renderer.centreDepth(device);
    const {width, height} = device, reach = Math.max(width, height) / FEATHER_SHARE;
    const sums = graphics.target(width, height, renderer.sumFormats);
    renderer.rasterise(sums, device, depth, 'splats.frag');
    const edges = graphics.target(width, height, [gl.RGBA16F]);
    graphics.fill(edges, ['gbuffer.glsl', 'edges.frag'], {...sumUniforms(sums, depth), ...deviceUniforms('camera', device)});
    const near = findNear(graphics, edges.textures[0], device, [reach + 1, reach + 1]);
    this.target = graphics.fit(this.target, width, height, [gl.RGBA16F]);
    graphics.fill(this.target, ['feather.frag'], {u_edges: edges.textures[0], u_near: near.textures[0], u_reach: reach});
    for (const target of [sums, edges, near]) graphics.free(target);
    this.key = key;
  }

  get texture() { return this.target.textures[0]; }
  free() { this.renderer.graphics.free(this.target); }
}

// The points that a projector's pixels light, and where one camera sees them. Kept while neither moves.
class CorrectionMaps {
  constructor(renderer) { this.renderer = renderer; }

  keyOf(grid, camera, others) { return JSON.stringify([grid, camera, others.map(({device, stops}) => [device, stops])]); }
  holds(grid, camera, others) { return this.key === this.keyOf(grid, camera, others); }

  // `grid`: the projector, a pixel for each of the maps, which is `times` of the pattern's a side; `others`: the projectors
  // that share its light.
  draw(grid, camera, times, others) {
    if (this.holds(grid, camera, others)) return;
    this.key = ''; // until all is drawn
    const {renderer} = this, {graphics} = renderer, {gl} = graphics;
    const fineness = (d) => d.fx / Math.max(renderer.centreDepth(d), 0.1 * (renderer.scene.radius || 1));
    const wider = times * fineness(grid) / fineness(camera), longer = Math.max(camera.width, camera.height);
    this.target = shadowDevice(camera, Math.min(wider * longer, TARGET_MAX)); // about as fine as the pattern
    this.maps = graphics.fit(this.maps, grid.width, grid.height, [gl.RGBA16F, gl.RGBA16F, gl.RG32F, ...(renderer.scatters ? [gl.RGBA16F] : [])]);
    const device = shadowDevice(camera, SEEN_SIDE / times), sums = graphics.target(device.width, device.height, renderer.sumFormats);
    const seen = sumUniforms(sums, renderer.centreDepth(camera));
    renderer.rasterise(sums, device, seen.u_depth, 'splats.frag');
    this.drawTiles(grid, seen);
    if (others.length) this.drawShares(grid, seen, others);
    else graphics.free(this.shares), this.shares = null;
    graphics.free(sums);
    this.reach = Math.max(grid.width, grid.height, REACH_SHARE) / REACH_SHARE;
    this.near = findNear(graphics, this.maps.textures[0], grid, [this.reach, clamp(wider, 1, RIM_MAX) / times], this.near);
    this.known = graphics.fit(this.known, grid.width, grid.height, [gl.RGBA16F], false, Math.floor(Math.log2(Math.max(grid.width, grid.height))) + 1);
    this.most = others.length ? this.countMost() : 1;
    this.key = this.keyOf(grid, camera, others);
  }

  // `seen`: the camera's G-buffer.
  drawTiles(grid, seen) {
    const {renderer} = this, {graphics, sumFormat} = renderer, {gl} = graphics, depth = renderer.centreDepth(grid);
    const width = Math.min(TILE[0], grid.width), height = Math.min(TILE[1], grid.height), surface = graphics.target(width, height, [sumFormat]);
    for (let y = 0; y < grid.height; y += height)
      for (let x = 0; x < grid.width; x += width) {
        renderer.rasterise(surface, grid, depth, 'shadow.frag', [x, y]);
        gl.enable(gl.SCISSOR_TEST);
        gl.scissor(x, y, width, height);
        graphics.fill(this.maps, ['gbuffer.glsl', 'light.glsl', 'response.frag'], {
          ...seen, ...deviceUniforms('camera', grid), ...deviceUniforms('projector', this.target),
          u_surface: surface.textures[0], u_surface_depth: depth, u_corner: [x, y],
          u_shadow: seen.u_g0, u_shadow_depth: seen.u_depth, u_shadow_bias: renderer.settings.shadow_bias,
          u_shadows: true, u_footprint: false, u_intensity: renderer.scene.intensity,
        });
        gl.disable(gl.SCISSOR_TEST);
      }
    graphics.free(surface);
  }

  drawShares(grid, seen, others) {
    const {renderer} = this, {graphics} = renderer, {gl} = graphics, [u_response, , u_place] = this.maps.textures;
    this.shares = graphics.fit(this.shares, grid.width, grid.height, [gl.RGBA16F, gl.RGBA16F]);
    graphics.clear(this.shares);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE);
    for (const other of others)
      graphics.fill(this.shares, ['gbuffer.glsl', 'light.glsl', 'share.frag'],
                    {...renderer.lightUniforms(other, this.target), ...seen, u_response, u_place, u_feather: other.feather.texture});
    gl.disable(gl.BLEND);
  }

  // The most projectors that light one place, among those that at least a hundredth of the lit pixels share.
  countMost() {
    const {graphics} = this.renderer, {gl} = graphics, target = graphics.target(COUNT_SIDE, COUNT_SIDE, [gl.RGBA16F]), counts = [];
    graphics.fill(target, ['count.frag'], {u_response: this.maps.textures[0], u_whites: this.shares.textures[1]});
    const texels = graphics.readFloats(target);
    for (let i = 0; i < texels.length; i += 4) if (texels[i]) counts[texels[i]] = (counts[texels[i]] || 0) + 1;
    graphics.free(target);
    const lit = counts.reduce((sum, n) => sum + (n || 0), 0);
    return Math.max(1, counts.findLastIndex((n) => n && 100 * n >= lit));
  }

  // The levels that the camera wants at the pixels that it sees, and their means.
  want(values) {
    const {graphics} = this.renderer, {gl} = graphics;
    graphics.fill(this.known, ['wanted.frag'], values);
    gl.bindTexture(gl.TEXTURE_2D, this.known.textures[0]);
    gl.generateMipmap(gl.TEXTURE_2D);
  }

  free() { for (const target of [this.maps, this.near, this.known, this.shares]) this.renderer.graphics.free(target); }
}

class Compensator {
  constructor(renderer) { this.renderer = renderer; }

  drawTarget(projector, {width, height}, camera) {
    if (!this.canvas || this.canvas.width !== width || this.canvas.height !== height) {
      if (this.target) this.target.free();
      this.canvas = makeCanvas(width, height);
      this.target = new PatternTexture(this.renderer.graphics, width, height);
    }
    const context = this.canvas.getContext('2d');
    context.fillStyle = '#000'; // what is transparent, as around text and logos, is to stay dark
    context.fillRect(0, 0, width, height);
    projector.draw(context, width, height, camera);
    this.target.set(this.canvas);
  }

  paintTexture({paint}) {
    if (!this.paint || this.paint.width !== paint.width || this.paint.height !== paint.height) {
      if (this.paint) this.paint.free();
      this.paint = new PatternTexture(this.renderer.graphics, paint.width, paint.height);
    }
    this.paint.set(paint, false);
    return this.paint.texture;
  }

  // Maps at the pattern's pixels, or coarse ones in their place while things move.
  mapsOf(projector, camera, coarse, others) {
    const {grid} = projector, share = (n) => Math.ceil(n / COARSE), {maps} = projector;
    for (const name of ['fine', 'coarse']) maps[name] = maps[name] || new CorrectionMaps(this.renderer);
    if (coarse && !maps.fine.holds(grid, camera, others)) {
      maps.coarse.draw(scaleDevice(grid, share(grid.width), share(grid.height)), camera, COARSE, others);
      return maps.coarse;
    }
    maps.fine.draw(grid, camera, 1, others);
    return maps.fine;
  }

  drawFeathers(projectors) {
    for (const projector of projectors) {
      projector.feather = projector.feather || new Feather(this.renderer);
      projector.feather.draw(projector.grid);
      this.renderer.drawShadow(projector);
    }
  }

  // One texel: brightness times level, of all these projectors.
  drawLevels(projectors, black) {
    const {graphics} = this.renderer, {gl} = graphics;
    this.levels = graphics.fit(this.levels, 1, 1, [gl.RGBA16F]);
    graphics.clear(this.levels);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE);
    for (const {level, brightness} of projectors)
      graphics.fill(this.levels, ['sum.frag'], {u_level: level.textures[0], u_brightness: brightness, u_black: black});
    gl.disable(gl.BLEND);
    return this.levels.textures[0];
  }

  // ffp_procams_closed_form: fills the projector's pattern. `others` share its light; dark projectors give the share `black`
  // of their white, of which up to `most` add up. Returns whether it is only a coarse one.
  solve(projector, camera, coarse, {others = [], black = 0, most = 1} = {}) {
    if (others.length) this.drawFeathers([projector, ...others]);
    const {renderer} = this, {pattern, spread} = projector, made = this.mapsOf(projector, camera, coarse, others);
    const [u_response, u_ambient, u_place, u_scattered = null] = made.maps.textures, [u_lights, u_whites] = made.shares ? made.shares.textures : [null, null];
    this.drawTarget(projector, made.target, camera);
    const values = {
      u_scattered, u_response, u_ambient, u_place, u_near: made.near.textures[0], u_known: made.known.textures[0], u_reach: made.reach, u_target: this.target.texture, u_paint: this.paintTexture(projector),
      u_lights, u_whites, u_feather: made.shares ? projector.feather.texture : null, u_shared: !!made.shares, u_dark: [black, Math.min(1, black * most)],
      u_share: [made.maps.width / pattern.width, made.maps.height / pattern.height],
      u_look: projector.correction === 'paint', u_gain: 2 ** projector.gain, u_brightness: projector.brightness,
    };
    const rounds = (renderer.scatters || spread) && !projector.live ? ROUNDS : 0; // a film's frame begins with the one before
    if (rounds) pattern.draw(['black.frag'], {});
    for (let round = 0; round <= rounds; round++) {
      for (const each of [projector, ...others]) renderer.drawSpread(each);
      const now = {...values, ...renderer.patternUniforms(projector), u_level: renderer.scatters ? this.drawLevels([projector, ...others], black) : null};
      made.want(now);
      pattern.draw(['pattern.frag'], now);
    }
    projector.most = made.most;
    return made === projector.maps.coarse;
  }
}

// samples_across of core/capture/panel.c
const samplesAcross = (panelFocal, idealFocal) => clamp(Math.ceil(idealFocal / panelFocal - 1e-6), 1, 64);

// The picture sent to the real projector for its pattern, RGBA bytes {width, height, data}. `panel`: the device of
// scene.json (docs/reference/formats/capture.md); none: the pattern itself.
function panelPicture(graphics, projector, panel, kept) {
  const d = projector.grid, {device} = projector, original = projector.original || device;
  const p = panel || {width: d.width, height: d.height, fx: d.fx, fy: d.fy, cx: d.cx, cy: d.cy};
  const lens = (panel && panel.lens) || [0, 0, 0, 0, 0], zoom = panel ? device.fx / original.fx : 1;
  kept.target = graphics.fit(kept.target, p.width, p.height, [graphics.gl.RGBA8]);
  graphics.fill(kept.target, ['panel.frag'], {
    u_pattern: projector.pattern.texture, ...deviceUniforms('projector', d),
    u_panel_focal: [p.fx * zoom, p.fy * zoom], u_panel_principal: [p.cx, p.cy],
    u_samples: [samplesAcross(p.fx * zoom, d.fx), samplesAcross(p.fy * zoom, d.fy)],
    u_radial: [lens[0], lens[1], lens[4]], u_tangential: [lens[2], lens[3]],
    u_gamma: (panel && panel.gamma) || [0, 0, 0],
  });
  return {width: p.width, height: p.height, data: graphics.readBytes(kept.target)};
}
