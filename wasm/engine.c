// The engine of the page (view/engine.html): what view/engine_worker.js calls. One capture and its Gaussians
// at a time; messages and progress go to the worker's listener.
#include <emscripten.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "ffprocams.h"

enum { COMMAND_WORDS = 4096 };

int command_line(int argc, char **argv); // src/product/cli/main.c
int engine_command(const char *lines);
const char *engine_open(const char *path);
const char *engine_run(int polish, int force);
const char *engine_save(const char *path);
double engine_peak(void);

static FfpContext *context;
static FfpModel *model;
static FfpCapture *capture;
static FfpGaussians *gaussians;
static char *description;
static char answer[2048];

// clang-format off
EM_JS(void, tell_progress, (const char *stage, double done, double total, double left), {
    postMessage({kind: "progress", stage: stage ? UTF8ToString(stage) : "", done: done, total: total, left: left});
})
// clang-format on

// Threads of the pool have messages too; the worker's listener hears the engine's own alone.
static void log_line(void *user, FfpLogLevel level, const char *text) {
    (void)user;
    MAIN_THREAD_EM_ASM({ postMessage({kind : "log", level : $0, text : UTF8ToString($1)}); }, (int)level,
                       text);
}

static void tell_finding(void *user, const FfpFinding *finding) {
    (void)user;
    char *text = ffp_finding_json(finding);
    if (text) MAIN_THREAD_EM_ASM({ postMessage({kind : "finding", finding : UTF8ToString($0)}); }, text);
    ffp_free(text);
}

static bool show_progress(void *user, const FfpProgress *progress) {
    (void)user;
    tell_progress(progress->stage, (double)progress->done, (double)progress->total, progress->left_s);
    return true;
}

// A fault of the capture is an error that engine_run's `force` goes past.
static const char *failed(const FfpError *err) {
    snprintf(answer, sizeof answer, "%s: %s", err->code == FFP_ERROR_FAULT ? "fault" : "error", err->text);
    return answer;
}

static bool start(FfpError *err) {
    FfpContextSettings settings = ffp_context_defaults();
    settings.log = log_line;
    settings.progress = show_progress;
    settings.finding = tell_finding;
    settings.interval_s = 0.5; // seconds: each is drawn, by a processor where no GPU draws
    if (!context) context = ffp_context_new(&settings, err);
    if (context && !model) model = ffp_model_open(context, "/models/small.safetensors", NULL, err);
    return model != NULL;
}

// Runs a command line: its words, one a line, each ended by \n. Returns its exit status.
EMSCRIPTEN_KEEPALIVE int engine_command(const char *lines) {
    char *words = strdup(lines), *argv[COMMAND_WORDS + 1] = {NULL};
    int argc = 0, status = 1;
    for (char *at = words, *end; at && argc < COMMAND_WORDS && (end = strchr(at, '\n')); at = end + 1) {
        *end = 0;
        argv[argc++] = at;
    }
    if (argc > 0) status = command_line(argc, argv);
    fflush(NULL);
    free(words);
    return status;
}

// Opens the capture in a folder or at a scene.json. Returns what `ffprocams info` says of it, or "error:
// ...".
EMSCRIPTEN_KEEPALIVE const char *engine_open(const char *path) {
    FfpError err = {0};
    if (!start(&err)) return failed(&err);
    ffp_gaussians_close(gaussians);
    gaussians = NULL;
    ffp_capture_close(capture);
    capture = ffp_capture_open(context, path, NULL, &err);
    ffp_free(description);
    description = capture ? ffp_info(context, path, &err) : NULL;
    return description ? description : failed(&err);
}

// Reconstructs; `polish` as FfpReconstruction's, `force` to go on although the capture has a fault. Returns
// JSON, "error: ..." or "fault: ...".
EMSCRIPTEN_KEEPALIVE const char *engine_run(int polish, int force) {
    FfpError err = {0};
    FfpReconstruction options = ffp_reconstruction_defaults();
    FfpReconstructionStats stats = {0};
    options.model = model;
    options.force = force != 0;
    if (polish >= 0) options.polish = polish;
    ffp_gaussians_close(gaussians);
    gaussians = ffp_reconstruct(context, capture, &options, &stats, &err);
    if (!gaussians) return failed(&err);
    snprintf(answer, sizeof answer,
             "{\"gaussians\": %lld, \"patterns\": %d, \"psnr\": %.3f, \"initialisation\": %.3f, \"network\": "
             "%.3f, "
             "\"polish\": %.3f, \"noise\": %.3f, \"score\": %.3f}",
             (long long)stats.gaussians, stats.patterns, stats.psnr, stats.initialisation_s, stats.network_s,
             stats.polish_s, stats.denoise_s, stats.score_s);
    return answer;
}

static bool save(const char *path, FfpError *err) {
    const char *dot = strrchr(path, '.');
    if (dot && strcmp(dot, ".html") == 0) {
        FfpPage page = ffp_page_defaults();
        page.file = path;
        return ffp_write_page(context, gaussians, capture, &page, NULL, err);
    }
    if (dot && (strcmp(dot, ".spz") == 0 || strcmp(dot, ".glb") == 0)) {
        FfpExport splats = ffp_export_defaults();
        splats.file = path;
        return ffp_export(context, gaussians, capture, &splats, NULL, err);
    }
    return ffp_gaussians_save(context, gaussians, path, err);
}

// Writes the Gaussians: .html the page that shows them; .spz and .glb splats in ambient light; or .ply.
// Returns "", or "error: ...".
EMSCRIPTEN_KEEPALIVE const char *engine_save(const char *path) {
    FfpError err = {0};
    return save(path, &err) ? "" : failed(&err);
}

// Bytes of memory that the engine has taken, which WebAssembly never gives back.
EMSCRIPTEN_KEEPALIVE double engine_peak(void) {
    return (double)(__builtin_wasm_memory_size(0) * (size_t)65536);
}
