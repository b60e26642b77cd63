#include "core/numerics/resection.h"
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/rng.h"
#include "core/numerics/least_squares.h"
#include "core/numerics/projection.h"
#include "core/numerics/rank.h"

enum { LEAST = 60, SAMPLE = 8, TRIES = 400, TRIED = 500 }; // points; of a sample; samples; points they meet
enum { PRIORS = FFP_RESECTED - FFP_RESECTED_FOCAL, ROUNDS = 4, STEPS = 60, PARTS = 4 }; // PARTS: a side
#define WORTH 1e-10
#define BEHIND 1e3       // pixels: the distance of what is behind the device
#define OUTLIER 3.0      // deviations
#define NOISE_LEAST 0.05 // pixels
#define TELL 400.0       // points that tell as much as all of a surface, since neighbours share their errors
#define FITTING 0.5      // share of the points that must fit
#define OFF_MOST 8.0     // pixels, or
#define OFF_SHARE 0.01   // of the panel's width: the median distance of a device that fits
#define PLANE 0.004      // the share of the distance by which half of the points must leave every plane

// Deviations that are usual among projectors: of the logarithm of the focal length, the principal point
// (shares of the width; shifted lenses) and the aspect.
static const double usual[PRIORS] = {0.8, 0.03, 0.5, 0.002};

typedef struct Device {
    FfpRigid pose; // points to device
    double
        lens[PRIORS]; // log of the focal length in widths, principal point from the middle in widths, aspect
} Device;

typedef struct Fit {
    const double *points, *pixels; // [n,3], [n,2]
    const unsigned char *left_out; // [n]; NULL: none
    int n, width, height;
    double noise; // pixels
    Device device;
} Fit;

static Device moved(const Device *from, const double by[FFP_RESECTED]) {
    Device to = *from;
    double turn[9];
    const double back[3] = {-by[0], -by[1], -by[2]};
    ffp_rotation_from_vector(back, turn); // of the points, as the device turns
    ffp_rotation_product(turn, from->pose.r, to.pose.r);
    for (int k = 0; k < 3; k++)
        to.pose.t[k] = ffp_dot(turn + 3 * (size_t)k, from->pose.t) - by[FFP_RESECTED_PLACE + k];
    for (int k = 0; k < PRIORS; k++) to.lens[k] += by[FFP_RESECTED_FOCAL + k];
    return to;
}

// The pixel of a point; false: behind the device.
static bool pixel_of(const Fit *fit, const Device *d, const double point[3], double at[2]) {
    double local[3];
    for (int k = 0; k < 3; k++) local[k] = ffp_dot(d->pose.r + 3 * (size_t)k, point) + d->pose.t[k];
    if (!(local[2] > 0)) return false;
    const double focal = exp(d->lens[0]) * fit->width;
    at[0] = (0.5 + d->lens[1]) * fit->width + focal * (1 - 0.5 * d->lens[3]) * local[0] / local[2];
    at[1] =
        0.5 * fit->height + d->lens[2] * fit->width + focal * (1 + 0.5 * d->lens[3]) * local[1] / local[2];
    return true;
}

// Distances from pixels, in both directions, and from what is usual, each in its deviation.
static void differences(const void *state, const double *by, double *out) {
    const Fit *fit = state;
    const Device device = moved(&fit->device, by);
    double at[2];
    for (int i = 0; i < fit->n; i++) {
        const bool there = pixel_of(fit, &device, fit->points + 3 * (size_t)i, at);
        for (int k = 0; k < 2; k++)
            out[2 * i + k] = there ? (at[k] - fit->pixels[2 * (size_t)i + (size_t)k]) / fit->noise : BEHIND;
    }
    for (int k = 0; k < PRIORS; k++)
        out[2 * fit->n + k] = (device.lens[k] - (k == 0 ? log(FFP_USUAL_FOCAL) : 0)) / usual[k];
}

static void move(void *state, const double *by) {
    Fit *fit = state;
    fit->device = moved(&fit->device, by);
}

