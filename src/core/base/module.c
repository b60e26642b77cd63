#include "core/base/module.h"
#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include "core/base/file.h"

// From the folder of the library, or of the program that it is linked into: a build's or a Python package's
// folder holds both; an installed library's has one for its modules. The build sets the path to the latter
// from the folder of installed programs.
#ifndef FFP_PROGRAM_TO_MODULES
#define FFP_PROGRAM_TO_MODULES "../lib/ffprocams"
#endif
static const char *const places[] = {".", "ffprocams", FFP_PROGRAM_TO_MODULES};
enum { PLACES = sizeof places / sizeof *places };

static bool find(const char *file, char path[FFP_PATH_MAX]) {
    char own[FFP_PATH_MAX], folder[FFP_PATH_MAX];
    const char *chosen = getenv("FFPROCAMS_MODULES");
    if (chosen && *chosen) return ffp_join_path(path, chosen, file) && ffp_is_file(path);
    if (!ffp_own_folder(own)) return false;
    for (int i = 0; i < PLACES; i++)
        if (ffp_join_path(folder, own, places[i]) && ffp_join_path(path, folder, file) && ffp_is_file(path))
            return true;
    return false;
}

// Sets module->table, or returns why that cannot be.
static const char *load(FfpModule *module, const char *path) {
    char symbol[64];
    void *handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!handle) {
        const char *why = dlerror();
        return why ? why : "no reason is given";
    }
    snprintf(symbol, sizeof symbol, "ffp_%s_module", module->name);
    const int *version = dlsym(handle, symbol);
    if (version && *version == module->version) {
        module->table = version;
        return NULL;
    }
    dlclose(handle);
    return "it belongs to another version of ffprocams";
}

static void load_once(FfpModule *module, FfpError *err) {
    char file[64], path[FFP_PATH_MAX];
    snprintf(file, sizeof file, "libffprocams-%s.so", module->name);
    if (!find(file, path)) {
        ffp_fail(err, FFP_ERROR_UNSUPPORTED, file, "%s, whose module is not installed: it comes with %s",
                 module->purpose, module->origin);
        return;
    }
    const char *why = load(module, path);
    if (why)
        ffp_fail(err, FFP_ERROR_UNSUPPORTED, file, "%s, whose module cannot be loaded: %s", module->purpose,
                 why);
}

const void *ffp_module_load(FfpModule *module, FfpError *err) {
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    pthread_mutex_lock(&lock);
    if (!module->table) load_once(module, err);
    const void *table = module->table;
    pthread_mutex_unlock(&lock);
    return table;
}
