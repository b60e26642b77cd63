#include "rig/checks/hypotheses.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/rigid.h"
#include "core/image/codec.h"
#include "rig/checks/slip.h"

#define CLEARLY 0.8          // of a mirrored pattern's error: what mirrored photographs must leave at most
#define PREFERRED 0.7        // likewise of a camera's size as it is
#define FITS_WELL 0.08       // error of colours that are looked up rightly, at most
#define UNREACHED_MOST 0.1   // of the lit pixels, where no light can be: more than that before, and
#define UNREACHED_LEAST 0.02 // less than that after
#define EXCHANGES 16         // views with which one may be exchanged by its surface, which takes long
#define SUSPECTS 8 // views of which two may be exchanged: the time to try them does not grow with the views

// Orientations that undo mishaps, as the tags of files count them (core/image/codec.h).
enum { MIRRORED = 2, HALF_TURN, FLIPPED, TO_THE_LEFT = 6, TO_THE_RIGHT = 8 };
enum { MISHAPS = 5 };
static const int mishaps[MISHAPS] = {HALF_TURN, TO_THE_LEFT, TO_THE_RIGHT, MIRRORED, FLIPPED};
static const char *const mishap_names[MISHAPS] = {"turned by 180 degrees", "turned by 90 degrees to the left",
                                                  "turned by 90 degrees to the right",
                                                  "mirrored left to right", "mirrored upside down"};

// --- A capture as it would be. ---

typedef struct Trial {
    FfpCapture capture; // its views are its own; what they point to is the given capture's, or in `memory`
    FfpArena *memory;
    const FfpImage *pattern; // to be looked up
    FfpGuess guess;
    int view;       // whose light alone is looked at; -1: all
    double clearly; // of the error that is left: 1, or less for a variant that looks like another
} Trial;

static Trial trial_new(const FfpCapture *capture, int active) {
    Trial t = {.capture = *capture, .memory = ffp_arena_new(), .view = -1, .clearly = 1};
    const size_t n = (size_t)capture->n_views;
    t.capture.views = ffp_arena_take(t.memory, n, sizeof *t.capture.views);
    memcpy(t.capture.views, capture->views, n * sizeof *t.capture.views);
    t.pattern = active >= 0 ? &capture->patterns[active].image : NULL;
    return t;
}

static FfpImage undone(FfpArena *memory, const FfpImage *image, int orientation) {
    FfpImage out = *image;
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    out.data = ffp_arena_take(memory, pixels * (size_t)image->channels, sizeof *out.data);
    ffp_orient_into(out.data, image, orientation);
    return out;
}

