// Splats of other programs, turned into the capture's world.
#include "cli.h"

const FfpWord ffp_cli_up[] = {{"z", 1 + FFP_UP_Z}, {"y", 1 + FFP_UP_Y}, {"-y", 1 + FFP_UP_MINUS_Y}, {0}};

bool ffp_cli_turn(FfpGaussians *gaussians, const char *path, const FfpCapture *capture, int up,
                  FfpError *err) {
    const FfpUp given = up > 0 ? (FfpUp)(up - 1) : FFP_UP_Z;
    return ffp_gaussians_turn(ffp_cli_context(), gaussians, path, capture, up > 0 ? &given : NULL, err);
}
