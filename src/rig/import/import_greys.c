// Import: the projector's response from photographs of even greys.
#include <math.h>
#include <stdlib.h>
#include "core/base/log.h"
#include "core/capture/pixel.h"
#include "core/numerics/rank.h"
#include "rig/import/import_steps.h"

#define COVERED 0.999F                                  // photographs of greys are not masked
enum { SAMPLES = 20000, LEAST = 100, GREYS_LEAST = 2 }; // lit pixels of all views

// Every `step`-th lit pixel of the views.
typedef struct Lit {
    int n, count;
    int64_t step, met;
    float bright;  // at least
    double *light; // [n + 1][3][SAMPLES]: of the greys, then black / white
} Lit;

// The light that white adds to a pixel of the object, in its darkest channel; 0: it is not lit, or clipped.
static float light_at(const FfpCapture *capture, const FfpView *view, size_t pixel) {
    const real *black = view->images[capture->black].data + 3 * pixel,
               *white = view->images[capture->white].data + 3 * pixel;
    real ratio[3], least = 1;
    if (view->coverage.data[pixel] < COVERED ||
        !ffp_lit_ratio(capture, view, &view->images[capture->white], pixel, ratio))
        return 0;
    for (int c = 0; c < 3; c++) least = white[c] - black[c] < least ? white[c] - black[c] : least;
    return (float)least;
}

// The brighter half of the lit pixels: noise that a camera cuts off at black weighs less there.
static void choose_pixels(Lit *lit, const FfpCapture *capture) {
    size_t all = 0, n = 0;
    for (int v = 0; v < capture->n_views; v++)
        all += (size_t)capture->views[v].camera.width * (size_t)capture->views[v].camera.height;
    float *lights = ffp_alloc(all, sizeof *lights);
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        const size_t pixels = (size_t)view->camera.width * (size_t)view->camera.height;
        for (size_t i = 0; i < pixels; i++)
            if (light_at(capture, view, i) > 0) lights[n++] = light_at(capture, view, i);
    }
    lit->bright = ffp_median(lights, n);
    lit->step = (int64_t)(n / 2) / SAMPLES + 1;
    ffp_free(lights);
}

static void add_pixel(Lit *lit, const FfpCapture *capture, const FfpView *view, const FfpImage *greys,
                      size_t pixel) {
    real ratio[3];
    for (int g = 0; g < lit->n; g++) {
        if (!ffp_lit_ratio(capture, view, &greys[g], pixel, ratio)) return;
        for (int c = 0; c < 3; c++) lit->light[(3 * g + c) * SAMPLES + lit->count] = (double)ratio[c];
    }
    for (int c = 0; c < 3; c++)
        lit->light[(3 * lit->n + c) * SAMPLES + lit->count] =
            (double)(view->images[capture->black].data[3 * pixel + (size_t)c] /
                     view->images[capture->white].data[3 * pixel + (size_t)c]);
    lit->count++;
}

static void add_view(Lit *lit, const FfpCapture *capture, const FfpView *view, const FfpImage *greys) {
    const size_t pixels = (size_t)view->camera.width * (size_t)view->camera.height;
    for (size_t i = 0; i < pixels && lit->count < SAMPLES; i++) {
        const float light = light_at(capture, view, i);
        if (light > 0 && light >= lit->bright && lit->met++ % lit->step == 0)
            add_pixel(lit, capture, view, greys, i);
    }
}

// Photographs are read over nothing: only pixels that are the object's through and through are looked at.
static bool look(FfpImporting *import, Lit *lit, FfpError *err) {
    const int n = lit->n;
    FfpImage *greys = ffp_alloc((size_t)n, sizeof *greys), *alphas = ffp_alloc((size_t)n, sizeof *alphas);
    bool ok = true;
    for (int v = 0; v < import->capture.n_views && ok; v++) {
        ok = ffp_importing_read_pictures(import, import->shots.greys + (ptrdiff_t)v * n, n, v, greys, alphas,
                                         err);
        if (ok) add_view(lit, &import->capture, &import->capture.views[v], greys);
        for (int g = 0; g < n; g++) ffp_image_free(&greys[g]), ffp_image_free(&alphas[g]);
    }
    ffp_free(greys), ffp_free(alphas);
    return ok;
}

static void fit(FfpImporting *import, Lit *lit, double errors[2]) {
    FfpResponse *response = &import->response;
    FfpGrey *greys = ffp_alloc((size_t)lit->n, sizeof *greys);
    const size_t count = (size_t)lit->count;
    *response = (FfpResponse){.black_known = true, .samples = lit->count};
    for (int g = 0; g < lit->n; g++) {
        greys[g].value = import->shots.grey[g] / 255.0;
        for (int c = 0; c < 3; c++)
            greys[g].light[c] = ffp_quantile(lit->light + (ptrdiff_t)(3 * g + c) * SAMPLES, count, 0.5);
    }
    for (int c = 0; c < 3; c++)
        response->black_known &= ffp_response_black(lit->light + (ptrdiff_t)(3 * lit->n + c) * SAMPLES, count,
                                                    &response->black[c]);
    ffp_fit_greys(response, greys, lit->n, import->settings->linear_patterns, errors);
    ffp_free(greys);
}

bool ffp_importing_has_greys(const FfpImporting *import) {
    return import->shots.n_greys >= GREYS_LEAST;
}

bool ffp_importing_fit_greys(FfpImporting *import, bool *enough, double errors[2], FfpError *err) {
    const int n = import->shots.n_greys;
    Lit lit = {.n = n};
    choose_pixels(&lit, &import->capture);
    lit.light = ffp_alloc((size_t)(3 * (n + 1)) * SAMPLES, sizeof *lit.light);
    const bool ok = look(import, &lit, err);
    *enough = lit.count >= LEAST;
    if (ok && *enough) fit(import, &lit, errors);
    if (ok && !*enough)
        ffp_note("only %d pixels are lit and not clipped: greys need %d to tell the projector's response",
                 lit.count, LEAST);
    ffp_free(lit.light);
    return ok;
}
