#include "rig/turntable/fit_axis.h"
#include <math.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/capture/reduce.h"
#include "core/capture/small.h"
#include "core/numerics/rank.h"
#include "rig/findings/tell.h"
#include "rig/turntable/cloud.h"
#include "rig/turntable/outline.h"
#include "rig/turntable/scan.h"

#define PLACE "turntable.axis"
#define SIDE_MAX 176      // pixels across of the pictures that colours are looked up in
#define CANDIDATES 4      // axes that silhouettes leave
#define SAME 0.998        // cosine between directions of one candidate
#define OUTLINE_MAX 0.04  // of the object's width in the picture: silhouettes that no axis explains
#define OUTLINE_LEAST 0.1 // pixels, of the scale of silhouettes: coverage is not finer
#define FOUND 0.25        // share of the residuals that must be there
#define CHANCE_MAX 0.6 // error at the best distance, as a share of chance: more, and the pattern tells none
#define RIVAL 1.6      // times the least cost of silhouettes: worth looking at
#define LIKELY 1.15    // times the least error: as good
#define NEAR 0.3       // distances tried, in distances between camera and projector
#define FAR 300.0
#define GUESS_OFF 1.4  // factor that a guess may be wrong by
#define ROUNDS 3       // of matching and fitting
#define SHARED 10      // pairs share silhouettes and their errors: so many say as much as one
#define CORRELATED 250 // points share pixels, too
#define PROBE 4        // degrees
#define TILT_MAX 0.5   // degrees of standard deviation
#define SHIFT_MAX 0.01 // of the distance
#define POINTS_LEAST 300

typedef struct Search {
    const FfpCapture *capture; // small
    int active;
    double baseline;
    FfpOutlines outlines;
    double width; // of the object in the picture, pixels
} Search;

typedef struct Candidate {
    FfpAxis axis;
    double cost;
    FfpScan scan;
} Candidate;

// --- What silhouettes say. ---

static FfpAxisTerm outline_term(const Search *search, double scale) {
    return (FfpAxisTerm){
        ffp_outline_residuals, &search->outlines, 2 * search->outlines.n_pairs, scale, 1.0 / SHARED, false};
}

// The object's width, as the angle between outline rays, in pixels: the median of the stops.
static double object_width(const FfpOutlines *outlines) {
    double *widths = ffp_alloc((size_t)outlines->n, sizeof *widths);
    int n = 0; // stops that show any
    for (int s = 0; s < outlines->n; s++) {
        const FfpOutline *o = &outlines->outlines[s];
        widths[n] = 0;
        for (int i = 0; i < o->count; i++) {
            double across[3];
            ffp_cross(o->rays[i], o->centroid, across);
            widths[n] = fmax(widths[n], 2 * outlines->focal * sqrt(ffp_dot(across, across)));
        }
        n += widths[n] > 0;
    }
    const double width = ffp_median(widths, (size_t)n);
    ffp_free(widths);
    return width;
}

// The axis' point beside the object's middle; the whole scaled so that it lies at the distance given (0: as
// it is).
static void settle(const Search *search, FfpAxis *axis, double distance) {
    double centre[3], radius, along = 0;
    ffp_outline_sphere(&search->outlines, axis, centre, &radius);
    for (int i = 0; i < 3; i++) along += (centre[i] - axis->point[i]) * axis->direction[i];
    for (int i = 0; i < 3; i++) axis->point[i] += along * axis->direction[i];
    const double length = sqrt(ffp_dot(axis->point, axis->point));
    for (int i = 0; i < 3 && distance > 0 && length > 0; i++) axis->point[i] *= distance / length;
}

// Coarse to fine; the cost is that of the middle scale, which is the same for all candidates.
static void fit_outlines(const Search *search, Candidate *candidate) {
    FfpAxisTerm term = outline_term(search, 0.06 * search->width);
    ffp_axis_fit(&candidate->axis, 3, &term, 1, 15, NULL);
    term.scale = 0.015 * search->width;
    candidate->cost = ffp_axis_fit(&candidate->axis, 3, &term, 1, 15, NULL);
}

static void polish_outlines(const Search *search, FfpAxis *axis) {
    FfpAxisTerm term = outline_term(search, 1);
    term.scale = fmax(3 * ffp_axis_median(&term, axis, NULL), OUTLINE_LEAST);
    ffp_axis_fit(axis, 3, &term, 1, 20, NULL);
}

// Among the best so far, sorted by cost, unless a better one has its direction.
static void keep(Candidate kept[CANDIDATES], int *count, const Candidate *new) {
    int same = 0;
    while (same < *count && ffp_dot(kept[same].axis.direction, new->axis.direction) < SAME) same++;
    if (same < *count) {
        if (kept[same].cost <= new->cost) return;
        memmove(kept + same, kept + same + 1, (size_t)(--*count - same) * sizeof *kept);
    }
    int at = 0;
    while (at < *count && kept[at].cost <= new->cost) at++;
    if (at == CANDIDATES) return;
    const int behind = (*count < CANDIDATES ? *count : CANDIDATES - 1) - at;
    memmove(kept + at + 1, kept + at, (size_t)behind * sizeof *kept);
    kept[at] = *new;
    *count = *count < CANDIDATES ? *count + 1 : CANDIDATES;
}

