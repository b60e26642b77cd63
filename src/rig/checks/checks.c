#include "rig/checks/checks.h"
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/text.h"
#include "core/numerics/rank.h"
#include "rig/checks/slip.h"
#include "rig/checks/suspect_parts.h"
#include "rig/masks/chord.h"

#define LIT 0.02F
#define CLIPPED (254.5 / 255) // encoded
#define CLIPPED_SHARE 0.05    // of the object's pixels: highlights; training has as many
#define SPHERE_POINTS 200
#define CHORD_PARTS 24
#define FITS 0.8       // of the error: what explains so much better is right
#define FITS_WELL 0.08 // error of colours that are looked up rightly, at most
#define IMPOSSIBLE_MAX 0.02
#define CAMERA_LEAST 0.9    // of the object's sphere, which the camera must see, and
#define PROJECTOR_LEAST 0.8 // the pattern cover
#define CHANCE_MAX 0.75     // of what chance explains: more, and the pattern explains nothing

typedef struct Page {
    FILE *out;
    int doubts;
} Page;

static void line(Page *page, bool good, const char *subject, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
static void line(Page *page, bool good, const char *subject, const char *format, ...) {
    va_list arguments;
    fprintf(page->out, "  %-4s %-12s ", good ? "ok" : "LOOK", subject);
    va_start(arguments, format);
    vfprintf(page->out, format, arguments);
    va_end(arguments);
    fputc('\n', page->out);
    page->doubts += !good;
}

static void advise(const Page *page, const char *text) {
    fprintf(page->out, "       -> %s\n", text);
}

typedef struct Range {
    double low, high;
} Range;

static Range no_range(void) {
    return (Range){INFINITY, -INFINITY};
}

static void widen(Range *range, double value) {
    range->low = fmin(range->low, value), range->high = fmax(range->high, value);
}

// --- Numbers of one view. ---

static double degrees(double radians) {
    return radians * 180 / acos(-1.0);
}

// From the object's centre to a device: its distance, and its direction as a unit vector.
static double direction_to(const FfpCapture *capture, const FfpCamera *device, double out[3]) {
    double square = 0;
    for (int i = 0; i < 3; i++) {
        out[i] = (double)device->pose[4 * i + 3] - (double)capture->centre[i];
        square += out[i] * out[i];
    }
    for (int i = 0; i < 3 && square > 0; i++) out[i] /= sqrt(square);
    return sqrt(square);
}

// Full angle of the narrower side of a device's picture, were its principal point in the middle.
static double field_of_view(const FfpCamera *device) {
    const double x = (double)device->width / (double)device->fx,
                 y = (double)device->height / (double)device->fy;
    return degrees(2 * atan(fmin(x, y) / 2));
}

// Evenly spread directions (a Fibonacci lattice).
static void sphere_point(const FfpCapture *capture, int index, real point[3]) {
    const double z = 1 - (2 * index + 1.0) / SPHERE_POINTS, ring = sqrt(1 - z * z),
                 turn = 2.399963229728653 * index;
    const double unit[3] = {ring * cos(turn), ring * sin(turn), z};
    for (int i = 0; i < 3; i++) point[i] = capture->centre[i] + capture->radius * (real)unit[i];
}

static bool falls_into(const FfpCamera *device, const real point[3]) {
    real x, y;
    return ffp_project(device, point, &x, &y) > 0 && x >= -1 && y >= -1 && x <= (real)device->width + 1 &&
           y <= (real)device->height + 1;
}

static double share_inside(const FfpCapture *capture, const FfpCamera *device) {
    int inside = 0;
    for (int k = 0; k < SPHERE_POINTS; k++) {
        real point[3];
        sphere_point(capture, k, point);
        inside += falls_into(device, point);
    }
    return (double)inside / SPHERE_POINTS;
}

// Whether any point of the pixel's ray within the object's sphere lies in the projector's frustum.
static bool can_be_lit(const FfpCapture *capture, const FfpView *view, size_t pixel) {
    FfpChord chord;
    const int parts = ffp_chord(capture, &view->camera, pixel, &chord) ? CHORD_PARTS : 0;
    for (int k = 0; k < parts; k++) {
        real point[3];
        ffp_chord_point(&chord, k, parts, point);
        if (falls_into(&view->projector, point)) return true;
    }
    return false;
}

static real brightest(const real rgb[3]) {
    return (real)fmax((double)rgb[0], fmax((double)rgb[1], (double)rgb[2]));
}

// --- What all pictures say. ---

typedef struct Light {
    size_t object, lit, clipped, reversed, impossible; // pixels
    float *white, *share;                              // of lit pixels: brightest channel; black / white
} Light;

static int ascending(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static void measure_view(const FfpCapture *capture, const FfpView *view, Light *light) {
    const size_t pixels = (size_t)view->camera.width * (size_t)view->camera.height;
    for (size_t i = 0; i < pixels; i++) {
        const real *black = view->images[capture->black].data + 3 * i;
        const real *white = view->images[capture->white].data + 3 * i;
        if (view->coverage.data[i] < 0.5F) continue;
        const double w = (double)brightest(white), b = (double)brightest(black);
        light->object++;
        light->clipped += (double)ffp_srgb_encode((real)w) >= CLIPPED;
        light->reversed += w < b - (double)LIT;
        if (w - b <= (double)LIT) continue;
        light->impossible += !can_be_lit(capture, view, i);
        light->white[light->lit] = (float)w;
        light->share[light->lit++] = (float)(b / w);
    }
}

static Light measure(const FfpCapture *capture) {
    Light light = {0};
    size_t pixels = 1;
    for (int v = 0; v < capture->n_views; v++)
        pixels += (size_t)capture->views[v].camera.width * (size_t)capture->views[v].camera.height;
    light.white = ffp_alloc(pixels, sizeof *light.white);
    light.share = ffp_alloc(pixels, sizeof *light.share);
    for (int v = 0; v < capture->n_views; v++) measure_view(capture, &capture->views[v], &light);
    return light;
}

static double impossible_share(const Light *light) {
    return light->lit > 0 ? (double)light->impossible / (double)light->lit : 0;
}

// --- The lines. ---

FfpFrusta ffp_rig_frusta(const FfpCapture *capture) {
    FfpFrusta out = {.camera = 1, .projector = 1, .ahead = true};
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        real x, y;
        out.camera = fmin(out.camera, share_inside(capture, &view->camera));
        out.projector = fmin(out.projector, share_inside(capture, &view->projector));
        out.ahead = out.ahead && ffp_project(&view->camera, capture->centre, &x, &y) > 0 &&
                    ffp_project(&view->projector, capture->centre, &x, &y) > 0;
    }
    return out;
}

bool ffp_rig_frusta_hold(FfpFrusta frusta) {
    return frusta.ahead && frusta.camera > CAMERA_LEAST && frusta.projector > PROJECTOR_LEAST;
}

static void check_frusta(Page *page, const FfpCapture *capture, const Light *light) {
    const FfpFrusta frusta = ffp_rig_frusta(capture);
    line(page, ffp_rig_frusta_hold(frusta), "frusta",
         "the camera sees %.0f %% of the object's sphere, the pattern covers %.0f %% (worst views)",
         100 * frusta.camera, 100 * frusta.projector);
    if (!frusta.ahead)
        advise(page,
               "the object lies behind a device: the turntable's axis or the direction of R and T is wrong");
    else if (frusta.camera <= CAMERA_LEAST)
        advise(page, "the object leaves the picture: move the camera back, or give the object's sphere");
    else if (frusta.projector <= PROJECTOR_LEAST)
        advise(
            page,
            "the pattern does not reach all of the object: move or aim the projector, or check the size it "
            "was calibrated at");
    const double impossible = impossible_share(light);
    line(page, impossible < IMPOSSIBLE_MAX, "lit pixels",
         "%.1f %% are lit where no projector light can reach", 100 * impossible);
    if (impossible >= IMPOSSIBLE_MAX)
        advise(page, "the poses do not fit the pictures: check axis, angles and their sign, sizes and masks");
}

static void check_silhouettes(Page *page, const FfpCapture *capture) {
    FfpSilhouettes found = ffp_rig_silhouettes(capture);
    const double misfit = found.misfit, without = found.without;
    const int odd = found.odd;
    ffp_rig_silhouettes_free(&found);
    line(page, misfit < FFP_RIG_MISFIT_MAX && odd < 0, "silhouettes",
         "%.1f %% of the object's pixels contradict the other views' silhouettes", 100 * misfit);
    if (odd >= 0) {
        fputs("       -> without view ", page->out);
        ffp_put_plain(page->out, capture->views[odd].id);
        fprintf(page->out,
                " it is %.1f %%: look at its mask; was the camera bumped, a hand in the picture, or the "
                "turntable not where its angle says?\n",
                100 * without);
    } else if (misfit >= FFP_RIG_MISFIT_MAX) {
        advise(page, "the views are inconsistent: check the masks (computed ones may lack parts in "
                     "shadow, or hold parts of the stage), the turntable's axis, its angles and their "
                     "sign, and the order of the pictures");
    }
}

static void check_exposure(Page *page, Light *light) {
    const double clipped = light->object > 0 ? (double)light->clipped / (double)light->object : 0;
    const double bright = (double)ffp_quantile(light->white, light->lit, 0.95);
    line(page, clipped < CLIPPED_SHARE, "clipping",
         "%.2f %% of the object's pixels are at the limit under white", 100 * clipped);
    if (clipped >= CLIPPED_SHARE) advise(page, "shorten the exposure until white clips in highlights only");
    line(page, bright > 0.1 && light->lit > 0, "exposure",
         "white's bright pixels (95 %%) reach %.2f of the range, linear", bright);
    if (!(bright > 0.1))
        advise(page, "expose longer, or move the projector closer: otherwise noise will show");
}

static void check_black(Page *page, Light *light) {
    const double reversed = light->object > 0 ? (double)light->reversed / (double)light->object : 0;
    line(page, reversed < 0.01, "black level",
         "%.2f %% of the object's pixels are darker under white than under black", 100 * reversed);
    if (reversed >= 0.01)
        advise(page, "black and white are swapped, the room's light changed, or camera and projector are not "
                     "synchronised (expose for whole frames of the projector)");
}

static void check_lit_share(Page *page, const Light *light) {
    const double lit = light->object > 0 ? (double)light->lit / (double)light->object : 0;
    line(page, lit > 0.4, "lit share", "%.0f %% of the object's pixels receive projector light", 100 * lit);
    if (lit <= 0.4)
        advise(
            page,
            "the masks include background, or the projector is too far to the side: unlit sides are guessed");
}

// --- Against the rigs of training (world/synth/rig.c), as they look once the object's sphere has radius 1.
// ---

typedef struct Trained {
    const char *subject, *unit;
    double low, high; // of training
    double margin;    // beyond which it is worth a word
    const char *advice;
} Trained;

enum {
    CAMERA_DISTANCE,
    PROJECTOR_DISTANCE,
    CAMERA_HEIGHT,
    BETWEEN,
    CAMERA_FIELD,
    PROJECTOR_FIELD,
    ROLL,
    AMBIENT
};
static const Trained trained[] = {
    [CAMERA_DISTANCE] = {"camera", "object radii away", 2.9, 3.5, 0.6,
                         "the model was not trained at this distance"},
    [PROJECTOR_DISTANCE] = {"projector", "object radii away", 1.8, 2.5, 0.6,
                            "the model was not trained with light from this distance"},
    [CAMERA_HEIGHT] = {"height", "degrees above the object's equator (camera)", -10, 10, 8,
                       "the model was trained on views from the side; check that the axis points up"},
    [BETWEEN] = {"angle", "degrees between camera and projector, seen from the object", 15, 45, 5,
                 "a smaller angle makes depth less accurate, a larger one casts more shadow"},
    [CAMERA_FIELD] = {"camera field", "degrees", 40, 40, 20, "the field of view differs from training"},
    [PROJECTOR_FIELD] = {"projector field", "degrees", 55, 55, 30,
                         "the spread of the light differs from training"},
    [ROLL] = {"roll", "degrees of the camera about its axis", 0, 0, 10,
              "turn the photographs upright, or check the sign of the axis: the world's z must be up"},
    [AMBIENT] = {"ambient", "of the light under white remains under black", 0.07, 0.66, 0.07,
                 "darken or lighten the room to get between"},
};

static void compare(Page *page, int which, Range found) {
    const Trained *t = &trained[which];
    const bool good = found.low >= t->low - t->margin && found.high <= t->high + t->margin;
    char range[64];
    const double low = round(found.low * 100) / 100, high = round(found.high * 100) / 100;
    if (low == high)
        snprintf(range, sizeof range, "%g", high);
    else
        snprintf(range, sizeof range, "%g to %g", low, high);
    char of_training[64], limits[64] = ""; // the latter are told where they decide
    if (t->low == t->high)
        snprintf(of_training, sizeof of_training, "%.3g", t->low);
    else
        snprintf(of_training, sizeof of_training, "%.3g to %.3g", t->low, t->high);
    if (low < t->low || high > t->high)
        snprintf(limits, sizeof limits, "; ok from %.3g to %.3g", t->low - t->margin, t->high + t->margin);
    line(page, good, t->subject, "%s %s (trained: %s%s)", range, t->unit, of_training, limits);
    if (!good) advise(page, t->advice);
}

static void measure_rig(const FfpCapture *capture, Range ranges[AMBIENT]) {
    for (int i = 0; i < AMBIENT; i++) ranges[i] = no_range();
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        double to_camera[3], to_projector[3], cosine = 0;
        widen(&ranges[CAMERA_DISTANCE],
              direction_to(capture, &view->camera, to_camera) / (double)capture->radius);
        widen(&ranges[PROJECTOR_DISTANCE],
              direction_to(capture, &view->projector, to_projector) / (double)capture->radius);
        for (int i = 0; i < 3; i++) cosine += to_camera[i] * to_projector[i];
        widen(&ranges[BETWEEN], degrees(acos(fmin(fmax(cosine, -1), 1))));
        widen(&ranges[CAMERA_HEIGHT], degrees(asin(fmin(fmax(to_camera[2], -1), 1))));
        widen(&ranges[CAMERA_FIELD], field_of_view(&view->camera));
        widen(&ranges[PROJECTOR_FIELD], field_of_view(&view->projector));
        // Upright: the picture's x axis is level, and its y axis points down.
        widen(&ranges[ROLL], degrees(atan2((double)view->camera.pose[8], -(double)view->camera.pose[9])));
    }
}

