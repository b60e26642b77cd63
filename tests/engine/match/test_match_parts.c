// The parts of matching, each against what can be worked out by hand or by brute force.
#include <math.h>
#include "core/base/rng.h"
#include "core/base/vec.h"
#include "engine/match/blurred.h"
#include "engine/match/enlarge.h"
#include "engine/match/fill.h"
#include "engine/match/labels.h"
#include "engine/match/layout.h"
#include "engine/match/line.h"
#include "engine/match/match.h"
#include "engine/match/projector_rays.h"
#include "engine/match/prune.h"
#include "engine/match/stereo.h"
#include "engine/match/surface.h"
#include "engine/match/sweep.h"
#include "support.h"

static FfpCamera camera_at(real x, real y, real z, int width, int height) {
    return (FfpCamera){width,
                       height,
                       40,
                       44,
                       (real)width / 2 + 1,
                       (real)height / 2 - 2,
                       {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1}};
}

static void test_frame(void **state) {
    (void)state;
    FfpRng rng = ffp_rng(3, 0);
    for (int n = 0; n < 200; n++) {
        real normal[3] = {ffp_rng_normal(&rng), ffp_rng_normal(&rng), ffp_rng_normal(&rng)}, q[4];
        if (n < 6) normal[0] = normal[1] = normal[2] = 0, normal[n / 2] = n % 2 ? 1 : -1;
        if (n == 6) normal[0] = 1e-5F, normal[1] = 0, normal[2] = -1;
        ffp_normalise3(normal);
        ffp_normal_frame(normal, q);
        const real w = q[0], x = q[1], y = q[2], z = q[3];
        const real axis[3] = {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)};
        assert_true(fabsf(w * w + x * x + y * y + z * z - 1) < 1e-5F);
        for (int c = 0; c < 3; c++) assert_true(fabsf(axis[c] - normal[c]) < 1e-4F);
    }
    const real none[3] = {0, 0, 0};
    real q[4];
    ffp_normal_frame(none, q);
    assert_true(q[0] == 1 && q[1] == 0 && q[2] == 0 && q[3] == 0);
}

static void test_line_is_projection(void **state) {
    (void)state;
    const FfpCamera camera = camera_at(0.1F, -0.2F, -3, 33, 29);
    FfpCamera device = camera_at(0.5F, 0.3F, -2, 61, 47);
    const real c = cosf(0.4F), s = sinf(0.4F), turn[9] = {c, 0, s, 0, 1, 0, -s, 0, c};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) device.pose[4 * i + j] = turn[3 * i + j];
    const FfpLine line = ffp_line(&camera, 12.25F, 7.5F, &device);
    for (real z = 1.5F; z < 4; z += 0.5F) {
        real point[3], u = -1, v = -1, x, y;
        ffp_point_at(&camera, 12.25F, 7.5F, z, point);
        assert_true(fabsf(ffp_project(&device, point, &x, &y) - ffp_line_at(&line, z, &u, &v)) < 1e-4F);
        assert_true(fabsf(u - x) < 1e-3F && fabsf(v - y) < 1e-3F);
    }
}

