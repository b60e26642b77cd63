// The pattern: the levels that the camera wants where it sees the projector's light (wanted.frag); elsewhere levels that go on
// from there and fade (ffp_fill_unseen, engine/apply/unseen.c); and the paint on it. The shader writes linear values, sRGB is
// kept.
#define TRUSTED 2.0
uniform sampler2D u_response, u_known, u_paint, u_feather, u_wide;
uniform highp usampler2D u_near;
uniform vec2 u_share;  // of a pixel of the maps that one of the pattern is
uniform float u_reach; // of their pixels, over which levels fade
uniform vec3 u_spread;
uniform bool u_shared;
layout(location = 0) out vec4 o_pattern;

vec3 pull(vec2 share) {
  vec3 level = vec3(0.0);
  ivec2 size = textureSize(u_known, 0);
  for (int lod = int(log2(float(max(size.x, size.y)))); lod > 0; lod--) {
    vec4 mean = linear_at(u_known, share, lod);
    if (mean.a > 0.0) level = mix(level, mean.rgb / mean.a, min(TRUSTED * mean.a, 1.0));
  }
  return level;
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy), q = ivec2(gl_FragCoord.xy * u_share);
  vec4 paint = texelFetch(u_paint, p, 0);
  vec2 share = gl_FragCoord.xy * u_share / vec2(textureSize(u_response, 0));
  uvec2 near = texelFetch(u_near, q, 0).xy;
  vec3 level = vec3(0.0);
  if (near.x != NOWHERE) {
    bool unseen = texelFetch(u_response, q, 0).a == HIDDEN;
    ivec2 from = unseen ? q : ivec2(near);
    float close = clamp(1.0 - distance(vec2(q), vec2(near)) / u_reach, 0.0, 1.0);
    level = unseen ? close * close * (3.0 - 2.0 * close) * pull(share) : texelFetch(u_known, from, 0).rgb;
    if (u_shared) level *= linear_at(u_feather, (vec2(from) + 0.5) / vec2(textureSize(u_response, 0))).x;
    if (u_spread != vec3(0.0)) // unspread
      level = (level - u_spread * textureLod(u_wide, share, 0.0).rgb) / (1.0 - u_spread);
  }
  o_pattern = vec4(mix(clamp(level, 0.0, 1.0), paint.rgb, paint.a), 1.0);
}
