// The findings of the checks, by their rules.
#ifndef FFP_TESTS_RIG_CHECKS_FOUND_H
#define FFP_TESTS_RIG_CHECKS_FOUND_H

#include "rig/checks/checks.h"
#include "support.h"

static FfpFindings found; // of the last check
static FfpCapture capture;

// A sound capture.
static int setup(void **state) {
    (void)state;
    return !ffp_capture_read(&capture, FFP_SOURCE_DIR "/data/sample", NULL);
}

static int teardown(void **state) {
    (void)state;
    ffp_capture_free(&capture);
    ffp_findings_free(&found);
    return 0;
}

// The finding of a rule, about a view (NULL: about none, or any).
static inline const FfpFinding *must_find(FfpRuleId id, const char *view) {
    const FfpRule *rule = ffp_rule(id);
    for (int i = 0; i < found.count; i++) {
        const FfpFinding *f = &found.items[i];
        if (strcmp(f->code, rule->code) == 0 && f->severity == rule->severity &&
            (!view || (f->view && strcmp(f->view, view) == 0)))
            return f;
    }
    for (int i = 0; i < found.count; i++)
        print_error("%s %s: %s\n", found.items[i].code, found.items[i].view, found.items[i].text);
    fail_msg("%s of %s is not found", rule->code, view ? view : "all");
    return NULL;
}

#endif
