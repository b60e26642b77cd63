// Forty faults of rigs and captures, put into a capture in memory one at a time: what the checks before the
// work say of each, and what they cost; then captures without fault, of which nothing may be said. Prints
// tables in Markdown. The exit status is 1 if a fault is missed or a faultless capture refused.
//   rig_faults CAPTURE [SCENES [CAPTURE...]]     SCENES: of the test split, from the first on
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "bench/on_request.h"
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

static void turn_round(FfpCamera *d) {
    for (int i = 0; i < 3; i++) {
        d->pose[4 * i] = -d->pose[4 * i];
        d->pose[4 * i + 2] = -d->pose[4 * i + 2];
    }
}

static void put_inside(const FfpCapture *c, FfpCamera *d) {
    for (int i = 0; i < 3; i++) d->pose[4 * i + 3] = c->centre[i] - 0.1F * c->radius * d->pose[4 * i + 2];
}

static void move_by(FfpCamera *d, real factor) {
    for (int i = 0; i < 3; i++) d->pose[4 * i + 3] *= factor;
}

// World-to-device in place of device-to-world.
static void invert(FfpCamera *d) {
    real out[16] = {[15] = 1};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            out[4 * i + k] = d->pose[4 * k + i];
            out[4 * i + 3] -= d->pose[4 * k + i] * d->pose[4 * k + 3];
        }
    memcpy(d->pose, out, sizeof out);
}

static void flip_axes(FfpCamera *d) {
    for (int i = 0; i < 3; i++) {
        d->pose[4 * i + 1] = -d->pose[4 * i + 1];
        d->pose[4 * i + 2] = -d->pose[4 * i + 2];
    }
}

static void scale_intrinsics(FfpCamera *d, real factor) {
    d->fx *= factor, d->fy *= factor;
    d->cx *= factor, d->cy *= factor;
}

// About the world's z.
static void turn_about_z(FfpCamera *d, double degrees) {
    const real s = (real)sin(degrees * acos(-1.0) / 180), c = (real)cos(degrees * acos(-1.0) / 180);
    for (int k = 0; k < 4; k++) {
        const real x = d->pose[k], y = d->pose[4 + k];
        d->pose[k] = c * x - s * y;
        d->pose[4 + k] = s * x + c * y;
    }
}

#define EVERY_VIEW(c) for (FfpView *v = (c)->views; v < (c)->views + (c)->n_views; v++)

static void camera_behind(FfpCapture *c) {
    turn_round(&view_of(c, VIEW)->camera);
}
static void projector_behind(FfpCapture *c) {
    turn_round(&view_of(c, VIEW)->projector);
}
static void camera_inside(FfpCapture *c) {
    put_inside(c, &view_of(c, VIEW)->camera);
}
static void projector_inside(FfpCapture *c) {
    put_inside(c, &view_of(c, VIEW)->projector);
}
static void cameras_in_millimetres(FfpCapture *c) {
    EVERY_VIEW(c) move_by(&v->camera, 1000);
}
static void projectors_in_millimetres(FfpCapture *c) {
    EVERY_VIEW(c) move_by(&v->projector, 1000);
}
static void cameras_in_metres(FfpCapture *c) {
    EVERY_VIEW(c) move_by(&v->camera, 0.001F);
}
static void cameras_inverted(FfpCapture *c) {
    EVERY_VIEW(c) invert(&v->camera);
}
static void projectors_inverted(FfpCapture *c) {
    EVERY_VIEW(c) invert(&v->projector);
}
static void opengl_axes(FfpCapture *c) {
    EVERY_VIEW(c) {
        flip_axes(&v->camera);
        flip_axes(&v->projector);
    }
}
static void camera_of_half_size(FfpCapture *c) {
    EVERY_VIEW(c) scale_intrinsics(&v->camera, 0.5F);
}
static void camera_of_twice_the_size(FfpCapture *c) {
    EVERY_VIEW(c) scale_intrinsics(&v->camera, 2);
}
static void projector_of_half_size(FfpCapture *c) {
    EVERY_VIEW(c) scale_intrinsics(&v->projector, 0.5F);
}
static void projector_of_twice_the_size(FfpCapture *c) {
    EVERY_VIEW(c) scale_intrinsics(&v->projector, 2);
}
static void one_stop_wrong(FfpCapture *c) {
    turn_about_z(&view_of(c, VIEW)->camera, 45);
    turn_about_z(&view_of(c, VIEW)->projector, 45);
}
static void steps_too_wide(FfpCapture *c) {
    for (int v = 0; v < c->n_views; v++) {
        turn_about_z(&view_of(c, v)->camera, 7 * v);
        turn_about_z(&view_of(c, v)->projector, 7 * v);
    }
}
static void one_projector_moved(FfpCapture *c) {
    turn_about_z(&view_of(c, VIEW)->projector, 40);
}
static void axis_off(FfpCapture *c) {
    EVERY_VIEW(c) {
        for (int i = 0; i < 3; i++) {
            const real step = 0.3F * c->radius * v->camera.pose[4 * i];
            v->camera.pose[4 * i + 3] += step;
            v->projector.pose[4 * i + 3] += step;
        }
    }
}