// A start for every 30 degrees of roll and 25 of pitch, both ways round.
static int try_directions(const Search *search, Candidate kept[CANDIDATES]) {
    const double degree = acos(-1.0) / 180;
    int count = 0;
    double middle[3] = {0};
    for (int s = 0; s < search->outlines.n; s++)
        for (int i = 0; i < 3; i++) middle[i] += search->outlines.outlines[s].centroid[i];
    ffp_unit(middle);
    for (int k = 0; k < 12 * 5; k++) {
        ffp_cancel_point();
        const double roll = 30 * (k % 12) * degree, pitch = 25 * (k / 12 - 2) * degree;
        Candidate start = {
            .axis = {.direction = {sin(roll) * cos(pitch), -cos(roll) * cos(pitch), sin(pitch)},
                     .point = {middle[0], middle[1], middle[2]}}};
        fit_outlines(search, &start);
        settle(search, &start.axis, 1);
        keep(kept, &count, &start);
    }
    return count;
}

static bool check_outlines(const Search *search, const FfpAxis *axis, FfpError *err) {
    const FfpAxisTerm term = outline_term(search, 1);
    int there = 0;
    const double median = ffp_axis_median(&term, axis, &there);
    if (there < FOUND * term.count) return ffp_refuse(FFP_RULE_OUTLINES_FEW, &(FfpFacts){0}, PLACE, err);
    const double most = OUTLINE_MAX * search->width;
    return median < most ||
           ffp_refuse(FFP_RULE_OUTLINES_NO_AXIS, &(FfpFacts){.figure = median, .limit = most}, PLACE, err);
}

// --- What the pattern says. ---

// The candidate and its distance at which the pattern explains the pictures; of several that it explains
// alike, the one with the best silhouettes.
static bool find_distance(const Search *search, Candidate *candidates, int count, const FfpAxis *guess,
                          Candidate *best, FfpError *err) {
    const double known = guess ? sqrt(ffp_dot(guess->point, guess->point)) : 0;
    const double low = guess ? known / GUESS_OFF : NEAR * search->baseline,
                 high = guess ? known * GUESS_OFF : FAR * search->baseline;
    double least = INFINITY;
    int tried = 0, chosen = 0;
    for (int k = 0; k < count; k++) {
        candidates[k].scan.error = INFINITY;
        if (candidates[k].cost > RIVAL * candidates[0].cost + 0.02) continue;
        polish_outlines(search, &candidates[k].axis);
        settle(search, &candidates[k].axis, 1);
        candidates[k].scan = ffp_scan_distance(search->capture, search->active, &search->outlines,
                                               &candidates[k].axis, low, high);
        tried += candidates[k].scan.tried;
        if (candidates[k].scan.error < least) least = candidates[k].scan.error;
    }
    while (chosen + 1 < count && !(candidates[chosen].scan.error <= LIKELY * least)) chosen++;
    *best = candidates[chosen];
    if (tried == 0) return ffp_refuse(FFP_RULE_PROJECTOR_MISSES, &(FfpFacts){0}, PLACE, err);
    if (best->scan.error > CHANCE_MAX * best->scan.chance)
        return ffp_refuse(FFP_RULE_DISTANCE_OPEN,
                          &(FfpFacts){.x = sqrt(best->scan.error), .y = sqrt(best->scan.chance)}, PLACE, err);
    settle(search, &best->axis, best->scan.factor);
    return true;
}

// All four numbers, from silhouettes and surfaces together.
static void fit_all(const Search *search, FfpAxis *axis, FfpAxisReport *report, double covariance[16]) {
    for (int round = 0; round < ROUNDS; round++) {
        const double distance = sqrt(ffp_dot(axis->point, axis->point));
        FfpClouds clouds = ffp_clouds_new(search->capture, search->active, &search->outlines, axis);
        FfpAxisTerm terms[2] = {outline_term(search, 1),
                                {ffp_cloud_residuals, &clouds, clouds.count, 1, 1.0 / CORRELATED, true}};
        terms[0].scale = fmax(3 * ffp_axis_median(&terms[0], axis, NULL), OUTLINE_LEAST);
        for (int pass = 0; pass < 2; pass++) {
            terms[1].scale =
                fmin(fmax(3 * ffp_axis_median(&terms[1], axis, NULL), 3e-4 * distance), distance);
            ffp_axis_fit(axis, 4, terms, 2, 20, covariance);
        }
        report->outline = ffp_axis_median(&terms[0], axis, NULL);
        report->surface = ffp_axis_median(&terms[1], axis, &report->surface_points) / distance;
        ffp_clouds_free(&clouds);
    }
}

