// Cells of four neighbouring camera pixels, as two triangles each in the projector (engine/apply/inverse.c).
uniform sampler2D u_response, u_place;
uniform vec2 projector_size, camera_focal, u_depths; // nearest and farthest
out vec2 f_camera;
#define JUMP 4.0

bool is_there(ivec2 p) {
  vec4 r = texelFetch(u_response, p, 0), at = texelFetch(u_place, p, 0);
  return at.w > 0.0 && at.z > 0.0 && r.a >= 0.5 && any(greaterThan(r.rgb, vec3(0.0)));
}

void main() {
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  int across = textureSize(u_place, 0).x - 1, cell = gl_VertexID / 6, corner = gl_VertexID % 6;
  ivec2 first = ivec2(cell % across, cell / across);
  float near = 1e30, far = 0.0;
  for (int k = 0; k < 4; k++) {
    ivec2 p = first + ivec2(k & 1, k >> 1);
    if (!is_there(p)) return;
    float z = texelFetch(u_place, p, 0).w;
    near = min(near, z), far = max(far, z);
  }
  if (far - near > JUMP * far / min(camera_focal.x, camera_focal.y)) return; // is_whole
  int k = corner == 0 ? 0 : corner == 1 || corner == 3 ? 1 : corner == 4 ? 3 : 2;
  ivec2 p = first + ivec2(k & 1, k >> 1);
  vec4 at = texelFetch(u_place, p, 0);
  f_camera = vec2(p) + 0.5;
  gl_Position = vec4(2.0 * at.xy / projector_size - 1.0,
                     clamp(2.0 * (at.z - u_depths.x) / (u_depths.y - u_depths.x) - 1.0, -1.0, 1.0), 1.0);
}
