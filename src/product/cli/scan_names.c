#define _GNU_SOURCE // strverscmp
#include "scan_names.h"
#include <dirent.h>
#include <errno.h>
#include <glob.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#define SPECIAL "*?[{=\\" // to import

int ffp_cli_count_entries(const char *folder, bool files) {
    DIR *directory = opendir(folder);
    char path[2 * FFP_CLI_PATH];
    struct stat status;
    int count = 0;
    if (!directory) return -1;
    for (const struct dirent *entry; (entry = readdir(directory));) {
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        const bool regular = stat(path, &status) == 0 && S_ISREG(status.st_mode);
        count += entry->d_name[0] != '.' && (regular || !files);
    }
    closedir(directory);
    return count;
}

static int check_folder(const char *folder) {
    FfpError err = {.code = FFP_ERROR_IO};
    if (strpbrk(folder, SPECIAL))
        return ffp_cli_usage("scan", "%s: rename the folder: *, ?, [, {, = and \\ have a meaning for import",
                             folder);
    if (ffp_cli_count_entries(folder, false) >= 0) return FFP_EXIT_OK;
    snprintf(err.text, sizeof err.text, "cannot open: %s (%.600s)", strerror(errno), folder);
    return ffp_cli_fail(&err);
}

// How much all folders begin with or, `back`, end with behind the `begin` that they begin with.
static int common(const FfpList *folders, int begin, bool back) {
    const char *first = folders->values[0];
    for (int n = 0, length = (int)strlen(first);; n++)
        for (int i = 0; i < folders->count; i++) {
            const char *other = folders->values[i];
            const int others = (int)strlen(other);
            if (begin + n >= length || begin + n >= others ||
                (back ? first[length - 1 - n] != other[others - 1 - n] : first[n] != other[n]))
                return n;
        }
}

// Folders that are named after their views, or folders of one name in these: shots/1/gray, shots/2/gray.
static int name_by_view(const FfpList *folders, char *views, size_t size) {
    const char *first = folders->values[0];
    int begin = common(folders, 0, false);
    while (begin > 0 && first[begin - 1] != '/') begin--;
    const char *inner = strchr(first + strlen(first) - common(folders, begin, true), '/');
    int length = inner ? (int)strlen(inner) : 0;
    const int after = length;
    while (length > 0 && inner[length - 1] == '/') length--;
    for (int i = 0; i < folders->count; i++) {
        const char *name = folders->values[i] + begin, *slash = strchr(name, '/');
        if (slash && slash[strspn(slash, "/")] && (int)strlen(slash) != after)
            return ffp_cli_usage("scan", "%s and %s: the folders of photographs must be in one folder", first,
                                 folders->values[folders->count - 1]);
    }
    snprintf(views, size, "%.*s{view}%.*s", begin, first, length, inner ? inner : "");
    return FFP_EXIT_OK;
}

// As a shell orders them, by their bytes, or naturally: import takes both in natural order.
static bool ascend(const FfpList *folders) {
    bool by_bytes = true, naturally = true;
    for (int i = 1; i < folders->count; i++) {
        by_bytes = by_bytes && strcmp(folders->values[i - 1], folders->values[i]) < 0;
        naturally = naturally && strverscmp(folders->values[i - 1], folders->values[i]) < 0;
    }
    return by_bytes || naturally;
}

static int name_stops(const FfpList *folders, char *views, size_t size) {
    const char *first = folders->values[0];
    const int begin = common(folders, 0, false), end = common(folders, begin, true);
    glob_t found = {0};
    if (!ascend(folders))
        return ffp_cli_usage("scan",
                             "%s and others: the folders are not in natural order: with --calibration or "
                             "--attitudes, angles are given in natural order",
                             first);
    const int length = snprintf(views, size, "%.*s*%s/", begin, first, first + strlen(first) - end);
    const bool others = glob(views, 0, NULL, &found) != 0 || found.gl_pathc != (size_t)folders->count;
    globfree(&found);
    if (others)
        return ffp_cli_usage("scan",
                             "%s: there are more such folders than the %d given: put these into one folder",
                             views, folders->count);
    if (length > 0 && (size_t)length < size) views[length - 1] = 0;
    return FFP_EXIT_OK;
}

