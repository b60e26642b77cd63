precision highp float;
precision highp int;
precision highp sampler2D;

#define ALPHA_MIN (1.0 / 255.0)   // FFP_ALPHA_MIN and what follows it in engine/render/formula.h
#define ALPHA_MAX 0.99
#define OPACITY_MIN 1e-3
#define COMPENSATION_MIN 0.005
#define HOLD_MARGIN 0.15
#define LOG2_E 1.4426950408889634
#define PI 3.14159265358979324
#define LIT 1.0    // in the maps of a correction: a pixel that the camera sees lit
#define HIDDEN 0.5 // ... one of the object that it does not
#define NOWHERE 65535u
#define COUNT_SIDE 64.0

// Targets are drawn with row 0 on top, as pictures lie in memory: gl_FragCoord is the pixel position.

// ffp_srgb_encode
float srgb_encode(float linear) {
  if (!(linear > 0.0)) return 0.0;
  if (linear >= 1.0) return 1.0;
  return linear <= 0.0031308 ? linear * 12.92 : 1.055 * pow(linear, 1.0 / 2.4) - 0.055;
}
vec3 srgb_encode(vec3 c) { return vec3(srgb_encode(c.r), srgb_encode(c.g), srgb_encode(c.b)); }

// ffp_srgb_decode
float srgb_decode(float encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4);
}
vec3 srgb_decode(vec3 c) { return vec3(srgb_decode(c.r), srgb_decode(c.g), srgb_decode(c.b)); }

// ffp_image_sample at a share of the picture, of one of its mip levels: bilinear, held at the edges.
vec4 linear_at(sampler2D picture, vec2 share, int lod) {
  ivec2 size = textureSize(picture, lod);
  vec2 at = clamp(share * vec2(size) - 0.5, vec2(0.0), vec2(size - 1));
  ivec2 first = ivec2(at), next = min(first + 1, size - 1);
  vec2 w = at - vec2(first);
  return mix(mix(texelFetch(picture, first, lod), texelFetch(picture, ivec2(next.x, first.y), lod), w.x),
             mix(texelFetch(picture, ivec2(first.x, next.y), lod), texelFetch(picture, next, lod), w.x), w.y);
}
vec4 linear_at(sampler2D picture, vec2 share) { return linear_at(picture, share, 0); }
