// A rig as a user has it, simulated: photographs, a calibration file and a turntable go through `import`, the
// capture is reconstructed, and the pictures predicted are scored against those of the faultless rig. One
// fault at a time, then all. Prints a table in Markdown.
//   degraded_rig FOLDER [MODEL.safetensors] [OBJECTS] [FIRST]
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/file.h"
#include "engine/loss/metrics.h"
#include "engine/pipeline/relight.h"
#include "rig/optics/matrix.h"
#include "world/shapes/mesh.h"
#include "world/synth/synth.h"

#define OFF_CENTRE 200 // pixels that the projector's panel is wider to the left of the light
#define VIEWS 8

// Faults of a rig, and the user's remedies.
enum {
    NOISE = 1,
    DEFOCUS = 2,
    GAMMA = 4,
    CALIBRATION = 8,
    PANEL = 16,
    FIT_RESPONSE = 32,
    FIT_AXIS = 64,
    ALIGN = 128
};

static const struct {
    const char *name;
    unsigned faults;
} rows[] = {
    {"no fault", 0},
    {"noise of 1 %", NOISE},
    {"projector out of focus by 2 pixels", DEFOCUS},
    {"projector gamma 2.2", GAMMA},
    {"the same, `--fit-response`", GAMMA | FIT_RESPONSE},
    {"calibration off by 0.5 pixels", CALIBRATION},
    {"the same, `align`", CALIBRATION | ALIGN},
    {"off-centre projector", PANEL},
    {"axis not known, `--fit-axis`", FIT_AXIS},
    {"all faults", NOISE | DEFOCUS | GAMMA | CALIBRATION | PANEL},
    {"the same, `align`", NOISE | DEFOCUS | GAMMA | CALIBRATION | PANEL | ALIGN},
    {"all faults, both fits", NOISE | DEFOCUS | GAMMA | CALIBRATION | PANEL | FIT_RESPONSE | FIT_AXIS},
};
enum { ROWS = sizeof rows / sizeof *rows, PROTOCOLS = 3, FORMS = 2 };

typedef struct Score {
    double sum[FORMS][PROTOCOLS]; // without and with the polish; rendering, novel pattern, novel pose
    int count[FORMS][PROTOCOLS];
} Score;

typedef struct Bench {
    const char *folder;
    FfpModel *model;
    FfpCapture truth; // the faultless rig, with targets behind the input views
    Score scores[ROWS];
} Bench;

// --- The rig. ---

static FfpSceneSpec spec_of(int object, unsigned faults) {
    FfpSceneSpec spec = ffp_scene_defaults();
    int meshes[64];
    const int n = ffp_split_meshes("test", meshes, 64);
    spec.mesh = meshes[object % n];
    spec.material = 3 * object % ffp_material_count();
    spec.seed = 700 + (uint64_t)object;
    spec.naturals = 2;
    spec.views = VIEWS;
    if (faults & NOISE) spec.sensor.read = 0.01F;
    if (faults & DEFOCUS) spec.sensor.defocus = 2;
    return spec;
}

// --- What the user has: photographs, masks, patterns, a calibration file, an axis. ---

static bool save(const FfpImage *linear, const char *folder, const char *name, FfpError *err) {
    char path[FFP_PATH_MAX];
    FfpImage image = ffp_image_copy(linear);
    if (image.channels == 3) ffp_image_to_srgb(&image);
    const bool ok = ffp_join_path(path, folder, name) && ffp_image_write_png(&image, path, err);
    ffp_image_free(&image);
    return ok;
}

// The file of a pattern whose light is `light`: of a projector that makes value^2.2 of values, and of a panel
// that is wider than the lit part.
static bool save_pattern(const FfpImage *light, unsigned faults, const char *folder, const char *name,
                         FfpError *err) {
    const int left = faults & PANEL ? OFF_CENTRE : 0;
    FfpImage file = ffp_image_new(light->width + left, light->height, 3);
    for (int i = 0; i < 3 * light->width * light->height; i++) {
        const int row = i / (3 * light->width), at = i % (3 * light->width);
        const double value = (double)light->data[i];
        file.data[3 * file.width * row + 3 * left + at] =
            faults & GAMMA ? ffp_srgb_decode((real)pow(value, 1 / 2.2)) : light->data[i];
    }
    const bool ok = save(&file, folder, name, err);
    ffp_image_free(&file);
    return ok;
}

