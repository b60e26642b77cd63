// Random walks, sound and with faults of cameras and projectors: what is wrong lies within its deviation or
// has a name, and what is sound has none. bench/walk_faults counts many.
#include "named.h"
#include "rig/chessboard/opencv.h"
#include "rig/selfcal/walks.h"

enum { SPOTS = 360 };

static WalkResult run(WalkFault fault, uint64_t seed) {
    Walk walk = random_walk(seed, SPOTS);
    put_fault(&walk, fault);
    const WalkResult r = solve_walk(&walk);
    printf("%s: camera %+.2f +- %.2f %%, projector %+.2f +- %.2f %%, rms %.3f, noise %.3f: %s\n",
           walk_names[fault], 100 * r.camera[0], 100 * r.camera[1], 100 * r.projector[0],
           100 * r.projector[1], r.rms, r.noise, r.said);
    return r;
}

static bool within(const double value[2], double deviations) {
    return fabs(value[0]) <= deviations * value[1];
}

static void sound_rigs_raise_no_doubt(void **state) {
    (void)state;
    if (!ffp_cv_available(NULL)) skip();
    for (uint64_t seed = 0; seed < TIMES(5, 1); seed++) {
        const WalkResult r = run(WALK_SOUND, seed);
        assert_string_equal(r.said, "");
        assert_true(!r.refused && within(r.camera, 3) && within(r.projector, 3) && within(r.turn, 3));
        assert_true(r.camera[1] < 0.02);
    }
}

static void check_named(WalkFault fault, const char *code) {
    const WalkResult r = run(fault, 4);
    assert_non_null(strstr(r.said, code));
}

static void faults_are_named(void **state) {
    (void)state;
    if (!ffp_cv_available(NULL)) skip();
    SAME_WAY_AGAIN();
    check_named(WALK_ZOOMED, "place-zoomed");
    check_named(WALK_ZOOMED_A_LITTLE, "place-zoomed");
    check_named(WALK_STABILISED, "place-shifted");
    check_named(WALK_STRETCHED, "panel-stretched");
    check_named(WALK_KEYSTONED, "corrected");
    check_named(WALK_TURNED, "place");
    check_named(WALK_ROLLING, "places-misfit");
}

// Two cameras whose axes lie apart are not taken for one.
static void two_bodies_are_not_one(void **state) {
    (void)state;
    if (!ffp_cv_available(NULL)) skip();
    SAME_WAY_AGAIN();
    for (uint64_t seed = 0; seed < 4; seed++) {
        const WalkResult r = run(WALK_TWO_BODIES, seed);
        if (r.refused)
            assert_non_null(strstr(r.said, "uncertain"));
        else
            assert_true(within(r.camera, 1.2) && within(r.projector, 1.2));
    }
}

// A lens that is given is that of most places.
static void a_lens_is_that_of_most_places(void **state) {
    (void)state;
    if (!ffp_cv_available(NULL)) skip();
    SAME_WAY_AGAIN();
    const WalkResult r = run(WALK_TWO_LENSES, 5); // which has seven places
    assert_non_null(strstr(r.said, "place-zoomed"));
    assert_null(strstr(r.said, "lens-differs"));
}

// Two lenses before which a fit of one camera fails, told by the files; and two bodies.
static void every_place_may_have_its_own_camera(void **state) {
    (void)state;
    if (!ffp_cv_available(NULL)) skip();
    SAME_WAY_AGAIN();
    for (uint64_t seed = 0; seed < 6; seed++)
        for (int k = 0; k < 2; k++) {
            Walk walk = random_walk(seed, SPOTS);
            if (k == 0 && walk.places < 5) continue; // of the two lenses
            put_fault(&walk, k == 0 ? WALK_TWO_LENSES : WALK_STABILISED);
            walk.lens = 0, walk.each = true, walk.tagged = k == 0;
            const WalkResult r = solve_walk(&walk);
            printf("%s: camera %+.2f +- %.2f %%, projector %+.2f +- %.2f %%: %s\n", k ? "bodies" : "lenses",
                   100 * r.camera[0], 100 * r.camera[1], 100 * r.projector[0], 100 * r.projector[1], r.said);
            assert_null(strstr(r.said, "place-"));
            if (r.refused)
                assert_non_null(strstr(r.said, "camera's focal length is uncertain"));
            else
                assert_true(within(r.camera, 3) && within(r.projector, 3) && r.camera[1] < 0.07);
        }
}

