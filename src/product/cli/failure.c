// Messages of a command that cannot go on.
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include "cli.h"

int ffp_cli_fail(const FfpError *err) {
    ffp_cli_clear_progress();
    ffp_cli_event_error(err);
    fprintf(stderr, "ffprocams: %serror: %s\n", ffp_cli_rank_name(), err->text);
    return FFP_EXIT_FAILURE;
}

// A comma may be part of a name, so it is not always a mistake.
int ffp_cli_fail_patterns(const FfpError *err, const FfpList *patterns) {
    const int status = ffp_cli_fail(err);
    for (int i = 0; i < patterns->count; i++) {
        const char *name = patterns->values[i];
        const size_t length = strcspn(name, "=");
        if (!memchr(name, ',', length)) continue;
        fprintf(stderr,
                "ffprocams: '%.*s' was taken as the name of one pattern; repeat -p for several: -p A -p B\n",
                (int)length, name);
        break;
    }
    return status;
}

int ffp_cli_usage(const char *command, const char *what_format, ...) {
    va_list arguments;
    fputs("ffprocams: error: ", stderr);
    va_start(arguments, what_format);
    vfprintf(stderr, what_format, arguments);
    va_end(arguments);
    fprintf(stderr, "\nffprocams: see: ffprocams %s%s--help\n", command ? command : "", command ? " " : "");
    return FFP_EXIT_USAGE;
}
