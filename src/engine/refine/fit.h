// One step of a fit, in parts: a view drawn, compared and taken back to the Gaussians; Adam.
#ifndef FFP_REFINE_FIT_H
#define FFP_REFINE_FIT_H

#include "engine/refine/adam.h"
#include "engine/refine/refine.h"

// dB that a fit's best round has more than its first, from which it has clearly gained: nothing need be drawn
// again to see it.
#define FFP_CLEAR_GAIN 1

// The setting that no device supports, in words for a message; NULL: none.
const char *ffp_refine_beyond_devices(const FfpRefineSettings *settings);

// The losses of a view, before its step.
typedef struct FfpFitLoss {
    double pictures, maps; // the pictures' terms, and those that look at G-buffers
    double psnr;           // mean over the patterns; Gray codes, which take turns, do not count
} FfpFitLoss;

// Draws views and compares; owns the buffers of one view and all pictures that are aimed at.
typedef struct FfpPhotoLoss FfpPhotoLoss;
FfpPhotoLoss *ffp_photo_loss_new(const FfpCapture *capture, const int *patterns, int n_patterns,
                                 const FfpRefineSettings *settings);
void ffp_photo_loss_free(FfpPhotoLoss *viewer);
// PSNR of all views, mean over each view's photographs and over the views.
double ffp_photo_loss_psnr(FfpPhotoLoss *viewer, const FfpGaussians *gaussians);

typedef struct FfpFitView {
    int view;
    int64_t step; // determines which terms are already active
    FfpGaussians *grad;
    FfpFitLoss *loss;
} FfpFitView;

// The losses of one or two views. ADDS each one's gradient to its grad, and its value to its *loss, by
// ffp_loss_add (engine/loss/loss.h), so that a round need not wait for each. Two views, which must differ,
// are processed at the same time if that is faster; the numbers are the same as one after the other.
void ffp_photo_loss_backward(FfpPhotoLoss *viewer, const FfpGaussians *gaussians, const FfpFitView *looks,
                             int n);

// Rearranges an order of all views: after every other one (the first, the third, ...) comes the remaining one
// that looks from the opposite side. The step of one such view does not change splats that only the other
// sees.
void ffp_pair_opposites(const FfpCapture *capture, int *order);

FfpGaussianAdam ffp_gaussian_adam_new(const FfpParameters *parameters, const FfpRefineSettings *settings);
void ffp_gaussian_adam_free(FfpGaussianAdam *adam_state);
// One step. `share` of the budget is spent, in [0,1].
void ffp_gaussian_adam_step(FfpGaussianAdam *adam_state, FfpParameters *parameters, const FfpGaussians *grad,
                            const FfpRefineSettings *settings, double share);

#endif
