// The light that another projector adds at the points that one lights, as the camera sees them; drawn once for each other, and
// added up. shared_white of engine/apply/procams.c.
uniform sampler2D u_response, u_place; // of response.frag
uniform sampler2D u_feather; // the other's
layout(location = 0) out vec4 o_light; // feather times radiance under its white; feather
layout(location = 1) out vec4 o_white; // radiance under its white; 1

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  o_light = o_white = vec4(0.0);
  if (texelFetch(u_response, p, 0).a != LIT) return;
  vec2 place = texelFetch(u_place, p, 0).xy;
  Sums s = sums_between(place / camera_size);
  float z = s.depth / s.opacity;
  Mapped m = map_place(place, z);
  if (!(m.visibility > 0.0)) return;
  vec3 slope = slope_at(place), l = projector_position - camera_position - z * slope;
  vec3 white = m.visibility * reflected(s, -normalize(slope), normalize(l)) / s.opacity * u_intensity / dot(l, l);
  float feather = m.visibility * linear_at(u_feather, m.uv / projector_size).x;
  if (!any(greaterThan(white, vec3(0.0)))) return;
  o_light = vec4(feather * white, feather);
  o_white = vec4(white, step(0.5, m.visibility));
}
