// Light that an effect (effects.js) sends to each pixel of what a device sees, in the colour that it is given; alpha: how much.
uniform sampler2D u_place, u_normal; // of relief.frag
uniform highp usampler2D u_near;     // the nearest pixel of a crease or an outline
uniform int u_kind;
uniform float u_phase, u_size, u_level; // 0 to 1; the sound's level times the gain
uniform vec3 u_colour, u_eye, u_up;
uniform vec2 u_heights, u_depths;       // from where to where the object goes
layout(location = 0) out vec4 o_light;

// Three numbers from 0 to 1 for a cell (Jarzynski and Olano 2020, pcg3d).
vec3 hash(ivec3 cell) {
  uvec3 v = uvec3(cell + 4096) * 1664525u + 1013904223u;
  v.x += v.y * v.z, v.y += v.z * v.x, v.z += v.x * v.y;
  v ^= v >> 16u;
  v.x += v.y * v.z, v.y += v.z * v.x, v.z += v.x * v.y;
  return vec3(v >> 8u) / 16777216.0;
}

float band(float away, float width) { return 1.0 - smoothstep(0.0, width, abs(away)); }

float scan_line(float height) {
  float width = mix(0.005, 0.25, u_size);
  return band(height - mix(-width, 1.0 + width, u_phase), width);
}

// Lines on creases and outlines; the light on them runs up.
float creases(ivec2 p, float height, float pixel) {
  uvec2 near = texelFetch(u_near, p, 0).xy;
  if (near.x == NOWHERE) return 0.0;
  float half_width = max(mix(0.002, 0.03, u_size) / pixel, 0.75);
  float wave = 0.5 + 0.5 * cos(2.0 * PI * (height - u_phase));
  return (1.0 - smoothstep(half_width - 0.75, half_width + 0.75, distance(vec2(p), vec2(near)))) * mix(0.1, 1.0, wave * wave * wave);
}

// A front that goes away from the eye, and what it leaves behind.
float sweep(vec3 place) {
  float depth = (distance(place, u_eye) - u_depths.x) / (u_depths.y - u_depths.x), tail = mix(0.03, 0.8, u_size), behind = u_phase * (1.0 + tail) - depth;
  return smoothstep(0.0, 0.01, behind) * (1.0 - smoothstep(0.0, tail, behind));
}

// Dots in cells of space, each with a time of its own.
float sparkle(vec3 place) {
  vec3 at = place / mix(0.025, 0.15, u_size);
  ivec3 first = ivec3(floor(at - 0.5));
  float light = 0.0;
  for (int k = 0; k < 8; k++) {
    ivec3 cell = first + ivec3(k & 1, k >> 1 & 1, k >> 2);
    vec3 h = hash(cell);
    float twinkle = max(0.0, sin(2.0 * PI * (u_phase * (1.0 + floor(3.0 * h.z)) + h.x + h.y)));
    light = max(light, pow(twinkle, 6.0) * (1.0 - smoothstep(0.1, 0.45, distance(at, vec3(cell) + h))));
  }
  return light;
}

// As far from the middle as it is loud.
float pulse(vec3 place) {
  float soft = mix(0.03, 0.8, u_size), reach = u_level * (1.0 + soft);
  return 1.0 - smoothstep(reach - soft, reach, length(place));
}

// A lamp that goes round the object, lower or higher.
float lamp(vec3 place, vec3 normal) {
  float around = 2.0 * PI * u_phase, above = radians(mix(-20.0, 80.0, u_size));
  vec3 right = normalize(abs(u_up.x) < 0.9 ? cross(u_up, vec3(1.0, 0.0, 0.0)) : cross(u_up, vec3(0.0, 1.0, 0.0)));
  vec3 at = 2.5 * (cos(above) * (cos(around) * right + sin(around) * cross(u_up, right)) + sin(above) * u_up);
  return max(dot(normal, normalize(at - place)), 0.0);
}

void main() {
  ivec2 p = ivec2(gl_FragCoord.xy);
  vec4 place = texelFetch(u_place, p, 0), normal = texelFetch(u_normal, p, 0);
  float height = (dot(place.xyz, u_up) - u_heights.x) / (u_heights.y - u_heights.x), light = 0.0;
  if (place.w > 0.3) {
    if (u_kind == 0) light = scan_line(height);
    if (u_kind == 1) light = creases(p, height, normal.w);
    if (u_kind == 2) light = sweep(place.xyz);
    if (u_kind == 3) light = sparkle(place.xyz);
    if (u_kind == 4) light = pulse(place.xyz);
    if (u_kind == 5) light = lamp(place.xyz, normal.xyz);
  }
  o_light = vec4(u_colour, light * smoothstep(0.3, 0.7, place.w));
}
