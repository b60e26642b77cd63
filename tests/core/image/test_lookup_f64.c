// Summed-area lookups against sums pixel by pixel, and their gradients against central differences.
#include <math.h>
#include <omp.h>
#include "core/base/rng.h"
#include "core/image/lookup_box.h"
#include "support.h"

enum { WIDTH = 13, HEIGHT = 9 };

static FfpImage random_pattern(uint64_t seed) {
    FfpRng rng = ffp_rng(seed, 0);
    FfpImage pattern = ffp_image_new(WIDTH, HEIGHT, 3);
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++) pattern.data[i] = ffp_rng_uniform(&rng);
    return pattern;
}

// Overlap of [low, high] with pixel i.
static double overlap(double low, double high, int i) {
    return fmax(0, fmin(high, i + 1.0) - fmax(low, (double)i));
}

static void mean_by_pixels(const FfpImage *pattern, double u, double v, double du, double dv, double out[3]) {
    du = fmax(du, 1);
    dv = fmax(dv, 1);
    out[0] = out[1] = out[2] = 0;
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            const double area = overlap(u - du / 2, u + du / 2, x) * overlap(v - dv / 2, v + dv / 2, y);
            for (int c = 0; c < 3; c++) out[c] += area * pattern->data[(y * WIDTH + x) * 3 + c] / (du * dv);
        }
    }
}

// Boxes inside, across the edges, around everything, and outside.
static void random_box(FfpRng *rng, double box[4]) {
    box[0] = ffp_rng_range(rng, -3, WIDTH + 3);
    box[1] = ffp_rng_range(rng, -3, HEIGHT + 3);
    box[2] = ffp_rng_range(rng, 0.2F, 9);
    box[3] = ffp_rng_below(rng, 8) == 0 ? 40 : ffp_rng_range(rng, 0.2F, 6);
}

static void lookup_is_the_mean(void **state) {
    (void)state;
    FfpImage pattern = random_pattern(1);
    FfpSummed summed = ffp_summed_new(&pattern);
    FfpRng rng = ffp_rng(2, 0);
    for (int k = 0; k < 500; k++) {
        double box[4], want[3], got[3];
        random_box(&rng, box);
        mean_by_pixels(&pattern, box[0], box[1], box[2], box[3], want);
        ffp_lookup(&summed, box[0], box[1], box[2], box[3], got);
        for (int c = 0; c < 3; c++) assert_true(fabs(want[c] - got[c]) < 1e-12);
    }
    double at_nan[3];
    ffp_lookup(&summed, NAN, INFINITY, 1, 1, at_nan);
    for (int c = 0; c < 3; c++) assert_true(isfinite(at_nan[c]));
    ffp_summed_free(&summed);
    ffp_image_free(&pattern);
}

static void unit_box_is_bilinear(void **state) {
    (void)state;
    FfpImage pattern = random_pattern(3);
    FfpSummed summed = ffp_summed_new(&pattern);
    FfpRng rng = ffp_rng(4, 0);
    for (int k = 0; k < 200; k++) {
        const double u = ffp_rng_range(&rng, 0.5F, WIDTH - 0.5F),
                     v = ffp_rng_range(&rng, 0.5F, HEIGHT - 0.5F);
        double want[3], got[3];
        ffp_image_sample(&pattern, u, v, want);
        ffp_lookup(&summed, u, v, 1, 1, got);
        for (int c = 0; c < 3; c++) assert_true(fabs(want[c] - got[c]) < 1e-12);
    }
    ffp_summed_free(&summed);
    ffp_image_free(&pattern);
}

static double contracted(const FfpSummed *summed, double u, double v, const double box[4],
                         const double grad[3]) {
    double out[3];
    ffp_lookup(summed, u, v, box[2], box[3], out);
    return out[0] * grad[0] + out[1] * grad[1] + out[2] * grad[2];
}

// Of the same along u and v.
static void slopes_at(const FfpSummed *summed, const double box[4], const double grad[3], double slopes[2]) {
    double mean[3], along[2][3];
    ffp_box_slopes(summed, box[0], box[1], box[2], box[3], mean, along[0], along[1]);
    for (int i = 0; i < 2; i++)
        slopes[i] = along[i][0] * grad[0] + along[i][1] * grad[1] + along[i][2] * grad[2];
}

static void position_gradient(void **state) {
    (void)state;
    FfpImage pattern = random_pattern(5);
    FfpSummed summed = ffp_summed_new(&pattern);
    FfpRng rng = ffp_rng(6, 0);
    const double grad[3] = {0.7, -1.3, 0.4}, h = 1e-6;
    int checked = 0;
    for (int k = 0; k < 500; k++) {
        double box[4], slopes[2];
        random_box(&rng, box);
        // The mean is piecewise bilinear: differences across a pixel border would straddle a kink.
        const double edges[4] = {box[0] - fmax(box[2], 1) / 2, box[0] + fmax(box[2], 1) / 2,
                                 box[1] - fmax(box[3], 1) / 2, box[1] + fmax(box[3], 1) / 2};
        double distance = 1;
        for (int i = 0; i < 4; i++) distance = fmin(distance, fabs(edges[i] - round(edges[i])));
        if (distance < 1e-4) continue;
        slopes_at(&summed, box, grad, slopes);
        const double du = (contracted(&summed, box[0] + h, box[1], box, grad) -
                           contracted(&summed, box[0] - h, box[1], box, grad)) /
                          (2 * h);
        const double dv = (contracted(&summed, box[0], box[1] + h, box, grad) -
                           contracted(&summed, box[0], box[1] - h, box, grad)) /
                          (2 * h);
        assert_true(fabs(slopes[0] - du) < 1e-7);
        assert_true(fabs(slopes[1] - dv) < 1e-7);
        checked++;
    }
    assert_true(checked > 400);
    ffp_summed_free(&summed);
    ffp_image_free(&pattern);
}

