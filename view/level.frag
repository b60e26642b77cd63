// A pattern's mean over the part of it that falls on the splats: ffp_pattern_level.
#define ACROSS 32 // texels of the mip level that are added up, at most
uniform vec4 u_lit; // middle and size, pixels
layout(location = 0) out vec4 o_level;

void main() {
  int level = int(clamp(ceil(log2(max(u_lit.z, u_lit.w) / float(ACROSS))), 0.0, float(u_levels - 1)));
  vec2 shrink = vec2(textureSize(u_pattern, level)) / projector_size;
  vec2 low = (u_lit.xy - 0.5 * u_lit.zw) * shrink, high = (u_lit.xy + 0.5 * u_lit.zw) * shrink;
  ivec2 first = max(ivec2(low), ivec2(0)), last = min(ivec2(ceil(high)), textureSize(u_pattern, level)) - 1;
  vec4 sum = vec4(0.0);
  for (int y = first.y; y <= last.y; y++)
    for (int x = first.x; x <= last.x; x++) {
      vec2 part = min(high, vec2(x + 1, y + 1)) - max(low, vec2(x, y));
      vec3 shown = texelFetch(u_pattern, ivec2(x, y), level).rgb;
      if (u_spread != vec3(0.0)) shown = mix(shown, textureLod(u_wide, (vec2(x, y) + 0.5) / shrink / projector_size, 0.0).rgb, u_spread);
      sum += part.x * part.y * vec4(shown, 1.0);
    }
  o_level = sum / sum.w;
}
