// Adds one projector's light: the mean of a pixel's samples, and what is scattered of it.
uniform int u_side;
uniform float u_brightness;
uniform sampler2D u_level; // one texel: the mean that scattered light follows
layout(location = 0) out vec4 o_mean;

void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * u_side;
  vec3 sum = vec3(0.0);
  for (int v = 0; v < u_side; v++)
    for (int u = 0; u < u_side; u++) {
      ivec2 p = first + ivec2(u, v);
#ifdef SCATTERS
      sum += u_brightness * mix(texelFetch(u_level, ivec2(0), 0).rgb, vec3(1.0), u_black) * texelFetch(u_g4, p, 0).rgb;
#endif
      Sums s = sums_at(p);
      if (!(s.opacity > OPACITY_MIN)) continue;
      sum += light_pixel(p, s, map_pixel(p, s.depth / s.opacity));
    }
  o_mean = vec4(sum / float(u_side * u_side), 0.0);
}
