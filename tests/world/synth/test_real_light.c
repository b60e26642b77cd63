// Real light: spread, glare, response, vignetting and focus against their formulas, and what a seed draws.
#include <jansson.h>
#include <math.h>
#include <unistd.h>
#include "core/base/file.h"
#include "core/patterns/patterns.h"
#include "support.h"
#include "world/shapes/solids.h"
#include "world/synth/photographs.h"
#include "world/synth/room.h"
#include "world/synth/sensor.h"
#include "world/synth/simulate.h"

enum { WIDTH = 400, HEIGHT = 24 };

static FfpImage even(int width, int height, float value) {
    FfpImage image = ffp_image_new(width, height, 3);
    for (int i = 0; i < width * height * 3; i++) image.data[i] = value;
    return image;
}

// Stripes of so many pixels, the first dark.
static FfpImage stripes(int width, int height, int wide) {
    FfpImage image = ffp_image_new(width, height, 3);
    for (int i = 0; i < width * height * 3; i++) image.data[i] = (real)(i / 3 % width / wide % 2);
    return image;
}

// --- The projector's spread and response. ---

static void spread_keeps_white_white(void **state) {
    (void)state;
    const FfpSensor sensor = {.spread = {0.08F, 0.02F, 0}, .spread_reach = 40};
    FfpImage white = even(WIDTH, HEIGHT, 1), sent = ffp_sensor_emit(&white, &sensor);
    assert_true(ffp_sensor_changes_light(&sensor));
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++) assert_float_equal(sent.data[i], 1, 1e-6);
    ffp_image_free(&white), ffp_image_free(&sent);
}

static void dark_stripes_get_more_the_finer_they_are(void **state) {
    (void)state;
    const FfpSensor sensor = {.spread = {0.06F, 0.03F, 0}, .spread_reach = 12}; // 6 pixels of this panel
    double before = -1;
    for (int wide = 100; wide >= 4; wide /= 5) {
        FfpImage plain = stripes(WIDTH, HEIGHT, wide), sent = ffp_sensor_emit(&plain, &sensor);
        const real *dark = sent.data + 3 * (HEIGHT / 2 * WIDTH + WIDTH / 2 + wide / 2);
        assert_float_equal(dark[1], dark[0] / 2, 1e-6);
        assert_true(dark[2] == 0 && (double)dark[0] > before);
        before = (double)dark[0];
        FfpImage wider = ffp_image_copy(&plain); // the formula
        ffp_image_blur(&wider, 6);
        for (int i = 0; i < WIDTH * HEIGHT * 3; i += 3)
            assert_float_equal(sent.data[i], 0.94F * plain.data[i] + 0.06F * wider.data[i], 1e-6);
        ffp_image_free(&plain), ffp_image_free(&sent), ffp_image_free(&wider);
    }
    assert_float_equal(before, 0.03, 1e-3); // half the picture is lit
}

static void values_are_sent_as_their_power(void **state) {
    (void)state;
    const FfpSensor sensor = {.power = 1.61F, .black_level = 0.05F};
    for (int i = 0; i <= 10; i++) {
        const float value = (float)i / 10; // of the file
        FfpImage grey = even(2, 2, (float)ffp_srgb_decode((real)value)),
                 sent = ffp_sensor_emit(&grey, &sensor);
        assert_float_equal(sent.data[0], 0.05F + 0.95F * powf(value, 1.61F), 1e-5);
        ffp_image_free(&grey), ffp_image_free(&sent);
    }
}

// --- The camera's lens. ---

static void glare_is_a_wide_gaussian(void **state) {
    (void)state;
    const FfpSensor sensor = {.glare = 0.03F, .glare_reach = 0.1F};
    const FfpCamera camera = {.width = WIDTH, .height = 3 * WIDTH / 4};
    FfpImage plain = stripes(WIDTH, camera.height, WIDTH / 2), wide = ffp_image_copy(&plain),
             seen = ffp_image_copy(&plain);
    ffp_sensor_see(&seen, &sensor, &camera);
    ffp_image_blur(&wide, 40);
    for (int i = 0; i < WIDTH * camera.height * 3; i++)
        assert_float_equal(seen.data[i], 0.97F * plain.data[i] + 0.03F * wide.data[i], 2e-4);
    assert_true(seen.data[3 * (WIDTH / 2 - 1)] > 0.014F && seen.data[0] < 1e-4F);
    ffp_image_free(&plain), ffp_image_free(&wide), ffp_image_free(&seen);
}