// The widest gap between neighbouring cameras' azimuths, in degrees.
static double widest_gap(const FfpCapture *capture) {
    float *azimuths = ffp_alloc((size_t)capture->n_views, sizeof *azimuths);
    for (int v = 0; v < capture->n_views; v++) {
        double to[3];
        direction_to(capture, &capture->views[v].camera, to);
        azimuths[v] = (float)degrees(atan2(to[1], to[0]));
    }
    qsort(azimuths, (size_t)capture->n_views, sizeof *azimuths, ascending);
    double gap = 360 + (double)azimuths[0] - (double)azimuths[capture->n_views - 1];
    for (int v = 1; v < capture->n_views; v++) gap = fmax(gap, (double)azimuths[v] - (double)azimuths[v - 1]);
    ffp_free(azimuths);
    return gap;
}

static void check_rig(Page *page, const FfpCapture *capture, const FfpCamera *taken, Light *light) {
    Range ranges[AMBIENT];
    const double gap = widest_gap(capture), share = (double)ffp_quantile(light->share, light->lit, 0.5);
    measure_rig(capture, ranges);
    for (int i = 0; i < AMBIENT; i++) compare(page, i, ranges[i]);
    compare(page, AMBIENT, (Range){share, share});
    line(page, capture->n_views >= 6 && gap < 75, "views",
         "%d, with a widest gap of %.0f degrees (trained: 8 and 45)", capture->n_views, gap);
    if (capture->n_views < 6 || gap >= 75)
        advise(page, "sides that no view sees are guessed: photograph all around");
    const double side = sqrt((double)taken->width * taken->height);
    line(page, side >= 90 && side <= 260, "size", "%d x %d pixels (trained: 128 x 128)", taken->width,
         taken->height);
    if (side > 260)
        advise(page, "import narrower pictures, about 128 pixels wide, or reconstruct without the network: "
                     "time and memory grow fast");
    if (side < 90) advise(page, "too few pixels for fine patterns");
}

