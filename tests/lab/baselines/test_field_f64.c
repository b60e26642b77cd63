// The field's gradients against central differences: the whole way from the loss of a chunk of rays to every
// kind of parameter.
#include <string.h>
#include "lab/baselines/field_scene.h"
#include "lab/baselines/kernels/kernels.h"

enum { RAYS = 40 };

typedef struct Setup {
    FfpCapture capture;
    FfpFieldScene scene;
    FfpNeuralField field;
    FfpFieldChunk chunk;
    FfpFieldSettings settings;
    real *grad;
} Setup;

static const int chosen[SCENE_PATTERNS] = {0, 1, 2};

static double loss_of(Setup *s) {
    ffp_field_chunk_forward(&s->chunk, &s->field);
    ffp_field_chunk_loss(&s->chunk, &s->field, &s->scene, &s->settings, SCENE_PATTERNS, (real)1 / RAYS);
    const FfpChunkLoss *l = &s->chunk.loss;
    return l->pictures + l->mask + l->visibility + l->facing + l->match;
}

// Numbers far from where all networks say the same, and terms that all weigh something.
static void set_up(Setup *s) {
    FfpRng rng = ffp_rng(3, 0);
    s->capture = scene_capture();
    s->scene = ffp_field_scene_new(&s->capture, chosen, SCENE_PATTERNS);
    s->field = ffp_neural_field_new(2);
    s->field.step = 1.0F / 24;
    for (int64_t i = 0; i < s->field.layout.grid; i++)
        s->field.parameters[i] = ffp_rng_range(&rng, -0.5F, 0.5F);
    s->settings = ffp_field_defaults();
    s->settings.facing = 0.3F, s->settings.match = 0.2F, s->settings.visibility = 0.5F;
    s->chunk = ffp_field_chunk_new(&s->field.layout);
    ffp_field_chunk_draw(&s->chunk, &s->field, &s->scene, RAYS, &rng);
    assert_int_equal(s->chunk.n_rays, RAYS);
    ffp_field_chunk_forward(&s->chunk, &s->field);
    ffp_field_chunk_hold(&s->chunk, &s->field, &s->scene, &rng);
    s->grad = ffp_alloc((size_t)s->field.layout.count, sizeof(real));
}

static void tear_down(Setup *s) {
    ffp_free(s->grad);
    ffp_field_chunk_free(&s->chunk);
    ffp_neural_field_free(&s->field);
    ffp_field_scene_free(&s->scene);
    for (int v = 0; v < SCENE_VIEWS; v++) ffp_view_free(&s->capture.views[v], SCENE_PATTERNS);
    for (int p = 0; p < SCENE_PATTERNS; p++) ffp_image_free(&s->capture.patterns[p].image);
    ffp_free(s->capture.views);
    ffp_free(s->capture.patterns);
}

static void take_back(Setup *s) {
    const FfpFieldLayout *layout = &s->field.layout;
    FfpFieldScatter *scatter = ffp_field_kernels()->scatter;
    ffp_field_chunk_backward(&s->chunk, &s->field);
    for (int l = 0; l < FFP_FIELD_LEVELS; l++) {
        const int64_t row = (int64_t)l * FFP_FIELD_FEATURES * FFP_CHUNK_ROW;
        scatter(&layout->levels[l], s->chunk.position, s->chunk.points, FFP_CHUNK_ROW,
                s->chunk.d_encoded + row, s->grad);
        scatter(&layout->levels[l], s->chunk.look_position, s->chunk.looks, FFP_CHUNK_ROW,
                s->chunk.d_look_encoded + row, s->grad);
    }
    memcpy(s->grad + layout->grid, s->chunk.gradient, (size_t)(layout->count - layout->grid) * sizeof(real));
}

