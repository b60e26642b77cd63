// What went wrong, as a value. Every function of the library that can fail returns false or NULL and fills
// the FfpError that it was given.
#ifndef FFPROCAMS_ERROR_H
#define FFPROCAMS_ERROR_H

#ifdef __cplusplus
extern "C" {
#endif

typedef enum FfpErrorCode {
    FFP_OK,
    FFP_ERROR_ARGUMENT,    // the caller's: a value out of range, a name that does not exist, a missing option
    FFP_ERROR_FILE,        // a file from outside holds what it must not, or lacks what it must have
    FFP_ERROR_UNSUPPORTED, // sound, but not what this library, build or machine can do
    FFP_ERROR_MEMORY,      // there is not enough
    FFP_ERROR_CANCELLED,   // the progress callback said so
    FFP_ERROR_IO,          // the system could not open, read, write or rename
} FfpErrorCode;

typedef struct FfpError {
    char text[768]; // "WHAT (WHERE)", WHERE being a file, "FILE: FIELD", or empty; "" when nothing failed
    FfpErrorCode code;
} FfpError;

#ifdef __cplusplus
}
#endif

#endif
