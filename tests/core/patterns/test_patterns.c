// Patterns for a projector: Gray codes that decode, pictures of the right shape.
#include "core/base/alloc.h"
#include "core/patterns/lollipop.h"
#include "core/patterns/patterns.h"
#include "support.h"

static void gray_codes_number_every_column_and_row(void **state) {
    (void)state;
    enum { WIDTH = 100, HEIGHT = 65 };
    assert_int_equal(ffp_gray_code_bits(64), 6);
    assert_int_equal(ffp_gray_code_bits(65), 7);
    assert_int_equal(ffp_gray_code_bits(1920), 11);
    for (int axis = 0; axis < 2; axis++) {
        const int size = axis == 0 ? WIDTH : HEIGHT, count = ffp_gray_code_bits(size);
        FfpImage bit[8], inverse[8];
        for (int b = 0; b < count; b++) {
            bit[b] = ffp_pattern_gray_code(WIDTH, HEIGHT, axis, b, false);
            inverse[b] = ffp_pattern_gray_code(WIDTH, HEIGHT, axis, b, true);
        }
        int changes = 0;
        for (int i = 0; i < size; i++) {
            bool bits[8];
            const int p = axis == 0 ? 7 * WIDTH + i : i * WIDTH + 7, before = axis == 0 ? p - 1 : p - WIDTH;
            for (int b = 0; b < count; b++) {
                bits[b] = bit[b].data[p] > 0.5F;
                assert_true(bit[b].data[p] + inverse[b].data[p] == 1);
                changes += i > 0 && bit[b].data[p] != bit[b].data[before];
            }
            assert_int_equal(ffp_gray_decode(bits, count), i);
        }
        assert_int_equal(changes, size - 1); // neighbours differ in one bit
        for (int b = 0; b < count; b++) ffp_image_free(&bit[b]), ffp_image_free(&inverse[b]);
    }
}

static void a_lollipop_stays_round(void **state) {
    (void)state;
    FfpImage wide = ffp_pattern_round_lollipop(160, 90, 4), square = ffp_lollipop_pattern(90, 90, 4);
    ffp_image_to_srgb(&square);
    for (int y = 0; y < 90; y++) {
        const real *row = wide.data + (size_t)3 * 160 * (size_t)y;
        for (int x = 0; x < 3 * 35; x++) assert_true(row[x] == 0 && row[3 * 125 + x] == 0);
        assert_memory_equal(row + (size_t)3 * 35, square.data + (size_t)3 * 90 * (size_t)y,
                            3 * 90 * sizeof(real));
    }
    ffp_image_free(&wide);
    ffp_image_free(&square);
}

static void the_order_is_that_of_the_parts(void **state) {
    (void)state;
    const FfpShow show = {
        .width = 80, .height = 70, .lollipops = 2, .focus = true, .capture = true, .gray_codes = true};
    static const char *const first[] = {"focus", "black", "white", "lollipop_0", "lollipop_1", "gray_x_00"};
    const int count = ffp_show_count(&show);
    assert_int_equal(count, 1 + 4 + 2 * (7 + 7));
    char name[32];
    FfpShowPart part;
    for (int i = 0; i < count; i++) {
        FfpImage image = ffp_show_picture(&show, i, name, &part);
        if (i < 6) assert_string_equal(name, first[i]);
        assert_true(image.width == 80 && image.height == 70);
        assert_int_equal(ffp_show_number(&show, i), i);
        ffp_image_free(&image);
    }
    assert_string_equal(name, "gray_y_06_inverse");
    const FfpShow capture = {.width = 80, .height = 70, .lollipops = 1, .capture = true};
    assert_int_equal(ffp_show_count(&capture), 3);
    assert_int_equal(ffp_show_number(&capture, 0), 1); // nothing to focus by
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(gray_codes_number_every_column_and_row),
                                       cmocka_unit_test(a_lollipop_stays_round),
                                       cmocka_unit_test(the_order_is_that_of_the_parts)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
