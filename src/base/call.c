#include "base/call.h"

#include <locale.h>
#include <omp.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/log.h"

#define ALIGNMENT ((size_t)64)
#define EXTRA_MAX 128
#define MAGIC UINT64_C(0x66667063616d7301) // an ffp_free of what is none, or twice, is seen

// What stands before every block.
typedef struct FfpBlock {
    FfpBlocks *owner; // NULL: nobody's but its holder's
    struct FfpBlock *before, *after;
    size_t bytes;
    uint64_t unused[3], magic;
} FfpBlock;
_Static_assert(sizeof(FfpBlock) == 64, "blocks stay aligned");

typedef struct FfpOwned {
    struct FfpOwned *older;
    void *thing;
    void (*release)(void *thing);
} FfpOwned;

typedef struct Call {
    FfpContext *context;
    FfpBlocks blocks;
    pthread_mutex_t lock;    // of the log callback
    atomic_int failed;       // an FfpErrorCode
    atomic_size_t wanted;    // bytes that were not there
    atomic_bool cancelled;   // the caller said so
    bool ending;             // what is left is given back
    bool held_off;           // and the work will end by itself
    FfpProgress progress;    // of the innermost task, but for:
    atomic_llong done;       // of it
    char extra[EXTRA_MAX];   // what was said with its last step
    double began, asked;     // ffp_seconds(): that task; the progress callback, last
    const FfpDevice *device; // that the thread worked on before
    int threads;             // of OpenMP, before
    locale_t locale;         // of the thread, before: the callbacks' own
} Call;

// Where a jump leads: the call's own frame, or that of a body of ffp_parallel_for.
typedef struct FfpFrame {
    jmp_buf jump;
    Call *call;        // NULL: in a region of a thread that is in no call
    FfpBlocks *blocks; // whose memory is taken
    struct FfpFrame *outer;
    int level;   // of OpenMP's regions
    bool caller; // in the thread that made the call
} FfpFrame;

static _Thread_local FfpFrame *current;
static pthread_mutex_t device_lock = PTHREAD_MUTEX_INITIALIZER; // calls on a device take turns

static pthread_once_t locale_once = PTHREAD_ONCE_INIT;
static locale_t plain_locale; // kept to the end of the process; 0: there is none to be had

// What only the library itself can get wrong: seen where it is built for tests.
static void check(bool right, const char *what) {
#if !defined(NDEBUG) || defined(FFP_SANITIZED)
    if (right) return;
    fprintf(stderr, "ffprocams: %s\n", what);
    abort();
#else
    (void)right, (void)what;
#endif
}

// --- Blocks. ---

void ffp_blocks_init(FfpBlocks *blocks, void *owner, void (*lost)(void *owner)) {
    *blocks = (FfpBlocks){.owner = owner, .lost = lost};
    pthread_mutex_init(&blocks->lock, NULL);
}

static void add_block(FfpBlocks *blocks, FfpBlock *block) {
    block->owner = blocks;
    if (!blocks) return;
    pthread_mutex_lock(&blocks->lock);
    block->after = blocks->first;
    if (block->after) block->after->before = block;
    blocks->first = block;
    pthread_mutex_unlock(&blocks->lock);
}

static void remove_block(FfpBlock *block) {
    FfpBlocks *blocks = block->owner;
    if (!blocks) return;
    pthread_mutex_lock(&blocks->lock);
    if (block->after) block->after->before = block->before;
    *(block->before ? &block->before->after : &blocks->first) = block->after;
    pthread_mutex_unlock(&blocks->lock);
    block->owner = NULL, block->before = block->after = NULL;
}

// All of them are their holders' from here on.
static void set_free(FfpBlocks *blocks) {
    for (FfpBlock *block = blocks->first, *next; block; block = next) {
        next = block->after;
        block->owner = NULL, block->before = block->after = NULL;
    }
    blocks->first = NULL;
    for (FfpOwned *owned = blocks->owned, *older; owned; owned = older) {
        older = owned->older;
        free(owned);
    }
    blocks->owned = NULL;
}

static void release_blocks(FfpBlocks *blocks) {
    while (blocks->owned) { // its release may take others out
        FfpOwned *owned = blocks->owned;
        blocks->owned = owned->older;
        owned->release(owned->thing);
        free(owned);
    }
    for (FfpBlock *block = blocks->first, *next; block; block = next) {
        next = block->after;
        block->magic = 0;
        free(block);
    }
    blocks->first = NULL;
}

void ffp_blocks_close(FfpBlocks *blocks) {
    release_blocks(blocks);
    pthread_mutex_destroy(&blocks->lock);
}

