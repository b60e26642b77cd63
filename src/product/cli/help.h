// Code shared by help and man pages.
#ifndef FFP_CLI_HELP_H
#define FFP_CLI_HELP_H

#include "options.h"

// "-c, --capture CAPTURE", or four spaces in place of the letter; returns the length.
int ffp_cli_option_label(const FfpOption *option, char *text, size_t size);
// The i-th word after the command's name in its usage line; false after the last.
bool ffp_cli_usage_word(const FfpCommand *command, int i, char *text, size_t size);

// A line of prose.
typedef struct FfpProse {
    enum { FFP_PROSE_PARAGRAPH, FFP_PROSE_ITEM, FFP_PROSE_DEFINITION } kind;
    const char *term, *text; // not ended by zeros; a term is a definition's
    int term_length, length;
} FfpProse;
FfpProse ffp_cli_prose(const char **at); // the line at *at, which goes on to the next

#endif
