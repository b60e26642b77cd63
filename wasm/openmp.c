// OpenMP's runtime for a page with threads: the functions that clang's code for the pragmas calls (the
// interface of LLVM's libomp, as clang 14 uses it), as far as the engine's loops need them, and OpenMP's own.
// Functions that are missing here do not link, or stop. A region inside another has one thread; one thread of
// the page, the engine's, begins the outer ones. Static loops are cut as libgomp cuts them.
#include <emscripten/threading.h>
#include <math.h>
#include <omp.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>

enum {
    THREADS_MAX = 16,
    DEPTH_MAX = 8,      // regions inside each other
    ARGUMENTS_MAX = 18, // of a region: what it shares with its surroundings
    SPINS = 4000,       // looks at a word before its thread goes to sleep
    STATIC = 34,        // clang's numbers of schedules
    DYNAMIC = 35,
    MODIFIERS = 3 << 29
};

typedef struct Place Place; // in the source, for error messages
typedef int32_t Numbers[8]; // a lock of clang's
typedef void Work(int32_t *thread, int32_t *bound, ...);

// A region of the source at work.
typedef struct Region {
    int threads;
    Work *work;
    int count;
    void *arguments[ARGUMENTS_MAX];
    atomic_uint arrived, barriers; // at the barrier; barriers passed
    atomic_llong next;             // chunk of its dynamic loop
} Region;

// A thread's part in a region: the innermost one's is on top.
typedef struct Part {
    Region *region;
    int number;
    int64_t lower, upper, step, chunk; // its dynamic loop
} Part;

static Region outer, alone[THREADS_MAX][DEPTH_MAX + 1]; // what several threads do; regions of one thread
static _Thread_local Part parts[DEPTH_MAX + 1];
static _Thread_local int depth, me, pushed;
static int available, asked; // threads of the pool, with the engine's; for the next regions, 0: all
static atomic_uint begun[THREADS_MAX], ended;
static pthread_mutex_t critical = PTHREAD_MUTEX_INITIALIZER;

// Waits until the word is another one. Where the engine's thread waits it wakes every millisecond for what
// others ask of it: files and messages are its own.
static void wait_for_change(atomic_uint *word, unsigned from) {
    for (int i = 0; i < SPINS; i++)
        if (atomic_load(word) != from) return;
    while (atomic_load(word) == from)
        emscripten_futex_wait(word, from, emscripten_is_main_runtime_thread() ? 1 : INFINITY);
}

static void change(atomic_uint *word) {
    atomic_fetch_add(word, 1);
    emscripten_futex_wake(word, THREADS_MAX);
}

static Part *part(void) {
    return &parts[depth];
}

static int threads_here(void) {
    return depth ? part()->region->threads : 1;
}

static void enter(Region *region, int number) {
    if (depth == DEPTH_MAX) abort();
    parts[++depth] = (Part){.region = region, .number = number};
}

// Calls the outlined function of a region. A call through a pointer has to have the function's own number of
// arguments.
static void work_on(const Region *r, int number) {
    int32_t thread = number, bound = 0;
    void *const *a = r->arguments;
#define A4(i) a[i], a[i + 1], a[i + 2], a[i + 3]
#define P1 void *
#define P2 P1, P1
#define P3 P2, P1
#define P4 P2, P2
#define TAKES(n, types, values)                                                                              \
    case n:                                                                                                  \
        ((void (*)(int32_t *, int32_t *, types))r->work)(&thread, &bound, values);                           \
        return;
#define LIST(...) __VA_ARGS__
    switch (r->count) {
    case 0:
        ((void (*)(int32_t *, int32_t *))r->work)(&thread, &bound);
        return;
        TAKES(1, LIST(P1), LIST(a[0]))
        TAKES(2, LIST(P2), LIST(a[0], a[1]))
        TAKES(3, LIST(P3), LIST(a[0], a[1], a[2]))
        TAKES(4, LIST(P4), LIST(A4(0)))
        TAKES(5, LIST(P4, P1), LIST(A4(0), a[4]))
        TAKES(6, LIST(P4, P2), LIST(A4(0), a[4], a[5]))
        TAKES(7, LIST(P4, P3), LIST(A4(0), a[4], a[5], a[6]))
        TAKES(8, LIST(P4, P4), LIST(A4(0), A4(4)))
        TAKES(9, LIST(P4, P4, P1), LIST(A4(0), A4(4), a[8]))
        TAKES(10, LIST(P4, P4, P2), LIST(A4(0), A4(4), a[8], a[9]))
        TAKES(11, LIST(P4, P4, P3), LIST(A4(0), A4(4), a[8], a[9], a[10]))
        TAKES(12, LIST(P4, P4, P4), LIST(A4(0), A4(4), A4(8)))
        TAKES(13, LIST(P4, P4, P4, P1), LIST(A4(0), A4(4), A4(8), a[12]))
        TAKES(14, LIST(P4, P4, P4, P2), LIST(A4(0), A4(4), A4(8), a[12], a[13]))
        TAKES(15, LIST(P4, P4, P4, P3), LIST(A4(0), A4(4), A4(8), a[12], a[13], a[14]))
        TAKES(16, LIST(P4, P4, P4, P4), LIST(A4(0), A4(4), A4(8), A4(12)))
        TAKES(17, LIST(P4, P4, P4, P4, P1), LIST(A4(0), A4(4), A4(8), A4(12), a[16]))
        TAKES(18, LIST(P4, P4, P4, P4, P2), LIST(A4(0), A4(4), A4(8), A4(12), a[16], a[17]))
    default:
        abort();
    }
}