int ffp_cli_name_views(const FfpList *folders, bool by_angle, bool apart, char *views, size_t size) {
    int status = FFP_EXIT_OK;
    for (int i = 0; i < folders->count && status == FFP_EXIT_OK; i++)
        status = check_folder(folders->values[i]);
    if (status != FFP_EXIT_OK) return status;
    if (folders->count > 1) return (by_angle ? name_stops : name_by_view)(folders, views, size);
    const char *part = by_angle ? "/*" : "/{view}";
    const int files = ffp_cli_count_entries(folders->values[0], true);
    if (files == ffp_cli_count_entries(folders->values[0], false) || (apart && files > 0))
        part = ""; // one view
    snprintf(views, size, "%s%s", folders->values[0], part);
    return FFP_EXIT_OK;
}

static int count_ending(const char *folder, const char *ending) {
    DIR *directory = opendir(folder);
    int count = 0;
    for (const struct dirent *entry; directory && (entry = readdir(directory));) {
        const char *own = strrchr(entry->d_name, '.');
        count += entry->d_name[0] != '.' && own && strcasecmp(own, ending) == 0;
    }
    if (directory) closedir(directory);
    return count;
}

// The folder in a folder: "" if it holds none, or several.
static void find_folder(const char *folder, char inner[FFP_CLI_NAME]) {
    DIR *directory = opendir(folder);
    char path[2 * FFP_CLI_PATH];
    int count = 0;
    for (const struct dirent *entry; directory && (entry = readdir(directory));) {
        struct stat status;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (entry->d_name[0] == '.' || stat(path, &status) != 0 || !S_ISDIR(status.st_mode)) continue;
        snprintf(inner, FFP_CLI_NAME, "%s", entry->d_name), count++;
    }
    if (directory) closedir(directory);
    if (count != 1 || strpbrk(inner, SPECIAL)) inner[0] = 0;
}

// True if a folder has two pictures, and a single folder more of the same ending; sets `inner` to that one's
// name or, unless it is empty, requires it.
static bool has_codes(const char *folder, char inner[FFP_CLI_NAME]) {
    char path[2 * FFP_CLI_PATH], name[FFP_CLI_NAME] = "";
    bool found = false;
    find_folder(folder, name);
    snprintf(path, sizeof path, "%s/%s", folder, name);
    DIR *directory = name[0] ? opendir(folder) : NULL;
    for (const struct dirent *entry; directory && (entry = readdir(directory));) {
        const char *ending = strrchr(entry->d_name, '.');
        if (entry->d_name[0] == '.' || !ending) continue;
        const int own = count_ending(folder, ending);
        found = own <= 2 && (found || (own == 2 && count_ending(path, ending) > 2));
        if (own > 2) break; // photographs, beside which two others lie
    }
    if (directory) closedir(directory);
    if (!found || (inner[0] && strcmp(inner, name) != 0)) return false;
    snprintf(inner, FFP_CLI_NAME, "%s", name);
    return true;
}

bool ffp_cli_find_codes(const char *const *folders, int n, char inner[FFP_CLI_NAME]) {
    char pattern[FFP_CLI_PATH + 8];
    glob_t inside = {0};
    if (n == 1 && ffp_cli_count_entries(folders[0], true) == 0) {
        snprintf(pattern, sizeof pattern, "%s/*/", folders[0]);
        if (glob(pattern, 0, NULL, &inside) == 0)
            folders = (const char *const *)inside.gl_pathv, n = (int)inside.gl_pathc;
    }
    bool found = n > 0;
    inner[0] = 0;
    for (int i = 0; i < n && found; i++) found = has_codes(folders[i], inner);
    globfree(&inside);
    return found;
}
