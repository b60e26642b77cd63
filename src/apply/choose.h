// The views that a command was asked for.
#ifndef FFP_APPLY_CHOOSE_H
#define FFP_APPLY_CHOOSE_H

#include "capture/capture.h"

typedef struct FfpChosen {
    FfpCapture poses; // where a poses file was named; else empty
    bool has_poses;
    int n_views;
    const FfpView **views; // [n_views], of the capture or the poses
} FfpChosen;

// `poses` NULL: views of the capture. No ids: all views. An error names the view that is not there.
bool ffp_choose_views(FfpChosen *chosen, const FfpCapture *capture, const char *poses, const char *const *ids,
                      int n_ids, FfpError *err);
void ffp_chosen_free(FfpChosen *chosen);

#endif
