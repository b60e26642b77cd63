// Positions in the projector as a picture of 16 bits.
#include <tgmath.h>
#include "core/capture/positions.h"
#include "scratch.h"

enum { WIDTH = 1920, HEIGHT = 1080 };

static const real places[][3] = {{0.5F, 0.5F, 1},       {1919.7F, 1079.2F, 1}, {777.123F, 3.21F, 0.5F},
                                 {-400, 1300, 1},       {100, 100, 0},         {-600, 20, 1},
                                 {20, 1.3F * HEIGHT, 1}};
enum { COUNT = sizeof places / sizeof *places, KNOWN = 4 };

static void test_round_trip(void **state) {
    (void)state;
    FfpError err = {0};
    FfpImage map = ffp_image_new(COUNT, 1, 3), picture;
    for (int i = 0; i < 3 * COUNT; i++) map.data[i] = places[i / 3][i % 3];
    FfpImage encoded = ffp_positions_encoded(&map, WIDTH, HEIGHT);
    if (!ffp_image_write_png16(&encoded, in_scratch("map.png"), &err)) fail_msg("%s", err.text);
    if (!ffp_image_read(&picture, in_scratch("map.png"), FFP_COLOUR_STORED, &err)) fail_msg("%s", err.text);
    FfpImage back = ffp_positions_decoded(&picture, WIDTH, HEIGHT);
    for (int i = 0; i < COUNT; i++) {
        const real *at = back.data + 3 * i;
        const bool known = i < KNOWN; // the others had no confidence, or lie too far outside
        assert_float_equal(at[0], known ? places[i][0] : 0, 1.5 * WIDTH / 131070 + 1e-3);
        assert_float_equal(at[1], known ? places[i][1] : 0, 1.5 * HEIGHT / 131070 + 1e-3);
        assert_float_equal(at[2], known ? places[i][2] : 0, 1e-5);
    }
    ffp_image_free(&map), ffp_image_free(&encoded), ffp_image_free(&picture), ffp_image_free(&back);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_round_trip)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