// The function of Geman and McClure, of both directions together.
static double weigh(const void *state, const double *found, double *weights) {
    const Fit *fit = state;
    const double count = fmin(1, TELL / fit->n), reach = OUTLIER * OUTLIER;
    double sum = 0;
    for (int i = 0; i < fit->n; i++) {
        const double square = (found[2 * i] * found[2 * i] + found[2 * i + 1] * found[2 * i + 1]) / reach;
        const bool counts = !fit->left_out || !fit->left_out[i];
        weights[2 * i] = weights[2 * i + 1] = counts ? count / ((1 + square) * (1 + square)) : 0;
        if (counts) sum += count * reach * square / (1 + square);
    }
    for (int k = 2 * fit->n; k < 2 * fit->n + PRIORS; k++) weights[k] = 1, sum += found[k] * found[k];
    return sum;
}

static void descend(Fit *fit, double *covariance) {
    static const double step[FFP_RESECTED] = {1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5};
    const FfpLeastSquares problem = {.state = fit,
                                     .numbers = FFP_RESECTED,
                                     .count = 2 * fit->n + PRIORS,
                                     .differences = differences,
                                     .move = move,
                                     .weigh = weigh,
                                     .step = step,
                                     .steps = STEPS,
                                     .worth = WORTH};
    ffp_least_squares(&problem, covariance);
}

// Distances of all points from their pixels, at most BEHIND, into off [n]; returns their median.
static double distances(const Fit *fit, double *off) {
    double *sorted = ffp_alloc((size_t)fit->n, sizeof *sorted), at[2];
    for (int i = 0; i < fit->n; i++) {
        const double *pixel = fit->pixels + 2 * (size_t)i;
        const bool there = pixel_of(fit, &fit->device, fit->points + 3 * (size_t)i, at);
        off[i] = sorted[i] = there ? fmin(BEHIND, hypot(at[0] - pixel[0], at[1] - pixel[1])) : BEHIND;
    }
    const double median = ffp_median(sorted, (size_t)fit->n);
    ffp_free(sorted);
    return median;
}

// --- The start. ---

static Device device_of(const FfpLinearDevice *p) {
    return (Device){
        p->pose,
        {log(fmax(0.3, fmin(20, p->focal))), fmax(-0.2, fmin(0.2, p->x)), fmax(-1, fmin(1, p->y)), 0}};
}

// Some of the points, evenly chosen, and their positions in widths around the panel's middle.
static Fit some_of(const Fit *fit, double *points, double *pixels, double *positions) {
    Fit some = *fit;
    some.points = points, some.pixels = pixels;
    some.n = fit->n < TRIED ? fit->n : TRIED;
    for (int i = 0; i < some.n; i++) {
        const size_t from = (size_t)i * (size_t)fit->n / (size_t)some.n;
        memcpy(points + 3 * (size_t)i, fit->points + 3 * from, 3 * sizeof *points);
        memcpy(pixels + 2 * (size_t)i, fit->pixels + 2 * from, 2 * sizeof *pixels);
        positions[2 * (size_t)i] = pixels[2 * (size_t)i] / fit->width - 0.5;
        positions[2 * (size_t)i + 1] = (pixels[2 * (size_t)i + 1] - 0.5 * fit->height) / fit->width;
    }
    return some;
}

// The sample's device, and the one of all that it fits.
static void try_sample(Fit *some, const double *positions, FfpRng *rng, double *least, Device *best) {
    double *off = ffp_alloc((size_t)some->n, sizeof *off);
    unsigned char *use = ffp_alloc((size_t)some->n, 1);
    FfpLinearDevice projection;
    for (int k = 0; k < SAMPLE; k++) use[ffp_rng_below(rng, (uint32_t)some->n)] = 1;
    for (int pass = 0; pass < 2; pass++) {
        if (!ffp_projection_find(some->points, positions, use, some->n, 1 + 2 * pass, &projection)) break;
        some->device = device_of(&projection);
        const double median = distances(some, off);
        if (median > 2 * *least) break;
        if (median < *least) *least = median, *best = some->device;
        for (int i = 0; i < some->n; i++) use[i] = off[i] <= 4 * median;
    }
    ffp_free(off), ffp_free(use);
}

