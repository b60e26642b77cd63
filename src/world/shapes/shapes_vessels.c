// Vases, bottles and cups turned on a lathe, and what else stands in a kitchen or a cupboard.
#include <math.h>
#include "core/base/real.h"
#include "world/shapes/scalar.h"
#include "world/shapes/shape.h"

// A body turned around z: its outer wall is a Catmull-Rom curve through n <= 10 knots (radius, z) from the
// foot up. With a `wall` it is hollow and open above, so thick across; without, solid.
static void turned(FfpShape *shape, const float (*knot)[2], int n, float wall) {
    enum { STEPS = 5 };
    float p[STEPS * 9 + 1][2];
    const int last = STEPS * (n - 1);
    for (int i = 0; i <= last; i++) {
        const int k = i < last ? i / STEPS : n - 2;
        const float t = (float)(i - STEPS * k) / STEPS;
        for (int c = 0; c < 2; c++) {
            const float a = knot[k > 0 ? k - 1 : 0][c], b = knot[k][c], d = knot[k + 1][c],
                        e = knot[k + 2 < n ? k + 2 : n - 1][c];
            p[i][c] = b + 0.5F * t * (d - a + t * (2 * a - 5 * b + 4 * d - e + t * (3 * (b - d) + e - a)));
        }
    }
    int count = 0;
    shape->outline[count][0] = 0, shape->outline[count++][1] = p[0][1];
    for (int i = 0; i <= last; i++)
        shape->outline[count][0] = ffp_max(p[i][0], 0.005F), shape->outline[count++][1] = p[i][1];
    for (int i = last; wall > 0 && i >= 1; i -= 2) {
        const float *a = p[i - 1], *b = p[i < last ? i + 1 : last];
        const float r = b[0] - a[0], z = b[1] - a[1], scale = wall / sqrtf(r * r + z * z);
        const float inner = p[i][0] - scale * z, height = p[i][1] + scale * r;
        if (inner < 0.02F || height < p[0][1] + 1.5F * wall) continue;
        shape->outline[count][0] = inner, shape->outline[count++][1] = height;
    }
    shape->outline[count][0] = 0, shape->outline[count][1] = shape->outline[count - 1][1];
    shape->n_outline = count + 1;
    ffp_add_lathe(shape, 0.012F, 0);
}

static void amphora(FfpShape *shape) {
    static const float wall[9][2] = {{0.16F, -1},     {0.2F, -0.9F},  {0.4F, -0.5F},
                                     {0.55F, -0.05F}, {0.5F, 0.3F},   {0.24F, 0.52F},
                                     {0.19F, 0.75F},  {0.22F, 0.92F}, {0.28F, 0.98F}};
    static const float handle[5][4] = {{0.5F, 0, 0.28F, 0.06F},
                                       {0.66F, 0, 0.45F, 0.06F},
                                       {0.6F, 0, 0.75F, 0.055F},
                                       {0.42F, 0, 0.84F, 0.055F},
                                       {0.2F, 0, 0.8F, 0.05F}};
    turned(shape, wall, 9, 0.075F);
    for (int i = 0; i < 2; i++) ffp_add_tube(shape, handle, 5, 1, FFP_PI * (float)i, 0.04F);
}

static void bottle(FfpShape *shape) {
    static const float wall[9][2] = {{0.36F, -1},   {0.4F, -0.96F}, {0.4F, -0.5F},
                                     {0.4F, 0.05F}, {0.33F, 0.3F},  {0.14F, 0.45F},
                                     {0.13F, 0.9F}, {0.17F, 0.93F}, {0.17F, 1}};
    turned(shape, wall, 9, 0);
    ffp_cut(ffp_add_cylinder(shape, ffp_v3(0, 0, 1), 0.08F, 0.12F, 0.01F, 0));
}

static void fluted_vase(FfpShape *shape) {
    static const float wall[7][2] = {{0.42F, -0.9F}, {0.38F, -0.8F}, {0.3F, -0.6F}, {0.42F, -0.1F},
                                     {0.62F, 0.4F},  {0.66F, 0.7F},  {0.8F, 0.85F}};
    turned(shape, wall, 7, 0.12F);
    shape->ribs = 14, shape->rib_depth = 0.03F;
}

