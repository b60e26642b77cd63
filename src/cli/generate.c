#include <stdio.h>
#include <string.h>
#include "cli/cli.h"

static const char help[] =
    "usage: ffprocams generate DIR [--split S] [--first A --count N] [--preset P]\n"
    "                          [--rig KIND] [--views N] [--resolution R] [--seed S] [--mesh FILE]\n"
    "                          [--material FOLDER] [--sensor NAME=VALUE]..\n"
    "\n"
    "Makes captures of procedural objects with a ray-traced light simulator: DIR/<scene>/ in the\n"
    "project's own capture format, with depth, normal, albedo, roughness and mask besides, and new\n"
    "poses of the test split's objects in DIR/<scene>/targets/. A scene depends only on its number,\n"
    "the seed and the preset; rig, views and resolution show the same scene otherwise. Scenes that are\n"
    "there already are kept, so that a stopped run goes on where it was, and several runs can share a\n"
    "job, each with its own --first and --count. What is made with other options goes to another DIR.\n"
    "\n"
    "  DIR                   folder for the captures\n"
    "  -s, --split S         train, validation or test: which objects. Default: all of them\n"
    "  -a, --first A         number of the first scene. Default: 0\n"
    "  -n, --count N         how many scenes. Default: all of the split\n"
    "      --preset P        paper: 8 views at 128 x 128, 6 lollipops (default); smoke: small, quick;\n"
    "                        training: what `train` makes for itself, new poses and a rig of its own for\n"
    "                        each scene, to be read with the configuration's `scenes`\n"
    "      --rig KIND        turntable: camera and projector stay, the object turns (default); free: a\n"
    "                        camera all around the object and a projector anew beside it for each view\n"
    "      --views N         input views, 1 to 64, instead of the preset's 8\n"
    "  -m, --mesh FILE       an OBJ, PLY, STL or glTF file instead of the generated objects, centred and\n"
    "                        scaled into a ball of radius 0.95; one scene unless --count says more\n"
    "      --material FOLDER maps called basecolor (or albedo, diffuse, color), roughness, normal,\n"
    "                        instead of the generated materials; metallic maps are not used\n"
    "  -r, --resolution R    image side, instead of the preset's\n"
    "      --seed S          another seed, other scenes. Default: 0\n"
    "      --sensor N=VALUE  what real devices do, again for more: noise of reading (read=0.01, of white)\n"
    "                        and of light (shot), the projector's defocus (defocus=1, deviation in its\n"
    "                        pixels), gamma and black_level, exposure (stops), errors of the written poses\n"
    "                        (turn_error=0.2 degrees, shift_error=0.004 units). The scenes are the same\n"
    "                        otherwise. Default: all 0\n"
    "\n"
    "example: ffprocams generate scenes --preset smoke --count 2\n"
    "         ffprocams generate mine --mesh vase.obj --material glazed_clay\n";

static bool is_one_of(const char *text, const char *const *words) {
    while (text && *words && strcmp(*words, text) != 0) words++;
    return text && *words;
}

// The exit code of a command line that is wrong, -1 of one that is right.
static int parse(int argc, char **argv, FfpGeneration *generation, FfpList *sensor) {
    enum { PRESET = 256, RIG, VIEWS, SEED, MATERIAL, SENSOR };
    static const struct option options[] = {{"split", required_argument, NULL, 's'},
                                            {"first", required_argument, NULL, 'a'},
                                            {"count", required_argument, NULL, 'n'},
                                            {"preset", required_argument, NULL, PRESET},
                                            {"rig", required_argument, NULL, RIG},
                                            {"views", required_argument, NULL, VIEWS},
                                            {"resolution", required_argument, NULL, 'r'},
                                            {"mesh", required_argument, NULL, 'm'},
                                            {"material", required_argument, NULL, MATERIAL},
                                            {"seed", required_argument, NULL, SEED},
                                            {"sensor", required_argument, NULL, SENSOR},
                                            {"help", no_argument, NULL, 'h'},
                                            {0}};
    int64_t resolution = 0, views = 0, seed = 0;
    bool number_ok = true;
    for (int option; number_ok && (option = ffp_cli_next(argc, argv, ":s:a:n:r:m:h", options)) != -1;) {
        switch (option) {
        case 's':
            generation->split = optarg;
            break;
        case 'a':
            number_ok = ffp_cli_number(optarg, 0, 1000000000, &generation->first);
            break;
        case 'n':
            number_ok = ffp_cli_number(optarg, 1, 1000000000, &generation->count);
            break;
        case PRESET:
            generation->preset = optarg;
            break;
        case RIG:
            generation->rig = optarg;
            break;
        case VIEWS:
            number_ok = ffp_cli_number(optarg, 1, 64, &views);
            break;
        case 'r':
            number_ok = ffp_cli_number(optarg, 8, 4096, &resolution);
            break;
        case SEED:
            number_ok = ffp_cli_number(optarg, 0, INT64_MAX, &seed);
            break;
        case 'm':
            generation->mesh = optarg;
            break;
        case MATERIAL:
            generation->material = optarg;
            break;
        case SENSOR:
            ffp_cli_append(sensor, optarg);
            break;
        case 'h':
            fputs(help, stdout);
            return FFP_EXIT_OK;
        default:
            return FFP_EXIT_USAGE;
        }
    }
    if (!number_ok) return ffp_cli_usage(argv[0], "%s is no number in its option's range", optarg);
    if (optind + 1 != argc) return ffp_cli_usage(argv[0], "give exactly one DIR");
    static const char *const splits[] = {"train", "validation", "test", NULL};
    static const char *const presets[] = {"paper", "smoke", "training", NULL};
    if (generation->split && !is_one_of(generation->split, splits))
        return ffp_cli_usage(argv[0], "--split is train, validation or test, not %s", generation->split);
    if (!is_one_of(generation->preset, presets))
        return ffp_cli_usage(argv[0], "--preset is paper, smoke or training, not %s", generation->preset);
    static const char *const rigs[] = {"turntable", "free", NULL};
    if (!is_one_of(generation->rig, rigs))
        return ffp_cli_usage(argv[0], "--rig is turntable or free, not %s", generation->rig);
    if (generation->split && generation->mesh)
        return ffp_cli_usage(argv[0], "--split is of the generated objects: not with --mesh");
    generation->folder = argv[optind];
    generation->resolution = (int)resolution;
    generation->views = (int)views;
    generation->seed = (uint64_t)seed;
    return -1;
}

int ffp_cli_generate(int argc, char **argv) {
    FfpGeneration generation = {.preset = "paper", .rig = "turntable", .count = -1};
    FfpList sensor = {0};
    FfpError err = {0};
    int status = parse(argc, argv, &generation, &sensor);
    if (status < 0) {
        generation.sensor = sensor.values, generation.n_sensor = sensor.count;
        status = ffp_generate(&generation, &err) ? FFP_EXIT_OK : ffp_cli_fail(&err);
    }
    ffp_cli_list_free(&sensor);
    return status;
}
