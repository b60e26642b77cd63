// The levels that the camera wants where it sees the projector's light: levels of engine/apply/closed.c, for one projector and
// those that share its light.
uniform sampler2D u_response, u_ambient, u_place, u_target;
uniform sampler2D u_lights, u_whites, u_feather; // of share.frag; the projector's own
uniform sampler2D u_scattered; // of response.frag
uniform sampler2D u_level;             // one texel: brightness times level of the patterns so far, of all that are lit
uniform vec2 u_dark;  // the share of their white that dark projectors give, and all together where most overlap
uniform bool u_look;  // true if the target is the look of the object between dark and full light
uniform bool u_shared;
uniform float u_gain, u_brightness;
layout(location = 0) out vec4 o_known; // levels, and 1; 0 where it sees none

// The level of every projector that lights a point is its feather times this: ffp_procams_lift and _paint, then levels.
vec3 levels_at(ivec2 q, float feather) {
  vec3 wanted = linear_at(u_target, texelFetch(u_place, q, 0).xy / vec2(textureSize(u_target, 0))).rgb;
  vec3 own = u_brightness * texelFetch(u_response, q, 0).rgb, ambient = texelFetch(u_ambient, q, 0).rgb;
  vec4 lights = u_shared ? texelFetch(u_lights, q, 0) : vec4(0.0), whites = u_shared ? texelFetch(u_whites, q, 0) : vec4(0.0);
  vec3 most = feather * own + lights.rgb;
  float sum = feather + lights.a;
  vec3 white = most / sum, other = vec3(0.0), scattered = vec3(0.0);
#ifdef SCATTERS
  scattered = texelFetch(u_scattered, q, 0).rgb;
  other = u_brightness * scattered;
  white += other;
  scattered *= texelFetch(u_level, ivec2(0), 0).rgb;
#endif
  vec3 floor_at = ambient + u_dark.y * white;
  vec3 target = u_look ? floor_at + (1.0 - u_dark.y) * white * wanted : max(u_gain * wanted, floor_at);
  vec3 all = target - ambient - u_dark.x * (own + whites.rgb), missing = all - scattered, direct = (1.0 - u_dark.x) * most, level;
  for (int c = 0; c < 3; c++) {
    level[c] = most[c] > 0.0 ? missing[c] / direct[c] : u_look ? wanted[c] / sum : missing[c] > 0.0 ? 1.0 / sum : 0.0;
    if (other[c] > 0.0) // steadied
      level[c] = mix(all[c] / (direct[c] + other[c]), level[c], direct[c] * direct[c] / (direct[c] * direct[c] + other[c] * other[c]));
  }
  return clamp(level, 0.0, 1.0 / sum);
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  o_known = vec4(0.0);
  if (texelFetch(u_response, p, 0).a != LIT) return;
  float feather = u_shared ? linear_at(u_feather, gl_FragCoord.xy / vec2(textureSize(u_response, 0))).x : 1.0;
  o_known = vec4(levels_at(p, feather), 1.0);
}
