// For each camera pixel, the effect of a projector there (engine/apply/procams.c, fill_link): the radiance that a pattern
// of 1 adds; the position in the pattern that it comes from, and its depth; the depth from the camera.
layout(location = 0) out vec4 o_response; // rgb, visibility
layout(location = 1) out vec4 o_place;    // u, v, depth from the projector, depth from the camera
layout(location = 2) out vec4 o_extent;   // of the footprint, its visibility, facing

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  Sums s = sums_at(p);
  float z = s.opacity > OPACITY_MIN ? s.depth / s.opacity : 0.0;
  Mapped m = map_pixel(p, z);
  vec3 slope = slope_at(vec2(p) + 0.5);
  float facing = s.opacity >= 0.5 ? min(abs(dot(normalize(s.normal), normalize(slope))), 1.0) : 0.0;
  o_response = vec4(max(light_pixel(p, s, m), vec3(0.0)), m.visibility);
  o_place = vec4(pattern_position(vec2(p) + 0.5, z), s.opacity >= 0.5 ? z : 0.0);
  o_extent = vec4(m.extent, m.visibility, facing);
}
