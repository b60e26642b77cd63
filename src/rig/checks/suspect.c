#include "rig/checks/suspect.h"
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "rig/checks/checks.h"
#include "rig/checks/suspect_parts.h"

#define FAR_RADII 100 // from the object to a device, in its radii: more is another unit
#define SUSPECTS 8 // views of which two may be exchanged: the time to try them does not grow with the views

// --- Devices. ---

static double distance_to_centre(const FfpCapture *capture, const FfpCamera *device) {
    double square = 0;
    for (int i = 0; i < 3; i++)
        square += pow((double)device->pose[4 * i + 3] - (double)capture->centre[i], 2);
    return sqrt(square);
}

static bool is_behind(const FfpCapture *capture, const FfpCamera *device) {
    real x, y;
    return !(ffp_project(device, capture->centre, &x, &y) > 0);
}

static bool check_device(const FfpCapture *capture, const FfpView *view, const FfpCamera *device,
                         const char *name, FfpError *err) {
    const double radii = distance_to_centre(capture, device) / (double)capture->radius;
    if (!capture->scene && radii < 0.5)
        return ffp_fail(err, FFP_ERROR_FAULT, view->id,
                        "the %s is inside the object: check its position, the direction of R and T, and the "
                        "unit of lengths",
                        name);
    if (is_behind(capture, device))
        return ffp_fail(
            err, FFP_ERROR_FAULT, view->id,
            "the object is behind the %s: check the turntable's axis, and the direction of R and T", name);
    if (!capture->scene && radii > FAR_RADII)
        return ffp_fail(err, FFP_ERROR_FAULT, view->id,
                        "the %s is %.0f times the object's radius away: check the unit of lengths", name,
                        radii);
    return true;
}

// Cameras that all look away look the right way in OpenGL's axes.
static bool check_axes(const FfpCapture *capture, FfpError *err) {
    for (int v = 0; v < capture->n_views; v++)
        if (!is_behind(capture, &capture->views[v].camera)) return true;
    return ffp_fail(
        err, FFP_ERROR_FAULT, capture->folder,
        "the object is behind every camera: the poses have OpenGL's axes (y up, z backwards), or R "
        "and T have the other direction");
}

static bool check_devices(const FfpCapture *capture, FfpError *err) {
    if (!check_axes(capture, err)) return false;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        if (!check_device(capture, view, &view->camera, "camera", err) ||
            !check_device(capture, view, &view->projector, "projector", err))
            return false;
    }
    return true;
}

// --- Silhouettes under a hypothesis: their misfit, or INFINITY as soon as it is not below `enough`. ---

static const char *const mishaps[FFP_RIG_MISHAPS] = {
    [FFP_RIG_TURNED_HALF] = "turned by 180 degrees",
    [FFP_RIG_TURNED_LEFT] = "turned by 90 degrees to the left",
    [FFP_RIG_TURNED_RIGHT] = "turned by 90 degrees to the right",
    [FFP_RIG_MIRRORED] = "mirrored left to right",
    [FFP_RIG_FLIPPED] = "mirrored upside down"};

static double misfit_undone(const FfpCapture *capture, int view, FfpRigMishap mishap, double enough) {
    const FfpImage *mask = &capture->views[view].coverage;
    if ((mishap == FFP_RIG_TURNED_LEFT || mishap == FFP_RIG_TURNED_RIGHT) && mask->width != mask->height)
        return INFINITY;
    FfpCapture alias = ffp_rig_alias(capture);
    alias.views[view].coverage = ffp_rig_undone(mask, mishap);
    const double misfit = ffp_rig_misfit_below(&alias, enough);
    ffp_image_free(&alias.views[view].coverage);
    ffp_free(alias.views);
    return misfit;
}

static bool same_size(const FfpImage *a, const FfpImage *b) {
    return a->width == b->width && a->height == b->height;
}

static double misfit_exchanged(const FfpCapture *capture, int a, int b, double enough) {
    const FfpView *views = capture->views;
    if (!same_size(&views[a].coverage, &views[b].coverage)) return INFINITY;
    FfpCapture alias = ffp_rig_alias(capture);
    alias.views[a].coverage = views[b].coverage;
    alias.views[b].coverage = views[a].coverage;
    const double misfit = ffp_rig_misfit_below(&alias, enough);
    ffp_free(alias.views);
    return misfit;
}

