// The simulator and the renderer must mean the same light: the generator's own depth, normal, albedo,
// roughness and shadows, put through our shading, give back its direct-light picture.
#include <math.h>
#include "engine/render/render.h"
#include "support.h"
#include "world/synth/scene.h"

static FfpGbuffer truth_gbuffer(const FfpView *view) {
    FfpGbuffer g = ffp_gbuffer_new(view->camera.width, view->camera.height);
    for (int i = 0; i < g.width * g.height; i++) {
        if (view->coverage.data[i] < 1 || view->depth.data[i] <= 0) continue;
        g.opacity[i] = 1;
        g.depth[i] = view->depth.data[i];
        g.roughness[i] = view->roughness.data[i];
        for (int c = 0; c < 3; c++) {
            g.normal[3 * i + c] = view->normal.data[3 * i + c];
            g.albedo[3 * i + c] = view->albedo.data[3 * i + c];
        }
    }
    return g;
}

// A pixel whose neighbourhood is one surface: where a nearer part ends, samples of two surfaces share a
// pixel, and no mean normal can stand for both.
static int is_interior(const FfpView *view, int x, int y) {
    const int width = view->camera.width, height = view->camera.height;
    if (x < 1 || y < 1 || x >= width - 1 || y >= height - 1) return 0;
    const real here = view->depth.data[y * width + x];
    for (int k = 0; k < 9; k++) {
        const int i = (y + k / 3 - 1) * width + x + k % 3 - 1;
        if (view->coverage.data[i] < 1 || fabsf(view->depth.data[i] - here) > 0.1F) return 0;
    }
    return 1;
}

typedef struct Agreement {
    double interior,
        frame; // sRGB PSNR over interior pixels, and over the whole frame's fully covered ones and background
} Agreement;

static Agreement compare(const FfpView *view, const FfpGbuffer *g, const FfpImage *out) {
    double square[2] = {0, 0}, count[2] = {0, 0};
    for (int y = 0; y < g->height; y++)
        for (int x = 0; x < g->width; x++) {
            const int i = y * g->width + x, interior = is_interior(view, x, y);
            for (int c = 0; c < 3; c++) {
                const real truth = g->opacity[i] > 0 ? view->direct_white.data[3 * i + c] : 0;
                const double error = (double)(ffp_srgb_encode(out->data[3 * i + c]) - ffp_srgb_encode(truth));
                square[1] += error * error, count[1]++;
                if (interior) square[0] += error * error, count[0]++;
            }
        }
    return (Agreement){-10 * log10(square[0] / count[0]), -10 * log10(square[1] / count[1])};
}

static Agreement truth_agreement(const FfpCapture *capture, const FfpView *view, const FfpImage *visibility,
                                 const FfpSummed *white) {
    FfpGbuffer g = truth_gbuffer(view);
    const int pixels = g.width * g.height;
    FfpMapping mapping = ffp_mapping_new(g.width, g.height);
    for (int i = 0; i < pixels; i++) {
        mapping.extent[2 * i] = mapping.extent[2 * i + 1] = 1;
        mapping.visibility[i] = visibility->data[i];
    }
    FfpImage out = ffp_image_new(g.width, g.height, 3);
    ffp_shade_once(&g, &mapping, &view->camera, &view->projector, capture->intensity, white, &out);
    const Agreement agreement = compare(view, &g, &out);
    ffp_image_free(&out);
    ffp_mapping_free(&mapping);
    ffp_gbuffer_free(&g);
    return agreement;
}

static void true_maps_give_back_the_direct_light(void **state) {
    (void)state;
    static const char *const scenes[3] = {"smooth", "bumpy", "glossy"};
    static const int meshes[3] = {1, 7, 17}, materials[3] = {15, 11, 5};
    for (int s = 0; s < 3; s++) {
        FfpSceneSpec spec = ffp_scene_defaults();
        spec.mesh = meshes[s], spec.material = materials[s], spec.seed = 4;
        spec.views = 2, spec.targets = 2, spec.lollipops = 0, spec.samples = 64, spec.ambient_rays = 0;
        FfpCapture capture;
        FfpImage visibility[4];
        FfpError err;
        assert_true(ffp_scene_make_lit(&capture, &spec, visibility, &err));
        FfpSummed white = ffp_summed_new(&capture.patterns[capture.white].image);
        double interior = 0, frame = 0;
        for (int v = 0; v < 4; v++) {
            const Agreement a = truth_agreement(&capture, &capture.views[v], &visibility[v], &white);
            print_message("%s, %s: interior %.2f dB, frame %.2f dB\n", scenes[s], capture.views[v].id,
                          a.interior, a.frame);
            interior += a.interior / 4,
                frame += a.frame / 4; // a single view may have a highlight narrower than a pixel
            ffp_image_free(&visibility[v]);
        }
        assert_true(interior >= 40);
        assert_true(frame >= 40);
        ffp_summed_free(&white);
        ffp_capture_free(&capture);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(true_maps_give_back_the_direct_light)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
