// Distance bounds of the parts and their joining. The formulas for box, torus, capped and rounded cone are
// elementary geometry; the smooth minimum is the quadratic one.
#include "world/shapes/shape.h"
#include <assert.h>
#include <math.h>
#include <string.h>
#include "world/shapes/noise.h"
#include "world/shapes/scalar.h"

void ffp_shape_init(FfpShape *shape, uint32_t noise_seed) {
    memset(shape, 0, sizeof *shape);
    shape->noise_seed = noise_seed;
    shape->bump_frequency = 1;
    shape->lipschitz = 1.5F;
    shape->upright = true;
}

FfpRng ffp_shape_rng(const FfpShape *shape) {
    return ffp_rng(0x5a4fe5, shape->noise_seed);
}

static FfpPart *add(FfpShape *shape, FfpPartKind kind, FfpV3 centre, float blend) {
    assert(shape->n_parts < FFP_PARTS_MAX);
    FfpPart *part = &shape->parts[shape->n_parts++];
    *part = (FfpPart){.kind = kind, .blend = blend, .centre = {centre.x, centre.y, centre.z}};
    part->axes[0] = part->axes[4] = part->axes[8] = 1;
    return part;
}

static void set3(float out[3], float x, float y, float z) {
    out[0] = x, out[1] = y, out[2] = z;
}

FfpPart *ffp_add_ellipsoid(FfpShape *shape, FfpV3 centre, FfpV3 half, float blend) {
    FfpPart *part = add(shape, FFP_PART_ELLIPSOID, centre, blend);
    set3(part->size, half.x, half.y, half.z);
    set3(part->reach, half.x, half.y, half.z);
    return part;
}

FfpPart *ffp_add_cone(FfpShape *shape, FfpV3 a, FfpV3 b, float radius_a, float radius_b, float blend) {
    FfpPart *part = add(shape, FFP_PART_CONE, a, blend);
    const FfpV3 way = {b.x - a.x, b.y - a.y, b.z - a.z};
    const float length = ffp_max(sqrtf(way.x * way.x + way.y * way.y + way.z * way.z), 1e-4F);
    const float radius = ffp_max(radius_a, radius_b);
    set3(part->size, radius_a, radius_b, length);
    set3(part->reach, radius, radius, 0.5F * length + radius);
    part->middle[2] = 0.5F * length;
    ffp_part_align(part, way);
    return part;
}

FfpPart *ffp_add_box(FfpShape *shape, FfpV3 centre, FfpV3 half, float corner, float blend) {
    FfpPart *part = add(shape, FFP_PART_BOX, centre, blend);
    set3(part->size, half.x, half.y, half.z);
    part->size[3] = ffp_min(corner, ffp_min(half.x, ffp_min(half.y, half.z)));
    set3(part->reach, half.x, half.y, half.z);
    return part;
}

FfpPart *ffp_add_cylinder(FfpShape *shape, FfpV3 centre, float radius, float half, float edge, float blend) {
    FfpPart *part = add(shape, FFP_PART_CYLINDER, centre, blend);
    set3(part->size, radius, half, ffp_min(edge, ffp_min(radius, half)));
    set3(part->reach, radius, radius, half);
    return part;
}

FfpPart *ffp_add_torus(FfpShape *shape, FfpV3 centre, float ring, float tube, float blend) {
    FfpPart *part = add(shape, FFP_PART_TORUS, centre, blend);
    set3(part->size, ring, tube, 0);
    set3(part->reach, ring + tube, ring + tube, tube);
    return part;
}

// Lets the outline run on smoothly, halfway between the directions of two edges, where they meet at less than
// 0.4 radians; other corners stay sharp.
static void smooth_outline(FfpShape *shape) {
    for (int i = 0; i < shape->n_outline; i++) {
        float *e = shape->edge[i], *next = shape->edge[(i + 1) % shape->n_outline];
        const float turn = atan2f(e[0] * next[1] - e[1] * next[0], e[0] * next[0] + e[1] * next[1]);
        const float slope = fabsf(turn) < 0.4F ? tanf(0.5F * turn) : 0;
        e[4] = slope / sqrtf(e[2]);
        next[3] = -slope / sqrtf(next[2]);
    }
}

