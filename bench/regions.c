// Parallel regions of a program that libgomp runs, recorded: a module for LD_PRELOAD (bench/cores.py builds
// and uses it). With one thread it also schedules the recorded parts of each region on 2, 4, 8 and 16
// threads, as `schedule(dynamic)` would, and shares the work of other regions out evenly.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <omp.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { SITES = 1024, PARTS = 1 << 20, THREADS = 64, COUNTS = 4 };
static const int counts[COUNTS] = {2, 4, 8, 16};

typedef struct Site {
    void (*body)(void *data);
    long calls;
    double wall, work, longest; // seconds, sums over calls; longest: its largest part, or thread
    double least_wait;          // of all calls: wall without the longest thread
    double on[COUNTS];          // predicted, waiting left out
} Site;

typedef struct Region {
    void (*body)(void *data);
    void *data;
    double busy[THREADS];
} Region;

static Site sites[SITES];
static float parts[PARTS]; // of the region at hand, with one thread
static int n_parts;
static __thread double part_begin;

static double now(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// With one thread the processor's time, which other programs do not disturb.
static double clock_of(void) {
    return now(omp_get_max_threads() == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC);
}

static Site *site_of(void (*body)(void *data)) {
    size_t at = ((size_t)body >> 4) % SITES;
    while (sites[at].body && sites[at].body != body) at = (at + 1) % SITES;
    if (!sites[at].body) sites[at] = (Site){.body = body, .least_wait = 1e9};
    return &sites[at];
}

static void run_body(void *argument) {
    Region *region = argument;
    const double begin = clock_of();
    part_begin = begin;
    region->body(region->data);
    region->busy[omp_get_thread_num() % THREADS] = clock_of() - begin;
}

// Each part goes to the thread that is free first.
static double scheduled(int threads) {
    double busy[16] = {0}, last = 0;
    for (int i = 0; i < n_parts; i++) {
        int next = 0;
        for (int t = 1; t < threads; t++)
            if (busy[t] < busy[next]) next = t;
        busy[next] += (double)parts[i];
    }
    for (int t = 0; t < threads; t++) last = busy[t] > last ? busy[t] : last;
    return last;
}

static void note(Site *site, const Region *region, double wall) {
    double work = 0, longest = 0;
    for (int t = 0; t < THREADS; t++) {
        work += region->busy[t];
        longest = region->busy[t] > longest ? region->busy[t] : longest;
    }
    site->calls++;
    site->wall += wall;
    site->work += work;
    if (wall - longest < site->least_wait) site->least_wait = wall - longest;
    double part = 0;
    for (int i = 0; i < n_parts; i++) part = (double)parts[i] > part ? (double)parts[i] : part;
    site->longest += n_parts ? part : longest;
    for (int k = 0; k < COUNTS; k++) site->on[k] += n_parts ? scheduled(counts[k]) : work / counts[k];
}

typedef void Parallel(void (*body)(void *), void *data, unsigned threads, unsigned flags);
typedef void ParallelLoop(void (*body)(void *), void *data, unsigned threads, long from, long to, long step,
                          long chunk, unsigned flags);

void GOMP_parallel(void (*body)(void *), void *data, unsigned threads, unsigned flags) {
    static Parallel *real;
    if (!real) real = (Parallel *)dlsym(RTLD_NEXT, "GOMP_parallel");
    if (omp_get_level() > 0) {
        real(body, data, threads, flags);
        return;
    }
    Region region = {.body = body, .data = data};
    n_parts = 0;
    const double begin = clock_of();
    real(run_body, &region, threads, flags);
    note(site_of(body), &region, clock_of() - begin);
}

void GOMP_parallel_loop_nonmonotonic_dynamic(void (*body)(void *), void *data, unsigned threads, long from,
                                             long to, long step, long chunk, unsigned flags) {
    static ParallelLoop *real;
    if (!real) real = (ParallelLoop *)dlsym(RTLD_NEXT, "GOMP_parallel_loop_nonmonotonic_dynamic");
    if (omp_get_level() > 0) {
        real(body, data, threads, from, to, step, chunk, flags);
        return;
    }
    Region region = {.body = body, .data = data};
    n_parts = 0;
    const double begin = clock_of();
    real(run_body, &region, threads, from, to, step, chunk, flags);
    note(site_of(body), &region, clock_of() - begin);
}

static void end_part(void) {
    if (omp_get_level() != 1 || omp_get_num_threads() != 1) return;
    const double end = clock_of();
    if (n_parts < PARTS) parts[n_parts++] = (float)(end - part_begin);
    part_begin = end;
}

bool GOMP_loop_nonmonotonic_dynamic_next(long *from, long *to) {
    static bool (*real)(long *, long *);
    if (!real) real = (bool (*)(long *, long *))dlsym(RTLD_NEXT, "GOMP_loop_nonmonotonic_dynamic_next");
    end_part();
    return real(from, to);
}

bool GOMP_loop_ull_nonmonotonic_dynamic_next(unsigned long long *from, unsigned long long *to) {
    typedef bool Next(unsigned long long *, unsigned long long *);
    static Next *real;
    if (!real) real = (Next *)dlsym(RTLD_NEXT, "GOMP_loop_ull_nonmonotonic_dynamic_next");
    end_part();
    return real(from, to);
}

// JSON, a line a region: where its body lies in which file, and the figures.
__attribute__((destructor)) static void tell(void) {
    const char *path = getenv("REGIONS_FILE");
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file) return;
    fprintf(file, "{\"process\": %.6f}\n", now(CLOCK_PROCESS_CPUTIME_ID));
    for (int i = 0; i < SITES; i++) {
        const Site *s = &sites[i];
        Dl_info where = {0};
        if (!s->body || !dladdr((void *)s->body, &where)) continue;
        fprintf(file,
                "{\"file\": \"%s\", \"at\": %ld, \"calls\": %ld, \"wall\": %.6f, \"work\": %.6f, "
                "\"longest\": %.6f, \"wait\": %.9f, \"on\": [%.6f, %.6f, %.6f, %.6f]}\n",
                where.dli_fname, (long)((char *)s->body - (char *)where.dli_fbase), s->calls, s->wall,
                s->work, s->longest, s->least_wait, s->on[0], s->on[1], s->on[2], s->on[3]);
    }
    fclose(file);
}