// --- Calibration tools that count a projector's pixels otherwise than the pattern's file: twice, or half.
// ---

// What the pictures say with the projector's focal lengths and principal points `factor` times as large.
typedef struct OtherSize {
    FfpExplanation found;
    double impossible; // share of lit pixels where no light can be
} OtherSize;

static OtherSize look_at_size(const FfpCapture *capture, int active, double factor) {
    FfpCapture scaled = *capture;
    OtherSize out;
    scaled.views = ffp_alloc((size_t)capture->n_views, sizeof *scaled.views);
    for (int v = 0; v < capture->n_views; v++) {
        FfpCamera *projector = &scaled.views[v].projector;
        scaled.views[v] = capture->views[v];
        projector->fx *= (real)factor, projector->fy *= (real)factor;
        projector->cx *= (real)factor, projector->cy *= (real)factor;
    }
    out.found = ffp_rig_explain(&scaled, active);
    ffp_capture_estimate_bounds(&scaled); // the capture's own may have been estimated by the wrong size
    const FfpExplanation anew = ffp_rig_explain(&scaled, active);
    Light light = measure(&scaled);
    const bool better = anew.error * out.found.chance < out.found.error * anew.chance;
    if (anew.pixels > 0 && (out.found.pixels == 0 || better)) out.found = anew;
    out.impossible = impossible_share(&light);
    ffp_free(light.white), ffp_free(light.share), ffp_free(scaled.views);
    return out;
}

