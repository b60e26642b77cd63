// A projector found again by points on an object and the pixels that light them: exact, noisy, with wrong
// pixels and through a shifted lens; and what must be refused.
#include <math.h>
#include "core/base/rng.h"
#include "core/numerics/resection.h"
#include "support.h"

enum { MOST = 4000, WIDTH = 800, HEIGHT = 500 };
#define DISTANCE 3.0

typedef struct Scene {
    FfpRigid pose; // of the world to the projector
    double fx, fy, x, y, points[3 * MOST], pixels[2 * MOST];
    int n;
} Scene;

static Scene scene;

static void see(int i) {
    double local[3];
    for (int k = 0; k < 3; k++)
        local[k] = ffp_dot(scene.pose.r + 3 * k, scene.points + 3 * i) + scene.pose.t[k];
    scene.pixels[2 * i] = scene.x + scene.fx * local[0] / local[2];
    scene.pixels[2 * i + 1] = scene.y + scene.fy * local[1] / local[2];
}

// A lumpy ball before a projector three radii away; `depth` of its half, 0: a disc.
static void make(int n, double depth) {
    const double turn[3] = {0.4, -0.9, 0.3};
    FfpRng rng = ffp_rng(5, 1);
    scene = (Scene){.fx = 1.21 * WIDTH, .fy = 1.212 * WIDTH, .x = 0.51 * WIDTH, .y = 1.1 * HEIGHT, .n = n};
    ffp_rotation_from_vector(turn, scene.pose.r);
    scene.pose.t[0] = 0.05, scene.pose.t[1] = -0.4, scene.pose.t[2] = DISTANCE;
    for (int i = 0; i < n;) {
        const double x = (double)ffp_rng_range(&rng, -1, 1), y = (double)ffp_rng_range(&rng, -1, 1);
        if (x * x + y * y > 0.9) continue;
        const double bump = 1 + 0.1 * sin(7 * x) * cos(5 * y);
        const double local[3] = {x, y, -depth * sqrt(1 - x * x - y * y) * bump};
        for (int k = 0; k < 3; k++) { // turned towards the projector
            scene.points[3 * i + k] = 0;
            for (int m = 0; m < 3; m++) scene.points[3 * i + k] += scene.pose.r[3 * m + k] * local[m];
        }
        see(i++);
    }
}

static void spoil(double noise, double depth_noise, double wrong) {
    FfpRng rng = ffp_rng(6, 2);
    for (int i = 0; i < scene.n; i++) {
        for (int k = 0; k < 2; k++) scene.pixels[2 * i + k] += noise * (double)ffp_rng_normal(&rng);
        for (int k = 0; k < 3; k++) scene.points[3 * i + k] += depth_noise * (double)ffp_rng_normal(&rng);
        if ((double)ffp_rng_uniform(&rng) >= wrong) continue;
        scene.pixels[2 * i] = (double)ffp_rng_range(&rng, 0, WIDTH);
        scene.pixels[2 * i + 1] = (double)ffp_rng_range(&rng, 0, HEIGHT);
    }
}

typedef struct Errors {
    double turned, moved, focal, x, y; // degrees, shares of the distance, of the focal length, of the width
} Errors;

static Errors errors_of(const FfpResection *r) {
    double between[9], turn[3];
    FfpRigid found, right;
    Errors e;
    ffp_rigid_inverse(&r->pose, &found), ffp_rigid_inverse(&scene.pose, &right);
    ffp_rotation_difference(found.r, right.r, between);
    ffp_rotation_to_vector(between, turn);
    for (int k = 0; k < 3; k++) found.t[k] -= right.t[k];
    e.turned = sqrt(ffp_dot(turn, turn)) * 180 / FFP_PI_DOUBLE;
    e.moved = sqrt(ffp_dot(found.t, found.t)) / DISTANCE;
    e.focal = fabs(r->fx / scene.fx - 1);
    e.x = fabs(r->x - scene.x) / WIDTH, e.y = fabs(r->y - scene.y) / WIDTH;
    printf(
        "turned %.4f degrees, moved %.5f, focal length %.5f, principal point %.5f %.5f; rms %.3f pixels, %d "
        "used; said to be known to %.4f degrees, %.5f, %.5f, %.5f %.5f\n",
        e.turned, e.moved, e.focal, e.x, e.y, r->rms, r->used,
        sqrt(ffp_dot(r->deviation, r->deviation)) * 180 / FFP_PI_DOUBLE,
        sqrt(ffp_dot(r->deviation + FFP_RESECTED_PLACE, r->deviation + FFP_RESECTED_PLACE)) / DISTANCE,
        r->deviation[FFP_RESECTED_FOCAL], r->deviation[FFP_RESECTED_X], r->deviation[FFP_RESECTED_Y]);
    return e;
}

