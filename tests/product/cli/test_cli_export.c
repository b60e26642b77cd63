// `export` as a user runs it: each file read by other means than those that wrote it, and held against the
// Gaussians that it comes from.
#include <jansson.h>
#include <zlib.h>
#include "core/gaussians/gaussians.h"
#include "core/image/image.h"
#include "product/cli/program.h"
#include "product/cli/tiny.h"
#include "world/shapes/mesh.h"

#define SIDE 48
#define NUMBERS 62 // floats in a row of the PLY
#define SH_C0 0.28209479177387814

static ProgramRun run;
static FfpGaussians truth;

static void must_run(void) {
    if (run.status != 0) printf("exit %d\n%s", run.status, run.err);
    assert_int_equal(run.status, 0);
}

static void must_fail(int status, const char *what, const char *file) {
    if (run.status != status || !strstr(run.err, what)) printf("exit %d\n%s", run.status, run.err);
    assert_int_equal(run.status, status);
    assert_non_null(strstr(run.err, what));
    if (file) assert_false(ffp_is_file(in_scratch(file)));
}

static int group_setup(void **state) {
    FfpError err = {0};
    if (scratch_setup(state) != 0) return -1;
    tiny_capture(in_scratch("tiny"), SIDE);
    run_format(&run, "reconstruct %s/tiny -o %s/tiny.ply --model none", scratch, scratch);
    must_run();
    if (!ffp_gaussians_read(&truth, in_scratch("tiny.ply"), &err)) fail_msg("%s", err.text);
    return 0;
}

static int group_teardown(void **state) {
    ffp_gaussians_free(&truth);
    return scratch_teardown(state);
}

// The k-th Gaussian that is opaque enough to be written.
static int64_t kept(int64_t k) {
    for (int64_t i = 0; i < truth.count; i++)
        if (truth.opacity[i] >= 1.0F / 255 && k-- == 0) return i;
    return -1;
}

static int64_t count_kept(void) {
    int64_t n = 0;
    for (int64_t i = 0; i < truth.count; i++) n += truth.opacity[i] >= 1.0F / 255;
    return n;
}

// Rows of the PLY [count,62]; released with free.
static float *read_ply(const char *name, int64_t *count) {
    long long n = 0;
    char line[64];
    FILE *file = fopen(in_scratch(name), "rb");
    assert_non_null(file);
    int properties = 0;
    while (fgets(line, sizeof line, file) && strcmp(line, "end_header\n") != 0) {
        if (strncmp(line, "element vertex ", 15) == 0) n = strtoll(line + 15, NULL, 10);
        properties += strncmp(line, "property float ", 15) == 0;
        if (properties == 4) assert_string_equal(line, "property float nx\n");
        if (properties == 10) assert_string_equal(line, "property float f_rest_0\n");
        if (properties == 55) assert_string_equal(line, "property float opacity\n");
        if (properties == NUMBERS) assert_string_equal(line, "property float rot_3\n");
    }
    assert_int_equal(properties, NUMBERS);
    float *rows = malloc((size_t)n * NUMBERS * sizeof *rows);
    assert_int_equal(fread(rows, NUMBERS * sizeof *rows, (size_t)n, file), n);
    assert_int_equal(fgetc(file), EOF);
    fclose(file);
    *count = n;
    return rows;
}

static bool near(float a, float b) {
    return fabsf(a - b) < 1e-6F;
}

static double encode(double c) {
    return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055;
}

