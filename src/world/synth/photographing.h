// The common state of the files of photographs.h: a rig, what stands before it in turn, and what is shown to
// it.
#ifndef FFP_SYNTH_PHOTOGRAPHING_H
#define FFP_SYNTH_PHOTOGRAPHING_H

#include "core/base/file.h"
#include "core/patterns/shown.h"
#include "world/synth/photographs.h"
#include "world/synth/room.h"

typedef enum FfpPhotographedKind {
    FFP_SUBJECT_STOP,
    FFP_SUBJECT_BETWEEN, // two stops
    FFP_SUBJECT_EMPTY,
    FFP_SUBJECT_ATTITUDE,
    FFP_SUBJECT_TURNTABLE // the board on it
} FfpPhotographedKind;

typedef struct FfpPhotographed {
    FfpPhotographedKind kind;
    char name[32];   // of its folder
    uint32_t stream; // by which rays and noise are drawn, whichever subjects there are
    double angle;    // by which the turntable has turned
    int stop;        // of the board on it: the number of its one photograph
    FfpChessboard board;
} FfpPhotographed;

typedef struct FfpPhotographing {
    const FfpPhotographs *options;
    const FfpSceneSpec *spec;
    FfpSensor sensor;
    const FfpMesh *mesh;
    FfpMaterial material;
    FfpRoom room; // its rig alone, where there is no room
    FfpShown shown;
    int n_patterns; // that are shown, and behind them those that are held out
    int n_subjects;
    FfpPhotographed *subjects;
    const char *folder; // being written
} FfpPhotographing;

static inline bool ffp_subject_is_board(const FfpPhotographed *subject) {
    return subject->kind >= FFP_SUBJECT_ATTITUDE;
}
// The path of a name in the folder.
static inline bool ffp_photographing_path(const FfpPhotographing *job, const char *name,
                                          char path[FFP_PATH_MAX], FfpError *err) {
    return ffp_join_path(path, job->folder, name) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, job->folder, "the path is too long");
}
// Draws the patterns that are held out, and takes all photographs; their number, or -1. Patterns come in
// batches: each is sent out once, and lights all subjects with one set of rays.
int64_t ffp_photographing_run(const FfpPhotographing *job, FfpError *err);
// truth.json
bool ffp_photographing_truth(const FfpPhotographing *job, FfpError *err);

#endif
