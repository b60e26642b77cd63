// The displacement between an empty stage and a view, of textures that are moved, exposed otherwise and
// covered.
#include "core/base/rng.h"
#include "rig/masks/steps.h"
#include "support.h"

enum { WIDTH = 240, HEIGHT = 180, CELL = 7 };

// A wall of random tiles under a light that falls off, moved by (dx, dy), with noise; an object before it.
static FfpImage draw(int dx, int dy, double gain, bool object, uint64_t noise) {
    FfpImage out = ffp_image_new(WIDTH, HEIGHT, 3);
    FfpRng rng = ffp_rng(noise, 0);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const int u = x - dx + 10 * CELL, v = y - dy + 10 * CELL;
            FfpRng tile = ffp_rng((uint64_t)(u / CELL) * 1000 + (uint64_t)(v / CELL), 0);
            const bool covered = object && x > 90 && x < 150 && y > 60 && y < 130;
            const double light = covered ? 0.7 : 0.1 + 0.4 * (double)ffp_rng_uniform(&tile);
            for (int c = 0; c < 3; c++)
                out.data[3 * (y * WIDTH + x) + c] =
                    (real)(gain * light + 0.01 * (double)ffp_rng_uniform(&rng));
        }
    return out;
}

static void find(int moved[2], int dx, int dy, double gain) {
    FfpImage black = ffp_image_new(WIDTH, HEIGHT, 3), view = draw(dx, dy, gain, true, 1),
             stage = draw(0, 0, 1, false, 2);
    ffp_stage_moved(moved, &black, &view, &black, &stage);
    ffp_image_free(&black), ffp_image_free(&view), ffp_image_free(&stage);
}

static void a_displacement_is_found(void **state) {
    (void)state;
    static const int places[][2] = {{4, 0}, {0, -6}, {-8, 6}, {12, -10}};
    for (size_t k = 0; k < sizeof places / sizeof *places; k++) {
        int moved[2];
        find(moved, places[k][0], places[k][1], k % 2 ? 1.3 : 1);
        for (int i = 0; i < 2; i++) assert_in_range(moved[i] + 100, places[k][i] + 98, places[k][i] + 102);
    }
}

static void what_stands_still_is_not_named(void **state) {
    (void)state;
    int moved[2];
    find(moved, 0, 0, 0.7);
    assert_int_equal(moved[0], 0);
    assert_int_equal(moved[1], 0);
}

static void darkness_says_nothing(void **state) {
    (void)state;
    int moved[2] = {9, 9};
    FfpImage dark = ffp_image_new(WIDTH, HEIGHT, 3);
    ffp_stage_moved(moved, &dark, &dark, &dark, &dark);
    assert_int_equal(moved[0], 0);
    assert_int_equal(moved[1], 0);
    ffp_image_free(&dark);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_displacement_is_found),
                                       cmocka_unit_test(what_stands_still_is_not_named),
                                       cmocka_unit_test(darkness_says_nothing)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
