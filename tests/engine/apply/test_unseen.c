// Light that goes on where no camera sees what a projector lights.
#include "engine/apply/unseen.h"
#include "support.h"

enum { WIDTH = 160, HEIGHT = 60, REACH = WIDTH / 20 };

// Known to the left of `from` (bright) and to the right of `to` (dark); in between only lit, but for the
// lowest rows, which miss the object.
static FfpImage filled(int from, int to) {
    FfpImage levels = ffp_image_new(WIDTH, HEIGHT, 4), lit = ffp_image_new(WIDTH, HEIGHT, 1);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const int x = i % WIDTH;
        lit.data[i] = i / WIDTH < HEIGHT - 10;
        if (x >= from && x < to) continue;
        levels.data[4 * i] = (x < from ? 0.8F : 0.2F) * 0.5F; // times the certainty
        levels.data[4 * i + 3] = 0.5F;
    }
    ffp_fill_unseen(&levels, &lit);
    ffp_image_free(&lit);
    return levels;
}

static double level_at(const FfpImage *levels, int x, int y) {
    const real *at = levels->data + 4 * (y * WIDTH + x);
    return at[3] > 0 ? (double)(at[0] / at[3]) : 0;
}

static void it_goes_on_and_fades(void **state) {
    (void)state;
    FfpImage levels = filled(40, WIDTH);
    assert_float_equal(level_at(&levels, 39, 20), 0.8, 1e-6); // what is known stays
    assert_true(level_at(&levels, 40, 20) > 0.7);
    for (int x = 40; x < 40 + REACH; x++) {
        const double fall = level_at(&levels, x - 1, 20) - level_at(&levels, x, 20);
        assert_true(fall > 0 && fall < 0.25); // no edge
    }
    for (int x = 40 + REACH; x < WIDTH; x++) assert_true(level_at(&levels, x, 20) == 0);
    for (int x = 40; x < WIDTH; x++) assert_true(level_at(&levels, x, HEIGHT - 5) == 0); // not on the object
    ffp_image_free(&levels);
}

// Narrower than the reach: from one side's level to the other's, without a step where the nearest changes.
static void it_joins_two_sides(void **state) {
    (void)state;
    FfpImage levels = filled(40, 46);
    for (int x = 40; x <= 46; x++) {
        const double fall = level_at(&levels, x - 1, 20) - level_at(&levels, x, 20);
        assert_true(fall > -0.05 && fall < 0.3); // the nearest level falls by 0.6 at once
    }
    ffp_image_free(&levels);
}

static void nothing_known_stays_dark(void **state) {
    (void)state;
    FfpImage levels = filled(0, WIDTH);
    for (int i = 0; i < WIDTH * HEIGHT; i++) assert_true(level_at(&levels, i % WIDTH, i / WIDTH) == 0);
    ffp_image_free(&levels);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(it_goes_on_and_fades),
                                       cmocka_unit_test(it_joins_two_sides),
                                       cmocka_unit_test(nothing_known_stays_dark)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
