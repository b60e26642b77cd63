// A real room around the turntable: a platter that turns with the object, a table, a wall, boxes and a weak
// lamp, and the devices that stand in it. Lengths are the world's; z is the turntable's axis.
#ifndef FFP_SYNTH_ROOM_H
#define FFP_SYNTH_ROOM_H

#include "world/shapes/mesh.h"
#include "world/synth/bare_rig.h"
#include "world/synth/material.h"
#include "world/synth/synth.h"
#include "world/synth/trace.h"

enum { FFP_ROOM_BOXES = 4, FFP_ROOM_PARTS = 32 };

// A thing of one material, or of one colour.
typedef struct FfpRoomPart {
    FfpMesh mesh;         // at angle 0
    bool turns;           // with the turntable
    bool plain;           // of one colour, without a material
    FfpMaterial material; // otherwise
    float albedo[3], roughness;
} FfpRoomPart;

// A sphere that shines; rays do not meet it.
typedef struct FfpLamp {
    float centre[3], radius, radiance;
} FfpLamp;

typedef struct FfpRoom {
    int n_parts;
    FfpRoomPart parts[FFP_ROOM_PARTS]; // platter, table, wall, boxes; or those of a whole scene (walk.h)
    FfpLamp lamp;
    FfpBareRig rig;
    FfpSensor sensor;     // the devices' faults
    float camera_defocus; // deviation of a Gaussian, in pixels of the camera
} FfpRoom;

// The room of a seed whose platter's upper side is at height `floor`, with pictures height * 4/3 x height and
// a panel of the given size. The seed alone decides where things are, in units of the world and of the
// pictures' height. To be freed.
FfpRoom ffp_room_draw(uint64_t seed, float floor, int height, int panel_width, int panel_height);
void ffp_room_free(FfpRoom *room);
// The height on which a mesh stands: its lowest point's.
float ffp_room_floor(const FfpMesh *mesh);

// An object in its room, in the frame of what has turned by an angle: one mesh for one tracer.
typedef struct FfpSurroundings {
    const FfpRoom *room;
    FfpMesh mesh;                  // the object's triangles, then those of each part
    int first[FFP_ROOM_PARTS + 1]; // each part's first triangle, and their number
    float cosine, sine;            // of the angle
    FfpLamp lamp;
} FfpSurroundings;

// `object` NULL: the empty stage. Angle in degrees. The room must live as long. To be freed.
FfpSurroundings ffp_around_new(const FfpRoom *room, const FfpMesh *object, double angle);
void ffp_around_free(FfpSurroundings *around);
// True if a hit is the room's, not the object's; false for NULL.
static inline bool ffp_around_has(const FfpSurroundings *around, const FfpHit *hit) {
    return around && hit->triangle >= (uint32_t)around->first[0];
}
// Linear albedo and roughness at a hit of the room's, and the unit normal there bent by the relief.
void ffp_around_look(const FfpSurroundings *around, const FfpHit *hit, float albedo[3], float *roughness);
void ffp_around_bump(const FfpSurroundings *around, const FfpHit *hit, float normal[3]);

#endif
