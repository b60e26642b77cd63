// The pixels that the rays of a fit are drawn from, and the patterns that light them.
#include <tgmath.h>
#include "core/base/alloc.h"
#include "lab/baselines/chunk.h"

enum { MARGIN = 3 }; // pixels around the object that rays are drawn from too

static bool near_object(const FfpView *view, int x, int y) {
    const int width = ffp_frame_width(view), height = ffp_frame_height(view);
    for (int j = y - MARGIN < 0 ? 0 : y - MARGIN; j <= y + MARGIN && j < height; j++)
        for (int i = x - MARGIN < 0 ? 0 : x - MARGIN; i <= x + MARGIN && i < width; i++)
            if (view->coverage.data[j * view->camera.width + i] > 0) return true;
    return false;
}

static int64_t choose_pixels(const FfpView *view, int32_t *pixels) {
    int64_t count = 0;
    for (int y = 0; y < ffp_frame_height(view); y++)
        for (int x = 0; x < ffp_frame_width(view); x++)
            if (near_object(view, x, y)) pixels[count++] = y * view->camera.width + x;
    if (count == 0) pixels[count++] = 0; // a view that sees nothing of the object
    return count;
}

static FfpFieldPattern pattern_of(const FfpImage *image) {
    FfpFieldPattern pattern = {.image = image, .flat = true};
    const size_t count = (size_t)image->width * (size_t)image->height;
    for (int k = 0; k < 3; k++) pattern.colour[k] = image->data[k];
    for (size_t i = 0; i < 3 * count && pattern.flat; i++)
        pattern.flat = image->data[i] == pattern.colour[i % 3];
    if (!pattern.flat) pattern.summed = ffp_summed_new(image);
    return pattern;
}

FfpFieldScene ffp_field_scene_new(const FfpCapture *capture, const int *chosen, int n_patterns) {
    FfpFieldScene scene = {.capture = capture, .chosen = chosen, .n_patterns = n_patterns};
    int64_t drawn = 0, all = 0;
    scene.patterns = ffp_alloc((size_t)n_patterns, sizeof *scene.patterns);
    scene.pixels = ffp_alloc((size_t)capture->n_views, sizeof *scene.pixels);
    scene.counts = ffp_alloc((size_t)capture->n_views, sizeof *scene.counts);
    for (int p = 0; p < n_patterns; p++) scene.patterns[p] = pattern_of(&capture->patterns[chosen[p]].image);
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        const size_t pixels = (size_t)view->camera.width * (size_t)view->camera.height;
        scene.pixels[v] = ffp_alloc(pixels, sizeof **scene.pixels);
        scene.counts[v] = choose_pixels(view, scene.pixels[v]);
        drawn += scene.counts[v];
        all += (int64_t)pixels;
    }
    scene.share = (double)drawn / (double)all;
    return scene;
}

void ffp_field_scene_free(FfpFieldScene *scene) {
    for (int p = 0; p < scene->n_patterns; p++) ffp_summed_free(&scene->patterns[p].summed);
    for (int v = 0; v < scene->capture->n_views; v++) ffp_free(scene->pixels[v]);
    ffp_free(scene->patterns);
    ffp_free((void *)scene->pixels);
    ffp_free(scene->counts);
    *scene = (FfpFieldScene){0};
}