// y down, z forward: our x, -z, y. A splat's axes turn with it.
static void ply_is_the_reference_layout_with_y_down(void **state) {
    (void)state;
    int64_t n;
    run_format(&run, "export %s/tiny.ply -o %s/out.ply", scratch, scratch);
    must_run();
    float *rows = read_ply("out.ply", &n);
    assert_int_equal(n, count_kept());
    for (int64_t k = 0; k < n; k += 97) {
        const float *row = rows + NUMBERS * k, *q = row + 58;
        const int64_t i = kept(k);
        assert_true(near(row[0], truth.centre[3 * i]) && near(row[1], -truth.centre[3 * i + 2]) &&
                    near(row[2], truth.centre[3 * i + 1]));
        assert_true(fabs(1 / (1 + exp(-(double)row[54])) - (double)truth.opacity[i]) < 1e-4);
        const float *p = truth.rotation + 4 * i;
        const float ours[3] = {2 * (p[1] * p[3] + p[0] * p[2]), 2 * (p[2] * p[3] - p[0] * p[1]),
                               1 - 2 * (p[1] * p[1] + p[2] * p[2])};
        const float theirs[3] = {2 * (q[1] * q[3] + q[0] * q[2]), 2 * (q[2] * q[3] - q[0] * q[1]),
                                 1 - 2 * (q[1] * q[1] + q[2] * q[2])};
        assert_true(fabsf(theirs[0] - ours[0]) < 1e-4F && fabsf(theirs[1] + ours[2]) < 1e-4F &&
                    fabsf(theirs[2] - ours[1]) < 1e-4F);
        for (int c = 0; c < 3; c++) {
            assert_true(fabs(exp((double)row[55 + c]) / (double)truth.scale[3 * i + c] - 1) < 1e-3);
            assert_true(fabs(0.5 + SH_C0 * (double)row[6 + c] - encode((double)truth.ambient[3 * i + c])) <
                        1e-3);
            assert_true(row[3 + c] == 0 && row[9 + 15 * c] == 0);
        }
    }
    free(rows);
}

// Files that are read, or hold more than what would be written, survive.
static void what_is_worth_more_is_not_overwritten(void **state) {
    (void)state;
    run_format(&run, "export %s/tiny.ply -o %s/tiny.ply", scratch, scratch);
    must_fail(2, "--output would overwrite the input", NULL);
    run_format(&run, "export %s/tiny.ply -o %s/./tiny.ply", scratch, scratch);
    must_fail(2, "--output would overwrite the input", NULL);
    run_format(&run, "view %s/tiny.ply -c %s/tiny -o %s/page.png", scratch, scratch, scratch);
    must_fail(2, "--output writes a .html file, not '", "page.png");
    run_format(&run, "refine %s/tiny.ply -c %s/tiny -o %s/both.ply --metrics %s/both.ply", scratch, scratch,
               scratch, scratch);
    must_fail(2, "--output and --metrics are the same file", "both.ply");

    run_format(&run, "reconstruct %s/tiny -o %s/kept.ply --model none", scratch, scratch);
    must_run();
    run_format(&run, "export %s/tiny.ply -o %s/kept.ply", scratch, scratch);
    must_fail(1, "exists and holds relightable Gaussians", NULL);
    assert_true(ffp_gaussians_are_relightable(in_scratch("kept.ply")));
    run_format(&run, "export %s/tiny.ply -o %s/kept.ply --force", scratch, scratch);
    must_run();
    assert_false(ffp_gaussians_are_relightable(in_scratch("kept.ply")));
    run_format(&run, "export %s/tiny.ply -o %s/kept.ply", scratch, scratch); // its own kind
    must_run();
}

// Files of `export` are like those of other programs: they come back with their colours as albedo, and are
// drawn.
static void plain_splats_are_read(void **state) {
    (void)state;
    FfpGaussians plain;
    FfpError err = {0};
    run_format(&run, "export %s/tiny.ply -o %s/plain.ply --up=-y", scratch, scratch);
    must_run();
    assert_true(ffp_gaussians_read(&plain, in_scratch("plain.ply"), &err));
    assert_int_equal(plain.count, count_kept());
    for (int64_t k = 0; k < plain.count; k++) {
        const int64_t i = kept(k);
        assert_true(plain.roughness[k] == 0.5F);
        for (int c = 0; c < 3; c++) {
            assert_true(fabsf(plain.ambient[3 * k + c] - truth.ambient[3 * i + c]) < 1e-4F);
            assert_true(near(plain.albedo[3 * k + c], fminf(plain.ambient[3 * k + c], 1)));
        }
    }
    ffp_gaussians_free(&plain);
    run_format(&run, "render %s/plain.ply -c %s/tiny -o %s/plain", scratch, scratch, scratch);
    must_run();
    assert_non_null(strstr(run.err, "splats without material"));
    run_format(&run, "info %s/plain.ply", scratch);
    must_run();
    run_format(&run, "refine %s/plain.ply -c %s/tiny -o %s/fitted.ply --steps 24", scratch, scratch, scratch);
    must_run();
    assert_true(ffp_gaussians_are_relightable(in_scratch("fitted.ply")));
}

