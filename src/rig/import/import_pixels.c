// Import: patterns and photographs as linear light without lens distortion.
#include <math.h>
#include <string.h>
#include "core/base/log.h"
#include "core/patterns/patterns.h"
#include "rig/findings/tell.h"
#include "rig/import/import_steps.h"
#include "rig/masks/masks.h"

FfpImage ffp_importing_code_pattern(const FfpOptics *panel, int index) {
    const int columns = ffp_gray_code_bits(panel->width), pair = index / 2, axis = pair >= columns;
    FfpImage grey = ffp_pattern_gray_code(panel->width, panel->height, axis, axis ? pair - columns : pair,
                                          index % 2 == 1);
    FfpImage out = ffp_image_new(panel->width, panel->height, 3);
    const size_t count = 3 * (size_t)out.width * (size_t)out.height;
    for (size_t i = 0; i < count; i++) out.data[i] = grey.data[i / 3];
    ffp_image_free(&grey);
    return out;
}

static bool load_pattern(FfpImporting *import, int index, FfpError *err) {
    FfpPattern *pattern = &import->capture.patterns[index];
    const FfpShotPattern *shot = &import->shots.patterns[index];
    const FfpOptics *optics = &import->calibration.projector;
    const FfpCamera *pinhole = &import->capture.views[0].projector;
    FfpImage raw = {0};
    memcpy(pattern->name, shot->name, sizeof pattern->name);
    pattern->novel = shot->novel;
    if (shot->file) {
        if (!ffp_importing_check_size(shot->file, optics, err) ||
            !(import->settings->linear_patterns ? ffp_image_read_light
                                                : ffp_image_read_over_black)(&raw, NULL, shot->file, err))
            return false;
    } else if (shot->code > 0) {
        raw = ffp_importing_code_pattern(optics, shot->code - 1);
    } else {
        raw = ffp_image_new(optics->width, optics->height, 3);
        const ptrdiff_t count = (ptrdiff_t)raw.width * raw.height * 3;
        for (ptrdiff_t i = 0; i < count; i++) raw.data[i] = index == import->shots.white;
    }
    pattern->image = ffp_optics_rectify(optics, pinhole, &raw);
    ffp_image_free(&raw);
    return true;
}

static bool load_view(FfpImporting *import, int stop, FfpError *err) {
    const int n = import->shots.n_patterns;
    FfpView *view = &import->capture.views[stop];
    FfpImage *alphas = ffp_alloc((size_t)n, sizeof *alphas);
    view->images = ffp_alloc((size_t)n + (size_t)ffp_importing_codes_looked_at(import), sizeof *view->images);
    bool ok = ffp_importing_read_pictures(import, import->shots.pictures + (ptrdiff_t)stop * FFP_PATTERNS_MAX,
                                          n, stop, view->images, alphas, err) &&
              ffp_importing_make_plain(import, stop, &view->images[import->shots.black],
                                       &view->images[import->shots.white], err);
    if (ok) import->thumbs[stop] = ffp_contact_thumb(&view->images[import->shots.white]);
    if (ok && import->settings->scene)
        ffp_importing_cover_scene(import, stop);
    else
        ok = ok && ffp_importing_cover(import, stop, alphas, err);
    for (int p = 0; p < n; p++) ffp_image_free(&alphas[p]);
    ffp_free(alphas);
    return ok;
}

static void note_developed(const FfpDeveloped *developed) {
    if (developed->raws > 0)
        ffp_note(
            "%d raw photographs were developed by dcraw_emu to linear light, with one white balance for all",
            developed->raws);
    if (developed->films > 0)
        ffp_note("%d films read by ffmpeg, each as the mean of its frames (%d frames)", developed->films,
                 developed->frames);
}

// Numbers of 10 to 14 bits in files of 16 are hardly ever anything but linear light.
static void note_too_dark(const FfpImporting *import) {
    const bool linear = import->settings->linear_images;
    const double most = linear ? import->brightest : (double)ffp_srgb_encode((real)import->brightest);
    if (!(most > 0 && most <= ffp_rule(FFP_RULE_FEW_BITS)->limit)) return;
    const double stops = floor(-log2(most));
    if (!linear || import->settings->exposure < stops)
        ffp_tell(linear ? FFP_RULE_FEW_BITS : FFP_RULE_FEW_BITS_AS_SRGB,
                 &(FfpFacts){.figure = most, .x = stops, .y = ceil(16 + log2(most))});
}

static void note_too_bright(const FfpImporting *import) {
    const double share = (double)import->too_bright / (double)import->values;
    if (share > ffp_rule(FFP_RULE_TOO_BRIGHT)->limit)
        ffp_tell(FFP_RULE_TOO_BRIGHT, &(FfpFacts){.figure = share});
}

// Files of masks that leave nothing of any view are the wrong way round, or other pictures.
static bool check_masks(const FfpImporting *import, FfpError *err) {
    const FfpCapture *capture = &import->capture;
    if (!import->shots.masks) return true;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpImage *mask = &capture->views[v].coverage;
        const ptrdiff_t pixels = (ptrdiff_t)mask->width * mask->height;
        for (ptrdiff_t i = 0; i < pixels; i++)
            if (mask->data[i] > 0) return true;
    }
    return ffp_fail_by(FFP_RULE_MASKS_EMPTY, &(FfpFacts){0}, import->shots.masks[0], err);
}

bool ffp_importing_load_pixels(FfpImporting *import, FfpError *err) {
    FfpCapture *capture = &import->capture;
    import->made = ffp_alloc((size_t)capture->n_views, sizeof *import->made);
    import->holes = ffp_alloc((size_t)capture->n_views, sizeof *import->holes);
    import->thumbs = ffp_alloc((size_t)capture->n_views, sizeof *import->thumbs);
    capture->n_patterns = import->shots.n_patterns;
    capture->patterns = ffp_alloc((size_t)capture->n_patterns + (size_t)ffp_importing_codes_looked_at(import),
                                  sizeof *capture->patterns);
    capture->black = import->shots.black, capture->white = import->shots.white;
    for (int p = 0; p < capture->n_patterns; p++) {
        if (!load_pattern(import, p, err)) return false;
    }
    FfpTask progress = ffp_task("importing", capture->n_views);
    bool ok = true;
    for (int v = 0; v < capture->n_views && ok; v++) {
        ok = load_view(import, v, err);
        if (ok) ffp_task_step(&progress, v + 1, capture->views[v].id);
    }
    ffp_task_end(&progress);
    if (ok) note_developed(&import->developed);
    if (ok) note_too_bright(import);
    if (ok) note_too_dark(import);
    return ok && check_masks(import, err);
}
