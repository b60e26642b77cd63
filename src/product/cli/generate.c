#include <math.h>
#include <string.h>
#include "cli.h"

typedef struct Arguments {
    FfpGeneration generation;
} Arguments;

static void set_defaults(void *data) {
    ((Arguments *)data)->generation = ffp_generation_defaults();
}

// "NAME=VALUE"
static bool read_fault(const char *text, void *destination) {
    FfpGeneration *generation = destination;
    FfpSensorFaults *sensor = &generation->sensor;
    FfpLightFaults *light = &generation->light;
    const struct {
        const char *name;
        double *value;
    } faults[] = {{"exposure=", &sensor->exposure},
                  {"shot=", &sensor->shot},
                  {"read=", &sensor->read},
                  {"defocus=", &sensor->defocus},
                  {"gamma=", &sensor->gamma},
                  {"black_level=", &sensor->black_level},
                  {"turn_error=", &sensor->turn_error},
                  {"shift_error=", &sensor->shift_error},
                  {"real_light=", &light->real_light},
                  {"spread=", &light->spread},
                  {"spread_reach=", &light->spread_reach},
                  {"glare=", &light->glare},
                  {"glare_reach=", &light->glare_reach},
                  {"power=", &light->power},
                  {"vignetting=", &light->vignetting},
                  {"throw_fall=", &light->throw_fall},
                  {"focus_blur=", &light->focus_blur},
                  {"focus_at=", &light->focus_at}};
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
        const size_t length = strlen(faults[i].name);
        if (strncmp(faults[i].name, text, length) == 0)
            return ffp_cli_real(text + length, -HUGE_VAL, HUGE_VAL, faults[i].value);
    }
    return false;
}

static int run(void *data) {
    Arguments *arguments = data;
    FfpGeneration *generation = &arguments->generation;
    FfpError err = {0};
    if (generation->split != FFP_SPLIT_ALL && generation->mesh)
        return ffp_cli_usage("generate", "--split applies to generated objects, not to --mesh");
    if (!generation->check && !ffp_cli_use_ranks(&err)) return ffp_cli_fail(&err);
    return ffp_generate(ffp_cli_context(), generation, &err) ? FFP_EXIT_OK : ffp_cli_fail(&err);
}

