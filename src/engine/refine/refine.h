// Fits Gaussians to one object's photographs, kept close to a prediction or free of it. The capture is
// normalised (object in the unit sphere) and so are the Gaussians.
#ifndef FFP_REFINE_REFINE_H
#define FFP_REFINE_REFINE_H

#include <stdbool.h>
#include <stdio.h>
#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "engine/refine/adam.h"
#include "engine/render/render.h"

// Changes the number of Gaussians while they are fitted: free of where they began, all in the world's axes.
typedef struct FfpGrowth {
    void *state;
    // A view's gradient to the Gaussians, before it is pulled back.
    void (*note)(void *state, const FfpGaussians *gaussians, const FfpGaussians *grad,
                 const FfpCamera *camera);
    // After each step, from 1. True if the number of parameters may have changed, or opacities were taken
    // back; Adam's state has then been adapted. No such state is a fit's result.
    bool (*step)(void *state, int64_t step, FfpParameters *parameters, const FfpGaussians *gaussians,
                 FfpGaussianAdam *adam_state);
} FfpGrowth;

typedef struct FfpRefineSettings {
    FfpRenderSettings render;
    FfpRates rates;
    double decay;               // all rates but the centre's fall by this factor over the budget, as a power
    double centre_decay;        // the centre's rate falls by this factor over `centre_decay_steps`
    int64_t centre_decay_steps; // 0: over the budget
    real beta1, beta2, epsilon; // Adam's
    bool coupled;               // centres move by ffp_adam_coupled (adam.h); with growth they do not
    real l1, square, ssim, mask, roughness_smooth, normal_smooth, distortion; // weights of the loss terms
    int64_t distortion_from;                                                  // step
    real hold;   // weight of the term that holds pixels to the places that Gray codes found; on the CPU
    real smooth; // share by which a step draws displacements along the normal towards the neighbours' mean
    double mean; // share of the budget, its end, over which the numbers are averaged: that is then the result
    double mean_late; // their weights grow nearly as the step's number in that share to this power; 0: equal
    int shadow_looks; // steps at a view that share a shadow map; up to 1: each draws its own
    bool pairs;       // steps come in twos, both by gradients of the same state: of two views at a time
    bool one_picture; // a step looks at one of the view's pictures, in turn, instead of all
    int codes;        // of the patterns, the last: a look compares one of them, in turn, beside all others
    const FfpGrowth *growth; // NULL: their number stays
    int64_t steps;           // of one view each; 0: no limit
    double seconds;          // of wall clock; 0: no limit
    uint64_t seed;
    bool may_stop;           // when cancelled, the fit returns its result so far
    FILE *metrics;           // a line of JSON per round; NULL: none. Failing to write one ends the fit
    bool measure;            // the PSNR before and after
    bool quiet;              // reports no progress
    const char *label;       // of the progress; NULL: "refining"
    const FfpCapture *there; // for ffp_refine_offered: the capture, if it is on the device already
} FfpRefineSettings;
FfpRefineSettings ffp_refine_defaults(void); // from a prediction
#define FFP_POLISH_DEFAULT_STEPS 72          // of eight views
// A short fit directly after a prediction: faster rates, nothing smoothed or measured.
FfpRefineSettings ffp_polish_defaults(int64_t steps);

// Of a pair's views that have no more pixels than these each is looked at by a thread of its own where there
// are two or three, with buffers of its own.
enum { FFP_AT_ONCE_PIXELS = 512 * 512 };

typedef struct FfpRefineResult {
    int64_t steps, gaussians;
    double seconds;
    double psnr_before, psnr_after; // dB on the pictures fitted, mean over pictures; without 8-bit rounding;
                                    // 0 unless they are to be measured
    double first_psnr,
        best_psnr; // of whole rounds, -INFINITY without one: of states on the way, by the looks
    bool stopped;  // by the caller
    bool dropped;  // the fit made the pictures worse: nothing was changed
} FfpRefineResult;

// Fits to the given patterns of all views (indices into the capture's), as far as a view has photographs
// under them; it must have at least one, and all of a view's have the same weight. Views come in rounds, each
// in an order drawn from the seed, or with pairs all in one such order. The result is the state after the
// round with the highest PSNR; or the mean, if it is asked for and that round was the last complete one or
// the one before it; or the initial state: where it is not clear, that of the three with the highest PSNR on
// the same pictures. Three rounds in a row below the first end the fit. With a limit in steps, the same seed
// and thread count give the same bits. Errors: no Gaussians, no limit, a loss that is not finite. On a
// device, the arrays of the Gaussians, pictures, coverage and patterns are in that device's memory, and
// growth and smoothing are errors.
bool ffp_refine(FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns, int n_patterns,
                const FfpRefineSettings *settings, FfpRefineResult *result, FfpError *err);

// The same for Gaussians and a capture on the host, using the device offered for long work
// (core/base/device.h), if any. Settings that no device supports run on the CPU, and a note says so.
bool ffp_refine_offered(FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns,
                        int n_patterns, const FfpRefineSettings *settings, FfpRefineResult *result,
                        FfpError *err);

// How well Gaussians reproduce the given patterns' pictures of all views: PSNR in dB, mean over the pictures
// that a view has, and over the views.
double ffp_photographs_psnr(const FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns,
                            int n_patterns, const FfpRenderSettings *render);

// The same for one view: over the whole frame, and over the pixels of the object that white lights; of the
// patterns that the Gaussians were made from, and of others. NaN: of nothing.
typedef struct FfpViewScore {
    double psnr, lit, unseen, unseen_lit;
} FfpViewScore;
// Of every view, into scores[n_views], on the CPU; the last n_unseen patterns are the others. Memory: a
// view's pass, two pictures and the patterns.
void ffp_photographs_score(const FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns,
                           int n_patterns, int n_unseen, const FfpRenderSettings *render,
                           FfpViewScore *scores);

// ffp_summed_new on what the thread works on, pattern and table alike; released by ffp_summed_free.
FfpSummed ffp_pattern_summed(const FfpImage *pattern);

#endif
