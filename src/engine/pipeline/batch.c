#include "engine/pipeline/batch.h"
#include <omp.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "engine/pipeline/maps.h"

// The sums of a view's gradients; one for each view that is worked on at the same time.
typedef struct Slot {
    FfpGaussians gaussians;
    FfpSummed *scatter;   // [n_patterns], over all its views; NULL: not wanted
    FfpImage grad_linear; // of one picture
    real intensity[3];
    FfpAimGradient aim;
} Slot;

struct FfpBatch {
    FfpRenderSettings settings;
    FfpViewPass **passes; // [room]
    int room;
    FfpSummed *patterns; // [n_patterns]; width 0: dark
    FfpImage *linear;    // [views, patterns] radiance of encoded pictures, until their gradients
    int n_views, n_patterns, width, height, pattern_width, pattern_height;
    int64_t kept; // pictures that `linear` has
    FfpGaussians gaussians;
    real intensity[3];
    bool is_linear, gradients;
};

FfpBatch *ffp_batch_new(const FfpRenderSettings *settings) {
    FfpBatch *batch = ffp_alloc(1, sizeof *batch);
    batch->settings = *settings;
    batch->settings.smooth = false; // the same pictures with gradients and without
    return batch;
}

static void free_linear(FfpBatch *batch) {
    for (int64_t i = 0; i < batch->kept; i++) ffp_image_free(&batch->linear[i]);
    ffp_free(batch->linear);
    batch->linear = NULL;
    batch->kept = 0;
}

static void free_patterns(FfpBatch *batch) {
    for (int p = 0; p < batch->n_patterns; p++) ffp_summed_free(&batch->patterns[p]);
    ffp_free(batch->patterns);
    batch->patterns = NULL;
    batch->n_patterns = 0;
}

void ffp_batch_free(FfpBatch *batch) {
    if (!batch) return;
    for (int i = 0; i < batch->room; i++) ffp_view_pass_free(batch->passes[i]);
    ffp_free(batch->passes);
    free_linear(batch);
    free_patterns(batch);
    ffp_free(batch);
}

FfpBatchShape ffp_batch_shape(const FfpBatch *batch) {
    return (FfpBatchShape){batch->gaussians.count,
                           batch->n_views,
                           batch->n_patterns,
                           batch->pattern_width,
                           batch->pattern_height,
                           (size_t)batch->n_views * (size_t)batch->n_patterns * 3 * (size_t)batch->width *
                               (size_t)batch->height,
                           batch->gradients};
}

// --- Forward. ---

static void fit_passes(FfpBatch *batch, const FfpBatchJob *job) {
    if (job->n_views > batch->room) {
        batch->passes = ffp_grow(batch->passes, (size_t)job->n_views, sizeof *batch->passes);
        for (; batch->room < job->n_views; batch->room++)
            batch->passes[batch->room] = ffp_view_pass_new(&batch->settings);
    }
    // Before the first draw: a pass that has drawn without keeps none, which costs a second lookup only.
    for (int i = 0; job->gradients && i < job->n_views; i++) ffp_view_pass_expect_gradients(batch->passes[i]);
}

static void take_patterns(FfpBatch *batch, const FfpBatchJob *job) {
    if (job->same_patterns) return;
    if (batch->n_patterns != job->n_patterns) {
        free_patterns(batch);
        batch->patterns = job->n_patterns ? ffp_alloc((size_t)job->n_patterns, sizeof(FfpSummed)) : NULL;
        batch->n_patterns = job->n_patterns;
    }
    for (int p = 0; p < job->n_patterns; p++) {
        if (job->patterns[p].data)
            ffp_summed_fill(&batch->patterns[p], &job->patterns[p]);
        else
            ffp_summed_free(&batch->patterns[p]);
    }
    batch->pattern_width = job->projectors[0].width;
    batch->pattern_height = job->projectors[0].height;
}

