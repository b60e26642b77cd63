// Import: which pixels are the object: from files, alpha channels or light.
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/arena.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/numerics/rank.h"
#include "rig/checks/measure.h"
#include "rig/findings/tell.h"
#include "rig/import/import_steps.h"
#include "rig/masks/common_stage.h"
#include "rig/masks/contact_sheet.h"
#include "rig/masks/dark.h"
#include "rig/masks/grow_masks.h"
#include "rig/masks/local_mean.h"
#include "rig/masks/mask.h"
#include "rig/masks/soft_edges.h"
#include "rig/masks/stage_masks.h"

#define MISFIT_LEAST 0.12 // of the pixels, which contradict the other views' masks: those show a wall
#define LATE_TIMES 1.5    // brighter than any other photograph: what must be white itself
#define LIT_LEAST 0.5     // of what is lit that must stay the same
#define MISFIT_MORE 0.01  // by which masks of all light may contradict each other more than others
#define LACKING_MOST 0.02 // of the masks' pixels, which all light does not show
#define VIEWS_TURNED 5    // that tell it
#define LIGHT_LEAST 0.01  // of full scale, by which the light under black may change, and
#define LIGHT_CHANGE 0.25 // of itself
#define AGREE_LEAST 0.9   // of the masks' pixels
#define GAIN_MOST 1.1     // either way, by which the light may have changed without a word

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

static double mean_of(const FfpImage *rgb) {
    const ptrdiff_t values = 3 * (ptrdiff_t)rgb->width * rgb->height;
    double sum = 0;
    for (ptrdiff_t i = 0; i < values; i++) sum += (double)rgb->data[i];
    return sum / (double)values;
}

// White adds no light: where one photograph is lighter than all others, and clearly so, it is white's, and
// all are a pattern late. With one pattern alone, that may as well be the pattern's own light.
static bool tell_late(const FfpImporting *import, int stop, FfpError *err) {
    const FfpShots *shots = &import->shots;
    const FfpImage *images = import->capture.views[stop].images;
    const char *const *files = shots->pictures + (ptrdiff_t)stop * FFP_PATTERNS_MAX;
    double most = 0, next = 0;
    int lightest = -1, shown = 0;
    for (int p = 0; p < shots->n_patterns; p++) {
        if (!images[p].data) continue;
        const double mean = mean_of(&images[p]);
        next = fmax(next, fmin(mean, most));
        if (mean > most) most = mean, lightest = p;
        shown++;
    }
    if (shown < 4 || lightest == shots->white || lightest == shots->black || !(most > LATE_TIMES * next))
        return false;
    return ffp_fail_by(
        FFP_RULE_ONE_LATE,
        &(FfpFacts){.a = ffp_basename(files[shots->white]), .b = ffp_basename(files[lightest])},
        files[shots->white], err);
}