// Stripes are explained by chance as well: then it counts that light reaches what is lit, and did not before.
static bool fits_better(const OtherSize *other, const FfpExplanation *found, double impossible) {
    const double error = other->found.error;
    if (other->found.pixels == 0 || !(error < FITS * found->error)) return false;
    const bool reaches = impossible > 5 * IMPOSSIBLE_MAX && other->impossible < IMPOSSIBLE_MAX;
    return error < CHANCE_MAX * other->found.chance ||
           (reaches && error < FITS_WELL && error < 0.5 * found->error);
}

// Tells the size that explains the pictures in place of what `found` says; false when neither does.
static bool try_other_sizes(const Page *page, const FfpCapture *capture, int active, const Light *light,
                            const FfpExplanation *found) {
    static const double factors[2] = {0.5, 2};
    const FfpCamera *projector = &capture->views[0].projector;
    double factor = 1, error = INFINITY;
    for (int k = 0; k < 2; k++) {
        const OtherSize other = look_at_size(capture, active, factors[k]);
        if (!fits_better(&other, found, impossible_share(light)) || other.found.error > error) continue;
        factor = factors[k], error = other.found.error;
    }
    if (factor == 1) return false;
    fprintf(
        page->out,
        "       -> it fits with %s the projector's focal lengths and principal point (%.3f): the projector "
        "was calibrated at %.0f x %.0f pixels, not at the pattern's %d x %d; import with that size, "
        "scaled\n",
        factor < 1 ? "half" : "twice", error, projector->width / factor, projector->height / factor,
        projector->width, projector->height);
    return true;
}

