// The rows of an evaluation as JSON.
#ifndef FFP_EVAL_SCORES_H
#define FFP_EVAL_SCORES_H

#include "ffprocams.h"

// {"version", "predictor", "rows": [a row a capture and protocol], "means": [a row a protocol]} into
// options->json. Figures that do not apply are null.
bool ffp_scores_write(const FfpScore *scores, int n_scores, const FfpEvaluation *options, FfpError *err);

#endif
