// The losses on the device against those on the CPU: values and gradients on odd sizes, and the same bits
// whenever they are taken. With FFP_LARGE set: pictures of training's size too.
#include <math.h>
#include "core/base/arena.h"
#include "core/base/rng.h"
#include "engine/cuda/cuda.h"
#include "engine/cuda/perceptual_conv.h"
#include "engine/loss/metrics.h"
#include "engine/loss/perceptual_net.h"
#include "random_perceptual.h"
#include "support.h"

enum { INPUTS = 4, GRADS = 2 };

typedef struct Problem {
    int width, height, channels;
    real weight; // of the order of the pixels: slopes of the order of 1 survive being added to something
    const FfpPerceptual *net;
    real *input[INPUTS]; // on the host; NULL: not used
    size_t inputs[INPUTS], grads[GRADS];
} Problem;

// A function under test: value, and gradients unless they are NULL.
typedef double (*Term)(const Problem *p, real *const *input, real *const *grad);

typedef struct Result {
    double value;
    real *grad[GRADS];
} Result;

static const FfpDevice *device;

static int set_up(void **state) {
    (void)state;
    FfpError err = {0};
    device = ffp_cuda_device(&err);
    print_message("%s\n", device ? ffp_cuda_describe() : err.text);
    return 0;
}

static real *random_values(size_t count, uint64_t seed, float low, float high) {
    FfpRng rng = ffp_rng(seed, 7);
    real *values = ffp_alloc(count, sizeof *values);
    for (size_t i = 0; i < count; i++) values[i] = ffp_rng_range(&rng, low, high);
    return values;
}

static Problem new_problem(int width, int height, int channels) {
    return (Problem){
        .width = width, .height = height, .channels = channels, .weight = 0.7F * (real)(width * height)};
}

static void set_input(Problem *p, int which, size_t count, uint64_t seed, float low, float high) {
    p->input[which] = random_values(count, seed, low, high);
    p->inputs[which] = count;
}

static void free_problem(Problem *p) {
    for (int i = 0; i < INPUTS; i++) ffp_free(p->input[i]);
}

// The initial values of the gradients.
static real *start_of(const Problem *p, int which) {
    return random_values(p->grads[which], 100 + which, -1, 1);
}

// On the device in use. wanted: bit k for gradient k.
static Result result_of(Term term, const Problem *p, unsigned wanted) {
    Result result = {.value = 0};
    real *input[INPUTS], *grad[GRADS] = {NULL};
    for (int i = 0; i < INPUTS; i++) input[i] = ffp_memory_uploaded(p->input[i], p->inputs[i], sizeof(real));
    for (int k = 0; k < GRADS; k++) {
        if (!p->grads[k] || !(wanted >> k & 1)) continue;
        result.grad[k] = start_of(p, k);
        grad[k] = ffp_memory_uploaded(result.grad[k], p->grads[k], sizeof(real));
    }
    result.value = term(p, input, grad);
    for (int k = 0; k < GRADS; k++) {
        if (grad[k]) ffp_memory_download(result.grad[k], grad[k], p->grads[k] * sizeof(real));
        ffp_memory_free(grad[k]);
    }
    for (int i = 0; i < INPUTS; i++) ffp_memory_free(input[i]);
    return result;
}

static Result on_device(Term term, const Problem *p, unsigned wanted) {
    ffp_device_use(device);
    const Result result = result_of(term, p, wanted);
    ffp_device_use(NULL);
    return result;
}

static void free_result(Result *result) {
    for (int k = 0; k < GRADS; k++) ffp_free(result->grad[k]);
}

static void expect_same_bits(const char *what, const Problem *p, const Result *a, const Result *b) {
    if (memcmp(&a->value, &b->value, sizeof a->value) != 0) fail_msg("%s: another value", what);
    for (int k = 0; k < GRADS; k++)
        if (a->grad[k] && b->grad[k] && memcmp(a->grad[k], b->grad[k], p->grads[k] * sizeof(real)) != 0)
            fail_msg("%s: another gradient %d", what, k);
}

// Differences relative to the value and, for gradients, to the largest slope; `mean` is a bound of their
// root mean square relative to that of the slopes.
typedef struct Tolerance {
    double value, largest, mean;
} Tolerance;

