// Generated scenes: the same bits on any number of threads, the rig, the light, and the way to disk and back.
#include <jansson.h>
#include <math.h>
#include <omp.h>
#include "core/base/file.h"
#include "core/image/lookup.h"
#include "scratch.h"
#include "world/shapes/mesh.h"
#include "world/synth/dataset.h"
#include "world/synth/natural.h"
#include "world/synth/scene.h"

static FfpSceneSpec small_spec(int mesh, int material) {
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.mesh = mesh, spec.material = material, spec.seed = 11;
    spec.resolution = 48, spec.views = 2, spec.targets = 1, spec.lollipops = 1, spec.pattern_side = 200;
    return spec;
}

static bool same_image(const FfpImage *a, const FfpImage *b) {
    return a->width == b->width && a->height == b->height && a->channels == b->channels &&
           !memcmp(a->data, b->data,
                   (size_t)a->width * (size_t)a->height * (size_t)a->channels * sizeof(real));
}

static void threads_do_not_change_a_bit(void **state) {
    (void)state;
    const int threads = omp_get_max_threads();
    FfpSceneSpec spec = small_spec(5, 14);
    spec.jitter = true;
    FfpCapture a, b;
    FfpError err;
    omp_set_num_threads(1);
    assert_true(ffp_scene_make(&a, &spec, &err));
    omp_set_num_threads(2);
    assert_true(ffp_scene_make(&b, &spec, &err));
    omp_set_num_threads(threads);
    assert_int_equal(a.n_views, 3);
    for (int v = 0; v < a.n_views; v++) {
        const FfpView *x = &a.views[v], *y = &b.views[v];
        assert_string_equal(x->id, y->id);
        assert_memory_equal(x->camera.pose, y->camera.pose, sizeof x->camera.pose);
        for (int p = 0; p < a.n_patterns; p++) assert_true(same_image(&x->images[p], &y->images[p]));
        assert_true(same_image(&x->coverage, &y->coverage));
        assert_true(same_image(&x->depth, &y->depth));
        assert_true(same_image(&x->normal, &y->normal));
        assert_true(same_image(&x->albedo, &y->albedo));
        assert_true(same_image(&x->roughness, &y->roughness));
        assert_true(same_image(&x->direct_white, &y->direct_white));
    }
    ffp_capture_free(&a);
    ffp_capture_free(&b);
}

static void another_seed_is_another_picture(void **state) {
    (void)state;
    FfpSceneSpec spec = small_spec(7, 3);
    FfpCapture a, b;
    FfpError err;
    assert_true(ffp_scene_make(&a, &spec, &err));
    spec.seed++;
    assert_true(ffp_scene_make(&b, &spec, &err));
    assert_false(same_image(&a.views[0].images[1], &b.views[0].images[1]));
    assert_memory_equal(a.views[0].camera.pose, b.views[0].camera.pose,
                        sizeof a.views[0].camera.pose); // the rig stays
    ffp_capture_free(&a);
    ffp_capture_free(&b);
}

static void the_default_rig_is_the_reference_rig(void **state) {
    (void)state;
    char path[1024];
    if (!shared_path(path, "captures/spot/render_poses.json")) skip();
    FfpSceneSpec spec = small_spec(0, 0);
    spec.resolution = 128, spec.views = 8, spec.targets = 0, spec.lollipops = 0, spec.pattern_side = 800,
    spec.samples = 1;
    FfpCapture made = {0}, read = {0};
    FfpError err;
    assert_true(ffp_capture_read(&read, path, &err));
    assert_true(ffp_scene_make(&made, &spec, &err));
    for (int v = 0; v < 8; v++) {
        assert_string_equal(made.views[v].id, read.views[v].id);
        const FfpCamera *pairs[2][2] = {{&made.views[v].camera, &read.views[v].camera},
                                        {&made.views[v].projector, &read.views[v].projector}};
        for (int d = 0; d < 2; d++) {
            assert_float_equal(pairs[d][0]->fx, pairs[d][1]->fx, 1e-2);
            assert_float_equal(pairs[d][0]->cx, pairs[d][1]->cx, 1e-4);
            for (int i = 0; i < 16; i++) assert_float_equal(pairs[d][0]->pose[i], pairs[d][1]->pose[i], 1e-5);
        }
    }
    ffp_capture_free(&made);
    ffp_capture_free(&read);
}

