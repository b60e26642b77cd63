// One step of a fit, in parts: a view drawn, compared and taken back to the Gaussians; Adam.
#ifndef FFP_REFINE_FIT_H
#define FFP_REFINE_FIT_H

#include "refine/adam.h"
#include "refine/refine.h"

// What the settings ask for that no device has code for, in words; NULL: nothing.
const char *ffp_refine_beyond_devices(const FfpRefineSettings *settings);

// What a view was worth, before the step that it caused.
typedef struct FfpFitLoss {
    double pictures, maps; // the pictures' terms, and those that look at G-buffers
    double psnr;           // mean over the patterns
} FfpFitLoss;

// Draws views and compares; owns the buffers of one view and all pictures that are aimed at.
typedef struct FfpViewer FfpViewer;
FfpViewer *ffp_viewer_new(const FfpCapture *capture, const int *patterns, int n_patterns,
                          const FfpRefineSettings *settings);
void ffp_viewer_free(FfpViewer *viewer);
// PSNR of all views, mean over each view's photographs and over the views.
double ffp_viewer_psnr(FfpViewer *viewer, const FfpGaussians *gaussians);

typedef struct FfpFitLook {
    int view;
    int64_t step; // says which terms count already
    FfpGaussians *grad;
    FfpFitLoss *loss;
} FfpFitLook;

// The losses of one or two views. ADDS each one's gradient to its grad, and what it comes to to its *loss: by
// ffp_loss_add (loss/loss.h), so that a round need not wait for each. Two, which must not be the same, are
// looked at at the same time where that pays; the numbers are those of one after the other.
void ffp_viewer_look(FfpViewer *viewer, const FfpGaussians *gaussians, const FfpFitLook *looks, int n);

// Of an order of all views: behind every other one (the first, the third, ...) comes the one of those left
// that looks from the other side. What two views do not both see, neither's step changes for the other.
void ffp_pair_opposites(const FfpCapture *capture, int *order);

FfpMover ffp_mover_new(const FfpParameters *parameters, const FfpRefineSettings *settings);
void ffp_mover_free(FfpMover *mover);
// One step. `share` of the budget is spent, in [0,1].
void ffp_mover_step(FfpMover *mover, FfpParameters *parameters, const FfpGaussians *grad,
                    const FfpRefineSettings *settings, double share);

#endif
