// A page's threads have the stacks that the module was linked with.
#include "product/cli/cli.h"

int ffp_cli_on_large_stack(int (*function)(void *argument), void *argument) {
    return function(argument);
}
