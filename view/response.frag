// For each pixel of the projector, the point that it lights as a camera sees it: the radiance that a pattern of 1 adds
// there, the ambient light, the place in the camera's picture. In light.glsl the two have changed places here: its camera
// is the projector, from which the G-buffer is drawn, its projector the camera, and shadow is what the camera does not see.
uniform ivec2 u_corner; // of the tile that is drawn
layout(location = 0) out vec4 o_response; // alpha: LIT, HIDDEN or 0, no object
layout(location = 1) out vec4 o_ambient;
layout(location = 2) out vec2 o_place;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  Sums s = sums_at(p - u_corner);
  o_response = o_ambient = vec4(0.0), o_place = vec2(0.0);
  if (!(s.opacity >= 0.5)) return;
  float z = s.depth / s.opacity;
  Mapped m = map_pixel(p, z);
  vec3 slope = slope_at(vec2(p) + 0.5), v = normalize(projector_position - camera_position - z * slope);
  vec3 ambient = s.ambient / s.opacity;
  vec3 light = reflected(s, v, -normalize(slope)) / s.opacity * u_intensity / (z * z * dot(slope, slope));
  vec3 gained = srgb_encode(ambient + light) - srgb_encode(ambient);
  bool lit = m.visibility >= 0.5 && any(greaterThanEqual(gained, vec3(2.0 / 255.0))); // is_lit of engine/apply/gamut.c
  o_response = vec4(light, lit ? LIT : HIDDEN);
  o_ambient = vec4(ambient, 1.0);
  o_place = m.uv;
}
