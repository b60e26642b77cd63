#include "rig/import/suspect.h"
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "rig/import/checks.h"

#define DARKER 0.02F          // linear: by how much white is darker than black where they are exchanged
#define EXCHANGED_SHARE 0.25  // of a view's object pixels
#define MISFIT_EXPLAINED 0.25 // of the pixels that contradict other views: what leaves less explains them
#define VIEWS_TO_ACCUSE 4     // fewer views than these cannot outvote one

// --- Devices and light. ---

static double distance_to_centre(const FfpCapture *capture, const FfpCamera *device) {
    double square = 0;
    for (int i = 0; i < 3; i++)
        square += pow((double)device->pose[4 * i + 3] - (double)capture->centre[i], 2);
    return sqrt(square);
}

static bool check_device(const FfpCapture *capture, const FfpView *view, const FfpCamera *device,
                         const char *name, FfpError *err) {
    real x, y;
    if (!(ffp_project(device, capture->centre, &x, &y) > 0))
        return ffp_fail(
            err, FFP_ERROR_ARGUMENT, view->id,
            "the object is behind the %s: check the turntable's axis, and the direction of R and T", name);
    if (!capture->scene && distance_to_centre(capture, device) < 0.5 * (double)capture->radius)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, view->id,
                        "the %s is inside the object: check its position, and the unit of lengths", name);
    return true;
}

// Share of the object's pixels that are darker under white than under black.
static double reversed_share(const FfpCapture *capture, const FfpView *view) {
    const FfpImage *black = &view->images[capture->black], *white = &view->images[capture->white];
    const ptrdiff_t pixels = (ptrdiff_t)view->camera.width * view->camera.height;
    double object = 0, reversed = 0;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        if (view->coverage.data[i] < 0.5F) continue;
        real difference = 0;
        for (int c = 0; c < 3; c++) difference += (black->data[3 * i + c] - white->data[3 * i + c]) / 3;
        object++;
        reversed += difference > DARKER;
    }
    return object > 0 ? reversed / object : 0;
}

static bool check_light(const FfpCapture *capture, FfpError *err) {
    int count = 0, first = 0;
    for (int v = 0; v < capture->n_views; v++) {
        if (!(reversed_share(capture, &capture->views[v]) > EXCHANGED_SHARE)) continue;
        if (count++ == 0) first = v;
    }
    if (count == 0) return true;
    if (count == capture->n_views && count > 1)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->folder,
                        "black and white are exchanged: the object is darker under white");
    return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->views[first].id,
                    "the photographs under black and white are exchanged: the object is darker under white");
}

// --- Silhouettes under a hypothesis. ---

// Mishaps of one view's photographs.
typedef enum Mishap { TURNED_HALF, TURNED_LEFT, TURNED_RIGHT, MIRRORED, FLIPPED, MISHAPS } Mishap;
static const char *const mishaps[MISHAPS] = {[TURNED_HALF] = "turned by 180 degrees",
                                             [TURNED_LEFT] = "turned by 90 degrees to the left",
                                             [TURNED_RIGHT] = "turned by 90 degrees to the right",
                                             [MIRRORED] = "mirrored left to right",
                                             [FLIPPED] = "mirrored upside down"};

// The mask with the mishap undone.
static FfpImage undone(const FfpImage *mask, Mishap mishap) {
    FfpImage out = ffp_image_new(mask->width, mask->height, 1);
    const int w = mask->width, h = mask->height;
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++) {
            const int from[MISHAPS][2] = {[TURNED_HALF] = {w - 1 - x, h - 1 - y},
                                          [TURNED_LEFT] = {y, w - 1 - x},
                                          [TURNED_RIGHT] = {h - 1 - y, x},
                                          [MIRRORED] = {w - 1 - x, y},
                                          [FLIPPED] = {x, h - 1 - y}};
            out.data[(ptrdiff_t)y * w + x] = mask->data[(ptrdiff_t)from[mishap][1] * w + from[mishap][0]];
        }
    return out;
}

// A capture with views of its own, to be rearranged: everything they point to stays the capture's.
static FfpCapture alias_new(const FfpCapture *capture) {
    FfpCapture alias = *capture;
    alias.views = ffp_alloc((size_t)capture->n_views, sizeof *alias.views);
    memcpy(alias.views, capture->views, (size_t)capture->n_views * sizeof *alias.views);
    return alias;
}

static double misfit_without(const FfpCapture *capture, int view) {
    FfpCapture alias = alias_new(capture);
    alias.n_views--;
    memmove(alias.views + view, alias.views + view + 1, (size_t)(alias.n_views - view) * sizeof *alias.views);
    const double misfit = ffp_rig_silhouette_misfit(&alias);
    ffp_free(alias.views);
    return misfit;
}

