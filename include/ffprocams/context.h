// Who a call works for: where its words and its progress go, who may end it, and what it may use.
#ifndef FFPROCAMS_CONTEXT_H
#define FFPROCAMS_CONTEXT_H

#include <stdbool.h>
#include <stdint.h>
#include "ffprocams/api.h"
#include "ffprocams/error.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum FfpLogLevel {
    FFP_LOG_NOTE,    // what the caller may want to know
    FFP_LOG_WARNING, // what may not be as the caller means it
} FfpLogLevel;

// How far a call is.
typedef struct FfpProgress {
    const char *stage;   // what is being done: "rendering"; NULL: nothing that is counted
    int64_t done, total; // of the stage's pictures, steps or scenes, or of its seconds
    double seconds;      // since the stage began
    double seconds_left; // expected; negative: not known yet
    const char *extra;   // a few words about the last step, or NULL
} FfpProgress;

typedef enum FfpDeviceKind {
    FFP_DEVICE_CPU,
    FFP_DEVICE_CUDA, // the first NVIDIA GPU, for training, networks and the polish behind them; calls that
                     // use it take turns. Fits on their own work on the CPU, and a note says so
} FfpDeviceKind;

// Processes that share a work ("ranks"), each with a context of its own: all of them make the same calls with
// the same options, and each does its share. A table of what they tell each other by, which the program makes
// of MPI (src/cluster) and the library knows nothing else of. Only training, generating and evaluating look
// at it. All ranks call these in the same order, one thread of a rank at a time; sums have the same bits on
// all ranks, and the same ones for the same number of ranks. Failures name what failed.
typedef struct FfpRanks {
    void *user; // passed to all of them
    int rank, count;
    // Begins to add up [count] numbers over all ranks, in place, while the caller goes on: they are not to be
    // touched before sum_finish, which waits for all sums begun.
    void (*sum_begin)(void *user, float *values, int64_t count);
    bool (*sum_finish)(void *user, FfpError *err);
    // Adds up a few numbers, in place.
    bool (*sum)(void *user, double *values, int count, FfpError *err);
    // Of an array whose part first[r] .. first[r + 1] - 1 is rank r's: the parts, into `whole`, on rank `to`
    // alone, where `whole` is NULL on the others, or (to -1) on all. `part` is the caller's own; it may lie
    // in its place in `whole`.
    bool (*gather)(void *user, const float *part, float *whole, const int64_t *first, int to, FfpError *err);
    // Bytes of rank `from`, to all.
    bool (*broadcast)(void *user, void *bytes, int64_t size, int from, FfpError *err);
    // This rank cannot go on, and cannot say so in turn (its memory is out): the others need not wait for it.
    void (*leave)(void *user);
} FfpRanks;

typedef struct FfpContextSettings {
    void *user; // passed to both callbacks
    // A line of text without a line's end; NULL: nobody reads it. May come from threads of the library's own.
    void (*log)(void *user, FfpLogLevel level, const char *text);
    // Called again and again, by the thread that made the call. False ends the call, with
    // FFP_ERROR_CANCELLED where the function does not say otherwise. NULL: nobody asks. What it is given is
    // good until it returns. It must not call the library.
    bool (*progress)(void *user, const FfpProgress *progress);
    double interval; // least seconds between two calls of progress; 0: at every point where work can end
    int threads;     // that may work at a time; 0: as many as OpenMP has (processors, or OMP_NUM_THREADS)
    FfpDeviceKind device;
    const FfpRanks *ranks; // must outlive the context; NULL: this process is alone
} FfpContextSettings;

// Silent, not to be cancelled, all processors, no GPU; what NULL in place of a context means.
FFP_API FfpContextSettings ffp_context_defaults(void);

// Holds no state of the calls made with it: several threads may use one, if its callbacks allow it. Each call
// gives the bits that it gives alone. NULL with an error: a device that is not there.
typedef struct FfpContext FfpContext;
FFP_API FfpContext *ffp_context_new(const FfpContextSettings *settings, FfpError *err);
FFP_API void ffp_context_free(FfpContext *context); // after the last call made with it; NULL is allowed

// Releases memory that a function returns as such (scores, text); NULL is allowed.
FFP_API void ffp_free(void *memory);

#ifdef __cplusplus
}
#endif

#endif