static bool save_pictures(const FfpCapture *seen, unsigned faults, const char *folder, FfpError *err) {
    char name[2 * FFP_NAME_MAX];
    bool ok = ffp_make_folders(folder, err);
    for (int v = 0; v < VIEWS && ok; v++) {
        snprintf(name, sizeof name, "%d_mask.png", v);
        ok = save(&seen->views[v].coverage, folder, name, err);
        for (int p = 0; p < seen->n_patterns && ok; p++) {
            if (seen->patterns[p].novel) continue;
            snprintf(name, sizeof name, "%d_%s.png", v, seen->patterns[p].name);
            ok = save(&seen->views[v].images[p], folder, name, err);
        }
    }
    for (int p = 0; p < seen->n_patterns && ok; p++) {
        if (p == seen->black || p == seen->white || seen->patterns[p].novel) continue;
        snprintf(name, sizeof name, "%s.png", seen->patterns[p].name);
        ok = save_pattern(&seen->patterns[p].image, faults, folder, name, err);
    }
    return ok;
}

static void poses_of(const FfpView *view, double c2w[16], double p2w[16]) {
    for (int i = 0; i < 16; i++) {
        c2w[i] = (double)view->camera.pose[i];
        p2w[i] = (double)view->projector.pose[i];
    }
}

static void put(FILE *out, const char *key, int height, int width, const double *values) {
    fprintf(out, "%s: !!opencv-matrix\n   rows: %d\n   cols: %d\n   dt: d\n   data: [ ", key, height, width);
    for (int i = 0; i < height * width; i++) fprintf(out, "%s%.12e", i > 0 ? ", " : "", values[i]);
    fputs(" ]\n", out);
}

// Principal points and the directions between the devices off by half a pixel each, where they are to be.
static bool save_calibration(const FfpView *view, unsigned faults, const char *path, FfpError *err) {
    static const double none[5] = {0};
    const double off = faults & CALIBRATION ? 0.5 : 0, left = faults & PANEL ? OFF_CENTRE : 0;
    const FfpCamera *c = &view->camera, *p = &view->projector;
    const double k[9] = {(double)c->fx + off,
                         0,
                         (double)c->cx - 0.5 + off,
                         0,
                         (double)c->fy + off,
                         (double)c->cy - 0.5 - off,
                         0,
                         0,
                         1},
                 l[9] = {(double)p->fx - off,
                         0,
                         (double)p->cx - 0.5 + left - off,
                         0,
                         (double)p->fy - off,
                         (double)p->cy - 0.5 + off,
                         0,
                         0,
                         1};
    double c2w[16], p2w[16], w2p[16], c2p[16], turned[16], r[9], t[3];
    const double angle = off / (double)c->fx, turn[16] = {cos(angle),  0, sin(angle), 0, 0, 1, 0, 0,
                                                          -sin(angle), 0, cos(angle), 0, 0, 0, 0, 1};
    poses_of(view, c2w, p2w);
    ffp_pose_inverse(p2w, w2p);
    ffp_pose_product(w2p, c2w, c2p);
    ffp_pose_product(turn, c2p, turned);
    for (int i = 0; i < 9; i++) r[i] = turned[4 * (i / 3) + i % 3];
    for (int i = 0; i < 3; i++) t[i] = c2p[4 * i + 3];
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) return false;
    fputs("%YAML:1.0\n---\n", out.stream);
    put(out.stream, "camK", 3, 3, k);
    put(out.stream, "camKc", 1, 5, none);
    put(out.stream, "prjK", 3, 3, l);
    put(out.stream, "prjKc", 1, 5, none);
    put(out.stream, "R", 3, 3, r);
    put(out.stream, "T", 3, 1, t);
    return ffp_output_commit(&out, err);
}

// The object turns by -45 degrees a stop about the world's z axis, as the first camera sees it; a calibration
// that errs has the axis off by half a pixel, too.
static FfpImportTurntable turntable_of(const FfpView *view, unsigned faults) {
    static const double angles[8] = {0, -45, -90, -135, -180, -225, -270, -315};
    double c2w[16], p2w[16], w[16];
    poses_of(view, c2w, p2w);
    ffp_pose_inverse(c2w, w);
    const double off = faults & CALIBRATION ? 0.5 * w[11] / (double)view->camera.fx : 0;
    return (FfpImportTurntable){.axis = {w[2], w[6], w[10]},
                                .point = {w[3] + off, w[7], w[11]},
                                .angles = angles,
                                .n_angles = 8,
                                .find_axis = (faults & FIT_AXIS) != 0};
}

