// The folders of photographs that `ffprocams scan` is given, as the one name of files that import takes.
#ifndef FFP_CLI_SCAN_NAMES_H
#define FFP_CLI_SCAN_NAMES_H

#include "cli.h"

// Visible entries of a folder, all or regular files alone; -1: it cannot be read.
int ffp_cli_count_entries(const char *folder, bool files);
// Of one folder of photographs, of folders in one, or of a folder of folders: the part of FILES of `import
// --images` before the files' names, with {view}, or `by_angle` with * for stops in natural order. The
// photographs of codes may be `apart`, in folders beside the others. An exit code.
int ffp_cli_name_views(const FfpList *folders, bool by_angle, bool apart, char *views, size_t size);
// True if each of these folders, or each folder in the only one, has two pictures, black and white, and a
// single folder, called `inner` in all of them, with more.
bool ffp_cli_find_codes(const char *const *folders, int n, char inner[FFP_CLI_NAME]);

#endif
