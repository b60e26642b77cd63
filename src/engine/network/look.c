#include "engine/network/look.h"
#include "core/base/arena.h"
#include "core/base/device.h"
#include "core/image/srgb_formula.h"
#include "engine/network/table.h"

static void encode_view(FfpLookPhotographs *p, const FfpCapture *capture, int v, int active) {
    const FfpView *view = &capture->views[v];
    const int shown[3] = {capture->black, capture->white, active};
    const size_t area = (size_t)p->width * (size_t)p->height;
    real *colour = p->colour + (size_t)v * area * FFP_LOOK_COLOURS,
         *coverage = p->coverage + (size_t)v * area;
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < area; i++) {
        for (int k = 0; k < FFP_LOOK_COLOURS; k++)
            colour[i * FFP_LOOK_COLOURS + (size_t)k] =
                ffp_srgb_encode(view->images[shown[k / 3]].data[3 * i + (size_t)(k % 3)]);
        coverage[i] = view->coverage.data[i];
    }
    p->camera[v] = view->camera;
    p->projector[v] = view->projector;
    p->frame[2 * v] = view->frame_width ? view->frame_width : p->width;
    p->frame[2 * v + 1] = view->frame_height ? view->frame_height : p->height;
}

FfpLookPhotographs *ffp_look_photographs_new(const FfpCapture *capture, int views, int active) {
    const FfpCamera *first = &capture->views[0].camera;
    const size_t n = (size_t)views, area = (size_t)first->width * (size_t)first->height;
    FfpLookPhotographs *p = ffp_alloc(1, sizeof *p);
    *p = (FfpLookPhotographs){.views = views,
                              .width = first->width,
                              .height = first->height,
                              .projector = ffp_alloc(n, sizeof *p->projector),
                              .camera = ffp_alloc(n, sizeof *p->camera),
                              .frame = ffp_alloc(2 * n, sizeof *p->frame),
                              .colour = ffp_alloc(n * area, FFP_LOOK_COLOURS * sizeof *p->colour),
                              .coverage = ffp_alloc(n * area, sizeof *p->coverage),
                              .pattern = {ffp_summed_new(&capture->patterns[capture->white].image),
                                          ffp_summed_new(&capture->patterns[active].image)}};
    p->camera_there = p->camera;
    for (int k = 0; k < 3; k++) p->intensity[k] = capture->intensity[k];
    for (int v = 0; v < views; v++) encode_view(p, capture, v, active);
    return p;
}

FfpLookPhotographs *ffp_look_photographs_uploaded(const FfpLookPhotographs *here) {
    if (!here) return NULL;
    const size_t n = (size_t)here->views, area = (size_t)here->width * (size_t)here->height;
    FfpLookPhotographs *p = ffp_alloc(1, sizeof *p);
    *p = *here;
    p->camera = ffp_alloc(n, sizeof *p->camera);
    p->projector = ffp_alloc(n, sizeof *p->projector);
    for (size_t v = 0; v < n; v++) {
        p->camera[v] = here->camera[v];
        p->projector[v] = here->projector[v];
    }
    p->camera_there = ffp_memory_uploaded(here->camera, n, sizeof *p->camera);
    p->frame = ffp_memory_uploaded(here->frame, 2 * n, sizeof *p->frame);
    p->colour = ffp_memory_uploaded(here->colour, n * area, FFP_LOOK_COLOURS * sizeof *p->colour);
    p->coverage = ffp_memory_uploaded(here->coverage, n * area, sizeof *p->coverage);
    for (int k = 0; k < 2; k++) p->pattern[k] = ffp_summed_uploaded(&here->pattern[k]);
    return p;
}

void ffp_look_photographs_free(FfpLookPhotographs *p) {
    if (!p) return;
    if (p->camera_there != p->camera) ffp_memory_free(p->camera_there);
    ffp_memory_free(p->frame);
    ffp_memory_free(p->colour);
    ffp_memory_free(p->coverage);
    for (int k = 0; k < 2; k++) ffp_summed_free(&p->pattern[k]);
    ffp_free(p->camera);
    ffp_free(p->projector);
    ffp_free(p);
}

static void compare(real *numbers, const FfpLookPictures *drawn, const real *colour, const real *coverage,
                    size_t pixels) {
    if (ffp_device()) {
        ffp_device()->network->look_compare(numbers, drawn, colour, coverage, pixels);
        return;
    }
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < pixels; i++)
        ffp_look_pixel(numbers + i * FFP_LOOK_NUMBERS, drawn, i, colour + i * FFP_LOOK_COLOURS, coverage[i]);
}

void ffp_look(real *numbers, FfpViewPass *pass, const FfpGaussians *gaussians, const FfpLookPhotographs *p) {
    const size_t area = (size_t)p->width * (size_t)p->height;
    FfpImage picture[3] = {{0}};
    for (int v = 0; v < p->views; v++) {
        ffp_view_pass_draw(pass, gaussians, &p->camera[v], &p->projector[v]);
        for (int k = 0; k < 3; k++) {
            if (!picture[k].data) picture[k] = ffp_view_pass_picture_new(pass);
            ffp_view_pass_shade(pass, p->intensity, k ? &p->pattern[k - 1] : NULL, &picture[k]);
        }
        const FfpGbuffer *g = ffp_view_pass_gbuffer(pass);
        const FfpLookPictures drawn = {
            {picture[0].data, picture[1].data, picture[2].data}, g->opacity, g->depth};
        compare(numbers + (size_t)v * area * FFP_LOOK_NUMBERS, &drawn,
                p->colour + (size_t)v * area * FFP_LOOK_COLOURS, p->coverage + (size_t)v * area, area);
    }
    for (int k = 0; k < 3; k++) ffp_image_free(&picture[k]);
}

FfpLookMaps ffp_look_maps(const FfpLookPhotographs *p, const real *numbers) {
    return (FfpLookMaps){p->views, p->width, p->height, p->camera_there, p->frame, numbers};
}

void ffp_look_gather(real *out, const FfpLookInputs *l, int64_t first, int count) {
    if (ffp_device()) {
        ffp_device()->network->look_gather(out, l, first, count);
        return;
    }
    const size_t width = (size_t)FFP_LOOK_SEEN + (size_t)l->numbers;
#pragma omp parallel for schedule(static)
    for (int64_t g = first; g < first + count; g++)
        ffp_look_inputs(out + (size_t)(g - first) * width, &l->maps, l->pixel[g], l->centre + 3 * g,
                        l->raw + g * l->numbers, l->numbers);
}
