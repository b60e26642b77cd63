// The encoder alone on given numbers, once for every line that is asked for: what other libraries' form of it
// is compared with, in turns (bench/peers/compare).
//   encoder_times MODEL.safetensors INPUTS [GRADIENT]
// INPUTS: float32 [tokens, patch^2 channels]. With GRADIENT, float32 [tokens, dim], a run is the forward and
// the backward pass, from this gradient of the outputs to those of the weights; without, the forward pass.
// Says "ready" and the CPU level, then reads lines: `run` is answered with the seconds of processor time and
// of wall clock of a pass, `write FILE` with "written": the last run's outputs, float32 [tokens, dim], and
// behind them the gradients of the encoder's weights in the order of the file.
#include "core/base/arena.h"
#include "core/base/cpu.h"
#include "core/tensor/tensor.h"
#include "engine/network/blocks.h"
#include "on_request.h"

enum { INPUTS_MAX = 1 << 30 }; // bytes

typedef union Block {
    FfpMambaActivations mamba;
    FfpTransformerActivations transformer;
} Block;

typedef struct Encoder {
    FfpModel *model;
    FfpWidths widths;
    int rows, in, blocks;    // in = patch^2 channels
    int64_t weights;         // the encoder's: all up to the last norm's
    const real *inputs, *dy; // [rows, in], [rows, dim]; dy NULL: forward alone
    FfpArena *arena;
    real *tokens, *mean[2], *rstd[2]; // ahead of the first norm; of the first and the last norm
    real *stream[FFP_MODULES_MAX + 1], *final;
    Block block[FFP_MODULES_MAX];
    FfpScratch scratch;
    real *dstream, *dtokens, *grad; // with dy; grad [weights]
    FfpProfileTimes unread;
} Encoder;

static real *take(Encoder *e, size_t columns) {
    return ffp_arena_take(e->arena, (size_t)e->rows * columns, sizeof(real));
}

// As the program does (engine/network/run.c): without a backward pass blocks of a kind share their memory.
static void allocate_blocks(Encoder *e) {
    const char *modules = e->model->config.modules;
    for (int i = 0; i <= e->blocks; i++)
        e->stream[i] = e->dy || i < 2 ? take(e, (size_t)e->widths.dim) : e->stream[i - 2];
    for (int i = 0; i < e->blocks; i++) {
        const int first = (int)(strchr(modules, modules[i]) - modules);
        if (!e->dy && first != i)
            e->block[i] = e->block[first];
        else if (modules[i] == 'M')
            ffp_mamba_allocate(&e->block[i].mamba, &e->widths, e->rows, e->dy != NULL, e->arena);
        else
            ffp_transformer_allocate(&e->block[i].transformer, &e->widths, e->rows, e->arena);
    }
}

static void allocate(Encoder *e) {
    const size_t dim = (size_t)e->widths.dim, inner = (size_t)e->widths.inner, mlp = FFP_MLP_RATIO * dim;
    const size_t wide = (size_t)e->widths.projected > mlp ? (size_t)e->widths.projected : mlp;
    e->arena = ffp_arena_new();
    e->tokens = take(e, dim);
    for (int i = 0; i < 2; i++) {
        e->mean[i] = take(e, 1);
        e->rstd[i] = take(e, 1);
    }
    allocate_blocks(e);
    e->final = take(e, dim);
    e->scratch.inner = take(e, inner);
    e->scratch.kernel = ffp_arena_take(e->arena, ffp_kernel_scratch(&e->widths, e->rows), sizeof(real));
    if (!e->dy) return;
    e->scratch.dwide = take(e, wide);
    e->scratch.dwide2 = take(e, wide);
    e->scratch.dinner = take(e, inner);
    e->scratch.dnarrow = take(e, dim);
    e->scratch.dnarrow2 = take(e, dim);
    e->dstream = take(e, dim);
    e->dtokens = take(e, dim);
    e->grad = ffp_arena_take(e->arena, (size_t)e->weights, sizeof(real));
}

static void forward(Encoder *e) {
    const FfpLayout *at = e->model->layout;
    const real *values = e->model->values;
    const int dim = e->widths.dim;
    const FfpBlockPass pass = {values, &e->widths, e->rows, &e->scratch, &e->unread};
    ffp_linear_forward(e->tokens, e->inputs, values + at->tokeniser, NULL, e->rows, e->in, dim);
    ffp_layernorm_forward(e->stream[0], e->mean[0], e->rstd[0], e->tokens, values + at->tokeniser_norm,
                          e->rows, dim);
    for (int i = 0; i < e->blocks; i++)
        if (e->model->config.modules[i] == 'M')
            ffp_mamba_forward(e->stream[i + 1], &e->block[i].mamba, e->stream[i], &at->blocks[i].mamba,
                              &pass);
        else
            ffp_transformer_forward(e->stream[i + 1], &e->block[i].transformer, e->stream[i],
                                    &at->blocks[i].transformer, &pass);
    ffp_layernorm_forward(e->final, e->mean[1], e->rstd[1], e->stream[e->blocks], values + at->final_norm,
                          e->rows, dim);
}

