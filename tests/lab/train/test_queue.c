// The queue of scenes: order, errors, and that it can be closed at any moment. The scenes here are empty but
// for a number, and slow.
// Labels: threads
#include <omp.h>
#include <pthread.h>
#include <signal.h>
#include <time.h>
#include "core/base/arena.h"
#include "core/base/log.h"
#include "lab/train/queue.h"
#include "support.h"

typedef struct Factory {
    int64_t end;          // scenes are needed at the even steps below
    int64_t broken;       // this one cannot be made
    int slow_ms, fast_ms; // scenes 0, 4, 8 .. are slow, the others fast
    atomic_int begun, ended, threads_without_mask, threads_with_teams;
} Factory;

static atomic_bool stop;

static void rest(int ms) {
    const struct timespec time = {.tv_sec = ms / 1000, .tv_nsec = ms % 1000 * 1000000L};
    nanosleep(&time, NULL);
}

static int64_t next_even(const void *context, int64_t from) {
    const int64_t step = from + (from & 1);
    return step < ((const Factory *)context)->end ? step : -1;
}

static bool make(const void *context, int64_t step, FfpScene *scene, FfpError *err) {
    Factory *factory = (Factory *)context;
    sigset_t blocked;
    factory->begun++;
    pthread_sigmask(SIG_SETMASK, NULL, &blocked);
    factory->threads_without_mask += !sigismember(&blocked, SIGINT) || !sigismember(&blocked, SIGTERM);
    factory->threads_with_teams += omp_get_max_threads() != 1;
    rest(step % 4 == 0 ? factory->slow_ms : factory->fast_ms);
    factory->ended++;
    if (step == factory->broken) return ffp_fail(err, FFP_ERROR_ARGUMENT, "scene 6", "no such luck");
    *scene = (FfpScene){.active = (int)step, .patterns = ffp_alloc(1, sizeof *scene->patterns)};
    return true;
}

static FfpQueue *queue_of(Factory *factory, int64_t first, int generators, int capacity) {
    const FfpSceneSource source = {factory, next_even, make};
    FfpError err = {0};
    stop = false;
    FfpQueue *queue = ffp_queue_new(&source, first, generators, capacity, &stop, &err);
    if (!queue) fail_msg("%s", err.text);
    return queue;
}

static void assert_taken(FfpQueue *queue, int step) {
    FfpScene scene;
    FfpError err = {0};
    bool stopped;
    if (!ffp_queue_take(queue, &scene, &stopped, &err)) fail_msg("%s", err.text);
    assert_false(stopped);
    assert_int_equal(scene.active, step);
    ffp_scene_close(&scene);
}

static void assert_stopped(FfpQueue *queue) {
    FfpScene scene;
    bool stopped = false;
    assert_true(ffp_queue_take(queue, &scene, &stopped, NULL));
    assert_true(stopped);
    assert_null(scene.patterns);
}

static void order_is_that_of_need(void **state) {
    (void)state;
    static const int generators[3] = {1, 3, 8}, capacities[3] = {3, 1, 4};
    for (int i = 0; i < 9; i++) {
        Factory factory = {.end = 30, .broken = -1, .slow_ms = 8};
        FfpQueue *queue = queue_of(&factory, 3, generators[i / 3], capacities[i % 3]);
        for (int step = 4; step < 30; step += 2) assert_taken(queue, step);
        assert_stopped(queue);
        ffp_queue_free(queue);
        assert_int_equal(factory.begun, 13);
        assert_int_equal(factory.threads_without_mask, 0);
        assert_int_equal(factory.threads_with_teams, 0);
    }
}

static void an_error_comes_in_its_turn(void **state) {
    (void)state;
    Factory factory = {.end = 30, .broken = 6, .slow_ms = 20};
    FfpQueue *queue = queue_of(&factory, 0, 3, 6);
    for (int step = 0; step < 6; step += 2) assert_taken(queue, step);
    FfpScene scene;
    FfpError err = {0};
    bool stopped;
    assert_false(ffp_queue_take(queue, &scene, &stopped, &err));
    assert_string_equal(err.text, "no such luck (scene 6)");
    ffp_queue_free(queue);
}

static void wait_for(const atomic_int *count, int least) {
    for (int i = 0; i < 5000 && *count < least; i++) rest(2);
    assert_true(*count >= least);
}

static void a_full_queue_waits_and_closes(void **state) {
    (void)state;
    Factory factory = {.end = 1000, .broken = -1};
    FfpQueue *queue = queue_of(&factory, 0, 2, 5);
    wait_for(&factory.begun, 5);
    rest(50);
    assert_int_equal(factory.begun, 5);
    assert_taken(queue, 0);
    wait_for(&factory.begun, 6);
    ffp_queue_free(queue);
    assert_int_equal(factory.begun, 6);
}

static void closing_waits_for_the_scenes_in_the_making(void **state) {
    (void)state;
    Factory factory = {.end = 1000, .broken = -1, .slow_ms = 300, .fast_ms = 300};
    FfpQueue *queue = queue_of(&factory, 0, 3, 20);
    wait_for(&factory.begun, 3);
    ffp_queue_free(queue);
    assert_int_equal(factory.begun, 3);
    assert_int_equal(factory.ended, 3);
}

static void *raise_stop(void *argument) {
    (void)argument;
    rest(50);
    stop = true;
    return NULL;
}

static void stop_wakes_the_taker(void **state) {
    (void)state;
    Factory factory = {.end = 1000, .broken = -1, .slow_ms = 1500};
    FfpQueue *queue = queue_of(&factory, 0, 1, 4);
    pthread_t thread;
    wait_for(&factory.begun, 1);
    assert_int_equal(pthread_create(&thread, NULL, raise_stop, NULL), 0);
    assert_stopped(queue);
    assert_int_equal(factory.ended, 0); // it did not wait for the scene
    pthread_join(thread, NULL);
    ffp_queue_free(queue);
    assert_int_equal(factory.begun, 1);
    assert_int_equal(factory.ended, 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(order_is_that_of_need),
        cmocka_unit_test(an_error_comes_in_its_turn),
        cmocka_unit_test(a_full_queue_waits_and_closes),
        cmocka_unit_test(closing_waits_for_the_scenes_in_the_making),
        cmocka_unit_test(stop_wakes_the_taker),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
