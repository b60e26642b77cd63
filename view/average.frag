// Means over side x side samples, as ffp_average_gbuffer.
uniform sampler2D u_g0, u_g1, u_g2, u_g3;
uniform int u_side;
layout(location = 0) out vec4 o_0;
layout(location = 1) out vec4 o_1;
layout(location = 2) out vec4 o_2;
layout(location = 3) out vec4 o_3;

void main() {
  ivec2 first = ivec2(gl_FragCoord.xy) * u_side;
  o_0 = o_1 = o_2 = o_3 = vec4(0.0);
  for (int v = 0; v < u_side; v++)
    for (int u = 0; u < u_side; u++) {
      ivec2 p = first + ivec2(u, v);
      o_0 += texelFetch(u_g0, p, 0), o_1 += texelFetch(u_g1, p, 0);
      o_2 += texelFetch(u_g2, p, 0), o_3 += texelFetch(u_g3, p, 0);
    }
  float share = 1.0 / float(u_side * u_side);
  o_0 *= share, o_1 *= share, o_2 *= share, o_3 *= share;
}
