#include "engine/loss/deferred.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/device.h"
#include "engine/loss/loss.h"
#include "engine/loss/metrics.h"
#include "engine/loss/table.h"

typedef struct Due { // a value of the device's, and what it is added to
    double *sum, weight;
    FfpDeferredKind kind;
    real scale;
} Due;

static _Thread_local struct {
    int depth, seen; // how often values are asked to be late; how many of the device's are spoken for
    Due *due;        // [FFP_DEFERRED_MAX]
    const FfpDevice *device;
} late;

double ffp_psnr_of(double mean_square) {
    if (mean_square == 0) return FFP_PSNR_CAP;
    const double value = -10 * log10(mean_square);
    return value > FFP_PSNR_CAP ? FFP_PSNR_CAP : value;
}

// Nothing is late any more, and nothing that was comes.
static void forget(void *thing) {
    (void)thing;
    late.device->loss->late(false);
    late.depth = late.seen = 0;
    late.due = NULL;
}

static int kept(void) {
    return late.depth > 0 ? ffp_device()->loss->deferred_count() : 0;
}

void ffp_losses_defer(void) {
    if (!ffp_device() || late.depth > 0) {
        late.depth += ffp_device() != NULL;
        return;
    }
    late.due = ffp_alloc(FFP_DEFERRED_MAX, sizeof *late.due);
    late.device = ffp_device();
    late.device->loss->late(true);
    late.depth = 1;
    ffp_own(&late, forget);
}

bool ffp_loss_deferred_as(FfpDeferredKind kind, real scale) {
    const int count = kept();
    if (count == late.seen) return false;
    late.due[count - 1].kind = kind;
    late.due[count - 1].scale = scale;
    return true;
}

static double value_of(const Due *due, double v) {
    if (due->kind == FFP_DEFERRED_SIMILARITY) return (double)due->scale * (1 - v);
    return due->kind == FFP_DEFERRED_PSNR ? ffp_psnr_of(v) : v;
}

static void settle(void) {
    double *values = ffp_alloc(FFP_DEFERRED_MAX, sizeof *values);
    ffp_device()->loss->deferred_values(values);
    for (int i = 0; i < late.seen; i++) {
        const Due *due = &late.due[i];
        if (due->sum) *due->sum += due->weight * value_of(due, values[i]);
    }
    memset(late.due, 0, (size_t)late.seen * sizeof *late.due);
    late.seen = 0;
    ffp_free(values);
}

void ffp_loss_add(double *sum, double weight, double value) {
    const int count = kept();
    if (count == late.seen) {
        *sum += weight * value;
        return;
    }
    late.due[count - 1].sum = sum;
    late.due[count - 1].weight = weight;
    late.seen = count;
    if (count == FFP_DEFERRED_MAX) settle();
}

void ffp_losses_collect(void) {
    if (late.depth == 0) return;
    settle();
    if (--late.depth > 0) return;
    ffp_disown(&late);
    ffp_device()->loss->late(false);
    ffp_free(late.due);
    late.due = NULL;
}
