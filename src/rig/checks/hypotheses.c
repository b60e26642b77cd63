#include "rig/checks/hypotheses.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/arena.h"
#include "rig/checks/slip.h"

#define CLEARLY 0.8          // of a mirrored pattern's error: what mirrored photographs must leave at most
#define PREFERRED 0.7        // likewise of a camera's size as it is
#define FITS_WELL 0.08       // error of colours that are looked up rightly, at most
#define UNREACHED_MOST 0.1   // of the lit pixels, where no light can be: more than that before, and
#define UNREACHED_LEAST 0.02 // less than that after
#define THIRDS 4
#define EXCHANGES 16 // views with which one may be exchanged by its surface, which takes long
#define SUSPECTS 8   // views of which two may be exchanged: the time to try them does not grow with the views

typedef enum Mishap { HALF_TURN, TO_THE_LEFT, TO_THE_RIGHT, MIRRORED, FLIPPED, MISHAPS } Mishap;

// --- A capture as it would be. ---

typedef struct Trial {
    FfpCapture capture; // its views are its own; what they point to is the given capture's, or in `memory`
    FfpArena *memory;
    const FfpImage *pattern; // to be looked up
    FfpGuess guess;
    int view; // whose light alone is looked at; -1: all
} Trial;

static Trial trial_new(const FfpCapture *capture, int active) {
    Trial t = {.capture = *capture, .memory = ffp_arena_new(), .view = -1};
    const size_t n = (size_t)capture->n_views;
    t.capture.views = ffp_arena_take(t.memory, n, sizeof *t.capture.views);
    memcpy(t.capture.views, capture->views, n * sizeof *t.capture.views);
    t.pattern = active >= 0 ? &capture->patterns[active].image : NULL;
    return t;
}

static FfpImage undone(FfpArena *memory, const FfpImage *image, Mishap mishap) {
    const int w = image->width, h = image->height, n = image->channels;
    FfpImage out = *image;
    out.data = ffp_arena_take(memory, (size_t)w * (size_t)h * (size_t)n, sizeof *out.data);
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++) {
            const int from[MISHAPS][2] = {[HALF_TURN] = {w - 1 - x, h - 1 - y},
                                          [TO_THE_LEFT] = {y, w - 1 - x},
                                          [TO_THE_RIGHT] = {h - 1 - y, x},
                                          [MIRRORED] = {w - 1 - x, y},
                                          [FLIPPED] = {x, h - 1 - y}};
            memcpy(out.data + n * ((ptrdiff_t)y * w + x),
                   image->data + n * ((ptrdiff_t)from[mishap][1] * w + from[mishap][0]),
                   (size_t)n * sizeof *out.data);
        }
    return out;
}

// The pictures that structured light is judged by, and the mask. False: a quarter turn would change their
// shape.
static bool undo_in_view(Trial *t, int v, int active, Mishap mishap) {
    FfpView *view = &t->capture.views[v];
    const FfpImage *taken = view->images;
    const int shown[3] = {t->capture.black, t->capture.white, active};
    if ((mishap == TO_THE_LEFT || mishap == TO_THE_RIGHT) && view->coverage.width != view->coverage.height)
        return false;
    view->coverage = undone(t->memory, &view->coverage, mishap);
    if (active < 0) return true;
    view->images = ffp_arena_alloc(t->memory, (size_t)t->capture.n_patterns, sizeof *view->images);
    for (int k = 0; k < 3; k++) view->images[shown[k]] = undone(t->memory, &taken[shown[k]], mishap);
    return true;
}

static void scale_device(FfpCamera *device, real factor) {
    device->fx *= factor, device->fy *= factor;
    device->cx *= factor, device->cy *= factor;
}

static bool take_photographs(FfpView *view, const FfpView *from) {
    const FfpImage *own = &view->coverage, *other = &from->coverage;
    if (own->width != other->width || own->height != other->height) return false;
    view->coverage = *other;
    view->images = from->images;
    return true;
}

// --- How well it fits. ---

