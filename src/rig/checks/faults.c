#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/numerics/rank.h"
#include "rig/checks/checks.h"
#include "rig/checks/hypotheses.h"

#define INSIDE 0.5         // radii from the object's centre
#define BORDER_MOST 0.9    // of the frame's edge that a mask may call object
#define LAMP 3             // times the others' median: ambient light that another lamp made,
#define LAMP_LEAST 0.05    // and at least so much of full scale
#define WELL 0.06          // error of colours that are looked up rightly, at most: no more questions then
#define QUITE_WELL 0.03    // likewise: then they are not asked whether they are sRGB or linear light either
#define BETTER_VALUES 0.7  // of the error as it is, which the other of these must leave
#define BETTER 0.6         // of the error as it is: what explains so much better is right
#define ALIKE 0.05         // of white's light, by which photographs of the same differ
#define ALIKE_PATTERNS 0.2 // of white, by which patterns differ if their photographs must
#define GREY 0.02          // of an image's light, by which the channels of one without colour are apart,
#define COLOURED 0.2       // and those of one with colour
#define ODD 2              // times the others' median: a view that disagrees
#define ALMOST 1.5         // times the median: an error that is none

// --- Devices. ---

static bool check_device(FfpFindings *found, const FfpCapture *capture, const FfpView *view,
                         const FfpCamera *device, const char *name) {
    double direction[3];
    const double radii = ffp_rig_direction(capture, device, direction) / (double)capture->radius;
    const FfpFacts facts = {.view = view->id, .a = name, .figure = radii};
    if (!capture->scene && radii < INSIDE) return ffp_found(found, FFP_RULE_DEVICE_INSIDE, &facts);
    if (ffp_rig_is_behind(capture, device)) return ffp_found(found, FFP_RULE_DEVICE_BEHIND, &facts);
    return capture->scene || !(radii > ffp_rule(FFP_RULE_DEVICE_FAR)->limit) ||
           ffp_found(found, FFP_RULE_DEVICE_FAR, &facts);
}

// Between camera and projector, as a share of the projector's distance to the object: the most of all views.
static double widest_baseline(const FfpCapture *capture) {
    double widest = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpCamera *camera = &capture->views[v].camera, *projector = &capture->views[v].projector;
        double direction[3], apart = 0;
        const double distance = ffp_rig_direction(capture, projector, direction);
        for (int i = 3; i < 12; i += 4) apart += pow((double)(camera->pose[i] - projector->pose[i]), 2);
        widest = fmax(widest, sqrt(apart) / distance);
    }
    return widest;
}

static bool check_devices(FfpFindings *found, const FfpCapture *capture) {
    int behind = 0;
    const double apart = widest_baseline(capture);
    for (int v = 0; v < capture->n_views; v++)
        behind += ffp_rig_is_behind(capture, &capture->views[v].camera);
    // Cameras that all look away look the right way in OpenGL's axes.
    if (behind == capture->n_views) return ffp_found(found, FFP_RULE_AXES, &(FfpFacts){0});
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        if (!check_device(found, capture, view, &view->camera, "camera") ||
            !check_device(found, capture, view, &view->projector, "projector"))
            return false;
    }
    return apart >= ffp_rule(FFP_RULE_TOGETHER)->limit ||
           ffp_found(found, FFP_RULE_TOGETHER, &(FfpFacts){.figure = apart});
}

// --- Photographs that are exchanged or repeated. ---

// A fault if a is darker than b in some or all views, although it cannot be. `lights`: b is black; where it
// is brighter than white, too, the room's light was on. NULL: no matter.
static bool check_order(FfpFindings *found, const FfpCapture *capture, int a, int b,
                        const FfpLights *lights) {
    int count = 0, first = capture->n_views;
#pragma omp parallel for schedule(static) reduction(+ : count) reduction(min : first)
    for (int v = 0; v < capture->n_views; v++) {
        if (!ffp_rig_is_darker(&capture->views[v], a, b)) continue;
        count++;
        if (v < first) first = v;
    }
    const bool all = count == capture->n_views && count > 1;
    if (count == 0) return true;
    const double above = lights ? lights->views[first].reversed / lights->views[first].object : 0;
    const bool lit = above > ffp_rule(FFP_RULE_BLACK_LIT)->limit;
    return ffp_found(found, lit ? FFP_RULE_BLACK_LIT : FFP_RULE_EXCHANGED,
                     &(FfpFacts){.figure = above,
                                 .view = all ? NULL : capture->views[first].id,
                                 .a = capture->patterns[b].name,
                                 .b = capture->patterns[a].name});
}

