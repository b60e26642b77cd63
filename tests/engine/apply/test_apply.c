// Compensation and maps on a tilted board with a ball before it, where geometry and light are known.
#include <math.h>
#include "engine/apply/solve.h"
#include "engine/apply/surface.h"
#include "engine/apply/view_maps.h"
#include "engine/loss/metrics.h"
#include "engine/render/pass.h"
#include "engine/render/scenes.h"
#include "engine/render/strip.h"
#include "support.h"

enum { SIDE = 40, PATTERN = 96, BOARD = 60 };

static const real tilted[3] = {0.2425356F, 0, 0.9701425F}; // the board's normal

// A splat of the board or the ball, flat along its normal.
static void put_splat(FfpGaussians *g, int64_t i, const real at[3], const real normal[3], real size) {
    const real half = sqrtf(fmaxf((1 + normal[2]) / 2, 1e-6F)); // turns z into the normal
    for (int k = 0; k < 3; k++) {
        g->centre[3 * i + k] = at[k];
        g->scale[3 * i + k] = k == 2 ? size * 0.05F : size;
        g->albedo[3 * i + k] = 0.35F + 0.3F * (real)((i / 7 + k) % 2);
        g->ambient[3 * i + k] = 0.03F;
    }
    g->rotation[4 * i] = half;
    g->rotation[4 * i + 1] = -normal[1] / (2 * half), g->rotation[4 * i + 2] = normal[0] / (2 * half);
    g->opacity[i] = 0.98F, g->roughness[i] = 0.8F;
}

static FfpGaussians board(bool with_ball) {
    const int64_t ball = with_ball ? 1500 : 0, flat = BOARD * BOARD;
    FfpGaussians g = ffp_gaussians_new(flat + ball);
    const real along[3] = {tilted[2], 0, -tilted[0]};
    for (int64_t i = 0; i < flat; i++) {
        const real a = ((real)(i % BOARD) / (BOARD - 1) - 0.5F) * 2,
                   b = ((real)(i / BOARD) / (BOARD - 1) - 0.5F) * 2;
        const real at[3] = {a * along[0], b, a * along[2]};
        put_splat(&g, i, at, tilted, 1.2F / BOARD);
    }
    for (int64_t i = 0; i < ball; i++) { // Fibonacci's lattice
        const real z = 1 - (2 * (real)i + 1) / (real)ball, turn = 2.3999632F * (real)i;
        const real r = sqrtf(1 - z * z), n[3] = {r * cosf(turn), r * sinf(turn), z};
        const real at[3] = {0.2F * n[0], 0.2F * n[1], 0.8F + 0.2F * n[2]};
        put_splat(&g, flat + i, at, n, 0.012F);
    }
    return g;
}

static FfpImage grey(int width, int height, real value) {
    FfpImage image = ffp_image_new(width, height, 3);
    for (int i = 0; i < 3 * width * height; i++) image.data[i] = value;
    return image;
}

typedef struct World {
    FfpGaussians gaussians;
    FfpCapture capture;
    FfpPattern patterns[2];
    FfpView views[2];
    const FfpView *chosen[2];
} World;

static void world_new(World *w, bool with_ball) {
    const real origin[3] = {0, 0, 0}, eye[2][3] = {{0.3F, -0.6F, 3}, {-0.7F, -0.3F, 3}};
    const real light[2][3] = {{-0.8F, 0.3F, 2.4F}, {1, 0.2F, 2.4F}};
    memset(w, 0, sizeof *w);
    w->gaussians = board(with_ball);
    w->patterns[0].image = grey(PATTERN, PATTERN, 0);
    w->patterns[1].image = grey(PATTERN, PATTERN, 1);
    w->capture = (FfpCapture){.n_patterns = 2,
                              .n_views = 2,
                              .patterns = w->patterns,
                              .views = w->views,
                              .white = 1,
                              .intensity = {8, 7, 6},
                              .radius = 1};
    for (int v = 0; v < 2; v++) {
        snprintf(w->views[v].id, sizeof w->views[v].id, "view_%d", v);
        w->views[v].camera = look_at(SIDE, SIDE, SIDE * 1.4, eye[v], origin);
        w->views[v].projector = look_at(PATTERN, PATTERN, PATTERN * 1.1, light[v], origin);
        w->chosen[v] = &w->views[v];
    }
}

