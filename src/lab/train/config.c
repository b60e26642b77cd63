// The training configuration: one table of fields serves reading, checking and writing.
#include <jansson.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/call.h"
#include "core/base/file.h"
#include "lab/train/train.h"

typedef enum Kind { INT, INT64, DOUBLE, BOOL, TEXT } Kind;
typedef struct Field {
    const char *name;
    Kind kind;
    size_t offset;
    double low, high; // TEXT: high is the size of the char array
    const char *help; // its row in docs/reference/training.md
} Field;

#define AT(field) offsetof(FfpTrainConfig, field)
#define MODEL_AT(field) offsetof(FfpModelConfig, field)

static const Field train_fields[] = {
    {"seed", INT64, AT(seed), 0, 9e15, "seed of all random numbers"},
    {"steps", INT64, AT(steps), 1, 1e9, "updates of the weights"},
    {"batch", INT, AT(batch), 1, 65536,
     "scenes whose gradients are averaged in a step, by all ranks together"},
    {"pool", INT, AT(pool), 1, 65536, "scenes alive at a time, visited in turn"},
    {"reuse", INT, AT(reuse), 1, 1000000, "uses of each scene"},
    {"views", INT, AT(views), 1, FFP_TRAIN_VIEWS_MAX, "input views of a scene"},
    {"targets", INT, AT(targets), 0, FFP_TRAIN_VIEWS_MAX, "new poses of a scene"},
    {"lollipops", INT, AT(lollipops), 1, 16, "patterns besides black and white"},
    {"resolution", INT, AT(resolution), 8, 1024, "image side, pixels; a multiple of the model's patch"},
    {"pattern_side", INT, AT(pattern_side), 64, 4096, "side of generated patterns, pixels"},
    {"samples", INT, AT(samples), 1, 1024, "rays per pixel of the generator"},
    {"ambient_rays", INT, AT(ambient_rays), 1, 256, "rays per sample for ambient light"},
    {"sensor_share", DOUBLE, AT(sensor_share), 0, 1,
     "share of the scenes seen through a sensor model of random strength: noise, defocus, wrong poses"},
    {"material_share", DOUBLE, AT(material_share), 0, 1,
     "share of the scenes with a material of the folder `materials`"},
    {"materials", TEXT, AT(materials), 0, sizeof(((FfpTrainConfig *)0)->materials),
     "folder of pictures, as of `generate --materials`"},
    {"pattern_share", DOUBLE, AT(pattern_share), 0, 1,
     "share of the scenes whose lollipops, all but the first, are pictures of the folder `patterns`"},
    {"patterns", TEXT, AT(patterns), 0, sizeof(((FfpTrainConfig *)0)->patterns),
     "folder of pictures, as of `generate --patterns`"},
    {"room_share", DOUBLE, AT(room_share), 0, 1,
     "share of the scenes that are captures of the folder `rooms`"},
    {"rooms", TEXT, AT(rooms), 0, sizeof(((FfpTrainConfig *)0)->rooms),
     "folder made by `script/training-rooms`"},
    {"views_least", INT, AT(views_least), 0, FFP_TRAIN_VIEWS_MAX,
     "a scene has between this number and `views` input views; 0: all have `views`"},
    {"free_share", DOUBLE, AT(free_share), 0, 1, "share of the scenes with a free rig"},
    {"large_share", DOUBLE, AT(large_share), 0, 1, "share of the scenes made at `large_resolution`"},
    {"large_resolution", INT, AT(large_resolution), 8, 1024, "image side of these, pixels"},
    {"captures", TEXT, AT(captures), 0, sizeof(((FfpTrainConfig *)0)->captures),
     "folder of captures to learn from instead; `train --captures` sets it, and other defaults"},
    {"patience", INT, AT(patience), 0, 1e9,
     "with `captures`: steps without a gain on held-out photographs after which the run ends; 0: none"},
    {"scenes", TEXT, AT(scenes), 0, sizeof(((FfpTrainConfig *)0)->scenes),
     "folder made by `generate`, from which scenes are taken instead"},
    {"generators", INT, AT(generators), 0, 64,
     "threads that make scenes in advance; 0: the training thread makes them. The result is the same"},
    {"queue", INT, AT(queue), 1, 1024, "scenes made in advance"},
    {"supervised_inputs", INT, AT(supervised_inputs), 0, FFP_TRAIN_VIEWS_MAX,
     "input views rendered per step, drawn at random"},
    {"supervised_targets", INT, AT(supervised_targets), 0, FFP_TRAIN_VIEWS_MAX,
     "new poses rendered per step, drawn at random"},
    {"polish_share", DOUBLE, AT(polish_share), 0, 1,
     "share of the steps whose loss is taken after a fit to the input views"},
    {"polish_steps", INT, AT(polish_steps), 1, 100000, "steps of that fit"},
    {"l1", DOUBLE, AT(l1), 0, 1e4, "weight: absolute difference of pictures"},
    {"ssim", DOUBLE, AT(ssim), 0, 1e4, "weight: 1 - SSIM of pictures"},
    {"perceptual", DOUBLE, AT(perceptual), 0, 1e4, "weight: perceptual difference of pictures"},
    {"mask", DOUBLE, AT(mask), 0, 1e4, "weight: coverage"},
    {"depth", DOUBLE, AT(depth), 0, 1e4, "weight: rendered depth against the truth"},
    {"distortion", DOUBLE, AT(distortion), 0, 1e4, "weight: spread of the splats along a ray"},
    {"normal_smooth", DOUBLE, AT(normal_smooth), 0, 1e4, "weight: differences between neighbouring normals"},
    {"roughness_smooth", DOUBLE, AT(roughness_smooth), 0, 1e4,
     "weight: differences between neighbouring roughnesses"},
    {"direct_t", DOUBLE, AT(direct_t), 0, 1e4,
     "weight: predicted against true distance along the rays, object radii"},
    {"truth_albedo", DOUBLE, AT(truth_albedo), 0, 1e4, "weight: albedo against the generator's"},
    {"truth_normal", DOUBLE, AT(truth_normal), 0, 1e4, "weight: normals against the generator's"},
    {"truth_roughness", DOUBLE, AT(truth_roughness), 0, 1e4, "weight: roughness against the generator's"},
    {"perceptual_from", INT, AT(perceptual_from), 0, 1e9, "step from which the perceptual term counts"},
    {"white_from", INT, AT(white_from), 0, 1e9, "step from which pictures under white are supervised"},
    {"active_from", INT, AT(active_from), 0, 1e9, "step from which pictures under lollipops are supervised"},
    {"learning_rate", DOUBLE, AT(learning_rate), 0, 1, "of AdamW, after the warm-up"},
    {"final_learning_rate", DOUBLE, AT(final_learning_rate), 0, 1, "at the end of the cosine"},
    {"beta1", DOUBLE, AT(beta1), 0, 0.99999, "of AdamW"},
    {"beta2", DOUBLE, AT(beta2), 0, 0.99999, "of AdamW"},
    {"weight_decay", DOUBLE, AT(weight_decay), 0, 10, "of AdamW"},
    {"clip", DOUBLE, AT(clip), 1e-6, 1e6, "largest norm of the gradient"},
    {"skip_above", DOUBLE, AT(skip_above), 1, 1e9,
     "a step with a norm above this multiple of `clip` is skipped"},
    {"ema", DOUBLE, AT(ema), 0, 0.999999, "decay of the weights' average"},
    {"warmup_steps", INT, AT(warmup_steps), 0, 1e9, "steps of the linear warm-up"},
    {"looks_only", BOOL, AT(looks_only), 0, 1,
     "only the layers of the model's looks learn; all other weights stay as they are"},
    {"recompute", BOOL, AT(recompute), 0, 1,
     "keep only the inputs of the blocks and run them again in the backward pass: less memory, same bits"},
    {"validate_every", INT, AT(validate_every), 0, 1e9, "steps between validations; 0: none"},
    {"validation_scenes", INT, AT(validation_scenes), 1, 1000, "scenes of a validation"},
    {"checkpoint_minutes", INT, AT(checkpoint_minutes), 1, 10000, "minutes between checkpoints"},
    {"checkpoint_steps", INT, AT(checkpoint_steps), 0, 1e9, "steps between checkpoints; 0: by time only"},
    {"log_every", INT, AT(log_every), 1, 1e6, "steps between lines of `metrics.jsonl`"},
};