// --- The pool. ---

static void take_part(int number) {
    enter(&outer, number);
    work_on(&outer, number);
    depth--;
}

static void *serve(void *number) {
    me = (int)(intptr_t)number;
    for (unsigned seen = 0;; seen++) {
        wait_for_change(&begun[me], seen);
        take_part(me);
        change(&ended);
    }
    return NULL;
}

// As many threads as there are processors and the page has workers for (-sPTHREAD_POOL_SIZE).
static int pool(void) {
    const int cores = emscripten_num_logical_cores(), most = cores < THREADS_MAX ? cores : THREADS_MAX;
    if (available || depth) return available ? available : 1;
    for (available = 1; available < most; available++) {
        pthread_t thread;
        if (pthread_create(&thread, NULL, serve, (void *)(intptr_t)available) != 0) break;
    }
    return available;
}

static void run_together(void) {
    const int others = outer.threads - 1;
    atomic_store(&ended, 0);
    for (int i = 1; i <= others; i++) change(&begun[i]);
    take_part(0);
    for (unsigned so_far; (so_far = atomic_load(&ended)) != (unsigned)others;)
        wait_for_change(&ended, so_far);
}

static void run_alone(Region *r) {
    enter(r, 0);
    work_on(r, 0);
    depth--;
}

// --- What clang's code calls. ---

int32_t __kmpc_global_thread_num(Place *place);
void __kmpc_push_num_threads(Place *place, int32_t thread, int32_t threads);
void __kmpc_fork_call(Place *place, int32_t count, Work *work, ...);
void __kmpc_serialized_parallel(Place *place, int32_t thread);
void __kmpc_end_serialized_parallel(Place *place, int32_t thread);
void __kmpc_barrier(Place *place, int32_t thread);
void __kmpc_for_static_fini(Place *place, int32_t thread);
int32_t __kmpc_reduce_nowait(Place *place, int32_t thread, int32_t count, size_t size, void *data,
                             void (*add)(void *, void *), Numbers *lock);
void __kmpc_end_reduce_nowait(Place *place, int32_t thread, Numbers *lock);

int32_t __kmpc_global_thread_num(Place *place) {
    (void)place;
    return part()->number;
}

void __kmpc_push_num_threads(Place *place, int32_t thread, int32_t threads) {
    (void)place, (void)thread;
    pushed = threads;
}

void __kmpc_fork_call(Place *place, int32_t count, Work *work, ...) {
    (void)place;
    const int wanted = pushed > 0 ? pushed : omp_get_max_threads(), most = pool();
    const int threads = depth ? 1 : wanted < most ? wanted : most;
    Region *r = threads > 1 ? &outer : &alone[me][depth];
    if (count > ARGUMENTS_MAX) abort();
    pushed = 0;
    *r = (Region){.threads = threads, .work = work, .count = count};
    va_list list;
    va_start(list, work);
    for (int i = 0; i < count; i++) r->arguments[i] = va_arg(list, void *);
    va_end(list);
    if (threads > 1)
        run_together();
    else
        run_alone(r);
}

void __kmpc_serialized_parallel(Place *place, int32_t thread) {
    (void)place, (void)thread;
    Region *r = &alone[me][depth];
    *r = (Region){.threads = 1};
    pushed = 0;
    enter(r, 0);
}

void __kmpc_end_serialized_parallel(Place *place, int32_t thread) {
    (void)place, (void)thread;
    depth--;
}

void __kmpc_barrier(Place *place, int32_t thread) {
    (void)place, (void)thread;
    Region *r = depth ? part()->region : NULL;
    if (!r || r->threads == 1) return;
    const unsigned before = atomic_load(&r->barriers);
    if (atomic_fetch_add(&r->arrived, 1) + 1 == (unsigned)r->threads) {
        atomic_store(&r->arrived, 0);
        change(&r->barriers);
    } else {
        wait_for_change(&r->barriers, before);
    }
}

// Iterations first..last in steps: this thread's share of them, of which the first threads have one more
// where they do not come out even.
static void share(int64_t *first, int64_t *last, int64_t step, int32_t *is_last) {
    const int64_t all = step > 0 ? (*last - *first) / step + 1 : (*first - *last) / -step + 1;
    const int64_t threads = threads_here(), number = part()->number, each = all / threads,
                  more = all % threads;
    const int64_t from = number * each + (number < more ? number : more), n = each + (number < more);
    *is_last = n > 0 && from + n == all;
    *first += from * step;
    *last = *first + (n - 1) * step;
}