static void up_chooses_the_axes(void **state) {
    (void)state;
    int64_t n;
    run_format(&run, "export %s/tiny.ply -o %s/same.ply --up=-y", scratch, scratch);
    must_run();
    float *rows = read_ply("same.ply", &n);
    const int64_t i = kept(5);
    for (int c = 0; c < 3; c++) assert_true(rows[5 * NUMBERS + c] == truth.centre[3 * i + c]);
    free(rows);
}

// The baked splats, drawn in their own light, look as the others do under the projector.
static void baked_light_is_the_renderers(void **state) {
    (void)state;
    static const char *const lights[3] = {"white", "lollipop_1", "white"};
    static const char *const pictures[3] = {"all_white", "lollipop_1", "all_white"};
    static const char *const forms[3] = {"ours", "ours", "gs-procams"};
    for (int k = 0; k < 3; k++) {
        int64_t n;
        FfpError err = {0};
        FfpImage baked, drawn;
        char name[64];
        run_format(&run,
                   "export %s/tiny.ply -c %s/tiny --light %s --projector-view view_1 --camera-view view_1 "
                   "--drawing %s -o %s/lit.ply --up=-y",
                   scratch, scratch, lights[k], forms[k], scratch);
        must_run();
        float *rows = read_ply("lit.ply", &n);
        FfpGaussians lit = ffp_gaussians_copy(&truth);
        for (int64_t j = 0; j < n; j++)
            for (int c = 0; c < 3; c++)
                lit.ambient[3 * kept(j) + c] =
                    ffp_srgb_decode((float)(0.5 + SH_C0 * (double)rows[NUMBERS * j + 6 + c]));
        free(rows);
        if (!ffp_gaussians_write(&lit, in_scratch("lit_back.ply"), 0, &err)) fail_msg("%s", err.text);
        ffp_gaussians_free(&lit);
        run_format(&run, "render %s/lit_back.ply -c %s/tiny -v view_1 -p all_black --drawing %s -o %s/baked",
                   scratch, scratch, forms[k], scratch);
        must_run();
        run_format(&run, "render %s/tiny.ply -c %s/tiny -v view_1 -p %s --drawing %s -o %s/drawn", scratch,
                   scratch, pictures[k], forms[k], scratch);
        must_run();
        snprintf(name, sizeof name, "drawn/view_1_%s.png", pictures[k]);
        assert_true(
            ffp_image_read(&baked, in_scratch("baked/view_1_all_black.png"), FFP_COLOUR_ENCODED, &err));
        assert_true(ffp_image_read(&drawn, in_scratch(name), FFP_COLOUR_ENCODED, &err));
        double square = 0, level = 0;
        for (int i = 0; i < SIDE * SIDE * 4; i++) {
            const double d = (double)(baked.data[i] - drawn.data[i]);
            if (i % 4 < 3) square += d * d, level += (double)drawn.data[i];
        }
        const double psnr = -10 * log10(square / (3 * SIDE * SIDE));
        printf("%s, %s: %.1f dB\n", lights[k], forms[k], psnr);
        assert_true(level / (3 * SIDE * SIDE) > 0.05);
        assert_true(psnr > (k == 1 ? 24 : 32));
        ffp_image_free(&baked);
        ffp_image_free(&drawn);
    }
}