static void vignetting_falls_from_the_principal_point(void **state) {
    (void)state;
    const FfpSensor sensor = {.vignetting = 0.3F};
    const FfpCamera camera = {.width = 80, .height = 60, .cx = 30.5F, .cy = 30.5F};
    FfpImage seen = even(80, 60, 0.5F);
    assert_true(ffp_sensor_has_lens(&sensor));
    ffp_sensor_see(&seen, &sensor, &camera);
    assert_float_equal(seen.data[3 * (30 * 80 + 30)], 0.5, 1e-6);
    assert_float_equal(seen.data[3 * (30 * 80 + 70)], 0.5 * (1 - 0.3 * 1600 / 2500), 1e-6); // 40 of 50
    assert_float_equal(seen.data[3 * (0 * 80 + 70)], 0.5 * (1 - 0.3), 1e-6);                // 40, 30
    ffp_image_free(&seen);
}

// --- The projector's light on a wall. ---

// A device on the x axis, 4 before the origin, that looks at it.
static FfpCamera device(int height) {
    FfpCamera c = {.width = WIDTH,
                   .height = height,
                   .fx = WIDTH,
                   .fy = WIDTH,
                   .cx = WIDTH / 2.0F,
                   .cy = (real)height / 2};
    const real pose[16] = {0, 0, -1, 4, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 1};
    memcpy(c.pose, pose, sizeof pose);
    return c;
}

// A pattern on a wall that is `before` the origin, from where it is projected.
static FfpImage on_wall(const FfpImage *pattern, float before, const FfpSensor *sensor, int height) {
    FfpRoom room = {.n_parts = 1};
    room.parts[0] = (FfpRoomPart){.mesh = ffp_solid_box((float[3]){before - 1, 0, 0}, (float[3]){1, 8, 8}, 0),
                                  .plain = true,
                                  .albedo = {0.5F, 0.5F, 0.5F},
                                  .roughness = 0.9F};
    FfpSurroundings around = ffp_around_new(&room, NULL, 0);
    FfpLight light = ffp_light_new(&pattern, 1);
    if (sensor->focus_blur > 0) ffp_light_soften(&light);
    FfpError err = {0};
    FfpTracer *tracer = ffp_tracer_new(&around.mesh, &err);
    if (!tracer) fail_msg("%s", err.text);
    const FfpSimulation simulation = {.tracer = tracer,
                                      .mesh = &around.mesh,
                                      .around = &around,
                                      .light = &light,
                                      .intensity = {50, 50, 50},
                                      .samples = 8,
                                      .sensor = sensor,
                                      .photograph = true,
                                      .light_only = true};
    FfpView view = {.camera = device(height), .projector = device(pattern->height)};
    ffp_simulate_view(&simulation, &view, 0, NULL);
    FfpImage seen = ffp_image_copy(&view.images[0]);
    ffp_view_free(&view, 1);
    ffp_tracer_free(tracer);
    ffp_light_free(&light);
    ffp_around_free(&around);
    ffp_room_free(&room);
    return seen;
}

static void the_throw_falls_towards_its_corners(void **state) {
    (void)state;
    const FfpSensor ideal = {0}, falls = {.throw_fall = 0.25F};
    FfpImage white = even(WIDTH, HEIGHT, 1), plain = on_wall(&white, 0, &ideal, HEIGHT),
             seen = on_wall(&white, 0, &falls, HEIGHT);
    for (int x = 0; x < WIDTH; x += 7) {
        const int at = 3 * (HEIGHT / 2 * WIDTH + x);
        const double r = (x + 0.5 - WIDTH / 2) / (0.5 * hypot(WIDTH, HEIGHT));
        assert_float_equal(seen.data[at] / plain.data[at], 1 - 0.25 * r * r, 1e-3);
    }
    ffp_image_free(&white), ffp_image_free(&plain), ffp_image_free(&seen);
}

