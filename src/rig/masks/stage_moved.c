#include <tgmath.h>
#include "core/base/alloc.h"
#include "rig/masks/limits.h"
#include "rig/masks/steps.h"

typedef struct Small {
    int width, height;
    double *of, mean; // [height*width]
} Small;

// White minus black, in means of step x step pixels.
static Small reduce(const FfpImage *black, const FfpImage *white, int step) {
    Small out = {.width = white->width / step, .height = white->height / step};
    out.of = ffp_alloc((size_t)out.width * (size_t)out.height, sizeof *out.of);
    for (int y = 0; y < out.height * step; y++)
        for (int x = 0; x < out.width * step; x++) {
            const ptrdiff_t i = 3 * ((ptrdiff_t)y * white->width + x);
            double *sum = &out.of[(ptrdiff_t)(y / step) * out.width + x / step];
            for (int c = 0; c < 3; c++) *sum += (double)white->data[i + c] - (double)black->data[i + c];
        }
    for (ptrdiff_t i = 0; i < (ptrdiff_t)out.width * out.height; i++) {
        out.of[i] = fmax(out.of[i], 0);
        out.mean += out.of[i] / ((double)out.width * out.height);
    }
    return out;
}

// How much the view differs from the stage moved by (dx, dy), from 0 to MOVED_OFF_MOST.
static double difference(const Small *view, const Small *stage, int dx, int dy) {
    const double gain = view->mean / stage->mean, dark = MOVED_DARK * view->mean;
    double sum = 0, count = 0;
    for (int y = fmax(0, dy); y < view->height + fmin(0, dy); y++)
        for (int x = fmax(0, dx); x < view->width + fmin(0, dx); x++) {
            const double here = view->of[(ptrdiff_t)y * view->width + x],
                         there = gain * stage->of[(ptrdiff_t)(y - dy) * view->width + x - dx];
            if (here + there < 2 * dark) continue;
            sum += fmin(fabs(here - there) / (here + there), MOVED_OFF_MOST), count++;
        }
    return count > 0 ? sum / count : MOVED_OFF_MOST;
}

static void search(int moved[2], const Small *view, const Small *stage) {
    const int reach = (int)ceil(MOVED_REACH * view->width), side = 2 * reach + 1;
    double *differences = ffp_alloc((size_t)side * (size_t)side, sizeof *differences);
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < side * side; i++)
        differences[i] = difference(view, stage, i % side - reach, i / side - reach);
    int best = reach * side + reach;
    const double without = differences[best];
    for (int i = 0; i < side * side; i++)
        if (differences[i] < differences[best]) best = i;
    const bool clearly = differences[best] < MOVED_CLEARLY * without;
    moved[0] = clearly ? best % side - reach : 0;
    moved[1] = clearly ? best / side - reach : 0;
    ffp_free(differences);
}

void ffp_stage_moved(int moved[2], const FfpImage *black, const FfpImage *white, const FfpImage *stage_black,
                     const FfpImage *stage_white) {
    const int step = (int)fmax(1, round(white->width / (double)MOVED_WIDTH));
    Small view = reduce(black, white, step), stage = reduce(stage_black, stage_white, step);
    moved[0] = moved[1] = 0;
    if (view.mean > 0 && stage.mean > 0 && view.width > 0 && view.height > 0) search(moved, &view, &stage);
    for (int k = 0; k < 2; k++) moved[k] *= step;
    ffp_free(view.of), ffp_free(stage.of);
}
