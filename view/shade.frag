// Adds one projector's light: the mean of a pixel's samples.
uniform int u_side;
layout(location = 0) out vec4 o_mean;

void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * u_side;
  vec3 sum = vec3(0.0);
  for (int v = 0; v < u_side; v++)
    for (int u = 0; u < u_side; u++) {
      ivec2 p = first + ivec2(u, v);
      Sums s = sums_at(p);
      if (!(s.opacity > OPACITY_MIN)) continue;
      sum += light_pixel(p, s, map_pixel(p, s.depth / s.opacity));
    }
  o_mean = vec4(sum / float(u_side * u_side), 0.0);
}
