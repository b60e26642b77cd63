// The fit: steps of some rays each, until steps or seconds end. Losses and phases follow Nepmap's released
// program: smooth L1 of the pictures, the visibility network beside the densities' transmittance, normals
// that face the camera and follow the density; first the black pictures alone, then all of them. Ours are the
// mask term, and rates for a hash grid, an exponential fall instead of six steps by 1/4.
#include <math.h>
#include <string.h>
#include "core/base/call.h"
#include "core/base/device.h"
#include "core/base/file.h"
#include "core/base/hash.h"
#include "core/base/log.h"
#include "core/base/text.h"
#include "core/tensor/adam.h"
#include "engine/loss/metrics.h"
#include "lab/baselines/checkpoint.h"
#include "lab/baselines/chunk.h"
#include "lab/baselines/kernels/kernels.h"

enum {
    CHUNKS = 16,     // of a step, whatever the number of threads: so the bits do not depend on it
    RENEW_EVERY = 8, // steps
    RENEW_PARTS = 4, // of all cells: renewed each time
    FIRST_RAYS = 40, // of a chunk
    TELL_EVERY = 100 // steps
};
#define FINE_SHARE 0.3   // of the budget, after which steps along the rays are shorter
#define SAVE_EVERY 120.0 // seconds
#define FIRST_STEP (1.0F / 64)
#define FINE_STEP (1.0F / 96)

FfpFieldSettings ffp_field_defaults(void) {
    return (FfpFieldSettings){.grid_rate = 0.01,
                              .net_rate = 0.003,
                              .decay = 0.02,
                              .black_share = 0.03,
                              .samples = 1 << 15,
                              .mask = 0.1F,
                              .visibility = 0.1F,
                              .facing = 0.01F,
                              .match = 0.01F,
                              .seed = 1};
}

typedef struct Fit {
    FfpNeuralField *field;
    const FfpFieldSettings *settings;
    FfpFieldScene scene;
    FfpFieldChunk chunks[CHUNKS];
    FfpFieldCells cells;
    real *grad, *mean, *square; // [layout.count]
    int64_t step;
    int rays;   // of a chunk
    int summed; // steps that the three below are of
    double square_error, numbers, loss;
    double started, saved;
    char *name; // of the fit, in its checkpoint; NULL: it has none
    FfpTask progress;
} Fit;

static double share_spent(const Fit *fit) {
    return ffp_share_spent(fit->step, fit->settings->steps, fit->started, fit->settings->seconds);
}

// --- A step. ---

static void run_chunk(Fit *fit, int index, int n_patterns) {
    FfpFieldChunk *chunk = &fit->chunks[index];
    FfpRng rng = ffp_rng(fit->settings->seed, (uint64_t)fit->step * CHUNKS + (uint64_t)index);
    const real per_ray = 1 / (real)(CHUNKS * fit->rays);
    ffp_field_chunk_draw(chunk, fit->field, &fit->scene, fit->rays, &rng);
    chunk->looks = 0;
    ffp_field_chunk_forward(chunk, fit->field);
    ffp_field_chunk_hold(chunk, fit->field, &fit->scene, &rng);
    ffp_field_chunk_loss(chunk, fit->field, &fit->scene, fit->settings, n_patterns, per_ray);
    ffp_field_chunk_backward(chunk, fit->field);
}

// Chunks in order, level by level: no two threads add to one number.
static void scatter(Fit *fit) {
    const FfpFieldLayout *layout = &fit->field->layout;
    FfpFieldScatter *add = ffp_field_kernels()->scatter;
#pragma omp parallel for schedule(dynamic)
    for (int l = FFP_FIELD_LEVELS - 1; l >= 0; l--)
        for (int c = 0; c < CHUNKS; c++) {
            const FfpFieldChunk *chunk = &fit->chunks[c];
            const int64_t row = (int64_t)l * FFP_FIELD_FEATURES * FFP_CHUNK_ROW;
            add(&layout->levels[l], chunk->position, chunk->points, FFP_CHUNK_ROW, chunk->d_encoded + row,
                fit->grad);
            add(&layout->levels[l], chunk->look_position, chunk->looks, FFP_CHUNK_ROW,
                chunk->d_look_encoded + row, fit->grad);
        }
    for (int c = 0; c < CHUNKS; c++)
        for (int64_t i = layout->grid; i < layout->count; i++)
            fit->grad[i] += fit->chunks[c].gradient[i - layout->grid];
}

// The parameters from `from` on.
static FfpAdamArray part_of(const Fit *fit, const FfpAdamStep *step, int64_t from, int64_t count) {
    return (FfpAdamArray){.step = *step,
                          .count = count,
                          .x = fit->field->parameters + from,
                          .mean = fit->mean + from,
                          .square = fit->square + from,
                          .grad = fit->grad + from};
}

