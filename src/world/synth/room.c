// Which room a seed gives (room.h).
#include "world/synth/room.h"
#include <math.h>
#include <string.h>
#include "core/base/real.h"
#include "core/base/rng.h"
#include "world/shapes/solids.h"
#include "world/synth/rig.h"

// One stream for each thing, so that a change of one leaves the others as they are.
enum {
    STREAM_RIG = 8000,
    STREAM_PLATTER,
    STREAM_TABLE,
    STREAM_WALL,
    STREAM_WALLS_PLACE,
    STREAM_BOXES,
    STREAM_LAMP,
    STREAM_FAULTS
};
enum { PLACES = 60 }; // tried for a box
static const float DEGREE = 0.017453293F;

// Decisions that the rest depends on.
typedef struct Plan {
    uint64_t seed;
    FfpRoom *room;
    float floor, table;      // heights of the platter's and the table's upper side
    float wall;              // distance of the wall behind the axis
    float platter;           // radius
    float projector_azimuth; // degrees; the camera's is 0
} Plan;

void ffp_room_free(FfpRoom *room) {
    for (int p = 0; p < room->n_parts; p++) ffp_mesh_free(&room->parts[p].mesh);
    *room = (FfpRoom){0};
}

float ffp_room_floor(const FfpMesh *mesh) {
    float low = mesh->positions[2];
    for (size_t i = 1; i < (size_t)mesh->n_vertices; i++) low = fminf(low, mesh->positions[3 * i + 2]);
    return low;
}

// --- Materials. ---

static FfpMaterial material_named(const char *name, FfpRng *rng) {
    int number = 0;
    while (number + 1 < ffp_material_count() && strcmp(ffp_material_name(number), name) != 0) number++;
    return ffp_material_make(number, ffp_rng_u32(rng));
}

// A grey between two albedos with a tint of up to `tint` of it.
static void plain_grey(FfpRoomPart *part, float low, float high, float tint, FfpRng *rng) {
    const float grey = ffp_rng_range(rng, low, high);
    part->plain = true;
    part->roughness = ffp_rng_range(rng, 0.5F, 0.95F);
    for (int c = 0; c < 3; c++) part->albedo[c] = grey * (1 + ffp_rng_range(rng, -tint, tint));
}

static FfpRoomPart *new_part(const Plan *plan) {
    return &plan->room->parts[plan->room->n_parts++];
}

// --- Devices. ---

// Some 700 mm from the axis, the camera a little above the table and the projector above it to a side; the
// camera sees twice the object's size and the projector lights half as much again.
static void draw_rig(Plan *plan, int height, int panel_width, int panel_height) {
    FfpRng rng = ffp_rng(plan->seed, STREAM_RIG);
    FfpBareRig *rig = &plan->room->rig;
    const double aim[3] = {0, 0, (double)ffp_rng_range(&rng, -0.15F, 0.05F)};
    const double away = (double)ffp_rng_range(&rng, 6.5F, 8),
                 thrown = (double)ffp_rng_range(&rng, 6.2F, 7.8F);
    const double polar = (double)ffp_rng_range(&rng, 70, 80), above = (double)ffp_rng_range(&rng, 14, 24);
    const float side = ffp_rng_uniform(&rng) < 0.5F ? -1 : 1;
    plan->projector_azimuth = side * ffp_rng_range(&rng, 18, 30);
    const double seen = (double)ffp_rng_range(&rng, 1.7F, 2.1F),
                 lit = (double)ffp_rng_range(&rng, 1.35F, 1.5F);
    const double off = (double)ffp_rng_range(&rng, -0.02F, 0.02F),
                 shift = (double)ffp_rng_range(&rng, 0, 0.06F);
    ffp_bare_rig_optics(&rig->camera, (4 * height + 2) / 3, height, 0.5 * away / seen, off, -off);
    ffp_bare_rig_optics(&rig->projector, panel_width, panel_height, 0.5 * thrown / lit, 0.5 * off, shift);
    ffp_rig_place(&rig->camera, away, polar, 0, aim);
    ffp_rig_place(&rig->projector, thrown, polar - above, (double)plan->projector_azimuth, aim);
    rig->camera_lens[0] = (double)ffp_rng_range(&rng, -0.12F, -0.04F);
    rig->camera_lens[1] = (double)ffp_rng_range(&rng, 0, 0.04F);
    rig->projector_lens[0] = (double)ffp_rng_range(&rng, -0.04F, 0);
    rig->square = 0.2;
    rig->intensity = ffp_rng_range(&rng, 2.3F, 3) * (float)(thrown * thrown);
}

