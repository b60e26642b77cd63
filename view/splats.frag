// Alpha and the values weighted by it, as cover_block in engine/render/kernels/blocks.h. Splats are blended from far to
// near, which gives the sums W_i b_i of front-to-back blending. Depths are relative to u_depth, so that sums in 16 bits
// are precise enough. The layout: see gbuffer.glsl.
flat in vec2 f_at;
flat in vec4 f_power, f_a, f_b;
flat in vec3 f_c;
#ifdef SCATTERS
flat in vec3 f_d;
layout(location = 4) out vec4 o_4;
#endif
uniform float u_firmness;
layout(location = 0) out vec4 o_0;
layout(location = 1) out vec4 o_1;
layout(location = 2) out vec4 o_2;
layout(location = 3) out vec4 o_3;

void main() {
  vec2 d = f_at - gl_FragCoord.xy;
  float t = (f_power.x * d.x + f_power.y * d.y) * d.x + f_power.z * d.y * d.y;
  float density = f_power.w * exp2(clamp(t, -100.0, 0.0));
  float alpha = density * (1.0 + u_firmness * (1.0 - density));
  if (!(alpha >= ALPHA_MIN)) discard;
  alpha = min(alpha, ALPHA_MAX);
  o_0 = alpha * vec4(f_a.xyz, 1.0);
  o_1 = alpha * vec4(f_a.w, f_b.xy, 1.0);
  o_2 = alpha * vec4(f_b.zw, f_c.x, 1.0);
  o_3 = alpha * vec4(f_c.yz, 0.0, 1.0);
#ifdef SCATTERS
  o_4 = alpha * vec4(f_d, 1.0);
#endif
}