// With the photographs in the other direction round the object, the first staying where it is.
static double misfit_reversed(const FfpCapture *capture, double enough) {
    const int n = capture->n_views;
    FfpCapture alias = ffp_rig_alias(capture);
    bool fits = true;
    for (int v = 1; v < n; v++) {
        fits = fits && same_size(&capture->views[v].coverage, &capture->views[n - v].coverage);
        alias.views[v].coverage = capture->views[n - v].coverage;
    }
    const double misfit = fits ? ffp_rig_misfit_below(&alias, enough) : INFINITY;
    ffp_free(alias.views);
    return misfit;
}

// With the cameras' intrinsics as of a picture `factor` times as large.
static double misfit_of_size(const FfpCapture *capture, real factor, double enough) {
    FfpCapture alias = ffp_rig_alias(capture);
    for (int v = 0; v < alias.n_views; v++) {
        FfpCamera *c = &alias.views[v].camera;
        c->fx *= factor, c->fy *= factor;
        c->cx *= factor, c->cy *= factor;
    }
    const double misfit = ffp_rig_misfit_below(&alias, enough);
    ffp_free(alias.views);
    return misfit;
}

// --- Who is to blame. ---

// Whether structured light explains the view as well or better once the mishap is undone: of objects that are
// nearly symmetric, silhouettes alone would accept a mirrored view for a wrong mask.
static bool light_agrees(const FfpCapture *capture, int odd, FfpRigMishap mishap) {
    const FfpView *view = &capture->views[odd];
    const int active = ffp_capture_active_pattern(capture, NULL, NULL);
    const int shown[3] = {capture->black, capture->white, active};
    if (active < 0) return true;
    FfpSummed pattern = ffp_summed_new(&capture->patterns[active].image);
    const double before =
        ffp_rig_guess(capture, view, &(FfpGuess){.photograph = &view->images[active], .pattern = &pattern});
    FfpView mended = *view;
    mended.images = ffp_alloc((size_t)capture->n_patterns, sizeof *mended.images);
    for (int k = 0; k < 3; k++) mended.images[shown[k]] = ffp_rig_undone(&view->images[shown[k]], mishap);
    mended.coverage = ffp_rig_undone(&view->coverage, mishap);
    const double after = ffp_rig_guess(
        capture, &mended, &(FfpGuess){.photograph = &mended.images[active], .pattern = &pattern});
    ffp_image_free(&mended.coverage);
    for (int k = 0; k < 3; k++) ffp_image_free(&mended.images[shown[k]]);
    ffp_free(mended.images);
    ffp_summed_free(&pattern);
    return !(after > before);
}

// Fails if a mishap of this view explains it.
static bool try_mishaps(const FfpCapture *capture, int view, double enough, FfpError *err) {
    double least = INFINITY;
    FfpRigMishap best = FFP_RIG_TURNED_HALF;
    for (FfpRigMishap m = FFP_RIG_TURNED_HALF; m < FFP_RIG_MISHAPS; m++) {
        const double misfit = misfit_undone(capture, view, m, enough);
        if (misfit < least) {
            least = misfit;
            best = m;
        }
    }
    if (!(least < enough) || !light_agrees(capture, view, best)) return true;
    return ffp_fail(err, FFP_ERROR_FAULT, capture->views[view].id,
                    "its photographs contradict the other views, and fit when they are taken as %s",
                    mishaps[best]);
}

// The views that silhouettes blame most, SUSPECTS at most; returns their number.
static int most_blamed(const FfpSilhouettes *found, int n_views, int suspects[SUSPECTS]) {
    int n = 0;
    for (int v = 0; v < n_views; v++) {
        int at = n < SUSPECTS ? n++ : SUSPECTS;
        for (; at > 0 && found->blame[suspects[at - 1]] < found->blame[v]; at--)
            if (at < SUSPECTS) suspects[at] = suspects[at - 1];
        if (at < SUSPECTS) suspects[at] = v;
    }
    return n;
}

// Fails if exchanging two of the views that are blamed most explains it.
static bool try_exchanges(const FfpCapture *capture, const FfpSilhouettes *found, double enough,
                          FfpError *err) {
    int suspects[SUSPECTS], a = 0, b = 0;
    const int n = most_blamed(found, capture->n_views, suspects);
    double least = INFINITY;
    for (int i = 0; i < n; i++)
        for (int j = i + 1; j < n; j++) {
            const double misfit = misfit_exchanged(capture, suspects[i], suspects[j], enough);
            if (!(misfit < least)) continue;
            least = misfit;
            a = suspects[i] < suspects[j] ? suspects[i] : suspects[j];
            b = suspects[i] + suspects[j] - a;
        }
    if (!(least < enough)) return true;
    return ffp_fail(
        err, FFP_ERROR_FAULT, capture->views[a].id,
        "its photographs and those of view %s are exchanged: the silhouettes fit the other way round",
        capture->views[b].id);
}

