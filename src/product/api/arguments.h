// What a caller in C may leave out or get wrong though the type says otherwise; asked first by every public
// call. Errors are FFP_ERROR_ARGUMENT and name the argument or the option.
#ifndef FFP_API_ARGUMENTS_H
#define FFP_API_ARGUMENTS_H

#include "ffprocams.h"

// A handle, a struct, a text: not NULL.
bool ffp_need(const void *thing, const char *name, FfpError *err);
// n texts, none of them NULL; n 0: the list is not looked at.
bool ffp_need_texts(const char *const *texts, int n, const char *name, FfpError *err);
// A form that there is, and samples that a pixel can have.
bool ffp_check_drawing(FfpDrawing drawing, FfpError *err);

#endif
