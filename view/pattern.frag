// The pattern in closed form (levels of engine/apply/closed.c, for one projector, whose feather is 1 everywhere), and the
// paint on it. The target is sRGB: what is written is linear, what is kept encoded.
uniform sampler2D u_response, u_ambient, u_place, u_target, u_paint;
uniform highp usampler2D u_near;
uniform vec2 u_share; // of a pixel of the maps that one of the pattern is
uniform bool u_look;  // true if the target is the look of the object between dark and full light
uniform float u_gain, u_brightness;
layout(location = 0) out vec4 o_pattern;

// ffp_image_sample: bilinear, held at the edges
vec3 wanted_at(vec2 place) {
  ivec2 size = textureSize(u_target, 0);
  vec2 at = clamp(place - 0.5, vec2(0.0), vec2(size - 1));
  ivec2 first = ivec2(at), next = min(first + 1, size - 1);
  vec2 w = at - vec2(first);
  return mix(mix(texelFetch(u_target, first, 0), texelFetch(u_target, ivec2(next.x, first.y), 0), w.x),
             mix(texelFetch(u_target, ivec2(first.x, next.y), 0), texelFetch(u_target, next, 0), w.x), w.y).rgb;
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 paint = texelFetch(u_paint, p, 0);
  uvec2 near = texelFetch(u_near, ivec2(gl_FragCoord.xy * u_share), 0).xy;
  vec3 level = vec3(0.0);
  if (near.x != NOWHERE) {
    ivec2 q = ivec2(near);
    vec3 wanted = wanted_at(texelFetch(u_place, q, 0).xy), most = u_brightness * texelFetch(u_response, q, 0).rgb;
    vec3 missing = u_gain * wanted - texelFetch(u_ambient, q, 0).rgb;
    for (int c = 0; c < 3; c++)
      level[c] = u_look ? wanted[c] : most[c] > 0.0 ? missing[c] / most[c] : missing[c] > 0.0 ? 1.0 : 0.0;
  }
  o_pattern = vec4(mix(clamp(level, 0.0, 1.0), paint.rgb, paint.a), 1.0);
}
