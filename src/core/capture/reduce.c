// A capture whose pictures are smaller, as cameras with fewer pixels would have taken them.
#include "core/capture/reduce.h"
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/capture/manifest.h"

static void reduce_camera(FfpCamera *camera, int width, int height) {
    const real x = (real)width / (real)camera->width, y = (real)height / (real)camera->height;
    camera->fx *= x;
    camera->cx *= x;
    camera->fy *= y;
    camera->cy *= y;
    camera->width = width;
    camera->height = height;
}

typedef struct Photograph {
    const FfpImage *shown, *coverage;
} Photograph;

// Coverage times the object's own linear radiance.
static void row_of_light(void *context, int y, real *row) {
    const Photograph *photograph = context;
    const size_t width = (size_t)photograph->shown->width, first = (size_t)y * width;
    memset(row, 0, 3 * width * sizeof *row);
    for (size_t x = 0; x < width; x++) {
        const real share = photograph->coverage->data[first + x];
        if (share <= 0) continue;
        ffp_own_radiance(row + 3 * x, photograph->shown->data + 3 * (first + x), share);
        for (int c = 0; c < 3; c++) row[3 * x + c] *= share;
    }
}

// Picture over black -> coverage times the object's own linear radiance, averaged -> picture over black.
static FfpImage reduce_photograph(const FfpImage *shown, const FfpImage *coverage,
                                  const FfpImage *coverage_out) {
    if (coverage_out->width == shown->width && coverage_out->height == shown->height)
        return ffp_image_copy(shown);
    const size_t pixels_out = (size_t)coverage_out->width * (size_t)coverage_out->height;
    Photograph photograph = {shown, coverage};
    const FfpRows rows = {shown->width, shown->height, 3, row_of_light, &photograph};
    FfpImage out = ffp_image_resize_rows(&rows, coverage_out->width, coverage_out->height);
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < pixels_out; i++)
        ffp_shown_radiance(out.data + 3 * i, out.data + 3 * i, coverage_out->data[i]);
    return out;
}

// Pixels of a side that hold a frame's.
static int frame_side(int frame, int side, int side_out) {
    return frame == side ? 0 : (int)ceil((double)frame * side_out / side);
}

#define CENTRED                                                                                              \
    0.2           // of a reduced pixel: how far the mean of the pixels that are known may lie off its centre
#define KNOWN 0.5 // of a reduced pixel's, at least

typedef struct Mean { // of a reduced pixel's correspondences
    double weight, known, x, y, u, v, u_low, u_high, v_low, v_high;
} Mean;

static void add_known(Mean *mean, const real *p, double x, double y) {
    mean->weight++;
    if (!(p[2] > 0)) return;
    const double u = (double)p[0], v = (double)p[1];
    if (!(mean->known > 0)) {
        mean->u_low = mean->u_high = u;
        mean->v_low = mean->v_high = v;
    }
    mean->known++;
    mean->x += x;
    mean->y += y;
    mean->u += u;
    mean->v += v;
    mean->u_low = fmin(mean->u_low, u);
    mean->u_high = fmax(mean->u_high, u);
    mean->v_low = fmin(mean->v_low, v);
    mean->v_high = fmax(mean->v_high, v);
}

// Positions are means over each pixel's area where they are known in most of it, evenly around its centre,
// and of one surface, which spreads over no more than `spread` pixels of the projector.
static FfpImage reduce_correspondence(const FfpImage *map, int width, int height, double spread) {
    if (!map->data) return (FfpImage){0};
    if (width == map->width && height == map->height) return ffp_image_copy(map);
    FfpImage out = ffp_image_new(width, height, 3);
    const double across = (double)map->width / width, down = (double)map->height / height;
#pragma omp parallel for schedule(static)
    for (int j = 0; j < height; j++)
        for (int i = 0; i < width; i++) {
            Mean mean = {0};
            for (int y = (int)ceil(j * down - 0.5); y < map->height && y + 0.5 < (j + 1) * down; y++)
                for (int x = (int)ceil(i * across - 0.5); x < map->width && x + 0.5 < (i + 1) * across; x++)
                    add_known(&mean, map->data + 3 * ((size_t)y * (size_t)map->width + (size_t)x),
                              (x + 0.5) / across - i - 0.5, (y + 0.5) / down - j - 0.5);
            if (!(mean.known > 0) || mean.known < KNOWN * mean.weight) continue;
            const bool even = fabs(mean.x) <= CENTRED * mean.known && fabs(mean.y) <= CENTRED * mean.known;
            if (!even || mean.u_high - mean.u_low > spread || mean.v_high - mean.v_low > spread) continue;
            real *p = out.data + 3 * ((size_t)j * (size_t)width + (size_t)i);
            p[0] = (real)(mean.u / mean.known), p[1] = (real)(mean.v / mean.known), p[2] = 1;
        }
    return out;
}

