// A ring of places. A generator claims the next place in the order of need, makes its scene outside the lock
// and marks it; the taker empties the oldest place.
#include "lab/train/queue.h"
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "core/base/arena.h"
#include "core/base/call.h"

enum { POLL_MS = 100 }; // how often a waiting taker looks at *stop

typedef enum State { EMPTY, MAKING, READY, FAILED } State;

typedef struct Place {
    State state;
    FfpScene scene;
    FfpError error;
} Place;

struct FfpQueue {
    FfpSceneSource source;
    atomic_bool *stop;
    FfpContext context;   // of the generators
    pthread_mutex_t lock; // of everything below
    pthread_cond_t made;  // a place became READY or FAILED, or no scene is left to be made
    pthread_cond_t freed; // a place became EMPTY, or the queue closes
    Place *places;
    int capacity;
    int64_t claimed, taken; // scenes so far; places[i % capacity] belongs to the i-th
    int64_t from;           // where to look for the next step that needs a scene; -1: all are claimed
    bool closing;
    pthread_t *threads;
    int n_threads;
};

// The place and step of the next scene to make, or NULL when there is no more to do.
static Place *claim(FfpQueue *queue, int64_t *step) {
    Place *place = NULL;
    pthread_mutex_lock(&queue->lock);
    while (!queue->closing && queue->from >= 0 && queue->claimed - queue->taken >= queue->capacity)
        pthread_cond_wait(&queue->freed, &queue->lock);
    if (!queue->closing && queue->from >= 0 && !atomic_load(queue->stop)) {
        *step = queue->from;
        queue->from = queue->source.next(queue->source.context, *step + 1);
        place = &queue->places[queue->claimed++ % queue->capacity];
        place->state = MAKING;
    }
    pthread_mutex_unlock(&queue->lock);
    return place;
}

typedef struct Making {
    const FfpSceneSource *source;
    int64_t step;
    FfpScene *scene;
} Making;

static bool make(void *argument, FfpError *err) {
    const Making *m = argument;
    return m->source->make(m->source->context, m->step, m->scene, err);
}

static void *generate(void *argument) {
    FfpQueue *queue = argument;
    int64_t step;
    for (Place *place; (place = claim(queue, &step)) != NULL;) {
        Making making = {&queue->source, step, &place->scene};
        const bool ok = ffp_call_run(&queue->context, make, &making, &place->error);
        pthread_mutex_lock(&queue->lock);
        place->state = ok ? READY : FAILED;
        pthread_cond_broadcast(&queue->made);
        pthread_mutex_unlock(&queue->lock);
    }
    return NULL;
}

// New threads inherit the mask: signals go to the threads that were there before.
static bool start_threads(FfpQueue *queue, int generators, FfpError *err) {
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    int problem = 0;
    while (queue->n_threads < generators && problem == 0) {
        problem = pthread_create(&queue->threads[queue->n_threads], NULL, generate, queue);
        queue->n_threads += problem == 0;
    }
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return problem == 0 || ffp_fail(err, FFP_ERROR_IO, "generators", "cannot start thread %d of %d: %s",
                                    queue->n_threads + 1, generators, strerror(problem));
}

static void free_queue(void *thing);

FfpQueue *ffp_queue_new(const FfpSceneSource *source, int64_t first, int generators, int capacity,
                        atomic_bool *stop, FfpError *err) {
    FfpQueue *queue = ffp_alloc(1, sizeof *queue);
    queue->source = *source;
    queue->stop = stop;
    if (ffp_call_context()) queue->context = *ffp_call_context();
    queue->context.beside = true;
    queue->context.settings.progress = NULL;
    queue->context.settings.threads = 1;
    queue->capacity = capacity;
    queue->places = ffp_alloc((size_t)capacity, sizeof *queue->places);
    queue->threads = ffp_alloc((size_t)generators, sizeof *queue->threads);
    queue->from = source->next(source->context, first);
    pthread_condattr_t clock;
    pthread_condattr_init(&clock);
    pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
    pthread_mutex_init(&queue->lock, NULL);
    pthread_cond_init(&queue->made, &clock);
    pthread_cond_init(&queue->freed, NULL);
    pthread_condattr_destroy(&clock);
    ffp_own(queue, free_queue);
    if (start_threads(queue, generators, err)) return queue;
    ffp_queue_free(queue);
    return NULL;
}

static struct timespec soon(void) {
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    at.tv_nsec += POLL_MS * 1000000L;
    at.tv_sec += at.tv_nsec / 1000000000L;
    at.tv_nsec %= 1000000000L;
    return at;
}

// Waits until the oldest place is made; false when *stop or the end of all scenes comes first.
static bool await(FfpQueue *queue, const Place *place) {
    while (place->state != READY && place->state != FAILED) {
        if (atomic_load(queue->stop) || (place->state == EMPTY && queue->from < 0)) return false;
        const struct timespec at = soon();
        pthread_cond_timedwait(&queue->made, &queue->lock, &at);
        if (ffp_cancelled()) atomic_store(queue->stop, true);
    }
    return true;
}

bool ffp_queue_take(FfpQueue *queue, FfpScene *scene, bool *stopped, FfpError *err) {
    *scene = (FfpScene){0};
    bool ok = true;
    pthread_mutex_lock(&queue->lock);
    Place *place = &queue->places[queue->taken % queue->capacity];
    *stopped = !await(queue, place);
    if (!*stopped) {
        ok = place->state == READY || ffp_fail(err, place->error.code, NULL, "%s", place->error.text);
        if (ok) *scene = place->scene;
        *place = (Place){.state = EMPTY};
        queue->taken++;
        pthread_cond_broadcast(&queue->freed);
    }
    pthread_mutex_unlock(&queue->lock);
    return ok;
}

void ffp_queue_free(FfpQueue *queue) {
    ffp_disown(queue);
    if (queue) free_queue(queue);
}

static void free_queue(void *thing) {
    FfpQueue *queue = thing;
    pthread_mutex_lock(&queue->lock);
    queue->closing = true;
    pthread_cond_broadcast(&queue->freed);
    pthread_mutex_unlock(&queue->lock);
    for (int i = 0; i < queue->n_threads; i++) pthread_join(queue->threads[i], NULL);
    for (int i = 0; i < queue->capacity; i++)
        if (queue->places[i].state == READY) ffp_scene_close(&queue->places[i].scene);
    pthread_cond_destroy(&queue->made);
    pthread_cond_destroy(&queue->freed);
    pthread_mutex_destroy(&queue->lock);
    ffp_free(queue->places);
    ffp_free(queue->threads);
    ffp_free(queue);
}
