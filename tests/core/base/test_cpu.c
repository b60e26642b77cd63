// Which kernels run: names, order, and what cannot run here.
#include <stdlib.h>
#include "core/base/cpu.h"
#include "support.h"

static void levels(void **state) {
    (void)state;
    assert_string_equal(ffp_cpu_name(FFP_CPU_PORTABLE), "portable");
#if defined(__x86_64__)
    assert_string_equal(ffp_cpu_name(FFP_CPU_AMX), "amx");
    assert_true(ffp_cpu_bf16(FFP_CPU_AMX) && !ffp_cpu_bf16(FFP_CPU_AVX512));
#elif defined(__aarch64__)
    assert_string_equal(ffp_cpu_name(FFP_CPU_NEONBF16), "neonbf16");
    assert_true(ffp_cpu_bf16(FFP_CPU_NEONBF16) && !ffp_cpu_bf16(FFP_CPU_NEON));
#endif
    const FfpCpuLevel best = ffp_cpu_best(), first = ffp_cpu_level();
    print_message("best level: %s\n", ffp_cpu_name(best));
    assert_true(first <= best);
    for (int level = 0; level < FFP_CPU_LEVELS; level++) {
        const bool runs = level <= (int)best;
        assert_true(ffp_cpu_set_level((FfpCpuLevel)level) == runs);
        assert_int_equal(ffp_cpu_level(), runs ? level : (int)best);
    }
    assert_true(ffp_cpu_set_level(first));
}

// bf16 pairs are slower than fp32 on Intel's processors without tiles, and quicker on AMD's.
static void quickest_level(void **state) {
    (void)state;
#if defined(__x86_64__)
    if (getenv("FFPROCAMS_CPU")) skip();
    const bool slow = ffp_cpu_best() == FFP_CPU_AVX512BF16 && __builtin_cpu_is("intel");
    assert_int_equal(ffp_cpu_level(), slow ? FFP_CPU_AVX512 : ffp_cpu_best());
#endif
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(quickest_level), cmocka_unit_test(levels)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
