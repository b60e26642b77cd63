#include "rig/import/soft_edges.h"
#include <tgmath.h>
#include "core/base/alloc.h"
#include "rig/import/local_mean.h"

#define BAND 2        // pixels on either side of an outline
#define SIGMA 1.5     // pixels over which object and stage are averaged
#define RELATIVE 0.05 // of the light: texture and noise
#define CONTRAST 8    // standard deviations between object and stage that make shares sure
#define INSIDE 0.3    // share that pixels have at least that are not at the outline itself
#define SHARE_LEAST 0.06
#define BRIGHTEST 1.3 // of the stage near the object over the empty one

typedef struct Edge {
    int width, height;
    unsigned char *inner, *outer, *deep; // [height*width] away from the outline on either side; not at it
    FfpImage object, around, stage;      // under white, 4 channels: the object, the background, the stage
} Edge;

static unsigned char *marks_of(const FfpImage *mask, bool of_object) {
    const ptrdiff_t pixels = (ptrdiff_t)mask->width * mask->height;
    unsigned char *out = ffp_alloc((size_t)pixels, 1);
    for (ptrdiff_t i = 0; i < pixels; i++) out[i] = (mask->data[i] >= 0.5F) == of_object;
    return out;
}

static Edge edge_of(const FfpImage *mask, const FfpImage *white, const FfpImage *stage) {
    Edge e = {.width = mask->width, .height = mask->height};
    e.inner = marks_of(mask, true), e.outer = marks_of(mask, false), e.deep = marks_of(mask, true);
    ffp_marks_shrink(e.inner, e.width, e.height, BAND);
    ffp_marks_shrink(e.outer, e.width, e.height, BAND);
    ffp_marks_shrink(e.deep, e.width, e.height, 1);
    e.object = ffp_local_mean_where(white, e.inner, SIGMA);
    e.around = ffp_local_mean_where(white, e.outer, SIGMA);
    e.stage = ffp_local_mean_where(stage, e.outer, SIGMA);
    return e;
}

static void free_edge(Edge *e) {
    ffp_free(e->inner), ffp_free(e->outer), ffp_free(e->deep);
    ffp_image_free(&e->object), ffp_image_free(&e->around), ffp_image_free(&e->stage);
}

// The stage's light at a pixel, as bright as it is around.
static double behind(const FfpImage *around, const FfpImage *before, const FfpImage *stage, ptrdiff_t pixel,
                     int c) {
    const double then = (double)before->data[4 * pixel + c], now = (double)around->data[4 * pixel + c];
    return (double)stage->data[3 * pixel + c] * fmin(fmax(now / fmax(then, 1e-4), 0), BRIGHTEST);
}

// A pixel's share, and how sure it is, from 0 to 1.
static double share_of(const Edge *e, const FfpImage *white, const FfpImage *stage, double noise,
                       ptrdiff_t pixel, double *sure) {
    double across = 0, square = 0;
    *sure = 0;
    if (!(e->object.data[4 * pixel + 3] > 1e-4F) || !(e->around.data[4 * pixel + 3] > 1e-4F)) return 0;
    for (int c = 0; c < 3; c++) {
        const double object = (double)e->object.data[4 * pixel + c],
                     back = behind(&e->around, &e->stage, stage, pixel, c);
        const double here = (double)white->data[3 * pixel + c];
        const double s = noise * noise + pow(RELATIVE * fmax(object, back), 2);
        across += (here - back) * (object - back) / s, square += pow(object - back, 2) / s;
    }
    *sure = fmin(fmax(sqrt(square) / CONTRAST - 0.5, 0), 1);
    const double share = square > 0 ? fmin(fmax(across / square, 0), 1) : 0;
    return e->deep[pixel] ? fmax(share, INSIDE) : share;
}

// Takes the stage's share out of a picture: what is left is the object's own light, within what it has
// nearby.
static void take_out(const Edge *e, const FfpImage *mask, const FfpImage *stage, FfpImage *picture) {
    FfpImage object = ffp_local_mean_where(picture, e->inner, SIGMA);
    FfpImage around = ffp_local_mean_where(picture, e->outer, SIGMA),
             before = ffp_local_mean_where(stage, e->outer, SIGMA);
    for (ptrdiff_t i = 0; i < (ptrdiff_t)e->width * e->height; i++) {
        const double share = (double)mask->data[i];
        if (!(share > 0) || share >= 1) continue;
        for (int c = 0; c < 3; c++) {
            const double back = behind(&around, &before, stage, i, c),
                         own = ((double)picture->data[3 * i + c] - (1 - share) * back) / share;
            const double most = fmax(2 * (double)object.data[4 * i + c], (double)picture->data[3 * i + c]);
            picture->data[3 * i + c] = (real)fmin(fmax(own, 0), most);
        }
    }
    ffp_image_free(&object), ffp_image_free(&around), ffp_image_free(&before);
}

void ffp_soften_edges(const FfpCapture *capture, FfpView *view, const FfpEmptyStage *stage, double noise) {
    FfpImage *mask = &view->coverage;
    const FfpImage *white = &view->images[capture->white], *empty = &stage->images[capture->white];
    Edge e = edge_of(mask, white, empty);
    for (ptrdiff_t i = 0; i < (ptrdiff_t)e.width * e.height; i++) {
        double sure;
        if (e.inner[i] || e.outer[i] || (stage->known.data && !(stage->known.data[i] > 0))) continue;
        const double share = share_of(&e, white, empty, noise, i, &sure);
        const double mixed = sure * share + (1 - sure) * (double)mask->data[i];
        mask->data[i] = (real)(mixed < SHARE_LEAST ? 0 : mixed > 1 - SHARE_LEAST ? 1 : mixed);
    }
    for (int p = 0; p < capture->n_patterns; p++)
        if (view->images[p].data && stage->images[p].data)
            take_out(&e, mask, &stage->images[p], &view->images[p]);
    free_edge(&e);
}