static bool same_picture(const FfpImage *a, const FfpImage *b) {
    return a->data && b->data && a->width == b->width && a->height == b->height &&
           memcmp(a->data, b->data, 3 * (size_t)a->width * (size_t)a->height * sizeof *a->data) == 0;
}

// A view that has another's photograph; drawn objects may look the same from two sides. Pictures are compared
// where their means are equal.
static void check_repeated_views(FfpFindings *found, const FfpCapture *capture) {
    const int white = capture->white;
    double *means = ffp_alloc((size_t)capture->n_views, sizeof *means);
#pragma omp parallel for schedule(static)
    for (int v = 0; v < capture->n_views; v++) means[v] = ffp_image_mean(&capture->views[v].images[white]);
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        for (int w = 0; w < v; w++)
            if (means[v] == means[w] && !ffp_same_device(&view->camera, &capture->views[w].camera) &&
                same_picture(&view->images[white], &capture->views[w].images[white]))
                ffp_found(found, FFP_RULE_SAME_VIEW,
                          &(FfpFacts){.view = view->id, .other = capture->views[w].id});
        ffp_cancel_point();
    }
    ffp_free(means);
}

// True if the photographs under two patterns differ by hardly any of the projector's light, noise or more.
// unlike: the patterns do.
static bool shows_same(const FfpCapture *capture, const FfpView *view, int a, int b, bool unlike) {
    double light = 0, apart = 0;
    if (same_picture(&view->images[a], &view->images[b])) return true;
    if (!unlike) return false;
    for (ptrdiff_t i = 0; i < (ptrdiff_t)3 * view->camera.width * view->camera.height; i++) {
        apart += fabs((double)(view->images[a].data[i] - view->images[b].data[i]));
        light += fabs((double)(view->images[capture->white].data[i] - view->images[capture->black].data[i]));
    }
    return apart < ALIKE * light;
}

// A file that was copied, or a photograph taken before the projector had changed.
static bool check_repeated(FfpFindings *found, const FfpCapture *capture, int active) {
    const int shown[3] = {capture->black, capture->white, active};
    const double mean = active >= 0 ? ffp_image_mean(&capture->patterns[active].image) : 0,
                 means[3] = {0, 1, mean};
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        for (int k = 0; k < (active >= 0 ? 3 : 1); k++) { // the first two are black and white
            const int other = (k + 1) % 3, a = shown[k], b = shown[other];
            if (shows_same(capture, view, a, b, fabs(means[k] - means[other]) >= ALIKE_PATTERNS))
                return ffp_found(found, FFP_RULE_SAME_PHOTOGRAPH,
                                 &(FfpFacts){.view = view->id,
                                             .a = capture->patterns[a].name,
                                             .b = capture->patterns[b].name});
        }
    }
    check_repeated_views(found, capture);
    return true;
}

// --- Masks and light. ---

// Share of the frame's edge that the mask calls object.
static double border_share(const FfpView *view) {
    const int w = view->frame_width ? view->frame_width : view->camera.width,
              h = view->frame_height ? view->frame_height : view->camera.height;
    const ptrdiff_t row = view->camera.width;
    double covered = 0;
    for (int x = 0; x < w; x++)
        covered += (view->coverage.data[x] >= 0.5F) + (view->coverage.data[(h - 1) * row + x] >= 0.5F);
    for (int y = 0; y < h; y++)
        covered += (view->coverage.data[y * row] >= 0.5F) + (view->coverage.data[y * row + w - 1] >= 0.5F);
    return covered / (2.0 * (w + h));
}

static bool check_masks(FfpFindings *found, const FfpCapture *capture) {
    for (int v = 0; v < capture->n_views && !capture->scene; v++)
        if (border_share(&capture->views[v]) > BORDER_MOST)
            return ffp_found(found, FFP_RULE_MASK_INVERTED, &(FfpFacts){.view = capture->views[v].id});
    return true;
}

static bool check_lit(FfpFindings *found, const FfpCapture *capture, const FfpLights *lights) {
    for (int v = 0; v < capture->n_views; v++) {
        const FfpObjectLight *light = &lights->views[v];
        const FfpFacts facts = {.view = capture->views[v].id,
                                .figure = light->brightened / fmax(1, light->object)};
        if (light->object == 0) return ffp_found(found, FFP_RULE_MASK_EMPTY, &facts);
        if (!capture->scene && light->brightened < ffp_rule(FFP_RULE_PROJECTOR_DARK)->limit * light->object)
            return ffp_found(found, FFP_RULE_PROJECTOR_DARK, &facts);
    }
    return true;
}

