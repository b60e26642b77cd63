// Import: which pixels are the object: from files, alpha channels or light.
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "rig/findings/tell.h"
#include "rig/import/import_steps.h"
#include "rig/masks/masks.h"

#define LATE_TIMES 1.5     // brighter than any other photograph: what must be white itself
#define SWAPPED_TIMES 10   // as much light as white adds, it takes away, and
#define SWAPPED_LEAST 1e-3 // so much of full scale in the mean: white is black

static bool load_mask(FfpImporting *import, int stop, FfpError *err) {
    const char *path = import->shots.masks[stop];
    const FfpOptics *optics = &import->calibration.stops[stop].camera;
    FfpView *view = &import->capture.views[stop];
    FfpImage rgba = {0};
    if (!ffp_importing_check_size(path, optics, err) || !ffp_image_read(&rgba, path, FFP_COLOUR_ENCODED, err))
        return false;
    FfpImage mask = ffp_mask_of(&rgba);
    view->coverage = ffp_optics_rectify(optics, &view->camera, &mask);
    ffp_image_free(&mask);
    ffp_image_free(&rgba);
    return true;
}

// White adds no light: where one photograph is lighter than all others, and clearly so, it is white's, and
// all are a pattern late. With one pattern alone, that may as well be the pattern's own light: then white
// shows what black does.
static bool tell_late(const FfpImporting *import, int stop, FfpError *err) {
    const FfpShots *shots = &import->shots;
    const FfpImage *images = import->capture.views[stop].images;
    const char *const *files = shots->pictures + (ptrdiff_t)stop * FFP_PATTERNS_MAX;
    double most = 0, next = 0;
    int lightest = -1, shown = 0;
    for (int p = 0; p < shots->n_patterns; p++) {
        if (!images[p].data) continue;
        const double mean = ffp_image_mean(&images[p]);
        next = fmax(next, fmin(mean, most));
        if (mean > most) most = mean, lightest = p;
        shown++;
    }
    if (!files[shots->black] || !files[shots->white] || lightest == shots->white ||
        lightest == shots->black || !(most > LATE_TIMES * next))
        return false;
    const char *white = files[shots->white];
    const bool late = shown >= 4;
    return ffp_fail_by(late ? FFP_RULE_ONE_LATE : FFP_RULE_WHITE_IS_BLACK,
                       &(FfpFacts){.a = ffp_basename(files[shots->black]), .b = ffp_basename(white)}, white,
                       err);
}

// True if white is darker than black and than a pattern, as exchanged photographs are. Where a lamp was on
// under black alone, white is still the lightest picture that the projector shows: the check of all views
// reports it.
static bool is_swapped(const FfpShots *shots, const FfpImage *images) {
    const FfpImage *black = &images[shots->black], *white = &images[shots->white];
    const ptrdiff_t values = 3 * (ptrdiff_t)white->width * white->height;
    double added = 0, taken = 0, most = 0;
    for (ptrdiff_t i = 0; i < values; i++) {
        const double by = (double)(white->data[i] - black->data[i]);
        *(by > 0 ? &added : &taken) += fabs(by);
    }
    for (int p = 0; p < shots->n_patterns; p++)
        if (images[p].data && p != shots->black) most = fmax(most, ffp_image_mean(&images[p]));
    return taken > SWAPPED_TIMES * added && taken > SWAPPED_LEAST * (double)values &&
           most > ffp_image_mean(white);
}