// --- Cameras that mirror their pictures. ---

static const char *const ways[3] = {"left to right", "upside down", "both ways"};

// Tells which way all photographs are mirrored, if that explains them better than a mirrored pattern, or what
// else there is, with `error`: seen from above the projector, the two look the same.
static bool try_mirrored_back(const Page *page, const FfpCapture *capture, int active, double error) {
    const double across = ffp_rig_error_mirrored_back(capture, active, FFP_RIG_MIRRORED),
                 down = ffp_rig_error_mirrored_back(capture, active, FFP_RIG_FLIPPED);
    const double least = down < across ? down : across;
    if (!(least < FITS * error)) return false;
    fprintf(
        page->out,
        "       -> it fits when the photographs are mirrored %s (%.3f): the camera's program shows them as "
        "in a mirror; switch that off, or mirror the files, and import again\n",
        ways[down < across], least);
    return true;
}

static void advise_odd_view(const Page *page, const FfpCapture *capture, const FfpExplanation *found) {
    fputs("       -> view ", page->out);
    ffp_put_plain(page->out, capture->views[found->odd].id);
    if (found->odd_across != 0)
        fprintf(page->out,
                " fits better when its pattern is moved by %.0f pixels, which few others do: was the camera "
                "or the projector bumped, or the turntable not where its angle says? Take it again\n",
                fabs(found->odd_across));
    else
        fputs(" fits far worse than the others: was something in front of the object or of the projector, or "
              "the room's light changed? Take it again\n",
              page->out);
}

