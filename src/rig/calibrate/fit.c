#include "rig/calibrate/fit.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/log.h"
#include "core/base/rigid.h"
#include "core/numerics/rank.h"
#include "rig/calibrate/notes.h"
#include "rig/calibrate/pose.h"
#include "rig/import/lens.h"

#define CORNER_FAR 5        // times the deviation on an axis: Gauss passes it once in 270,000
#define CORNER_LEAST 0.25   // pixels: nothing nearer is out of line
#define ATTITUDE_FAR 3      // times the median of the attitudes' root mean squares
#define ATTITUDE_LEAST 0.75 // pixels
#define CORNERS_LEAST 0.3   // share of the board's corners that an attitude must keep
#define PARALLEL 3          // degrees between the boards farthest from parallel
#define FOCAL_OPEN 0.1      // share of the focal length by which it may be uncertain
#define FOCAL_VAGUE 0.02    // and where that is worth a warning
#define OPEN_PIXELS 1.0     // at the corner of the picture: a lens term no better known than that
#define GUESS_FOCAL 1.2     // of the picture's longer side: to see whether boards are parallel
enum { ROUNDS = 12 };       // in which corners change and no attitude falls out

const char *const ffp_term_names[FFP_TERMS] = {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
static const char *const device_names[2] = {"camera", "projector"};

double ffp_term(const FfpCvDevice *device, int term) {
    static const int places[4] = {0, 4, 2, 5};
    return term < 4 ? device->matrix[places[term]] : device->lens[term - 4];
}

double ffp_term_reach(const FfpCvDevice *device, int term) {
    static const int powers[FFP_TERMS] = {0, 0, 0, 0, 3, 5, 2, 2, 7};
    const double *m = device->matrix;
    const double x = fmax(m[2], device->width - 1 - m[2]) / m[0],
                 y = fmax(m[5], device->height - 1 - m[5]) / m[4];
    if (term < 4) return 0;
    return fmax(m[0], m[4]) * pow(hypot(x, y), powers[term]) * (term == 6 || term == 7 ? 3 : 1);
}

bool ffp_term_open(const FfpCvDevice *device, int term) {
    const double deviation = device->deviation[term];
    return deviation > 0.5 * fabs(ffp_term(device, term)) &&
           deviation * ffp_term_reach(device, term) > OPEN_PIXELS;
}

int ffp_attitudes_used(const FfpRigFit *fit) {
    int n = 0;
    for (int i = 0; i < fit->n; i++) n += fit->attitudes[i].problem[0] == 0;
    return n;
}

// --- The corners as OpenCV's. ---

typedef struct Views {
    FfpCvViews cv;
    int *counts;
    double *board, *points[2];
    int *attitude; // [cv.n] which
} Views;

static Views new_views(const FfpRigFit *fit) {
    size_t corners = 1;
    for (int i = 0; i < fit->n; i++) corners += (size_t)fit->attitudes[i].n;
    Views v = {.counts = ffp_alloc((size_t)fit->n, sizeof(int)),
               .attitude = ffp_alloc((size_t)fit->n, sizeof(int)),
               .board = ffp_alloc(corners, 3 * sizeof(double))};
    for (int k = 0; k < 2; k++) v.points[k] = ffp_alloc(corners, 2 * sizeof(double));
    return v;
}

static void free_views(Views *v) {
    ffp_free(v->counts), ffp_free(v->attitude), ffp_free(v->board);
    ffp_free(v->points[0]), ffp_free(v->points[1]);
}

static bool is_used(const FfpAttitude *a, int corner, unsigned devices) {
    return (!(devices & 1U) || a->camera_state[corner] == FFP_CORNER_USED) &&
           (!(devices & 2U) || a->projector_state[corner] == FFP_CORNER_USED);
}

// Corners that every one of the devices (1 camera, 2 projector, 3 both) has.
static void fill_views(const FfpRigFit *fit, unsigned devices, Views *v) {
    int sum = 0;
    v->cv = (FfpCvViews){.counts = v->counts, .board = v->board};
    v->cv.first = v->points[devices == 2 ? 1 : 0], v->cv.second = v->points[1];
    for (int i = 0; i < fit->n; i++) {
        const FfpAttitude *a = &fit->attitudes[i];
        if (a->problem[0]) continue;
        const int before = sum;
        for (int k = 0; k < a->n; k++) {
            if (!is_used(a, k, devices)) continue;
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

// --- Attitudes that cannot serve. ---

static bool too_few(const FfpRigFit *fit, FfpError *err) {
    char why[640];
    ffp_list_problems(fit, why, sizeof why);
    return ffp_fail(err, FFP_ERROR_FILE, NULL,
                    "%d of %d attitudes of the board can be used, but %d are needed%s",
                    ffp_attitudes_used(fit), fit->n, FFP_FIT_ATTITUDES_LEAST, why);
}

static bool enough(const FfpRigFit *fit, FfpError *err) {
    return ffp_attitudes_used(fit) >= FFP_FIT_ATTITUDES_LEAST || too_few(fit, err);
}

static void leave_out(FfpAttitude *a, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void leave_out(FfpAttitude *a, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(a->problem, sizeof a->problem, format, arguments);
    va_end(arguments);
}

static void check_counts(FfpRigFit *fit) {
    for (int i = 0; i < fit->n; i++) {
        FfpAttitude *a = &fit->attitudes[i];
        int kept = 0;
        if (a->problem[0]) continue;
        for (int k = 0; k < a->n; k++) kept += is_used(a, k, 3);
        if (kept < CORNERS_LEAST * a->n || kept < 8)
            leave_out(a, "only %d of %d corners are good enough", kept, a->n);
    }
}

// The normal of a board as a pinhole of a guessed focal length sees it. Boards that are parallel in truth
// have the same normals at any focal length, since these are those of their common horizon.
static bool normal_of(const FfpRigFit *fit, const FfpAttitude *a, double normal[3], FfpError *err) {
    const FfpCvDevice *camera = &fit->devices[0];
    const double focal = GUESS_FOCAL * fmax(camera->width, camera->height);
    double *flat = ffp_alloc((size_t)a->n, 2 * sizeof *flat), h[9];
    unsigned char *inside = ffp_alloc((size_t)a->n, 1);
    bool found;
    for (int i = 0; i < a->n; i++)
        flat[2 * i] = ffp_corner_column(&fit->board, i), flat[2 * i + 1] = ffp_corner_row(&fit->board, i);
    const bool ok = ffp_cv_homography(flat, a->camera, a->n, 5, h, inside, &found, err);
    ffp_free(flat), ffp_free(inside);
    normal[0] = normal[1] = 0, normal[2] = 1;
    if (!ok || !found) return ok;
    double columns[2][3];
    for (int k = 0; k < 2; k++) {
        columns[k][0] = (h[k] - 0.5 * camera->width * h[6 + k]) / focal;
        columns[k][1] = (h[3 + k] - 0.5 * camera->height * h[6 + k]) / focal;
        columns[k][2] = h[6 + k];
    }
    ffp_cross(columns[0], columns[1], normal);
    ffp_unit(normal);
    return true;
}

static bool check_parallel(FfpRigFit *fit, FfpError *err) {
    double(*normals)[3] = ffp_alloc((size_t)fit->n, sizeof *normals), widest = 0;
    bool ok = true;
    int n = 0;
    for (int i = 0; ok && i < fit->n; i++)
        if (!fit->attitudes[i].problem[0]) ok = normal_of(fit, &fit->attitudes[i], normals[n++], err);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < i; k++)
            widest = fmax(widest, acos(fmin(1, fabs(ffp_dot(normals[i], normals[k])))) * 180 / FFP_PI_DOUBLE);
    ffp_free(normals);
    return ok &&
           (widest > PARALLEL ||
            ffp_fail(err, FFP_ERROR_FILE, NULL,
                     "the board is parallel in all attitudes (within %.1f degrees), which leaves the focal "
                     "lengths undetermined: tilt it by 20 to 40 degrees, in a different direction each time",
                     widest));
}

// --- What is out of line. ---

// Where a device with the board in its pose sees a corner.
static void project(const FfpCvDevice *device, const double pose[6], const double point[3], double out[2]) {
    double r[9], x[3], u, v;
    ffp_rotation_from_vector(pose, r);
    for (int i = 0; i < 3; i++) x[i] = ffp_dot(r + 3 * i, point) + pose[3 + i];
    ffp_lens_distort(device->lens, x[0] / x[2], x[1] / x[2], &u, &v);
    out[0] = device->matrix[0] * u + device->matrix[2], out[1] = device->matrix[4] * v + device->matrix[5];
}

static void corner_offsets(const FfpRigFit *fit, int which, const Views *views, const double *poses) {
    for (int v = 0; v < views->cv.n; v++) {
        FfpAttitude *a = &fit->attitudes[views->attitude[v]];
        double *off = which == 0 ? a->camera_off : a->projector_off, square = 0, at[2];
        const double *seen = which == 0 ? a->camera : a->projector;
        int n = 0;
        for (int i = 0; i < a->n; i++) {
            const double point[3] = {ffp_corner_column(&fit->board, i) * fit->board.square,
                                     ffp_corner_row(&fit->board, i) * fit->board.square, 0};
            project(&fit->devices[which], poses + 6 * (size_t)v, point, at);
            for (int k = 0; k < 2; k++) off[2 * i + k] = seen[2 * i + k] - at[k];
            if (!is_used(a, i, 1U << which)) continue;
            square += off[2 * i] * off[2 * i] + off[2 * i + 1] * off[2 * i + 1], n++;
        }
        *(which == 0 ? &a->camera_rms : &a->projector_rms) = sqrt(square / fmax(1, n));
    }
}

// Whether a corner has a place in the device's fit, or had one until it fell out.
static bool is_judged(unsigned char state) {
    return state == FFP_CORNER_USED || state == FFP_CORNER_FAR;
}

// Corners farther off than the spread of those used explains fall out, and come back when a later fit, no
// longer drawn aside by worse ones, puts them into line. Returns how many changed.
static int judge_corners(const FfpRigFit *fit, int which, const Views *views) {
    int total = 1, n = 0, changed = 0;
    for (int v = 0; v < views->cv.n; v++) total += views->counts[v];
    double *lengths = ffp_alloc((size_t)total, sizeof *lengths), limit = 0;
    for (int pass = 0; pass < 2; pass++) {
        // The median length of offsets with deviation s on both axes is 1.177 s (Rayleigh's distribution).
        if (pass == 1) limit = fmax(CORNER_LEAST, CORNER_FAR * ffp_median(lengths, (size_t)n) / 1.1774);
        for (int v = 0; v < views->cv.n; v++) {
            const FfpAttitude *a = &fit->attitudes[views->attitude[v]];
            const double *off = which == 0 ? a->camera_off : a->projector_off;
            unsigned char *states = which == 0 ? a->camera_state : a->projector_state;
            for (int i = 0; i < a->n; i++) {
                const double length = hypot(off[2 * i], off[2 * i + 1]);
                if (pass == 0 && states[i] == FFP_CORNER_USED) lengths[n++] = length;
                if (pass == 0 || !is_judged(states[i])) continue;
                const unsigned char state = length > limit ? FFP_CORNER_FAR : FFP_CORNER_USED;
                changed += state != states[i];
                states[i] = state;
            }
        }
    }
    ffp_free(lengths);
    return changed;
}

// The attitude farthest out of line, if one is: root mean squares `rms` of the attitudes used, in order,
// every `stride`.
static bool drop_attitude(const FfpRigFit *fit, const Views *views, const double *rms, int stride,
                          const char *of) {
    double *sorted = ffp_alloc((size_t)views->cv.n, sizeof *sorted);
    int worst = 0;
    for (int v = 0; v < views->cv.n; v++) {
        sorted[v] = rms[(size_t)stride * (size_t)v];
        if (sorted[v] > rms[(size_t)stride * (size_t)worst]) worst = v;
    }
    const double middle = ffp_median(sorted, (size_t)views->cv.n), most = rms[(size_t)stride * (size_t)worst];
    ffp_free(sorted);
    if (most <= fmax(ATTITUDE_LEAST, ATTITUDE_FAR * middle)) return false;
    leave_out(
        &fit->attitudes[views->attitude[worst]],
        "its corners are %.2f pixels (rms) away from %s, those of others typically %.2f: the board or a "
        "device moved, or a photograph is out of order",
        most, of, middle);
    return true;
}

// --- Fitting. ---

static bool fit_device(FfpRigFit *fit, int which, bool *changed, FfpError *err) {
    Views views = new_views(fit);
    double *poses = ffp_alloc((size_t)fit->n, 6 * sizeof *poses),
           *rms = ffp_alloc((size_t)fit->n, sizeof *rms);
    fill_views(fit, 1U << which, &views);
    const bool ok = ffp_cv_calibrate(&views.cv, fit->fixed[which], &fit->devices[which], poses, err);
    if (ok) {
        corner_offsets(fit, which, &views, poses);
        for (int v = 0; v < views.cv.n; v++) {
            FfpAttitude *a = &fit->attitudes[views.attitude[v]];
            rms[v] = which == 0 ? a->camera_rms : a->projector_rms;
            double r[9];
            ffp_rotation_from_vector(poses + 6 * (size_t)v, r);
            // Towards the camera: corners may be numbered either way round.
            for (int k = 0; which == 0 && k < 3; k++) a->normal[k] = r[8] < 0 ? r[3 * k + 2] : -r[3 * k + 2];
        }
        const char *of =
            which == 0 ? "where the camera's fit puts them" : "where the projector's fit puts them";
        *changed = drop_attitude(fit, &views, rms, 1, of) || judge_corners(fit, which, &views) > 0;
    }
    ffp_free(poses), ffp_free(rms);
    free_views(&views);
    return ok;
}

static bool fit_pair(FfpRigFit *fit, bool *changed, FfpError *err) {
    Views views = new_views(fit);
    double *rms = ffp_alloc((size_t)fit->n, 2 * sizeof *rms);
    fill_views(fit, 3, &views);
    const bool ok =
        ffp_cv_pair(&views.cv, &fit->devices[0], &fit->devices[1], fit->r, fit->t, rms, &fit->rms, err);
    for (int v = 0; ok && v < views.cv.n; v++)
        memcpy(fit->attitudes[views.attitude[v]].rms, rms + 2 * (size_t)v, 2 * sizeof *rms);
    const char *of = "where camera and projector together put them";
    *changed = ok && (drop_attitude(fit, &views, rms, 2, of) || drop_attitude(fit, &views, rms + 1, 2, of));
    ffp_free(rms);
    free_views(&views);
    return ok;
}

// Round after round until nothing falls out or comes back any more, and camera and projector together last.
// A round that does not end it leaves an attitude out, or is one of those in which corners alone changed:
// of these there are ROUNDS at the most, since corners at the limit may come and go without end.
static bool fit_all(FfpRigFit *fit, FfpError *err) {
    const FfpTask task = ffp_task("calibrating", ROUNDS + fit->n);
    bool ok = true, done = false;
    for (int round = 0, restless = 0; ok && !done; round++) {
        bool changed[3] = {false, false, true};
        ffp_cancel_point();
        check_counts(fit);
        const int before = ffp_attitudes_used(fit);
        ok = enough(fit, err) && check_parallel(fit, err) && fit_device(fit, 0, &changed[0], err) &&
             enough(fit, err) && fit_device(fit, 1, &changed[1], err);
        const bool dropped = ffp_attitudes_used(fit) < before;
        if (!dropped && (changed[0] || changed[1])) restless++;
        const bool settled = !dropped && ((!changed[0] && !changed[1]) || restless >= ROUNDS);
        if (ok && settled) ok = fit_pair(fit, &changed[2], err);
        done = !changed[2];
        ffp_task_step(&task, round + 1, NULL);
    }
    ffp_task_end(&task);
    return ok;
}

// --- What came out. ---

static void measure_spread(FfpRigFit *fit) {
    for (int i = 0; i < fit->n; i++)
        for (int k = 0; k < i; k++) {
            const FfpAttitude *a = &fit->attitudes[i], *b = &fit->attitudes[k];
            if (a->problem[0] || b->problem[0]) continue;
            const double cosine = ffp_dot(a->normal, b->normal);
            fit->spread = fmax(fit->spread, acos(fmax(-1, fmin(1, cosine))) * 180 / FFP_PI_DOUBLE);
        }
}

static bool check_focal(const FfpRigFit *fit, int which, FfpError *err) {
    const FfpCvDevice *d = &fit->devices[which];
    const double open = fmax(d->deviation[0] / d->matrix[0], d->deviation[1] / d->matrix[4]);
    if (!(open < FOCAL_OPEN))
        return ffp_fail(
            err, FFP_ERROR_FILE, NULL,
            "the %s's focal length (%.0f pixels) is uncertain by %.0f %%: tilt the board more, by 20 "
            "to 40 degrees, in a different direction each time",
            device_names[which], d->matrix[0], 100 * open);
    if (open > FOCAL_VAGUE)
        ffp_warning("the %s's focal length is uncertain by %.1f %%: take more attitudes, tilted more",
                    device_names[which], 100 * open);
    return true;
}

// One warning a device.
static void tell_open_terms(const FfpRigFit *fit) {
    for (int d = 0; d < 2; d++) {
        const FfpCvDevice *device = &fit->devices[d];
        char terms[320] = "", fix[160] = "";
        double most = 0;
        int n = 0, m = 0;
        bool tangential = false;
        for (int term = 4; term < FFP_TERMS; term++) {
            const bool p = term == 6 || term == 7;
            if (!ffp_term_open(device, term)) continue;
            n += snprintf(terms + n, sizeof terms - (size_t)n, "%s%s (%.4g, deviation %.2g)",
                          n > 0 ? ", " : "", ffp_term_names[term], ffp_term(device, term),
                          device->deviation[term]);
            if (!p || !tangential)
                m += snprintf(fix + m, sizeof fix - (size_t)m, "%sfix %s.%s", m > 0 ? ", " : "",
                              device_names[d], p ? "p" : ffp_term_names[term]);
            tangential = tangential || p;
            most = fmax(most, device->deviation[term] * ffp_term_reach(device, term));
        }
        if (n > 0)
            ffp_warning("the photographs do not determine the %s's %s: up to %.0f pixels in the picture's "
                        "corner; it can be fixed at 0 (%s)",
                        device_names[d], terms, most, fix);
    }
}

bool ffp_fit_rig(FfpRigFit *fit, FfpError *err) {
    if (!enough(fit, err)) return false;
    const bool ok = fit_all(fit, err) && check_focal(fit, 0, err) && check_focal(fit, 1, err);
    if (!ok) return false;
    measure_spread(fit);
    ffp_note_left_out(fit);
    tell_open_terms(fit);
    return true;
}