// --- Photographs. ---

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

static void move_photographs(FfpCapture *c, int move) {
    FfpView *v = view_of(c, VIEW);
    for (int p = 0; p < c->n_patterns; p++)
        if (v->images[p].data) replace(&v->images[p], moved_picture(&v->images[p], move));
    replace(&v->coverage, moved_picture(&v->coverage, move));
}

static void exchange_pictures(FfpImage *a, FfpImage *b) {
    const FfpImage kept = *a;
    *a = *b;
    *b = kept;
}

static void exchange_views(FfpCapture *c, int a, int b) {
    FfpView *one = view_of(c, a), *other = view_of(c, b);
    for (int p = 0; p < c->n_patterns; p++) exchange_pictures(&one->images[p], &other->images[p]);
    exchange_pictures(&one->coverage, &other->coverage);
}

static void exchange_patterns(FfpView *v, int a, int b) {
    exchange_pictures(&v->images[a], &v->images[b]);
}

static void scale_picture(FfpImage *image, real factor, real plus) {
    for (ptrdiff_t i = 0; i < (ptrdiff_t)3 * image->width * image->height; i++)
        image->data[i] = fminf(factor * image->data[i] + plus, 1);
}

static void reverse_channels(FfpImage *image) {
    for (ptrdiff_t i = 0; i < (ptrdiff_t)image->width * image->height; i++) {
        const real red = image->data[3 * i];
        image->data[3 * i] = image->data[3 * i + 2];
        image->data[3 * i + 2] = red;
    }
}

