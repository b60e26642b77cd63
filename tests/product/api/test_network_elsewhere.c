// Calls for programs that train the network or fit splats themselves: the weights, what the network sees of a
// capture, and the loss of pictures.
#include <math.h>
#include <string.h>
#include "core/base/rng.h"
#include "engine/loss/perceptual_net.h"
#include "random_perceptual.h"
#include "small.h"
#include "support.h"

static FfpError err;
static FfpCapture *capture;
static FfpModel *model;

static void test_weights_go_through_a_file(void **state) {
    (void)state;
    const FfpModelForm form = ffp_model_form(model);
    assert_string_equal(form.modules, "MTMT");
    assert_int_equal(form.dim, 128);
    const int n = ffp_model_weights_count(model);
    assert_true(n > 20);
    assert_null(ffp_model_weights(model, n).values);
    assert_null(ffp_model_weights(model, -1).name);
    const FfpWeights last = ffp_model_weights(model, n - 1), first = ffp_model_weights(model, 0);
    assert_string_equal(first.name, "tokeniser.weight");
    assert_int_equal(first.rows, form.dim);
    assert_int_equal(last.columns, 0);
    const float before = last.values[1];
    last.values[1] = 0.37F;
    assert_true(ffp_model_save(NULL, model, in_scratch("changed"), true, &err));
    FfpModel *back = ffp_model_open(NULL, in_scratch("changed"), NULL, &err);
    assert_non_null(back);
    for (int i = 0; i < n; i++) {
        const FfpWeights a = ffp_model_weights(model, i), b = ffp_model_weights(back, i);
        assert_string_equal(a.name, b.name);
        const int64_t count = a.rows * (a.columns ? a.columns : 1);
        assert_memory_equal(a.values, b.values, (size_t)count * sizeof *a.values);
    }
    ffp_model_close(back);
    last.values[1] = before;
    assert_false(ffp_model_save(NULL, NULL, in_scratch("none"), true, &err));
    assert_false(ffp_model_save(NULL, model, in_scratch("no/such/folder"), true, &err));
}

// The tokens of so small a capture are of its own pixels: what a Gaussian's pixel sees itself is a part of
// its token.
static void check_pixel(const FfpPreparedArrays *a, int64_t g, int patch) {
    const int pixels = patch * patch;
    float sum = 0;
    for (int t = 0; t < a->taps; t++) {
        const int row = a->row[g * a->taps + t];
        assert_in_range(row, 0, a->n_used * pixels - 1);
        sum += a->weight[g * a->taps + t];
    }
    assert_float_equal(sum, 1, 1e-6);
    const int row = a->row[g * a->taps];
    const float *seen =
        a->inputs + (int64_t)a->used[row / pixels] * a->token_width + (int64_t)(row % pixels) * a->channels;
    if (a->channels) assert_memory_equal(seen, a->own + g * a->channels, (size_t)a->channels * sizeof *seen);
    const float *ray = a->base + FFP_PREPARED_BASE * g + 3;
    assert_float_equal(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2], 1, 1e-5);
    const float *quaternion = ray + 8;
    float length = 0;
    for (int i = 0; i < 4; i++) length += quaternion[i] * quaternion[i];
    assert_float_equal(length, 1, 1e-5);
}

static void test_what_the_network_sees(void **state) {
    (void)state;
    const FfpReconstruction how = {.size = sizeof how, .model = model};
    FfpPrepared *prepared = ffp_prepare(NULL, capture, &how, &err);
    if (!prepared) fail_msg("%s", err.text);
    const FfpPreparedArrays a = ffp_prepared_arrays(prepared);
    const int patch = ffp_model_form(model).patch;
    assert_int_equal(a.tokens, SMALL_VIEWS * SMALL_SIDE * SMALL_SIDE / (patch * patch));
    assert_true(a.count > 50 && a.count <= SMALL_VIEWS * SMALL_SIDE * SMALL_SIDE);
    assert_null(a.context);
    for (int i = 1; i < a.n_used; i++) assert_true(a.used[i] > a.used[i - 1]);
    for (int64_t g = 0; g < a.count; g++) check_pixel(&a, g, patch);
    // An untrained residual network gives the classical initialisation, a Gaussian for each of these pixels.
    FfpGaussians *start = ffp_reconstruct(NULL, capture, &how, NULL, &err);
    assert_non_null(start);
    assert_true(ffp_gaussians_count(start) <= a.count);
    ffp_gaussians_close(start);
    ffp_prepared_close(prepared);
    ffp_prepared_close(NULL);
    assert_null(ffp_prepare(NULL, capture, &(FfpReconstruction){.size = sizeof(FfpReconstruction)}, &err));
    assert_non_null(strstr(err.text, "options.model"));
    assert_null(ffp_prepare(NULL, NULL, &how, &err));
}

enum { N = 2, W = 13, H = 9, VALUES = N * W * H * 3 };

static double loss_of(const float *pictures, const float *targets, double l1, double ssim, float *gradients) {
    const FfpPictureLoss given = {.count = N,
                                  .width = W,
                                  .height = H,
                                  .pictures = pictures,
                                  .targets = targets,
                                  .l1 = l1,
                                  .ssim = ssim,
                                  .gradients = gradients};
    double loss;
    if (!ffp_picture_loss(NULL, &given, &loss, &err)) fail_msg("%s", err.text);
    return loss;
}

