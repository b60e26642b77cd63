// Where what a projector lights ends, in its own pixels: LIT at an end, as near.frag looks for, HIDDEN elsewhere; and the
// cosine of the angle of incidence. at_edge and measure of engine/apply/surface.c.
uniform mat3 camera_rotation;
uniform vec2 camera_focal, camera_principal, camera_size;
layout(location = 0) out vec4 o_edge; // cosine, 0, 0, LIT or HIDDEN

float surface_at(ivec2 p) {
  vec4 a = texelFetch(u_g0, p, 0);
  return a.w >= 0.5 ? a.x / a.w + u_depth : 0.0;
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy), size = ivec2(camera_size);
  float z = surface_at(p), jump = 4.0 * z / min(camera_focal.x, camera_focal.y);
  bool ends = !(z > 0.0);
  for (int k = 0; k < 4; k++) {
    ivec2 n = p + ivec2(k == 0 ? 1 : k == 1 ? -1 : 0, k == 2 ? 1 : k == 3 ? -1 : 0);
    bool outside = any(lessThan(n, ivec2(0))) || any(greaterThanEqual(n, size));
    float other = outside ? 0.0 : surface_at(n);
    ends = ends || !(other > 0.0) || abs(z - other) > jump;
  }
  vec3 ray = normalize(camera_rotation * vec3((gl_FragCoord.xy - camera_principal) / camera_focal, 1.0)), normal = sums_at(p).normal;
  float cosine = z > 0.0 && length(normal) > 0.0 ? clamp(-dot(normalize(normal), ray), 0.0, 1.0) : 0.0;
  o_edge = vec4(cosine, 0.0, 0.0, ends ? LIT : HIDDEN);
}