static double light_of(const FfpCapture *capture, int active, int only, FfpGuess guess) {
    double sum = 0;
    int n = 0;
    for (int v = only < 0 ? 0 : only; v < (only < 0 ? capture->n_views : only + 1); v++) {
        FfpGuess own = guess;
        if (!own.photograph) own.photograph = &capture->views[v].images[active];
        const double error = ffp_rig_guess(capture, &capture->views[v], &own);
        if (isnan(error)) continue;
        sum += error * error;
        n++;
    }
    return n > 0 ? sqrt(sum / n) : NAN;
}

double ffp_error_of(const FfpCapture *capture, int active, FfpGuess guess) {
    return light_of(capture, active, -1, guess);
}

double ffp_chance_of(const FfpCapture *capture, int active, const FfpSummed *pattern, int view) {
    double least = INFINITY;
    for (int k = 1; k <= THIRDS; k++)
        least = fmin(least, light_of(capture, active, view, (FfpGuess){.pattern = pattern, .third = k}));
    return least;
}

static double light_in(const Trial *t, const FfpCase *c) {
    FfpGuess guess = t->guess;
    FfpSummed summed = {0};
    guess.pattern = c->pattern;
    if (t->pattern != &c->capture->patterns[c->active].image) {
        summed = ffp_summed_new(t->pattern);
        guess.pattern = &summed;
    }
    const double error = light_of(&t->capture, c->active, t->view, guess);
    if (guess.pattern == &summed) ffp_summed_free(&summed);
    return error;
}

// True if structured light explains a view as well or better once the mishap is undone: of objects that are
// nearly symmetric, silhouettes alone would accept a mirrored view for a wrong mask.
static bool light_agrees(const FfpCase *c, int view, Mishap mishap) {
    if (c->active < 0) return true;
    Trial t = trial_new(c->capture, c->active);
    t.view = view;
    const double before = light_in(&t, c);
    undo_in_view(&t, view, c->active, mishap);
    const double after = light_in(&t, c);
    ffp_arena_free(t.memory);
    return !(after > before);
}

// --- The hypotheses. ---

static bool suppose_mishap(Trial *t, const FfpCase *c, int variant) {
    return undo_in_view(t, c->view, c->active, (Mishap)variant);
}

static bool suppose_mishap_alone(Trial *t, const FfpCase *c, int variant) {
    t->view = c->view;
    return suppose_mishap(t, c, variant);
}

static bool mishap_agrees(const FfpCase *c, int variant) {
    return light_agrees(c, c->view, (Mishap)variant);
}

// Found by the view's light alone; but where silhouettes accuse this view alone, they must fit as well.
static bool mishap_fits(const FfpCase *c, int variant) {
    FfpSilhouettes shapes = ffp_rig_silhouettes(c->capture);
    Trial t = trial_new(c->capture, c->active);
    undo_in_view(&t, c->view, c->active, (Mishap)variant);
    const bool fits =
        shapes.odd != c->view || ffp_rig_silhouette_misfit(&t.capture) < FFP_RIG_EXPLAINED * shapes.misfit;
    ffp_arena_free(t.memory);
    ffp_rig_silhouettes_free(&shapes);
    return fits;
}

static FfpRuleId tell_mishap(const FfpCase *c, int variant, FfpFacts *facts) {
    static const char *const names[MISHAPS] = {[HALF_TURN] = "turned by 180 degrees",
                                               [TO_THE_LEFT] = "turned by 90 degrees to the left",
                                               [TO_THE_RIGHT] = "turned by 90 degrees to the right",
                                               [MIRRORED] = "mirrored left to right",
                                               [FLIPPED] = "mirrored upside down"};
    facts->view = c->capture->views[c->view].id;
    facts->a = names[variant];
    return FFP_RULE_VIEW_TURNED;
}

// The photographs in the other direction round the object, the first staying where it is.
static bool suppose_reversal(Trial *t, const FfpCase *c, int variant) {
    const int n = c->capture->n_views;
    bool fits = true;
    (void)variant;
    for (int v = 1; v < n; v++)
        fits = take_photographs(&t->capture.views[v], &c->capture->views[n - v]) && fits;
    return fits;
}

