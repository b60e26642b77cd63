'use strict';
// The graphics context, its programs, textures and targets.

const FENCE_LOOK = 30; // ms

class Graphics {
  constructor(canvas) {
    const gl = canvas.getContext('webgl2', {alpha: true, antialias: false, depth: false, premultipliedAlpha: true,
                                            preserveDrawingBuffer: false, powerPreference: 'high-performance'});
    if (!gl) throw new Error('The page requires WebGL 2, which this browser does not offer. Try a current Firefox, ' +
                             'Chromium or Safari, and check that hardware acceleration is switched on.');
    if (!gl.getExtension('EXT_color_buffer_float'))
      throw new Error('This graphics driver cannot draw into float textures (EXT_color_buffer_float).');
    this.gl = gl;
    this.float32 = !!gl.getExtension('EXT_float_blend'); // sums are kept in 32 bits, otherwise in 16
    this.sideMax = gl.getParameter(gl.MAX_TEXTURE_SIZE); // pixels
    this.programs = new Map();
    this.empty = gl.createVertexArray();
    this.defines = ''; // lines before every shader
    gl.disable(gl.DITHER);
  }

  // A promise of the moment at which the driver has drawn all that it was asked to; slow ones take long after the calls.
  drawn() {
    const {gl} = this, fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    return new Promise((done) => {
      const look = () => {
        if (fence && !gl.isContextLost() && gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) return setTimeout(look, FENCE_LOOK);
        gl.deleteSync(fence);
        done();
      };
      look();
    });
  }

  shader(type, names) {
    const {gl} = this;
    const text = names.map((name) => document.getElementById(name).textContent.trim()).join('\n');
    const shader = gl.createShader(type);
    gl.shaderSource(shader, '#version 300 es\n' + this.defines + text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost())
      throw new Error(names.join(' + ') + ': ' + gl.getShaderInfoLog(shader));
    return shader;
  }