static void jitter_moves_rig_and_light(void **state) {
    (void)state;
    FfpSceneSpec spec = small_spec(0, 0);
    spec.jitter = true;
    FfpCapture a;
    FfpError err;
    double low = 1e9, high = 0;
    for (spec.seed = 0; spec.seed < 8; spec.seed++) {
        assert_true(ffp_scene_make(&a, &spec, &err));
        low = fmin(low, (double)a.intensity[0]), high = fmax(high, (double)a.intensity[0]);
        for (int v = 0; v < a.n_views; v++) {
            const real *p = a.views[v].camera.pose, *q = a.views[v].projector.pose;
            const double c = hypot(hypot(p[3], p[7]), p[11]), d = hypot(hypot(q[3], q[7]), q[11]);
            assert_true(c > 2.84 && c < 3.26);
            assert_true(d > 1.79 && d < 2.31);
        }
        ffp_capture_free(&a);
    }
    assert_true(low >= 7.96 * 0.6 - 1e-4 && high <= 7.96 * 1.5 + 1e-4 && high > 1.1 * low);
}

static void assert_same_view(const FfpView *x, const FfpView *y, int patterns) {
    assert_string_equal(x->id, y->id);
    assert_memory_equal(&x->camera, &y->camera, sizeof x->camera);
    assert_memory_equal(&x->projector, &y->projector, sizeof x->projector);
    for (int p = 0; p < patterns; p++) assert_true(same_image(&x->images[p], &y->images[p]));
    assert_true(same_image(&x->depth, &y->depth));
    assert_true(same_image(&x->albedo, &y->albedo));
}

// The common subject of figures over the number of views: object, material, light, patterns and targets are
// the same to the bit, noise and pose errors included.
static void rig_and_number_of_views_leave_the_scene(void **state) {
    (void)state;
    static const int counts[] = {1, 2, 3, 4, 6, 8, 12, 16, 32};
    FfpSceneSpec spec = small_spec(17, 5);
    spec.jitter = true, spec.resolution = 16, spec.targets = 2, spec.samples = 1, spec.ambient_rays = 1;
    spec.sensor.read = 0.01F, spec.sensor.turn_error = 0.003F;
    FfpCapture usual, other;
    FfpError err;
    assert_true(ffp_scene_make(&usual, &spec, &err));
    for (size_t i = 0; i < 2 * sizeof counts / sizeof *counts; i++) {
        spec.views = counts[i / 2];
        spec.rig = i % 2 ? FFP_SCENE_FREE : FFP_SCENE_TURNTABLE;
        assert_true(ffp_scene_make(&other, &spec, &err));
        assert_int_equal(other.n_views, spec.views + 2);
        assert_string_equal(usual.name, other.name);
        assert_memory_equal(usual.intensity, other.intensity, sizeof usual.intensity);
        for (int p = 0; p < usual.n_patterns; p++)
            assert_true(same_image(&usual.patterns[p].image, &other.patterns[p].image));
        for (int t = 0; t < 2; t++)
            assert_same_view(&usual.views[2 + t], &other.views[spec.views + t], usual.n_patterns);
        for (int v = 0; v < other.n_views; v++)
            for (int w = 0; w < v; w++) assert_string_not_equal(other.views[v].id, other.views[w].id);
        ffp_capture_free(&other);
    }
    ffp_capture_free(&usual);
}

