// Its source, multiplied by alpha, to a picture that is not.
uniform sampler2D u_source;
in vec2 v_at;
layout(location = 0) out vec4 o_picture;

void main() {
  vec4 seen = texture(u_source, v_at);
  o_picture = seen.a > 0.0 ? vec4(seen.rgb / seen.a, seen.a) : vec4(0.0);
}