// The mask as it was asked for: later, from the empty stage; a file; otherwise the white picture's alpha
// channel, unless Otsu's was named; otherwise Otsu's. Pictures that are over black by an alpha channel of
// their own are left alone in the second case.
bool ffp_importing_cover(FfpImporting *import, int stop, const FfpImage *alphas, FfpError *err) {
    const FfpShots *shots = &import->shots;
    FfpView *view = &import->capture.views[stop];
    const bool by_alpha = !shots->masks && !shots->empty && import->settings->masks == FFP_MASKS_FROM_ALPHA &&
                          alphas[shots->white].data != NULL;
    if (shots->empty) {
        view->coverage = ffp_image_new(view->camera.width, view->camera.height, 1);
        import->made[stop] = true; // when all views are known
    } else if (shots->masks) {
        if (!load_mask(import, stop, err)) return false;
    } else if (by_alpha) {
        view->coverage = ffp_image_copy(&alphas[shots->white]);
    } else {
        const char *path = shots->pictures[stop * FFP_PATTERNS_MAX + shots->white];
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

static void note_stage(const FfpImporting *import, const FfpStageMasks *report, const char *from) {
    ffp_note(
        "%d masks were made from %s: %.0f %% of the pictures are stage, %.1f %% object, and %.1f %% object "
        "by the other views",
        import->capture.n_views, from, 100 * report->stage, 100 * report->object, 100 * report->decided);
    if (report->shade > 0)
        ffp_note("  %.1f %% are shadows of the object on the stage that only their colour tells",
                 100 * report->shade);
    if (report->gain_least < 1 / GAIN_MOST || report->gain_most > GAIN_MOST)
        ffp_tell(FFP_RULE_STAGE_GAIN, &(FfpFacts){.x = report->gain_least, .y = report->gain_most});
}

// From the empty stage of each view; NULL: from the one that all share.
static bool mask_by_stage(FfpImporting *import, const FfpEmptyStage *shared, FfpStageMasks *report,
                          FfpError *err) {
    FfpCapture *capture = &import->capture;
    const bool posed = !import->settings->turntable.find_axis;
    const FfpEmptyStage **stages = ffp_alloc((size_t)capture->n_views, sizeof *stages);
    const char **paths = ffp_alloc((size_t)capture->n_views, sizeof *paths);
    for (int v = 0; v < capture->n_views; v++) {
        stages[v] = shared ? shared : &import->stages[v];
        paths[v] = import->shots.pictures[v * FFP_PATTERNS_MAX + import->shots.white];
    }
    const bool ok = ffp_stage_masks(report, capture, stages, posed, paths, err);
    ffp_free(stages), ffp_free(paths);
    return ok;
}

static void soften_edges(FfpImporting *import, const FfpEmptyStage *shared, const FfpStageMasks *report) {
    for (int v = 0; v < import->capture.n_views; v++)
        ffp_soften_edges(&import->capture, &import->capture.views[v], shared ? shared : &import->stages[v],
                         report->noise[v]);
}

// --- A lit background that nobody photographed alone. ---

static bool has_one_camera(const FfpImporting *import) {
    const FfpImport *settings = import->settings;
    const FfpStop *stops = import->calibration.stops;
    for (int v = 1; v < import->capture.n_views; v++)
        if (memcmp(&stops[v].camera, &stops[0].camera, sizeof stops[0].camera) != 0) return false;
    for (int v = 0; v < import->capture.n_views; v++)
        if (!import->made[v]) return false; // masked by its alpha channel already
    return ffp_turntable_is_given(&settings->turntable) && !settings->turntable.find_axis;
}

static void free_coverages(FfpCapture *capture) {
    for (int v = 0; v < capture->n_views; v++) ffp_image_free(&capture->views[v].coverage);
}

// The mean share of the pictures that the masks take.
static double masked_share(const FfpCapture *capture) {
    double sum = 0, pixels = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpImage *mask = &capture->views[v].coverage;
        for (ptrdiff_t i = 0; i < (ptrdiff_t)mask->width * mask->height; i++) sum += mask->data[i] >= 0.5F;
        pixels += (double)mask->width * mask->height;
    }
    return sum / pixels;
}

// Masks that show a wall contradict each other; if they show nothing but walls they do not, but what they
// hold then does not fit into the devices' fields.
static bool may_show_background(const FfpCapture *capture) {
    return !ffp_rig_frusta_hold(ffp_rig_frusta(capture)) ||
           ffp_rig_silhouette_misfit(capture) >= MISFIT_LEAST;
}

// Replaces the masks by those from the one stage of all views; false, and they stay, when that fails.
static bool replace_masks(FfpImporting *import, const FfpEmptyStage *stage, FfpStageMasks *report) {
    FfpCapture *capture = &import->capture;
    FfpStageMasks made;
    FfpError none = {0};
    FfpImage *before = ffp_alloc((size_t)capture->n_views, sizeof *before);
    for (int v = 0; v < capture->n_views; v++)
        before[v] = capture->views[v].coverage, capture->views[v].coverage = (FfpImage){0};
    const bool ok = mask_by_stage(import, stage, &made, &none);
    if (ok)
        *report = made;
    else
        free_coverages(capture);
    for (int v = 0; v < capture->n_views; v++) {
        if (ok)
            ffp_image_free(&before[v]);
        else
            capture->views[v].coverage = before[v];
    }
    ffp_free(before);
    return ok;
}

// Whether the light's masks show a background, and what stays the same over the stops tells the object
// better: they are replaced then.
static bool mask_by_common_stage(FfpImporting *import) {
    FfpCapture *capture = &import->capture;
    FfpEmptyStage stage = {0};
    FfpCommon found;
    FfpStageMasks report;
    if (!has_one_camera(import) || capture->n_views < VIEWS_TURNED) return false;
    ffp_capture_estimate_bounds(capture);
    if (!may_show_background(capture) || !ffp_common_stage(&stage, &found, capture)) return false;
    const bool ok = found.lit > LIT_LEAST * masked_share(capture) && replace_masks(import, &stage, &report);
    if (ok) {
        if (ffp_common_stage_again(&stage, capture)) replace_masks(import, &stage, &report);
        soften_edges(import, &stage, &report);
        ffp_tell(FFP_RULE_LIT_BACKGROUND, &(FfpFacts){.figure = found.lit});
        note_stage(import, &report, "what stays the same over the stops");
    }
    ffp_common_stage_free(&stage, capture->n_patterns);
    return ok;
}

#define VIEWS_GROWN 4 // from which on views know enough of each other

typedef struct Grown {
    bool asked, sure; // whether other views could say, and did
    double added;     // share of the object's pixels
} Grown;

// The shadows in Otsu's masks, from what the other views show.
static Grown add_shadows(FfpImporting *import) {
    FfpCapture *capture = &import->capture;
    int64_t covered = 0, added;
    Grown out = {.asked = !import->settings->turntable.find_axis && capture->n_views >= VIEWS_GROWN};
    if (!out.asked) return out;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpImage *mask = &capture->views[v].coverage;
        for (ptrdiff_t i = 0; i < (ptrdiff_t)mask->width * mask->height; i++)
            covered += mask->data[i] >= 0.5F;
    }
    ffp_capture_estimate_bounds(capture);
    out.sure = ffp_grow_masks(capture, import->made, import->holes, &added);
    out.added = (double)added / fmax(1, (double)covered);
    return out;
}