// Photographs in the opposite direction round the object are as photographs in a mirror, but for structured
// light.
static FfpRuleId tell_reversal(const FfpCase *c, int variant, FfpFacts *facts) {
    int agree = 0;
    (void)variant;
    for (int v = 0; c->active >= 0 && v < c->capture->n_views; v++) agree += light_agrees(c, v, MIRRORED);
    facts->b = "left to right";
    return 2 * agree > c->capture->n_views ? FFP_RULE_ALL_MIRRORED : FFP_RULE_OTHER_DIRECTION;
}

static const real sizes[2] = {0.5F, 2};
static const char *const size_names[2] = {"half", "twice"};

// Half and twice; and with the object's bounds estimated again, which may come from the wrong size.
static bool suppose_camera_size(Trial *t, const FfpCase *c, int variant) {
    (void)c;
    for (int v = 0; v < t->capture.n_views; v++)
        scale_device(&t->capture.views[v].camera, sizes[variant % 2]);
    if (variant > 1) ffp_capture_estimate_bounds(&t->capture);
    return true;
}

// True if structured light explains the views clearly better in that size: masks that are wrong fit some
// sizes better, too.
static bool size_agrees(const FfpCase *c, int variant) {
    if (c->active < 0) return true;
    Trial t = trial_new(c->capture, c->active);
    suppose_camera_size(&t, c, variant);
    const FfpGuess guess = {.pattern = c->pattern};
    double before = 0, after = 0;
    for (int v = 0; v < c->capture->n_views; v++) {
        const double a = light_of(c->capture, c->active, v, guess),
                     b = light_of(&t.capture, c->active, v, guess);
        if (isnan(b)) continue;
        before += isnan(a) ? 1 : a; // rays that miss the object explain nothing
        after += b;
    }
    ffp_arena_free(t.memory);
    return after > 0 && after < PREFERRED * before;
}

static FfpRuleId tell_camera_size(const FfpCase *c, int variant, FfpFacts *facts) {
    (void)c;
    facts->a = size_names[variant % 2];
    return FFP_RULE_CAMERA_SIZE;
}

// The pair of the views that silhouettes blame most, with that number; false: there are not so many.
static bool suspects_of(const FfpCase *c, int variant, int pair[2]) {
    const double *blame = c->shapes->blame;
    int suspects[SUSPECTS] = {0}, n = 0;
    for (int v = 0; v < c->capture->n_views; v++) {
        int at = n < SUSPECTS ? n++ : SUSPECTS;
        for (; at > 0 && blame[suspects[at - 1]] < blame[v]; at--)
            if (at < SUSPECTS) suspects[at] = suspects[at - 1];
        if (at < SUSPECTS) suspects[at] = v;
    }
    const int a = suspects[variant / SUSPECTS % SUSPECTS], b = suspects[variant % SUSPECTS];
    pair[0] = a < b ? a : b, pair[1] = a < b ? b : a;
    return variant / SUSPECTS < variant % SUSPECTS && variant % SUSPECTS < n;
}

static bool suppose_exchange(Trial *t, const FfpCase *c, int variant) {
    int pair[2];
    if (!suspects_of(c, variant, pair)) return false;
    const FfpView *views = c->capture->views;
    return take_photographs(&t->capture.views[pair[0]], &views[pair[1]]) &&
           take_photographs(&t->capture.views[pair[1]], &views[pair[0]]);
}

// Of the one view with another.
static bool suppose_exchange_of_one(Trial *t, const FfpCase *c, int variant) {
    const FfpView *views = c->capture->views;
    return variant < c->capture->n_views && variant != c->view &&
           take_photographs(&t->capture.views[c->view], &views[variant]) &&
           take_photographs(&t->capture.views[variant], &views[c->view]);
}

// Of an object that slipped another view may show nothing that contradicts, but its silhouette does.
static bool exchange_agrees(const FfpCase *c, int variant) {
    Trial t = trial_new(c->capture, c->active);
    suppose_exchange_of_one(&t, c, variant);
    const bool fits = ffp_rig_silhouette_misfit(&t.capture) <= ffp_rig_silhouette_misfit(c->capture);
    ffp_arena_free(t.memory);
    return fits;
}

