// Faults found in photographs, poses and calibrations, as values: the observation, its view, and the remedy.
// docs/guide/troubleshooting.md lists all of them.
#ifndef FFPROCAMS_FINDINGS_H
#define FFPROCAMS_FINDINGS_H

#include "ffprocams/api.h"
#include "ffprocams/error.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum FfpSeverity {
    FFP_FINDING_OK,    // looked at, and as it should be
    FFP_FINDING_NOTE,  // worth knowing
    FFP_FINDING_DOUBT, // makes the result worse, or may not be what the caller intended
    FFP_FINDING_FAULT, // makes the result wrong: calls fail, of a capture with FFP_ERROR_FAULT unless forced
} FfpSeverity;

typedef struct FfpFinding {
    const char *code; // "pattern-mirrored": tells findings apart, and does not change
    FfpSeverity severity;
    const char *view, *other; // ids of the views (or names of the folders) it is about; NULL: of none
    // The measured number, and that from which on it is in doubt, above or below as the text says; NAN: none.
    double figure, limit;
    const char *subject; // what was looked at, in a word or two: "silhouettes"
    const char *text;    // what was seen
    const char *advice;  // what to do; NULL: nothing can be advised
    const char *setting; // option of the call that may help, by its name: "force"; with words for its
                         // value: "fix=camera.k3 projector.p"; or NULL
    FFP_RESERVED;
} FfpFinding;

// A finding as a line of JSON, {"code", "severity" ("ok", "note", "doubt" or "fault"), "subject", "text"} and
// those of "view", "other", "figure", "limit", "advice" and "setting" that it has; to be released with
// ffp_free. NULL: there is no memory, or no such severity.
FFP_API char *ffp_finding_json(const FfpFinding *finding);

#ifdef __cplusplus
}
#endif

#endif