static void apply_masks(FfpImporting *import) {
    const FfpCapture *capture = &import->capture;
    for (int v = 0; v < capture->n_views; v++)
        for (int p = 0; p < capture->n_patterns && import->made[v]; p++)
            ffp_mask_apply(&capture->views[v].coverage, &capture->views[v].images[p]);
}

// The median over a view's pixels under black, which is the room's light on what is around the object.
static double room_light(const FfpImporting *import, int v) {
    const FfpImage *black = &import->capture.views[v].images[import->shots.black];
    const ptrdiff_t pixels = (ptrdiff_t)black->width * black->height;
    double *levels = ffp_alloc((size_t)pixels, sizeof *levels);
    for (ptrdiff_t i = 0; i < pixels; i++)
        levels[i] = (double)(black->data[3 * i] + black->data[3 * i + 1] + black->data[3 * i + 2]) / 3;
    const double median = ffp_median(levels, (size_t)pixels);
    ffp_free(levels);
    return median;
}

// Lamps that were switched on or off between the views, and daylight that changed.
static void warn_of_other_light(const FfpImporting *import) {
    const int n = import->capture.n_views;
    double *lights = ffp_alloc(2 * (size_t)n, sizeof *lights), *sorted = lights + n;
    int odd = -1;
    for (int v = 0; v < n; v++) lights[v] = sorted[v] = room_light(import, v);
    const double usual = ffp_median(sorted, (size_t)n), most = fmax(LIGHT_LEAST, LIGHT_CHANGE * usual);
    for (int v = 0; v < n; v++)
        if (fabs(lights[v] - usual) > most &&
            (odd < 0 || fabs(lights[v] - usual) > fabs(lights[odd] - usual)))
            odd = v;
    if (odd >= 0)
        ffp_tell(FFP_RULE_VIEW_LIGHT,
                 &(FfpFacts){.view = import->capture.views[odd].id, .figure = lights[odd], .x = usual});
    ffp_free(lights);
}

// How well the masks go together.
static void note_agreement(FfpImporting *import) {
    FfpCapture *capture = &import->capture;
    if (import->settings->turntable.find_axis || capture->n_views < 2) return;
    ffp_capture_estimate_bounds(capture);
    const double share = 1 - ffp_rig_silhouette_misfit(capture);
    if (!import->stages || share >= AGREE_LEAST)
        ffp_note(
            "  %.1f %% of the masks' pixels agree with the other views' masks; masks.png in the capture's "
            "folder shows all of them",
            100 * share);
    else
        ffp_tell(FFP_RULE_MASKS_DISAGREE, &(FfpFacts){.figure = share, .limit = AGREE_LEAST});
}