static void light_only_adds(void **state) {
    (void)state;
    FfpSceneSpec spec = small_spec(21, 9);
    FfpCapture a;
    FfpError err;
    assert_true(ffp_scene_make(&a, &spec, &err));
    assert_int_equal(a.n_patterns, 3);
    assert_string_equal(a.patterns[0].name, "all_black");
    assert_string_equal(a.patterns[1].name, "all_white");
    assert_string_equal(a.patterns[2].name, "lollipop_0");
    for (int v = 0; v < a.n_views; v++) {
        const FfpView *view = &a.views[v];
        int seen = 0, lit = 0, missed = 0;
        for (int i = 0; i < 48 * 48; i++) {
            const double cover = (double)view->coverage.data[i];
            seen += cover > 0;
            lit += view->direct_white.data[3 * i] > 0;
            assert_true(cover >= 0 && cover <= 1);
            missed += cover == 1 && view->depth.data[i] == 0; // samples hit, the ray of the centre does not
            if (view->depth.data[i] > 0) assert_true(view->depth.data[i] > 1.8 && view->depth.data[i] < 4.3);
            if (cover == 0) assert_true(view->depth.data[i] == 0);
            for (int c = 0; c < 3; c++) {
                const real black = view->images[0].data[3 * i + c], white = view->images[1].data[3 * i + c];
                assert_true(black <= white && view->images[2].data[3 * i + c] <= white + 1e-6F);
                if (cover == 0) assert_true(white == 0);
            }
        }
        assert_true(seen > 100 && lit > seen / 4 && lit < seen && missed < seen / 100);
    }
    ffp_capture_free(&a);
}

// pixel = black + (white - black) * pattern at the projection of the true depth, as tools of the reference
// captures do it: it holds for any material, so it checks poses, depth, pattern lookup and the order of
// colours at once.
static double predicted_psnr(const FfpCapture *a, const FfpView *view, const FfpSummed *pattern, int p) {
    double square = 0;
    const int side = view->camera.width;
    for (int y = 0; y < side; y++)
        for (int x = 0; x < side; x++) {
            const int i = y * side + x;
            real d[3], point[3], u, v, colour[3] = {0, 0, 0};
            const real z = view->depth.data[i],
                       slope = ffp_pixel_ray(&view->camera, (real)x + 0.5F, (real)y + 0.5F, d);
            for (int k = 0; k < 3; k++) point[k] = view->camera.pose[4 * k + 3] + z / slope * d[k];
            const real extent = 9 * (real)view->projector.width / 800;
            if (z > 0 && ffp_project(&view->projector, point, &u, &v) > 0)
                ffp_lookup(pattern, u, v, extent, extent, colour);
            for (int c = 0; c < 3; c++) {
                const real black = view->images[0].data[3 * i + c], white = view->images[1].data[3 * i + c];
                const real guess = ffp_srgb_encode(black + (white - black) * colour[c]);
                const double error = (double)(guess - ffp_srgb_encode(view->images[p].data[3 * i + c]));
                square += error * error;
            }
        }
    (void)a;
    return -10 * log10(square / (3.0 * side * side));
}

static void the_true_depth_predictor_holds(void **state) {
    (void)state;
    FfpSceneSpec spec = small_spec(1, 14);
    spec.resolution = 128, spec.pattern_side = 800, spec.samples = 16;
    FfpCapture a;
    FfpError err;
    assert_true(ffp_scene_make(&a, &spec, &err));
    FfpSummed pattern = ffp_summed_new(&a.patterns[2].image);
    for (int v = 0; v < a.n_views; v++) {
        const double psnr = predicted_psnr(&a, &a.views[v], &pattern, 2);
        print_message("%s: %.2f dB\n", a.views[v].id, psnr);
        assert_true(psnr > 38);
    }
    ffp_summed_free(&pattern);
    ffp_capture_free(&a);
}

// Files keep what a scene in memory holds: colours to the bit of their 8-bit form.
static void disk_and_memory_agree(void **state) {
    (void)state;
    const char *root = in_scratch("scenes");
    const FfpDatasetSettings options = {.folder = root,
                                        .split = "test",
                                        .preset = FFP_DATASET_SMOKE,
                                        .first = 4,
                                        .count = 1,
                                        .resolution = 32};
    FfpError err;
    if (!ffp_dataset_write(&options, &err)) fail_msg("%s", err.text);
    FfpCapture read, targets;
    if (!ffp_capture_read(&read, in_scratch("scenes/test_00004"), &err)) fail_msg("%s", err.text);
    assert_int_equal(read.n_views, 8);
    assert_int_equal(read.n_patterns, 4 + FFP_NATURAL_KINDS);
    for (int p = 0; p < read.n_patterns; p++) assert_int_equal(read.patterns[p].novel, p >= 4);
    assert_int_equal(ffp_capture_active_pattern(&read, NULL, &err), 2);
    assert_true(read.intensity_known);
    assert_float_equal(read.radius, 0.95, 1e-6);
    if (!ffp_capture_read_targets(&targets, in_scratch("scenes/test_00004/targets/scene.json"), &read, &err))
        fail_msg("%s", err.text);
    assert_int_equal(targets.n_views, 2);
    assert_int_equal(targets.n_patterns, read.n_patterns);
    assert_true(ffp_dataset_write(&options, &err)); // a second run finds it done
    const FfpDatasetSettings wrong[4] = {{.folder = root, .split = "tests", .count = 1},
                                         {.folder = root, .views = 361, .count = 1},
                                         {.folder = root, .first = 1000000, .count = 1},
                                         {.folder = NULL, .count = 1}};
    for (int i = 0; i < 4; i++) assert_false(ffp_dataset_write(&wrong[i], &err));
    ffp_capture_free(&targets);
    ffp_capture_free(&read);
}

