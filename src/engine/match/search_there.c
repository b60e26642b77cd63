#include "engine/match/search_there.h"
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/device.h"
#include "engine/match/matching.h"
#include "engine/match/table.h"

typedef struct Searched { // of a view, until it is read back; the device's
    real *depth, *confidence;
    unsigned char *inside;
} Searched;

bool ffp_can_search_there(const FfpCapture *capture, const FfpMatchSettings *settings) {
    bool can = settings->device && !capture->scene && settings->coarse_steps <= FFP_SEARCH_PLANES_MAX;
    for (int v = 0; v < capture->n_views; v++) can &= !capture->views[v].correspondence.data;
    return can;
}

static FfpForeground foreground_uploaded(const FfpForeground *host) {
    FfpForeground there = *host;
    there.pixel = ffp_memory_uploaded(host->pixel, host->count, sizeof *host->pixel);
    there.slot =
        ffp_memory_uploaded(host->slot, (size_t)host->width * (size_t)host->height, sizeof *host->slot);
    return there;
}

static FfpObservation observation_uploaded(const FfpObservation *host) {
    FfpObservation there = *host;
    const size_t area = (size_t)host->width * (size_t)host->height;
    there.asked = ffp_memory_uploaded(host->asked, (size_t)host->count, sizeof *host->asked);
    there.ratio = ffp_memory_uploaded(host->ratio, 3 * area * (size_t)host->count, sizeof(real));
    there.weight = ffp_memory_uploaded(host->weight, 3 * area, sizeof(real));
    there.lit = ffp_memory_uploaded(host->lit, area, sizeof(real));
    return there;
}

static void free_there(FfpSearch *s) {
    void *const blocks[] = {s->foreground.pixel, s->foreground.slot, s->observed.asked,
                            s->observed.ratio,   s->observed.weight, s->observed.lit};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) ffp_memory_free(blocks[i]);
}

static FfpSearch search_of(const FfpCapture *capture, int view, const FfpForeground *foreground,
                           const FfpObservation *observed, const FfpBlurred *patterns,
                           unsigned char *const *wide, const FfpMatchSettings *settings) {
    const FfpView *self = &capture->views[view];
    FfpSearch s = {.camera = self->camera,
                   .projector = self->projector,
                   .planes = ffp_planes(capture, view, settings),
                   .foreground = foreground_uploaded(foreground),
                   .observed = observation_uploaded(observed),
                   .patterns = *patterns};
    const FfpAsked asked = ffp_asked(capture, view);
    for (int k = 0; k < asked.count; k++) {
        const FfpView *other = &capture->views[asked.view[k]];
        if (asked.view[k] == view) continue;
        s.seer[s.seers++] =
            (FfpSeer){other->camera, ffp_frame_width(other), ffp_frame_height(other), wide[asked.view[k]]};
    }
    return s;
}

// The plane of least cost of every pixel, and its confidence.
static void search_planes(const Searched *out, const FfpSearch *s) {
    const FfpMatchTable *table = ffp_device()->match;
    const size_t cells = s->foreground.count * (size_t)s->planes.count;
    real *cost = ffp_memory_new(cells, sizeof(real)),
         *paths = ffp_memory_new(FFP_SEARCH_WAYS * cells, sizeof(real));
    table->hull(out->inside, s);
    table->sweep(cost, out->inside, s);
    table->paths(paths, cost, s);
    table->choose(out->depth, out->confidence, paths, cost, s);
    ffp_memory_free(cost);
    ffp_memory_free(paths);
}

static FfpSheet sheet_uploaded(const FfpCamera *camera) {
    FfpSheet sheet = {.width = camera->width,
                      .height = camera->height,
                      .stride = camera->width + 2 * FFP_FINE_PLANE_REACH,
                      .reach = FFP_FINE_PLANE_REACH,
                      .focal = camera->fx};
    enum { SIDE = 2 * FFP_FINE_PLANE_REACH + 1 };
    const size_t cells = (size_t)sheet.stride * (size_t)(camera->height + 2 * sheet.reach);
    ffp_sheet_neighbours(&sheet);
    const FfpSheet host = sheet;
    sheet.nearness = ffp_memory_uploaded(host.nearness, SIDE * SIDE, sizeof(real));
    sheet.jump = ffp_memory_uploaded(host.jump, SIDE * SIDE, sizeof(real));
    ffp_free(host.nearness);
    ffp_free(host.jump);
    sheet.depth = ffp_memory_new(cells, sizeof(real));
    sheet.inverse = ffp_memory_new(cells, sizeof(real));
    sheet.weight = ffp_memory_new(cells, sizeof(real));
    return sheet;
}

