// The memory that a reconstruction needs, computed before it begins.
#ifndef FFP_PIPELINE_NEED_H
#define FFP_PIPELINE_NEED_H

#include "core/capture/capture.h"
#include "engine/network/network.h"
#include "ffprocams.h"

// The quantities that it depends on.
typedef struct FfpProblemSize {
    int views, width, height;      // of the widest and highest view
    int photographs;               // of a view: black, white and the patterns used
    double pattern;                // pixels of a pattern
    double share;                  // of the pixels that show the object
    bool scene;                    // it is of a whole scene
    bool denoise, polish;          // noise is filtered; the splats are fitted
    int samples;                   // per side of a pixel, while fitting
    int threads;                   // that match views at the same time
    const FfpModelConfig *network; // NULL: the classical initialisation alone
} FfpProblemSize;

FfpProblemSize ffp_problem_size(const FfpCapture *capture, const FfpReconstruction *options);

// The peak number of bytes that a reconstruction takes besides the capture: the sum of what it keeps
// (filtered photographs, the start, splats) and the largest amount that a stage takes in addition. Between
// 0.8 and 1.6 times the measured peak.
double ffp_reconstruction_bytes(const FfpProblemSize *scale);

// The bytes that drawing a view takes, without its picture: projected splats, their order in every tile, and
// G-buffers of samples x samples places per pixel.
double ffp_drawing_bytes(double splats, double pixels, int samples);
// Of a view's pictures under several patterns, of which `rows` rows are drawn at once, and with smooth
// outlines `margin` more above and below (0: they are not).
double ffp_pictures_bytes(double splats, const FfpCamera *camera, int samples, int rows, int margin,
                          int pictures);

// The bytes that the maps of a view take: the picture that is kept, and a strip while it is drawn.
double ffp_warps_bytes(double splats, const FfpView *view, int samples);
// The bytes that compensation takes (engine/apply/procams.h): all that is kept of all cameras' and
// projectors' pixels, and the largest strip while it is drawn.
double ffp_compensation_bytes(double splats, const FfpView *const *views, int n_views, int samples);

// Checks that a reconstruction needs at most `available` bytes (negative: not known, and the check passes).
// The error says how much is needed, how much is available, and which resolution would fit.
bool ffp_check_memory(const FfpCapture *capture, const FfpReconstruction *options, double available,
                      FfpError *err);

#endif