  // A program of the page's shaders, by their names; made once.
  program(vertex, fragments) {
    const {gl} = this, key = vertex + ' ' + fragments.join(' ');
    if (this.programs.has(key)) return this.programs.get(key);
    const program = gl.createProgram();
    gl.attachShader(program, this.shader(gl.VERTEX_SHADER, ['common.glsl', vertex]));
    gl.attachShader(program, this.shader(gl.FRAGMENT_SHADER, ['common.glsl', ...fragments]));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost())
      throw new Error(key + ': ' + gl.getProgramInfoLog(program));
    const uniforms = {};
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) || 0;
    for (let i = 0; i < count; i++) {
      const info = gl.getActiveUniform(program, i);
      uniforms[info.name] = {type: info.type, at: gl.getUniformLocation(program, info.name)};
    }
    const made = {program, uniforms};
    this.programs.set(key, made);
    return made;
  }

  // Sets uniforms by name; those that a shader does not use are skipped. Textures are bound to units in order.
  use(made, values) {
    const {gl} = this;
    let unit = 0;
    gl.useProgram(made.program);
    for (const [name, value] of Object.entries(values)) {
      const uniform = made.uniforms[name];
      if (!uniform) continue;
      switch (uniform.type) {
      case gl.FLOAT: gl.uniform1f(uniform.at, value); break;
      case gl.FLOAT_VEC2: gl.uniform2fv(uniform.at, value); break;
      case gl.FLOAT_VEC3: gl.uniform3fv(uniform.at, value); break;
      case gl.FLOAT_VEC4: gl.uniform4fv(uniform.at, value); break;
      case gl.FLOAT_MAT3: gl.uniformMatrix3fv(uniform.at, false, value); break;
      case gl.INT_VEC2: gl.uniform2iv(uniform.at, value); break;
      case gl.INT: case gl.BOOL: gl.uniform1i(uniform.at, value); break;
      default: // a sampler
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, value);
        gl.uniform1i(uniform.at, unit++);
      }
    }
  }

  texture(width, height, format, levels = 1) {
    const {gl} = this, texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, levels, format, width, height);
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, levels > 1 ? gl.NEAREST_MIPMAP_NEAREST : gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    return texture;
  }

  // Does an upload of a canvas; colours are multiplied by alpha, or stay as they are. The state is set back afterwards: it holds
  // for arrays too, and Firefox then refuses those of integers ("Unconvertible texel format").
  unpack(premultiply, upload) {
    const {gl} = this;
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, premultiply);
    upload();
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.BROWSER_DEFAULT_WEBGL);
  }

  // Something to draw into: {width, height, textures, framebuffer}. `depth`: with a depth buffer. `levels`: of the mips.
  target(width, height, formats, depth = false, levels = 1) {
    const {gl} = this, framebuffer = gl.createFramebuffer();
    const textures = formats.map((format) => this.texture(width, height, format, levels));
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    textures.forEach((texture, i) =>
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0));
    gl.drawBuffers(textures.map((_, i) => gl.COLOR_ATTACHMENT0 + i));
    const target = {width, height, formats, textures, framebuffer, depth: null};
    if (depth) {
      target.depth = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, target.depth);
      gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT32F, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, target.depth);
    }
    if (gl.checkFramebufferStatus(gl.FRAMEBUFFER) !== gl.FRAMEBUFFER_COMPLETE && !gl.isContextLost()) {
      this.free(target);
      throw new Message(`The graphics driver has no room for ${width} × ${height} samples. Try a smaller window.`);
    }
    return target;
  }

  // True if it draws into textures of these formats at once.
  draws(formats) {
    const {gl} = this, framebuffer = gl.createFramebuffer(), textures = formats.map((format) => this.texture(1, 1, format));
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    textures.forEach((texture, i) => gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0));
    const whole = gl.checkFramebufferStatus(gl.FRAMEBUFFER) === gl.FRAMEBUFFER_COMPLETE;
    this.free({textures, framebuffer});
    return whole;
  }

  // The target again if it fits, otherwise a new one in its place.
  fit(target, width, height, formats, depth = false, levels = 1) {
    if (target && target.width === width && target.height === height) return target;
    this.free(target);
    return this.target(width, height, formats, depth, levels);
  }

  free(target) {
    if (!target) return;
    target.textures.forEach((texture) => this.gl.deleteTexture(texture));
    if (target.depth) this.gl.deleteRenderbuffer(target.depth);
    this.gl.deleteFramebuffer(target.framebuffer);
    target.width = target.height = 0; // so that it fits no size
  }

  // Draws a program over every pixel of a target (null: the canvas, of the given size).
  fill(target, fragments, values, width = 0, height = 0) {
    const {gl} = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target ? target.framebuffer : null);
    gl.viewport(0, 0, target ? target.width : width, target ? target.height : height);
    gl.bindVertexArray(this.empty);
    this.use(this.program('fill.vert', fragments), values);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  clear(target) {
    const {gl} = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.framebuffer);
    target.textures.forEach((_, i) => gl.clearBufferfv(gl.COLOR, i, [0, 0, 0, 0]));
  }

  // Float pixels [height, width, 4], row 0 first.
  readFloats(target, attachment = 0, x = 0, y = 0, width = target.width, height = target.height) {
    const {gl} = this, out = new Float32Array(4 * width * height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.framebuffer);
    gl.readBuffer(gl.COLOR_ATTACHMENT0 + attachment);
    gl.readPixels(x, y, width, height, gl.RGBA, gl.FLOAT, out);
    return out;
  }

  readBytes(target) {
    const {gl} = this, out = new Uint8ClampedArray(4 * target.width * target.height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.framebuffer);
    gl.readBuffer(gl.COLOR_ATTACHMENT0);
    gl.readPixels(0, 0, target.width, target.height, gl.RGBA, gl.UNSIGNED_BYTE, out);
    return out;
  }
}

// The uniforms of a device, by a name that the shaders give it.
function deviceUniforms(name, d) {
  return {
    [name + '_rotation']: [...axisOf(d.pose, 0), ...axisOf(d.pose, 1), ...axisOf(d.pose, 2)],
    [name + '_position']: positionOf(d.pose), [name + '_focal']: [d.fx, d.fy], [name + '_principal']: [d.cx, d.cy],
    [name + '_size']: [d.width, d.height],
  };
}
