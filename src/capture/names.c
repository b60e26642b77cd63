// What a capture has, for errors about what it has not.
#include <stdio.h>
#include <string.h>
#include "capture/capture.h"

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