static void draw_faults(const Plan *plan, int height) {
    FfpRng rng = ffp_rng(plan->seed, STREAM_FAULTS);
    FfpSensor *s = &plan->room->sensor;
    s->gamma = ffp_rng_range(&rng, -0.1F, 0.1F);
    s->black_level = ffp_rng_range(&rng, 0.0008F, 0.003F);
    s->defocus = ffp_rng_range(&rng, 0.4F, 0.8F);
    s->shot = ffp_rng_range(&rng, 2e-4F, 4e-4F);
    s->read = ffp_rng_range(&rng, 0.0015F, 0.0025F);
    plan->room->camera_defocus = ffp_rng_range(&rng, 0.5F, 0.9F) * (float)height / 540;
}

// --- Platter, table, wall. ---

static void draw_platter(Plan *plan) {
    FfpRng rng = ffp_rng(plan->seed, STREAM_PLATTER);
    const float thickness = ffp_rng_range(&rng, 0.12F, 0.3F);
    FfpRoomPart *part = new_part(plan);
    plan->platter = ffp_rng_range(&rng, 1.05F, 1.3F);
    plan->table = plan->floor - thickness;
    part->mesh = ffp_solid_cylinder(plan->platter, plan->table, plan->floor);
    part->turns = true;
    plain_grey(part, 0.12F, 0.6F, 0.05F, &rng);
    if (ffp_rng_uniform(&rng) < 0.25F) { // of wood, whose grain is seen to turn
        part->plain = false;
        part->material = material_named("wood", &rng);
    }
}

static void draw_table(Plan *plan) {
    static const char *const kinds[] = {"wood", "parquet", "wood", "concrete", "slate", "formwork"};
    FfpRng rng = ffp_rng(plan->seed, STREAM_TABLE);
    const float front = ffp_rng_range(&rng, 2, 3), side = ffp_rng_range(&rng, 3.5F, 5), thick = 0.2F;
    const float depth = 0.5F * (front + plan->wall + 1);
    const float centre[3] = {front - depth, 0, plan->table - thick}, half[3] = {depth, side, thick};
    FfpRoomPart *part = new_part(plan);
    part->mesh = ffp_solid_box(centre, half, 0);
    part->material = material_named(kinds[ffp_rng_below(&rng, sizeof kinds / sizeof *kinds)], &rng);
}

// It stands behind the table, not quite across the camera's view.
static void draw_wall(Plan *plan) {
    static const char *const kinds[] = {"plaster", "stucco", "concrete", "brick"};
    FfpRng rng = ffp_rng(plan->seed, STREAM_WALL);
    const float thick = 0.2F, turn = ffp_rng_range(&rng, -12, 12) * DEGREE;
    const float centre[3] = {-(plan->wall + thick), 0, plan->table + 2}, half[3] = {thick, 9, 6};
    FfpRoomPart *part = new_part(plan);
    part->mesh = ffp_solid_box(centre, half, turn);
    plain_grey(part, 0.35F, 0.75F, 0.06F, &rng);
    if (ffp_rng_uniform(&rng) < 0.4F) {
        part->plain = false;
        part->material = material_named(kinds[ffp_rng_below(&rng, sizeof kinds / sizeof *kinds)], &rng);
    }
}

// --- Boxes. ---

typedef struct Place {
    float x, y, reach; // reach: from the middle to the farthest corner
} Place;

static bool is_free(const Plan *plan, const Place *at, const Place *others, int count) {
    if (at->x - at->reach < -(plan->wall - 0.25F * fabsf(at->y)) + 0.1F) return false;
    for (int i = 0; i < count; i++)
        if (hypotf(at->x - others[i].x, at->y - others[i].y) < at->reach + others[i].reach) return false;
    return true;
}