static void check_pattern(Page *page, const FfpCapture *capture, const Light *light) {
    const int active = ffp_capture_active_pattern(capture, NULL, NULL);
    const FfpExplanation found = active >= 0 ? ffp_rig_explain(capture, active) : (FfpExplanation){0};
    if (found.pixels == 0) {
        line(page, false, "pattern", "no lit pixels under a pattern that every view has");
        advise(page, "depth requires such a pattern: take one more picture at each stop");
        return;
    }
    if (found.error < FFP_RIG_SHOWN && !ffp_rig_tells(capture, active)) {
        line(page, true, "pattern",
             "'%s' explains the pictures with error %.3f, but cannot tell whether poses are right: every ray "
             "meets all of its colours (%d pixels)",
             capture->patterns[active].name, found.error, found.pixels);
        return;
    }
    int mirror = 0;
    for (int k = 1; k < 3; k++) mirror = found.mirrored[k] < found.mirrored[mirror] ? k : mirror;
    const bool mirrored = found.mirrored[mirror] < FITS * found.error;
    const bool moved = !mirrored && found.best < 0.85 * found.error && found.best < CHANCE_MAX * found.chance;
    const bool spoilt = found.odd >= 0 && found.odd_across == 0; // the others fit
    const bool nothing = !mirrored && !moved && !spoilt && found.error > CHANCE_MAX * found.chance;
    const bool odd = !mirrored && !moved && !nothing && found.odd >= 0;
    line(page, !mirrored && !moved && !nothing && !odd, "pattern",
         "'%s' explains the pictures with error %.3f; chance gives %.3f (%d pixels)",
         capture->patterns[active].name, found.error, found.chance, found.pixels);
    if ((mirrored || moved || nothing) && try_other_sizes(page, capture, active, light, &found)) return;
    const double enough = fmin(fmin(found.error, found.mirrored[mirror]), CHANCE_MAX * found.chance);
    if ((mirrored || moved || nothing || odd) && try_mirrored_back(page, capture, active, enough)) return;
    if (mirrored)
        fprintf(page->out,
                "       -> it fits when mirrored %s (%.3f): the projector, the pattern's file or all "
                "photographs are mirrored; import again without that\n",
                ways[mirror], found.mirrored[mirror]);
    if (moved)
        fprintf(page->out,
                "       -> it fits better moved by %.0f, %.0f of its pixels (%.3f): the projector's "
                "calibration or the "
                "turntable's axis is off by as much; `ffprocams align` can correct it\n",
                round(found.across * found.direction[0]), round(found.across * found.direction[1]),
                found.best);
    if (odd) advise_odd_view(page, capture, &found);
    if (nothing)
        advise(page, "no better than chance: another pattern was shown, views are mixed up, or poses are "
                     "wrong (angles' "
                     "sign, R and T from camera to projector)");
}

// --- What moved. ---

static void put_views(const Page *page, const FfpCapture *capture, int a, const char *between, int b) {
    ffp_put_plain(page->out, capture->views[a].id);
    if (a == b) return;
    fputs(between, page->out);
    ffp_put_plain(page->out, capture->views[b].id);
}

