#include "world/synth/walk.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/real.h"
#include "core/base/rng.h"
#include "world/shapes/mesh.h"
#include "world/shapes/noise.h"
#include "world/shapes/solids.h"
#include "world/synth/rig.h"

// One stream for each thing, so that a change of one leaves the others as they are.
enum { STREAM_SHELL = 8100, STREAM_THINGS, STREAM_LIGHT, STREAM_WALK, STREAM_TARGET = 8200 };
static const double DEGREE = FFP_PI_DOUBLE / 180;

// Decisions that the rest depends on.
typedef struct Plan {
    const FfpSceneSpec *spec;
    FfpWalk *walk;
    FfpRng rng;
} Plan;

static float draw(Plan *plan, float low, float high) {
    return ffp_rng_range(&plan->rng, low, high);
}

// --- Parts. ---

static FfpRoomPart *new_part(Plan *plan, FfpMesh mesh) {
    FfpRoom *room = &plan->walk->room;
    FfpRoomPart *part = &room->parts[room->n_parts++];
    part->mesh = mesh;
    return part;
}

static void dress_in(FfpRoomPart *part, int material, FfpRng *rng) {
    part->material = ffp_material_make(material, ffp_rng_u32(rng));
}

static int material_named(const char *name) {
    int number = 0;
    while (number + 1 < ffp_material_count() && strcmp(ffp_material_name(number), name) != 0) number++;
    return number;
}

// One of a wall's or a floor's looks, or a plain grey.
static void dress_shell(Plan *plan, FfpRoomPart *part, const char *const *kinds, int count) {
    const int kind = (int)ffp_rng_below(&plan->rng, (uint32_t)count + 1);
    if (kind < count) {
        dress_in(part, material_named(kinds[kind]), &plan->rng);
        return;
    }
    const float grey = draw(plan, 0.35F, 0.75F);
    part->plain = true;
    part->roughness = draw(plan, 0.5F, 0.95F);
    for (int c = 0; c < 3; c++) part->albedo[c] = grey * (1 + draw(plan, -0.06F, 0.06F));
}

static void dress_wall(Plan *plan, FfpRoomPart *part) {
    static const char *const kinds[] = {"plaster", "stucco", "concrete", "brick", "fresco", "paint"};
    dress_shell(plan, part, kinds, 6);
}

static void dress_floor(Plan *plan, FfpRoomPart *part) {
    static const char *const kinds[] = {"wood", "parquet", "slate", "terrazzo", "concrete", "checks"};
    dress_shell(plan, part, kinds, 6);
}

static void dress_thing(Plan *plan, FfpRoomPart *part) {
    dress_in(part, (int)ffp_rng_below(&plan->rng, (uint32_t)ffp_material_count()), &plan->rng);
}

static FfpRoomPart *add_box(Plan *plan, const float centre[3], const float half[3], float turn) {
    return new_part(plan, ffp_solid_box(centre, half, turn));
}

// Scales a mesh, turns it about its vertical axis and moves it.
static void place_mesh(FfpMesh *mesh, float scale, float turn, const float to[3]) {
    const float c = cosf(turn), s = sinf(turn);
    for (size_t i = 0; i < (size_t)mesh->n_vertices; i++) {
        float *p = mesh->positions + 3 * i, *n = mesh->normals + 3 * i;
        const float x = p[0], y = p[1], u = n[0], v = n[1];
        p[0] = scale * (c * x - s * y) + to[0], p[1] = scale * (s * x + c * y) + to[1];
        p[2] = scale * p[2] + to[2];
        n[0] = c * u - s * v, n[1] = s * u + c * v;
    }
}

// An object that stands at (x, y) on a height; the first is the spec's.
static void add_object(Plan *plan, bool first, float x, float y, float floor, float radius) {
    const int any = (int)ffp_rng_below(&plan->rng, (uint32_t)ffp_mesh_count());
    FfpMesh mesh = ffp_mesh_make(first ? plan->spec->mesh : any);
    const float turn = draw(plan, 0, 6.28F), scale = radius / FFP_MESH_RADIUS;
    const float to[3] = {x, y, floor - scale * ffp_room_floor(&mesh)};
    place_mesh(&mesh, scale, turn, to);
    FfpRoomPart *part = new_part(plan, mesh);
    if (first)
        part->material = ffp_material_make(plan->spec->material, plan->spec->seed);
    else
        dress_thing(plan, part);
}

static void add_column(Plan *plan, float x, float y, float radius, float bottom, float top) {
    const float to[3] = {x, y, 0};
    FfpMesh mesh = ffp_solid_cylinder(radius, bottom, top);
    place_mesh(&mesh, 1, 0, (const float[3]){0, 0, 0});
    for (size_t i = 0; i < (size_t)mesh.n_vertices; i++)
        for (size_t k = 0; k < 2; k++) mesh.positions[3 * i + k] += to[k];
    dress_wall(plan, new_part(plan, mesh));
}

