// Model configurations: presets and checks.
#include "network/network.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

static const FfpModelConfig presets[] = {
    {.name = "tiny",
     .modules = "MTMT",
     .dim = 128,
     .patch = 8,
     .state = 64,
     .chunk = 64,
     .residual = true,
     .match_input = true,
     .pixel_skip = true,
     .pixel_features = 8,
     .pixel_hidden = 32,
     .render = "ours"},
    {.name = "small",
     .modules = "MTMTMTMT",
     .dim = 256,
     .patch = 8,
     .state = 64,
     .chunk = 64,
     .residual = true,
     .match_input = true,
     .pixel_skip = true,
     .pixel_features = 24,
     .pixel_hidden = 96,
     .render = "ours"},
    {.name = "paper-small",
     .modules = "MTMTMTMT",
     .dim = 256,
     .patch = 8,
     .state = 64,
     .chunk = 64,
     .render = "paper"},
    {.name = "paper",
     .modules = "MTMTMTMTMTMTMTMTMTMTMTMT",
     .dim = 1024,
     .patch = 8,
     .state = 64,
     .chunk = 64,
     .render = "paper"},
};

bool ffp_model_preset(FfpModelConfig *config, const char *name) {
    for (size_t i = 0; i < sizeof presets / sizeof *presets; i++)
        if (strcmp(presets[i].name, name) == 0) {
            *config = presets[i];
            return true;
        }
    return false;
}

static bool refuse(FfpError *err, const char *where, const char *field, const char *what) {
    char place[1200];
    snprintf(place, sizeof place, "%s%smodel.%s", where ? where : "", where ? ": " : "", field);
    return ffp_fail(err, place, "%s", what);
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
    if (!check_range(config->dim, 64, 4096, 64, "dim", where, err) ||
        !check_range(config->patch, 1, 32, 1, "patch", where, err) ||
        !check_range(config->state, 1, 512, 1, "state", where, err) ||
        !check_range(config->chunk, 1, 1024, 1, "chunk", where, err))
        return false;
    const int least = config->pixel_skip ? 1 : 0; // without the pixel MLP its widths mean nothing
    return check_range(config->pixel_features, least, 256, 1, "pixel_features", where, err) &&
           check_range(config->pixel_hidden, least, 1024, 1, "pixel_hidden", where, err);
}
