// How far two renderings of one scene with different random numbers lie apart at the paper preset's samples.
#include <math.h>
#include "core/base/alloc.h"
#include "core/patterns/lollipop.h"
#include "support.h"
#include "world/shapes/mesh.h"
#include "world/synth/rig.h"
#include "world/synth/simulate.h"
#include "world/synth/synth.h"

enum { SIDE = 128, PATTERNS = 2 };

static double psnr_of_two_seeds(int mesh_number, int material_number) {
    FfpError err = {0};
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.resolution = SIDE;
    FfpMesh mesh = ffp_mesh_make(mesh_number);
    const FfpMaterial material = ffp_material_make(material_number, 3);
    FfpTracer *tracer = ffp_tracer_new(&mesh, &err);
    assert_non_null(tracer);
    FfpImage image[PATTERNS] = {ffp_image_new(800, 800, 3), ffp_lollipop_pattern(800, 800, 5)};
    for (int i = 0; i < 800 * 800 * 3; i++) image[0].data[i] = 1;
    FfpLight light = ffp_light_new((const FfpImage *[]){&image[0], &image[1]}, PATTERNS);
    FfpCapture captures[2];
    for (int s = 0; s < 2; s++) {
        captures[s] =
            (FfpCapture){.n_patterns = PATTERNS, .n_views = 1, .views = ffp_alloc(1, sizeof(FfpView))};
        assert_non_null(captures[s].views);
        const FfpSimulation simulation = {.tracer = tracer,
                                          .mesh = &mesh,
                                          .material = &material,
                                          .light = &light,
                                          .intensity = {7.96F, 7.96F, 7.96F},
                                          .ambient = 0.3F,
                                          .samples = 16,
                                          .ambient_rays = 4,
                                          .seed = (uint64_t)s + 1};
        ffp_rig_input(&spec, 1, captures[s].views);
        ffp_simulate_view(&simulation, captures[s].views, 0, NULL);
    }
    double square = 0;
    for (int p = 0; p < PATTERNS; p++)
        for (int i = 0; i < 3 * SIDE * SIDE; i++) {
            const double d = (double)(ffp_srgb_encode(captures[0].views[0].images[p].data[i]) -
                                      ffp_srgb_encode(captures[1].views[0].images[p].data[i]));
            square += d * d / (3.0 * SIDE * SIDE * PATTERNS);
        }
    ffp_light_free(&light);
    for (int p = 0; p < PATTERNS; p++) ffp_image_free(&image[p]);
    ffp_tracer_free(tracer);
    ffp_mesh_free(&mesh);
    for (int s = 0; s < 2; s++) {
        captures[s].n_patterns = 0; // they were the test's
        for (int p = 0; p < PATTERNS; p++) ffp_image_free(&captures[s].views[0].images[p]);
        ffp_capture_free(&captures[s]);
    }
    return -10 * log10(square);
}

static void seeds_differ_by_little(void **state) {
    (void)state;
    const int scenes[6][2] = {{1, 5}, {6, 0}, {10, 14}, {29, 8}, {41, 12}, {74, 3}};
    double mean = 0;
    for (int i = 0; i < 6; i++) {
        const double psnr = psnr_of_two_seeds(scenes[i][0], scenes[i][1]);
        print_message("%s under %s: %.2f dB\n", ffp_mesh_name(scenes[i][0]), ffp_material_name(scenes[i][1]),
                      psnr);
        assert_true(psnr >= 38);
        assert_true(psnr < 90); // they do differ
        mean += psnr / 6;
    }
    print_message("mean: %.2f dB\n", mean);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(seeds_differ_by_little)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
