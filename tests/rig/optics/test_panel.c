// Patterns for the real projector: a lens and a gamma put in again undo what an import has taken away.
#include <math.h>
#include "core/capture/panel.h"
#include "rig/optics/lens.h"
#include "support.h"

static FfpError err;

static const FfpOptics lamp = {.width = 480,
                               .height = 270,
                               .fx = 520,
                               .fy = 515,
                               .cx = 236,
                               .cy = 281,
                               .lens = {0.09, -0.12, -0.004, 0.003, 0.05}};

// Smooth waves of linear light, a few across the picture: what survives resampling.
static FfpImage waves(int width, int height) {
    FfpImage image = ffp_image_new(width, height, 3);
    for (int i = 0; i < width * height * 3; i++) {
        const double x = (i / 3 % width + 0.5) / width, y = (i / 3 / width + 0.5) / height;
        image.data[i] = (real)(0.5 + 0.4 * sin(20 * x + 3 * (i % 3)) * cos(14 * y - i % 3));
    }
    return image;
}

// PSNR of encoded values over the pixels that are `margin` or more away from the edge.
static double psnr(const FfpImage *a, const FfpImage *b, int margin) {
    double sum = 0;
    int count = 0;
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    for (int y = margin; y < a->height - margin; y++)
        for (int x = margin; x < a->width - margin; x++)
            for (int c = 0; c < 3; c++) {
                const int i = 3 * (y * a->width + x) + c;
                const double d = (double)(ffp_srgb_encode(a->data[i]) - ffp_srgb_encode(b->data[i]));
                sum += d * d, count++;
            }
    return -10 * log10(sum / count);
}

// An imported pattern, shown again, is the pattern that was shown.
static void distorting_undoes_rectifying(void **state) {
    (void)state;
    FfpCamera ideal = {0};
    FfpPanel panel = {0};
    FfpImage shown = waves(lamp.width, lamp.height), again;
    ffp_optics_pinhole(&lamp, 0, &ideal);
    ffp_panel_describe(&panel, &lamp);
    FfpImage pattern = ffp_optics_rectify(&lamp, &ideal, &shown);
    assert_true(ffp_panel_picture(&again, &panel, &ideal, &pattern, "lamp", &err));
    const double untouched = psnr(&shown, &pattern, 24), returned = psnr(&shown, &again, 24);
    printf("as imported %.1f dB, for the device %.1f dB\n", untouched, returned);
    assert_true(untouched < 35);
    assert_true(returned > 50);
    ffp_image_free(&shown), ffp_image_free(&pattern), ffp_image_free(&again);
}

// However the lens bends the panel's sides, the widened frame shows all of its light, and darkness around it.
static void a_frame_holds_all_light(void **state) {
    (void)state;
    enum { BORDER = 3 };
    for (int sign = -1; sign <= 1; sign++) {
        FfpOptics optics = lamp;
        for (int i = 0; i < 5; i++) optics.lens[i] *= 0.5 * sign;
        FfpCamera ideal = {0};
        FfpImage white = ffp_image_new(lamp.width, lamp.height, 3);
        double before = 0, after = 0;
        for (int i = 0; i < white.width * white.height * 3; i++) white.data[i] = 1;
        ffp_optics_pinhole(&optics, 0, &ideal);
        const double cx = (double)ideal.cx;
        FfpImage cut = ffp_optics_rectify(&optics, &ideal, &white);
        ffp_optics_frame_all(&optics, BORDER, &ideal);
        FfpImage all = ffp_optics_rectify(&optics, &ideal, &white);
        for (int i = 0; i < cut.width * cut.height; i++) before += (double)cut.data[3 * i];
        for (int y = 0; y < all.height; y++)
            for (int x = 0; x < all.width; x++) {
                const double v = (double)all.data[3 * (y * all.width + x)];
                const bool rim =
                    x < BORDER || y < BORDER || x >= all.width - BORDER || y >= all.height - BORDER;
                after += v;
                if (rim) assert_true(v == 0);
            }
        if (sign == 0) assert_true(before == after && ideal.width == lamp.width + 2 * BORDER);
        if (sign < 0) assert_true(after > before + 500); // a lens that had bent light out of the frame
        assert_true(after >= before - 1e-3 && (double)ideal.cx >= cx + BORDER);
        ffp_image_free(&white), ffp_image_free(&cut), ffp_image_free(&all);
    }
}

