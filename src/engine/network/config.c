// Model configurations: presets and checks.
#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include "engine/network/layout.h"

// The presets' differences; `paper` and `paper-small` have the paper's plain heads, without a start.
static const struct {
    const char *name, *modules;
    int dim;
    bool ours;
    int pixel_features, pixel_hidden;
} presets[] = {
    {"tiny", "MTMT", 128, true, 8, 32},
    {"small", "MTMTMTMT", 256, true, 24, 96},
    {"paper-small", "MTMTMTMT", 256, false, 0, 0},
    {"paper", "MTMTMTMTMTMTMTMTMTMTMTMT", 1024, false, 0, 0},
};

bool ffp_model_preset(FfpModelConfig *config, const char *name) {
    size_t i = 0;
    while (i < sizeof presets / sizeof *presets && strcmp(presets[i].name, name) != 0) i++;
    if (i == sizeof presets / sizeof *presets) return false;
    const bool ours = presets[i].ours;
    *config = (FfpModelConfig){.dim = presets[i].dim,
                               .patch = 8,
                               .tokens = 4096,
                               .state = 64,
                               .chunk = 64,
                               .residual = ours,
                               .match_input = ours,
                               .pixel_skip = ours,
                               .context_inputs = ours,
                               .pixel_features = presets[i].pixel_features,
                               .pixel_hidden = presets[i].pixel_hidden,
                               .look_hidden = 2 * presets[i].pixel_hidden};
    snprintf(config->name, sizeof config->name, "%s", presets[i].name);
    snprintf(config->modules, sizeof config->modules, "%s", presets[i].modules);
    snprintf(config->render, sizeof config->render, "%s", ours ? "ours" : "paper");
    config->samples = ours ? 2 : 1;
    return true;
}

bool ffp_model_is_paper_form(const FfpModelConfig *config) {
    return strcmp(config->render, "paper") == 0;
}

static bool refuse(FfpError *err, const char *where, const char *field, const char *what) {
    char name[64];
    snprintf(name, sizeof name, "model.%s", field);
    return ffp_fail(err, FFP_ERROR_FILE, where ? ffp_place(where, name).text : name, "%s", what);
}

static bool check_range(int value, int low, int high, int step, const char *field, const char *where,
                        FfpError *err) {
    if (value >= low && value <= high && value % step == 0) return true;
    char what[96];
    snprintf(what, sizeof what, step > 1 ? "%d is not in %d..%d in steps of %d" : "%d is not in %d..%d",
             value, low, high, step);
    return refuse(err, where, field, what);
}

static bool is_printable(const char *text, size_t size) {
    if (!*text || !memchr(text, 0, size)) return false;
    for (; *text; text++)
        if (!isprint((unsigned char)*text)) return false;
    return true;
}

bool ffp_model_config_check(const FfpModelConfig *config, const char *where, FfpError *err) {
    if (!is_printable(config->name, sizeof config->name)) return refuse(err, where, "name", "not a name");
    if (!is_printable(config->modules, sizeof config->modules) ||
        strspn(config->modules, "MT") != strlen(config->modules))
        return refuse(err, where, "modules", "must be letters M and T, at least one");
    if (!memchr(config->render, 0, sizeof config->render) ||
        (strcmp(config->render, "ours") != 0 && strcmp(config->render, "paper") != 0))
        return refuse(err, where, "render", "must be ours or paper");
    if (!check_range(config->samples, 1, 4, 1, "samples", where, err) ||
        !check_range(config->dim, 64, 4096, 64, "dim", where, err) ||
        !check_range(config->patch, 1, 32, 1, "patch", where, err) ||
        !check_range(config->tokens, 1, FFP_TOKENS_MAX, 1, "tokens", where, err) ||
        !check_range(config->state, 1, 512, 1, "state", where, err) ||
        !check_range(config->chunk, 1, 1024, 1, "chunk", where, err))
        return false;
    if (!check_range(config->looks, 0, config->pixel_skip ? FFP_LOOKS_MAX : 0, 1, "looks", where, err) ||
        !check_range(config->look_hidden, config->looks ? 1 : 0, 1024, 1, "look_hidden", where, err))
        return false;
    const int least = config->pixel_skip ? 1 : 0; // without the pixel MLP its widths mean nothing
    return check_range(config->pixel_features, least, 256, 1, "pixel_features", where, err) &&
           check_range(config->pixel_hidden, least, 1024, 1, "pixel_hidden", where, err);
}
