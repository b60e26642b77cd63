#include "world/synth/photographs.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/rigid.h"
#include "world/synth/pattern_folder.h"
#include "world/synth/photographing.h"
#include "world/synth/sensor.h"

typedef enum Wanted { WANTED_ALL, WANTED_CAPTURE, WANTED_CODES, WANTED_WHITE } Wanted;

// Something before the rig, photographed into a folder.
typedef struct Subject {
    char name[32];
    uint32_t stream; // its place among all, whether they are photographed or not
    int stop;        // of the board on the turntable: the number of its one photograph, else -1
    const FfpMesh *mesh;
    const FfpTracer *tracer;
    FfpMesh board_mesh;      // of a board alone; owned
    FfpTracer *board_tracer; // likewise
    FfpChessboard board;
    double angle; // by which the turntable has turned
    Wanted wanted;
} Subject;

typedef struct Job {
    const FfpPhotographs *options;
    const FfpSceneSpec *spec;
    const FfpMesh *mesh;
    FfpTracer *tracer;
    FfpMaterial material;
    FfpBareRig rig;
    FfpPatternFolder patterns;
    int n_subjects;
    Subject *subjects;
    const char *folder; // being written
    FfpPhotographing run;
} Job;

// --- Subjects. ---

static bool add_board(Subject *subject, FfpChessboard board, FfpError *err) {
    subject->board = board;
    subject->board_mesh = ffp_chessboard_mesh(&board);
    subject->mesh = &subject->board_mesh;
    subject->tracer = subject->board_tracer = ffp_tracer_new(&subject->board_mesh, err);
    return subject->tracer != NULL;
}

// The next of all subjects; NULL if it is not to be photographed.
static Subject *next_subject(Job *job, uint32_t *stream, const char *name) {
    const char *only = job->options->only;
    const uint32_t own = (*stream)++;
    if (only && strcmp(only, name) != 0) return NULL;
    Subject *s = &job->subjects[job->n_subjects++];
    *s = (Subject){.stream = own, .stop = -1};
    snprintf(s->name, sizeof s->name, "%s", name);
    return s;
}

static bool add_subjects(Job *job, FfpError *err) {
    const int views = job->spec->views, attitudes = job->options->attitudes;
    const int stops = attitudes > 0 ? FFP_BOARD_STOPS : 0;
    uint32_t stream = 0;
    char name[32];
    job->subjects = ffp_alloc((size_t)views + (size_t)attitudes + (size_t)stops + 1, sizeof *job->subjects);
    for (int i = 0; i < views; i++) {
        const double angle = 360.0 * i / views;
        snprintf(name, sizeof name, "view-%03d", (int)lround(angle)); // as `import` calls it
        Subject *s = next_subject(job, &stream, name);
        if (!s) continue;
        s->mesh = job->mesh, s->tracer = job->tracer;
        s->angle = angle, s->wanted = WANTED_ALL;
    }
    for (int i = 0; i < attitudes; i++) {
        snprintf(name, sizeof name, "attitude-%02d", i);
        Subject *s = next_subject(job, &stream, name);
        if (!s) continue;
        s->wanted = WANTED_CODES;
        if (!add_board(s, ffp_bare_rig_attitude(&job->rig, i, job->spec->seed), err)) return false;
    }
    for (int i = 0; i < stops; i++) {
        Subject *s = next_subject(job, &stream, "turntable");
        if (!s) continue;
        s->wanted = WANTED_WHITE, s->angle = ffp_board_angle(i);
        s->stop = i;
        if (!add_board(s, ffp_bare_rig_turntable_board(&job->rig), err)) return false;
    }
    Subject *empty = next_subject(job, &stream, "empty");
    if (empty) empty->wanted = WANTED_CAPTURE;
    return job->n_subjects > 0 ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "only", "nothing is called \"%s\" among what is photographed",
                    job->options->only);
}

static void free_subjects(Job *job) {
    for (int i = 0; i < job->n_subjects; i++) {
        ffp_tracer_free(job->subjects[i].board_tracer);
        ffp_mesh_free(&job->subjects[i].board_mesh);
    }
    ffp_free(job->subjects);
}

