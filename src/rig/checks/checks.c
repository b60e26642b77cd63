#include "rig/checks/checks.h"
#include <math.h>
#include "core/base/alloc.h"
#include "rig/checks/hypotheses.h"
#include "rig/checks/slip.h"

#define FITS 0.8   // of the error: what explains so much better is right
#define MOVED 0.85 // likewise with the pattern moved
#define VIEWS_LEAST 6

// Adds the rule of what is ok or that of what is not.
static void look(FfpFindings *found, bool good, FfpRuleId right, FfpRuleId wrong, const FfpFacts *facts) {
    ffp_found(found, good ? right : wrong, facts);
}

static double share(double part, double whole) {
    return whole > 0 ? part / whole : 0;
}

static void check_frusta(FfpFindings *found, const FfpCapture *capture, const FfpLights *lights) {
    const FfpFrusta frusta = ffp_rig_frusta(capture);
    look(found, ffp_rig_frusta_hold(frusta), FFP_RULE_FRUSTA,
         !frusta.ahead                           ? FFP_RULE_OBJECT_BEHIND
         : frusta.camera <= FFP_RIG_CAMERA_LEAST ? FFP_RULE_OBJECT_CUT_OFF
                                                 : FFP_RULE_PATTERN_TOO_SMALL,
         &(FfpFacts){.x = frusta.camera, .y = frusta.projector});
    const double unreached = share(lights->all.unreached, lights->all.lit);
    look(found, unreached < ffp_rule(FFP_RULE_LIT_PIXELS)->limit, FFP_RULE_LIT_PIXELS,
         FFP_RULE_LIT_WHERE_NONE, &(FfpFacts){.figure = unreached});
}

static void check_silhouettes(FfpFindings *found, const FfpCapture *capture) {
    FfpSilhouettes shapes = ffp_rig_silhouettes(capture);
    const bool odd = shapes.odd >= 0;
    look(found, shapes.misfit < ffp_rule(FFP_RULE_SILHOUETTES)->limit && !odd, FFP_RULE_SILHOUETTES,
         odd ? FFP_RULE_VIEW_CONTRADICTS : FFP_RULE_VIEWS_CONTRADICT,
         &(FfpFacts){.view = odd ? capture->views[shapes.odd].id : NULL,
                     .figure = shapes.misfit,
                     .x = shapes.without});
    ffp_rig_silhouettes_free(&shapes);
}

static void check_light(FfpFindings *found, const FfpLights *lights) {
    const double clipped = share(lights->all.clipped, lights->all.object),
                 reversed = share(lights->all.reversed, lights->all.object), bright = (double)lights->bright;
    look(found, clipped < ffp_rule(FFP_RULE_CLIPPING)->limit, FFP_RULE_CLIPPING, FFP_RULE_CLIPPED,
         &(FfpFacts){.figure = clipped});
    look(found, bright > ffp_rule(FFP_RULE_EXPOSURE)->limit, FFP_RULE_EXPOSURE, FFP_RULE_UNDEREXPOSED,
         &(FfpFacts){.figure = bright});
    look(found, reversed < ffp_rule(FFP_RULE_BLACK_LEVEL)->limit, FFP_RULE_BLACK_LEVEL, FFP_RULE_WHITE_DARKER,
         &(FfpFacts){.figure = reversed});
}

static void check_guesses(FfpFindings *found, const FfpCapture *capture, const FfpLights *lights) {
    const double guessed = share(lights->all.guessed, lights->all.object);
    int worst = 0;
    double most = -1;
    for (int v = 0; v < capture->n_views; v++) {
        const double own = share(lights->views[v].guessed, lights->views[v].object);
        if (own <= most) continue;
        most = own;
        worst = v;
    }
    if (guessed > ffp_rule(FFP_RULE_GUESSED)->limit)
        ffp_found(found, FFP_RULE_GUESSED,
                  &(FfpFacts){.view = capture->views[worst].id, .figure = guessed, .x = most});
}

// --- Against the rigs of training (world/synth/rig.c), as they look once the object's sphere has radius 1.
// ---

typedef struct Trained {
    double low, high;   // of training: turntables and free rigs
    double least, most; // what is ok: beyond, results are worse or were not looked at
} Trained;

