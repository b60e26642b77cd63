// Pictures in frames of another shape: what is seen where, to the pixel.
#include <math.h>
#include "core/image/framing.h"
#include "support.h"

// Red rises from left to right, green from top to bottom, both from 0 to 1 over the picture; blue is 1.
static FfpImage ramp(int width, int height) {
    FfpImage image = ffp_image_new(width, height, 3);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            real *pixel = image.data + 3 * ((ptrdiff_t)y * width + x);
            pixel[0] = ((real)x + 0.5F) / (real)width;
            pixel[1] = ((real)y + 0.5F) / (real)height;
            pixel[2] = 1;
        }
    return image;
}

static const real *at(const FfpImage *image, int x, int y) {
    return image->data + 3 * ((ptrdiff_t)y * image->width + x);
}

// Where in the picture (0 to 1) the frame's pixel looks, or nothing (black).
static void must_show(const FfpImage *image, int x, int y, double u, double v) {
    const real *pixel = at(image, x, y);
    const bool right =
        fabs((double)pixel[0] - u) < 0.02 && fabs((double)pixel[1] - v) < 0.02 && pixel[2] > 0.99F;
    if (!right)
        printf("%d %d: %g %g %g, not %g %g\n", x, y, (double)pixel[0], (double)pixel[1], (double)pixel[2], u,
               v);
    assert_true(right);
}

static void must_be_black(const FfpImage *image, int x, int y) {
    for (int c = 0; c < 3; c++) assert_true(at(image, x, y)[c] == 0);
}

static void a_wide_picture_in_a_square(void **state) {
    (void)state;
    FfpImage wide = ramp(160, 90);
    FfpImage cover = ffp_image_framed(&wide, 60, 60, FFP_FRAMING_COVER);
    must_show(&cover, 0, 0, 0.5 - 0.5 * 9 / 16, 0);
    must_show(&cover, 59, 59, 0.5 + 0.5 * 9 / 16, 1);
    FfpImage contain = ffp_image_framed(&wide, 60, 60, FFP_FRAMING_CONTAIN);
    must_show(&contain, 0, 30, 0, 0.5);
    must_show(&contain, 59, 30, 1, 0.5);
    must_be_black(&contain, 30, 12);
    must_be_black(&contain, 30, 47);
    must_show(&contain, 30, 14, 0.508, 1.5 / 34);
    FfpImage stretch = ffp_image_framed(&wide, 60, 60, FFP_FRAMING_STRETCH);
    must_show(&stretch, 0, 0, 0, 0);
    must_show(&stretch, 59, 59, 1, 1);
    FfpImage *const all[] = {&wide, &cover, &contain, &stretch};
    for (int i = 0; i < 4; i++) ffp_image_free(all[i]);
}

static void pixel_for_pixel(void **state) {
    (void)state;
    FfpImage picture = ramp(40, 100);
    FfpImage frame = ffp_image_framed(&picture, 50, 60, FFP_FRAMING_PIXEL);
    must_be_black(&frame, 4, 30);
    must_be_black(&frame, 45, 30);
    for (int y = 0; y < 60; y++)
        for (int x = 0; x < 40; x++)
            for (int c = 0; c < 3; c++) assert_true(at(&frame, x + 5, y)[c] == at(&picture, x, y + 20)[c]);
    ffp_image_free(&picture);
    ffp_image_free(&frame);
}

// Every shape in every frame: the frame's size, nothing outside the picture's range, the middle in the
// middle.
static void any_shape_in_any_frame(void **state) {
    (void)state;
    static const int sides[] = {1, 2, 7, 64, 333};
    enum { N = sizeof sides / sizeof *sides };
    for (int k = 0; k < N * N * N * N; k++) {
        const int w = sides[k % N], h = sides[k / N % N], fw = sides[k / N / N % N],
                  fh = sides[k / N / N / N];
        FfpImage picture = ramp(w, h);
        for (int how = 0; how <= FFP_FRAMING_PIXEL; how++) {
            FfpImage frame = ffp_image_framed(&picture, fw, fh, (FfpFraming)how);
            assert_true(frame.width == fw && frame.height == fh && frame.channels == 3);
            for (int i = 0; i < 3 * fw * fh; i++) assert_true(frame.data[i] >= 0 && frame.data[i] <= 1.0001F);
            assert_true(at(&frame, (fw - 1) / 2, (fh - 1) / 2)[2] > 0.99F);
            ffp_image_free(&frame);
        }
        ffp_image_free(&picture);
    }
}

static void a_shape_that_is_nearly_the_same_is_only_resized(void **state) {
    (void)state;
    FfpImage picture = ramp(201, 100), same = ffp_image_resize(&picture, 80, 40);
    for (int how = 0; how < FFP_FRAMING_PIXEL; how++) {
        FfpImage frame = ffp_image_framed(&picture, 80, 40, (FfpFraming)how);
        assert_memory_equal(frame.data, same.data, 3 * 80 * 40 * sizeof *same.data);
        ffp_image_free(&frame);
    }
    ffp_image_free(&picture);
    ffp_image_free(&same);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_wide_picture_in_a_square),
        cmocka_unit_test(pixel_for_pixel),
        cmocka_unit_test(any_shape_in_any_frame),
        cmocka_unit_test(a_shape_that_is_nearly_the_same_is_only_resized),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
