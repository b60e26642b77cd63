#include "engine/match/labels.h"
#include <string.h>
#include <tgmath.h>
#include "engine/match/sweep.h"

#define WITHIN 10.0F // cost of another label within one colour,
#define ACROSS 0.05F // between two,
#define UNTOLD 0.25F // and in the dark
#define UNLIKE 0.03F // difference of encoded colours at which the cost has fallen by a factor of e
#define BRIGHT 0.1F  // encoded colours from which a picture tells surfaces apart

static real cost_of_change(const real *picture, size_t first, size_t second) {
    const real *a = picture + 3 * first, *b = picture + 3 * second;
    real off = 0, bright = 0;
    for (int c = 0; c < 3; c++) off += fabs(a[c] - b[c]) / 3, bright += (a[c] + b[c]) / 6;
    const real told = fmin(bright / BRIGHT, 1);
    return told * (ACROSS + (WITHIN - ACROSS) * exp(-off / UNLIKE)) + (1 - told) * UNTOLD;
}

void ffp_labels_total(real *total, const real *cost, const FfpForeground *foreground, int labels,
                      const real *colour) {
    memset(total, 0, foreground->count * (size_t)labels * sizeof(real));
    ffp_semi_global(total, cost, foreground, labels,
                    &(FfpSteps){.border = cost_of_change, .picture = colour});
}