// One colour everywhere needs no table, and says the same as the table.
static void plain_as_by_table(void **state) {
    (void)state;
    FfpImage pattern = ffp_image_new(WIDTH, HEIGHT, 3);
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++) pattern.data[i] = 0.3 + 0.2 * (i % 3);
    FfpSummed summed = ffp_summed_new(&pattern), table = ffp_summed_zeros(WIDTH, HEIGHT);
    assert_true(summed.plain && !summed.sum);
    for (int i = 0; i < (WIDTH + 1) * (HEIGHT + 1); i++)
        for (int c = 0; c < 3; c++)
            table.sum[FFP_SUMMED_CHANNELS * i + c] =
                pattern.data[c] * (i % (WIDTH + 1)) * (double)(i / (WIDTH + 1));
    FfpRng rng = ffp_rng(8, 0);
    const double grad[3] = {0.7, -1.3, 0.4};
    for (int k = 0; k < 500; k++) {
        double box[4], plain[3], tabled[3], slopes[4];
        random_box(&rng, box);
        ffp_lookup(&summed, box[0], box[1], box[2], box[3], plain);
        ffp_lookup(&table, box[0], box[1], box[2], box[3], tabled);
        for (int c = 0; c < 3; c++) assert_true(fabs(plain[c] - tabled[c]) < 1e-12);
        slopes_at(&summed, box, grad, slopes);
        slopes_at(&table, box, grad, slopes + 2);
        for (int i = 0; i < 2; i++) assert_true(fabs(slopes[i] - slopes[2 + i]) < 1e-12);
    }
    ffp_summed_free(&table);
    ffp_summed_free(&summed);
    ffp_image_free(&pattern);
    FfpImage other = random_pattern(9);
    summed = ffp_summed_new(&other);
    assert_false(summed.plain);
    ffp_summed_free(&summed);
    ffp_image_free(&other);
}

// The lookup is linear in the pattern: central differences are exact but for rounding.
static void pattern_gradient(void **state) {
    (void)state;
    enum { BOXES = 40 };
    FfpImage pattern = random_pattern(7), gradient = ffp_image_new(WIDTH, HEIGHT, 3);
    FfpSummed scattered = ffp_summed_zeros(WIDTH, HEIGHT);
    FfpRng rng = ffp_rng(8, 0);
    double boxes[BOXES][4], grads[BOXES][3];
    for (int k = 0; k < BOXES; k++) {
        random_box(&rng, boxes[k]);
        for (int c = 0; c < 3; c++) grads[k][c] = ffp_rng_normal(&rng);
        ffp_lookup_backward_pattern(&scattered, boxes[k][0], boxes[k][1], boxes[k][2], boxes[k][3], grads[k]);
    }
    ffp_lookup_gather_pattern(&scattered, &gradient);
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++) {
        double value[2] = {0, 0};
        for (int side = 0; side < 2; side++) {
            const double old = pattern.data[i];
            pattern.data[i] = old + (side == 1 ? 0.5 : -0.5);
            FfpSummed summed = ffp_summed_new(&pattern);
            for (int k = 0; k < BOXES; k++)
                value[side] += contracted(&summed, boxes[k][0], boxes[k][1], boxes[k], grads[k]);
            ffp_summed_free(&summed);
            pattern.data[i] = old;
        }
        assert_true(fabs(value[1] - value[0] - gradient.data[i]) < 1e-11);
    }
    ffp_summed_free(&scattered);
    ffp_image_free(&gradient);
    ffp_image_free(&pattern);
}

static void srgb_slope(void **state) {
    (void)state;
    for (int i = 1; i < 1000; i++) {
        const double x = i / 1000.0, h = 1e-7;
        const double slope = (ffp_srgb_encode(x + h) - ffp_srgb_encode(x - h)) / (2 * h);
        assert_true(fabs(slope - ffp_srgb_encode_slope(x)) < 1e-6 * fmax(1, slope));
    }
}

// Threads fill strips of columns: with any number of them the same bits.
static void strips(void **state) {
    (void)state;
    enum { WIDE = 301, THREADS = 4 };
    FfpRng rng = ffp_rng(9, 0);
    FfpImage pattern = ffp_image_new(WIDE, HEIGHT, 3);
    for (int i = 0; i < WIDE * HEIGHT * 3; i++) pattern.data[i] = ffp_rng_uniform(&rng);
    const int usual = omp_get_max_threads();
    FfpSummed of[THREADS];
    for (int t = 0; t < THREADS; t++) {
        omp_set_num_threads(t + 1);
        of[t] = ffp_summed_new(&pattern);
        assert_memory_equal(of[t].sum, of[0].sum,
                            (WIDE + 1) * (HEIGHT + 1) * FFP_SUMMED_CHANNELS * sizeof(double));
    }
    omp_set_num_threads(usual);
    for (int t = 0; t < THREADS; t++) ffp_summed_free(&of[t]);
    ffp_image_free(&pattern);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lookup_is_the_mean),
        cmocka_unit_test(unit_box_is_bilinear),
        cmocka_unit_test(position_gradient),
        cmocka_unit_test(plain_as_by_table),
        cmocka_unit_test(pattern_gradient),
        cmocka_unit_test(srgb_slope),
        cmocka_unit_test(strips),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
