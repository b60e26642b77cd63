// Splats of other programs: every version and form reads back to known numbers, and damaged files are
// refused. The files are the fuzzers' seeds (tests/fuzz/make_seeds.py).
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
#include "core/base/base64.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/base/kind.h"
#include "core/gaussians/elsewhere.h"
#include "scratch.h"
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
    hold("gltf/hidden.glb", floats, false, 1e-6); // another scene has them once more
    hold("spz/plain.spz", bytes, false, 2e-3);
    hold("gltf/packed.glb", bytes, false, 2e-3);
    hold("spz/streams.spz", bytes, false, 2e-3);
    hold("gltf/camera.glb", floats, false, 1e-6);
    hold("gltf/beside.gltf", floats, false, 1e-6);
    hold("gltf/kernel.glb", floats, false, 1e-6);
    static const char *const plys[] = {"ascii", "loose", "big", "elements", "harmonics", "no_harmonics"};
    for (size_t i = 0; i < sizeof plys / sizeof *plys; i++) {
        char name[64];
        snprintf(name, sizeof name, "ply/%s.ply", plys[i]);
        hold(name, floats, false, 1e-6);
    }
    const double levels[3] = {(199 / 255.0 - 0.5) / SH_C0, (128 / 255.0 - 0.5) / SH_C0,
                              (56 / 255.0 - 0.5) / SH_C0};
    hold("ply/coloured.ply", levels, false, 1e-6);
    hold("ply/compressed.ply", levels, false, 1e-3);
    hold("splat/two.splat", levels, false, 5e-3);
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
    refused("spz/version4.spz", "version 4, gzipped: 1 to 4 are read");
    refused("spz/streams_short.spz", "its stream 4 does not hold 2 Gaussians");
    refused("spz/streams_many.spz", "40000000 Gaussians do not fit");
    refused("ply/ascii_short.ply", "element vertex, property rot_2: the file ends");
    refused("ply/ascii_word.ply", "element vertex, property scale_0: cannot understand");
    refused("ply/points.ply", "is a point cloud, not Gaussians");
    refused("ply/mesh.ply", "is a mesh, not Gaussians");
    refused("ply/no_chunk.ply", "element chunk: 0 before 2 vertices");
    refused("spz/short.spz", "ends before its 2 Gaussians do");
    refused("spz/many.spz", "40000000 Gaussians do not fit");
    refused("gltf/packed_nowhere.glb", "spz_2: its bufferView is not inside a buffer");
    refused("gltf/packed_else.glb", "compressed (EXT_other_compression)");
    refused("gltf/above.gltf", "is not a file beside it");
    refused("gltf/negative.glb", "Gaussian 0: invalid scale_0");
    refused("gltf/size.glb", "Gaussian 0: invalid scale_0");
    refused("gltf/none.glb", "holds no splats");
    refused("gltf/meshopt.glb", "requires the extension EXT_meshopt_compression");
    refused("gltf/stand_in.glb", "does not give 3 numbers a splat inside a buffer");
    refused("gltf/sparse.glb", "attribute POSITION: its accessor is sparse");
}

static FfpGaussians read_seed(const char *name) {
    FfpGaussians g;
    FfpError err = {0};
    char path[FFP_PATH_MAX];
    snprintf(path, sizeof path, CORPUS "%s", name);
    if (!ffp_gaussians_read(&g, path, &err)) fail_msg("%s", err.text);
    return g;
}