static FfpRuleId tell_exchange_of_one(const FfpCase *c, int variant, FfpFacts *facts) {
    facts->view = c->capture->views[c->view < variant ? c->view : variant].id;
    facts->other = c->capture->views[c->view < variant ? variant : c->view].id;
    return FFP_RULE_VIEWS_EXCHANGED;
}

static FfpRuleId tell_exchange(const FfpCase *c, int variant, FfpFacts *facts) {
    int pair[2];
    suspects_of(c, variant, pair);
    facts->view = c->capture->views[pair[0]].id;
    facts->other = c->capture->views[pair[1]].id;
    return FFP_RULE_VIEWS_EXCHANGED;
}

enum { PATTERN_BOTH_WAYS = 3, PHOTOGRAPHS_ACROSS = 3, PHOTOGRAPHS_DOWN, MIRRORS };

// The pattern, left to right, upside down and both; then the photographs.
static bool suppose_mirror(Trial *t, const FfpCase *c, int variant) {
    if (variant < PATTERN_BOTH_WAYS)
        t->guess.mirror = 1 + variant;
    else
        for (int v = 0; v < t->capture.n_views; v++)
            undo_in_view(t, v, c->active, variant == PHOTOGRAPHS_DOWN ? FLIPPED : MIRRORED);
    return true;
}

static FfpRuleId tell_mirror(const FfpCase *c, int variant, FfpFacts *facts) {
    static const char *const ways[MIRRORS] = {"left to right", "upside down", "both ways", "left to right",
                                              "upside down"};
    (void)c;
    facts->b = ways[variant];
    return variant < PATTERN_BOTH_WAYS ? FFP_RULE_PATTERN_MIRRORED : FFP_RULE_ALL_MIRRORED;
}

static bool suppose_red_and_blue(Trial *t, const FfpCase *c, int variant) {
    (void)c, (void)variant;
    t->guess.reversed = true;
    return true;
}

static FfpRuleId tell_red_and_blue(const FfpCase *c, int variant, FfpFacts *facts) {
    (void)c, (void)variant, (void)facts;
    return FFP_RULE_RED_AND_BLUE;
}

// Linear light that was read as sRGB, and sRGB that was read as linear light.
static bool suppose_encoding(Trial *t, const FfpCase *c, int variant) {
    const int shown[3] = {c->capture->black, c->capture->white, c->active};
    for (int v = 0; v < t->capture.n_views; v++) {
        FfpView *view = &t->capture.views[v];
        const FfpImage *taken = view->images;
        view->images = ffp_arena_alloc(t->memory, (size_t)t->capture.n_patterns, sizeof *view->images);
        for (int k = 0; k < 3; k++) {
            FfpImage *image = &view->images[shown[k]];
            *image = taken[shown[k]];
            if (!image->data) return false;
            const size_t n = 3 * (size_t)image->width * (size_t)image->height;
            image->data = ffp_arena_take(t->memory, n, sizeof *image->data);
            for (size_t i = 0; i < n; i++) {
                const real value = taken[shown[k]].data[i];
                image->data[i] = variant ? ffp_srgb_decode(value) : ffp_srgb_encode(value);
            }
        }
    }
    return true;
}

// Other values have another error by chance.
static bool encoding_agrees(const FfpCase *c, int variant) {
    Trial t = trial_new(c->capture, c->active);
    suppose_encoding(&t, c, variant);
    const double chance = ffp_chance_of(&t.capture, c->active, c->pattern, -1), error = light_in(&t, c);
    ffp_arena_free(t.memory);
    return error < FFP_LIGHT_EXPLAINED * chance;
}

static FfpRuleId tell_encoding(const FfpCase *c, int variant, FfpFacts *facts) {
    (void)c;
    facts->b = variant ? "sRGB" : "linear light";
    return FFP_RULE_ENCODING;
}

// Likewise.
static bool suppose_projector_size(Trial *t, const FfpCase *c, int variant) {
    (void)c;
    for (int v = 0; v < t->capture.n_views; v++)
        scale_device(&t->capture.views[v].projector, sizes[variant % 2]);
    if (variant > 1) ffp_capture_estimate_bounds(&t->capture);
    return true;
}

