// Several ranks make the run that one makes, to rounding, and the same bits again; ranks here are threads,
// each with a context of its own, so that this needs no MPI. (tests/product/cli/test_cli_ranks.c has
// processes.)
// Labels: slow
#include <math.h>
#include <pthread.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "lab/train/shard.h"
#include "lab/train/train.h"
#include "scratch.h"
#include "world/synth/dataset.h"

enum { RANKS_MAX = 4, PENDING_MAX = 16, STEPS = 5 };

// --- Ranks that are threads. ---

typedef struct Job {
    int count;
    pthread_barrier_t barrier;
    void *slot[RANKS_MAX]; // what each rank shows the others
} Job;

typedef struct Rank {
    Job *job;
    FfpRanks table;
    struct {
        float *values;
        int64_t count;
    } pending[PENDING_MAX];
    int n_pending, most_pending;
    FfpTrainRun run;
    bool stops; // its caller wants it to end at once
    bool ok;
    FfpError err;
    pthread_t thread;
} Rank;

static void show(Rank *rank, void *thing) {
    rank->job->slot[rank->table.rank] = thing;
    pthread_barrier_wait(&rank->job->barrier);
}

static void hide(Rank *rank) {
    pthread_barrier_wait(&rank->job->barrier);
}

static void sum_floats(Rank *rank, float *values, int64_t count) {
    show(rank, values);
    for (int64_t i = 0; rank->table.rank == 0 && i < count; i++) {
        float total = 0;
        for (int r = 0; r < rank->job->count; r++) total += ((float *)rank->job->slot[r])[i];
        for (int r = 0; r < rank->job->count; r++) ((float *)rank->job->slot[r])[i] = total;
    }
    hide(rank);
}

static void sum_begin(void *user, float *values, int64_t count) {
    Rank *rank = user;
    if (rank->n_pending == PENDING_MAX) abort();
    rank->pending[rank->n_pending].values = values;
    rank->pending[rank->n_pending++].count = count;
    if (rank->n_pending > rank->most_pending) rank->most_pending = rank->n_pending;
}

static bool sum_finish(void *user, FfpError *err) {
    Rank *rank = user;
    (void)err;
    for (int i = 0; i < rank->n_pending; i++)
        sum_floats(rank, rank->pending[i].values, rank->pending[i].count);
    rank->n_pending = 0;
    return true;
}

static bool sum(void *user, double *values, int count, FfpError *err) {
    Rank *rank = user;
    (void)err;
    show(rank, values);
    for (int i = 0; rank->table.rank == 0 && i < count; i++) {
        double total = 0;
        for (int r = 0; r < rank->job->count; r++) total += ((double *)rank->job->slot[r])[i];
        for (int r = 0; r < rank->job->count; r++) ((double *)rank->job->slot[r])[i] = total;
    }
    hide(rank);
    return true;
}

static bool gather(void *user, const float *part, float *whole, const int64_t *first, int to, FfpError *err) {
    Rank *rank = user;
    (void)err;
    show(rank, (void *)part);
    for (int r = 0; (to < 0 || to == rank->table.rank) && r < rank->job->count; r++)
        if (whole + first[r] != rank->job->slot[r])
            memcpy(whole + first[r], rank->job->slot[r], sizeof *whole * (size_t)(first[r + 1] - first[r]));
    hide(rank);
    return true;
}

static bool broadcast(void *user, void *bytes, int64_t size, int from, FfpError *err) {
    Rank *rank = user;
    (void)err;
    show(rank, bytes);
    if (rank->table.rank != from) memcpy(bytes, rank->job->slot[from], (size_t)size);
    hide(rank);
    return true;
}

static void leave(void *user) {
    (void)user;
    abort();
}

static bool go_on(void *user, const FfpProgress *progress) {
    (void)progress;
    return !((const Rank *)user)->stops;
}

static bool work(void *argument, FfpError *err) {
    return ffp_train_run(&((Rank *)argument)->run, err);
}

static void *live(void *argument) {
    Rank *rank = argument;
    FfpContext context = {.settings = {.user = rank, .progress = go_on, .threads = 1, .ranks = &rank->table}};
    rank->ok = ffp_call_run(&context, work, rank, &rank->err);
    return NULL;
}

