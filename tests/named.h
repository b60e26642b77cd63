// Errors by the findings that they tell of.
#ifndef FFP_TESTS_NAMED_H
#define FFP_TESTS_NAMED_H

#include <string.h>
#include "core/base/call.h"
#include "rig/findings/rules.h"
#include "support.h"

// The error tells of this finding (0: of none).
static inline void must_be(const FfpError *err, FfpRuleId rule) {
    const char *code = rule ? ffp_rule(rule)->code : "none", *found = err->finding ? err->finding : "none";
    if (strcmp(code, found) != 0) fail_msg("%s, not %s: %s", found, code, err->text);
}

static inline void keep_told(void *user, const FfpFinding *finding) {
    const size_t used = strlen(user);
    if (finding->severity >= FFP_FINDING_DOUBT)
        snprintf((char *)user + used, 4096 - used, "%s%s %s: %s\n",
                 finding->severity == FFP_FINDING_FAULT ? "fault " : "", finding->code,
                 finding->view ? finding->view : "", finding->text);
}

// A call refuses its photographs: by a fault, and by the error, which is returned. said: a line for each
// doubt or fault.
static inline FfpError must_refuse(bool (*call)(void *argument, FfpError *err), void *argument,
                                   FfpRuleId rule, char said[4096]) {
    FfpContext context = {.settings = {.finding = keep_told, .user = said}};
    FfpError err = {0};
    char fault[128];
    snprintf(fault, sizeof fault, "fault %s ", ffp_rule(rule)->code);
    said[0] = 0;
    if (ffp_call_run(&context, call, argument, &err)) fail_msg("nothing is refused by %s", fault);
    printf("%s%s\n", said, err.text);
    if (!strstr(said, fault)) fail_msg("no %s is told, but %s%s", fault, said, err.text);
    return err;
}

#endif
