// The lollipop pattern against its closed form, and against one that another program drew.
#include <math.h>
#include "core/base/alloc.h"
#include "core/image/image.h"
#include "core/patterns/lollipop.h"
#include "support.h"

static const real *at(const FfpImage *image, int x, int y) {
    return image->data + 3 * ((size_t)y * (size_t)image->width + (size_t)x);
}

static void fields_lie_where_the_reference_draws_them(void **state) {
    (void)state;
    uint8_t *map = ffp_lollipop_map(800, 800);
    for (int y = 0; y < 800; y += 3)
        for (int x = 0; x < 800; x += 7) {
            const double dx = x + 0.5 - 400, dy = y + 0.5 - 400, r = hypot(dx, dy);
            double angle = atan2(dy, dx) * 180 / 3.14159265358979;
            if (angle < 0) angle += 360;
            if (fabs(remainder(angle, 45)) < 1e-6 || fabs(remainder(400 - r, 13)) < 1e-6)
                continue; // on a border
            const int ring = r > 400 ? -1 : (int)fmin(29, floor((400 - r) / 13));
            const int expected = ring < 0 ? FFP_LOLLIPOP_FIELDS : ring * 8 + (int)(angle / 45);
            assert_int_equal(map[y * 800 + x], expected);
        }
    ffp_free(map);
}

static void wide_patterns_have_ellipses(void **state) {
    (void)state;
    uint8_t *map = ffp_lollipop_map(1920, 1080);
    assert_int_equal(map[0], FFP_LOLLIPOP_FIELDS);
    assert_int_equal(map[1080 / 2 * 1920 + 1919] / 8, 0); // right end of the outermost ellipse
    assert_int_equal(map[1079 * 1920 + 970] / 8, 0);      // and its lower end
    assert_int_equal(map[1080 / 2 * 1920 + 965], 29 * 8); // the middle
    assert_int_equal(map[545 * 1920 + 960 + 928 - 3] / 8, 1);
    ffp_free(map);
}

static void colours_are_eight_bit_and_fresh(void **state) {
    (void)state;
    FfpImage a = ffp_lollipop_pattern(100, 100, 1), b = ffp_lollipop_pattern(100, 100, 1),
             c = ffp_lollipop_pattern(100, 100, 2);
    assert_memory_equal(a.data, b.data, 100 * 100 * 3 * sizeof(real));
    assert_memory_not_equal(a.data, c.data, 100 * 100 * 3 * sizeof(real));
    for (int i = 0; i < 100 * 100 * 3; i++) {
        const double level = 255 * (double)ffp_srgb_encode(a.data[i]);
        assert_true(fabs(level - round(level)) < 1e-3);
    }
    ffp_image_free(&a);
    ffp_image_free(&b);
    ffp_image_free(&c);
}

// Each field of a pattern that was drawn elsewhere must have one colour nearly everywhere: borders may differ
// by a pixel.
static void a_foreign_lollipop_has_the_same_fields(void **state) {
    (void)state;
    char path[1024];
    FfpError err;
    if (!shared_path(path, "captures/patterns/lollipop_0.png")) skip();
    FfpImage rgb;
    assert_true(ffp_image_read(&rgb, path, FFP_COLOUR_ENCODED, &err));
    ffp_image_put_over_black(&rgb);
    uint8_t *map = ffp_lollipop_map(rgb.width, rgb.height);
    int same = 0, all = 0;
    for (int y = 1; y < rgb.height - 1; y++)
        for (int x = 1; x < rgb.width - 1; x++) {
            const int here = map[y * rgb.width + x];
            if (here != map[y * rgb.width + x + 1] || here != map[(y + 1) * rgb.width + x]) continue;
            const real *p = at(&rgb, x, y), *right = at(&rgb, x + 1, y), *below = at(&rgb, x, y + 1);
            int equal = 1;
            for (int c = 0; c < 3; c++) equal &= p[c] == right[c] && p[c] == below[c];
            same += equal;
            all++;
        }
    assert_true(same > 0.995 * all);
    ffp_free(map);
    ffp_image_free(&rgb);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fields_lie_where_the_reference_draws_them),
        cmocka_unit_test(wide_patterns_have_ellipses),
        cmocka_unit_test(colours_are_eight_bit_and_fresh),
        cmocka_unit_test(a_foreign_lollipop_has_the_same_fields),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