// The least median distance; as it were seen in a mirror, if that is asked for.
static double search(const Fit *fit, bool mirror, Device *best) {
    double *points = ffp_alloc(TRIED, 3 * sizeof *points), *pixels = ffp_alloc(TRIED, 2 * sizeof *pixels),
           *positions = ffp_alloc(TRIED, 2 * sizeof *positions), least = BEHIND;
    Fit some = some_of(fit, points, pixels, positions);
    FfpRng rng = ffp_rng(1, 0);
    for (int i = 0; mirror && i < some.n; i++) {
        pixels[2 * (size_t)i] = fit->width - pixels[2 * (size_t)i];
        positions[2 * (size_t)i] *= -1;
    }
    for (int i = 0; i < TRIES; i++) {
        try_sample(&some, positions, &rng, &least, best);
        ffp_cancel_point();
    }
    ffp_free(points), ffp_free(pixels), ffp_free(positions);
    return least;
}

static double most_off(const Fit *fit) {
    return fmax(OFF_MOST, OFF_SHARE * fit->width);
}

static bool start(Fit *fit, FfpError *err) {
    Device other;
    const double least = search(fit, false, &fit->device);
    fit->noise = fmax(NOISE_LEAST, least);
    if (least > most_off(fit) && search(fit, true, &other) < least / 2)
        return ffp_fail(err, FFP_ERROR_FILE, NULL,
                        "the codes show a mirror image: the pictures or the codes are mirrored");
    return least < BEHIND || ffp_fail(err, FFP_ERROR_FILE, NULL,
                                      "the %d points lie on one plane, or no device has them where the codes "
                                      "do",
                                      fit->n);
}

// --- The fit. ---

static bool check_plane(const Fit *fit, FfpError *err) {
    double *local = ffp_alloc((size_t)fit->n, 3 * sizeof *local);
    const FfpRigid *pose = &fit->device.pose;
    for (int i = 0; i < 3 * fit->n; i++)
        local[i] = ffp_dot(pose->r + (size_t)3 * (size_t)(i % 3), fit->points + (size_t)3 * (size_t)(i / 3)) +
                   pose->t[i % 3];
    const double off = ffp_off_plane(local, fit->n);
    ffp_free(local);
    return off > PLANE ||
           ffp_fail(err, FFP_ERROR_FILE, NULL,
                    "all points lie on one plane, before which a device's place and focal length cannot be "
                    "told apart: light more of the object, or another side of it");
}

// From coarse to fine: the noise is what the last round leaves.
static bool settle(Fit *fit, FfpError *err) {
    double *off = ffp_alloc((size_t)fit->n, sizeof *off), median = BEHIND;
    for (int round = 0; round < ROUNDS; round++) {
        descend(fit, NULL);
        median = distances(fit, off);
        fit->noise = fmax(NOISE_LEAST, median / 1.18); // of a distance in two directions, Rayleigh's
    }
    int fitting = 0;
    for (int i = 0; i < fit->n; i++) fitting += off[i] < fmin(OUTLIER * fit->noise, most_off(fit));
    ffp_free(off);
    return (median < most_off(fit) && fitting >= FITTING * fit->n) ||
           ffp_fail(err, FFP_ERROR_FILE, NULL,
                    "%d of %d points lie where one device has them (half of them "
                    "are %.1f pixels off): something moved, or the codes are of another order",
                    fitting, fit->n, median);
}

// --- Deviations. ---

// The numbers by which one device becomes another.
static void numbers_between(const Device *from, const Device *to, double by[FFP_RESECTED]) {
    double turn[9], vector[3];
    for (int i = 0; i < 9; i++) // to = turn from
        turn[i] =
            ffp_dot(to->pose.r + (size_t)3 * (size_t)(i / 3), from->pose.r + (size_t)3 * (size_t)(i % 3));
    ffp_rotation_to_vector(turn, vector);
    for (int k = 0; k < 3; k++) {
        by[k] = -vector[k];
        by[FFP_RESECTED_PLACE + k] = ffp_dot(turn + 3 * (size_t)k, from->pose.t) - to->pose.t[k];
    }
    for (int k = 0; k < PRIORS; k++) by[FFP_RESECTED_FOCAL + k] = to->lens[k] - from->lens[k];
}