static void twisted_vase(FfpShape *shape) {
    static const float wall[6][2] = {{0.45F, -1},   {0.6F, -0.6F}, {0.62F, -0.1F},
                                     {0.36F, 0.4F}, {0.3F, 0.7F},  {0.42F, 1}};
    turned(shape, wall, 6, 0);
    for (int i = 0; i < 5; i++) {
        const float a = 0.4F * FFP_PI * (float)i;
        ffp_add_cone(shape, ffp_v3(0.5F * cosf(a), 0.5F * sinf(a), -0.95F),
                     ffp_v3(0.42F * cosf(a), 0.42F * sinf(a), 0.95F), 0.16F, 0.1F, 0.1F);
    }
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0, 0, 1), ffp_v3(0.26F, 0.26F, 0.7F), 0.02F));
    shape->twist = 1.6F;
    shape->lipschitz = 1.8F;
}

static void bowl(FfpShape *shape) {
    static const float wall[7][2] = {{0.42F, -0.45F}, {0.42F, -0.32F}, {0.48F, -0.28F}, {0.8F, -0.1F},
                                     {0.97F, 0.2F},   {1, 0.32F},      {1.02F, 0.36F}};
    turned(shape, wall, 7, 0.075F);
    for (int i = 0; i < 3; i++) { // what lies in it
        const float a = 2.1F * (float)i;
        ffp_add_ellipsoid(shape, ffp_v3(0.28F * cosf(a), 0.28F * sinf(a), 0), ffp_v3(0.26F, 0.26F, 0.24F),
                          0.01F);
    }
}

static void goblet(FfpShape *shape) {
    static const float wall[10][2] = {{0.46F, -1},     {0.44F, -0.92F},  {0.12F, -0.82F}, {0.085F, -0.5F},
                                      {0.17F, -0.36F}, {0.085F, -0.22F}, {0.2F, -0.08F},  {0.5F, 0.2F},
                                      {0.52F, 0.6F},   {0.46F, 1}};
    turned(shape, wall, 10, 0);
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0.75F), ffp_v3(0.42F, 0.42F, 0.65F), 0.02F));
}

// A gourd with four windows besides its mouth: genus 4.
static void lantern(FfpShape *shape) {
    static const float wall[8][2] = {{0.3F, -0.8F}, {0.5F, -0.66F}, {0.66F, -0.25F}, {0.66F, 0.1F},
                                     {0.5F, 0.42F}, {0.26F, 0.58F}, {0.25F, 0.72F},  {0.34F, 0.8F}};
    turned(shape, wall, 8, 0.1F);
    for (int i = 0; i < 4; i++) {
        const float a = 0.5F * FFP_PI * (float)i;
        FfpPart *window = ffp_add_ellipsoid(shape, ffp_v3(0.6F * cosf(a), 0.6F * sinf(a), -0.08F),
                                            ffp_v3(0.4F, 0.26F, 0.36F), 0.02F);
        ffp_part_rotate(window, a, 0, 0);
        ffp_cut(window);
    }
    ffp_add_cylinder(shape, ffp_v3(0, 0, -0.5F), 0.14F, 0.25F, 0.02F, 0.02F); // a candle
}

static void carafe(FfpShape *shape) {
    static const float wall[8][2] = {{0.6F, -0.8F}, {0.7F, -0.68F}, {0.66F, -0.4F}, {0.3F, -0.08F},
                                     {0.16F, 0.2F}, {0.15F, 0.6F},  {0.22F, 0.85F}, {0.32F, 0.92F}};
    static const float handle[5][4] = {{0.5F, 0, -0.25F, 0.06F},
                                       {0.75F, 0, -0.05F, 0.06F},
                                       {0.78F, 0, 0.4F, 0.055F},
                                       {0.55F, 0, 0.72F, 0.055F},
                                       {0.18F, 0, 0.7F, 0.05F}};
    turned(shape, wall, 8, 0.07F);
    ffp_add_tube(shape, handle, 5, 1, 0, 0.04F);
    ffp_cut(ffp_add_cylinder(shape, ffp_v3(-0.4F, 0, 0.98F), 0.12F, 0.1F, 0.02F, 0.05F));
}