// Ranges of the model's fields are checked by the network room; here only that they fit their type.
static const Field model_fields[] = {
    {"name", TEXT, MODEL_AT(name), 0, sizeof(((FfpModelConfig *)0)->name), "kept in the weights' file"},
    {"modules", TEXT, MODEL_AT(modules), 0, sizeof(((FfpModelConfig *)0)->modules),
     "a letter for each block: M is Mamba2, T a Transformer"},
    {"dim", INT, MODEL_AT(dim), 1, 1e5, "width of the tokens"},
    {"patch", INT, MODEL_AT(patch), 1, 1e3, "side of a token, pixels"},
    {"state", INT, MODEL_AT(state), 1, 1e4, "state of a Mamba2 block"},
    {"chunk", INT, MODEL_AT(chunk), 1, 1e4, "tokens that Mamba2 processes together"},
    {"residual", BOOL, MODEL_AT(residual), 0, 1,
     "heads are residuals around the classical initialisation; otherwise the paper's heads"},
    {"match_input", BOOL, MODEL_AT(match_input), 0, 1, "the classical initialisation's maps are inputs"},
    {"pixel_skip", BOOL, MODEL_AT(pixel_skip), 0, 1,
     "a small MLP per pixel combines its token's features with the pixel's own inputs"},
    {"pixel_features", INT, MODEL_AT(pixel_features), 0, 1e4, "features that this MLP takes from the token"},
    {"pixel_hidden", INT, MODEL_AT(pixel_hidden), 0, 1e4, "its hidden units"},
    {"context_inputs", BOOL, MODEL_AT(context_inputs), 0, 1,
     "more inputs of this MLP where the context has fewer pixels than the picture"},
    {"appearance_cnn", BOOL, MODEL_AT(appearance_cnn), 0, 1,
     "two 3 x 3 convolutions over the tokens before albedo, roughness and ambient colour"},
    {"looks", INT, MODEL_AT(looks), 0, 1e2,
     "rounds in which the input views are drawn and each pixel's splat is corrected by what is wrong there; "
     "0 to 4"},
    {"look_hidden", INT, MODEL_AT(look_hidden), 0, 1e4, "hidden units of the MLP that corrects"},
    {"tokens", INT, MODEL_AT(tokens), 1, 1e6,
     "the most for up to 16 views, in proportion for more; larger captures are reduced"},
    {"render", TEXT, MODEL_AT(render), 0, sizeof(((FfpModelConfig *)0)->render),
     "how the Gaussians are drawn: `ours` or `paper`"},
    {"samples", INT, MODEL_AT(samples), 1, 1e2, "samples per side of a pixel when drawing, 1 to 4"},
};

