// A call that is left gives back what it has taken, wherever it is left; one that succeeds keeps it.
// Labels: threads
#include <omp.h>
#include <stdatomic.h>
#include <time.h>
#include "comma.h"
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/log.h"

static atomic_int released, begun;

static void on_release(void *thing) {
    (void)thing;
    released++;
}

static bool hungry(void *argument, FfpError *err) {
    (void)err;
    static int thing;
    FfpArena *arena = ffp_arena_new();
    *(void **)argument = ffp_alloc(100, 1);
    ffp_arena_alloc(arena, 1000, 1);
    ffp_own(&thing, on_release);
    assert_null(ffp_try_alloc(SIZE_MAX / 2, 3));
    ffp_alloc(SIZE_MAX / 2, 3);
    fail_msg("there was room");
    return true;
}

static void sizes_that_overflow_end_the_call(void **state) {
    (void)state;
    FfpError err = {0};
    void *block = NULL;
    released = 0;
    assert_false(ffp_call_run(NULL, hungry, &block, &err));
    assert_int_equal(err.code, FFP_ERROR_MEMORY);
    assert_non_null(block);
    assert_int_equal(released, 1);
}

static bool modest(void *argument, FfpError *err) {
    (void)err;
    int *numbers = ffp_alloc(3, sizeof *numbers);
    numbers[2] = 7;
    numbers = ffp_grow(numbers, 1000, sizeof *numbers);
    *(int **)argument = numbers;
    static int thing;
    ffp_own(&thing, on_release);
    ffp_disown(&thing);
    return true;
}

static void a_call_that_succeeds_keeps_its_memory(void **state) {
    (void)state;
    int *numbers = NULL;
    released = 0;
    FfpError err = {.text = "of an earlier call", .code = FFP_ERROR_FILE};
    assert_true(ffp_call_run(NULL, modest, &numbers, &err));
    assert_true(err.code == FFP_OK && err.text[0] == 0);
    assert_true(numbers[2] == 7 && numbers[999] == 0);
    assert_int_equal((uintptr_t)numbers % 64, 0);
    assert_int_equal(released, 0);
    ffp_free(numbers);
}

// Bodies behind the bad one take their time, so that its failure is seen before they have all begun, even
// where its thread is held up for half a second.
static void greedy_body(void *argument, int64_t index) {
    const int64_t *bad = argument;
    begun++;
    if (*bad >= 0 && index > *bad) nanosleep(&(struct timespec){.tv_nsec = 5000000}, NULL);
    ffp_free(ffp_alloc(1000, 1));
    ffp_alloc(10, 1); // left for the call
    if (index == *bad) ffp_alloc(SIZE_MAX / 2, 3);
}

static bool together(void *argument, FfpError *err) {
    (void)err;
    ffp_parallel_for(1000, 4, greedy_body, argument);
    return true;
}

static bool one_by_one(void *argument, FfpError *err) {
    (void)err;
    ffp_parallel_for(1000, 1, greedy_body, argument);
    return true;
}

static void a_body_ends_the_call_behind_the_region(void **state) {
    (void)state;
    FfpError err = {0};
    int64_t bad = 500;
    begun = 0;
    assert_false(ffp_call_run(NULL, together, &bad, &err));
    assert_int_equal(err.code, FFP_ERROR_MEMORY);
    assert_true(begun > 0 && begun < 1000); // how many depends on who comes first
    begun = 0;
    assert_false(ffp_call_run(NULL, one_by_one, &bad, &err));
    assert_int_equal(begun, 501);
    bad = -1, begun = 0;
    FfpContext context = {0};
    ffp_context_fail_at(&context, 77);
    assert_false(ffp_call_run(&context, together, &bad, &err));
    assert_int_equal(err.code, FFP_ERROR_MEMORY);
}

// --- Being cancelled. ---

static bool on_progress(void *user, const FfpProgress *progress) {
    int *left = user;
    if (progress->stage) assert_string_equal(progress->stage, "counting");
    return --*left > 0;
}