enum { AMBIENT = FFP_RIG_NUMBERS };
// Rooms of `generate --room` have cameras 8 and projectors 7.8 radii away with fields of 20.9 degrees. There
// the model is as good as the classical start: at new turns of ten rooms by -0.8 to 0.2 dB over the object,
// 0.1 less in the mean, and by -0.4 to 0.6 dB over the picture, 0.2 more in the mean.
static const Trained trained[] = {
    [FFP_RIG_CAMERA_DISTANCE] = {2.8, 3.6, 2.3, 8.1},
    [FFP_RIG_PROJECTOR_DISTANCE] = {1.8, 2.5, 1.2, 7.9},
    [FFP_RIG_CAMERA_HEIGHT] = {-40, 50, -48, 58},
    [FFP_RIG_BETWEEN] = {15, 63, 10, 68},
    [FFP_RIG_CAMERA_FIELD] = {34, 46, 20, 60},
    [FFP_RIG_PROJECTOR_FIELD] = {55, 55, 20.9, 85},
    [FFP_RIG_ROLL] = {-5, 5, -10, 10},
    [AMBIENT] = {0.07, 0.66, 0, 0.73},
};
// A rule for each, in the same order, and another where it is unusual.
_Static_assert(FFP_RULE_AMBIENT - FFP_RULE_CAMERA_DISTANCE == AMBIENT &&
                   FFP_RULE_UNUSUAL - FFP_RULE_CAMERA_DISTANCE == AMBIENT + 1 &&
                   FFP_RULE_ROLL - FFP_RULE_CAMERA_DISTANCE == FFP_RIG_ROLL,
               "the rules of the rig's numbers are in their order");

static void compare(FfpFindings *found, int which, FfpRange range) {
    const Trained *t = &trained[which];
    const bool good = range.low >= t->least && range.high <= t->most;
    const double low = round(range.low * 100) / 100, high = round(range.high * 100) / 100;
    char seen[64], of_training[64], limits[64] = ""; // the latter are told where they decide
    if (low == high)
        snprintf(seen, sizeof seen, "%g", high);
    else
        snprintf(seen, sizeof seen, "%g to %g", low, high);
    if (t->low == t->high)
        snprintf(of_training, sizeof of_training, "%.3g", t->low);
    else
        snprintf(of_training, sizeof of_training, "%.3g to %.3g", t->low, t->high);
    if (low < t->low || high > t->high)
        snprintf(limits, sizeof limits, "; ok from %.3g to %.3g", t->least, t->most);
    const FfpRuleId rule = (FfpRuleId)(FFP_RULE_CAMERA_DISTANCE + which);
    const double beyond = fmax(t->low - range.low, range.high - t->high); // the end that is farther out
    look(found, good, rule, (FfpRuleId)(FFP_RULE_UNUSUAL + which),
         &(FfpFacts){.a = seen,
                     .b = of_training,
                     .c = limits,
                     .figure = beyond == range.high - t->high ? range.high : range.low});
}

static void check_rig(FfpFindings *found, const FfpCapture *capture, const FfpCamera *taken,
                      const FfpLights *lights) {
    FfpRange ranges[FFP_RIG_NUMBERS];
    const double gap = ffp_rig_widest_gap(capture), ambient = (double)lights->ambient;
    ffp_rig_ranges(capture, ranges);
    // One view stands on no turntable: its height and roll say nothing of an axis.
    for (int i = 0; i < FFP_RIG_NUMBERS; i++)
        if (capture->n_views > 1 || (i != FFP_RIG_CAMERA_HEIGHT && i != FFP_RIG_ROLL))
            compare(found, i, ranges[i]);
    compare(found, AMBIENT, (FfpRange){ambient, ambient});
    look(found, capture->n_views >= VIEWS_LEAST && gap < ffp_rule(FFP_RULE_VIEWS)->limit, FFP_RULE_VIEWS,
         FFP_RULE_FEW_VIEWS, &(FfpFacts){.x = capture->n_views, .figure = gap});
    const double side = sqrt((double)taken->width * taken->height);
    const bool small = side<ffp_rule(FFP_RULE_SMALL)->limit, large = side> ffp_rule(FFP_RULE_LARGE)->limit;
    look(found, !small && !large, FFP_RULE_SIZE, large ? FFP_RULE_LARGE : FFP_RULE_SMALL,
         &(FfpFacts){.x = taken->width, .y = taken->height, .figure = side});
}

