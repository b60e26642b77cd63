// How much the surface bends at each pixel, across the direction in which it bends most, and that direction; outlines bend by all.
uniform sampler2D u_place, u_normal;
uniform int u_reach; // pixels
layout(location = 0) out vec4 o_bend; // bend, direction
#define OUTLINE 2.0

bool is_solid(ivec2 p) { return texelFetch(u_place, clamp(p, ivec2(0), textureSize(u_place, 0) - 1), 0).w >= 0.5; }

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy), last = textureSize(u_place, 0) - 1;
  o_bend = vec4(0.0);
  if (!is_solid(p)) return;
  vec3 here = texelFetch(u_place, p, 0).xyz;
  float pixel = texelFetch(u_normal, p, 0).w;
  for (int k = 0; k < 4; k++) {
    ivec2 along = ivec2(k == 2 ? 0 : 1, k == 0 ? 0 : k == 3 ? -1 : 1);
    for (int side = -1; side <= 1; side += 2) {
      ivec2 n = p + side * along;
      vec3 there = texelFetch(u_place, clamp(n, ivec2(0), last), 0).xyz;
      if (!is_solid(n) || (distance(here, there) > 8.0 * pixel && texelFetch(u_normal, p, 0).w < texelFetch(u_normal, clamp(n, ivec2(0), last), 0).w)) o_bend = vec4(OUTLINE, 0.0, 0.0, 0.0);
    }
    int reach = k == 1 || k == 3 ? (u_reach * 7 + 5) / 10 : u_reach;
    ivec2 a = clamp(p + reach * along, ivec2(0), last), b = clamp(p - reach * along, ivec2(0), last);
    if (!is_solid(a) || !is_solid(b)) continue;
    if (max(distance(here, texelFetch(u_place, a, 0).xyz), distance(here, texelFetch(u_place, b, 0).xyz)) > 5.0 * float(u_reach) * pixel) continue;
    float bend = 1.0 - dot(texelFetch(u_normal, a, 0).xyz, texelFetch(u_normal, b, 0).xyz);
    if (bend > o_bend.x) o_bend = vec4(bend, vec2(along), 0.0);
  }
}
