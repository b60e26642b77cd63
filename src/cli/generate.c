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
    FfpSensorFaults *sensor = destination;
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
                  {"shift_error=", &sensor->shift_error}};
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
        return ffp_cli_usage("generate", "--split is of the generated objects: not with --mesh");
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
     .help = "train, validation or test: which objects. Default: all of them"},
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
     .help = "how many scenes. Default: all of the split"},
    {.name = "check",
     .type = FFP_OPTION_FLAG,
     .offset = offsetof(Arguments, generation.check),
     .help = "make nothing: say which of these scenes are not there yet, if any (exit 1)"},
    {.name = "preset",
     .argument = "P",
     .type = FFP_OPTION_CHOICE,
     .offset = offsetof(Arguments, generation.preset),
     .words = (const FfpWord[]){{"paper", FFP_PRESET_PAPER},
                                {"smoke", FFP_PRESET_SMOKE},
                                {"training", FFP_PRESET_TRAINING},
                                {0}},
     .help =
         "paper: 8 views at 128 x 128, 6 lollipops (default); smoke: small, quick; training: what `train` "
         "makes for itself, new poses and a rig of its own for each scene, to be read with the "
         "configuration's `scenes`"},
    {.name = "rig",
     .argument = "KIND",
     .type = FFP_OPTION_CHOICE,
     .offset = offsetof(Arguments, generation.rig),
     .words =
         (const FfpWord[]){
             {"turntable", FFP_RIG_TURNTABLE}, {"free", FFP_RIG_FREE}, {"sphere", FFP_RIG_SPHERE}, {0}},
     .help =
         "turntable: camera and projector stay, the object turns (default); free: a camera all around the "
         "object and a projector anew beside it for each view; sphere: object and projector stay and the "
         "camera goes around them in a spiral"},
    {.name = "views",
     .argument = "N",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, generation.views),
     .low = 1,
     .high = 360,
     .help = "input views, 1 to 360, instead of the preset's 8"},
    {.name = "mesh",
     .letter = 'm',
     .argument = "FILE",
     .type = FFP_OPTION_FILE,
     .offset = offsetof(Arguments, generation.mesh),
     .help = "an OBJ, PLY, STL or glTF file instead of the generated objects, centred and scaled into a ball "
             "of radius 0.95; one scene unless --count says more"},
    {.name = "material",
     .argument = "FOLDER",
     .type = FFP_OPTION_FOLDER,
     .offset = offsetof(Arguments, generation.material),
     .help = "maps called basecolor (or albedo, diffuse, color), roughness, normal, instead of the generated "
             "materials; metallic maps are not used"},
    {.name = "resolution",
     .letter = 'r',
     .argument = "R",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, generation.resolution),
     .low = 8,
     .high = 4096,
     .help = "image side, instead of the preset's"},
    {.name = "seed",
     .argument = "S",
     .type = FFP_OPTION_INT64,
     .offset = offsetof(Arguments, generation.seed),
     .high = INT64_MAX,
     .help = "another seed, other scenes. Default: 0"},
    {.name = "sensor",
     .argument = "NAME=VALUE",
     .type = FFP_OPTION_PARSED,
     .repeated = true,
     .offset = offsetof(Arguments, generation.sensor),
     .parse = read_fault,
     .takes = "exposure, shot, read, defocus, gamma, black_level, turn_error or shift_error = a number",
     .words = (const FfpWord[]){{"read=", 0},
                                {"shot=", 0},
                                {"defocus=", 0},
                                {"gamma=", 0},
                                {"black_level=", 0},
                                {"exposure=", 0},
                                {"turn_error=", 0},
                                {"shift_error=", 0},
                                {0}},
     .help = "what real devices do, again for more: noise of reading (read=0.01, of white) and of light "
             "(shot), the projector's defocus (defocus=1, deviation in its pixels), gamma and black_level, "
             "exposure (stops), errors of the written poses (turn_error=0.2 degrees, shift_error=0.004 "
             "units). The scenes are the same otherwise. Default: all 0"},
    {.name = "photographs",
     .argument = "PATTERNS",
     .type = FFP_OPTION_FOLDER,
     .offset = offsetof(Arguments, generation.photographs),
     .help =
         "photographs instead of captures: of one object (the first, or --mesh) on a turntable under every "
         "pattern in this folder of `patterns`, in view-DDD/ by its degrees, and of a chessboard of 9 x 6 "
         "corners for "
         "`calibrate`, in attitude-NN/ and turntable/, by a camera and a projector whose lenses "
         "distort. Each has its pattern's number. truth.json is the calibration as it should come out. "
         "--resolution is their height (480), --views the stops"},
    {.name = "attitudes",
     .needs = "photographs",
     .argument = "N",
     .type = FFP_OPTION_INT,
     .offset = offsetof(Arguments, generation.attitudes),
     .high = 64,
     .help = "with --photographs: in how many the chessboard is held; 0: without one. Default: 8"},
    {0},
};

const FfpCommand ffp_cli_generate = {
    .name = "generate",
    .group = FFP_CLI_TRAIN,
    .purpose = "makes captures of procedural objects, traced with all their truth",
    .prose =
        "A ray-traced light simulator writes DIR/<scene>/ in the project's own capture format, with depth, "
        "normal, albedo, roughness and mask besides, and new poses of the test split's objects in "
        "DIR/<scene>/targets/.\n"
        "A scene depends only on its number, the seed and the preset; rig, views and resolution show the "
        "same "
        "scene otherwise. Scenes that are there already are kept, so that a stopped run goes on where it "
        "was, "
        "and several runs can share a job, each with its own --first and --count, as can the processes of "
        "`mpirun -n N ffprocams generate ...`. What is made with other "
        "options goes to another DIR.",
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
                             {.about = "What somebody with a camera and a projector would have photographed:",
                              .command =
                                  "ffprocams patterns -o patterns --projector 640x400\n"
                                  "ffprocams generate shots --photographs patterns --views 16 --sensor "
                                  "read=0.005"},
                             {0}},
    .size = sizeof(Arguments),
    .set_defaults = set_defaults,
    .run = run,
};