static void backward(Encoder *e) {
    const FfpLayout *at = e->model->layout;
    const real *values = e->model->values;
    const int dim = e->widths.dim;
    const FfpBlockPass pass = {values, &e->widths, e->rows, &e->scratch, &e->unread};
    memset(e->grad, 0, (size_t)e->weights * sizeof *e->grad);
    ffp_layernorm_backward(e->dstream, e->grad + at->final_norm, e->dy, e->stream[e->blocks], e->mean[1],
                           e->rstd[1], values + at->final_norm, e->rows, dim);
    for (int i = e->blocks - 1; i >= 0; i--)
        if (e->model->config.modules[i] == 'M')
            ffp_mamba_backward(e->dstream, e->grad, &e->block[i].mamba, e->stream[i], &at->blocks[i].mamba,
                               &pass);
        else
            ffp_transformer_backward(e->dstream, e->grad, &e->block[i].transformer, e->stream[i],
                                     &at->blocks[i].transformer, &pass);
    ffp_layernorm_backward(e->dtokens, e->grad + at->tokeniser_norm, e->dstream, e->tokens, e->mean[0],
                           e->rstd[0], values + at->tokeniser_norm, e->rows, dim);
    ffp_linear_backward(NULL, e->grad + at->tokeniser, NULL, e->dtokens, e->inputs, values + at->tokeniser,
                        e->rows, e->in, dim);
}

static void timed_run(void *encoder) {
    Encoder *e = encoder;
    const Moment begin = moment_now();
    forward(e);
    if (e->dy) backward(e);
    print_since(&begin, '\n');
}

// Numbers of a file that must be a whole number of rows of `columns`; *rows 0: as many as the file has.
static const real *read_rows(const char *path, int columns, int *rows, FfpError *err) {
    char *data;
    size_t size;
    const size_t row = (size_t)columns * sizeof(float);
    if (!ffp_read_file(path, INPUTS_MAX, &data, &size, err)) return NULL;
    if (*rows == 0 && size % row == 0 && size / row <= FFP_TOKENS_MAX) *rows = (int)(size / row);
    if (*rows > 0 && size == (size_t)*rows * row) return (const real *)data; // real is float in the program
    ffp_fail(err, FFP_ERROR_FILE, path, "%zu bytes are not %s rows of %d float32", size,
             *rows ? "as many" : "1 to 65536", columns);
    ffp_free(data);
    return NULL;
}

static bool open_encoder(Encoder *e, int argc, char **argv, FfpError *err) {
    FfpModel *model = e->model = ffp_model_read(argv[1], err);
    if (!model) return false;
    e->widths = ffp_widths(&model->config);
    e->in = model->config.patch * model->config.patch * ffp_input_channels(&model->config);
    e->blocks = (int)strlen(model->config.modules);
    e->weights = model->layout->final_norm + e->widths.dim;
    if (!(e->inputs = read_rows(argv[2], e->in, &e->rows, err))) return false;
    if (argc > 3 && !(e->dy = read_rows(argv[3], e->widths.dim, &e->rows, err))) return false;
    allocate(e);
    return true;
}

static void close_encoder(Encoder *e) {
    ffp_arena_free(e->arena);
    ffp_free((void *)e->inputs);
    ffp_free((void *)e->dy);
    ffp_model_free(e->model);
}

static void write_outputs(const void *encoder, FILE *out) {
    const Encoder *e = encoder;
    fwrite(e->final, sizeof(real), (size_t)e->rows * (size_t)e->widths.dim, out);
    if (e->dy) fwrite(e->grad, sizeof(real), (size_t)e->weights, out);
}

int main(int argc, char **argv) {
    FfpError err = {0};
    Encoder encoder = {0};
    if (argc != 3 && argc != 4) {
        fputs("usage: encoder_times MODEL.safetensors INPUTS [GRADIENT]\n", stderr);
        return 2;
    }
    bool ok = ffp_cpu_check(&err) && open_encoder(&encoder, argc, argv, &err);
    if (ok) {
        printf("ready %s\n", ffp_cpu_name(ffp_cpu_level()));
        ok = serve(&(Requests){&encoder, timed_run, write_outputs}, &err);
    }
    close_encoder(&encoder);
    if (!ok) fprintf(stderr, "encoder_times: error: %s\n", err.text);
    return !ok;
}