static void note_otsu(const Grown *grown, int made) {
    ffp_note(
        "%d masks were made from white minus black (Otsu): look at them, and give files of masks if they "
        "are wrong",
        made);
    if (grown->sure)
        ffp_note("  shadows that the other views show lit were added to them, and holes opened that they see "
                 "through: %+.1f %% of the object's pixels",
                 100 * grown->added);
    else if (grown->asked)
        ffp_note("  too much of the object is in shadow for the other views to complete them");
    else
        ffp_note("  what the projector does not reach is left out");
}

// --- An object in the dark. ---

static void exchange_masks(FfpCapture *capture, FfpImage *masks) {
    for (int v = 0; v < capture->n_views; v++) {
        const FfpImage before = capture->views[v].coverage;
        capture->views[v].coverage = masks[v];
        masks[v] = before;
    }
}

// The share of the views' masks that other ones lack, beside their outlines.
static double lacking(const FfpCapture *capture, const FfpImage *masks) {
    double missing = 0, all = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpImage *view = &capture->views[v].coverage;
        const size_t pixels = (size_t)view->width * (size_t)view->height;
        unsigned char *there = ffp_alloc(pixels, 1);
        for (size_t i = 0; i < pixels; i++) there[i] = masks[v].data[i] > 0;
        ffp_marks_grow(there, view->width, view->height, 1);
        for (size_t i = 0; i < pixels; i++) {
            missing += view->data[i] >= 0.5F && !there[i];
            all += view->data[i] >= 0.5F;
        }
        ffp_free(there);
    }
    return missing / fmax(all, 1);
}

static double misfit_of(FfpCapture *capture) {
    ffp_capture_estimate_bounds(capture);
    return ffp_rig_silhouette_misfit(capture);
}

// Whether masks of all light are better than those that the views have: the empty stage must be as dark; or,
// if the views have completed each other's masks, they must show the shadows that were found, and contradict
// each other no more, as they would with a window or a hand in a picture.
static bool is_better(FfpImporting *import, FfpImage *masks, bool completed) {
    FfpCapture *capture = &import->capture;
    for (int v = 0; import->stages && v < capture->n_views; v++)
        if (!ffp_dark_stage(capture, v, &import->stages[v])) return false;
    if (!completed) return true;
    if (lacking(capture, masks) >= LACKING_MOST) return false;
    const double before = misfit_of(capture);
    exchange_masks(capture, masks);
    const double after = misfit_of(capture);
    exchange_masks(capture, masks);
    return after < before + MISFIT_MORE;
}

// Where nothing but the object sends light to the camera, all light together shows it, and its shadows too.
static bool mask_in_the_dark(FfpImporting *import, bool completed) {
    FfpCapture *capture = &import->capture;
    FfpImage *masks = ffp_alloc((size_t)capture->n_views, sizeof *masks);
    const bool found = ffp_dark_masks(masks, capture) && is_better(import, masks, completed);
    if (found) exchange_masks(capture, masks);
    for (int v = 0; v < capture->n_views; v++) {
        if (found && !ffp_importing_refine_mask(import, v)) ffp_dark_soften(capture, &capture->views[v]);
        ffp_image_free(&masks[v]);
    }
    ffp_free(masks);
    if (found)
        ffp_note(
            "%d masks were made from all light, since nothing but the object is bright: look at them, and "
            "give files of masks if they are wrong",
            capture->n_views);
    return found;
}

// Masks made of light, completed where there are views enough and their poses are known, and applied.
bool ffp_importing_complete_masks(FfpImporting *import, FfpError *err) {
    const FfpCapture *capture = &import->capture;
    int made = 0;
    for (int v = 0; v < capture->n_views; v++) made += import->made[v];
    if (made == 0) return true;
    if (made == capture->n_views && has_one_camera(import)) warn_of_other_light(import);
    if (import->stages) {
        FfpStageMasks report;
        if (!mask_in_the_dark(import, false)) {
            if (!mask_by_stage(import, NULL, &report, err)) return false;
            soften_edges(import, NULL, &report);
            note_stage(import, &report, "the empty stage");
        }
    } else if (made < capture->n_views || !mask_by_common_stage(import)) {
        const Grown grown = add_shadows(import);
        if (made < capture->n_views || !mask_in_the_dark(import, grown.sure)) note_otsu(&grown, made);
    }
    note_agreement(import);
    apply_masks(import);
    return true;
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
