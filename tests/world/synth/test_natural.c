// Natural patterns and the strokes that they are drawn with.
#include <math.h>
#include "support.h"
#include "world/synth/natural.h"
#include "world/synth/stroke.h"
#include "world/synth/synth.h"

enum { SIDE = 160 };

static void patterns_are_eight_bit_and_their_own(void **state) {
    (void)state;
    const size_t bytes = (size_t)SIDE * SIDE * 3 * sizeof(real);
    for (int i = 0; i < FFP_NATURAL_KINDS; i++) {
        FfpImage a = ffp_natural_pattern(SIDE, SIDE, i, 7), b = ffp_natural_pattern(SIDE, SIDE, i, 7);
        FfpImage c = ffp_natural_pattern(SIDE, SIDE, i, 8),
                 d = ffp_natural_pattern(SIDE, SIDE, i + FFP_NATURAL_KINDS, 7);
        assert_memory_equal(a.data, b.data, bytes);
        assert_memory_not_equal(a.data, c.data, bytes);
        assert_memory_not_equal(a.data, d.data, bytes);
        double sum = 0, square = 0;
        for (int k = 0; k < SIDE * SIDE * 3; k++) {
            const double level = 255 * (double)ffp_srgb_encode(a.data[k]);
            assert_true(fabs(level - round(level)) < 1e-3);
            sum += level / 255, square += level * level / 255 / 255;
        }
        const double mean = sum / (SIDE * SIDE * 3),
                     deviation = sqrt(square / (SIDE * SIDE * 3) - mean * mean);
        assert_true(mean > 0.1 && mean < 0.95 && deviation > 0.04);
        assert_string_equal(ffp_natural_name(i), ffp_natural_name(i + FFP_NATURAL_KINDS));
        ffp_image_free(&a);
        ffp_image_free(&b);
        ffp_image_free(&c);
        ffp_image_free(&d);
    }
}

// Natural patterns come after the others and change none of them.
static void scenes_keep_their_other_pictures(void **state) {
    (void)state;
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.mesh = 3, spec.material = 20, spec.seed = 2, spec.resolution = 24, spec.views = 1, spec.targets = 1;
    spec.lollipops = 1, spec.pattern_side = 100, spec.samples = 1;
    FfpCapture plain, more;
    FfpError err;
    assert_true(ffp_scene_make(&plain, &spec, &err));
    spec.naturals = FFP_NATURAL_KINDS;
    assert_true(ffp_scene_make(&more, &spec, &err));
    assert_int_equal(plain.n_patterns, 3);
    assert_int_equal(more.n_patterns, 3 + FFP_NATURAL_KINDS);
    for (int p = 0; p < more.n_patterns; p++) {
        assert_int_equal(more.patterns[p].novel, p >= 3);
        for (int v = 0; v < 2 && p < 3; v++)
            assert_memory_equal(plain.views[v].images[p].data, more.views[v].images[p].data,
                                24 * 24 * 3 * sizeof(real));
    }
    assert_string_equal(more.patterns[4].name, "text_1");
    ffp_capture_free(&plain);
    ffp_capture_free(&more);
}

static double ink(const char *text) {
    FfpImage image = ffp_image_new(60, 20, 1);
    const FfpPen pen = {&image, 1, {1, 1, 1}};
    const float at[2] = {4, 4};
    const float length = ffp_stroke_text(&pen, at, 10, 0, text);
    assert_float_equal(length, ffp_stroke_length(10, text), 1e-6);
    double sum = 0;
    for (int i = 0; i < 60 * 20; i++) {
        assert_true(image.data[i] >= 0 && image.data[i] <= 1);
        sum += (double)image.data[i];
    }
    ffp_image_free(&image);
    return sum;
}

static void letters_leave_ink(void **state) {
    (void)state;
    for (const char *c = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_:/!?+"; *c; c++) {
        const char text[2] = {*c, 0};
        assert_true(ink(text) > 3);
    }
    assert_true(ink(" \x7f\xff") == 0);
    assert_true(fabs(ink("abc") - ink("ABC")) < 1e-6);
    assert_true(ink("O") > ink("C") && ink("E") > ink("F"));
}

// A line of width 3 covers 3 pixels for each pixel of its length, its round end half a disc more; nothing is
// written outside the image.
static void lines_have_their_width(void **state) {
    (void)state;
    FfpImage image = ffp_image_new(40, 40, 1);
    const FfpPen pen = {&image, 3, {1, 1, 1}};
    ffp_stroke_line(&pen, (float[2]){20, -30}, (float[2]){20, 20});
    ffp_stroke_line(&pen, (float[2]){-300, 100}, (float[2]){-200, 400});
    double sum = 0;
    for (int i = 0; i < 1600; i++) sum += (double)image.data[i];
    assert_float_equal(sum, 3 * 20 + 0.5 * 3.14159265 * 1.5 * 1.5, 0.3);
    ffp_image_free(&image);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(patterns_are_eight_bit_and_their_own),
        cmocka_unit_test(scenes_keep_their_other_pictures),
        cmocka_unit_test(letters_leave_ink),
        cmocka_unit_test(lines_have_their_width),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
