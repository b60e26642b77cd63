// The state of a training run, shared by the files that implement it: trainer.c has the run from beginning to
// end, the others its parts.
#ifndef FFP_TRAIN_TRAINER_H
#define FFP_TRAIN_TRAINER_H

#include "core/base/device.h"
#include "lab/train/captures.h"
#include "lab/train/mirror.h"
#include "lab/train/shard.h"
#include "lab/train/train.h"
#include "world/synth/picture_folder.h"

typedef struct Trainer {
    FfpTrainConfig config;
    const char *out;
    char origin[FFP_ORIGIN_MAX]; // the weights that the run began with, in words
    FfpModel *model;
    FfpAdam adam;
    FfpPerceptual *perceptual;
    FfpTrainStep *stepper;
    FfpSceneFolder folder;
    FfpStock stock; // of the pictures of generated scenes
    FfpStream *scenes;
    FfpShard share;            // among ranks
    FfpCaptureSet *captures;   // NULL: scenes are generated or read
    FfpCaptureSet *rooms;      // for a share of the generated scenes; NULL: none
    double before, best;       // dB of the held-out captures, polished: with the first weights, with the best
    int64_t best_step, scored; // steps; scored: -1 before this run's first score
    // On a device, which steps are made on: the weights and scenes there. model and adam are then up to date
    // only after download_state.
    const FfpDevice *device;
    FfpMirror *mirror;       // NULL on the CPU
    real *grad;              // where the steps are made
    FILE *metrics;           // rank 0's
    double started, saved;   // seconds
    double wait_s, gather_s; // of the step: for sums, and for the others in turn; gathering weights
    atomic_bool stop;        // no further step, and no further scene
} Trainer;

static inline bool ffp_trainer_is_first(const Trainer *trainer) { // the rank that writes
    return trainer->share.turn.rank == 0;
}

// --- trainer_open.c ---

// All but the scenes. close: of what has been opened.
bool ffp_trainer_open(Trainer *trainer, const FfpTrainRun *options, FfpError *err);
void ffp_trainer_close(Trainer *trainer);

// --- trainer_step.c ---

typedef enum FfpStepOutcome {
    FFP_STEP_LEARNT,
    FFP_STEP_STOPPED, // nothing has changed
    FFP_STEP_FAILED,  // nothing has changed
    FFP_STEP_BROKEN   // the ranks have lost contact, or cannot agree on the outcome
} FfpStepOutcome;
// *save_due: a checkpoint is.
FfpStepOutcome ffp_trainer_step(Trainer *trainer, int64_t step, bool *save_due, FfpError *err);

// --- trainer_save.c ---

// "out/name".
bool ffp_trainer_path(char path[FFP_PATH_MAX], const Trainer *trainer, const char *name, FfpError *err);
// The model with the averaged weights in place of the current ones, until called again.
void ffp_trainer_swap_ema(Trainer *trainer, FfpAdam *whole);
// The state of all ranks on the first, or its averaged weights alone; released by ffp_shard_state_free.
bool ffp_trainer_gather(Trainer *trainer, bool average_only, FfpAdam *whole, FfpError *err);
// The averaged weights as a model file.
bool ffp_trainer_write_weights(Trainer *trainer, FfpAdam *whole, FfpError *err);
// A checkpoint and the weights, by all ranks together.
bool ffp_trainer_save(Trainer *trainer, FfpError *err);

// --- report.c: a line of metrics.jsonl, and a note of the same. On rank 0; false when the line cannot be
// written. ---

bool ffp_metrics_step(const Trainer *trainer, int64_t step, const FfpLosses *losses, double norm,
                      bool skipped, double scene_s, double step_s, FfpError *err);
bool ffp_metrics_validation(const Trainer *trainer, int64_t step, const FfpValidation *v, FfpError *err);
bool ffp_metrics_held_out(const Trainer *trainer, int64_t step, const FfpHeldOut *score, bool gain,
                          FfpError *err);

// --- held_out.c: of the weights, those that predict the held-out captures best are kept. ---

bool ffp_held_out_open(Trainer *trainer, FfpError *err); // reads the captures
// Scores the averaged weights, and writes them where they are the best: those at the start are the first.
bool ffp_held_out_score(Trainer *trainer, FfpAdam *whole, int64_t step, FfpError *err);
// A resumed run has the weights of its best step so far, which are scored again.
bool ffp_held_out_resume(Trainer *trainer, FfpError *err);
// True if scores have not improved for too long (config.patience).
bool ffp_held_out_is_over(const Trainer *trainer);
void ffp_held_out_tell(const Trainer *trainer); // of the first weights and the best ones

#endif