static void compare_gradient(const char *what, const Problem *p, int k, const real *truth, const real *got,
                             const Tolerance *tolerance) {
    real *start = start_of(p, k);
    double slope = 0, error = 0, squares = 0, errors = 0;
    for (size_t i = 0; i < p->grads[k]; i++) {
        const double s = (double)truth[i] - start[i], e = (double)got[i] - truth[i];
        if (!isfinite(got[i])) fail_msg("%s: gradient %d is not finite at %zu", what, k, i);
        slope = fmax(slope, fabs(s)), error = fmax(error, fabs(e));
        squares += s * s, errors += e * e;
    }
    ffp_free(start);
    print_message("  %s, gradient %d: largest %.3g, error %.2g, in the mean %.2g\n", what, k, slope,
                  error / slope, sqrt(errors / squares));
    if (!(error <= tolerance->largest * slope) || !(errors <= tolerance->mean * tolerance->mean * squares))
        fail_msg("%s: gradient %d differs", what, k);
}

static void check_to(const char *what, Term term, const Problem *p, Tolerance tolerance) {
    if (!device) skip();
    Result truth = result_of(term, p, 3), got = on_device(term, p, 3);
    print_message("%s %dx%dx%d: %.8g, on the CPU %.8g\n", what, p->width, p->height, p->channels, got.value,
                  truth.value);
    if (!(fabs(got.value - truth.value) <= tolerance.value * fabs(truth.value)))
        fail_msg("%s: another value", what);
    for (int k = 0; k < GRADS; k++)
        if (p->grads[k]) compare_gradient(what, p, k, truth.grad[k], got.grad[k], &tolerance);
    for (unsigned wanted = 0; wanted < 4; wanted++) { // 3: all of it again
        Result again = on_device(term, p, wanted);
        expect_same_bits(what, p, &got, &again);
        free_result(&again);
    }
    free_result(&truth);
    free_result(&got);
}

static void check(const char *what, Term term, const Problem *p) {
    check_to(what, term, p, (Tolerance){1e-4, 1e-4, 1e-4});
}

// --- Pictures. ---

static FfpImage picture(const Problem *p, real *data) {
    return (FfpImage){p->width, p->height, p->channels, data};
}

static double l1(const Problem *p, real *const *input, real *const *grad) {
    const FfpImage a = picture(p, input[0]), b = picture(p, input[1]);
    FfpImage g = picture(p, grad[0]);
    return ffp_l1_loss(&a, &b, p->weight, g.data ? &g : NULL);
}

static double square(const Problem *p, real *const *input, real *const *grad) {
    const FfpImage a = picture(p, input[0]), b = picture(p, input[1]);
    FfpImage g = picture(p, grad[0]);
    return ffp_square_loss(&a, &b, p->weight, g.data ? &g : NULL);
}

static double ssim_loss(const Problem *p, real *const *input, real *const *grad) {
    const FfpImage a = picture(p, input[0]), b = picture(p, input[1]);
    FfpImage g = picture(p, grad[0]);
    return ffp_ssim_loss(&a, &b, p->weight, g.data ? &g : NULL);
}

static double ssim(const Problem *p, real *const *input, real *const *grad) {
    (void)grad;
    const FfpImage a = picture(p, input[0]), b = picture(p, input[1]);
    return ffp_ssim(&a, &b);
}

static double psnr(const Problem *p, real *const *input, real *const *grad) {
    (void)grad;
    const FfpImage a = picture(p, input[0]), b = picture(p, input[1]);
    return ffp_psnr(&a, &b);
}

static double psnr_masked(const Problem *p, real *const *input, real *const *grad) {
    (void)grad;
    const FfpImage a = picture(p, input[0]), b = picture(p, input[1]);
    const FfpImage mask = {p->width, p->height, 1, input[2]};
    return ffp_psnr_masked(&a, &b, &mask);
}

// In place: the "gradient" is the picture.
static double to_srgb(const Problem *p, real *const *input, real *const *grad) {
    (void)input;
    FfpImage image = picture(p, grad[0]);
    if (image.data) ffp_image_to_srgb(&image);
    return 0;
}