static void written_colours_come_back_exactly(void **state) {
    (void)state;
    const char *root = in_scratch("written");
    FfpSceneSpec spec = small_spec(2, 8);
    spec.targets = 0;
    FfpCapture made = {0}, read = {0};
    FfpError err;
    assert_true(ffp_scene_make(&made, &spec, &err));
    if (!ffp_capture_write(&made, root, &err) || !ffp_capture_read(&read, root, &err))
        fail_msg("%s", err.text);
    assert_int_equal(read.n_views, made.n_views);
    for (int v = 0; v < made.n_views && v < read.n_views; v++)
        for (int i = 0; i < 48 * 48; i++) {
            assert_float_equal(made.views[v].coverage.data[i], read.views[v].coverage.data[i], 1e-6);
            assert_float_equal(made.views[v].depth.data[i], read.views[v].depth.data[i], 1e-6);
            for (int p = 0; p < 3; p++)
                for (int c = 0; c < 3; c++)
                    assert_float_equal(made.views[v].images[p].data[3 * i + c],
                                       read.views[v].images[p].data[3 * i + c], 1e-5);
        }
    ffp_capture_free(&made);
    ffp_capture_free(&read);
}

// Only the test split has natural patterns: training and validation must not see one.
static void other_splits_have_lollipops_alone(void **state) {
    (void)state;
    const FfpDatasetSettings options = {.folder = in_scratch("training"),
                                        .split = "train",
                                        .preset = FFP_DATASET_SMOKE,
                                        .count = 1,
                                        .resolution = 8};
    FfpError err;
    if (!ffp_dataset_write(&options, &err)) fail_msg("%s", err.text);
    FfpCapture read;
    if (!ffp_capture_read(&read, in_scratch("training/train_00000"), &err)) fail_msg("%s", err.text);
    assert_int_equal(read.n_patterns, 4);
    assert_int_equal(ffp_scene_defaults().naturals, 0);
    ffp_capture_free(&read);
}

static void write_set(const FfpDatasetSettings *options) {
    FfpError err;
    if (!ffp_dataset_write(options, &err)) fail_msg("%s", err.text);
}

// The text of a member of a scene file's `generator`, numbers in digits; "" where there is none.
static const char *generator(const char *file, const char *member) {
    static char text[80];
    json_t *root = json_load_file(in_scratch(file), 0, NULL);
    const json_t *value = json_object_get(json_object_get(root, "generator"), member);
    snprintf(text, sizeof text, "%s", json_is_string(value) ? json_string_value(value) : "");
    if (json_is_integer(value)) snprintf(text, sizeof text, "%lld", (long long)json_integer_value(value));
    json_decref(root);
    return text;
}