// S, by rows, of a Gaussian.
static void covariance(const FfpGaussians *g, int64_t i, double s[9]) {
    const real *q = g->rotation + 4 * i;
    const double w = (double)q[0], x = (double)q[1], y = (double)q[2], z = (double)q[3];
    const double r[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                         2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                         2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    for (int k = 0; k < 9; k++) {
        s[k] = 0;
        for (int j = 0; j < 3; j++) {
            const double scale = (double)g->scale[3 * i + j];
            s[k] += r[3 * (k / 3) + j] * r[3 * (k % 3) + j] * scale * scale;
        }
    }
}

// Whatever the axes, the splats lie where their names say; spheres aside, covariances tell of turns.
static void test_axes_that_a_file_names(void **state) {
    (void)state;
    static const char *const names[] = {"spz/axes.spz", "spz/axes_zipped.spz", "spz/axes_plain.spz"};
    double still[9], turned[9];
    FfpGaussians from = read_seed("spz/version3.spz");
    covariance(&from, 0, still);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        FfpGaussians g = read_seed(names[i]);
        for (int k = 0; k < 3; k++) assert_close(g.centre[k], (double)from.centre[k], 1e-6);
        covariance(&g, 0, turned);
        for (int k = 0; k < 9; k++) assert_close((real)turned[k], still[k], 1e-5);
        ffp_gaussians_free(&g);
    }
    ffp_gaussians_free(&from);
    static const struct {
        unsigned char number;
        double at[3];
    } cases[] = {
        {3, {-0.5, 1, -2}}, {12, {0.5, -2, -1}}, {13, {-0.5, 2, 1}}, {0, {0.5, 1, -2}}, {99, {0.5, 1, -2}}};
    size_t size;
    char *bytes;
    assert_true(ffp_read_file(CORPUS "spz/axes.spz", 1 << 20, &bytes, &size, NULL));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        FfpGaussians g;
        FfpError err = {0};
        bytes[52] = (char)cases[i].number;
        assert_true(ffp_write_file(in_scratch("axes.spz"), bytes, size, NULL));
        if (!ffp_gaussians_read(&g, in_scratch("axes.spz"), &err)) fail_msg("%s", err.text);
        for (int k = 0; k < 3; k++) assert_close(g.centre[k], cases[i].at[k], 1e-3);
        ffp_gaussians_free(&g);
    }
    ffp_free(bytes);
}

// A .splat has no mark: its first bytes, of a number, are those of JSON or gzip now and then.
static void test_splats_that_begin_like_others(void **state) {
    (void)state;
    static const char *const heads[] = {"{", " {", "\n\t{", "\xef\xbb\xbf{", "\x1f\x8b"};
    size_t size;
    char *bytes;
    assert_true(ffp_read_file(CORPUS "splat/two.splat", 1 << 20, &bytes, &size, NULL));
    for (size_t i = 0; i < sizeof heads / sizeof *heads; i++) {
        FfpGaussians g;
        FfpError err = {0};
        memcpy(bytes, "\0\0\0", 4);
        memcpy(bytes, heads[i], strlen(heads[i]));
        assert_true(ffp_write_file(in_scratch("brace.splat"), bytes, size, NULL));
        if (!ffp_gaussians_read(&g, in_scratch("brace.splat"), &err)) fail_msg("%s", err.text);
        assert_int_equal(g.count, 2);
        ffp_gaussians_free(&g);
    }
    memcpy(bytes, "\x1f\x8b\x08", 3); // as downloads are that stayed packed
    assert_true(ffp_write_file(in_scratch("packed.splat"), bytes, size, NULL));
    assert_int_equal(ffp_file_kind(in_scratch("packed.splat")), FFP_KIND_SPZ);
    ffp_free(bytes);
}

// The parent mirrors z, triples it and adds (1,0,0); the node turns x to y to z to x and doubles.
static void test_nodes_move_splats(void **state) {
    (void)state;
    static const double a[9] = {0, 0, 2, 2, 0, 0, 0, -6, 0}, t[3] = {1, 0, 0};
    double from[9], to[9];
    FfpGaussians still = read_seed("gltf/splats.glb"), moved = read_seed("gltf/moved.glb"),
                 turned = read_seed("gltf/carried.glb");
    for (int k = 0; k < 6; k++) {
        const real *at = still.centre + k / 3 * 3;
        assert_close(moved.centre[k], (double)still.centre[k] + (k % 3 == 0), 1e-6);
        double wanted = t[k % 3];
        for (int j = 0; j < 3; j++) wanted += a[3 * (k % 3) + j] * (double)at[j];
        assert_close(turned.centre[k], wanted, 1e-6);
    }
    covariance(&still, 0, from);
    covariance(&turned, 0, to);
    for (int k = 0; k < 9; k++) {
        double wanted = 0;
        for (int i = 0; i < 9; i++) wanted += a[3 * (k / 3) + i / 3] * from[i] * a[3 * (k % 3) + i % 3];
        assert_close((real)to[k], wanted, 1e-8);
    }
    ffp_gaussians_free(&still), ffp_gaussians_free(&moved), ffp_gaussians_free(&turned);
}