static void add_floor(Plan *plan) {
    const float centre[3] = {0, 0, -0.1F}, half[3] = {40, 40, 0.1F};
    dress_floor(plan, add_box(plan, centre, half, 0));
}

// A wall whose face passes `away` behind the middle, its normal turned by an angle from +x.
static void add_wall(Plan *plan, float away, float turn) {
    const float thick = 0.2F, c = cosf(turn), s = sinf(turn), far = away + thick;
    const float centre[3] = {-far * c, -far * s, 4}, half[3] = {thick, 40, 4.2F};
    dress_wall(plan, add_box(plan, centre, half, turn));
}

// --- Kinds of scene: parts before a camera that looks along -x at about (0, 0, 1). ---

static void make_corner(Plan *plan) {
    const float turn = draw(plan, 0.65F, 0.95F);
    add_floor(plan);
    add_wall(plan, draw(plan, 1, 1.5F), turn);
    add_wall(plan, draw(plan, 1, 1.5F), turn - 1.5708F);
    add_object(plan, true, draw(plan, -0.2F, 0.4F), draw(plan, -0.3F, 0.3F), 0, draw(plan, 0.5F, 0.7F));
    const float low = draw(plan, 0.2F, 0.35F), x = draw(plan, 0.2F, 0.8F), y = draw(plan, 0.9F, 1.3F);
    const float centre[3] = {x, y, low}, half[3] = {draw(plan, 0.2F, 0.4F), draw(plan, 0.2F, 0.4F), low};
    dress_thing(plan, add_box(plan, centre, half, draw(plan, -0.7F, 0.7F)));
    add_object(plan, false, x, y, 2 * low, 0.25F);
    add_object(plan, false, draw(plan, 0.2F, 0.8F), draw(plan, -1.3F, -0.9F), 0, draw(plan, 0.25F, 0.4F));
}

static void make_table(Plan *plan) {
    const float high = 0.75F, deep = draw(plan, 0.8F, 1), wide = draw(plan, 1.3F, 1.7F);
    const float centre[3] = {0, 0, high - 0.05F}, half[3] = {deep, wide, 0.05F};
    add_floor(plan);
    add_wall(plan, draw(plan, 1.5F, 2.2F), draw(plan, -0.2F, 0.2F));
    dress_floor(plan, add_box(plan, centre, half, 0));
    for (int leg = 0; leg < 4; leg++)
        add_column(plan, (leg % 2 ? 0.9F : -0.9F) * deep, (leg / 2 ? 0.9F : -0.9F) * wide, 0.06F, 0,
                   high - 0.1F);
    for (int i = 0; i < 5; i++) {
        const float y = wide * (-0.7F + 0.35F * (float)i) + draw(plan, -0.05F, 0.05F);
        const float x = draw(plan, -0.4F, 0.4F) * deep;
        add_object(plan, i == 2, x, y, high, i == 2 ? 0.4F : draw(plan, 0.2F, 0.3F));
    }
}

static void make_columns(Plan *plan) {
    add_floor(plan);
    add_wall(plan, draw(plan, 1.5F, 2.2F), draw(plan, -0.25F, 0.25F));
    const int count = 3 + (int)ffp_rng_below(&plan->rng, 2);
    for (int i = 0; i < count; i++) {
        const float y = 3.2F * ((float)i / (float)(count - 1) - 0.5F) + draw(plan, -0.15F, 0.15F);
        const float x = draw(plan, -0.9F, 0.4F), radius = draw(plan, 0.15F, 0.3F);
        const float centre[3] = {x, y, 0.15F}, half[3] = {1.4F * radius, 1.4F * radius, 0.15F};
        add_column(plan, x, y, radius, 0.3F, 5);
        dress_wall(plan, add_box(plan, centre, half, 0));
    }
    add_object(plan, true, draw(plan, 0.3F, 0.6F), draw(plan, -0.6F, 0.6F), 0, draw(plan, 0.4F, 0.55F));
}