static const FfpOption options[] = {
    {.name = "split",
     .letter = 's',
     .argument = "S",
     .type = FFP_OPTION_CHOICE,
     .offset = offsetof(Arguments, generation.split),
     .words =
         (const FfpWord[]){
             {"train", FFP_SPLIT_TRAIN}, {"validation", FFP_SPLIT_VALIDATION}, {"test", FFP_SPLIT_TEST}, {0}},
     .help = "objects to use: train, validation or test. Default: all"},
    {.name = "first",
     .letter = 'a',
     .argument = "A",
     .type = FFP_OPTION_INT64,
     .offset = offsetof(Arguments, generation.first),
     .high = 1000000000,
     .help = "number of the first scene. Default: 0"},
    {.name = "count",
     .letter = 'n',
     .argument = "N",
     .type = FFP_OPTION_INT64,
     .offset = offsetof(Arguments, generation.count),
     .low = 1,
     .high = 1000000000,
     .help = "number of scenes. Default: the whole split"},
    {.name = "check",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, generation.check),
     .help =
         "generate nothing; list the scenes that are still missing, and exit with status 1 if there are any"},
    {.name = "preset",
     .argument = "P",
     .type = FFP_OPTION_CHOICE,
     .offset = offsetof(Arguments, generation.preset),
     .words = (const FfpWord[]){{"paper", FFP_PRESET_PAPER},
                                {"smoke", FFP_PRESET_SMOKE},
                                {"training", FFP_PRESET_TRAINING},
                                {0}},
     .help = "paper: 8 views at 128 x 128, 6 lollipops (default); smoke: small and quick; training: what "
             "`train` generates for itself, with new poses and a different rig for each scene, to be read "
             "through `scenes` in the configuration"},
    {.name = "rig",
     .argument = "KIND",
     .type = FFP_OPTION_CHOICE,
     .offset = offsetof(Arguments, generation.rig),
     .words = (const FfpWord[]){{"turntable", FFP_RIG_TURNTABLE},
                                {"free", FFP_RIG_FREE},
                                {"sphere", FFP_RIG_SPHERE},
                                {"walk", FFP_RIG_WALK},
                                {"walk-two", FFP_RIG_WALK_TWO},
                                {0}},
     .help =
         "turntable: the object turns before a fixed camera and projector (default); free: cameras all "
         "around the object, each with a projector of its own beside it; sphere: the camera spirals "
         "around a fixed object and projector; walk: a whole scene (a corner, a table, columns, a facade or "
         "a "
         "stage), before which the projector stands and the camera walks along an arc of some 80 degrees; "
         "walk-two: the same with two projectors, in turn, so two views of each place of the camera"},
    {.name = "views",
     .argument = "N",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, generation.views),
     .low = 1,
     .high = 360,
     .help = "number of input views, 1 to 360, instead of the preset's 8"},
    {.name = "mesh",
     .letter = 'm',
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, generation.mesh),
     .help = "OBJ, PLY, STL or glTF file to use instead of generated objects, centred and scaled to a sphere "
             "of radius 0.95; one scene unless --count asks for more"},
    {.name = "material",
     .argument = "FOLDER",
     .type = FFP_OPTION_FOLDER,
     .offset = offsetof(Arguments, generation.material),
     .help = "folder of maps named basecolor (or albedo, diffuse, color), roughness and normal, instead of "
             "generated materials; metallic maps are not used"},
    {.name = "materials",
     .argument = "FOLDER",
     .type = FFP_OPTION_FOLDER,
     .excludes = "material",
     .offset = offsetof(Arguments, generation.materials),
     .help = "folder of pictures, each of which is a material, and of folders as of --material; each scene "
             "draws one of them by its seed, with its own size, direction and (for pictures) roughness"},
    {.name = "patterns",
     .argument = "FOLDER",
     .type = FFP_OPTION_FOLDER,
     .excludes = "photographs",
     .offset = offsetof(Arguments, generation.patterns),
     .help =
         "folder of pictures that the projector shows in place of all lollipops but the first; each scene "
         "draws them, and a square of each, by its seed"},
    {.name = "resolution",
     .letter = 'r',
     .argument = "R",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, generation.resolution),
     .low = 8,
     .high = 4096,
     .help = "image size in pixels, instead of the preset's"},
    {.name = "seed",
     .argument = "S",
     .type = FFP_OPTION_INT64,
     .offset = offsetof(Arguments, generation.seed),
     .high = INT64_MAX,
     .help = "random seed; each seed gives different scenes. Default: 0"},
    {.name = "sensor",
     .argument = "NAME=VALUE",
     .type = FFP_OPTION_PARSED,
     .repeated = true,
     .offset = offsetof(Arguments, generation),
     .parse = read_fault,
     .takes = "NAME=NUMBER, NAME being exposure, shot, read, defocus, gamma, black_level, turn_error, "
              "shift_error, real_light, spread, spread_reach, glare, glare_reach, power, vignetting, "
              "throw_fall, focus_blur or focus_at",
     .words = (const FfpWord[]){{"read=", 0},
                                {"shot=", 0},
                                {"defocus=", 0},
                                {"gamma=", 0},
                                {"black_level=", 0},
                                {"exposure=", 0},
                                {"turn_error=", 0},
                                {"shift_error=", 0},
                                {"real_light=", 0},
                                {"spread=", 0},
                                {"spread_reach=", 0},
                                {"glare=", 0},
                                {"glare_reach=", 0},
                                {"power=", 0},
                                {"vignetting=", 0},
                                {"throw_fall=", 0},
                                {"focus_blur=", 0},
                                {"focus_at=", 0},
                                {0}},
     .help = "imperfections of real devices, may be repeated: read noise (read=0.01, relative to white) and "
             "shot noise (shot), the projector's defocus (defocus=1, standard deviation in its pixels), "
             "gamma and black_level, exposure (stops), errors of the written poses (turn_error=0.2 degrees, "
             "shift_error=0.004 units). real_light=1 draws what real devices do to light from the seed: the "
             "projector's spread, response (power), vignetting (throw_fall) and focus (focus_blur), the "
             "camera's glare and vignetting; less than 1 is weaker, and each can be given by itself. The "
             "scenes are otherwise the same. Default: all 0"},
    {.name = "photographs",
     .argument = "PATTERNS",
     .type = FFP_OPTION_FOLDER,
     .offset = offsetof(Arguments, generation.photographs),
     .help =
         "write photographs instead of captures: of one object (the first, or --mesh) on a turntable "
         "under every pattern in this folder (from `patterns`), in view-DDD/ named by angle, of the stage "
         "without it, in empty/, and, if there are Gray codes, of a "
         "chessboard of 9 x 6 corners for `calibrate`, in attitude-NN/ and turntable/. Camera and "
         "projector have lens distortion. Photographs are numbered like their patterns. truth.json holds "
         "the true calibration. --resolution sets their height (480), --views the number of stops. With "
         "--rig walk of a whole scene instead, from --views places of the camera, in place-NN/; colmap/ "
         "holds the true calibration"},
    {.name = "attitudes",
     .needs = "photographs",
     .argument = "N",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, generation.attitudes),
     .high = 64,
     .help = "with --photographs: number of attitudes of the chessboard; 0: no chessboard. Default: 8"},
    {.name = "only",
     .needs = "photographs",
     .argument = "NAME",
     .type = FFP_OPTION_TEXT,
     .offset = offsetof(Arguments, generation.only),
     .help = "with --photographs: only this folder of them, view-DDD, attitude-NN, turntable or empty, the "
             "same as "
             "among all of them"},
    {.name = "other-projector",
     .needs = "photographs",
     .excludes = "room",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, generation.other_projector),
     .help = "with --photographs: the light comes from another projector, on the other side of the camera"},
    {.name = "room",
     .needs = "photographs",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, generation.room),
     .help =
         "with --photographs: in a real room, with platter, table, wall, boxes in the projector's light, "
         "bounced light and a weak lamp, all of them decided by --seed. Two turns between the stops are "
         "added, view-022 and view-157, and two patterns, in held-out/; truth/ has the photographs without "
         "noise. The room's devices have their own imperfections, which --sensor replaces"},
    {.name = "quality",
     .needs = "room",
     .argument = "Q",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, generation.quality),
     .low = 1,
     .high = 100,
     .help = "with --room: quality of the JPEG files, 1 to 100. Default: 92"},
    {0},
};