#define COUNT(table) ((int)(sizeof(table) / sizeof((table)[0])))

FfpTrainConfig ffp_train_defaults(void) {
    FfpTrainConfig c = {
        .seed = 1,
        .steps = 20000,
        .batch = 1,
        .pool = 8,
        .reuse = 12,
        .views = 8,
        .targets = 4,
        .lollipops = 4,
        .resolution = 128,
        .pattern_side = 800,
        .samples = 4,
        .ambient_rays = 2,
        .sensor_share = 0,
        .material_share = 0,
        .pattern_share = 0,
        .room_share = 0,
        .views_least = 0,
        .free_share = 0,
        .large_share = 0,
        .large_resolution = 256,
        .generators = 0,
        .queue = 2,
        .supervised_inputs = 2,
        .supervised_targets = 2,
        .polish_share = 0,
        .polish_steps = 24,
        .l1 = 0.8,
        .ssim = 0.2,
        .perceptual = 0.05,
        .mask = 0.1,
        .depth = 0.1,
        .distortion = 0.05,
        .normal_smooth = 0.01,
        .roughness_smooth = 0.002,
        .direct_t = 0.5,
        .truth_albedo = 0,
        .truth_normal = 0,
        .truth_roughness = 0,
        .perceptual_from = 5000,
        .learning_rate = 4e-4,
        .final_learning_rate = 1e-6,
        .beta1 = 0.9,
        .beta2 = 0.95,
        .weight_decay = 0.05,
        .clip = 1,
        .skip_above = 10,
        .ema = 0.999,
        .warmup_steps = 500,
        .validate_every = 1000,
        .validation_scenes = 6,
        .checkpoint_minutes = 5,
        .log_every = 20,
    };
    ffp_model_preset(&c.model, "small");
    return c;
}

