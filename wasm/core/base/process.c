// A page starts no programs: ffmpeg and dcraw_emu do not exist for it.
#include "core/base/process.h"

bool ffp_program_exists(const char *name) {
    (void)name;
    return false;
}

bool ffp_process_start(FfpProcess **process, const char *const arguments[], FfpProcessEnd end,
                       const char *where, FfpError *err) {
    *process = NULL;
    (void)end;
    return ffp_fail(err, FFP_ERROR_UNSUPPORTED, where, "this takes %s, which a page cannot start",
                    arguments[0]);
}

bool ffp_process_write(FfpProcess *process, const void *bytes, size_t size) {
    (void)process, (void)bytes, (void)size;
    return false;
}

size_t ffp_process_read(FfpProcess *process, void *bytes, size_t size) {
    (void)process, (void)bytes, (void)size;
    return 0;
}

bool ffp_process_finish(FfpProcess **process, char said[FFP_PROCESS_SAID]) {
    *process = NULL;
    said[0] = 0;
    return false;
}

void ffp_process_kill(FfpProcess **process) {
    *process = NULL;
}
