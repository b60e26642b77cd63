// The folders of photographs that `ffprocams scan` is given, as the one name of files that import takes.
#ifndef FFP_CLI_SCAN_NAMES_H
#define FFP_CLI_SCAN_NAMES_H

#include "cli.h"

// Visible entries of a folder, all or regular files alone; -1: it cannot be read.
int ffp_cli_count_entries(const char *folder, bool files);
// Of one folder of photographs, of folders in one, or of a folder of folders: FILES of `import --images` with
// {view}, or `by_angle` with * for stops in natural order. The photographs of codes may be `apart`, in
// folders beside the others. An exit code.
int ffp_cli_name_photographs(const FfpList *folders, bool by_angle, bool apart, char *images, size_t size);

#endif
