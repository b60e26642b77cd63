#include "world/synth/scene.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/file.h"
#include "core/patterns/lollipop.h"
#include "world/shapes/mesh.h"
#include "world/synth/natural.h"
#include "world/synth/rig.h"
#include "world/synth/sensor.h"
#include "world/synth/simulate.h"
#include "world/synth/walk.h"

FfpSceneSpec ffp_scene_defaults(void) {
    return (FfpSceneSpec){.resolution = 128,
                          .views = 8,
                          .targets = 4,
                          .lollipops = 4,
                          .pattern_side = 800,
                          .samples = 4,
                          .ambient_rays = 2};
}

static bool check_spec(const FfpSceneSpec *s, FfpError *err) {
    if (s->mesh < 0 || s->mesh >= ffp_mesh_count())
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "unknown mesh %d", s->mesh);
    if (s->material < 0 || s->material >= ffp_material_count())
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "unknown material %d", s->material);
    if ((s->own_mesh || s->own_textures) && (s->rig == FFP_SCENE_WALK || s->rig == FFP_SCENE_WALK_TWO))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL,
                        "a whole scene is made of generated objects: it takes no mesh or material");
    if (s->resolution < 8 || s->resolution > 4096)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "resolution %d is not in 8..4096", s->resolution);
    if (s->pattern_side < 60 || s->pattern_side > 8192)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "pattern side %d is not in 60..8192", s->pattern_side);
    if (s->views < 1 || s->targets < 0 || s->views > 360 || s->targets > FFP_VIEWS_MAX - s->views)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL,
                        "%d views and %d targets are not in 1..360 and up to %d in all", s->views, s->targets,
                        FFP_VIEWS_MAX);
    if (s->lollipops < 0 || s->naturals < 0 || s->lollipops > FFP_PATTERNS_MAX - 2 ||
        s->naturals > FFP_PATTERNS_MAX - 2 - s->lollipops)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL,
                        "%d lollipops and %d natural patterns are too many or negative", s->lollipops,
                        s->naturals);
    if (s->samples < 1 || s->samples > 65536 || s->ambient_rays < 0 || s->ambient_rays > 4096)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "%d samples or %d ambient rays are out of range",
                        s->samples, s->ambient_rays);
    return ffp_sensor_check(&s->sensor, err);
}

static FfpImage flat_pattern(int side, real value) {
    FfpImage image = ffp_image_new(side, side, 3);
    for (size_t i = 0; i < (size_t)side * (size_t)side * 3; i++) image.data[i] = value;
    return image;
}

// Black, white, the lollipops or pictures, the natural ones.
static void make_patterns(FfpCapture *capture, const FfpSceneSpec *spec) {
    const int side = spec->pattern_side;
    capture->n_patterns = 2 + spec->lollipops + spec->naturals;
    capture->patterns = ffp_alloc((size_t)capture->n_patterns, sizeof *capture->patterns);
    capture->black = 0, capture->white = 1;
    uint8_t *map = ffp_lollipop_map(side, side);
    for (int p = 0; p < capture->n_patterns; p++) {
        FfpPattern *pattern = &capture->patterns[p];
        const int natural = p - 2 - spec->lollipops;
        pattern->novel = natural >= 0;
        if (p < 2) {
            snprintf(pattern->name, sizeof pattern->name, p == 0 ? "all_black" : "all_white");
            pattern->image = flat_pattern(side, (real)p);
        } else if (natural < 0 && p > 2 && spec->own_patterns) {
            memcpy(pattern->name, spec->own_patterns[p - 3].name, sizeof pattern->name);
            pattern->image = ffp_image_copy(&spec->own_patterns[p - 3].image);
        } else if (natural < 0) {
            snprintf(pattern->name, sizeof pattern->name, "lollipop_%d", p - 2);
            pattern->image = ffp_lollipop_paint(map, side, side, spec->seed * 1000003ULL + (uint64_t)p);
        } else {
            snprintf(pattern->name, sizeof pattern->name, "%s_%d", ffp_natural_name(natural), natural);
            pattern->image = ffp_natural_pattern(side, side, natural, spec->seed);
        }
    }
    ffp_free(map);
}

