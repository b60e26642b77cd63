// Sightings to optics and places, without pictures: what is found, what is left out, what cannot be known.
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/lens.h"
#include "core/base/rng.h"
#include "named.h"
#include "rig/chessboard/opencv.h"
#include "rig/selfcal/selfcal.h"

#define NEEDS_OPENCV()                                                                                       \
    (void)state;                                                                                             \
    if (!ffp_cv_available(NULL)) skip()

enum { WIDTH = 640, HEIGHT = 480, PANEL_WIDTH = 800, PANEL_HEIGHT = 500, PLACES = 4, SPOTS = 600 };
#define NOISE 0.1 // pixels
#define CAMERA 700.0
#define PROJECTOR 1150.0

static const double camera_lens[5] = {-0.08, 0.02, 0, 0, 0}, projector_lens[5] = {-0.04, 0, 0, 0, 0};

// Differences from a sound walk.
typedef struct Walk {
    double apart;  // degrees from one place to the next
    bool flat;     // a wall alone
    bool mirrored; // pictures
    int moved;     // place before which the projector turns; 0: it stands
    bool blurred;  // by shake, within each place
    bool level;    // all rows of the panel are read as one
    int unread;    // places that have photographs of no use
    double lens;   // the focal length that the user gives, pixels; 0: none
} Walk;

// The projector at the origin, the walls and boxes before it 3 to 5 units away.
static double depth_at(const Walk *walk, double x, double y) {
    if (walk->flat) return 4 / (1 + 0.2 * x - 0.1 * y);
    if (fabs(x) < 0.12 && fabs(y) < 0.1) return 2.6 + 3 * x;
    return y > 0.12 ? 3.6 / (1 + 3 * (y - 0.12)) : 5 / (1 + 1.5 * fabs(x - 0.05));
}

static FfpRigid pose_of(const Walk *walk, int place) { // projector's frame to the camera's there
    const double angle = (place - 0.5 * (PLACES - 1)) * walk->apart * FFP_PI_DOUBLE / 180;
    const double turn[3] = {0.1 + 0.01 * place, angle, 0.02 * place};
    const double steps = walk->apart / 12, away = 4 + 0.4 * steps * (place % 2);
    const double from[3] = {away * sin(angle), 0.5 * steps * (place % 3) - 0.3, 4 - away * cos(angle)};
    FfpRigid pose;
    ffp_rotation_from_vector(turn, pose.r);
    for (int k = 0; k < 3; k++) pose.t[k] = -ffp_dot(pose.r + 3 * k, from);
    return pose;
}

static bool see_spot(const Walk *walk, int place, const double panel[2], double at[2]) {
    const double x = (panel[0] - 0.51 * PANEL_WIDTH) / PROJECTOR,
                 y = (panel[1] - 0.5 * PANEL_HEIGHT - 0.1 * PANEL_WIDTH) / PROJECTOR;
    double ray[3] = {0, 0, 1}, point[3], seen[3], u, v;
    if (!ffp_lens_undistort(projector_lens, x, y, ray)) return false;
    if (walk->moved > 0 && place >= walk->moved) ray[0] += 0.07; // it turned
    for (int k = 0; k < 3; k++) point[k] = ray[k] * depth_at(walk, ray[0], ray[1]);
    const FfpRigid pose = pose_of(walk, place);
    for (int k = 0; k < 3; k++) seen[k] = ffp_dot(pose.r + 3 * k, point) + pose.t[k];
    if (!(seen[2] > 0)) return false;
    ffp_lens_distort(camera_lens, seen[0] / seen[2], seen[1] / seen[2], &u, &v);
    at[0] = 0.505 * WIDTH + CAMERA * u, at[1] = 0.5 * HEIGHT + CAMERA * v;
    if (walk->mirrored) at[0] = WIDTH - at[0];
    return at[0] >= 0 && at[1] >= 0 && at[0] < WIDTH && at[1] < HEIGHT;
}

