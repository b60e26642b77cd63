#include "apply/choose.h"

#include <stdlib.h>
#include <string.h>
#include "base/arena.h"

static bool find_view(const FfpCapture *source, const char *id, const char *where, int *found,
                      FfpError *err) {
    *found = ffp_capture_find_view(source, id);
    return *found >= 0 || ffp_fail(err, FFP_ERROR_ARGUMENT, where, "there is no view %.96s; there are %s", id,
                                   ffp_list_views(source).text);
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
    for (int v = 0; v < chosen->n_views; v++) {
        int found = v;
        if (n_ids && !find_view(source, ids[v], poses ? poses : capture->folder, &found, err)) return false;
        for (int before = 0; before < v; before++)
            if (chosen->views[before] == &source->views[found])
                return ffp_fail(err, FFP_ERROR_ARGUMENT, poses ? poses : capture->folder,
                                "view %s is named twice", ids[v]);
        chosen->views[v] = &source->views[found];
    }
    return true;
}

void ffp_chosen_free(FfpChosen *chosen) {
    ffp_free(chosen->views);
    if (chosen->has_poses) ffp_capture_free(&chosen->poses);
    *chosen = (FfpChosen){0};
}
