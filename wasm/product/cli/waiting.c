// A page does not start again.
#include "product/cli/cli.h"

void ffp_cli_wait_passively(char **argv) {
    (void)argv;
}