// --- Pictures. ---

static const char *name_of(const void *argument, int subject) {
    const Job *job = argument;
    return job->subjects[subject].name;
}

static bool is_wanted(const void *argument, int subject, int pattern) {
    const Job *job = argument;
    const Wanted wanted = job->subjects[subject].wanted;
    const char *name = job->patterns.list[pattern].name;
    if (wanted == WANTED_ALL || strcmp(name, "white") == 0) return true;
    if (wanted == WANTED_CAPTURE) return strncmp(name, "gray_", 5) != 0;
    return wanted == WANTED_CODES && (strcmp(name, "black") == 0 || strncmp(name, "gray_", 5) == 0);
}

static bool emit(const void *argument, int pattern, FfpImage *emitted, FfpError *err) {
    const Job *job = argument;
    return ffp_pattern_folder_emit(&job->patterns, pattern, &job->spec->sensor, emitted, err);
}

static bool write_photograph(const void *argument, int index, int pattern, FfpImage *image, FfpError *err) {
    const Job *job = argument;
    const Subject *subject = &job->subjects[index];
    char name[64], path[FFP_PATH_MAX];
    const int stop = subject->stop, number = stop >= 0 ? stop : job->patterns.list[pattern].number;
    snprintf(name, sizeof name, "%s/%0*d.png", subject->name, stop >= 0 ? 2 : 3, number);
    if (!ffp_photographing_path(job->folder, name, path, err)) return false;
    ffp_image_to_srgb(image);
    return ffp_image_write_png(image, path, err);
}

// What of the pixels the object fills, as somebody who cuts it out by hand would have it.
static bool write_mask(const Job *job, const Subject *subject, const FfpView *view, FfpError *err) {
    char name[64], path[FFP_PATH_MAX];
    snprintf(name, sizeof name, "masks/%s.png", subject->name);
    return ffp_photographing_path(job->folder, name, path, err) &&
           ffp_image_write_png(&view->coverage, path, err);
}

// Nothing stands before the rig, and nothing is around it: the dark, and the camera's noise.
static bool photograph_nothing(const Job *job, int index, int first, int count, FfpError *err) {
    const Subject *subject = &job->subjects[index];
    FfpView view = {.camera = job->rig.camera};
    view.images = ffp_alloc((size_t)count, sizeof *view.images);
    for (int i = 0; i < count; i++) {
        view.images[i] = ffp_image_new(view.camera.width, view.camera.height, 3);
        const uint32_t key = subject->stream * FFP_PATTERNS_MAX + (uint32_t)(first + i);
        ffp_sensor_expose(&view.images[i], &job->spec->sensor, key ^ (uint32_t)job->spec->seed);
    }
    const bool ok = ffp_photographing_develop(&job->run, index, &view, first, count, err);
    ffp_view_free(&view, count);
    return ok;
}

// The subject under the patterns of a batch.
static bool photograph(void *argument, int index, const FfpLight *light, int first, FfpError *err) {
    const Job *job = argument;
    const Subject *subject = &job->subjects[index];
    if (!subject->mesh) return photograph_nothing(job, index, first, light->n_patterns, err);
    const FfpSceneSpec *spec = job->spec;
    const float gain = exp2f(spec->sensor.exposure), intensity = gain * job->rig.intensity;
    const bool is_board = subject->wanted != WANTED_ALL;
    const FfpSimulation simulation = {.tracer = subject->tracer,
                                      .mesh = subject->mesh,
                                      .material = &job->material,
                                      .textures = spec->own_textures,
                                      .board = is_board ? &subject->board : NULL,
                                      .light = light,
                                      .intensity = {intensity, intensity, intensity},
                                      .ambient = gain * job->rig.ambient,
                                      .samples = spec->samples,
                                      .ambient_rays = spec->ambient_rays,
                                      .shot = spec->sensor.shot,
                                      .read = spec->sensor.read,
                                      .camera_lens = job->rig.camera_lens,
                                      .projector_lens = job->rig.projector_lens,
                                      .photograph = true,
                                      .first_pattern = first,
                                      .seed = spec->seed};
    FfpView view = {0};
    ffp_bare_rig_devices(&job->rig, subject->angle, &view.camera, &view.projector);
    ffp_simulate_view(&simulation, &view, subject->stream, NULL);
    const bool ok = ffp_photographing_develop(&job->run, index, &view, first, light->n_patterns, err) &&
                    (first > 0 || is_board || write_mask(job, subject, &view, err));
    ffp_view_free(&view, light->n_patterns);
    return ok;
}

