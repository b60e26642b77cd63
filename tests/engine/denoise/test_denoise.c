// Photographs made noisy, and cleaned again.
// Labels: threads
#include <math.h>
#include <omp.h>
#include "core/base/alloc.h"
#include "core/base/rng.h"
#include "engine/denoise/denoise.h"
#include "engine/denoise/stack.h"
#include "support.h"

static FfpCapture capture; // data/sample
static FfpImage *truth;    // its pictures, [n_views,n_patterns]
static int photographs[FFP_PHOTOGRAPHS];
static FfpError err;

static FfpImage *picture(FfpImage *lists, int view, int photograph) {
    return &lists[view * capture.n_patterns + photographs[photograph]];
}

static void keep_lists(void) {
    truth = ffp_alloc((size_t)(capture.n_views * capture.n_patterns), sizeof *truth);
    for (int i = 0; i < capture.n_views * capture.n_patterns; i++)
        truth[i] = ffp_image_copy(&capture.views[i / capture.n_patterns].images[i % capture.n_patterns]);
}

static int setup(void **state) {
    (void)state;
    if (!ffp_capture_read(&capture, FFP_SOURCE_DIR "/data/sample", &err)) return 1;
    photographs[0] = capture.black, photographs[1] = capture.white;
    photographs[2] = ffp_capture_active_pattern(&capture, NULL, &err);
    keep_lists();
    return photographs[2] < 0;
}

static int teardown(void **state) {
    (void)state;
    for (int i = 0; i < capture.n_views * capture.n_patterns; i++) ffp_image_free(&truth[i]);
    ffp_free(truth);
    ffp_capture_free(&capture);
    return 0;
}

// The truth with normal noise where the object covers; never below 0, as on a sensor.
static void make_noisy(double noise) {
    FfpRng rng = ffp_rng(7, 1);
    for (int v = 0; v < capture.n_views; v++)
        for (int p = 0; p < FFP_PHOTOGRAPHS; p++) {
            FfpImage *image = &capture.views[v].images[photographs[p]];
            const FfpImage *from = picture(truth, v, p);
            for (int i = 0; i < 3 * image->width * image->height; i++) {
                const real coverage = capture.views[v].coverage.data[i / 3];
                const real more = coverage > 0 ? (real)noise * ffp_rng_normal(&rng) : 0;
                image->data[i] = fmaxf(from->data[i] + more, 0);
            }
        }
}

static double psnr_encoded(int view, int photograph, const FfpImage *image) {
    const FfpImage *from = picture(truth, view, photograph);
    const int values = 3 * image->width * image->height;
    double square = 0;
    for (int i = 0; i < values; i++) {
        const double d = (double)ffp_srgb_encode(image->data[i]) - (double)ffp_srgb_encode(from->data[i]);
        square += d * d / values;
    }
    return -10 * log10(square);
}

static double mean_psnr(void) {
    double sum = 0;
    for (int v = 0; v < capture.n_views; v++)
        for (int p = 0; p < FFP_PHOTOGRAPHS; p++)
            sum += psnr_encoded(v, p, &capture.views[v].images[photographs[p]]);
    return sum / (capture.n_views * FFP_PHOTOGRAPHS);
}

// The mean PSNR after ffp_denoise; the capture gets its own lists back.
static double denoised_psnr(double noise) {
    FfpImage *own[FFP_VIEWS_MAX];
    for (int v = 0; v < capture.n_views; v++) own[v] = capture.views[v].images;
    FfpImage *lists = ffp_denoise(&capture, photographs, FFP_PHOTOGRAPHS, noise);
    const double psnr = mean_psnr();
    for (int v = 0; v < capture.n_views; v++) capture.views[v].images = own[v];
    ffp_denoise_free(lists, &capture, photographs, FFP_PHOTOGRAPHS);
    return psnr;
}

static void eigenvectors_make_the_matrix(void **state) {
    (void)state;
    FfpRng rng = ffp_rng(3, 1);
    for (int n = 1; n <= FFP_VALUES; n++) {
        double a[FFP_VALUES * FFP_VALUES], vectors[FFP_VALUES * FFP_VALUES], values[FFP_VALUES];
        for (int i = 0; i < n; i++)
            for (int j = 0; j <= i; j++) a[n * i + j] = a[n * j + i] = (double)ffp_rng_normal(&rng);
        memcpy(vectors, a, sizeof a);
        ffp_eigen(vectors, n, values);
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                double sum = 0;
                for (int k = 0; k < n; k++) sum += values[k] * vectors[n * k + i] * vectors[n * k + j];
                assert_float_equal(sum, a[n * i + j], 1e-12);
            }
        for (int k = 1; k < n; k++) assert_true(values[k] >= values[k - 1]);
    }
}

static void noise_is_estimated(void **state) {
    (void)state;
    make_noisy(0);
    const double clean = ffp_noise_estimate(&capture, photographs);
    printf("clean: %.4f\n", clean);
    assert_true(clean < 0.0025);
    const double levels[] = {0.005, 0.01, 0.02};
    for (int i = 0; i < 3; i++) {
        make_noisy(levels[i]);
        const double found = ffp_noise_estimate(&capture, photographs);
        printf("noise of %.3f: estimated %.4f\n", levels[i], found);
        assert_float_equal(found, levels[i], 0.15 * levels[i]);
    }
}