static void candlestick(FfpShape *shape) {
    static const float wall[10][2] = {{0.42F, -1},     {0.4F, -0.88F}, {0.14F, -0.76F}, {0.24F, -0.58F},
                                      {0.09F, -0.42F}, {0.11F, 0.1F},  {0.22F, 0.26F},  {0.1F, 0.4F},
                                      {0.3F, 0.56F},   {0.3F, 0.62F}};
    static const float arm[5][4] = {{0.08F, 0, 0, 0.06F},
                                    {0.35F, 0, -0.12F, 0.055F},
                                    {0.62F, 0, 0, 0.05F},
                                    {0.64F, 0, 0.2F, 0.055F},
                                    {0.64F, 0, 0.36F, 0.06F}};
    turned(shape, wall, 10, 0);
    ffp_add_cylinder(shape, ffp_v3(0, 0, 0.82F), 0.09F, 0.24F, 0.01F, 0.01F);
    for (int i = 0; i < 2; i++) {
        const float s = i ? -1 : 1;
        ffp_add_tube(shape, arm, 5, 1, FFP_PI * (float)i, 0.03F);
        ffp_add_cylinder(shape, ffp_v3(0.64F * s, 0, 0.38F), 0.19F, 0.045F, 0.02F, 0.02F);
        ffp_add_cylinder(shape, ffp_v3(0.64F * s, 0, 0.58F), 0.075F, 0.2F, 0.01F, 0.01F);
    }
}

static void hand_bell(FfpShape *shape) {
    static const float wall[8][2] = {{0.82F, -0.8F}, {0.78F, -0.7F}, {0.6F, -0.5F},  {0.46F, -0.1F},
                                     {0.42F, 0.15F}, {0.3F, 0.3F},   {0.12F, 0.36F}, {0.005F, 0.37F}};
    turned(shape, wall, 8, 0);
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0, 0, -0.8F), ffp_v3(0.4F, 0.4F, 0.95F), 0.02F));
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0, 0, -0.85F), ffp_v3(0.7F, 0.7F, 0.4F), 0.1F));
    ffp_add_cone(shape, ffp_v3(0, 0, 0.2F), ffp_v3(0, 0, -0.7F), 0.05F, 0.05F, 0.02F);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, -0.72F), ffp_v3(0.15F, 0.15F, 0.16F), 0.02F);
    ffp_add_cone(shape, ffp_v3(0, 0, 0.35F), ffp_v3(0, 0, 1), 0.09F, 0.13F, 0.05F);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 1.08F), ffp_v3(0.17F, 0.17F, 0.14F), 0.04F);
}

const FfpFamily ffp_family_vase = {{{"amphora", amphora},
                                    {"bottle", bottle},
                                    {"fluted vase", fluted_vase},
                                    {"twisted vase", twisted_vase},
                                    {"bowl", bowl},
                                    {"goblet", goblet},
                                    {"lantern", lantern},
                                    {"carafe", carafe},
                                    {"candlestick", candlestick},
                                    {"hand bell", hand_bell}}};

static void teapot(FfpShape *shape) {
    static const float wall[8][2] = {{0.36F, -0.62F}, {0.42F, -0.58F}, {0.68F, -0.2F}, {0.7F, 0.1F},
                                     {0.52F, 0.42F},  {0.4F, 0.5F},    {0.3F, 0.56F},  {0.005F, 0.64F}};
    static const float spout[4][4] = {{0.5F, 0, -0.25F, 0.2F},
                                      {0.9F, 0, -0.05F, 0.13F},
                                      {1.02F, 0, 0.25F, 0.09F},
                                      {1.22F, 0, 0.45F, 0.08F}};
    static const float handle[5][4] = {{-0.55F, 0, 0.35F, 0.075F},
                                       {-0.9F, 0, 0.42F, 0.075F},
                                       {-1.12F, 0, 0.15F, 0.075F},
                                       {-0.95F, 0, -0.2F, 0.075F},
                                       {-0.6F, 0, -0.25F, 0.07F}};
    turned(shape, wall, 8, 0);
    ffp_add_tube(shape, spout, 4, 1, 0, 0.08F);
    ffp_add_tube(shape, handle, 5, 1, 0, 0.05F);
    ffp_add_torus(shape, ffp_v3(0, 0, 0.47F), 0.43F, 0.045F, 0.02F);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0.72F), ffp_v3(0.12F, 0.12F, 0.11F), 0.04F);
}

