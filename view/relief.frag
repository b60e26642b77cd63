// A device's picture for surfaces and effects: the place of each pixel relative to the scene's centre, in radii, and the opacity;
// the normal and the size of the pixel there; the square root of the albedo. Normals and albedo are means around.
uniform mat3 camera_rotation;
uniform vec3 camera_position;
uniform vec2 camera_focal, camera_principal, camera_size;
uniform vec3 u_centre;
uniform float u_radius;
layout(location = 0) out vec4 o_place;
layout(location = 1) out vec4 o_normal;
layout(location = 2) out vec4 o_albedo;
#define REACH 3
#define APART 8.0 // pixels: farther neighbours are another surface

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy), size = ivec2(camera_size);
  float z = depth_at(p), opacity = sums_at(p).opacity, pixel = z / min(camera_focal.x, camera_focal.y);
  o_place = o_normal = o_albedo = vec4(0.0);
  if (!(opacity > 0.05)) return;
  vec3 normal = vec3(0.0), albedo = vec3(0.0);
  float weight = 0.0;
  for (int v = -REACH; v <= REACH; v++)
    for (int u = -REACH; u <= REACH; u++) {
      ivec2 n = clamp(p + ivec2(u, v), ivec2(0), size - 1);
      Sums s = sums_at(n);
      if (!(s.opacity > OPACITY_MIN) || abs(s.depth / s.opacity - z) > APART * pixel) continue;
      normal += s.normal, albedo += s.albedo, weight += s.opacity;
    }
  vec3 ray = camera_rotation * vec3((gl_FragCoord.xy - camera_principal) / camera_focal, 1.0);
  o_place = vec4((camera_position + z * ray - u_centre) / u_radius, opacity);
  o_normal = vec4(length(normal) > 0.0 ? normalize(normal) : -normalize(ray), pixel / u_radius);
  o_albedo = vec4(sqrt(clamp(albedo / weight, 0.0, 1.0)), 1.0);
}
