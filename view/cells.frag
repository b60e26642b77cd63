// The requested level at the camera pixel that a projector pixel lights (gather of engine/apply/closed.c).
in vec2 f_camera;
uniform sampler2D u_wishes;
layout(location = 0) out vec4 o_wish;

// ffp_image_sample: bilinear, held at the edges
void main() {
  ivec2 size = textureSize(u_wishes, 0);
  vec2 at = clamp(f_camera - 0.5, vec2(0.0), vec2(size - 1));
  ivec2 first = ivec2(floor(at)), next = min(first + 1, size - 1);
  vec2 w = at - vec2(first);
  vec4 top = mix(texelFetch(u_wishes, first, 0), texelFetch(u_wishes, ivec2(next.x, first.y), 0), w.x);
  vec4 bottom = mix(texelFetch(u_wishes, ivec2(first.x, next.y), 0), texelFetch(u_wishes, next, 0), w.x);
  o_wish = mix(top, bottom, w.y);
}
