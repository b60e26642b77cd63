// Evaluation: captures, or rows of earlier evaluations, in; rows, report and predicted pictures out.
#ifndef FFP_EVAL_EVALUATE_H
#define FFP_EVAL_EVALUATE_H

#include "core/base/error.h"
#include "ffprocams.h" // options and rows, types alone (engine/pipeline/reconstruct.h says why)

// The work of ffp_evaluate (ffprocams.h): the rows (release with ffp_free) and their number, or NULL.
FfpScore *ffp_evaluation_run(const FfpEvaluation *settings, int *n_scores, FfpError *err);

#endif