static double to_linear(const Problem *p, real *const *input, real *const *grad) {
    (void)input;
    FfpImage image = picture(p, grad[0]);
    if (image.data) ffp_image_to_linear(&image);
    return 0;
}

static void check_pictures(int width, int height, int channels) {
    Problem p = new_problem(width, height, channels);
    const size_t values = (size_t)width * height * channels;
    set_input(&p, 0, values, 1, -0.1F, 1.2F);
    set_input(&p, 1, values, 2, -0.1F, 1.1F);
    set_input(&p, 2, (size_t)width * height, 3, 0, 1);
    for (size_t i = 0; i < values; i += 7) p.input[1][i] = p.input[0][i]; // no slope there
    p.weight *= (real)channels;
    p.grads[0] = values;
    check("l1", l1, &p);
    check("squares", square, &p);
    check("SSIM loss", ssim_loss, &p);
    check("to sRGB", to_srgb, &p);
    check("to linear", to_linear, &p);
    p.grads[0] = 0;
    check("SSIM", ssim, &p);
    check("PSNR", psnr, &p);
    check("PSNR, masked", psnr_masked, &p);
    free_problem(&p);
}

static void test_pictures(void **state) {
    (void)state;
    check_pictures(37, 29, 3);
    check_pictures(16, 33, 1);
    check_pictures(3, 2, 4);
    if (getenv("FFP_LARGE")) check_pictures(128, 128, 3), check_pictures(511, 257, 3);
}

// Equal pictures: SSIM 1, no slope to speak of; PSNR at its cap; nothing under a mask: NaN, as on the CPU.
static void test_equal_pictures(void **state) {
    (void)state;
    if (!device) skip();
    Problem p = new_problem(19, 13, 3);
    for (int i = 0; i < 2; i++) set_input(&p, i, 19 * 13 * 3, 4, 0, 1);
    set_input(&p, 2, 19 * 13, 5, 0, 0.5F);
    assert_true(fabs(on_device(ssim, &p, 0).value - 1) < 1e-6);
    assert_true(on_device(l1, &p, 0).value == 0);
    assert_true(on_device(psnr, &p, 0).value == FFP_PSNR_CAP);
    assert_true(isnan(on_device(psnr_masked, &p, 0).value));
    p.input[0][50] = NAN;
    assert_true(isnan(on_device(psnr, &p, 0).value));
    free_problem(&p);
}

// --- Maps. ---

static double mask(const Problem *p, real *const *input, real *const *grad) {
    return ffp_mask_loss(input[0], input[1], p->width * p->height, p->weight, grad[0]);
}

static double depth(const Problem *p, real *const *input, real *const *grad) {
    return ffp_depth_loss(input[2], input[0], input[3], p->width * p->height, p->weight, grad[0], grad[1]);
}

static double distortion(const Problem *p, real *const *input, real *const *grad) {
    return ffp_distortion_loss(input[2], p->width * p->height, p->weight, grad[0]);
}

static double normal_smooth(const Problem *p, real *const *input, real *const *grad) {
    return ffp_normal_smooth_loss(input[2], input[1], p->width, p->height, p->weight, grad[0]);
}

static double roughness(const Problem *p, real *const *input, real *const *grad) {
    return ffp_roughness_loss(input[3], input[2], input[0], input[1], p->width, p->height, p->weight, grad[0],
                              grad[1]);
}

// A mask with holes, an empty band and the rest full or soft.
static void cut_mask(real *values, int width, int height) {
    for (int i = 0; i < width * height; i++) {
        const int y = i / width;
        values[i] = i % 5 == 0 ? 0.3F * values[i] : fminf(1, 0.6F + values[i]);
        if (2 * y >= height && 3 * y < 2 * height) values[i] = 0;
    }
}

// Opacity and mask; input 2 of so many channels; input 3.
static Problem new_maps(int width, int height, int channels, float low, float high) {
    Problem p = new_problem(width, height, channels);
    const size_t pixels = (size_t)width * height;
    set_input(&p, 0, pixels, 11, -0.05F, 1.05F); // a rasteriser's may pass 1 by rounding
    set_input(&p, 1, pixels, 12, 0, 1);
    set_input(&p, 2, pixels * channels, 13, low, high);
    set_input(&p, 3, pixels, 14, 0.01F, 1);
    cut_mask(p.input[1], width, height);
    p.grads[0] = pixels;
    return p;
}