// The pictures that structured light is judged by, and the mask. False: a quarter turn would change their
// shape.
static bool undo_in_view(Trial *t, int v, int active, int orientation) {
    FfpView *view = &t->capture.views[v];
    const FfpImage *taken = view->images;
    const int shown[3] = {t->capture.black, t->capture.white, active};
    if (orientation >= TO_THE_LEFT && view->coverage.width != view->coverage.height) return false;
    view->coverage = undone(t->memory, &view->coverage, orientation);
    if (active < 0) return true;
    view->images = ffp_arena_alloc(t->memory, (size_t)t->capture.n_patterns, sizeof *view->images);
    for (int k = 0; k < 3; k++) view->images[shown[k]] = undone(t->memory, &taken[shown[k]], orientation);
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

static double light_in(const Trial *t, const FfpCase *c) {
    FfpGuess guess = t->guess;
    FfpSummed summed = {0};
    guess.pattern = c->pattern;
    if (t->pattern != &c->capture->patterns[c->active].image) {
        summed = ffp_summed_new(t->pattern);
        guess.pattern = &summed;
    }
    const double error = ffp_error_of(&t->capture, c->active, t->view, guess);
    if (guess.pattern == &summed) ffp_summed_free(&summed);
    return error;
}

// True if structured light explains a view as well or better once the mishap is undone: of objects that are
// nearly symmetric, silhouettes alone would accept a mirrored view for a wrong mask.
static bool light_agrees(const FfpCase *c, int view, int orientation) {
    if (c->active < 0) return true;
    Trial t = trial_new(c->capture, c->active);
    t.view = view;
    const double before = light_in(&t, c);
    undo_in_view(&t, view, c->active, orientation);
    const double after = light_in(&t, c);
    ffp_arena_free(t.memory);
    return !(after > before);
}

// --- The hypotheses. ---

static bool suppose_mishap(Trial *t, const FfpCase *c, int variant) {
    return undo_in_view(t, c->view, c->active, mishaps[variant]);
}

static bool mishap_agrees(const Trial *t, const FfpCase *c, int variant) {
    (void)t;
    return light_agrees(c, c->view, mishaps[variant]);
}

// Found by the view's light alone; but where silhouettes accuse this view alone, they must fit as well.
static bool mishap_fits(const Trial *t, const FfpCase *c, int variant) {
    FfpSilhouettes shapes = ffp_rig_silhouettes(c->capture);
    (void)variant;
    const bool fits =
        shapes.odd != c->view || ffp_rig_silhouette_misfit(&t->capture) < FFP_RIG_EXPLAINED * shapes.misfit;
    ffp_rig_silhouettes_free(&shapes);
    return fits;
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
static FfpRuleId rule_of_reversal(const FfpCase *c, int variant) {
    int agree = 0;
    (void)variant;
    for (int v = 0; c->active >= 0 && v < c->capture->n_views; v++) agree += light_agrees(c, v, MIRRORED);
    return 2 * agree > c->capture->n_views ? FFP_RULE_ALL_MIRRORED : FFP_RULE_OTHER_DIRECTION;
}

static const real sizes[4] = {0.5F, 2, 0.5F, 2};
static const char *const size_names[4] = {"half", "twice", "half", "twice"};

// Half and twice; and with the object's bounds estimated again, which may come from the wrong size.
static bool suppose_camera_size(Trial *t, const FfpCase *c, int variant) {
    (void)c;
    for (int v = 0; v < t->capture.n_views; v++) scale_device(&t->capture.views[v].camera, sizes[variant]);
    if (variant > 1) ffp_capture_estimate_bounds(&t->capture);
    return true;
}

static bool suppose_projector_size(Trial *t, const FfpCase *c, int variant) {
    (void)c;
    for (int v = 0; v < t->capture.n_views; v++) scale_device(&t->capture.views[v].projector, sizes[variant]);
    if (variant > 1) ffp_capture_estimate_bounds(&t->capture);
    return true;
}

// True if structured light explains the views clearly better in that size: masks that are wrong fit some
// sizes better, too.
static bool size_agrees(const Trial *t, const FfpCase *c, int variant) {
    const FfpGuess guess = {.pattern = c->pattern};
    double before = 0, after = 0;
    (void)variant;
    if (c->active < 0) return true;
    for (int v = 0; v < c->capture->n_views; v++) {
        const double a = ffp_error_of(c->capture, c->active, v, guess),
                     b = ffp_error_of(&t->capture, c->active, v, guess);
        if (isnan(b)) continue;
        before += isnan(a) ? 1 : a; // rays that miss the object explain nothing
        after += b;
    }
    return after > 0 && after < PREFERRED * before;
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

// By shape a pair of the suspects; by depth the one view and view number `variant`.
static bool pair_of(const FfpCase *c, int variant, int pair[2]) {
    if (c->shapes) return suspects_of(c, variant, pair);
    pair[0] = c->view < variant ? c->view : variant, pair[1] = c->view < variant ? variant : c->view;
    return variant < c->capture->n_views && variant != c->view;
}

static bool suppose_exchange(Trial *t, const FfpCase *c, int variant) {
    int pair[2];
    if (!pair_of(c, variant, pair)) return false;
    const FfpView *views = c->capture->views;
    return take_photographs(&t->capture.views[pair[0]], &views[pair[1]]) &&
           take_photographs(&t->capture.views[pair[1]], &views[pair[0]]);
}

// Of an object that slipped another view may show nothing that contradicts, but its silhouette does.
static bool exchange_agrees(const Trial *t, const FfpCase *c, int variant) {
    (void)variant;
    return ffp_rig_silhouette_misfit(&t->capture) <= ffp_rig_silhouette_misfit(c->capture);
}

static void tell_exchange(const FfpCase *c, int variant, FfpFacts *facts) {
    int pair[2];
    pair_of(c, variant, pair);
    facts->view = c->capture->views[pair[0]].id;
    facts->other = c->capture->views[pair[1]].id;
}

enum { PATTERN_WAYS = 3, PHOTOGRAPHS_ACROSS = 3, PHOTOGRAPHS_DOWN, MIRRORS };
static const char *const ways[MIRRORS] = {"left to right", "upside down", "both ways", "left to right",
                                          "upside down"};

// The pattern, left to right, upside down and both; then the photographs.
static bool suppose_mirror(Trial *t, const FfpCase *c, int variant) {
    if (variant < PATTERN_WAYS) {
        t->guess.mirror = 1 + variant;
        return true;
    }
    t->clearly = CLEARLY; // from above the projector a mirrored pattern looks like mirrored photographs
    for (int v = 0; v < t->capture.n_views; v++)
        undo_in_view(t, v, c->active, variant == PHOTOGRAPHS_DOWN ? FLIPPED : MIRRORED);
    return true;
}

static FfpRuleId rule_of_mirror(const FfpCase *c, int variant) {
    (void)c;
    return variant < PATTERN_WAYS ? FFP_RULE_PATTERN_MIRRORED : FFP_RULE_ALL_MIRRORED;
}

static bool suppose_red_and_blue(Trial *t, const FfpCase *c, int variant) {
    (void)c, (void)variant;
    t->guess.reversed = true;
    return true;
}

static const char *const encodings[2] = {"linear light", "sRGB"};

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
static bool encoding_agrees(const Trial *t, const FfpCase *c, int variant) {
    (void)variant;
    return light_in(t, c) < FFP_LIGHT_EXPLAINED * ffp_chance_of(&t->capture, c->active, c->pattern, -1);
}

// Stripes are explained by chance as well: then it counts that light reaches what is lit, and did not before.
static double enough_to_reach(const FfpCase *c, const Trial *t) {
    const bool reaches =
        ffp_rig_unreached(c->capture) > UNREACHED_MOST && ffp_rig_unreached(&t->capture) < UNREACHED_LEAST;
    return reaches ? fmax(c->enough, fmin(FITS_WELL, 0.5 * c->error)) : c->enough;
}

static void tell_projector_size(const FfpCase *c, int variant, FfpFacts *facts) {
    const FfpCamera *p = &c->capture->views[0].projector;
    facts->x = variant % 2 ? p->width / 2 : 2 * p->width;
    facts->y = variant % 2 ? p->height / 2 : 2 * p->height;
}

static const char *const inverted_names[3] = {"poses", "poses", "rotation"};

// The projector's pose in the world; its motion from the camera, which a turntable carries along; and that
// motion's rotation alone.
static bool suppose_inverted(Trial *t, const FfpCase *c, int variant) {
    (void)c;
    for (int v = 0; v < t->capture.n_views; v++) {
        FfpView *view = &t->capture.views[v];
        const FfpRigid camera = ffp_rigid_from_pose(view->camera.pose),
                       projector = ffp_rigid_from_pose(view->projector.pose);
        FfpRigid pose, motion, back;
        ffp_rigid_inverse(&projector, &pose);
        if (variant > 0) {
            ffp_rigid_product(&pose, &camera, &motion); // camera to projector, where the reverse was meant
            if (variant == 2) {
                ffp_rigid_inverse(&motion, &back);
                memcpy(back.t, motion.t, sizeof back.t);
                ffp_rigid_inverse(&back, &motion);
            }
            ffp_rigid_product(&camera, &motion, &pose);
        }
        ffp_rigid_store(&pose, view->projector.pose);
    }
    return true;
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

static bool pattern_agrees(const Trial *t, const FfpCase *c, int variant) {
    FfpSummed summed = ffp_summed_new(&c->capture->patterns[variant].image);
    const double chance = ffp_chance_of(c->capture, c->active, &summed, -1),
                 error = ffp_error_of(c->capture, c->active, -1, (FfpGuess){.pattern = &summed});
    (void)t;
    ffp_summed_free(&summed);
    return error < FFP_LIGHT_EXPLAINED * chance;
}

static void tell_pattern(const FfpCase *c, int variant, FfpFacts *facts) {
    facts->b = c->capture->patterns[variant].name;
}

// View number `variant` has the photograph under the pattern.
static bool suppose_photograph(Trial *t, const FfpCase *c, int variant) {
    if (variant >= c->capture->n_views || variant == c->view) return false;
    const FfpImage *photograph = &c->capture->views[variant].images[c->active];
    const FfpCamera *camera = &c->capture->views[c->view].camera;
    t->guess.photograph = photograph;
    return photograph->width == camera->width && photograph->height == camera->height;
}

// True if the odd view's photograph fits there, as it does where the two are exchanged: of an object that
// looks alike from both, the other's may fit here by its shape alone, whatever is wrong with the odd one.
static bool photograph_agrees(const Trial *t, const FfpCase *c, int variant) {
    const FfpGuess guess = {.photograph = &c->capture->views[c->view].images[c->active],
                            .pattern = c->pattern};
    (void)t;
    return ffp_error_of(c->capture, c->active, variant, guess) < c->enough;
}

static void tell_photograph(const FfpCase *c, int variant, FfpFacts *facts) {
    facts->other = c->capture->views[variant].id;
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
    t->guess.photograph = photograph;
    return variant != FACTORS / 2;
}

static void tell_exposure(const FfpCase *c, int variant, FfpFacts *facts) {
    (void)c;
    facts->x = factor_of(variant);
}

// Tried in this order; of variants the best counts.
static const struct Hypothesis {
    FfpEvidence evidence;
    int variants;                                                  // of which some may be impossible
    bool (*suppose)(Trial *t, const FfpCase *c, int variant);      // false: impossible
    FfpRuleId rule;                                                // of all variants,
    FfpRuleId (*rule_of)(const FfpCase *c, int variant);           // or of each
    bool (*agrees)(const Trial *t, const FfpCase *c, int variant); // what else has to be so; NULL: nothing
    double (*enough)(const FfpCase *c, const Trial *t);            // NULL: the case's
    const char *const *a, *const *b;                               // [variants] what is put for {a} or {b},
    void (*tell)(const FfpCase *c, int variant, FfpFacts *facts);  // and the rest
} hypotheses[] = {
    {FFP_VIEW_BY_SHAPE, MISHAPS, suppose_mishap, FFP_RULE_VIEW_TURNED, .agrees = mishap_agrees,
     .a = mishap_names},
    {FFP_VIEWS_BY_SHAPE, 1, suppose_reversal, .rule_of = rule_of_reversal, .b = ways},
    {FFP_VIEWS_BY_SHAPE, 2, suppose_camera_size, FFP_RULE_CAMERA_SIZE, .agrees = size_agrees,
     .a = size_names},
    {FFP_VIEWS_BY_SHAPE, SUSPECTS *SUSPECTS, suppose_exchange, FFP_RULE_VIEWS_EXCHANGED,
     .tell = tell_exchange},
    {FFP_VIEWS_BY_LIGHT, MIRRORS, suppose_mirror, .rule_of = rule_of_mirror, .b = ways},
    {FFP_VIEWS_BY_LIGHT, 1, suppose_red_and_blue, .rule = FFP_RULE_RED_AND_BLUE},
    {FFP_VIEWS_BY_LIGHT, 4, suppose_projector_size, FFP_RULE_PROJECTOR_SIZE, .enough = enough_to_reach,
     .b = size_names, .tell = tell_projector_size},
    {FFP_VIEWS_BY_LIGHT, 3, suppose_inverted, FFP_RULE_PROJECTOR_INVERTED, .b = inverted_names},
    {FFP_VIEWS_BY_LIGHT, 4, suppose_camera_size, FFP_RULE_CAMERA_SIZE, .a = size_names},
    {FFP_VALUES_BY_LIGHT, 2, suppose_encoding, FFP_RULE_ENCODING, .agrees = encoding_agrees, .b = encodings},
    {FFP_VIEWS_BY_LIGHT, FFP_PATTERNS_MAX, suppose_pattern, FFP_RULE_OTHER_PATTERN, .agrees = pattern_agrees,
     .tell = tell_pattern},
    {FFP_VIEW_BY_LIGHT, MISHAPS, suppose_mishap, FFP_RULE_VIEW_TURNED, .agrees = mishap_fits,
     .a = mishap_names},
    {FFP_VIEW_BY_LIGHT, FFP_VIEWS_MAX, suppose_photograph, FFP_RULE_PATTERN_EXCHANGED,
     .agrees = photograph_agrees, .tell = tell_photograph},
    {FFP_VIEW_BY_LIGHT, FFP_PATTERNS_MAX, suppose_pattern, FFP_RULE_OTHER_PATTERN_ONCE, .tell = tell_pattern},
    {FFP_VIEW_BY_LIGHT, FACTORS, suppose_exposure, FFP_RULE_EXPOSED_OTHERWISE, .tell = tell_exposure},
    {FFP_VIEWS_BY_DEPTH, 1, suppose_reversal, .rule_of = rule_of_reversal, .b = ways},
    {FFP_VIEW_BY_DEPTH, EXCHANGES, suppose_exchange, FFP_RULE_VIEWS_EXCHANGED, .agrees = exchange_agrees,
     .tell = tell_exchange},
};

// --- The loop. ---

// Views that show nothing of one surface any more explain nothing.
static double pairs_apart(const Trial *t, const FfpCase *c) {
    const FfpSlip slip = ffp_rig_slip(&t->capture, c->active);
    return slip.compared < c->compared ? INFINITY : slip.pairs;
}

static bool is_of_one_view(FfpEvidence evidence) {
    return evidence == FFP_VIEW_BY_SHAPE || evidence == FFP_VIEW_BY_LIGHT || evidence == FFP_VIEW_BY_DEPTH;
}

static Trial trial_of(const struct Hypothesis *h, const FfpCase *c) {
    Trial t = trial_new(c->capture, c->active);
    if (is_of_one_view(h->evidence)) t.view = c->view;
    return t;
}

// The rest of the contradiction that a variant leaves; not below `least` or the case's `enough`: INFINITY.
static double left_by(const struct Hypothesis *h, const FfpCase *c, int variant, double least) {
    Trial t = trial_of(h, c);
    double left = INFINITY;
    if (h->suppose(&t, c, variant)) {
        const bool by_shape = h->evidence == FFP_VIEW_BY_SHAPE || h->evidence == FFP_VIEWS_BY_SHAPE;
        left = by_shape                           ? ffp_rig_misfit_below(&t.capture, c->enough)
               : h->evidence >= FFP_VIEW_BY_DEPTH ? pairs_apart(&t, c)
                                                  : light_in(&t, c);
        left /= t.clearly;
        if (!(left < least) || !(left < (h->enough ? h->enough(c, &t) : c->enough))) left = INFINITY;
    }
    ffp_arena_free(t.memory);
    return left;
}

static bool agrees(const struct Hypothesis *h, const FfpCase *c, int variant) {
    if (!h->agrees) return true;
    Trial t = trial_of(h, c);
    h->suppose(&t, c, variant);
    const bool agreed = h->agrees(&t, c, variant);
    ffp_arena_free(t.memory);
    return agreed;
}

static bool tell(FfpFindings *found, const struct Hypothesis *h, const FfpCase *c, int variant, double left) {
    FfpFacts facts = {.figure = left, .limit = c->enough};
    char panel[32];
    const FfpCamera *p = &c->capture->views[0].projector;
    snprintf(panel, sizeof panel, "%d x %d", p->width, p->height);
    facts.c = panel;
    if (c->active >= 0) facts.a = c->capture->patterns[c->active].name;
    if (is_of_one_view(h->evidence)) facts.view = c->capture->views[c->view].id;
    if (h->a) facts.a = h->a[variant];
    if (h->b) facts.b = h->b[variant];
    if (h->tell) h->tell(c, variant, &facts);
    return ffp_found(found, h->rule_of ? h->rule_of(c, variant) : h->rule, &facts);
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
        if (best >= 0 && agrees(h, c, best)) return tell(found, h, c, best, least);
    }
    return true;
}