// The projector's light for each pattern. `emitted` keeps the images that differ from the patterns.
static FfpLight make_light(const FfpCapture *capture, const FfpSensor *sensor, FfpImage *emitted) {
    const FfpImage **images = ffp_alloc((size_t)capture->n_patterns, sizeof *images);
    for (int p = 0; p < capture->n_patterns; p++) {
        images[p] = &capture->patterns[p].image;
        if (!ffp_sensor_changes_light(sensor)) continue;
        emitted[p] = ffp_sensor_emit(images[p], sensor);
        images[p] = &emitted[p];
    }
    FfpLight light = ffp_light_new(images, capture->n_patterns);
    if (sensor->focus_blur > 0) ffp_light_soften(&light);
    ffp_free((void *)images);
    return light;
}

// The stream of a view's random numbers. Those of the targets follow those of eight input views, however many
// there are: so targets are the same to the bit for any number of input views.
static uint32_t stream_of(const FfpSceneSpec *spec, int index) {
    enum { USUAL_VIEWS = 8, FURTHER_VIEWS = 0x10000 };
    if (index >= spec->views) return (uint32_t)(USUAL_VIEWS + index - spec->views);
    return (uint32_t)(index < USUAL_VIEWS ? index : FURTHER_VIEWS + index);
}

static void misplace(FfpView *view, const FfpSceneSpec *spec, uint32_t stream) {
    const FfpSensor *s = &spec->sensor;
    if (s->turn_error <= 0 && s->shift_error <= 0) return;
    FfpRng rng = ffp_rng(spec->seed, 0x5e4501ULL + stream);
    ffp_sensor_misplace(&view->camera, s->turn_error, s->shift_error, &rng);
    ffp_sensor_misplace(&view->projector, s->turn_error, s->shift_error, &rng);
}

// Where a view's devices stand. walk NULL: before an object.
static void place_view(const FfpSceneSpec *spec, const FfpWalk *walk, int index, FfpView *view) {
    const int target = index - spec->views;
    if (walk && target < 0)
        ffp_walk_input(walk, spec, index, view);
    else if (walk)
        ffp_walk_target(walk, spec, target, view);
    else if (target < 0)
        ffp_rig_input(spec, index, view);
    else
        ffp_rig_target(spec, target, view);
}

// Poses and pictures of all views.
static void make_views(FfpCapture *capture, const FfpSceneSpec *spec, const FfpWalk *walk,
                       FfpSimulation *simulation, FfpImage *visibility) {
    FfpImage *emitted = ffp_alloc((size_t)capture->n_patterns, sizeof *emitted);
    FfpLight light = make_light(capture, &spec->sensor, emitted);
    simulation->light = &light;
    capture->n_views = spec->views + spec->targets;
    capture->views = ffp_alloc((size_t)capture->n_views, sizeof *capture->views);
    for (int i = 0; i < capture->n_views; i++) {
        place_view(spec, walk, i, &capture->views[i]);
        const uint32_t stream = stream_of(spec, i);
        ffp_simulate_view(simulation, &capture->views[i], stream, visibility ? &visibility[i] : NULL);
        misplace(&capture->views[i], spec, stream);
    }
    simulation->light = NULL;
    ffp_light_free(&light);
    for (int p = 0; p < capture->n_patterns; p++) ffp_image_free(&emitted[p]);
    ffp_free(emitted);
}

// The subject of the photographs: an object, or a whole scene around it.
typedef struct Subject {
    FfpMesh made;
    FfpWalk walk;
    FfpSurroundings around;
    const FfpMesh *mesh; // for the rays
    bool whole;
} Subject;

static void make_subject(Subject *out, const FfpSceneSpec *spec) {
    *out = (Subject){.whole = spec->rig == FFP_SCENE_WALK || spec->rig == FFP_SCENE_WALK_TWO};
    if (out->whole) {
        out->walk = ffp_walk_draw(spec);
        out->around = ffp_around_new(&out->walk.room, NULL, 0);
        out->mesh = &out->around.mesh;
        return;
    }
    if (!spec->own_mesh) out->made = ffp_mesh_make(spec->mesh);
    out->mesh = spec->own_mesh ? spec->own_mesh : &out->made;
}