static void check_lamps(FfpFindings *found, const FfpCapture *capture, const FfpLights *lights) {
    const int n = capture->n_views;
    double *ratios = ffp_alloc(2 * (size_t)n, sizeof *ratios), *sorted = ratios + n;
    for (int v = 0; v < n; v++)
        ratios[v] = sorted[v] = lights->views[v].black / fmax(lights->views[v].added, 1e-9);
    const double usual = ffp_median(sorted, (size_t)n);
    for (int v = 0; v < n && n > 2 && !capture->scene; v++)
        if (ratios[v] > LAMP * usual && lights->views[v].black > LAMP_LEAST * lights->views[v].object)
            ffp_found(found, FFP_RULE_LAMP, &(FfpFacts){.view = capture->views[v].id});
    ffp_free(ratios);
}

// A note, if a figure is above its rule's limit.
static void note_above(FfpFindings *found, FfpRuleId rule, double figure) {
    if (figure > ffp_rule(rule)->limit) ffp_found(found, rule, &(FfpFacts){.figure = figure});
}

static bool check_light(FfpFindings *found, const FfpCapture *capture, int active) {
    if (!check_masks(found, capture) || !check_order(found, capture, capture->white, capture->black, NULL) ||
        !check_repeated(found, capture, active))
        return false;
    FfpLights lights = ffp_rig_lights(capture, false);
    const FfpObjectLight *all = &lights.all;
    bool ok = check_lit(found, capture, &lights);
    if (ok && active >= 0)
        ok = check_order(found, capture, capture->white, active, NULL) &&
             check_order(found, capture, active, capture->black, &lights);
    if (ok) {
        check_lamps(found, capture, &lights);
        note_above(found, FFP_RULE_NOTE_CLIPPED, all->clipped / all->object);
        if ((double)all->bright < ffp_rule(FFP_RULE_NOTE_UNDEREXPOSED)->limit)
            ffp_found(found, FFP_RULE_NOTE_UNDEREXPOSED, &(FfpFacts){.figure = (double)all->bright});
        note_above(found, FFP_RULE_BRIGHT_ROOM, all->black / (all->black + all->added));
    }
    ffp_rig_lights_free(&lights);
    return ok;
}

// --- Silhouettes. ---

static bool check_silhouettes(FfpFindings *found, const FfpCapture *capture, int active) {
    FfpSilhouettes shapes = ffp_rig_silhouettes(capture);
    FfpSummed pattern = {0};
    if (active >= 0) pattern = ffp_summed_new(&capture->patterns[active].image);
    const FfpCase c = {.capture = capture,
                       .active = active,
                       .pattern = &pattern,
                       .view = shapes.odd,
                       .shapes = &shapes,
                       .enough = FFP_RIG_EXPLAINED * shapes.misfit};
    const bool much =
        shapes.misfit >= ffp_rule(FFP_RULE_SILHOUETTES)->limit && capture->n_views >= FFP_RIG_VIEWS_TO_ACCUSE;
    const FfpFacts facts = {.figure = shapes.misfit,
                            .view = shapes.odd >= 0 ? capture->views[shapes.odd].id : NULL};
    const bool ok = (shapes.odd < 0 || ffp_hypotheses_try(found, FFP_VIEW_BY_SHAPE, &c)) &&
                    (!much || ffp_hypotheses_try(found, FFP_VIEWS_BY_SHAPE, &c));
    if (ok && (shapes.odd >= 0 || much))
        ffp_found(found, shapes.odd >= 0 ? FFP_RULE_NOTE_VIEW_CONTRADICTS : FFP_RULE_NOTE_VIEWS_CONTRADICT,
                  &facts);
    if (active >= 0) ffp_summed_free(&pattern);
    ffp_rig_silhouettes_free(&shapes);
    return ok;
}

// --- Structured light. ---

typedef struct Odd {
    int view;     // explained much worse than the others; -1: none
    bool sure;    // and no better than by chance
    double usual; // error of the views
} Odd;

static Odd odd_view(const FfpCapture *capture, int active, const FfpSummed *pattern) {
    double *errors = ffp_alloc(2 * (size_t)capture->n_views, sizeof *errors),
           *sorted = errors + capture->n_views;
    Odd out = {.view = -1};
    int n = 0, odd = -1;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpGuess guess = {.photograph = &capture->views[v].images[active], .pattern = pattern};
        errors[v] = ffp_rig_guess(capture, &capture->views[v], &guess);
        if (isnan(errors[v])) continue;
        sorted[n++] = errors[v];
        if (odd < 0 || errors[v] > errors[odd]) odd = v;
    }
    out.usual = ffp_median(sorted, (size_t)n);
    const double worst = odd >= 0 ? errors[odd] : 0;
    ffp_free(errors);
    if (n < 3 || !(worst > ODD * out.usual) || worst < WELL) return out;
    out.view = odd;
    out.sure = worst > FFP_LIGHT_EXPLAINED * ffp_chance_of(capture, active, pattern, odd);
    return out;
}