// The board scatters light, and the projector's lens spreads a share of its own.
static void world_scatters(World *w) {
    scatter_light(&w->gaussians, 3);
    for (int64_t i = 0; i < 3 * w->gaussians.count; i++) w->gaussians.scattered[i] *= 0.3F;
    for (int c = 0; c < 3; c++) w->capture.panel.spread[c] = 0.06F + 0.02F * (real)c;
    w->capture.panel.spread_reach = 7;
}

static void world_free(World *w) {
    ffp_gaussians_free(&w->gaussians);
    ffp_image_free(&w->patterns[0].image);
    ffp_image_free(&w->patterns[1].image);
}

static FfpProCams drawn_procams_of(World *w, int views, const FfpRenderSettings *settings) {
    return ffp_procams_new(&w->gaussians, &w->capture, w->chosen, views, settings, false);
}

static FfpProCams procams_of(World *w, int views) {
    const FfpRenderSettings settings = ffp_render_defaults();
    return drawn_procams_of(w, views, &settings);
}

static void randomise(FfpImage *image, uint64_t seed, double low, double high) {
    FfpRng rng = ffp_rng(seed, 3);
    for (int i = 0; i < image->width * image->height * image->channels; i++)
        image->data[i] = between(&rng, low, high);
}

// Waves of light, the same whatever the size.
static FfpImage waves(int side) {
    FfpImage image = ffp_image_new(side, side, 3);
    for (int p = 0; p < side * side; p++)
        for (int c = 0; c < 3; c++) {
            const real x = (real)(p % side) / (real)side, y = (real)(p / side) / (real)side;
            image.data[3 * p + c] = 0.5F + 0.35F * sinf(40 * x + (real)c) * cosf(33 * y);
        }
    return image;
}

// Largest difference, and the PSNR, of FfpProCams' picture and the renderer's.
static double picture_difference(const FfpRenderSettings *settings, bool scatters, double *psnr) {
    World w;
    world_new(&w, true);
    if (scatters) world_scatters(&w);
    FfpProCams procams = drawn_procams_of(&w, 1, settings);
    randomise(&procams.projections[0].pattern, 5, 0, 1);
    FfpImage ours = ffp_procams_picture(&procams, 0);
    ffp_image_to_srgb(&ours);
    FfpImage light = ffp_procams_light(&procams, 0);
    FfpSummed summed = ffp_summed_new(&light);
    ffp_image_free(&light);
    FfpImage theirs = ffp_render_view(&w.gaussians, &w.views[0].camera, &w.views[0].projector,
                                      w.capture.intensity, &summed, settings);
    double most = 0, brightest = 0;
    for (int i = 0; i < 3 * SIDE * SIDE; i++) {
        most = worse(most, fabs((double)(ours.data[i] - theirs.data[i])));
        brightest = fmax(brightest, (double)ours.data[i]);
    }
    assert_true(brightest > 0.4);
    *psnr = ffp_psnr(&ours, &theirs);
    ffp_summed_free(&summed);
    ffp_image_free(&ours);
    ffp_image_free(&theirs);
    ffp_procams_free(&procams);
    world_free(&w);
    return most;
}

// With one sample a pixel they are the same. With more, FfpProCams shades each pixel's means, and the
// renderer takes means of what it shaded: at outlines they differ.
static void the_picture_is_the_renderers(void **state) {
    (void)state;
    double psnr;
    const FfpRenderSettings one = ffp_render_settings(false, 1), two = ffp_render_settings(false, 2);
    const FfpRenderSettings even = ffp_render_gs_procams();
    assert_true(picture_difference(&one, false, &psnr) < 2e-4);
    assert_true(picture_difference(&one, true, &psnr) < 2e-4);
    assert_true(picture_difference(&even, false, &psnr) < 2e-4);
    picture_difference(&two, false, &psnr);
    print_message("two samples a side: %.2f dB\n", psnr);
    assert_true(psnr > 30);
}

