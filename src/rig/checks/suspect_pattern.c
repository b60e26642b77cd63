#include <math.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "core/numerics/rank.h"
#include "rig/checks/checks.h"
#include "rig/checks/suspect_parts.h"

#define WELL 0.06     // error of colours that are looked up rightly, at most: no more questions then
#define EXPLAINED 0.7 // of what chance explains: less is an explanation
#define BETTER 0.6    // of the error as it is: what explains so much better is right
#define CLEARLY 0.8   // of a mirrored pattern's error: what mirrored photographs must explain so much better
#define ODD 2         // times the others' median: a view that disagrees
#define THIRDS 4

// Root mean square over all views of a guess at the photographs under `active`.
static double error_of(const FfpCapture *capture, int active, FfpGuess guess) {
    double sum = 0;
    int n = 0;
    for (int v = 0; v < capture->n_views; v++) {
        guess.photograph = &capture->views[v].images[active];
        const double error = ffp_rig_guess(capture, &capture->views[v], &guess);
        if (isnan(error)) continue;
        sum += error * error;
        n++;
    }
    return n > 0 ? sqrt(sum / n) : NAN;
}

double ffp_rig_error_mirrored_back(const FfpCapture *capture, int active, FfpRigMishap mishap) {
    const int shown[3] = {capture->black, capture->white, active};
    FfpSummed pattern = ffp_summed_new(&capture->patterns[active].image);
    FfpCapture alias = ffp_rig_alias(capture);
    for (int v = 0; v < alias.n_views; v++) {
        FfpView *view = &alias.views[v];
        const FfpImage *taken = view->images;
        view->images = ffp_alloc((size_t)alias.n_patterns, sizeof *view->images);
        for (int k = 0; k < 3; k++) view->images[shown[k]] = ffp_rig_undone(&taken[shown[k]], mishap);
        view->coverage = ffp_rig_undone(&view->coverage, mishap);
    }
    const double error = error_of(&alias, active, (FfpGuess){.pattern = &pattern});
    for (int v = 0; v < alias.n_views; v++) {
        FfpView *view = &alias.views[v];
        for (int k = 0; k < 3; k++) ffp_image_free(&view->images[shown[k]]);
        ffp_free(view->images);
        ffp_image_free(&view->coverage);
    }
    ffp_free(alias.views);
    ffp_summed_free(&pattern);
    return error;
}

// The least of four places where the pattern certainly is not.
static double chance_of(const FfpCapture *capture, int active, const FfpSummed *pattern) {
    double least = INFINITY;
    for (int k = 1; k <= THIRDS; k++)
        least = fmin(least, error_of(capture, active, (FfpGuess){.pattern = pattern, .third = k}));
    return least;
}

// --- All views. ---

static double error_of_size(const FfpCapture *capture, int active, const FfpSummed *pattern, real factor) {
    FfpCapture alias = ffp_rig_alias(capture);
    for (int v = 0; v < alias.n_views; v++) {
        FfpCamera *p = &alias.views[v].projector;
        p->fx *= factor, p->fy *= factor;
        p->cx *= factor, p->cy *= factor;
    }
    const double error = error_of(&alias, active, (FfpGuess){.pattern = pattern});
    ffp_free(alias.views);
    return error;
}

static double error_of_inverted(const FfpCapture *capture, int active, const FfpSummed *pattern) {
    FfpCapture alias = ffp_rig_alias(capture);
    for (int v = 0; v < alias.n_views; v++) {
        const real *from = capture->views[v].projector.pose;
        real *to = alias.views[v].projector.pose;
        for (int i = 0; i < 3; i++) {
            to[4 * i + 3] = 0;
            for (int k = 0; k < 3; k++) {
                to[4 * i + k] = from[4 * k + i];
                to[4 * i + 3] -= from[4 * k + i] * from[4 * k + 3];
            }
        }
    }
    const double error = error_of(&alias, active, (FfpGuess){.pattern = pattern});
    ffp_free(alias.views);
    return error;
}

static bool is_other(const FfpCapture *capture, int pattern, int active) {
    return pattern != active && pattern < ffp_patterns_shown(capture) && pattern != capture->black &&
           pattern != capture->white && capture->patterns[pattern].image.data;
}

