// The pictures to draw: views and patterns, from a capture, a file of poses, an orbit or image files.
#ifndef FFP_PIPELINE_PICTURE_JOB_H
#define FFP_PIPELINE_PICTURE_JOB_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "ffprocams.h"

// Views and patterns borrowed from the capture or the poses file, or read for it.
typedef struct FfpPictureJob {
    const FfpPictures *options;
    FfpCapture poses; // only when the options name a file
    bool has_poses;
    const FfpCapture *capture; // the caller's, or the poses where there is none
    FfpView *own;              // [n_views] of an orbit or of another size; NULL: the source's
    int n_views, n_patterns;
    real intensity[3];
    const FfpCapture *source; // of the views: the capture or the poses
    const FfpView **views;    // [n_views] those chosen
    FfpPattern *patterns;     // images are owned when `owned`
    bool *owned;
} FfpPictureJob;

// Checks everything about the job. `capture` may be NULL if the options name poses. Must be freed whether it
// succeeds or not.
bool ffp_picture_job_new(FfpPictureJob *job, const FfpGaussians *gaussians, const FfpCapture *capture,
                         const FfpPictures *options, FfpError *err);
void ffp_picture_job_free(FfpPictureJob *job);

static inline const FfpView *ffp_picture_view(const FfpPictureJob *job, int v) {
    return job->own ? &job->own[v] : job->views[v];
}

// True if pictures are frames with numbers, in place of names.
static inline bool ffp_is_sequence(const FfpPictures *options) {
    return options->orbit != FFP_ORBIT_NONE || options->video;
}

#endif