// Two planes with a jump between: each is found on its own side, right up to the edge.
static void test_planes_keep_apart(void **state) {
    (void)state;
    const FfpCamera camera = camera_at(0, 0, 0, 17, 13);
    const FfpPlane left = {0.4F, 0.002F, -0.003F}, right = {0.2F, -0.001F, 0.001F};
    real depth[17 * 13], weight[17 * 13];
    for (int y = 0; y < 13; y++) {
        for (int x = 0; x < 17; x++) {
            const FfpPlane *p = x < 9 ? &left : &right;
            depth[y * 17 + x] = 1 / (p->q0 + p->qx * (real)x + p->qy * (real)y);
            weight[y * 17 + x] = 1;
        }
    }
    FfpSheet sheet = ffp_sheet_new(depth, weight, &camera, 2);
    FfpPlane planes[FFP_MATCH_LANES];
    ffp_fit_planes(planes, &sheet, 1, 6);
    for (int x = 7; x < 11; x++) {
        const FfpPlane fit = planes[x - 1];
        const FfpPlane *p = x < 9 ? &left : &right;
        assert_true(fabsf(fit.qx - p->qx) < 2e-4F && fabsf(fit.qy - p->qy) < 2e-4F);
        assert_true(fabsf(fit.q0 * depth[6 * 17 + x] - 1) < 1e-3F);
        real normal[3], at[3], beside[3];
        ffp_plane_normal(&fit, &camera, (real)x + 0.5F, 6.5F, normal);
        ffp_point_at(&camera, (real)x + 0.5F, 6.5F, depth[6 * 17 + x], at);
        const int step = x < 9 ? -1 : 1;
        ffp_point_at(&camera, (real)(x + step) + 0.5F, 7.5F, depth[7 * 17 + x + step], beside);
        const real way[3] = {beside[0] - at[0], beside[1] - at[1], beside[2] - at[2]};
        assert_true(ffp_dot3(normal, at) < 0); // faces the camera, which is at the origin
        assert_true(fabsf(ffp_dot3(normal, way)) < 0.03F * sqrtf(ffp_dot3(way, way)));
    }
    ffp_sheet_free(&sheet);
    depth[0] = 0;
    memset(weight, 0, sizeof weight); // nobody says anything about his neighbours
    sheet = ffp_sheet_new(depth, weight, &camera, 2);
    ffp_fit_planes(planes, &sheet, 0, 0);
    assert_true(planes[0].q0 == 0);
    assert_true(planes[15].q0 == 1 / depth[15] && planes[15].qx == 0 && planes[15].qy == 0);
    ffp_fit_planes(planes, &sheet, 16, 0);
    assert_true(planes[0].q0 == 1 / depth[16] && planes[1].q0 == 0); // off the picture
    ffp_sheet_free(&sheet);
}

static void test_fill_is_harmonic(void **state) {
    (void)state;
    enum { W = 19, H = 15 };
    real depth[W * H], mask[W * H], range[2 * W * H];
    for (int i = 0; i < W * H; i++) {
        const int x = i % W, y = i / W;
        const bool hole = x > 3 && x < 14 && y > 2 && y < 12;
        mask[i] = y < 14;
        depth[i] =
            hole || y == 14 ? 0 : 3 + 0.1F * (real)x - 0.05F * (real)y; // linear functions are harmonic
        range[2 * i] = 1, range[2 * i + 1] = x < 9 ? 10 : 3.5F;
    }
    real free_depth[W * H];
    memcpy(free_depth, depth, sizeof depth);
    ffp_fill_smoothly(free_depth, mask, NULL, W, H);
    ffp_fill_smoothly(depth, mask, range, W, H);
    for (int i = 0; i < W * H; i++) {
        const int x = i % W, y = i / W;
        const bool hole = x > 3 && x < 14 && y > 2 && y < 12;
        const real linear = mask[i] > 0 ? 3 + 0.1F * (real)x - 0.05F * (real)y : 0;
        assert_true(fabsf(free_depth[i] - linear) < 1e-3F);
        assert_true(fabsf(depth[i] - (hole ? fminf(linear, range[2 * i + 1]) : linear)) < 1e-3F);
    }
    real nothing[6] = {0};
    ffp_fill_smoothly(nothing, NULL, NULL, 3, 2);
    for (int i = 0; i < 6; i++) assert_true(nothing[i] == 0);
}

typedef struct Costs {
    const real *cost, *mask; // [h,w,n], [h,w]
    int w, h, n;
    real small, large; // penalties of a jump by one and by more
} Costs;