// The deviation of an edge's slope.
static double softness_of_edge(float before, const FfpSensor *sensor) {
    FfpImage white = even(WIDTH, HEIGHT, 1), edge = stripes(WIDTH, HEIGHT, WIDTH / 2),
             lit = on_wall(&white, before, sensor, 4), seen = on_wall(&edge, before, sensor, 4);
    double total = 0, square = 0;
    for (int x = WIDTH / 2 - 60; x < WIDTH / 2 + 60; x++) {
        const real *a = seen.data + 3 * (2 * WIDTH + x), *w = lit.data + 3 * (2 * WIDTH + x);
        const double slope = (double)(a[3] / w[3] - a[0] / w[0]), away = x + 1 - WIDTH / 2;
        total += slope, square += slope * away * away;
    }
    ffp_image_free(&white), ffp_image_free(&edge), ffp_image_free(&lit), ffp_image_free(&seen);
    assert_float_equal(total, 1, 0.01);
    return sqrt(square);
}

static void blur_grows_away_from_the_focal_plane(void **state) {
    (void)state;
    const FfpSensor sensor = {.focus_blur = 6, .focus_at = 1}; // 3 pixels of this panel a unit
    const double sharp = softness_of_edge(0, &sensor), nearer = softness_of_edge(1, &sensor),
                 farther = softness_of_edge(-1, &sensor), far = softness_of_edge(-2, &sensor);
    print_message("edges: %.2f on the plane, %.2f nearer, %.2f and %.2f farther\n", sharp, nearer, farther,
                  far);
    assert_true(sharp < 0.7);
    assert_float_equal(nearer, hypot(sharp, 3.0 * (16 / 3.0 - 4)), 0.15);
    assert_float_equal(farther, hypot(sharp, 3 * (4 - 16 / 5.0)), 0.15);
    assert_float_equal(far, hypot(sharp, 3 * (4 - 16 / 6.0)), 0.15);
    const FfpSensor behind = {.focus_blur = 6, .focus_at = 1.25F};
    assert_true(softness_of_edge(-1, &behind) < 0.7);
}

// --- What a seed draws. ---

static void check_ranges(const FfpSensor *s) {
    for (int c = 0; c < 3; c++) assert_true(s->spread[c] >= 0 && s->spread[c] <= 0.08F);
    assert_true(s->spread_reach >= 4 && s->spread_reach <= 30);
    assert_true(s->glare >= 0 && s->glare <= 0.03F);
    assert_true(s->glare_reach >= 0.05F && s->glare_reach <= 0.3F);
    assert_true(s->power >= 1.5F && s->power <= 2.4F && s->black_level >= 0 && s->black_level <= 0.05F);
    assert_true(s->vignetting >= 0 && s->vignetting <= 0.3F && s->throw_fall >= 0 && s->throw_fall <= 0.3F);
    assert_true(s->focus_blur >= 0 && s->focus_blur <= 2 && s->focus_at >= 0.93F && s->focus_at <= 1.07F);
}

static void a_seed_is_a_rig(void **state) {
    (void)state;
    FfpError err = {0};
    FfpSensor off = {.read = 0.01F, .gamma = 0.1F}, same = off;
    ffp_sensor_settle(&off, 3);
    assert_memory_equal(&off, &same, sizeof off);
    assert_null(ffp_sensor_truth(&off));
    for (uint64_t seed = 0; seed < 200; seed++) {
        FfpSensor one = {.real_light = 1}, again = one, half = {.real_light = 0.5F},
                  given = {.real_light = 1, .glare = 0.2F, .gamma = 0.1F, .spread = {0, 0.3F, 0}};
        ffp_sensor_settle(&one, seed), ffp_sensor_settle(&again, seed);
        ffp_sensor_settle(&half, seed), ffp_sensor_settle(&given, seed);
        assert_memory_equal(&one, &again, sizeof one);
        check_ranges(&one);
        assert_true(ffp_sensor_check(&one, &err) && ffp_sensor_check(&given, &err));
        assert_float_equal(half.spread[1], one.spread[1] / 2, 1e-6);
        assert_true(half.power == one.power && half.spread_reach == one.spread_reach);
        assert_true(given.glare == 0.2F && given.power == 0 && given.spread[0] == 0);
        assert_true(given.throw_fall == one.throw_fall);
        FfpSensor other = {.real_light = 1};
        ffp_sensor_settle(&other, seed + 1);
        assert_true(other.spread[0] != one.spread[0] && other.power != one.power);
    }
    const FfpSensor wrong[] = {{.spread = {0, 0.6F, 0}}, {.power = 2, .gamma = 0.1F}, {.glare = NAN},
                               {.real_light = 2},        {.focus_blur = -1},          {.vignetting = 1}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) assert_false(ffp_sensor_check(&wrong[i], &err));
}