// Whoever finds a scene knows what it shows, and how to make it again; training objects have new poses, too.
static void files_say_what_they_show(void **state) {
    (void)state;
    const FfpDatasetSettings options = {.folder = in_scratch("told"),
                                        .split = "train",
                                        .preset = FFP_DATASET_PAPER,
                                        .first = 7,
                                        .count = 1,
                                        .seed = 5,
                                        .resolution = 8};
    write_set(&options);
    FfpSceneSpec spec;
    ffp_dataset_scene("train", 7, 5, &spec);
    static const char *const files[2] = {"told/train_00007/scene.json",
                                         "told/train_00007/targets/scene.json"};
    for (int i = 0; i < 2; i++) {
        assert_string_equal(generator(files[i], "version"), FFP_VERSION);
        assert_string_equal(generator(files[i], "split"), "train");
        assert_string_equal(generator(files[i], "number"), "7");
        assert_string_equal(generator(files[i], "seed"), "5");
        assert_string_equal(generator(files[i], "mesh"), ffp_mesh_name(spec.mesh));
        assert_string_equal(generator(files[i], "material"), ffp_material_name(spec.material));
    }
    FfpCapture read, targets;
    FfpError err;
    if (!ffp_capture_read(&read, in_scratch("told/train_00007"), &err) ||
        !ffp_capture_read_targets(&targets, in_scratch(files[1]), &read, &err))
        fail_msg("%s", err.text);
    assert_int_equal(targets.n_views, 6);
    ffp_capture_free(&targets);
    ffp_capture_free(&read);
}

static void files_name_what_the_user_gave(void **state) {
    (void)state;
    static const char mesh[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    FfpError err;
    FfpImage grey = ffp_image_new(4, 4, 3);
    char file[FFP_PATH_MAX], rock[FFP_PATH_MAX];
    snprintf(file, sizeof file, "%s", in_scratch("four-sided.obj"));
    snprintf(rock, sizeof rock, "%s", in_scratch("red rock"));
    assert_true(ffp_write_file(file, mesh, strlen(mesh), &err) && ffp_make_folders(rock, &err) &&
                ffp_image_write_png(&grey, in_scratch("red rock/basecolor.png"), &err));
    FfpDatasetSettings options = {.folder = in_scratch("given"),
                                  .preset = FFP_DATASET_SMOKE,
                                  .count = 1,
                                  .mesh = file,
                                  .material = rock,
                                  .resolution = 8};
    write_set(&options);
    assert_string_equal(generator("given/four-sided_00000/scene.json", "mesh"), "four-sided");
    assert_string_equal(generator("given/four-sided_00000/scene.json", "material"), "red_rock");
    assert_string_equal(generator("given/four-sided_00000/scene.json", "split"), "");
    options.folder = in_scratch("any"), options.mesh = options.material = NULL;
    write_set(&options);
    assert_string_equal(generator("any/all_00000/scene.json", "split"), "all");
    ffp_image_free(&grey);
}

static void bad_specs_are_refused(void **state) {
    (void)state;
    FfpError err;
    FfpCapture capture;
    FfpSceneSpec spec = small_spec(-1, 0);
    assert_false(ffp_scene_make(&capture, &spec, &err));
    spec = small_spec(0, ffp_material_count());
    assert_false(ffp_scene_make(&capture, &spec, &err));
    spec = small_spec(0, 0), spec.resolution = 1 << 20;
    assert_false(ffp_scene_make(&capture, &spec, &err));
    spec = small_spec(0, 0), spec.samples = 0;
    assert_false(ffp_scene_make(&capture, &spec, &err));
    spec = small_spec(0, 0), spec.naturals = -1;
    assert_false(ffp_scene_make(&capture, &spec, &err));
    spec = small_spec(0, 0), spec.sensor.shot = NAN;
    assert_false(ffp_scene_make(&capture, &spec, &err));
    spec = small_spec(0, 0), spec.sensor.defocus = 1e9F;
    assert_false(ffp_scene_make(&capture, &spec, &err));
    assert_true(strlen(err.text) > 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_do_not_change_a_bit),
        cmocka_unit_test(another_seed_is_another_picture),
        cmocka_unit_test(the_default_rig_is_the_reference_rig),
        cmocka_unit_test(jitter_moves_rig_and_light),
        cmocka_unit_test(rig_and_number_of_views_leave_the_scene),
        cmocka_unit_test(light_only_adds),
        cmocka_unit_test(files_say_what_they_show),
        cmocka_unit_test(files_name_what_the_user_gave),
        cmocka_unit_test(the_true_depth_predictor_holds),
        cmocka_unit_test(disk_and_memory_agree),
        cmocka_unit_test(written_colours_come_back_exactly),
        cmocka_unit_test(other_splits_have_lollipops_alone),
        cmocka_unit_test(bad_specs_are_refused),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
