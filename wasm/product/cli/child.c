// In a page, where there are no processes, a command runs inside the one that asks for it.
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include "product/cli/cli.h"

int ffp_cli_child(const FfpList *words) {
    const char *const *given = words->values;
    if (strcmp(given[0], "mkdir") == 0) {
        const bool made = mkdir(given[words->count - 1], 0777) == 0 || errno == EEXIST;
        return made ? FFP_EXIT_OK : FFP_EXIT_FAILURE;
    }
    char **argv = calloc((size_t)words->count, sizeof *argv); // options are parsed in another order
    const FfpCommand *command = ffp_cli_command(given[1]);
    if (!argv || !command) return free(argv), FFP_EXIT_FAILURE;
    for (int i = 1; i < words->count; i++) argv[i - 1] = (char *)given[i];
    const int status = ffp_cli_run(command, words->count - 1, argv);
    free(argv);
    return status;
}

void ffp_cli_end_as_child(void) {}
