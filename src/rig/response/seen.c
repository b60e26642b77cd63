#include "rig/response/seen.h"
#include <string.h>
#include <tgmath.h>
#include "core/image/lookup_box.h"

int ffp_seen_patterns(const FfpCapture *capture, int *patterns) {
    int n = 0;
    for (int p = 0; p < capture->n_patterns; p++)
        if (p != capture->black && p != capture->white &&
            (p >= ffp_patterns_shown(capture) || !capture->patterns[p].novel))
            patterns[n++] = p;
    return n;
}

bool ffp_seen_box(const FfpImage *map, int x, int y, FfpSeenBox *box) {
    const real *here = map->data + 3 * ((size_t)y * (size_t)map->width + (size_t)x);
    if (x < 1 || y < 1 || x + 1 >= map->width || y + 1 >= map->height || !(here[2] > 0)) return false;
    const real *left = here - 3, *right = here + 3, *above = here - 3 * (size_t)map->width,
               *below = here + 3 * (size_t)map->width;
    if (!(left[2] > 0 && right[2] > 0 && above[2] > 0 && below[2] > 0)) return false;
    box->u = here[0], box->v = here[1];
    box->du = fmax(hypot(right[0] - left[0], below[0] - above[0]) / 2, (real)1);
    box->dv = fmax(hypot(right[1] - left[1], below[1] - above[1]) / 2, (real)1);
    return true;
}

// Three places a side have half of the Gaussian's variance (the nodes and weights of Gauss and Hermite),
// wider boxes the other half.
void ffp_seen_through(const FfpSummed *pattern, const FfpSeenBox *box, real deviation, real out[3]) {
    static const real weights[3] = {1.0F / 6, 2.0F / 3, 1.0F / 6};
    const real apart = (real)sqrt(1.5) * deviation, more = 6 * deviation * deviation,
               du = sqrt(box->du * box->du + more), dv = sqrt(box->dv * box->dv + more);
    FfpBox at[3]; // along the diagonal: the others are made of their sides
    for (int k = 0; k < 3; k++)
        at[k] = ffp_box_at(pattern, box->u + (real)(k - 1) * apart, box->v + (real)(k - 1) * apart, du, dv);
    for (int c = 0; c < 3; c++) out[c] = 0;
    for (int k = 0; k < 9; k++) {
        real value[3];
        FfpBox here = at[k % 3];
        memcpy(here.y, at[k / 3].y, sizeof here.y);
        if (pattern->plain)
            ffp_lookup(pattern, box->u + (real)(k % 3 - 1) * apart, box->v + (real)(k / 3 - 1) * apart, du,
                       dv, value);
        else
            ffp_mean_in(pattern, &here, value);
        for (int c = 0; c < 3; c++) out[c] += weights[k % 3] * weights[k / 3] * value[c];
    }
}
