// For each pixel of the projector, the point that it lights as a camera sees it: the radiance that a pattern of 1 adds
// there, the ambient light, the place in the camera's picture. In light.glsl the two have changed places here: its camera
// is the projector, its projector the camera, and shadow is what the camera does not see. The G-buffer is the camera's: the
// projector, which sees the splats from another side, draws a surface of its own, and only tells which part is lit.
uniform sampler2D u_surface; // what the projector sees, of shadow.frag
uniform float u_surface_depth;
uniform ivec2 u_corner; // of the tile that is drawn
layout(location = 0) out vec4 o_response; // alpha: LIT, HIDDEN or 0, no object
layout(location = 1) out vec4 o_ambient;
layout(location = 2) out vec2 o_place;
#ifdef SCATTERS
layout(location = 3) out vec4 o_scattered; // what white adds in other ways
#endif

struct Meeting {
  vec3 place; // in the camera's picture, and the depth from it
  float off;  // how far that is behind the camera's surface
  bool found;
};

// At depth z of the projector's pixel.
Meeting look(ivec2 p, float z) {
  vec3 place = pattern_position(vec2(p) + 0.5, z);
  vec4 s = linear_at(u_shadow, place.xy / projector_size);
  return Meeting(place, place.z - u_shadow_depth - s.x / s.w, place.z > 0.0 && s.w >= 0.5);
}

// Where the pixel's ray meets the camera's surface, by secants from depth z; not found where that is another surface.
Meeting meet(ivec2 p, float z) {
  Meeting before = look(p, z), now = before;
  float depth = z, next = z - before.off / dot(projector_rotation[2], slope_at(vec2(p) + 0.5));
  for (int k = 0; k < 5 && now.found; k++) {
    now = look(p, next);
    now.found = now.found && abs(next - z) <= u_shadow_bias * z;
    float slope = (now.off - before.off) / (next - depth);
    if (abs(now.off) < 1e-6 * z || !(abs(slope) > 1e-3)) break;
    depth = next, before = now, next -= now.off / slope;
  }
  now.found = now.found && abs(now.off) < 5e-4 * z;
  return now;
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 surface = texelFetch(u_surface, p - u_corner, 0);
  o_response = o_ambient = vec4(0.0), o_place = vec2(0.0);
#ifdef SCATTERS
  o_scattered = vec4(0.0);
#endif
  if (!(surface.w >= 0.5)) return;
  o_response.a = HIDDEN;
  float z = surface.x / surface.w + u_surface_depth;
  if (!(map_pixel(p, z).visibility >= 0.5)) return;
  Meeting met = meet(p, z);
  if (!met.found) return;
  Sums s = sums_between(met.place.xy / projector_size);
  vec3 slope = slope_at(vec2(p) + 0.5), v = normalize(projector_position - camera_position - z * slope);
  vec3 ambient = s.ambient / s.opacity;
  vec3 light = reflected(s, v, -normalize(slope)) / s.opacity * u_intensity / (z * z * dot(slope, slope));
  vec3 gained = srgb_encode(ambient + light) - srgb_encode(ambient);
  if (!any(greaterThanEqual(gained, vec3(2.0 / 255.0)))) return; // is_lit of engine/apply/gamut.c
  o_response = vec4(light, LIT);
  o_ambient = vec4(ambient, 1.0);
  o_place = met.place.xy;
#ifdef SCATTERS
  o_scattered = linear_at(u_g4, met.place.xy / projector_size) / s.opacity;
#endif
}
