// Faults of rigs and captures, put into a capture in memory one at a time: what the checks before the
// work say of each, and what they cost; then captures without fault, of which nothing may be said. Prints
// tables in Markdown. The exit status is 1 if a fault is missed or a faultless capture refused.
//   rig_faults CAPTURE [SCENES [CAPTURE...]]     SCENES: of the test split, from the first on
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/patterns/lollipop.h"
#include "rig/checks/checks.h"
#include "world/synth/dataset.h"

enum { VIEW = 3, OTHER = 5 };

static char said[4096];   // what the last check found
static FfpFinding *items; // the same, [count]
static int count;
static bool sound; // nothing was refused
static bool whole; // `info`'s looks count as well

static FfpView *view_of(const FfpCapture *c, int v) {
    return &c->views[v];
}

static int active_of(const FfpCapture *c) {
    return ffp_capture_active_pattern(c, NULL, NULL);
}

// --- Devices. ---

static void turn_round(FfpCamera *d, const FfpCapture *c, real by) {
    (void)c, (void)by;
    for (int i = 0; i < 3; i++) {
        d->pose[4 * i] = -d->pose[4 * i];
        d->pose[4 * i + 2] = -d->pose[4 * i + 2];
    }
}

static void put_inside(FfpCamera *d, const FfpCapture *c, real by) {
    for (int i = 0; i < 3; i++) d->pose[4 * i + 3] = c->centre[i] - by * c->radius * d->pose[4 * i + 2];
}

static void scale_place(FfpCamera *d, const FfpCapture *c, real by) {
    (void)c;
    for (int i = 0; i < 3; i++) d->pose[4 * i + 3] *= by;
}

// World-to-device in place of device-to-world.
static void invert(FfpCamera *d, const FfpCapture *c, real by) {
    real out[16] = {[15] = 1};
    (void)c, (void)by;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            out[4 * i + k] = d->pose[4 * k + i];
            out[4 * i + 3] -= d->pose[4 * k + i] * d->pose[4 * k + 3];
        }
    memcpy(d->pose, out, sizeof out);
}

static void flip_axes(FfpCamera *d, const FfpCapture *c, real by) {
    (void)c, (void)by;
    for (int i = 0; i < 3; i++) {
        d->pose[4 * i + 1] = -d->pose[4 * i + 1];
        d->pose[4 * i + 2] = -d->pose[4 * i + 2];
    }
}

static void scale_intrinsics(FfpCamera *d, const FfpCapture *c, real by) {
    (void)c;
    d->fx *= by, d->fy *= by;
    d->cx *= by, d->cy *= by;
}

// About the world's z.
static void turn(FfpCamera *d, const FfpCapture *capture, real degrees) {
    const real s = (real)sin((double)degrees * acos(-1.0) / 180),
               c = (real)cos((double)degrees * acos(-1.0) / 180);
    (void)capture;
    for (int k = 0; k < 4; k++) {
        const real x = d->pose[k], y = d->pose[4 + k];
        d->pose[k] = c * x - s * y;
        d->pose[4 + k] = s * x + c * y;
    }
}

#define EVERY_VIEW(c) for (FfpView *v = (c)->views; v < (c)->views + (c)->n_views; v++)

static void steps_too_wide(FfpCapture *c, int degrees) {
    for (int v = 0; v < c->n_views; v++) {
        turn(&view_of(c, v)->camera, c, (real)(degrees * v));
        turn(&view_of(c, v)->projector, c, (real)(degrees * v));
    }
}
static void axis_off(FfpCapture *c, int percent) {
    EVERY_VIEW(c) {
        for (int i = 0; i < 3; i++) {
            const real step = (real)percent / 100 * c->radius * v->camera.pose[4 * i];
            v->camera.pose[4 * i + 3] += step;
            v->projector.pose[4 * i + 3] += step;
        }
    }
}

// --- Photographs. ---

typedef enum Move { UPSIDE_DOWN, LEFT, RIGHT, MIRRORED, FLIPPED } Move;

