#define _DEFAULT_SOURCE // syscall
#include "core/base/cpu.h"
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#if defined(__x86_64__)
#include <cpuid.h>
#include <sys/syscall.h>
#include <unistd.h>
#elif defined(__aarch64__) && defined(__linux__)
#include <sys/auxv.h>
#endif
#include "core/base/error.h"

#define LEVEL_NAME(NAME, name, ...) #name,
static const char *const names[FFP_CPU_LEVELS] = {FFP_EACH_LEVEL(LEVEL_NAME, )};

static pthread_once_t once = PTHREAD_ONCE_INIT;
static FfpCpuLevel best, chosen;
static const char *refused; // the value of FFPROCAMS_CPU that cannot be followed

#if defined(__x86_64__)
// Register state that the operating system saves (XCR0): bit 1 SSE, 2 AVX, 5..7 AVX-512, 17, 18 tiles.
static uint64_t saved_state(void) {
    uint32_t low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return (uint64_t)high << 32 | low;
}

// Linux grants the tile data's state on request only (arch_prctl(2): ARCH_REQ_XCOMP_PERM, feature 18).
static bool grant_tiles(void) {
    enum { ARCH_REQ_XCOMP_PERM = 0x1023, TILE_DATA = 18 };
    return syscall(SYS_arch_prctl, ARCH_REQ_XCOMP_PERM, TILE_DATA) == 0;
}

static bool has(uint32_t bits, uint32_t wanted) {
    return (bits & wanted) == wanted;
}

// Feature bits: Intel's manual, volume 2A, CPUID leaves 1 and 7.
static FfpCpuLevel detect(void) {
    const uint32_t fma_osxsave_avx = 1U << 12 | 1U << 27 | 1U << 28;
    const uint32_t bmi1_avx2_bmi2 = 1U << 3 | 1U << 5 | 1U << 8;
    const uint32_t avx512 = 1U << 16 | 1U << 17 | 1U << 28 | 1U << 30 | 1U << 31; // F, DQ, CD, BW, VL
    uint32_t a, b, c, d, a1, b1, c1, d1;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !has(c, fma_osxsave_avx)) return FFP_CPU_PORTABLE;
    const uint64_t state = saved_state();
    if ((state & 0x6) != 0x6 || !__get_cpuid_count(7, 0, &a, &b, &c, &d) || !has(b, bmi1_avx2_bmi2))
        return FFP_CPU_PORTABLE;
    if ((state & 0xE0) != 0xE0 || !has(b, avx512)) return FFP_CPU_AVX2;
    if (!__get_cpuid_count(7, 1, &a1, &b1, &c1, &d1) || !has(a1, 1U << 5)) return FFP_CPU_AVX512;
    const bool tiles = has(d, 1U << 22 | 1U << 24) && (state & 0x60000) == 0x60000;
    return tiles && grant_tiles() ? FFP_CPU_AMX : FFP_CPU_AVX512BF16;
}
#elif defined(__aarch64__)
// Bits of getauxval(3): the kernel's Documentation/arm64/elf_hwcaps.rst. Elsewhere than under Linux, what
// every 64-bit ARM processor of a desktop or telephone has.
static FfpCpuLevel detect(void) {
#ifdef __linux__
    const unsigned long simd = 1UL << 1, bf16 = 1UL << 14;
    if (!(getauxval(AT_HWCAP) & simd)) return FFP_CPU_PORTABLE;
    if (getauxval(AT_HWCAP2) & bf16) return FFP_CPU_NEONBF16;
#endif
    return FFP_CPU_NEON;
}
#else
static FfpCpuLevel detect(void) {
    return (FfpCpuLevel)(FFP_CPU_LEVELS - 1);
}
#endif

// On Intel's processors arithmetic in pairs of bf16 without tiles has half the rate of fp32, on AMD's twice
// (docs/design/performance.md).
static FfpCpuLevel quickest(FfpCpuLevel level) {
#if defined(__x86_64__)
    uint32_t a, b, c, d;
    if (level == FFP_CPU_AVX512BF16 && __get_cpuid(0, &a, &b, &c, &d) && b == signature_INTEL_ebx)
        return FFP_CPU_AVX512;
#endif
    return level;
}

static void decide(void) {
    best = detect();
    chosen = quickest(best);
    const char *wanted = getenv("FFPROCAMS_CPU");
    if (!wanted || !*wanted) return;
    for (int level = 0; level <= (int)best; level++) {
        if (strcmp(wanted, names[level]) != 0) continue;
        chosen = (FfpCpuLevel)level;
        return;
    }
    refused = wanted;
}

const char *ffp_cpu_name(FfpCpuLevel level) {
    return names[level];
}

bool ffp_cpu_bf16(FfpCpuLevel level) {
#define IS_LEVEL(NAME, name, ...) || level == FFP_CPU_##NAME
    return level == FFP_CPU_LEVELS FFP_EACH_BF16_LEVEL(IS_LEVEL, );
}

FfpCpuLevel ffp_cpu_best(void) {
    pthread_once(&once, decide);
    return best;
}

FfpCpuLevel ffp_cpu_level(void) {
    pthread_once(&once, decide);
    return chosen;
}

bool ffp_cpu_check(FfpError *err) {
    pthread_once(&once, decide);
    if (!refused) return true;
    for (int level = 0; level < FFP_CPU_LEVELS; level++)
        if (strcmp(refused, names[level]) == 0)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "FFPROCAMS_CPU",
                            "this processor cannot run %s; its best is %s", refused, names[best]);
    char list[128] = "";
    for (int level = 0; level < FFP_CPU_LEVELS; level++) {
        const size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", names[level],
                 level < FFP_CPU_LEVELS - 2   ? ", "
                 : level < FFP_CPU_LEVELS - 1 ? " or "
                                              : "");
    }
    return ffp_fail(err, FFP_ERROR_ARGUMENT, "FFPROCAMS_CPU", "invalid value %s: expected %s", refused, list);
}

bool ffp_cpu_set_level(FfpCpuLevel level) {
    pthread_once(&once, decide);
    if (level > best) return false;
    chosen = level;
    return true;
}