// Photographs in the opposite direction round the object are as photographs in a mirror, but for structured
// light.
static bool are_all_mirrored(const FfpCapture *capture) {
    int agree = 0;
    if (ffp_capture_active_pattern(capture, NULL, NULL) < 0) return false;
    for (int v = 0; v < capture->n_views; v++) agree += light_agrees(capture, v, FFP_RIG_MIRRORED);
    return 2 * agree > capture->n_views;
}

static bool try_reversal(const FfpCapture *capture, double enough, FfpError *err) {
    if (!(misfit_reversed(capture, enough) < enough)) return true;
    return are_all_mirrored(capture)
               ? ffp_fail(err, FFP_ERROR_FAULT, capture->folder, FFP_RIG_ALL_MIRRORED, "left to right")
               : ffp_fail(
                     err, FFP_ERROR_FAULT, capture->folder,
                     "the views fit in the opposite order: the turntable turned the other way, change the "
                     "sign of its "
                     "angles");
}

// Whether structured light explains the views clearly better with the cameras' intrinsics of that size: masks
// that are wrong fit some sizes better, too.
static bool light_prefers_size(const FfpCapture *capture, real factor) {
    const int active = ffp_capture_active_pattern(capture, NULL, NULL);
    if (active < 0) return true;
    FfpSummed pattern = ffp_summed_new(&capture->patterns[active].image);
    double before = 0, after = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpGuess guess = {.photograph = &capture->views[v].images[active], .pattern = &pattern};
        FfpView scaled = capture->views[v];
        scaled.camera.fx *= factor, scaled.camera.fy *= factor;
        scaled.camera.cx *= factor, scaled.camera.cy *= factor;
        const double a = ffp_rig_guess(capture, &capture->views[v], &guess),
                     b = ffp_rig_guess(capture, &scaled, &guess);
        if (isnan(b)) continue;
        before += isnan(a) ? 1 : a; // rays that miss the object explain nothing
        after += b;
    }
    ffp_summed_free(&pattern);
    return after > 0 && after < 0.7 * before;
}

static bool try_sizes(const FfpCapture *capture, double enough, FfpError *err) {
    for (int twice = 0; twice < 2; twice++)
        if (misfit_of_size(capture, twice ? 2 : 0.5F, enough) < enough &&
            light_prefers_size(capture, twice ? 2 : 0.5F))
            return ffp_fail(
                err, FFP_ERROR_FAULT, capture->folder,
                "the silhouettes fit with %s the camera's focal lengths and principal point: it was "
                "calibrated with photographs of another size",
                twice ? "twice" : "half");
    return true;
}

// Fails if what people do explains the contradictions.
static bool explain_silhouettes(const FfpCapture *capture, const FfpSilhouettes *found, FfpError *err) {
    const double enough = FFP_RIG_EXPLAINED * found->misfit;
    const bool much = found->misfit >= FFP_RIG_MISFIT_MAX && capture->n_views >= FFP_RIG_VIEWS_TO_ACCUSE;
    if (found->odd >= 0 && !try_mishaps(capture, found->odd, enough, err)) return false;
    return !much || (try_reversal(capture, enough, err) && try_sizes(capture, enough, err) &&
                     try_exchanges(capture, found, enough, err));
}

static bool check_silhouettes(const FfpCapture *capture, FfpError *err) {
    FfpSilhouettes found = ffp_rig_silhouettes(capture);
    const bool ok = explain_silhouettes(capture, &found, err),
               much = found.misfit >= FFP_RIG_MISFIT_MAX && capture->n_views >= FFP_RIG_VIEWS_TO_ACCUSE;
    if (ok && found.odd >= 0)
        ffp_note("view %s contradicts the others' silhouettes: look at its mask and pose",
                 capture->views[found.odd].id);
    else if (ok && much)
        ffp_note("%.0f %% of the object's pixels contradict the other views' silhouettes: `info` says what "
                 "to look at",
                 100 * found.misfit);
    ffp_rig_silhouettes_free(&found);
    return ok;
}

bool ffp_rig_suspect(const FfpCapture *capture, FfpError *err) {
    const int active = ffp_capture_active_pattern(capture, NULL, NULL);
    return check_devices(capture, err) && ffp_rig_suspect_light(capture, active, err) &&
           (capture->scene || check_silhouettes(capture, err)) &&
           (active < 0 || ffp_rig_suspect_pattern(capture, active, err));
}