// One path at a time, as the recursion is written in the paper.
static real brute_path(const Costs *c, int x, int y, int k, const int way[2]) {
    const int px = x - way[0], py = y - way[1];
    const real own = c->cost[(y * c->w + x) * c->n + k];
    if (px < 0 || py < 0 || px >= c->w || py >= c->h || c->mask[py * c->w + px] <= 0) return own;
    real before[8], least = 1e9F;
    for (int j = 0; j < c->n; j++) {
        before[j] = brute_path(c, px, py, j, way);
        least = fminf(least, before[j]);
    }
    real best = fminf(before[k], least + c->large);
    if (k > 0) best = fminf(best, before[k - 1] + c->small);
    if (k + 1 < c->n) best = fminf(best, before[k + 1] + c->small);
    return own + best - least;
}

// One channel counts, and the neighbour's is x + 10 y hundredths.
static void test_photographs_at_a_plane(void **state) {
    (void)state;
    enum { W = 4, H = 3 };
    FfpStereoCell own[4] = {{0}}, theirs[W * H] = {{0}};
    for (int i = 0; i < W * H; i++) theirs[i][1] = (real)(i % W + 10 * (i / W)) / 100;
    own[0][1] = own[1][1] = own[2][1] = 0.1F;
    // Pixel x 2, y 1.25; behind the neighbour; outside; the first again, and quite unlike.
    const real u0[] = {2, 2, 0.2F, 2}, u1[] = {0.5F, 0.5F, 0, 0.5F}, v0[] = {1.75F, 1.75F, 1.5F, 1.75F},
               v1[4] = {0}, w0[] = {1, -1, 1, 1}, w1[4] = {0};
    const size_t pixel[] = {0, 1, 2, 3};
    const FfpStereoPlane plane = {.count = 4,
                                  .pixel = pixel,
                                  .line = {u0, u1, v0, v1, w0, w1},
                                  .at = 1,
                                  .own = own,
                                  .theirs = theirs,
                                  .weight = {0, 1},
                                  .width = W,
                                  .right = W - 1,
                                  .bottom = H - 1};
    real single[4];
    ffp_stereo_plane(single, &plane);
    assert_float_equal(single[0], (0.145 - 0.1) / 0.1, 1e-5);
    assert_float_equal(single[1], -1, 0);
    assert_float_equal(single[2], -1, 0);
    assert_float_equal(single[3], 1, 1e-5);
}

static void test_semi_global(void **state) {
    (void)state;
    enum { W = 5, H = 4, N = 4 };
    static const int ways[8][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}};
    real cost[W * H * N] = {0}, mask[W * H], shown_cost[W * H * N], total[W * H * N] = {0};
    FfpRng rng = ffp_rng(11, 0);
    for (int i = 0; i < W * H; i++) {
        mask[i] = i == 7 || i == 13 ? 0 : 1;
        for (int k = 0; k < N; k++) cost[i * N + k] = mask[i] > 0 ? ffp_rng_uniform(&rng) : 0;
    }
    const Costs costs = {cost, mask, W, H, N, 0.1F, 0.4F};
    const FfpImage coverage = {.width = W, .height = H, .channels = 1, .data = mask};
    FfpForeground foreground = ffp_foreground_new(&coverage);
    assert_int_equal(foreground.count, W * H - 2);
    for (size_t slot = 0; slot < foreground.count; slot++)
        for (size_t k = 0; k < N; k++) shown_cost[slot * N + k] = cost[foreground.pixel[slot] * N + k];
    ffp_semi_global(total, shown_cost, &foreground, N, &(FfpSteps){.small = 0.1F, .large = 0.4F});
    for (int i = 0; i < W * H; i++) {
        const size_t slot = foreground.slot[i];
        assert_true((slot == FFP_OFF) == (mask[i] <= 0));
        for (int k = 0; slot != FFP_OFF && k < N; k++) {
            real sum = 0;
            for (int d = 0; d < 8; d++) sum += brute_path(&costs, i % W, i / W, k, ways[d]);
            assert_true(fabsf(sum - total[slot * N + (size_t)k]) < 1e-5F);
        }
    }
    ffp_foreground_free(&foreground);
}

