// Adam's step: its length at first, where it leads, what is handed in, and every CPU level against the
// formulas of the papers in double.
#include <math.h>
#include <omp.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/cpu.h"
#include "core/tensor/adam.h"
#include "core/tensor/random.h"
#include "support.h"

enum { COUNT = 1003, STEPS = 5 };

// Numbers that lie apart and fall differently: half the sum of c_i (x_i - a_i)^2.
static void a_quadratic_is_minimised(void **state) {
    (void)state;
    const real least[3] = {2, -1, 0.5F}, curve[3] = {0.01F, 1, 100};
    real x[3] = {0}, mean[3] = {0}, square[3] = {0}, grad[3];
    for (int step = 1; step <= 3000; step++) {
        const double rate = 0.02 * pow(0.998, step - 1);
        for (int i = 0; i < 3; i++) grad[i] = curve[i] * (x[i] - least[i]);
        const FfpAdamArray array = {.step = ffp_adam_step(rate, 0.9, 0.999, 1e-12, step),
                                    .count = 3,
                                    .x = x,
                                    .mean = mean,
                                    .square = square,
                                    .grad = grad};
        ffp_adam(&array, 1);
        // with corrected moments the first step is as long as the rate, whatever the gradient's size
        for (int i = 0; step == 1 && i < 3; i++)
            assert_true(fabs((double)x[i] - copysign(0.02, (double)least[i])) < 1e-6);
    }
    for (int i = 0; i < 3; i++) assert_true(fabs((double)(x[i] - least[i])) < 1e-3);
}

typedef struct Numbers {
    real *x, *mean, *square, *average, *grad, *start;
} Numbers;

static Numbers numbers_new(void) {
    FfpRng rng = ffp_rng(5, 0);
    Numbers n = {.x = random_reals(&rng, COUNT, 1, 0),
                 .mean = ffp_alloc(COUNT, sizeof(real)),
                 .square = ffp_alloc(COUNT, sizeof(real)),
                 .average = random_reals(&rng, COUNT, 1, 0),
                 .grad = random_reals(&rng, STEPS * COUNT, 1, 0),
                 .start = random_reals(&rng, COUNT, 1, 0)};
    for (int i = 0; i < STEPS * COUNT; i += 3) n.grad[i] = 0;
    return n;
}

static void numbers_free(Numbers *n) {
    ffp_free(n->x);
    ffp_free(n->mean);
    ffp_free(n->square);
    ffp_free(n->average);
    ffp_free(n->grad);
    ffp_free(n->start);
}

typedef struct Case {
    const char *name;
    double decay, pull, average, scale; // average 0: none is kept
    bool sparse;
} Case;

static const Case cases[] = {
    {"plain", .scale = 1},
    {"decay", .decay = 0.1, .scale = 1},
    {"pull", .pull = 0.2, .scale = 1},
    {"average", .average = 0.75, .scale = 1},
    {"scale", .scale = 0.125},
    {"sparse", .scale = 1, .sparse = true},
    {"all", .decay = 0.1, .pull = 0.2, .average = 0.75, .scale = 0.125, .sparse = true}};

// Kingma and Ba 2015, algorithm 1; Loshchilov and Hutter 2019, algorithm 2; of number i, in double.
static void expect(const Case *c, const Numbers *n, int i, double *x, double *average) {
    double mean = 0, square = 0;
    *x = (double)n->x[i], *average = (double)n->average[i];
    for (int t = 1; t <= STEPS; t++) {
        const double g = c->scale * (double)n->grad[(t - 1) * COUNT + i];
        if (!c->sparse || g != 0) {
            mean = 0.9 * mean + 0.1 * g, square = 0.99 * square + 0.01 * g * g;
            const double m = mean / (1 - pow(0.9, t)), v = square / (1 - pow(0.99, t));
            *x -= 0.05 * m / (sqrt(v) + 1e-3) + c->decay * *x;
        }
        if (c->pull > 0) *x -= c->pull * (*x - (double)n->start[i]);
        *average = c->average * *average + (1 - c->average) * *x;
    }
}

static void check_case(const Case *c, FfpCpuLevel level) {
    Numbers n = numbers_new(), before = numbers_new();
    for (int t = 1; t <= STEPS; t++) {
        FfpAdamArray halves[2];
        for (int h = 0; h < 2; h++) {
            const int from = h * 500;
            FfpAdamArray *a = &halves[h];
            *a = (FfpAdamArray){.step = ffp_adam_step(0.05, 0.9, 0.99, 1e-3, t),
                                .count = h ? COUNT - 500 : 500,
                                .x = n.x + from,
                                .mean = n.mean + from,
                                .square = n.square + from,
                                .grad = n.grad + (ptrdiff_t)(t - 1) * COUNT + from,
                                .start = c->pull > 0 ? n.start + from : NULL,
                                .average = c->average > 0 ? n.average + from : NULL};
            a->step.decay = (real)c->decay, a->step.pull = (real)c->pull, a->step.scale = (real)c->scale;
            a->step.average = (real)c->average, a->step.sparse = c->sparse;
        }
        ffp_adam(halves, 2);
    }
    for (int i = 0; i < COUNT; i++) {
        double x, average;
        expect(c, &before, i, &x, &average);
        if (!(fabs((double)n.x[i] - x) < 1e-5))
            fail_msg("%s, %s, number %d: %g, not %g", ffp_cpu_name(level), c->name, i, (double)n.x[i], x);
        if (c->average > 0 && !(fabs((double)n.average[i] - average) < 1e-5))
            fail_msg("%s, %s, average %d: %g, not %g", ffp_cpu_name(level), c->name, i, (double)n.average[i],
                     average);
    }
    numbers_free(&n), numbers_free(&before);
}

static void every_level_steps_as_the_papers_say(void **state) {
    (void)state;
    const FfpCpuLevel used = ffp_cpu_level();
    for (int level = FFP_CPU_PORTABLE; level <= (int)ffp_cpu_best(); level++) {
        assert_true(ffp_cpu_set_level((FfpCpuLevel)level));
        for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) check_case(&cases[i], (FfpCpuLevel)level);
    }
    assert_true(ffp_cpu_set_level(used));
}

static void norms_have_the_same_bits_for_any_number_of_threads(void **state) {
    (void)state;
    enum { MANY = 100003 };
    FfpRng rng = ffp_rng(6, 0);
    real *x = random_reals(&rng, MANY, 1, 0);
    double sum = 0;
    const int threads = omp_get_max_threads();
    for (int i = 0; i < MANY; i++) sum += (double)x[i] * (double)x[i];
    omp_set_num_threads(1);
    const double alone = ffp_squared_norm(x, MANY);
    omp_set_num_threads(3);
    const double shared = ffp_squared_norm(x, MANY);
    omp_set_num_threads(threads);
    assert_true(fabs(alone / sum - 1) < 1e-12);
    assert_memory_equal(&alone, &shared, sizeof alone);
    ffp_free(x);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_quadratic_is_minimised),
                                       cmocka_unit_test(every_level_steps_as_the_papers_say),
                                       cmocka_unit_test(norms_have_the_same_bits_for_any_number_of_threads)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