// Numbers first .. first + count - 1, every `every`-th of those that have a gradient.
static void check_numbers(Setup *s, const char *what, int64_t first, int64_t count, int every) {
    const double h = 1e-6;
    double largest = 0;
    int seen = 0, checked = 0;
    for (int64_t i = first; i < first + count; i++) largest = fmax(largest, fabs(s->grad[i]));
    if (!(largest > 0)) fail_msg("%s: no gradient at all", what);
    for (int64_t i = first; i < first + count; i++) {
        if (s->grad[i] == 0 || seen++ % every != 0) continue;
        real *x = &s->field.parameters[i];
        const real kept = *x;
        *x = kept + h;
        const double above = loss_of(s);
        *x = kept - h;
        const double below = loss_of(s);
        *x = kept;
        const double numeric = (above - below) / (2 * h);
        checked++;
        if (!(fabs(numeric - s->grad[i]) <= 2e-4 * largest))
            fail_msg("%s[%lld]: analytic %.10g, numeric %.10g", what, (long long)(i - first), s->grad[i],
                     numeric);
    }
    assert_true(checked >= 1);
}

static void check_net(Setup *s, const char *name, const FfpFieldNet *net) {
    for (int i = 0; i < net->count; i++) {
        const FfpFieldLayer *layer = &net->layers[i];
        char what[64];
        snprintf(what, sizeof what, "%s, weights of layer %d", name, i);
        const int64_t weights = (int64_t)layer->inputs * layer->outputs;
        check_numbers(s, what, layer->weights, weights, weights > 200 ? 41 : 5);
        snprintf(what, sizeof what, "%s, biases of layer %d", name, i);
        check_numbers(s, what, layer->biases, layer->outputs, layer->relu ? 5 : 1);
    }
}

static void gradients_agree_with_differences(void **state) {
    (void)state;
    static Setup s;
    set_up(&s);
    assert_true(loss_of(&s) > 0);
    const FfpChunkLoss l = s.chunk.loss; // every term is at work
    assert_true(l.pictures > 0 && l.mask > 0 && l.visibility > 0 && l.facing > 0 && l.match > 0);
    take_back(&s);
    check_net(&s, "geometry", &s.field.layout.geometry);
    check_net(&s, "material", &s.field.layout.material);
    check_net(&s, "visibility", &s.field.layout.visibility);
    for (int i = 0; i < FFP_FIELD_LEVELS; i++) {
        const FfpGridLevel *level = &s.field.layout.levels[i];
        char what[32];
        snprintf(what, sizeof what, "level %d", i);
        check_numbers(&s, what, level->first, level->entries * FFP_FIELD_FEATURES, 500);
    }
    tear_down(&s);
}

// Between grid points features are linear along an axis, and at a grid point they are its own.
static void features_are_interpolated(void **state) {
    (void)state;
    FfpNeuralField field = ffp_neural_field_new(4);
    enum { ROW = FFP_FIELD_BLOCK, POINTS = 3 };
    const FfpGridLevel *level = &field.layout.levels[0];
    real position[3 * ROW] = {0}, encoded[FFP_FIELD_ENCODED * ROW];
    for (int i = 0; i < POINTS; i++) // grid points 5 and 6 along x, and halfway
        position[i] = (5 + (real)i / 2) * 2 / (real)level->resolution - 1, position[ROW + i] = -1,
        position[2 * ROW + i] = -1;
    ffp_field_kernels()->encode(&field.layout, field.parameters, position, POINTS, ROW, encoded);
    for (int f = 0; f < FFP_FIELD_FEATURES; f++) {
        const real *row = encoded + f * ROW;
        const real *numbers = field.parameters + level->first + f;
        assert_float_equal(row[0], numbers[5 * FFP_FIELD_FEATURES], 1e-12);
        assert_float_equal(row[2], numbers[6 * FFP_FIELD_FEATURES], 1e-12);
        assert_float_equal(row[1], (row[0] + row[2]) / 2, 1e-12);
    }
    ffp_neural_field_free(&field);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(features_are_interpolated),
        cmocka_unit_test(gradients_agree_with_differences),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
