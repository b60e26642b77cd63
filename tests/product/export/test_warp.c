// The mesh of a warp: it reaches the rim of what the camera sees, and leaves out what lies across a step.
#include <math.h>
#include "product/export/warp.h"
#include "support.h"

enum { WIDTH = 300, HEIGHT = 200, RADIUS = 90, STEP_AT = 170, STEP_BY = 40 };

static const FfpCamera camera = {.width = 400, .height = 320};

// A disc; right of a column the camera sees it further to the right.
static bool is_seen(int x, int y) {
    return hypot(x - 150.0, y - 95.0) < RADIUS;
}

static double seen_at(int x) {
    return x + 20.25 + (x >= STEP_AT ? STEP_BY : 0);
}

static FfpImage disc(int *count) {
    FfpImage map = ffp_image_new(WIDTH, HEIGHT, 3);
    *count = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            real *to = map.data + 3 * (y * WIDTH + x);
            const bool seen = is_seen(x, y);
            to[0] = seen ? (real)seen_at(x) : -1;
            to[1] = seen ? (real)y + 30.5F : -1;
            to[2] = seen;
            *count += seen;
        }
    return map;
}

static void it_reaches_the_rim_and_no_further(void **state) {
    (void)state;
    int count;
    FfpImage map = disc(&count);
    FfpWarp warp = ffp_warp_of_map(&map, &camera);
    double area = 0, large = 0;
    for (size_t t = 0; t < warp.n_triangles; t++) {
        double x[3], y[3];
        int sides = 0;
        for (int k = 0; k < 3; k++) {
            const uint32_t c = warp.corners[3 * t + (size_t)k];
            assert_true(c < warp.n_corners);
            x[k] = (double)warp.position[3 * c] * WIDTH - 0.5;
            y[k] = (1 - (double)warp.position[3 * c + 1]) * HEIGHT - 0.5;
            const int column = (int)lround(x[k]), row = (int)lround(y[k]);
            assert_true(is_seen(column, row));
            sides |= column < STEP_AT ? 1 : 2;
            assert_true(fabs((double)warp.texture[2 * c] * camera.width - seen_at(column)) < 1e-3);
            assert_true(fabs((1 - (double)warp.texture[2 * c + 1]) * camera.height - row - 30.5) < 1e-3);
        }
        assert_int_not_equal(sides, 3); // none across the step
        const double one = ((x[2] - x[0]) * (y[1] - y[0]) - (x[1] - x[0]) * (y[2] - y[0])) / 2;
        assert_true(one > 0); // counter-clockwise, with y up
        area += one;
        large = fmax(large, one);
    }
    print_message("%.3f of the pixels, %zu triangles\n", area / count, warp.n_triangles);
    assert_true(area > 0.97 * count && area <= count);
    assert_true(fabs(large - 8) < 1e-3 &&
                warp.n_triangles < (size_t)count / 4); // cells of four pixels inside
    ffp_warp_free(&warp);
    ffp_image_free(&map);
}

static void nothing_seen_is_no_mesh(void **state) {
    (void)state;
    FfpImage map = ffp_image_new(WIDTH, HEIGHT, 3);
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) map.data[i] = i % 3 == 2 ? 0 : -1;
    FfpWarp warp = ffp_warp_of_map(&map, &camera);
    assert_true(warp.n_triangles == 0 && warp.n_corners == 0);
    ffp_warp_free(&warp);
    ffp_image_free(&map);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(it_reaches_the_rim_and_no_further),
                                       cmocka_unit_test(nothing_seen_is_no_mesh)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