static bool photograph_all(Job *job, FfpError *err) {
    char path[FFP_PATH_MAX];
    if (!ffp_photographing_path(job->folder, "masks", path, err) || !ffp_make_folders(path, err))
        return false;
    for (int s = 0; s < job->n_subjects; s++)
        if (!ffp_photographing_path(job->folder, job->subjects[s].name, path, err) ||
            !ffp_make_folders(path, err))
            return false;
    job->run = (FfpPhotographing){job,       &job->rig, job->patterns.count, job->n_subjects, name_of,
                                  is_wanted, emit,      photograph,          write_photograph};
    const int64_t count = ffp_photographing_run(&job->run, err);
    if (count >= 0)
        ffp_note("%s: %lld photographs of %s", job->options->folder, (long long)count,
                 job->options->attitudes > 0 ? "the object and of the chessboard" : "the object");
    return count >= 0;
}

// --- What is true. ---

static void print_numbers(FILE *f, const char *name, const double *values, int count) {
    fprintf(f, "  \"%s\": [", name);
    for (int i = 0; i < count; i++) fprintf(f, "%s%.9g", i > 0 ? ", " : "", values[i]);
    fputs("],\n", f);
}

// Intrinsics as OpenCV has them: pixel centres at integers.
static void print_device(FILE *f, const char *name, const FfpCamera *device, const double lens[5]) {
    char lens_name[16];
    snprintf(lens_name, sizeof lens_name, "%skc", name);
    fprintf(f, "  \"%sK\": [[%.9g, 0, %.9g], [0, %.9g, %.9g], [0, 0, 1]],\n", name, (double)device->fx,
            (double)device->cx - 0.5, (double)device->fy, (double)device->cy - 0.5);
    print_numbers(f, lens_name, lens, 5);
    const char *size = strcmp(name, "cam_") == 0 ? "cam" : "prj";
    fprintf(f, "  \"%sW\": %d,\n  \"%sH\": %d,\n", size, device->width, size, device->height);
}

// X_p = R X_c + T.
static void print_motion(FILE *f, const FfpBareRig *rig) {
    const FfpRigid camera = ffp_rigid_from_pose(rig->camera.pose),
                   projector = ffp_rigid_from_pose(rig->projector.pose);
    double r[9], t[3];
    ffp_rotation_difference(projector.r, camera.r, r);
    ffp_bare_rig_in_frame(&rig->projector, camera.t, true, t);
    fputs("  \"R\": [", f);
    for (int i = 0; i < 3; i++)
        fprintf(f, "%s[%.12g, %.12g, %.12g]", i > 0 ? ", " : "", r[3 * i], r[3 * i + 1], r[3 * i + 2]);
    fputs("],\n", f);
    print_numbers(f, "T", t, 3);
}

static void print_turntable(FILE *f, const Job *job) {
    const double up[3] = {0, 0, 1}, middle[3] = {0, 0, 0};
    double axis[3], point[3], stops[FFP_BOARD_STOPS];
    ffp_bare_rig_in_frame(&job->rig.camera, up, false, axis);
    ffp_bare_rig_in_frame(&job->rig.camera, middle, true, point);
    print_numbers(f, "axis", axis, 3);
    print_numbers(f, "point", point, 3);
    fputs("  \"angles\": [", f);
    for (int i = 0; i < job->spec->views; i++)
        fprintf(f, "%s%.9g", i > 0 ? ", " : "", 360.0 * i / job->spec->views);
    fputs("],\n", f);
    for (int i = 0; i < FFP_BOARD_STOPS; i++) stops[i] = ffp_board_angle(i);
    if (job->options->attitudes > 0) print_numbers(f, "board_angles", stops, FFP_BOARD_STOPS);
}

