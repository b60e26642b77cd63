#include "world/synth/photographing.h"
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/call.h"

// Patterns at a time: eight, or as many as ROOM holds of their and the pictures' pixels, four bytes for every
// colour.
enum { BATCH_LEAST = 8, BATCH_MOST = 64, HEIGHT_MIN = 64 };
#define ROOM 128e6 // bytes

static int batch_of(const FfpBareRig *rig) {
    const FfpCamera *devices[2] = {&rig->camera, &rig->projector};
    double bytes = 0;
    for (int k = 0; k < 2; k++) bytes += 12.0 * devices[k]->width * devices[k]->height;
    return (int)fmax(BATCH_LEAST, fmin(BATCH_MOST, ROOM / bytes));
}

static int count_wanted(const FfpPhotographing *run, int subject, int first, int count) {
    int wanted = 0;
    for (int p = first; p < first + count; p++) wanted += run->is_wanted(run->job, subject, p);
    return wanted;
}

typedef struct Progress {
    FfpTask task;
    int64_t done;
} Progress;

static bool photograph_batch(const FfpPhotographing *run, Progress *progress, int first, int count,
                             FfpError *err) {
    FfpImage emitted[BATCH_MOST] = {0};
    const FfpImage *images[BATCH_MOST];
    bool ok = true;
    for (int i = 0; ok && i < count; i++) {
        ok = run->emit(run->job, first + i, &emitted[i], err);
        images[i] = &emitted[i];
    }
    if (ok) {
        FfpLight light = ffp_light_new(images, count);
        for (int s = 0; ok && s < run->n_subjects; s++) {
            const int wanted = count_wanted(run, s, first, count);
            if (wanted == 0) continue;
            ok = run->photograph(run->job, s, &light, first, err);
            progress->done += wanted;
            ffp_task_step(&progress->task, progress->done, run->name_of(run->job, s));
        }
        ffp_light_free(&light);
    }
    for (int i = 0; i < count; i++) ffp_image_free(&emitted[i]);
    return ok;
}

int64_t ffp_photographing_run(const FfpPhotographing *run, FfpError *err) {
    const int batch = batch_of(run->rig);
    int64_t all = 0;
    for (int s = 0; s < run->n_subjects; s++) all += count_wanted(run, s, 0, run->n_patterns);
    Progress progress = {.task = ffp_task("photographing", all)};
    bool ok = true;
    for (int first = 0; ok && first < run->n_patterns; first += batch) {
        const int left = run->n_patterns - first;
        ok = photograph_batch(run, &progress, first, left < batch ? left : batch, err);
    }
    ffp_task_end(&progress.task);
    return ok ? all : -1;
}

typedef struct Developing {
    const FfpPhotographing *run;
    int subject, first;
    const FfpView *view;
    FfpError *errors; // of every picture
} Developing;

static void develop(void *argument, int64_t index) {
    const Developing *d = argument;
    const int pattern = d->first + (int)index;
    if (d->run->is_wanted(d->run->job, d->subject, pattern))
        d->run->write(d->run->job, d->subject, pattern, &d->view->images[index], &d->errors[index]);
}

bool ffp_photographing_develop(const FfpPhotographing *run, int subject, const FfpView *view, int first,
                               int count, FfpError *err) {
    FfpError *errors = ffp_alloc((size_t)count, sizeof *errors);
    int good = 0;
    ffp_parallel_for(count, 0, develop, &(Developing){run, subject, first, view, errors});
    while (good < count && errors[good].code == FFP_OK) good++;
    if (good < count && err) *err = errors[good];
    ffp_free(errors);
    return good == count;
}

bool ffp_photographing_check(const FfpSceneSpec *spec, int attitudes, FfpError *err) {
    if (spec->sensor.turn_error > 0 || spec->sensor.shift_error > 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "sensor",
                        "turn_error and shift_error are of written poses: photographs have none");
    if (spec->resolution < HEIGHT_MIN || spec->resolution > 4096)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "resolution", "%d is not in %d..4096", spec->resolution,
                        HEIGHT_MIN);
    return (attitudes >= 0 && attitudes <= 64) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "attitudes", "%d are not in 0..64", attitudes);
}

bool ffp_photographing_path(const char *folder, const char *name, char path[FFP_PATH_MAX], FfpError *err) {
    return ffp_join_path(path, folder, name) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "the path is too long");
}
