#include "cli.h"

const FfpCommand *const ffp_cli_commands[FFP_CLI_COMMANDS_MAX] = {
    &ffp_cli_studio,
    &ffp_cli_scan,
    &ffp_cli_patterns,
    &ffp_cli_calibrate,
    &ffp_cli_import,
    &ffp_cli_align,
    &ffp_cli_info,
    &ffp_cli_reconstruct,
    &ffp_cli_refine,
    &ffp_cli_render,
    &ffp_cli_view,
    &ffp_cli_export,
    &ffp_cli_compensate,
    &ffp_cli_map,
    &ffp_cli_evaluate,
    &ffp_cli_bench,
    &ffp_cli_generate,
    &ffp_cli_train,
    NULL,
};
