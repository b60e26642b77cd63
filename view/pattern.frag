// The pattern itself, and the paint on it. The target is sRGB: what is written is linear, what is kept encoded.
uniform sampler2D u_known, u_paint;
layout(location = 0) out vec4 o_pattern;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 known = texelFetch(u_known, p, 0), paint = texelFetch(u_paint, p, 0);
  vec3 level = known.a > 0.0 ? min(known.rgb / known.a, 1.0) : vec3(0.0);
  o_pattern = vec4(mix(level, paint.rgb, paint.a), 1.0);
}
