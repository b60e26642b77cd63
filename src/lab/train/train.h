// Training: scenes generated on the fly, one step, the optimiser,
// checkpoints, validation. Everything random in a step is a pure function of (seed, draw), so a resumed run
// repeats the bits of one that was never stopped.
#ifndef FFP_TRAIN_TRAIN_H
#define FFP_TRAIN_TRAIN_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include "core/base/error.h"
#include "core/base/file.h"
#include "core/capture/capture.h"
#include "engine/loss/loss.h"
#include "engine/match/match.h"
#include "engine/network/network.h"
#include "engine/render/render.h"

#define FFP_TRAIN_VIEWS_MAX 64 // input views of a scene, and new poses

// Every field has the same name in the configuration file (JSON, see docs/reference/training.md); ranges
// are in config.c.
typedef struct FfpTrainConfig {
    FfpModelConfig model; // "model": a preset's name, or an object with a "preset" and the fields that differ
    int64_t seed, steps;
    int batch; // scenes whose gradients are averaged in a step, by all ranks together

    // Scenes. A slot of the pool keeps its scene for `reuse` uses; the slots are visited in turn.
    int pool, reuse;
    int views, targets, lollipops; // input views, new-pose views, patterns besides black and white
    int resolution, pattern_side, samples, ambient_rays;
    double sensor_share;   // of the training scenes: seen through a sensor model of random strength
    double material_share; // of the training scenes: their material is a picture of the folder `materials`
    double pattern_share; // likewise: all their lollipops but the first are pictures of the folder `patterns`
    char materials[FFP_PATH_MAX], patterns[FFP_PATH_MAX]; // world/synth/picture_folder.h; empty: none
    double room_share;        // of the training scenes: a room of the folder `rooms` instead (captures.h)
    char rooms[FFP_PATH_MAX]; // empty: none
    int views_least;          // a training scene has views_least..views input views; 0: all have views
    double free_share;        // of the training scenes: with a free rig
    double large_share;       // of the training scenes: at large_resolution instead
    int large_resolution;
    char captures[FFP_PATH_MAX]; // folder of your own captures to learn from instead (captures.h); empty:
                                 // none
    int patience;                // with captures: steps without improvement on those held out before stopping
    char scenes[FFP_PATH_MAX];   // folder made by `ffprocams generate` to take scenes from; empty: made here
    int generators; // threads that make scenes in advance; 0: the training thread makes each when it is
                    // needed
    int queue;      // number of scenes made in advance

    // Supervision of a step: views drawn from the input views (all of a scene that has fewer) and from the
    // new-pose views; of a room, as many from the latter alone.
    int supervised_inputs, supervised_targets;
    double polish_share; // of the steps supervise the prediction after a fit of polish_steps
    int polish_steps;

    // Weights of the terms (0 = off).
    double l1, ssim, perceptual, mask, depth, distortion, normal_smooth, roughness_smooth, direct_t;
    double truth_albedo, truth_normal, truth_roughness; // G-buffers against the generator's maps
    int perceptual_from;                                // step from which the perceptual term counts
    int white_from, active_from; // the same for pictures under white and under lollipops (the paper's T_w,
                                 // T_p, Sec. 3.6); black counts from the first

    // AdamW.
    double learning_rate, final_learning_rate, beta1, beta2, weight_decay, clip, skip_above, ema;
    int warmup_steps;
    bool looks_only;
    bool recompute; // blocks of the network keep their inputs alone (FfpRun)

    // Reports.
    int validate_every, validation_scenes, log_every;
    int checkpoint_minutes, checkpoint_steps; // both apply; checkpoint_steps 0: minutes only
} FfpTrainConfig;

