// The light that another projector adds at the points that one lights, as a camera at u_watcher sees them; drawn once for each other,
// and added up. In light.glsl the camera is the one, the projector the other. shared_white of engine/apply/procams.c.
uniform ivec2 u_corner; // of the tile that is drawn
uniform vec3 u_watcher;
uniform sampler2D u_feather; // the other's
layout(location = 0) out vec4 o_light; // feather times radiance under its white; feather
layout(location = 1) out vec4 o_white; // radiance under its white; 1

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  Sums s = sums_at(p - u_corner);
  o_light = o_white = vec4(0.0);
  if (!(s.opacity >= 0.5)) return;
  float z = s.depth / s.opacity;
  Mapped m = map_pixel(p, z);
  if (!(m.visibility > 0.0)) return;
  vec3 point = camera_position + z * slope_at(vec2(p) + 0.5), l = projector_position - point;
  vec3 white = m.visibility * reflected(s, normalize(u_watcher - point), normalize(l)) / s.opacity * u_intensity / dot(l, l);
  float feather = m.visibility * linear_at(u_feather, m.uv / projector_size).x;
  if (!any(greaterThan(white, vec3(0.0)))) return;
  o_light = vec4(feather * white, feather);
  o_white = vec4(white, step(0.5, m.visibility));
}
