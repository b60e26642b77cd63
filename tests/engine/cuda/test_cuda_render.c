// The view pass on the device against that on the CPU: G-buffers, mapping, pictures and the Gaussians'
// gradients. FFP_LARGE in the environment: at the sizes of training.
//
// Both round differently, and in a few samples that decides whether a shadow map's texel holds light back, or
// which neighbour a footprint is measured to. So the mapping is compared sample by sample, and a few samples
// may differ; everything behind it is then done with the CPU's mapping on both.
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/device.h"
#include "engine/cuda/cuda.h"
#include "engine/render/pass.h"
#include "engine/render/scenes.h"
#include "support.h"

#define TOLERANCE 1e-4  // of the difference's norm, as a share of the norm
#define MAPPED 1e-3     // a sample's mapping differs from here on
#define MAPPED_FEW 2e-3 // share of samples that may

enum { PATTERNS = 3, PATTERN_WIDTH = 97, PATTERN_HEIGHT = 71 };

typedef struct Case {
    const char *name;
    FfpRenderSettings settings;
    int width, height;
    int64_t splats;
    double scale; // largest deviation
    bool keep_shadow;
} Case;

// The inputs of a case, on the host.
typedef struct World {
    FfpGaussians gaussians;
    FfpCamera camera, projector;
    FfpSummed light[PATTERNS]; // the first: black
    FfpImage grad_picture[PATTERNS];
    FfpGbuffer grad_gbuffer;
} World;

// Its outputs, on the host.
typedef struct Result {
    FfpGbuffer gbuffer, samples;
    FfpMapping mapping;
    FfpImage picture[PATTERNS];
    FfpGaussians grad;
} Result;

static const FfpDevice *device;

static FfpImage random_image(int width, int height, double low, uint64_t seed) {
    FfpRng rng = ffp_rng(seed, 3);
    FfpImage image = ffp_image_new(width, height, 3);
    for (int i = 0; i < 3 * width * height; i++) image.data[i] = between(&rng, low, 1);
    return image;
}

static World new_world(const Case *c) {
    static const real eye[3] = {2.1F, -1.7F, 1.1F}, projector_eye[3] = {1.0F, -1.9F, 1.7F}, origin[3] = {0};
    const double focal = 2.2 * c->width;
    World w = {.gaussians = random_gaussians(c->splats, 7, 0.5, 0.1 * c->scale, c->scale, 0, 1.1),
               .camera = look_at(c->width, c->height, focal, eye, origin),
               .projector = look_at(PATTERN_WIDTH, PATTERN_HEIGHT, 150, projector_eye, origin),
               .grad_gbuffer = ffp_gbuffer_new(c->width, c->height)};
    w.camera.cx += 1.3F, w.camera.fy *= 1.02F;
    if (c->settings.samples > 1) { // with one, none is scattered
        scatter_light(&w.gaussians, 8);
        ffp_gbuffer_add_scattered(&w.grad_gbuffer);
    }
    randomise_gbuffer(&w.grad_gbuffer, 11);
    for (int p = 0; p < PATTERNS; p++) {
        FfpImage pattern = random_image(PATTERN_WIDTH, PATTERN_HEIGHT, p == 1 ? 1 : 0, 20 + (uint64_t)p);
        if (p > 0) w.light[p] = ffp_summed_new(&pattern);
        w.grad_picture[p] = random_image(c->width, c->height, -1, 30 + (uint64_t)p);
        ffp_image_free(&pattern);
    }
    return w;
}

static void free_world(World *w) {
    ffp_gaussians_free(&w->gaussians);
    ffp_gbuffer_free(&w->grad_gbuffer);
    for (int p = 0; p < PATTERNS; p++) {
        ffp_summed_free(&w->light[p]);
        ffp_image_free(&w->grad_picture[p]);
    }
}

static void free_result(Result *r) {
    ffp_gbuffer_free(&r->gbuffer);
    ffp_gbuffer_free(&r->samples);
    ffp_mapping_free(&r->mapping);
    ffp_gaussians_free(&r->grad);
    for (int p = 0; p < PATTERNS; p++) ffp_image_free(&r->picture[p]);
}

// From the device's arrays or to them; what is of the host was made there.
static void move_gbuffer(const FfpGbuffer *there, const FfpGbuffer *host, bool up) {
    Field from[FIELDS], to[FIELDS];
    gbuffer_fields(there, from);
    gbuffer_fields(host, to);
    for (int k = 0; k < FIELDS; k++) {
        const size_t bytes = (size_t)from[k].count * sizeof(real);
        if (up)
            ffp_memory_upload(from[k].data, to[k].data, bytes);
        else
            ffp_memory_download(to[k].data, from[k].data, bytes);
    }
}