static void upside_down(FfpCapture *c) {
    move_photographs(c, 0);
}
static void turned_left(FfpCapture *c) {
    move_photographs(c, 1);
}
static void turned_right(FfpCapture *c) {
    move_photographs(c, 2);
}
static void mirrored(FfpCapture *c) {
    move_photographs(c, 3);
}
static void flipped(FfpCapture *c) {
    move_photographs(c, 4);
}
static void exchanged(FfpCapture *c) {
    exchange_views(c, VIEW, OTHER);
}
static void neighbours_exchanged(FfpCapture *c) {
    exchange_views(c, VIEW, VIEW + 1);
}
static void reversed_turntable(FfpCapture *c) {
    for (int v = 1; 2 * v < c->n_views; v++) exchange_views(c, v, c->n_views - v);
}
static void black_and_white(FfpCapture *c) {
    EVERY_VIEW(c) exchange_patterns(v, c->black, c->white);
}
static void black_and_white_once(FfpCapture *c) {
    exchange_patterns(view_of(c, VIEW), c->black, c->white);
}
static void white_and_active(FfpCapture *c) {
    EVERY_VIEW(c) exchange_patterns(v, active_of(c), c->white);
}
static void white_and_active_once(FfpCapture *c) {
    exchange_patterns(view_of(c, VIEW), active_of(c), c->white);
}
static void black_and_active(FfpCapture *c) {
    EVERY_VIEW(c) exchange_patterns(v, active_of(c), c->black);
}
static void active_of_another_view(FfpCapture *c) {
    exchange_pictures(&view_of(c, VIEW)->images[active_of(c)], &view_of(c, OTHER)->images[active_of(c)]);
}
static void active_taken_twice(FfpCapture *c) {
    FfpView *v = view_of(c, VIEW);
    replace(&v->images[active_of(c)], ffp_image_copy(&v->images[c->white]));
}
static void stop_taken_twice(FfpCapture *c) {
    for (int p = 0; p < c->n_patterns; p++)
        if (view_of(c, VIEW)->images[p].data)
            replace(&view_of(c, VIEW)->images[p], ffp_image_copy(&view_of(c, VIEW - 1)->images[p]));
    replace(&view_of(c, VIEW)->coverage, ffp_image_copy(&view_of(c, VIEW - 1)->coverage));
}
static void projector_off(FfpCapture *c) {
    FfpView *v = view_of(c, VIEW);
    for (int p = 0; p < c->n_patterns; p++) {
        if (p == c->black || !v->images[p].data) continue;
        replace(&v->images[p], ffp_image_copy(&v->images[c->black]));
        v->images[p].data[0] += 1e-4F; // as two photographs differ
        v->images[p].data[1] += 1e-4F * (real)(p + 1);
    }
}
static void lamp_on(FfpCapture *c) {
    FfpView *v = view_of(c, VIEW);
    for (int p = 0; p < c->n_patterns; p++)
        for (ptrdiff_t i = 0; v->images[p].data && i < (ptrdiff_t)v->camera.width * v->camera.height; i++)
            for (int k = 0; k < 3; k++) v->images[p].data[3 * i + k] += 0.5F * v->coverage.data[i];
}
static void overexposed(FfpCapture *c) {
    EVERY_VIEW(c)
    for (int p = 0; p < c->n_patterns; p++)
        if (v->images[p].data) scale_picture(&v->images[p], 4, 0);
}
static void underexposed(FfpCapture *c) {
    EVERY_VIEW(c)
    for (int p = 0; p < c->n_patterns; p++)
        if (v->images[p].data) scale_picture(&v->images[p], 0.015F, 0);
}
static void bright_room(FfpCapture *c) {
    EVERY_VIEW(c)
    for (int p = 0; p < c->n_patterns; p++)
        if (v->images[p].data) scale_picture(&v->images[p], 0.25F, 0.75F);
}
static void mask_inverted(FfpCapture *c) {
    FfpImage *mask = &view_of(c, VIEW)->coverage;
    for (ptrdiff_t i = 0; i < (ptrdiff_t)mask->width * mask->height; i++) mask->data[i] = 1 - mask->data[i];
}
static void mask_empty(FfpCapture *c) {
    FfpImage *mask = &view_of(c, VIEW)->coverage;
    memset(mask->data, 0, (size_t)mask->width * (size_t)mask->height * sizeof *mask->data);
}
static void mask_of_another_view(FfpCapture *c) {
    FfpView *v = view_of(c, VIEW);
    replace(&v->coverage, ffp_image_copy(&view_of(c, VIEW - 2)->coverage));
    for (int p = 0; p < c->n_patterns; p++)
        for (ptrdiff_t i = 0; v->images[p].data && i < (ptrdiff_t)v->camera.width * v->camera.height; i++)
            for (int k = 0; k < 3; k++) v->images[p].data[3 * i + k] *= v->coverage.data[i];
}
static void channels_reversed(FfpCapture *c) {
    EVERY_VIEW(c)
    for (int p = 0; p < c->n_patterns; p++)
        if (v->images[p].data) reverse_channels(&v->images[p]);
}

// --- Patterns. ---

static void mirror_pattern(FfpCapture *c, int move) {
    FfpPattern *p = &c->patterns[active_of(c)];
    replace(&p->image, moved_picture(&p->image, move));
}
static void pattern_mirrored(FfpCapture *c) {
    mirror_pattern(c, 3);
}
static void pattern_flipped(FfpCapture *c) {
    mirror_pattern(c, 4);
}
static void pattern_turned(FfpCapture *c) {
    mirror_pattern(c, 0);
}
static void another_pattern(FfpCapture *c) {
    const int a = active_of(c);
    for (int p = 0; p < c->n_patterns; p++)
        if (p != a && p != c->black && p != c->white) {
            exchange_pictures(&c->patterns[p].image, &c->patterns[a].image);
            return;
        }
}
static void unknown_pattern(FfpCapture *c) {
    FfpImage *image = &c->patterns[active_of(c)].image;
    for (ptrdiff_t i = 0; i < (ptrdiff_t)image->width * image->height; i++) {
        const int x = (int)(i % image->width) / 40, y = (int)(i / image->width) / 40;
        for (int k = 0; k < 3; k++) image->data[3 * i + k] = (real)((x * 7 + y * 13 + k * 5) % 11 > 5);
    }
}

