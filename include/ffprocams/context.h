// Settings for calls: where messages and progress go, who may cancel, and which resources may be used.
#ifndef FFPROCAMS_CONTEXT_H
#define FFPROCAMS_CONTEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "ffprocams/api.h"
#include "ffprocams/error.h"
#include "ffprocams/findings.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum FfpLogLevel {
    FFP_LOG_NOTE,    // information
    FFP_LOG_WARNING, // something may not be what the caller intended
} FfpLogLevel;

// Progress of a call.
typedef struct FfpProgress {
    const char *stage;   // such as "rendering"; NULL: nothing to count
    int64_t done, total; // pictures, steps, scenes or seconds of the stage; 0 of 0: not counted
    double elapsed_s;    // since the stage began
    double left_s;       // estimate; negative: not known yet
    const char *extra;   // a few words about the last step, or NULL
} FfpProgress;

typedef enum FfpDeviceKind {
    FFP_DEVICE_CPU,
    FFP_DEVICE_CUDA, // the first NVIDIA GPU, for training, networks and the polish that follows them; calls
                     // that use it take turns. Other fits run on the CPU, and a note says so
} FfpDeviceKind;

// Processes that share a job ("ranks"), each with its own context: all make the same calls with the same
// options, and each does its share. These functions are how they communicate; the program implements them
// with MPI (src/product/cluster). Only training, generating and evaluating use them. All ranks call them in
// the same order, one thread of a rank at a time; sums are identical to the bit on all ranks, and for equal
// numbers of ranks. Errors name what failed.
typedef struct FfpRanks {
    void *user; // passed to all functions
    int rank, count;
    // Starts adding up [count] numbers over all ranks, in place, while the caller continues. They must not be
    // accessed before sum_finish, which waits for all sums that were started.
    void (*sum_begin)(void *user, float *values, int64_t count);
    bool (*sum_finish)(void *user, FfpError *err);
    // Adds up a few numbers over all ranks, in place.
    bool (*sum)(void *user, double *values, int count, FfpError *err);
    // Gathers an array of which rank r has first[r] .. first[r + 1] - 1 into `whole`, on rank `to` alone
    // (`whole` is NULL on the others) or, with to -1, on all ranks. `part` is the caller's own part and may
    // already be at its place in `whole`.
    bool (*gather)(void *user, const float *part, float *whole, const int64_t *first, int to, FfpError *err);
    // Sends bytes from rank `from` to all.
    bool (*broadcast)(void *user, void *bytes, int64_t size, int from, FfpError *err);
    // This rank cannot continue and cannot report it in the usual order (it is out of memory): the others
    // must not wait for it.
    void (*leave)(void *user);
    FFP_RESERVED;
} FfpRanks;

typedef struct FfpContextSettings {
    size_t size; // set by ffp_context_defaults
    void *user;  // passed to all callbacks, which must not throw, longjmp or call with a context
    // Receives a line of text without a newline; NULL: no messages. May be called from threads of the
    // library.
    void (*log)(void *user, FfpLogLevel level, const char *text);
    // Receives what is found wrong (findings.h) as values, which are valid until it returns; NULL: their text
    // goes to `log`. A fault that ends the call comes here before.
    void (*finding)(void *user, const FfpFinding *finding);
    // Called repeatedly by the thread that made the call. Returning false cancels the call, which then fails
    // with FFP_ERROR_CANCELLED unless documented otherwise. NULL: no progress. The pointers passed to it are
    // valid until it returns.
    bool (*progress)(void *user, const FfpProgress *progress);
    double interval_s; // 0 or more: minimum between calls of progress; 0: call it at every cancellation point
    int threads; // number to use, up to 4096; 0: OpenMP's default (all processors, or OMP_NUM_THREADS). A
                 // process that was forked after a call uses one
    FfpDeviceKind device;
    const FfpRanks *ranks; // must outlive the context; NULL: a single process
    // Where calls get the memory of their work and results: `bytes`, a multiple of `alignment`, aligned to
    // it, or NULL if there are none. `release` gives a block back, and may be called until the last handle or
    // text that such a call returned is closed. Any thread of the library calls them. Both or neither (the C
    // library's). Not for what other libraries take (OpenBLAS, OpenMP, image formats, the GPU's memory), the
    // library's own bookkeeping, the contents that ffp_gaussians_bytes and ffp_model_bytes gather, and
    // buffers that a thread keeps from call to call.
    void *(*allocate)(void *user, size_t alignment, size_t bytes);
    void (*release)(void *user, void *memory);
} FfpContextSettings;

// Silent, not cancellable, all processors, no GPU; equivalent to passing NULL as context.
FFP_DEFAULTS(FfpContextSettings, ffp_context_defaults)

// Holds no state of the calls made with it: several threads may share one if its callbacks allow it, and each
// call gives the same bits as on its own. Fails if the device is not available.
typedef struct FfpContext FfpContext;
FFP_API FfpContext *ffp_context_new(const FfpContextSettings *settings, FfpError *err);
FFP_API void ffp_context_free(FfpContext *context); // after the last call that uses it; accepts NULL

// Releases memory returned by a function (scores, text); accepts NULL.
FFP_API void ffp_free(void *memory);

#ifdef __cplusplus
}
#endif

#endif