FfpTrainConfig ffp_fine_tuning_defaults(void) {
    FfpTrainConfig c = ffp_train_defaults();
    c.steps = 300;
    c.warmup_steps = 20;
    c.learning_rate = 1e-4;
    c.weight_decay = 0;
    c.ema = 0.98;
    c.pool = 4;
    c.reuse = 4;
    c.supervised_inputs = 1;
    c.supervised_targets = 2;
    c.polish_share = 0.4;
    c.depth = 0;
    c.direct_t = 0;
    c.perceptual = 0;
    c.validate_every = 50;
    c.patience = 150;
    return c;
}

static bool read_number(double *out, const json_t *value, const Field *field, const char *where,
                        FfpError *err) {
    const bool whole = field->kind != DOUBLE;
    if (whole ? !json_is_integer(value) : !json_is_number(value))
        return ffp_fail(err, FFP_ERROR_FILE, where, "expected %s", whole ? "a whole number" : "a number");
    *out = json_number_value(value);
    if (!isfinite(*out) || *out < field->low || *out > field->high)
        return ffp_fail(err, FFP_ERROR_FILE, where, "%g is not in [%g, %g]", *out, field->low, field->high);
    return true;
}

static bool read_field(void *base, const Field *field, const json_t *value, const char *where,
                       FfpError *err) {
    char *at = (char *)base + field->offset;
    double number = 0;
    switch (field->kind) {
    case BOOL:
        if (!json_is_boolean(value)) return ffp_fail(err, FFP_ERROR_FILE, where, "expected true or false");
        *(bool *)at = json_is_true(value);
        return true;
    case TEXT:
        if (!json_is_string(value)) return ffp_fail(err, FFP_ERROR_FILE, where, "expected a string");
        if (json_string_length(value) >= (size_t)field->high)
            return ffp_fail(err, FFP_ERROR_FILE, where, "text is too long");
        snprintf(at, (size_t)field->high, "%s", json_string_value(value));
        return true;
    case INT:
        if (!read_number(&number, value, field, where, err)) return false;
        *(int *)at = (int)number;
        return true;
    case INT64:
        if (!read_number(&number, value, field, where, err)) return false;
        *(int64_t *)at = (int64_t)number;
        return true;
    case DOUBLE:
        return read_number((double *)at, value, field, where, err);
    }
    return false;
}

// Fields of former versions are read where they say what is always so now: checkpoints of then hold them all.
static bool is_former(const char *key, const json_t *value) {
    if (strcmp(key, "low_resolution") == 0) return true;
    if (strcmp(key, "single_scene") == 0) return json_is_false(value);
    return (strcmp(key, "low_steps") == 0 || strcmp(key, "warmup_geometry") == 0) && json_is_integer(value) &&
           json_integer_value(value) == 0;
}

static bool read_fields(void *base, const Field *fields, int count, const json_t *object, const char *prefix,
                        const char *skip, const char *where, FfpError *err) {
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)object, key, value) {
        if (strcmp(key, skip) == 0) continue;
        char name[128];
        snprintf(name, sizeof name, "%s%.64s", prefix, key);
        const FfpPlace place = ffp_place(where, name);
        const Field *found = NULL;
        for (int i = 0; i < count && !found; i++)
            if (strcmp(fields[i].name, key) == 0) found = &fields[i];
        if (!found && is_former(key, value)) continue;
        if (!found) return ffp_fail(err, FFP_ERROR_FILE, place.text, "unknown field");
        if (!read_field(base, found, value, place.text, err)) return false;
    }
    return true;
}

static bool read_model(FfpModelConfig *model, const json_t *value, const char *where, FfpError *err) {
    const FfpPlace place = ffp_place(where, "model");
    const json_t *preset = json_is_object(value) ? json_object_get(value, "preset") : value;
    if (preset) {
        if (!json_is_string(preset))
            return ffp_fail(err, FFP_ERROR_FILE, place.text, "expected a preset's name");
        if (!ffp_model_preset(model, json_string_value(preset)))
            return ffp_fail(err, FFP_ERROR_FILE, place.text, "no preset '%.40s'", json_string_value(preset));
    }
    if (json_is_object(value) &&
        !read_fields(model, model_fields, COUNT(model_fields), value, "model.", "preset", where, err))
        return false;
    return ffp_model_config_check(model, where, err);
}

