// Perceptual networks as files: LPIPS against the reference implementation's figures, and files that must be
// refused.
#include <jansson.h>
#include <math.h>
#include <unistd.h>
#include "core/base/rng.h"
#include "core/tensor/safetensors.h"
#include "engine/loss/perceptual_net.h"
#include "support.h"

#define FILE_NAME "test_lpips.safetensors"

// --- Golden figures. ---

// As the reference saw it: straight alpha over black, rounded to 8 bits.
static FfpImage read_picture(const char *name) {
    char path[1024], relative[512];
    snprintf(relative, sizeof relative, "captures/%s", name);
    assert_true(shared_path(path, relative));
    FfpImage image;
    FfpError err;
    if (!ffp_image_read(&image, path, FFP_COLOUR_ENCODED, &err)) fail_msg("%s", err.text);
    ffp_image_put_over_black(&image);
    for (int i = 0; i < image.width * image.height * image.channels; i++)
        image.data[i] = roundf(image.data[i] * 255) / 255;
    return image;
}

static void check_pair(const FfpPerceptual *net, const char *network, json_t *pair) {
    FfpImage a = read_picture(json_string_value(json_object_get(pair, "a")));
    FfpImage b = read_picture(json_string_value(json_object_get(pair, "b")));
    const double truth = json_real_value(json_object_get(pair, network));
    const double value = ffp_perceptual_loss(net, &a, &b, 1, NULL);
    printf("%s: %.6f, reference %.6f\n", network, value, truth);
    assert_true(truth > 0 && fabs(value - truth) < 1e-4);
    ffp_image_free(&a);
    ffp_image_free(&b);
}

static void check_golden(const char *network, const char *file) {
    char path[1024], golden_path[1024];
    if (!shared_path(golden_path, "perceptual/golden.json") || !shared_path(path, file)) skip();
    json_t *golden = json_load_file(golden_path, 0, NULL);
    json_t *pairs = json_object_get(golden, "pairs");
    assert_true(json_array_size(pairs) >= 5);
    FfpError err;
    FfpPerceptual *net = ffp_perceptual_read(path, &err);
    if (!net) fail_msg("%s", err.text);
    assert_true(ffp_perceptual_is_lpips(net));
    for (size_t i = 0; i < json_array_size(pairs); i++) check_pair(net, network, json_array_get(pairs, i));
    ffp_perceptual_free(net);
    json_decref(golden);
}

static void test_alex(void **state) {
    (void)state;
    check_golden("alex", "perceptual/lpips_alex.safetensors");
}

static void test_squeeze(void **state) {
    (void)state;
    check_golden("squeeze", "perceptual/lpips_squeeze.safetensors");
}

// --- Files. ---

typedef struct Weights { // a network's tensors, ready to be written, open to damage
    FfpTensor tensors[64];
    int count;
} Weights;

static void add_tensor(Weights *weights, const char *name, const real *data, int rank, const int64_t *shape) {
    FfpTensor *tensor = &weights->tensors[weights->count++];
    *tensor = (FfpTensor){.dtype = FFP_F32, .rank = rank, .count = 1, .data = data};
    snprintf(tensor->name, sizeof tensor->name, "%s", name);
    for (int i = 0; i < rank; i++) tensor->count *= tensor->shape[i] = shape[i];
}

static Weights collect(FfpPerceptual *net) {
    Weights weights = {.count = 0};
    FfpRng rng = ffp_rng(9, 0);
    char name[FFP_TENSOR_NAME_MAX];
    for (int i = 0; i < net->layer_count; i++) {
        FfpLayer *layer = &net->layers[i];
        if (layer->is_pool) continue;
        const int64_t shape[4] = {layer->out, layer->in, layer->kernel, layer->kernel};
        const int64_t count = shape[0] * shape[1] * shape[2] * shape[3];
        for (int64_t k = 0; k < count; k++) layer->weight[k] = ffp_rng_range(&rng, -0.1F, 0.1F);
        for (int k = 0; k < layer->out; k++) layer->bias[k] = ffp_rng_range(&rng, -0.1F, 0.1F);
        snprintf(name, sizeof name, "%s.weight", layer->name);
        add_tensor(&weights, name, layer->weight, 4, shape);
        snprintf(name, sizeof name, "%s.bias", layer->name);
        add_tensor(&weights, name, layer->bias, 1, shape);
    }
    for (int i = 0; i < net->tap_count && net->taps[i].head; i++) {
        const int64_t shape[4] = {1, net->channels[net->taps[i].slot], 1, 1};
        for (int k = 0; k < shape[1]; k++) net->taps[i].head[k] = ffp_rng_uniform(&rng);
        snprintf(name, sizeof name, "lin%d.weight", i);
        add_tensor(&weights, name, net->taps[i].head, 4, shape);
    }
    return weights;
}

