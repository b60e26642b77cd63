// The gradient of a fit's step, through all pictures of a view, against central differences.
#include "core/base/alloc.h"
#include "engine/refine/fit.h"
#include "engine/render/gradients.h"
#include "support.h"

enum { BLACK, WHITE, DOTS, MORE_DOTS, PATTERNS, WIDTH = 17, HEIGHT = 13, LIGHT = 15, SPLATS = 12 };

static const int all_patterns[] = {BLACK, WHITE, DOTS, MORE_DOTS};

typedef struct Case {
    FfpCapture capture;
    FfpRefineSettings settings;
    FfpPhotoLoss *viewer;
    FfpGaussians gaussians;
    int view;
} Case;

static FfpImage noise_image(int width, int height, FfpRng *rng) {
    FfpImage image = ffp_image_new(width, height, 3);
    for (int i = 0; i < 3 * width * height; i++) image.data[i] = between(rng, 0.05, 0.95);
    return image;
}

// Two views of which the second lacks a photograph. Footprints, visibility and the weights of smoothness are
// constants of the backward pass: here they do not change.
static Case new_case(void) {
    static const real eyes[2][3] = {{2.1, -1.7, 1.1}, {-1.9, 1.8, 0.9}}, light[3] = {1.0, -1.6, 1.7},
                      origin[3] = {0};
    FfpRng rng = ffp_rng(11, 1);
    Case c = {.capture = {.n_patterns = PATTERNS,
                          .n_views = 2,
                          .patterns = ffp_alloc(PATTERNS, sizeof *c.capture.patterns),
                          .views = ffp_alloc(2, sizeof *c.capture.views),
                          .black = BLACK,
                          .white = WHITE,
                          .intensity = {2, 2.5, 3},
                          .radius = 1},
              .settings = ffp_polish_defaults(1),
              .gaussians = random_gaussians(SPLATS, 15, 0.5, 0.05, 0.3, 0.3, 0.95)};
    c.settings.render.footprint = c.settings.render.shadows = false;
    c.settings.roughness_smooth = c.settings.normal_smooth = 0;
    for (int p = 0; p < PATTERNS; p++) c.capture.patterns[p].image = noise_image(LIGHT, LIGHT, &rng);
    for (int v = 0; v < 2; v++) {
        FfpView *view = &c.capture.views[v];
        view->camera = look_at(WIDTH, HEIGHT, 12, eyes[v], origin);
        view->projector = look_at(LIGHT, LIGHT, 14, light, origin);
        view->coverage = ffp_image_new(WIDTH, HEIGHT, 1);
        for (int i = 0; i < WIDTH * HEIGHT; i++) view->coverage.data[i] = between(&rng, 0, 1);
        view->images = ffp_alloc(PATTERNS, sizeof *view->images);
        for (int p = 0; p < PATTERNS; p++)
            if (v == 0 || p != DOTS) view->images[p] = noise_image(WIDTH, HEIGHT, &rng);
    }
    return c;
}

static void free_case(Case *c) {
    ffp_photo_loss_free(c->viewer);
    ffp_gaussians_free(&c->gaussians);
    ffp_capture_free(&c->capture);
}

static double loss_of(void *context) {
    Case *c = context;
    FfpGaussians grad = ffp_gaussians_new(SPLATS);
    FfpFitLoss loss = {0};
    ffp_photo_loss_backward(c->viewer, &c->gaussians, &(FfpFitView){c->view, 1, &grad, &loss}, 1);
    ffp_gaussians_free(&grad);
    return loss.pictures + loss.maps;
}

static void gradient_of_all_pictures(void **state) {
    (void)state;
    Case c = new_case();
    c.viewer = ffp_photo_loss_new(&c.capture, all_patterns, PATTERNS, &c.settings);
    for (c.view = 0; c.view < 2; c.view++) {
        FfpGaussians grad = ffp_gaussians_new(SPLATS);
        FfpFitLoss loss = {0};
        Field fields[FIELDS], analytic[FIELDS];
        ffp_photo_loss_backward(c.viewer, &c.gaussians, &(FfpFitView){c.view, 1, &grad, &loss}, 1);
        gaussian_fields(&c.gaussians, fields), gaussian_fields(&grad, analytic);
        for (int k = 0; k < FIELDS; k++)
            check_field(c.view ? "three pictures" : "four pictures", &fields[k], analytic[k].data, loss_of,
                        &c);
        ffp_gaussians_free(&grad);
    }
    free_case(&c);
}