// A plane that light falls on from the side: the surface it meets is known where it meets it, and nowhere
// else.
static void test_projector_rays(void **state) {
    (void)state;
    enum { W = 20, H = 16 };
    real depth[W * H], trust[W * H];
    FfpView view = {.camera = camera_at(0, 0, -3, W, H), .projector = camera_at(0.6F, 0, -3, 2 * W, 2 * H)};
    const FfpCapture capture = {.n_views = 1, .views = &view, .radius = 1};
    for (int i = 0; i < W * H; i++)
        depth[i] = 3, trust[i] = i % W < 10 ? 0.5F : 0; // the left half is trusted
    const FfpDepths depths = {&capture, W, H, depth, trust};
    FfpProjectorRays projector_rays = ffp_projector_rays_new(&depths, 0);
    real point[3], u, v;
    ffp_point_at(&view.camera, 5, 8, 3, point);
    assert_true(fabsf(ffp_project(&view.projector, point, &u, &v) - 3) < 1e-4F);
    const FfpDepthBounds lit = ffp_projector_rays_at(&projector_rays, u, v);
    assert_true(fabsf(lit.low - 3) < 1e-3F && fabsf(lit.high - 3) < 1e-3F && lit.trust == 0.5F);
    ffp_point_at(&view.camera, 15, 8, 3, point);
    ffp_project(&view.projector, point, &u, &v);
    assert_true(ffp_projector_rays_at(&projector_rays, u, v).trust == 0);
    assert_true(ffp_projector_rays_at(&projector_rays, -1, v).trust == 0 &&
                ffp_projector_rays_at(&projector_rays, u, 1e6F).trust == 0);
    ffp_projector_rays_free(&projector_rays);
}

// Of forty views on a ring those that are asked are spread around it, the neighbours among them; of a few,
// all.
static void test_asked(void **state) {
    (void)state;
    enum { N = 40 };
    FfpView views[N];
    for (int v = 0; v < N; v++) {
        const real turn = 2 * (real)acos(-1) * (real)v / N;
        views[v] = (FfpView){.camera = camera_at(3 * sinf(turn), 0, 3 * cosf(turn), 20, 16)};
    }
    const FfpCapture few = {.n_views = FFP_ASKED, .views = views}, many = {.n_views = N, .views = views};
    const FfpAsked all = ffp_asked(&few, 5), some = ffp_asked(&many, 5);
    assert_int_equal(all.count, FFP_ASKED);
    assert_int_equal(some.count, FFP_ASKED);
    int near = 0, far = 0;
    for (int k = 0; k < FFP_ASKED; k++) {
        assert_int_equal(all.view[k], k);
        assert_true(k == 0 || some.view[k] > some.view[k - 1]);
        near += some.view[k] >= 4 && some.view[k] <= 6;
        far += some.view[k] >= 20 && some.view[k] <= 30;
    }
    assert_true(near >= 2 && near <= 3 && far >= 3 && far <= 6);
    assert_true(some.view[0] <= 5 && some.view[FFP_ASKED - 1] < N);
}

