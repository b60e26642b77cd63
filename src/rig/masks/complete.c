// Masks made of light, from the first to those that are applied.
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "core/numerics/rank.h"
#include "rig/checks/measure.h"
#include "rig/findings/tell.h"
#include "rig/masks/limits.h"
#include "rig/masks/local_mean.h"
#include "rig/masks/steps.h"

static void note_stage(const FfpMasking *masking, const FfpStageMasks *report, const char *from) {
    ffp_note(
        "%d masks were made from %s: %.0f %% of the pictures are stage, %.1f %% object, and %.1f %% object "
        "by the other views",
        masking->capture->n_views, from, 100 * report->stage, 100 * report->object, 100 * report->decided);
    if (report->shade > 0)
        ffp_note("  %.1f %% are shadows of the object on the stage that only their colour tells",
                 100 * report->shade);
    if (report->gain_least < 1 / MASKS_GAIN_MOST || report->gain_most > MASKS_GAIN_MOST)
        ffp_tell(FFP_RULE_STAGE_GAIN, &(FfpFacts){.x = report->gain_least, .y = report->gain_most});
}

// From the empty stage of each view; NULL: from the one that all share.
static bool mask_by_stage(const FfpMasking *masking, const FfpEmptyStage *shared, FfpStageMasks *report,
                          FfpError *err) {
    const int n = masking->capture->n_views;
    const FfpEmptyStage **stages = ffp_alloc((size_t)n, sizeof *stages);
    for (int v = 0; v < n; v++) stages[v] = shared ? shared : &masking->stages[v];
    const bool ok = ffp_stage_masks(report, masking->capture, stages, masking->posed, masking->paths, err);
    ffp_free(stages);
    return ok;
}

static void soften_edges(const FfpMasking *masking, const FfpEmptyStage *shared,
                         const FfpStageMasks *report) {
    for (int v = 0; v < masking->capture->n_views; v++)
        ffp_soften_edges(masking->capture, &masking->capture->views[v], shared ? shared : &masking->stages[v],
                         report->noise[v]);
}

// --- A lit background that nobody photographed alone. ---

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
           ffp_rig_silhouette_misfit(capture) >= MASKS_MISFIT_LEAST;
}

// Replaces the masks by those from the one stage of all views; false, and they stay, when that fails.
static bool replace_masks(const FfpMasking *masking, const FfpEmptyStage *stage, FfpStageMasks *report) {
    FfpCapture *capture = masking->capture;
    FfpStageMasks made;
    FfpError none = {0};
    FfpImage *before = ffp_alloc((size_t)capture->n_views, sizeof *before);
    for (int v = 0; v < capture->n_views; v++)
        before[v] = capture->views[v].coverage, capture->views[v].coverage = (FfpImage){0};
    const bool ok = mask_by_stage(masking, stage, &made, &none);
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

// Replaces the light's masks, and returns true, if they show a background and the common look of the stops
// tells the object better.
static bool mask_by_common_stage(const FfpMasking *masking) {
    FfpCapture *capture = masking->capture;
    FfpEmptyStage stage = {0};
    FfpCommon found;
    FfpStageMasks report;
    if (!masking->turns || capture->n_views < MASKS_VIEWS_TURNED) return false;
    ffp_capture_estimate_bounds(capture);
    if (!may_show_background(capture) || !ffp_common_stage(&stage, &found, capture)) return false;
    const bool ok =
        found.lit > MASKS_LIT_LEAST * masked_share(capture) && replace_masks(masking, &stage, &report);
    if (ok) {
        if (ffp_common_stage_again(&stage, capture)) replace_masks(masking, &stage, &report);
        soften_edges(masking, &stage, &report);
        ffp_tell(FFP_RULE_LIT_BACKGROUND, &(FfpFacts){.figure = found.lit});
        note_stage(masking, &report, "what stays the same over the stops");
    }
    ffp_common_stage_free(&stage, capture->n_patterns);
    return ok;
}

typedef struct Grown {
    bool asked, sure; // other views could say, and did
    double added;     // share of the object's pixels
} Grown;

// The shadows in Otsu's masks, from what the other views show.
static Grown add_shadows(const FfpMasking *masking) {
    FfpCapture *capture = masking->capture;
    int64_t covered = 0, added;
    Grown out = {.asked = masking->posed && capture->n_views >= MASKS_VIEWS_GROWN};
    if (!out.asked) return out;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpImage *mask = &capture->views[v].coverage;
        for (ptrdiff_t i = 0; i < (ptrdiff_t)mask->width * mask->height; i++)
            covered += mask->data[i] >= 0.5F;
    }
    ffp_capture_estimate_bounds(capture);
    out.sure = ffp_grow_masks(capture, masking->made, masking->holes, &added);
    out.added = (double)added / fmax(1, (double)covered);
    return out;
}

