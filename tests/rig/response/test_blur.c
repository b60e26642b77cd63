// The blur between a pattern and its photographs, found again where Gray codes say what each pixel sees.
#include <math.h>
#include "core/image/lookup.h"
#include "rig/response/blur.h"
#include "support.h"

enum { CAMERA = 80, PROJECTOR = 240 };
#define ACROSS 2.5 // pixels of the projector that one of the camera's covers

static FfpImage stripes(int wide) {
    FfpImage image = ffp_image_new(PROJECTOR, PROJECTOR, 3);
    for (int i = 0; i < PROJECTOR * PROJECTOR * 3; i++) image.data[i] = (real)(i / 3 % PROJECTOR / wide % 2);
    return image;
}

// Albedo, room light and what the camera adds differ from pixel to pixel; a few pixels are wrong altogether.
static void photograph(FfpCapture *capture, const FfpImage *pattern, double blur) {
    FfpView *view = &capture->views[0];
    FfpImage soft = ffp_image_copy(pattern);
    ffp_image_blur(&soft, (real)blur);
    FfpSummed summed = ffp_summed_new(&soft);
    for (int i = 0; i < CAMERA * CAMERA; i++) {
        real *at = view->correspondence.data + 3 * i, colour[3];
        at[0] = (real)(8 + ACROSS * (i % CAMERA + 0.5)), at[1] = (real)(8 + ACROSS * (i / CAMERA + 0.5)),
        at[2] = 1;
        ffp_lookup(&summed, at[0], at[1], (real)ACROSS, (real)ACROSS, colour);
        for (int c = 0; c < 3; c++) {
            const double black = 0.01 * (1 + i % 3), lamp = 0.3 + 0.1 * (i % 5) + 0.05 * c;
            view->images[0].data[3 * i + c] = (real)black;
            view->images[1].data[3 * i + c] = (real)(black + lamp);
            view->images[2].data[3 * i + c] = (real)(black + lamp * (i % 97 ? (double)colour[c] : 0.5));
        }
    }
    ffp_summed_free(&summed), ffp_image_free(&soft);
}

static double found(const FfpImage *pattern, double blur) {
    FfpImage images[3];
    FfpPattern patterns[3] = {{.name = "black"}, {.name = "white"}, {.name = "stripes", .image = *pattern}};
    FfpView view = {.images = images, .correspondence = ffp_image_new(CAMERA, CAMERA, 3)};
    FfpCapture capture = {.patterns = patterns, .n_patterns = 3, .views = &view, .n_views = 1, .white = 1};
    view.camera.width = view.camera.height = CAMERA;
    for (int p = 0; p < 3; p++) images[p] = ffp_image_new(CAMERA, CAMERA, 3);
    photograph(&capture, pattern, blur);
    const double out = ffp_fit_blur(&capture);
    for (int p = 0; p < 3; p++) ffp_image_free(&images[p]);
    ffp_image_free(&view.correspondence);
    return out;
}

static void blur_is_found(void **state) {
    (void)state;
    FfpImage pattern = stripes(12);
    for (double blur = 0.8; blur < 4; blur *= 1.5) {
        const double is = found(&pattern, blur);
        if (!(fabs(is / blur - 1) < 0.12)) fail_msg("%.2f pixels instead of %.2f", is, blur);
    }
    assert_true(found(&pattern, 0) < 0.3);
    ffp_image_free(&pattern);
}

static void no_edge_tells_nothing(void **state) {
    (void)state;
    FfpImage pattern = stripes(PROJECTOR);
    assert_true(found(&pattern, 2) == 0);
    ffp_image_free(&pattern);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(blur_is_found),
                                       cmocka_unit_test(no_edge_tells_nothing)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
