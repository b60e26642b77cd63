// A layer whose corners are pulled: the unit square through a homography.
uniform mat3 u_map;              // to the picture's pixels
uniform vec2 u_size, u_border;   // the picture's pixels; the source's empty border, in shares of what is inside
out vec2 v_at;

void main() {
  v_at = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  vec3 p = u_map * vec3(mix(-u_border, 1.0 + u_border, v_at), 1.0);
  gl_Position = vec4(2.0 * p.xy / u_size - p.z, 0.0, p.z); // its last divides v_at too
}
