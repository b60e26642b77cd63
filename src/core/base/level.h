// Functions that are compiled once for each CPU level (core/base/cpu.h): the sources in src/<room>/kernels/.
// CMake defines FFP_LEVEL as the level's name (portable, avx2, avx512, avx512bf16, amx) and, where products
// take bf16 operands, FFP_BF16.
#ifndef FFP_BASE_LEVEL_H
#define FFP_BASE_LEVEL_H

#include "core/base/cpu.h"

#define FFP_PASTE_LEVEL(level, name) ffp_##level##_##name
#define FFP_EXPAND_LEVEL(level, name) FFP_PASTE_LEVEL(level, name)
#define FFP_K(name) FFP_EXPAND_LEVEL(FFP_LEVEL, name)

// Declares a room's tables of functions, ffp_<level>_<name> of type Table, and ffp_<name>_kernels(), which
// gives that of the level in use. For loops in plain C, which gain nothing from bf16 and tiles: avx512 serves
// the levels above it. Rooms built in double exist at one level only.
#if defined(FFP_ALL_LEVELS) && !defined(FFP_REAL_DOUBLE)
#define FFP_LOOP_TABLES(Table, name)                                                                         \
    extern const Table ffp_portable_##name, ffp_avx2_##name, ffp_avx512_##name;                              \
    static inline const Table *ffp_##name##_kernels(void) {                                                  \
        const FfpCpuLevel level = ffp_cpu_level();                                                           \
        if (level >= FFP_CPU_AVX512) return &ffp_avx512_##name;                                              \
        return level >= FFP_CPU_AVX2 ? &ffp_avx2_##name : &ffp_portable_##name;                              \
    }
#else
#define FFP_LOOP_TABLES(Table, name)                                                                         \
    extern const Table ffp_portable_##name;                                                                  \
    static inline const Table *ffp_##name##_kernels(void) {                                                  \
        return &ffp_portable_##name;                                                                         \
    }
#endif

#endif
