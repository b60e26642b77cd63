// How well Gaussians reproduce photographs, view by view. Of a picture there is one copy at a time.
#include "core/base/arena.h"
#include "engine/loss/metrics.h"
#include "engine/refine/refine.h"
#include "engine/render/pass.h"

typedef struct Score {
    const FfpCapture *capture;
    const int *patterns;
    int n_patterns;
    FfpSummed *light; // [n_patterns], zeros for black
    FfpViewPass *pass;
} Score;

// Mean over the view's photographs, added to *psnr.
static void add_view(const Score *s, const FfpGaussians *gaussians, const FfpView *view, double *psnr) {
    int shown = 0;
    FfpImage picture = ffp_image_new(view->camera.width, view->camera.height, 3);
    for (int p = 0; p < s->n_patterns; p++) shown += view->images[s->patterns[p]].data != NULL;
    ffp_view_pass_draw(s->pass, gaussians, &view->camera, &view->projector);
    for (int p = 0; p < s->n_patterns; p++) {
        const FfpImage *photograph = &view->images[s->patterns[p]];
        if (!photograph->data) continue;
        const bool dark = s->patterns[p] == s->capture->black;
        FfpImage target = ffp_image_copy(photograph);
        ffp_image_to_srgb(&target);
        ffp_view_pass_shade(s->pass, s->capture->intensity, dark ? NULL : &s->light[p], &picture);
        *psnr += ffp_psnr(&picture, &target) / shown;
        ffp_image_free(&target);
    }
    ffp_image_free(&picture);
}

void ffp_photographs_psnr_by_view(const FfpGaussians *gaussians, const FfpCapture *capture,
                                  const int *patterns, int n_patterns, const FfpRenderSettings *render,
                                  double *psnr) {
    Score s = {capture, patterns, n_patterns, ffp_alloc((size_t)n_patterns, sizeof *s.light),
               ffp_view_pass_new(render)};
    for (int p = 0; p < n_patterns; p++)
        if (patterns[p] != capture->black)
            s.light[p] = ffp_pattern_summed(&capture->patterns[patterns[p]].image);
    for (int v = 0; v < capture->n_views; v++) {
        psnr[v] = 0;
        add_view(&s, gaussians, &capture->views[v], &psnr[v]);
    }
    for (int p = 0; p < n_patterns; p++) ffp_summed_free(&s.light[p]);
    ffp_view_pass_free(s.pass);
    ffp_free(s.light);
}
