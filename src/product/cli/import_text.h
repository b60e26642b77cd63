// The values of `ffprocams import` as numbers and structs, and its options as users know them.
#ifndef FFP_CLI_IMPORT_TEXT_H
#define FFP_CLI_IMPORT_TEXT_H

#include "cli.h"

// The values of the options that may be repeated, owned, including the parts of strings.
typedef struct FfpImportLists {
    FfpImportImages *images, *empty;
    FfpImportPattern *patterns, *held_out;
    FfpAngles angles;
    char **texts; // copies that were cut into parts
    int n_images, n_empty, n_patterns, n_held_out, n_texts;
} FfpImportLists;
void ffp_cli_import_lists_free(FfpImportLists *lists);

// "NAME[,NAME..]=FILES"; with `shown`, files alone are of all patterns that were shown.
bool ffp_cli_add_images(FfpImportLists *lists, const char *text, bool shown, FfpError *err);
// "NAME[,NAME..]=FILES", of the empty stage
bool ffp_cli_add_empty(FfpImportLists *lists, const char *text, FfpError *err);
// "NAME=FILE"
bool ffp_cli_add_pattern(FfpImportLists *lists, const char *text, bool held_out, FfpError *err);

// --turntable: "AX,AY,AZ,PX,PY,PZ,ANGLES" ("ANGLES" alone where the axis is to be found), or a file. ANGLES
// as ffp_cli_angles takes them.
bool ffp_cli_turntable(FfpImportLists *lists, const char *text, FfpImportTurntable *turntable, FfpError *err);
// --fit-axis: "", or a guess "AX,AY,AZ,PX,PY,PZ".
bool ffp_cli_fit_axis(const char *text, FfpImportTurntable *turntable, FfpError *err);

// The option that an error of the library is about, or NULL.
const char *ffp_cli_import_option(const FfpError *err);

#endif