// The pattern, of those that the capture names, that explains the photographs under `active` best; -1: none.
static int likeliest_pattern(const FfpCapture *capture, int active, double enough) {
    int best = -1;
    for (int p = 0; p < capture->n_patterns; p++) {
        if (!is_other(capture, p, active)) continue;
        FfpSummed summed = ffp_summed_new(&capture->patterns[p].image);
        const double error = error_of(capture, active, (FfpGuess){.pattern = &summed});
        if (error < enough && error < EXPLAINED * chance_of(capture, active, &summed)) {
            enough = error;
            best = p;
        }
        ffp_summed_free(&summed);
    }
    return best;
}

// Tries what is wrong in all views; `enough`: an error that is an explanation.
static bool try_all_views(const FfpCapture *capture, int active, const FfpSummed *pattern, double enough,
                          FfpError *err) {
    static const char *const ways[4] = {NULL, "left to right", "upside down", "both ways"};
    const char *name = capture->patterns[active].name;
    const FfpCamera *p = &capture->views[0].projector;
    double least = enough;
    int mirrored = 0;
    for (int mirror = 1; mirror < 4; mirror++) {
        const double error = error_of(capture, active, (FfpGuess){.pattern = pattern, .mirror = mirror});
        if (error < least) least = error, mirrored = mirror;
    }
    for (int down = 0; down < 2; down++)
        if (ffp_rig_error_mirrored_back(capture, active, down ? FFP_RIG_FLIPPED : FFP_RIG_MIRRORED) <
            CLEARLY * least)
            return ffp_fail(err, FFP_ERROR_FAULT, capture->folder, FFP_RIG_ALL_MIRRORED, ways[1 + down]);
    if (mirrored > 0)
        return ffp_fail(err, FFP_ERROR_FAULT, capture->folder,
                        "the photographs under %s fit when it is mirrored %s: the projector mirrors its "
                        "picture, or the pattern's file or all photographs are mirrored",
                        name, ways[mirrored]);
    if (error_of(capture, active, (FfpGuess){.pattern = pattern, .reversed = true}) < enough)
        return ffp_fail(err, FFP_ERROR_FAULT, capture->folder,
                        "the photographs under %s fit with red and blue exchanged: the photographs or the "
                        "pattern's file have the channels in another order",
                        name);
    for (int twice = 0; twice < 2; twice++)
        if (error_of_size(capture, active, pattern, twice ? 2 : 0.5F) < enough)
            return ffp_fail(
                err, FFP_ERROR_FAULT, capture->folder,
                "the photographs under %s fit with %s the projector's focal lengths and principal "
                "point: it was calibrated at %d x %d pixels, not at the pattern's %d x %d",
                name, twice ? "twice" : "half", twice ? p->width / 2 : 2 * p->width,
                twice ? p->height / 2 : 2 * p->height, p->width, p->height);
    if (error_of_inverted(capture, active, pattern) < enough)
        return ffp_fail(
            err, FFP_ERROR_FAULT, capture->folder,
            "the photographs under %s fit with the projector's poses inverted: its R and T have the "
            "other direction",
            name);
    const int other = likeliest_pattern(capture, active, enough);
    if (other < 0) return true;
    return ffp_fail(err, FFP_ERROR_FAULT, capture->folder, "the photographs under %s show %s", name,
                    capture->patterns[other].name);
}

// --- One view. ---

typedef struct Odd {
    int view;     // explained much worse than the others; -1: none
    bool sure;    // and no better than by chance
    double usual; // error of the views
} Odd;

// Whether the photograph of view `odd` fits view `other`, as it does where the two are exchanged: of an
// object that looks alike from both, the other's may fit here by its shape alone, whatever is wrong with the
// odd one.
static bool fits_there(const FfpCapture *capture, int active, const FfpSummed *pattern, int odd, int other,
                       double enough) {
    const FfpGuess guess = {.photograph = &capture->views[odd].images[active], .pattern = pattern};
    return ffp_rig_guess(capture, &capture->views[other], &guess) < enough;
}

