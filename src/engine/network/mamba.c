// The bidirectional Mamba2 block: Dao & Gu 2024, Sec. 7.1, with one convolution, scan and gated norm for each
// direction between a shared in_proj and out_proj.
#include "core/base/device.h"
#include "core/tensor/tensor.h"
#include "engine/network/blocks.h"

void ffp_mamba_allocate(FfpMambaActivations *at, const FfpWidths *widths, int rows, bool backward,
                        FfpArena *arena) {
    const size_t t = (size_t)rows;
    at->norm = ffp_arena_take(arena, t * widths->dim, sizeof(real));
    at->rstd = ffp_arena_take(arena, t, sizeof(real));
    at->projected = ffp_arena_take(arena, t * widths->projected, sizeof(real));
    for (int i = 0; i < (backward ? 2 : 1); i++) {
        at->direction[i].convolved = ffp_arena_take(arena, t * widths->convolved, sizeof(real));
        at->direction[i].scanned = ffp_arena_take(arena, t * widths->inner, sizeof(real));
        at->direction[i].rstd = ffp_arena_take(arena, t, sizeof(real));
    }
    if (!backward) at->direction[1] = at->direction[0];
    at->summed = ffp_arena_take(arena, t * widths->inner, sizeof(real));
}

static FfpScanShape scan_shape(const FfpWidths *widths, int rows, int direction) {
    return (FfpScanShape){.rows = rows,
                          .heads = widths->scan_heads,
                          .head_dim = FFP_HEAD_DIM,
                          .state = widths->state,
                          .chunk = widths->chunk,
                          .reverse = direction == 1};
}

static FfpScanInput scan_input(const FfpMambaActivations *at, const FfpMambaLayout *layout,
                               const FfpBlockPass *pass, int i) {
    const real *convolved = at->direction[i].convolved, *values = pass->values;
    const FfpWidths *widths = pass->widths;
    return (FfpScanInput){.x = convolved,
                          .b = convolved + widths->inner,
                          .c = convolved + widths->inner + widths->state,
                          .ld = widths->convolved,
                          .dt_raw = at->projected + widths->inner + widths->convolved,
                          .lddt = widths->projected,
                          .dt_bias = values + layout->direction[i].dt_bias,
                          .a_log = values + layout->direction[i].a_log,
                          .d = values + layout->direction[i].d};
}

static FfpDepthwise conv_input(const FfpMambaActivations *at, const FfpMambaLayout *layout,
                               const FfpBlockPass *pass, int i) {
    const FfpWidths *widths = pass->widths;
    return (FfpDepthwise){.x = at->projected + widths->inner,
                          .w = pass->values + layout->direction[i].conv,
                          .bias = pass->values + layout->direction[i].conv_bias,
                          .ldx = widths->projected,
                          .rows = pass->rows,
                          .channels = widths->convolved,
                          .taps = FFP_CONV_TAPS,
                          .reverse = i == 1};
}

static FfpGatedNorm norm_input(const FfpMambaActivations *at, const FfpMambaLayout *layout,
                               const FfpBlockPass *pass, int i) {
    return (FfpGatedNorm){.x = at->direction[i].scanned,
                          .z = at->projected,
                          .ldz = pass->widths->projected,
                          .gain = pass->values + layout->direction[i].norm,
                          .rows = pass->rows,
                          .dim = pass->widths->inner};
}

void ffp_mamba_forward(real *y, FfpMambaActivations *at, const real *x, const FfpMambaLayout *layout,
                       const FfpBlockPass *pass) {
    const FfpWidths *widths = pass->widths;
    const FfpScratch *scratch = pass->scratch;
    FfpProfileTimes *times = pass->times;
    const real *values = pass->values;
    const int rows = pass->rows, dim = widths->dim, inner = widths->inner, ld = widths->projected;
    double last = ffp_seconds();
    ffp_rmsnorm_forward(at->norm, at->rstd, x, values + layout->norm, rows, dim);
    ffp_lap(&last, &times->other);
    ffp_linear_forward(at->projected, at->norm, values + layout->in_proj, NULL, rows, dim, ld);
    ffp_lap(&last, &times->products);
    for (int i = 0; i < 2; i++) {
        const FfpDepthwise conv = conv_input(at, layout, pass, i);
        ffp_conv_forward(at->direction[i].convolved, &conv);
        ffp_lap(&last, &times->other);
        const FfpScanShape shape = scan_shape(widths, rows, i);
        const FfpScanInput in = scan_input(at, layout, pass, i);
        ffp_scan_forward(at->direction[i].scanned, &shape, &in, scratch->kernel);
        ffp_lap(&last, &times->scan);
        const FfpGatedNorm norm = norm_input(at, layout, pass, i);
        ffp_gated_norm_forward(i ? scratch->inner : at->summed, at->direction[i].rstd, &norm);
    }
    ffp_add(at->summed, scratch->inner, (size_t)rows * inner);
    ffp_lap(&last, &times->other);
    ffp_linear_residual_forward(y, x, at->summed, values + layout->out_proj, rows, inner, dim);
    ffp_lap(&last, &times->products);
}

