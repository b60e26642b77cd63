#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "rig/masks/layers.h"
#include "rig/masks/limits.h"
#include "rig/masks/local_mean.h"
#include "rig/masks/place.h"
#include "rig/masks/steps.h"

static const double near_and_far[3] = {0.05, 0.02, 0.008}; // Gaussians, of the picture's longer side
enum { SIDE = 5, AROUND_LEAST = 4, ROUNDS = 200 };         // pixels around one; which must be known
enum { VIEWS_LEAST = 5, VIEWS_MOST = 16, SHARED_LEAST = 3 };

typedef struct Common {
    const FfpCapture *capture;
    int n, views[VIEWS_MOST]; // compared
    FfpLayers *layers[VIEWS_MOST];
    const unsigned char *object; // [height*width] pixels that do not show the stage; NULL: not known
    double noise;
} Common;

static double white_at(const FfpLayers *layers, ptrdiff_t pixel) {
    const real *p = layers->of[1].data + 3 * pixel;
    return ((double)p[0] + (double)p[1] + (double)p[2]) / 3;
}

static bool is_alike(const Common *c, int a, int b, ptrdiff_t pixel) {
    const FfpLayers *one = c->layers[a], *two = c->layers[b];
    double sum = 0;
    for (int k = 0; k < one->n; k++)
        for (int i = 0; i < 3; i++) {
            const double x = (double)one->of[k].data[3 * pixel + i],
                         y = (double)two->of[k].data[3 * pixel + i];
            sum += (x - y) * (x - y) / ffp_layers_variance(c->noise, fmax(x, y), 0);
        }
    return sum < ALIKE * 3 * one->n;
}

// The view whose look at a pixel most others share, and how many do; a brighter one before its shadow.
static int choose(const Common *c, ptrdiff_t pixel, int least, int *shared) {
    int counts[VIEWS_MOST] = {0}, best = -1;
    for (int a = 0; a < c->n; a++)
        for (int b = 0; b < c->n; b++) counts[a] += a == b || is_alike(c, a, b, pixel);
    for (int a = 0; a < c->n; a++) {
        if (counts[a] < least) continue;
        const double here = white_at(c->layers[a], pixel),
                     before = best < 0 ? 0 : white_at(c->layers[best], pixel);
        const bool lit = here > LIT_NOISE * c->noise;
        if (best < 0 || (lit && here > COMMON_BRIGHTER * before) ||
            (counts[a] > counts[best] && !(before > LIT_NOISE * c->noise && before > COMMON_BRIGHTER * here)))
            best = a;
    }
    *shared = best < 0 ? 0 : counts[best];
    return best;
}

// The mean of the views that share a look.
static void take_mean(const Common *c, FfpEmptyStage *stage, int like, int shared, ptrdiff_t pixel) {
    for (int a = 0; a < c->n; a++) {
        if (a != like && !is_alike(c, like, a, pixel)) continue;
        for (int p = 0; p < c->capture->n_patterns; p++) {
            const FfpImage *from = &c->capture->views[c->views[a]].images[p];
            for (int i = 0; stage->images[p].data && i < 3; i++)
                stage->images[p].data[3 * pixel + i] += from->data[3 * pixel + i] / (real)shared;
        }
    }
    stage->known.data[pixel] = 1;
}

// True if a look is much brighter than the stage is known to be at a pixel, which then is in shadow.
static bool is_brighter(const Common *c, const FfpEmptyStage *stage, int like, ptrdiff_t pixel,
                        ptrdiff_t at) {
    const real *white = stage->images[c->capture->white].data + 3 * at,
               *black = stage->images[c->capture->black].data + 3 * at;
    double known = 0;
    for (int i = 0; i < 3; i++) known += (double)(white[i] - black[i]) / 3;
    return white_at(c->layers[like], pixel) > fmax(COMMON_SHADOWED * known, LIT_NOISE * c->noise);
}

