// The view pass against its parts put together by hand, and against the convention of the captures.
// Labels: threads
#include <omp.h>
#include "engine/render/pass.h"
#include "engine/render/scenes.h"
#include "support.h"

enum { WIDTH = 21, HEIGHT = 13, SIDE_MAX = 4 };
static const real eye[3] = {2.1F, -1.7F, 1.1F}, beside[3] = {1.0F, -1.6F, 1.7F}, origin[3] = {0};
static const real intensity[3] = {5, 6, 7};

static FfpSummed stripes(int width, int height) {
    FfpImage image = ffp_image_new(width, height, 3);
    for (int i = 0; i < width * height; i++)
        for (int k = 0; k < 3; k++) image.data[3 * i + k] = (real)((i % width / 3 + k) % 2);
    FfpSummed summed = ffp_summed_new(&image);
    ffp_image_free(&image);
    return summed;
}

// By the definition in pass.h, one pixel at a time.
static void resolve_by_hand(const FfpImage *linear, const FfpGbuffer *g, int side, FfpImage *out) {
    for (int p = 0; p < out->width * out->height; p++) {
        double radiance[3] = {0}, opacity = 0;
        for (int i = 0; i < side * side; i++) {
            const int x = p % out->width * side + i % side, y = p / out->width * side + i / side;
            const int at = y * g->width + x;
            opacity += (double)g->opacity[at] / (side * side);
            for (int k = 0; k < 3; k++) radiance[k] += (double)linear->data[3 * at + k] / (side * side);
        }
        const double covered = side > 1 && opacity >= 1e-3 ? opacity : 1;
        for (int k = 0; k < 3; k++)
            out->data[3 * p + k] = (real)covered * ffp_srgb_encode((real)(radiance[k] / covered));
    }
}

static void test_parts_by_hand(void **state) {
    (void)state;
    FfpGaussians g = random_gaussians(200, 7, 0.6, 0.02, 0.15, 0.3, 0.95);
    const FfpCamera camera = look_at(WIDTH, HEIGHT, 14, eye, origin);
    const FfpCamera projector = look_at(31, 29, 30, beside, origin);
    FfpSummed pattern = stripes(31, 29);
    for (int side = 1; side <= SIDE_MAX; side++) {
        FfpRenderSettings settings = ffp_render_defaults();
        settings.samples = side;
        FfpCamera fine = camera;
        fine.width *= side, fine.height *= side;
        fine.fx *= side, fine.fy *= side, fine.cx *= side, fine.cy *= side;
        FfpRaster *raster = ffp_raster_new();
        FfpGbuffer gbuffer = ffp_gbuffer_new(fine.width, fine.height);
        FfpMapping mapping = ffp_mapping_new(fine.width, fine.height);
        FfpImage linear = ffp_image_new(fine.width, fine.height, 3), hand = ffp_image_new(WIDTH, HEIGHT, 3);
        ffp_rasterise(raster, &g, &fine, &settings, &gbuffer);
        ffp_map_to_projector(raster, &g, &gbuffer, &fine, &projector, &settings, &mapping);
        ffp_shade_once(&gbuffer, &mapping, &fine, &projector, intensity, &pattern, &linear);
        resolve_by_hand(&linear, &gbuffer, side, &hand);
        FfpImage picture = ffp_render_view(&g, &camera, &projector, intensity, &pattern, &settings);
        double light = 0;
        for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) {
            assert_float_equal(picture.data[i], hand.data[i], 1e-5);
            light += picture.data[i];
        }
        assert_true(light > 20);
        ffp_image_free(&picture);
        ffp_image_free(&hand);
        ffp_image_free(&linear);
        ffp_mapping_free(&mapping);
        ffp_gbuffer_free(&gbuffer);
        ffp_raster_free(raster);
    }
    ffp_summed_free(&pattern);
    ffp_gaussians_free(&g);
}

// A wall of one ambient colour that ends within a column of pixels: whatever share of a pixel it fills, the
// encoded picture over black is that share of the wall's encoded colour. One sample a pixel sees all or
// nothing of it.
static void test_outline_is_straight_alpha(void **state) {
    (void)state;
    const real colour = 0.3F, encoded = ffp_srgb_encode(colour);
    const real in_front[3] = {0, -3, 0};
    const FfpCamera camera = look_at(16, 16, 24, in_front, origin);
    FfpGaussians wall = ffp_gaussians_new(1);
    for (int k = 0; k < 3; k++) {
        wall.centre[k] = k == 0 ? -1.0F : 0;
        wall.scale[k] = k == 1 ? 0.01F : 0.3F;
        wall.ambient[k] = colour;
    }
    wall.rotation[0] = 1, wall.opacity[0] = 0.99F;
    FfpRenderSettings settings = ffp_render_defaults();
    settings.samples = SIDE_MAX;
    FfpViewPass *pass = ffp_view_pass_new(&settings);
    FfpImage picture = ffp_image_new(16, 16, 3);
    ffp_view_pass_draw(pass, &wall, &camera, &camera);
    ffp_view_pass_shade(pass, intensity, NULL, &picture);
    int partial = 0;
    for (int p = 0; p < 256; p++) {
        const real opacity = ffp_view_pass_gbuffer(pass)->opacity[p];
        partial += opacity > 0.05F && opacity < 0.9F;
        if (opacity >= 1e-3F) assert_float_equal(picture.data[3 * p], opacity * encoded, 1e-4);
    }
    assert_true(partial > 5);
    ffp_image_free(&picture);
    ffp_view_pass_free(pass);
    ffp_gaussians_free(&wall);
}