FfpPart *ffp_add_lathe(FfpShape *shape, float rounding, float blend) {
    FfpPart *part = add(shape, FFP_PART_LATHE, ffp_v3(0, 0, 0), blend);
    float radius = 0, low = 1e9F, high = -1e9F;
    for (int i = 0; i < shape->n_outline; i++) {
        radius = ffp_max(radius, shape->outline[i][0]);
        low = ffp_min(low, shape->outline[i][1]);
        high = ffp_max(high, shape->outline[i][1]);
    }
    for (int i = 0; i < shape->n_outline; i++) {
        const float *a = shape->outline[i ? i - 1 : shape->n_outline - 1], *b = shape->outline[i];
        float *e = shape->edge[i];
        e[0] = b[0] - a[0], e[1] = b[1] - a[1];
        e[2] = 1 / ffp_max(e[0] * e[0] + e[1] * e[1], 1e-12F);
    }
    smooth_outline(shape);
    part->size[0] = rounding;
    set3(part->reach, radius + rounding, radius + rounding, 0.5F * (high - low) + rounding);
    part->middle[2] = 0.5F * (low + high);
    return part;
}

FfpPart *ffp_add_cog(FfpShape *shape, FfpV3 centre, float radius, float half, float tooth, int teeth,
                     float sharpness) {
    FfpPart *part = add(shape, FFP_PART_COG, centre, 0);
    set3(part->size, radius, half, tooth);
    part->size[3] = 0.03F;
    part->also[0] = (float)teeth, part->also[1] = sharpness;
    set3(part->reach, radius + tooth, radius + tooth, half);
    return part;
}

FfpPart *ffp_add_prism(FfpShape *shape, FfpV3 centre, int sides, float radius_low, float radius_high,
                       float half, float blend) {
    FfpPart *part = add(shape, FFP_PART_PRISM, centre, blend);
    const float radius = ffp_max(radius_low, radius_high);
    set3(part->size, radius_low, radius_high, half);
    part->also[0] = (float)sides;
    set3(part->reach, radius, radius, half);
    return part;
}

FfpPart *ffp_add_superquadric(FfpShape *shape, FfpV3 centre, FfpV3 half, float exponent_z,
                              float exponent_xy) {
    FfpPart *part = add(shape, FFP_PART_SUPERQUADRIC, centre, 0);
    set3(part->size, half.x, half.y, half.z);
    part->also[0] = exponent_z, part->also[1] = exponent_xy;
    set3(part->reach, half.x, half.y, half.z);
    return part;
}

FfpPart *ffp_add_land(FfpShape *shape, FfpV3 half, float hills) {
    FfpPart *part = add(shape, FFP_PART_LAND, ffp_v3(0, 0, 0), 0);
    set3(part->size, half.x, half.y, half.z);
    part->size[3] = hills;
    set3(part->reach, half.x, half.y, half.z + hills);
    return part;
}

