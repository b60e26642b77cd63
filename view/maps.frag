// A G-buffer as a picture, as ffp_map_picture shows it.
uniform int u_map; // 0 opacity, 1 depth, 2 normal, 3 albedo, 4 roughness, 5 ambient
uniform vec2 u_range; // of depths shown
uniform bool u_flip;
uniform vec2 u_size;
layout(location = 0) out vec4 o_picture;

void main() {
  vec2 at = gl_FragCoord.xy;
  if (u_flip) at.y = u_size.y - at.y;
  Sums s = sums_at(ivec2(at));
  vec3 c = vec3(s.opacity);
  if (u_map == 1)
    c = vec3(s.opacity >= 0.5 ? clamp(1.0 - 0.9 * (s.depth / s.opacity - u_range.x) / (u_range.y - u_range.x), 0.0, 1.0) : 0.0);
  if (u_map == 2) c = length(s.normal) > 0.0 ? s.opacity * (0.5 + 0.5 * normalize(s.normal)) : vec3(0.0);
  if (u_map == 3) c = srgb_encode(s.albedo);
  if (u_map == 4) c = vec3(s.roughness);
  if (u_map == 5) c = srgb_encode(s.ambient);
  o_picture = vec4(c, s.opacity);
}