// Fails if another photograph is what belongs there, or if what is there certainly does not.
static bool try_one_view(const FfpCapture *capture, int active, const FfpSummed *pattern, const Odd *found,
                         FfpError *err) {
    const int odd = found->view;
    const double enough = 1.5 * found->usual;
    const FfpView *view = &capture->views[odd];
    const char *name = capture->patterns[active].name;
    double least = INFINITY;
    int best = -1;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpImage *photograph = &capture->views[v].images[active];
        if (v == odd || photograph->width != view->camera.width || photograph->height != view->camera.height)
            continue;
        const double error =
            ffp_rig_guess(capture, view, &(FfpGuess){.photograph = photograph, .pattern = pattern});
        if (!(error < least)) continue;
        least = error;
        best = v;
    }
    if (least < enough && fits_there(capture, active, pattern, odd, best, enough))
        return ffp_fail(err, FFP_ERROR_FAULT, view->id,
                        "its photograph under %s does not fit the others of this view; that of view %s does: "
                        "they are exchanged",
                        name, capture->views[best].id);
    for (int p = 0; p < capture->n_patterns; p++) {
        if (!is_other(capture, p, active)) continue;
        FfpSummed summed = ffp_summed_new(&capture->patterns[p].image);
        const double error = ffp_rig_guess(
            capture, view, &(FfpGuess){.photograph = &view->images[active], .pattern = &summed});
        ffp_summed_free(&summed);
        if (error < enough)
            return ffp_fail(err, FFP_ERROR_FAULT, view->id, "its photograph under %s shows %s", name,
                            capture->patterns[p].name);
    }
    return !found->sure ||
           ffp_fail(err, FFP_ERROR_FAULT, view->id,
                    "its photograph under %s does not show that pattern where this view's projector is: "
                    "something was in front of it, or its pose or one of its photographs is another's",
                    name);
}

static Odd odd_view(const FfpCapture *capture, int active, const FfpSummed *pattern) {
    double *errors = ffp_alloc(2 * (size_t)capture->n_views, sizeof *errors),
           *sorted = errors + capture->n_views;
    Odd found = {.view = -1};
    int n = 0, odd = -1;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpGuess guess = {.photograph = &capture->views[v].images[active], .pattern = pattern};
        errors[v] = ffp_rig_guess(capture, &capture->views[v], &guess);
        if (isnan(errors[v])) continue;
        sorted[n++] = errors[v];
        if (odd < 0 || errors[v] > errors[odd]) odd = v;
    }
    found.usual = ffp_median(sorted, (size_t)n);
    const double worst = odd >= 0 ? errors[odd] : 0;
    ffp_free(errors);
    if (n < 3 || !(worst > ODD * found.usual) || worst < WELL) return found;
    double chance = INFINITY;
    for (int k = 1; k <= THIRDS; k++) {
        const FfpGuess guess = {
            .photograph = &capture->views[odd].images[active], .pattern = pattern, .third = k};
        chance = fmin(chance, ffp_rig_guess(capture, &capture->views[odd], &guess));
    }
    found.view = odd;
    found.sure = worst > EXPLAINED * chance;
    return found;
}

bool ffp_rig_suspect_pattern(const FfpCapture *capture, int active, FfpError *err) {
    FfpSummed pattern = ffp_summed_new(&capture->patterns[active].image);
    bool ok = true;
    const Odd odd = odd_view(capture, active, &pattern);
    const double error = error_of(capture, active, (FfpGuess){.pattern = &pattern});
    if (error < FFP_RIG_SHOWN && (odd.usual >= WELL || odd.view >= 0) && !ffp_rig_tells(capture, active)) {
        // Stripes: every guess explains them.
    } else if (odd.usual >= WELL) {
        const double chance = chance_of(capture, active, &pattern),
                     enough = fmin(BETTER * error, EXPLAINED * chance);
        if (error > EXPLAINED * chance) {
            ok = try_all_views(capture, active, &pattern, enough, err);
            if (ok)
                ffp_note("'%s' explains its photographs no better than chance: another pattern was shown, or "
                         "poses are wrong; `info` says what to look at",
                         capture->patterns[active].name);
        }
    } else if (odd.view >= 0) {
        ok = try_one_view(capture, active, &pattern, &odd, err);
    }
    ffp_summed_free(&pattern);
    return ok;
}
