#include "core/capture/photograph_files.h"
#include "core/capture/photographs.h"

void ffp_photographs_leave(FfpManifest *manifest) {
    FfpCapture *capture = manifest->capture;
    FfpPhotographFiles *files = ffp_arena_alloc(manifest->arena, 1, sizeof *files);
    *files = (FfpPhotographFiles){.arena = manifest->arena,
                                  .json = ffp_arena_text(manifest->arena, manifest->file),
                                  .views = manifest->views,
                                  .mask_is_given = manifest->mask_is_given};
    files->wholes = ffp_arena_alloc(manifest->arena, (size_t)capture->n_views, sizeof *files->wholes);
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        files->wholes[v] =
            (FfpWholePicture){view->camera.width, view->camera.height, view->frame_width, view->frame_height};
    }
    capture->files = files;
}

void ffp_photographs_forget(FfpCapture *capture) {
    if (capture->files) ffp_arena_free(capture->files->arena);
    capture->files = NULL;
}

bool ffp_photographs_has(const FfpCapture *capture, int view, int pattern) {
    const FfpImage *images = capture->views[view].images;
    return (images && images[pattern].data) ||
           (capture->files && capture->files->views[view].images[pattern].path);
}
