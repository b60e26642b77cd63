// The point of the pattern that lights a sample, how much of the pattern the sample covers, and the visibility:
// engine/render/map_pixel.h. The light it then sends to the camera: engine/render/shade_pixel.h, core/base/brdf.h.
uniform mat3 camera_rotation, projector_rotation; // columns: the axes in the world
uniform vec3 camera_position, projector_position;
uniform vec2 camera_focal, camera_principal, camera_size;
uniform vec2 projector_focal, projector_principal, projector_size;
uniform sampler2D u_shadow, u_pattern;
uniform sampler2D u_wide; // the pattern through a wide Gaussian (wide.frag)
uniform vec3 u_spread;    // the share of the pattern's light that is spread so; 0: none
uniform float u_shadow_depth, u_shadow_bias;
uniform bool u_shadows, u_footprint;
uniform int u_levels;                         // of the pattern's mip map
uniform vec3 u_intensity;
uniform float u_black; // the share of its white that the projector gives where its pattern is black
#define TILT_MAX 4.0
#define ROUGHNESS_MIN 0.02
#define NORMAL_MIN 0.05

// ffp_surface_point
vec3 slope_at(vec2 at) { return camera_rotation * vec3((at - camera_principal) / camera_focal, 1.0); }

// ffp_pattern_position: x, y in the pattern, depth from the projector
vec3 pattern_position(vec2 at, float z) {
  vec3 q = transpose(projector_rotation) * (camera_position + z * slope_at(at) - projector_position);
  return vec3(projector_principal + projector_focal * q.xy / q.z, q.z);
}

// ffp_pattern_step
vec2 pattern_step(ivec2 p, ivec2 along, vec2 here, float z) {
  vec3 flat_at = pattern_position(vec2(p + along) + 0.5, z);
  if (!(flat_at.z > 0.0)) return vec2(0.0);
  vec2 even = flat_at.xy - here, step = even;
  float least = 1e30;
  for (int side = -1; side <= 1; side += 2) {
    ivec2 n = p + side * along;
    if (any(lessThan(n, ivec2(0))) || any(greaterThanEqual(n, ivec2(camera_size)))) continue;
    float depth = depth_at(n), jump = abs(depth - z);
    if (depth == 0.0 || !(jump < least)) continue;
    vec3 there = pattern_position(vec2(n) + 0.5, depth);
    if (!(there.z > 0.0)) continue;
    least = jump;
    step = there.xy - here;
  }
  float most = TILT_MAX * TILT_MAX * dot(even, even), size = dot(step, step);
  return size <= most ? step : step * sqrt(most / size);
}

// ffp_pattern_extent
vec2 pattern_extent(ivec2 p, vec2 here, float z) {
  vec2 a = pattern_step(p, ivec2(1, 0), here, z), b = pattern_step(p, ivec2(0, 1), here, z);
  return max(sqrt(a * a + b * b), vec2(1.0));
}

// ffp_light_through
float light_through(vec2 uv, float z) {
  ivec2 size = textureSize(u_shadow, 0);
  vec2 at = uv * vec2(size) / projector_size - 0.5;
  ivec2 first = ivec2(floor(at));
  float held = 0.0;
  for (int k = 0; k < 4; k++) {
    ivec2 t = first + ivec2(k & 1, k >> 1);
    if (any(lessThan(t, ivec2(0))) || any(greaterThanEqual(t, size))) continue;
    vec2 near = 1.0 - abs(at - vec2(t));
    vec4 s = texelFetch(u_shadow, t, 0);
    if (s.w > OPACITY_MIN && s.w * z * (1.0 - u_shadow_bias) > s.x + u_shadow_depth * s.w)
      held += near.x * near.y * s.w;
  }
  return held < 1.0 ? 1.0 - held : 0.0;
}

struct Mapped {
  vec2 uv, extent;
  float visibility; // 0: no light
};

// ffp_map_pixel at any place, without the footprint
Mapped map_place(vec2 at, float z) {
  Mapped m = Mapped(vec2(-1.0), vec2(1.0), 0.0);
  if (z == 0.0) return m;
  vec3 there = pattern_position(at, z);
  m.uv = there.xy;
  if (!(there.z > 0.0) || any(lessThan(m.uv, vec2(0.0))) || any(greaterThan(m.uv, projector_size))) return m;
  m.visibility = u_shadows ? light_through(m.uv, there.z) : 1.0;
  return m;
}