static void fit_linear(FfpBatch *batch, const FfpBatchJob *job) {
    const int width = job->cameras[0].width, height = job->cameras[0].height;
    const int64_t wanted = job->gradients && !job->linear ? (int64_t)job->n_views * batch->n_patterns : 0;
    if (wanted != batch->kept || width != batch->width || height != batch->height) {
        free_linear(batch);
        if (wanted) batch->linear = ffp_alloc((size_t)wanted, sizeof *batch->linear);
        for (; batch->kept < wanted; batch->kept++)
            batch->linear[batch->kept] = ffp_image_new(width, height, 3);
    }
    batch->width = width;
    batch->height = height;
}

static const FfpSummed *pattern_of(const FfpBatch *batch, int p) {
    return batch->patterns[p].width ? &batch->patterns[p] : NULL;
}

typedef struct Forward {
    FfpBatch *batch;
    const FfpBatchJob *job;
    float *pictures;
    float *const *maps;
} Forward;

static size_t pixels_of(const FfpBatch *batch) {
    return (size_t)batch->width * (size_t)batch->height;
}

// Where picture p of view i begins in an array of them all.
static size_t picture_at(const FfpBatch *batch, int64_t i, int p) {
    return (size_t)(i * batch->n_patterns + p) * pixels_of(batch) * 3;
}

static size_t map_at(const FfpBatch *batch, int64_t i, int map) {
    return (size_t)i * pixels_of(batch) * (size_t)ffp_map_width((FfpMap)map);
}

static void draw_picture(const Forward *f, int64_t i, int p) {
    FfpBatch *batch = f->batch;
    FfpViewPass *pass = batch->passes[i];
    FfpImage out = {batch->width, batch->height, 3, f->pictures + picture_at(batch, i, p)};
    const FfpSummed *pattern = pattern_of(batch, p);
    if (batch->is_linear) {
        ffp_view_pass_radiance(pass, batch->intensity, pattern, &out);
    } else if (batch->gradients) {
        FfpImage *linear = &batch->linear[i * batch->n_patterns + p];
        ffp_view_pass_radiance(pass, batch->intensity, pattern, linear);
        ffp_view_pass_resolve(pass, linear, &out);
    } else {
        ffp_view_pass_shade(pass, batch->intensity, pattern, &out);
    }
}

static void draw_view(void *argument, int64_t i) {
    const Forward *f = argument;
    FfpBatch *batch = f->batch;
    FfpViewPass *pass = batch->passes[i];
    ffp_view_pass_draw(pass, &batch->gaussians, &f->job->cameras[i], &f->job->projectors[i]);
    for (int p = 0; p < batch->n_patterns; p++) draw_picture(f, i, p);
    for (int m = 0; f->maps && m < FFP_MAP_COUNT; m++)
        if (f->maps[m])
            ffp_map_values(ffp_view_pass_gbuffer(pass), (FfpMap)m, f->maps[m] + map_at(batch, i, m));
}

// With a view for at least every second thread, each belongs to one thread, which waits for no other;
// otherwise all threads share each.
static int views_at_once(int views) {
    const int threads = omp_get_max_threads();
    return views > 1 && 2 * views > threads ? threads : 1;
}

void ffp_batch_forward(FfpBatch *batch, const FfpBatchJob *job, float *pictures, float *const *maps) {
    batch->gaussians.count = 0; // nothing is drawn until all is
    fit_passes(batch, job);
    take_patterns(batch, job);
    fit_linear(batch, job);
    batch->n_views = job->n_views;
    batch->is_linear = job->linear;
    batch->gradients = job->gradients;
    memcpy(batch->intensity, job->intensity, sizeof batch->intensity);
    batch->gaussians = *job->gaussians;
    Forward f = {batch, job, pictures, maps};
    if (views_at_once(job->n_views) > 1)
        ffp_parallel_for(job->n_views, 0, draw_view, &f);
    else
        for (int i = 0; i < job->n_views; i++) draw_view(&f, i);
}

// --- Backward. ---

typedef struct Backward {
    FfpBatch *batch;
    const float *grad_pictures;
    const float *const *grad_maps;
    const FfpRenderGradients *out;
    Slot *slots;
    int n_slots;
    int64_t first; // the first slot's view
    bool aim;
} Backward;

