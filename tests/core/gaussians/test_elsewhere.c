// Splats of other programs: every version and form reads back to known numbers, and damaged files are
// refused. The files are the fuzzers' seeds (tests/fuzz/make_seeds.py).
#include <math.h>
#include <stdio.h>
#include <unistd.h>
#include "core/base/base64.h"
#include "core/base/file.h"
#include "core/gaussians/elsewhere.h"
#include "support.h"

#define CORPUS FFP_SOURCE_DIR "/tests/fuzz/corpus/"
#define SH_C0 0.28209479

static double decode(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4);
}

static void assert_close(real found, double wanted, double tolerance) {
    if (!(fabs((double)found - wanted) <= tolerance)) fail_msg("%.6f, not %.6f", (double)found, wanted);
}

// The two splats of every seed; `dc` is the colour of theirs, `linear` how it is meant.
static void hold(const char *name, const double dc[3], bool linear, double coarse) {
    FfpGaussians g;
    FfpError err = {0};
    char path[FFP_PATH_MAX];
    snprintf(path, sizeof path, CORPUS "%s", name);
    if (!ffp_gaussians_read(&g, path, &err)) fail_msg("%s", err.text);
    assert_int_equal(g.count, 2);
    const double at[6] = {0.5, -1, 2, 0, 0, 0}, turn[4] = {sqrt(0.75), 0.5, 0, 0};
    for (int i = 0; i < 6; i++) assert_close(g.centre[i], at[i], 1e-3);
    for (int i = 0; i < 4; i++) assert_close(g.rotation[i], turn[i], coarse);
    for (int i = 0; i < 3; i++) {
        const double colour = 0.5 + SH_C0 * dc[i], light = linear ? colour : decode(colour);
        assert_close(g.ambient[i], light, 1e-3);
        assert_close(g.albedo[i], light, 1e-3);
        assert_close(g.scale[i], exp(i < 2 ? -4 : -5), 1e-4);
    }
    assert_close(g.opacity[0], 0.8, 1e-3);
    assert_close(g.opacity[1], 0.2, 1e-3);
    assert_close(g.roughness[1], 0.5, 0);
    ffp_gaussians_free(&g);
    char none[FFP_MADE_FROM];
    assert_true(ffp_gaussians_read_made_from(none, path, &err));
    assert_false(ffp_gaussians_are_relightable(path));
}

static void test_every_form(void **state) {
    (void)state;
    const double bytes[3] = {(166 / 255.0 - 0.5) / 0.15, (128 / 255.0 - 0.5) / 0.15,
                             (90 / 255.0 - 0.5) / 0.15},
                 floats[3] = {1, 0, -1};
    hold("spz/version1.spz", bytes, false, 0.01);
    hold("spz/version2.spz", bytes, false, 0.01);
    hold("spz/version3.spz", bytes, false, 2e-3);
    hold("gltf/splats.glb", floats, false, 1e-6);
    hold("gltf/splats.gltf", floats, false, 1e-6);
    hold("gltf/linear.glb", floats, true, 1e-6);
    hold("gltf/camera.glb", floats, false, 1e-6);
}

static void refused(const char *name, const char *why) {
    FfpGaussians g;
    FfpError err = {0};
    char path[FFP_PATH_MAX];
    snprintf(path, sizeof path, CORPUS "%s", name);
    assert_false(ffp_gaussians_read(&g, path, &err));
    if (!strstr(err.text, why) || !strstr(err.text, name)) fail_msg("\"%s\" without \"%s\"", err.text, why);
}

static void test_what_is_not_read_is_refused_by_name(void **state) {
    (void)state;
    refused("spz/version4.spz", "version 4: 1 to 3 are read");
    refused("spz/short.spz", "ends before its 2 Gaussians do");
    refused("spz/many.spz", "40000000 Gaussians do not fit");
    refused("gltf/moved.glb", "nodes[0] has a translation");
    refused("gltf/carried.glb", "nodes[1] has a translation");
    refused("gltf/twice.glb", "holds several sets of splats");
    refused("gltf/size.glb", "Gaussian 0: invalid scale_0");
    refused("gltf/none.glb", "holds no splats");
}

// Into a new file: ext4 writes one at once that replaces what it held, and ffp_write_file waits for the disk.
static void put(const char *path, const char *bytes, size_t size) {
    unlink(path);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

// A file cut anywhere, or with any byte changed, is read or refused, and nothing else.
static void damage(const char *name, const char *as) {
    char *bytes;
    size_t size;
    FfpError err = {0};
    char path[FFP_PATH_MAX];
    snprintf(path, sizeof path, CORPUS "%s", name);
    if (!ffp_read_file(path, 1 << 20, &bytes, &size, &err)) fail_msg("%s", err.text);
    for (size_t i = 0; i < 2 * size; i++) {
        FfpGaussians g;
        FfpError why = {0};
        const size_t at = i / 2;
        const char kept = bytes[at];
        if (i % 2) bytes[at] = (char)(kept ^ 0x5a);
        put(as, bytes, i % 2 ? size : at);
        bytes[at] = kept;
        const bool read = ffp_gaussians_read(&g, as, &why);
        if (read)
            ffp_gaussians_free(&g);
        else
            assert_non_null(strstr(why.text, as));
        // zlib checks all of a gzip file but its head's time, flags and system
        if (strstr(name, "spz") && (i % 2 == 0 || at >= 10) && read) fail_msg("byte %zu of %s", at, name);
    }
    ffp_free(bytes);
    unlink(as);
}

static void test_damaged(void **state) {
    (void)state;
    damage("spz/version3.spz", "test_elsewhere.spz");
    damage("gltf/splats.glb", "test_elsewhere.glb");
    damage("gltf/splats.gltf", "test_elsewhere.gltf");
}

static void test_base64(void **state) {
    (void)state;
    unsigned char out[12];
    assert_int_equal(ffp_read_base64(out, "aGVsbG8=", 8), 5);
    assert_memory_equal(out, "hello", 5);
    assert_int_equal(ffp_read_base64(out, "aGVsbG8", 7), 5);
    assert_int_equal(ffp_read_base64(out, "aGVs", 4), 3);
    assert_int_equal(ffp_read_base64(out, "", 0), 0);
    assert_int_equal(ffp_read_base64(out, "aGVsb", 5), -1);
    assert_int_equal(ffp_read_base64(out, "aG=s", 4), -1);
    assert_int_equal(ffp_read_base64(out, "aG s", 4), -1);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_every_form),
                                       cmocka_unit_test(test_what_is_not_read_is_refused_by_name),
                                       cmocka_unit_test(test_damaged), cmocka_unit_test(test_base64)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