typedef enum Kind { REFUSED, NOTED } Kind;

static const struct Fault {
    const char *name;
    void (*put)(FfpCapture *c);
    Kind kind;
    FfpRuleId rule;   // by which it is to be named
    const char *view; // its end; NULL: no view of its own
} faults[] = {
    {"camera turned away", camera_behind, REFUSED, FFP_RULE_DEVICE_BEHIND, "135"},
    {"projector turned away", projector_behind, REFUSED, FFP_RULE_DEVICE_BEHIND, "135"},
    {"camera inside the object", camera_inside, REFUSED, FFP_RULE_DEVICE_INSIDE, "135"},
    {"projector inside the object", projector_inside, REFUSED, FFP_RULE_DEVICE_INSIDE, "135"},
    {"cameras' positions in mm", cameras_in_millimetres, REFUSED, FFP_RULE_DEVICE_FAR, NULL},
    {"projectors' positions in mm", projectors_in_millimetres, REFUSED, FFP_RULE_DEVICE_FAR, NULL},
    {"cameras' positions in km", cameras_in_metres, REFUSED, FFP_RULE_DEVICE_INSIDE, NULL},
    {"camera poses inverted", cameras_inverted, REFUSED, FFP_RULE_DEVICE_BEHIND, NULL},
    {"projector poses inverted", projectors_inverted, REFUSED, FFP_RULE_PROJECTOR_INVERTED, NULL},
    {"OpenGL's axes", opengl_axes, REFUSED, FFP_RULE_AXES, NULL},
    {"camera calibrated at half the size", camera_of_half_size, REFUSED, FFP_RULE_CAMERA_SIZE, NULL},
    {"camera calibrated at twice the size", camera_of_twice_the_size, REFUSED, FFP_RULE_CAMERA_SIZE, NULL},
    {"projector calibrated at half the size", projector_of_half_size, REFUSED, FFP_RULE_PROJECTOR_SIZE, NULL},
    {"projector calibrated at twice the size", projector_of_twice_the_size, REFUSED, FFP_RULE_PROJECTOR_SIZE,
     NULL},
    {"one stop's angle off by 45 degrees", one_stop_wrong, NOTED, FFP_RULE_NOTE_VIEW_CONTRADICTS, "135"},
    {"every step 7 degrees too wide", steps_too_wide, NOTED, FFP_RULE_NOTE_VIEWS_CONTRADICT, NULL},
    {"one view's projector moved by 40 degrees", one_projector_moved, REFUSED, FFP_RULE_PATTERN_NOT_THERE,
     "135"},
    {"axis off by a third of the radius", axis_off, NOTED, FFP_RULE_NOTE_VIEWS_CONTRADICT, NULL},
    {"one view upside down (turned by 180 degrees)", upside_down, REFUSED, FFP_RULE_VIEW_TURNED, "135"},
    {"one view turned left", turned_left, REFUSED, FFP_RULE_VIEW_TURNED, "135"},
    {"one view turned right", turned_right, REFUSED, FFP_RULE_VIEW_TURNED, "135"},
    {"one view mirrored", mirrored, REFUSED, FFP_RULE_VIEW_TURNED, "135"},
    {"one view mirrored upside down", flipped, REFUSED, FFP_RULE_VIEW_TURNED, "135"},
    {"two views exchanged", exchanged, REFUSED, FFP_RULE_VIEWS_EXCHANGED, "135"},
    {"two neighbours exchanged", neighbours_exchanged, REFUSED, FFP_RULE_VIEWS_EXCHANGED, "135"},
    {"turntable in the other direction", reversed_turntable, REFUSED, FFP_RULE_OTHER_DIRECTION, NULL},
    {"black and white exchanged", black_and_white, REFUSED, FFP_RULE_EXCHANGED, NULL},
    {"black and white exchanged in one view", black_and_white_once, REFUSED, FFP_RULE_EXCHANGED, "135"},
    {"white and pattern exchanged", white_and_active, REFUSED, FFP_RULE_EXCHANGED, NULL},
    {"white and pattern exchanged in one view", white_and_active_once, REFUSED, FFP_RULE_EXCHANGED, "135"},
    {"black and pattern exchanged", black_and_active, REFUSED, FFP_RULE_EXCHANGED, NULL},
    {"two views' photographs of the pattern exchanged", active_of_another_view, REFUSED,
     FFP_RULE_PATTERN_EXCHANGED, "135"},
    {"white photographed twice, the pattern not", active_taken_twice, REFUSED, FFP_RULE_SAME_PHOTOGRAPH,
     "135"},
    {"one stop photographed twice", stop_taken_twice, NOTED, FFP_RULE_SAME_VIEW, "135"},
    {"projector off at one stop", projector_off, REFUSED, FFP_RULE_PROJECTOR_DARK, "135"},
    {"a lamp on at one stop", lamp_on, NOTED, FFP_RULE_LAMP, "135"},
    {"overexposed by two stops", overexposed, NOTED, FFP_RULE_NOTE_CLIPPED, NULL},
    {"underexposed by six stops", underexposed, NOTED, FFP_RULE_NOTE_UNDEREXPOSED, NULL},
    {"a room too bright", bright_room, NOTED, FFP_RULE_BRIGHT_ROOM, NULL},
    {"one mask inverted", mask_inverted, REFUSED, FFP_RULE_MASK_INVERTED, "135"},
    {"one mask empty", mask_empty, REFUSED, FFP_RULE_MASK_EMPTY, "135"},
    {"one view with the mask of another, a quarter turn away", mask_of_another_view, NOTED,
     FFP_RULE_NOTE_VIEW_CONTRADICTS, "135"},
    {"red and blue exchanged in all photographs", channels_reversed, REFUSED, FFP_RULE_RED_AND_BLUE, NULL},
    {"pattern's file mirrored", pattern_mirrored, REFUSED, FFP_RULE_PATTERN_MIRRORED, NULL},
    {"pattern's file upside down", pattern_flipped, REFUSED, FFP_RULE_PATTERN_MIRRORED, NULL},
    {"pattern's file turned by 180 degrees", pattern_turned, REFUSED, FFP_RULE_PATTERN_MIRRORED, NULL},
    {"files of two patterns exchanged", another_pattern, REFUSED, FFP_RULE_OTHER_PATTERN, NULL},
    {"a pattern that was never shown", unknown_pattern, NOTED, FFP_RULE_NOTE_CHANCE, NULL},
};
enum { FAULTS = sizeof faults / sizeof *faults };

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
static bool look(FfpContext *context, FfpCapture *capture, Moment *took) {
    FfpError err = {0};
    ffp_free(items), items = NULL, count = 0;
    said[0] = 0;
    const Moment began = moment_now();
    const bool passed = ffp_call_run(context, check, capture, &err) && sound;
    const Moment ended = moment_now();
    *took = (Moment){ended.processor - began.processor, ended.wall - began.wall};
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
        Moment took;
        if (!ffp_capture_read(&capture, path, &err)) {
            fprintf(stderr, "rig_faults: %s\n", err.text);
            return 1;
        }
        faults[f].put(&capture);
        const bool passed = look(context, &capture, &took);
        const bool named = is_named(&faults[f], passed);
        missed += !named;
        printf("| %s | %s | %s | %.0f | %s |\n", faults[f].name,
               !passed   ? "refused"
               : said[0] ? "noted"
                         : "no",
               named ? "yes" : "no", 1e3 * took.processor, said);
        fflush(stdout);
        ffp_capture_free(&capture);
    }
    printf("\n%d of %d named.\n", FAULTS - missed, FAULTS);
    return missed;
}

static int try_sound(FfpContext *context, FfpCapture *capture, const char *name, double *most) {
    Moment took, all;
    whole = false;
    const bool passed = look(context, capture, &took);
    whole = true;
    look(context, capture, &all);
    *most = fmax(*most, took.processor);
    if (!passed || said[0]) printf("%s: %s (%.0f ms)\n", name, said, 1e3 * took.processor);
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