// A splat on a matched plane or behind it stays; one before it, or off the silhouette, loses its opacity.
static void test_refute(void **state) {
    (void)state;
    enum { W = 20, H = 16 };
    real footprint[W * H], trust[W * H], coverage[W * H], centre[5][3],
        opacity[5] = {0.9F, 0.9F, 0.9F, 0.9F, 0.9F};
    const int64_t pixel[5] = {0, 0, 0, 0, 0};
    FfpView view = {.camera = camera_at(0, 0, -3, W, H), .projector = camera_at(0.6F, 0, -3, 2 * W, 2 * H)};
    view.coverage = (FfpImage){.width = W, .height = H, .channels = 1, .data = coverage};
    const FfpCapture capture = {.n_views = 1, .views = &view, .radius = 1};
    for (int i = 0; i < W * H; i++) {
        coverage[i] = i % W < 16;
        trust[i] = i % W < 10 ? 0.5F : 0;
        footprint[i] = coverage[i] > 0 ? 3 / view.camera.fx : 0;
    }
    const FfpInitialisation start = {
        .views = 1, .width = W, .height = H, .confidence = trust, .footprint = footprint};
    static const real place[5][2] = {{5, 3}, {5, 3.5F}, {5, 2.6F}, {18, 3}, {15, 2.9F}};
    for (int i = 0; i < 5; i++) ffp_point_at(&view.camera, place[i][0], 8, place[i][1], centre[i]);
    assert_int_equal(ffp_prune_contradicted(opacity, centre[0], pixel, 5, &capture, &start), 2);
    static const bool stays[5] = {true, true, false, false, true};
    for (int i = 0; i < 5; i++) assert_true(opacity[i] == (stays[i] ? 0.9F : 0));
    // By silhouettes alone, of two views.
    FfpView both[2] = {view, view};
    const FfpCapture seen_twice = {.n_views = 2, .views = both, .radius = 1};
    for (int i = 0; i < 5; i++) opacity[i] = 0.9F;
    assert_int_equal(ffp_prune_off_silhouettes(opacity, centre[0], 5, &capture), 0);
    assert_int_equal(ffp_prune_off_silhouettes(opacity, centre[0], 5, &seen_twice), 1);
    for (int i = 0; i < 5; i++) assert_true(opacity[i] == (i == 3 ? 0 : 0.9F));
    assert_int_equal(ffp_prune_off_silhouettes(opacity, centre[0], 5, &seen_twice), 0);
}

// Two for three reduced pixels a side: the middle of every third pixel lies on the line between two reduced
// ones, and a third one's share of the blend there is exactly 0. A pixel beside a jump of depth that saw the
// pattern as the surface beyond has it gets that surface's plane, though nothing of it is in the blend.
static void test_a_surface_without_a_share(void **state) {
    (void)state;
    enum { SMALL = 4, LARGE = 6, PIXELS = LARGE * LARGE };
    const real near = 2, far = 3;
    real ramp[3 * 64 * 64], confidence[SMALL * SMALL], lit[SMALL * SMALL], footprint[SMALL * SMALL];
    real seen_lit[PIXELS], coverage[PIXELS], ratio[3 * PIXELS], weight[3 * PIXELS];
    real depth[PIXELS], normal[3 * PIXELS], sure[PIXELS];
    int asked = 0, first = 0;
    for (int i = 0; i < 3 * 64 * 64; i++) ramp[i] = (real)(i / 3 % 64) / 64;
    FfpPattern pattern = {.image = {64, 64, 3, ramp}};
    const FfpCapture patterns = {.n_patterns = 1, .patterns = &pattern};
    FfpBlurred blurred = ffp_blurred_new(&patterns, &first, 1, 1);
    FfpView view = {.camera = camera_at(0, 0, 0, LARGE, LARGE), .projector = camera_at(0.6F, 0, 0, 64, 64)};
    view.coverage = (FfpImage){LARGE, LARGE, 1, coverage};
    FfpView less = {.camera = {SMALL, SMALL, 40, 44, 2, 2, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}};
    FfpReduced reduced = {.capture = {.n_views = 1, .views = &less},
                          .start = {.views = 1,
                                    .width = SMALL,
                                    .height = SMALL,
                                    .confidence = confidence,
                                    .lit = lit,
                                    .footprint = footprint}};
    for (int i = 0; i < SMALL * SMALL; i++)
        confidence[i] = lit[i] = 1, footprint[i] = (i % SMALL < 2 ? near : far) / less.camera.fx;
    for (int i = 0; i < PIXELS; i++) {
        real point[3], u, v; // all of the picture shows the surface that is farther away
        ffp_point_at(&view.camera, (real)(i % LARGE) + 0.5F, (real)(i / LARGE) + 0.5F, far, point);
        ffp_project(&view.projector, point, &u, &v);
        seen_lit[i] = coverage[i] = 1;
        for (int c = 0; c < 3; c++) ratio[3 * i + c] = (u - 0.5F) / 64, weight[3 * i + c] = 1;
    }
    const FfpObservation seen = {LARGE, LARGE, 1, &asked, ratio, weight, seen_lit};
    ffp_enlarge(&(FfpEnlarged){depth, normal, sure}, &reduced, &view, 0, &seen, &blurred);
    for (int i = 0; i < PIXELS; i++) {
        const real *n = normal + 3 * i, expected = i % LARGE < 1 ? near : far; // 0 has no such neighbour
        assert_true(fabsf(depth[i] - expected) < 1e-4F);                       // none is NaN
        assert_true(fabsf(ffp_dot3(n, n) - 1) < 1e-4F && fabsf(n[2] + 1) < 1e-4F);
    }
    ffp_blurred_free(&blurred);
}

