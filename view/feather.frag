// A projector's feather from the nearest end of what it lights: ffp_lit_surface_feather.
#define FEATHER_MIN 0.01
uniform sampler2D u_edges;
uniform highp usampler2D u_near;
uniform float u_reach;
layout(location = 0) out vec4 o_feather;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  uvec2 near = texelFetch(u_near, p, 0).xy;
  float t = near.x == NOWHERE ? 1.0 : min(distance(vec2(p), vec2(near)) / u_reach, 1.0);
  o_feather = vec4(max(t * t * (3.0 - 2.0 * t) * texelFetch(u_edges, p, 0).x, FEATHER_MIN));
}