void ffp_blocks_use(FfpBlocks *blocks) {
    if (current && current->call) current->blocks = blocks ? blocks : &current->call->blocks;
}

// --- The locale. ---

static void make_plain_locale(void) {
    plain_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
}

// From here on this thread reads and writes numbers with a point, whatever the host has set. Returns what it
// had before, to be set again.
static locale_t use_plain_locale(void) {
    pthread_once(&locale_once, make_plain_locale);
    return uselocale(plain_locale);
}

// --- Frames. ---

FfpContext *ffp_call_context(void) {
    return current && current->call ? current->call->context : NULL;
}

void ffp_context_fail_at(FfpContext *context, long long n) {
    context->fail = n > 0 ? context->allocations + n : 0;
}

// Leaves for the frame's setjmp.
static _Noreturn void leave(FfpErrorCode code, size_t bytes) {
    if (!current || !current->call || current->call->ending || omp_get_level() != current->level) {
        // Only inside the library: a function that is no public one was called by a test or a bench.
        fprintf(stderr, "ffprocams: error: out of memory outside of any call (%zu bytes)\n", bytes);
        abort();
    }
    Call *call = current->call;
    int none = FFP_OK;
    if (atomic_compare_exchange_strong(&call->failed, &none, (int)code)) call->wanted = bytes;
    longjmp(current->jump, 1);
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

// False when the work was left. This frame has nothing that changes between setjmp and a jump.
static bool enter(FfpFrame *frame, bool (*work)(void *argument, FfpError *err), void *argument, FfpError *err,
                  bool *ok) {
    if (setjmp(frame->jump)) return false;
    *ok = work(argument, err);
    return true;
}

static void run_guarded(FfpFrame *outer, Body *body) {
    FfpFrame frame = {.outer = current, .level = omp_get_level()};
    bool ok;
    if (outer) {
        if (outer->call && outer->call->failed) return;
        frame.call = outer->call, frame.blocks = outer->blocks;
        frame.caller = outer->caller && current == outer;
    }
    current = &frame;
    const locale_t before = use_plain_locale();
    enter(&frame, run_body, body, NULL, &ok);
    uselocale(before);
    current = frame.outer;
}

void ffp_parallel_for(int64_t count, int threads, void (*body)(void *argument, int64_t index),
                      void *argument) {
    FfpFrame *outer = current;
#pragma omp parallel for schedule(dynamic) num_threads(threads > 0 ? threads : omp_get_max_threads())
    for (int64_t i = 0; i < count; i++) run_guarded(outer, &(Body){body, argument, i});
    if (outer && outer->call && outer->call->failed) leave((FfpErrorCode)outer->call->failed, 0);
    ffp_cancel_point(); // this thread may have had none of them
}

// --- Calls. ---

// Whether the call takes the device's turn. What works beside such a call only makes things ready for the
// device, and would wait for the turn as long as the call waits for it.
static bool takes_turn(const FfpContext *context) {
    return context && context->device && !context->beside;
}

static void begin(Call *call, FfpFrame *frame) {
    const FfpContext *context = call->context;
    ffp_blocks_init(&call->blocks, NULL, NULL);
    pthread_mutex_init(&call->lock, NULL);
    if (takes_turn(context)) pthread_mutex_lock(&device_lock);
    call->device = ffp_device();
    call->locale = use_plain_locale();
    call->threads = omp_get_max_threads();
    if (context && context->settings.threads > 0) omp_set_num_threads(context->settings.threads);
    *frame = (FfpFrame){
        .call = call, .blocks = &call->blocks, .outer = current, .level = omp_get_level(), .caller = true};
    current = frame;
}

static void end(Call *call, FfpFrame *frame, bool ok) {
    call->ending = true;
    if (ok)
        set_free(&call->blocks);
    else
        release_blocks(&call->blocks);
    if (call->failed && frame->blocks != &call->blocks) {
        release_blocks(frame->blocks);
        frame->blocks->lost(frame->blocks->owner);
    }
    current = frame->outer;
    ffp_device_use(call->device);
    uselocale(call->locale);
    omp_set_num_threads(call->threads);
    if (takes_turn(call->context)) pthread_mutex_unlock(&device_lock);
    pthread_mutex_destroy(&call->lock);
    pthread_mutex_destroy(&call->blocks.lock);
}

static bool tell(const Call *call, FfpError *err) {
    if (call->failed == FFP_ERROR_CANCELLED) return ffp_fail(err, FFP_ERROR_CANCELLED, NULL, "cancelled");
    return ffp_fail(err, FFP_ERROR_MEMORY, NULL, "out of memory: %zu bytes more were needed", call->wanted);
}

bool ffp_call_run(FfpContext *context, bool (*work)(void *argument, FfpError *err), void *argument,
                  FfpError *err) {
    if (current && current->call) return work(argument, err);
    Call call = {.context = context};
    FfpFrame frame;
    bool ok = false;
    begin(&call, &frame);
    if (!enter(&frame, work, argument, err, &ok)) ok = tell(&call, err);
    end(&call, &frame, ok);
    return ok;
}

void ffp_call_forget(void) {
    current = NULL;
}

// --- Memory. ---

size_t ffp_checked_bytes(size_t count, size_t size) {
    size_t bytes = 0;
    if (__builtin_mul_overflow(count, size, &bytes) || bytes > SIZE_MAX / 2)
        leave(FFP_ERROR_MEMORY, SIZE_MAX);
    return bytes == 0 ? ALIGNMENT : (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

// In a region only a body of ffp_parallel_for can be left.
static void check_place(void) {
    check(omp_get_level() == (current ? current->level : 0), "memory is taken in a plain parallel region");
}

static bool is_to_fail(void) {
    FfpContext *context = ffp_call_context();
    return context && context->fail && ++context->allocations == context->fail;
}

static FfpBlock *new_block(FfpBlocks *owner, size_t bytes) {
    check_place();
    FfpBlock *block = is_to_fail() ? NULL : aligned_alloc(ALIGNMENT, sizeof *block + bytes);
    if (!block) return NULL;
    *block = (FfpBlock){.bytes = bytes, .magic = MAGIC};
    add_block(owner, block);
    return block;
}

void ffp_no_memory(size_t bytes) {
    leave(FFP_ERROR_MEMORY, bytes);
}

static FfpBlocks *owner_of_new(void) {
    return current ? current->blocks : NULL;
}

void *ffp_alloc_undefined(size_t bytes) {
    FfpBlock *block = new_block(owner_of_new(), bytes);
    if (!block) leave(FFP_ERROR_MEMORY, bytes);
    return block + 1;
}

void *ffp_alloc(size_t count, size_t size) {
    const size_t bytes = ffp_checked_bytes(count, size);
    return memset(ffp_alloc_undefined(bytes), 0, bytes);
}

void *ffp_try_alloc(size_t count, size_t size) {
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) || bytes > SIZE_MAX / 2) return NULL;
    bytes = ffp_checked_bytes(count, size);
    FfpBlock *block = new_block(owner_of_new(), bytes);
    return block ? memset(block + 1, 0, bytes) : NULL;
}

void *ffp_alloc_kept(size_t count, size_t size) {
    const size_t bytes = ffp_checked_bytes(count, size);
    FfpBlock *block = new_block(NULL, bytes);
    if (!block) leave(FFP_ERROR_MEMORY, bytes);
    return memset(block + 1, 0, bytes);
}

static FfpBlock *block_of(void *memory) {
    FfpBlock *block = (FfpBlock *)memory - 1;
    if (block->magic == MAGIC) return block;
    fprintf(stderr, "ffprocams: %p is given back, but was not taken\n", memory);
    abort();
}

void *ffp_try_grow(void *memory, size_t count, size_t size) {
    void *larger = ffp_try_alloc(count, size);
    if (!larger || !memory) return larger;
    const size_t before = block_of(memory)->bytes, after = block_of(larger)->bytes;
    memcpy(larger, memory, before < after ? before : after);
    ffp_free(memory);
    return larger;
}

void *ffp_grow(void *memory, size_t count, size_t size) {
    void *larger = ffp_try_grow(memory, count, size);
    if (!larger) leave(FFP_ERROR_MEMORY, ffp_checked_bytes(count, size));
    return larger;
}

char *ffp_copy_text(const char *text) {
    const size_t size = strlen(text) + 1;
    return memcpy(ffp_alloc(size, 1), text, size);
}

void ffp_free(void *memory) {
    if (!memory) return;
    FfpBlock *block = block_of(memory);
    remove_block(block);
    block->magic = 0;
    free(block);
}

// --- Other things. ---

// False when there is no memory for it.
static bool own(FfpBlocks *owner, void *thing, void (*release)(void *thing)) {
    FfpOwned *owned = is_to_fail() ? NULL : malloc(sizeof *owned);
    if (!owned) return false;
    pthread_mutex_lock(&owner->lock);
    *owned = (FfpOwned){owner->owned, thing, release};
    owner->owned = owned;
    pthread_mutex_unlock(&owner->lock);
    return true;
}

bool ffp_try_own(void *thing, void (*release)(void *thing)) {
    FfpBlocks *owner = owner_of_new();
    check_place();
    return !owner || own(owner, thing, release);
}

void ffp_own(void *thing, void (*release)(void *thing)) {
    if (ffp_try_own(thing, release)) return;
    release(thing);
    leave(FFP_ERROR_MEMORY, sizeof(FfpOwned));
}

void ffp_disown(void *thing) {
    FfpBlocks *owner = owner_of_new();
    if (!owner || !thing) return;
    pthread_mutex_lock(&owner->lock);
    FfpOwned **at = &owner->owned;
    while (*at && (*at)->thing != thing) at = &(*at)->older;
    FfpOwned *owned = *at;
    if (owned) *at = owned->older;
    pthread_mutex_unlock(&owner->lock);
    free(owned);
}

void *ffp_alloc_on_device(const FfpDevice *device, size_t bytes) {
    void *memory = is_to_fail() ? NULL : device->alloc(bytes);
    if (!memory) leave(FFP_ERROR_MEMORY, bytes);
    ffp_own(memory, device->release);
    return memory;
}

void ffp_free_on_device(const FfpDevice *device, void *memory) {
    ffp_disown(memory);
    device->release(memory);
}

// --- Words. ---

static void say(FfpLogLevel level, const char *format, va_list arguments) {
    const FfpContext *context = ffp_call_context();
    if (!context || !context->settings.log) return;
    char text[2048];
    vsnprintf(text, sizeof text, format, arguments);
    const locale_t ours = uselocale(current->call->locale);
    pthread_mutex_lock(&current->call->lock);
    context->settings.log(context->settings.user, level, text);
    pthread_mutex_unlock(&current->call->lock);
    uselocale(ours);
}

void ffp_note(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say(FFP_LOG_NOTE, format, arguments);
    va_end(arguments);
}

void ffp_warning(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say(FFP_LOG_WARNING, format, arguments);
    va_end(arguments);
}

// --- Progress. ---

static bool is_asked(void) {
    const FfpContext *context = ffp_call_context();
    return context && context->settings.progress && current->caller && !current->call->cancelled;
}

// Tells the caller where the call is, and hears whether it is to go on.
static void ask(double now) {
    Call *call = current->call;
    const FfpContextSettings *settings = &call->context->settings;
    FfpProgress p = call->progress;
    p.extra = call->extra[0] ? call->extra : NULL;
    p.done = call->done;
    p.seconds = p.stage ? now - call->began : 0;
    p.seconds_left = p.done > 0 ? p.seconds * (double)(p.total - p.done) / (double)p.done : -1.0;
    call->asked = now;
    const locale_t ours = uselocale(call->locale);
    if (!settings->progress(settings->user, &p)) call->cancelled = true;
    uselocale(ours);
}

static void ask_in_time(void) {
    if (!is_asked()) return;
    const double now = ffp_seconds();
    if (now - current->call->asked >= current->call->context->settings.interval) ask(now);
}

static void leave_if_cancelled(void) {
    Call *call = current ? current->call : NULL;
    if (!call || omp_get_level() != current->level) return;
    if (call->failed) leave((FfpErrorCode)call->failed, 0); // in another body of a region
    if (call->cancelled && !call->held_off) leave(FFP_ERROR_CANCELLED, 0);
}

void ffp_cancel_point(void) {
    ask_in_time();
    leave_if_cancelled();
}

bool ffp_cancelled(void) {
    ask_in_time();
    return current && current->call && current->call->cancelled;
}

bool ffp_cancel_hold_off(bool on) {
    if (!current || !current->call) return false;
    const bool before = current->call->held_off;
    current->call->held_off = on;
    return before;
}

FfpTask ffp_task(const char *what, int64_t total) {
    FfpTask task = {.what = what, .total = total, .started = ffp_seconds()};
    if (!current || !current->call || !current->caller) return task;
    Call *call = current->call;
    task.before = call->progress, task.before.done = call->done, task.before_began = call->began;
    call->progress = (FfpProgress){.stage = what, .total = total};
    call->done = 0;
    call->extra[0] = 0;
    call->began = task.started;
    return task;
}

void ffp_task_step(const FfpTask *task, int64_t done, const char *extra) {
    if (!current || !current->call) return;
    check(task->total == current->call->progress.total, "the task is not the innermost");
    current->call->done = done;
    if (current->caller) snprintf(current->call->extra, EXTRA_MAX, "%s", extra ? extra : "");
    ask_in_time();
    leave_if_cancelled();
}

void ffp_task_end(const FfpTask *task) {
    if (!current || !current->call || !current->caller) return;
    Call *call = current->call;
    call->progress = task->before;
    call->done = task->before.done;
    call->extra[0] = 0;
    call->began = task->before_began;
    // What was shown of the task is over.
    if (is_asked() && call->asked >= task->started) ask(ffp_seconds());
    leave_if_cancelled();
}