static FfpGbuffer downloaded_gbuffer(const FfpGbuffer *there) {
    const FfpDevice *before = ffp_device_use(NULL);
    FfpGbuffer host = ffp_gbuffer_new(there->width, there->height);
    if (there->scattered) ffp_gbuffer_add_scattered(&host);
    ffp_device_use(before);
    move_gbuffer(there, &host, false);
    return host;
}

static void mapping_fields(const FfpMapping *m, Field out[3]) {
    const int64_t n = (int64_t)m->width * m->height;
    out[0] = (Field){"uv", m->uv, 2 * n}, out[1] = (Field){"extent", m->extent, 2 * n};
    out[2] = (Field){"visibility", m->visibility, n};
}

static FfpMapping downloaded_mapping(const FfpMapping *there) {
    const FfpDevice *before = ffp_device_use(NULL);
    const FfpMapping host = ffp_mapping_new(there->width, there->height);
    Field from[3], to[3];
    ffp_device_use(before);
    mapping_fields(there, from);
    mapping_fields(&host, to);
    for (int k = 0; k < 3; k++)
        ffp_memory_download(to[k].data, from[k].data, (size_t)from[k].count * sizeof(real));
    return host;
}

static void use_mapping(const FfpMapping *there, const FfpMapping *host) {
    Field from[3], to[3];
    mapping_fields(host, from);
    mapping_fields(there, to);
    for (int k = 0; k < 3; k++)
        ffp_memory_upload(to[k].data, from[k].data, (size_t)from[k].count * sizeof(real));
}

// Fills planes that are to be written with what no result has.
static void poison(real *data, size_t count) {
    real *nans = ffp_alloc(count * sizeof *nans, 1);
    memset(nans, 0xff, count * sizeof *nans);
    ffp_memory_upload(data, nans, count * sizeof *nans);
    ffp_free(nans);
}

static void poison_samples(FfpViewPass *pass) {
    Field fields[FIELDS];
    gbuffer_fields(ffp_view_pass_samples(pass), fields);
    for (int k = 0; k < FIELDS; k++) poison(fields[k].data, (size_t)fields[k].count);
    mapping_fields(ffp_view_pass_mapping(pass), fields);
    for (int k = 0; k < 3; k++) poison(fields[k].data, (size_t)fields[k].count);
}

static void run_pictures(FfpViewPass *pass, const World *w, const FfpSummed *light, Result *r) {
    const real intensity[3] = {21, 19, 17};
    FfpImage picture = ffp_view_pass_picture_new(pass);
    for (int p = 0; p < PATTERNS; p++) {
        const size_t count = 3 * (size_t)picture.width * (size_t)picture.height;
        FfpImage grad = w->grad_picture[p];
        grad.data = ffp_memory_uploaded(grad.data, count, sizeof(real));
        poison(picture.data, count);
        ffp_view_pass_shade(pass, intensity, p ? &light[p] : NULL, &picture);
        r->picture[p] = picture;
        r->picture[p].data = ffp_alloc(count, sizeof(real));
        ffp_memory_download(r->picture[p].data, picture.data, count * sizeof(real));
        ffp_view_pass_shade_backward(pass, intensity, p ? &light[p] : NULL, &grad, NULL, NULL);
        ffp_image_free(&grad);
    }
    ffp_image_free(&picture);
}

