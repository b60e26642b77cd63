// A call from its beginning to its end, and its bodies of parallel regions.
#include "core/base/call.h"
#include <omp.h>
#include <string.h>
#include "core/base/blocks.h"
#include "core/base/frame.h"
#include "core/base/memory_file.h"

static pthread_mutex_t device_lock = PTHREAD_MUTEX_INITIALIZER; // calls on a device take turns

// --- The locale. ---

static pthread_once_t locale_once = PTHREAD_ONCE_INIT;
static locale_t plain_locale; // kept to the end of the process; 0: there is none available

static void make_plain_locale(void) {
    plain_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
}

// From here on this thread reads and writes numbers with a point, whatever the host has set. Returns what it
// had before, to be set again.
static locale_t use_plain_locale(void) {
    pthread_once(&locale_once, make_plain_locale);
    return uselocale(plain_locale);
}

// --- Processes that are forked. ---

static pthread_once_t fork_once = PTHREAD_ONCE_INIT;
static bool forked; // OpenMP's workers stayed in the parent, and a region of two threads would wait for them

static void enter_child(void) {
    forked = true;
    pthread_mutex_init(&device_lock, NULL); // whoever had it is in the parent
}

static void watch_forks(void) {
    pthread_atfork(NULL, NULL, enter_child);
}

// --- Work that may be left. ---

// False when the work was left. This frame has nothing that changes between setjmp and a jump.
static bool enter(FfpFrame *frame, bool (*work)(void *argument, FfpError *err), void *argument, FfpError *err,
                  bool *ok) {
    if (setjmp(frame->jump)) return false;
    *ok = work(argument, err);
    return true;
}

typedef struct Body {
    void (*body)(void *argument, int64_t index);
    void *argument;
    int64_t index;
} Body;

static bool run_body(void *argument, FfpError *err) {
    (void)err;
    const Body *b = argument;
    b->body(b->argument, b->index);
    return true;
}

static void run_guarded(FfpFrame *outer, Body *body) {
    FfpFrame frame = {.outer = ffp_frame, .level = omp_get_level()};
    bool ok;
    if (outer) {
        if (outer->call && outer->call->failed) return;
        frame.call = outer->call;
        frame.blocks = outer->blocks;
        frame.caller = outer->caller && ffp_frame == outer;
    }
    ffp_frame = &frame;
    const locale_t before = use_plain_locale();
    enter(&frame, run_body, body, NULL, &ok);
    uselocale(before);
    ffp_frame = frame.outer;
}

static int threads_for(int wanted) {
    if (forked) return 1;
    return wanted > 0 ? wanted : omp_get_max_threads();
}

void ffp_parallel_for(int64_t count, int threads, void (*body)(void *argument, int64_t index),
                      void *argument) {
    FfpFrame *outer = ffp_frame;
#pragma omp parallel for schedule(dynamic) num_threads(threads_for(threads))
    for (int64_t i = 0; i < count; i++) run_guarded(outer, &(Body){body, argument, i});
    if (outer && outer->call && outer->call->failed) ffp_leave((FfpErrorCode)outer->call->failed, 0);
    ffp_cancel_point(); // this thread may have had none of them
}

// --- Calls. ---

// True if the call takes the device's turn. Work beside such a call only makes things ready for the device,
// and would wait for the turn as long as the call waits for it.
static bool takes_turn(const FfpContext *context) {
    return context && context->device && !context->beside;
}

static void begin(FfpCall *call, FfpFrame *frame) {
    const FfpContext *context = call->context;
    ffp_blocks_init(&call->blocks, NULL, NULL);
    pthread_mutex_init(&call->lock, NULL);
    if (takes_turn(context)) pthread_mutex_lock(&device_lock);
    call->device = ffp_device();
    call->locale = use_plain_locale();
    pthread_once(&fork_once, watch_forks);
    call->threads = omp_get_max_threads();
    int wanted = context ? context->settings.threads : 0;
    if (forked) wanted = 1;
    if (wanted > 0) omp_set_num_threads(wanted);
    *frame = (FfpFrame){
        .call = call, .blocks = &call->blocks, .outer = ffp_frame, .level = omp_get_level(), .caller = true};
    ffp_frame = frame;
}

static void end(FfpCall *call, FfpFrame *frame, bool ok) {
    call->ending = true;
    if (ok)
        ffp_blocks_set_free(&call->blocks);
    else
        ffp_blocks_release(&call->blocks);
    if (call->failed && frame->blocks != &call->blocks) {
        ffp_blocks_release(frame->blocks);
        frame->blocks->lost(frame->blocks->owner);
    }
    ffp_frame = frame->outer;
    ffp_device_use(call->device);
    uselocale(call->locale);
    omp_set_num_threads(call->threads);
    if (takes_turn(call->context)) pthread_mutex_unlock(&device_lock);
    pthread_mutex_destroy(&call->lock);
    pthread_mutex_destroy(&call->blocks.lock);
}

static bool tell(const FfpCall *call, FfpError *err) {
    if (call->failed == FFP_ERROR_CANCELLED) return ffp_fail(err, FFP_ERROR_CANCELLED, NULL, "cancelled");
    return ffp_fail(err, FFP_ERROR_MEMORY, NULL, "out of memory: %zu more bytes were needed", call->wanted);
}

bool ffp_call_run(FfpContext *context, bool (*work)(void *argument, FfpError *err), void *argument,
                  FfpError *err) {
    if (ffp_call()) return work(argument, err);
    if (err) *err = (FfpError){.code = FFP_OK}; // of an earlier call
    FfpCall call = {.context = context};
    FfpFrame frame;
    bool ok = false;
    begin(&call, &frame);
    if (!enter(&frame, work, argument, err, &ok)) ok = tell(&call, err);
    end(&call, &frame, ok);
    return ok;
}

void ffp_memory_file_use(FfpMemoryFile *file) {
    if (ffp_call()) ffp_call()->file = file;
}

FfpMemoryFile *ffp_memory_file(const char *path) {
    FfpMemoryFile *file = ffp_call() ? ffp_call()->file : NULL;
    return file && strcmp(file->path, path) == 0 ? file : NULL;
}

void ffp_call_forget(void) {
    ffp_frame = NULL;
}

void ffp_blocks_use(FfpBlocks *blocks) {
    FfpCall *call = ffp_call();
    if (call) ffp_frame->blocks = blocks ? blocks : &call->blocks;
}

const FfpDevice *ffp_device_offered(void) {
    const FfpContext *context = ffp_call_context();
    return context ? context->device : NULL;
}
