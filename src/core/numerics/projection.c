#include "core/numerics/projection.h"
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/numerics/least_squares.h"
#include "core/numerics/rank.h"

#define FAR 4 // times the median

typedef struct Linear { // equations of a projection whose depth is 1 at the points' middle
    int n;
    const double *points, *panel; // [n,3] from the middle, in their spread; [n,2]
    unsigned char *use;
} Linear;

static bool solve_linear(const Linear *l, double m[12]) {
    double a[11 * 11] = {0}, c[11] = {0};
    for (int i = 0; i < l->n; i++) {
        const double *x = l->points + 3 * (size_t)i, *p = l->panel + 2 * (size_t)i;
        if (!l->use[i]) continue;
        for (int k = 0; k < 2; k++) { // (m_k x - p_k m_2 x) = 0
            double row[11] = {0};
            for (int j = 0; j < 3; j++) row[4 * k + j] = x[j], row[8 + j] = -p[k] * x[j];
            row[4 * k + 3] = 1;
            for (int r = 0; r < 11; r++) {
                c[r] -= row[r] * p[k];
                for (int s = 0; s < 11; s++) a[11 * r + s] += row[r] * row[s];
            }
        }
    }
    for (int r = 0; r < 11; r++) a[12 * r] *= 1 + 1e-12;
    m[11] = 1;
    return ffp_solve_positive(a, c, 11, m);
}

// Leaves out what lies far from where the equations put it.
static void leave_out(const Linear *l, const double m[12]) {
    real *off = ffp_alloc((size_t)l->n + 1, sizeof *off), *sorted = ffp_alloc((size_t)l->n + 1, sizeof *off);
    for (int i = 0; i < l->n; i++) {
        double at[3];
        for (int k = 0; k < 3; k++)
            at[k] = ffp_dot(m + 4 * (size_t)k, l->points + 3 * (size_t)i) + m[4 * k + 3];
        const double *p = l->panel + 2 * (size_t)i;
        off[i] = sorted[i] = (real)fmin(hypot(at[0] / at[2] - p[0], at[1] / at[2] - p[1]), 1e6);
    }
    const double median = (double)ffp_median(sorted, (size_t)l->n);
    for (int i = 0; i < l->n; i++) l->use[i] = (double)off[i] <= FAR * median;
    ffp_free(off), ffp_free(sorted);
}

// Matrix, rotation and place out of a projection (Hartley and Zisserman 2004, section 6.2.4).
static FfpLinearDevice take_apart(const double m[12]) {
    FfpLinearDevice p;
    double r[3][3], across[3], down[3];
    memcpy(r[2], m + 8, sizeof r[2]);
    const double scale = ffp_unit(r[2]);
    p.x = ffp_dot(m, r[2]) / scale, p.y = ffp_dot(m + 4, r[2]) / scale;
    for (int k = 0; k < 3; k++)
        r[0][k] = m[k] / scale - p.x * r[2][k], r[1][k] = m[4 + k] / scale - p.y * r[2][k];
    const double fx = ffp_unit(r[0]), fy = ffp_unit(r[1]);
    p.focal = sqrt(fx * fy);
    ffp_cross(r[2], r[0], down);
    p.mirrored = ffp_dot(down, r[1]) < 0;
    ffp_unit(down);
    ffp_cross(down, r[2], across);
    memcpy(p.pose.r, across, sizeof across), memcpy(p.pose.r + 3, down, sizeof down);
    memcpy(p.pose.r + 6, r[2], sizeof r[2]);
    const double z = 1 / scale;
    p.pose.t[0] = (m[3] - p.x) * z / fx, p.pose.t[1] = (m[7] - p.y) * z / fy, p.pose.t[2] = z;
    return p;
}

// The points' middle goes to 0 and their spread to 1.
static void settle_points(double *points, int n, double middle[3], double *spread) {
    double square = 0;
    memset(middle, 0, 3 * sizeof *middle);
    for (int i = 0; i < 3 * n; i++) middle[i % 3] += points[i] / n;
    for (int i = 0; i < 3 * n; i++) square += pow(points[i] -= middle[i % 3], 2);
    *spread = sqrt(square / n);
    for (int i = 0; i < 3 * n; i++) points[i] /= *spread;
}

bool ffp_projection_find(const double *points, const double *positions, unsigned char *use, int n, int rounds,
                         FfpLinearDevice *projection) {
    double *settled = ffp_alloc((size_t)n + 1, 3 * sizeof *settled), middle[3], spread, m[12] = {0};
    const Linear l = {n, settled, positions, use};
    bool ok = n > 0 && rounds > 0;
    if (ok) memcpy(settled, points, 3 * sizeof *settled * (size_t)n);
    if (ok) settle_points(settled, n, middle, &spread);
    for (int round = 0; ok && round < rounds; round++) {
        ok = solve_linear(&l, m);
        if (ok && round + 1 < rounds) leave_out(&l, m);
    }
    if (ok) {
        *projection = take_apart(m); // of points at (X - middle) / spread
        FfpRigid *pose = &projection->pose;
        for (int k = 0; k < 3; k++)
            pose->t[k] = pose->t[k] * spread - ffp_dot(pose->r + 3 * (size_t)k, middle);
    }
    ffp_free(settled);
    return ok && isfinite(projection->focal);
}

double ffp_off_plane(const double *points, int n) {
    double a[9] = {0}, c[3] = {0}, normal[3];
    double *off = ffp_alloc((size_t)n + 1, sizeof *off);
    for (int i = 0; i < n; i++) { // n . X = 1
        const double *point = points + 3 * (size_t)i;
        for (int r = 0; r < 3; r++) {
            c[r] -= point[r];
            for (int s = 0; s < 3; s++) a[3 * r + s] += point[r] * point[s];
        }
    }
    const bool ok = n > 0 && ffp_solve_positive(a, c, 3, normal);
    for (int i = 0; ok && i < n; i++) off[i] = fabs(ffp_dot(normal, points + 3 * (size_t)i) - 1);
    const double median = ok ? ffp_median(off, (size_t)n) : 0;
    ffp_free(off);
    return median;
}
