// A pattern through a wide Gaussian, first across, then down: from a level of its mip map, ends repeated.
uniform sampler2D u_from;
uniform int u_mip;
uniform ivec2 u_along;
uniform float u_deviation; // texels of the level
layout(location = 0) out vec4 o_wide;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy), last = textureSize(u_from, u_mip) - 1;
  int reach = int(ceil(3.0 * u_deviation));
  vec4 sum = vec4(0.0);
  for (int i = -reach; i <= reach; i++)
    sum += exp(-0.5 * float(i * i) / (u_deviation * u_deviation)) * vec4(texelFetch(u_from, clamp(p + i * u_along, ivec2(0), last), u_mip).rgb, 1.0);
  o_wide = sum / sum.w;
}