FfpTrainConfig ffp_train_defaults(void);
// The defaults for learning from your own captures: short, at a low rate, without terms that need ground
// truth.
FfpTrainConfig ffp_fine_tuning_defaults(void);
// Overlays the configuration with a JSON file. Unknown fields, wrong types and values out of range are errors
// "(FILE: FIELD)".
bool ffp_train_config_overlay(FfpTrainConfig *config, const char *path, FfpError *err);
// The same from text over the defaults; `where` names it in errors.
bool ffp_train_config_parse(FfpTrainConfig *config, const char *text, const char *where, FfpError *err);
// JSON text, released with ffp_free; reads back to the same configuration. NULL with an error where a text in
// it is not UTF-8.
char *ffp_train_config_print(const FfpTrainConfig *config, FfpError *err);
// The fields as tables of Markdown: names, defaults, ranges, meanings. docs/reference/training.md has them.
void ffp_train_write_fields(FILE *out);

// --- The parts, in the order of a step; used by ffp_train and by the tests. ---

// A scene ready for training: capture normalised by bounds estimated from the input views alone, as a user's
// would be.
typedef struct FfpScene {
    FfpCapture capture; // input views first, then the new-pose views
    FfpCapture inputs;  // the same memory seen with only the input views: do not free
    bool borrowed; // both borrow all but their lists of views (captures.h); inputs may differ in noise and
                   // padding. On a device (mirror.h) each has its own pictures
    bool targets_only; // of the new poses alone there are clean pictures, and only they are supervised
    FfpInitialisation start;
    FfpPixelContext context; // of the configuration's model
    FfpSummed *patterns;     // [capture.n_patterns]
    int active;              // input pattern
    // Where a device is offered (core/base/device.h), else NULL. A scene on the device (mirror.h) lacks
    // `start` and `context`:
    FfpPrepared *prepared; // the network's inputs from the scene
    real *true_t;          // [its Gaussians] true distances (ffp_scene_distances)
} FfpScene;
struct FfpStock; // world/synth/picture_folder.h
// The scene of a number: mesh, material and jitter follow from (config->seed, split, number), and with them
// in the training split the number of views, the rig and whether it is large: then it is made at
// config->large_resolution; and whether it has a material or patterns from the stock, which holds the
// configuration's folders of pictures (NULL: it has none). Errors name the scene.
bool ffp_scene_open(FfpScene *scene, const FfpTrainConfig *config, const struct FfpStock *stock,
                    const char *split, int64_t number, FfpError *err);
// The validation scene of a number with a free rig: the same object, light and new poses.
bool ffp_scene_open_free(FfpScene *scene, const FfpTrainConfig *config, int64_t number, FfpError *err);
void ffp_scene_close(FfpScene *scene);

// The training scenes of a folder made by `ffprocams generate`: its captures called train_<number>.
#define FFP_SCENE_NAME_MAX 32
typedef struct FfpSceneFolder {
    char path[FFP_PATH_MAX];
    int64_t count;
    char (*names)[FFP_SCENE_NAME_MAX]; // [count], sorted
} FfpSceneFolder;
// The list; a folder without any such scene is an error.
bool ffp_scene_folder_open(FfpSceneFolder *folder, const char *path, FfpError *err);
void ffp_scene_folder_close(FfpSceneFolder *folder); // safe on {0}
// The name of the `number`-th scene drawn: all of them once in an order of (seed, round), then the next
// round.
const char *ffp_scene_folder_name(const FfpSceneFolder *folder, int64_t seed, int64_t number);
// The capture of a name, as the generator would make it with the configuration's views, targets and
// lollipops: input views, new poses; black, white, lollipops. More than that in the folder is left out (the
// first are kept); less, another resolution, no depth, or a missing true map that a term needs is an error
// with file and field.
bool ffp_scene_folder_read(FfpCapture *capture, const FfpSceneFolder *folder, const char *name,
                           const FfpTrainConfig *config, FfpError *err);
// As ffp_scene_open, for the `number`-th scene drawn from the folder.
bool ffp_scene_read(FfpScene *scene, const FfpTrainConfig *config, const FfpSceneFolder *folder,
                    int64_t number, FfpError *err);