static FfpSceneSpec small_spec(void) {
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.mesh = 2, spec.material = 4, spec.seed = 5, spec.resolution = 40, spec.views = 1, spec.targets = 0;
    spec.lollipops = 1, spec.pattern_side = 160, spec.samples = 2;
    return spec;
}

static void scenes_have_the_light_of_their_seed(void **state) {
    (void)state;
    FfpError err = {0};
    FfpSceneSpec spec = small_spec();
    FfpCapture plain, real_one, again;
    assert_true(ffp_scene_make(&plain, &spec, &err));
    spec.sensor.real_light = 1;
    assert_true(ffp_scene_make(&real_one, &spec, &err) && ffp_scene_make(&again, &spec, &err));
    double darker = 0, whites = 0, blacks = 0;
    for (int p = 0; p < 3; p++)
        assert_memory_equal(real_one.views[0].images[p].data, again.views[0].images[p].data,
                            40 * 40 * 3 * sizeof(real));
    for (int i = 0; i < 40 * 40 * 3; i++) {
        darker += (double)(plain.views[0].images[1].data[i] - real_one.views[0].images[1].data[i]);
        whites += (double)(plain.views[0].images[1].data[i] - plain.views[0].images[0].data[i]);
        blacks += (double)(real_one.views[0].images[0].data[i] - plain.views[0].images[0].data[i]);
    }
    FfpSensor drawn = {.real_light = 1};
    ffp_sensor_settle(&drawn, 5);
    print_message("white loses %.3f to vignetting, black gains %.4f of white, %.4f drawn\n", darker / whites,
                  blacks / whites, (double)drawn.black_level);
    assert_true(darker / whites > 0 && darker / whites < 0.3);
    assert_float_equal(blacks / whites, drawn.black_level, 0.3 * (double)drawn.black_level);
    ffp_capture_free(&plain), ffp_capture_free(&real_one), ffp_capture_free(&again);
}

// An object's pictures pass the lens: under white what vignetting leaves, within the rounding to 8 bits.
static void scenes_are_seen_through_the_lens(void **state) {
    (void)state;
    FfpError err = {0};
    FfpSceneSpec spec = small_spec();
    FfpCapture plain, seen;
    assert_true(ffp_scene_make(&plain, &spec, &err));
    spec.sensor.vignetting = 0.6F;
    assert_true(ffp_scene_make(&seen, &spec, &err));
    const FfpView *a = &plain.views[0], *b = &seen.views[0];
    double off = 0, dark = 0;
    int pixels = 0;
    for (int i = 0; i < 40 * 40; i++) {
        const double was = (double)a->images[1].data[3 * i];
        const double left =
            (double)ffp_sensor_vignette(0.6F, &a->camera, (float)(i % 40) + 0.5F, (float)(i / 40) + 0.5F);
        if (a->coverage.data[i] < 1 || was < 0.1 || was > 0.9) continue;
        off += fabs((double)b->images[1].data[3 * i] / was - left), dark += 1 - left, pixels++;
    }
    assert_true(pixels > 100 && dark / pixels > 0.05 && off / pixels < 0.01);
    ffp_capture_free(&plain), ffp_capture_free(&seen);
}

// --- Files. ---

static char root[64];