static void keep_code(void *user, const FfpFinding *finding) {
    snprintf(user, 64, "%s: %s", finding->code, finding->text);
}

static bool end_three_ways(void *argument, FfpError *err) {
    (void)err;
    char *said = argument;
    ffp_tell_end(FFP_END_SETTLED);
    assert_string_equal(said, "");
    ffp_tell_end(FFP_END_STUCK);
    assert_non_null(strstr(said, "fit-unsettled: the fit ended before it settled: no step"));
    ffp_tell_end(FFP_END_UNFINISHED);
    assert_non_null(strstr(said, "steps ran"));
    return true;
}

static void a_fit_that_does_not_settle_is_told(void **state) {
    (void)state;
    char said[64] = "";
    FfpContext context = {.settings = {.finding = keep_code, .user = said}};
    assert_true(ffp_call_run(&context, end_three_ways, said, NULL));
}

typedef struct Judged {
    double deviation; // of a focal length, or
    double skew;      // of the panel, which is known to a thousandth
    FfpRuleId doubt;
} Judged;

static bool judge(void *argument, FfpError *err) {
    const Judged *j = argument;
    double optics[FFP_BUNDLE_OPTICS] = {0}, deviation[FFP_BUNDLE_OPTICS] = {0};
    optics[FFP_BUNDLE_PROJECTOR_SKEW] = j->skew, deviation[FFP_BUNDLE_PROJECTOR_SKEW] = 1e-3;
    return ffp_judge_focal(j->deviation, "camera", j->doubt, err) && ffp_judge_panel(optics, deviation, err);
}

static void what_is_uncertain_is_doubted_or_refused(void **state) {
    (void)state;
    static const FfpRuleId rules[2][2] = {{FFP_RULE_PLACES_FOCAL, FFP_RULE_PLACES_FOCAL_OPEN},
                                          {FFP_RULE_STOPS_FOCAL, FFP_RULE_STOPS_FOCAL_OPEN}};
    char said[4096] = "";
    FfpContext context = {.settings = {.finding = keep_told, .user = said}};
    for (int k = 0; k < 2; k++) {
        said[0] = 0;
        assert_true(ffp_call_run(&context, judge, &(Judged){.deviation = 0.01, .doubt = rules[k][0]}, NULL));
        assert_string_equal(said, "");
        assert_true(ffp_call_run(&context, judge, &(Judged){.deviation = 0.05, .doubt = rules[k][0]}, NULL));
        assert_ptr_equal(strstr(said, ffp_rule(rules[k][0])->code), said);
        const FfpError err =
            must_refuse(judge, &(Judged){.deviation = INFINITY, .doubt = rules[k][0]}, rules[k][1], said);
        assert_non_null(strstr(err.text, "is uncertain by 999.0 %"));
    }
    must_refuse(judge, &(Judged){.skew = 0.03, .doubt = FFP_RULE_PLACES_FOCAL}, FFP_RULE_PANEL_KEYSTONED,
                said);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sound_rigs_raise_no_doubt),
        cmocka_unit_test(faults_are_named),
        cmocka_unit_test(two_bodies_are_not_one),
        cmocka_unit_test(a_lens_is_that_of_most_places),
        cmocka_unit_test(every_place_may_have_its_own_camera),
        cmocka_unit_test(what_is_uncertain_is_doubted_or_refused),
        cmocka_unit_test(a_fit_that_does_not_settle_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
