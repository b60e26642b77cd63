// The pattern in closed form (levels of engine/apply/closed.c, for one projector and those that share its light), and the
// paint on it. The target is sRGB: what is written is linear, what is kept encoded.
uniform sampler2D u_response, u_ambient, u_place, u_target, u_paint;
uniform sampler2D u_lights, u_whites, u_feather; // of share.frag; the projector's own
uniform highp usampler2D u_near;
uniform vec2 u_share; // of a pixel of the maps that one of the pattern is
uniform vec2 u_dark;  // the share of their white that dark projectors give, and all together where most overlap
uniform bool u_look;  // true if the target is the look of the object between dark and full light
uniform bool u_shared;
uniform float u_gain, u_brightness;
layout(location = 0) out vec4 o_pattern;

// The level of every projector that lights a point is its feather times this: ffp_procams_lift and _paint, then levels.
vec3 levels_at(ivec2 q, float feather) {
  vec3 wanted = linear_at(u_target, texelFetch(u_place, q, 0).xy / vec2(textureSize(u_target, 0))).rgb;
  vec3 own = u_brightness * texelFetch(u_response, q, 0).rgb, ambient = texelFetch(u_ambient, q, 0).rgb;
  vec4 lights = u_shared ? texelFetch(u_lights, q, 0) : vec4(0.0), whites = u_shared ? texelFetch(u_whites, q, 0) : vec4(0.0);
  vec3 most = feather * own + lights.rgb;
  float sum = feather + lights.a;
  vec3 floor_at = ambient + u_dark.y * most / sum;
  vec3 target = u_look ? floor_at + (1.0 - u_dark.y) * most / sum * wanted : max(u_gain * wanted, floor_at);
  vec3 missing = target - ambient - u_dark.x * (own + whites.rgb), level;
  for (int c = 0; c < 3; c++)
    level[c] = most[c] > 0.0 ? missing[c] / ((1.0 - u_dark.x) * most[c]) : u_look ? wanted[c] / sum : missing[c] > 0.0 ? 1.0 / sum : 0.0;
  return clamp(level, 0.0, 1.0 / sum);
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 paint = texelFetch(u_paint, p, 0);
  uvec2 near = texelFetch(u_near, ivec2(gl_FragCoord.xy * u_share), 0).xy;
  vec3 level = vec3(0.0);
  if (near.x != NOWHERE) {
    ivec2 q = ivec2(near);
    float feather = u_shared ? linear_at(u_feather, (vec2(q) + 0.5) / vec2(textureSize(u_response, 0))).x : 1.0;
    level = feather * levels_at(q, feather);
  }
  o_pattern = vec4(mix(clamp(level, 0.0, 1.0), paint.rgb, paint.a), 1.0);
}