// The spread's adjoint is taken as itself: at the pattern's edges that is not exact.
static void check_gradient(bool scatters, double tolerance) {
    World w;
    world_new(&w, false);
    if (scatters) world_scatters(&w);
    FfpProCams procams = procams_of(&w, 2);
    assert_int_equal(procams.n_projections, 2);
    if (scatters) procams.blur = 1;
    FfpImage target = waves(SIDE), gradients[2], way[2];
    for (int k = 0; k < 2; k++) {
        ffp_procams_aim(&procams, k, &target, NULL);
        randomise(&procams.projections[k].pattern, 7 + (uint64_t)k, 0.2, 0.5);
        gradients[k] = ffp_image_new(PATTERN, PATTERN, 3), way[k] = ffp_image_new(PATTERN, PATTERN, 3);
        randomise(&way[k], 9 + (uint64_t)k, -1, 1);
    }
    ffp_procams_loss(&procams, gradients);
    double along = 0, loss[2];
    for (int side = 0; side < 2; side++) {
        for (int k = 0; k < 2; k++)
            for (int i = 0; i < 3 * PATTERN * PATTERN; i++)
                procams.projections[k].pattern.data[i] += (side ? -0.04F : 0.02F) * way[k].data[i];
        loss[side] = ffp_procams_loss(&procams, NULL);
    }
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 3 * PATTERN * PATTERN; i++)
            along += (double)gradients[k].data[i] * (double)way[k].data[i];
    const double measured = (loss[0] - loss[1]) / 0.04;
    assert_true(fabs(along) > 1e-5);
    if (!(fabs(measured - along) < tolerance * fabs(along)))
        fail_msg("%g along, %g measured", along, measured);
    for (int k = 0; k < 2; k++) ffp_image_free(&gradients[k]), ffp_image_free(&way[k]);
    ffp_image_free(&target);
    ffp_procams_free(&procams);
    world_free(&w);
}

static void the_gradient_is_that_of_the_loss(void **state) {
    (void)state;
    check_gradient(false, 0.01);
    check_gradient(true, 0.02);
}

static double unwarped_psnr(FfpProCams *procams, const FfpImage *target) {
    FfpImage pattern = ffp_image_resize(target, PATTERN, PATTERN);
    memcpy(procams->projections[0].pattern.data, pattern.data, (size_t)PATTERN * PATTERN * 3 * sizeof(real));
    ffp_image_free(&pattern);
    return ffp_procams_psnr(procams);
}

static void compensation_comes_near_and_descent_nearer(void **state) {
    (void)state;
    World w;
    world_new(&w, true);
    FfpProCams procams = procams_of(&w, 1);
    FfpImage target = waves(SIDE);
    ffp_procams_aim(&procams, 0, &target, NULL);
    ffp_procams_paint(&procams);
    const FfpGamut gamut = ffp_procams_gamut(&procams);
    assert_true(gamut.too_dark == 0 && gamut.too_bright == 0);
    assert_true(gamut.unlit > 0.005 && gamut.unlit < 0.5); // the ball's shadow
    const double unwarped = unwarped_psnr(&procams, &target);
    ffp_procams_closed_form(&procams, 1);
    const double closed = ffp_procams_psnr(&procams);
    ffp_procams_descend(&procams, 40);
    ffp_procams_quantise(&procams);
    const double descended = ffp_procams_psnr(&procams);
    print_message("unwarped %.2f, closed form %.2f, descended %.2f dB\n", unwarped, closed, descended);
    assert_true(closed > unwarped + 6);
    assert_true(descended > closed + 1);
    for (int i = 0; i < 3 * PATTERN * PATTERN; i++)
        assert_true(procams.projections[0].pattern.data[i] >= 0 &&
                    procams.projections[0].pattern.data[i] <= 1);
    ffp_image_free(&target);
    ffp_procams_free(&procams);
    world_free(&w);
}

