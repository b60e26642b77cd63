#include "rig/chessboard/fit.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/log.h"
#include "core/base/rigid.h"
#include "core/numerics/rank.h"
#include "rig/chessboard/notes.h"
#include "rig/chessboard/views.h"
#include "rig/findings/tell.h"
#include "rig/optics/lens.h"

#define CORNER_FAR 5        // times the deviation on an axis: Gauss passes it once in 270,000
#define CORNER_LEAST 0.25   // pixels: nothing nearer is out of line
#define ATTITUDE_FAR 3      // times the median of the attitudes' root mean squares
#define ATTITUDE_LEAST 0.75 // pixels
#define CORNERS_LEAST 0.3   // share of the board's corners that an attitude must keep
#define PARALLEL 3          // degrees between the boards farthest from parallel
#define BENT 0.3            // pixels: a projector alone that fits worse, and
#define BENT_TIMES 3        // so many times worse than the camera, is bent by its own electronics; or
#define BENT_ALONE 1.5      // so many times worse, where both together fit so many times worse than alone
#define FOCAL_OPEN 0.1      // share of the focal length by which it may be uncertain
#define FOCAL_VAGUE 0.02    // and where that is worth a warning
#define GUESS_FOCAL 1.2     // of the picture's longer side: to see whether boards are parallel
enum { ROUNDS = 12 };       // in which corners change and no attitude falls out

static const char *const device_names[2] = {"camera", "projector"};

int ffp_attitudes_used(const FfpRigFit *fit) {
    int n = 0;
    for (int i = 0; i < fit->n; i++) n += fit->attitudes[i].problem[0] == 0;
    return n;
}

// --- Attitudes that cannot serve. ---

static bool too_few(const FfpRigFit *fit, FfpError *err) {
    char why[640];
    ffp_list_problems(fit, why, sizeof why);
    ffp_refuse(FFP_RULE_TOO_FEW,
               &(FfpFacts){.x = ffp_attitudes_used(fit),
                           .y = fit->n,
                           .z = FFP_FIT_ATTITUDES_LEAST,
                           .a = "attitudes of the board can be used",
                           .b = why[0] ? why + 2 : "none left out"},
               NULL, err);
    for (int i = fit->n - 1; i >= 0; i--)
        if (fit->attitudes[i].finding && err)
            err->finding = fit->attitudes[i].finding; // the first that is one
    return false;
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
        for (int k = 0; k < a->n; k++) kept += ffp_corner_used(a, k, 3);
        if (kept < CORNERS_LEAST * a->n || kept < 8)
            leave_out(a, "only %d of %d corners are good enough", kept, a->n);
    }
}

bool ffp_board_normal(const FfpBoard *board, const FfpAttitude *a, int width, int height, double normal[3],
                      FfpError *err) {
    const double focal = GUESS_FOCAL * fmax(width, height);
    double h[9];
    bool found;
    const bool ok = ffp_board_homography(board, a, 5, h, &found, err);
    normal[0] = normal[1] = 0, normal[2] = 1;
    if (!ok || !found) return ok;
    double columns[2][3];
    for (int k = 0; k < 2; k++) {
        columns[k][0] = (h[k] - 0.5 * width * h[6 + k]) / focal;
        columns[k][1] = (h[3 + k] - 0.5 * height * h[6 + k]) / focal;
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
        if (!fit->attitudes[i].problem[0])
            ok = ffp_board_normal(&fit->board, &fit->attitudes[i], fit->devices[0].width,
                                  fit->devices[0].height, normals[n++], err);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < i; k++)
            widest = fmax(widest, acos(fmin(1, fabs(ffp_dot(normals[i], normals[k])))) * 180 / FFP_PI_DOUBLE);
    ffp_free(normals);
    return ok &&
           (widest > PARALLEL || ffp_refuse(FFP_RULE_BOARDS_PARALLEL,
                                            &(FfpFacts){.figure = widest, .limit = PARALLEL}, NULL, err));
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

static void corner_offsets(const FfpRigFit *fit, int which, const FfpViews *views, const double *poses) {
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
            if (!ffp_corner_used(a, i, 1U << which)) continue;
            square += off[2 * i] * off[2 * i] + off[2 * i + 1] * off[2 * i + 1], n++;
        }
        *(which == 0 ? &a->camera_rms : &a->projector_rms) = sqrt(square / fmax(1, n));
    }
}