// True if a look under white goes on from the known stage around a pixel.
static bool goes_on(const Common *c, const FfpEmptyStage *stage, int like, ptrdiff_t pixel) {
    const FfpImage *white = &stage->images[c->capture->white];
    const int x = (int)(pixel % white->width), y = (int)(pixel / white->width);
    double sum[3] = {0}, n = 0;
    for (int k = 0; k < SIDE * SIDE; k++) {
        const int px = x + k % SIDE - SIDE / 2, py = y + k / SIDE - SIDE / 2;
        if (px < 0 || py < 0 || px >= white->width || py >= white->height) continue;
        const ptrdiff_t at = (ptrdiff_t)py * white->width + px;
        if (!(stage->known.data[at] > 0) || is_brighter(c, stage, like, pixel, at)) continue;
        for (int i = 0; i < 3; i++) sum[i] += (double)white->data[3 * at + i];
        n++;
    }
    for (int i = 0; i < 3 && n > 0; i++) {
        const FfpLayers *of = c->layers[like];
        const double here = (double)of->of[0].data[3 * pixel + i] + (double)of->of[1].data[3 * pixel + i];
        if (fabs(here - sum[i] / n) > c->noise + COMMON_GOES_ON * fmax(here, sum[i] / n)) return false;
    }
    return n >= AROUND_LEAST;
}

// The look that two views share where the stage is not known, or known in shadow alone; -1: none.
static int candidate(const Common *c, const FfpEmptyStage *stage, ptrdiff_t pixel, int *shared) {
    if (c->object && c->object[pixel]) return -1;
    const int like = choose(c, pixel, 2, shared);
    const bool known = stage->known.data[pixel] > 0;
    return like >= 0 && known && !is_brighter(c, stage, like, pixel, pixel) ? -1 : like;
}

static void forget(FfpEmptyStage *stage, int n_patterns, ptrdiff_t pixel) {
    for (int p = 0; p < n_patterns; p++)
        for (int i = 0; stage->images[p].data && i < 3; i++) stage->images[p].data[3 * pixel + i] = 0;
}

// Pixels that only two views show alike are stage where they go on from it.
static void grow(const Common *c, FfpEmptyStage *stage) {
    const ptrdiff_t pixels = (ptrdiff_t)stage->known.width * stage->known.height;
    int *likes = ffp_alloc((size_t)pixels, sizeof *likes),
        *shared = ffp_alloc((size_t)pixels, sizeof *shared);
    unsigned char *found = ffp_alloc((size_t)pixels, 1);
#pragma omp parallel for schedule(static)
    for (ptrdiff_t i = 0; i < pixels; i++) likes[i] = candidate(c, stage, i, &shared[i]);
    for (int added = 1, round = 0; added > 0 && round < ROUNDS; round++) {
        added = 0;
        ffp_cancel_point();
        for (ptrdiff_t i = 0; i < pixels; i++) found[i] = likes[i] >= 0 && goes_on(c, stage, likes[i], i);
        for (ptrdiff_t i = 0; i < pixels; i++) {
            if (!found[i]) continue;
            forget(stage, c->capture->n_patterns, i);
            take_mean(c, stage, likes[i], shared[i], i);
            likes[i] = -1;
            added++;
        }
    }
    ffp_free(likes), ffp_free(shared), ffp_free(found);
}

// Where the stage is not known its pictures get means of what is around, near or farther: for shadows, which
// are compared with what the stage would be.
static void fill_in(FfpImage *image, const unsigned char *known) {
    const ptrdiff_t pixels = (ptrdiff_t)image->width * image->height;
    const double longest = fmax(image->width, image->height);
    for (int k = 0; k < 3; k++) {
        FfpImage means = ffp_local_mean_where(image, known, fmax(longest * near_and_far[k], 1));
        for (ptrdiff_t i = 0; i < pixels; i++)
            for (int c = 0; c < 3 && !known[i] && means.data[4 * i + 3] > COMMON_SURE; c++)
                image->data[3 * i + c] = means.data[4 * i + c];
        ffp_image_free(&means);
    }
}