// Solved as if nothing were scattered or spread, and as it is.
static void scattered_and_spread_light_is_taken_off(void **state) {
    (void)state;
    double psnr[2];
    for (int knows = 0; knows < 2; knows++) {
        World w;
        world_new(&w, true);
        world_scatters(&w);
        FfpProCams procams = procams_of(&w, 1);
        FfpImage target = waves(SIDE), hidden = procams.camera_views[0].scattered;
        ffp_procams_aim(&procams, 0, &target, NULL);
        ffp_procams_paint(&procams);
        if (!knows) procams.camera_views[0].scattered = (FfpImage){0}, procams.spread_reach = 0;
        ffp_procams_closed_form(&procams, 1);
        procams.camera_views[0].scattered = hidden, procams.spread_reach = w.capture.panel.spread_reach;
        psnr[knows] = ffp_procams_psnr(&procams);
        ffp_image_free(&target);
        ffp_procams_free(&procams);
        world_free(&w);
    }
    print_message("without what scatters %.2f, with it %.2f dB\n", psnr[0], psnr[1]);
    assert_true(psnr[1] > psnr[0] + 3);
}

// Stripes of the camera's picture that hardly any direct light reaches, as in shadows, ask for as much of it
// as the places beside them do, not for what would make up for scattered light.
static void shadows_do_not_make_up_for_scattered_light(void **state) {
    (void)state;
    World w;
    world_new(&w, true);
    world_scatters(&w);
    w.capture.panel.spread_reach = 0;
    FfpProCams procams = procams_of(&w, 1);
    FfpImage *response = &ffp_procams_link(&procams, 0, 0)->response, target = grey(SIDE, SIDE, 0.25F);
    for (int i = 0; i < 3 * SIDE * SIDE; i++)
        if (i / 3 % SIDE % 12 < 4) response->data[i] *= 0.01F;
    ffp_procams_aim(&procams, 0, &target, NULL);
    ffp_procams_paint(&procams);
    ffp_procams_closed_form(&procams, 0);
    const FfpImage *pattern = &procams.projections[0].pattern;
    double most = 0;
    for (int i = 0; i < 3 * PATTERN * PATTERN; i++)
        most = pattern->data[i] > most ? (double)pattern->data[i] : most;
    print_message("with shadows, a quarter of white takes up to %.3f of it\n", most);
    assert_true(most < 0.4);
    ffp_image_free(&target);
    ffp_procams_free(&procams);
    world_free(&w);
}

// Seen through the projector's blur, solved without it and for it.
static void patterns_are_sharpened_for_the_blur(void **state) {
    (void)state;
    double psnr[2];
    for (int knows = 0; knows < 2; knows++) {
        World w;
        world_new(&w, true);
        FfpProCams procams = procams_of(&w, 1);
        FfpImage target = waves(SIDE);
        ffp_procams_aim(&procams, 0, &target, NULL);
        ffp_procams_paint(&procams);
        if (knows) procams.blur = 2;
        ffp_procams_closed_form(&procams, 1);
        ffp_procams_descend(&procams, 10);
        procams.blur = 2;
        psnr[knows] = ffp_procams_psnr(&procams);
        ffp_image_free(&target);
        ffp_procams_free(&procams);
        world_free(&w);
    }
    print_message("through a blur of 2 pixels %.2f, sharpened for it %.2f dB\n", psnr[0], psnr[1]);
    assert_true(psnr[1] > psnr[0] + 3);
}

static void two_runs_give_the_same_bits(void **state) {
    (void)state;
    World w;
    world_new(&w, true);
    FfpImage target = waves(SIDE), first = {0};
    for (int run = 0; run < 2; run++) {
        FfpProCams procams = procams_of(&w, 1);
        ffp_procams_aim(&procams, 0, &target, NULL);
        ffp_procams_closed_form(&procams, 1);
        ffp_procams_descend(&procams, 3);
        if (run == 0)
            first = ffp_image_copy(&procams.projections[0].pattern);
        else
            assert_memory_equal(first.data, procams.projections[0].pattern.data,
                                PATTERN * PATTERN * 3 * sizeof(real));
        ffp_procams_free(&procams);
    }
    ffp_image_free(&first);
    ffp_image_free(&target);
    world_free(&w);
}

