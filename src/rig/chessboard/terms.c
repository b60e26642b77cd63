#include "rig/chessboard/terms.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "rig/chessboard/pose.h"
#include "rig/chessboard/views.h"
#include "rig/findings/tell.h"

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

// --- What is told of it. ---

// Names of the open terms with their values, and by how many pixels the worst moves the picture's corner; 0:
// all are determined.
static double open_terms(const FfpCvDevice *device, char text[320]) {
    double most = 0;
    int n = 0;
    for (int term = 4; term < FFP_TERMS; term++) {
        if (!ffp_term_open(device, term)) continue;
        n += snprintf(text + n, 320 - (size_t)n, "%s%s (%.4g, deviation %.2g)", n > 0 ? ", " : "",
                      ffp_term_names[term], ffp_term(device, term), device->deviation[term]);
        most = fmax(most, device->deviation[term] * ffp_term_reach(device, term));
    }
    return most;
}

// "camera.k3 camera.p"
static void name_fixed(char text[80], int which, unsigned fixed) {
    text[0] = 0;
    for (int i = 0; i < TRIED; i++) {
        const size_t used = strlen(text);
        if (fixed & tried[i].fix)
            snprintf(text + used, 80 - used, "%s%s.%s", used > 0 ? " " : "", device_names[which],
                     tried[i].name);
    }
}

static bool judge_device(const FfpRigFit *fit, int which, FfpError *err) {
    char terms[320], fixed[80];
    const int used = ffp_attitudes_used(fit), most = (used + FOLDS - 1) / FOLDS;
    FfpFacts facts = {.a = device_names[which], .b = terms, .c = fixed};
    facts.figure = open_terms(&fit->devices[which], terms);
    if (!(facts.figure > 0)) return true;
    FfpRuleId rule = FFP_RULE_TERMS_UNTRIED; // from so few attitudes none can be held out
    Trial trial = {.fixed = fit->fixed[which]};
    if (used - most >= FFP_FIT_ATTITUDES_LEAST) {
        if (!try_device(fit, which, &trial, err)) return false;
        rule = trial.fixed == fit->fixed[which] ? FFP_RULE_TERMS_OPEN : FFP_RULE_TERMS_FIX;
        facts.x = trial.fewer, facts.y = trial.with;
    } else {
        for (int i = 0; i < TRIED; i++)
            if (is_open(&fit->devices[which], tried[i].terms)) trial.fixed |= tried[i].fix;
        facts.x = FFP_FIT_ATTITUDES_LEAST + 1;
    }
    name_fixed(fixed, which, trial.fixed);
    ffp_tell(rule, &facts);
    return true;
}

bool ffp_judge_terms(const FfpRigFit *fit, FfpError *err) {
    return judge_device(fit, 0, err) && (ffp_projector_bent(fit) || judge_device(fit, 1, err));
}
