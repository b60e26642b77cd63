// An object and its room as one mesh (room.h).
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "world/synth/room.h"

#define DEGREE (FFP_PI_DOUBLE / 180)

// From the world to the frame of what has turned: R_z(-angle).
static void into_frame(const FfpSurroundings *a, const float from[3], float to[3]) {
    const float x = from[0], y = from[1];
    to[0] = a->cosine * x + a->sine * y, to[1] = a->cosine * y - a->sine * x, to[2] = from[2];
}

static void out_of_frame(const FfpSurroundings *a, const float from[3], float to[3]) {
    const float x = from[0], y = from[1];
    to[0] = a->cosine * x - a->sine * y, to[1] = a->cosine * y + a->sine * x, to[2] = from[2];
}

// Appends a mesh, turned back with the room's unless it turns itself. There is room for it.
static void append(FfpSurroundings *a, const FfpMesh *from, bool turns) {
    FfpMesh *to = &a->mesh;
    const size_t vertex = (size_t)to->n_vertices, triangle = (size_t)to->n_triangles;
    const size_t vertices = (size_t)from->n_vertices, corners = 3 * (size_t)from->n_triangles;
    memcpy(to->positions + 3 * vertex, from->positions, vertices * 3 * sizeof(float));
    memcpy(to->normals + 3 * vertex, from->normals, vertices * 3 * sizeof(float));
    if (to->uv && from->uv) memcpy(to->uv + 2 * vertex, from->uv, vertices * 2 * sizeof(float));
    for (size_t i = 0; i < vertices && !turns; i++) {
        float *position = to->positions + 3 * (vertex + i), *normal = to->normals + 3 * (vertex + i);
        into_frame(a, position, position);
        into_frame(a, normal, normal);
    }
    for (size_t i = 0; i < corners; i++)
        to->triangles[3 * triangle + i] = from->triangles[i] + (uint32_t)vertex;
    to->n_vertices += from->n_vertices;
    to->n_triangles += from->n_triangles;
}

FfpSurroundings ffp_around_new(const FfpRoom *room, const FfpMesh *object, double angle) {
    FfpSurroundings a = {.room = room,
                         .cosine = (float)cos(angle * DEGREE),
                         .sine = (float)sin(angle * DEGREE),
                         .lamp = room->lamp};
    size_t vertices = object ? (size_t)object->n_vertices : 0;
    size_t triangles = object ? (size_t)object->n_triangles : 0;
    for (int p = 0; p < room->n_parts; p++) {
        vertices += (size_t)room->parts[p].mesh.n_vertices;
        triangles += (size_t)room->parts[p].mesh.n_triangles;
    }
    a.mesh.positions = ffp_alloc(vertices * 3 + 1, sizeof(float));
    a.mesh.normals = ffp_alloc(vertices * 3, sizeof(float));
    a.mesh.triangles = ffp_alloc(triangles * 3, sizeof(uint32_t));
    if (object && object->uv) a.mesh.uv = ffp_alloc(vertices * 2, sizeof(float));
    a.mesh.two_sided = object && object->two_sided;
    if (object) append(&a, object, true);
    for (int p = 0; p < room->n_parts; p++) {
        a.first[p] = a.mesh.n_triangles;
        append(&a, &room->parts[p].mesh, room->parts[p].turns);
    }
    a.first[room->n_parts] = a.mesh.n_triangles;
    into_frame(&a, room->lamp.centre, a.lamp.centre);
    return a;
}

void ffp_around_free(FfpSurroundings *around) {
    ffp_mesh_free(&around->mesh);
    *around = (FfpSurroundings){0};
}

static const FfpRoomPart *part_of(const FfpSurroundings *a, const FfpHit *hit) {
    int p = 0;
    while (p + 1 < a->room->n_parts && hit->triangle >= (uint32_t)a->first[p + 1]) p++;
    return &a->room->parts[p];
}

// Where a hit lies in the part's own frame, which its texture is fixed to.
static void part_point(const FfpSurroundings *a, const FfpRoomPart *part, const float from[3], float to[3]) {
    if (part->turns)
        memcpy(to, from, 3 * sizeof *to);
    else
        out_of_frame(a, from, to);
}

void ffp_around_look(const FfpSurroundings *around, const FfpHit *hit, float albedo[3], float *roughness) {
    const FfpRoomPart *part = part_of(around, hit);
    if (part->plain) {
        memcpy(albedo, part->albedo, sizeof part->albedo);
        *roughness = part->roughness;
        return;
    }
    float point[3];
    part_point(around, part, hit->point, point);
    ffp_material_look(&part->material, point, albedo, roughness);
}

void ffp_around_bump(const FfpSurroundings *around, const FfpHit *hit, float normal[3]) {
    const FfpRoomPart *part = part_of(around, hit);
    if (part->plain) return;
    float point[3], bent[3];
    part_point(around, part, hit->point, point);
    part_point(around, part, normal, bent);
    ffp_material_bump(&part->material, point, bent);
    if (part->turns)
        memcpy(normal, bent, sizeof bent);
    else
        into_frame(around, bent, normal);
}