static FfpTracks walk_tracks(const Walk *walk) {
    FfpTracks t = {.width = WIDTH,
                   .height = HEIGHT,
                   .panel_width = PANEL_WIDTH,
                   .panel_height = PANEL_HEIGHT,
                   .n_places = PLACES,
                   .places = ffp_alloc(PLACES, sizeof *t.places),
                   .tracks = ffp_alloc(SPOTS, sizeof *t.tracks),
                   .sightings = ffp_alloc((size_t)SPOTS * PLACES, sizeof *t.sightings)};
    FfpRng rng = ffp_rng(5, 1);
    for (int p = 0; p < PLACES; p++) {
        snprintf(t.places[p].name, sizeof t.places[p].name, "%d", p);
        snprintf(t.places[p].problem, sizeof t.places[p].problem, "%s", p < walk->unread ? "no white" : "");
    }
    for (int i = 0; i < SPOTS; i++) {
        FfpTrack *track = &t.tracks[t.n];
        *track = (FfpTrack){.panel = {(double)ffp_rng_range(&rng, 0, PANEL_WIDTH),
                                      (double)ffp_rng_range(&rng, 0, PANEL_HEIGHT)},
                            .first = t.n_sightings};
        const double panel[2] = {track->panel[0], track->panel[1]};
        if (walk->level) track->panel[1] = 0.5 * PANEL_HEIGHT;
        for (int p = 0; p < PLACES; p++) {
            FfpSighting *s = &t.sightings[t.n_sightings];
            *s = (FfpSighting){.place = p, .used = true};
            if (p < walk->unread || !see_spot(walk, p, panel, s->at)) continue;
            const double noise = walk->blurred ? 40 : NOISE;
            for (int k = 0; k < 2; k++) s->at[k] += noise * (double)ffp_rng_normal(&rng);
            if (i % 29 == 7 && p == 1) s->at[0] += 25; // codes misread
            t.n_sightings++, track->n++;
        }
        t.n += track->n > 0;
    }
    return t;
}

static FfpBundle new_bundle(const FfpTracks *t, const Walk *walk) {
    return (FfpBundle){.tracks = t,
                       .places = ffp_alloc(PLACES, sizeof(FfpRigid)),
                       .known = ffp_alloc(PLACES, sizeof(bool)),
                       .nearness = ffp_alloc((size_t)t->n, sizeof(double)),
                       .own = ffp_alloc(PLACES, sizeof(FfpOwn)),
                       .usual.focal = {walk->lens > 0 ? log(walk->lens) : 0, walk->lens > 0 ? 0.03 : 0}};
}

static void free_bundle(FfpBundle *b, FfpTracks *t) {
    ffp_free(b->places), ffp_free(b->known), ffp_free(b->nearness), ffp_free(b->deviation), ffp_free(b->own),
        ffp_free(b->own_deviation), ffp_free(b->focal_deviation);
    ffp_tracks_free(t);
}

static double off(double found, double truth) {
    return fabs(found / truth - 1);
}

// Between the first and the last place, degrees.
static double turn_off(const FfpBundle *b, const Walk *walk) {
    const FfpRigid first = pose_of(walk, 0), last = pose_of(walk, PLACES - 1);
    double truth[9], found[9], difference[9], v[3], transposed[2][9];
    for (int i = 0; i < 9; i++)
        transposed[0][i] = first.r[3 * (i % 3) + i / 3],
        transposed[1][i] = b->places[0].r[3 * (i % 3) + i / 3];
    ffp_rotation_product(last.r, transposed[0], truth);
    ffp_rotation_product(b->places[PLACES - 1].r, transposed[1], found);
    ffp_rotation_difference(found, truth, difference);
    ffp_rotation_to_vector(difference, v);
    return sqrt(ffp_dot(v, v)) * 180 / FFP_PI_DOUBLE;
}

static void check_found(const Walk *walk) {
    FfpTracks t = walk_tracks(walk);
    FfpBundle b = new_bundle(&t, walk);
    FfpError err = {0};
    if (!ffp_self_calibration_fit(&b, &err)) fail_msg("%s", err.text);
    const double camera = exp(b.optics[FFP_BUNDLE_CAMERA_FOCAL]),
                 projector = exp(b.optics[FFP_BUNDLE_PROJECTOR_FOCAL]);
    printf("camera %.2f +- %.2f %%, projector %.2f +- %.2f %%, rms %.3f, turn off by %.3f degrees\n", camera,
           100 * b.deviation[FFP_BUNDLE_CAMERA_FOCAL], projector,
           100 * b.deviation[FFP_BUNDLE_PROJECTOR_FOCAL], b.rms, turn_off(&b, walk));
    for (int p = 0; p < PLACES; p++) assert_true(b.known[p]);
    assert_true(off(camera, CAMERA) < 0.005 && off(projector, PROJECTOR) < 0.005);
    assert_true(turn_off(&b, walk) < 0.1 && b.rms < 2 * NOISE);
    assert_true(b.deviation[FFP_BUNDLE_CAMERA_FOCAL] < 0.01);
    free_bundle(&b, &t);
}

