// The levels that the camera asks for: level times certainty, and the certainty (levels of engine/apply/closed.c, for one
// projector, whose feather is 1 everywhere).
uniform sampler2D u_response, u_extent, u_target, u_g0, u_g2, u_g3;
uniform bool u_paint;
uniform float u_gain;
layout(location = 0) out vec4 o_wish;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 response = texelFetch(u_response, p, 0), extent = texelFetch(u_extent, p, 0), wanted = texelFetch(u_target, p, 0);
  vec3 ambient = vec3(texelFetch(u_g2, p, 0).z, texelFetch(u_g3, p, 0).xy);
  float weight = min(texelFetch(u_g0, p, 0).w, 1.0) * wanted.a;
  vec3 gained = srgb_encode(ambient + response.rgb) - srgb_encode(ambient);
  bool lit = weight > 0.5 && any(greaterThanEqual(gained, vec3(2.0 / 255.0))); // is_lit of engine/apply/gamut.c
  float certainty = lit ? weight * extent.w : 0.0;
  o_wish = vec4(0.0);
  if (!(certainty > 0.0) || !(response.a > 0.0)) return;
  vec3 target = u_paint ? ambient + response.rgb * min(wanted.rgb, 1.0) : u_gain * wanted.rgb;
  vec3 level;
  for (int c = 0; c < 3; c++) {
    float missing = target[c] - ambient[c];
    level[c] = clamp(response[c] > 0.0 ? missing / response[c] : missing > 0.0 ? 1.0 : 0.0, 0.0, 1.0);
  }
  o_wish = vec4(certainty * level, certainty);
}