// Of a compressed PLY whichever part of the quaternion is the largest, and opacities of 0 and 1.
static void test_packed_rotations(void **state) {
    (void)state;
    static const double turns[2][4] = {{0.1, 0.3, 0.9, -0.3}, {-0.1, 0.3, 0.3, 0.9}};
    FfpGaussians g = read_seed("ply/turned.ply");
    for (int i = 0; i < 8; i++) assert_close(g.rotation[i], turns[i / 4][i % 4], 2e-3);
    assert_true(g.opacity[0] == 1 && g.opacity[1] == 0);
    ffp_gaussians_free(&g);
}

static void test_several_sets_and_thin_splats(void **state) {
    (void)state;
    FfpGaussians twice = read_seed("gltf/twice.glb"), thin = read_seed("gltf/thin.glb"),
                 discs = read_seed("ply/discs.ply");
    assert_int_equal(twice.count, 4);
    for (int k = 0; k < 6; k++) assert_close(twice.centre[6 + k], (double)twice.centre[k], 0);
    assert_close(thin.scale[0], exp(-5) / 100, 1e-8);
    assert_close(discs.scale[2], exp(-4) / 100, 1e-8);
    ffp_gaussians_free(&twice), ffp_gaussians_free(&thin), ffp_gaussians_free(&discs);
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
        else if (!strstr(why.text, as) && !strstr(why.text, "cannot open")) // a buffer beside it
            fail_msg("%s", why.text);
        // zlib checks all of a gzip file but its head's time, flags and system
        if (strstr(name, "version3") && (i % 2 == 0 || at >= 10) && read)
            fail_msg("byte %zu of %s", at, name);
    }
    ffp_free(bytes);
    unlink(as);
}

static void test_damaged(void **state) {
    (void)state;
    damage("spz/version3.spz", "test_elsewhere.spz");
    damage("spz/streams.spz", "test_elsewhere.spz");
    damage("ply/compressed.ply", "test_elsewhere.ply");
    damage("ply/elements.ply", "test_elsewhere.ply");
    damage("ply/ascii.ply", "test_elsewhere.ply");
    damage("splat/two.splat", "test_elsewhere.splat");
    damage("gltf/splats.glb", "test_elsewhere.glb");
    damage("gltf/splats.gltf", "test_elsewhere.gltf");
    damage("gltf/packed.glb", "test_elsewhere.glb");
    damage("spz/axes.spz", "test_elsewhere.spz");
}

