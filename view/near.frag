// The nearest pixel whose level is known, which others take theirs from: jump flooding (Rong and Tan 2006).
uniform sampler2D u_response;
uniform highp usampler2D u_near;
uniform int u_step;    // 0: each pixel for itself
uniform vec2 u_limits; // how far it may be: within the object, and beyond its outline
layout(location = 0) out uvec2 o_near;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy), size = textureSize(u_response, 0);
  float part = texelFetch(u_response, p, 0).a, least = part > 0.0 ? u_limits.x : u_limits.y;
  if (u_step > 1) least = 1e9; // others may be reached through this one
  least *= least;
  o_near = uvec2(NOWHERE);
  if (u_step == 0) {
    if (part == LIT) o_near = uvec2(p);
    return;
  }
  for (int k = 0; k < 9; k++) {
    ivec2 q = p + u_step * ivec2(k % 3 - 1, k / 3 - 1);
    if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, size))) continue;
    uvec2 near = texelFetch(u_near, q, 0).xy;
    vec2 away = vec2(ivec2(near) - p);
    if (near.x == NOWHERE || dot(away, away) > least) continue;
    least = dot(away, away);
    o_near = near;
  }
}
