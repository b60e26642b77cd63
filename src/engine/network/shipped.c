#define _XOPEN_SOURCE 700 // realpath
#include "engine/network/shipped.h"
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/file.h"

#define FILE_NAME "small.safetensors"

// From the folder of the library, or of the program that it is linked into. The first is set by the build: it
// leads from where the library is installed to where the data are.
#ifndef FFP_LIBRARY_TO_DATA
#define FFP_LIBRARY_TO_DATA "../share"
#endif
static const char *const beside[] = {FFP_LIBRARY_TO_DATA "/ffprocams/models", "../share/ffprocams/models",
                                     "models"};

// Looks in one folder; adds its name to `looked` where the file is not there.
static bool is_in(const char *folder, char path[FFP_PATH_MAX], char *looked, size_t room) {
    if (ffp_join_path(path, folder, FILE_NAME) && ffp_is_file(path)) return true;
    const size_t used = strlen(looked);
    snprintf(looked + used, room - used, "%s%.500s", used ? ", " : "", folder);
    return false;
}

static bool is_installed(char path[FFP_PATH_MAX], char *looked, size_t room) {
    char own[FFP_PATH_MAX], folder[FFP_PATH_MAX], whole[PATH_MAX];
    if (!ffp_own_folder(own)) return false;
    for (size_t i = 0; i < sizeof beside / sizeof beside[0]; i++) {
        if (i == 1 && strcmp(beside[0], beside[1]) == 0) continue;
        if (!ffp_join_path(folder, own, beside[i])) continue;
        if (is_in(realpath(folder, whole) ? whole : folder, path, looked, room)) return true;
    }
    return false;
}

bool ffp_find_weights(char path[FFP_PATH_MAX], FfpError *err) {
    char looked[640] = "";
    const char *chosen = getenv("FFPROCAMS_MODELS");
    if (chosen && *chosen) {
        if (is_in(chosen, path, looked, sizeof looked)) return true;
        return ffp_fail(err, FFP_ERROR_IO, FILE_NAME,
                        "the shipped weights are not in %s, which FFPROCAMS_MODELS names", looked);
    }
    if (is_installed(path, looked, sizeof looked) || is_in("models", path, looked, sizeof looked))
        return true;
    return ffp_fail(err, FFP_ERROR_IO, FILE_NAME,
                    "the shipped weights are not in any of %s: name a file, `none`, or their folder in "
                    "FFPROCAMS_MODELS",
                    looked);
}

FfpModel *ffp_model_load(const char *path, FfpError *err) {
    char shipped[FFP_PATH_MAX];
    if (!path && !ffp_find_weights(shipped, err)) return NULL;
    FfpModel *model = ffp_model_read(path ? path : shipped, err);
    if (model && path) model->file = ffp_copy_text(path);
    return model;
}
