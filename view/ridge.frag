// Creases: pixels that bend more than those on both sides. LIT in alpha, as near.frag looks for; the object elsewhere is HIDDEN.
uniform sampler2D u_bend, u_place;
uniform float u_least;
layout(location = 0) out vec4 o_ridge;
#define OUTLINE 2.0

// The mean along the crease that runs across a direction.
float bend_at(ivec2 p, ivec2 along) {
  ivec2 last = textureSize(u_bend, 0) - 1, on = ivec2(-along.y, along.x);
  float sum = 0.0, count = 0.0;
  for (int k = -5; k <= 5; k++) {
    float bend = texelFetch(u_bend, clamp(p + k * on, ivec2(0), last), 0).x;
    if (bend < OUTLINE) sum += bend, count += 1.0;
  }
  return count > 0.0 ? sum / count : 0.0;
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy), along = ivec2(texelFetch(u_bend, p, 0).yz);
  float here = texelFetch(u_bend, p, 0).x;
  bool most = here >= OUTLINE;
  if (!most && here > u_least) {
    here = bend_at(p, along);
    most = here > u_least;
    for (int k = 1; k <= 4; k++) most = most && here >= bend_at(p + k * along, along) && here > bend_at(p - k * along, along);
  }
  o_ridge = vec4(here, 0.0, 0.0, most ? LIT : texelFetch(u_place, p, 0).w >= 0.5 ? HIDDEN : 0.0);
}
