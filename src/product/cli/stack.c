// Where the user's limit on stacks is small (ulimit -s 128), the work is done on a stack of its own.
#define _GNU_SOURCE // pthread_setattr_default_np
#include <pthread.h>
#include <sys/resource.h>
#include "cli.h"

enum { STACK_BYTES = 8 << 20 }; // as Linux gives it by default

typedef struct Work {
    int (*function)(void *argument);
    void *argument;
    int status;
} Work;

static void *begin(void *argument) {
    Work *work = argument;
    work->status = work->function(work->argument);
    return NULL;
}

int ffp_cli_on_large_stack(int (*function)(void *argument), void *argument) {
    struct rlimit limit;
    Work work = {function, argument, FFP_EXIT_FAILURE};
    pthread_attr_t attributes;
    pthread_t thread;
    if (getrlimit(RLIMIT_STACK, &limit) != 0 || limit.rlim_cur >= STACK_BYTES) return function(argument);
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, STACK_BYTES);
    pthread_setattr_default_np(&attributes); // for OpenMP's threads
    const bool begun = pthread_create(&thread, &attributes, begin, &work) == 0;
    pthread_attr_destroy(&attributes);
    if (!begun) return function(argument);
    pthread_join(thread, NULL);
    return work.status;
}
