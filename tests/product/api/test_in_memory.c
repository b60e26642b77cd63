// Files that are bytes in the caller's memory, and memory from the caller's allocator.
#include <stdatomic.h>
#include <stdlib.h>
#include "core/base/file.h"
#include "initialised.h"

static FfpError err;

static void assert_fails(bool failed, FfpErrorCode code, const char *text) {
    if (!failed || err.code != code || !strstr(err.text, text)) fail_msg("not %s: %s", text, err.text);
    err = (FfpError){0};
}

// --- Bytes for files. ---

static void assert_contents(const char *path, const void *bytes, size_t size) {
    char *file;
    size_t on_disk;
    assert_true(ffp_read_file(path, 1 << 28, &file, &on_disk, &err));
    assert_int_equal(size, on_disk);
    assert_memory_equal(bytes, file, size);
    ffp_free(file);
}

static void gaussians_are_the_bytes_of_their_file(void **state) {
    (void)state;
    size_t size = 0;
    assert_true(ffp_gaussians_save(NULL, gaussians, in_scratch("saved.ply"), &err));
    void *bytes = ffp_gaussians_bytes(NULL, gaussians, &size, &err);
    if (!bytes) fail_msg("%s", err.text);
    assert_contents(in_scratch("saved.ply"), bytes, size);
    FfpGaussians *from_file = ffp_gaussians_open(NULL, in_scratch("saved.ply"), NULL, &err);
    if (!from_file) fail_msg("%s", err.text);
    size_t as_much = 0, once_more = 0;
    void *same = ffp_gaussians_bytes(NULL, from_file, &as_much, &err);
    // A name that is also a folder's, and one without a file: neither is looked at.
    const char *const names[] = {NULL, in_scratch("capture"), "nowhere.ply"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        FfpGaussians *from_bytes = ffp_gaussians_open(NULL, names[i], &(FfpBytes){bytes, size}, &err);
        if (!from_bytes) fail_msg("%s", err.text);
        void *again = ffp_gaussians_bytes(NULL, from_bytes, &once_more, &err);
        assert_int_equal(once_more, as_much);
        assert_memory_equal(again, same, as_much);
        ffp_free(again);
        ffp_gaussians_close(from_bytes);
    }
    ffp_free(same);
    ffp_gaussians_close(from_file);
    assert_fails(!ffp_gaussians_open(NULL, "a.ply", &(FfpBytes){bytes, size - 1}, &err), FFP_ERROR_FILE,
                 "(a.ply");
    assert_fails(!ffp_gaussians_open(NULL, NULL, &(FfpBytes){bytes, 0}, &err), FFP_ERROR_FILE, "is empty");
    assert_fails(!ffp_gaussians_open(NULL, NULL, &(FfpBytes){NULL, 4}, &err), FFP_ERROR_ARGUMENT,
                 "contents.data");
    assert_fails(!ffp_gaussians_open(NULL, NULL, &(FfpBytes){"neither", 7}, &err), FFP_ERROR_FILE,
                 "contents");
    assert_fails(!ffp_gaussians_bytes(NULL, gaussians, NULL, &err), FFP_ERROR_ARGUMENT, "size");
    ffp_free(bytes);
}

static void other_formats_are_read_from_bytes(void **state) {
    (void)state;
    static const char *const names[] = {"splats.spz", "splats.glb"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        FfpExport how = ffp_export_defaults();
        char *bytes;
        size_t size;
        how.file = in_scratch(names[i]);
        assert_true(ffp_export(NULL, gaussians, NULL, &how, NULL, &err));
        assert_true(ffp_read_file(in_scratch(names[i]), 1 << 28, &bytes, &size, &err));
        FfpGaussians *from_file = ffp_gaussians_open(NULL, in_scratch(names[i]), NULL, &err);
        FfpGaussians *from_bytes = ffp_gaussians_open(NULL, names[i], &(FfpBytes){bytes, size}, &err);
        if (!from_file || !from_bytes) fail_msg("%s", err.text);
        const FfpGaussianArrays a = ffp_gaussians_arrays(from_file), b = ffp_gaussians_arrays(from_bytes);
        assert_int_equal(a.count, b.count);
        assert_memory_equal(a.centre, b.centre, 3 * (size_t)a.count * sizeof(float));
        assert_memory_equal(a.ambient, b.ambient, 3 * (size_t)a.count * sizeof(float));
        ffp_gaussians_close(from_file);
        ffp_gaussians_close(from_bytes);
        ffp_free(bytes);
    }
}

static void contents_name_no_other_file(void **state) {
    (void)state;
    static const char json[] =
        "{\"asset\": {\"version\": \"2.0\"}, \"buffers\": [{\"uri\": \"beside.bin\", \"byteLength\": 4}]}";
    FILE *beside = fopen(in_scratch("beside.bin"), "w");
    assert_true(beside && fputs("1234", beside) > 0 && fclose(beside) == 0);
    assert_fails(!ffp_gaussians_open(NULL, in_scratch("mine.gltf"), &(FfpBytes){json, sizeof json - 1}, &err),
                 FFP_ERROR_FILE, "cannot name a file ('beside.bin')");
}

