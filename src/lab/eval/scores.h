// The rows of an evaluation: their means, and all as JSON.
#ifndef FFP_EVAL_SCORES_H
#define FFP_EVAL_SCORES_H

#include "ffprocams.h"

#define FFP_PROTOCOLS 5
#define FFP_UNSEEN "unseen" // of the pictures of "rendering" those that the predictor was not given,
#define FFP_GIVEN "given"   // and those that it was given
// In the order of the rows: novel_pattern, novel_pose, unseen, rendering, given.
extern const char *const ffp_protocols[FFP_PROTOCOLS];

// The means over captures of a protocol's rows, figure by figure; returns the number of rows. A figure
// missing from one row is missing from the mean; only that of highlights is averaged over the rows that have
// it. Numbers of images, and the seconds for all of them, are added up.
int ffp_scores_mean(FfpScore *mean, const FfpScore *scores, int n_scores, const char *protocol);

// Appends the rows of such a file to the n_scores that exist; *predictor is the file's, not truncated,
// released with ffp_free (NULL after an error). Errors name file and field: a file of another kind, or a row
// that exists already.
bool ffp_scores_read(FfpScore **scores, int *n_scores, char **predictor, const char *path, FfpError *err);

// {"version", "predictor", "rows": [one per capture and protocol], "means": [one per protocol]} into
// options->json. Figures that do not apply are null.
bool ffp_scores_write(const FfpScore *scores, int n_scores, const FfpEvaluation *options, FfpError *err);

#endif