// The whole pass; `mapping`: to be used in place of its own (NULL: its own).
static Result run_pass(const Case *c, const World *w, const FfpDevice *on, const FfpMapping *mapping) {
    ffp_device_use(on);
    Result r;
    FfpSummed light[PATTERNS] = {0};
    FfpGaussians g = ffp_gaussians_uploaded(&w->gaussians), few = g, grad = ffp_gaussians_new(g.count);
    FfpGbuffer shadow = {0};
    for (int p = 1; p < PATTERNS; p++) light[p] = ffp_summed_uploaded(&w->light[p]);
    FfpViewPass *pass = ffp_view_pass_new(&c->settings);
    few.count = g.count < 3 ? g.count : 3; // buffers must grow
    ffp_view_pass_draw(pass, &few, &w->camera, &w->projector);
    run_pictures(pass, w, light, &r); // leaves gradients that the next draw must clear
    for (int p = 0; p < PATTERNS; p++) ffp_free(r.picture[p].data);
    poison_samples(pass);
    if (c->keep_shadow) { // of the next draw, and kept for the one after
        ffp_view_pass_keep_shadow(pass, &shadow);
        ffp_view_pass_draw(pass, &g, &w->camera, &w->projector);
        poison_samples(pass);
    }
    ffp_view_pass_draw(pass, &g, &w->camera, &w->projector);
    r.samples = downloaded_gbuffer(ffp_view_pass_samples(pass));
    r.gbuffer = downloaded_gbuffer(ffp_view_pass_gbuffer(pass));
    r.mapping = downloaded_mapping(ffp_view_pass_mapping(pass));
    if (mapping) use_mapping(ffp_view_pass_mapping(pass), mapping);
    move_gbuffer(ffp_view_pass_grad_gbuffer(pass), &w->grad_gbuffer, true);
    run_pictures(pass, w, light, &r);
    ffp_view_pass_backward(pass, &grad);
    r.grad = ffp_gaussians_downloaded(&grad);
    ffp_view_pass_free(pass);
    ffp_gbuffer_free(&shadow);
    ffp_gaussians_free(&g);
    ffp_gaussians_free(&grad);
    for (int p = 0; p < PATTERNS; p++) ffp_summed_free(&light[p]);
    ffp_device_use(NULL);
    return r;
}

static void check_norm(const char *what, const Field *expected, const Field *got) {
    double difference = 0, norm = 0;
    assert_int_equal(expected->count, got->count);
    for (int64_t i = 0; i < expected->count; i++) {
        const double a = (double)expected->data[i], b = (double)got->data[i];
        assert_true(isfinite(a) && isfinite(b));
        difference += (a - b) * (a - b);
        norm += a * a;
    }
    const double share = sqrt(difference) / (sqrt(norm) + 1e-12);
    print_message("%s %s: %.2g of %.3g\n", what, expected->name, share, sqrt(norm));
    if (!(share < TOLERANCE)) fail_msg("%s %s is off by %.3g of its norm", what, expected->name, share);
}

static void check_mapping(const FfpMapping *expected, const FfpMapping *got) {
    Field a[3], b[3];
    mapping_fields(expected, a);
    mapping_fields(got, b);
    for (int k = 0; k < 3; k++) {
        int64_t differ = 0;
        for (int64_t i = 0; i < a[k].count; i++) {
            assert_true(isfinite(b[k].data[i]));
            const double off = fabs((double)a[k].data[i] - (double)b[k].data[i]);
            differ += off > MAPPED * (1 + fabs((double)a[k].data[i]));
        }
        print_message("mapping %s: %ld of %ld differ\n", a[k].name, (long)differ, (long)a[k].count);
        assert_true(differ <= 1 + (int64_t)(MAPPED_FEW * (double)a[k].count));
    }
}

static void check_results(const Result *expected, const Result *got) {
    Field a[FIELDS], b[FIELDS];
    gbuffer_fields(&expected->samples, a);
    gbuffer_fields(&got->samples, b);
    for (int k = 0; k < FIELDS; k++) check_norm("samples", &a[k], &b[k]);
    gbuffer_fields(&expected->gbuffer, a);
    gbuffer_fields(&got->gbuffer, b);
    for (int k = 0; k < FIELDS; k++) check_norm("gbuffer", &a[k], &b[k]);
    check_mapping(&expected->mapping, &got->mapping);
    for (int p = 0; p < PATTERNS; p++) {
        const int64_t n = 3 * (int64_t)expected->picture[p].width * expected->picture[p].height;
        const Field x = {"shaded", expected->picture[p].data, n}, y = {"shaded", got->picture[p].data, n};
        check_norm("picture", &x, &y);
    }
    gaussian_fields(&expected->grad, a);
    gaussian_fields(&got->grad, b);
    for (int k = 0; k < FIELDS; k++) check_norm("gradient of", &a[k], &b[k]);
}

static void check_same_bits(const Result *a, const Result *b) {
    Field x[FIELDS], y[FIELDS];
    gbuffer_fields(&a->samples, x);
    gbuffer_fields(&b->samples, y);
    for (int k = 0; k < FIELDS; k++)
        assert_memory_equal(x[k].data, y[k].data, (size_t)x[k].count * sizeof(real));
    gaussian_fields(&a->grad, x);
    gaussian_fields(&b->grad, y);
    for (int k = 0; k < FIELDS; k++)
        assert_memory_equal(x[k].data, y[k].data, (size_t)x[k].count * sizeof(real));
    for (int p = 0; p < PATTERNS; p++)
        assert_memory_equal(a->picture[p].data, b->picture[p].data,
                            3 * (size_t)a->picture[p].width * (size_t)a->picture[p].height * sizeof(real));
}

