#include "core/tensor/workspace.h"
#include <pthread.h>
#include <stdlib.h>
#include "core/base/arena.h"

typedef struct Workspace {
    void *memory;
    size_t bytes;
} Workspace;

static pthread_once_t once = PTHREAD_ONCE_INIT;
static pthread_key_t key;

static void free_workspace(void *pointer) {
    Workspace *workspace = pointer;
    ffp_free(workspace->memory);
    ffp_free(workspace);
}

static void make_key(void) {
    if (pthread_key_create(&key, free_workspace) != 0) abort(); // no keys left: nothing can be computed
}

static Workspace *own_workspace(void) {
    pthread_once(&once, make_key);
    Workspace *workspace = pthread_getspecific(key);
    if (workspace) return workspace;
    workspace = ffp_alloc_kept(1, sizeof *workspace);
    pthread_setspecific(key, workspace);
    return workspace;
}

void *ffp_workspace(size_t bytes) {
    Workspace *workspace = own_workspace();
    if (bytes > workspace->bytes) {
        ffp_free(workspace->memory);
        workspace->memory = NULL;
        workspace->bytes = 0;
        workspace->memory = ffp_alloc_kept(bytes, 1);
        workspace->bytes = bytes;
    }
    return workspace->memory;
}