// Stripes are explained by chance as well: then it counts that light reaches what is lit, and did not before.
static double enough_to_reach(const FfpCase *c, const Trial *t) {
    const bool reaches =
        ffp_rig_unreached(c->capture) > UNREACHED_MOST && ffp_rig_unreached(&t->capture) < UNREACHED_LEAST;
    return reaches ? fmax(c->enough, fmin(FITS_WELL, 0.5 * c->error)) : c->enough;
}

static FfpRuleId tell_projector_size(const FfpCase *c, int variant, FfpFacts *facts) {
    const FfpCamera *p = &c->capture->views[0].projector;
    facts->b = size_names[variant % 2];
    facts->x = variant % 2 ? p->width / 2 : 2 * p->width;
    facts->y = variant % 2 ? p->height / 2 : 2 * p->height;
    return FFP_RULE_PROJECTOR_SIZE;
}

static void invert(const real from[16], real to[16]) {
    memcpy(to, from, 16 * sizeof *to);
    for (int i = 0; i < 3; i++) {
        to[4 * i + 3] = 0;
        for (int k = 0; k < 3; k++) {
            to[4 * i + k] = from[4 * k + i];
            to[4 * i + 3] -= from[4 * k + i] * from[4 * k + 3];
        }
    }
}

static void multiply(const real a[16], const real b[16], real out[16]) {
    memset(out, 0, 16 * sizeof *out);
    for (int i = 0; i < 16; i++)
        for (int k = 0; k < 4; k++) out[i] += a[i / 4 * 4 + k] * b[4 * k + i % 4];
}

// The projector's pose in the world; its motion from the camera, which a turntable carries along; and that
// motion's rotation alone.
static bool suppose_inverted(Trial *t, const FfpCase *c, int variant) {
    (void)c;
    for (int v = 0; v < t->capture.n_views; v++) {
        FfpView *view = &t->capture.views[v];
        real to_camera[16], motion[16], pose[16];
        if (variant == 0) {
            invert(view->projector.pose, pose);
        } else {
            invert(view->projector.pose, motion);
            multiply(motion, view->camera.pose, to_camera); // camera to projector
            if (variant == 1) {                             // where the reverse was meant
                multiply(view->camera.pose, to_camera, pose);
            } else {
                invert(to_camera, motion);
                for (int i = 3; i < 12; i += 4) motion[i] = to_camera[i];
                invert(motion, to_camera);
                multiply(view->camera.pose, to_camera, pose);
            }
        }
        memcpy(view->projector.pose, pose, sizeof pose);
    }
    return true;
}

static FfpRuleId tell_inverted(const FfpCase *c, int variant, FfpFacts *facts) {
    (void)c;
    facts->b = variant < 2 ? "poses" : "rotation";
    return FFP_RULE_PROJECTOR_INVERTED;
}

// Pattern number `variant` of the capture.
static bool suppose_pattern(Trial *t, const FfpCase *c, int variant) {
    const FfpCapture *capture = c->capture;
    if (variant >= ffp_patterns_shown(capture) || variant == c->active || variant == capture->black ||
        variant == capture->white || !capture->patterns[variant].image.data)
        return false;
    t->pattern = &capture->patterns[variant].image;
    return true;
}

static bool pattern_agrees(const FfpCase *c, int variant) {
    FfpSummed summed = ffp_summed_new(&c->capture->patterns[variant].image);
    const double chance = ffp_chance_of(c->capture, c->active, &summed, -1),
                 error = ffp_error_of(c->capture, c->active, (FfpGuess){.pattern = &summed});
    ffp_summed_free(&summed);
    return error < FFP_LIGHT_EXPLAINED * chance;
}

static FfpRuleId tell_pattern(const FfpCase *c, int variant, FfpFacts *facts) {
    facts->b = c->capture->patterns[variant].name;
    return FFP_RULE_OTHER_PATTERN;
}

