// The shares of training scenes that are seen through a sensor model, and whose material or patterns are
// pictures.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/file.h"
#include "core/image/image.h"
#include "lab/train/train.h"
#include "support.h"
#include "world/synth/picture_folder.h"

static FfpTrainConfig configuration(double share) {
    FfpTrainConfig config = ffp_train_defaults();
    config.resolution = 16, config.views = 2, config.targets = 0, config.lollipops = 1;
    config.pattern_side = 64, config.samples = 1, config.ambient_rays = 1;
    config.sensor_share = share;
    return config;
}

// Mean difference of two openings of a scene, over the white pictures of the first view.
static double difference(double share_a, double share_b, const char *split, int64_t number) {
    const FfpTrainConfig a = configuration(share_a), b = configuration(share_b);
    FfpScene x, y;
    FfpError err = {0};
    if (!ffp_scene_open(&x, &a, NULL, split, number, &err)) fail_msg("%s", err.text);
    if (!ffp_scene_open(&y, &b, NULL, split, number, &err)) fail_msg("%s", err.text);
    const FfpImage *p = &x.capture.views[0].images[x.capture.white];
    const FfpImage *q = &y.capture.views[0].images[y.capture.white];
    double sum = 0;
    for (int i = 0; i < 16 * 16 * 3; i++) sum += fabs((double)p->data[i] - (double)q->data[i]);
    ffp_scene_close(&x);
    ffp_scene_close(&y);
    return sum / (16 * 16 * 3);
}

static void share(void **state) {
    (void)state;
    assert_true(difference(1, 1, "train", 3) == 0);
    assert_true(difference(0, 1, "train", 3) > 1e-5);
    assert_true(difference(0, 1, "train", 3) < 0.05);
    assert_true(difference(0, 1, "validation", 3) == 0);
    int changed = 0;
    for (int64_t number = 0; number < 24; number++) changed += difference(0, 0.5, "train", number) > 0;
    assert_true(changed > 4 && changed < 20);
}

// A scene with the configuration's folders of pictures.
static FfpScene open_with_pictures(const FfpTrainConfig *config, const char *split, int64_t number) {
    FfpScene scene = {0};
    FfpStock stock;
    FfpError err = {0};
    if (!ffp_stock_open(&stock, config->materials, config->patterns, &err) ||
        !ffp_scene_open(&scene, config, &stock, split, number, &err))
        fail_msg("%s", err.text);
    ffp_stock_close(&stock);
    return scene;
}

// True if a training scene is all green, as its true albedo has it.
static bool is_green(const FfpTrainConfig *config, const char *split, int64_t number) {
    FfpScene scene = open_with_pictures(config, split, number);
    const FfpView *view = &scene.capture.views[0];
    int seen = 0, green = 0;
    for (int i = 0; i < 16 * 16; i++) {
        const real *albedo = view->albedo.data + 3 * i;
        if (view->coverage.data[i] < 1) continue;
        seen++;
        green += fabs(albedo[0] - 0.02) < 1e-3 && fabs(albedo[1] - 0.92) < 1e-3;
    }
    ffp_scene_close(&scene);
    assert_true(seen > 10 && (green == 0 || green == seen));
    return green > 0;
}

// A folder with one picture, green.png.
static void make_folder(char *root) {
    FfpError err = {0};
    char file[64];
    assert_non_null(mkdtemp(root));
    snprintf(file, sizeof file, "%s/green.png", root);
    FfpImage image = ffp_image_new(8, 8, 3);
    for (int i = 0; i < 64; i++) image.data[3 * i + 1] = 1;
    assert_true(ffp_image_write_png(&image, file, &err));
    ffp_image_free(&image);
}

static void materials(void **state) {
    (void)state;
    FfpTrainConfig config = configuration(0);
    char root[] = "/tmp/ffp_pictures_XXXXXX";
    make_folder(root);
    snprintf(config.materials, sizeof config.materials, "%s", root);
    assert_false(is_green(&config, "train", 3));
    config.material_share = 1;
    assert_true(is_green(&config, "train", 3));
    assert_false(is_green(&config, "validation", 3));
    config.material_share = 0.5;
    int green = 0;
    for (int64_t number = 0; number < 24; number++) green += is_green(&config, "train", number);
    assert_true(green > 4 && green < 20);
    ffp_remove_tree(root);
}

// True if every pattern after the first lollipop is the green picture, and shown as that; none may be, or
// all.
static bool shows_green(const FfpTrainConfig *config, const char *split, int64_t number) {
    FfpScene scene = open_with_pictures(config, split, number);
    const FfpCapture *capture = &scene.capture;
    int green = 0;
    assert_int_equal(capture->n_patterns, 5);
    assert_string_equal(capture->patterns[2].name, "lollipop_0");
    assert_int_equal(scene.active, 2);
    for (int p = 3; p < 5; p++) {
        const real *seen = capture->views[0].images[p].data, *black = capture->views[0].images[0].data;
        double red = 0, light = 0;
        for (int i = 0; i < 16 * 16; i++) {
            red += fabs((double)seen[3 * i] - (double)black[3 * i]);
            light += fabs((double)seen[3 * i + 1] - (double)black[3 * i + 1]);
        }
        assert_true(light > 0.1);
        assert_true(!strncmp(capture->patterns[p].name, "picture_", 8) == (red < 1e-6));
        green += red < 1e-6;
    }
    ffp_scene_close(&scene);
    assert_true(green == 0 || green == 2);
    return green > 0;
}

static void patterns(void **state) {
    (void)state;
    FfpTrainConfig config = configuration(0);
    char root[] = "/tmp/ffp_pictures_XXXXXX";
    make_folder(root);
    config.lollipops = 3;
    snprintf(config.patterns, sizeof config.patterns, "%s", root);
    assert_false(shows_green(&config, "train", 3));
    config.pattern_share = 1;
    assert_true(shows_green(&config, "train", 3));
    assert_false(shows_green(&config, "validation", 3));
    config.pattern_share = 0.5;
    int green = 0;
    for (int64_t number = 0; number < 24; number++) green += shows_green(&config, "train", number);
    assert_true(green > 4 && green < 20);
    ffp_remove_tree(root);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(share), cmocka_unit_test(materials),
                                       cmocka_unit_test(patterns)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
