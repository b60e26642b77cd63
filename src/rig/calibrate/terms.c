#include "rig/calibrate/terms.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/log.h"
#include "rig/calibrate/pose.h"
#include "rig/calibrate/views.h"

#define OPEN_PIXELS 1.0 // at the corner of the picture: a lens term no better known than that
#define AS_GOOD 1.005   // of the boards' error: fewer terms may have as much more
enum { FOLDS = 5, TRIED = 3 };

const char *const ffp_term_names[FFP_TERMS] = {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
static const char *const device_names[2] = {"camera", "projector"};

// Terms that may be given up, the least needed first, and where they are among a device's.
static const struct {
    unsigned fix;
    const char *name;
    int terms[2];
} tried[TRIED] = {
    {FFP_CV_FIX_K3, "k3", {8, 8}}, {FFP_CV_FIX_K2, "k2", {5, 5}}, {FFP_CV_FIX_TANGENTIAL, "p", {6, 7}}};

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

// --- Boards held out. ---

// The corners of an attitude in one device, as those of a camera: where it does not see one, its fit says
// where.
static void take_corners(FfpAttitude *out, const FfpAttitude *a, int which, double *corners) {
    const double *seen = which == 0 ? a->camera : a->projector,
                 *off = which == 0 ? a->camera_off : a->projector_off;
    for (int i = 0; i < 2 * a->n; i++)
        corners[i] = ffp_corner_used(a, i / 2, 1U << which) ? seen[i] : seen[i] - off[i];
    *out = (FfpAttitude){.n = a->n, .camera = corners};
}

// Adds the squared distances of the boards of a fold from where a device puts them that was fitted without
// them.
static bool add_fold(const FfpRigFit *fit, const FfpCvDevice *device, int which, int fold, double sum[2],
                     FfpError *err) {
    double *corners = ffp_alloc((size_t)fit->board.columns * (size_t)fit->board.rows, 2 * sizeof *corners);
    bool ok = true;
    for (int i = 0, used = 0; ok && i < fit->n; i++) {
        const FfpAttitude *a = &fit->attitudes[i];
        if (a->problem[0] || used++ % FOLDS != fold) continue;
        FfpAttitude seen;
        FfpBoardPose pose;
        bool found;
        take_corners(&seen, a, which, corners);
        ok = ffp_board_pose(&fit->board, device, &seen, &pose, &found, err);
        if (!ok || !found) continue;
        sum[0] += pose.rms * pose.rms;
        sum[1]++;
    }
    ffp_free(corners);
    return ok;
}

// Root mean square distance, pixels, of boards from where a device puts them that was fitted to the others.
static bool held_out(const FfpRigFit *fit, int which, unsigned fixed, double *rms, FfpError *err) {
    FfpRigFit rest = *fit;
    FfpViews views = ffp_views_new(fit);
    double *poses = ffp_alloc((size_t)fit->n, 6 * sizeof *poses), sum[2] = {0};
    const int folds = ffp_attitudes_used(fit) < FOLDS ? ffp_attitudes_used(fit) : FOLDS;
    bool ok = true;
    rest.attitudes = ffp_alloc((size_t)fit->n, sizeof *rest.attitudes);
    for (int fold = 0; ok && fold < folds; fold++) {
        FfpCvDevice device = {.width = fit->devices[which].width, .height = fit->devices[which].height};
        memcpy(rest.attitudes, fit->attitudes, (size_t)fit->n * sizeof *rest.attitudes);
        for (int i = 0, used = 0; i < fit->n; i++)
            if (!fit->attitudes[i].problem[0] && used++ % FOLDS == fold)
                snprintf(rest.attitudes[i].problem, sizeof rest.attitudes[i].problem, "held out");
        ffp_cancel_point();
        ffp_views_fill(&rest, 1U << which, &views);
        ok = ffp_cv_calibrate(&views.cv, fixed, &device, poses, err) &&
             add_fold(fit, &device, which, fold, sum, err);
    }
    ffp_free(poses);
    ffp_free(rest.attitudes);
    ffp_views_free(&views);
    *rms = sqrt(sum[0] / fmax(1, sum[1]));
    return ok;
}

// --- Fewer terms. ---

typedef struct Trial {
    unsigned fixed;     // with those that can be given up
    double with, fewer; // error of boards held out, pixels: with all terms, and with fewer
} Trial;

// A device fitted to all its corners with these terms fixed.
static bool refit(const FfpRigFit *fit, int which, unsigned fixed, FfpCvDevice *device, FfpError *err) {
    FfpViews views = ffp_views_new(fit);
    double *poses = ffp_alloc((size_t)fit->n, 6 * sizeof *poses);
    *device = (FfpCvDevice){.width = fit->devices[which].width, .height = fit->devices[which].height};
    ffp_views_fill(fit, 1U << which, &views);
    const bool ok = ffp_cv_calibrate(&views.cv, fixed, device, poses, err);
    ffp_free(poses);
    ffp_views_free(&views);
    return ok;
}

static bool is_open(const FfpCvDevice *device, const int terms[2]) {
    return ffp_term_open(device, terms[0]) || ffp_term_open(device, terms[1]);
}

static bool try_device(const FfpRigFit *fit, int which, Trial *trial, FfpError *err) {
    FfpCvDevice device = fit->devices[which];
    *trial = (Trial){.fixed = fit->fixed[which]};
    if (!held_out(fit, which, trial->fixed, &trial->with, err)) return false;
    trial->fewer = trial->with;
    for (int i = 0; i < TRIED; i++) {
        double rms;
        if ((trial->fixed & tried[i].fix) || !is_open(&device, tried[i].terms)) continue;
        if (!held_out(fit, which, trial->fixed | tried[i].fix, &rms, err)) return false;
        if (rms > AS_GOOD * trial->fewer) continue;
        trial->fixed |= tried[i].fix;
        trial->fewer = rms;
        if (!refit(fit, which, trial->fixed, &device, err)) return false;
    }
    return true;
}

// The error of all corners in both devices with these terms fixed.
static bool pair_error(const FfpRigFit *fit, const unsigned fixed[2], double *rms, FfpError *err) {
    FfpViews views = ffp_views_new(fit);
    FfpCvDevice devices[2];
    double *each = ffp_alloc((size_t)fit->n, 2 * sizeof *each), r[9], t[3];
    ffp_views_fill(fit, 3, &views);
    const bool ok = refit(fit, 0, fixed[0], &devices[0], err) && refit(fit, 1, fixed[1], &devices[1], err) &&
                    ffp_cv_pair(&views.cv, &devices[0], &devices[1], r, t, each, rms, err);
    ffp_free(each);
    ffp_views_free(&views);
    return ok;
}

// --- What is said of it. ---

// One warning a device; false where all its terms are determined.
static bool tell_open_terms(const FfpCvDevice *device, const char *name) {
    char terms[320] = "";
    double most = 0;
    int n = 0;
    for (int term = 4; term < FFP_TERMS; term++) {
        if (!ffp_term_open(device, term)) continue;
        n += snprintf(terms + n, sizeof terms - (size_t)n, "%s%s (%.4g, deviation %.2g)", n > 0 ? ", " : "",
                      ffp_term_names[term], ffp_term(device, term), device->deviation[term]);
        most = fmax(most, device->deviation[term] * ffp_term_reach(device, term));
    }
    if (n > 0)
        ffp_warning("the photographs do not determine the %s's %s: up to %.0f pixels in the picture's corner",
                    name, terms, most);
    return n > 0;
}

static void add_options(char text[400], int which, unsigned fixed) {
    for (int i = 0; i < TRIED; i++) {
        const size_t used = strlen(text);
        if (fixed & tried[i].fix)
            snprintf(text + used, 400 - used, " --fix %s.%s", device_names[which], tried[i].name);
    }
}

static bool tell_trials(const FfpRigFit *fit, const bool open[2], const Trial trials[2], FfpError *err) {
    char options[400] = "", off[200] = "";
    unsigned fixed[2] = {fit->fixed[0], fit->fixed[1]};
    double rms;
    for (int d = 0; d < 2; d++) {
        if (!open[d]) continue;
        const size_t used = strlen(off);
        snprintf(off + used, sizeof off - used, "%s%.3f pixels in the %s, %.3f before", used ? "; " : "",
                 trials[d].fewer, device_names[d], trials[d].with);
        fixed[d] = trials[d].fixed;
    }
    const bool fewer = fixed[0] != fit->fixed[0] || fixed[1] != fit->fixed[1];
    for (int d = 0; d < 2; d++) add_options(options, d, fixed[d]);
    if (!fewer) {
        ffp_note("  without these terms boards that are held out fit worse: do not fix them; take "
                 "photographs of the "
                 "board at the picture's edges (%s)",
                 off);
        return true;
    }
    if (!pair_error(fit, fixed, &rms, err)) return false;
    ffp_note("  calibrate again with%s", options);
    ffp_note("  tried, and it holds: boards held out are off by %s; rms of all corners %.3f, %.3f before",
             off, rms, fit->rms);
    return true;
}

// From so few attitudes none can be held out.
static void tell_untried(const FfpRigFit *fit) {
    char options[400] = "";
    for (int d = 0; d < 2; d++) {
        unsigned fixed = fit->fixed[d];
        for (int i = 0; i < TRIED; i++)
            if (is_open(&fit->devices[d], tried[i].terms)) fixed |= tried[i].fix;
        add_options(options, d, fixed);
    }
    ffp_note("  calibrate again with%s, or with more attitudes: from %d on it is tried whether that holds",
             options, FFP_FIT_ATTITUDES_LEAST + 1);
}

bool ffp_judge_terms(const FfpRigFit *fit, FfpError *err) {
    bool open[2], ok = true;
    Trial trials[2] = {0};
    for (int d = 0; d < 2; d++) open[d] = tell_open_terms(&fit->devices[d], device_names[d]);
    if (!open[0] && !open[1]) return true;
    const int used = ffp_attitudes_used(fit), most = (used + FOLDS - 1) / FOLDS;
    if (used - most < FFP_FIT_ATTITUDES_LEAST) {
        tell_untried(fit);
        return true;
    }
    for (int d = 0; ok && d < 2; d++)
        if (open[d]) ok = try_device(fit, d, &trials[d], err);
    return ok && tell_trials(fit, open, trials, err);
}