// The case is worth comparing: some of what is seen is lit, and some in shadow where there are shadows.
static void check_light(const Result *r, bool shadows) {
    int64_t lit = 0, dark = 0;
    for (int64_t i = 0; i < (int64_t)r->samples.width * r->samples.height; i++) {
        if (!(r->samples.opacity[i] > 0.5F)) continue;
        lit += r->mapping.visibility[i] > 0.5F;
        dark += r->mapping.visibility[i] < 0.5F;
    }
    assert_true(lit > 50 && (dark > 50 || !shadows));
}

static void check_case(const Case *c, bool twice) {
    if (!device) skip();
    print_message("%s\n", c->name);
    World w = new_world(c);
    Result cpu = run_pass(c, &w, NULL, NULL), gpu = run_pass(c, &w, device, &cpu.mapping);
    check_light(&cpu, c->settings.shadows);
    check_results(&cpu, &gpu);
    if (twice) {
        Result again = run_pass(c, &w, device, &cpu.mapping);
        check_same_bits(&gpu, &again);
        free_result(&again);
    }
    free_result(&cpu);
    free_result(&gpu);
    free_world(&w);
}

static Case ours(const char *name, int samples, int width, int height) {
    FfpRenderSettings settings = ffp_render_defaults();
    settings.samples = samples;
    settings.shadow_side = 61;
    return (Case){name, settings, width, height, 400, 0.08, false};
}

static void test_one_sample(void **state) {
    (void)state;
    const Case c = ours("ours, one sample", 1, 53, 37);
    check_case(&c, true);
}

static void test_two_samples(void **state) {
    (void)state;
    Case c = ours("ours, 2x2 samples, kept shadow", 2, 29, 21);
    c.keep_shadow = true;
    check_case(&c, true);
}

static void test_three_samples(void **state) {
    (void)state;
    Case c = ours("ours, 3x3 samples, no shadows, compensation", 3, 17, 15);
    c.settings.shadows = false, c.settings.compensation = true, c.settings.blur = 0.1F;
    check_case(&c, false);
}

static void test_papers_form(void **state) {
    (void)state;
    Case c = ours("paper's form", 1, 47, 33);
    c.settings = ffp_render_paper();
    c.scale = 0.3;
    check_case(&c, false);
}

// Splats behind the camera, none at all, and pictures smaller than a tile.
static void test_nothing_to_draw(void **state) {
    (void)state;
    if (!device) skip();
    const Case c = ours("nothing to draw", 2, 5, 3);
    World w = new_world(&c);
    for (int64_t i = 0; i < 3 * w.gaussians.count; i++) w.gaussians.centre[i] *= 0.1F;
    for (int64_t i = 0; i < w.gaussians.count; i++) w.gaussians.centre[3 * i] += 9;
    for (int k = 0; k < 2; k++) {
        Result r = run_pass(&c, &w, device, NULL);
        Field fields[FIELDS];
        gbuffer_fields(&r.samples, fields);
        for (int f = 0; f < FIELDS; f++)
            for (int64_t i = 0; i < fields[f].count; i++) assert_true(fields[f].data[i] == 0);
        gaussian_fields(&r.grad, fields);
        for (int f = 0; f < FIELDS; f++)
            for (int64_t i = 0; i < fields[f].count; i++) assert_true(fields[f].data[i] == 0);
        for (int p = 0; p < PATTERNS; p++)
            for (int i = 0; i < 3 * c.width * c.height; i++) assert_true(r.picture[p].data[i] == 0);
        free_result(&r);
        w.gaussians.count = 0;
    }
    free_world(&w);
}

static void test_training_size(void **state) {
    (void)state;
    if (!getenv("FFP_LARGE")) skip();
    Case c = ours("ours at training's size", 2, 128, 128);
    c.settings.shadow_side = 160;
    c.splats = 45000, c.scale = 0.012;
    check_case(&c, true);
}

int main(void) {
    FfpError err = {0};
    device = ffp_cuda_device(&err);
    print_message("%s\n", device ? ffp_cuda_describe() : err.text);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_one_sample),      cmocka_unit_test(test_two_samples),
        cmocka_unit_test(test_three_samples),   cmocka_unit_test(test_papers_form),
        cmocka_unit_test(test_nothing_to_draw), cmocka_unit_test(test_training_size)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
