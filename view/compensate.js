'use strict';
// The pattern that makes a camera see the projector's content on the object, in closed form (engine/apply/closed.c),
// for each projector separately: 'colours' asks for the content's light times a gain, 'paint' for the look of
// the object between dark and full light.

class Compensator {
  constructor(renderer) {
    this.renderer = renderer;
    this.view = new GbufferView(renderer);
  }

  // The light that each camera pixel can receive; kept while camera and projector do not move.
  drawResponse(projector, camera) {
    const {renderer, view} = this, {graphics} = renderer, {gl} = graphics, format = renderer.sumFormat;
    renderer.drawShadow(projector);
    view.draw(camera, renderer.settings.samples);
    const key = JSON.stringify([view.key, projector.device, projector.brightness]);
    if (key === this.key) return;
    this.response = graphics.fit(this.response, camera.width, camera.height, [gl.RGBA32F, gl.RGBA32F, gl.RGBA32F]);
    graphics.fill(this.response, ['gbuffer.glsl', 'light.glsl', 'response.frag'],
                  {...view.uniforms(view.mean()), ...renderer.lightUniforms(projector, camera), u_white: true});
    this.footprint = this.typicalFootprint();
    this.key = key;
  }

  // typical_footprint of engine/apply/closed.c
  typicalFootprint() {
    const texels = this.renderer.graphics.readFloats(this.response, 2);
    let sum = 0, count = 0;
    for (let i = 0; i < texels.length; i += 4)
      if (texels[i + 2] > 0) sum += Math.max(texels[i], texels[i + 1]), count++;
    return count ? Math.min(Math.ceil(sum / count), 64) : 1;
  }

  drawTarget(projector, camera) {
    const {graphics} = this.renderer;
    if (!this.canvas || this.canvas.width !== camera.width || this.canvas.height !== camera.height) {
      if (this.target) this.target.free();
      this.canvas = makeCanvas(camera.width, camera.height);
      this.target = new PatternTexture(graphics, camera.width, camera.height);
    }
    const context = this.canvas.getContext('2d');
    context.fillStyle = '#000'; // what is transparent, as around text and logos, is to stay dark
    context.fillRect(0, 0, camera.width, camera.height);
    projector.content.draw(context, camera.width, camera.height, projector.fit);
    this.target.set(this.canvas);
  }

  // Cells of the camera into the projector, near ones in front.
  gather(projector, camera) {
    const {graphics} = this.renderer, {gl} = graphics, d = projector.device;
    const radius = this.renderer.scene.radius || 1, depth = this.renderer.centreDepth(d);
    this.known = graphics.fit(this.known, d.width, d.height, [gl.RGBA32F], true);
    this.grown = graphics.fit(this.grown, d.width, d.height, [gl.RGBA32F], true);
    graphics.clear(this.known);
    gl.clearDepth(1);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.viewport(0, 0, d.width, d.height);
    gl.bindVertexArray(graphics.empty);
    graphics.use(graphics.program('cells.vert', ['cells.frag']), {
      u_response: this.response.textures[0], u_place: this.response.textures[1], u_wishes: this.wishes.textures[0],
      projector_size: [d.width, d.height], camera_focal: [camera.fx, camera.fy],
      u_depths: [Math.max(depth - 4 * radius, 1e-6), depth + 4 * radius],
    });
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LESS);
    gl.drawArrays(gl.TRIANGLES, 0, 6 * (camera.width - 1) * (camera.height - 1));
    gl.disable(gl.DEPTH_TEST);
    for (let i = 0; i < this.footprint; i++) {
      graphics.fill(this.grown, ['grow.frag'], {u_known: this.known.textures[0]});
      [this.known, this.grown] = [this.grown, this.known];
    }
  }

  paintTexture(projector) {
    if (!this.paint || this.paint.width !== projector.paint.width || this.paint.height !== projector.paint.height) {
      if (this.paint) this.paint.free();
      this.paint = new PatternTexture(this.renderer.graphics, projector.paint.width, projector.paint.height);
    }
    this.paint.set(projector.paint, false);
    return this.paint.texture;
  }

  // ffp_procams_closed_form: fills the projector's pattern.
  solve(projector, camera) {
    const {renderer, view} = this, {graphics} = renderer, {gl} = graphics;
    this.drawResponse(projector, camera);
    this.drawTarget(projector, camera);
    this.wishes = graphics.fit(this.wishes, camera.width, camera.height, [gl.RGBA32F]);
    graphics.fill(this.wishes, ['wishes.frag'], {
      ...view.uniforms(view.mean()), u_response: this.response.textures[0], u_extent: this.response.textures[2],
      u_target: this.target.texture, u_paint: projector.correction === 'paint', u_gain: 2 ** projector.gain,
    });
    this.gather(projector, camera);
    const {pattern} = projector, framebuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, pattern.texture, 0);
    graphics.fill({framebuffer, width: pattern.width, height: pattern.height}, ['pattern.frag'],
                  {u_known: this.known.textures[0], u_paint: this.paintTexture(projector)});
    gl.deleteFramebuffer(framebuffer);
    gl.bindTexture(gl.TEXTURE_2D, pattern.texture);
    gl.generateMipmap(gl.TEXTURE_2D);
  }
}

// samples_across of core/capture/panel.c
const samplesAcross = (panelFocal, idealFocal) => clamp(Math.ceil(idealFocal / panelFocal - 1e-6), 1, 64);

// The picture sent to the real projector for its pattern, RGBA bytes {width, height, data}. `panel`: the device of
// scene.json (docs/reference/formats/capture.md); none: the pattern itself.
function panelPicture(graphics, projector, panel, kept) {
  const d = projector.device, original = projector.original || d;
  const p = panel || {width: d.width, height: d.height, fx: d.fx, fy: d.fy, cx: d.cx, cy: d.cy};
  const lens = (panel && panel.lens) || [0, 0, 0, 0, 0], zoom = panel ? d.fx / original.fx : 1;
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