// A share of the scenes comes from a folder, or is made with its pictures: both are given, or neither is.
static bool check_stock(const char *where, const char *share_name, double share, const char *folder_name,
                        const char *folder, FfpError *err) {
    return (share > 0) == (folder[0] != 0) ||
           ffp_fail(err, FFP_ERROR_FILE, ffp_place(where, folder_name).text,
                    folder[0] ? "is given, but %s is 0" : "names no folder, but %s is above 0", share_name);
}

// The fields that make scenes differ from each other.
static bool check_mixture(const FfpTrainConfig *c, const char *where, FfpError *err) {
    if (c->views_least > c->views)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(where, "views_least").text, "is above views");
    if (c->large_share > 0 && c->large_resolution % c->model.patch)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(where, "large_resolution").text,
                        "must be a multiple of the patch, %d", c->model.patch);
    if (!check_stock(where, "material_share", c->material_share, "materials", c->materials, err) ||
        !check_stock(where, "pattern_share", c->pattern_share, "patterns", c->patterns, err) ||
        !check_stock(where, "room_share", c->room_share, "rooms", c->rooms, err))
        return false;
    if (c->pattern_share > 0 && c->lollipops < 2)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(where, "pattern_share").text,
                        "pictures take the place of all lollipops but the first, and there is no other");
    const char *mixed = c->views_least > 0      ? "views_least"
                        : c->free_share > 0     ? "free_share"
                        : c->large_share > 0    ? "large_share"
                        : c->sensor_share > 0   ? "sensor_share"
                        : c->material_share > 0 ? "material_share"
                        : c->pattern_share > 0  ? "pattern_share"
                        : c->room_share > 0     ? "room_share"
                                                : NULL;
    if (mixed && (c->scenes[0] || c->captures[0]))
        return ffp_fail(
            err, FFP_ERROR_FILE, ffp_place(where, mixed).text,
            "applies to scenes generated in training, not to those of a folder (scenes, captures)");
    return true;
}

// Checks the requirements of learning from captures.
static bool check_with_captures(const FfpTrainConfig *c, const char *where, FfpError *err) {
    if (c->validate_every == 0)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(where, "validate_every").text,
                        "is 0, but with captures weights are kept only when they are scored");
    if (c->patience > 0 && c->patience < c->validate_every)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(where, "patience").text,
                        "is below validate_every, %d: no gain can be seen in so few steps",
                        c->validate_every);
    return true;
}

// Conditions on several fields together.
static bool check_together(const FfpTrainConfig *c, const char *where, FfpError *err) {
    if (c->supervised_inputs + c->supervised_targets < 1)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(where, "supervised_inputs").text,
                        "supervised_inputs and supervised_targets are both 0");
    if (c->supervised_inputs > c->views)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(where, "supervised_inputs").text, "is above views");
    if (c->supervised_targets > c->targets)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(where, "supervised_targets").text, "is above targets");
    if (c->resolution % c->model.patch)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(where, "resolution").text,
                        "must be a multiple of the patch, %d", c->model.patch);
    if (c->captures[0] && c->scenes[0])
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(where, "captures").text,
                        "captures and scenes cannot be combined");
    if (c->looks_only && (c->model.looks == 0 || c->polish_share > 0))
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(where, "looks_only").text,
                        c->model.looks == 0 ? "the model has no looks"
                                            : "a fit begins before the looks: polish_share must be 0");
    return (!c->captures[0] || check_with_captures(c, where, err)) && check_mixture(c, where, err);
}

static bool parse_over(FfpTrainConfig *config, const char *text, const char *where, FfpError *err) {
    json_error_t problem;
    json_t *root = json_loads(text, JSON_REJECT_DUPLICATES, &problem);
    if (!root)
        return ffp_fail(err, FFP_ERROR_FILE, where, "broken JSON at line %d: %s", problem.line, problem.text);
    bool ok = json_is_object(root) || ffp_fail(err, FFP_ERROR_FILE, where, "expected an object");
    const json_t *model = ok ? json_object_get(root, "model") : NULL;
    ok = ok && (!model || read_model(&config->model, model, where, err)) &&
         read_fields(config, train_fields, COUNT(train_fields), root, "", "model", where, err) &&
         check_together(config, where, err);
    json_decref(root);
    return ok;
}