// --- Import, reconstruction, scores. ---

static bool import(FfpCapture *capture, const FfpCapture *seen, unsigned faults, const char *folder,
                   FfpError *err) {
    char calibration[FFP_PATH_MAX], images[FFP_PATH_MAX + 32], mask[FFP_PATH_MAX + 32], into[FFP_PATH_MAX],
        files[8][FFP_PATH_MAX + 128];
    const char *calibrations[1] = {calibration}, *names[FFP_PATTERNS_MAX];
    FfpImportPattern patterns[8];
    FfpImportImages shots = {names, 0, images};
    int n = 0;
    if (!ffp_join_path(calibration, folder, "calibration.yml") || !ffp_join_path(into, folder, "capture") ||
        !save_pictures(seen, faults, folder, err) ||
        !save_calibration(&seen->views[0], faults, calibration, err))
        return false;
    for (int p = 0; p < seen->n_patterns; p++) {
        if (seen->patterns[p].novel) continue;
        names[shots.n_patterns++] = seen->patterns[p].name;
        if (p == seen->black || p == seen->white || n == 8) continue;
        const int needed = snprintf(files[n], sizeof files[n], "%s/%s.png", folder, seen->patterns[p].name);
        if (needed < 0 || (size_t)needed >= sizeof files[n])
            return ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "the path is too long");
        patterns[n] = (FfpImportPattern){seen->patterns[p].name, files[n]};
        n++;
    }
    snprintf(images, sizeof images, "%s/{index}_{pattern}.png", folder);
    snprintf(mask, sizeof mask, "%s/{index}_mask.png", folder);
    const FfpImport options = {
        .size = sizeof options,
        .calibrations = calibrations,
        .n_calibrations = 1,
        .turntable = turntable_of(&seen->views[0], faults),
        .images = &shots,
        .n_images = 1,
        .patterns = patterns,
        .n_patterns = n,
        .masks = FFP_MASKS_FROM_FILES,
        .mask_files = mask,
        .folder = into,
        .fit_response = (faults & FIT_RESPONSE) != 0,
        .camera = {.width = seen->views[0].camera.width, .height = seen->views[0].camera.height},
        .projector = {.width = seen->views[0].projector.width + (faults & PANEL ? OFF_CENTRE : 0),
                      .height = seen->views[0].projector.height}};
    return ffp_import_capture(NULL, &options, err) && ffp_capture_read(capture, into, err);
}