static void apply_masks(const FfpMasking *masking) {
    const FfpCapture *capture = masking->capture;
    for (int v = 0; v < capture->n_views; v++)
        for (int p = 0; p < capture->n_patterns && masking->made[v]; p++)
            ffp_mask_apply(&capture->views[v].coverage, &capture->views[v].images[p]);
}

// The median over a view's pixels under black, which is the room's light on what is around the object.
static double room_light(const FfpMasking *masking, int v) {
    const FfpImage *black = &masking->capture->views[v].images[masking->capture->black];
    const ptrdiff_t pixels = (ptrdiff_t)black->width * black->height;
    double *levels = ffp_alloc((size_t)pixels, sizeof *levels);
    for (ptrdiff_t i = 0; i < pixels; i++)
        levels[i] = (double)(black->data[3 * i] + black->data[3 * i + 1] + black->data[3 * i + 2]) / 3;
    const double median = ffp_median(levels, (size_t)pixels);
    ffp_free(levels);
    return median;
}

// Lamps that were switched on or off between the views, and daylight that changed.
static void warn_of_other_light(const FfpMasking *masking) {
    const int n = masking->capture->n_views;
    double *lights = ffp_alloc(2 * (size_t)n, sizeof *lights), *sorted = lights + n;
    int odd = -1;
    for (int v = 0; v < n; v++) lights[v] = sorted[v] = room_light(masking, v);
    const double usual = ffp_median(sorted, (size_t)n), most = fmax(MASKS_LIGHT_LEAST, LIGHT_CHANGE * usual);
    for (int v = 0; v < n; v++)
        if (fabs(lights[v] - usual) > most &&
            (odd < 0 || fabs(lights[v] - usual) > fabs(lights[odd] - usual)))
            odd = v;
    if (odd >= 0)
        ffp_tell(FFP_RULE_VIEW_LIGHT,
                 &(FfpFacts){.view = masking->capture->views[odd].id, .figure = lights[odd], .x = usual});
    ffp_free(lights);
}

// How well the masks go together.
static void note_agreement(const FfpMasking *masking) {
    FfpCapture *capture = masking->capture;
    if (!masking->posed || capture->n_views < 2) return;
    ffp_capture_estimate_bounds(capture);
    const double share = 1 - ffp_rig_silhouette_misfit(capture);
    if (!masking->stages || share >= MASKS_AGREE_LEAST)
        ffp_note(
            "  %.1f %% of the masks' pixels agree with the other views' masks; masks.png in the capture's "
            "folder shows all of them",
            100 * share);
    else
        ffp_tell(FFP_RULE_MASKS_DISAGREE, &(FfpFacts){.figure = share, .limit = MASKS_AGREE_LEAST});
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

// True if masks of all light are better than those that the views have: the empty stage must be as dark; or,
// if the views have completed each other's masks, they must show the shadows that were found, and contradict
// each other no more, as they would with a window or a hand in a picture.
static bool is_better(const FfpMasking *masking, FfpImage *masks, bool completed) {
    FfpCapture *capture = masking->capture;
    for (int v = 0; masking->stages && v < capture->n_views; v++)
        if (!ffp_dark_stage(capture, v, &masking->stages[v])) return false;
    if (!completed) return true;
    if (lacking(capture, masks) >= MASKS_LACKING_MOST) return false;
    const double before = misfit_of(capture);
    exchange_masks(capture, masks);
    const double after = misfit_of(capture);
    exchange_masks(capture, masks);
    return after < before + MASKS_MISFIT_MORE;
}

// Where nothing but the object sends light to the camera, all light together shows it, and its shadows too.
static bool mask_in_the_dark(const FfpMasking *masking, bool completed) {
    FfpCapture *capture = masking->capture;
    FfpImage *masks = ffp_alloc((size_t)capture->n_views, sizeof *masks);
    const bool found = ffp_dark_masks(masks, capture) && is_better(masking, masks, completed);
    if (found) exchange_masks(capture, masks);
    for (int v = 0; v < capture->n_views; v++) {
        if (found && !masking->refine(masking->context, v)) ffp_dark_soften(capture, &capture->views[v]);
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
bool ffp_masks_complete(const FfpMasking *masking, FfpError *err) {
    const FfpCapture *capture = masking->capture;
    int made = 0;
    for (int v = 0; v < capture->n_views; v++) made += masking->made[v];
    if (made == 0) return true;
    if (made == capture->n_views && masking->turns) warn_of_other_light(masking);
    if (masking->stages) {
        FfpStageMasks report;
        if (!mask_in_the_dark(masking, false)) {
            if (!mask_by_stage(masking, NULL, &report, err)) return false;
            soften_edges(masking, NULL, &report);
            note_stage(masking, &report, "the empty stage");
        }
    } else if (made < capture->n_views || !mask_by_common_stage(masking)) {
        const Grown grown = add_shadows(masking);
        if (made < capture->n_views || !mask_in_the_dark(masking, grown.sure)) note_otsu(&grown, made);
    }
    note_agreement(masking);
    apply_masks(masking);
    return true;
}
