// The current call of a public function: its context, which everything it calls can see; the resources it
// holds; and the way out of it when memory runs out or the caller cancels it. In these cases ffp_alloc or
// ffp_cancel_point does not return: all resources of the call are released, and the public
// function returns with an error. PostgreSQL's memory contexts work in the same way.
#ifndef FFP_BASE_CALL_H
#define FFP_BASE_CALL_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include "core/base/alloc.h"
#include "core/base/device.h"
#include "core/base/error.h"
#include "ffprocams/context.h" // public types that all rooms share

struct FfpContext {
    FfpContextSettings settings;
    const FfpDevice *device;        // for long work; NULL: the CPU
    bool beside;                    // its calls help one that has the device's turn: they wait for none
    atomic_llong allocations, fail; // so far; the one that fails, for tests; 0: none
};

// --- Calls. ---

// Runs a public function's work for the context (NULL: the defaults) and returns the result of `work`, or
// false if the call was aborted. If false, memory that the work allocated is released. If the thread is
// already in a call, it only runs the work: nested calls belong to the outer one. Meanwhile numbers are read
// and written as in the C locale, by this thread and in bodies of ffp_parallel_for; the callbacks have the
// caller's locale.
bool ffp_call_run(FfpContext *context, bool (*work)(void *argument, FfpError *err), void *argument,
                  FfpError *err);

// The context of the call that this thread is in; NULL: it is in none, or has the defaults.
FfpContext *ffp_call_context(void);

// In a child process: it does not belong to its parent's call. Running out of memory ends the process.
void ffp_call_forget(void);

// Runs the body for every index in 0..count-1, on up to `threads` threads (0: all). In a parallel region only
// bodies may allocate memory and be cancelled; once one is aborted no others are started, and the call ends
// after the region. (Small loops inside bodies are plain OpenMP.)
void ffp_parallel_for(int64_t count, int threads, void (*body)(void *argument, int64_t index),
                      void *argument);

// --- Being cancelled. ---

// A point at which work can be cancelled: aborts the call if its caller asks for it. Calls the progress
// callback if the last time was long enough ago. Costs next to nothing.
void ffp_cancel_point(void);

// True if the caller has cancelled the call, without aborting it. For work that then finishes early with the
// results so far: it calls ffp_cancel_hold_off before it begins, which returns the previous setting.
bool ffp_cancelled(void);
bool ffp_cancel_hold_off(bool on);

// --- What must be given back besides memory. ---

// `thing`, which must not be on a stack, is released when the call is aborted, the youngest first, before any
// memory. If that cannot be guaranteed, it is released now and the call aborted.
void ffp_own(void *thing, void (*release)(void *thing));
bool ffp_try_own(void *thing, void (*release)(void *thing)); // false instead, and nothing is released
void ffp_disown(void *thing); // its holder gives it back; what is not owned, and NULL, are allowed

// --- Whose memory it is. ---

// Blocks and things of one owner. A handle that grows from call to call has its own: if a call that works on
// them is aborted, all of them are released and `lost` is called, after which the owner has none.
typedef struct FfpBlocks {
    pthread_mutex_t lock;
    struct FfpBlock *first;
    struct FfpOwned *owned; // youngest
    void *owner;
    void (*lost)(void *owner);
} FfpBlocks;
void ffp_blocks_init(FfpBlocks *blocks, void *owner, void (*lost)(void *owner));
void ffp_blocks_close(FfpBlocks *blocks); // releases what is left
// From here on this thread's call allocates memory for them (NULL: for itself).
void ffp_blocks_use(FfpBlocks *blocks);

// For tests: the n-th (from 1) allocation from now of the context's calls fails; 0: none.
void ffp_context_fail_at(FfpContext *context, long long n);

#endif
