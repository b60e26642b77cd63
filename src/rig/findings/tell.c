#include "rig/findings/tell.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/call.h"
#include "core/base/log.h"
#include "core/base/text.h"

// --- Words. ---

// The number of a placeholder, from the digits behind its colon: ".2f", ".3g" or ".1%".
static void put_number(FILE *out, double value, const char *digits) {
    const int precision = digits[0] == '.' ? digits[1] - '0' : 6;
    const char kind = digits[0] == '.' ? digits[2] : 'g';
    if (kind == '%')
        fprintf(out, "%.*f %%", precision, 100 * value);
    else
        fprintf(out, kind == 'f' ? "%.*f" : "%.*g", precision, value);
}

static void put_value(FILE *out, const char *name, size_t length, const char *digits, const void *with) {
    const FfpFacts *facts = with;
    const struct {
        const char *name, *text;
        double number;
    } values[] = {{"view", facts->view, 0},
                  {"other", facts->other, 0},
                  {"a", facts->a, 0},
                  {"b", facts->b, 0},
                  {"c", facts->c, 0},
                  {"figure", NULL, facts->figure},
                  {"limit", NULL, facts->limit},
                  {"x", NULL, facts->x},
                  {"y", NULL, facts->y},
                  {"z", NULL, facts->z}};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
        if (strlen(values[i].name) != length || strncmp(values[i].name, name, length) != 0) continue;
        if (values[i].text)
            ffp_put_plain(out, values[i].text);
        else if (i > 4)
            put_number(out, values[i].number, digits);
    }
}

void ffp_put_template(FILE *out, const char *template, FfpPutPlaceholder *put, const void *with) {
    for (const char *at = template; *at; at++) {
        if (*at != '{') {
            fputc(*at, out);
            continue;
        }
        const size_t length = strcspn(at + 1, ":}"), whole = strcspn(at, "}");
        put(out, at + 1, length, at[1 + length] == ':' ? at + 2 + length : "", with);
        at += whole;
    }
}

static const char *fill(FfpArena *memory, const char *template, const FfpFacts *facts) {
    if (!template) return NULL;
    FfpText *text = ffp_text_new();
    ffp_put_template(ffp_text_stream(text), template, put_value, facts);
    const char *filled = ffp_arena_text(memory, ffp_text_so_far(text, NULL));
    ffp_text_free(text);
    return filled;
}

// --- Findings. ---

bool ffp_found(FfpFindings *findings, FfpRuleId id, const FfpFacts *facts) {
    const FfpRule *rule = ffp_rule(id);
    FfpFacts filled = *facts;
    if (!findings->memory) findings->memory = ffp_arena_new();
    if (rule->limit > 0) filled.limit = rule->limit;
    findings->items = ffp_grow(findings->items, (size_t)findings->count + 1, sizeof *findings->items);
    findings->items[findings->count++] = (FfpFinding){
        .code = rule->code,
        .severity = rule->severity,
        .view = facts->view ? ffp_arena_text(findings->memory, facts->view) : NULL,
        .other = facts->other ? ffp_arena_text(findings->memory, facts->other) : NULL,
        .figure = rule->measure ? filled.figure : NAN,
        .limit = rule->measure && filled.limit > 0 ? filled.limit : NAN,
        .subject = rule->subject,
        .text = fill(findings->memory, rule->sentence, &filled),
        .advice = fill(findings->memory, rule->advice, &filled),
        .setting = fill(findings->memory, rule->setting, &filled),
    };
    return rule->severity != FFP_FINDING_FAULT;
}

void ffp_findings_free(FfpFindings *findings) {
    ffp_free(findings->items);
    ffp_arena_free(findings->memory);
    *findings = (FfpFindings){0};
}

const FfpFinding *ffp_findings_fault(const FfpFindings *findings) {
    for (int i = 0; i < findings->count; i++)
        if (findings->items[i].severity == FFP_FINDING_FAULT) return &findings->items[i];
    return NULL;
}

FfpFinding *ffp_findings_packed(const FfpFindings *findings) {
    const size_t n = (size_t)findings->count;
    size_t size = n * sizeof(FfpFinding) + 1;
    for (size_t i = 0; i < n; i++) {
        const FfpFinding *f = &findings->items[i];
        const char *const texts[] = {f->view, f->other, f->text, f->advice, f->setting};
        for (int k = 0; k < 5; k++) size += texts[k] ? strlen(texts[k]) + 1 : 0;
    }
    FfpFinding *out = ffp_alloc(size, 1);
    char *at = (char *)(out + n);
    for (size_t i = 0; i < n; i++) {
        out[i] = findings->items[i];
        const char **const texts[] = {&out[i].view, &out[i].other, &out[i].text, &out[i].advice,
                                      &out[i].setting};
        for (int k = 0; k < 5; k++) {
            if (!*texts[k]) continue;
            const size_t length = strlen(*texts[k]) + 1;
            *texts[k] = memcpy(at, *texts[k], length);
            at += length;
        }
    }
    return out;
}