#define STATIC_LOOP(suffix, T, S)                                                                            \
    void __kmpc_for_static_init_##suffix(Place *place, int32_t thread, int32_t schedule, int32_t *last,      \
                                         T *lower, T *upper, S *stride, S step, S chunk);                    \
    void __kmpc_for_static_init_##suffix(Place *place, int32_t thread, int32_t schedule, int32_t *last,      \
                                         T *lower, T *upper, S *stride, S step, S chunk) {                   \
        int64_t from = (int64_t)*lower, to = (int64_t)*upper;                                                \
        (void)place, (void)thread, (void)chunk;                                                              \
        if (schedule != STATIC) abort();                                                                     \
        *stride = (S)(to - from + step);                                                                     \
        share(&from, &to, step, last);                                                                       \
        *lower = (T)from;                                                                                    \
        *upper = (T)to;                                                                                      \
    }
STATIC_LOOP(4, int32_t, int32_t)
STATIC_LOOP(4u, uint32_t, int32_t)
STATIC_LOOP(8, int64_t, int64_t)
STATIC_LOOP(8u, uint64_t, int64_t) // of sizes; no loop here has 2^63 iterations

void __kmpc_for_static_fini(Place *place, int32_t thread) {
    (void)place, (void)thread;
}

// A region has one dynamic loop at most.
#define DYNAMIC_LOOP(suffix, T, S)                                                                           \
    void __kmpc_dispatch_init_##suffix(Place *place, int32_t thread, int32_t schedule, T lower, T upper,     \
                                       S step, S chunk);                                                     \
    int32_t __kmpc_dispatch_next_##suffix(Place *place, int32_t thread, int32_t *last, T *lower, T *upper,   \
                                          S *stride);                                                        \
    void __kmpc_dispatch_init_##suffix(Place *place, int32_t thread, int32_t schedule, T lower, T upper,     \
                                       S step, S chunk) {                                                    \
        Part *p = part();                                                                                    \
        (void)place, (void)thread;                                                                           \
        if ((schedule & ~MODIFIERS) != DYNAMIC || p->step || !depth) abort();                                \
        p->lower = (int64_t)lower, p->upper = (int64_t)upper, p->step = step,                                \
        p->chunk = chunk > 0 ? chunk : 1;                                                                    \
    }                                                                                                        \
    int32_t __kmpc_dispatch_next_##suffix(Place *place, int32_t thread, int32_t *last, T *lower, T *upper,   \
                                          S *stride) {                                                       \
        int64_t from, to;                                                                                    \
        (void)place, (void)thread;                                                                           \
        if (!next_chunk(&from, &to, last)) return 0;                                                         \
        *lower = (T)from;                                                                                    \
        *upper = (T)to;                                                                                      \
        *stride = (S)part()->step;                                                                           \
        return 1;                                                                                            \
    }

static int next_chunk(int64_t *from, int64_t *to, int32_t *last) {
    const Part *p = part();
    const int64_t all = (p->upper - p->lower) / p->step + 1,
                  begin = p->chunk * atomic_fetch_add(&p->region->next, 1);
    if (begin >= all) return 0;
    const int64_t end = begin + p->chunk < all ? begin + p->chunk : all;
    *from = p->lower + begin * p->step;
    *to = p->lower + (end - 1) * p->step;
    *last = end == all;
    return 1;
}
DYNAMIC_LOOP(4, int32_t, int32_t)
DYNAMIC_LOOP(4u, uint32_t, int32_t)
DYNAMIC_LOOP(8, int64_t, int64_t)

// Threads add their sums one after another: of whole numbers and truths alone, whose order does not matter.
// clang leaves the lock for it undefined.
extern Numbers reduction_lock __asm__(".gomp_critical_user_.reduction.var");
Numbers reduction_lock;

int32_t __kmpc_reduce_nowait(Place *place, int32_t thread, int32_t count, size_t size, void *data,
                             void (*add)(void *, void *), Numbers *lock) {
    (void)place, (void)thread, (void)count, (void)size, (void)data, (void)add, (void)lock;
    pthread_mutex_lock(&critical);
    return 1;
}

void __kmpc_end_reduce_nowait(Place *place, int32_t thread, Numbers *lock) {
    (void)place, (void)thread, (void)lock;
    pthread_mutex_unlock(&critical);
}

// --- OpenMP's own functions. ---

int omp_get_max_threads(void) {
    return asked > 0 ? asked : pool();
}

void omp_set_num_threads(int threads) {
    asked = threads;
}

int omp_get_num_threads(void) {
    return threads_here();
}

int omp_get_thread_num(void) {
    return part()->number;
}

int omp_get_num_procs(void) {
    return emscripten_num_logical_cores();
}

int omp_get_level(void) {
    return depth;
}

int omp_in_parallel(void) {
    for (int i = 1; i <= depth; i++)
        if (parts[i].region->threads > 1) return 1;
    return 0;
}
