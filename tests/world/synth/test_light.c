// One lookup for all patterns against each pattern's own.
#include <math.h>
#include <stdlib.h>
#include "core/base/alloc.h"
#include "core/base/rng.h"
#include "support.h"
#include "world/synth/light.h"

enum { WIDTH = 21, HEIGHT = 13, PATTERNS = 12, LOOKUPS = 300 };

// Black, one colour, black but for its last pixel, and nine of noise: more than eight lanes.
static void make_patterns(FfpImage patterns[PATTERNS]) {
    FfpRng rng = ffp_rng(5, 6);
    for (int p = 0; p < PATTERNS; p++) {
        patterns[p] = ffp_image_new(WIDTH, HEIGHT, 3);
        for (int i = 0; i < WIDTH * HEIGHT * 3 && p != 0 && p != 2; i++)
            patterns[p].data[i] = p == 1 ? 0.2F * (real)(i % 3 + 1) : (real)ffp_rng_uniform(&rng);
    }
    patterns[2].data[WIDTH * HEIGHT * 3 - 1] = 1;
}

static FfpImage coarse_of(const FfpImage *image) {
    FfpImage out =
        ffp_image_new((WIDTH + FFP_COARSE - 1) / FFP_COARSE, (HEIGHT + FFP_COARSE - 1) / FFP_COARSE, 3);
    int *pixels = ffp_alloc((size_t)out.width * (size_t)out.height, sizeof *pixels);
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++) {
        const int box = i / 3 / WIDTH / FFP_COARSE * out.width + i / 3 % WIDTH / FFP_COARSE;
        out.data[3 * box + i % 3] += image->data[i];
        pixels[box] += i % 3 == 0;
    }
    for (int i = 0; i < out.width * out.height * 3; i++) out.data[i] /= (real)pixels[i / 3];
    ffp_free(pixels);
    return out;
}

// Expects the result of ffp_image_sample for pattern p at the lookup, times the colour.
static void expect_sample(const FfpLight *light, const FfpImage *image, int p, float u, float v,
                          const float colour[3], const float *sum) {
    real want[3];
    ffp_image_sample(image, u, v, want);
    for (int c = 0; c < 3; c++) {
        const float got = light->lane[p] < 0 ? 1 : sum[c * light->lanes + light->lane[p]];
        assert_float_equal(got, 1 + (light->lane[p] < 0 ? 0 : colour[c] * want[c]), 2e-6);
    }
}

static void lookups_are_each_patterns_own(void **state) {
    (void)state;
    FfpImage patterns[PATTERNS], coarse[PATTERNS];
    const FfpImage *images[PATTERNS];
    make_patterns(patterns);
    for (int p = 0; p < PATTERNS; p++) images[p] = &patterns[p], coarse[p] = coarse_of(&patterns[p]);
    FfpLight light = ffp_light_new(images, PATTERNS);
    assert_int_equal(light.lane[0], -1);
    assert_true(light.lane[1] >= 0 && light.lane[2] >= 0 && light.lanes == 16);
    const float colour[3] = {0.5F, 2, 1};
    float *sum = ffp_alloc((size_t)light.lanes * 3, sizeof *sum);
    assert_non_null(sum);
    for (int i = 0; i < LOOKUPS; i++) {
        const float u = 0.5F * WIDTH * (1 + sinf((float)i)), v = 0.5F * HEIGHT * (1 + cosf(1.3F * (float)i));
        const float s = u / FFP_COARSE, t = v / FFP_COARSE;
        FfpTexel texel;
        for (int k = 0; k < 3 * light.lanes; k++) sum[k] = 1;
        assert_true(ffp_light_texel(light.width, light.height, u, v, &texel));
        ffp_light_add(&light, &texel, colour, sum);
        for (int p = 0; p < PATTERNS; p++) expect_sample(&light, &patterns[p], p, u, v, colour, sum);
        for (int k = 0; k < 3 * light.lanes; k++) sum[k] = 1;
        assert_true(ffp_light_texel(light.coarse_width, light.coarse_height, s, t, &texel));
        ffp_light_add_coarse(&light, &texel, colour, sum);
        for (int p = 0; p < PATTERNS; p++) expect_sample(&light, &coarse[p], p, s, t, colour, sum);
    }
    ffp_free(sum);
    ffp_light_free(&light);
    for (int p = 0; p < PATTERNS; p++) ffp_image_free(&patterns[p]), ffp_image_free(&coarse[p]);
}

// Boxes at the border are means of what they hold: one colour stays one colour. Whole boxes keep their bits.
static void boxes_are_means_of_their_own(void **state) {
    (void)state;
    FfpRng rng = ffp_rng(8, 1);
    FfpImage plain = ffp_image_new(WIDTH, HEIGHT, 3), noise = ffp_image_new(2 * FFP_COARSE, FFP_COARSE, 3);
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++) plain.data[i] = 0.3F;
    for (int i = 0; i < 2 * FFP_COARSE * FFP_COARSE * 3; i++) noise.data[i] = ffp_rng_uniform(&rng);
    const FfpImage *images[2] = {&plain, &noise};
    FfpLight light = ffp_light_new(&images[0], 1);
    for (int i = 0; i < light.coarse_width * light.coarse_height * 3; i++)
        assert_float_equal(light.coarse[i * light.lanes + light.lane[0]], 0.3F, 1e-6);
    ffp_light_free(&light);
    light = ffp_light_new(&images[1], 1);
    for (int i = 0; i < 6; i++) {
        float sum = 0;
        for (int y = 0; y < FFP_COARSE; y++)
            for (int x = 0; x < FFP_COARSE; x++)
                sum += noise.data[3 * (y * 2 * FFP_COARSE + i / 3 * FFP_COARSE + x) + i % 3] /
                       (FFP_COARSE * FFP_COARSE);
        assert_true(light.coarse[i * light.lanes + light.lane[0]] == sum);
    }
    ffp_light_free(&light);
    ffp_image_free(&plain), ffp_image_free(&noise);
}

static void nothing_lies_outside(void **state) {
    (void)state;
    FfpTexel texel;
    const float outside[5][2] = {{-0.01F, 3}, {3, -0.01F}, {21.01F, 3}, {3, 13.01F}, {NAN, 3}};
    for (int i = 0; i < 5; i++)
        assert_false(ffp_light_texel(WIDTH, HEIGHT, outside[i][0], outside[i][1], &texel));
    assert_true(ffp_light_texel(WIDTH, HEIGHT, WIDTH, HEIGHT, &texel));
    assert_int_equal(texel.at, WIDTH * HEIGHT - 1);
    assert_int_equal(texel.right + texel.down, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(lookups_are_each_patterns_own),
                                       cmocka_unit_test(boxes_are_means_of_their_own),
                                       cmocka_unit_test(nothing_lies_outside)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
