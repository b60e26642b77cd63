// Errors as values. Every function of the library that can fail returns false, NULL or, where it counts
// something, -1, and fills the FfpError passed to it. One that takes an FfpContext leaves it empty when it
// succeeds; others do not touch it then, so look at what they return.
#ifndef FFPROCAMS_ERROR_H
#define FFPROCAMS_ERROR_H

#include "ffprocams/api.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum FfpErrorCode {
    FFP_OK,
    FFP_ERROR_ARGUMENT,    // by the caller: a value out of range, an unknown name, a missing option
    FFP_ERROR_FILE,        // an input's content is invalid or missing, or an output folder is not empty
    FFP_ERROR_UNSUPPORTED, // valid, but not supported by this library, build or machine
    FFP_ERROR_MEMORY,      // not enough memory
    FFP_ERROR_CANCELLED,   // by the progress callback
    FFP_ERROR_IO,          // the system failed to open, read, write or rename a file
    FFP_ERROR_FAULT,       // a mistake found in a capture: `force` (FfpReconstruction and others) goes on
} FfpErrorCode;

typedef struct FfpError {
    // "WHAT (WHERE)", where WHERE is a file, "FILE: FIELD", a capture's name or an argument, or just "WHAT";
    // "" on success.
    char text[768];
    FfpErrorCode code;
    const char *finding; // the code of the finding (findings.h) behind it, a constant; NULL: there is none
    char where[768];     // WHERE alone; "": there is none
    FFP_RESERVED;
} FfpError;

#ifdef __cplusplus
}
#endif

#endif
