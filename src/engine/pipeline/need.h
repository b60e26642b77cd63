// How much memory a reconstruction needs, known before it begins.
#ifndef FFP_PIPELINE_NEED_H
#define FFP_PIPELINE_NEED_H

#include "core/capture/capture.h"
#include "engine/network/network.h"
#include "ffprocams.h"

// What the need depends on.
typedef struct FfpProblemSize {
    int views, width, height;      // of the widest and highest view
    int photographs;               // of a view: black, white and the patterns used
    double pattern;                // pixels of a pattern
    double share;                  // of the pixels that show the object
    bool denoise, polish;          // whether noise is taken away, and whether the splats are fitted
    int samples;                   // a side of a pixel, while fitting
    int threads;                   // that match views at a time
    const FfpModelConfig *network; // NULL: the classical initialisation alone
} FfpProblemSize;

FfpProblemSize ffp_problem_size(const FfpCapture *capture, const FfpReconstruction *options);

// The most bytes that a reconstruction takes at a time beside the capture: the sum of what stays (photographs
// without noise, the start, splats) and the largest of what its stages take besides. Between 0.8 and 1.6
// times what is measured.
double ffp_reconstruction_bytes(const FfpProblemSize *scale);

// The bytes that drawing a view takes, without its picture: projected splats, their order in every tile, and
// G-buffers of samples x samples places a pixel.
double ffp_drawing_bytes(double splats, double pixels, int samples);

// Whether a reconstruction needs at most `available` bytes (negative: nobody knows, and it does). The error
// says how much is needed, how much there is, and which resolution would fit.
bool ffp_check_memory(const FfpCapture *capture, const FfpReconstruction *options, double available,
                      FfpError *err);

#endif
