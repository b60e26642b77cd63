#include "core/gaussians/affine.h"
#include <math.h>
#include <string.h>
#include "core/base/rigid.h"

enum { SWEEPS = 12 };

FfpAffine ffp_affine_product(const FfpAffine *after, const FfpAffine *before) {
    FfpAffine out;
    for (int i = 0; i < 3; i++) {
        out.t[i] = after->t[i];
        for (int k = 0; k < 3; k++) out.t[i] += after->a[3 * i + k] * before->t[k];
        for (int j = 0; j < 3; j++) {
            out.a[3 * i + j] = 0;
            for (int k = 0; k < 3; k++) out.a[3 * i + j] += after->a[3 * i + k] * before->a[3 * k + j];
        }
    }
    return out;
}

void ffp_affine_rotation(const double q[4], double r[9]) {
    const double n = 2 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]), w = q[0], x = q[1],
                 y = q[2], z = q[3];
    const double rows[9] = {1 - n * (y * y + z * z), n * (x * y - w * z),     n * (x * z + w * y),
                            n * (x * y + w * z),     1 - n * (x * x + z * z), n * (y * z - w * x),
                            n * (x * z - w * y),     n * (y * z + w * x),     1 - n * (x * x + y * y)};
    memcpy(r, rows, sizeof rows);
}

// The columns of b become orthogonal by turns from the right, which do not change b b^T: one-sided Jacobi
// (Hestenes 1958), whose small columns are as exact as its large ones.
static void make_orthogonal(double b[9]) {
    for (int sweep = 0; sweep < SWEEPS; sweep++)
        for (int p = 0; p < 2; p++)
            for (int q = p + 1; q < 3; q++) {
                double pp = 0, qq = 0, pq = 0;
                for (int i = 0; i < 3; i++) {
                    pp += b[3 * i + p] * b[3 * i + p];
                    qq += b[3 * i + q] * b[3 * i + q];
                    pq += b[3 * i + p] * b[3 * i + q];
                }
                if (fabs(pq) <= 1e-15 * sqrt(pp * qq) || pq == 0) continue;
                const double zeta = (qq - pp) / (2 * pq),
                             t = copysign(1, zeta) / (fabs(zeta) + sqrt(1 + zeta * zeta)),
                             c = 1 / sqrt(1 + t * t), s = c * t;
                for (int i = 0; i < 3; i++) {
                    const double u = b[3 * i + p], v = b[3 * i + q];
                    b[3 * i + p] = c * u - s * v;
                    b[3 * i + q] = s * u + c * v;
                }
            }
}

static void cross_column(double r[9], int to, int from, int other) {
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        r[3 * i + to] = r[3 * j + from] * r[3 * k + other] - r[3 * k + from] * r[3 * j + other];
    }
}

// Unit columns from orthogonal ones, right-handed; a column that vanished is what the others leave. False:
// two of them did.
static bool take_lengths(double b[9], double lengths[3]) {
    double most = 0;
    int gone = -1;
    for (int k = 0; k < 3; k++) {
        lengths[k] = sqrt(b[k] * b[k] + b[3 + k] * b[3 + k] + b[6 + k] * b[6 + k]);
        most = fmax(most, lengths[k]);
    }
    for (int k = 0; k < 3; k++) {
        if (!(lengths[k] > 1e-12 * most)) {
            if (gone >= 0) return false;
            gone = k;
            lengths[k] = 0;
        }
        for (int i = 0; i < 3 && lengths[k] > 0; i++) b[3 * i + k] /= lengths[k];
    }
    if (gone < 0) gone = 2; // only its sign may change
    cross_column(b, gone, (gone + 1) % 3, (gone + 2) % 3);
    return true;
}

void ffp_affine_move(const FfpAffine *affine, float row[FFP_ROW_NUMBERS]) {
    double q[4], r[9], b[9], lengths[3];
    float *at = row + FFP_ROW_POSITION, *scale = row + FFP_ROW_SCALE, *turn = row + FFP_ROW_ROTATION;
    const double from[3] = {(double)at[0], (double)at[1], (double)at[2]};
    for (int i = 0; i < 3; i++)
        at[i] = (float)(affine->a[3 * i] * from[0] + affine->a[3 * i + 1] * from[1] +
                        affine->a[3 * i + 2] * from[2] + affine->t[i]);
    for (int k = 0; k < 4; k++) q[k] = (double)turn[k];
    ffp_affine_rotation(q, r);
    double sum = 0;
    for (int i = 0; i < 9; i++) {
        b[i] = 0;
        for (int k = 0; k < 3; k++) b[i] += affine->a[3 * (i / 3) + k] * r[3 * k + i % 3];
        b[i] *= exp((double)scale[i % 3]);
        sum += b[i];
    }
    if (!isfinite(sum)) return;
    make_orthogonal(b);
    if (!take_lengths(b, lengths)) {
        for (int k = 0; k < 3; k++) scale[k] = -INFINITY; // a line or a point: no splat
        return;
    }
    for (int k = 0; k < 3; k++) scale[k] = (float)log(lengths[k]);
    ffp_rotation_to_quaternion(b, q);
    for (int k = 0; k < 4; k++) turn[k] = (float)q[k];
}
