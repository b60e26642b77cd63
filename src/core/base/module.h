// Modules: code that needs a large third-party library is a separate shared library, loaded when a call first
// asks for it. So neither libffprocams nor programs that link it depend on those libraries, and they are
// loaded only on demand. A module allocates no memory from the call, and no call is aborted from inside one.
#ifndef FFP_BASE_MODULE_H
#define FFP_BASE_MODULE_H

#include "core/base/error.h"

// Module NAME is the file libffprocams-NAME.so. It exports one constant, ffp_NAME_module: a table of
// functions that begins with an int, its version.
typedef struct FfpModule {
    const char *name;
    int version;
    const char *purpose; // what needs it: "scenes are lit by Embree"
    const char *origin;  // where it comes from: "the package ffprocams-world, or ..."
    const void *table;   // for module.c: once it is loaded
} FfpModule;

// The module's table, which stays loaded; NULL with an error that says what to install. It is searched for
// beside the library, or the program that it is linked into, and where it was installed; or only in the
// folder named by FFPROCAMS_MODULES. Thread safe.
const void *ffp_module_load(FfpModule *module, FfpError *err);

// For what a module exports.
#define FFP_MODULE_EXPORT __attribute__((visibility("default")))

#endif