static void make_facade(Plan *plan) {
    add_floor(plan);
    add_wall(plan, 0.8F, 0);
    const float face = -0.8F, from = 0.5F, tall = draw(plan, 0.35F, 0.5F), wide = draw(plan, 0.2F, 0.3F);
    for (int i = 0; i < 6; i++) { // windows: a frame of two jambs, a sill, and a ledge above
        const float y = 1.2F * (float)(i % 3 - 1), z = from + 0.4F + 1.5F * (float)(i / 3);
        const float rise = draw(plan, 0.08F, 0.2F);
        const float sill[3] = {face, y, z - tall}, ledge[3] = {face, y, z + tall},
                    jamb[2][3] = {{face, y - wide, z}, {face, y + wide, z}};
        const float flat[3] = {rise, 1.3F * wide, 0.05F}, post[3] = {0.7F * rise, 0.05F, tall};
        FfpRoomPart *first = add_box(plan, sill, flat, 0);
        dress_wall(plan, first);
        add_box(plan, ledge, flat, 0);
        for (int k = 0; k < 2; k++) add_box(plan, jamb[k], post, 0);
        for (FfpRoomPart *part = first + 1; part < first + 4; part++) {
            const FfpMesh mesh = part->mesh;
            *part = *first;
            part->mesh = mesh;
        }
    }
    const float cornice[3] = {face, 0, 3.3F}, across[3] = {0.25F, 40, 0.08F};
    dress_wall(plan, add_box(plan, cornice, across, 0));
    add_object(plan, true, draw(plan, 0.1F, 0.4F), draw(plan, -0.8F, 0.8F), 0, draw(plan, 0.4F, 0.6F));
}

static void make_stage(Plan *plan) {
    add_floor(plan);
    add_wall(plan, draw(plan, 1.8F, 2.4F), 0);
    for (int side = -1; side <= 1; side += 2) { // flats
        const float centre[3] = {draw(plan, -1, -0.4F), (float)side * draw(plan, 1.3F, 1.7F), 1.1F};
        const float half[3] = {0.05F, draw(plan, 0.4F, 0.6F), 1.1F};
        dress_wall(plan, add_box(plan, centre, half, (float)side * draw(plan, -0.9F, -0.3F)));
    }
    for (int step = 0; step < 3; step++) {
        const float high = 0.12F * (float)(step + 1), x = -0.35F * (float)step - 0.2F;
        const float centre[3] = {x, 0, 0.5F * high}, half[3] = {0.175F, 0.8F, 0.5F * high};
        dress_floor(plan, add_box(plan, centre, half, 0));
    }
    add_object(plan, true, -0.9F, draw(plan, -0.3F, 0.3F), 0.36F, draw(plan, 0.4F, 0.5F));
    add_object(plan, false, draw(plan, 0.2F, 0.6F), draw(plan, 0.5F, 1), 0, draw(plan, 0.25F, 0.4F));
    add_object(plan, false, draw(plan, 0.2F, 0.6F), draw(plan, -1, -0.5F), 0, draw(plan, 0.25F, 0.4F));
}

static const struct {
    const char *name;
    void (*make)(Plan *);
} kinds[FFP_WALK_KINDS] = {{"corner", make_corner},
                           {"table", make_table},
                           {"columns", make_columns},
                           {"facade", make_facade},
                           {"stage", make_stage}};

static int kind_of(const FfpSceneSpec *spec) {
    const uint32_t seed = ffp_hash32((uint32_t)spec->seed ^ ffp_hash32((uint32_t)(spec->seed >> 32)));
    return (int)(seed % FFP_WALK_KINDS);
}

const char *ffp_walk_name(const FfpSceneSpec *spec) {
    return kinds[kind_of(spec)].name;
}

// --- Devices and light. ---

static void optics(FfpCamera *device, int width, int height, double field) {
    device->width = width, device->height = height;
    device->fx = device->fy = (real)(0.5 * height / tan(0.5 * field * DEGREE));
    device->cx = (real)(0.5 * width), device->cy = (real)(0.5 * height);
}

// A device on an arc about the aim, which it looks at.
static void place_on_arc(FfpCamera *device, const double aim[3], double away, double height, double azimuth) {
    const double origin[3] = {0, 0, 0};
    const double rise = height - aim[2], radius = hypot(away, rise), polar = atan2(away, rise) / DEGREE;
    ffp_rig_place(device, radius, polar, azimuth, origin);
    for (int k = 0; k < 3; k++) device->pose[4 * k + 3] += (real)aim[k];
}

