// A bounded queue of scenes, filled in advance by threads of its own and emptied in the order in which scenes
// are needed. A scene does not depend on which thread makes it, or when.
#ifndef FFP_TRAIN_QUEUE_H
#define FFP_TRAIN_QUEUE_H

#include <stdatomic.h>
#include "lab/train/train.h"

// Where scenes come from. Both functions are called from several threads at once and must be pure functions
// of their arguments.
typedef struct FfpSceneSource {
    const void *context;
    // The first step from `from` on that needs a scene of its own; -1: there is none.
    int64_t (*next)(const void *context, int64_t from);
    // The scene of such a step; on failure, everything is released.
    bool (*make)(const void *context, int64_t step, FfpScene *scene, FfpError *err);
} FfpSceneSource;

typedef struct FfpQueue FfpQueue;

// `generators` threads (>= 1) begin with the first scene needed from step `first` on and keep at most
// `capacity` (>= 1) scenes, made or in the making. Each has one OpenMP thread, takes no signals and works for
// the context of the caller's call (core/base/call.h), on the CPU, beside that call where it has a device's
// turn. When *stop becomes true no further scene is begun; waiting sets it when that call is cancelled. NULL
// with an error when a thread cannot be started.
FfpQueue *ffp_queue_new(const FfpSceneSource *source, int64_t first, int generators, int capacity,
                        atomic_bool *stop, FfpError *err);
// The next scene needed, now the caller's; waits for it. *stopped: *stop was set while it was not ready, and
// *scene is empty. False with the maker's error when it could not be made.
bool ffp_queue_take(FfpQueue *queue, FfpScene *scene, bool *stopped, FfpError *err);
// Waits for the scenes in the making, at most one a thread, and frees what nobody took. NULL is allowed.
void ffp_queue_free(FfpQueue *queue);

#endif