static void what_cannot_be_reached_is_counted(void **state) {
    (void)state;
    World w;
    world_new(&w, true);
    FfpProCams procams = procams_of(&w, 1);
    FfpImage black = grey(SIDE, SIDE, 0), blinding = grey(SIDE, SIDE, 1),
             alpha = ffp_image_new(SIDE, SIDE, 1);
    ffp_procams_aim(&procams, 0, &black, NULL);
    FfpGamut gamut = ffp_procams_gamut(&procams);
    const int whole = gamut.pixels;
    assert_true(whole > SIDE * SIDE / 4);
    assert_true(fabs(gamut.too_dark + gamut.unlit - 1) < 1e-9 && gamut.too_bright == 0);
    assert_true(ffp_procams_brightest(&procams) == 1); // black is black with any gain
    ffp_procams_aim(&procams, 0, &blinding, NULL);
    gamut = ffp_procams_gamut(&procams);
    assert_true(fabs(gamut.too_bright + gamut.unlit - 1) < 1e-9 && gamut.too_dark == 0);
    for (int p = 0; p < SIDE * SIDE; p++) alpha.data[p] = p % SIDE < SIDE / 2;
    ffp_procams_aim(&procams, 0, &blinding, &alpha);
    gamut = ffp_procams_gamut(&procams);
    assert_true(gamut.pixels > 0 && gamut.pixels < whole * 3 / 4);
    ffp_image_free(&black);
    ffp_image_free(&blinding);
    ffp_image_free(&alpha);
    ffp_procams_free(&procams);
    world_free(&w);
}

// A target that is within reach, made eight times too dark or too bright, is brought back.
static void the_gain_that_light_allows_is_found(void **state) {
    (void)state;
    World w;
    world_new(&w, false);
    static const real factors[2] = {0.125F, 8};
    for (int k = 0; k < 2; k++) {
        FfpProCams procams = procams_of(&w, 1);
        FfpImage target = waves(SIDE);
        ffp_procams_aim(&procams, 0, &target, NULL);
        ffp_procams_paint(&procams);
        ffp_procams_scale(&procams, factors[k]);
        const real gain = ffp_procams_brightest(&procams);
        assert_true(gain * factors[k] >= 1 && gain * factors[k] < 1.5F);
        ffp_procams_scale(&procams, gain);
        const FfpGamut gamut = ffp_procams_gamut(&procams);
        assert_true(gamut.too_bright + gamut.too_dark < 0.2);
        ffp_image_free(&target);
        ffp_procams_free(&procams);
    }
    world_free(&w);
}

// Both projectors reach the board's middle; together they must not light it twice.
static void projectors_share_where_they_overlap(void **state) {
    (void)state;
    World w;
    world_new(&w, false);
    w.views[1].camera = w.views[0].camera; // one camera twice, two projectors
    FfpProCams procams = procams_of(&w, 2);
    assert_int_equal(procams.n_projections, 2);
    FfpImage target = grey(SIDE, SIDE, 0.14F);
    for (int s = 0; s < 2; s++) ffp_procams_aim(&procams, s, &target, NULL);
    ffp_procams_closed_form(&procams, 1);
    const double closed = ffp_procams_psnr(&procams);
    ffp_procams_descend(&procams, 40);
    const double descended = ffp_procams_psnr(&procams);
    print_message("two projectors: closed form %.2f, descended %.2f dB\n", closed, descended);
    assert_true(closed > 25);
    assert_true(descended > closed);
    for (int k = 0; k < 2; k++) { // each does a part in the middle, and less at the edge of its light
        const FfpProjection *projection = &procams.projections[k];
        const int middle = PATTERN / 2 * PATTERN + PATTERN / 2;
        assert_true(projection->pattern.data[3 * middle] > 0.02F &&
                    projection->pattern.data[3 * middle] < 0.9F);
        assert_true(projection->feather.data[middle] > 0.5F);
        assert_true(projection->feather.data[0] < 0.05F);
    }
    ffp_image_free(&target);
    ffp_procams_free(&procams);
    world_free(&w);
}

