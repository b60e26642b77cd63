// The turntable's axis and angles, in JSON or YAML.
#include "fuzz.h"
#include "rig/turntable/turntable.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    FfpTurntable turntable;
    FfpError err = {0};
    const char *path = fuzz_file(data, size);
    fuzz_verdict(ffp_turntable_take(&turntable, &(FfpImportTurntable){.file = path}, &err), &err);
    fuzz_verdict(ffp_turntable_take(&turntable, &(FfpImportTurntable){.file = path, .find_axis = true}, &err),
                 &err);
    return 0;
}
