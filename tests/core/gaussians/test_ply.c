// The PLY file: what is written reads back, viewers see the right colour, and hostile files are refused.
#include <math.h>
#include <unistd.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/base/rng.h"
#include "core/gaussians/gaussians.h"
#include "support.h"

#define PATH "test_ply.ply"

static FfpGaussians random_gaussians(int64_t count) {
    FfpGaussians g = ffp_gaussians_new(count);
    FfpRng rng = ffp_rng(7, 1);
    for (int64_t i = 0; i < count; i++) {
        for (int c = 0; c < 3; c++) {
            g.centre[3 * i + c] = ffp_rng_range(&rng, -2, 2);
            g.scale[3 * i + c] = expf(ffp_rng_range(&rng, -9, 0));
            g.albedo[3 * i + c] = ffp_rng_uniform(&rng);
            g.ambient[3 * i + c] = ffp_rng_range(&rng, 0, 1.5F);
        }
        float length = 0;
        for (int c = 0; c < 4; c++) {
            g.rotation[4 * i + c] = ffp_rng_normal(&rng);
            length += g.rotation[4 * i + c] * g.rotation[4 * i + c];
        }
        for (int c = 0; c < 4; c++) g.rotation[4 * i + c] /= sqrtf(length);
        g.opacity[i] = ffp_rng_uniform(&rng);
        g.roughness[i] = ffp_rng_uniform(&rng);
    }
    return g;
}

static void assert_near(const real *a, const real *b, int64_t n, double tolerance) {
    for (int64_t i = 0; i < n; i++)
        if (!(fabs((double)a[i] - (double)b[i]) <= tolerance * (1 + fabs((double)b[i]))))
            fail_msg("value %lld: %.8g against %.8g", (long long)i, (double)a[i], (double)b[i]);
}

static void test_round_trip(void **state) {
    (void)state;
    FfpError err;
    FfpGaussians a = random_gaussians(2500), b;
    for (int c = 0; c < 3; c++) a.ambient[c] = 0, a.albedo[c] = 0, a.albedo[3 + c] = 1, a.ambient[3 + c] = 1;
    a.opacity[0] = 0, a.opacity[1] = 1, a.roughness[0] = 0, a.roughness[1] = 1;
    if (!ffp_gaussians_write(&a, PATH, 0, &err)) fail_msg("%s", err.text);
    if (!ffp_gaussians_read(&b, PATH, &err)) fail_msg("%s", err.text);
    assert_int_equal(b.count, a.count);
    assert_near(b.centre, a.centre, 3 * a.count, 0);
    assert_near(b.scale, a.scale, 3 * a.count, 2e-6);
    assert_near(b.rotation, a.rotation, 4 * a.count, 1e-6);
    assert_near(b.opacity, a.opacity, a.count, 2e-6);
    assert_near(b.albedo, a.albedo, 3 * a.count, 2e-6);
    assert_near(b.roughness, a.roughness, a.count, 2e-6);
    assert_near(b.ambient, a.ambient, 3 * a.count, 2e-6);
    ffp_gaussians_free(&a);
    ffp_gaussians_free(&b);
    unlink(PATH);
}

// Light that is scattered takes three more columns; without any, files are what they were.
static void test_scattered(void **state) {
    (void)state;
    FfpError err;
    FfpGaussians a = random_gaussians(40), b;
    assert_true(ffp_gaussians_write(&a, PATH, 0, &err) && ffp_gaussians_read(&b, PATH, &err));
    assert_false(b.scatters);
    ffp_gaussians_free(&b);
    for (int i = 0; i < 120; i++) a.scattered[i] = 0.001F * (float)i;
    a.scatters = true;
    assert_true(ffp_gaussians_write(&a, PATH, 0, &err) && ffp_gaussians_read(&b, PATH, &err));
    assert_true(b.scatters);
    assert_near(b.scattered, a.scattered, 120, 0);
    assert_near(b.ambient, a.ambient, 120, 2e-6);
    ffp_gaussians_free(&b);
    a.scattered[5] = -1; // a file of somebody else's
    assert_true(ffp_gaussians_write(&a, PATH, 0, &err) && ffp_gaussians_read(&b, PATH, &err));
    assert_true(b.scattered[5] == 0);
    ffp_gaussians_free(&b);
    a.scattered[5] = NAN;
    assert_false(ffp_gaussians_write(&a, PATH, 0, &err));
    assert_non_null(strstr(err.text, "scattered_2"));
    ffp_gaussians_free(&a);
    unlink(PATH);
}