// The scenes of a run, draw by draw: step s makes the draws s * config->batch and on, a batch of them. A
// draw's contents are a pure function of the configuration, the folder and the draw, whatever
// config->generators and config->queue are, and however many ranks there are. Draw d is rank d % count's, and
// so is slot d % pool: no scene is made by two of them (lab/train/shard.h).
int ffp_scene_slot(const FfpTrainConfig *config, int64_t draw);       // of the pool
int64_t ffp_scene_number(const FfpTrainConfig *config, int64_t draw); // a slot's scene changes in turn
typedef struct FfpRank {                                              // one rank among so many
    int rank, count;
} FfpRank;
typedef struct FfpStream FfpStream;
struct FfpCaptureSet; // captures.h
// Where scenes come from.
typedef struct FfpSceneOrigin {
    const FfpSceneFolder *folder;         // read; NULL: generated
    const struct FfpCaptureSet *captures; // or photographs of the user's; NULL: none
    const struct FfpStock *stock;         // of the pictures of generated ones; NULL: none
    const struct FfpCaptureSet *rooms;    // for config->room_share of the generated ones; NULL: none
} FfpSceneOrigin;
// For the draws of a rank in the steps first..end-1, which must be asked for in turn. Nothing is begun any
// more once *stop is true. All that is passed but `origin` itself must outlive the stream, also where the
// call at work is left: it lies on no stack then. NULL with an error when threads cannot be started.
FfpStream *ffp_stream_new(const FfpTrainConfig *config, const FfpSceneOrigin *origin, FfpRank turn,
                          int64_t first, int64_t end, atomic_bool *stop, FfpError *err);
// The draw's scene, the stream's own, good until the next call; *scene is NULL when *stop came before it was
// ready. *fresh: the slot has changed with this draw.
bool ffp_stream_scene(FfpStream *stream, int64_t draw, const FfpScene **scene, bool *fresh, FfpError *err);
void ffp_stream_free(FfpStream *stream); // waits for scenes in the making, one a thread; NULL is allowed

// True distance along the unit ray of a pixel (index into the view's images); 0 where there is no surface or
// no truth.
real ffp_true_t(const FfpView *view, int pixel);

// The same for `count` pixels of the input views, each (view * height + y) * width + x.
void ffp_scene_distances(real *out, const FfpScene *scene, const int64_t *pixel, int64_t count);

typedef enum FfpLossTerm {
    FFP_TERM_L1,
    FFP_TERM_SSIM,
    FFP_TERM_PERCEPTUAL,
    FFP_TERM_MASK,
    FFP_TERM_DEPTH,
    FFP_TERM_DISTORTION,
    FFP_TERM_NORMAL_SMOOTH,
    FFP_TERM_ROUGHNESS_SMOOTH,
    FFP_TERM_DIRECT_T,
    FFP_TERM_TRUTH_ALBEDO,
    FFP_TERM_TRUTH_NORMAL,
    FFP_TERM_TRUTH_ROUGHNESS,
    FFP_LOSS_TERMS
} FfpLossTerm;
extern const char *const ffp_loss_term_names[FFP_LOSS_TERMS];

typedef enum FfpStepPhase {
    FFP_PHASE_FORWARD,
    FFP_PHASE_POLISH,
    FFP_PHASE_RASTERISE,
    FFP_PHASE_SHADE,
    FFP_PHASE_LOSS,
    FFP_PHASE_SHADE_BACKWARD,
    FFP_PHASE_RASTERISE_BACKWARD,
    FFP_PHASE_BACKWARD,
    FFP_PHASES
} FfpStepPhase;
extern const char *const ffp_step_phase_names[FFP_PHASES];

typedef struct FfpLosses {
    double term[FFP_LOSS_TERMS]; // weighted values of a step
    double total;                // their sum
    double seconds[FFP_PHASES];  // of the step
    FfpProfile network;          // parts of FFP_PHASE_FORWARD and _BACKWARD
} FfpLosses;
// The state of a step besides the model, reused from step to step. Created, used and freed on a device
// (core/base/device.h), it works there: model, scene (ffp_scene_upload) and gradient are then in the device's
// memory.
typedef struct FfpTrainStep FfpTrainStep;
FfpTrainStep *ffp_train_step_new(const FfpTrainConfig *config, const FfpPerceptual *perceptual);
void ffp_train_step_free(FfpTrainStep *stepper);
FfpRun *ffp_train_step_run(FfpTrainStep *stepper);
// Loss of one draw's scene; ADDS the gradient to `grad` [model->count].
bool ffp_train_step_loss(FfpTrainStep *stepper, const FfpModel *model, const FfpScene *scene, int64_t draw,
                         FfpLosses *losses, real *grad, FfpError *err);

