// Poses to predict, in either layout, for a capture that is sound.
#include <stdlib.h>
#include <string.h>
#include "core/capture/capture.h"
#include "fuzz.h"

static const char sound[] =
    "{\"format\": \"ffprocams-capture\", \"version\": 1, \"object\": {\"centre\": [0, 0, 0], \"radius\": 1},"
    "\"camera\": {\"width\": 8, \"height\": 8, \"fx\": 9, \"fy\": 9, \"cx\": 4, \"cy\": 4},"
    "\"projector\": {\"width\": 4, \"height\": 4, \"fx\": 5, \"fy\": 5, \"cx\": 2, \"cy\": 2, "
    "\"intensity\": [1, 1, 1]},"
    "\"patterns\": [{\"name\": \"black\", \"role\": \"black\"}, {\"name\": \"white\", \"role\": \"white\"}],"
    "\"views\": [{\"id\": \"0\", \"images\": {\"black\": \"a.png\", \"white\": \"b.png\"},"
    "\"c2w\": [[0, 0, -1, 3], [1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]],"
    "\"p2w\": [[0, 0, -1, 2], [1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]]}]}";

static FfpCapture reference;

static void close_reference(void) {
    ffp_capture_free(&reference);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    FfpCapture targets;
    FfpError err = {0};
    if (reference.n_views == 0) {
        const char *path = fuzz_neighbour("scene.json", (const uint8_t *)sound, strlen(sound));
        if (!ffp_capture_read(&reference, path, &err)) abort();
        atexit(close_reference);
    }
    fuzz_verdict(
        ffp_capture_read_targets(&targets, fuzz_neighbour("targets.json", data, size), &reference, &err),
        &err);
    ffp_capture_free(&targets);
    return 0;
}
