// The surface where a ray meets an object or its room.
#include "world/synth/chessboard.h"
#include "world/synth/room.h"
#include "world/synth/simulate_work.h"

void ffp_surface_look(const FfpSimulation *sim, const FfpHit *hit, float footprint, float albedo[3],
                      float *roughness) {
    if (ffp_around_has(sim->around, hit))
        ffp_around_look(sim->around, hit, albedo, roughness);
    else if (sim->board)
        ffp_chessboard_look(sim->board, hit->point, albedo, roughness);
    else if (sim->textures)
        ffp_textures_look(sim->textures, sim->mesh, hit, footprint, albedo, roughness);
    else
        ffp_material_look(sim->material, hit->point, albedo, roughness);
}

void ffp_surface_bump(const FfpSimulation *sim, const FfpHit *hit, float footprint, float normal[3]) {
    if (ffp_around_has(sim->around, hit))
        ffp_around_bump(sim->around, hit, normal);
    else if (sim->board)
        return;
    else if (sim->textures)
        ffp_textures_bump(sim->textures, sim->mesh, hit, footprint, normal);
    else
        ffp_material_bump(sim->material, hit->point, normal);
}
