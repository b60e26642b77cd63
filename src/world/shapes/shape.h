// A solid as a list of parts joined by smooth set operations: the implicit surface that every mesh is made
// from. Distances are bounds in the sense of Hart 1996 (sphere tracing): never larger than lipschitz times
// the true one.
#ifndef FFP_SHAPES_SHAPE_H
#define FFP_SHAPES_SHAPE_H

#include <stdbool.h>
#include <stdint.h>
#include "core/base/rng.h"

#define FFP_PARTS_MAX 224
#define FFP_OUTLINE_MAX 80

typedef struct FfpV3 {
    float x, y, z;
} FfpV3;
static inline FfpV3 ffp_v3(float x, float y, float z) {
    return (FfpV3){x, y, z};
}

// Random numbers for the families. Draws never stand side by side in one argument list: C leaves their order
// open, and the meshes must not depend on the compiler.
static inline float ffp_draw(FfpRng *rng, float low, float high) {
    return ffp_rng_range(rng, low, high);
}
static inline int ffp_pick(FfpRng *rng, int low, int high) {
    return low + (int)ffp_rng_below(rng, (uint32_t)(high - low + 1));
}
static inline FfpV3 ffp_draw3(FfpRng *rng, FfpV3 low, FfpV3 high) {
    const float x = ffp_draw(rng, low.x, high.x), y = ffp_draw(rng, low.y, high.y);
    return ffp_v3(x, y, ffp_draw(rng, low.z, high.z));
}

typedef enum FfpPartKind {
    FFP_PART_ELLIPSOID, // size: half axes
    FFP_PART_CONE,     // rounded cone from the centre along +z; size: radius there, radius at the end, length
    FFP_PART_BOX,      // size: half sides, corner radius
    FFP_PART_CYLINDER, // along z; size: radius, half height, edge radius
    FFP_PART_TORUS,    // around z; size: ring radius, tube radius
    FFP_PART_LATHE,    // the shape's outline (radius, z) turned around z; size: rounding
    FFP_PART_COG, // along z; size: radius, half height, tooth height, edge radius; also teeth and sharpness
    FFP_PART_SUPERQUADRIC, // size: half axes; also two exponents
    FFP_PART_PRISM, // along z, regular polygon; size: its circle's radius below, above, half height; also
                    // sides
    FFP_PART_LAND,  // box whose top is a height field; size: half sides, height of the hills
} FfpPartKind;

typedef enum FfpCsgOperation {
    FFP_CSG_UNION,
    FFP_CSG_DIFFERENCE,
    FFP_CSG_INTERSECTION
} FfpCsgOperation; // union, difference, intersection

typedef struct FfpPart {
    FfpPartKind kind;
    FfpCsgOperation join;
    float blend;              // width of the smooth transition
    float centre[3], axes[9]; // rows of axes: the part's own x, y, z in the shape's frame
    float size[4], also[2];
    float reach[3]; // half extents in its own axes, around `middle` in its own frame
    float middle[3];
} FfpPart;

typedef struct FfpShape {
    int n_parts;
    FfpPart parts[FFP_PARTS_MAX];
    int n_outline; // closed polygon (radius, z) for FFP_PART_LATHE
    float outline[FFP_OUTLINE_MAX][2];
    // by ffp_add_lathe, from the point before: radius and z difference, 1 / length^2, and the rise of the
    // smooth curve over the edge at its two ends, times length
    float edge[FFP_OUTLINE_MAX][5];
    uint32_t noise_seed;
    float bump, bump_frequency; // displacement along the normal: height, features a unit length
    bool ridged;
    float ribs, rib_depth; // waves around z: how many, how deep
    float twist;           // radians a unit of z
    float lipschitz;       // >= 1; how much faster than the distance the function may grow
    bool upright;          // keep z up: only turned around z when placed
} FfpShape;

// Starts empty, lipschitz 1.5, upright.
void ffp_shape_init(FfpShape *shape, uint32_t noise_seed);
FfpRng ffp_shape_rng(const FfpShape *shape); // a stream that depends on noise_seed alone
// Each adds one part as a union and returns it, so that join and orientation can be changed.
FfpPart *ffp_add_ellipsoid(FfpShape *shape, FfpV3 centre, FfpV3 half, float blend);
FfpPart *ffp_add_cone(FfpShape *shape, FfpV3 a, FfpV3 b, float radius_a, float radius_b, float blend);
FfpPart *ffp_add_box(FfpShape *shape, FfpV3 centre, FfpV3 half, float corner, float blend);
FfpPart *ffp_add_cylinder(FfpShape *shape, FfpV3 centre, float radius, float half, float edge, float blend);
FfpPart *ffp_add_torus(FfpShape *shape, FfpV3 centre, float ring, float tube, float blend);
FfpPart *ffp_add_lathe(FfpShape *shape, float rounding, float blend); // after the outline is set
FfpPart *ffp_add_cog(FfpShape *shape, FfpV3 centre, float radius, float half, float tooth, int teeth,
                     float sharpness);
// A prism of `sides` sides, a corner towards +x: a frustum where the radii differ, a pyramid where one is
// small.
FfpPart *ffp_add_prism(FfpShape *shape, FfpV3 centre, int sides, float radius_low, float radius_high,
                       float half, float blend);
FfpPart *ffp_add_superquadric(FfpShape *shape, FfpV3 centre, FfpV3 half, float exponent_z, float exponent_xy);
FfpPart *ffp_add_land(FfpShape *shape, FfpV3 half, float hills);
// A tube through n >= 2 points (x, y, z, radius) along a Catmull-Rom curve, six rounded cones a piece; the
// first joins with `blend`. `side` -1 mirrors y, then `yaw` (radians) turns it around z.
void ffp_add_tube(FfpShape *shape, const float (*point)[4], int n, float side, float yaw, float blend);
// Makes a part a cut; returns it.
FfpPart *ffp_cut(FfpPart *part);
// Points the part's z axis along `direction`, or turns it by yaw, pitch, roll (radians, around z, y, x).
void ffp_part_align(FfpPart *part, FfpV3 direction);
void ffp_part_rotate(FfpPart *part, float yaw, float pitch, float roll);

// Signed distance bound of one part alone, and of the parts whose numbers are in list[count] (ascending),
// displaced.
float ffp_part_distance(const FfpShape *shape, const FfpPart *part, const float p[3]);
float ffp_shape_distance(const FfpShape *shape, const uint8_t *list, int count, const float p[3]);
// Axis-aligned bounds that surely hold the surface.
void ffp_shape_bounds(const FfpShape *shape, float low[3], float high[3]);

// The families: ten kinds of object each, every one a shape of its own.
enum { FFP_FAMILIES = 15, FFP_KINDS = 10 };
typedef struct FfpFamily {
    struct {
        const char *name;
        void (*make)(FfpShape *shape); // fills an empty shape; what is random in it comes from ffp_shape_rng
    } kinds[FFP_KINDS];
} FfpFamily;
extern const FfpFamily ffp_family_stone, ffp_family_blob, ffp_family_fruit, ffp_family_land, ffp_family_shell,
    ffp_family_animal, ffp_family_figure, ffp_family_bust, ffp_family_vase, ffp_family_kitchen,
    ffp_family_furniture, ffp_family_machine, ffp_family_solid, ffp_family_stack, ffp_family_knot;

#endif