static FfpImage moved_picture(const FfpImage *image, int move) {
    FfpImage out = ffp_image_new(image->width, image->height, image->channels);
    const int last = image->width - 1, n = image->channels;
    for (int y = 0; y <= last; y++)
        for (int x = 0; x <= last; x++) {
            const int from[5][2] = {
                {last - x, last - y}, {last - y, x}, {y, last - x}, {last - x, y}, {x, last - y}};
            memcpy(out.data + (ptrdiff_t)n * (y * image->width + x),
                   image->data + (ptrdiff_t)n * (from[move][1] * image->width + from[move][0]),
                   (size_t)n * sizeof *out.data);
        }
    return out;
}

static void replace(FfpImage *image, FfpImage with) {
    ffp_image_free(image);
    *image = with;
}

static void exchange_pictures(FfpImage *a, FfpImage *b) {
    const FfpImage kept = *a;
    *a = *b;
    *b = kept;
}

static void move_photographs(FfpCapture *c, int move) {
    FfpView *v = view_of(c, VIEW);
    for (int p = 0; p < c->n_patterns; p++)
        if (v->images[p].data) replace(&v->images[p], moved_picture(&v->images[p], move));
    replace(&v->coverage, moved_picture(&v->coverage, move));
}

static void exchange_views(FfpCapture *c, int a, int b) {
    FfpView *one = view_of(c, a), *other = view_of(c, b);
    for (int p = 0; p < c->n_patterns; p++) exchange_pictures(&one->images[p], &other->images[p]);
    exchange_pictures(&one->coverage, &other->coverage);
}
static void exchange_with(FfpCapture *c, int other) {
    exchange_views(c, VIEW, other);
}
static void reversed_turntable(FfpCapture *c, int how) {
    (void)how;
    for (int v = 1; 2 * v < c->n_views; v++) exchange_views(c, v, c->n_views - v);
}

// Photographs under two patterns, in one view or in all.
typedef enum Pair { BLACK_WHITE, ACTIVE_WHITE, ACTIVE_BLACK } Pair;

static void exchange_patterns(FfpCapture *c, FfpView *v, int pair) {
    exchange_pictures(&v->images[pair == BLACK_WHITE ? c->black : active_of(c)],
                      &v->images[pair == ACTIVE_BLACK ? c->black : c->white]);
}
static void exchange_once(FfpCapture *c, int pair) {
    exchange_patterns(c, view_of(c, VIEW), pair);
}
static void exchange_everywhere(FfpCapture *c, int pair) {
    EVERY_VIEW(c) exchange_patterns(c, v, pair);
}

static void active_of_another_view(FfpCapture *c, int other) {
    exchange_pictures(&view_of(c, VIEW)->images[active_of(c)], &view_of(c, other)->images[active_of(c)]);
}
static void active_taken_twice(FfpCapture *c, int how) {
    FfpView *v = view_of(c, VIEW);
    (void)how;
    replace(&v->images[active_of(c)], ffp_image_copy(&v->images[c->white]));
}
static void stop_taken_twice(FfpCapture *c, int other) {
    for (int p = 0; p < c->n_patterns; p++)
        if (view_of(c, VIEW)->images[p].data)
            replace(&view_of(c, VIEW)->images[p], ffp_image_copy(&view_of(c, other)->images[p]));
    replace(&view_of(c, VIEW)->coverage, ffp_image_copy(&view_of(c, other)->coverage));
}
static void projector_off(FfpCapture *c, int how) {
    FfpView *v = view_of(c, VIEW);
    (void)how;
    for (int p = 0; p < c->n_patterns; p++) {
        if (p == c->black || !v->images[p].data) continue;
        replace(&v->images[p], ffp_image_copy(&v->images[c->black]));
        v->images[p].data[0] += 1e-4F; // as two photographs differ
        v->images[p].data[1] += 1e-4F * (real)(p + 1);
    }
}

// All photographs of a view times the coverage, or lit by it.
static void by_coverage(FfpCapture *c, FfpView *v, bool lit) {
    for (int p = 0; p < c->n_patterns; p++)
        for (ptrdiff_t i = 0; v->images[p].data && i < (ptrdiff_t)3 * v->camera.width * v->camera.height; i++)
            v->images[p].data[i] = lit ? v->images[p].data[i] + 0.5F * v->coverage.data[i / 3]
                                       : v->images[p].data[i] * v->coverage.data[i / 3];
}
static void lamp_on(FfpCapture *c, int how) {
    (void)how;
    by_coverage(c, view_of(c, VIEW), true);
}