const FfpCommand ffp_cli_generate = {
    .name = "generate",
    .group = FFP_CLI_TRAIN,
    .purpose = "generates ray-traced captures of procedural objects, with ground truth",
    .prose =
        "A ray-traced light simulator writes DIR/<scene>/ in the project's capture format, together with "
        "depth, normal, albedo, roughness and mask, and new poses in "
        "DIR/<scene>/targets/.\n"
        "A scene depends only on its number, the seed and the preset; rig, views and resolution show the "
        "same scene in a different way. Existing scenes are kept, so an interrupted run resumes where it "
        "stopped, and several runs can share a job, each with its own --first and --count, as can the "
        "processes of `mpirun -n N ffprocams generate ...`. Use a different DIR for different options.",
    .positional = {.name = "DIR",
                   .least = 1,
                   .most = 1,
                   .offset = offsetof(Arguments, generation.folder),
                   .help = "folder for the captures"},
    .options = options,
    .examples =
        (const FfpExample[]){{.command = "ffprocams generate scenes --preset smoke --count 2\n"
                                         "ffprocams generate mine --mesh vase.obj --material "
                                         "glazed_clay"},
                             {.about = "The photographs that a real camera and projector would have given:",
                              .command =
                                  "ffprocams patterns -o patterns --projector 640x400\n"
                                  "ffprocams generate shots --photographs patterns --views 16 --sensor "
                                  "read=0.005\n"
                                  "ffprocams generate room --photographs patterns --room --seed 7 "
                                  "--attitudes 0"},
                             {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
