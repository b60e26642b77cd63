// The share of training scenes that are seen through a sensor model.
#include <math.h>
#include <string.h>
#include "lab/train/train.h"
#include "support.h"

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
    if (!ffp_scene_open(&x, &a, split, number, &err)) fail_msg("%s", err.text);
    if (!ffp_scene_open(&y, &b, split, number, &err)) fail_msg("%s", err.text);
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

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(share)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
