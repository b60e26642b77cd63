// The capture and the splats of commands that draw: devices alone, and splats of other programs turned into
// the capture's world.
#include "cli.h"

const FfpWord ffp_cli_up[] = {{"z", 1 + FFP_UP_Z}, {"y", 1 + FFP_UP_Y}, {"-y", 1 + FFP_UP_MINUS_Y}, {0}};

FfpCapture *ffp_cli_open_devices(const char *path, bool sphere, FfpError *err) {
    FfpOpening how = ffp_opening_defaults();
    how.photographs = FFP_READ_NONE;
    how.sphere = sphere;
    return ffp_capture_open(ffp_cli_context(), path, &how, err);
}

bool ffp_cli_turn(FfpGaussians *gaussians, const char *path, const FfpCapture *capture, int up,
                  FfpError *err) {
    const FfpUp given = up > 0 ? (FfpUp)(up - 1) : FFP_UP_Z;
    return ffp_gaussians_turn(ffp_cli_context(), gaussians, path, capture, up > 0 ? &given : NULL, err);
}
