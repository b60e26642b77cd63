// Errors are values. A function that can fail takes an FfpError and returns bool (or NULL).
#ifndef FFP_BASE_ERROR_H
#define FFP_BASE_ERROR_H

#include <stdbool.h>
#include "ffprocams/error.h" // the one public type that all rooms share

#ifdef __cplusplus
extern "C" {
#endif

// Writes the code and "WHAT (WHERE)" into err (which may be NULL) and returns false, so that a caller can
// `return ffp_fail(...)`. `where` may be NULL or empty: then only WHAT is written. Control characters in the
// text are replaced by '?'.
bool ffp_fail(FfpError *err, FfpErrorCode code, const char *where, const char *what_format, ...)
    __attribute__((format(printf, 4, 5)));

// Fails unless `value` is one of an enum's, 0 to `last`: C lets a caller pass any number. `name`: of the
// argument.
bool ffp_check_choice(int value, int last, const char *name, FfpError *err);

// "FILE: FIELD" for an error's WHERE, as ffp_place(file, field).text; very long names are truncated.
typedef struct FfpPlace {
    char text[1200];
} FfpPlace;
FfpPlace ffp_place(const char *file, const char *field);

#ifdef __cplusplus
}
#endif

#endif