// The mask as it was asked for: later, from the empty stage; a file; otherwise the white picture's alpha
// channel, unless Otsu's was named; otherwise Otsu's. Pictures that are over black by an alpha channel of
// their own are left alone in the second case.
bool ffp_importing_cover(FfpImporting *import, int stop, const FfpImage *alphas, FfpError *err) {
    const FfpShots *shots = &import->shots;
    FfpView *view = &import->capture.views[stop];
    const bool by_alpha = !shots->masks && !shots->empty && import->settings->masks == FFP_MASKS_FROM_ALPHA &&
                          alphas[shots->white].data != NULL;
    if (is_swapped(shots, view->images))
        return ffp_fail_by(FFP_RULE_PLAIN_SWAPPED, &(FfpFacts){0}, ffp_shots_white(shots, stop), err);
    if (shots->empty) {
        view->coverage = ffp_image_new(view->camera.width, view->camera.height, 1);
        import->made[stop] = true; // when all views are known
    } else if (shots->masks) {
        if (!load_mask(import, stop, err)) return false;
    } else if (by_alpha) {
        view->coverage = ffp_image_copy(&alphas[shots->white]);
    } else {
        const char *path = ffp_shots_white(shots, stop);
        if (!ffp_mask_otsu(&view->coverage, &import->holes[stop], &view->images[shots->black],
                           &view->images[shots->white], path, err)) {
            return tell_late(import, stop, err);
        }
        import->made[stop] = true; // and applied when it is complete
    }
    for (int p = 0; p < shots->n_patterns && !import->made[stop]; p++) {
        if (!by_alpha || !alphas[p].data) ffp_mask_apply(&view->coverage, &view->images[p]);
    }
    return true;
}

static bool refine(void *context, int view) {
    return ffp_importing_refine_mask(context, view);
}

// True if the views are a turntable's stops, seen by one camera.
static bool turns(const FfpImporting *import) {
    const FfpImportTurntable *turntable = &import->settings->turntable;
    const FfpStop *stops = import->calibration.stops;
    for (int v = 1; v < import->capture.n_views; v++)
        if (memcmp(&stops[v].camera, &stops[0].camera, sizeof stops[0].camera) != 0) return false;
    return ffp_turntable_is_given(turntable) && !turntable->find_axis;
}

bool ffp_importing_complete_masks(FfpImporting *import, FfpError *err) {
    const int n = import->capture.n_views;
    const char **paths = ffp_alloc((size_t)n, sizeof *paths);
    for (int v = 0; v < n; v++) paths[v] = ffp_shots_white(&import->shots, v);
    const FfpMasking masking = {.capture = &import->capture,
                                .made = import->made,
                                .holes = import->holes,
                                .stages = import->stages,
                                .paths = paths,
                                .posed = !import->settings->turntable.find_axis,
                                .turns = turns(import),
                                .refine = refine,
                                .context = import};
    const bool ok =
        (!import->stages || ffp_masks_check_stage(&masking, err)) && ffp_masks_complete(&masking, err);
    ffp_free(paths);
    return ok;
}

bool ffp_importing_write_sheet(const char *folder, const FfpImporting *import, FfpError *err) {
    char path[FFP_PATH_MAX];
    if (!ffp_join_path(path, folder, "masks.png"))
        return ffp_fail(err, FFP_ERROR_FILE, folder, "the path is too long");
    FfpImage sheet = ffp_contact_sheet(&import->capture, import->thumbs);
    const bool ok = ffp_image_write_png(&sheet, path, err);
    ffp_image_free(&sheet);
    return ok;
}

// The size and lens of the photographs, so that they can be painted on and given back (--mask).
static bool write_mask(const char *folder, const FfpImporting *import, int v, FfpError *err) {
    const FfpView *view = &import->capture.views[v];
    char name[FFP_NAME_MAX + 16], path[FFP_PATH_MAX];
    snprintf(name, sizeof name, "masks/%s.png", view->id);
    if (!ffp_join_path(path, folder, name))
        return ffp_fail(err, FFP_ERROR_FILE, folder, "the path is too long");
    FfpImage mask = ffp_optics_distort(&import->calibration.stops[v].camera, &view->camera, &view->coverage);
    const bool ok = ffp_image_write_png(&mask, path, err);
    ffp_image_free(&mask);
    return ok;
}

bool ffp_importing_write_masks(const char *folder, const FfpImporting *import, FfpError *err) {
    char path[FFP_PATH_MAX];
    bool made = false;
    for (int v = 0; v < import->capture.n_views; v++) made = made || import->made[v];
    if (!made) return true;
    if (!ffp_join_path(path, folder, "masks"))
        return ffp_fail(err, FFP_ERROR_FILE, folder, "the path is too long");
    if (!ffp_make_folders(path, err)) return false;
    for (int v = 0; v < import->capture.n_views; v++)
        if (!write_mask(folder, import, v, err)) return false;
    return true;
}