// Some 4 m away, the projector between the cameras or beside them and above their heads. It lights half to
// two thirds of what a camera sees; two stand on either side, and what they light overlaps.
static void draw_devices(Plan *plan) {
    FfpWalk *walk = plan->walk;
    plan->rng = ffp_rng(plan->spec->seed, STREAM_WALK);
    walk->aim[2] = (double)draw(plan, 0.85F, 1.05F);
    walk->away = (double)draw(plan, 3.6F, 4.2F);
    walk->height = (double)draw(plan, 1.4F, 1.8F);
    walk->degree = (double)draw(plan, 36, 42);
    walk->field = (double)draw(plan, 46, 52);
    walk->n_projectors = plan->spec->rig == FFP_SCENE_WALK_TWO ? 2 : 1;
    const int side = plan->spec->pattern_side;
    const float first = draw(plan, 0, 1) < 0.5F ? -1 : 1;
    for (int p = 0; p < walk->n_projectors; p++) {
        const bool alone = walk->n_projectors == 1;
        const double azimuth =
            (double)((p ? -first : first) * (alone ? draw(plan, 8, 20) : draw(plan, 22, 32)));
        double aim[3] = {0, alone ? (double)draw(plan, -0.2F, 0.2F) : (azimuth > 0 ? 0.6 : -0.6),
                         walk->aim[2]};
        optics(&walk->projector[p], side, side, (double)draw(plan, 34, 40));
        place_on_arc(&walk->projector[p], aim, walk->away + (double)draw(plan, -0.2F, 0.6F),
                     (double)draw(plan, 2, 2.6F), azimuth);
    }
}

// Under black a surface is a tenth to a sixth as bright as in the projector's light.
static void draw_light(Plan *plan) {
    FfpWalk *walk = plan->walk;
    plan->rng = ffp_rng(plan->spec->seed, STREAM_LIGHT);
    const float square = (float)(walk->away * walk->away);
    walk->intensity = draw(plan, 2.6F, 3.4F) * square;
    walk->ambient = draw(plan, 0.03F, 0.08F);
    FfpLamp *lamp = &walk->room.lamp;
    lamp->centre[0] = draw(plan, 1, 4), lamp->centre[1] = draw(plan, -3, 3),
    lamp->centre[2] = draw(plan, 3.5F, 5);
    lamp->radius = draw(plan, 0.2F, 0.5F);
    float distance = 0;
    for (int k = 0; k < 3; k++) distance += lamp->centre[k] * lamp->centre[k];
    lamp->radiance = draw(plan, 0.1F, 0.25F) * distance / (FFP_PI * lamp->radius * lamp->radius);
}

FfpWalk ffp_walk_draw(const FfpSceneSpec *spec) {
    FfpWalk walk = {.n_projectors = 1};
    Plan plan = {spec, &walk, ffp_rng(spec->seed, STREAM_SHELL)};
    kinds[kind_of(spec)].make(&plan);
    draw_devices(&plan);
    draw_light(&plan);
    return walk;
}

void ffp_walk_free(FfpWalk *walk) {
    ffp_room_free(&walk->room);
}

static void camera_of(const FfpWalk *walk, const FfpSceneSpec *spec, FfpCamera *camera) {
    enum { PATCH = 8 };
    const int width = (4 * spec->resolution / 3 + PATCH - 1) / PATCH * PATCH;
    optics(camera, width, spec->resolution, walk->field);
}

void ffp_walk_input(const FfpWalk *walk, const FfpSceneSpec *spec, int index, FfpView *view) {
    const int place = index / walk->n_projectors, projector = index % walk->n_projectors;
    const int places = (spec->views + walk->n_projectors - 1) / walk->n_projectors;
    const double share = places > 1 ? 2.0 * place / (places - 1) - 1 : 0;
    FfpRng rng = ffp_rng(spec->seed, STREAM_WALK + 1000 + (uint64_t)place);
    const double away = walk->away + (double)ffp_rng_range(&rng, -0.15F, 0.15F),
                 height = walk->height + (double)ffp_rng_range(&rng, -0.2F, 0.2F);
    camera_of(walk, spec, &view->camera);
    place_on_arc(&view->camera, walk->aim, away, height, share * walk->degree);
    view->projector = walk->projector[projector];
    if (walk->n_projectors > 1)
        snprintf(view->id, sizeof view->id, "walk_%02d_%c", place, projector ? 'b' : 'a');
    else
        snprintf(view->id, sizeof view->id, "walk_%02d", place);
}

void ffp_walk_target(const FfpWalk *walk, const FfpSceneSpec *spec, int index, FfpView *view) {
    FfpRng rng = ffp_rng(spec->seed, STREAM_TARGET + (uint64_t)index);
    const double azimuth = walk->degree * (double)ffp_rng_range(&rng, -0.95F, 0.95F),
                 away = walk->away + (double)ffp_rng_range(&rng, -0.3F, 0.3F),
                 height = walk->height + (double)ffp_rng_range(&rng, -0.3F, 0.3F);
    camera_of(walk, spec, &view->camera);
    place_on_arc(&view->camera, walk->aim, away, height, azimuth);
    view->projector = walk->projector[index % walk->n_projectors];
    snprintf(view->id, sizeof view->id, "novel_%02d", index);
}
