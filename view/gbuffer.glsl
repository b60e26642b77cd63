// The sums W b of one sample, in four textures of RGBA whose alpha is the opacity:
// depth from u_depth, normal x y | normal z, albedo r g | albedo b, roughness, ambient r | ambient g b. Where splats scatter light
// (SCATTERS) it is in a fifth.
uniform sampler2D u_g0, u_g1, u_g2, u_g3, u_g4;
uniform float u_depth;

struct Sums {
  float opacity, depth;
  vec3 normal, albedo;
  float roughness;
  vec3 ambient;
};

Sums sums_of(vec4 a, vec4 b, vec4 c, vec4 d) {
  return Sums(a.w, a.x + u_depth * a.w, vec3(a.yz, b.x), vec3(b.yz, c.x), c.y, vec3(c.z, d.xy));
}

Sums sums_at(ivec2 p) {
  return sums_of(texelFetch(u_g0, p, 0), texelFetch(u_g1, p, 0), texelFetch(u_g2, p, 0), texelFetch(u_g3, p, 0));
}

// At a share of the picture.
Sums sums_between(vec2 share) {
  return sums_of(linear_at(u_g0, share), linear_at(u_g1, share), linear_at(u_g2, share), linear_at(u_g3, share));
}

// The depth of the surface, 0 where the opacity is too low for one.
float depth_at(ivec2 p) {
  vec4 a = texelFetch(u_g0, p, 0);
  return a.w > OPACITY_MIN ? a.x / a.w + u_depth : 0.0;
}