static void jug(FfpShape *shape) {
    static const float wall[7][2] = {{0.45F, -0.85F}, {0.52F, -0.75F}, {0.62F, -0.3F}, {0.5F, 0.2F},
                                     {0.36F, 0.5F},   {0.4F, 0.8F},    {0.46F, 0.88F}};
    static const float handle[5][4] = {{-0.55F, 0, -0.05F, 0.075F},
                                       {-0.95F, 0, 0.15F, 0.075F},
                                       {-1, 0, 0.6F, 0.075F},
                                       {-0.7F, 0, 0.82F, 0.075F},
                                       {-0.4F, 0, 0.72F, 0.07F}};
    turned(shape, wall, 7, 0.09F);
    ffp_add_tube(shape, handle, 5, 1, 0, 0.05F);
    ffp_add_cone(shape, ffp_v3(0.36F, 0, 0.72F), ffp_v3(0.66F, 0, 0.88F), 0.14F, 0.09F, 0.08F);
    ffp_add_cone(shape, ffp_v3(0.2F, 0, 0.92F), ffp_v3(0.7F, 0, 1), 0.14F, 0.1F, 0.03F)->join =
        FFP_CSG_DIFFERENCE;
}

static void mug(FfpShape *shape) {
    static const float wall[5][2] = {
        {0.5F, -0.6F}, {0.55F, -0.52F}, {0.55F, 0}, {0.55F, 0.5F}, {0.55F, 0.6F}};
    static const float handle[5][4] = {{0.54F, 0, 0.35F, 0.08F},
                                       {0.9F, 0, 0.36F, 0.085F},
                                       {1.02F, 0, 0, 0.085F},
                                       {0.88F, 0, -0.32F, 0.085F},
                                       {0.54F, 0, -0.34F, 0.08F}};
    turned(shape, wall, 5, 0.09F);
    ffp_add_tube(shape, handle, 5, 1, 0, 0.03F);
}

static void watering_can(FfpShape *shape) {
    static const float spout[4][4] = {
        {0.4F, 0, -0.35F, 0.11F}, {0.75F, 0, -0.05F, 0.085F}, {1, 0, 0.3F, 0.07F}, {1.2F, 0, 0.55F, 0.075F}};
    static const float handle[6][4] = {{0.2F, 0, 0.42F, 0.06F},  {0.1F, 0, 0.8F, 0.06F},
                                       {-0.4F, 0, 0.95F, 0.06F}, {-0.85F, 0, 0.6F, 0.06F},
                                       {-0.85F, 0, 0.1F, 0.06F}, {-0.45F, 0, -0.25F, 0.06F}};
    ffp_add_prism(shape, ffp_v3(0, 0, 0), 40, 0.56F, 0.46F, 0.55F, 0);
    ffp_cut(ffp_add_prism(shape, ffp_v3(0, 0, 0.15F), 40, 0.47F, 0.39F, 0.6F, 0));
    ffp_add_box(shape, ffp_v3(0.25F, 0, 0.5F), ffp_v3(0.2F, 0.36F, 0.05F), 0.02F, 0.02F);
    ffp_add_tube(shape, spout, 4, 1, 0, 0.04F);
    ffp_part_align(ffp_add_prism(shape, ffp_v3(1.24F, 0, 0.6F), 24, 0.08F, 0.2F, 0.1F, 0.02F),
                   ffp_v3(0.7F, 0, 0.72F));
    ffp_add_tube(shape, handle, 6, 1, 0, 0.03F);
}

