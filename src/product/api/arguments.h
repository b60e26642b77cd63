// Checks of arguments that their C types do not enforce, made first by every public call. Errors are
// FFP_ERROR_ARGUMENT and name the argument or the option.
#ifndef FFP_API_ARGUMENTS_H
#define FFP_API_ARGUMENTS_H

#include "ffprocams.h"

// A handle, a struct, a text: not NULL.
bool ffp_need(const void *thing, const char *name, FfpError *err);
// Fills a caller's struct of options, whose first field is its size, as far as both sides know it; what only
// the caller knows is 0.
void ffp_give_defaults(void *options, size_t size, const void *defaults, size_t known);
// Copies a caller's options to `own`, which has the defaults: they stay where the caller's struct, named
// `name`, is that of an earlier version. Errors: NULL; no size; that of a later version.
bool ffp_take_options(void *own, const void *options, const char *name, FfpError *err);
// A capture with its photographs in memory: not NULL, and not opened with FFP_READ_NONE.
bool ffp_need_photographs(const FfpCapture *capture, FfpError *err);
// Gaussians, all of whose numbers are finite, with scales above 0 and rotations other than 0: their arrays
// may be written to from outside.
bool ffp_need_gaussians(const FfpGaussians *gaussians, FfpError *err);
// n texts, none of them NULL; n 0: the list is ignored.
bool ffp_need_texts(const char *const *texts, int n, const char *name, FfpError *err);
// An existing form, and a valid number of samples.
bool ffp_check_drawing(FfpDrawing drawing, FfpError *err);
// Names of patterns, and numbers in the ranges of ffprocams/reconstruct.h.
bool ffp_check_reconstruction(const FfpReconstruction *options, FfpError *err);
bool ffp_check_refinement(const FfpRefinement *options, FfpError *err);

#endif
