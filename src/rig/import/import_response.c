// Import: the projector's response from the pictures.
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/capture/manifest.h"
#include "rig/import/checks.h"
#include "rig/import/import_steps.h"

static void log_response(const FfpResponse *r, double before, double after) {
    ffp_note(
        "projector gamma %.3f %.3f %.3f (+- %.2g %.2g %.2g), from %d pixels; pattern lookup %.1f dB, before "
        "%.1f",
        r->gamma[0], r->gamma[1], r->gamma[2], r->gamma_deviation[0], r->gamma_deviation[1],
        r->gamma_deviation[2], r->samples, -20 * log10(after), -20 * log10(before));
    ffp_note("  black level %s%.4f %.4f %.4f of white%s", r->black_known ? "" : "at most ", r->black[0],
             r->black[1], r->black[2],
             r->black_known ? "" : " (the room's light hides it: photograph in the dark to know)");
}

// Patterns become the light that the projector made of them.
bool ffp_importing_find_response(FfpImporting *import, FfpError *err) {
    FfpCapture *capture = &import->capture;
    const bool linear = import->settings->linear_patterns;
    capture->panel.power = linear || import->settings->fit_response;
    for (int c = 0; c < 3; c++) capture->panel.gamma[c] = 1;
    if (!import->settings->fit_response) return true;
    const int active = ffp_capture_active_pattern(capture, NULL, err);
    if (active < 0 || !ffp_fit_response(&import->response, capture, active, linear, err)) return false;
    const double before = ffp_rig_explain(capture, active).error;
    for (int p = 0; p < capture->n_patterns; p++) {
        if (p != capture->black && p != capture->white)
            ffp_response_apply(&import->response, linear, &capture->patterns[p].image);
    }
    for (int c = 0; c < 3; c++) {
        capture->intensity[c] = (real)import->response.intensity;
        capture->panel.gamma[c] = (real)import->response.gamma[c];
    }
    capture->intensity_known = true;
    const FfpExplanation found = ffp_rig_explain(capture, active);
    if (!(found.error < FFP_CHANCE_MAX * found.chance))
        return ffp_fail(err, FFP_ERROR_FILE, "fit_response",
                        "with the best response the pattern explains the pictures hardly better than chance: "
                        "check poses and the pattern's file");
    log_response(&import->response, before, found.error);
    return true;
}

// Puts the response into the capture's JSON: what was found is kept though patterns hold it already.
bool ffp_importing_keep_response(const char *folder, const FfpImporting *import, FfpError *err) {
    char path[FFP_PATH_MAX];
    FfpNode root;
    const FfpResponse *r = &import->response;
    if (!import->settings->fit_response) return true;
    if (!ffp_join_path(path, folder, "scene.json"))
        return ffp_fail(err, FFP_ERROR_FILE, folder, "the path is too long");
    if (!ffp_node_open(&root, path, err)) return false;
    json_t *response =
        json_pack("{s:[f,f,f], s:[f,f,f], s:b}", "gamma", r->gamma[0], r->gamma[1], r->gamma[2],
                  "black_level", r->black[0], r->black[1], r->black[2], "black_level_known", r->black_known);
    json_object_set_new(json_object_get(root.value, "projector"), "response", response);
    char *text = json_dumps(root.value, JSON_INDENT(1) | JSON_REAL_PRECISION(9));
    ffp_node_close(&root);
    const bool ok = text ? ffp_write_file(path, text, strlen(text), err)
                         : ffp_fail(err, FFP_ERROR_IO, path, "cannot write the JSON");
    free(text);
    return ok;
}