static void a_walk_is_found(void **state) {
    NEEDS_OPENCV();
    check_found(&(Walk){.apart = 12});
}

// The files' focal length holds if nobody gives a lens and it is plausible.
static void files_tell_the_lens(void **state) {
    (void)state;
    const FfpTracks tracks = {.width = 600, .height = 400, .focal_35mm = 50},
                    none = {.width = 600, .height = 400},
                    absurd = {.width = 600, .height = 400, .focal_35mm = 4};
    assert_true(fabs(exp(ffp_known_focal(0, &tracks).log) - 50.0 / 36 * 600) < 0.02);
    assert_true(fabs(exp(ffp_known_focal(24, &tracks).log) - 24.0 / 36 * 600) < 0.02);
    assert_true(ffp_known_focal(0, &none).deviation == 0 && ffp_known_focal(0, &absurd).deviation == 0);
}

static void what_photographs_hardly_tell_contradicts_no_lens(void **state) {
    (void)state;
    const FfpKnownFocal lens = {log(700), 0.03}, none = {0};
    assert_true(ffp_focal_contradicts(&lens, log(840), 0) && ffp_focal_contradicts(&lens, log(560), 0.02));
    assert_false(ffp_focal_contradicts(&lens, log(840), 0.1) || ffp_focal_contradicts(&none, log(840), 0));
}

// As one coordinate of a sighting that is off by its noise.
static void a_lens_counts_as_it_is_known(void **state) {
    (void)state;
    const FfpUsual usual = {.focal = {log(700), 0.03}};
    double optics[FFP_BUNDLE_OPTICS] = {log(700) + 0.03}, out[FFP_BUNDLE_PRIORS];
    ffp_optics_unusual(optics, &usual, 1, 1, out);
    assert_float_equal(out[FFP_BUNDLE_CAMERA_FOCAL] * out[FFP_BUNDLE_CAMERA_FOCAL], 0.5, 1e-6);
}

static void a_wrong_lens_is_overruled(void **state) {
    NEEDS_OPENCV();
    check_found(&(Walk){.apart = 12, .lens = 1.25 * CAMERA});
}

static bool fit(void *walk, FfpError *err) {
    FfpTracks t = walk_tracks(walk);
    FfpBundle b = new_bundle(&t, walk);
    const bool ok = ffp_self_calibration_fit(&b, err);
    free_bundle(&b, &t);
    return ok;
}

static char said[4096];

static FfpError check_refused(const Walk *walk, FfpRuleId rule) {
    Walk copy = *walk;
    const FfpError err = must_refuse(fit, &copy, rule, said);
    must_be(&err, rule);
    return err;
}

static void what_cannot_be_known_is_said(void **state) {
    NEEDS_OPENCV();
    check_refused(&(Walk){.apart = 12, .flat = true}, FFP_RULE_ONE_PLANE);
    check_refused(&(Walk){.apart = 0.1}, FFP_RULE_PLACES_NEAR);
    check_refused(&(Walk){.apart = 12, .mirrored = true}, FFP_RULE_CODES_MIRRORED);
    check_refused(&(Walk){.apart = 12, .level = true}, FFP_RULE_PLACES_UNEXPLAINED);
    check_refused(&(Walk){.apart = 0}, FFP_RULE_PLACES_NEAR); // as of takes from one tripod
}

// Before a walk fails, each place says why.
static void every_place_says_why(void **state) {
    NEEDS_OPENCV();
    FfpError err = check_refused(&(Walk){.apart = 12, .blurred = true}, FFP_RULE_PLACES_UNRELATED);
    assert_non_null(strstr(said, "place-left-out 3: "));
    assert_non_null(strstr(said, "fit any move of the camera"));
    assert_non_null(strstr(err.text, "enough of the same (4 left out, 0: of "));
    err = check_refused(&(Walk){.apart = 12, .unread = 3}, FFP_RULE_TOO_FEW);
    assert_non_null(strstr(said, "place-left-out 2: "));
    assert_null(strstr(said, "place-left-out 3: "));
    assert_non_null(strstr(err.text,
                           "1 of 4 places of the camera can be used, but 2 are needed (3 left out, 0: "
                           "no white)"));
}