// By the published layout, y up and z backwards: our x, z, -y.
static void spz_unpacks_to_the_gaussians(void **state) {
    (void)state;
    unsigned char head[16];
    run_format(&run, "export %s/tiny.ply -o %s/out.spz", scratch, scratch);
    must_run();
    gzFile file = gzopen(in_scratch("out.spz"), "rb");
    assert_non_null(file);
    assert_int_equal(gzread(file, head, 16), 16);
    assert_memory_equal(head, "NGSP\3\0\0\0", 8);
    const int64_t n = count_kept(), given = head[8] | head[9] << 8 | head[10] << 16;
    assert_int_equal(given, n);
    assert_true(head[12] == 0 && head[13] > 8 && head[14] == 0);
    unsigned char *bytes = malloc((size_t)n * 20 + 1);
    assert_int_equal(gzread(file, bytes, (unsigned)(n * 20 + 1)), n * 20);
    gzclose(file);
    for (int64_t k = 0; k < n; k += 53) {
        const int64_t i = kept(k);
        const float want[3] = {truth.centre[3 * i], truth.centre[3 * i + 2], -truth.centre[3 * i + 1]};
        for (int c = 0; c < 3; c++) {
            const unsigned char *b = bytes + 9 * k + 3 * c;
            const int fixed = (b[0] | b[1] << 8 | b[2] << 16) - ((b[2] & 0x80) << 17);
            assert_true(fabs(ldexp(fixed, -head[13]) - (double)want[c]) <
                        1.01 * ldexp(0.5, -head[13]) + 1e-7);
            const double scale = exp(bytes[13 * n + 3 * k + c] / 16.0 - 10);
            assert_true(fabs(log(scale / (double)truth.scale[3 * i + c])) < 0.04);
            const double colour = 0.5 + SH_C0 * (bytes[10 * n + 3 * k + c] / 255.0 - 0.5) / 0.15;
            assert_true(fabs(colour - encode((double)truth.ambient[3 * i + c])) < 0.005);
        }
        assert_true(fabs(bytes[9 * n + k] / 255.0 - (double)truth.opacity[i]) < 0.003);
        // the splat's turn, undone by the quarter turn, is ours up to the sign
        const unsigned char *r = bytes + 16 * n + 4 * k;
        uint32_t packed = r[0] | (uint32_t)r[1] << 8 | (uint32_t)r[2] << 16 | (uint32_t)r[3] << 24;
        const int largest = (int)(packed >> 30);
        double xyzw[4], rest = 1;
        for (int c = 3; c >= 0; c--) {
            if (c == largest) continue;
            xyzw[c] = sqrt(0.5) * (packed & 511) / 511 * (packed >> 9 & 1 ? -1 : 1);
            rest -= xyzw[c] * xyzw[c], packed >>= 10;
        }
        xyzw[largest] = sqrt(fmax(rest, 0));
        const double h = sqrt(0.5), *q = xyzw; // (w,x) of the turn are h, -h
        const float *p = truth.rotation + 4 * i;
        const double w = h * (double)p[0] + h * (double)p[1], x = h * (double)p[1] - h * (double)p[0],
                     y = h * (double)p[2] + h * (double)p[3], z = h * (double)p[3] - h * (double)p[2];
        assert_true(fabs(q[3] * w + q[0] * x + q[1] * y + q[2] * z) > 0.99999);
    }
    free(bytes);
}

// --- glTF. ---

static json_t *read_glb(const char *name, char **bytes, char **buffer) {
    size_t size;
    uint32_t head[5];
    assert_true(ffp_read_file(in_scratch(name), 1 << 26, bytes, &size, NULL));
    memcpy(head, *bytes, 20);
    assert_memory_equal(*bytes, "glTF", 4);
    assert_true(head[1] == 2 && head[2] == size && head[3] % 4 == 0);
    json_t *root = json_loadb(*bytes + 20, head[3], 0, NULL);
    assert_non_null(root);
    *buffer = *bytes + 20 + head[3] + 8;
    return root;
}

