// A training run at work, as the files that make it share it: trainer.c has the steps and the run, report.c
// what the run tells, held_out.c what it learns from captures that it does not learn from.
#ifndef FFP_TRAIN_TRAINER_H
#define FFP_TRAIN_TRAINER_H

#include "base/device.h"
#include "train/captures.h"
#include "train/mirror.h"
#include "train/share.h"
#include "train/train.h"

typedef struct Trainer {
    FfpTrainConfig config;
    const char *out;
    char origin[FFP_ORIGIN_MAX]; // what the run began with
    FfpModel *model;
    FfpAdam adam;
    FfpPerceptual *perceptual;
    FfpStepper *stepper;
    FfpSceneFolder folder;
    FfpStream *scenes;
    FfpShare share;            // among ranks
    FfpCaptureSet *captures;   // NULL: scenes are generated or read
    double before, best;       // dB of the held-out captures, polished: with the first weights, with the best
    int64_t best_step, scored; // steps; scored: -1 before this run's first score
    // On a device, which steps are made on: the weights and scenes there. model and adam are then up to date
    // only after come_home.
    const FfpDevice *device;
    FfpMirror *mirror;       // NULL on the CPU
    real *grad;              // where the steps are made
    FILE *metrics;           // rank 0's
    double started, saved;   // seconds
    double wait_s, gather_s; // of the step: for sums, and for the others in turn; gathering weights
    atomic_bool stop;        // no further step, and no further scene
} Trainer;

// "out/name".
bool ffp_trainer_path(char path[FFP_PATH_MAX], const Trainer *trainer, const char *name, FfpError *err);
// The model with the averaged weights in place of the current ones, until called again.
void ffp_trainer_swap_ema(Trainer *trainer, FfpAdam *whole);
// The averaged weights as a model file.
bool ffp_trainer_write_weights(Trainer *trainer, FfpAdam *whole, FfpError *err);
// Of the averaged weights of a step: a validation, or with captures the score of those held out. By all ranks
// together.
bool ffp_trainer_validate(Trainer *trainer, int64_t step, FfpError *err);

// --- report.c: a line of metrics.jsonl, and a note of the same. On rank 0; false when the line cannot be
// written. ---

bool ffp_tell_step(const Trainer *trainer, int64_t step, const FfpLosses *losses, double norm, bool skipped,
                   double scene_s, double step_s, FfpError *err);
bool ffp_tell_validation(const Trainer *trainer, int64_t step, const FfpValidation *v, FfpError *err);
bool ffp_tell_held_out(const Trainer *trainer, int64_t step, const FfpHeldOut *score, bool gain,
                       FfpError *err);

// --- held_out.c: of the weights, those that predict the held-out captures best are kept. ---

bool ffp_held_out_open(Trainer *trainer, FfpError *err); // reads the captures
// The weights at the start are the first that are kept. A resumed run has those of its best step so far,
// which are scored anew.
bool ffp_held_out_begin(Trainer *trainer, bool resume, FfpError *err);
// Scores the averaged weights, and writes them where they are the best.
bool ffp_held_out_score(Trainer *trainer, FfpAdam *whole, int64_t step, FfpError *err);
// Whether the last score was one too many without a gain (config.patience).
bool ffp_held_out_is_over(const Trainer *trainer);
// The last weights have their score too, however the run ended.
bool ffp_held_out_end(Trainer *trainer, FfpError *err);

#endif
