// Photographs that stay in their files until a view's are asked for.
#ifndef FFP_CAPTURE_PHOTOGRAPHS_H
#define FFP_CAPTURE_PHOTOGRAPHS_H

#include "core/capture/coverage.h"

// The view (an index) with its coverage and its photographs under the `n` given patterns, at width x height
// pixels as ffp_view_reduced makes them: from memory, or of a capture that was opened without photographs
// (ffp_capture_load_devices) from its files, as reading all of it gives them. Pictures that are reduced are
// in memory one at a time. Release with ffp_view_reduced_free. Errors, where they are read from files: a file
// that is missing, broken or of another size than the camera; no photograph under black or white, if that is
// asked for; too little memory.
bool ffp_photographs_read(FfpView *out, const FfpCapture *capture, int view, const int *patterns, int n,
                          int width, int height, FfpError *err);

// True if the view has a photograph under the pattern, in memory or in a file.
bool ffp_photographs_has(const FfpCapture *capture, int view, int pattern);

// True if the view has truth of a kind, in memory or in a file: depth, normal, albedo, roughness, direct
// light.
enum { FFP_TRUTHS = 5 };
bool ffp_photographs_truth(const FfpCapture *capture, int view, int kind);

// --- Inside the room. ---

// Reads one view's pictures, coverage and maps, with their checks. *source tells where the coverage is from.
bool ffp_manifest_load_view(FfpManifest *manifest, int index, FfpCoverageSource *source, FfpError *err);

#endif