static const float *floats_of(json_t *root, const char *buffer, json_t *attributes, const char *name,
                              int64_t n) {
    json_t *accessor = json_array_get(json_object_get(root, "accessors"),
                                      (size_t)json_integer_value(json_object_get(attributes, name)));
    json_t *view = json_array_get(json_object_get(root, "bufferViews"),
                                  (size_t)json_integer_value(json_object_get(accessor, "bufferView")));
    assert_int_equal(json_integer_value(json_object_get(accessor, "count")), n);
    assert_int_equal(json_integer_value(json_object_get(accessor, "componentType")), 5126);
    return (const float *)(const void *)(buffer + json_integer_value(json_object_get(view, "byteOffset")));
}

static void glb_holds_gaussian_splatting(void **state) {
    (void)state;
    char *bytes, *buffer;
    const int64_t n = count_kept();
    run_format(&run, "export %s/tiny.ply -o %s/out.glb", scratch, scratch);
    must_run();
    json_t *root = read_glb("out.glb", &bytes, &buffer), *used = json_object_get(root, "extensionsUsed");
    assert_string_equal(json_string_value(json_array_get(used, 0)), "KHR_gaussian_splatting");
    json_t *mesh = json_array_get(json_object_get(root, "meshes"), 0),
           *primitive = json_array_get(json_object_get(mesh, "primitives"), 0),
           *attributes = json_object_get(primitive, "attributes"),
           *form = json_object_get(json_object_get(primitive, "extensions"), "KHR_gaussian_splatting");
    assert_int_equal(json_integer_value(json_object_get(primitive, "mode")), 0);
    assert_string_equal(json_string_value(json_object_get(form, "kernel")), "ellipse");
    assert_string_equal(json_string_value(json_object_get(form, "colorSpace")), "srgb_rec709_display");
    const float *centre = floats_of(root, buffer, attributes, "POSITION", n),
                *scale = floats_of(root, buffer, attributes, "KHR_gaussian_splatting:SCALE", n),
                *opacity = floats_of(root, buffer, attributes, "KHR_gaussian_splatting:OPACITY", n),
                *turn = floats_of(root, buffer, attributes, "KHR_gaussian_splatting:ROTATION", n),
                *colour = floats_of(root, buffer, attributes, "KHR_gaussian_splatting:SH_DEGREE_0_COEF_0", n),
                *plain = floats_of(root, buffer, attributes, "COLOR_0", n);
    for (int64_t k = 0; k < n; k += 61) {
        const int64_t i = kept(k);
        const float *q = turn + 4 * k, *p = truth.rotation + 4 * i, h = sqrtf(0.5F);
        assert_true(near(centre[3 * k], truth.centre[3 * i]) &&
                    near(centre[3 * k + 1], truth.centre[3 * i + 2]) &&
                    near(centre[3 * k + 2], -truth.centre[3 * i + 1]));
        assert_true(opacity[k] == truth.opacity[i] && plain[4 * k + 3] == opacity[k]);
        assert_true(fabsf(q[3] - h * (p[0] + p[1])) < 1e-6F && fabsf(q[0] - h * (p[1] - p[0])) < 1e-6F);
        assert_true(fabsf(q[1] - h * (p[2] + p[3])) < 1e-6F && fabsf(q[2] - h * (p[3] - p[2])) < 1e-6F);
        for (int c = 0; c < 3; c++) {
            assert_true(scale[3 * k + c] == truth.scale[3 * i + c]);
            assert_true(fabs(0.5 + SH_C0 * (double)colour[3 * k + c] -
                             encode((double)truth.ambient[3 * i + c])) < 1e-4);
            assert_true(fabsf(plain[4 * k + c] - truth.ambient[3 * i + c]) < 1e-4F);
        }
    }
    json_decref(root);
    ffp_free(bytes);
}

static size_t digit_of(char c) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *at = strchr(digits, c);
    assert_true(c != 0 && at);
    return (size_t)(at - digits);
}