#define SPREAD 4 // times what a reduced pixel spans in the projector if both stood at the same place

FfpView ffp_view_reduced(const FfpView *view, int n_patterns, const int *patterns, int n, int width,
                         int height) {
    FfpView out = {
        .camera = view->camera, .projector = view->projector, .near = view->near, .far = view->far};
    memcpy(out.id, view->id, sizeof out.id);
    reduce_camera(&out.camera, width, height);
    out.frame_width = frame_side(ffp_frame_width(view), view->camera.width, width);
    out.frame_height = frame_side(ffp_frame_height(view), view->camera.height, height);
    if (view->coverage.data) out.coverage = ffp_image_resize(&view->coverage, width, height);
    const real spread =
        SPREAD * fmax(view->projector.fx, view->projector.fy) / fmin(out.camera.fx, out.camera.fy);
    out.correspondence = reduce_correspondence(&view->correspondence, width, height, (double)fmax(spread, 2));
    out.images = ffp_alloc((size_t)n_patterns, sizeof *out.images);
    for (int k = 0; k < n && view->coverage.data; k++) { // none: devices alone, without photographs
        FfpImage *image = &out.images[patterns[k]];
        if (view->images[patterns[k]].data && !image->data)
            *image = reduce_photograph(&view->images[patterns[k]], &view->coverage, &out.coverage);
    }
    return out;
}

void ffp_view_reduced_free(FfpView *view, int n_patterns) {
    ffp_image_free(&view->coverage);
    ffp_image_free(&view->correspondence);
    for (int p = 0; view->images && p < n_patterns; p++) ffp_image_free(&view->images[p]);
    ffp_free(view->images);
    view->images = NULL;
}

FfpCapture ffp_capture_reduced(const FfpCapture *capture, int views, const int *patterns, int n, int width,
                               int height) {
    FfpCapture out = *capture;
    out.n_views = views;
    out.views = ffp_alloc((size_t)views, sizeof *out.views);
    for (int v = 0; v < views; v++)
        out.views[v] = ffp_view_reduced(&capture->views[v], capture->n_patterns, patterns, n, width, height);
    return out;
}

int ffp_capture_widest(const FfpCapture *capture) {
    int widest = 0;
    for (int v = 0; v < capture->n_views; v++)
        widest = capture->views[v].camera.width > widest ? capture->views[v].camera.width : widest;
    return widest;
}

FfpCapture ffp_capture_narrowed(const FfpCapture *capture, int width) {
    FfpCapture out = *capture;
    int all[FFP_PATTERNS_MAX];
    const double scale = (double)width / ffp_capture_widest(capture);
    for (int p = 0; p < capture->n_patterns; p++) all[p] = p;
    out.views = ffp_alloc((size_t)capture->n_views, sizeof *out.views);
    for (int v = 0; v < capture->n_views; v++) {
        const FfpCamera *camera = &capture->views[v].camera;
        out.views[v] = ffp_view_reduced(&capture->views[v], capture->n_patterns, all, capture->n_patterns,
                                        (int)fmax(FFP_CAMERA_SIDE_MIN, round(scale * camera->width)),
                                        (int)fmax(FFP_CAMERA_SIDE_MIN, round(scale * camera->height)));
    }
    return out;
}

void ffp_capture_reduced_free(FfpCapture *reduced) {
    for (int v = 0; v < reduced->n_views; v++) ffp_view_reduced_free(&reduced->views[v], reduced->n_patterns);
    ffp_free(reduced->views);
    reduced->views = NULL;
    reduced->n_views = 0;
}