// Trains with `count` ranks; those that stop do so at once.
static void train(Rank *ranks, int count, const FfpTrainRun *run, int stopping) {
    Job job = {.count = count};
    pthread_barrier_init(&job.barrier, NULL, (unsigned)count);
    for (int r = 0; r < count; r++) {
        ranks[r] = (Rank){.job = &job, .run = *run, .stops = r == stopping};
        ranks[r].table = (FfpRanks){.user = &ranks[r],
                                    .rank = r,
                                    .count = count,
                                    .sum_begin = sum_begin,
                                    .sum_finish = sum_finish,
                                    .sum = sum,
                                    .gather = gather,
                                    .broadcast = broadcast,
                                    .leave = leave};
    }
    for (int r = 0; r < count; r++)
        assert_int_equal(pthread_create(&ranks[r].thread, NULL, live, &ranks[r]), 0);
    for (int r = 0; r < count; r++) pthread_join(ranks[r].thread, NULL);
    pthread_barrier_destroy(&job.barrier);
}

static void train_well(const char *out, const char *config, int count, int64_t stop_at, bool resume) {
    Rank ranks[RANKS_MAX];
    const FfpTrainRun run = {
        .out = out, .config = resume ? NULL : config, .steps = -1, .stop_at = stop_at, .resume = resume};
    train(ranks, count, &run, -1);
    for (int r = 0; r < count; r++)
        if (!ranks[r].ok) fail_msg("rank %d: %s", r, ranks[r].err.text);
    // more than one sum under way: they begin before the gradient is whole
    for (int r = 0; count > 1 && r < count; r++) assert_true(ranks[r].most_pending > 1);
}

// --- Runs that are compared. ---

// A model of 1.2 million weights, for more than one bucket.
static const char form[] =
    "{\"model\": {\"preset\": \"tiny\", \"dim\": 192}, \"resolution\": 16, \"reuse\": 2,"
    " \"views\": 2, \"targets\": 1, \"lollipops\": 1, \"pattern_side\": 64, \"samples\": 1,"
    " \"ambient_rays\": 1, \"supervised_inputs\": 1, \"supervised_targets\": 1, \"steps\": 5,"
    " \"warmup_steps\": 1, \"validate_every\": 0,"
    " \"log_every\": 1%s}";

// Its path is good until the next.
static const char *write_config(const char *name, const char *fields) {
    static char path[FFP_PATH_MAX];
    char text[1024];
    snprintf(path, sizeof path, "%s", in_scratch(name));
    const int length = snprintf(text, sizeof text, form, fields);
    assert_true(ffp_write_file(path, text, (size_t)length, NULL));
    return path;
}

typedef struct State {
    FfpModel *model;
    FfpAdam adam;
} State;

static State read_state(const char *out) {
    State state;
    FfpTrainConfig config;
    char path[FFP_PATH_MAX], origin[FFP_ORIGIN_MAX];
    FfpError err = {0};
    assert_true(ffp_join_path(path, out, "checkpoint.safetensors"));
    state.model = ffp_checkpoint_read(path, &state.adam, &config, origin, &err);
    if (!state.model) fail_msg("%s", err.text);
    return state;
}

static void free_state(State *state) {
    ffp_model_free(state->model);
    ffp_adam_free(&state->adam);
}

// The root mean square of the difference, over that of `a`. Single numbers may differ by more: where a
// gradient is all rounding, Adam's first steps are of full length whichever way it points.
static double apart(const real *a, const real *b, int64_t count) {
    double squares = 0, off = 0;
    for (int64_t i = 0; i < count; i++) {
        const double difference = (double)a[i] - b[i];
        squares += (double)a[i] * a[i], off += difference * difference;
    }
    return sqrt(off / squares);
}

static void assert_runs_agree(const char *a, const char *b, double tolerance) {
    State x = read_state(a), y = read_state(b);
    assert_int_equal(x.adam.step, y.adam.step);
    const int64_t n = x.model->count;
    const double values = apart(x.model->values, y.model->values, n), m = apart(x.adam.m, y.adam.m, n),
                 ema = apart(x.adam.ema, y.adam.ema, n);
    printf("%s and %s: weights %.2g, averages %.2g, moments %.2g apart\n", ffp_basename(a), ffp_basename(b),
           values, ema, m);
    if (values > tolerance || ema > tolerance || m > 100 * tolerance) fail_msg("too far apart");
    free_state(&x);
    free_state(&y);
}

static void assert_same_files(const char *a, const char *b, const char *name) {
    char path[2][FFP_PATH_MAX], *text[2];
    size_t size[2];
    assert_true(ffp_join_path(path[0], a, name) && ffp_join_path(path[1], b, name));
    for (int i = 0; i < 2; i++) assert_true(ffp_read_file(path[i], 1 << 28, &text[i], &size[i], NULL));
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(text[0], text[1], size[0]);
    ffp_free(text[0]), ffp_free(text[1]);
}