bool ffp_train_config_parse(FfpTrainConfig *config, const char *text, const char *where, FfpError *err) {
    *config = ffp_train_defaults();
    return parse_over(config, text, where, err);
}

bool ffp_train_config_overlay(FfpTrainConfig *config, const char *path, FfpError *err) {
    char *text = NULL;
    size_t size = 0;
    if (!ffp_read_text(path, 1 << 20, &text, &size, err)) return false;
    const bool ok = strlen(text) == size
                        ? parse_over(config, text, path, err)
                        : ffp_fail(err, FFP_ERROR_FILE, path, "broken JSON: a zero byte in the text");
    ffp_free(text);
    return ok;
}

static json_t *value_of(const void *base, const Field *field) {
    const char *at = (const char *)base + field->offset;
    switch (field->kind) {
    case BOOL:
        return json_boolean(*(const bool *)at);
    case TEXT:
        return json_string(at);
    case INT:
        return json_integer(*(const int *)at);
    case INT64:
        return json_integer(*(const int64_t *)at);
    case DOUBLE:
        return json_real(*(const double *)at);
    }
    return NULL;
}

static bool print_fields(json_t *object, const void *base, const Field *fields, int count, FfpError *err) {
    for (int i = 0; i < count; i++)
        if (json_object_set_new(object, fields[i].name, value_of(base, &fields[i])) != 0)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, fields[i].name,
                            fields[i].kind == TEXT ? "is not UTF-8, the encoding of the configuration"
                                                   : "cannot be written as a JSON number");
    return true;
}

// A field's value as JSON, with as few digits as it was given.
static void write_value(FILE *out, const void *base, const Field *field) {
    json_t *value = value_of(base, field);
    char *text = json_dumps(value, JSON_ENCODE_ANY | JSON_REAL_PRECISION(6));
    fprintf(out, "`%s`", text ? text : "");
    free(text);
    json_decref(value);
}

void ffp_train_write_fields(FILE *out) {
    const FfpTrainConfig plain = ffp_train_defaults(), fine = ffp_fine_tuning_defaults();
    fputs("| field | default | with `--captures` | range | meaning |\n|---|---|---|---|---|\n", out);
    for (int i = 0; i < COUNT(train_fields); i++) {
        const Field *field = &train_fields[i];
        fprintf(out, "| `%s` | ", field->name);
        write_value(out, &plain, field);
        json_t *one = value_of(&plain, field), *other = value_of(&fine, field);
        fputs(" | ", out);
        if (!json_equal(one, other)) write_value(out, &fine, field);
        json_decref(one);
        json_decref(other);
        if (field->kind == TEXT || field->kind == BOOL)
            fprintf(out, " | %s | %s |\n", field->kind == TEXT ? "text" : "bool", field->help);
        else
            fprintf(out, " | %g to %g | %s |\n", field->low, field->high, field->help);
    }
    fputs("\n| field of `model` | of the preset `small` | meaning |\n|---|---|---|\n", out);
    for (int i = 0; i < COUNT(model_fields); i++) {
        fprintf(out, "| `%s` | ", model_fields[i].name);
        write_value(out, &plain.model, &model_fields[i]);
        fprintf(out, " | %s |\n", model_fields[i].help);
    }
}

char *ffp_train_config_print(const FfpTrainConfig *config, FfpError *err) {
    json_t *root = json_object(), *model = json_object();
    const bool ok = print_fields(root, config, train_fields, COUNT(train_fields), err) &&
                    print_fields(model, &config->model, model_fields, COUNT(model_fields), err);
    json_object_set_new(root, "model", model);
    char *text = ok ? json_dumps(root, JSON_INDENT(1) | JSON_PRESERVE_ORDER) : NULL;
    json_decref(root);
    if (ok && !text) ffp_fail(err, FFP_ERROR_MEMORY, NULL, "out of memory");
    if (!text) return NULL;
    ffp_own(text, free);
    char *copy = ffp_copy_text(text);
    ffp_disown(text);
    free(text);
    return copy;
}