static void saucepan(FfpShape *shape) {
    static const float handle[4][4] = {
        {0.6F, 0, 0.15F, 0.07F}, {0.9F, 0, 0.2F, 0.065F}, {1.3F, 0, 0.26F, 0.08F}, {1.6F, 0, 0.28F, 0.085F}};
    ffp_add_cylinder(shape, ffp_v3(0, 0, 0), 0.68F, 0.3F, 0.05F, 0);
    ffp_cut(ffp_add_cylinder(shape, ffp_v3(0, 0, 0.16F), 0.6F, 0.34F, 0.05F, 0));
    ffp_add_torus(shape, ffp_v3(0, 0, 0.3F), 0.66F, 0.045F, 0.01F);
    ffp_add_tube(shape, handle, 4, 1, 0, 0.04F);
    ffp_cut(ffp_add_cylinder(shape, ffp_v3(1.58F, 0, 0.28F), 0.04F, 0.3F, 0.005F, 0.01F));
}

static void bucket(FfpShape *shape) {
    static const float bail[6][4] = {{0, 0.62F, 0.45F, 0.05F},     {0.25F, 0.62F, 0.8F, 0.05F},
                                     {0.42F, 0.3F, 1.12F, 0.05F},  {0.42F, -0.3F, 1.12F, 0.05F},
                                     {0.25F, -0.62F, 0.8F, 0.05F}, {0, -0.62F, 0.45F, 0.05F}};
    ffp_add_prism(shape, ffp_v3(0, 0, -0.1F), 48, 0.46F, 0.66F, 0.6F, 0);
    ffp_cut(ffp_add_prism(shape, ffp_v3(0, 0, 0.02F), 48, 0.38F, 0.58F, 0.62F, 0));
    for (int i = 0; i < 3; i++)
        ffp_add_torus(shape, ffp_v3(0, 0, -0.5F + 0.45F * (float)i), 0.5F + 0.075F * (float)i, 0.045F, 0.01F);
    ffp_add_tube(shape, bail, 6, 1, 0, 0.02F);
    for (int side = -1; side <= 1; side += 2)
        ffp_add_ellipsoid(shape, ffp_v3(0, 0.64F * (float)side, 0.44F), ffp_v3(0.1F, 0.06F, 0.1F), 0.02F);
}

static void oil_lamp(FfpShape *shape) {
    static const float spout[4][4] = {
        {0.3F, 0, -0.05F, 0.24F}, {0.7F, 0, -0.05F, 0.16F}, {1, 0, 0.1F, 0.11F}, {1.25F, 0, 0.28F, 0.11F}};
    static const float handle[6][4] = {{-0.5F, 0, 0, 0.07F},      {-0.85F, 0, 0.2F, 0.065F},
                                       {-1.1F, 0, 0.1F, 0.06F},   {-1.05F, 0, -0.15F, 0.06F},
                                       {-0.8F, 0, -0.22F, 0.06F}, {-0.45F, 0, -0.12F, 0.06F}};
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.62F, 0.46F, 0.26F), 0);
    ffp_add_tube(shape, spout, 4, 1, 0, 0.12F);
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(1.3F, 0, 0.38F), ffp_v3(0.09F, 0.07F, 0.16F), 0.02F));
    ffp_add_tube(shape, handle, 6, 1, 0, 0.05F);
    ffp_add_prism(shape, ffp_v3(0, 0, -0.3F), 32, 0.36F, 0.16F, 0.1F, 0.05F);
    ffp_add_ellipsoid(shape, ffp_v3(-0.05F, 0, 0.24F), ffp_v3(0.24F, 0.24F, 0.12F), 0.03F);
    ffp_add_cone(shape, ffp_v3(-0.05F, 0, 0.3F), ffp_v3(-0.05F, 0, 0.5F), 0.06F, 0.08F, 0.04F);
}

