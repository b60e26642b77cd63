// One capture under evaluation, and the protocols that are run on it.
#ifndef FFP_EVAL_SUBJECT_H
#define FFP_EVAL_SUBJECT_H

#include "core/base/file.h"
#include "engine/loss/loss.h"
#include "engine/pipeline/relight.h"
#include "ffprocams/lab.h"
#include "lab/baselines/field.h"
#include "lab/eval/report.h"

typedef struct FfpEvaluating { // the data shared by all captures
    const FfpEvaluation *options;
    FfpPerceptual *lpips;
    FfpReport *report;
    FfpScore *scores;
    int n_scores;
} FfpEvaluating;

#define FFP_FIRST_GIVEN 2 // of the photographs, the first under structured light

typedef struct FfpSubject { // one capture under evaluation
    FfpEvaluating *shared;
    FfpCapture *capture;
    FfpCapture normalised; // lookup predictors only
    FfpCapture targets;
    bool has_targets;
    int given[FFP_PATTERNS_MAX]; // [n_given] black, white and the patterns (ffp_capture_photographs)
    int n_given;
    FfpGaussians *gaussians; // or a field; both NULL for the lookup predictors
    FfpViewPass *pass;
    FfpNeuralField *field;
    FfpFieldPass *field_pass;
    real **depth; // lookup predictors: [n_views] camera z in the normalised capture
    double reconstruct_s;
    FfpReconstructionStats stats; // of the reconstruction, where one was made
    char folder[FFP_PATH_MAX];    // where predictions are saved
} FfpSubject;

// True if the predictor was given the photographs under a pattern.
bool ffp_subject_given(const FfpSubject *subject, int pattern);

// True if there are Gaussians or a field to draw: ffp_subject_draw then draws a view, which can be shaded
// under a pattern, rounded to 8 bits, or returned as a G-buffer, valid until the next.
bool ffp_subject_draws(const FfpSubject *subject);
void ffp_subject_draw(FfpSubject *subject, const FfpCamera *camera, const FfpCamera *projector);
FfpImage ffp_subject_relight(FfpSubject *subject, const FfpSummed *pattern);
const FfpGbuffer *ffp_subject_gbuffer(const FfpSubject *subject);
void ffp_subject_free_drawing(FfpSubject *subject);

// Predicts, measures, reports and saves the pictures of "rendering", "novel_pattern" or "novel_pose"
// (ffprocams/render.h), and adds a row to the scores if there are any; for "rendering" also "unseen" and
// "given". The explanation is for the report.
bool ffp_run_protocol(FfpSubject *subject, const char *name, const char *explanation, FfpError *err);

// One channel, 1 where the specular part of a view's light under white is above 0.05 (linear radiance, mean
// of the channels) by the truth that it holds; 0 elsewhere, and everywhere in a view without truth.
// `intensity`: [3], the projector's (FfpCapture).
FfpImage ffp_gloss_mask(const FfpView *view, const real intensity[3]);

// Compares depth and albedo of the subject's Gaussians with the capture's ground truth, and sets the score's
// figures: NAN without ground truth.
void ffp_measure_truth(FfpSubject *subject, FfpScore *score);

#endif