static int make_root(void **state) {
    (void)state;
    snprintf(root, sizeof root, "ffp_real_light_XXXXXX");
    return mkdtemp(root) ? 0 : -1;
}

static int remove_root(void **state) {
    (void)state;
    ffp_remove_tree(root);
    return 0;
}

static void path_of(char path[FFP_PATH_MAX], const char *name) {
    assert_true(ffp_join_path(path, root, name));
}

static void photograph_room(const char *name, const FfpSensor *sensor) {
    FfpError err = {0};
    char patterns[FFP_PATH_MAX], shots[FFP_PATH_MAX];
    path_of(patterns, "patterns"), path_of(shots, name);
    const FfpShow show = {.width = 96, .height = 64, .focus = true, .capture = true};
    assert_true(ffp_make_folders(patterns, &err) && ffp_show_write(&show, patterns, &err));
    FfpSceneSpec spec = small_spec();
    spec.resolution = 64, spec.samples = 1, spec.sensor = *sensor;
    const FfpPhotographs options = {
        .folder = shots, .patterns = patterns, .room = true, .seed = 7, .quality = 90, .only = "view-000"};
    if (!ffp_photographs_write(&options, &spec, &err)) fail_msg("%s", err.text);
}

static double number(const json_t *light, const char *name) {
    const json_t *value = json_object_get(light, name);
    assert_true(json_is_number(value));
    return json_number_value(value);
}

static void photographs_tell_the_truth(void **state) {
    (void)state;
    char path[FFP_PATH_MAX];
    const FfpSensor real_one = {.real_light = 1};
    FfpSensor drawn = real_one;
    photograph_room("real", &real_one);
    path_of(path, "real/truth.json");
    json_t *truth = json_load_file(path, 0, NULL);
    const json_t *light = json_object_get(truth, "light");
    ffp_sensor_settle(&drawn, 7); // the room's seed
    assert_float_equal(number(light, "glare"), drawn.glare, 1e-6);
    assert_float_equal(number(light, "power"), drawn.power, 1e-5);
    assert_float_equal(number(light, "black_level"), drawn.black_level, 1e-6);
    assert_float_equal(number(light, "focus_at"), drawn.focus_at, 1e-5);
    assert_float_equal(json_number_value(json_array_get(json_object_get(light, "spread"), 2)),
                       drawn.spread[2], 1e-6);
    json_decref(truth);
}

static double light_of(const char *name) {
    FfpError err = {0};
    char path[FFP_PATH_MAX];
    FfpImage image = {0};
    path_of(path, name);
    if (!ffp_image_read(&image, path, FFP_COLOUR_LINEAR, &err)) fail_msg("%s", err.text);
    double sum = 0;
    for (int i = 0; i < image.width * image.height; i++) sum += (double)image.data[4 * i];
    ffp_image_free(&image);
    return sum;
}

static void rooms_are_seen_through_the_lens(void **state) {
    (void)state;
    const FfpSensor ideal = {0}, lens = {.vignetting = 0.6F};
    photograph_room("ideal", &ideal), photograph_room("lens", &lens);
    const double left = light_of("lens/truth/view-000/002.png") / light_of("ideal/truth/view-000/002.png");
    assert_true(left > 0.5 && left < 0.97);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spread_keeps_white_white),
        cmocka_unit_test(dark_stripes_get_more_the_finer_they_are),
        cmocka_unit_test(values_are_sent_as_their_power),
        cmocka_unit_test(glare_is_a_wide_gaussian),
        cmocka_unit_test(vignetting_falls_from_the_principal_point),
        cmocka_unit_test(the_throw_falls_towards_its_corners),
        cmocka_unit_test(blur_grows_away_from_the_focal_plane),
        cmocka_unit_test(a_seed_is_a_rig),
        cmocka_unit_test(scenes_have_the_light_of_their_seed),
        cmocka_unit_test(scenes_are_seen_through_the_lens),
        cmocka_unit_test(photographs_tell_the_truth),
        cmocka_unit_test(rooms_are_seen_through_the_lens),
    };
    return cmocka_run_group_tests(tests, make_root, remove_root);
}