static void test_opacity_min_and_empty(void **state) {
    (void)state;
    FfpError err;
    FfpGaussians a = random_gaussians(100), b;
    int64_t above = 0;
    for (int i = 0; i < 100; i++) above += a.opacity[i] >= 0.25F;
    assert_true(above > 0 && above < 100);
    assert_true(ffp_gaussians_write(&a, PATH, 0.25F, &err) && ffp_gaussians_read(&b, PATH, &err));
    assert_int_equal(b.count, above);
    ffp_gaussians_free(&b);
    assert_true(ffp_gaussians_write(&a, PATH, 2, &err) && ffp_gaussians_read(&b, PATH, &err));
    assert_int_equal(b.count, 0);
    ffp_gaussians_free(&a);
    ffp_gaussians_free(&b);
    unlink(PATH);
}

// A splat viewer shows 0.5 + SH_C0 * f_dc as the encoded colour: linear 0.2140 is mid grey.
static void test_viewer_colour(void **state) {
    (void)state;
    FfpError err;
    FfpGaussians a = random_gaussians(1);
    a.ambient[0] = 0.21404114F, a.ambient[1] = 0, a.ambient[2] = 1;
    assert_true(ffp_gaussians_write(&a, PATH, 0, &err));
    char *data;
    size_t size;
    assert_true(ffp_read_file(PATH, 1 << 20, &data, &size, &err));
    const char *row = strstr(data, "end_header\n") + 11;
    assert_int_equal(data + size - row, 18 * 4);
    float dc[3];
    memcpy(dc, row + 12, sizeof dc);
    const float shown[3] = {0.5F, 0, 1};
    for (int c = 0; c < 3; c++) assert_true(fabsf(0.5F + 0.28209479F * dc[c] - shown[c]) < 1e-5F);
    ffp_free(data);
    ffp_gaussians_free(&a);
    unlink(PATH);
}

static void test_transform(void **state) {
    (void)state;
    FfpGaussians a = ffp_gaussians_new(1);
    const real offset[3] = {1, -2, 3};
    for (int c = 0; c < 3; c++) a.centre[c] = 0.5F, a.scale[c] = 0.25F;
    ffp_gaussians_transform(&a, offset, 4);
    for (int c = 0; c < 3; c++) {
        assert_true(a.centre[c] == 2 + offset[c]);
        assert_true(a.scale[c] == 1);
    }
    ffp_gaussians_free(&a);
}

static void test_refuses_to_write_nonsense(void **state) {
    (void)state;
    FfpError err;
    FfpGaussians a = random_gaussians(3);
    a.ambient[4] = NAN;
    assert_false(ffp_gaussians_write(&a, PATH, 0, &err));
    assert_non_null(strstr(err.text, "f_dc_1"));
    assert_false(ffp_is_file(PATH));
    ffp_gaussians_free(&a);
}

// A file of ours with one piece of text replaced and the end cut or lengthened.
static void expect_refused(const char *from, const char *to, int extra_bytes, const char *word) {
    FfpError err;
    FfpGaussians a = random_gaussians(5), b;
    assert_true(ffp_gaussians_write(&a, PATH, 0, &err));
    ffp_gaussians_free(&a);
    char *data;
    size_t size;
    assert_true(ffp_read_file(PATH, 1 << 20, &data, &size, &err));
    char *at = strstr(data, from);
    assert_non_null(at);
    FILE *file = fopen(PATH, "wb");
    assert_non_null(file);
    fwrite(data, 1, (size_t)(at - data), file);
    fputs(to, file);
    const char *rest = at + strlen(from);
    const size_t left = size - (size_t)(rest - data);
    fwrite(rest, 1, extra_bytes < 0 ? left - (size_t)-extra_bytes : left, file);
    for (int i = 0; i < extra_bytes; i++) fputc(0, file);
    fclose(file);
    if (ffp_gaussians_read(&b, PATH, &err)) fail_msg("\"%s\" for \"%s\" was accepted", to, from);
    assert_null(b.centre);
    if (!strstr(err.text, word)) fail_msg("no \"%s\" in: %s", word, err.text);
    if (!strstr(err.text, PATH)) fail_msg("no file in: %s", err.text);
    ffp_free(data);
    unlink(PATH);
}