static void ranks_make_the_run_of_one(void **state) {
    (void)state;
    const char *config = write_config("batch.json", ", \"batch\": 4");
    train_well(in_scratch("one"), config, 1, 0, false);
    train_well(in_scratch("two"), config, 2, 0, false);
    train_well(in_scratch("four"), config, 4, 0, false);
    train_well(in_scratch("again"), config, 4, 0, false);
    assert_runs_agree(in_scratch("one"), in_scratch("two"), 2e-5);
    assert_runs_agree(in_scratch("one"), in_scratch("four"), 2e-5);
    assert_same_files(in_scratch("four"), in_scratch("again"), "checkpoint.safetensors");
    // and what it makes is not what another batch makes
    train_well(in_scratch("single"), write_config("single.json", ""), 1, 0, false);
    State one = read_state(in_scratch("one")), single = read_state(in_scratch("single"));
    assert_true(apart(one.model->values, single.model->values, one.model->count) > 1e-2);
    free_state(&one), free_state(&single);
}

static void another_number_of_ranks_goes_on(void **state) {
    (void)state;
    const char *config = write_config("batch.json", ", \"batch\": 4");
    train_well(in_scratch("changed"), config, 4, 2, false);
    train_well(in_scratch("changed"), config, 2, 4, true);
    train_well(in_scratch("changed"), config, 1, 0, true);
    assert_runs_agree(in_scratch("one"), in_scratch("changed"), 2e-5);
    // with the same number the bits are the same
    train_well(in_scratch("halved"), config, 4, 3, false);
    train_well(in_scratch("halved"), config, 4, 0, true);
    assert_same_files(in_scratch("four"), in_scratch("halved"), "checkpoint.safetensors");
}

// Every draw is one rank's, and no scene is made by two.
static void draws_are_disjoint(void **state) {
    (void)state;
    FfpTrainConfig config;
    char text[1024];
    FfpError err = {0};
    snprintf(text, sizeof text, form, ", \"batch\": 4, \"generators\": 2");
    assert_true(ffp_train_config_parse(&config, text, "test", &err));
    int owner[256];
    memset(owner, -1, sizeof owner);
    for (int rank = 0; rank < 4; rank++) {
        atomic_bool stop = false;
        const FfpSceneOrigin generated = {0};
        FfpStream *stream = ffp_stream_new(&config, &generated, (FfpRank){rank, 4}, 1, STEPS, &stop, &err);
        for (int64_t draw = 4 + rank; draw < 4 * STEPS; draw += 4) {
            const FfpScene *scene = NULL;
            bool fresh;
            if (!ffp_stream_scene(stream, draw, &scene, &fresh, &err)) fail_msg("%s", err.text);
            assert_non_null(scene);
            assert_int_equal(scene->inputs.views[0].camera.width, 16);
            const int64_t number = ffp_scene_number(&config, draw);
            assert_true(number < 256 && (owner[number] < 0 || owner[number] == rank));
            owner[number] = rank;
        }
        ffp_stream_free(stream);
    }
}

static void recomputed_activations_change_no_bit(void **state) {
    (void)state;
    train_well(in_scratch("kept"), write_config("kept.json", ""), 1, 3, false);
    train_well(in_scratch("recomputed"), write_config("recomputed.json", ", \"recompute\": true"), 1, 3,
               false);
    assert_runs_agree(in_scratch("kept"), in_scratch("recomputed"), 0);
}

static void one_that_is_stopped_stops_all(void **state) {
    (void)state;
    const FfpTrainRun run = {
        .out = in_scratch("stopped"), .config = write_config("stop.json", ", \"batch\": 2"), .steps = -1};
    Rank ranks[RANKS_MAX];
    train(ranks, 2, &run, 1);
    assert_true(ranks[0].ok && ranks[1].ok);
    State stopped = read_state(in_scratch("stopped"));
    assert_int_equal(stopped.adam.step, 0);
    free_state(&stopped);
}

static void train_badly(const char *config, const char *what[2]) {
    char out[FFP_PATH_MAX];
    Rank ranks[RANKS_MAX];
    snprintf(out, sizeof out, "%s", in_scratch("bad"));
    const FfpTrainRun run = {.out = out, .config = config, .steps = -1};
    train(ranks, 2, &run, -1);
    for (int r = 0; r < 2; r++) {
        assert_false(ranks[r].ok);
        if (!strstr(ranks[r].err.text, what[r])) fail_msg("rank %d: %s", r, ranks[r].err.text);
    }
}

static void refusals(void **state) {
    (void)state;
    train_badly(write_config("odd.json", ", \"batch\": 3"),
                (const char *[]){"3 scenes per step cannot be divided among 2 ranks", "batch"});
    train_badly(write_config("pool.json", ", \"batch\": 2, \"pool\": 5"),
                (const char *[]){"5 scenes cannot be divided among 2 ranks", "pool"});
}

