// Which table of kernels the rasteriser uses.
#include "base/cpu.h"
#include "render/kernels/kernels.h"

static const FfpRenderKernels *const tables[FFP_CPU_LEVELS] = {
    [FFP_CPU_PORTABLE] = &ffp_portable_render,
#if defined(FFP_ALL_LEVELS) && !defined(FFP_REAL_DOUBLE)
    [FFP_CPU_AVX2] = &ffp_avx2_render,
    [FFP_CPU_AVX512] = &ffp_avx512_render,
    [FFP_CPU_AVX512BF16] = &ffp_avx512bf16_render,
    [FFP_CPU_AMX] = &ffp_amx_render,
#endif
};

const FfpRenderKernels *ffp_render_kernels(void) {
    const FfpRenderKernels *table = tables[ffp_cpu_level()];
    return table ? table : tables[FFP_CPU_PORTABLE];
}