// The loss of a view's pictures is their mean, whichever it lacks; each is what a fit to it alone would see.
static void all_pictures_count_alike(void **state) {
    (void)state;
    Case c = new_case();
    double pictures[2][PATTERNS] = {{0}};
    for (int p = 0; p < PATTERNS; p++) {
        c.viewer = ffp_photo_loss_new(&c.capture, &all_patterns[p], 1, &c.settings);
        for (int v = 0; v < 2; v++) {
            FfpGaussians grad = ffp_gaussians_new(SPLATS);
            FfpFitLoss loss = {0};
            if (c.capture.views[v].images[p].data)
                ffp_photo_loss_backward(c.viewer, &c.gaussians, &(FfpFitView){v, 1, &grad, &loss}, 1);
            pictures[v][p] = loss.pictures;
            ffp_gaussians_free(&grad);
        }
        ffp_photo_loss_free(c.viewer);
    }
    c.viewer = ffp_photo_loss_new(&c.capture, all_patterns, PATTERNS, &c.settings);
    for (int v = 0; v < 2; v++) {
        FfpGaussians grad = ffp_gaussians_new(SPLATS);
        FfpFitLoss loss = {0};
        double sum = 0;
        for (int p = 0; p < PATTERNS; p++) sum += pictures[v][p];
        ffp_photo_loss_backward(c.viewer, &c.gaussians, &(FfpFitView){v, 1, &grad, &loss}, 1);
        assert_true(sum > 0.1 && fabs(loss.pictures - sum / (v ? 3 : 4)) < 1e-12);
        ffp_gaussians_free(&grad);
    }
    ffp_photo_loss_free(c.viewer);
    c.settings.codes = 2; // black and white, and of the others one at a step: the second view lacks one
    c.viewer = ffp_photo_loss_new(&c.capture, all_patterns, PATTERNS, &c.settings);
    for (int v = 0; v < 2; v++)
        for (int step = 1; step <= 6; step++) {
            const int code = v || (step - 1) / 2 % 2 ? MORE_DOTS : DOTS;
            FfpGaussians grad = ffp_gaussians_new(SPLATS);
            FfpFitLoss loss = {0};
            ffp_photo_loss_backward(c.viewer, &c.gaussians, &(FfpFitView){v, step, &grad, &loss}, 1);
            const double lit = pictures[v][WHITE] + pictures[v][code];
            assert_true(fabs(loss.pictures - pictures[v][BLACK] / 2 - lit / 4) < 1e-12);
            ffp_gaussians_free(&grad);
        }
    c.settings.codes = 0;
    ffp_photo_loss_free(c.viewer);
    c.viewer = ffp_photo_loss_new(&c.capture, all_patterns, PATTERNS, &c.settings);
    c.settings.one_picture = true; // in turn: the view that lacks one skips it
    static const int turns[2][4] = {{WHITE, DOTS, MORE_DOTS, BLACK}, {WHITE, MORE_DOTS, BLACK, WHITE}};
    for (int v = 0; v < 2; v++)
        for (int step = 1; step <= 4; step++) {
            FfpGaussians grad = ffp_gaussians_new(SPLATS);
            FfpFitLoss loss = {0};
            ffp_photo_loss_backward(c.viewer, &c.gaussians, &(FfpFitView){v, step, &grad, &loss}, 1);
            assert_true(fabs(loss.pictures - pictures[v][turns[v][step - 1]]) < 1e-12);
            ffp_gaussians_free(&grad);
        }
    free_case(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(gradient_of_all_pictures),
                                       cmocka_unit_test(all_pictures_count_alike)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
