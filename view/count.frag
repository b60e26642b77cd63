// How many projectors light what one lights, at a few of its pixels; 0 where it lights nothing that the camera sees.
uniform sampler2D u_response, u_whites;
layout(location = 0) out vec4 o_count;

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy * vec2(textureSize(u_response, 0)) / COUNT_SIDE);
  o_count = vec4(texelFetch(u_response, p, 0).a == LIT ? 1.0 + floor(texelFetch(u_whites, p, 0).a + 0.5) : 0.0);
}
