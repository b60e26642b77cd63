#include "engine/apply/choose.h"
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"

bool ffp_choose_among(const FfpView **views, const FfpCapture *source, const char *const *ids, int n_ids,
                      bool again, const char *where, FfpError *err) {
    for (int v = 0; v < (n_ids ? n_ids : source->n_views); v++) {
        const int found = n_ids ? ffp_capture_find_view(source, ids[v]) : v;
        if (found < 0)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, where, "no view %.96s; the views are %s", ids[v],
                            ffp_list_views(source).text);
        views[v] = &source->views[found];
        for (int before = 0; before < v && !again; before++)
            if (views[before] == views[v])
                return ffp_fail(err, FFP_ERROR_ARGUMENT, where, "view %.96s is named twice", views[v]->id);
    }
    return true;
}

bool ffp_choose_views(FfpChosen *chosen, const FfpCapture *capture, const char *poses, const char *const *ids,
                      int n_ids, FfpError *err) {
    *chosen = (FfpChosen){0};
    const FfpCapture *source = capture;
    if (poses) {
        if (!ffp_capture_read_targets(&chosen->poses, poses, capture, err)) return false;
        chosen->has_poses = true;
        source = &chosen->poses;
    }
    chosen->n_views = n_ids ? n_ids : source->n_views;
    chosen->views = ffp_alloc((size_t)chosen->n_views, sizeof *chosen->views);
    return ffp_choose_among(chosen->views, source, ids, n_ids, false, poses ? poses : capture->folder, err);
}

void ffp_chosen_free(FfpChosen *chosen) {
    ffp_free(chosen->views);
    if (chosen->has_poses) ffp_capture_free(&chosen->poses);
    *chosen = (FfpChosen){0};
}
