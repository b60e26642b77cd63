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

bool ffp_photographs_truth(const FfpCapture *capture, int view, int kind) {
    const FfpView *v = &capture->views[view];
    const FfpImage *const images[FFP_TRUTHS] = {&v->depth, &v->normal, &v->albedo, &v->roughness,
                                                &v->direct_white};
    if (images[kind]->data || !capture->files) return images[kind]->data != NULL;
    const FfpViewFiles *f = &capture->files->views[view];
    const FfpSource *const sources[FFP_TRUTHS] = {&f->depth, &f->normal, &f->albedo, &f->roughness,
                                                  &f->direct_white};
    return sources[kind]->path != NULL;
}
