// Errors by the findings that they tell of.
#ifndef FFP_TESTS_NAMED_H
#define FFP_TESTS_NAMED_H

#include "rig/findings/rules.h"
#include "support.h"

// The error tells of this finding (0: of none).
static inline void must_be(const FfpError *err, FfpRuleId rule) {
    const char *code = rule ? ffp_rule(rule)->code : "none", *found = err->finding ? err->finding : "none";
    if (strcmp(code, found) != 0) fail_msg("%s, not %s: %s", found, code, err->text);
}

#endif
