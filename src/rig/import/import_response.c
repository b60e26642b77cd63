// Import: the projector's response from the pictures.
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/capture/manifest.h"
#include "core/capture/panel.h"
#include "rig/checks/measure.h"
#include "rig/findings/tell.h"
#include "rig/import/import_steps.h"
#include "rig/response/softness.h"

#define BETTER 0.99       // of the error without a response: what one must reach to be kept
#define GREYS_OFF 0.01    // of white: a smaller error on greys may be the photographs' own
enum { HALVES_FROM = 4 }; // views, of which every other one is held out

static double decibels(double error) {
    return -20 * log10(error);
}

static void log_black(const FfpResponse *r) {
    ffp_note("  black level %s%.4f %.4f %.4f of white%s", r->black_known ? "" : "at most ", r->black[0],
             r->black[1], r->black[2],
             r->black_known ? "" : " (hidden by the room's light: to measure it, photograph in the dark)");
}

static void log_response(const FfpResponse *r, const double errors[2]) {
    ffp_note("projector gamma %.3f %.3f %.3f (+- %.2g %.2g %.2g), from %d pixels; pattern lookup in views "
             "held out "
             "%.1f dB, before %.1f",
             r->gamma[0], r->gamma[1], r->gamma[2], r->gamma_deviation[0], r->gamma_deviation[1],
             r->gamma_deviation[2], r->samples, decibels(errors[1]), decibels(errors[0]));
    log_black(r);
}

// Every other view of a capture, from `first` on; all of them where they are few. Only the list is owned.
static FfpCapture half_of(const FfpCapture *capture, int first) {
    FfpCapture half = *capture;
    const int step = capture->n_views < HALVES_FROM ? 1 : 2;
    half.views = ffp_alloc((size_t)capture->n_views, sizeof *half.views);
    half.n_views = 0;
    for (int v = step == 1 ? 0 : first; v < capture->n_views; v += step)
        half.views[half.n_views++] = capture->views[v];
    return half;
}

// How far the pattern is from explaining views, without a response and with the one of the other views.
static bool try_response(const FfpImporting *import, int active, double errors[2], FfpError *err) {
    const bool linear = import->settings->linear_patterns;
    FfpCapture fitted = half_of(&import->capture, 0), checked = half_of(&import->capture, 1);
    FfpResponse response;
    const bool ok = ffp_fit_response(&response, &fitted, active, linear, err);
    if (ok) {
        errors[0] = ffp_rig_explain(&checked, active).error;
        FfpPattern *patterns = ffp_alloc((size_t)checked.n_patterns, sizeof *patterns);
        memcpy(patterns, checked.patterns, (size_t)checked.n_patterns * sizeof *patterns);
        patterns[active].image = ffp_image_copy(&checked.patterns[active].image);
        ffp_response_apply(&response, linear, &patterns[active].image);
        checked.patterns = patterns;
        errors[1] = ffp_rig_explain(&checked, active).error;
        ffp_image_free(&patterns[active].image);
        ffp_free(patterns);
    }
    ffp_free(fitted.views);
    ffp_free(checked.views);
    return ok;
}

static void take_response(FfpImporting *import) {
    FfpCapture *capture = &import->capture;
    for (int p = 0; p < capture->n_patterns; p++)
        if (p != capture->black && p != capture->white)
            ffp_response_apply(&import->response, import->settings->linear_patterns,
                               &capture->patterns[p].image);
    for (int c = 0; c < 3; c++) capture->panel.gamma[c] = (real)import->response.gamma[c];
    capture->panel.power = import->has_response = true;
}

// Greys tell more than a pattern, without depth.
static bool find_by_greys(FfpImporting *import, FfpError *err) {
    const FfpResponse *r = &import->response;
    const char *plain = import->settings->linear_patterns ? "linear" : "sRGB";
    double errors[2];
    bool enough;
    if (!ffp_importing_fit_greys(import, &enough, errors, err)) return false;
    if (!enough) return true;
    const bool better = errors[0] > GREYS_OFF && errors[1] < BETTER * errors[0];
    ffp_note(
        "projector gamma %.3f %.3f %.3f (+- %.2g %.2g %.2g), from %d greys%s; on greys left out it is off "
        "by %.4f (rms), %s by %.4f",
        r->gamma[0], r->gamma[1], r->gamma[2], r->gamma_deviation[0], r->gamma_deviation[1],
        r->gamma_deviation[2], import->shots.n_greys, better ? "" : ", is not kept", errors[1], plain,
        errors[0]);
    if (!better) return true;
    log_black(r);
    take_response(import);
    return true;
}

