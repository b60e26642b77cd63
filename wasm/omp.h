// OpenMP's functions in a page, which has one thread: its pragmas are left to the compiler, which knows
// `simd` alone of them (cmake/wasm.cmake).
#ifndef FFP_WASM_OMP_H
#define FFP_WASM_OMP_H

#include <time.h>

static inline int omp_get_max_threads(void) {
    return 1;
}
static inline int omp_get_num_threads(void) {
    return 1;
}
static inline int omp_get_thread_num(void) {
    return 0;
}
static inline int omp_get_num_procs(void) {
    return 1;
}
static inline int omp_in_parallel(void) {
    return 0;
}
static inline int omp_get_level(void) {
    return 0;
}
static inline void omp_set_num_threads(int threads) {
    (void)threads;
}
static inline double omp_get_wtime(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

#endif
