// The views that a command was asked for.
#ifndef FFP_APPLY_CHOOSE_H
#define FFP_APPLY_CHOOSE_H

#include "core/capture/capture.h"

typedef struct FfpChosen {
    FfpCapture poses; // where a poses file was named; otherwise empty
    bool has_poses;
    int n_views;
    const FfpView **views; // [n_views], of the capture or the poses
} FfpChosen;

// Views of one source, into views [n_ids, or without ids source->n_views: all]. `where` is for the messages:
// a view that is not there, and, unless it may come `again`, one that is named twice.
bool ffp_choose_among(const FfpView **views, const FfpCapture *source, const char *const *ids, int n_ids,
                      bool again, const char *where, FfpError *err);

// `poses` NULL: views of the capture. No ids: all views. An error names the view that is not there.
bool ffp_choose_views(FfpChosen *chosen, const FfpCapture *capture, const char *poses, const char *const *ids,
                      int n_ids, FfpError *err);
void ffp_chosen_free(FfpChosen *chosen);

#endif