// A dot of the pattern leaves the panel where the lens moves its ray to.
static void light_leaves_the_panel_where_the_lens_says(void **state) {
    (void)state;
    FfpCamera ideal = {0};
    FfpPanel panel = {0};
    ffp_optics_pinhole(&lamp, 0, &ideal);
    FfpOptics fine = lamp; // a panel of twice the pixels
    fine.width *= 2, fine.height *= 2, fine.fx *= 2, fine.fy *= 2, fine.cx *= 2, fine.cy *= 2;
    ffp_panel_describe(&panel, &fine);
    static const int places[3][2] = {{40, 30}, {430, 60}, {250, 220}};
    for (int k = 0; k < 3; k++) {
        FfpImage pattern = ffp_image_new(lamp.width, lamp.height, 3), out;
        for (int c = 0; c < 3; c++)
            pattern.data[3 * ((size_t)places[k][1] * (size_t)lamp.width + (size_t)places[k][0]) + (size_t)c] =
                1;
        assert_true(ffp_panel_picture(&out, &panel, &ideal, &pattern, "lamp", &err));
        assert_int_equal(out.width, 2 * lamp.width);
        double at[3] = {0}, x = 0, y = 0;
        for (int i = 0; i < out.width * out.height; i++) {
            const double light = (double)out.data[3 * (size_t)i];
            at[0] += light * (i % out.width + 0.5), at[1] += light * (i / out.width + 0.5), at[2] += light;
        }
        ffp_lens_distort(fine.lens, (places[k][0] + 0.5 - lamp.cx) / lamp.fx,
                         (places[k][1] + 0.5 - lamp.cy) / lamp.fy, &x, &y);
        assert_true(fabs(at[0] / at[2] - (fine.cx + fine.fx * x)) < 0.1);
        assert_true(fabs(at[1] / at[2] - (fine.cy + fine.fy * y)) < 0.1);
        ffp_image_free(&pattern), ffp_image_free(&out);
    }
}

// The values sent make the pattern's light again, by the gamma and without one by the sRGB curve.
static void values_make_the_light(void **state) {
    (void)state;
    const FfpOptics plain = {.width = 64, .height = 32, .fx = 70, .fy = 70, .cx = 32, .cy = 16};
    FfpCamera ideal = {0};
    FfpPanel panel = {.power = true, .gamma = {1.8F, 2.2F, 1}};
    FfpImage pattern = waves(64, 32), out;
    ffp_optics_pinhole(&plain, 0, &ideal);
    ffp_panel_describe(&panel, &plain);
    assert_true(ffp_panel_picture(&out, &panel, &ideal, &pattern, "lamp", &err));
    for (int i = 0; i < 64 * 32 * 3; i++) {
        const double value = (double)ffp_srgb_encode(out.data[i]);
        assert_true(fabs(pow(value, (double)panel.gamma[i % 3]) - (double)pattern.data[i]) < 1e-4);
    }
    ffp_image_free(&out);
    panel.power = false;
    assert_true(ffp_panel_picture(&out, &panel, &ideal, &pattern, "lamp", &err));
    for (int i = 0; i < 64 * 32 * 3; i++) assert_true(fabs((double)(out.data[i] - pattern.data[i])) < 1e-5);
    ffp_image_free(&out), ffp_image_free(&pattern);
}

static void a_lens_that_folds_is_refused(void **state) {
    (void)state;
    FfpOptics folded = lamp;
    folded.lens[0] = -3;
    FfpCamera ideal = {0};
    FfpPanel panel = {0};
    FfpImage pattern = waves(lamp.width, lamp.height), out;
    ffp_optics_pinhole(&lamp, 0, &ideal);
    ffp_panel_describe(&panel, &folded);
    assert_false(ffp_panel_picture(&out, &panel, &ideal, &pattern, "projector.device", &err));
    assert_non_null(strstr(err.text, "folds the picture"));
    assert_non_null(strstr(err.text, "projector.device"));
    ffp_image_free(&pattern);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distorting_undoes_rectifying),
        cmocka_unit_test(a_frame_holds_all_light),
        cmocka_unit_test(light_leaves_the_panel_where_the_lens_says),
        cmocka_unit_test(values_make_the_light),
        cmocka_unit_test(a_lens_that_folds_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