static void check_maps(int width, int height) {
    Problem p = new_maps(width, height, 1, 1, 3);
    check("mask", mask, &p);
    check("distortion", distortion, &p);
    for (int i = 0; i < width * height; i += 3) p.input[3][i] = -1; // no truth
    p.grads[1] = p.grads[0];
    check("depth", depth, &p);
    free_problem(&p);
    p = new_maps(width, height, 3, -0.5F, 0.5F);
    p.grads[0] *= 3;
    if (width > 3) p.input[2][9] = p.input[2][10] = p.input[2][11] = 0;
    check("normal smoothness", normal_smooth, &p);
    free_problem(&p);
    p = new_maps(width, height, 3, 0, 1);
    p.grads[1] = p.grads[0];
    check("roughness", roughness, &p);
    free_problem(&p);
}

static void test_maps(void **state) {
    (void)state;
    check_maps(37, 29);
    check_maps(5, 61);
    if (getenv("FFP_LARGE")) check_maps(128, 128), check_maps(511, 257);
}

// The value is 0 and the gradients keep their bits.
static void expect_nothing(const char *what, Term term, const Problem *p) {
    Result result = on_device(term, p, 3);
    if (result.value != 0) fail_msg("%s: a value of nothing", what);
    for (int k = 0; k < GRADS; k++) {
        real *start = start_of(p, k);
        if (p->grads[k]) assert_memory_equal(result.grad[k], start, p->grads[k] * sizeof(real));
        ffp_free(start);
    }
    free_result(&result);
}

static void test_nothing_counts(void **state) {
    (void)state;
    if (!device) skip();
    Problem p = new_maps(23, 9, 3, -0.5F, 0.5F);
    for (int i = 0; i < 23 * 9; i++) p.input[1][i] = 0, p.input[3][i] = 0; // no mask, no true depth
    p.grads[1] = p.grads[0];
    expect_nothing("depth", depth, &p);
    expect_nothing("roughness", roughness, &p);
    p.grads[0] *= 3;
    expect_nothing("normal smoothness", normal_smooth, &p);
    free_problem(&p);
}

// --- Perceptual networks. ---

static double perceptual(const Problem *p, real *const *input, real *const *grad) {
    const FfpImage a = picture(p, input[0]), b = {p->width, p->height, 3, input[1]};
    FfpImage g = picture(p, grad[0]);
    return ffp_perceptual_loss(p->net, &a, &b, p->weight, g.data ? &g : NULL);
}

// Rounding that shuts or opens a ReLU, or moves the largest value of a pool, changes single slopes by much:
// so the bound of single ones is loose. TF32 does that to about a thousandth of the activations.
static void check_network(FfpPerceptual *net, int width, int height, int channels) {
    Problem p = new_problem(width, height, channels);
    p.net = net;
    p.grads[0] = (size_t)width * height * channels;
    set_input(&p, 0, p.grads[0], 21, 0, 1);
    set_input(&p, 1, (size_t)width * height * 3, 22, 0, 1);
    ffp_cuda_conv_exact(true);
    check_to("perceptual", perceptual, &p, (Tolerance){1e-4, 2e-2, 2e-3});
    ffp_cuda_conv_exact(false);
    check_to("perceptual, TF32", perceptual, &p, (Tolerance){2e-3, 0.5, 0.1});
    free_problem(&p);
}

static void test_perceptual(void **state) {
    (void)state;
    if (!device) skip();
    const int sizes[][2] = {{39, 35}, {23, 27}, {13, 9}};
    for (int kind = FFP_PERCEPTUAL_ALEX; kind <= FFP_PERCEPTUAL_VGG16; kind++) {
        FfpPerceptual *net = random_perceptual(kind);
        check_network(net, sizes[kind][0], sizes[kind][1], 3 + kind % 2);
        if (getenv("FFP_LARGE")) check_network(net, 128, 128, 3), check_network(net, 253, 131, 3);
        Problem p = new_problem(40, ffp_perceptual_least_side(net) - 1, 3);
        p.net = net;
        p.grads[0] = (size_t)p.width * p.height * 3;
        for (int i = 0; i < 2; i++) set_input(&p, i, p.grads[0], i, 0, 1);
        expect_nothing("too small a picture", perceptual, &p);
        free_problem(&p);
        ffp_perceptual_free(net);
    }
}