static void test_losses_of_pictures(void **state) {
    (void)state;
    static float pictures[VALUES], targets[VALUES], gradients[VALUES];
    FfpRng rng = ffp_rng(5, 1);
    double mean = 0, slope = 0;
    for (int i = 0; i < VALUES; i++) {
        pictures[i] = (float)ffp_rng_uniform(&rng);
        targets[i] = (float)ffp_rng_uniform(&rng);
        mean += fabs((double)pictures[i] - (double)targets[i]) / VALUES;
        gradients[i] = 7; // replaced
    }
    assert_float_equal(loss_of(pictures, targets, 1, 0, NULL), mean, 1e-6);
    assert_float_equal(loss_of(pictures, pictures, 0.8, 0.2, NULL), 0, 1e-6);
    loss_of(pictures, targets, 0, 1, gradients);
    // Along the gradient's signs.
    const float step = 1e-3F;
    for (int i = 0; i < VALUES; i++) slope += fabs((double)gradients[i]);
    double ends[2];
    for (int s = 0; s < 2; s++) {
        static float moved[VALUES];
        for (int i = 0; i < VALUES; i++)
            moved[i] = pictures[i] + (s ? -step : step) * copysignf(1, gradients[i]);
        ends[s] = loss_of(moved, targets, 0, 1, NULL);
    }
    assert_float_equal((ends[0] - ends[1]) / (2 * (double)step), slope, 0.02 * slope);
    double loss;
    const FfpPictureLoss right = {
        .count = N, .width = W, .height = H, .pictures = pictures, .targets = targets, .l1 = 1};
    FfpPictureLoss none = right, wide = right, odd = right, nothing = right;
    none.count = 0, wide.width = 1 << 20, odd.l1 = NAN, nothing.pictures = NULL;
    assert_false(ffp_picture_loss(NULL, &none, &loss, &err));
    assert_false(ffp_picture_loss(NULL, &wide, &loss, &err));
    assert_false(ffp_picture_loss(NULL, &odd, &loss, &err));
    assert_non_null(strstr(err.text, "weights"));
    assert_false(ffp_picture_loss(NULL, &nothing, &loss, &err));
}

static void test_the_perceptual_term(void **state) {
    (void)state;
    static float pictures[VALUES], targets[VALUES], gradients[VALUES], moved[VALUES];
    FfpRng rng = ffp_rng(7, 1);
    FfpPerceptual *net = random_perceptual(FFP_PERCEPTUAL_VGG16);
    FfpPictureLoss how = {.count = N,
                          .width = W,
                          .height = H,
                          .pictures = pictures,
                          .targets = targets,
                          .gradients = gradients,
                          .perceptual = 3,
                          .network = net};
    double loss, alone = 0, slope = 0, ends[2];
    for (int i = 0; i < VALUES; i++) {
        pictures[i] = (float)ffp_rng_uniform(&rng);
        targets[i] = (float)ffp_rng_uniform(&rng);
    }
    for (int i = 0; i < N; i++) {
        const FfpImage a = {W, H, 3, pictures + i * VALUES / N}, b = {W, H, 3, targets + i * VALUES / N};
        alone += (double)ffp_perceptual_loss(net, &a, &b, 1, NULL) / N;
    }
    if (!ffp_picture_loss(NULL, &how, &loss, &err)) fail_msg("%s", err.text);
    assert_true(alone > 0);
    assert_float_equal(loss, 3 * alone, 1e-5 * alone);
    for (int i = 0; i < VALUES; i++) slope += fabs((double)gradients[i]);
    how.pictures = moved, how.gradients = NULL;
    for (int s = 0; s < 2; s++) {
        for (int i = 0; i < VALUES; i++)
            moved[i] = pictures[i] + (s ? -1e-3F : 1e-3F) * copysignf(1, gradients[i]);
        assert_true(ffp_picture_loss(NULL, &how, &ends[s], &err));
    }
    assert_float_equal((ends[0] - ends[1]) / 2e-3, slope, 0.03 * slope);
    how.network = NULL;
    assert_false(ffp_picture_loss(NULL, &how, &loss, &err));
    assert_non_null(strstr(err.text, "pictures.network"));
    how.network = net, how.perceptual = -1;
    assert_false(ffp_picture_loss(NULL, &how, &loss, &err));
    assert_non_null(strstr(err.text, "pictures.perceptual"));
    how.perceptual = 1, how.height = 1;
    assert_false(ffp_picture_loss(NULL, &how, &loss, &err));
    assert_non_null(strstr(err.text, "2 x 2"));
    ffp_perceptual_close(net);
    assert_null(ffp_perceptual_open(NULL, in_scratch("weights"), NULL, &err)); // those of the network
    assert_null(ffp_perceptual_open(NULL, "mine", &(FfpBytes){"{}", 2}, &err));
    assert_non_null(strstr(err.text, "mine"));
    assert_null(ffp_perceptual_open(NULL, NULL, NULL, &err));
    assert_int_equal(err.code, FFP_ERROR_ARGUMENT);
    ffp_perceptual_close(NULL);
}

static int setup(void **state) {
    if (small_setup(state) != 0) return -1;
    capture = ffp_capture_open(NULL, in_scratch("capture"), NULL, &err);
    model = ffp_model_open(NULL, in_scratch("weights"), NULL, &err);
    if (!capture || !model) fprintf(stderr, "%s\n", err.text);
    return capture && model ? 0 : -1;
}

static int teardown(void **state) {
    ffp_model_close(model);
    ffp_capture_close(capture);
    return scratch_teardown(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_weights_go_through_a_file),
        cmocka_unit_test(test_what_the_network_sees),
        cmocka_unit_test(test_losses_of_pictures),
        cmocka_unit_test(test_the_perceptual_term),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
