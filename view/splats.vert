// A Gaussian as a camera sees it: engine/render/kernels/frame.h and project.c.
uniform highp usampler2D u_order; // the splats far to near; four vertices each
uniform sampler2D u_centres, u_scales, u_rotations, u_albedos, u_ambients, u_scattereds;
uniform mat3 camera_rotation; // columns: the camera's axes in the world
uniform vec3 camera_position;
uniform vec2 camera_focal, camera_principal, camera_size;
uniform vec2 u_corner; // of the part of the picture that is drawn
uniform float u_blur, u_firmness, u_depth;
uniform bool u_compensation;
flat out vec2 f_at;
flat out vec4 f_power; // 3 of the exponent, and the opacity
flat out vec4 f_a, f_b;
flat out vec3 f_c;
#ifdef SCATTERS
flat out vec3 f_d;
#endif

// rotation_matrix of frame.h
mat3 axes_of(vec4 q) {
  float w = q.x, x = q.y, y = q.z, z = q.w;
  return mat3(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y),
              2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x),
              2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y));
}

void main() {
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0); // not drawn
  int rank = gl_VertexID >> 2, splat = int(texelFetch(u_order, ivec2(rank & 2047, rank >> 11), 0).r);
  ivec2 texel = ivec2(splat & 2047, splat >> 11);
  vec4 centre = texelFetch(u_centres, texel, 0), scale = texelFetch(u_scales, texel, 0);
  mat3 R = axes_of(normalize(texelFetch(u_rotations, texel, 0)));
  mat3 K = transpose(camera_rotation) * R;
  // make_jacobian
  vec3 t = transpose(camera_rotation) * (centre.xyz - camera_position);
  if (!(t.z > max(scale.x, max(scale.y, scale.z)) && t.z > 0.0)) return;
  vec2 margin = HOLD_MARGIN * camera_size;
  vec2 slope = clamp(t.xy / t.z, (-camera_principal - margin) / camera_focal,
                     (camera_size - camera_principal + margin) / camera_focal);
  vec2 J0 = camera_focal / t.z, J1 = -J0 * slope;
  // make_covariance; of a matrix m[k] is column k
  vec3 m0 = vec3(J0.x * K[0].x + J1.x * K[0].z, J0.x * K[1].x + J1.x * K[1].z, J0.x * K[2].x + J1.x * K[2].z) * scale.xyz;
  vec3 m1 = vec3(J0.y * K[0].y + J1.y * K[0].z, J0.y * K[1].y + J1.y * K[1].z, J0.y * K[2].y + J1.y * K[2].z) * scale.xyz;
  float a = dot(m0, m0), c = dot(m1, m1), b = dot(m0, m1);
  vec3 minors = vec3(m0.x * m1.y - m0.y * m1.x, m0.x * m1.z - m0.z * m1.x, m0.y * m1.z - m0.z * m1.y);
  float before = dot(minors, minors), det = before + u_blur * (a + c) + u_blur * u_blur;
  a += u_blur, c += u_blur;
  if (!(det > 0.0 && a < 1e12 && c < 1e12)) return;
  float opacity = min(centre.w, 1.0);
  if (u_compensation) opacity *= max(sqrt(before / det), COMPENSATION_MIN);
  if (!(opacity * (1.0 + u_firmness) > ALPHA_MIN)) return;
  // make_normal: the first of the shortest axes, turned to the camera
  int shortest = scale.x <= scale.y && scale.x <= scale.z ? 0 : scale.y <= scale.z ? 1 : 2;
  vec3 normal = R[shortest] * (dot(t, K[shortest]) > 0.0 ? -1.0 : 1.0);
  // where alpha can reach 1/255: the ellipse's own box in place of bound_splats' upright one, and a little more
  float reach = 2.0 * log(255.0 * opacity * (1.0 + u_firmness)) + 0.02;
  float half_difference = 0.5 * (a - c), root = sqrt(half_difference * half_difference + b * b);
  float longer = 0.5 * (a + c) + root, shorter = det / longer;
  vec2 along = half_difference >= 0.0 ? vec2(half_difference + root, b) : vec2(b, root - half_difference);
  along = root > 0.0 ? normalize(along) : vec2(1.0, 0.0);
  vec2 corner = vec2((gl_VertexID & 1) == 0 ? -1.0 : 1.0, (gl_VertexID & 2) == 0 ? -1.0 : 1.0);
  f_at = camera_focal * (t.xy / t.z) + camera_principal;
  vec2 pixel = f_at + corner.x * sqrt(reach * longer) * along +
               corner.y * sqrt(reach * max(shorter, 0.0)) * vec2(-along.y, along.x);
  gl_Position = vec4(2.0 * pixel / camera_size - 1.0, 0.0, 1.0);
  f_at -= u_corner;
  float power = -0.5 * LOG2_E / det;
  f_power = vec4(power * c, -2.0 * power * b, power * a, opacity);
  vec3 albedo = texelFetch(u_albedos, texel, 0).rgb, ambient = texelFetch(u_ambients, texel, 0).rgb;
  f_a = vec4(t.z - u_depth, normal);
  f_b = vec4(albedo, scale.w);
  f_c = ambient;
#ifdef SCATTERS
  f_d = texelFetch(u_scattereds, texel, 0).rgb;
#endif
}