// The projectors (bits) that reach a pixel and all around it; -1: not the same ones everywhere.
static int reached_by(const FfpProCams *procams, int x, int y) {
    int found = -1;
    for (int j = y - 2; j <= y + 2; j++)
        for (int i = x - 2; i <= x + 2; i++) {
            int here = 0;
            if (i < 0 || j < 0 || i >= SIDE || j >= SIDE) return -1;
            for (int k = 0; k < 2; k++)
                here |= (ffp_procams_link(procams, 0, k)->response.data[3 * (j * SIDE + i)] > 0.02F) << k;
            if (found >= 0 && here != found) return -1;
            found = here;
        }
    return found;
}

// White and black painted by two projectors, each on its half of the board and a part of the other, whose
// dark is a twentieth of their white: where both reach, no brighter than the brighter one would be and no
// darker than the darker one; and where one does as bright as it, and as dark as where there are both.
static void nothing_is_brighter_where_two_overlap(void **state) {
    (void)state;
    const real black = 0.05F;
    World w;
    world_new(&w, false);
    w.views[1].camera = w.views[0].camera;
    w.views[0].projector.cx -= 62, w.views[1].projector.cx += 62;
    FfpProCams alone = procams_of(&w, 2);
    for (int white = 0; white < 2; white++) {
        FfpProCams procams = procams_of(&w, 2);
        FfpImage target = grey(SIDE, SIDE, (real)white);
        ffp_procams_black_level(&procams, black);
        for (int s = 0; s < 2; s++) ffp_procams_aim(&procams, s, &target, NULL);
        ffp_procams_paint(&procams);
        ffp_procams_closed_form(&procams, 1);
        FfpImage picture = ffp_procams_picture(&procams, 0);
        int count[4] = {0}, off[4] = {0};
        for (int p = 0; p < SIDE * SIDE; p++) {
            const int reached = reached_by(&alone, p % SIDE, p / SIDE);
            if (reached < 1) continue;
            const real a = ffp_procams_link(&alone, 0, 0)->response.data[3 * p],
                       b = ffp_procams_link(&alone, 0, 1)->response.data[3 * p];
            const real share = white ? 1 : 2 * black;
            const real most = share * fmaxf(a, b), least = reached == 3 ? share * fminf(a, b) : most;
            const real seen = picture.data[3 * p] - alone.camera_views[0].ambient.data[3 * p];
            count[reached]++;
            off[reached] += seen > 1.03F * most || seen < 0.97F * least;
        }
        print_message("painted %d: of one %d of %d and %d of %d places off by 3 %%, of both %d of %d\n",
                      white, off[1], count[1], off[2], count[2], off[3], count[3]);
        for (int k = 1; k < 4; k++)
            assert_true(count[k] > 20 && 8 * off[k] < count[k]); // outlines are blurred
        ffp_image_free(&picture);
        ffp_image_free(&target);
        ffp_procams_free(&procams);
    }
    ffp_procams_free(&alone);
    world_free(&w);
}

static void views_of_one_projector_share_its_pattern(void **state) {
    (void)state;
    World w;
    world_new(&w, false);
    w.views[1].projector = w.views[0].projector;
    for (int i = 0; i < 12; i++) // written by another program: not the same to the last digit
        w.views[1].projector.pose[i] = nextafterf(w.views[1].projector.pose[i], 9);
    w.capture.radius = 1e-3F; // in the unit of a small object's capture these are places apart
    w.views[1].projector.pose[3] += 5e-5F;
    FfpProCams procams = procams_of(&w, 2);
    assert_int_equal(procams.n_projections, 2);
    ffp_procams_free(&procams);
    w.views[1].projector.pose[3] -= 5e-5F;
    w.capture.radius = 1;
    procams = procams_of(&w, 2);
    assert_int_equal(procams.n_projections, 1);
    FfpImage target = grey(SIDE, SIDE, 0.12F);
    for (int s = 0; s < 2; s++) ffp_procams_aim(&procams, s, &target, NULL);
    ffp_procams_closed_form(&procams, 1);
    assert_true(ffp_procams_psnr(&procams) > 25);
    ffp_image_free(&target);
    ffp_procams_free(&procams);
    world_free(&w);
}