static void gltf_holds_the_same_in_one_file(void **state) {
    (void)state;
    char *bytes, *binary;
    run_format(&run, "export %s/tiny.ply -o %s/twin.glb", scratch, scratch);
    must_run();
    json_decref(read_glb("twin.glb", &bytes, &binary));
    run_format(&run, "export %s/tiny.ply -o %s/out.gltf", scratch, scratch);
    must_run();
    json_t *root = json_load_file(in_scratch("out.gltf"), 0, NULL);
    assert_non_null(root);
    json_t *buffer = json_array_get(json_object_get(root, "buffers"), 0);
    const char *uri = json_string_value(json_object_get(buffer, "uri"));
    assert_non_null(uri);
    assert_true(strncmp(uri, "data:application/octet-stream;base64,", 37) == 0);
    const size_t size = (size_t)json_integer_value(json_object_get(buffer, "byteLength"));
    assert_int_equal(strlen(uri + 37), (size + 2) / 3 * 4);
    assert_true(size > 1000);
    for (size_t i = 0; i < size; i++) {
        const char *four = uri + 37 + i / 3 * 4 + i % 3; // a byte lies in two digits
        const size_t two = digit_of(four[0]) << 6 | digit_of(four[1]);
        assert_int_equal((unsigned char)binary[i], two >> (4 - 2 * (i % 3)) & 255);
    }
    json_decref(root);
    ffp_free(bytes);
}

// --- Meshes. ---

// Edges that do not have as many triangles one way as the other, by a table of hashes: 0 of a closed surface.
static int open_edges(const char *name, int *faces) {
    enum { ROOM = 1 << 21 };
    static int table[ROOM];
    char line[256];
    memset(table, 0, sizeof table);
    FILE *file = fopen(in_scratch(name), "r");
    assert_non_null(file);
    *faces = 0;
    while (fgets(line, sizeof line, file)) {
        unsigned v[3];
        char *at = line + 1;
        if (strncmp(line, "f ", 2) != 0) continue;
        for (int k = 0; k < 3; k++) {
            v[k] = (unsigned)strtoul(at, &at, 10);
            assert_true(strncmp(at, "//", 2) == 0 && strtoul(at + 2, &at, 10) == v[k]);
        }
        assert_int_equal(*at, '\n'); // a triangle
        ++*faces;
        for (int k = 0; k < 3; k++) {
            const unsigned a = v[k], b = v[(k + 1) % 3], low = a < b ? a : b, high = a < b ? b : a;
            table[(low * 2654435761U ^ high * 40503U) % ROOM] += a < b ? 1 : -1;
        }
    }
    fclose(file);
    int open = 0;
    for (int i = 0; i < ROOM; i++) open += table[i] != 0;
    return open;
}

static void meshes_are_closed_and_where_the_object_is(void **state) {
    (void)state;
    int faces = 0;
    run_format(&run, "export %s/tiny.ply -c %s/tiny --mesh --resolution 64 -o %s/ball.obj", scratch, scratch,
               scratch);
    must_run();
    assert_int_equal(open_edges("ball.obj", &faces), 0);
    assert_true(faces > 1000);
    char line[256];
    double least = 1e9, most = 0, red = 0;
    int vertices = 0;
    FILE *file = fopen(in_scratch("ball.obj"), "r");
    while (fgets(line, sizeof line, file)) {
        double p[6];
        char *at = line + 1;
        if (strncmp(line, "v ", 2) != 0) continue;
        for (int k = 0; k < 6; k++) p[k] = strtod(at, &at);
        const double r = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        if (fabs(p[1]) > 0.4) continue; // the poles are not seen
        least = fmin(least, r), most = worse(most, r), red += p[3], vertices++;
    }
    fclose(file);
    printf("ball of %.2f: %d vertices at %.3f to %.3f\n", (double)TINY_BALL, vertices, least, most);
    assert_true(vertices > 500 && red / vertices > 0.1);
    assert_true(least > 0.8 * (double)TINY_BALL && most < 1.15 * (double)TINY_BALL);
}