// --- The pattern. ---

// Tries people's mistakes; false if one explains the pictures.
static bool try_hypotheses(FfpFindings *found, const FfpCapture *capture, int active) {
    FfpSummed pattern = ffp_summed_new(&capture->patterns[active].image);
    FfpCase c = {.capture = capture, .active = active, .pattern = &pattern, .view = -1};
    c.error = ffp_error_of(capture, active, -1, (FfpGuess){.pattern = &pattern});
    c.chance = ffp_chance_of(capture, active, &pattern, -1);
    c.enough = FITS * fmin(c.error, FFP_RIG_CHANCE_MAX * c.chance);
    const bool none = ffp_hypotheses_try(found, FFP_VIEWS_BY_LIGHT, &c) &&
                      ffp_hypotheses_try(found, FFP_VALUES_BY_LIGHT, &c);
    ffp_summed_free(&pattern);
    return none;
}

// Views whose correspondences give depth, whatever patterns there are.
static int count_coded(const FfpCapture *capture) {
    int n = 0;
    for (int v = 0; v < capture->n_views; v++) n += capture->views[v].correspondence.data != NULL;
    return n;
}

static void check_pattern(FfpFindings *found, const FfpCapture *capture) {
    const int active = ffp_capture_active_pattern(capture, NULL, NULL);
    const FfpExplanation e = active >= 0 ? ffp_rig_explain(capture, active) : (FfpExplanation){0};
    char by[64];
    if (e.pixels == 0) {
        const int coded = count_coded(capture);
        ffp_found(found, coded == capture->n_views ? FFP_RULE_CODED : FFP_RULE_NONE_LIT,
                  &(FfpFacts){.x = coded});
        return;
    }
    if (e.error < FFP_RIG_SHOWN && !ffp_rig_tells(capture, active)) {
        ffp_found(found, FFP_RULE_PATTERN_BLIND,
                  &(FfpFacts){.a = capture->patterns[active].name, .figure = e.error, .x = e.pixels});
        return;
    }
    const double chance = FFP_RIG_CHANCE_MAX * e.chance;
    const bool moved = e.best < MOVED * e.error && e.best < chance;
    const bool spoilt = e.odd >= 0 && e.odd_across == 0; // the others fit
    const bool nothing = !moved && !spoilt && e.error > chance;
    const bool odd = !moved && !nothing && e.odd >= 0;
    const bool mirrored = e.mirrored < FITS * e.error;
    if ((mirrored || moved || nothing || odd) && !try_hypotheses(found, capture, active)) return;
    snprintf(by, sizeof by, "%.0f, %.0f", round(e.across * e.direction[0]), round(e.across * e.direction[1]));
    ffp_found(found,
              moved     ? FFP_RULE_PATTERN_MOVED
              : nothing ? FFP_RULE_CHANCE
              : !odd    ? FFP_RULE_PATTERN
              : spoilt  ? FFP_RULE_VIEW_SPOILT
                        : FFP_RULE_VIEW_MOVED,
              &(FfpFacts){.view = odd ? capture->views[e.odd].id : NULL,
                          .a = capture->patterns[active].name,
                          .b = by,
                          .figure = e.error,
                          .limit = chance,
                          .x = e.pixels,
                          .y = e.chance,
                          .z = odd ? fabs(e.odd_across) : e.best});
}

// --- What moved, and what is not sharp. ---

static void check_focus(FfpFindings *found, const FfpCapture *capture) {
    const int active = ffp_capture_active_pattern(capture, NULL, NULL);
    double left = 1;
    const int odd = active < 0 ? -1 : ffp_rig_blurred(capture, active, &left);
    if (odd < 0 || left >= ffp_rule(FFP_RULE_BLURRED)->limit) return;
    ffp_found(found, FFP_RULE_BLURRED, &(FfpFacts){.view = capture->views[odd].id, .figure = left});
}

