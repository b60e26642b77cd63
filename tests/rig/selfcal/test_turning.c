// Labels: slow
// From the sightings of a turntable's stops to optics, axis and angles, without pictures; the stops that are
// left out, and the quantities that cannot be known.
#include "core/base/call.h"
#include "named.h"
#include "rig/chessboard/opencv.h"
#include "rig/selfcal/tables.h"

enum { ZOOMED = 5, COARSE = 20 };

#define NEEDS_OPENCV()                                                                                       \
    (void)state;                                                                                             \
    if (!ffp_cv_available(NULL)) skip()

static double off(double found, double truth) {
    return fabs(found / truth - 1);
}

static void check_found(const Table *table, int used) {
    Found f;
    FfpError err = {0};
    double u[3];
    if (!find(table, &f, &err)) fail_msg("%s", err.text);
    const FfpTurning *t = &f.turning;
    const double camera = exp(t->optics[FFP_BUNDLE_CAMERA_FOCAL]),
                 projector = exp(t->optics[FFP_BUNDLE_PROJECTOR_FOCAL]);
    axis_direction(u);
    const double tilt = acos(fmin(1, ffp_dot(u, t->axis.direction))) * 180 / FFP_PI_DOUBLE;
    printf(
        "camera %.2f +- %.2f %%, projector %.2f +- %.2f %%, axis off by %.3f degrees (said %.3f), rms %.3f, "
        "surface %.3f\n",
        camera, 100 * t->deviation[FFP_BUNDLE_CAMERA_FOCAL], projector,
        100 * t->deviation[FFP_BUNDLE_PROJECTOR_FOCAL], tilt, t->tilt * 180 / FFP_PI_DOUBLE, t->rms,
        t->surface);
    assert_true(off(camera, CAMERA) < 0.01 && off(projector, PROJECTOR) < 0.01);
    assert_true(tilt < 0.5 && t->surface < 3 * NOISE);
    assert_int_equal(t->reversed, table->reversed);
    int sound = 0;
    for (int p = 0; p < f.tracks.n_places; p++) {
        const double truth = angle_of(table, p) * (table->reversed ? -1 : 1);
        if (f.tracks.places[p].problem[0]) {
            printf("%s\n", f.tracks.places[p].problem);
            assert_int_equal(strstr(f.tracks.places[p].problem, "did not turn") != NULL, p == table->twin);
            continue;
        }
        sound++;
        const double found = t->given[p] + (t->reversed ? -1 : 1) * t->off[p];
        assert_float_equal(found - t->given[0], truth - angle_of(table, 0), 3e-3);
    }
    assert_int_equal(sound, used);
    forget(&f);
}

// A lens that was misread, angles turned by hand, the other way round; the object did not turn before one
// stop, and fell before the last.
static void a_turntable_is_found(void **state) {
    NEEDS_OPENCV();
    check_found(&(Table){.lens = 1.2 * CAMERA, .hand = 2, .reversed = true, .twin = 3, .moved = STOPS - 1},
                STOPS - 2);
}

static bool find_alone(void *table, FfpError *err) {
    Found f;
    const bool ok = find(table, &f, err);
    forget(&f);
    return ok;
}

static char said[4096];

static void check_refused(const Table *table, FfpRuleId rule) {
    Table copy = *table;
    const FfpError err = must_refuse(find_alone, &copy, rule, said);
    must_be(&err, rule);
}

static void what_cannot_be_known_is_said(void **state) {
    NEEDS_OPENCV();
    check_refused(&(Table){.round = true, .lens = CAMERA}, FFP_RULE_STOPS_ALIKE);
    check_refused(&(Table){.mirrored = true, .lens = CAMERA}, FFP_RULE_CODES_MIRRORED);
    check_refused(&(Table){.apart = 3, .lens = CAMERA}, FFP_RULE_DEVICES_NEAR);
    check_refused(&(Table){.less = 0.05, .lens = CAMERA}, FFP_RULE_STOP_ANGLE);
    check_refused(&(Table){.stops = 3, .twin = 1, .lens = CAMERA}, FFP_RULE_TOO_FEW);
    assert_non_null(strstr(said, "stop-left-out "));
}

static void angles_of_other_stops_fit_no_axis(void **state) {
    NEEDS_OPENCV();
    check_refused(&(Table){.lens = CAMERA, .pitch = COARSE, .hand = 60}, FFP_RULE_STOPS_UNTURNED);
}

typedef struct Named {
    const Table *table;
    char codes[256];
    char problem[768]; // of the stop that is zoomed
} Named;

static void keep_code(void *user, const FfpFinding *finding) {
    Named *n = user;
    const size_t used = strlen(n->codes);
    if (finding->severity >= FFP_FINDING_DOUBT)
        snprintf(n->codes + used, sizeof n->codes - used, "%s ", finding->code);
}

static bool find_named(void *argument, FfpError *err) {
    Named *n = argument;
    Found f;
    const bool ok = find(n->table, &f, err);
    memcpy(n->problem, f.tracks.places[ZOOMED].problem, sizeof n->problem);
    if (ok) {
        const double *deviation = f.turning.deviation, *optics = f.turning.optics;
        printf("camera %.2f +- %.2f %%, noise %.3f of %.3f pixels: %s\n",
               exp(optics[FFP_BUNDLE_CAMERA_FOCAL]), 100 * deviation[FFP_BUNDLE_CAMERA_FOCAL],
               f.turning.noise, f.turning.rms, n->codes);
        assert_true(off(exp(optics[FFP_BUNDLE_CAMERA_FOCAL]), CAMERA) <
                    3 * deviation[FFP_BUNDLE_CAMERA_FOCAL]);
    }
    forget(&f);
    return ok;
}

static Named name(const Table *table, const char *error) {
    Named n = {.table = table};
    FfpContext context = {.settings = {.finding = keep_code, .user = &n}};
    FfpError err = {0};
    assert_int_equal(ffp_call_run(&context, find_named, &n, &err), error == NULL);
    assert_non_null(strstr(err.text, error ? error : ""));
    return n;
}

// A projector that scales or corrects its picture, one stop that is zoomed, a lens that focuses at each.
static void faults_of_devices_are_named(void **state) {
    NEEDS_OPENCV();
    SAME_WAY_AGAIN();
    Named n =
        name(&(Table){.lens = CAMERA, .pitch = COARSE, .stretched = 0.03, .zoomed[ZOOMED] = 0.06}, NULL);
    assert_non_null(strstr(n.codes, "panel-stretched"));
    assert_null(strstr(n.codes, "misfit"));
    assert_non_null(strstr(n.problem, "was zoomed"));
    name(&(Table){.lens = CAMERA, .pitch = COARSE, .leaning = 0.05}, "its columns lean by 5");
    n = name(&(Table){.lens = CAMERA, .pitch = COARSE, .zoomed = {0, -0.015, 0.009, 0.015, -0.008, 0.005}},
             NULL);
    assert_non_null(strstr(n.codes, "stops-misfit"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_turntable_is_found),
        cmocka_unit_test(angles_of_other_stops_fit_no_axis),
        cmocka_unit_test(what_cannot_be_known_is_said),
        cmocka_unit_test(faults_of_devices_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