static bool suppose_pattern_once(Trial *t, const FfpCase *c, int variant) {
    t->view = c->view;
    return suppose_pattern(t, c, variant);
}

static FfpRuleId tell_pattern_once(const FfpCase *c, int variant, FfpFacts *facts) {
    facts->view = c->capture->views[c->view].id;
    facts->b = c->capture->patterns[variant].name;
    return FFP_RULE_OTHER_PATTERN_ONCE;
}

// View number `variant` has the photograph under the pattern.
static bool suppose_photograph(Trial *t, const FfpCase *c, int variant) {
    if (variant >= c->capture->n_views || variant == c->view) return false;
    const FfpImage *photograph = &c->capture->views[variant].images[c->active];
    const FfpCamera *camera = &c->capture->views[c->view].camera;
    t->view = c->view;
    t->guess.photograph = photograph;
    return photograph->width == camera->width && photograph->height == camera->height;
}

// True if the odd view's photograph fits there, as it does where the two are exchanged: of an object that
// looks alike from both, the other's may fit here by its shape alone, whatever is wrong with the odd one.
static bool photograph_agrees(const FfpCase *c, int variant) {
    const FfpGuess guess = {.photograph = &c->capture->views[c->view].images[c->active],
                            .pattern = c->pattern};
    return light_of(c->capture, c->active, variant, guess) < c->enough;
}

static FfpRuleId tell_photograph(const FfpCase *c, int variant, FfpFacts *facts) {
    facts->view = c->capture->views[c->view].id;
    facts->other = c->capture->views[variant].id;
    return FFP_RULE_PATTERN_EXCHANGED;
}

enum { STOPS_A_FACTOR = 4, FACTORS = 13 }; // up to one and a half stops down and up, a quarter at a time

static double factor_of(int variant) {
    return pow(2, (double)(variant - FACTORS / 2) / STOPS_A_FACTOR);
}

// The view's photograph under the pattern, exposed as the others were.
static bool suppose_exposure(Trial *t, const FfpCase *c, int variant) {
    const FfpImage *taken = &c->capture->views[c->view].images[c->active];
    const size_t n = 3 * (size_t)taken->width * (size_t)taken->height;
    FfpImage *photograph = ffp_arena_take(t->memory, 1, sizeof *photograph);
    *photograph = *taken;
    photograph->data = ffp_arena_take(t->memory, n, sizeof *photograph->data);
    for (size_t i = 0; i < n; i++) photograph->data[i] = taken->data[i] / (real)factor_of(variant);
    t->view = c->view;
    t->guess.photograph = photograph;
    return variant != FACTORS / 2;
}

static FfpRuleId tell_exposure(const FfpCase *c, int variant, FfpFacts *facts) {
    facts->view = c->capture->views[c->view].id;
    facts->x = factor_of(variant);
    return FFP_RULE_EXPOSED_OTHERWISE;
}