// Beside or behind the platter, out of the way of both devices' light.
static Place draw_place(const Plan *plan, const float half[3], float side, FfpRng *rng) {
    const bool beside_projector = side * plan->projector_azimuth > 0;
    const float least = 80 + (beside_projector ? fabsf(plan->projector_azimuth) : 0);
    const float azimuth = side * ffp_rng_range(rng, least, 165) * DEGREE, reach = hypotf(half[0], half[1]);
    const float away = plan->platter + reach + ffp_rng_range(rng, 0.05F, 0.9F);
    return (Place){away * cosf(azimuth), away * sinf(azimuth), reach};
}

static void dress_box(FfpRoomPart *part, FfpRng *rng) {
    if (ffp_rng_uniform(rng) < 0.35F) {
        const int kind = (int)ffp_rng_below(rng, (uint32_t)ffp_material_count());
        part->material = ffp_material_make(kind, ffp_rng_u32(rng));
        return;
    }
    part->plain = true;
    part->roughness = ffp_rng_range(rng, 0.4F, 0.95F);
    for (int c = 0; c < 3; c++) { // the power gives more dark values, so colours are seldom grey
        const float value = ffp_rng_uniform(rng);
        part->albedo[c] = 0.04F + 0.7F * value * value;
    }
}

// Two to four of them; the sides take turns. One that finds no place is left out.
static void draw_boxes(Plan *plan) {
    FfpRng rng = ffp_rng(plan->seed, STREAM_BOXES);
    Place places[FFP_ROOM_BOXES];
    const int wanted = 2 + (int)ffp_rng_below(&rng, FFP_ROOM_BOXES - 1);
    const int first = ffp_rng_uniform(&rng) < 0.5F ? 0 : 1;
    int count = 0;
    for (int i = 0; i < wanted; i++) {
        const float side = (first + i) % 2 == 0 ? -1 : 1;
        const float across = ffp_rng_range(&rng, 0.2F, 0.6F), deep = ffp_rng_range(&rng, 0.2F, 0.6F),
                    high = ffp_rng_range(&rng, 0.25F, 0.9F), half[3] = {across, deep, high};
        const float turn = ffp_rng_range(&rng, -90, 90) * DEGREE;
        for (int tried = 0; tried < PLACES; tried++) {
            places[count] = draw_place(plan, half, side, &rng);
            if (!is_free(plan, &places[count], places, count)) continue;
            const float centre[3] = {places[count].x, places[count].y, plan->table + half[2]};
            FfpRoomPart *part = new_part(plan);
            part->mesh = ffp_solid_box(centre, half, turn);
            dress_box(part, &rng);
            count++;
            break;
        }
    }
}

// About 2 % of the projector's light at the object.
static void draw_lamp(const Plan *plan) {
    FfpRng rng = ffp_rng(plan->seed, STREAM_LAMP);
    FfpLamp *lamp = &plan->room->lamp;
    const FfpBareRig *rig = &plan->room->rig;
    lamp->centre[0] = ffp_rng_range(&rng, -1, 3);
    lamp->centre[1] = ffp_rng_range(&rng, -3, 3);
    lamp->centre[2] = plan->table + ffp_rng_range(&rng, 4, 6);
    lamp->radius = ffp_rng_range(&rng, 0.15F, 0.45F);
    float square = 0, thrown = 0;
    for (int k = 0; k < 3; k++) square += lamp->centre[k] * lamp->centre[k];
    for (int k = 0; k < 3; k++)
        thrown += (float)(rig->projector.pose[4 * k + 3] * rig->projector.pose[4 * k + 3]);
    const float irradiance = ffp_rng_range(&rng, 0.012F, 0.028F) * rig->intensity / thrown;
    lamp->radiance = irradiance * square / (FFP_PI * lamp->radius * lamp->radius);
}

FfpRoom ffp_room_draw(uint64_t seed, float floor, int height, int panel_width, int panel_height) {
    FfpRoom room = {0};
    Plan plan = {.seed = seed, .room = &room, .floor = floor};
    FfpRng rng = ffp_rng(seed, STREAM_WALLS_PLACE);
    plan.wall = ffp_rng_range(&rng, 2.4F, 4);
    draw_rig(&plan, height, panel_width, panel_height);
    draw_faults(&plan, height);
    draw_platter(&plan);
    draw_table(&plan);
    draw_wall(&plan);
    draw_boxes(&plan);
    draw_lamp(&plan);
    return room;
}
