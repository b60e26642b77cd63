// One plane of a whole scene's sweep over the photographs (engine/match/stereo.h), a run of pixels at a time.
#include "engine/match/kernels/kernels.h"

enum { RUN = 256 };
#define UNLIKE 0.1F // difference of an encoded channel beyond which it tells no more

typedef __typeof__((FfpStereoCell){0} < 0) Mask;

// `a` where the mask is set, and `b` elsewhere.
static inline FfpStereoCell pick(Mask mask, FfpStereoCell a, FfpStereoCell b) {
    return (FfpStereoCell)(((Mask)a & mask) | ((Mask)b & ~mask));
}

static inline real sum_of(FfpStereoCell x) {
    typedef real Half __attribute__((vector_size(FFP_STEREO_CHANNELS / 2 * sizeof(real))));
    const union {
        FfpStereoCell whole;
        Half half[2];
    } parts = {x};
    const Half four = parts.half[0] + parts.half[1];
    return (four[0] + four[2]) + (four[1] + four[3]);
}

// Positions in the neighbour, -1 where the point is not in front of it.
static void positions(real *restrict u, real *restrict v, const FfpStereoPlane *p, size_t first, int count) {
    const real *restrict l[6];
    for (int k = 0; k < 6; k++) l[k] = p->line[k] + first;
    const real at = p->at;
    for (int i = 0; i < count; i++) {
        const real depth = l[4][i] + l[5][i] * at, inverse = 1 / depth;
        const bool front = depth > 1e-6F;
        u[i] = front ? (l[0][i] + l[1][i] * at) * inverse - 0.5F : -1;
        v[i] = front ? (l[2][i] + l[3][i] * at) * inverse - 0.5F : -1;
    }
}

// Weighted difference of a pixel and the neighbour's picture at (u, v), bilinear; in [0,1].
static real difference(const FfpStereoPlane *p, size_t own, real u, real v) {
    const int x = (int)u, y = (int)v;
    const real a = u - (real)x, b = v - (real)y;
    const FfpStereoCell *above = p->theirs + (size_t)y * (size_t)p->width + (size_t)x,
                        *below = above + p->width;
    const FfpStereoCell left = above[0] + b * (below[0] - above[0]),
                        right = above[1] + b * (below[1] - above[1]);
    const FfpStereoCell off = p->own[own] - (left + a * (right - left));
    const FfpStereoCell size = pick(off < 0, -off, off), most = (FfpStereoCell){0} + UNLIKE;
    return sum_of(p->weight * pick(size < most, size, most)) / UNLIKE;
}

void FFP_K(stereo_plane)(real *single, const FfpStereoPlane *p) {
    real u[RUN], v[RUN];
    for (size_t first = 0; first < p->count; first += RUN) {
        const int count = p->count - first < RUN ? (int)(p->count - first) : RUN;
        positions(u, v, p, first, count);
        for (int i = 0; i < count; i++) {
            const size_t own = p->pixel[first + (size_t)i];
            const bool seen = u[i] >= 0 && v[i] >= 0 && u[i] < p->right && v[i] < p->bottom;
            single[own] = seen ? difference(p, own, u[i], v[i]) : -1;
        }
    }
}