static bool counts(void *argument, FfpError *err) {
    (void)err;
    int *done = argument;
    FfpTask task = ffp_task("counting", 100);
    for (*done = 0; *done < 100; ++*done) ffp_task_step(&task, *done, "one more");
    ffp_task_end(&task);
    return true;
}

static bool counts_on(void *argument, FfpError *err) {
    int *done = argument;
    ffp_cancel_hold_off(true);
    const bool ok = counts(done, err);
    assert_true(ffp_cancelled());
    return ok;
}

static bool counts_threads(void *argument, FfpError *err) {
    (void)err;
    *(int *)argument = omp_get_max_threads();
    return true;
}

static void the_caller_ends_a_call(void **state) {
    (void)state;
    FfpError err = {0};
    int left = 5, done = 0;
    FfpContext context = {.settings = {.user = &left, .progress = on_progress}};
    assert_false(ffp_call_run(&context, counts, &done, &err));
    assert_int_equal(err.code, FFP_ERROR_CANCELLED);
    assert_int_equal(done, 4);
    assert_int_equal(left, 0); // and was not asked again
    left = 5;
    assert_true(ffp_call_run(&context, counts_on, &done, &err));
    assert_int_equal(done, 100);
}

static void threads_are_the_calls_own(void **state) {
    (void)state;
    int seen = 0;
    const int before = omp_get_max_threads();
    FfpContext context = {.settings = {.threads = before + 3}};
    assert_true(ffp_call_run(&context, counts_threads, &seen, NULL));
    assert_int_equal(seen, before + 3);
    assert_int_equal(omp_get_max_threads(), before);
}

// --- The host's locale. ---

static atomic_int commas, bodies; // numbers seen with one, by `at_work`; bodies that looked

static void look(void) {
    commas += with_comma() || strtod("1.5", NULL) != 1.5;
}

static void looking_body(void *argument, int64_t index) {
    look();
    bodies++;
    ffp_note("body %d", (int)index);
    if (index == *(const int *)argument) ffp_alloc(SIZE_MAX / 2, 3);
    nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
}

static bool at_work(void *argument, FfpError *err) {
    look();
    ffp_parallel_for(40, 4, looking_body, argument);
    ffp_cancel_point();
    look();
    return *(int *)argument != 50 || ffp_fail(err, FFP_ERROR_FILE, NULL, "%.1f", 0.5);
}

static void host_has_commas(void *user, FfpLogLevel level, const char *text) {
    (void)level, (void)text;
    if (!with_comma()) *(bool *)user = false;
}

static bool host_is_asked(void *user, const FfpProgress *progress) {
    (void)progress;
    if (!with_comma()) *(bool *)user = false;
    return true;
}

// During the call numbers have decimal points, in every thread; in the host's callbacks and after the call,
// however it ends, they follow the host's locale.
static void the_hosts_locale_stays_outside(void **state) {
    (void)state;
    FfpError err = {0};
    bool right = true;
    FfpContext context = {.settings = {.user = &right, .log = host_has_commas, .progress = host_is_asked}};
    int bad = -1;
    if (!comma_locale()) skip();
    commas = bodies = 0;
    assert_true(ffp_call_run(&context, at_work, &bad, &err));
    assert_true(with_comma());
    assert_int_equal(bodies, 40);
    bad = 20; // out of memory, in a body
    assert_false(ffp_call_run(&context, at_work, &bad, &err));
    assert_true(with_comma());
    bad = 50; // an error
    assert_false(ffp_call_run(&context, at_work, &bad, &err));
    assert_string_equal(err.text, "0.5");
    assert_true(with_comma());
    setlocale(LC_NUMERIC, "C");
    assert_int_equal(commas, 0);
    assert_true(right);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_that_overflow_end_the_call),
        cmocka_unit_test(a_call_that_succeeds_keeps_its_memory),
        cmocka_unit_test(a_body_ends_the_call_behind_the_region),
        cmocka_unit_test(the_caller_ends_a_call),
        cmocka_unit_test(threads_are_the_calls_own),
        cmocka_unit_test(the_hosts_locale_stays_outside),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
