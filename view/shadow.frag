// Opacity and depth only, for a shadow map.
flat in vec2 f_at;
flat in vec4 f_power, f_a;
uniform float u_firmness;
layout(location = 0) out vec4 o_0;

void main() {
  vec2 d = f_at - gl_FragCoord.xy;
  float t = (f_power.x * d.x + f_power.y * d.y) * d.x + f_power.z * d.y * d.y;
  float density = f_power.w * exp2(clamp(t, -100.0, 0.0));
  float alpha = density * (1.0 + u_firmness * (1.0 - density));
  if (!(alpha >= ALPHA_MIN)) discard;
  o_0 = min(alpha, ALPHA_MAX) * vec4(f_a.x, 0.0, 0.0, 1.0);
}