// --- Convolution and pooling, with unfolded input in strips. ---

static const FfpConv convolutions[] = {
    {.in = 3, .out = 5, .kernel = 3, .stride = 1, .pad = 1, .width = 37, .height = 29},
    {.in = 2, .out = 4, .kernel = 3, .stride = 2, .pad = 0, .width = 70, .height = 23},
    {.in = 3, .out = 2, .kernel = 11, .stride = 4, .pad = 2, .width = 101, .height = 47},
    {.in = 7, .out = 3, .kernel = 1, .stride = 1, .pad = 0, .width = 61, .height = 9},
    {.in = 2, .out = 2, .kernel = 5, .stride = 1, .pad = 2, .width = 2, .height = 1},
};
enum { CONVOLUTIONS = sizeof convolutions / sizeof *convolutions };

// [images, channels, pixels] to [channels, images, pixels].
static real *by_channel(const real *values, int channels, int images, size_t pixels) {
    real *turned = ffp_alloc((size_t)channels * images * pixels, sizeof *turned);
    for (int c = 0; c < channels; c++)
        for (int i = 0; i < images; i++)
            memcpy(turned + ((size_t)c * images + i) * pixels, values + ((size_t)i * channels + c) * pixels,
                   pixels * sizeof *turned);
    return turned;
}

static void expect_near(const char *what, const real *truth, const real *there, size_t count) {
    real *got = ffp_alloc(count, sizeof *got);
    ffp_memory_download(got, there, count * sizeof *got);
    for (size_t i = 0; i < count; i++)
        if (!(fabsf(got[i] - truth[i]) < 1e-4F)) fail_msg("%s at %zu: %g, not %g", what, i, got[i], truth[i]);
    ffp_free(got);
}

// Two images forward, the first one back, with room for `pixels` output pixels of unfolded input.
static void check_convolution(const FfpConv *s, size_t pixels, bool add) {
    const size_t in = (size_t)s->width * s->height, depth = (size_t)s->in * s->kernel * s->kernel;
    const size_t out = (size_t)ffp_conv_side(s->width, s->kernel, s->stride, s->pad) *
                       ffp_conv_side(s->height, s->kernel, s->stride, s->pad);
    real *x = random_values(2 * s->in * in, 1, -1, 1), *w = random_values(s->out * depth, 2, -1, 1);
    real *bias = random_values(s->out, 3, -1, 1), *dy = random_values(s->out * out, 4, -1, 1);
    real *dx = random_values(s->in * in, 5, -1, 1), *y = ffp_alloc(2 * s->out * out, sizeof *y);
    real *turned_x = by_channel(x, s->in, 2, in);
    ffp_conv2d_forward(y, s->out * out, x, s->in * in, w, bias, s, 2);
    real *turned_y = by_channel(y, s->out, 2, out);
    ffp_device_use(device);
    const FfpColumns columns = {ffp_memory_new(depth * pixels, sizeof(real)), depth * pixels};
    real *there_x = ffp_memory_uploaded(turned_x, 2 * s->in * in, sizeof *x);
    real *there_w = ffp_memory_uploaded(w, s->out * depth, sizeof *w);
    real *there_bias = ffp_memory_uploaded(bias, s->out, sizeof *bias);
    real *there_y = device->alloc(2 * s->out * out * sizeof *y);
    real *there_dy = ffp_memory_uploaded(dy, s->out * out, sizeof *dy);
    real *there_dx = ffp_memory_uploaded(dx, s->in * in, sizeof *dx);
    ffp_cuda_picture_conv_forward(there_y, there_x, there_w, s, 2, columns);
    ffp_cuda_bias_relu(there_y, there_bias, s->out, 2 * out);
    expect_near("convolution", turned_y, there_y, 2 * s->out * out);
    ffp_cuda_relu_backward(there_dy, there_y, s->out, 2, out);
    ffp_cuda_picture_conv_backward(there_dx, there_dy, there_w, s, add, columns);
    for (size_t i = 0; i < s->in * in && !add; i++) dx[i] = 0;
    ffp_device_use(NULL);
    ffp_conv2d_backward(dx, dy, y, w, s);
    ffp_device_use(device);
    expect_near("its gradient", dx, there_dx, s->in * in);
    real *all[] = {there_x, there_w, there_bias, there_y, there_dy, there_dx, columns.values};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) ffp_memory_free(all[i]);
    ffp_device_use(NULL);
    ffp_free(x), ffp_free(w), ffp_free(bias), ffp_free(y), ffp_free(dy), ffp_free(dx), ffp_free(turned_x),
        ffp_free(turned_y);
}

