// Ranks by MPI-3. Sums of gradients are collective operations that do not block, begun and watched by a
// thread of their own, because MPI libraries get on with their work only while somebody is in a call of
// theirs, and the other threads are busy. MPI is entered by one thread at a time (MPI_THREAD_SERIALIZED): the
// watcher while sums are under way, otherwise the caller. Nobody spins for long: a rank that waits for
// another, which may be writing a checkpoint, leaves its processor to others.
#include <limits.h>
#include <mpi.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "product/cluster/cluster.h"

enum { SUMS = 4096 };                                            // under way at a time
enum { QUICK_LOOKS = 2000, WATCH_NS = 50000, REST_NS = 200000 }; // looks without a rest; rests between looks

typedef struct Sum {
    float *values;
    int64_t count;
} Sum;

static struct Job {
    FfpRanks ranks;
    pthread_t watcher;
    pthread_mutex_t lock; // of what follows
    pthread_cond_t changed;
    Sum sums[SUMS];      // the i-th asked for, from 0, at i % SUMS
    int64_t asked, done; // so far, in turn
    bool waiting;        // the caller is in sum_finish
    bool closing;
    int problem; // MPI's code of the first that failed; MPI_SUCCESS: none
} job;

static void rest(long ns) {
    nanosleep(&(struct timespec){.tv_nsec = ns}, NULL);
}

// "MPI_Iallreduce: WHAT (rank R of N)"
static bool fail(FfpError *err, const char *call, int problem) {
    char text[MPI_MAX_ERROR_STRING] = "";
    int length = 0;
    MPI_Error_string(problem, text, &length);
    if (!err) return false;
    err->code = FFP_ERROR_IO;
    snprintf(err->text, sizeof err->text, "%s: %.400s (rank %d of %d)", call, text, job.ranks.rank,
             job.ranks.count);
    return false;
}

// Waits for one operation. (clang-tidy does not take MPI_Test for waiting.)
static bool await(MPI_Request *request, const char *call, int problem, FfpError *err) {
    int done = 0;
    for (long looks = 0; problem == MPI_SUCCESS && !done; looks++) {
        problem = MPI_Test(request, &done, MPI_STATUS_IGNORE);
        if (!done && looks > QUICK_LOOKS) rest(REST_NS);
    }
    return problem == MPI_SUCCESS || fail(err, call, problem);
}

// --- Sums while others work. ---

static int begin(const Sum *sum, MPI_Request *request) {
    return MPI_Iallreduce(MPI_IN_PLACE, sum->values, (int)sum->count, MPI_FLOAT, MPI_SUM, MPI_COMM_WORLD,
                          request);
}

typedef struct Watch { // the watcher's own counts of sums
    int64_t begun, done;
    int problem;
    MPI_Request requests[SUMS];
} Watch;

// Tells what is done, and waits until there is something to do. False: there never will be.
static bool is_more(const Watch *watch, int64_t *asked, bool *waiting) {
    pthread_mutex_lock(&job.lock);
    if (job.done != watch->done || job.problem != watch->problem) {
        job.done = watch->done;
        job.problem = watch->problem;
        pthread_cond_broadcast(&job.changed);
    }
    while (job.asked == watch->done && !job.closing) pthread_cond_wait(&job.changed, &job.lock);
    *asked = job.asked;
    *waiting = job.waiting;
    const bool more = !job.closing;
    pthread_mutex_unlock(&job.lock);
    return more;
}

// Begins what was asked for, and gets on with what was begun; returns whether anything came of it.
static bool get_on(Watch *watch, int64_t asked) {
    const int64_t begun = watch->begun, done = watch->done;
    for (; watch->begun < asked && watch->problem == MPI_SUCCESS; watch->begun++)
        watch->problem = begin(&job.sums[watch->begun % SUMS], &watch->requests[watch->begun % SUMS]);
    int over = 1;
    while (watch->done < watch->begun && watch->problem == MPI_SUCCESS && over) {
        watch->problem = MPI_Test(&watch->requests[watch->done % SUMS], &over, MPI_STATUS_IGNORE);
        watch->done += over;
    }
    if (watch->problem != MPI_SUCCESS) watch->done = watch->begun = asked; // there is no going on
    return watch->begun != begun || watch->done != done;
}

static void *watch_sums(void *argument) {
    static Watch watch = {.problem = MPI_SUCCESS};
    (void)argument;
    int64_t asked;
    bool waiting;
    for (long looks = 0; is_more(&watch, &asked, &waiting); looks++) {
        if (get_on(&watch, asked))
            looks = 0;
        else if (!waiting || looks > QUICK_LOOKS)
            rest(WATCH_NS);
    }
    return NULL;
}

static void sum_begin(void *user, float *values, int64_t count) {
    (void)user;
    pthread_mutex_lock(&job.lock);
    while (job.asked - job.done >= SUMS) pthread_cond_wait(&job.changed, &job.lock);
    job.sums[job.asked++ % SUMS] = (Sum){values, count};
    pthread_cond_broadcast(&job.changed);
    pthread_mutex_unlock(&job.lock);
}