// Where the board's point in a projector pixel's ray lies in the camera.
static void true_camera_position(const World *w, int x, int y, real out[2]) {
    const FfpCamera *projector = &w->views[0].projector;
    real ray[3], at[3], origin[3];
    ffp_pixel_ray(projector, (real)x + 0.5F, (real)y + 0.5F, ray);
    for (int k = 0; k < 3; k++) origin[k] = projector->pose[4 * k + 3];
    const real t = -ffp_dot3(origin, tilted) / ffp_dot3(ray, tilted);
    for (int k = 0; k < 3; k++) at[k] = origin[k] + t * ray[k];
    ffp_project(&w->views[0].camera, at, &out[0], &out[1]);
}

static void the_inverse_is_where_geometry_says(void **state) {
    (void)state;
    World w;
    world_new(&w, false);
    FfpProCams procams = procams_of(&w, 1);
    FfpImage inverse = ffp_procams_inverse(&procams, 0, 0);
    double most = 0;
    int count = 0;
    for (int p = 0; p < PATTERN * PATTERN; p++) {
        real truth[2];
        if (!(inverse.data[3 * p + 2] > 0)) continue;
        true_camera_position(&w, p % PATTERN, p / PATTERN, truth);
        most = worse(most, hypot((double)(inverse.data[3 * p] - truth[0]),
                                 (double)(inverse.data[3 * p + 1] - truth[1])));
        count++;
    }
    assert_true(count > PATTERN * PATTERN / 4);
    assert_true(most < 0.4);
    ffp_image_free(&inverse);
    ffp_procams_free(&procams);
    world_free(&w);
}

// A picture just small enough to be drawn at once, and a slightly wider one, which is drawn in strips: what
// both see is the same, across the strips' edges too.
static void strips_show_what_a_whole_picture_does(void **state) {
    (void)state;
    enum { HEIGHT = 1400, WIDTH = 1428, MORE = 8 };
    World w;
    world_new(&w, true);
    const FfpRenderSettings settings = ffp_render_defaults();
    const real eye[3] = {0.3F, -0.6F, 3}, origin[3] = {0, 0, 0};
    FfpView whole = w.views[0], wider = w.views[0];
    whole.camera = wider.camera = look_at(WIDTH, HEIGHT, WIDTH * 1.4, eye, origin);
    wider.camera.width += MORE;
    assert_int_equal(ffp_strip_rows(&whole.camera), HEIGHT);
    assert_true(ffp_strip_rows(&wider.camera) < HEIGHT);
    FfpViewMapStats stats[2];
    FfpImages *one = ffp_view_maps(&w.gaussians, &w.capture, &whole, &settings, &stats[0]),
              *two = ffp_view_maps(&w.gaussians, &w.capture, &wider, &settings, &stats[1]);
    const FfpImage *a = &one->first->image, *b = &two->first->image;
    int apart = 0, there = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const real *p = a->data + 3 * (y * WIDTH + x), *q = b->data + 3 * (y * (WIDTH + MORE) + x);
            there += p[0] >= 0;
            apart += !(fabsf(p[0] - q[0]) < 0.01F && fabsf(p[1] - q[1]) < 0.01F);
        }
    print_message("%d of %d pixels lie elsewhere; round trips %.4f and %.4f\n", apart, there,
                  stats[0].trip.median, stats[1].trip.median);
    assert_true(there > WIDTH * HEIGHT / 4);
    assert_true(apart < there / 10000);
    assert_true(fabs(stats[0].trip.median - stats[1].trip.median) < 1e-3);
    assert_in_range(stats[1].trip.pixels - stats[0].trip.pixels, 0, MORE * HEIGHT);
    ffp_images_free(one);
    ffp_images_free(two);
    world_free(&w);
}

