// The wide lobe of a projector's light, found again from photographs of stripes where codes place the pixels;
// and what it does to a picture.
#include <math.h>
#include "core/base/rng.h"
#include "core/image/lookup.h"
#include "rig/response/spread.h"
#include "support.h"

enum { CAMERA = 80, PROJECTOR = 480, PATTERNS = 6 };
#define ACROSS 5.0 // pixels of the projector that one of the camera's covers

static const int widths[PATTERNS] = {0, PROJECTOR, 120, 60, 40, 30}; // of stripes; black and white first

static FfpImage stripes(int wide, int axis) {
    FfpImage image = ffp_image_new(PROJECTOR, PROJECTOR, 3);
    for (int i = 0; wide && i < PROJECTOR * PROJECTOR * 3; i++) {
        const int at = axis ? i / 3 / PROJECTOR : i / 3 % PROJECTOR;
        image.data[i] = wide == PROJECTOR || at / wide % 2 ? 1 : 0;
    }
    return image;
}

typedef struct Rig {
    FfpImage images[PATTERNS];
    FfpPattern patterns[PATTERNS];
    FfpView view;
    FfpCapture capture;
} Rig;

static void photograph(Rig *rig, int p, const real share[3], real reach) {
    FfpImage sent = ffp_image_copy(&rig->patterns[p].image);
    ffp_image_spread(&sent, share, reach);
    FfpSummed summed = ffp_summed_new(&sent);
    FfpRng rng = ffp_rng(3, (uint64_t)p + 1);
    for (int i = 0; i < CAMERA * CAMERA; i++) {
        const real *at = rig->view.correspondence.data + 3 * i;
        real light[3];
        ffp_lookup(&summed, at[0], at[1], (real)ACROSS, (real)ACROSS, light);
        for (int c = 0; c < 3; c++) {
            const double lamp = 0.3 + 0.1 * (i % 5), noise = 0.0005 * (double)ffp_rng_normal(&rng);
            rig->images[p].data[3 * i + c] = (real)(0.004 + lamp * (double)light[c] + noise);
        }
    }
    ffp_summed_free(&summed), ffp_image_free(&sent);
}

static void rig_make(Rig *rig, const real share[3], real reach) {
    *rig = (Rig){.view = {.images = rig->images, .correspondence = ffp_image_new(CAMERA, CAMERA, 3)},
                 .capture = {.patterns = rig->patterns,
                             .n_patterns = PATTERNS,
                             .n_codes = PATTERNS - 2,
                             .views = &rig->view,
                             .n_views = 1,
                             .white = 1}};
    rig->view.camera.width = rig->view.camera.height = CAMERA;
    rig->view.projector.width = rig->view.projector.height = PROJECTOR;
    for (int i = 0; i < CAMERA * CAMERA; i++) {
        real *at = rig->view.correspondence.data + 3 * i;
        at[0] = (real)(40 + ACROSS * (i % CAMERA + 0.5)), at[1] = (real)(40 + ACROSS * (i / CAMERA + 0.5));
        at[2] = 1;
    }
    for (int p = 0; p < PATTERNS; p++) {
        rig->patterns[p] = (FfpPattern){.image = stripes(widths[p], p % 2), .novel = p > 1};
        rig->images[p] = ffp_image_new(CAMERA, CAMERA, 3);
        photograph(rig, p, share, reach);
    }
}

static void rig_free(Rig *rig) {
    for (int p = 0; p < PATTERNS; p++) {
        ffp_image_free(&rig->patterns[p].image);
        ffp_image_free(&rig->images[p]);
    }
    ffp_image_free(&rig->view.correspondence);
}

static void spread_is_found(void **state) {
    (void)state;
    static const real shares[2][3] = {{0.04F, 0.02F, 0.01F}, {0.06F, 0.06F, 0.06F}}, reaches[2] = {6, 11};
    for (int n = 0; n < 2; n++) {
        Rig rig;
        rig_make(&rig, shares[n], reaches[n]);
        const FfpSpread found = ffp_fit_spread(&rig.capture);
        assert_true(found.after > found.before + 1);
        if (!(fabsf(found.reach / reaches[n] - 1) < 0.35F))
            fail_msg("%.1f pixels instead of %.1f", (double)found.reach, (double)reaches[n]);
        for (int c = 0; c < 3; c++)
            if (!(fabsf(found.share[c] / shares[n][c] - 1) < 0.15F))
                fail_msg("a share of %.4f instead of %.4f", (double)found.share[c], (double)shares[n][c]);
        rig_free(&rig);
    }
}

static void nothing_is_found_where_nothing_is(void **state) {
    (void)state;
    static const real none[3] = {0, 0, 0}, some[3] = {0.05F, 0.05F, 0.05F};
    Rig rig;
    rig_make(&rig, none, 0);
    assert_true(ffp_fit_spread(&rig.capture).reach == 0);
    rig_free(&rig);
    rig_make(&rig, some, 8);
    rig.capture.n_patterns = 3, rig.capture.n_codes = 1; // one pattern cannot be judged by another
    assert_true(ffp_fit_spread(&rig.capture).reach == 0);
    rig.capture.n_patterns = PATTERNS, rig.capture.n_codes = 0; // all are held out
    assert_true(ffp_fit_spread(&rig.capture).reach == 0);
    rig_free(&rig);
}

// Reducing first changes little, light is kept, and one colour stays to the bit.
static void pictures_are_spread(void **state) {
    (void)state;
    static const real all[3] = {1, 1, 1}, some[3] = {0.1F, 0, 0.05F};
    FfpImage image = stripes(60, 0), exact = ffp_image_copy(&image), white = stripes(PROJECTOR, 0);
    ffp_image_spread(&image, all, 22);
    ffp_image_blur(&exact, 22);
    double most = 0;
    for (int i = 0; i < PROJECTOR * PROJECTOR * 3; i++)
        most = fmax(most, fabs((double)(image.data[i] - exact.data[i])));
    if (!(most < 0.01)) fail_msg("off by %.4f", most);
    ffp_image_spread(&white, some, 22);
    for (int i = 0; i < PROJECTOR * PROJECTOR * 3; i++) assert_true(white.data[i] == 1);
    ffp_image_spread(&exact, some, 0);
    ffp_image_free(&image), ffp_image_free(&exact), ffp_image_free(&white);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(spread_is_found),
                                       cmocka_unit_test(nothing_is_found_where_nothing_is),
                                       cmocka_unit_test(pictures_are_spread)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