static void boot(FfpShape *shape) {
    static const float leg[4][4] = {{-0.3F, 0, 0.95F, 0.34F},
                                    {-0.34F, 0, 0.4F, 0.3F},
                                    {-0.32F, 0, -0.1F, 0.27F},
                                    {-0.25F, 0, -0.42F, 0.28F}};
    ffp_add_tube(shape, leg, 4, 1, 0, 0);
    ffp_add_ellipsoid(shape, ffp_v3(0.2F, 0, -0.5F), ffp_v3(0.6F, 0.26F, 0.2F), 0.2F);
    ffp_add_ellipsoid(shape, ffp_v3(0.6F, 0, -0.48F), ffp_v3(0.28F, 0.26F, 0.2F), 0.08F);
    ffp_cut(ffp_add_cylinder(shape, ffp_v3(-0.3F, 0, 1.45F), 1, 0.5F, 0, 0.02F));
    ffp_cut(ffp_add_cone(shape, ffp_v3(-0.3F, 0, 1.2F), ffp_v3(-0.32F, 0, -0.1F), 0.26F, 0.19F, 0.02F));
    ffp_add_torus(shape, ffp_v3(-0.3F, 0, 0.92F), 0.31F, 0.06F, 0.02F);
    ffp_add_ellipsoid(shape, ffp_v3(0.25F, 0, -0.7F), ffp_v3(0.68F, 0.3F, 0.07F), 0.02F); // sole
    ffp_add_box(shape, ffp_v3(-0.33F, 0, -0.76F), ffp_v3(0.2F, 0.2F, 0.14F), 0.04F, 0.03F);
    for (int i = 0; i < 4; i++) { // laces
        const float z = 0.15F - 0.15F * (float)i, x = -0.06F + 0.016F * (float)(i * i);
        ffp_add_cone(shape, ffp_v3(x, 0.12F, z), ffp_v3(x + 0.02F, -0.12F, z + 0.03F), 0.045F, 0.045F, 0.01F);
    }
}

static void sun_hat(FfpShape *shape) {
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(0.5F, 0.44F, 0.56F), 0);
    ffp_cut(ffp_add_box(shape, ffp_v3(0, 0, -1), ffp_v3(2, 2, 1), 0, 0));
    ffp_add_superquadric(shape, ffp_v3(0, 0, 0.02F), ffp_v3(1.02F, 0.92F, 0.07F), 1.2F, 1)->blend = 0.06F;
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0, 0, -0.06F), ffp_v3(0.42F, 0.36F, 0.5F), 0.02F));
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0.1F, 0, 0.66F), ffp_v3(0.3F, 0.09F, 0.16F), 0.08F)); // the dent
    ffp_add_torus(shape, ffp_v3(0, 0, 0.12F), 0.46F, 0.06F, 0.01F);
    ffp_part_rotate(ffp_add_ellipsoid(shape, ffp_v3(-0.25F, 0.48F, 0.18F), ffp_v3(0.2F, 0.06F, 0.12F), 0.02F),
                    0.5F, 0.3F, 0);
    ffp_part_rotate(ffp_add_ellipsoid(shape, ffp_v3(0.05F, 0.5F, 0.18F), ffp_v3(0.2F, 0.06F, 0.12F), 0.02F),
                    -0.1F, -0.3F, 0);
    shape->upright = false;
}

static void trophy(FfpShape *shape) {
    static const float wall[10][2] = {{0.34F, -0.75F}, {0.3F, -0.66F}, {0.1F, -0.55F}, {0.09F, -0.35F},
                                      {0.2F, -0.25F},  {0.46F, 0},     {0.52F, 0.4F},  {0.5F, 0.8F},
                                      {0.58F, 0.92F},  {0.62F, 0.96F}};
    static const float handle[5][4] = {{0.45F, 0, 0, 0.06F},
                                       {0.78F, 0, 0.1F, 0.06F},
                                       {0.95F, 0, 0.5F, 0.06F},
                                       {0.8F, 0, 0.8F, 0.055F},
                                       {0.5F, 0, 0.7F, 0.055F}};
    turned(shape, wall, 10, 0);
    ffp_cut(ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0.85F), ffp_v3(0.42F, 0.42F, 0.85F), 0.02F));
    for (int i = 0; i < 2; i++) ffp_add_tube(shape, handle, 5, 1, FFP_PI * (float)i, 0.03F);
    ffp_add_box(shape, ffp_v3(0, 0, -0.9F), ffp_v3(0.4F, 0.4F, 0.16F), 0.02F, 0);
}

const FfpFamily ffp_family_kitchen = {{{"teapot", teapot},
                                       {"jug", jug},
                                       {"mug", mug},
                                       {"watering can", watering_can},
                                       {"saucepan", saucepan},
                                       {"bucket", bucket},
                                       {"oil lamp", oil_lamp},
                                       {"boot", boot},
                                       {"sun hat", sun_hat},
                                       {"trophy", trophy}}};
