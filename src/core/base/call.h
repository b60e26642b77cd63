// A call of the public header at work: its context, seen by everything it calls in turn; what it has taken;
// and the way out of it when memory has run out or the caller does not want it any more. Then ffp_alloc or
// ffp_cancel_point does not return: all that the call has taken is given back, and the public
// function returns with an error. PostgreSQL's memory contexts work likewise.
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

// Does a public function's work for the context (NULL: the defaults) and returns what `work` returns, or
// false when it was left. When false, memory that the work took is gone. Called while the thread is in a call
// already it only does the work: nested calls are the outer one's. Numbers are read and written as in the C
// locale meanwhile, by this thread and in bodies of ffp_parallel_for; the callbacks have the caller's locale.
bool ffp_call_run(FfpContext *context, bool (*work)(void *argument, FfpError *err), void *argument,
                  FfpError *err);

// The context of the call that this thread is in; NULL: it is in none, or has the defaults.
FfpContext *ffp_call_context(void);

// In a child process: what goes on in its parent is not its own. Memory that is out ends it.
void ffp_call_forget(void);

// Body of every index in 0..count-1, by up to `threads` threads (0: all). In a parallel region bodies alone
// may take memory and be cancelled; when one is left the others are not begun, and the call ends
// after the region. (Small loops inside of these are plain OpenMP.)
void ffp_parallel_for(int64_t count, int threads, void (*body)(void *argument, int64_t index),
                      void *argument);

// --- Being cancelled. ---

// Where work can end: leaves the call if its caller wants that. Asks the progress callback, if the last time
// is long enough ago. Costs next to nothing.
void ffp_cancel_point(void);

// Whether the caller wants the call to end, without leaving it. For work that then ends on its own, with what
// it has: that holds its cancellation off before it begins. Returns what was set before.
bool ffp_cancelled(void);
bool ffp_cancel_hold_off(bool on);

// --- What must be given back besides memory. ---

// `thing`, which lies on no stack, is released when the call is left, the youngest first, before any memory.
// When that cannot be promised it is released now, and the call left.
void ffp_own(void *thing, void (*release)(void *thing));
bool ffp_try_own(void *thing, void (*release)(void *thing)); // false instead, and nothing is released
void ffp_disown(void *thing); // its holder gives it back; what is not owned, and NULL, are allowed

// --- Whose memory it is. ---

// Blocks and things of one owner. A handle that grows from call to call has its own: when a call that works
// on them is left all of them go, and `lost` is called, after which the owner has none.
typedef struct FfpBlocks {
    pthread_mutex_t lock;
    struct FfpBlock *first;
    struct FfpOwned *owned; // youngest
    void *owner;
    void (*lost)(void *owner);
} FfpBlocks;
void ffp_blocks_init(FfpBlocks *blocks, void *owner, void (*lost)(void *owner));
void ffp_blocks_close(FfpBlocks *blocks); // releases what is left
// From here on this thread's call takes memory for them (NULL: for itself).
void ffp_blocks_use(FfpBlocks *blocks);

// For tests: the n-th (from 1) allocation from now of the context's calls fails; 0: none.
void ffp_context_fail_at(FfpContext *context, long long n);

#endif
