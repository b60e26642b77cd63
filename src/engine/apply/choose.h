// The views that a caller chose.
#ifndef FFP_APPLY_CHOOSE_H
#define FFP_APPLY_CHOOSE_H

#include "core/capture/capture.h"

typedef struct FfpChosen {
    FfpCapture poses; // where a poses file was named; otherwise empty
    bool has_poses;
    int n_views;
    const FfpView **views; // [n_views], of the capture or the poses
} FfpChosen;

// Views of one source, into views [n_ids, or without ids source->n_views: all]. `where` is for the errors: an
// unknown view and, unless repeats are allowed (`again`), one that is named twice.
bool ffp_choose_among(const FfpView **views, const FfpCapture *source, const char *const *ids, int n_ids,
                      bool again, const char *where, FfpError *err);

// `poses` NULL: views of the capture. No ids: all views. Errors name the unknown view.
bool ffp_choose_views(FfpChosen *chosen, const FfpCapture *capture, const char *poses, const char *const *ids,
                      int n_ids, FfpError *err);
void ffp_chosen_free(FfpChosen *chosen);

#endif