// The optimiser's state of the weights `first` to first + count - 1, of which those before `learning` stay as
// they are.
typedef struct FfpAdam {
    int64_t count, step;
    real *m, *v, *ema; // [count]
    int64_t first, learning;
} FfpAdam;
FfpAdam ffp_adam_new(const FfpModel *model); // of all weights
void ffp_adam_free(FfpAdam *adam);
void ffp_adam_keep(FfpAdam *adam, int64_t first, int64_t count); // of what it has, that alone
double ffp_learning_rate(const FfpTrainConfig *config,
                         int64_t step); // linear warm-up, then cosine to the final rate
// Clips, updates values and EMA; returns the raw gradient norm. If the norm is not finite or is above
// skip_above
// * clip, only the step count changes (*skipped).
double ffp_adam_update(FfpAdam *adam, FfpModel *model, const real *grad, const FfpTrainConfig *config,
                       bool *skipped);
// Its two halves: the sum of squares of the gradients of its weights that learn; and the update, given the
// norm of all. `grad` is a sum over config->batch scenes, of which the norm is that of the mean.
double ffp_adam_squares(const FfpAdam *adam, const real *grad);
void ffp_adam_move_all(FfpAdam *adam, FfpModel *model, const real *grad, const FfpTrainConfig *config,
                       double norm, bool *skipped);

#define FFP_FREE_VALIDATION 3 // scenes of the validation that are also seen by free rigs
// Mean PSNR of the model on fixed scenes of the validation split.
typedef struct FfpValidation {
    double rendering,
        novel_pose; // dB, full frame: lollipops not given at the input poses; all patterns at new poses
    double polished_rendering, polished_novel_pose; // after a fit of polish_steps to the input views
    double start_rendering, start_novel_pose;       // the classical initialisation on the same pictures
    double free_rendering, free_novel_pose;         // with free rigs; 0 where free_share is 0
    double polished_free_rendering, polished_free_novel_pose;
    double depth_median; // of |t - truth|, % of the object's radius, foreground pixels of the input views
} FfpValidation;
// Fits Gaussians of the scene's input views to their black, white and active pictures: config->polish_steps.
bool ffp_scene_polish(FfpGaussians *gaussians, const FfpTrainConfig *config, const FfpRenderSettings *render,
                      const FfpScene *scene, uint64_t seed, FfpError *err);
bool ffp_validate(const FfpModel *model, const FfpTrainConfig *config, const char *picture,
                  FfpValidation *result, FfpError *err);

// Checkpoint: values, EMA, both moments (F32, of all weights), the step, the configuration and the origin,
// which says in words what weights the run began with. Atomic.
#define FFP_ORIGIN_MAX 256
bool ffp_checkpoint_write(const char *path, const FfpModel *model, const FfpAdam *adam,
                          const FfpTrainConfig *config, const char *origin, FfpError *err);
// The model (new), and what belongs to it, into the arguments; NULL with an error.
FfpModel *ffp_checkpoint_read(const char *path, FfpAdam *adam, FfpTrainConfig *config,
                              char origin[FFP_ORIGIN_MAX], FfpError *err);

// A training run (the public header describes the fields, in FfpTraining).
typedef struct FfpTrainRun {
    const char *out, *config, *initial, *perceptual; // only `out` is needed
    const char *captures;                            // NULL: none
    int64_t steps, stop_at;                          // -1 and 0: as the configuration says, to the end
    bool resume;
} FfpTrainRun;
// Runs to the end, or until the call is cancelled, in which case it writes a checkpoint first and succeeds.
// With ranks (the context's) each processes its share of every step's scenes; rank 0 writes.
bool ffp_train_run(const FfpTrainRun *options, FfpError *err);

#endif
