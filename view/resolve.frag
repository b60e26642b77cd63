// From mean radiance to the picture: ffp_resolve_pixel, premultiplied by the covered share of the pixel; with u_deviation the
// outlines of pictures finer than the photographs are smoothed as by ffp_resolve_smoothly.
uniform sampler2D u_mean;
uniform int u_side;
uniform float u_exposure, u_deviation; // pixels; 0: as they are
uniform bool u_flip;                   // the canvas has row 0 at the bottom
uniform vec2 u_size;
layout(location = 0) out vec4 o_picture;
#define WHOLE 0.99

vec4 mean_at(ivec2 p) { return texelFetch(u_mean, clamp(p, ivec2(0), ivec2(u_size) - 1), 0); }

// Whole or empty, and so is what lies around it: as far as is looked, and half as far.
bool is_even(ivec2 p, vec4 mean, int reach) {
  if (mean.w < WHOLE && mean.w >= OPACITY_MIN) return false;
  for (int k = 0; k < 16; k++) {
    int n = k % 8 < 4 ? k % 8 : k % 8 + 1, away = k < 8 ? reach : (reach + 1) / 2;
    float other = mean_at(p + away * ivec2(n % 3 - 1, n / 3 - 1)).w;
    if (mean.w >= WHOLE ? other < WHOLE : other >= OPACITY_MIN) return false;
  }
  return true;
}

vec4 mean_around(ivec2 p, int reach) {
  vec4 sum = vec4(0.0);
  float weights = 0.0;
  for (int v = -reach; v <= reach; v++)
    for (int u = -reach; u <= reach; u++) {
      float weight = exp(-float(u * u + v * v) / (2.0 * u_deviation * u_deviation));
      sum += weight * mean_at(p + ivec2(u, v));
      weights += weight;
    }
  return sum / weights;
}

void main() {
  vec2 at = gl_FragCoord.xy;
  if (u_flip) at.y = u_size.y - at.y;
  ivec2 p = ivec2(at);
  vec4 mean = mean_at(p);
  float covered = u_side > 1 && mean.w >= OPACITY_MIN ? mean.w : 1.0, opacity = mean.w;
  vec3 light = mean.rgb / covered;
  int reach = int(ceil(2.0 * u_deviation));
  if (u_deviation > 0.0 && !is_even(p, mean, reach)) {
    vec4 around = mean_around(p, reach);
    if (around.w >= OPACITY_MIN && (mean.w < WHOLE || around.w < WHOLE)) {
      covered = opacity = clamp(0.5 + sqrt(2.0 * PI * (u_deviation * u_deviation + 1.0 / 12.0)) * (around.w - 0.5), 0.0, 1.0);
      light = mean.rgb + max(1.0 - mean.w, 0.0) / around.w * around.rgb;
    }
  }
  o_picture = vec4(covered * srgb_encode(u_exposure * light), opacity);
}
