// A command's outputs, compared with its inputs before it writes.
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include "cli.h"

// The values of an option or of the positional arguments: texts of argv.
typedef struct Values {
    const char *const *texts;
    int count;
} Values;

static Values values_at(const void *arguments, size_t offset, bool list) {
    const void *place = (const char *)arguments + offset;
    if (list) return (Values){((const FfpList *)place)->values, ((const FfpList *)place)->count};
    return (Values){place, *(const char *const *)place != NULL};
}

static bool holds_paths(const FfpOption *option) {
    return option->type == FFP_OPTION_FILE || option->type == FFP_OPTION_FOLDER;
}

static bool same_file(const char *a, const char *b) {
    struct stat x, y;
    if (strcmp(a, b) == 0) return true;
    return stat(a, &x) == 0 && stat(b, &y) == 0 && S_ISREG(x.st_mode) && x.st_dev == y.st_dev &&
           x.st_ino == y.st_ino;
}

static const char *extension_of(const char *path) {
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
    return dot ? dot : "";
}

static bool among(Values values, const char *path) {
    for (int i = 0; i < values.count; i++)
        if (same_file(values.texts[i], path)) return true;
    return false;
}

static int check_output(const FfpCommand *command, const void *arguments, const FfpOption *output,
                        const char *path) {
    const FfpPositional *inputs = &command->positional;
    const char *wanted = extension_of(output->argument), *found = extension_of(path);
    if (*wanted && *found && strcasecmp(wanted, found) != 0)
        return ffp_cli_usage(command->name, "--%s writes a %s file, not '%s'", output->name, wanted, path);
    if (inputs->name && among(values_at(arguments, inputs->offset, inputs->most > 1), path))
        return ffp_cli_usage(command->name, "--%s would overwrite the input '%s'", output->name, path);
    for (const FfpOption *other = command->options; other->name; other++) {
        if (other == output || !holds_paths(other)) continue;
        if (!among(values_at(arguments, other->offset, other->repeated), path)) continue;
        if (other->writes)
            return ffp_cli_usage(command->name, "--%s and --%s are the same file '%s'", output->name,
                                 other->name, path);
        return ffp_cli_usage(command->name, "--%s would overwrite the input '%s' (--%s)", output->name, path,
                             other->name);
    }
    return -1;
}

// A new folder that is called as one picture would be: what was meant is a file.
static int check_folder(const FfpCommand *command, const FfpOption *option, const char *path) {
    static const char *const endings[] = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr", ".webp"};
    struct stat there;
    if (stat(path, &there) == 0) return -1;
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++)
        if (strcasecmp(extension_of(path), endings[i]) == 0)
            return ffp_cli_usage(command->name, "--%s is a folder for all pictures, not one picture: '%.*s'?",
                                 option->name, (int)(strlen(path) - strlen(endings[i])), path);
    return -1;
}

int ffp_cli_check_outputs(const FfpCommand *command, const void *arguments) {
    for (const FfpOption *option = command->options; option->name; option++) {
        const Values values =
            option->writes ? values_at(arguments, option->offset, option->repeated) : (Values){0};
        if (option->type == FFP_OPTION_FOLDER && strcmp(option->name, "output") == 0) {
            const Values folder = values_at(arguments, option->offset, false);
            const int status = folder.count ? check_folder(command, option, folder.texts[0]) : -1;
            if (status >= 0) return status;
        }
        for (int i = 0; i < values.count; i++) {
            const int status = check_output(command, arguments, option, values.texts[i]);
            if (status >= 0) return status;
        }
    }
    return -1;
}