// Of plain photographs; below half of what rounding makes there is none.
static void hardly_any_noise_is_none(void **state) {
    (void)state;
    const double levels[2] = {0.0004, 0.001};
    for (int n = 0; n < 2; n++) {
        FfpRng rng = ffp_rng(5, 1);
        for (int v = 0; v < capture.n_views; v++)
            for (int p = 0; p < FFP_PHOTOGRAPHS; p++) {
                FfpImage *image = &capture.views[v].images[photographs[p]];
                for (int i = 0; i < 3 * image->width * image->height; i++)
                    image->data[i] = capture.views[v].coverage.data[i / 3] *
                                     (0.2F + 0.3F * (real)p + (real)levels[n] * ffp_rng_normal(&rng));
            }
        const double found = ffp_noise_estimate(&capture, photographs);
        printf("noise of %.4f: estimated %.5f\n", levels[n], found);
        assert_float_equal(found, n ? levels[n] : 0, n ? 0.2 * levels[n] : 0);
    }
}

static void noise_is_taken_away(void **state) {
    (void)state;
    make_noisy(0.01);
    const double noisy = mean_psnr(), clean = denoised_psnr(0.01);
    printf("noise of 1 %%: %.2f dB, without it %.2f dB\n", noisy, clean);
    assert_true(clean > noisy + 3);
    make_noisy(0);
    const double kept = denoised_psnr(ffp_noise_estimate(&capture, photographs));
    printf("clean pictures: %.2f dB of themselves\n", kept);
    assert_true(kept > 48);
}

static void threads_make_no_difference(void **state) {
    (void)state;
    make_noisy(0.01);
    const int threads = omp_get_max_threads();
    omp_set_num_threads(1);
    const double one = denoised_psnr(0.01);
    omp_set_num_threads(3);
    const double three = denoised_psnr(0.01);
    omp_set_num_threads(threads);
    assert_true(one == three);
}

static void background_stays(void **state) {
    (void)state;
    make_noisy(0.01);
    FfpImage *own[FFP_VIEWS_MAX];
    for (int v = 0; v < capture.n_views; v++) own[v] = capture.views[v].images;
    FfpImage *lists = ffp_denoise(&capture, photographs, FFP_PHOTOGRAPHS, 0.01);
    const FfpImage *image = picture(lists, 0, 1), *before = &own[0][photographs[1]];
    for (int i = 0; i < 3 * image->width * image->height; i++) {
        assert_true(image->data[i] >= 0);
        if (capture.views[0].coverage.data[i / 3] > 0) continue;
        assert_true(image->data[i] == before->data[i]);
    }
    for (int v = 0; v < capture.n_views; v++) capture.views[v].images = own[v];
    ffp_denoise_free(lists, &capture, photographs, FFP_PHOTOGRAPHS);
}

static void a_view_without_a_photograph_is_left_alone(void **state) {
    (void)state;
    make_noisy(0.01);
    FfpImage *own[FFP_VIEWS_MAX];
    for (int v = 0; v < capture.n_views; v++) own[v] = capture.views[v].images;
    real *black = own[0][capture.black].data;
    own[0][capture.black].data = NULL;
    assert_true(ffp_noise_estimate(&capture, photographs) > 0.008);
    FfpImage *lists = ffp_denoise(&capture, photographs, FFP_PHOTOGRAPHS, 0.01);
    assert_true(capture.views[0].images == own[0]);
    assert_true(capture.views[1].images != own[1]);
    for (int v = 0; v < capture.n_views; v++) capture.views[v].images = own[v];
    ffp_denoise_free(lists, &capture, photographs, FFP_PHOTOGRAPHS);
    own[0][capture.black].data = black;
}

// Further photographs are cleaned with black and white, each by itself, where a view has them.
static void further_photographs_are_cleaned_where_they_are(void **state) {
    (void)state;
    enum { MORE = 2 };
    make_noisy(0.01);
    const int several[FFP_PHOTOGRAPHS + MORE] = {photographs[0], photographs[1], photographs[2],
                                                 ffp_capture_find_pattern(&capture, "lollipop_3"),
                                                 ffp_capture_find_pattern(&capture, "lollipop_5")};
    const int instead[FFP_PHOTOGRAPHS] = {photographs[0], photographs[1], several[4]};
    FfpImage *own[FFP_VIEWS_MAX], lacking;
    for (int v = 0; v < capture.n_views; v++) own[v] = capture.views[v].images;
    lacking = own[1][several[3]], own[1][several[3]] = (FfpImage){0};
    FfpImage *lists = ffp_denoise(&capture, several, FFP_PHOTOGRAPHS + MORE, 0.01);
    for (int v = 0; v < capture.n_views; v++) capture.views[v].images = own[v];
    FfpImage *alone = ffp_denoise(&capture, instead, FFP_PHOTOGRAPHS, 0.01);
    for (int v = 0; v < capture.n_views; v++) {
        FfpImage *of_view = lists + (ptrdiff_t)v * capture.n_patterns;
        const FfpImage *last = &of_view[several[4]];
        const size_t bytes = 3 * sizeof(real) * (size_t)last->width * (size_t)last->height;
        assert_true((of_view[several[3]].data == NULL) == (v == 1));
        assert_memory_equal(last->data, alone[v * capture.n_patterns + several[4]].data, bytes);
        assert_memory_not_equal(last->data, own[v][several[4]].data, bytes);
        capture.views[v].images = own[v];
    }
    ffp_denoise_free(lists, &capture, several, FFP_PHOTOGRAPHS + MORE);
    ffp_denoise_free(alone, &capture, instead, FFP_PHOTOGRAPHS);
    own[1][several[3]] = lacking;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(eigenvectors_make_the_matrix),
        cmocka_unit_test(noise_is_estimated),
        cmocka_unit_test(hardly_any_noise_is_none),
        cmocka_unit_test(noise_is_taken_away),
        cmocka_unit_test(threads_make_no_difference),
        cmocka_unit_test(a_view_without_a_photograph_is_left_alone),
        cmocka_unit_test(further_photographs_are_cleaned_where_they_are),
        cmocka_unit_test(background_stays),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
