// Photographs of several subjects under many patterns: what photographs.c and room_photographs.c share.
#ifndef FFP_SYNTH_PHOTOGRAPHING_H
#define FFP_SYNTH_PHOTOGRAPHING_H

#include "core/base/file.h"
#include "core/base/log.h"
#include "world/synth/bare_rig.h"
#include "world/synth/simulate.h"
#include "world/synth/synth.h"

// Patterns come in batches: each is sent out once, and lights all subjects with one set of rays.
typedef struct FfpPhotographing {
    void *job;             // first argument of all functions
    const FfpBareRig *rig; // its devices' sizes
    int n_patterns, n_subjects;
    const char *(*name_of)(const void *job, int subject);
    bool (*is_wanted)(const void *job, int subject, int pattern);
    // What the projector sends out, linear; a new image.
    bool (*emit)(const void *job, int pattern, FfpImage *emitted, FfpError *err);
    // The subject under the light's patterns, which begin with `first`: simulates it and develops the view.
    bool (*photograph)(void *job, int subject, const FfpLight *light, int first, FfpError *err);
    // Writes a picture, which it may change; on any thread.
    bool (*write)(const void *job, int subject, int pattern, FfpImage *picture, FfpError *err);
} FfpPhotographing;

// All that is wanted; their number, or -1.
int64_t ffp_photographing_run(const FfpPhotographing *run, FfpError *err);
// Writes the wanted ones among the view's first `count` pictures, on all threads. Error: the first picture's
// that has one.
bool ffp_photographing_develop(const FfpPhotographing *run, int subject, const FfpView *view, int first,
                               int count, FfpError *err);
// Errors of what is asked for: `sensor` has faults of poses, which photographs do not have; `resolution` or
// `attitudes` is out of range.
bool ffp_photographing_check(const FfpSceneSpec *spec, int attitudes, FfpError *err);
// The path of a name in a folder.
bool ffp_photographing_path(const char *folder, const char *name, char path[FFP_PATH_MAX], FfpError *err);

#endif