static FfpResection find(void) {
    FfpResection r;
    FfpError err = {0};
    if (!ffp_resect(scene.points, scene.pixels, scene.n, WIDTH, HEIGHT, &r, &err)) fail_msg("%s", err.text);
    return r;
}

static void exact_points_give_the_exact_device(void **state) {
    (void)state;
    make(500, 1);
    const FfpResection r = find();
    const Errors e = errors_of(&r);
    assert_true(e.turned < 0.02 && e.moved < 3e-4 && e.focal < 3e-4 && e.x < 3e-4 && e.y < 3e-4);
    assert_true(r.used == 500 && r.rms < 0.02);
}

static void noise_and_a_fifth_of_wrong_pixels(void **state) {
    (void)state;
    make(MOST, 1);
    spoil(0.5, 0.002, 0.2);
    const FfpResection r = find();
    const Errors e = errors_of(&r);
    assert_true(e.turned < 0.5 && e.moved < 0.005 && e.focal < 0.005 && e.x < 0.005 && e.y < 0.005);
    assert_true(r.used > 0.75 * MOST && r.used < 0.85 * MOST && r.rms < 2);
    // deviations are of the errors' size
    assert_true(r.deviation[FFP_RESECTED_FOCAL] > e.focal / 4 && r.deviation[FFP_RESECTED_FOCAL] < 0.02);
}

// A shallow object tells the focal length badly: it stays near the usual one's, and says so; what is lit
// stays where it is.
static void a_shallow_object(void **state) {
    (void)state;
    make(MOST, 0.08);
    spoil(0.5, 0.005, 0.1);
    const FfpResection r = find();
    const Errors e = errors_of(&r);
    assert_true(r.deviation[FFP_RESECTED_FOCAL] > 0.02 && r.deviation[FFP_RESECTED_FOCAL] < 1);
    assert_true(e.focal < 3 * r.deviation[FFP_RESECTED_FOCAL] && r.rms < 4);
    FfpResection deep;
    make(MOST, 1), spoil(0.5, 0.005, 0.1);
    deep = find();
    assert_true(deep.deviation[FFP_RESECTED_FOCAL] < r.deviation[FFP_RESECTED_FOCAL] / 3);
}

static void refused(const char *why) {
    FfpResection r;
    FfpError err = {0};
    assert_false(ffp_resect(scene.points, scene.pixels, scene.n, WIDTH, HEIGHT, &r, &err));
    print_message("%s\n", err.text);
    assert_non_null(strstr(err.text, why));
}

static void what_cannot_be_solved_is_refused(void **state) {
    (void)state;
    make(40, 1);
    refused("are the least");
    make(500, 0), spoil(0.2, 0, 0);
    refused("one plane");
    make(500, 1), spoil(0, 0, 0.9);
    refused("something moved");
    make(500, 1);
    for (int i = 0; i < scene.n; i++) scene.pixels[2 * i] = WIDTH - scene.pixels[2 * i];
    refused("mirror");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exact_points_give_the_exact_device),
        cmocka_unit_test(noise_and_a_fifth_of_wrong_pixels),
        cmocka_unit_test(a_shallow_object),
        cmocka_unit_test(what_cannot_be_solved_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