// A wall of splats one photograph's pixel apart, drawn `times` as large. Where its left edge lies, by how
// much of each row is covered, and how wide it is: pixels that are neither covered nor free.
enum { PHOTOGRAPH = 24 };

static void draw_wall(int times, bool smooth, double *ragged, double *width, FfpImage *out) {
    const real in_front[3] = {0, -3, 0}, apart = 3.0F / 36;
    const FfpCamera camera = look_at(times * PHOTOGRAPH, times * PHOTOGRAPH, 36 * times, in_front, origin);
    FfpGaussians wall = ffp_gaussians_new(20 * PHOTOGRAPH * 2);
    for (int i = 0; i < (int)wall.count; i++) {
        const real centre[3] = {(real)(i % 20) * apart - 0.3F, 0, ((real)(i / 20) - PHOTOGRAPH) * apart};
        for (int k = 0; k < 3; k++) {
            wall.centre[3 * i + k] = centre[k];
            wall.scale[3 * i + k] = k == 1 ? 0.002F : 0.5F * apart;
            wall.ambient[3 * i + k] = 1;
        }
        wall.rotation[4 * i] = 1, wall.opacity[i] = 0.95F;
    }
    FfpRenderSettings settings = ffp_render_defaults();
    settings.smooth = smooth;
    *out = ffp_render_view(&wall, &camera, &camera, intensity, NULL, &settings);
    real least = 1e9F, most = 0;
    for (int y = 0; y < out->height; y++) {
        real covered = 0;
        for (int x = 0; x < out->width; x++) {
            const real v = out->data[3 * (y * out->width + x)];
            covered += v;
            *width += v > 0.05F && v < 0.95F ? 1.0 / out->height : 0;
        }
        least = fmin(least, covered), most = fmax(most, covered);
    }
    *ragged = (double)(most - least);
    ffp_gaussians_free(&wall);
}

static void test_outlines_are_smooth_in_large_pictures_alone(void **state) {
    (void)state;
    for (int times = 1; times <= 8; times *= 2) {
        double ragged[2] = {0}, width[2] = {0};
        FfpImage picture[2];
        for (int smooth = 0; smooth < 2; smooth++)
            draw_wall(times, smooth, &ragged[smooth], &width[smooth], &picture[smooth]);
        if (times == 1)
            assert_memory_equal(picture[0].data, picture[1].data, sizeof(real) * 3 * PHOTOGRAPH * PHOTOGRAPH);
        if (times < 4) assert_true(ragged[0] < 0.1 && ragged[1] < 0.1);
        if (times >= 4) assert_true(ragged[0] > 0.5 && ragged[1] < 0.2 * ragged[0]);
        if (times >= 4) assert_true(width[0] > 3 && width[1] < 2.5); // as narrow as the edge of anything
        ffp_image_free(&picture[0]), ffp_image_free(&picture[1]);
    }
}

static void gradient_with(int threads, FfpGaussians *g, FfpGaussians *grad, FfpImage *picture) {
    const FfpCamera camera = look_at(WIDTH, HEIGHT, 14, eye, origin);
    const FfpCamera projector = look_at(31, 29, 30, beside, origin);
    FfpSummed pattern = stripes(31, 29);
    const FfpRenderSettings settings = ffp_render_defaults();
    FfpViewPass *pass = ffp_view_pass_new(&settings);
    omp_set_num_threads(threads);
    ffp_view_pass_draw(pass, g, &camera, &projector);
    ffp_view_pass_shade(pass, intensity, &pattern, picture);
    ffp_view_pass_shade_backward(pass, intensity, &pattern, picture, NULL, NULL);
    ffp_view_pass_backward(pass, grad);
    ffp_view_pass_free(pass);
    ffp_summed_free(&pattern);
}

static void test_same_bits_for_any_number_of_threads(void **state) {
    (void)state;
    FfpGaussians g = random_gaussians(300, 3, 0.6, 0.02, 0.15, 0.3, 0.95);
    FfpGaussians grads[2] = {ffp_gaussians_new(g.count), ffp_gaussians_new(g.count)};
    FfpImage pictures[2] = {ffp_image_new(WIDTH, HEIGHT, 3), ffp_image_new(WIDTH, HEIGHT, 3)};
    const int most = omp_get_max_threads();
    gradient_with(1, &g, &grads[0], &pictures[0]);
    gradient_with(3, &g, &grads[1], &pictures[1]);
    omp_set_num_threads(most);
    assert_memory_equal(pictures[0].data, pictures[1].data, sizeof(real) * 3 * WIDTH * HEIGHT);
    Field a[FIELDS], b[FIELDS];
    gaussian_fields(&grads[0], a);
    gaussian_fields(&grads[1], b);
    double size = 0;
    for (int k = 0; k < FIELDS; k++) {
        assert_memory_equal(a[k].data, b[k].data, sizeof(real) * (size_t)a[k].count);
        for (int64_t i = 0; i < a[k].count; i++) size += fabs((double)a[k].data[i]);
    }
    assert_true(size > 1);
    for (int i = 0; i < 2; i++) ffp_gaussians_free(&grads[i]), ffp_image_free(&pictures[i]);
    ffp_gaussians_free(&g);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parts_by_hand),
        cmocka_unit_test(test_outline_is_straight_alpha),
        cmocka_unit_test(test_outlines_are_smooth_in_large_pictures_alone),
        cmocka_unit_test(test_same_bits_for_any_number_of_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
