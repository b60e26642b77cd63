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
    FFP_DEVICE_CUDA, // the first NVIDIA GPU, for training, networks and fits; calls that use it take turns
} FfpDeviceKind;

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
