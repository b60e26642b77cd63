#include "synth/scene.h"

#include <stdio.h>
#include <stdlib.h>
#include "base/arena.h"
#include "synth/lollipop.h"
#include "synth/rig.h"
#include "synth/simulate.h"

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
        return ffp_fail(err, NULL, "there is no mesh %d", s->mesh);
    if (s->material < 0 || s->material >= ffp_material_count())
        return ffp_fail(err, NULL, "there is no material %d", s->material);
    if (s->resolution < 8 || s->resolution > 4096)
        return ffp_fail(err, NULL, "resolution %d is not in 8..4096", s->resolution);
    if (s->pattern_side < 60 || s->pattern_side > 8192)
        return ffp_fail(err, NULL, "pattern side %d is not in 60..8192", s->pattern_side);
    if (s->views < 1 || s->targets < 0 || s->views > 360 || s->targets > FFP_VIEWS_MAX - s->views)
        return ffp_fail(err, NULL, "%d views and %d targets are not in 1..360 and up to %d in all", s->views,
                        s->targets, FFP_VIEWS_MAX);
    if (s->lollipops < 0 || s->lollipops > FFP_PATTERNS_MAX - 2)
        return ffp_fail(err, NULL, "%d lollipops are too many or negative", s->lollipops);
    if (s->samples < 1 || s->samples > 65536 || s->ambient_rays < 0 || s->ambient_rays > 4096)
        return ffp_fail(err, NULL, "%d samples or %d ambient rays are out of range", s->samples,
                        s->ambient_rays);
    return true;
}

static void make_patterns(FfpCapture *capture, const FfpSceneSpec *spec) {
    const int side = spec->pattern_side;
    capture->n_patterns = 2 + spec->lollipops;
    capture->patterns = ffp_alloc((size_t)capture->n_patterns, sizeof *capture->patterns);
    capture->black = 0, capture->white = 1;
    uint8_t *map = ffp_lollipop_map(side, side);
    for (int p = 0; p < capture->n_patterns; p++) {
        FfpPattern *pattern = &capture->patterns[p];
        if (p >= 2) {
            snprintf(pattern->name, sizeof pattern->name, "lollipop_%d", p - 2);
            pattern->image = ffp_lollipop_paint(map, side, side, spec->seed * 1000003ULL + (uint64_t)p);
            continue;
        }
        snprintf(pattern->name, sizeof pattern->name, p == 0 ? "all_black" : "all_white");
        pattern->image = ffp_image_new(side, side, 3);
        for (size_t i = 0; i < (size_t)side * (size_t)side * 3; i++) pattern->image.data[i] = (real)p;
    }
    free(map);
}

// Poses and pictures of all views.
static void make_views(FfpCapture *capture, const FfpSceneSpec *spec, FfpSimulation *simulation,
                       FfpImage *visibility) {
    FfpLightPattern *patterns = ffp_alloc((size_t)capture->n_patterns, sizeof *patterns);
    for (int p = 0; p < capture->n_patterns; p++)
        patterns[p] = ffp_light_pattern_new(&capture->patterns[p].image);
    simulation->patterns = patterns;
    simulation->n_patterns = capture->n_patterns;
    capture->n_views = spec->views + spec->targets;
    capture->views = ffp_alloc((size_t)capture->n_views, sizeof *capture->views);
    for (int i = 0; i < capture->n_views; i++) {
        if (i < spec->views)
            ffp_rig_input(spec, i, &capture->views[i]);
        else
            ffp_rig_target(spec, i - spec->views, &capture->views[i]);
        ffp_simulate_view(simulation, &capture->views[i], (uint32_t)i, visibility ? &visibility[i] : NULL);
    }
    for (int p = 0; p < capture->n_patterns; p++) ffp_light_pattern_free(&patterns[p]);
    free(patterns);
}

bool ffp_scene_make_lit(FfpCapture *capture, const FfpSceneSpec *spec, FfpImage *visibility, FfpError *err) {
    *capture = (FfpCapture){0};
    if (!check_spec(spec, err)) return false;
    FfpMesh mesh = ffp_mesh_make(spec->mesh);
    FfpTracer *tracer = ffp_tracer_new(&mesh, err);
    if (!tracer) {
        ffp_mesh_free(&mesh);
        return false;
    }
    const FfpMaterial material = ffp_material_make(spec->material, spec->seed);
    const FfpRig rig = ffp_rig_light(spec);
    FfpSimulation simulation = {.tracer = tracer,
                                .mesh = &mesh,
                                .material = &material,
                                .ambient = rig.ambient,
                                .intensity = {rig.intensity[0], rig.intensity[1], rig.intensity[2]},
                                .samples = spec->samples,
                                .ambient_rays = spec->ambient_rays,
                                .seed = spec->seed};
    snprintf(capture->name, sizeof capture->name, "%s_%s", ffp_mesh_name(spec->mesh),
             ffp_material_name(spec->material));
    for (int c = 0; c < 3; c++) capture->intensity[c] = rig.intensity[c];
    capture->intensity_known = true;
    capture->radius = FFP_MESH_RADIUS;
    make_patterns(capture, spec);
    make_views(capture, spec, &simulation, visibility);
    ffp_tracer_free(tracer);
    ffp_mesh_free(&mesh);
    return true;
}

bool ffp_scene_make(FfpCapture *capture, const FfpSceneSpec *spec, FfpError *err) {
    return ffp_scene_make_lit(capture, spec, NULL, err);
}