// Patterns become the light that the projector made of them, where that makes them explain views better that
// had no part in it.
bool ffp_importing_find_response(FfpImporting *import, FfpError *err) {
    FfpCapture *capture = &import->capture;
    double errors[2];
    capture->panel.power = import->settings->linear_patterns;
    for (int c = 0; c < 3; c++) capture->panel.gamma[c] = 1;
    if (ffp_importing_has_greys(import)) return find_by_greys(import, err);
    if (!import->settings->fit_response) return true;
    const int active = ffp_capture_active_pattern(capture, NULL, err);
    if (active < 0 ||
        !ffp_fit_response(&import->response, capture, active, import->settings->linear_patterns, err) ||
        !try_response(import, active, errors, err))
        return false;
    if (!(errors[1] < BETTER * errors[0])) {
        char gamma[64];
        const double *g = import->response.gamma;
        snprintf(gamma, sizeof gamma, "%.2f %.2f %.2f", g[0], g[1], g[2]);
        ffp_tell(FFP_RULE_RESPONSE, &(FfpFacts){.a = gamma,
                                                .b = import->settings->linear_patterns ? "linear" : "sRGB",
                                                .x = decibels(errors[1]),
                                                .y = decibels(errors[0])});
        return true;
    }
    take_response(import);
    for (int c = 0; c < 3; c++) capture->intensity[c] = (real)import->response.intensity;
    capture->intensity_known = true;
    const FfpExplanation found = ffp_rig_explain(capture, active);
    if (!(found.error < FFP_RIG_CHANCE_MAX * found.chance))
        return ffp_fail(err, FFP_ERROR_FILE, "fit_response",
                        "with the best response the pattern explains the pictures hardly better than chance: "
                        "check poses and the pattern's file");
    log_response(&import->response, errors);
    return true;
}

static void note_softness(const FfpPanel *panel, const FfpSpread *spread) {
    if (panel->blur > 0)
        ffp_note(
            "the patterns reach the camera through a blur of %.1f of the projector's pixels (deviation): "
            "they are kept as soft as that",
            (double)panel->blur);
    if (panel->spread_reach > 0)
        ffp_note("%.1f %.1f %.1f %% of the projector's light (red, green, blue) spread over some %.0f of its "
                 "pixels: the patterns are kept so (photographs of codes left out: %.1f dB, without it %.1f)",
                 100 * (double)panel->spread[0], 100 * (double)panel->spread[1],
                 100 * (double)panel->spread[2], (double)panel->spread_reach, spread->after, spread->before);
}

// Patterns become as soft as they reached the camera.
void ffp_importing_find_softness(FfpImporting *import) {
    FfpCapture *capture = &import->capture;
    const FfpSoftness found = ffp_fit_softness(capture);
    capture->panel.blur = (real)found.blur;
    capture->panel.spread_reach = found.spread.reach;
    memcpy(capture->panel.spread, found.spread.share, sizeof capture->panel.spread);
    for (int p = 0; p < capture->n_patterns; p++)
        ffp_panel_soften(&capture->panel, &capture->patterns[p].image);
    note_softness(&capture->panel, &found.spread);
}

// Puts the response into the capture's JSON: what was found is kept though patterns hold it already.
bool ffp_importing_keep_response(const char *folder, const FfpImporting *import, FfpError *err) {
    const FfpResponse *r = &import->response;
    if (!import->has_response) return true;
    return ffp_scene_json_add(folder, "projector", "response",
                              json_pack("{s:[f,f,f], s:[f,f,f], s:b}", "gamma", r->gamma[0], r->gamma[1],
                                        r->gamma[2], "black_level", r->black[0], r->black[1], r->black[2],
                                        "black_level_known", r->black_known),
                              err);
}
