#include "core/capture/capture.h"
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/vec.h"
#include "core/capture/photograph_files.h"
#include "core/capture/project.h"

#define SAME_POSE 1e-4F
#define SAME_LENS 1e-2F // pixels

void ffp_view_free(FfpView *view, int n_patterns) {
    for (int i = 0; view->images && i < n_patterns; i++) ffp_image_free(&view->images[i]);
    ffp_free(view->images);
    ffp_image_free(&view->coverage);
    ffp_image_free(&view->correspondence);
    ffp_image_free(&view->depth);
    ffp_image_free(&view->normal);
    ffp_image_free(&view->albedo);
    ffp_image_free(&view->roughness);
    ffp_image_free(&view->direct_white);
}

void ffp_capture_free(FfpCapture *capture) {
    if (!capture) return;
    for (int i = 0; capture->views && i < capture->n_views; i++) {
        ffp_view_free(&capture->views[i], capture->n_patterns);
    }
    for (int i = 0; capture->patterns && i < capture->n_patterns; i++) {
        ffp_image_free(&capture->patterns[i].image);
    }
    ffp_free(capture->views);
    ffp_free(capture->patterns);
    ffp_photographs_forget(capture);
    *capture = (FfpCapture){0};
}

int ffp_capture_find_pattern(const FfpCapture *capture, const char *name) {
    for (int i = 0; i < capture->n_patterns; i++) {
        if (strcmp(capture->patterns[i].name, name) == 0) return i;
    }
    return -1;
}

int ffp_capture_find_view(const FfpCapture *capture, const char *id) {
    for (int i = 0; i < capture->n_views; i++) {
        if (strcmp(capture->views[i].id, id) == 0) return i;
    }
    return -1;
}

// The first view without a picture under this pattern, or -1 when all have one.
static int view_without(const FfpCapture *capture, int pattern) {
    for (int i = 0; i < capture->n_views; i++) {
        if (!capture->views[i].images[pattern].data) return i;
    }
    return -1;
}

static bool seen_by_any(const FfpCapture *capture, int pattern) {
    for (int i = 0; i < capture->n_views; i++)
        if (capture->views[i].images[pattern].data) return true;
    return false;
}

// A pattern of structure, by name; -1 with an error.
static int find_structured(const FfpCapture *capture, const char *name, FfpError *err) {
    const int found = ffp_capture_find_pattern(capture, name);
    if (found < 0) {
        ffp_fail(err, FFP_ERROR_ARGUMENT, capture->name, "no pattern '%.96s' in this capture, which has %s",
                 name, ffp_list_patterns(capture).text);
        return -1;
    }
    if (found == capture->black || found == capture->white) {
        ffp_fail(err, FFP_ERROR_ARGUMENT, capture->name,
                 "pattern '%.96s' is uniform: it carries no depth information", name);
        return -1;
    }
    return found;
}

int ffp_capture_active_pattern(const FfpCapture *capture, const char *name, FfpError *err) {
    if (!name) {
        for (int i = 0; i < capture->n_patterns; i++) {
            const bool usable = i != capture->black && i != capture->white && !capture->patterns[i].novel;
            if (usable && view_without(capture, i) < 0) return i;
        }
        ffp_fail(err, FFP_ERROR_FILE, capture->name,
                 "no structured-light pattern under which every view has a picture");
        return -1;
    }
    const int found = find_structured(capture, name, err);
    if (found < 0) return -1;
    const int view = view_without(capture, found);
    if (view < 0) return found;
    ffp_fail(err, FFP_ERROR_FILE, capture->name, "view '%s' has no picture under pattern '%.96s'",
             capture->views[view].id, name);
    return -1;
}

// A pattern beside those already chosen; -1 with an error.
static int find_further(const FfpCapture *capture, const char *name, const int *chosen, int count,
                        FfpError *err) {
    const int found = find_structured(capture, name, err);
    if (found < 0) return -1;
    for (int i = 0; i < count; i++)
        if (chosen[i] == found) {
            ffp_fail(err, FFP_ERROR_ARGUMENT, capture->name, "pattern '%.96s' is named twice", name);
            return -1;
        }
    if (seen_by_any(capture, found)) return found;
    ffp_fail(err, FFP_ERROR_FILE, capture->name, "no view has a picture under pattern '%.96s'", name);
    return -1;
}

int ffp_capture_photographs(const FfpCapture *capture, const char *const *names, int n, int *chosen,
                            FfpError *err) {
    int count = 0;
    chosen[count++] = capture->black;
    chosen[count++] = capture->white;
    const int first = ffp_capture_active_pattern(capture, n > 0 ? names[0] : NULL, err);
    if (first < 0) return -1;
    chosen[count++] = first;
    for (int i = 1; i < n; i++) {
        const int found = find_further(capture, names[i], chosen, count, err);
        if (found < 0) return -1;
        chosen[count++] = found;
    }
    return count;
}

int ffp_capture_unseen(const FfpCapture *capture, const int *chosen, int n, int *unseen) {
    int count = 0;
    for (int p = 0; p < ffp_patterns_shown(capture) && count < FFP_UNSEEN_MAX; p++) {
        bool free = capture->patterns[p].novel && seen_by_any(capture, p);
        for (int i = 0; i < n; i++) free = free && chosen[i] != p;
        if (free) unseen[count++] = p;
    }
    return count;
}

void ffp_capture_normalise(FfpCapture *capture, const real centre[3], real radius) {
    const real origin[3] = {centre[0], centre[1], centre[2]}; // `centre` may be capture->centre
    for (int v = 0; v < capture->n_views; v++) {
        FfpView *view = &capture->views[v];
        for (int i = 0; i < 3; i++) {
            view->camera.pose[4 * i + 3] = (view->camera.pose[4 * i + 3] - origin[i]) / radius;
            view->projector.pose[4 * i + 3] = (view->projector.pose[4 * i + 3] - origin[i]) / radius;
        }
        view->near /= radius;
        view->far /= radius;
        const ptrdiff_t pixels = view->depth.data ? (ptrdiff_t)view->depth.width * view->depth.height : 0;
        for (ptrdiff_t i = 0; i < pixels; i++) view->depth.data[i] /= radius;
    }
    for (int c = 0; c < 3; c++) {
        capture->intensity[c] /= radius * radius;
        capture->centre[c] = 0;
    }
    capture->radius = 1;
}

bool ffp_same_device(const FfpCamera *a, const FfpCamera *b) {
    const real lens[4] = {a->fx - b->fx, a->fy - b->fy, a->cx - b->cx, a->cy - b->cy};
    for (int i = 0; i < 4; i++)
        if (fabs(lens[i]) > SAME_LENS) return false;
    for (int i = 0; i < 16; i++)
        if (fabs(a->pose[i] - b->pose[i]) > SAME_POSE) return false;
    return a->width == b->width && a->height == b->height;
}

real ffp_project(const FfpCamera *camera, const real point[3], real *x, real *y) {
    return ffp_projected(camera, point, x, y);
}

real ffp_pixel_ray(const FfpCamera *camera, real x, real y, real direction[3]) {
    real local[3] = {(x - camera->cx) / camera->fx, (y - camera->cy) / camera->fy, 1};
    ffp_normalise3(local);
    ffp_rotate(camera->pose, local, direction);
    return local[2];
}
