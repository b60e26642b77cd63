// One step of a fit, in parts: a view drawn, compared and taken back to the Gaussians; Adam.
#ifndef FFP_REFINE_FIT_H
#define FFP_REFINE_FIT_H

#include "refine/adam.h"
#include "refine/refine.h"

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
// The loss of a view, at a step that says which terms count already. ADDS its gradient to grad, and what it
// comes to to *loss: by ffp_loss_add (loss/loss.h), so that a round need not wait for each.
void ffp_viewer_look(FfpViewer *viewer, const FfpGaussians *gaussians, int view, int64_t step,
                     FfpGaussians *grad, FfpFitLoss *loss);

FfpMover ffp_mover_new(const FfpParameters *parameters, const FfpRefineSettings *settings);
void ffp_mover_free(FfpMover *mover);
// One step. `share` of the budget is spent, in [0,1].
void ffp_mover_step(FfpMover *mover, FfpParameters *parameters, const FfpGaussians *grad,
                    const FfpRefineSettings *settings, double share);

#endif
