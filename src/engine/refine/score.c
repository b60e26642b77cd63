// How well Gaussians reproduce photographs, view by view. Of a picture there is one copy at a time.
#include <math.h>
#include "core/base/arena.h"
#include "engine/loss/metrics.h"
#include "engine/refine/refine.h"
#include "engine/render/pass.h"

#define LIT 0.01F // of white's photograph, linear: darker pixels are not lit

typedef struct Score {
    const FfpCapture *capture;
    const int *patterns;
    int n_patterns, n_unseen;
    FfpSummed *light; // [n_patterns], zeros for black
    FfpViewPass *pass;
} Score;

// 1 for the pixels of the object that white lights.
static FfpImage lit_pixels(const FfpView *view, const FfpImage *white) {
    FfpImage mask = ffp_image_new(white->width, white->height, 1);
    for (size_t i = 0; i < (size_t)mask.width * (size_t)mask.height; i++) {
        const real *light = white->data + 3 * i;
        mask.data[i] = view->coverage.data[i] > 0.5F && (light[0] > LIT || light[1] > LIT || light[2] > LIT);
    }
    return mask;
}

// The picture beside a photograph, added to the mean of `shown` of them.
static void add_picture(const FfpImage *picture, const FfpImage *photograph, const FfpImage *mask, int shown,
                        double *psnr, double *lit) {
    FfpImage target = ffp_image_copy(photograph);
    ffp_image_to_srgb(&target);
    *psnr += ffp_psnr(picture, &target) / shown;
    *lit += ffp_psnr_masked(picture, &target, mask) / shown;
    ffp_image_free(&target);
}

static FfpViewScore score_view(const Score *s, const FfpGaussians *gaussians, const FfpView *view) {
    const int given = s->n_patterns - s->n_unseen;
    int shown[2] = {0};
    FfpViewScore score = {0};
    FfpImage picture = ffp_image_new(view->camera.width, view->camera.height, 3),
             mask = lit_pixels(view, &view->images[s->capture->white]);
    for (int p = 0; p < s->n_patterns; p++) shown[p >= given] += view->images[s->patterns[p]].data != NULL;
    ffp_view_pass_draw(s->pass, gaussians, &view->camera, &view->projector);
    for (int p = 0; p < s->n_patterns; p++) {
        const FfpImage *photograph = &view->images[s->patterns[p]];
        if (!photograph->data) continue;
        const bool dark = s->patterns[p] == s->capture->black, unseen = p >= given;
        ffp_view_pass_shade(s->pass, s->capture->intensity, dark ? NULL : &s->light[p], &picture);
        add_picture(&picture, photograph, &mask, shown[unseen], unseen ? &score.unseen : &score.psnr,
                    unseen ? &score.unseen_lit : &score.lit);
    }
    if (shown[1] == 0) score.unseen = score.unseen_lit = NAN;
    ffp_image_free(&picture);
    ffp_image_free(&mask);
    return score;
}

void ffp_photographs_score(const FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns,
                           int n_patterns, int n_unseen, const FfpRenderSettings *render,
                           FfpViewScore *scores) {
    Score s = {capture,
               patterns,
               n_patterns,
               n_unseen,
               ffp_alloc((size_t)n_patterns, sizeof *s.light),
               ffp_view_pass_new(render)};
    for (int p = 0; p < n_patterns; p++)
        if (patterns[p] != capture->black)
            s.light[p] = ffp_pattern_summed(&capture->patterns[patterns[p]].image);
    for (int v = 0; v < capture->n_views; v++) scores[v] = score_view(&s, gaussians, &capture->views[v]);
    for (int p = 0; p < n_patterns; p++) ffp_summed_free(&s.light[p]);
    ffp_view_pass_free(s.pass);
    ffp_free(s.light);
}