// One view is unlike the others: a fault if another photograph is what belongs there, or if what is there
// certainly does not.
static bool check_odd_view(FfpFindings *found, const Odd *odd, FfpCase *c) {
    c->view = odd->view;
    c->enough = ALMOST * odd->usual;
    return ffp_hypotheses_try(found, FFP_VIEW_BY_LIGHT, c) &&
           (!odd->sure || ffp_found(found, FFP_RULE_PATTERN_NOT_THERE,
                                    &(FfpFacts){.view = c->capture->views[odd->view].id,
                                                .a = c->capture->patterns[c->active].name}));
}

static bool check_all_views(FfpFindings *found, FfpCase *c) {
    c->chance = ffp_chance_of(c->capture, c->active, c->pattern, -1);
    c->enough = fmin(BETTER * c->error, FFP_LIGHT_EXPLAINED * c->chance);
    return !(c->error > FFP_LIGHT_EXPLAINED * c->chance) ||
           (ffp_hypotheses_try(found, FFP_VIEWS_BY_LIGHT, c) &&
            ffp_found(found, FFP_RULE_NOTE_CHANCE,
                      &(FfpFacts){.a = c->capture->patterns[c->active].name,
                                  .figure = c->error,
                                  .limit = FFP_LIGHT_EXPLAINED * c->chance}));
}

// How far the channels of an image, or of what it adds to black (NULL: to nothing), are apart, as a share of
// its light.
static double colour_of(const FfpImage *image, const FfpImage *black) {
    double light = 0, apart = 0;
    for (ptrdiff_t i = 0; i < (ptrdiff_t)image->width * image->height; i++) {
        double p[3];
        for (int c = 0; c < 3; c++)
            p[c] = (double)image->data[3 * i + c] - (black ? (double)black->data[3 * i + c] : 0);
        light += fabs(p[0] + p[1] + p[2]);
        apart += fabs(p[0] - p[1]) + fabs(p[1] - p[2]) + fabs(p[2] - p[0]);
    }
    return apart / fmax(light, 1e-9);
}

static bool check_colour(FfpFindings *found, const FfpCapture *capture, int active) {
    double most = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpImage *images = capture->views[v].images;
        most = fmax(most, colour_of(&images[active], &images[capture->black]));
    }
    return most >= GREY || colour_of(&capture->patterns[active].image, NULL) < COLOURED ||
           ffp_found(found, FFP_RULE_GREY, &(FfpFacts){.a = capture->patterns[active].name});
}

static bool check_pattern(FfpFindings *found, const FfpCapture *capture, int active) {
    FfpSummed pattern = ffp_summed_new(&capture->patterns[active].image);
    FfpCase c = {.capture = capture, .active = active, .pattern = &pattern, .view = -1};
    const Odd odd = odd_view(capture, active, &pattern);
    c.error = ffp_error_of(capture, active, -1, (FfpGuess){.pattern = &pattern});
    c.enough = BETTER_VALUES * c.error;
    // Of stripes, every guess explains them.
    const bool ok = (odd.usual < QUITE_WELL && odd.view < 0) ||
                            (c.error < FFP_RIG_SHOWN && !ffp_rig_tells(capture, active))
                        ? true
                    : odd.view < 0 && !ffp_hypotheses_try(found, FFP_VALUES_BY_LIGHT, &c) ? false
                    : odd.usual >= WELL ? check_all_views(found, &c)
                                        : odd.view < 0 || check_odd_view(found, &odd, &c);
    ffp_summed_free(&pattern);
    return ok;
}

// --- All of it. ---

bool ffp_rig_faults(FfpFindings *found, const FfpCapture *capture) {
    const int active = ffp_capture_active_pattern(capture, NULL, NULL);
    return check_devices(found, capture) && check_light(found, capture, active) &&
           (capture->scene || check_silhouettes(found, capture, active)) &&
           (active < 0 || (check_colour(found, capture, active) && check_pattern(found, capture, active)));
}

bool ffp_rig_suspect(const FfpCapture *capture, FfpError *err) {
    FfpFindings found = {0};
    ffp_rig_faults(&found, capture);
    const bool ok = ffp_findings_tell(&found, capture->folder, err);
    ffp_findings_free(&found);
    return ok;
}