static void picture_backward(const Backward *b, Slot *slot, int64_t i, int p) {
    FfpBatch *batch = b->batch;
    FfpViewPass *pass = batch->passes[i];
    const float *given = b->grad_pictures + picture_at(batch, i, p);
    FfpImage grad = {batch->width, batch->height, 3, NULL}; // of read-only numbers, as the pass declares it
    const FfpImage *radiance = &grad;
    memcpy(&grad.data, &given, sizeof given);
    if (!batch->is_linear) {
        ffp_view_pass_resolve_backward(pass, &batch->linear[i * batch->n_patterns + p], &grad,
                                       &slot->grad_linear);
        radiance = &slot->grad_linear;
    }
    ffp_view_pass_radiance_backward(pass, batch->intensity, pattern_of(batch, p), radiance, slot->intensity,
                                    slot->scatter && pattern_of(batch, p) ? &slot->scatter[p] : NULL);
}

static void view_backward(void *argument, int64_t k) {
    const Backward *b = argument;
    FfpBatch *batch = b->batch;
    const int64_t i = b->first + k;
    Slot *slot = &b->slots[k];
    FfpViewPass *pass = batch->passes[i];
    ffp_gaussians_clear(&slot->gaussians);
    slot->aim = (FfpAimGradient){.camera = {0}};
    memset(slot->intensity, 0, sizeof slot->intensity);
    ffp_view_pass_forget_gradients(pass);
    for (int p = 0; b->grad_pictures && p < batch->n_patterns; p++) picture_backward(b, slot, i, p);
    for (int m = 0; b->grad_maps && m < FFP_MAP_COUNT; m++)
        if (b->grad_maps[m])
            ffp_map_values_backward(ffp_view_pass_gbuffer(pass), (FfpMap)m,
                                    b->grad_maps[m] + map_at(batch, i, m), ffp_view_pass_grad_gbuffer(pass));
    ffp_view_pass_backward(pass, &slot->gaussians);
    if (b->aim) ffp_view_pass_backward_aim(pass, &slot->gaussians, &slot->aim);
}

// The caller's arrays of the Gaussians' gradients, as they are.
static FfpGaussians wanted_arrays(const FfpRenderGradients *out, int64_t count) {
    const FfpGaussianArrays *a = &out->gaussians;
    return (FfpGaussians){.count = count,
                          .centre = a->centre,
                          .scale = a->scale,
                          .rotation = a->rotation,
                          .opacity = a->opacity,
                          .albedo = a->albedo,
                          .roughness = a->roughness,
                          .ambient = a->ambient,
                          .scattered = a->scattered};
}

// Arrays of `own` that the caller has for it are the caller's, where one slot does all.
static void lend_arrays(FfpGaussians *own, const FfpGaussians *wanted) {
    float **slots[] = {&own->centre, &own->scale,     &own->rotation, &own->opacity,
                       &own->albedo, &own->roughness, &own->ambient,  &own->scattered};
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute to = ffp_attribute(wanted, a);
        *slots[a] = to.data ? to.data : ffp_alloc((size_t)own->count * (size_t)to.width, sizeof(float));
    }
}

static void add_round(const Backward *b, int n, const FfpGaussians *wanted) {
    const FfpRenderGradients out = *b->out;
    for (int k = 0; k < n; k++) {
        const Slot *slot = &b->slots[k];
        const int64_t i = b->first + k;
        for (int a = 0; b->batch->n_views > 1 && a < FFP_ATTRIBUTES; a++) {
            const FfpAttribute to = ffp_attribute(wanted, a), from = ffp_attribute(&slot->gaussians, a);
            for (int64_t j = 0; to.data && j < wanted->count * to.width; j++) to.data[j] += from.data[j];
        }
        for (int c = 0; out.intensity && c < 3; c++) out.intensity[c] += (double)slot->intensity[c];
        for (int c = 0; c < 6; c++) {
            if (out.cameras) out.cameras[6 * i + c] = slot->aim.camera[c];
            if (out.projectors) out.projectors[6 * i + c] = slot->aim.projector[c];
        }
        for (int c = 0; c < 2; c++) {
            if (out.camera_focals) out.camera_focals[2 * i + c] = slot->aim.camera_focal[c];
            if (out.projector_focals) out.projector_focals[2 * i + c] = slot->aim.projector_focal[c];
        }
    }
}

