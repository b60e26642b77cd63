#include <jansson.h>
#include <stdio.h>
#include "cli.h"

typedef struct Arguments {
    const char *capture, *output, *gaussians;
    FfpAlignment options;
    bool json, second;
} Arguments;

static void print_json(const char *output, const FfpAlignmentStats *s) {
    json_t *all = json_pack("{s:s, s:f, s:f, s:f}", "output", output, "before", s->before, "after", s->after,
                            "seconds", s->elapsed_s);
    if (s->known)
        json_object_update_new(all, json_pack("{s:{s:f, s:f, s:f}, s:{s:f, s:f, s:f}}", "camera", "rotated",
                                              s->camera_turned, "moved", s->camera_moved, "pixels",
                                              s->camera_pixels, "projector", "rotated", s->projector_turned,
                                              "moved", s->projector_moved, "pixels", s->projector_pixels));
    else
        json_object_update_new(all, json_pack("{s:b, s:f, s:f, s:f, s:f, s:f, s:[ff], s:[ff], s:[ff]}",
                                              "turntable", s->turntable, "evened", s->evened, "depth",
                                              s->depth, "across", s->across, "side", s->side, "turned",
                                              s->turned, "off", s->off[0], s->off[1], "apart", s->apart[0],
                                              s->apart[1], "focal", s->focal[0], s->focal[1]));
    json_dumpf(all, stdout, JSON_INDENT(1) | JSON_PRESERVE_ORDER | JSON_REAL_PRECISION(9));
    putchar('\n');
    json_decref(all);
}

static void tell_known(const char *output, const FfpAlignmentStats *stats) {
    printf("camera      rotated by %.3f degrees and moved by %.4g: %.2f pixels (means over the views)\n"
           "projector   rotated by %.3f degrees and moved by %.4g: %.2f pixels\n"
           "pictures    drawn and photographed values differ by %.4f (%.4f before)\n"
           "%s: aligned in %.1f s\n",
           stats->camera_turned, stats->camera_moved, stats->camera_pixels, stats->projector_turned,
           stats->projector_moved, stats->projector_pixels, stats->after, stats->before, output,
           stats->elapsed_s);
}

static void tell(const char *output, const FfpAlignmentStats *stats) {
    if (stats->turntable)
        printf("turntable   devices rotated by %.3f degrees towards the poses shared by all views\n",
               stats->evened);
    else
        printf("turntable   none: each view has a pose of its own\n");
    if (stats->own)
        printf("each view   devices rotated by %.3f degrees; camera rays miss their projector pixels by %.3f "
               "pixels\n"
               "            (%.3f before); surfaces of different views are %.3f pixels apart (%.3f before)\n",
               stats->turned, stats->off[1], stats->off[0], stats->apart[1], stats->apart[0]);
    if (stats->focal[0] != 1 || stats->focal[1] != 1)
        printf("focal       camera focal lengths scaled by %.4f, projector focal lengths by %.4f\n",
               stats->focal[0], stats->focal[1]);
    printf("all views   camera rotated by %+.3f degrees towards the projector and by %+.3f across, the "
           "projector\n"
           "            by as much the other way; both by %+.3f sideways\n"
           "pictures    pattern values differ by %.4f (%.4f before)\n"
           "%s: aligned in %.1f s\n",
           stats->depth, stats->across, stats->side, stats->after, stats->before, output, stats->elapsed_s);
}

// --- A second projector. ---

static json_t *pinhole_json(const FfpPinhole *p) {
    json_t *pose = json_array();
    for (int i = 0; i < 16; i++) json_array_append_new(pose, json_real(p->pose[i]));
    return json_pack("{s:[ii], s:[ff], s:[ff], s:o}", "size", p->width, p->height, "focal", p->fx, p->fy,
                     "centre", p->cx, p->cy, "pose", pose);
}

static void tell_second(const Arguments *arguments, const FfpCapture *capture, const FfpFoundProjector *f) {
    FfpPinhole camera, p;
    ffp_capture_view_devices(capture, 0, &camera, &p);
    if (arguments->json) {
        json_t *all =
            json_pack("{s:s, s:o, s:f, s:{s:f, s:f, s:f, s:[ff]}, s:f, s:i, s:i}", "output",
                      arguments->output, "projector", pinhole_json(&p), "distance", f->distance, "deviations",
                      "turned", f->turned, "moved", f->moved, "focal", f->focal, "centre", f->centre[0],
                      f->centre[1], "rms", f->rms, "points", f->points, "used", f->used);
        json_dumpf(all, stdout, JSON_INDENT(1) | JSON_PRESERVE_ORDER | JSON_REAL_PRECISION(9));
        putchar('\n');
        json_decref(all);
        return;
    }
    printf(
        "projector   %.4g from the object, known to %.2g (%.2g %%) and to %.2g degrees\n"
        "lens        focal length %.1f pixels, known to %.2g %%; principal point %.1f, %.1f, known to %.2g, "
        "%.2g\n"
        "codes       %d of %d points used; they lie %.2f pixels off (rms)\n"
        "%s: found\n",
        f->distance, f->moved, 100 * f->moved / f->distance, f->turned, p.fx, 100 * f->focal, p.cx, p.cy,
        f->centre[0], f->centre[1], f->used, f->points, f->rms, arguments->output);
}

static bool find_second(const Arguments *arguments, FfpCapture *capture, const FfpGaussians *known,
                        FfpError *err) {
    FfpFoundProjector found;
    if (!ffp_find_projector(ffp_cli_context(), capture, known, &found, err) ||
        !ffp_capture_save(ffp_cli_context(), capture, arguments->output, err))
        return false;
    tell_second(arguments, capture, &found);
    return true;
}