static void test_hostile(void **state) {
    (void)state;
    expect_refused("ply\n", "plx\n", 0, "not a capture, a model, Gaussians (PLY");
    expect_refused("binary_little", "binary_middle", 0, "binary_little_endian or");
    expect_refused("vertex 5", "vertex 6", 0, "bytes");
    expect_refused("vertex 5", "vertex 49999999", 0, "bytes");
    expect_refused("vertex 5", "vertex 50000001", 0, "count");
    expect_refused("vertex 5", "vertex 99999999999999999999", 0, "count");
    expect_refused("vertex 5", "vertex -5", 0, "count");
    expect_refused("vertex 5", "vertex 5x", 0, "count");
    expect_refused("element vertex", "element chunk", 0, "no element vertex");
    expect_refused("vertex 5\n", "vertex 5\nelement vertex 5\n", 0, "element vertex twice");
    expect_refused("element vertex", "element none 3\nelement vertex", 0, "element none has no property");
    expect_refused("float opacity", "float opacities", 0, "opacity");
    expect_refused("float opacity", "float x", 0, "duplicate");
    expect_refused("float opacity", "float128 opacity", 0, "type");
    expect_refused("float opacity", "list uchar int opacity", 0, "a single number");
    expect_refused("float opacity", "list float int opacity", 0, "a whole number");
    expect_refused("float base_color_0", "float basecolor", 0, "base_color_0");
    expect_refused("end_header", "end_headex", 0, "end_headex");
    expect_refused("element vertex 5\n", "", 0, "property");
    expect_refused("comment", "nonsense", 0, "nonsense");
    expect_refused("x\n", "x\n", -1, "bytes");
    expect_refused("property float y", "property double y", 0, "bytes");
}