// From the gradient of the summed directions to that of the projected row (z, dt and the convolution's input
// are ADDED).
static void direction_backward(real *dprojected, const real *dsummed, real *grad,
                               const FfpMambaActivations *at, int i, const FfpMambaLayout *layout,
                               const FfpBlockPass *pass) {
    const FfpWidths *widths = pass->widths;
    const FfpScratch *scratch = pass->scratch;
    FfpProfileTimes *times = pass->times;
    const int rows = pass->rows, inner = widths->inner, ld = widths->projected;
    real *dscanned = scratch->inner, *dconvolved = scratch->dwide2;
    double last = ffp_seconds();
    const FfpGatedNorm norm = norm_input(at, layout, pass, i);
    const FfpGatedNormGradient dnorm = {
        .x = dscanned, .z = dprojected, .ldz = ld, .gain = grad + layout->direction[i].norm};
    ffp_gated_norm_backward(&dnorm, &norm, dsummed, at->direction[i].rstd);
    ffp_lap(&last, &times->other);
    const FfpScanShape shape = scan_shape(widths, rows, i);
    const FfpScanInput in = scan_input(at, layout, pass, i);
    const FfpScanGradient out = {.x = dconvolved,
                                 .b = dconvolved + inner,
                                 .c = dconvolved + inner + widths->state,
                                 .dt_raw = dprojected + inner + widths->convolved,
                                 .dt_bias = grad + layout->direction[i].dt_bias,
                                 .a_log = grad + layout->direction[i].a_log,
                                 .d = grad + layout->direction[i].d};
    ffp_scan_backward(&out, &shape, &in, dscanned, scratch->kernel);
    ffp_lap(&last, &times->scan);
    const FfpDepthwise conv = conv_input(at, layout, pass, i);
    const FfpDepthwiseGradient dconv = {.x = dprojected + inner,
                                        .w = grad + layout->direction[i].conv,
                                        .bias = grad + layout->direction[i].conv_bias,
                                        .ldx = ld};
    ffp_conv_backward(&dconv, &conv, dconvolved);
    ffp_lap(&last, &times->other);
}

void ffp_mamba_backward(real *dx, real *grad, const FfpMambaActivations *at, const real *x,
                        const FfpMambaLayout *layout, const FfpBlockPass *pass) {
    const FfpWidths *widths = pass->widths;
    const FfpScratch *scratch = pass->scratch;
    FfpProfileTimes *times = pass->times;
    const real *values = pass->values;
    const int rows = pass->rows, dim = widths->dim, inner = widths->inner, ld = widths->projected;
    real *dprojected = scratch->dwide, *dsummed = scratch->dinner;
    double last = ffp_seconds();
    ffp_linear_backward(dsummed, grad + layout->out_proj, NULL, dx, at->summed, values + layout->out_proj,
                        rows, inner, dim);
    ffp_lap(&last, &times->products);
    ffp_memory_zero(dprojected, (size_t)rows * ld * sizeof *dprojected);
    ffp_lap(&last, &times->other);
    for (int i = 0; i < 2; i++) direction_backward(dprojected, dsummed, grad, at, i, layout, pass);
    last = ffp_seconds();
    ffp_linear_backward(scratch->dnarrow, grad + layout->in_proj, NULL, dprojected, at->norm,
                        values + layout->in_proj, rows, dim, ld);
    ffp_lap(&last, &times->products);
    ffp_rmsnorm_backward(scratch->dnarrow2, grad + layout->norm, scratch->dnarrow, x, at->rstd,
                         values + layout->norm, rows, dim);
    ffp_add(dx, scratch->dnarrow2, (size_t)rows * dim);
    ffp_lap(&last, &times->other);
}