static double misfit_undone(const FfpCapture *capture, int view, Mishap mishap) {
    const FfpImage *mask = &capture->views[view].coverage;
    if ((mishap == TURNED_LEFT || mishap == TURNED_RIGHT) && mask->width != mask->height) return INFINITY;
    FfpCapture alias = alias_new(capture);
    alias.views[view].coverage = undone(mask, mishap);
    const double misfit = ffp_rig_silhouette_misfit(&alias);
    ffp_image_free(&alias.views[view].coverage);
    ffp_free(alias.views);
    return misfit;
}

static bool same_size(const FfpImage *a, const FfpImage *b) {
    return a->width == b->width && a->height == b->height;
}

static double misfit_exchanged(const FfpCapture *capture, int a, int b) {
    const FfpView *views = capture->views;
    if (!same_size(&views[a].coverage, &views[b].coverage)) return INFINITY;
    FfpCapture alias = alias_new(capture);
    alias.views[a].coverage = views[b].coverage;
    alias.views[b].coverage = views[a].coverage;
    const double misfit = ffp_rig_silhouette_misfit(&alias);
    ffp_free(alias.views);
    return misfit;
}

// With the photographs in the other direction round the object, the first staying where it is.
static double misfit_reversed(const FfpCapture *capture) {
    const int n = capture->n_views;
    FfpCapture alias = alias_new(capture);
    bool fits = true;
    for (int v = 1; v < n; v++) {
        fits = fits && same_size(&capture->views[v].coverage, &capture->views[n - v].coverage);
        alias.views[v].coverage = capture->views[n - v].coverage;
    }
    const double misfit = fits ? ffp_rig_silhouette_misfit(&alias) : INFINITY;
    ffp_free(alias.views);
    return misfit;
}

// --- Who is to blame. ---

// Fails if a mishap of this view explains it.
static bool try_mishaps(const FfpCapture *capture, int view, double enough, FfpError *err) {
    double least = INFINITY;
    int best = 0;
    for (int m = 0; m < MISHAPS; m++) {
        const double misfit = misfit_undone(capture, view, (Mishap)m);
        if (misfit < least) {
            least = misfit;
            best = m;
        }
    }
    if (!(least < enough)) return true;
    return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->views[view].id,
                    "its photographs contradict the other views, and fit when they are taken as %s",
                    mishaps[best]);
}

// Fails if exchanging two views explains it.
static bool try_exchanges(const FfpCapture *capture, double enough, FfpError *err) {
    double least = INFINITY;
    int a = 0, b = 0;
    for (int i = 0; i < capture->n_views; i++)
        for (int j = i + 1; j < capture->n_views; j++) {
            const double misfit = misfit_exchanged(capture, i, j);
            if (!(misfit < least)) continue;
            least = misfit;
            a = i;
            b = j;
        }
    if (!(least < enough)) return true;
    return ffp_fail(
        err, FFP_ERROR_ARGUMENT, capture->views[a].id,
        "its photographs and those of view %s are exchanged: the silhouettes fit the other way round",
        capture->views[b].id);
}

static bool try_reversal(const FfpCapture *capture, double enough, FfpError *err) {
    return !(misfit_reversed(capture) < enough) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, capture->folder,
                    "the views fit in the opposite order: the turntable turned the other way, change the "
                    "sign of its "
                    "angles");
}

// The view without which the others agree best.
static int odd_one_out(const FfpCapture *capture, double *misfit) {
    int odd = -1;
    *misfit = INFINITY;
    for (int v = 0; v < capture->n_views; v++) {
        const double without = misfit_without(capture, v);
        if (!(without < *misfit)) continue;
        *misfit = without;
        odd = v;
    }
    return odd;
}

static bool check_silhouettes(const FfpCapture *capture, FfpError *err) {
    const double misfit = ffp_rig_silhouette_misfit(capture), enough = MISFIT_EXPLAINED * misfit;
    if (misfit < FFP_RIG_MISFIT_MAX || capture->n_views < VIEWS_TO_ACCUSE) return true;
    double without;
    const int odd = odd_one_out(capture, &without);
    if (without < enough && !try_mishaps(capture, odd, enough, err)) return false;
    if (!try_exchanges(capture, enough, err) || !try_reversal(capture, enough, err)) return false;
    if (without < enough)
        ffp_note("view %s contradicts the others' silhouettes: look at its mask and pose",
                 capture->views[odd].id);
    else
        ffp_note("%.0f %% of the object's pixels contradict the other views' silhouettes: `info` says what "
                 "to look at",
                 100 * misfit);
    return true;
}

bool ffp_rig_suspect(const FfpCapture *capture, FfpError *err) {
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        if (!check_device(capture, view, &view->camera, "camera", err) ||
            !check_device(capture, view, &view->projector, "projector", err))
            return false;
    }
    return check_light(capture, err) && (capture->scene || check_silhouettes(capture, err));
}