static void check_surfaces(FfpFindings *found, const FfpCapture *capture) {
    const int active = ffp_capture_active_pattern(capture, NULL, NULL);
    if (active < 0 || !ffp_rig_tells(capture, active)) return; // nor what depths are
    const FfpSlip slip = ffp_rig_slip(capture, active);
    if (slip.compared == 0) return;
    const int first = slip.first < 0 ? slip.pair : slip.first,
              last = slip.first < 0 ? (slip.pair + 1) % capture->n_views : slip.last;
    FfpSummed pattern = ffp_summed_new(&capture->patterns[active].image);
    const FfpCase c = {.capture = capture,
                       .active = active,
                       .pattern = &pattern,
                       .view = first,
                       .compared = slip.compared,
                       .enough = 1};
    const bool explained = slip.pairs > 1 && !(ffp_hypotheses_try(found, FFP_VIEWS_BY_DEPTH, &c) &&
                                               ffp_hypotheses_try(found, FFP_VIEW_BY_DEPTH, &c));
    ffp_summed_free(&pattern);
    if (explained) return;
    char turned[64] = "";
    if (slip.turn > 0) snprintf(turned, sizeof turned, ", turned by %.0f degrees", slip.turn);
    look(found, slip.pairs == 0, FFP_RULE_SURFACES,
         slip.first < 0  ? FFP_RULE_APART
         : first == last ? FFP_RULE_SLIPPED
                         : FFP_RULE_SLIPPED_VIEWS,
         &(FfpFacts){.view = slip.pairs > 0 ? capture->views[first].id : NULL,
                     .other = slip.pairs > 0 && first != last ? capture->views[last].id : NULL,
                     .a = turned,
                     .x = slip.pairs,
                     .y = slip.compared,
                     .z = slip.shift});
}

// --- Whole scenes. ---

static void check_walk(FfpFindings *found, const FfpCapture *capture, const FfpLights *lights) {
    FfpRange depth = {INFINITY, -INFINITY};
    for (int v = 0; v < capture->n_views; v++) {
        depth.low = fmin(depth.low, fmin((double)capture->views[v].near, (double)capture->views[v].far));
        depth.high = fmax(depth.high, fmax((double)capture->views[v].near, (double)capture->views[v].far));
    }
    ffp_found(found, FFP_RULE_DEPTH, &(FfpFacts){.x = depth.low, .y = depth.high});
    const double step = ffp_rig_widest_step(capture), lit = share(lights->all.lit, lights->all.object);
    look(found, step > 0 && step <= ffp_rule(FFP_RULE_PARALLAX)->limit, FFP_RULE_PARALLAX,
         step > 0 ? FFP_RULE_WIDE_PARALLAX : FFP_RULE_NO_PARALLAX, &(FfpFacts){.figure = step});
    look(found, lit > ffp_rule(FFP_RULE_SCENE_LIT)->limit, FFP_RULE_SCENE_LIT, FFP_RULE_SCENE_DARK,
         &(FfpFacts){.figure = lit});
}

void ffp_rig_checks(FfpFindings *found, const FfpCapture *capture, const FfpCamera *taken) {
    FfpLights lights = ffp_rig_lights(capture, true);
    if (capture->scene) {
        check_walk(found, capture, &lights);
    } else {
        check_frusta(found, capture, &lights);
        check_silhouettes(found, capture);
    }
    check_light(found, &lights);
    if (!capture->scene) {
        const double lit = share(lights.all.lit, lights.all.object);
        look(found, lit > ffp_rule(FFP_RULE_LIT_SHARE)->limit, FFP_RULE_LIT_SHARE, FFP_RULE_LITTLE_LIT,
             &(FfpFacts){.figure = lit});
        check_rig(found, capture, taken, &lights);
    }
    check_guesses(found, capture, &lights);
    check_pattern(found, capture);
    if (!capture->scene) check_surfaces(found, capture);
    check_focus(found, capture);
    ffp_rig_lights_free(&lights);
}

void ffp_rig_look(FfpFindings *found, const FfpCapture *capture, const FfpCamera *taken) {
    ffp_rig_faults(found, capture);
    ffp_rig_checks(found, capture, taken);
    ffp_findings_merge(found);
}
