// Grows the known area by one pixel: the mean of the known ones among the eight neighbours (grow of engine/apply/closed.c).
uniform sampler2D u_known;
layout(location = 0) out vec4 o_wish;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy), size = textureSize(u_known, 0);
  o_wish = texelFetch(u_known, p, 0);
  if (o_wish.a > 0.0) return;
  vec4 sum = vec4(0.0);
  for (int y = max(p.y - 1, 0); y <= min(p.y + 1, size.y - 1); y++)
    for (int x = max(p.x - 1, 0); x <= min(p.x + 1, size.x - 1); x++) {
      vec4 there = texelFetch(u_known, ivec2(x, y), 0);
      if (there.a > 0.0) sum += vec4(there.rgb / there.a, 1.0);
    }
  if (sum.a > 0.0) o_wish = vec4(sum.rgb / sum.a, 1.0);
}