// A grid point that no ray comes near stays as it is (Mueller et al. 2022, section 4).
static void move_all(Fit *fit, double share) {
    const FfpFieldSettings *s = fit->settings;
    const FfpFieldLayout *layout = &fit->field->layout;
    const double fall = pow(s->decay, share);
    FfpAdamStep step = ffp_adam_step(s->grid_rate * fall, 0.9, 0.99, 1e-15, fit->step + 1);
    step.sparse = true;
    FfpAdamArray parts[2] = {part_of(fit, &step, 0, layout->grid)};
    step.rate = (real)(s->net_rate * fall);
    parts[1] = part_of(fit, &step, layout->grid, layout->count - layout->grid);
    ffp_adam(parts, 2);
#pragma omp parallel for simd schedule(static)
    for (int64_t i = 0; i < layout->count; i++) fit->grad[i] = 0;
}

// As many rays as will have the points that are asked for, by those of the last step.
static void aim_at_samples(Fit *fit) {
    int64_t points = 0, rays = 0;
    for (int c = 0; c < CHUNKS; c++) {
        points += fit->chunks[c].points;
        rays += fit->chunks[c].n_rays;
    }
    const double per_ray = fmax((double)points / (double)rays, 1);
    const double wanted = (double)fit->settings->samples / CHUNKS / per_ray;
    fit->rays = (int)fmin(fmax(0.5 * (fit->rays + wanted), 8), FFP_CHUNK_RAYS);
}

static void note_losses(Fit *fit) {
    for (int c = 0; c < CHUNKS; c++) {
        const FfpChunkLoss *l = &fit->chunks[c].loss;
        fit->loss += l->pictures + l->mask + l->visibility + l->facing + l->match;
        fit->square_error += l->square;
        fit->numbers += (double)l->numbers;
    }
    fit->summed++;
}

static void one_step(Fit *fit) {
    const double share = share_spent(fit);
    const FfpFieldSettings *s = fit->settings;
    const int n_patterns = share < s->black_share ? 1 : fit->scene.n_patterns;
    fit->field->step = share < FINE_SHARE ? FIRST_STEP : FINE_STEP;
    if (fit->step > 0 && fit->step % RENEW_EVERY == 0) {
        FfpRng rng = ffp_rng(s->seed, ((uint64_t)1 << 40) + (uint64_t)fit->step);
        ffp_field_cells_renew(&fit->cells, fit->field, fit->cells.count / RENEW_PARTS + 1, &rng);
    }
#pragma omp parallel for schedule(dynamic)
    for (int c = 0; c < CHUNKS; c++) run_chunk(fit, c, n_patterns);
    scatter(fit);
    move_all(fit, share);
    note_losses(fit);
    aim_at_samples(fit);
    fit->step++;
}

// --- All of them. ---

// Progress counts steps where they are the only limit, otherwise thousandths of the budget.
static bool counts_steps(const FfpFieldSettings *settings) {
    return settings->steps > 0 && !(settings->seconds > 0);
}

static int64_t progress_of(const Fit *fit) {
    return counts_steps(fit->settings) ? fit->step
                                       : (int64_t)(share_spent(fit) * (double)fit->progress.total);
}

static bool check_numbers(const Fit *fit, FfpError *err) {
    bool finite = isfinite(fit->loss);
    for (int64_t i = 0; i < fit->field->layout.count && finite; i++)
        finite = isfinite(fit->field->parameters[i]);
    return finite ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, fit->scene.capture->folder, "the loss is no longer finite");
}

// Reports on the last steps. The pixels that no ray is drawn from are black in the photographs and in the
// field alike, so they lower the mean.
static bool tell(Fit *fit, FfpError *err) {
    char extra[128];
    const double mean = fit->square_error / fmax(fit->numbers, 1) * fit->scene.share;
    const double psnr = -10 * log10(fmax(mean, 1e-10)), loss = fit->loss / fit->summed;
    if (!check_numbers(fit, err)) return false;
    snprintf(extra, sizeof extra, "step %lld, loss %.5f, %.2f dB, %d rays a step", (long long)fit->step, loss,
             psnr, CHUNKS * fit->rays);
    if (!fit->settings->quiet) ffp_task_step(&fit->progress, progress_of(fit), extra);
    fit->loss = fit->square_error = fit->numbers = 0;
    fit->summed = 0;
    if (!fit->settings->metrics) return true;
    fprintf(fit->settings->metrics, "{\"step\": %lld, \"seconds\": %.3f, \"loss\": %.6f, \"psnr\": %.4f}\n",
            (long long)fit->step, ffp_seconds() - fit->started, loss, psnr);
    if (fflush(fit->settings->metrics) == 0) return true;
    return ffp_fail(err, FFP_ERROR_IO, NULL, "cannot write the metrics");
}

