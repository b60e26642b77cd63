// Losses that are taken late are those that are waited for.
#include <math.h>
#include "core/base/rng.h"
#include "engine/cuda/cuda.h"
#include "engine/loss/loss.h"
#include "engine/loss/metrics.h"
#include "engine/loss/table.h"
#include "support.h"

enum { WIDTH = 21, HEIGHT = 13, PIXELS = WIDTH * HEIGHT, TERMS = 9 };

typedef struct Maps { // on what the thread works on
    FfpImage a, b;
    real *three, *one, *other, *mask;
} Maps;

static real *random_plane(int channels, uint64_t seed) {
    real host[3 * PIXELS];
    FfpRng rng = ffp_rng(seed, 1);
    for (int i = 0; i < channels * PIXELS; i++) host[i] = ffp_rng_range(&rng, 0.2F, 0.9F);
    return ffp_memory_uploaded(host, (size_t)channels * PIXELS, sizeof *host);
}

static Maps maps_new(void) {
    return (Maps){{WIDTH, HEIGHT, 3, random_plane(3, 1)},
                  {WIDTH, HEIGHT, 3, random_plane(3, 2)},
                  random_plane(3, 3),
                  random_plane(1, 4),
                  random_plane(1, 5),
                  random_plane(1, 6)};
}

static void maps_free(Maps *m) {
    real *all[] = {m->a.data, m->b.data, m->three, m->one, m->other, m->mask};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) ffp_memory_free(all[i]);
}

// Every term to a sum of its own.
static void add_all(const Maps *m, double sums[TERMS]) {
    ffp_loss_add(&sums[0], 1, ffp_l1_loss(&m->a, &m->b, 0.7F, NULL));
    ffp_loss_add(&sums[1], 1, ffp_ssim_loss(&m->a, &m->b, 0.3F, NULL));
    ffp_loss_add(&sums[2], 0.25, ffp_psnr(&m->a, &m->b));
    ffp_loss_add(&sums[3], 1, ffp_mask_loss(m->one, m->mask, PIXELS, 0.2F, NULL));
    ffp_loss_add(&sums[4], 1, ffp_depth_loss(m->one, m->other, m->mask, PIXELS, 0.4F, NULL, NULL));
    ffp_loss_add(&sums[5], 1, ffp_distortion_loss(m->one, PIXELS, 0.4F, NULL));
    ffp_loss_add(&sums[6], 1, ffp_normal_smooth_loss(m->three, m->mask, WIDTH, HEIGHT, 0.4F, NULL));
    ffp_loss_add(&sums[7], 1,
                 ffp_roughness_loss(m->one, m->three, m->other, m->mask, WIDTH, HEIGHT, 0.4F, NULL, NULL));
    ffp_loss_add(&sums[8], 1, 0.5); // of no loss function
}

static void check(const double wanted[TERMS], const double got[TERMS], double times) {
    for (int k = 0; k < TERMS; k++) {
        if (fabs(got[k] - times * wanted[k]) <= 1e-6 * times * fabs(wanted[k])) continue;
        fail_msg("term %d: %.9g, not %.9g", k, got[k], times * wanted[k]);
    }
}

static void test_late_values(void **state) {
    (void)state;
    FfpError err = {0};
    const FfpDevice *device = ffp_cuda_device(&err);
    if (!device) skip();
    double here[TERMS] = {0}, at_once[TERMS] = {0}, late[TERMS] = {0};
    Maps m = maps_new();
    ffp_losses_defer();
    add_all(&m, here);
    for (int k = 0; k < TERMS; k++) assert_true(here[k] != 0); // the CPU does not wait
    ffp_losses_collect();
    maps_free(&m);
    ffp_device_use(device);
    m = maps_new();
    add_all(&m, at_once);
    check(here, at_once, 1);
    ffp_losses_defer();
    add_all(&m, late);
    for (int k = 0; k < TERMS - 1; k++) assert_true(late[k] == 0);
    ffp_losses_collect();
    check(here, late, 1);
    double sum = 0;
    ffp_loss_add(&sum, 1, ffp_l1_loss(&m.a, &m.b, 0.7F, NULL)); // they are over
    assert_true(sum > 0);
    maps_free(&m);
    ffp_device_use(NULL);
}

// More than are kept, in pairs inside each other.
static void test_many(void **state) {
    (void)state;
    FfpError err = {0};
    const FfpDevice *device = ffp_cuda_device(&err);
    if (!device) skip();
    enum { OUTER = 50, INNER = 100 };
    double once[TERMS] = {0}, late[TERMS] = {0};
    ffp_device_use(device);
    Maps m = maps_new();
    add_all(&m, once);
    ffp_losses_defer();
    for (int i = 0; i < OUTER; i++) add_all(&m, late);
    ffp_losses_defer();
    for (int i = 0; i < INNER; i++) add_all(&m, late);
    ffp_losses_collect();
    check(once, late, OUTER + INNER);
    add_all(&m, late);
    ffp_losses_collect();
    check(once, late, OUTER + INNER + 1);
    maps_free(&m);
    ffp_device_use(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_late_values), cmocka_unit_test(test_many)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