static void test_hostile_numbers(void **state) {
    (void)state;
    static const struct {
        int number;
        float value;
        const char *name;
    } cases[] = {{0, NAN, "x"},        {6, NAN, "opacity"},
                 {8, 1e6F, "scale_1"}, {9, INFINITY, "scale_2"},
                 {5, 1e30F, "f_dc_2"}, {17, -INFINITY, "roughness"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        FfpError err;
        FfpGaussians a = random_gaussians(3), b;
        assert_true(ffp_gaussians_write(&a, PATH, 0, &err));
        FILE *file = fopen(PATH, "r+b");
        fseek(file, -(long)(18 * 4) + 4 * cases[i].number, SEEK_END);
        fwrite(&cases[i].value, 4, 1, file);
        fclose(file);
        assert_false(ffp_gaussians_read(&b, PATH, &err));
        assert_non_null(strstr(err.text, cases[i].name));
        assert_non_null(strstr(err.text, "Gaussian 2"));
        ffp_gaussians_free(&a);
    }
    FfpError err;
    FfpGaussians b;
    assert_false(ffp_gaussians_read(&b, "no such file.ply", &err));
    assert_false(ffp_gaussians_read(&b, "/", &err));
    unlink(PATH);
}

static void change(int64_t row, int number, float value, int64_t rows) {
    FILE *file = fopen(PATH, "r+b");
    assert_non_null(file);
    fseek(file, -4 * (long)(18 * (rows - row) - number), SEEK_END);
    fwrite(&value, 4, 1, file);
    fclose(file);
}

// Infinite logits are 0 and 1, a scale of 0 is a disc; up to a tenth of the rows may be unusable, and the
// others keep their order.
static void test_bad_rows(void **state) {
    (void)state;
    FfpError err;
    FfpGaussians a = random_gaussians(20), b;
    assert_true(ffp_gaussians_write(&a, PATH, 0, &err));
    change(0, 6, INFINITY, 20);
    change(1, 6, -INFINITY, 20);
    change(2, 8, -INFINITY, 20);
    change(3, 0, NAN, 20);
    for (int k = 10; k < 14; k++) change(19, k, 0, 20);
    if (!ffp_gaussians_read(&b, PATH, &err)) fail_msg("%s", err.text);
    assert_int_equal(b.count, 18);
    assert_true(b.opacity[0] == 1 && b.opacity[1] == 0);
    const real least = a.scale[6] < a.scale[8] ? a.scale[6] : a.scale[8];
    assert_near(&b.scale[7], &(real){least / 100}, 1, 1e-5);
    assert_near(b.centre + 9, a.centre + 12, 45, 0);
    ffp_gaussians_free(&b);
    change(4, 3, INFINITY, 20);
    assert_false(ffp_gaussians_read(&b, PATH, &err));
    assert_non_null(strstr(err.text, "Gaussian 3: invalid x (3 of 20 cannot be used)"));
    ffp_gaussians_free(&a);
    unlink(PATH);
}

// Files of other programs: properties in another order, doubles, and properties that mean nothing to us.
static void test_foreign_layout(void **state) {
    (void)state;
    static const char *names[] = {
        "roughness", "rot_3",   "rot_2",        "rot_1",        "rot_0",       "x",       "y",
        "z",         "nx",      "f_dc_0",       "f_dc_1",       "f_dc_2",      "opacity", "scale_2",
        "scale_1",   "scale_0", "base_color_2", "base_color_1", "base_color_0"};
    FILE *file = fopen(PATH, "wb");
    fputs("ply\r\nformat binary_little_endian 1.0\nobj_info here\nelement vertex 1\n", file);
    for (int i = 0; i < 19; i++) fprintf(file, "property double %s\n", names[i]);
    fputs("property uchar flag\nend_header\n", file);
    for (int i = 0; i < 19; i++) {
        const double value = i == 5 ? 0.75 : i == 4 ? 2 : 0; // x, and a rotation that is not normalised
        fwrite(&value, 8, 1, file);
    }
    fputc(7, file);
    fclose(file);
    FfpError err;
    FfpGaussians b;
    if (!ffp_gaussians_read(&b, PATH, &err)) fail_msg("%s", err.text);
    assert_true(b.centre[0] == 0.75F && b.rotation[0] == 1 && b.scale[1] == 1 && b.opacity[0] == 0.5F);
    ffp_gaussians_free(&b);
    unlink(PATH);
}

static void write_with_comment(const char *comment) {
    FILE *file = fopen(PATH, "wb");
    fprintf(file, "ply\nformat binary_little_endian 1.0\n%s\nelement vertex 0\n", comment);
    static const char *const names[] = {"x",     "y",     "z",     "opacity", "scale_0", "scale_1", "scale_2",
                                        "rot_0", "rot_1", "rot_2", "rot_3",   "f_dc_0",  "f_dc_1",  "f_dc_2"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) fprintf(file, "property float %s\n", names[i]);
    fputs("end_header\n", file);
    fclose(file);
}

static void test_baked_shadows(void **state) {
    (void)state;
    FfpError err;
    const real offset[3] = {1, 2, 3}, pose[16] = {1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 0, 1};
    FfpGaussians a = random_gaussians(3), b;
    assert_false(ffp_shadows_are_baked(&a, pose));
    a.baked = (FfpBakedShadows){{0, -0.5F, -1}, 0.01F};
    ffp_gaussians_transform(&a, offset, 2);
    assert_true(a.baked.light[0] == 1 && a.baked.light[1] == 1 && a.baked.light[2] == 1);
    if (!ffp_gaussians_write(&a, PATH, 0, &err) || !ffp_gaussians_read(&b, PATH, &err))
        fail_msg("%s", err.text);
    assert_memory_equal(&a.baked, &b.baked, sizeof a.baked);
    assert_true(ffp_shadows_are_baked(&b, pose));
    b.baked.light[1] += 0.03F;
    assert_false(ffp_shadows_are_baked(&b, pose));
    ffp_gaussians_free(&a);
    ffp_gaussians_free(&b);
    static const char *const bad[] = {"1 2 3",
                                      "1 2 3 within 0",
                                      "1 2 3 within -1",
                                      "1 2 nan within 1",
                                      "1 2 3 within 1 m",
                                      "inf 2 3 within 1",
                                      "1 2 3 within 1e39"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char comment[96];
        snprintf(comment, sizeof comment, "comment shadows baked from %s", bad[i]);
        write_with_comment(comment);
        assert_false(ffp_gaussians_read(&b, PATH, &err));
        assert_non_null(strstr(err.text, "shadows baked"));
    }
    unlink(PATH);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_round_trip),
                                       cmocka_unit_test(test_scattered),
                                       cmocka_unit_test(test_opacity_min_and_empty),
                                       cmocka_unit_test(test_viewer_colour),
                                       cmocka_unit_test(test_transform),
                                       cmocka_unit_test(test_hostile),
                                       cmocka_unit_test(test_refuses_to_write_nonsense),
                                       cmocka_unit_test(test_hostile_numbers),
                                       cmocka_unit_test(test_foreign_layout),
                                       cmocka_unit_test(test_baked_shadows),
                                       cmocka_unit_test(test_bad_rows)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