static void add_patterns(const Backward *b, float *out) {
    const FfpBatch *batch = b->batch;
    const int width = batch->pattern_width, height = batch->pattern_height;
    const size_t numbers = (size_t)width * (size_t)height * 3;
    FfpImage part = ffp_image_new(width, height, 3);
    memset(out, 0, (size_t)batch->n_patterns * numbers * sizeof *out);
    for (int p = 0; p < batch->n_patterns; p++)
        for (int s = 0; batch->patterns[p].width && s < b->n_slots; s++) {
            ffp_lookup_gather_pattern(&b->slots[s].scatter[p], &part);
            for (size_t j = 0; j < numbers; j++) out[(size_t)p * numbers + j] += part.data[j];
        }
    ffp_image_free(&part);
}

static void make_slot(const Backward *b, const FfpGaussians *wanted, Slot *slot) {
    const FfpBatch *batch = b->batch;
    slot->gaussians.count = wanted->count;
    if (batch->n_views == 1)
        lend_arrays(&slot->gaussians, wanted);
    else
        slot->gaussians = ffp_gaussians_new(wanted->count);
    if (!batch->is_linear) slot->grad_linear = ffp_image_new(batch->width, batch->height, 3);
    if (!b->out->patterns) return;
    slot->scatter = ffp_alloc((size_t)batch->n_patterns, sizeof *slot->scatter);
    for (int p = 0; p < batch->n_patterns; p++)
        slot->scatter[p] = ffp_summed_zeros(batch->pattern_width, batch->pattern_height);
}

static void free_slot(const Backward *b, const FfpGaussians *wanted, Slot *slot) {
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        real *data = ffp_attribute(&slot->gaussians, a).data;
        if (data != ffp_attribute(wanted, a).data) ffp_free(data);
    }
    ffp_image_free(&slot->grad_linear);
    for (int p = 0; slot->scatter && p < b->batch->n_patterns; p++) ffp_summed_free(&slot->scatter[p]);
    ffp_free(slot->scatter);
}

static void clear_wanted(const Backward *b, const FfpGaussians *wanted) {
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute to = ffp_attribute(wanted, a);
        if (to.data) memset(to.data, 0, (size_t)wanted->count * (size_t)to.width * sizeof *to.data);
    }
    if (b->out->intensity) memset(b->out->intensity, 0, 3 * sizeof *b->out->intensity);
}

void ffp_batch_backward(FfpBatch *batch, const float *grad_pictures, const float *const *grad_maps,
                        const FfpRenderGradients *out) {
    const int at_once = views_at_once(batch->n_views);
    const bool aim = out->cameras || out->projectors || out->camera_focals || out->projector_focals;
    Backward b = {.batch = batch,
                  .grad_pictures = grad_pictures,
                  .grad_maps = grad_maps,
                  .out = out,
                  .n_slots = at_once < batch->n_views ? at_once : batch->n_views,
                  .aim = aim};
    const FfpGaussians wanted = wanted_arrays(out, batch->gaussians.count);
    b.slots = ffp_alloc((size_t)b.n_slots, sizeof *b.slots);
    for (int s = 0; s < b.n_slots; s++) make_slot(&b, &wanted, &b.slots[s]);
    clear_wanted(&b, &wanted);
    for (; b.first < batch->n_views; b.first += b.n_slots) {
        const int64_t left = batch->n_views - b.first;
        const int n = left < b.n_slots ? (int)left : b.n_slots;
        if (n > 1)
            ffp_parallel_for(n, 0, view_backward, &b);
        else
            view_backward(&b, 0);
        add_round(&b, n, &wanted);
    }
    if (out->patterns) add_patterns(&b, out->patterns);
    for (int s = 0; s < b.n_slots; s++) free_slot(&b, &wanted, &b.slots[s]);
    ffp_free(b.slots);
}