// A view of the true world in the world of the import. That is made by the table's axis: its z axis, with the
// x axis to the first camera; where the axis is found, its origin is too, and the first camera tells the
// world.
static FfpView placed(const FfpCapture *truth, int index, const FfpCapture *imported, unsigned faults) {
    FfpView view = truth->views[index];
    double c2w[16], p2w[16], w2c[16], found[16], anchor[16], out[16];
    poses_of(&truth->views[0], c2w, p2w);
    ffp_pose_inverse(c2w, w2c);
    poses_of(&imported->views[0], found, p2w);
    ffp_pose_product(found, w2c, anchor);
    const double flat = hypot(c2w[3], c2w[7]), x = c2w[3] / flat, y = c2w[7] / flat;
    const double table[16] = {x, y, 0, 0, -y, x, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    FfpCamera *const devices[2] = {&view.camera, &view.projector};
    for (int k = 0; k < 2; k++) {
        double pose[16];
        for (int i = 0; i < 16; i++) pose[i] = (double)devices[k]->pose[i];
        ffp_pose_product(faults & FIT_AXIS ? anchor : table, pose, out);
        for (int i = 0; i < 16; i++) devices[k]->pose[i] = (real)out[i];
    }
    return view;
}

static void score(Bench *bench, const FfpGaussians *gaussians, const FfpCapture *imported, unsigned faults,
                  int form, Score *scores) {
    const FfpCapture *truth = &bench->truth;
    const FfpRenderSettings settings = ffp_drawing_settings((FfpDrawing){0}, bench->model);
    FfpViewPass *pass = ffp_view_pass_new(&settings);
    FfpSummed *sums = ffp_alloc((size_t)truth->n_patterns, sizeof *sums);
    for (int p = 0; p < truth->n_patterns; p++) sums[p] = ffp_summed_new(&truth->patterns[p].image);
    for (int v = 0; v < truth->n_views; v++) {
        const FfpView view = placed(truth, v, imported, faults);
        ffp_view_pass_draw(pass, gaussians, &view.camera, &view.projector);
        for (int p = 0; p < truth->n_patterns; p++) {
            const int protocol = v >= VIEWS ? 2 : truth->patterns[p].novel;
            FfpImage picture = ffp_relight(pass, imported->intensity, &sums[p]),
                     clean = ffp_image_copy(&truth->views[v].images[p]);
            ffp_image_to_srgb(&clean);
            scores->sum[form][protocol] += ffp_psnr(&picture, &clean);
            scores->count[form][protocol]++;
            ffp_image_free(&picture);
            ffp_image_free(&clean);
        }
    }
    for (int p = 0; p < truth->n_patterns; p++) ffp_summed_free(&sums[p]);
    ffp_free(sums);
    ffp_view_pass_free(pass);
}

// A row that cannot be imported leaves its cells empty, and the reason on stderr.
static void run_row(Bench *bench, int object, int row) {
    const FfpSceneSpec spec = spec_of(object, rows[row].faults);
    char folder[FFP_PATH_MAX], name[32];
    FfpError err = {0};
    FfpCapture seen = {0}, imported = {0};
    snprintf(name, sizeof name, "object_%d_row_%d", object, row);
    bool ok = ffp_join_path(folder, bench->folder, name) && ffp_scene_make(&seen, &spec, &err) &&
              import(&imported, &seen, rows[row].faults, folder, &err);
    const FfpAlignment alignment = ffp_alignment_defaults();
    if (ok && rows[row].faults & ALIGN) ok = ffp_align_poses(NULL, &imported, &alignment, NULL, &err);
    ffp_capture_free(&seen);
    for (int form = 0; form < FORMS && ok; form++) {
        const FfpReconstruction options = {.size = sizeof options,
                                           .model = bench->model,
                                           .polish = form * FFP_POLISH_STEPS,
                                           .noise = FFP_NOISE_ESTIMATED,
                                           .layers = FFP_LAYERS_AUTO};
        FfpGaussians *gaussians = ffp_reconstruct(NULL, &imported, &options, NULL, &err);
        if (gaussians) score(bench, gaussians, &imported, rows[row].faults, form, &bench->scores[row]);
        ok = gaussians != NULL;
        ffp_gaussians_close(gaussians);
    }
    if (ok) ffp_capture_free(&imported);
    if (!ok) fprintf(stderr, "%s, object %d: %s\n", rows[row].name, object, err.text);
}

static void print_table(const Bench *bench, int objects) {
    printf(
        "| %d objects | rendering | novel pattern | novel pose | rendering | novel pattern | novel pose |\n"
        "|---|---|---|---|---|---|---|\n",
        objects);
    for (int row = 0; row < ROWS; row++) {
        printf("| %s |", rows[row].name);
        for (int i = 0; i < FORMS * PROTOCOLS; i++) {
            const Score *s = &bench->scores[row];
            const int form = i / PROTOCOLS, protocol = i % PROTOCOLS;
            if (s->count[form][protocol] > 0)
                printf(" %.1f |", s->sum[form][protocol] / s->count[form][protocol]);
            else
                printf(" |");
        }
        printf("\n");
    }
}

int main(int argc, char **argv) {
    if (argc < 2 || argv[1][0] == '-') {
        fprintf(stderr, "usage: degraded_rig FOLDER [MODEL.safetensors] [OBJECTS] [FIRST]\n");
        return 2;
    }
    const int objects = argc > 3 ? atoi(argv[3]) : 2, first = argc > 4 ? atoi(argv[4]) : 0;
    FfpError err = {0};
    Bench *bench = ffp_alloc(1, sizeof *bench);
    bench->folder = argv[1];
    bench->model = ffp_model_open(NULL, argc > 2 ? argv[2] : NULL, &err);
    bool ok = bench->model && ffp_make_folders(bench->folder, &err);
    for (int object = first; object < first + objects && ok; object++) {
        const FfpSceneSpec spec = spec_of(object, 0);
        if (!(ok = ffp_scene_make(&bench->truth, &spec, &err))) break;
        for (int row = 0; row < ROWS; row++) run_row(bench, object, row);
        ffp_capture_free(&bench->truth);
    }
    if (ok)
        print_table(bench, objects);
    else
        fprintf(stderr, "degraded_rig: error: %s\n", err.text);
    ffp_model_close(bench->model);
    ffp_free(bench);
    return !ok;
}