// Factors and what is added, in thousandths.
static void expose(FfpCapture *c, int factor, int plus) {
    EVERY_VIEW(c)
    for (int p = 0; p < c->n_patterns; p++)
        for (ptrdiff_t i = 0; v->images[p].data && i < (ptrdiff_t)3 * v->camera.width * v->camera.height; i++)
            v->images[p].data[i] = fminf((real)factor / 1000 * v->images[p].data[i] + (real)plus / 1000, 1);
}
static void exposed(FfpCapture *c, int factor) {
    expose(c, factor, 0);
}
static void bright_room(FfpCapture *c, int plus) {
    expose(c, 1000 - plus, plus);
}

static void mask_inverted(FfpCapture *c, int how) {
    FfpImage *mask = &view_of(c, VIEW)->coverage;
    (void)how;
    for (ptrdiff_t i = 0; i < (ptrdiff_t)mask->width * mask->height; i++) mask->data[i] = 1 - mask->data[i];
}
static void mask_empty(FfpCapture *c, int how) {
    FfpImage *mask = &view_of(c, VIEW)->coverage;
    (void)how;
    memset(mask->data, 0, (size_t)mask->width * (size_t)mask->height * sizeof *mask->data);
}
static void mask_of(FfpCapture *c, int other) {
    FfpView *v = view_of(c, VIEW);
    replace(&v->coverage, ffp_image_copy(&view_of(c, other)->coverage));
    by_coverage(c, v, false);
}
static void channels_reversed(FfpCapture *c, int how) {
    (void)how;
    EVERY_VIEW(c)
    for (int p = 0; p < c->n_patterns; p++)
        for (ptrdiff_t i = 0; v->images[p].data && i < (ptrdiff_t)v->camera.width * v->camera.height; i++) {
            real *pixel = v->images[p].data + 3 * i;
            const real red = pixel[0];
            pixel[0] = pixel[2];
            pixel[2] = red;
        }
}

// --- Patterns. ---

static void move_pattern(FfpCapture *c, int move) {
    FfpPattern *p = &c->patterns[active_of(c)];
    replace(&p->image, moved_picture(&p->image, move));
}
static void another_pattern(FfpCapture *c, int how) {
    const int a = active_of(c);
    (void)how;
    for (int p = 0; p < c->n_patterns; p++)
        if (p != a && p != c->black && p != c->white) {
            exchange_pictures(&c->patterns[p].image, &c->patterns[a].image);
            return;
        }
}
static void unknown_pattern(FfpCapture *c, int square) {
    FfpImage *image = &c->patterns[active_of(c)].image;
    for (ptrdiff_t i = 0; i < (ptrdiff_t)image->width * image->height; i++) {
        const int x = (int)(i % image->width) / square, y = (int)(i / image->width) / square;
        for (int k = 0; k < 3; k++) image->data[3 * i + k] = (real)((x * 7 + y * 13 + k * 5) % 11 > 5);
    }
}

typedef enum Kind { REFUSED, NOTED } Kind;
enum { CAMERAS = 1, PROJECTORS = 2, ONE = 4 }; // of VIEW alone