static void a_place_after_a_move_is_left_out(void **state) {
    NEEDS_OPENCV();
    const Walk walk = {.apart = 12, .moved = PLACES - 1};
    FfpTracks t = walk_tracks(&walk);
    FfpBundle b = new_bundle(&t, &walk);
    FfpError err = {0};
    if (!ffp_self_calibration_fit(&b, &err)) fail_msg("%s", err.text);
    for (int p = 0; p < PLACES; p++) assert_int_equal(b.known[p], p < PLACES - 1);
    printf("%s\n", t.places[PLACES - 1].problem);
    assert_non_null(strstr(t.places[PLACES - 1].problem, "moved between"));
    free_bundle(&b, &t);
}

// A sighting that is not used tells nothing, as if it were not there.
static void deviations_are_of_what_is_used(void **state) {
    NEEDS_OPENCV();
    const Walk walk = {.apart = 12};
    FfpTracks tracks[2] = {walk_tracks(&walk), walk_tracks(&walk)}, *fewer = &tracks[1];
    double deviation[2];
    fewer->n_sightings = 0;
    for (int i = 0; i < tracks->n; i++) {
        FfpTrack *track = &fewer->tracks[i];
        const FfpSighting *all = &tracks->sightings[track->first];
        const int n = track->n;
        track->first = fewer->n_sightings, track->n = 0;
        for (int k = 0; k < n; k++) {
            tracks->sightings[tracks->tracks[i].first + k].used = (i + all[k].place) % 4 != 3;
            if (all[k].used) fewer->sightings[fewer->n_sightings++] = all[k], track->n++;
        }
    }
    for (int w = 0; w < 2; w++) {
        FfpBundle b = new_bundle(&tracks[w], &walk);
        for (int p = 0; p < PLACES; p++) b.places[p] = pose_of(&walk, p), b.known[p] = true;
        b.optics[FFP_BUNDLE_CAMERA_FOCAL] = log(CAMERA),
        b.optics[FFP_BUNDLE_PROJECTOR_FOCAL] = log(PROJECTOR);
        ffp_bundle_fit(&b, 1, 0, true);
        deviation[w] = b.deviation[FFP_BUNDLE_CAMERA_FOCAL];
        free_bundle(&b, &tracks[w]);
    }
    printf("%.4f %%, without what is not used %.4f %%\n", 100 * deviation[0], 100 * deviation[1]);
    assert_float_equal(deviation[0] / deviation[1], 1, 1e-3);
}

// Spots are where a plane through their pixels puts them; none on an edge between two surfaces.
static void spots_lie_on_surfaces(void **state) {
    (void)state;
    enum { SIDE = 120 };
    FfpImage map = ffp_image_new(SIDE, SIDE, 3), white = {0};
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            real *p = map.data + 3 * ((ptrdiff_t)y * SIDE + x);
            const double shift = x < SIDE / 2 ? 0 : 30; // the map's right half is of a surface behind
            p[0] = (real)(floor(1.5 * (x + 0.5) + shift) + 0.5), p[1] = (real)(1.5 * (y + 0.5)), p[2] = 1;
        }
    FfpTracks t = {.width = 2 * SIDE,
                   .height = 2 * SIDE,
                   .panel_width = 220,
                   .panel_height = 190,
                   .n_places = 1,
                   .places = ffp_alloc(1, sizeof *t.places)};
    ffp_tracks_find(&t, &map, &white, 2, 1.5);
    assert_true(t.n > 300);
    for (int i = 0; i < t.n; i++) {
        const double *panel = t.tracks[i].panel, *at = t.sightings[t.tracks[i].first].at;
        const double shift = panel[0] < 1.5 * SIDE / 2 ? 0 : 30;
        assert_true(panel[0] < 90.1 || panel[0] > 119.9);
        assert_float_equal(at[0], 2 * (panel[0] - shift) / 1.5, 0.5);
        assert_float_equal(at[1], 2 * panel[1] / 1.5, 0.01);
    }
    ffp_image_free(&map);
    ffp_tracks_free(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_walk_is_found),
        cmocka_unit_test(files_tell_the_lens),
        cmocka_unit_test(a_wrong_lens_is_overruled),
        cmocka_unit_test(a_lens_counts_as_it_is_known),
        cmocka_unit_test(what_photographs_hardly_tell_contradicts_no_lens),
        cmocka_unit_test(what_cannot_be_known_is_said),
        cmocka_unit_test(every_place_says_why),
        cmocka_unit_test(a_place_after_a_move_is_left_out),
        cmocka_unit_test(deviations_are_of_what_is_used),
        cmocka_unit_test(spots_lie_on_surfaces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