static void check_surfaces(Page *page, const FfpCapture *capture) {
    const int active = ffp_capture_active_pattern(capture, NULL, NULL);
    if (active < 0 || !ffp_rig_tells(capture, active)) return; // nor what depths are
    const FfpSlip found = ffp_rig_slip(capture, active);
    if (found.compared == 0) return;
    line(page, found.pairs == 0, "surfaces", "those of %d of %d pairs of neighbouring views lie apart",
         found.pairs, found.compared);
    if (found.pairs == 0) return;
    const bool one = found.first == found.last;
    fputs(found.first >= 0 && one ? "       -> view " : "       -> views ", page->out);
    if (found.first < 0) {
        put_views(page, capture, found.pair, " and ", (found.pair + 1) % capture->n_views);
        fputs(" most clearly: the object or a device moved in between, or the turntable's axis or angles are "
              "wrong\n",
              page->out);
        return;
    }
    put_views(page, capture, found.first, " to ", found.last);
    fprintf(page->out, " %s the object %.2g units from where the others show it", one ? "shows" : "show",
            found.shift);
    if (found.turn > 0) fprintf(page->out, ", turned by %.0f degrees", found.turn);
    fputs(
        one ? ": did it slip, was a device bumped, or the turntable not where its angle says? Take it again\n"
            : ": did it slip, or was a device moved? Take them again\n",
        page->out);
}

// --- Whole scenes. ---

#define APART_MAX 20 // degrees between a camera and the nearest other one, seen from the scene's middle
#define REACHED 0.1  // of the pixels that white brightens

static double angle_between(const double a[3], const double b[3]) {
    return degrees(acos(fmax(-1, fmin(1, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]))));
}

// The widest angle from a camera to the nearest that stands elsewhere; 0: all stand in one place.
static double widest_step(const FfpCapture *capture) {
    double widest = 0;
    for (int v = 0; v < capture->n_views; v++) {
        double own[3], other[3], nearest = INFINITY;
        direction_to(capture, &capture->views[v].camera, own);
        for (int w = 0; w < capture->n_views; w++) {
            if (ffp_same_device(&capture->views[v].camera, &capture->views[w].camera)) continue;
            direction_to(capture, &capture->views[w].camera, other);
            nearest = fmin(nearest, angle_between(own, other));
        }
        if (isfinite(nearest)) widest = fmax(widest, nearest);
    }
    return widest;
}

static void check_walk(Page *page, const FfpCapture *capture, const Light *light) {
    Range depth = no_range();
    for (int v = 0; v < capture->n_views; v++) {
        widen(&depth, (double)capture->views[v].near);
        widen(&depth, (double)capture->views[v].far);
    }
    line(page, true, "depth", "a whole scene, looked for %.3g to %.3g units before the cameras", depth.low,
         depth.high);
    const double step = widest_step(capture);
    line(page, step > 0 && step <= APART_MAX, "parallax",
         "at most %.1f degrees from a camera to the next, seen from the scene's middle", step);
    if (!(step > 0))
        advise(page,
               "one place of the camera: what the projector does not reach will have no depth of its own");
    else if (step > APART_MAX)
        advise(page,
               "take more views in between: depth where no projector reaches comes from neighbours that "
               "look alike");
    const double lit = light->object > 0 ? (double)light->lit / (double)light->object : 0;
    line(page, lit > REACHED, "lit share", "%.0f %% of the pixels receive projector light", 100 * lit);
    if (lit <= REACHED)
        advise(page, "most of the pictures show what the projector does not reach: move closer");
}

int ffp_rig_checks(const FfpCapture *capture, const FfpCamera *taken, FILE *out) {
    Page page = {out, 0};
    Light light = measure(capture);
    fputs("checks\n", out);
    if (capture->scene) {
        check_walk(&page, capture, &light);
    } else {
        check_frusta(&page, capture, &light);
        check_silhouettes(&page, capture);
    }
    check_exposure(&page, &light);
    check_black(&page, &light);
    if (!capture->scene) {
        check_lit_share(&page, &light);
        check_rig(&page, capture, taken, &light);
    }
    check_pattern(&page, capture, &light);
    if (!capture->scene) check_surfaces(&page, capture);
    ffp_free(light.white);
    ffp_free(light.share);
    return page.doubts;
}