static void textured_meshes_are_read_by_assimp(void **state) {
    (void)state;
    FfpError err = {0};
    run_format(&run, "export %s/tiny.ply -c %s/tiny --mesh --resolution 32 -o %s/ball.glb", scratch, scratch,
               scratch);
    must_run();
    char *bytes, *buffer;
    json_t *root = read_glb("ball.glb", &bytes, &buffer);
    json_t *material =
        json_object_get(json_array_get(json_object_get(root, "materials"), 0), "pbrMetallicRoughness");
    assert_non_null(json_object_get(material, "baseColorTexture"));
    assert_non_null(json_object_get(material, "metallicRoughnessTexture"));
    json_decref(root);
    ffp_free(bytes);
    FfpMesh mesh = {0};
    if (!ffp_mesh_read(&mesh, in_scratch("ball.glb"), &err)) fail_msg("%s", err.text);
    assert_true(mesh.n_triangles > 500 && mesh.uv && mesh.normals);
    double volume = 0; // of the tetrahedra over the origin: above 0 where triangles face outwards
    for (int t = 0; t < mesh.n_triangles; t++) {
        const float *p[3];
        for (int k = 0; k < 3; k++) p[k] = mesh.positions + 3 * (size_t)mesh.triangles[3 * t + k];
        for (int k = 0; k < 3; k++) {
            const int l = (k + 1) % 3, m = (k + 2) % 3;
            volume += (double)(p[0][k] * (p[1][l] * p[2][m] - p[1][m] * p[2][l])) / 6;
        }
    }
    printf("volume %.2f\n", volume);
    assert_true(volume > 1.5 && volume < 4); // a ball of radius 0.95 has 3.59
    ffp_mesh_free(&mesh);
}

static void wrong_exports_say_what_is_wrong(void **state) {
    (void)state;
    const char *in = "tiny.ply";
    run_format(&run, "export %s/%s -o %s/no.xyz", scratch, in, scratch);
    must_fail(1, "splats are written as .ply, .spz, .glb or .gltf", "no.xyz");
    run_format(&run, "export %s/%s -o %s/no.obj", scratch, in, scratch);
    must_fail(1, ".obj is for a mesh", "no.obj");
    run_format(&run, "export %s/%s -o %s/no.spz --mesh -c %s/tiny", scratch, in, scratch, scratch);
    must_fail(1, "a mesh is written as", "no.spz");
    run_format(&run, "export %s/%s -o %s/no.glb --mesh", scratch, in, scratch);
    must_fail(1, "a mesh requires the capture", "no.glb");
    run_format(&run, "export %s/%s -o %s/no.ply --light white", scratch, in, scratch);
    must_fail(1, "light requires the capture", "no.ply");
    run_format(&run, "export %s/%s -o %s/no.ply --light noon -c %s/tiny", scratch, in, scratch, scratch);
    must_fail(1, "noon is not ambient, white, an image file", "no.ply");
    run_format(&run, "export %s/%s -o %s/no.ply --light white --projector-view view_9 -c %s/tiny", scratch,
               in, scratch, scratch);
    must_fail(1, "no view view_9", "no.ply");
    run_format(&run, "export %s/%s -o %s/none/no.ply", scratch, in, scratch);
    must_fail(1, "cannot write", "none/no.ply");
    run_format(&run, "export %s/%s", scratch, in);
    must_fail(2, "-o, --output FILE is missing", NULL);
    run_format(&run, "export %s/%s -o %s/no.ply --up w", scratch, in, scratch);
    must_fail(2, "--up", "no.ply");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ply_is_the_reference_layout_with_y_down),
        cmocka_unit_test(what_is_worth_more_is_not_overwritten),
        cmocka_unit_test(plain_splats_are_read),
        cmocka_unit_test(up_chooses_the_axes),
        cmocka_unit_test(baked_light_is_the_renderers),
        cmocka_unit_test(spz_unpacks_to_the_gaussians),
        cmocka_unit_test(glb_holds_gaussian_splatting),
        cmocka_unit_test(gltf_holds_the_same_in_one_file),
        cmocka_unit_test(meshes_are_closed_and_where_the_object_is),
        cmocka_unit_test(textured_meshes_are_read_by_assimp),
        cmocka_unit_test(wrong_exports_say_what_is_wrong),
    };
    return cmocka_run_group_tests(tests, group_setup, group_teardown);
}