static bool align(Arguments *arguments, FfpCapture *capture, const FfpGaussians *known, FfpError *err) {
    FfpAlignmentStats stats;
    arguments->options.gaussians = known;
    if (!ffp_align_poses(ffp_cli_context(), capture, &arguments->options, &stats, err) ||
        !ffp_capture_save(ffp_cli_context(), capture, arguments->output, err))
        return false;
    (arguments->json ? print_json : stats.known ? tell_known : tell)(arguments->output, &stats);
    return true;
}

static int run(void *data) {
    Arguments *arguments = data;
    FfpError err = {0};
    FfpCapture *capture = ffp_can_save_capture(arguments->output, &err)
                              ? ffp_capture_open(ffp_cli_context(), arguments->capture, NULL, &err)
                              : NULL;
    FfpGaussians *known = capture && arguments->gaussians
                              ? ffp_gaussians_open(ffp_cli_context(), arguments->gaussians, NULL, &err)
                              : NULL;
    const bool ok = capture && (known || !arguments->gaussians) &&
                    (arguments->second ? find_second(arguments, capture, known, &err)
                                       : align(arguments, capture, known, &err));
    ffp_gaussians_close(known);
    ffp_capture_close(capture);
    return ok ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

static void set_defaults(void *data) {
    ((Arguments *)data)->options = ffp_alignment_defaults();
}

static const FfpOption options[] = {
    FFP_CLI_FOLDER(offsetof(Arguments, output),
                   "folder for the capture with corrected poses; it must be new or empty"),
    {.name = "pattern",
     .letter = 'p',
     .argument = "NAME",
     .type = FFP_OPTION_TEXT,
     .offset = offsetof(Arguments, options.pattern),
     .help = "the structured-light pattern to align by (default: as for `reconstruct`); with --gaussians the "
             "picture whose photograph is looked at, which may be any (default: all photographs)"},
    FFP_CLI_JSON(offsetof(Arguments, json), "print the figures as JSON instead"),
    {.name = "gaussians",
     .letter = 'g',
     .argument = "FILE.ply",
     .type = FFP_OPTION_FILE,
     .excludes = "focal",
     .offset = offsetof(Arguments, gaussians),
     .help = "the object as it is known, from `reconstruct`, in the capture's world: find camera and "
             "projector again by it. One view is enough"},
    {.name = "second-projector",
     .type = FFP_OPTION_FLAG,
     .needs = "gaussians",
     .excludes = "pattern",
     .offset = offsetof(Arguments, second),
     .help = "with --gaussians: the cameras are right, and the projector is one that no calibration "
             "describes; find its place and lens from its Gray codes on the object"},
    {.name = "focal",
     .letter = 'f',
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, options.focal_lengths),
     .help = "also correct the focal lengths of camera and projector, by the same factors in all views. "
             "Needs views from more than one side of the object"},
    {0},
};

const FfpCommand ffp_cli_align = {
    .name = "align",
    .group = FFP_CLI_CAPTURE,
    .purpose = "corrects the poses of a capture's cameras and projectors from its photographs",
    .prose =
        "An orientation that is off by a fifth of a degree, or a principal point by half a pixel, costs "
        "more than anything else: run this after `import` when `info` doubts the calibration, or when "
        "predictions look doubled.\n"
        "- If the views come from a fixed rig around a turning object, their poses are replaced by the "
        "ones they share, provided that the pictures agree at least as well. Poses calibrated one at a "
        "time gain the most.\n"
        "- Otherwise each view's poses are corrected separately, until camera rays meet the projector "
        "pixels whose light they see and the surfaces of different views coincide.\n"
        "- One rotation of the camera and one of the projector, the same in all views, are then "
        "searched for: those that make the surfaces found in one view agree best with the surfaces "
        "found in the others.\n"
        "The object's position along the turntable's axis, which no picture reveals, stays as it was.\n"
        "With --gaussians, camera and projector of each view are moved until the photographs look as the "
        "object is drawn: for a device that was bumped, or an object that was moved, since it was "
        "reconstructed. Import photographs of one stop under black, white and one pattern as they are "
        "now, align them, and give the result to `compensate`, `map` or `view` as --capture.\n"
        "With --second-projector, a projector is found that shone alone: photograph the object as it stands "
        "at a stop under its black, white and Gray codes, and `import --other-projector` that stop.",
    .positional = {.name = "CAPTURE",
                   .least = 1,
                   .most = 1,
                   .offset = offsetof(Arguments, capture),
                   .help = "as for `reconstruct`"},
    .options = options,
    .examples = (const FfpExample[]){{.command = "ffprocams align vase -o vase-aligned\n"
                                                 "ffprocams reconstruct vase-aligned -o vase.ply"},
                                     {.about = "The projector was bumped:",
                                      .command = "ffprocams align now -g vase.ply -o now-aligned"},
                                     {.about = "Another projector:",
                                      .command = "ffprocams patterns -o patterns-2 --projector 1280x800\n"
                                                 "ffprocams import -c calibration.xml -t axis.json -v 045 "
                                                 "--other-projector \\\n"
                                                 "    --projector-size 1280x800 --shown patterns-2 -i "
                                                 "'shots-2/{view}/*.JPG' -o second\n"
                                                 "ffprocams align second -g vase.ply --second-projector -o "
                                                 "vase-second"},
                                     {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
