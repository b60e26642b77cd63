#include "rig/chessboard/views.h"
#include <string.h>
#include "core/base/alloc.h"

FfpViews ffp_views_new(const FfpRigFit *fit) {
    size_t corners = 1;
    for (int i = 0; i < fit->n; i++) corners += (size_t)fit->attitudes[i].n;
    FfpViews v = {.counts = ffp_alloc((size_t)fit->n, sizeof(int)),
                  .attitude = ffp_alloc((size_t)fit->n, sizeof(int)),
                  .board = ffp_alloc(corners, 3 * sizeof(double))};
    for (int k = 0; k < 2; k++) v.points[k] = ffp_alloc(corners, 2 * sizeof(double));
    return v;
}

void ffp_views_free(FfpViews *v) {
    ffp_free(v->counts), ffp_free(v->attitude), ffp_free(v->board);
    ffp_free(v->points[0]), ffp_free(v->points[1]);
}

bool ffp_corner_used(const FfpAttitude *a, int corner, unsigned devices) {
    return (!(devices & 1U) || a->camera_state[corner] == FFP_CORNER_USED) &&
           (!(devices & 2U) || a->projector_state[corner] == FFP_CORNER_USED);
}

void ffp_views_fill(const FfpRigFit *fit, unsigned devices, FfpViews *v) {
    int sum = 0;
    v->cv = (FfpCvViews){.counts = v->counts, .board = v->board};
    v->cv.first = v->points[devices == 2 ? 1 : 0], v->cv.second = v->points[1];
    for (int i = 0; i < fit->n; i++) {
        const FfpAttitude *a = &fit->attitudes[i];
        if (a->problem[0]) continue;
        const int before = sum;
        for (int k = 0; k < a->n; k++) {
            if (!ffp_corner_used(a, k, devices)) continue;
            v->board[3 * sum] = ffp_corner_column(&fit->board, k) * fit->board.square;
            v->board[3 * sum + 1] = ffp_corner_row(&fit->board, k) * fit->board.square;
            v->board[3 * sum + 2] = 0;
            memcpy(v->points[0] + 2 * (size_t)sum, a->camera + 2 * (size_t)k, 2 * sizeof(double));
            memcpy(v->points[1] + 2 * (size_t)sum, a->projector + 2 * (size_t)k, 2 * sizeof(double));
            sum++;
        }
        v->attitude[v->cv.n] = i;
        v->counts[v->cv.n++] = sum - before;
    }
}