static bool over(const Fit *fit) {
    return share_spent(fit) >= 1 || (fit->settings->may_stop && ffp_cancelled());
}

static uint64_t hash_image(uint64_t so_far, const FfpImage *image) {
    const int size[3] = {image->width, image->height, image->channels};
    so_far = ffp_hash(so_far, size, sizeof size);
    return ffp_hash(so_far, image->data,
                    (size_t)image->width * (size_t)image->height * (size_t)image->channels * sizeof(real));
}

// Of all that decides how the fit goes and that its name does not say.
static uint64_t hash_fit(const FfpCapture *capture, const int *patterns, int n_patterns,
                         const FfpFieldSettings *s) {
    const double numbers[] = {s->grid_rate, s->net_rate,   s->decay,  s->black_share, (double)s->samples,
                              s->mask,      s->visibility, s->facing, s->match,       s->noise};
    uint64_t sum = ffp_hash(FFP_HASH_NONE, numbers, sizeof numbers);
    sum = ffp_hash(sum, capture->intensity, sizeof capture->intensity);
    sum = ffp_hash(sum, capture->centre, sizeof capture->centre);
    sum = ffp_hash(sum, &capture->radius, sizeof capture->radius);
    for (int p = 0; p < n_patterns; p++) {
        sum = ffp_hash_text(sum, capture->patterns[patterns[p]].name);
        sum = hash_image(sum, &capture->patterns[patterns[p]].image);
    }
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        const int frame[2] = {view->frame_width, view->frame_height};
        ffp_cancel_point();
        sum = ffp_hash(sum, &view->camera, sizeof view->camera);
        sum = ffp_hash(sum, &view->projector, sizeof view->projector);
        sum = ffp_hash(sum, frame, sizeof frame);
        sum = hash_image(sum, &view->coverage);
        for (int p = 0; p < n_patterns; p++) sum = hash_image(sum, &view->images[patterns[p]]);
    }
    return sum;
}

// The name of a fit: its field, its pictures, its length.
static char *name_fit(const FfpCapture *capture, const int *patterns, int n_patterns,
                      const FfpFieldSettings *s) {
    const FfpCapture *source = s->source ? s->source : capture;
    FfpText *text = ffp_text_new();
    fprintf(ffp_text_stream(text), "%s, %d views, %d patterns, seed %llu, %lld steps, %g s: %016llx",
            source->name, source->n_views, n_patterns, (unsigned long long)s->seed, (long long)s->steps,
            s->seconds, (unsigned long long)hash_fit(source, patterns, n_patterns, s));
    return ffp_text_end(text);
}

static bool save(Fit *fit, FfpError *err) {
    const FfpFieldState state = {fit->field,
                                 fit->mean,
                                 fit->square,
                                 fit->step,
                                 fit->cells.next,
                                 fit->rays,
                                 ffp_seconds() - fit->started};
    fit->saved = ffp_seconds();
    return check_numbers(fit, err) &&
           (!fit->name || ffp_field_state_write(&state, fit->name, fit->settings->checkpoint, err));
}

// Where the checkpoint is, if there is one.
static bool go_on(Fit *fit, FfpError *err) {
    FfpFieldState state = {.field = fit->field, .mean = fit->mean, .square = fit->square};
    if (!fit->name || !ffp_is_file(fit->settings->checkpoint)) return true;
    if (!ffp_field_state_read(&state, fit->name, fit->settings->checkpoint, err)) return false;
    fit->step = state.step;
    fit->rays = state.rays < FFP_CHUNK_RAYS ? state.rays : FFP_CHUNK_RAYS;
    fit->cells.next = state.next_cell % fit->cells.count;
    fit->started -= state.seconds;
    ffp_note("%s: resuming from step %lld", fit->settings->checkpoint, (long long)fit->step);
    return true;
}

static bool run(Fit *fit, FfpError *err) {
    bool ok = go_on(fit, err);
    fit->progress = ffp_task("fitting a field", counts_steps(fit->settings) ? fit->settings->steps : 1000);
    while (ok && !over(fit)) {
        one_step(fit);
        if (fit->step % TELL_EVERY == 0) ok = tell(fit, err);
        if (ok && ffp_seconds() - fit->saved > SAVE_EVERY) ok = save(fit, err);
    }
    ffp_task_end(&fit->progress);
    return ok && save(fit, err);
}