// Tried in this order; of variants the best counts.
static const struct Hypothesis {
    FfpEvidence evidence;
    int variants;                                             // as many, of which some may be impossible
    bool (*suppose)(Trial *t, const FfpCase *c, int variant); // false: impossible
    bool (*agrees)(const FfpCase *c, int variant);            // what else has to be so; NULL: nothing
    double (*enough)(const FfpCase *c, const Trial *t);       // NULL: the case's
    FfpRuleId (*tell)(const FfpCase *c, int variant, FfpFacts *facts);
} hypotheses[] = {
    {FFP_VIEW_BY_SHAPE, MISHAPS, suppose_mishap, mishap_agrees, NULL, tell_mishap},
    {FFP_VIEWS_BY_SHAPE, 1, suppose_reversal, NULL, NULL, tell_reversal},
    {FFP_VIEWS_BY_SHAPE, 2, suppose_camera_size, size_agrees, NULL, tell_camera_size},
    {FFP_VIEWS_BY_SHAPE, SUSPECTS *SUSPECTS, suppose_exchange, NULL, NULL, tell_exchange},
    {FFP_VIEWS_BY_LIGHT, MIRRORS, suppose_mirror, NULL, NULL, tell_mirror},
    {FFP_VIEWS_BY_LIGHT, 1, suppose_red_and_blue, NULL, NULL, tell_red_and_blue},
    {FFP_VIEWS_BY_LIGHT, 4, suppose_projector_size, NULL, enough_to_reach, tell_projector_size},
    {FFP_VIEWS_BY_LIGHT, 3, suppose_inverted, NULL, NULL, tell_inverted},
    {FFP_VIEWS_BY_LIGHT, 4, suppose_camera_size, NULL, NULL, tell_camera_size},
    {FFP_VALUES_BY_LIGHT, 2, suppose_encoding, encoding_agrees, NULL, tell_encoding},
    {FFP_VIEWS_BY_LIGHT, FFP_PATTERNS_MAX, suppose_pattern, pattern_agrees, NULL, tell_pattern},
    {FFP_VIEW_BY_LIGHT, MISHAPS, suppose_mishap_alone, mishap_fits, NULL, tell_mishap},
    {FFP_VIEW_BY_LIGHT, FFP_VIEWS_MAX, suppose_photograph, photograph_agrees, NULL, tell_photograph},
    {FFP_VIEW_BY_LIGHT, FFP_PATTERNS_MAX, suppose_pattern_once, NULL, NULL, tell_pattern_once},
    {FFP_VIEW_BY_LIGHT, FACTORS, suppose_exposure, NULL, NULL, tell_exposure},
    {FFP_VIEWS_BY_DEPTH, 1, suppose_reversal, NULL, NULL, tell_reversal},
    {FFP_VIEW_BY_DEPTH, EXCHANGES, suppose_exchange_of_one, exchange_agrees, NULL, tell_exchange_of_one},
};

// --- The loop. ---

// Views that show nothing of one surface any more explain nothing.
static double pairs_apart(const Trial *t, const FfpCase *c) {
    const FfpSlip slip = ffp_rig_slip(&t->capture, c->active);
    return slip.compared < c->compared ? INFINITY : slip.pairs;
}

// The rest of the contradiction that a variant leaves; not below `least` or the case's `enough`: INFINITY.
static double left_by(const struct Hypothesis *h, const FfpCase *c, int variant, double least) {
    Trial t = trial_new(c->capture, c->active);
    double left = INFINITY;
    if (h->suppose(&t, c, variant)) {
        const bool by_shape = h->evidence == FFP_VIEW_BY_SHAPE || h->evidence == FFP_VIEWS_BY_SHAPE;
        left = by_shape                           ? ffp_rig_misfit_below(&t.capture, c->enough)
               : h->evidence >= FFP_VIEW_BY_DEPTH ? pairs_apart(&t, c)
                                                  : light_in(&t, c);
        // Mirrored photographs and a mirrored pattern look alike from above the projector.
        if (h->suppose == suppose_mirror && variant >= PHOTOGRAPHS_ACROSS) left /= CLEARLY;
        if (!(left < least) || !(left < (h->enough ? h->enough(c, &t) : c->enough))) left = INFINITY;
    }
    ffp_arena_free(t.memory);
    return left;
}

bool ffp_hypotheses_try(FfpFindings *found, FfpEvidence evidence, const FfpCase *c) {
    for (size_t i = 0; i < sizeof hypotheses / sizeof *hypotheses; i++) {
        const struct Hypothesis *h = &hypotheses[i];
        double least = INFINITY;
        int best = -1;
        for (int variant = 0; variant < h->variants && h->evidence == evidence; variant++) {
            const double left = left_by(h, c, variant, least);
            if (!(left < least)) continue;
            least = left;
            best = variant;
        }
        if (best < 0 || (h->agrees && !h->agrees(c, best))) continue;
        FfpFacts facts = {.figure = least, .limit = c->enough};
        char panel[32];
        const FfpCamera *p = &c->capture->views[0].projector;
        snprintf(panel, sizeof panel, "%d x %d", p->width, p->height);
        facts.c = panel;
        if (c->active >= 0) facts.a = c->capture->patterns[c->active].name;
        const FfpRuleId rule = h->tell(c, best, &facts);
        return ffp_found(found, rule, &facts);
    }
    return true;
}