static const struct Fault {
    const char *name;
    Kind kind;
    FfpRuleId rule;   // by which it is to be named
    const char *view; // its end; NULL: no view of its own
    void (*put)(FfpCapture *c, int how);
    int how;
    void (*move)(FfpCamera *d, const FfpCapture *c, real by); // of these devices, where put is NULL
    unsigned devices;
    real by;
} faults[] = {
    {"camera turned away", REFUSED, FFP_RULE_DEVICE_BEHIND, "135", .move = turn_round,
     .devices = CAMERAS | ONE, .by = 0},
    {"projector turned away", REFUSED, FFP_RULE_DEVICE_BEHIND, "135", .move = turn_round,
     .devices = PROJECTORS | ONE, .by = 0},
    {"camera inside the object", REFUSED, FFP_RULE_DEVICE_INSIDE, "135", .move = put_inside,
     .devices = CAMERAS | ONE, .by = 0.1F},
    {"projector inside the object", REFUSED, FFP_RULE_DEVICE_INSIDE, "135", .move = put_inside,
     .devices = PROJECTORS | ONE, .by = 0.1F},
    {"cameras' positions in mm", REFUSED, FFP_RULE_DEVICE_FAR, NULL, .move = scale_place, .devices = CAMERAS,
     .by = 1000},
    {"projectors' positions in mm", REFUSED, FFP_RULE_DEVICE_FAR, NULL, .move = scale_place,
     .devices = PROJECTORS, .by = 1000},
    {"cameras' positions in km", REFUSED, FFP_RULE_DEVICE_INSIDE, NULL, .move = scale_place,
     .devices = CAMERAS, .by = 0.001F},
    {"camera poses inverted", REFUSED, FFP_RULE_DEVICE_BEHIND, NULL, .move = invert, .devices = CAMERAS,
     .by = 0},
    {"projector poses inverted", REFUSED, FFP_RULE_PROJECTOR_INVERTED, NULL, .move = invert,
     .devices = PROJECTORS, .by = 0},
    {"OpenGL's axes", REFUSED, FFP_RULE_AXES, NULL, .move = flip_axes, .devices = CAMERAS | PROJECTORS,
     .by = 0},
    {"camera calibrated at half the size", REFUSED, FFP_RULE_CAMERA_SIZE, NULL, .move = scale_intrinsics,
     .devices = CAMERAS, .by = 0.5F},
    {"camera calibrated at twice the size", REFUSED, FFP_RULE_CAMERA_SIZE, NULL, .move = scale_intrinsics,
     .devices = CAMERAS, .by = 2},
    {"projector calibrated at half the size", REFUSED, FFP_RULE_PROJECTOR_SIZE, NULL,
     .move = scale_intrinsics, .devices = PROJECTORS, .by = 0.5F},
    {"projector calibrated at twice the size", REFUSED, FFP_RULE_PROJECTOR_SIZE, NULL,
     .move = scale_intrinsics, .devices = PROJECTORS, .by = 2},
    {"one stop's angle off by 45 degrees", NOTED, FFP_RULE_NOTE_VIEW_CONTRADICTS, "135", .move = turn,
     .devices = CAMERAS | PROJECTORS | ONE, .by = 45},
    {"every step 7 degrees too wide", NOTED, FFP_RULE_NOTE_VIEWS_CONTRADICT, NULL, .put = steps_too_wide,
     .how = 7},
    {"one view's projector moved by 40 degrees", REFUSED, FFP_RULE_PATTERN_NOT_THERE, "135", .move = turn,
     .devices = PROJECTORS | ONE, .by = 40},
    {"axis off by a third of the radius", NOTED, FFP_RULE_NOTE_VIEWS_CONTRADICT, NULL, .put = axis_off,
     .how = 30},
    {"one view upside down (turned by 180 degrees)", REFUSED, FFP_RULE_VIEW_TURNED, "135",
     .put = move_photographs, .how = UPSIDE_DOWN},
    {"one view turned left", REFUSED, FFP_RULE_VIEW_TURNED, "135", .put = move_photographs, .how = LEFT},
    {"one view turned right", REFUSED, FFP_RULE_VIEW_TURNED, "135", .put = move_photographs, .how = RIGHT},
    {"one view mirrored", REFUSED, FFP_RULE_VIEW_TURNED, "135", .put = move_photographs, .how = MIRRORED},
    {"one view mirrored upside down", REFUSED, FFP_RULE_VIEW_TURNED, "135", .put = move_photographs,
     .how = FLIPPED},
    {"two views exchanged", REFUSED, FFP_RULE_VIEWS_EXCHANGED, "135", .put = exchange_with, .how = OTHER},
    {"two neighbours exchanged", REFUSED, FFP_RULE_VIEWS_EXCHANGED, "135", .put = exchange_with,
     .how = VIEW + 1},
    {"turntable in the other direction", REFUSED, FFP_RULE_OTHER_DIRECTION, NULL, .put = reversed_turntable,
     .how = 0},
    {"black and white exchanged", REFUSED, FFP_RULE_EXCHANGED, NULL, .put = exchange_everywhere,
     .how = BLACK_WHITE},
    {"black and white exchanged in one view", REFUSED, FFP_RULE_EXCHANGED, "135", .put = exchange_once,
     .how = BLACK_WHITE},
    {"white and pattern exchanged", REFUSED, FFP_RULE_EXCHANGED, NULL, .put = exchange_everywhere,
     .how = ACTIVE_WHITE},
    {"white and pattern exchanged in one view", REFUSED, FFP_RULE_EXCHANGED, "135", .put = exchange_once,
     .how = ACTIVE_WHITE},
    {"black and pattern exchanged", REFUSED, FFP_RULE_EXCHANGED, NULL, .put = exchange_everywhere,
     .how = ACTIVE_BLACK},
    {"two views' photographs of the pattern exchanged", REFUSED, FFP_RULE_PATTERN_EXCHANGED, "135",
     .put = active_of_another_view, .how = OTHER},
    {"white photographed twice, the pattern not", REFUSED, FFP_RULE_SAME_PHOTOGRAPH, "135",
     .put = active_taken_twice, .how = 0},
    {"one stop photographed twice", NOTED, FFP_RULE_SAME_VIEW, "135", .put = stop_taken_twice,
     .how = VIEW - 1},
    {"projector off at one stop", REFUSED, FFP_RULE_PROJECTOR_DARK, "135", .put = projector_off, .how = 0},
    {"a lamp on at one stop", NOTED, FFP_RULE_LAMP, "135", .put = lamp_on, .how = 0},
    {"overexposed by two stops", NOTED, FFP_RULE_NOTE_CLIPPED, NULL, .put = exposed, .how = 4000},
    {"underexposed by six stops", NOTED, FFP_RULE_NOTE_UNDEREXPOSED, NULL, .put = exposed, .how = 15},
    {"a room too bright", NOTED, FFP_RULE_BRIGHT_ROOM, NULL, .put = bright_room, .how = 750},
    {"one mask inverted", REFUSED, FFP_RULE_MASK_INVERTED, "135", .put = mask_inverted, .how = 0},
    {"one mask empty", REFUSED, FFP_RULE_MASK_EMPTY, "135", .put = mask_empty, .how = 0},
    {"one view with the mask of another, a quarter turn away", NOTED, FFP_RULE_NOTE_VIEW_CONTRADICTS, "135",
     .put = mask_of, .how = VIEW - 2},
    {"red and blue exchanged in all photographs", REFUSED, FFP_RULE_RED_AND_BLUE, NULL,
     .put = channels_reversed, .how = 0},
    {"pattern's file mirrored", REFUSED, FFP_RULE_PATTERN_MIRRORED, NULL, .put = move_pattern,
     .how = MIRRORED},
    {"pattern's file upside down", REFUSED, FFP_RULE_PATTERN_MIRRORED, NULL, .put = move_pattern,
     .how = FLIPPED},
    {"pattern's file turned by 180 degrees", REFUSED, FFP_RULE_PATTERN_MIRRORED, NULL, .put = move_pattern,
     .how = UPSIDE_DOWN},
    {"files of two patterns exchanged", REFUSED, FFP_RULE_OTHER_PATTERN, NULL, .put = another_pattern,
     .how = 0},
    {"a pattern that was never shown", NOTED, FFP_RULE_NOTE_CHANCE, NULL, .put = unknown_pattern, .how = 40},
};
enum { FAULTS = sizeof faults / sizeof *faults };