// A bright half and a dimmer one. One pixel of the bright half has label 1, and all others lean towards label
// 0: the whole half follows it, and nothing of the other. In the dark it stands alone.
static void test_labels_of_one_colour(void **state) {
    (void)state;
    enum { W = 24, H = 12, AREA = W * H, LABELS = 2 };
    static real colour[AREA * 3], cost[AREA * LABELS], total[AREA * LABELS], mask[AREA];
    for (int i = 0; i < AREA; i++) mask[i] = 1;
    const FfpImage coverage = {.width = W, .height = H, .channels = 1, .data = mask};
    FfpForeground foreground = ffp_foreground_new(&coverage);
    for (int dark = 0; dark < 2; dark++) {
        for (int i = 0; i < AREA * 3; i++) colour[i] = dark ? 0 : i / 3 % W < W / 2 ? 0.5F : 0.3F;
        for (int i = 0; i < AREA; i++) cost[i * LABELS] = 0, cost[i * LABELS + 1] = 0.05F;
        for (int i = W / 4; i < AREA; i += W) cost[i * LABELS] = 4, cost[i * LABELS + 1] = 0;
        ffp_labels_total(total, cost, &foreground, LABELS, colour);
        for (int i = 0; i < AREA; i++) {
            const bool one = total[i * LABELS + 1] < total[i * LABELS];
            const int away = abs(i % W - W / 4);
            assert_true(dark ? (away > 0 || one) && (away < 6 || !one) : one == (i % W < W / 2));
        }
    }
    ffp_foreground_free(&foreground);
}