// The board's first corner and the directions of its rows and columns, in the camera's frame.
static void print_board(FILE *f, const Job *job, const Subject *subject, const char *between) {
    const FfpChessboard *b = &subject->board;
    FfpCamera camera, projector;
    double numbers[9];
    ffp_bare_rig_devices(&job->rig, subject->angle, &camera, &projector);
    const float *const from[3] = {b->origin, b->right, b->down};
    for (int i = 0; i < 3; i++) {
        const double v[3] = {(double)from[i][0], (double)from[i][1], (double)from[i][2]};
        ffp_bare_rig_in_frame(&camera, v, i == 0, numbers + 3 * i);
    }
    fprintf(f, "%s    {\"folder\": \"%s\", \"origin_right_down\": [", between, subject->name);
    for (int i = 0; i < 9; i++) fprintf(f, "%s%.9g", i > 0 ? ", " : "", numbers[i]);
    fputs("]}", f);
}

static bool write_truth(const Job *job, FfpError *err) {
    char path[FFP_PATH_MAX];
    FfpOutput out;
    if (!ffp_photographing_path(job->folder, "truth.json", path, err) || !ffp_output_open(&out, path, err))
        return false;
    FILE *f = out.stream;
    fputs("{\n", f);
    print_device(f, "cam_", &job->rig.camera, job->rig.camera_lens);
    print_device(f, "proj_", &job->rig.projector, job->rig.projector_lens);
    print_motion(f, &job->rig);
    print_turntable(f, job);
    const FfpChessboard board = ffp_bare_rig_turntable_board(&job->rig);
    fprintf(f, "  \"board\": {\"corners\": [%d, %d], \"square\": %.9g},\n  \"boards\": [\n", board.columns,
            board.rows, (double)board.square * FFP_BARE_RIG_UNIT);
    const char *between = "";
    for (int s = 0; s < job->n_subjects; s++)
        if (job->subjects[s].board.columns > 0) {
            print_board(f, job, &job->subjects[s], between);
            between = ",\n";
        }
    fputs("\n  ]\n}\n", f);
    const bool ok = ffp_output_commit(&out, err);
    ffp_output_abort(&out);
    return ok;
}

// --- All of it. ---

static bool write_folder(Job *job, FfpError *err) {
    FfpOutput folder;
    if (!ffp_capture_probe(job->options->folder, err) ||
        !ffp_output_open_folder(&folder, job->options->folder, true, err))
        return false;
    job->folder = folder.temporary;
    const bool ok = photograph_all(job, err) && write_truth(job, err) && ffp_output_commit(&folder, err);
    ffp_output_abort(&folder);
    job->folder = NULL;
    return ok;
}

bool ffp_photographs_write(const FfpPhotographs *options, const FfpSceneSpec *spec, FfpError *err) {
    Job job = {.options = options, .spec = spec, .material = ffp_material_make(spec->material, spec->seed)};
    if (!ffp_photographing_check(spec, options->attitudes, err) ||
        !ffp_pattern_folder_open(&job.patterns, options->patterns, err))
        return false;
    FfpMesh made = {0};
    if (!spec->own_mesh) made = ffp_mesh_make(spec->mesh);
    job.mesh = spec->own_mesh ? spec->own_mesh : &made;
    job.rig = ffp_bare_rig(spec->resolution, job.patterns.width, job.patterns.height);
    job.tracer = ffp_tracer_new(job.mesh, err);
    const bool ok = job.tracer && add_subjects(&job, err) && write_folder(&job, err);
    free_subjects(&job);
    ffp_tracer_free(job.tracer);
    ffp_mesh_free(&made);
    ffp_pattern_folder_close(&job.patterns);
    return ok;
}