static void complete(FfpEmptyStage *stage, int n_patterns) {
    const ptrdiff_t pixels = (ptrdiff_t)stage->known.width * stage->known.height;
    unsigned char *known = ffp_alloc((size_t)pixels, 1);
    for (ptrdiff_t i = 0; i < pixels; i++) known[i] = stage->known.data[i] > 0;
    for (int p = 0; p < n_patterns; p++)
        if (stage->images[p].data) fill_in(&stage->images[p], known);
    ffp_free(known);
}

static bool all_have(const FfpCapture *capture, int pattern) {
    for (int v = 0; v < capture->n_views; v++)
        if (!capture->views[v].images[pattern].data) return false;
    return true;
}

static FfpEmptyStage new_stage(const FfpCapture *capture) {
    const FfpCamera *camera = &capture->views[0].camera;
    FfpEmptyStage out = {.images = ffp_alloc((size_t)capture->n_patterns, sizeof *out.images)};
    out.known = ffp_image_new(camera->width, camera->height, 1);
    for (int p = 0; p < capture->n_patterns; p++)
        if (all_have(capture, p)) out.images[p] = ffp_image_new(camera->width, camera->height, 3);
    return out;
}

static Common new_common(const FfpCapture *capture, const FfpEmptyStage *stage) {
    Common c = {.capture = capture, .n = capture->n_views < VIEWS_MOST ? capture->n_views : VIEWS_MOST};
    for (int a = 0; a < c.n; a++) {
        c.views[a] = (int)((int64_t)a * capture->n_views / c.n);
        c.layers[a] = ffp_layers_new(capture, capture->views[c.views[a]].images, stage->images);
    }
    c.noise = ffp_layers_noise(c.layers[0], c.layers[c.n / 2]);
    return c;
}

static FfpCommon find(FfpEmptyStage *stage, const FfpCapture *capture, const unsigned char *object) {
    *stage = new_stage(capture);
    Common c = new_common(capture, stage);
    c.object = object;
    const ptrdiff_t pixels = (ptrdiff_t)stage->known.width * stage->known.height;
    int64_t known = 0, lit = 0;
    ffp_cancel_point();
#pragma omp parallel for schedule(static) reduction(+ : known, lit)
    for (ptrdiff_t i = 0; i < pixels; i++) {
        int shared;
        if (object && object[i]) continue;
        const int like = choose(&c, i, (int)fmax(SHARED_LEAST, ceil(COMMON_SHARE_LEAST * c.n)), &shared);
        if (like < 0) continue;
        take_mean(&c, stage, like, shared, i);
        known++;
        lit += white_at(c.layers[like], i) > LIT_NOISE * c.noise;
    }
    ffp_mask_drop_pieces(&stage->known); // parts of the object that are alike by chance
    grow(&c, stage);
    for (int a = 0; a < c.n; a++) ffp_layers_free(c.layers[a]);
    complete(stage, capture->n_patterns);
    for (ptrdiff_t i = 0; object && i < pixels; i++)
        if (object[i]) stage->known.data[i] = -1;
    return (FfpCommon){.known = (double)known / (double)pixels, .lit = (double)lit / (double)pixels};
}

bool ffp_common_stage(FfpEmptyStage *stage, FfpCommon *found, const FfpCapture *capture) {
    *found = (FfpCommon){0};
    if (capture->n_views < VIEWS_LEAST) return false;
    *found = find(stage, capture, NULL);
    return true;
}

// --- Once more, without the object. ---

bool ffp_common_stage_again(FfpEmptyStage *stage, const FfpCapture *capture) {
    unsigned char *object = ffp_alloc((size_t)stage->known.width * (size_t)stage->known.height, 1);
    const bool again = ffp_place_above(object, capture, stage) >= COMMON_ABOVE_LEAST;
    if (again) {
        ffp_common_stage_free(stage, capture->n_patterns);
        find(stage, capture, object);
    }
    ffp_free(object);
    return again;
}

void ffp_common_stage_free(FfpEmptyStage *stage, int n_patterns) {
    for (int p = 0; stage->images && p < n_patterns; p++) ffp_image_free(&stage->images[p]);
    ffp_free(stage->images);
    ffp_image_free(&stage->known);
    *stage = (FfpEmptyStage){0};
}