// The fit again from axes tilted by a few degrees: where the pictures do not tell the direction it ends
// elsewhere. The greatest angle between the ends, in degrees.
static double probe(const Search *search, const FfpAxis *axis) {
    const double degree = acos(-1.0) / 180, distance = sqrt(ffp_dot(axis->point, axis->point));
    double worst = 0;
    for (int k = 0; k < 2; k++) {
        const double by[FFP_AXIS_NUMBERS] = {k == 0 ? PROBE * degree : 0, k == 1 ? PROBE * degree : 0};
        Candidate other = {.cost = 1};
        FfpAxisReport unused;
        double covariance[16], across[3];
        ffp_axis_move(axis, by, &other.axis);
        fit_outlines(search, &other);
        polish_outlines(search, &other.axis);
        settle(search, &other.axis, distance);
        fit_all(search, &other.axis, &unused, covariance);
        ffp_cross(axis->direction, other.axis.direction, across);
        worst = fmax(worst, asin(fmin(sqrt(ffp_dot(across, across)), 1)) / degree);
    }
    return worst;
}

static bool check_certain(const Search *search, const FfpAxis *axis, FfpAxisReport *report,
                          const double covariance[16], FfpError *err) {
    const double a = covariance[0], b = covariance[5], c = covariance[1];
    report->tilt = fmax(sqrt((a + b) / 2 + hypot((a - b) / 2, c)) * 180 / acos(-1.0), probe(search, axis));
    report->shift = sqrt(fmax(covariance[10], covariance[15]));
    if (report->surface_points < POINTS_LEAST)
        return ffp_refuse(FFP_RULE_SURFACE_POINTS, &(FfpFacts){.x = report->surface_points}, PLACE, err);
    return (report->tilt < TILT_MAX && report->shift < SHIFT_MAX) ||
           ffp_refuse(FFP_RULE_AXIS_OPEN,
                      &(FfpFacts){.figure = report->tilt, .limit = TILT_MAX, .x = 100 * report->shift}, PLACE,
                      err);
}

static bool check_angles(const double *angles, int n, FfpError *err) {
    int different = 0;
    for (int i = 0; i < n; i++) {
        bool again = false;
        for (int k = 0; k < i; k++) again = again || fabs(remainder(angles[i] - angles[k], 360)) < 1;
        different += !again;
    }
    return different >= 3 ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, PLACE,
                    "at least three different angles are needed, but only %d given", different);
}

// Up in the picture, or along the guess.
static void orient(FfpAxis *axis, const FfpAxis *guess, FfpAxisReport *report) {
    static const double up[3] = {0, -1, 0};
    report->reversed = ffp_dot(axis->direction, guess ? guess->direction : up) < 0;
    for (int i = 0; i < 3 && report->reversed; i++) axis->direction[i] = -axis->direction[i];
}

static bool search_axis(Search *search, FfpAxis *axis, FfpAxisReport *report, const FfpAxis *guess,
                        FfpError *err) {
    Candidate candidates[CANDIDATES] = {{.cost = 1}}, best;
    double covariance[16];
    int count = 1;
    if (guess) {
        candidates[0].axis = *guess;
        ffp_unit(candidates[0].axis.direction);
        fit_outlines(search, &candidates[0]);
    } else {
        count = try_directions(search, candidates);
    }
    if (!check_outlines(search, &candidates[0].axis, err) ||
        !find_distance(search, candidates, count, guess, &best, err))
        return false;
    *axis = best.axis;
    report->error = sqrt(best.scan.error), report->chance = sqrt(best.scan.chance);
    fit_all(search, axis, report, covariance);
    settle(search, axis, 0);
    const bool ok = check_certain(search, axis, report, covariance, err);
    orient(axis, guess, report);
    return ok;
}

bool ffp_fit_axis(FfpAxis *axis, FfpAxisReport *report, const FfpCapture *capture, int active,
                  const double p2c[16], const double *angles, const FfpAxis *guess, FfpError *err) {
    *report = (FfpAxisReport){.stops = capture->n_views};
    const double baseline = sqrt(p2c[3] * p2c[3] + p2c[7] * p2c[7] + p2c[11] * p2c[11]);
    if (!check_angles(angles, capture->n_views, err)) return false;
    if (!(baseline > 0))
        return ffp_fail(err, FFP_ERROR_FILE, "T",
                        "camera and projector are in the same place, so no distance can be measured and no "
                        "axis found");
    if (guess && !(ffp_dot(guess->point, guess->point) > 0))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, PLACE, "the initial axis passes through the camera");
    double *radians = ffp_alloc((size_t)capture->n_views, sizeof *radians);
    for (int v = 0; v < capture->n_views; v++) radians[v] = angles[v] * acos(-1.0) / 180;
    FfpCapture small = ffp_small_new(capture, active);
    for (int v = 0; v < small.n_views; v++)
        for (int i = 0; i < 16; i++) small.views[v].projector.pose[i] = (real)p2c[i];
    Search search = {.capture = &small, .active = active, .outlines = ffp_outlines_new(capture, radians)};
    search.baseline = baseline;
    search.width = object_width(&search.outlines);
    const bool ok = search_axis(&search, axis, report, guess, err);
    ffp_outlines_free(&search.outlines);
    ffp_capture_reduced_free(&small);
    ffp_free(radians);
    return ok;
}
