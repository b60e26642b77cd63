// OpenMP's functions in a page. With threads (FFP_WASM_THREADS of cmake/wasm.cmake) they are in openmp.c;
// with one thread the compiler knows `simd` alone of the pragmas.
#ifndef FFP_WASM_OMP_H
#define FFP_WASM_OMP_H

#include <time.h>

#ifdef _OPENMP
int omp_get_max_threads(void);
int omp_get_num_threads(void);
int omp_get_thread_num(void);
int omp_get_num_procs(void);
int omp_in_parallel(void);
int omp_get_level(void);
void omp_set_num_threads(int threads);
#else
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
#endif
static inline double omp_get_wtime(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

#endif