static void free_subject(Subject *subject) {
    if (subject->whole) {
        ffp_around_free(&subject->around);
        ffp_walk_free(&subject->walk);
    }
    ffp_mesh_free(&subject->made);
}

void ffp_asset_name(const char *path, char name[FFP_NAME_MAX]) {
    snprintf(name, FFP_NAME_MAX, "%s", ffp_basename(path));
    char *dot = strrchr(name, '.');
    if (dot && dot != name) *dot = 0;
    for (char *c = name; *c; c++)
        if (!isalnum((unsigned char)*c) && *c != '-') *c = '_';
}

static void name_capture(FfpCapture *capture, const FfpSceneSpec *spec, bool whole) {
    char material[FFP_NAME_MAX] = "own";
    if (spec->own_material) ffp_asset_name(spec->own_material, material);
    if (whole)
        snprintf(capture->name, sizeof capture->name, "%.40s_%.40s", ffp_walk_name(spec),
                 ffp_mesh_name(spec->mesh));
    else
        snprintf(capture->name, sizeof capture->name, "%.40s_%.40s",
                 spec->own_mesh ? spec->own_name : ffp_mesh_name(spec->mesh),
                 spec->own_textures ? material : ffp_material_name(spec->material));
}

static FfpSimulation simulation_of(const FfpSceneSpec *spec, Subject *subject, const FfpMaterial *material) {
    FfpRigLight rig = ffp_rig_light(spec);
    if (subject->whole) {
        rig.ambient = subject->walk.ambient;
        for (int c = 0; c < 3; c++) rig.intensity[c] = subject->walk.intensity;
    }
    const float gain =
        exp2f(spec->sensor.exposure); // of all light alike, so that every map agrees with the images
    for (int c = 0; c < 3; c++) rig.intensity[c] *= gain;
    rig.ambient *= gain;
    subject->around.lamp.radiance *= gain;
    return (FfpSimulation){.mesh = subject->mesh,
                           .material = material,
                           .textures = spec->own_textures,
                           .ambient = rig.ambient,
                           .intensity = {rig.intensity[0], rig.intensity[1], rig.intensity[2]},
                           .samples = spec->samples,
                           .ambient_rays = spec->ambient_rays,
                           .shot = spec->sensor.shot,
                           .read = spec->sensor.read,
                           .seed = spec->seed,
                           .sensor = &spec->sensor,
                           .around = subject->whole ? &subject->around : NULL,
                           .whole = subject->whole};
}

static bool make_lit(FfpCapture *capture, const FfpSceneSpec *spec, Subject *subject, FfpImage *visibility,
                     FfpError *err) {
    FfpTracer *tracer = ffp_tracer_new(subject->mesh, err);
    if (!tracer) return false;
    const FfpMaterial material = ffp_material_make(spec->material, spec->seed);
    FfpSimulation simulation = simulation_of(spec, subject, &material);
    simulation.tracer = tracer;
    name_capture(capture, spec, subject->whole);
    for (int c = 0; c < 3; c++) capture->intensity[c] = simulation.intensity[c];
    capture->intensity_known = true;
    capture->radius = FFP_MESH_RADIUS;
    capture->scene = subject->whole;
    make_patterns(capture, spec);
    make_views(capture, spec, subject->whole ? &subject->walk : NULL, &simulation, visibility);
    if (capture->scene) ffp_capture_estimate_bounds(capture);
    ffp_tracer_free(tracer);
    return true;
}

bool ffp_scene_make_lit(FfpCapture *capture, const FfpSceneSpec *spec, FfpImage *visibility, FfpError *err) {
    *capture = (FfpCapture){0};
    if (!check_spec(spec, err)) return false;
    Subject subject;
    FfpSceneSpec settled = *spec;
    ffp_sensor_settle(&settled.sensor, spec->seed);
    make_subject(&subject, spec);
    const bool ok = make_lit(capture, &settled, &subject, visibility, err);
    free_subject(&subject);
    return ok;
}

bool ffp_scene_make(FfpCapture *capture, const FfpSceneSpec *spec, FfpError *err) {
    return ffp_scene_make_lit(capture, spec, NULL, err);
}
