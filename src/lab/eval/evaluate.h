// Evaluation: captures, or rows of earlier evaluations, in; rows, report and predicted pictures out.
#ifndef FFP_EVAL_EVALUATE_H
#define FFP_EVAL_EVALUATE_H

#include "core/base/error.h"
#include "engine/loss/loss.h"
#include "ffprocams.h" // options and rows, types alone (engine/pipeline/reconstruct.h says why)

// The work of ffp_evaluate (ffprocams/lab.h): the rows (release with ffp_free) and their number, or NULL.
FfpScore *ffp_evaluation_run(const FfpEvaluation *settings, int *n_scores, FfpError *err);
// Weights of LPIPS. Errors: as ffp_perceptual_read, and weights of VGG16.
FfpPerceptual *ffp_lpips_read(const char *path, FfpError *err);

#endif