static void search_finely(const Searched *out, const FfpSearch *s, const FfpMatchSettings *settings) {
    const size_t area = (size_t)s->camera.width * (size_t)s->camera.height;
    const int steps =
        settings->fine_steps < FFP_REFINE_STEPS_MAX ? settings->fine_steps : FFP_REFINE_STEPS_MAX;
    FfpSheet sheet = sheet_uploaded(&s->camera);
    FfpPlane *planes = ffp_memory_new(area, sizeof *planes);
    real *finer = ffp_memory_new(area, sizeof(real)), span = 2 * s->planes.step;
    for (int round = 0; round < FFP_SEARCH_ROUNDS; round++) {
        ffp_device()->match->refine(finer, out->depth, out->confidence, s, &sheet, planes, steps, span);
        ffp_memory_copy(out->depth, finer, area * sizeof(real));
        span /= 2;
    }
    void *const blocks[] = {sheet.nearness, sheet.jump, sheet.depth, sheet.inverse,
                            sheet.weight,   planes,     finer};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) ffp_memory_free(blocks[i]);
}

static Searched search_view(const FfpSearch *s, const FfpMatchSettings *settings) {
    const size_t area = (size_t)s->camera.width * (size_t)s->camera.height;
    const Searched out = {ffp_memory_new(area, sizeof(real)), ffp_memory_new(area, sizeof(real)),
                          ffp_memory_new(s->foreground.count * (size_t)s->planes.count, 1)};
    search_planes(&out, s);
    search_finely(&out, s, settings);
    return out;
}

static void read_back(const Searched *there, real *depth, real *confidence, size_t area, unsigned char *hull,
                      size_t cells) {
    ffp_memory_download(depth, there->depth, area * sizeof(real));
    ffp_memory_download(confidence, there->confidence, area * sizeof(real));
    ffp_memory_download(hull, there->inside, cells);
    ffp_memory_free(there->depth);
    ffp_memory_free(there->confidence);
    ffp_memory_free(there->inside);
}

static unsigned char *widened_there(const FfpView *view) {
    unsigned char *host = ffp_hull_widened(view);
    const size_t frame = (size_t)ffp_frame_width(view) * (size_t)ffp_frame_height(view);
    unsigned char *there = ffp_memory_uploaded(host, frame + 1, 1);
    ffp_free(host);
    return there;
}

void ffp_search_there(real *depth, real *confidence, real *range, unsigned char **hulls,
                      const FfpCapture *capture, const FfpObservation *observed, const FfpBlurred *patterns,
                      const FfpMatchSettings *settings) {
    const size_t views = (size_t)capture->n_views, area = (size_t)observed->width * (size_t)observed->height;
    unsigned char **wide = ffp_alloc(views, sizeof *wide);
    Searched *found = ffp_alloc(views, sizeof *found);
    FfpForeground *foregrounds = ffp_alloc(views, sizeof *foregrounds);
    const FfpDevice *before = ffp_device_use(settings->device);
    FfpBlurred patterns_there = *patterns;
    patterns_there.cells =
        ffp_memory_uploaded(patterns->cells, patterns->area * (size_t)patterns->patterns, 4 * sizeof(real));
    for (size_t v = 0; v < views; v++) wide[v] = widened_there(&capture->views[v]);
    for (size_t v = 0; v < views; v++) { // queued, and
        ffp_cancel_point();
        foregrounds[v] = ffp_foreground_new(&capture->views[v].coverage);
        FfpSearch s =
            search_of(capture, (int)v, &foregrounds[v], &observed[v], &patterns_there, wide, settings);
        found[v] = search_view(&s, settings);
        free_there(&s);
    }
    for (size_t v = 0; v < views; v++) { // read back when all are under way
        const FfpPlanes planes = ffp_planes(capture, (int)v, settings);
        const size_t cells = foregrounds[v].count * (size_t)planes.count;
        hulls[v] = ffp_alloc(cells, 1);
        read_back(&found[v], depth + v * area, confidence + v * area, area, hulls[v], cells);
        ffp_hull_range(range + 2 * v * area, hulls[v], &foregrounds[v], &planes);
        ffp_foreground_free(&foregrounds[v]);
        ffp_memory_free(wide[v]);
    }
    ffp_memory_free(patterns_there.cells);
    ffp_device_use(before);
    ffp_free(foregrounds);
    ffp_free(found);
    ffp_free(wide);
}
