// Findings of a call: collected, told to its caller, and as text.
#ifndef FFP_RIG_FINDINGS_TELL_H
#define FFP_RIG_FINDINGS_TELL_H

#include <stdbool.h>
#include <stdio.h>
#include "core/base/arena.h"
#include "rig/findings/rules.h"

// The values for the placeholders in a rule's words.
typedef struct FfpFacts {
    const char *view, *other, *a, *b, *c;
    double figure, limit, x, y, z;
} FfpFacts;

// A rule's words, where `put` writes what stands for a placeholder: `length` bytes of its name, and what
// follows its colon, from the digits on (".1%} of"); "": it has none.
typedef void FfpPutPlaceholder(FILE *out, const char *name, size_t length, const char *digits,
                               const void *with);
void ffp_put_template(FILE *out, const char *template, FfpPutPlaceholder *put, const void *with);

typedef struct FfpFindings {
    FfpFinding *items; // [count]; their texts are in `memory`
    int count;
    FfpArena *memory;
} FfpFindings;

void ffp_findings_free(FfpFindings *findings);

// Adds a finding. False if it is a fault, so that a check can `return ffp_found(...)`.
bool ffp_found(FfpFindings *findings, FfpRuleId rule, const FfpFacts *facts);
// Of several findings of one code, the most severe stays; notes give way to doubts of their subject, and both
// to a fault.
void ffp_findings_merge(FfpFindings *findings);
// The fault among them; NULL: there is none.
const FfpFinding *ffp_findings_fault(const FfpFindings *findings);

// All of them in one block, to be released with ffp_free.
FfpFinding *ffp_findings_packed(const FfpFindings *findings);

// Passes them on to the function of the current call's context, if it has one. Otherwise: false.
bool ffp_findings_pass(const FfpFindings *findings);
// The same, and without such a function the call's log gets the line of each that is not ok. A fault becomes
// the error, and the function returns false. `place`: where the error is, if the fault names no view.
bool ffp_findings_tell(const FfpFindings *findings, const char *place, FfpError *err);

// The error of a file by a rule's words: "TEXT: ADVICE (WHERE)". Returns false.
bool ffp_fail_by(FfpRuleId rule, const FfpFacts *facts, const char *where, FfpError *err);
// The same of photographs that end the call: the finding is passed on, too, before the error.
bool ffp_refuse(FfpRuleId rule, const FfpFacts *facts, const char *where, FfpError *err);
// One finding at once, a note or a doubt.
void ffp_tell(FfpRuleId rule, const FfpFacts *facts);

// The page of `info`: a line for each, "ok", "note", "LOOK" or, of what is refused, "STOP"; the advice below.
void ffp_findings_page(FILE *out, const FfpFinding *findings, int count);

#endif
