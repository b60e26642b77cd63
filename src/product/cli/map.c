#include <stdio.h>
#include "cli.h"

typedef struct Arguments {
    const char *gaussians, *capture;
    FfpList views;
    FfpWarps maps;
    int up;
} Arguments;

static void tell(const Arguments *arguments, const FfpWarpStats *stats, int written) {
    for (int v = 0; v < FFP_VIEWS_MAX && stats[v].view[0]; v++) {
        const FfpWarpStats *view = &stats[v];
        printf("%s: %.1f %% of the projector's pixels fall on the object; round trip: %d camera pixels, %.2f "
               "%% within half a pixel, median %.3f, maximum %.3f; %d more do not return\n",
               view->view, 100 * view->lit_share, view->lit_pixels, 100 * view->within_half, view->median,
               view->most, view->lost_pixels);
    }
    printf("%s: %d file%s\n", arguments->maps.folder, written, FFP_CLI_S(written));
}

static int run(void *data) {
    static FfpWarpStats stats[FFP_VIEWS_MAX];
    Arguments *arguments = data;
    FfpError err = {0};
    int written = -1;
    arguments->maps.views = arguments->views.values;
    arguments->maps.n_views = arguments->views.count;
    FfpGaussians *gaussians = ffp_gaussians_open(ffp_cli_context(), arguments->gaussians, NULL, &err);
    FfpCapture *capture = gaussians ? ffp_cli_open_devices(arguments->capture, false, &err) : NULL;
    if (capture && ffp_cli_turn(gaussians, arguments->gaussians, capture, arguments->up, &err))
        written = ffp_write_warps(ffp_cli_context(), gaussians, capture, &arguments->maps, stats,
                                  FFP_VIEWS_MAX, &err);
    if (written >= 0) tell(arguments, stats, written);
    ffp_capture_close(capture);
    ffp_gaussians_close(gaussians);
    return written >= 0 ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

static void set_defaults(void *data) {
    ((Arguments *)data)->maps = ffp_warps_defaults();
}

static const FfpOption options[] = {
    FFP_CLI_CAPTURE_OPTION(offsetof(Arguments, capture), "the capture they come from"),
    FFP_CLI_FOLDER(offsetof(Arguments, maps.folder), "folder for the files"),
    FFP_CLI_POSES(offsetof(Arguments, maps.poses)),
    FFP_CLI_VIEWS(offsetof(Arguments, views),
                  "view to map; may be repeated. Default: all views of the poses"),
    FFP_CLI_UP(offsetof(Arguments, up)),
    FFP_CLI_DRAWING(offsetof(Arguments, maps.drawing.form), FFP_CLI_FORM_HELP),
    FFP_CLI_SAMPLES(offsetof(Arguments, maps.drawing.samples), FFP_CLI_SAMPLES_HELP),
    {0},
};

const FfpCommand ffp_cli_map = {
    .name = "map",
    .group = FFP_CLI_PROJECT,
    .purpose = "maps projector pixels to camera pixels and back, with the light that arrives",
    .prose =
        "Also writes how much light falls on the object, how densely and at what angle. For each view, in "
        "DIR:\n"
        "<view>_camera_to_projector.exr\tfor each camera pixel: x, y in the projector (R, G, in pixels, "
        "centres at + 0.5) and the unshadowed share of the light (B); -1 -1 0 off the object\n"
        "<view>_projector_to_camera.exr\tfor each projector pixel: x, y in the camera (R, G), 1 (B); -1 -1 0 "
        "where the camera does not see the lit point\n"
        "<view>_stmap.exr\tthe same as shares of the camera's picture, v from below (STMap); "
        "<view>_warp.obj, .glb: a mesh of it\n"
        "both\talso as 16-bit PNG: x / width, y / height; alpha 0 off the object\n"
        "<view>_projector_sees.png\tthe object seen from the projector, in its white light\n"
        "<view>_lit.png\tprojector pixels that fall on the object\n"
        "<view>_density.exr\tcamera pixels per projector pixel\n"
        "<view>_resolution.exr\tprojector pixels per unit of length on the surface\n"
        "<view>_incidence.exr\tangle of incidence in degrees, -1 off the object\n"
        "<view>_illuminance.exr, .png\tlight arriving at the surface, normalised to 1 at its maximum in the "
        "view\n"
        "projectors.mpcdi\tthe warps of all views, for media servers (MPCDI 2.0, profile 2d); "
        "projectors-1.0.mpcdi: of version 1.0\n"
        "For each view the command prints how far camera pixels end up from where they started after a round "
        "trip to the projector and back, which checks the two correspondence maps against each other.",
    .positional = FFP_CLI_GAUSSIANS(offsetof(Arguments, gaussians)),
    .options = options,
    .examples =
        (const FfpExample[]){
            {.command = "ffprocams map spot.ply --capture data/sample --view path_0_theta000 -o maps"}, {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
