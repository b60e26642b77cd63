layout(location = 0) out vec4 o_black;

void main() { o_black = vec4(0.0, 0.0, 0.0, 1.0); }