// True if a corner has a place in the device's fit, or had one until it fell out.
static bool is_judged(unsigned char state) {
    return state == FFP_CORNER_USED || state == FFP_CORNER_FAR;
}

// Corners farther off than the spread of those used explains fall out, and come back when a later fit, no
// longer drawn aside by worse ones, puts them into line. Returns how many changed.
static int judge_corners(const FfpRigFit *fit, int which, const FfpViews *views) {
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
static bool drop_attitude(const FfpRigFit *fit, const FfpViews *views, const double *rms, int stride,
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
    FfpAttitude *a = &fit->attitudes[views->attitude[worst]];
    leave_out(
        a,
        "its corners are %.2f pixels (rms) away from %s, those of others typically %.2f: %sthe board or a "
        "device moved, its photographs are turned, or one is out of order",
        most, of, middle, a->clipped > ffp_rule(FFP_RULE_BOARD_CLIPPED)->limit ? "it is overexposed, " : "");
    return true;
}

// --- Fitting. ---

static bool fit_device(FfpRigFit *fit, int which, bool *changed, FfpError *err) {
    FfpViews views = ffp_views_new(fit);
    double *poses = ffp_alloc((size_t)fit->n, 6 * sizeof *poses),
           *rms = ffp_alloc((size_t)fit->n, sizeof *rms);
    ffp_views_fill(fit, 1U << which, &views);
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
    ffp_views_free(&views);
    return ok;
}

static bool fit_pair(FfpRigFit *fit, bool *changed, FfpError *err) {
    FfpViews views = ffp_views_new(fit);
    double *rms = ffp_alloc((size_t)fit->n, 2 * sizeof *rms);
    ffp_views_fill(fit, 3, &views);
    const bool ok =
        ffp_cv_pair(&views.cv, &fit->devices[0], &fit->devices[1], fit->r, fit->t, rms, &fit->rms, err);
    for (int v = 0; ok && v < views.cv.n; v++)
        memcpy(fit->attitudes[views.attitude[v]].rms, rms + 2 * (size_t)v, 2 * sizeof *rms);
    const char *of = "where camera and projector together put them";
    *changed = ok && (drop_attitude(fit, &views, rms, 2, of) || drop_attitude(fit, &views, rms + 1, 2, of));
    ffp_free(rms);
    ffp_views_free(&views);
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

bool ffp_projector_bent(const FfpRigFit *fit) {
    const double projector = fit->devices[1].rms, camera = fit->devices[0].rms;
    const double alone = hypot(camera, projector) / sqrt(2);
    return (projector > BENT && projector > BENT_TIMES * camera) ||
           (fit->rms > BENT && fit->rms > BENT_ALONE * alone && projector > BENT_ALONE * camera);
}

static bool check_focal(const FfpRigFit *fit, int which, FfpError *err) {
    const FfpCvDevice *d = &fit->devices[which];
    const FfpFacts bent = {.figure = d->rms, .x = fit->devices[0].rms, .limit = BENT};
    const double open = fmax(d->deviation[0] / d->matrix[0], d->deviation[1] / d->matrix[4]);
    if (which == 1 && ffp_projector_bent(fit)) { // nor would more photographs help
        if (!(open < FOCAL_OPEN)) return ffp_refuse(FFP_RULE_PROJECTOR_OPEN, &bent, NULL, err);
        ffp_tell(FFP_RULE_PROJECTOR_FITS_BADLY, &bent);
        return true;
    }
    if (!(open < FOCAL_OPEN))
        return ffp_refuse(FFP_RULE_FOCAL_OPEN,
                          &(FfpFacts){.a = device_names[which], .figure = open, .limit = FOCAL_OPEN}, NULL,
                          err);
    if (open > FOCAL_VAGUE)
        ffp_tell(FFP_RULE_FOCAL, &(FfpFacts){.a = device_names[which], .figure = open, .limit = FOCAL_VAGUE});
    return true;
}

bool ffp_fit_rig(FfpRigFit *fit, FfpError *err) {
    if (!enough(fit, err)) return false;
    const bool ok = fit_all(fit, err) && check_focal(fit, 0, err) && check_focal(fit, 1, err);
    if (!ok) return false;
    measure_spread(fit);
    ffp_note_left_out(fit);
    return true;
}
