#include "rig/import/soft_edges.h"
#include <tgmath.h>
#include "core/base/alloc.h"
#include "rig/import/local_mean.h"

#define BAND 2        // pixels on either side of an outline
#define SIGMA 1.5     // pixels over which object and stage are averaged
#define RELATIVE 0.05 // of the light: texture and noise
#define UNEVEN 0.3    // of the light: what differs from place to place
#define CONTRAST 8    // standard deviations between object and stage that make shares sure
#define INSIDE 0.3    // share that pixels have at least that are not at the outline itself
#define SHARE_LEAST 0.06
#define BRIGHTEST 1.3 // of the stage near the object over the empty one

typedef struct Light {              // local means of one picture, 4 channels
    FfpImage object, around, stage; // the object, the background around it, the stage there
} Light;

typedef struct Edge {
    int width, height, n;
    unsigned char *inner, *outer, *deep; // [height*width] away from the outline on either side; not at it
    Light *lights;                       // [n] of each pattern; empty where view or stage lack its picture
} Edge;

static unsigned char *marks_of(const FfpImage *mask, bool of_object) {
    const ptrdiff_t pixels = (ptrdiff_t)mask->width * mask->height;
    unsigned char *out = ffp_alloc((size_t)pixels, 1);
    for (ptrdiff_t i = 0; i < pixels; i++) out[i] = (mask->data[i] >= 0.5F) == of_object;
    return out;
}

static Edge edge_of(const FfpCapture *capture, const FfpView *view, const FfpEmptyStage *stage) {
    const FfpImage *mask = &view->coverage;
    Edge e = {.width = mask->width, .height = mask->height, .n = capture->n_patterns};
    e.inner = marks_of(mask, true), e.outer = marks_of(mask, false), e.deep = marks_of(mask, true);
    ffp_marks_shrink(e.inner, e.width, e.height, BAND);
    ffp_marks_shrink(e.outer, e.width, e.height, BAND);
    ffp_marks_shrink(e.deep, e.width, e.height, 1);
    e.lights = ffp_alloc((size_t)e.n, sizeof *e.lights);
    for (int p = 0; p < e.n; p++) {
        if (!view->images[p].data || !stage->images[p].data) continue;
        e.lights[p] = (Light){ffp_local_mean_where(&view->images[p], e.inner, SIGMA),
                              ffp_local_mean_where(&view->images[p], e.outer, SIGMA),
                              ffp_local_mean_where(&stage->images[p], e.outer, SIGMA)};
    }
    return e;
}

static void free_edge(Edge *e) {
    ffp_free(e->inner), ffp_free(e->outer), ffp_free(e->deep);
    for (int p = 0; p < e->n; p++) {
        ffp_image_free(&e->lights[p].object);
        ffp_image_free(&e->lights[p].around);
        ffp_image_free(&e->lights[p].stage);
    }
    ffp_free(e->lights);
}

// The stage's light at a pixel, as bright as it is around.
static double behind(const Light *light, const FfpImage *stage, ptrdiff_t pixel, int c) {
    const double then = (double)light->stage.data[4 * pixel + c],
                 now = (double)light->around.data[4 * pixel + c];
    return (double)stage->data[3 * pixel + c] * fmin(fmax(now / fmax(then, 1e-4), 0), BRIGHTEST);
}

// A pixel's share, and how sure it is, from 0 to 1.
static double share_of(const Edge *e, const FfpView *view, const FfpEmptyStage *stage, double noise,
                       ptrdiff_t pixel, double *sure) {
    double across = 0, square = 0, contrast = 0;
    *sure = 0;
    for (int k = 0; k < 3 * e->n; k++) {
        const Light *light = &e->lights[k / 3];
        const int c = k % 3;
        if (!light->object.data) continue;
        if (!(light->object.data[4 * pixel + 3] > 1e-4F) || !(light->around.data[4 * pixel + 3] > 1e-4F))
            return 0;
        const double object = (double)light->object.data[4 * pixel + c],
                     back = behind(light, &stage->images[k / 3], pixel, c);
        const double here = (double)view->images[k / 3].data[3 * pixel + c], most = fmax(object, back);
        const double s = noise * noise + pow(UNEVEN * most, 2);
        across += (here - back) * (object - back) / s, square += pow(object - back, 2) / s;
        contrast += pow(object - back, 2) / (noise * noise + pow(RELATIVE * most, 2));
    }
    *sure = fmin(fmax(sqrt(contrast) / CONTRAST - 0.5, 0), 1);
    const double share = square > 0 ? fmin(fmax(across / square, 0), 1) : 0;
    return e->deep[pixel] ? fmax(share, INSIDE) : share;
}

// Takes the stage's share out of a picture: what is left is the object's own light, within what it has
// nearby.
static void take_out(const Light *light, const FfpImage *mask, const FfpImage *stage, FfpImage *picture) {
    for (ptrdiff_t i = 0; i < (ptrdiff_t)mask->width * mask->height; i++) {
        const double share = (double)mask->data[i];
        if (!(share > 0) || share >= 1) continue;
        for (int c = 0; c < 3; c++) {
            const double back = behind(light, stage, i, c),
                         own = ((double)picture->data[3 * i + c] - (1 - share) * back) / share;
            const double most =
                fmax(2 * (double)light->object.data[4 * i + c], (double)picture->data[3 * i + c]);
            picture->data[3 * i + c] = (real)fmin(fmax(own, 0), most);
        }
    }
}

void ffp_soften_edges(const FfpCapture *capture, FfpView *view, const FfpEmptyStage *stage, double noise) {
    FfpImage *mask = &view->coverage;
    Edge e = edge_of(capture, view, stage);
    for (ptrdiff_t i = 0; i < (ptrdiff_t)e.width * e.height; i++) {
        double sure;
        if (e.inner[i] || e.outer[i] || (stage->known.data && !(stage->known.data[i] > 0))) continue;
        const double share = share_of(&e, view, stage, noise, i, &sure);
        const double mixed = sure * share + (1 - sure) * (double)mask->data[i];
        mask->data[i] = (real)(mixed < SHARE_LEAST ? 0 : mixed > 1 - SHARE_LEAST ? 1 : mixed);
    }
    for (int p = 0; p < e.n; p++)
        if (e.lights[p].object.data) take_out(&e.lights[p], mask, &stage->images[p], &view->images[p]);
    free_edge(&e);
}
