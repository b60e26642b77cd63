// The picture sent to the real projector: the pattern at its panel's size, with the inverse of its lens distortion
// (rig/optics/lens.h has the formula) and of its gamma.
uniform sampler2D u_pattern;
uniform vec2 projector_focal, projector_principal, projector_size;
uniform vec2 u_panel_focal, u_panel_principal;
uniform vec3 u_radial, u_gamma; // k1 k2 k3; 0: the sRGB curve
uniform vec2 u_tangential;      // p1 p2
uniform ivec2 u_samples;        // across and down a pixel of the panel
layout(location = 0) out vec4 o_sent;

vec2 distort(vec2 x) {
  float r2 = dot(x, x), radial = 1.0 + r2 * (u_radial.x + r2 * (u_radial.y + r2 * u_radial.z));
  return x * radial + vec2(2.0 * u_tangential.x * x.x * x.y + u_tangential.y * (r2 + 2.0 * x.x * x.x),
                           2.0 * u_tangential.y * x.x * x.y + u_tangential.x * (r2 + 2.0 * x.y * x.y));
}

// The pattern's light at the position where a panel position sends its ray: add_sample of core/capture/panel.c.
vec3 light_at(vec2 place) {
  vec2 wanted = (place - u_panel_principal) / u_panel_focal, x = wanted;
  for (int i = 0; i < 20; i++) x += wanted - distort(x);
  vec2 at = projector_principal + projector_focal * x;
  if (any(lessThan(at, vec2(0.0))) || any(greaterThan(at, projector_size))) return vec3(0.0);
  vec2 from = clamp(at - 0.5, vec2(0.0), projector_size - 1.0);
  ivec2 first = ivec2(floor(from)), next = min(first + 1, ivec2(projector_size) - 1);
  vec2 w = from - vec2(first);
  vec3 top = mix(texelFetch(u_pattern, first, 0).rgb, texelFetch(u_pattern, ivec2(next.x, first.y), 0).rgb, w.x);
  vec3 bottom = mix(texelFetch(u_pattern, ivec2(first.x, next.y), 0).rgb, texelFetch(u_pattern, next, 0).rgb, w.x);
  return mix(top, bottom, w.y);
}

// ffp_panel_picture
void main() {
  vec2 corner = floor(gl_FragCoord.xy);
  vec3 light = vec3(0.0);
  for (int v = 0; v < u_samples.y; v++)
    for (int u = 0; u < u_samples.x; u++) light += light_at(corner + (vec2(u, v) + 0.5) / vec2(u_samples));
  light /= float(u_samples.x * u_samples.y);
  o_sent = vec4(u_gamma.x > 0.0 ? pow(light, 1.0 / u_gamma) : srgb_encode(light), 1.0);
}
