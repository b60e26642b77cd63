#define _GNU_SOURCE // dladdr

#include <dlfcn.h>
#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/auxv.h>
#include "core/base/file.h"

static const char here = 0;

// The system knows a program by the name it was called by, which need not lead anywhere; its entry point
// tells whether it is meant.
bool ffp_own_folder(char out[FFP_PATH_MAX]) {
    char path[PATH_MAX];
    Dl_info own, program;
    if (!dladdr(&here, &own)) return false;
    const bool linked_in = dladdr((void *)(uintptr_t)getauxval(AT_ENTRY), &program) && // NOLINT
                           program.dli_fbase == own.dli_fbase;
    if (!realpath(linked_in ? "/proc/self/exe" : own.dli_fname, path)) return false;
    char *slash = strrchr(path, '/');
    if (!slash || slash - path >= FFP_PATH_MAX) return false;
    *slash = 0;
    memcpy(out, path, (size_t)(slash - path) + 1);
    return true;
}
