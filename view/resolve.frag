// From mean radiance to the picture: ffp_resolve_pixel, premultiplied by the covered share of the pixel.
uniform sampler2D u_mean;
uniform int u_side;
uniform float u_exposure;
uniform bool u_flip; // the canvas has row 0 at the bottom
uniform vec2 u_size;
layout(location = 0) out vec4 o_picture;

void main() {
  vec2 at = gl_FragCoord.xy;
  if (u_flip) at.y = u_size.y - at.y;
  vec4 mean = texelFetch(u_mean, ivec2(at), 0);
  float covered = u_side > 1 && mean.w >= OPACITY_MIN ? mean.w : 1.0;
  o_picture = vec4(covered * srgb_encode(u_exposure * mean.rgb / covered), mean.w);
}
