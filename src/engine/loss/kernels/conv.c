// Convolution as a matrix product over unfolded strips of a few output rows, small enough to stay in the
// cache.
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/tensor/tensor.h"
#include "engine/loss/kernels/kernels.h"

// Output pixels in a strip: with 576 rows (64 channels, 3x3) the unfolded strip takes about 600 kB.
enum { STRIP_PIXELS = 256 };

typedef struct Strips {
    int width, height; // of the output
    int rows, count;   // rows in a strip, strips in an image
    int depth;         // in * kernel * kernel
    size_t plane, plane_in;
    bool direct; // 1x1 with stride 1: the input is its own unfolded form
} Strips;

static Strips plan_strips(const FfpConv *conv) {
    Strips plan = {.width = ffp_conv_side(conv->width, conv->kernel, conv->stride, conv->pad),
                   .height = ffp_conv_side(conv->height, conv->kernel, conv->stride, conv->pad),
                   .depth = conv->in * conv->kernel * conv->kernel,
                   .direct = conv->kernel == 1 && conv->stride == 1 && conv->pad == 0};
    if (plan.width < 1 || plan.height < 1) return plan; // no strips: nothing to do
    // At least kernel/stride rows: then strips two apart touch different input rows (see the backward pass).
    const int least = (conv->kernel + conv->stride - 1) / conv->stride, fitting = STRIP_PIXELS / plan.width;
    plan.rows = fitting > least ? fitting : least;
    if (plan.rows > plan.height) plan.rows = plan.height;
    plan.count = (plan.height + plan.rows - 1) / plan.rows;
    plan.plane = (size_t)plan.width * plan.height;
    plan.plane_in = (size_t)conv->width * conv->height;
    return plan;
}

static int strip_rows(const Strips *plan, int first) {
    return first + plan->rows > plan->height ? plan->height - first : plan->rows;
}

// Output columns [*low, *high) whose tap j falls inside the input.
static void inside(const FfpConv *conv, int columns, int j, int *low, int *high) {
    const int last = conv->width - 1 + conv->pad - j;
    *low = j >= conv->pad ? 0 : (conv->pad - j + conv->stride - 1) / conv->stride;
    *high = last < 0 ? 0 : last / conv->stride + 1;
    if (*high > columns) *high = columns;
    if (*low > *high) *low = *high;
}

// to [rows * columns] = what tap (i,j) of one channel sees from output rows first .. first + rows - 1.
static void unfold_tap(real *to, const real *plane, const FfpConv *conv, int i, int j, int first, int rows,
                       int columns) {
    int low, high;
    inside(conv, columns, j, &low, &high);
    for (int r = 0; r < rows; r++, to += columns) {
        const int y = (first + r) * conv->stride - conv->pad + i;
        if (y < 0 || y >= conv->height || low == high) {
            memset(to, 0, columns * sizeof *to);
            continue;
        }
        const real *from = plane + (size_t)y * conv->width + (low * conv->stride - conv->pad + j);
        for (int x = 0; x < low; x++) to[x] = 0;
        if (conv->stride == 1)
            memcpy(to + low, from, (high - low) * sizeof *to);
        else
            for (int x = low; x < high; x++) to[x] = from[(size_t)(x - low) * conv->stride];
        for (int x = high; x < columns; x++) to[x] = 0;
    }
}

static void fold_tap(real *plane, const real *from, const FfpConv *conv, int i, int j, int first, int rows,
                     int columns) {
    int low, high;
    inside(conv, columns, j, &low, &high);
    for (int r = 0; r < rows; r++, from += columns) {
        const int y = (first + r) * conv->stride - conv->pad + i;
        if (y < 0 || y >= conv->height || low == high) continue;
        real *to = plane + (size_t)y * conv->width + (low * conv->stride - conv->pad + j);
        if (conv->stride == 1)
            for (int x = low; x < high; x++) to[x - low] += from[x];
        else
            for (int x = low; x < high; x++) to[(size_t)(x - low) * conv->stride] += from[x];
    }
}

// columns [in * kernel * kernel, rows * width]: the patches under the strip's output pixels.
static void unfold(real *columns, const real *x, const FfpConv *conv, const Strips *plan, int first,
                   int rows) {
    const size_t pixels = (size_t)rows * plan->width;
    for (int c = 0; c < conv->in; c++)
        for (int i = 0; i < conv->kernel; i++)
            for (int j = 0; j < conv->kernel; j++, columns += pixels)
                unfold_tap(columns, x + c * plan->plane_in, conv, i, j, first, rows, plan->width);
}

// The adjoint: adds every patch value to the input value it came from.
static void fold(real *dx, const real *columns, const FfpConv *conv, const Strips *plan, int first,
                 int rows) {
    const size_t pixels = (size_t)rows * plan->width;
    for (int c = 0; c < conv->in; c++)
        for (int i = 0; i < conv->kernel; i++)
            for (int j = 0; j < conv->kernel; j++, columns += pixels)
                fold_tap(dx + c * plan->plane_in, columns, conv, i, j, first, rows, plan->width);
}

static size_t columns_size(const Strips *plan) {
    return (size_t)plan->depth * plan->rows * plan->width;
}

// Room for the patches of a strip, for each thread.
static real *new_columns(const Strips *plan) {
    return plan->direct ? NULL : ffp_alloc((size_t)omp_get_max_threads() * columns_size(plan), sizeof(real));
}