static void test_foreign_files_are_named(void **state) {
    (void)state;
    static const struct {
        const char *path, *bytes, *why;
    } cases[] = {{"a.sog", "PK\3\4", "is SOG, which is not supported: convert it"},
                 {"a.ksplat", "\0\1", "is KSPLAT"},
                 {"meta.json", "{\"version\":2,\"count\":3,\"means\":{}}", "is SOG"},
                 {"a.lcc", "{}", "is an LCC scene"},
                 {"a.ckpt", "PK\3\4", "is a checkpoint of PyTorch"},
                 {"a.las", "LASF", "is a point cloud (LAS)"},
                 {"a.ply", "version https://git-lfs.github.com/spec/v1", "is a Git LFS pointer"},
                 {"a.ply", "<!doctype html>", "is a web page"},
                 {"a.ply", "", "is empty"},
                 {"a.splat", "123", "its 3 bytes are not rows of 32"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        FfpGaussians g;
        FfpError err = {0};
        put(cases[i].path, cases[i].bytes, strlen(cases[i].bytes));
        assert_false(ffp_gaussians_read(&g, cases[i].path, &err));
        if (!strstr(err.text, cases[i].why) || !strstr(err.text, cases[i].path)) fail_msg("%s", err.text);
        unlink(cases[i].path);
    }
}

typedef struct Heard {
    const char *path;
    char text[4096];
} Heard;

static void hear(void *user, FfpLogLevel level, const char *text) {
    Heard *heard = user;
    (void)level;
    strncat(heard->text, text, sizeof heard->text - strlen(heard->text) - 1);
}

static bool read_in_call(void *argument, FfpError *err) {
    (void)err;
    FfpGaussians g;
    if (!ffp_gaussians_read(&g, ((Heard *)argument)->path, err)) return false;
    ffp_gaussians_free(&g);
    return true;
}

static void expect_note_of(const char *path, const char *part, bool said) {
    Heard heard = {.path = path};
    FfpError err = {0};
    FfpContext context = {.settings = {.user = &heard, .log = hear}};
    if (!ffp_call_run(&context, read_in_call, &heard, &err)) fail_msg("%s", err.text);
    if (!strstr(heard.text, part) == said) fail_msg("%s: \"%s\" in \"%s\"", path, part, heard.text);
}

static void expect_note(const char *name, const char *part, bool said) {
    char path[FFP_PATH_MAX];
    snprintf(path, sizeof path, CORPUS "%s", name);
    expect_note_of(path, part, said);
}

// Twenty splats in a row, as text; their logits and logarithms grow by `more` from the first to the last.
static void put_row_of_splats(const char *path, const char *first_x, double logit, double size, double more) {
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    fputs("ply\nformat ascii 1.0\nelement vertex 20\n", out);
    static const char *const names[] = {"x",      "y",       "z",       "f_dc_0",  "f_dc_1",
                                        "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
                                        "rot_0",  "rot_1",   "rot_2",   "rot_3"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) fprintf(out, "property float %s\n", names[k]);
    fputs("end_header\n", out);
    for (int i = 0; i < 20; i++) {
        const double s = size + more * i / 20;
        if (i == 0)
            fputs(first_x, out);
        else
            fprintf(out, "%g", 0.1 * i);
        fprintf(out, " 0 0 0 0 0 %g %g %g %g 1 0 0 0\n", logit + more * i / 20, s, s, s);
    }
    assert_int_equal(fclose(out), 0);
}

static void test_numbers_that_were_not_encoded(void **state) {
    (void)state;
    const char *path = in_scratch("row.ply"), *large = "larger than a tenth",
               *middling = "between 0.5 and 0.73";
    put_row_of_splats(path, "0", -2, -4, 4);
    expect_note_of(path, large, false);
    expect_note_of(path, middling, false);
    put_row_of_splats(path, "0", -2, 0.01, 0.02); // sizes
    expect_note_of(path, large, true);
    expect_note_of(path, middling, false);
    put_row_of_splats(path, "0", 0.1, -4, 0.8); // opacities
    expect_note_of(path, large, false);
    expect_note_of(path, middling, true);
}

// Twenty splats of red, as text.
static void put_reds(const char *path, const char *type, const char *most) {
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    fprintf(
        out,
        "ply\nformat ascii 1.0\nelement vertex 20\nproperty %s red\nproperty %s green\nproperty %s blue\n",
        type, type, type);
    static const char *const names[] = {"x",       "y",     "z",     "opacity", "scale_0", "scale_1",
                                        "scale_2", "rot_0", "rot_1", "rot_2",   "rot_3"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) fprintf(out, "property float %s\n", names[k]);
    fputs("end_header\n", out);
    for (int i = 0; i < 20; i++) fprintf(out, "%s %s 0 %d 0 0 2 -4 -4 -4 1 0 0 0\n", most, most, i);
    assert_int_equal(fclose(out), 0);
}

static void test_colours_of_all_types(void **state) {
    (void)state;
    static const char *const types[][2] = {
        {"uchar", "255"}, {"int", "255"}, {"short", "255"}, {"ushort", "65535"}, {"double", "1"}};
    const char *path = in_scratch("red.ply"), *far = "from 0 to 255?";
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        FfpGaussians g;
        put_reds(path, types[i][0], types[i][1]);
        assert_true(ffp_gaussians_read(&g, path, NULL));
        assert_close(g.ambient[0], 1, 1e-5);
        assert_close(g.ambient[2], 0, 1e-5);
        ffp_gaussians_free(&g);
        expect_note_of(path, far, false);
    }
    put_reds(path, "float", "255");
    expect_note_of(path, far, true);
}