void ffp_findings_merge(FfpFindings *findings) {
    int kept = 0;
    for (int i = 0; i < findings->count; i++) {
        const FfpFinding *f = &findings->items[i];
        bool needed = true;
        for (int k = 0; needed && k < findings->count; k++) {
            const FfpFinding *other = &findings->items[k];
            const bool alike = k != i && strcmp(other->code, f->code) == 0 &&
                               (!f->view || !other->view || strcmp(other->view, f->view) == 0);
            needed = !alike || (k < kept ? other->severity < f->severity : other->severity <= f->severity);
            // A worse finding explains the rest of its subject; measurements that were right stay.
            if (f->severity != FFP_FINDING_OK && other->severity > f->severity)
                needed = needed && strcmp(other->subject, f->subject) != 0;
        }
        if (needed) findings->items[kept++] = *f;
    }
    findings->count = kept;
}

// --- As text. ---

static void put_line(FILE *out, const FfpFinding *finding) {
    fputs(finding->text, out);
    if (finding->advice) fprintf(out, ": %s", finding->advice);
}

static char *line_of(const FfpFinding *finding) {
    FfpText *text = ffp_text_new();
    put_line(ffp_text_stream(text), finding);
    return ffp_text_end(text);
}

bool ffp_findings_pass(const FfpFindings *findings) {
    bool wanted = true;
    for (int i = 0; wanted && i < findings->count; i++) wanted = ffp_tell_finding(&findings->items[i]);
    return wanted;
}

static void log_finding(const FfpFinding *finding) {
    if (finding->severity == FFP_FINDING_OK || finding->severity == FFP_FINDING_FAULT) return;
    char *line = line_of(finding);
    if (finding->severity == FFP_FINDING_NOTE)
        ffp_note("%s", line);
    else
        ffp_warning("%s", line);
    ffp_free(line);
}

static bool fail_with(const FfpFinding *finding, FfpErrorCode code, const char *where, FfpError *err) {
    char *line = line_of(finding);
    ffp_fail(err, code, where, "%s", line);
    if (err) err->finding = finding->code;
    ffp_free(line);
    return false;
}

bool ffp_findings_tell(const FfpFindings *findings, const char *place, FfpError *err) {
    const FfpFinding *fault = ffp_findings_fault(findings);
    const bool passed = ffp_findings_pass(findings);
    for (int i = 0; !passed && i < findings->count; i++) log_finding(&findings->items[i]);
    if (!fault) return true;
    return fail_with(fault, FFP_ERROR_FAULT, fault->view ? fault->view : place, err);
}

static bool fail_by(FfpRuleId rule, const FfpFacts *facts, bool final, const char *where, FfpError *err) {
    FfpFindings found = {0};
    ffp_found(&found, rule, facts);
    if (final) ffp_findings_pass(&found);
    fail_with(&found.items[0], FFP_ERROR_FILE, where, err);
    ffp_findings_free(&found);
    return false;
}

bool ffp_fail_by(FfpRuleId rule, const FfpFacts *facts, const char *where, FfpError *err) {
    return fail_by(rule, facts, false, where, err);
}

bool ffp_refuse(FfpRuleId rule, const FfpFacts *facts, const char *where, FfpError *err) {
    return fail_by(rule, facts, true, where, err);
}

void ffp_tell(FfpRuleId rule, const FfpFacts *facts) {
    FfpFindings found = {0};
    ffp_found(&found, rule, facts);
    ffp_findings_tell(&found, "", NULL);
    ffp_findings_free(&found);
}

void ffp_findings_page(FILE *out, const FfpFinding *findings, int count) {
    static const char *const words[] = {"ok", "note", "LOOK", "STOP"};
    for (int i = 0; i < count; i++) {
        const FfpFinding *f = &findings[i];
        fprintf(out, "  %-4s %-12s ", words[f->severity], f->subject);
        // A fault begins with its view; doubts and notes say it themselves.
        if (f->severity == FFP_FINDING_FAULT && f->view) fprintf(out, "view %s: ", f->view);
        fprintf(out, "%s\n", f->text);
        if (f->advice) fprintf(out, "       -> %s\n", f->advice);
    }
}
