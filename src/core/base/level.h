// Functions that are compiled once for each CPU level (core/base/cpu.h): the sources in src/<room>/kernels/.
// CMake defines FFP_LEVEL as the level's name (portable, avx2, neon, ...) and, where products
// take bf16 operands, FFP_BF16.
#ifndef FFP_BASE_LEVEL_H
#define FFP_BASE_LEVEL_H

#include <stddef.h>
#include "core/base/cpu.h"

#define FFP_PASTE_LEVEL(level, name) ffp_##level##_##name
#define FFP_EXPAND_LEVEL(level, name) FFP_PASTE_LEVEL(level, name)
#define FFP_K(name) FFP_EXPAND_LEVEL(FFP_LEVEL, name)

// Ahead of a loop of at most n rounds, a number that is known: all of them in a row, so that arrays which it
// counts through are registers. Each compiler passes over the other's word for it.
#define FFP_PRAGMA(words) _Pragma(#words)
// Under the sanitizers, whose checks would be multiplied, the loops stay: clang takes minutes otherwise.
#ifdef FFP_SANITIZED
#define FFP_UNROLL(n)
#elif defined __clang__
#define FFP_UNROLL(n) FFP_PRAGMA(unroll)
#else
#define FFP_UNROLL(n) FFP_PRAGMA(GCC unroll n)
#endif

// Declares a room's tables of functions, ffp_<level>_<name> of type Table, and ffp_<name>_kernels(), which
// gives that of the level in use: of loops' levels the highest that it contains. Rooms built in double exist
// at one level only.
#ifdef FFP_REAL_DOUBLE
#define FFP_EACH_TABLE FFP_PORTABLE_LEVEL
#else
#define FFP_EACH_TABLE FFP_EACH_LOOP_LEVEL
#endif
#define FFP_DECLARE_TABLE(NAME, level, Table, name) extern const Table ffp_##level##_##name;
#define FFP_CHOOSE_TABLE(NAME, level, Table, name)                                                           \
    if (now >= FFP_CPU_##NAME) table = &ffp_##level##_##name;
#define FFP_LOOP_TABLES(Table, name)                                                                         \
    FFP_EACH_TABLE(FFP_DECLARE_TABLE, Table, name)                                                           \
    static inline const Table *ffp_##name##_kernels(void) {                                                  \
        const FfpCpuLevel now = ffp_cpu_level();                                                             \
        const Table *table = NULL;                                                                           \
        FFP_EACH_TABLE(FFP_CHOOSE_TABLE, Table, name)                                                        \
        return table;                                                                                        \
    }

#endif
