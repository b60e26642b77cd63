// Descriptions of files in readable text.
#ifndef FFP_DESCRIBE_DESCRIBE_H
#define FFP_DESCRIBE_DESCRIBE_H

#include <stdio.h>
#include "core/base/error.h"
#include "rig/findings/tell.h"

// A capture, weights, Gaussians or a neural field, distinguished by their first bytes. The checks of a
// capture are added to `found`, too.
bool ffp_describe(FILE *out, const char *path, FfpFindings *found, FfpError *err);
bool ffp_describe_capture(FILE *out, const char *path, FfpFindings *found, FfpError *err);
// An HTML page of a capture: the same text; the contact sheet, if import left one in the folder;
// every view as it is reconstructed, the doubtful ones marked; and in colours which pixels' depth no pattern
// tells.
bool ffp_describe_report(const char *path, const char *html, FfpError *err);

#endif