// ffp_map_pixel
Mapped map_pixel(ivec2 p, float z) {
  Mapped m = map_place(vec2(p) + 0.5, z);
  if (u_footprint && m.visibility > 0.0) m.extent = pattern_extent(p, m.uv, z);
  return m;
}

// ffp_box_mean: the mean over a box of a pattern that is constant within a pixel and black outside. Exact on
// the pattern itself where the box is at most four pixels on its shorter and sixteen on its longer side,
// otherwise on the mip level on which it is.
vec3 box_mean(vec2 at, vec2 extent) {
  float shorter = min(extent.x, extent.y), longer = max(extent.x, extent.y);
  int level = int(clamp(ceil(max(log2(shorter / 4.0), log2(longer / 16.0))), 0.0, float(u_levels - 1)));
  ivec2 size = textureSize(u_pattern, level);
  vec2 shrink = vec2(size) / projector_size;
  vec2 low = (at - 0.5 * extent) * shrink, high = (at + 0.5 * extent) * shrink;
  ivec2 first = max(ivec2(floor(low)), ivec2(0)), last = min(ivec2(floor(high)), size - 1);
  last = min(last, first + 40);
  vec3 sum = vec3(0.0);
  for (int y = first.y; y <= last.y; y++) {
    float rows = min(high.y, float(y + 1)) - max(low.y, float(y));
    for (int x = first.x; x <= last.x; x++) {
      float columns = min(high.x, float(x + 1)) - max(low.x, float(x));
      sum += rows * columns * texelFetch(u_pattern, ivec2(x, y), level).rgb;
    }
  }
  vec2 area = high - low;
  return sum / (area.x * area.y);
}

// The pattern as it reaches the surface: ffp_image_spread.
vec3 light_shown(vec2 at, vec2 extent) {
  vec3 sharp = box_mean(at, extent);
  return u_spread == vec3(0.0) ? sharp : mix(sharp, textureLod(u_wide, at / projector_size, 0.0).rgb, u_spread);
}

// ffp_lobe: D F V
float lobe(float roughness, float nl, float nv, float nh, float vh) {
  float a = roughness * roughness, a2 = a * a, k = (roughness + 1.0) * (roughness + 1.0) / 8.0;
  float c = min(nh * nh, 1.0), q = (1.0 - c) + a2 * c;
  float gv = nv * (1.0 - k) + k, gl = nl * (1.0 - k) + k;
  float F = 0.04 + 0.96 * exp2((-5.55473 * vh - 6.98316) * vh);
  return a2 / (PI * q * q) * F / (4.0 * gv * gl);
}

// The share of light from direction l that goes to v, times the cosine: premultiplied by the opacity.
vec3 reflected(Sums s, vec3 v, vec3 l) {
  float size = length(s.normal), least = NORMAL_MIN * s.opacity;
  vec3 n = s.normal / max(size, least) * (dot(s.normal, v) < 0.0 ? -1.0 : 1.0);
  float nl = dot(n, l), nv = dot(n, v);
  vec3 h = l + v;
  float h_length = length(h);
  if (!(nl > 0.0) || !(h_length > 0.0)) return vec3(0.0);
  h /= h_length;
  float roughness = max(s.roughness / s.opacity, ROUGHNESS_MIN);
  vec3 f = s.albedo / s.opacity / PI + lobe(roughness, nl, nv, dot(n, h), dot(v, h));
  return f * nl * s.opacity;
}

// ffp_light_pixel: radiance from the projector, premultiplied by the opacity
vec3 light_pixel(ivec2 p, Sums s, Mapped m) {
  if (!(m.visibility > 0.0) || !(s.opacity > OPACITY_MIN)) return vec3(0.0);
  float z = s.depth / s.opacity;
  if (!(z > 0.0)) return vec3(0.0);
  vec3 slope = slope_at(vec2(p) + 0.5), point = camera_position + z * slope;
  vec3 l = projector_position - point, v = -normalize(slope);
  float distance = length(l);
  vec3 reflection = reflected(s, v, l / distance);
  if (reflection == vec3(0.0)) return vec3(0.0);
  return reflection * m.visibility * u_intensity / (distance * distance) * mix(light_shown(m.uv, m.extent), vec3(1.0), u_black);
}