static void weights_are_the_bytes_of_their_file(void **state) {
    (void)state;
    char *file;
    size_t on_disk, size = 0;
    assert_true(ffp_read_file(in_scratch("weights"), 1 << 28, &file, &on_disk, &err));
    FfpModel *model = ffp_model_open(NULL, NULL, &(FfpBytes){file, on_disk}, &err);
    if (!model) fail_msg("%s", err.text);
    for (int exact = 0; exact < 2; exact++) {
        assert_true(ffp_model_save(NULL, model, in_scratch("again"), exact, &err));
        void *bytes = ffp_model_bytes(NULL, model, exact, &size, &err);
        if (!bytes) fail_msg("%s", err.text);
        assert_contents(in_scratch("again"), bytes, size);
        ffp_free(bytes);
    }
    assert_int_equal(size, on_disk);
    assert_fails(!ffp_model_open(NULL, "mine", &(FfpBytes){file, on_disk / 2}, &err), FFP_ERROR_FILE,
                 "(mine");
    ffp_model_close(model);
    ffp_free(file);
}

// --- The caller's memory. ---

typedef struct Heap {
    atomic_llong asked, held, most; // blocks: asked for, held now, held at once
    long long fail;                 // the one that is refused; 0: none
} Heap;

static void *take(void *user, size_t alignment, size_t bytes) {
    Heap *heap = user;
    if (++heap->asked == heap->fail) return NULL;
    const long long held = ++heap->held;
    if (held > heap->most) heap->most = held;
    return aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
}

static void give_back(void *user, void *memory) {
    ((Heap *)user)->held--;
    free(memory);
}

static FfpContext *context_with(Heap *heap) {
    FfpContextSettings settings = ffp_context_defaults();
    settings.user = heap;
    settings.allocate = take;
    settings.release = give_back;
    FfpContext *context = ffp_context_new(&settings, &err);
    if (!context) fail_msg("%s", err.text);
    return context;
}

static FfpGaussians *fitted(FfpContext *context) {
    FfpCapture *own = ffp_capture_open(context, in_scratch("capture"), NULL, &err);
    FfpModel *model = own ? ffp_model_open(context, in_scratch("weights"), NULL, &err) : NULL;
    const FfpReconstruction how = {.size = sizeof how, .model = model, .polish = 2};
    FfpGaussians *made = model ? ffp_reconstruct(context, own, &how, NULL, &err) : NULL;
    ffp_model_close(model);
    ffp_capture_close(own);
    return made;
}

static void calls_take_the_callers_memory(void **state) {
    (void)state;
    Heap heap = {0};
    FfpContext *context = context_with(&heap);
    FfpGaussians *plain = fitted(NULL), *made = fitted(context);
    if (!plain || !made) fail_msg("%s", err.text);
    assert_true(heap.asked > 100 && heap.most > 10);
    const FfpGaussianArrays a = ffp_gaussians_arrays(plain), b = ffp_gaussians_arrays(made);
    assert_int_equal(a.count, b.count);
    assert_memory_equal(a.centre, b.centre, 3 * (size_t)a.count * sizeof(float));
    assert_memory_equal(a.albedo, b.albedo, 3 * (size_t)a.count * sizeof(float));
    ffp_context_free(context);
    assert_true(heap.held > 0); // of the Gaussians, which outlive it
    ffp_gaussians_close(made);
    assert_int_equal(heap.held, 0);
    ffp_gaussians_close(plain);
}

static void memory_that_the_caller_refuses_ends_the_call(void **state) {
    (void)state;
    static const long long places[] = {1, 2, 7, 50};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        Heap heap = {.fail = places[i]};
        FfpContext *context = context_with(&heap);
        assert_fails(!fitted(context), FFP_ERROR_MEMORY, "out of memory");
        assert_int_equal(heap.held, 0);
        ffp_context_free(context);
    }
}

static void allocate_and_release_go_together(void **state) {
    (void)state;
    FfpContextSettings settings = ffp_context_defaults();
    settings.allocate = take;
    assert_fails(!ffp_context_new(&settings, &err), FFP_ERROR_ARGUMENT, "allocate");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gaussians_are_the_bytes_of_their_file),
        cmocka_unit_test(other_formats_are_read_from_bytes),
        cmocka_unit_test(contents_name_no_other_file),
        cmocka_unit_test(weights_are_the_bytes_of_their_file),
        cmocka_unit_test(calls_take_the_callers_memory),
        cmocka_unit_test(memory_that_the_caller_refuses_ends_the_call),
        cmocka_unit_test(allocate_and_release_go_together),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