// Which of PARTS x PARTS parts of the points' part of the panel each lies in, [n].
static void find_parts(const Fit *fit, unsigned char *part) {
    double ends[2][PARTS + 1], *sorted = ffp_alloc((size_t)fit->n, sizeof *sorted);
    for (int axis = 0; axis < 2; axis++)
        for (int q = 1; q < PARTS; q++) {
            for (int i = 0; i < fit->n; i++) sorted[i] = fit->pixels[2 * (size_t)i + (size_t)axis];
            ends[axis][q] = ffp_quantile(sorted, (size_t)fit->n, (double)q / PARTS);
        }
    for (int i = 0; i < fit->n; i++) {
        int cell[2] = {0, 0};
        for (int axis = 0; axis < 2; axis++)
            while (cell[axis] + 1 < PARTS &&
                   fit->pixels[2 * (size_t)i + (size_t)axis] > ends[axis][cell[axis] + 1])
                cell[axis]++;
        part[i] = (unsigned char)(cell[1] * PARTS + cell[0]);
    }
    ffp_free(sorted);
}

static void find_deviations(const Fit *fit, double deviation[FFP_RESECTED]) {
    double results[PARTS * PARTS][FFP_RESECTED], covariance[FFP_RESECTED * FFP_RESECTED];
    unsigned char *part = ffp_alloc((size_t)fit->n, 1), *left_out = ffp_alloc((size_t)fit->n, 1);
    Fit other = *fit;
    int parts = 0;
    descend(&other, covariance);
    find_parts(fit, part);
    for (int p = 0; p < PARTS * PARTS; p++) {
        int count = 0;
        for (int i = 0; i < fit->n; i++) count += left_out[i] = part[i] == p;
        if (count == 0) continue;
        other = *fit, other.left_out = left_out;
        descend(&other, NULL);
        numbers_between(&fit->device, &other.device, results[parts++]);
    }
    for (int k = 0; k < FFP_RESECTED; k++) {
        double mean = 0, square = 0;
        for (int p = 0; p < parts; p++) mean += results[p][k] / parts;
        for (int p = 0; p < parts; p++) square += (results[p][k] - mean) * (results[p][k] - mean);
        deviation[k] = sqrt(fmax(square * (parts - 1) / fmax(1, parts), covariance[(FFP_RESECTED + 1) * k]));
    }
    ffp_free(part), ffp_free(left_out);
}

static void tell(const Fit *fit, FfpResection *r) {
    const double *lens = fit->device.lens, focal = exp(lens[0]) * fit->width;
    double *off = ffp_alloc((size_t)fit->n, sizeof *off), square = 0;
    r->pose = fit->device.pose;
    r->fx = focal * (1 - 0.5 * lens[3]), r->fy = focal * (1 + 0.5 * lens[3]);
    r->x = (0.5 + lens[1]) * fit->width, r->y = 0.5 * fit->height + lens[2] * fit->width;
    r->median = distances(fit, off), r->used = 0;
    for (int i = 0; i < fit->n; i++)
        if (off[i] < OUTLIER * fit->noise) square += off[i] * off[i], r->used++;
    r->rms = sqrt(square / fmax(1, r->used));
    ffp_free(off);
}

bool ffp_resect(const double *points, const double *pixels, int n, int width, int height,
                FfpResection *resection, FfpError *err) {
    Fit fit = {.points = points, .pixels = pixels, .n = n, .width = width, .height = height};
    if (n < LEAST)
        return ffp_fail(err, FFP_ERROR_FILE, NULL,
                        "%d points are known both on the object and on the panel; %d are the least", n,
                        LEAST);
    if (!start(&fit, err) || !check_plane(&fit, err) || !settle(&fit, err)) return false;
    find_deviations(&fit, resection->deviation);
    tell(&fit, resection);
    return true;
}
