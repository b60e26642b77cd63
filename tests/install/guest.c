// guest LIBRARY CAPTURE: loads the library as a host loads a plug-in, makes one call that works in parallel,
// and unloads it, fifty times. Its workers outlive each unloading. Then a forked process makes the call.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#include "ffprocams.h"

// ISO C has no conversion from an object's address to a function's.
static void find(void *library, const char *name, void *function) {
    void *const symbol = dlsym(library, name);
    memcpy(function, &symbol, sizeof symbol);
}

static int call(const char *path, const char *folder) {
    FfpContext *(*new)(const FfpContextSettings *, FfpError *);
    FfpCapture *(*open)(FfpContext *, const char *, const FfpOpening *, FfpError *);
    void (*close)(FfpCapture *), (*end)(FfpContext *), (*defaults)(FfpContextSettings *, size_t);
    FfpContextSettings settings;
    FfpError err = {0};
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) return fprintf(stderr, "%s\n", dlerror()), 1;
    find(library, "ffp_context_new", &new), find(library, "ffp_capture_open", &open);
    find(library, "ffp_capture_close", &close), find(library, "ffp_context_free", &end);
    find(library, "ffp_context_defaults_into", &defaults), defaults(&settings, sizeof settings);
    settings.threads = 2;
    FfpContext *context = new (&settings, &err);
    FfpCapture *capture = context ? open(context, folder, NULL, &err) : NULL;
    if (!capture) return fprintf(stderr, "%s\n", err.text), 1;
    close(capture);
    end(context);
    dlclose(library);
    return 0;
}

int main(int argc, char **argv) {
    int status = 0;
    if (argc != 3) return 2;
    for (int i = 0; i < 50; i++)
        if (call(argv[1], argv[2]) != 0) return 1;
    const pid_t child = fork();
    if (child == 0) {
        alarm(60); // a process that waits for workers it has not got is ended
        _exit(call(argv[1], argv[2]));
    }
    if (child < 0 || waitpid(child, &status, 0) != child || status != 0)
        return fprintf(stderr, "a forked process: status %d\n", status), 1;
    return 0;
}