static void test_convolution(void **state) {
    (void)state;
    if (!device) skip();
    ffp_cuda_conv_exact(true);
    for (int i = 0; i < CONVOLUTIONS; i++) {
        check_convolution(&convolutions[i], 5000, false);
        check_convolution(&convolutions[i], 300, true);
        check_convolution(&convolutions[i], 41, false);
    }
    ffp_cuda_conv_exact(false);
}

static void check_pool(const FfpPool *pool, bool add) {
    const int width = ffp_pool_side(pool->width, pool->kernel, pool->stride, pool->round_up);
    const int height = ffp_pool_side(pool->height, pool->kernel, pool->stride, pool->round_up);
    const size_t in = (size_t)pool->width * pool->height, out = (size_t)width * height;
    const int channels = pool->channels;
    real *x = random_values(2 * channels * in, 1, -2, 2), *dy = random_values(channels * out, 2, -1, 1);
    real *dx = random_values(channels * in, 3, -1, 1), *y = ffp_alloc(2 * channels * out, sizeof *y);
    for (size_t i = 0; i < 2 * channels * in; i++) x[i] = fmaxf(0, roundf(x[i])); // ties
    real *turned = by_channel(x, channels, 2, in);
    FfpPool both = *pool;
    both.channels *= 2;
    ffp_maxpool_forward(y, turned, &both);
    ffp_device_use(device);
    real *there_x = ffp_memory_uploaded(turned, 2 * channels * in, sizeof *x);
    real *there_y = device->alloc(2 * channels * out * sizeof *y);
    real *there_dy = ffp_memory_uploaded(dy, channels * out, sizeof *dy);
    real *there_dx = ffp_memory_uploaded(dx, channels * in, sizeof *dx);
    ffp_cuda_maxpool_forward(there_y, there_x, pool, 2);
    expect_near("pool", y, there_y, 2 * channels * out);
    ffp_cuda_maxpool_backward(there_dx, there_dy, there_x, pool, 2, add);
    for (size_t i = 0; i < channels * in && !add; i++) dx[i] = 0;
    ffp_device_use(NULL);
    ffp_maxpool_backward(dx, dy, x, pool);
    ffp_device_use(device);
    expect_near("its gradient", dx, there_dx, channels * in);
    real *all[] = {there_x, there_y, there_dy, there_dx};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) ffp_memory_free(all[i]);
    ffp_device_use(NULL);
    ffp_free(x), ffp_free(y), ffp_free(dy), ffp_free(dx), ffp_free(turned);
}

static void test_pool(void **state) {
    (void)state;
    if (!device) skip();
    const FfpPool pools[] = {
        {.channels = 3, .kernel = 3, .stride = 2, .round_up = true, .width = 24, .height = 17},
        {.channels = 5, .kernel = 3, .stride = 2, .round_up = false, .width = 18, .height = 31},
        {.channels = 2, .kernel = 2, .stride = 2, .round_up = false, .width = 15, .height = 8},
    };
    for (size_t i = 0; i < sizeof pools / sizeof *pools; i++)
        check_pool(&pools[i], false), check_pool(&pools[i], true);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pictures),    cmocka_unit_test(test_equal_pictures),
        cmocka_unit_test(test_maps),        cmocka_unit_test(test_nothing_counts),
        cmocka_unit_test(test_convolution), cmocka_unit_test(test_pool),
        cmocka_unit_test(test_perceptual),
    };
    return cmocka_run_group_tests(tests, set_up, NULL);
}