// The mean PSNR of some of the views, drawn whole.
static double measure(const Fit *fit) {
    const FfpCapture *capture = fit->scene.capture;
    const int n = capture->n_views < FFP_FIELD_MEASURED ? capture->n_views : FFP_FIELD_MEASURED;
    double sum = 0;
    FfpFieldPass *pass = ffp_field_pass_new();
    FfpSummed *summed = ffp_alloc((size_t)fit->scene.n_patterns, sizeof *summed);
    for (int p = 0; p < fit->scene.n_patterns; p++) summed[p] = ffp_summed_new(fit->scene.patterns[p].image);
    for (int i = 0; i < n; i++) {
        const FfpView *view = &capture->views[(int64_t)i * capture->n_views / n];
        ffp_field_pass_draw(pass, fit->field, &view->camera, &view->projector, capture->intensity);
        for (int p = 0; p < fit->scene.n_patterns; p++) {
            FfpImage picture = ffp_field_pass_shade(pass, &summed[p]);
            FfpImage truth = ffp_image_copy(&view->images[fit->scene.chosen[p]]);
            ffp_image_to_srgb(&truth);
            sum += ffp_psnr(&picture, &truth);
            ffp_image_free(&picture);
            ffp_image_free(&truth);
        }
    }
    for (int p = 0; p < fit->scene.n_patterns; p++) ffp_summed_free(&summed[p]);
    ffp_free(summed);
    ffp_field_pass_free(pass);
    return sum / (n * fit->scene.n_patterns);
}

static Fit fit_new(FfpNeuralField *field, const FfpCapture *capture, const int *patterns, int n_patterns,
                   const FfpFieldSettings *settings) {
    const size_t count = (size_t)field->layout.count;
    Fit fit = {.field = field, .settings = settings, .rays = FIRST_RAYS, .started = ffp_seconds()};
    if (settings->checkpoint) fit.name = name_fit(capture, patterns, n_patterns, settings);
    fit.scene = ffp_field_scene_new(capture, patterns, n_patterns);
    for (int c = 0; c < CHUNKS; c++) fit.chunks[c] = ffp_field_chunk_new(&field->layout);
    fit.cells = ffp_field_cells_new(field);
    fit.saved = fit.started;
    fit.grad = ffp_alloc(count, sizeof(real));
    fit.mean = ffp_alloc(count, sizeof(real));
    fit.square = ffp_alloc(count, sizeof(real));
    return fit;
}

static void fit_free(Fit *fit) {
    for (int c = 0; c < CHUNKS; c++) ffp_field_chunk_free(&fit->chunks[c]);
    ffp_field_cells_free(&fit->cells);
    ffp_field_scene_free(&fit->scene);
    ffp_free(fit->name);
    ffp_free(fit->grad);
    ffp_free(fit->mean);
    ffp_free(fit->square);
}

static bool check(const FfpCapture *capture, const FfpFieldSettings *settings, FfpError *err) {
    if (ffp_device())
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, capture->folder, "a field is fitted on the CPU only");
    if (settings->steps <= 0 && settings->seconds <= 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->folder, "the fit has no limit");
    return ffp_output_probe(settings->checkpoint, err);
}

// The field's rays look at all patterns.
static bool check_pictures(const FfpCapture *capture, const int *patterns, int n_patterns, FfpError *err) {
    for (int i = 0; i < capture->n_views * n_patterns; i++) {
        const FfpView *view = &capture->views[i / n_patterns];
        const int pattern = patterns[i % n_patterns];
        if (!view->images[pattern].data)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->folder,
                            "view %s has no picture under pattern %s", view->id,
                            capture->patterns[pattern].name);
    }
    return true;
}

bool ffp_field_fit(FfpNeuralField *field, const FfpCapture *capture, const int *patterns, int n_patterns,
                   const FfpFieldSettings *settings, FfpFieldResult *result, FfpError *err) {
    if (!check_pictures(capture, patterns, n_patterns, err) || !check(capture, settings, err)) return false;
    ffp_cancel_hold_off(true); // from here on what there is counts
    *field = ffp_neural_field_new(settings->seed);
    if (ffp_field_carve(field, capture) == 0) {
        ffp_neural_field_free(field);
        return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->folder,
                        "the views' silhouettes leave no common room for an object");
    }
    Fit fit = fit_new(field, capture, patterns, n_patterns, settings);
    const bool ok = run(&fit, err);
    if (ok) {
        result->steps = fit.step;
        result->seconds = ffp_seconds() - fit.started;
        result->stopped = settings->may_stop && ffp_cancelled();
        result->psnr = measure(&fit);
    }
    if (ok && settings->source) {
        memcpy(field->centre, settings->source->centre, sizeof field->centre);
        field->radius = settings->source->radius;
    }
    fit_free(&fit);
    if (!ok) ffp_neural_field_free(field);
    return ok;
}