static void pixels_come_back_from_the_projector(void **state) {
    (void)state;
    World w;
    world_new(&w, true);
    FfpProCams procams = procams_of(&w, 1);
    const FfpCamera *camera = &w.views[0].camera, *projector = &w.views[0].projector;
    FfpImage inverse = ffp_procams_inverse(&procams, 0, 0), lit = ffp_procams_lit_depth(&procams, 0, 0);
    const FfpRoundTrip trip = ffp_round_trip(camera, projector, &lit, &inverse);
    print_message("round trip: %d pixels, %d lost, median %.3f, most %.3f\n", trip.pixels, trip.lost,
                  trip.median, trip.most);
    assert_true(trip.pixels > SIDE * SIDE / 4);
    assert_true(trip.within_half > 0.98);
    assert_true(trip.median < 0.1);
    assert_true(trip.lost < trip.pixels / 10);
    for (int p = 0; p < PATTERN * PATTERN; p++) inverse.data[3 * p] += 0.6F; // a wrong map is found out
    ffp_image_free(&lit);
    lit = ffp_procams_lit_depth(&procams, 0, 0);
    assert_true(ffp_round_trip(camera, projector, &lit, &inverse).within_half < 0.1);
    ffp_image_free(&lit);
    ffp_image_free(&inverse);
    ffp_procams_free(&procams);
    world_free(&w);
}

// The board seen by a projector straight above it, and by a camera of half its focal length in its place.
static void light_on_the_board_is_measured(void **state) {
    (void)state;
    World w;
    world_new(&w, false);
    const real origin[3] = {0, 0, 0}, above[3] = {2 * tilted[0], 0, 2 * tilted[2]};
    const FfpCamera projector = look_at(PATTERN, PATTERN, 0.8 * PATTERN, above, origin);
    FfpCamera camera = projector;
    camera.fx /= 2, camera.fy /= 2, camera.cx /= 2, camera.cy /= 2, camera.width /= 2, camera.height /= 2;
    const FfpRenderSettings settings = ffp_render_defaults();
    FfpLitSurface surface = ffp_lit_surface_new(&w.gaussians, &projector, &settings);
    FfpImage density = ffp_image_new(PATTERN, PATTERN, 1);
    ffp_lit_surface_density(&surface, &projector, &camera, &density);
    const int middle = PATTERN / 2 * PATTERN + PATTERN / 2, aside = middle + PATTERN / 4;
    const double cosine = 1 / sqrt(1 + pow(0.25 / 0.8, 2));
    assert_true(fabs((double)surface.depth.data[middle] - 2) < 0.02);
    assert_true(fabs((double)surface.cosine.data[middle] - 1) < 0.01);
    assert_true(fabs((double)surface.cosine.data[aside] - cosine) < 0.01);
    assert_true(fabs((double)surface.resolution.data[middle] - 0.4 * PATTERN) < 0.01 * PATTERN);
    assert_true(fabs((double)surface.resolution.data[aside] - 0.4 * PATTERN) < 0.01 * PATTERN);
    const double fall = (double)(surface.illuminance.data[aside] / surface.illuminance.data[middle]);
    assert_true(fabs(fall - pow(cosine, 3)) < 0.02);
    assert_true(fabs((double)density.data[middle] - 0.25) < 0.005);
    assert_true(fabs((double)density.data[aside] - 0.25) < 0.005);
    assert_true(density.data[0] == 0 && surface.resolution.data[0] == 0); // beside the board
    ffp_image_free(&density);
    ffp_lit_surface_free(&surface);
    world_free(&w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_picture_is_the_renderers),
        cmocka_unit_test(the_gradient_is_that_of_the_loss),
        cmocka_unit_test(compensation_comes_near_and_descent_nearer),
        cmocka_unit_test(scattered_and_spread_light_is_taken_off),
        cmocka_unit_test(shadows_do_not_make_up_for_scattered_light),
        cmocka_unit_test(patterns_are_sharpened_for_the_blur),
        cmocka_unit_test(two_runs_give_the_same_bits),
        cmocka_unit_test(what_cannot_be_reached_is_counted),
        cmocka_unit_test(the_gain_that_light_allows_is_found),
        cmocka_unit_test(projectors_share_where_they_overlap),
        cmocka_unit_test(nothing_is_brighter_where_two_overlap),
        cmocka_unit_test(views_of_one_projector_share_its_pattern),
        cmocka_unit_test(the_inverse_is_where_geometry_says),
        cmocka_unit_test(strips_show_what_a_whole_picture_does),
        cmocka_unit_test(pixels_come_back_from_the_projector),
        cmocka_unit_test(light_on_the_board_is_measured),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
