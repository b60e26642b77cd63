// Names of views and patterns: listed for errors about what a capture has not, and in those of files.
#include <stdio.h>
#include <string.h>
#include "core/capture/capture.h"

// Room for the last words, "and 512 more".
enum { MORE = 16 };

static void list(char text[FFP_LISTED_MAX], int n, const char *(*name)(const FfpCapture *, int),
                 const FfpCapture *capture) {
    size_t length = 0;
    text[0] = 0;
    for (int i = 0; i < n; i++) {
        const char *next = name(capture, i);
        const char *before = i == 0 ? "" : ", ";
        if (length + strlen(next) + MORE >= FFP_LISTED_MAX) {
            snprintf(text + length, FFP_LISTED_MAX - length, " and %d more", n - i);
            return;
        }
        length += (size_t)snprintf(text + length, FFP_LISTED_MAX - length, "%s%s", before, next);
    }
}

static const char *view_name(const FfpCapture *capture, int i) {
    return capture->views[i].id;
}

static const char *pattern_name(const FfpCapture *capture, int i) {
    return capture->patterns[i].name;
}

FfpListed ffp_list_views(const FfpCapture *capture) {
    FfpListed listed;
    list(listed.text, capture->n_views, view_name, capture);
    return listed;
}

FfpListed ffp_list_patterns(const FfpCapture *capture) {
    FfpListed listed;
    list(listed.text, capture->n_patterns, pattern_name, capture);
    return listed;
}

bool ffp_picture_path(char *out, size_t size, const char *folder, const char *view, const char *rest,
                      FfpError *err) {
    if (!*view || *view == '.' || strchr(view, '/') || strchr(rest, '/'))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "%s_%s is not a valid file name", view, rest);
    if ((size_t)snprintf(out, size, "%s/%s_%s", folder, view, rest) >= size)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "the path of %s_%s is too long", view, rest);
    return true;
}