// The scene that rank 1 draws first is broken: it says which, and rank 0 does not wait for it.
static void a_failure_is_everybodys(void **state) {
    (void)state;
    char folder[FFP_PATH_MAX], broken[FFP_PATH_MAX];
    snprintf(folder, sizeof folder, "%s", in_scratch("scenes"));
    FfpError err = {0};
    const FfpDatasetSettings settings = {
        .folder = folder, .split = "train", .preset = FFP_DATASET_TRAINING, .count = 2, .resolution = 16};
    if (!ffp_dataset_write(&settings, &err)) fail_msg("%s", err.text);
    FfpSceneFolder list;
    assert_true(ffp_scene_folder_open(&list, folder, &err));
    const char *name = ffp_scene_folder_name(&list, 1, 1);
    snprintf(broken, sizeof broken, "%.200s/%s/scene.json", folder, name);
    assert_true(ffp_write_file(broken, "{", 1, NULL));
    char text[2048];
    const int length = snprintf(text, sizeof text,
                                "{\"model\": \"tiny\", \"resolution\": 16, \"views\": 2, \"targets\": 1,"
                                " \"lollipops\": 1, \"steps\": 5, \"supervised_inputs\": 1,"
                                " \"supervised_targets\": 1, \"pool\": 2,"
                                " \"batch\": 2, \"scenes\": \"%.200s\"}",
                                folder);
    assert_true(ffp_write_file(in_scratch("broken.json"), text, (size_t)length, NULL));
    train_badly(in_scratch("broken.json"), (const char *[]){"the step failed on another rank", name});
    ffp_scene_folder_close(&list);
}

// --- Memory that is out. ---

static int left; // times that a rank said so

static void note_leaving(void *user) {
    (void)user;
    left++;
}

static void sum_nothing(void *user, float *values, int64_t count) {
    (void)user, (void)values, (void)count;
}

static bool finish_nothing(void *user, FfpError *err) {
    (void)user, (void)err;
    return true;
}

static bool add_nothing(void *user, double *values, int count, FfpError *err) {
    (void)user, (void)values, (void)count, (void)err;
    return true;
}

static bool gather_nothing(void *user, const float *part, float *whole, const int64_t *first, int to,
                           FfpError *err) {
    (void)user, (void)part, (void)whole, (void)first, (void)to, (void)err;
    return true;
}

static bool broadcast_nothing(void *user, void *bytes, int64_t size, int from, FfpError *err) {
    (void)user, (void)bytes, (void)size, (void)from, (void)err;
    return true;
}

// Where a rank's call is left in the middle of things the others hear of it, once; not when it ends well, nor
// before the ranks have met: the first allocations are the model's.
static void a_call_that_is_left_tells_the_others(void **state) {
    (void)state;
    char out[FFP_PATH_MAX], config[FFP_PATH_MAX];
    snprintf(config, sizeof config, "%s", write_config("left.json", ", \"batch\": 2"));
    FfpRanks table = {.count = 2,
                      .sum_begin = sum_nothing,
                      .sum_finish = finish_nothing,
                      .sum = add_nothing,
                      .gather = gather_nothing,
                      .broadcast = broadcast_nothing,
                      .leave = note_leaving};
    int times = 0;
    for (long long fail = 1; fail < 1 << 20; fail *= 4, times++) {
        snprintf(out, sizeof out, "%s", in_scratch("left"));
        Rank rank = {.run = {.out = out, .config = config, .steps = -1, .stop_at = 2}};
        FfpContext context = {.settings = {.threads = 1, .ranks = &table}};
        ffp_context_fail_at(&context, fail);
        left = 0;
        const bool ok = ffp_call_run(&context, work, &rank, &rank.err);
        if (ok) break;
        assert_int_equal(rank.err.code, FFP_ERROR_MEMORY);
        if (left != (fail > 4)) fail_msg("allocation %lld failed, %d heard of it", fail, left);
        if (ffp_is_file(in_scratch("left/metrics.jsonl")))
            assert_int_equal(remove(in_scratch("left/metrics.jsonl")), 0);
    }
    assert_true(times > 3 && left == 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(draws_are_disjoint),
        cmocka_unit_test(ranks_make_the_run_of_one),
        cmocka_unit_test(another_number_of_ranks_goes_on),
        cmocka_unit_test(recomputed_activations_change_no_bit),
        cmocka_unit_test(one_that_is_stopped_stops_all),
        cmocka_unit_test(refusals),
        cmocka_unit_test(a_failure_is_everybodys),
        cmocka_unit_test(a_call_that_is_left_tells_the_others),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
