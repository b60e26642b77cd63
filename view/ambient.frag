// A pixel's light under dark projectors, with the covered share of the pixel as alpha: means over the samples.
uniform sampler2D u_g2, u_g3;
uniform int u_side;
uniform float u_ambient; // 1 if the ambient light is on, otherwise 0
layout(location = 0) out vec4 o_mean;

void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * u_side;
  vec4 sum = vec4(0.0);
  for (int v = 0; v < u_side; v++)
    for (int u = 0; u < u_side; u++) {
      ivec2 p = first + ivec2(u, v);
      vec4 c = texelFetch(u_g2, p, 0), d = texelFetch(u_g3, p, 0);
      sum += vec4(u_ambient * vec3(c.z, d.xy), d.w);
    }
  o_mean = sum / float(u_side * u_side);
}