static void put(const struct Fault *fault, FfpCapture *c) {
    if (fault->put) {
        fault->put(c, fault->how);
        return;
    }
    for (int v = 0; v < c->n_views; v++) {
        if (fault->devices & ONE && v != VIEW) continue;
        if (fault->devices & CAMERAS) fault->move(&view_of(c, v)->camera, c, fault->by);
        if (fault->devices & PROJECTORS) fault->move(&view_of(c, v)->projector, c, fault->by);
    }
}

// --- Looking. ---

static bool check(void *capture, FfpError *err) {
    FfpFindings found = {0};
    if (whole)
        ffp_rig_look(&found, capture, &((FfpCapture *)capture)->views[0].camera);
    else
        ffp_rig_faults(&found, capture);
    items = ffp_findings_packed(&found);
    count = found.count;
    (void)err;
    sound = !ffp_findings_fault(&found);
    for (int i = 0; i < count; i++) {
        const size_t n = strlen(said);
        if (items[i].severity == FFP_FINDING_OK) continue;
        snprintf(said + n, sizeof said - n, "%s%s%s (%s); ", items[i].text, items[i].advice ? ": " : "",
                 items[i].advice ? items[i].advice : "", items[i].view ? items[i].view : "all");
    }
    ffp_findings_free(&found);
    return true; // what was found outlives the call
}

