#include <stdio.h>
#include "cli.h"

typedef struct Arguments {
    const char *gaussians, *capture;
    FfpExport how;
} Arguments;

static int run(void *data) {
    const Arguments *arguments = data;
    FfpError err = {0};
    FfpExportStats stats;
    bool ok = false;
    FfpGaussians *gaussians = ffp_gaussians_open(ffp_cli_context(), arguments->gaussians, NULL, &err);
    const bool with = arguments->capture != NULL;
    const bool sphere = arguments->how.mesh; // that the mesh lies in
    FfpCapture *capture = gaussians && with ? ffp_cli_open_devices(arguments->capture, sphere, &err) : NULL;
    if (gaussians && (capture || !with))
        ok = ffp_export(ffp_cli_context(), gaussians, capture, &arguments->how, &stats, &err);
    if (ok)
        printf("%s: %lld %s, %.2f MB\n", arguments->how.file,
               (long long)(arguments->how.mesh ? stats.triangles : stats.splats),
               arguments->how.mesh ? "triangles" : "splats", (double)stats.bytes / 1e6);
    ffp_capture_close(capture);
    ffp_gaussians_close(gaussians);
    return ok ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

static void set_defaults(void *data) {
    ((Arguments *)data)->how = ffp_export_defaults();
}

static const FfpOption options[] = {
    FFP_CLI_FILE(offsetof(Arguments, how.file), "FILE",
                 "splats: .ply, .spz, .glb or .gltf; with --mesh: .glb, .gltf or .obj"),
    {.name = "capture",
     .letter = 'c',
     .argument = "CAPTURE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, capture),
     .help = "the capture that the Gaussians come from; needed for --light and --mesh"},
    {.name = "up",
     .argument = "AXIS",
     .type = FFP_OPTION_CHOICE,
     .offset = offsetof(Arguments, how.up),
     .words = (const FfpWord[]){{"z", FFP_UP_Z}, {"y", FFP_UP_Y}, {"-y", FFP_UP_MINUS_Y}, {0}},
     .help = "up direction of the Gaussians' world: z (default), y, or -y where the world is a camera's "
             "frame. The "
             "file uses its format's axes: y down and z forward in .ply, y up and z backwards in all others"},
    FFP_CLI_DRAWING(offsetof(Arguments, how.form), FFP_CLI_FORM_HELP),
    {.name = "force",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, how.force),
     .help =
         "let plain splats replace a PLY of relightable Gaussians, whose albedo and roughness are then lost"},
    {.name = "light",
     .argument = "ambient|white|PATTERN",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, how.light),
     .words = (const FfpWord[]){{"ambient", 0}, {"white", 0}, {0}},
     .group = "light",
     .help = "light baked into the splats: ambient (default), or in addition a projector showing white, a "
             "pattern of the capture (by name), or an image file"},
    FFP_CLI_FRAMING(offsetof(Arguments, how.framing), "an image file"),
    {.name = "projector-view",
     .needs = "light",
     .argument = "ID",
     .type = FFP_OPTION_TEXT,
     .offset = offsetof(Arguments, how.projector_view),
     .group = "light",
     .help = "view whose projector shines. Default: the first"},
    {.name = "camera-view",
     .needs = "light",
     .argument = "ID",
     .type = FFP_OPTION_TEXT,
     .offset = offsetof(Arguments, how.camera_view),
     .group = "light",
     .help = "view for whose camera highlights are baked in. Default: none, only the diffuse light, which "
             "looks the same from everywhere"},
    {.name = "poses",
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, how.poses),
     .group = "light",
     .help =
         "file of other camera and projector poses (targets.json or scene.json) to take these views from"},
    {.name = "mesh",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, how.mesh),
     .group = "mesh",
     .help = "write a closed surface with albedo and roughness instead of splats: as textures in .glb and "
             ".gltf (base colour, metallic-roughness), as vertex colours (albedo only) in .obj"},
    {.name = "resolution",
     .needs = "mesh",
     .argument = "N",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, how.resolution),
     .low = 16,
     .high = 512,
     .group = "mesh",
     .help = "cells along the mesh's longest side (default 128)"},
    {0},
};

const FfpCommand ffp_cli_export = {
    .name = "export",
    .group = FFP_CLI_LOOK,
    .purpose = "writes Gaussians for other programs, as splats with baked light or as a mesh",
    .prose = "The extension of FILE selects the format:\n"
             ".ply\tsplats in the reference layout of 3DGS, read by SuperSplat and most viewers\n"
             ".spz\tsplats in Niantic's packed format (version 3), about a tenth of the size\n"
             ".glb, .gltf\tsplats as glTF 2.0 with KHR_gaussian_splatting; with --mesh, a textured mesh\n"
             ".obj\twith --mesh: triangles with coloured vertices\n"
             "Other programs do not simulate a projector, so each splat gets a single colour: the light of "
             "--light at its centre, by the light model, with shadows. A pattern is as sharp as the splats "
             "are small.\n"
             "A mesh is fused from the depth maps of the Gaussians in the capture's cameras; surface seen by "
             "no camera is closed within the silhouettes.",
    .positional = FFP_CLI_GAUSSIANS(offsetof(Arguments, gaussians)),
    .options = options,
    .examples =
        (const FfpExample[]){{.command = "ffprocams export spot.ply -o spot.spz\n"
                                         "ffprocams export spot.ply -c data/sample --light data/sun.png \\\n"
                                         "    --projector-view path_0_theta000 -o sunny.ply\n"
                                         "ffprocams export spot.ply -c data/sample --mesh -o spot.glb"},
                             {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
