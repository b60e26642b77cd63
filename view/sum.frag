// A projector's level, to be added up.
uniform sampler2D u_level;
uniform float u_brightness, u_black;
layout(location = 0) out vec4 o_level;

void main() { o_level = u_brightness * mix(texelFetch(u_level, ivec2(0), 0), vec4(1.0), u_black); }