// True if nothing was refused; `said`, `items` and `count` have what was found.
static bool look(FfpContext *context, FfpCapture *capture, double *took) {
    FfpError err = {0};
    ffp_free(items), items = NULL, count = 0;
    said[0] = 0;
    const clock_t began = clock();
    const bool passed = ffp_call_run(context, check, capture, &err) && sound;
    *took = (double)(clock() - began) / CLOCKS_PER_SEC; // of all threads
    return passed;
}

// By its rule, and the view.
static bool is_named(const struct Fault *fault, bool passed) {
    bool named = false;
    for (int i = 0; i < count; i++)
        named = named || (strcmp(items[i].code, ffp_rule(fault->rule)->code) == 0 &&
                          (!fault->view || strstr(items[i].view ? items[i].view : "", fault->view) ||
                           strstr(items[i].other ? items[i].other : "", fault->view)));
    return named && passed == (fault->kind == NOTED);
}

static int try_faults(FfpContext *context, const char *path) {
    int missed = 0;
    printf("| fault | found | named | ms | said |\n|---|---|---|---|---|\n");
    for (int f = 0; f < FAULTS; f++) {
        FfpCapture capture;
        FfpError err = {0};
        double took;
        if (!ffp_capture_read(&capture, path, &err)) {
            fprintf(stderr, "rig_faults: %s\n", err.text);
            return 1;
        }
        put(&faults[f], &capture);
        const bool passed = look(context, &capture, &took);
        const bool named = is_named(&faults[f], passed);
        missed += !named;
        printf("| %s | %s | %s | %.0f | %s |\n", faults[f].name,
               !passed   ? "refused"
               : said[0] ? "noted"
                         : "no",
               named ? "yes" : "no", 1e3 * took, said);
        fflush(stdout);
        ffp_capture_free(&capture);
    }
    printf("\n%d of %d named.\n", FAULTS - missed, FAULTS);
    return missed;
}

static int try_sound(FfpContext *context, FfpCapture *capture, const char *name, double *most) {
    double took, all;
    whole = false;
    const bool passed = look(context, capture, &took);
    whole = true;
    look(context, capture, &all);
    *most = fmax(*most, took);
    if (!passed || said[0]) printf("%s: %s (%.0f ms)\n", name, said, 1e3 * took);
    fflush(stdout);
    return !passed;
}

static FfpSceneSpec scene_of(int64_t index) {
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.resolution = 128;
    spec.views = 8;
    spec.targets = 0;
    spec.lollipops = 1;
    spec.pattern_side = 800;
    spec.samples = 4;
    spec.ambient_rays = 1;
    ffp_dataset_scene("test", index, 0, &spec);
    return spec;
}

int main(int argc, char **argv) {
    FfpContextSettings settings = ffp_context_defaults();
    FfpContext *context = ffp_context_new(&settings, NULL);
    const long scenes = argc > 2 ? atol(argv[2]) : 0;
    int wrong = argc > 1 && context ? try_faults(context, argv[1]) : 1;
    double most = 0;
    for (int i = 1; i < argc; i++) {
        FfpCapture capture;
        FfpError err = {0};
        if (i == 2) continue;
        if (!ffp_capture_read(&capture, argv[i], &err)) {
            printf("%s: %s\n", argv[i], err.text);
            continue;
        }
        wrong += try_sound(context, &capture, argv[i], &most);
        ffp_capture_free(&capture);
    }
    for (long s = 0; s < scenes; s++) {
        FfpCapture capture;
        FfpError err = {0};
        const FfpSceneSpec spec = scene_of(s);
        char name[32];
        snprintf(name, sizeof name, "test scene %ld", s);
        if (!ffp_scene_make(&capture, &spec, &err)) {
            printf("%s: %s\n", name, err.text);
            wrong++;
            continue;
        }
        wrong += try_sound(context, &capture, name, &most);
        ffp_capture_free(&capture);
    }
    printf("\n%d captures and %ld test scenes without fault; at most %.0f ms.\n",
           argc > 2 ? argc - 2 : argc - 1, scenes, 1e3 * most);
    ffp_context_free(context);
    return wrong > 0;
}