static real *own_columns(real *columns, const Strips *plan) {
    return plan->direct ? NULL : columns + (size_t)omp_get_thread_num() * columns_size(plan);
}

static void forward_strip(real *y, const real *x, const real *w, const real *bias, const FfpConv *conv,
                          const Strips *plan, int first, real *columns) {
    const int rows = strip_rows(plan, first), pixels = rows * plan->width;
    real *out = y + (size_t)first * plan->width;
    if (!plan->direct) unfold(columns, x, conv, plan, first, rows);
    const FfpFactor patches =
        plan->direct ? ffp_factor(x + (size_t)first * plan->width, plan->depth, pixels, (int)plan->plane)
                     : ffp_factor(columns, plan->depth, pixels, pixels);
    ffp_gemm(1, ffp_factor(w, conv->out, plan->depth, plan->depth), patches, 0, out, (int)plan->plane);
    for (int c = 0; c < conv->out; c++, out += plan->plane)
        for (int i = 0; i < pixels; i++) {
            const real sum = out[i] + bias[c];
            out[i] = sum > 0 ? sum : 0;
        }
}

typedef struct Forward {
    real *y;
    const real *x, *w, *bias;
    size_t y_step, x_step;
    const FfpConv *conv;
    Strips plan;
    real *columns;
} Forward;

static void forward(void *argument, int64_t k) {
    const Forward *f = argument;
    const int image = (int)k / f->plan.count, first = (int)k % f->plan.count * f->plan.rows;
    forward_strip(f->y + image * f->y_step, f->x + image * f->x_step, f->w, f->bias, f->conv, &f->plan, first,
                  own_columns(f->columns, &f->plan));
}

void FFP_K(conv2d_forward)(real *y, size_t y_step, const real *x, size_t x_step, const real *w,
                           const real *bias, const FfpConv *conv, int images) {
    const Strips plan = plan_strips(conv);
    Forward f = {y, x, w, bias, y_step, x_step, conv, plan, new_columns(&plan)};
    ffp_parallel_for((int64_t)images * plan.count, 0, forward, &f);
    ffp_free(f.columns);
}

static void backward_strip(real *dx, real *dy, const real *y, const real *w, const FfpConv *conv,
                           const Strips *plan, int first, real *columns) {
    const int rows = strip_rows(plan, first), pixels = rows * plan->width;
    const size_t start = (size_t)first * plan->width;
    for (int c = 0; c < conv->out; c++) {
        real *d = dy + start + c * plan->plane;
        const real *o = y + start + c * plan->plane;
        for (int i = 0; i < pixels; i++) d[i] = o[i] > 0 ? d[i] : 0;
    }
    const FfpFactor weights = ffp_transposed(ffp_factor(w, conv->out, plan->depth, plan->depth));
    const FfpFactor gradients = ffp_factor(dy + start, conv->out, pixels, (int)plan->plane);
    if (plan->direct) {
        ffp_gemm(1, weights, gradients, 1, dx + start, (int)plan->plane);
        return;
    }
    ffp_gemm(1, weights, gradients, 0, columns, pixels);
    fold(dx, columns, conv, plan, first, rows);
}

typedef struct Backward {
    real *dx, *dy;
    const real *y, *w;
    const FfpConv *conv;
    Strips plan;
    int odd;
    real *columns;
} Backward;

static void backward(void *argument, int64_t half) {
    const Backward *b = argument;
    backward_strip(b->dx, b->dy, b->y, b->w, b->conv, &b->plan, (2 * (int)half + b->odd) * b->plan.rows,
                   own_columns(b->columns, &b->plan));
}

void FFP_K(conv2d_backward)(real *dx, real *dy, const real *y, const real *w, const FfpConv *conv) {
    const Strips plan = plan_strips(conv);
    Backward b = {dx, dy, y, w, conv, plan, 0, new_columns(&plan)};
    // Neighbouring strips add to shared input rows, strips two apart never do: first the even ones, then
    // the odd.
    for (; b.odd < 2; b.odd++) ffp_parallel_for((plan.count + 1 - b.odd) / 2, 0, backward, &b);
    ffp_free(b.columns);
}

void FFP_K(maxpool_forward)(real *y, const real *x, const FfpPool *pool) {
    const int width = ffp_pool_side(pool->width, pool->kernel, pool->stride, pool->round_up);
    const int height = ffp_pool_side(pool->height, pool->kernel, pool->stride, pool->round_up);
#pragma omp parallel for schedule(static)
    for (int c = 0; c < pool->channels; c++) {
        const real *plane = x + (size_t)c * pool->width * pool->height;
        real *out = y + (size_t)c * width * height;
        for (int i = 0; i < width * height; i++)
            out[i] = plane[ffp_pool_largest(plane, pool, i % width, i / width)];
    }
}

void FFP_K(maxpool_backward)(real *dx, const real *dy, const real *x, const FfpPool *pool) {
    const int width = ffp_pool_side(pool->width, pool->kernel, pool->stride, pool->round_up);
    const int height = ffp_pool_side(pool->height, pool->kernel, pool->stride, pool->round_up);
#pragma omp parallel for schedule(static)
    for (int c = 0; c < pool->channels; c++) {
        const size_t start = (size_t)c * pool->width * pool->height;
        const real *from = dy + (size_t)c * width * height;
        for (int i = 0; i < width * height; i++)
            dx[start + ffp_pool_largest(x + start, pool, i % width, i / width)] += from[i];
    }
}