// A panel before a wall in the dark, with a place that no pattern reaches. Two views from afar have it
// in two pixels, where those around tell; a close one has 14, and would put their middle on the wall, which
// is larger, if the others' labels were not heard.
static void test_layout_asks_views(void **state) {
    (void)state;
    enum { N = 3, W = 64, H = 64, AREA = W * H };
    const real panel = 3, wall = 4, half = 0.45F, unlit = 0.06F;
    static real depth[N * AREA], trust[N * AREA], lit[N * AREA], filled[N * AREA], found[N * AREA];
    static real black[N * AREA * 3], normals[N * AREA * 3], coverage[AREA];
    FfpView views[N];
    FfpImage images[N];
    const FfpCapture capture = {.n_views = N, .views = views, .radius = 1, .scene = true};
    for (int i = 0; i < N * AREA * 3; i++) black[i] = 0, normals[i] = i % 3 == 2 ? -1 : 0;
    for (int i = 0; i < AREA; i++) coverage[i] = 1;
    for (int v = 0; v < N; v++) {
        const real focal = v == 0 ? 350 : 50;
        const FfpCamera camera = {
            W, H, focal, focal, W / 2, H / 2, {1, 0, 0, 0.1F * (real)v, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
        images[v] = (FfpImage){W, H, 3, black + (size_t)v * AREA * 3};
        views[v] =
            (FfpView){.camera = camera, .projector = camera, .images = &images[v], .near = 1, .far = 9};
        views[v].coverage = (FfpImage){W, H, 1, coverage};
        for (int i = 0; i < AREA; i++) {
            real at[3];
            ffp_point_at(&camera, (real)(i % W) + 0.5F, (real)(i / W) + 0.5F, panel, at);
            const bool on = fabsf(at[0]) < half && fabsf(at[1]) < half;
            const bool dark = fabsf(at[0]) < unlit && fabsf(at[1]) < unlit;
            const size_t p = (size_t)v * AREA + (size_t)i;
            depth[p] = on ? panel : wall;
            trust[p] = lit[p] = dark ? 0 : 1;
            filled[p] = dark ? 6 : depth[p];
        }
    }
    const FfpDepths depths = {&capture, W, H, depth, trust};
    ffp_layout_depths(found, &depths, normals, filled, lit);
    for (int i = 0; i < N * AREA; i++) assert_true(fabsf(found[i] - depth[i]) < 0.02F);
}

// A wall and, below the cameras, a floor that patterns reach only far behind: the dark part in front lies on
// the floor too, since what the wall would make of it is below the floor.
static void test_nothing_lies_below_a_floor(void **state) {
    (void)state;
    enum { N = 3, W = 48, H = 64, AREA = W * H };
    const real wall = 4, floor = 1, lit_from = 3;
    static real depth[N * AREA], trust[N * AREA], lit[N * AREA], filled[N * AREA], found[N * AREA];
    static real black[N * AREA * 3], normals[N * AREA * 3], coverage[AREA];
    FfpView views[N];
    FfpImage images[N];
    const FfpCapture capture = {.n_views = N, .views = views, .radius = 1, .scene = true};
    for (int i = 0; i < AREA; i++) coverage[i] = 1;
    for (int v = 0; v < N; v++) {
        const FfpCamera camera = {
            W, H, 50, 50, W / 2, H / 2, {1, 0, 0, 0.1F * (real)v, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
        images[v] = (FfpImage){W, H, 3, black + (size_t)v * AREA * 3};
        views[v] =
            (FfpView){.camera = camera, .projector = camera, .images = &images[v], .near = 1, .far = 9};
        views[v].coverage = (FfpImage){W, H, 1, coverage};
        for (int i = 0; i < AREA; i++) {
            const size_t p = (size_t)v * AREA + (size_t)i;
            const real down = ((real)(i / W) + 0.5F - H / 2) / 50, to_floor = down > 0 ? floor / down : 9;
            const bool below = to_floor < wall;
            depth[p] = below ? to_floor : wall;
            trust[p] = lit[p] = depth[p] > lit_from;
            filled[p] = trust[p] > 0 ? depth[p] : wall;
            normals[3 * p + (below ? 1 : 2)] = -1;
        }
    }
    const FfpDepths depths = {&capture, W, H, depth, trust};
    ffp_layout_depths(found, &depths, normals, filled, lit);
    for (int i = 0; i < N * AREA; i++) assert_true(fabsf(found[i] - depth[i]) < 0.02F);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_frame),
                                       cmocka_unit_test(test_line_is_projection),
                                       cmocka_unit_test(test_planes_keep_apart),
                                       cmocka_unit_test(test_fill_is_harmonic),
                                       cmocka_unit_test(test_photographs_at_a_plane),
                                       cmocka_unit_test(test_semi_global),
                                       cmocka_unit_test(test_projector_rays),
                                       cmocka_unit_test(test_asked),
                                       cmocka_unit_test(test_refute),
                                       cmocka_unit_test(test_a_surface_without_a_share),
                                       cmocka_unit_test(test_labels_of_one_colour),
                                       cmocka_unit_test(test_layout_asks_views),
                                       cmocka_unit_test(test_nothing_lies_below_a_floor)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