// Catmull-Rom between b and c.
static float curve(float a, float b, float c, float d, float t) {
    return b + 0.5F * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

void ffp_add_tube(FfpShape *shape, const float (*point)[4], int n, float side, float yaw, float blend) {
    enum { STEPS = 6 };
    const float cosine = cosf(yaw), sine = sinf(yaw);
    FfpV3 last = {0};
    float last_radius = 0;
    for (int i = 0; i <= STEPS * (n - 1); i++) {
        const int k = i < STEPS * (n - 1) ? i / STEPS : n - 2;
        const float t = (float)(i - STEPS * k) / STEPS;
        const float *a = point[k > 0 ? k - 1 : 0], *d = point[k + 2 < n ? k + 2 : n - 1];
        float at[4];
        for (int c = 0; c < 4; c++) at[c] = curve(a[c], point[k][c], point[k + 1][c], d[c], t);
        at[1] *= side;
        const FfpV3 next = {cosine * at[0] - sine * at[1], sine * at[0] + cosine * at[1], at[2]};
        if (i > 0) ffp_add_cone(shape, last, next, last_radius, at[3], i == 1 ? blend : 0);
        last = next, last_radius = at[3];
    }
}

FfpPart *ffp_cut(FfpPart *part) {
    part->join = FFP_CSG_DIFFERENCE;
    return part;
}

void ffp_part_align(FfpPart *part, FfpV3 d) {
    const float length = sqrtf(d.x * d.x + d.y * d.y + d.z * d.z);
    if (length < 1e-6F) return;
    const float z[3] = {d.x / length, d.y / length, d.z / length};
    // the helper axis is the one least along z
    const int a =
        fabsf(z[0]) < fabsf(z[1]) ? (fabsf(z[0]) < fabsf(z[2]) ? 0 : 2) : (fabsf(z[1]) < fabsf(z[2]) ? 1 : 2);
    float x[3] = {-z[a] * z[0], -z[a] * z[1], -z[a] * z[2]};
    x[a] += 1;
    const float n = 1 / sqrtf(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    for (int i = 0; i < 3; i++) part->axes[i] = x[i] *= n, part->axes[6 + i] = z[i];
    for (int i = 0; i < 3; i++)
        part->axes[3 + i] = z[(i + 1) % 3] * x[(i + 2) % 3] - z[(i + 2) % 3] * x[(i + 1) % 3];
}

void ffp_part_rotate(FfpPart *part, float yaw, float pitch, float roll) {
    const float cy = cosf(yaw), sy = sinf(yaw), cp = cosf(pitch), sp = sinf(pitch), cr = cosf(roll),
                sr = sinf(roll);
    // columns of Rz(yaw) Ry(pitch) Rx(roll) are the part's axes
    const float r[9] = {cy * cp,
                        sy * cp,
                        -sp,
                        cy * sp * sr - sy * cr,
                        sy * sp * sr + cy * cr,
                        cp * sr,
                        cy * sp * cr + sy * sr,
                        sy * sp * cr - cy * sr,
                        cp * cr};
    memcpy(part->axes, r, sizeof r);
}

static float ellipsoid(const float q[3], const float r[3]) {
    float k0 = 0, k1 = 0;
    for (int i = 0; i < 3; i++) {
        const float a = q[i] / r[i], b = a / r[i];
        k0 += a * a, k1 += b * b;
    }
    k0 = sqrtf(k0), k1 = sqrtf(k1);
    if (k1 < 1e-6F) return -ffp_min(r[0], ffp_min(r[1], r[2]));
    return k0 * (k0 - 1) / k1; // first-order distance
}

static float cone(const float q[3], const float size[4]) {
    const float ra = size[0], rb = size[1], length = size[2];
    const float slope = ffp_max(ffp_min((ra - rb) / length, 0.99F), -0.99F),
                across = sqrtf(1 - slope * slope);
    const float r = sqrtf(q[0] * q[0] + q[1] * q[1]), along = across * q[2] - slope * r;
    if (along < 0) return sqrtf(r * r + q[2] * q[2]) - ra;
    const float z = q[2] - length;
    if (along > across * length) return sqrtf(r * r + z * z) - rb;
    return across * r + slope * q[2] - ra;
}

static float slab2(float dx, float dy) {
    const float ox = ffp_max(dx, 0), oy = ffp_max(dy, 0);
    return ffp_min(ffp_max(dx, dy), 0) + sqrtf(ox * ox + oy * oy);
}

static float box(const float q[3], const float size[4]) {
    float outside = 0, inside = -1e9F;
    for (int i = 0; i < 3; i++) {
        const float d = fabsf(q[i]) - size[i] + size[3], o = ffp_max(d, 0);
        outside += o * o;
        inside = ffp_max(inside, d);
    }
    return ffp_min(inside, 0) + sqrtf(outside) - size[3];
}

// Distance to the outline in the (radius, z) half plane: to the polygon, crossing number for the sign, less
// the height of the cubic Hermite curve above its nearest edge.
static float lathe(const FfpShape *shape, const float q[3], float rounding) {
    const float x = sqrtf(q[0] * q[0] + q[1] * q[1]), y = q[2];
    float best = 1e18F, height = 0;
    bool inside = false;
    for (int i = 0, j = shape->n_outline - 1; i < shape->n_outline; j = i++) {
        const float *a = shape->outline[j], *b = shape->outline[i], *e = shape->edge[i];
        const float wx = x - a[0], wy = y - a[1];
        const float t = ffp_max(0, ffp_min(1, (wx * e[0] + wy * e[1]) * e[2]));
        const float dx = wx - t * e[0], dy = wy - t * e[1];
        const float square = dx * dx + dy * dy;
        if (square < best && (a[0] > 0 || b[0] > 0)) // the edge on the axis is not a surface
            best = square, height = t * (1 - t) * (e[3] * (1 - t) - e[4] * t);
        if ((a[1] > y) != (b[1] > y) && wx < e[0] * wy / e[1]) inside = !inside;
    }
    return (inside ? -sqrtf(best) : sqrtf(best)) + height - rounding;
}

static float cog(const FfpPart *part, const float q[3]) {
    const float radius = part->size[0], tooth = part->size[2], edge = part->size[3];
    const float teeth = part->also[0], sharp = part->also[1];
    const float r = sqrtf(q[0] * q[0] + q[1] * q[1]);
    const float wave = ffp_max(-1, ffp_min(1, sharp * cosf(teeth * atan2f(q[1], q[0]))));
    // the outline's steepest rise bounds how much the radial difference overstates the distance
    const float slope = tooth * teeth * sharp / ffp_max(r, 0.5F * radius);
    const float side = (r - radius - tooth * 0.5F * (1 + wave)) / sqrtf(1 + 0.25F * slope * slope);
    return slab2(side + edge, fabsf(q[2]) - part->size[1] + edge) - edge;
}

// The largest of the distances to the planes of the faces: right where one face is nearest, less elsewhere.
static float prism(const FfpPart *part, const float q[3]) {
    const float low = part->size[0], high = part->size[1], half = part->size[2];
    const float sector = 6.2831853F / part->also[0], angle = atan2f(q[1], q[0]);
    const float fold =
        angle - sector * (floorf(angle / sector) + 0.5F); // from the middle of the nearest face
    const float across = sqrtf(q[0] * q[0] + q[1] * q[1]) * cosf(fold);
    const float lean = 0.5F * (high - low) / half, middle = cosf(0.5F * sector);
    const float apothem = middle * (0.5F * (low + high) + lean * q[2]);
    const float side = (across - apothem) / sqrtf(1 + lean * lean * middle * middle);
    return ffp_max(side, fabsf(q[2]) - half);
}

static float superquadric(const FfpPart *part, const float q[3]) {
    const float ez = part->also[0], exy = part->also[1];
    const float x = fabsf(q[0] / part->size[0]), y = fabsf(q[1] / part->size[1]),
                z = fabsf(q[2] / part->size[2]);
    const float flat = powf(powf(x, 2 / exy) + powf(y, 2 / exy), exy / ez);
    const float f = powf(flat + powf(z, 2 / ez), 0.5F * ez); // homogeneous of degree 1: 1 on the surface
    const float r = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
    const float least = ffp_min(part->size[0], ffp_min(part->size[1], part->size[2]));
    return f < 1e-4F ? -least : 0.6F * (r - r / f);
}

static float land(const FfpShape *shape, const FfpPart *part, const float q[3]) {
    const float sides[4] = {part->size[0], part->size[1], part->size[2] + part->size[3], 0.02F};
    const float hull = box(q, sides);
    const float flat[3] = {1.6F * q[0], 1.6F * q[1], 0};
    const float h =
        shape->ridged ? 2 * ffp_ridges(flat, shape->noise_seed, 4) - 1 : ffp_fbm(flat, shape->noise_seed, 4);
    const float top = 0.5F * (q[2] - part->size[2] * 0.2F - part->size[3] * ffp_max(-1, ffp_min(1, h)));
    return ffp_max(hull, top);
}

float ffp_part_distance(const FfpShape *shape, const FfpPart *part, const float p[3]) {
    const float d[3] = {p[0] - part->centre[0], p[1] - part->centre[1], p[2] - part->centre[2]};
    float q[3];
    for (int i = 0; i < 3; i++)
        q[i] = part->axes[3 * i] * d[0] + part->axes[3 * i + 1] * d[1] + part->axes[3 * i + 2] * d[2];
    const float r = sqrtf(q[0] * q[0] + q[1] * q[1]);
    switch (part->kind) {
    case FFP_PART_ELLIPSOID:
        return ellipsoid(q, part->size);
    case FFP_PART_CONE:
        return cone(q, part->size);
    case FFP_PART_BOX:
        return box(q, part->size);
    case FFP_PART_CYLINDER:
        return slab2(r - part->size[0] + part->size[2], fabsf(q[2]) - part->size[1] + part->size[2]) -
               part->size[2];
    case FFP_PART_TORUS:
        return sqrtf((r - part->size[0]) * (r - part->size[0]) + q[2] * q[2]) - part->size[1];
    case FFP_PART_LATHE:
        return lathe(shape, q, part->size[0]);
    case FFP_PART_COG:
        return cog(part, q);
    case FFP_PART_PRISM:
        return prism(part, q);
    case FFP_PART_SUPERQUADRIC:
        return superquadric(part, q);
    case FFP_PART_LAND:
        return land(shape, part, q);
    }
    return 1e3F;
}

// max for sign -1, min for +1, rounded where the two are within k of each other.
static float smooth_min(float a, float b, float k) {
    const float h = k > 0 ? ffp_max(k - fabsf(a - b), 0) : 0;
    return ffp_min(a, b) - (k > 0 ? h * h / (4 * k) : 0);
}

static float displacement(const FfpShape *shape, const float p[3]) {
    float d = 0;
    if (shape->bump > 0) {
        const float f = shape->bump_frequency, q[3] = {f * p[0], f * p[1], f * p[2]};
        d += shape->bump * (shape->ridged ? 2 * ffp_ridges(q, shape->noise_seed, 3) - 1.2F
                                          : ffp_fbm(q, shape->noise_seed, 4));
    }
    if (shape->rib_depth > 0) d -= shape->rib_depth * (0.5F - 0.5F * cosf(shape->ribs * atan2f(p[1], p[0])));
    return d;
}

float ffp_shape_distance(const FfpShape *shape, const uint8_t *list, int count, const float p[3]) {
    float q[3] = {p[0], p[1], p[2]}, d = 1e3F;
    if (shape->twist != 0) {
        const float c = cosf(shape->twist * p[2]), s = sinf(shape->twist * p[2]);
        q[0] = c * p[0] - s * p[1], q[1] = s * p[0] + c * p[1];
    }
    for (int i = 0; i < count; i++) {
        const FfpPart *part = &shape->parts[list[i]];
        const float e = ffp_part_distance(shape, part, q);
        if (part->join == FFP_CSG_UNION)
            d = smooth_min(d, e, part->blend);
        else if (part->join == FFP_CSG_DIFFERENCE)
            d = -smooth_min(-d, e, part->blend);
        else
            d = -smooth_min(-d, -e, part->blend);
    }
    const float reach = 1.5F * (shape->bump + shape->rib_depth);
    return fabsf(d) < 2 * reach ? d - displacement(shape, p) : d; // far away the sign is settled
}

void ffp_shape_bounds(const FfpShape *shape, float low[3], float high[3]) {
    for (int a = 0; a < 3; a++) low[a] = 1e9F, high[a] = -1e9F;
    float margin = 1.5F * shape->bump;
    for (int i = 0; i < shape->n_parts; i++) {
        const FfpPart *part = &shape->parts[i];
        if (part->join != FFP_CSG_UNION) continue;
        margin = ffp_max(margin, 1.5F * shape->bump + 0.25F * part->blend);
        for (int a = 0; a < 3; a++) {
            float middle = part->centre[a], reach = 0;
            for (int k = 0; k < 3; k++) {
                middle += part->axes[3 * k + a] * part->middle[k];
                reach += fabsf(part->axes[3 * k + a]) * part->reach[k];
            }
            low[a] = ffp_min(low[a], middle - reach), high[a] = ffp_max(high[a], middle + reach);
        }
    }
    if (shape->twist != 0) { // a turning section sweeps a disc
        const float r = hypotf(ffp_max(-low[0], high[0]), ffp_max(-low[1], high[1]));
        for (int a = 0; a < 2; a++) low[a] = -r, high[a] = r;
    }
    for (int a = 0; a < 3; a++) low[a] -= margin, high[a] += margin;
}