static FfpPerceptual *written_and_read(const Weights *weights, FfpError *err) {
    FfpError write;
    if (!ffp_safetensors_write(FILE_NAME, weights->tensors, weights->count, NULL, 0, &write))
        fail_msg("%s", write.text);
    FfpPerceptual *net = ffp_perceptual_read(FILE_NAME, err);
    unlink(FILE_NAME);
    return net;
}

static void test_round_trip(void **state) {
    (void)state;
    FfpRng rng = ffp_rng(1, 1);
    FfpImage a = ffp_image_new(35, 33, 3), b = ffp_image_new(35, 33, 3);
    for (int i = 0; i < 35 * 33 * 3; i++)
        a.data[i] = ffp_rng_uniform(&rng), b.data[i] = ffp_rng_uniform(&rng);
    for (int kind = FFP_PERCEPTUAL_ALEX; kind <= FFP_PERCEPTUAL_VGG16; kind++) {
        FfpPerceptual *net = ffp_perceptual_new(kind);
        const Weights weights = collect(net);
        FfpError err;
        FfpPerceptual *again = written_and_read(&weights, &err);
        if (!again) fail_msg("%s", err.text);
        assert_int_equal(again->kind, kind);
        const real value = ffp_perceptual_loss(net, &a, &b, 1, NULL);
        assert_true(value > 0 && ffp_perceptual_loss(again, &a, &b, 1, NULL) == value);
        ffp_perceptual_free(again);
        ffp_perceptual_free(net);
    }
    ffp_image_free(&a);
    ffp_image_free(&b);
}

static void expect_refusal(const Weights *weights, const char *says) {
    FfpError err;
    assert_null(written_and_read(weights, &err));
    if (!strstr(err.text, says)) fail_msg("\"%s\" does not say \"%s\"", err.text, says);
    assert_non_null(strstr(err.text, FILE_NAME));
}

static void test_refused(void **state) {
    (void)state;
    FfpPerceptual *net = ffp_perceptual_new(FFP_PERCEPTUAL_VGG16);
    const Weights good = collect(net);
    Weights bad = good;
    bad.count--;
    expect_refusal(&bad, "features.7.bias");
    bad = good;
    snprintf(bad.tensors[2].name, sizeof bad.tensors[2].name, "another");
    expect_refusal(&bad, "nor VGG16");
    bad = good;
    bad.tensors[4].shape[0] = 64, bad.tensors[4].shape[1] = 128; // the right count in the wrong shape
    expect_refusal(&bad, "features.5.weight");
    bad = good;
    bad.tensors[1].rank = 2, bad.tensors[1].shape[1] = 1;
    expect_refusal(&bad, "features.0.bias");
    bad = good;
    const int64_t numbers[64] = {0};
    bad.tensors[1].dtype = FFP_I64, bad.tensors[1].data = numbers;
    expect_refusal(&bad, "features.0.bias");
    net->layers[0].weight[7] = NAN;
    expect_refusal(&good, "features.0.weight");
    ffp_perceptual_free(net);
    FfpError err;
    assert_null(ffp_perceptual_read("no_such_file.safetensors", &err));
    assert_non_null(strstr(err.text, "no_such_file.safetensors"));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_alex), cmocka_unit_test(test_squeeze),
                                       cmocka_unit_test(test_round_trip), cmocka_unit_test(test_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