static bool sum_finish(void *user, FfpError *err) {
    (void)user;
    pthread_mutex_lock(&job.lock);
    job.waiting = true;
    while (job.done != job.asked) pthread_cond_wait(&job.changed, &job.lock);
    job.waiting = false;
    const int problem = job.problem;
    pthread_mutex_unlock(&job.lock);
    return problem == MPI_SUCCESS || fail(err, "MPI_Iallreduce", problem);
}

// --- What is waited for. ---

static bool sum(void *user, double *values, int count, FfpError *err) {
    (void)user;
    MPI_Request request;
    const int problem =
        MPI_Iallreduce(MPI_IN_PLACE, values, count, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD, &request);
    return await(&request, "MPI_Iallreduce", problem, err); // NOLINT(clang-analyzer-optin.mpi.MPI-Checker)
}

static bool gather_parts(const float *part, float *whole, const int *counts, const int *places, int to,
                         FfpError *err) {
    const int rank = job.ranks.rank, own = counts[rank];
    const bool in_place = whole && part == whole + places[rank];
    int problem = MPI_SUCCESS;
    if (to < 0) {
        problem = MPI_Allgatherv(in_place ? MPI_IN_PLACE : part, own, MPI_FLOAT, whole, counts, places,
                                 MPI_FLOAT, MPI_COMM_WORLD);
        return problem == MPI_SUCCESS || fail(err, "MPI_Allgatherv", problem);
    }
    problem = MPI_Gatherv(in_place && rank == to ? MPI_IN_PLACE : part, own, MPI_FLOAT, whole, counts, places,
                          MPI_FLOAT, to, MPI_COMM_WORLD);
    return problem == MPI_SUCCESS || fail(err, "MPI_Gatherv", problem);
}

static bool gather(void *user, const float *part, float *whole, const int64_t *first, int to, FfpError *err) {
    (void)user;
    const int n = job.ranks.count;
    if (first[n] > INT_MAX) return fail(err, "MPI_Allgatherv", MPI_ERR_COUNT); // MPI-3 counts in int
    int *counts = malloc(2 * (size_t)n * sizeof *counts);
    if (!counts) return fail(err, "malloc", MPI_ERR_NO_MEM);
    for (int r = 0; r < n; r++) {
        counts[r] = (int)(first[r + 1] - first[r]);
        counts[n + r] = (int)first[r];
    }
    const bool ok = gather_parts(part, whole, counts, counts + n, to, err);
    free(counts);
    return ok;
}

static bool broadcast(void *user, void *bytes, int64_t size, int from, FfpError *err) {
    (void)user;
    for (int64_t at = 0; at < size; at += INT_MAX) { // NOLINT(clang-analyzer-optin.mpi.MPI-Checker)
        const int count = size - at < INT_MAX ? (int)(size - at) : INT_MAX;
        MPI_Request request;
        const int problem = MPI_Ibcast((char *)bytes + at, count, MPI_BYTE, from, MPI_COMM_WORLD, &request);
        // NOLINTNEXTLINE(clang-analyzer-optin.mpi.MPI-Checker)
        if (!await(&request, "MPI_Ibcast", problem, err)) return false;
    }
    return true;
}

static void leave(void *user) {
    (void)user;
    ffp_cluster_abort();
}

// --- The job. ---

static bool start_watcher(FfpError *err) {
    sigset_t all, before;
    pthread_mutex_init(&job.lock, NULL);
    pthread_cond_init(&job.changed, NULL);
    sigfillset(&all); // signals go to the threads that were there before
    pthread_sigmask(SIG_SETMASK, &all, &before);
    const int problem = pthread_create(&job.watcher, NULL, watch_sums, NULL);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (problem == 0) return true;
    err->code = FFP_ERROR_IO;
    snprintf(err->text, sizeof err->text, "cannot start a thread: %s", strerror(problem));
    return false;
}

const FfpRanks *ffp_cluster_join(FfpError *err) {
    int threads = 0;
    const int problem = MPI_Init_thread(NULL, NULL, MPI_THREAD_SERIALIZED, &threads);
    if (problem != MPI_SUCCESS) {
        fail(err, "MPI_Init_thread", problem);
        return NULL;
    }
    job.ranks = (FfpRanks){.sum_begin = sum_begin,
                           .sum_finish = sum_finish,
                           .sum = sum,
                           .gather = gather,
                           .broadcast = broadcast,
                           .leave = leave};
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    MPI_Comm_rank(MPI_COMM_WORLD, &job.ranks.rank);
    MPI_Comm_size(MPI_COMM_WORLD, &job.ranks.count);
    if (threads < MPI_THREAD_SERIALIZED) {
        err->code = FFP_ERROR_UNSUPPORTED;
        snprintf(err->text, sizeof err->text,
                 "this MPI library does not support threads (MPI_THREAD_SERIALIZED)");
        return NULL;
    }
    return start_watcher(err) ? &job.ranks : NULL;
}

void ffp_cluster_leave(void) {
    pthread_mutex_lock(&job.lock);
    job.closing = true;
    pthread_cond_broadcast(&job.changed);
    pthread_mutex_unlock(&job.lock);
    pthread_join(job.watcher, NULL);
    MPI_Finalize();
}

void ffp_cluster_abort(void) {
    fprintf(stderr, "ffprocams: rank %d of %d has failed: the job ends\n", job.ranks.rank, job.ranks.count);
    MPI_Abort(MPI_COMM_WORLD, 1);
    abort();
}