static void test_old_words_for_nan(void **state) {
    (void)state;
    static const char *const words[] = {"1.#QNAN", "-1.#IND000", "1.#INF", "1.#J", "-nan(ind)"};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        put_row_of_splats(in_scratch("row.ply"), words[i], -2, -4, 4);
        expect_note_of(in_scratch("row.ply"), "left out 1 of 20 splats", true);
    }
}

static void test_files_that_go_on(void **state) {
    (void)state;
    static const char *const names[] = {"splat/two.splat", "ply/big.ply", "gltf/splats.glb"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char path[FFP_PATH_MAX], *bytes;
        size_t size;
        snprintf(path, sizeof path, CORPUS "%s", names[i]);
        assert_true(ffp_read_file(path, 1 << 20, &bytes, &size, NULL));
        FILE *out = fopen(in_scratch(strrchr(names[i], '/') + 1), "wb");
        assert_non_null(out);
        fwrite(bytes, 1, size, out);
        fputs("thirteen more", out);
        assert_int_equal(fclose(out), 0);
        expect_note_of(in_scratch(strrchr(names[i], '/') + 1), "13 bytes after its last splat are left out",
                       true);
        ffp_free(bytes);
    }
}

static void test_notes(void **state) {
    (void)state;
    expect_note("ply/ascii.ply", "splats without material", true);
    expect_note("ply/harmonics.ply", "spherical harmonics are left out", true);
    expect_note("ply/no_harmonics.ply", "spherical harmonics are left out", false);
    expect_note("ply/no_harmonics.ply", "filter_3D", true);
    expect_note("ply/elements.ply", "its 1 faces are left out", true);
    expect_note("spz/harmonics.spz", "spherical harmonics are left out", true);
    expect_note("gltf/mixed.glb", "what is not splats is left out: 1 primitives", true);
    expect_note("gltf/splats.glb", "what is not splats", false);
    expect_note("gltf/kernel.glb", "customShape are drawn as ellipses", true);
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
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_form),
        cmocka_unit_test(test_what_is_not_read_is_refused_by_name),
        cmocka_unit_test_setup_teardown(test_splats_that_begin_like_others, scratch_setup, scratch_teardown),
        cmocka_unit_test_setup_teardown(test_axes_that_a_file_names, scratch_setup, scratch_teardown),
        cmocka_unit_test(test_nodes_move_splats),
        cmocka_unit_test(test_packed_rotations),
        cmocka_unit_test(test_several_sets_and_thin_splats),
        cmocka_unit_test(test_foreign_files_are_named),
        cmocka_unit_test(test_notes),
        cmocka_unit_test_setup_teardown(test_numbers_that_were_not_encoded, scratch_setup, scratch_teardown),
        cmocka_unit_test_setup_teardown(test_colours_of_all_types, scratch_setup, scratch_teardown),
        cmocka_unit_test_setup_teardown(test_old_words_for_nan, scratch_setup, scratch_teardown),
        cmocka_unit_test_setup_teardown(test_files_that_go_on, scratch_setup, scratch_teardown),
        cmocka_unit_test(test_damaged),
        cmocka_unit_test(test_base64)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
