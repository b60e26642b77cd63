#include "rig/chessboard/notes.h"
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "rig/findings/tell.h"

enum { NAMES_MAX = 6, NAMES_SIZE = 320 };

// "pose_1, pose_4", "all 5 attitudes", "pose_1, ... and 3 more"
static void name_chosen(const FfpRigFit *fit, const bool *chosen, char text[NAMES_SIZE]) {
    int count = 0, named = 0, used = 0;
    for (int i = 0; i < fit->n; i++) count += chosen[i];
    if (count == fit->n && count > 1) {
        snprintf(text, NAMES_SIZE, "all %d attitudes", count);
        return;
    }
    text[0] = 0;
    const int shown = count > NAMES_MAX ? NAMES_MAX - 1 : count;
    for (int i = 0; i < fit->n && named < shown; i++)
        if (chosen[i])
            used += snprintf(text + used, (size_t)(NAMES_SIZE - used), "%s%.40s", named++ > 0 ? ", " : "",
                             fit->attitudes[i].name);
    if (count > shown) snprintf(text + used, (size_t)(NAMES_SIZE - used), " and %d more", count - shown);
}

// A problem without the folder's own name before its files', so that those of several can be compared.
static void without_folder(const FfpAttitude *a, char text[sizeof a->problem]) {
    const size_t length = strlen(a->name);
    size_t used = 0;
    for (const char *at = a->problem; *at;) {
        const bool here = length > 0 && strncmp(at, a->name, length) == 0 && at[length] == '/';
        if (here) at += length + 1;
        if (*at) text[used++] = *at++;
    }
    text[used] = 0;
}

// Marks the attitudes that have the problem of attitude `first`; false when an earlier one has it. *why: as
// it is to be told.
static bool alike(const FfpRigFit *fit, int first, bool *chosen, char why[sizeof fit->attitudes->problem]) {
    char other[sizeof fit->attitudes->problem];
    int count = 0;
    without_folder(&fit->attitudes[first], why);
    for (int i = 0; i < fit->n; i++) {
        without_folder(&fit->attitudes[i], other);
        chosen[i] = strcmp(why, other) == 0;
        count += chosen[i];
        if (chosen[i] && i < first) return false;
    }
    if (count == 1) snprintf(why, sizeof other, "%s", fit->attitudes[first].problem);
    return true;
}

// The next reason from *at on, with who has it; false when there is none.
static bool next_problem(const FfpRigFit *fit, int *at, bool *chosen, char names[NAMES_SIZE],
                         char why[sizeof fit->attitudes->problem]) {
    for (; *at < fit->n; (*at)++) {
        if (fit->attitudes[*at].problem[0] == 0 || !alike(fit, *at, chosen, why)) continue;
        name_chosen(fit, chosen, names);
        (*at)++;
        return true;
    }
    return false;
}

void ffp_list_problems(const FfpRigFit *fit, char *text, size_t size) {
    bool *chosen = ffp_alloc((size_t)fit->n, sizeof *chosen);
    char names[NAMES_SIZE], why[sizeof fit->attitudes->problem];
    size_t used = 0;
    static const char more[] = "; and more";
    text[0] = 0;
    for (int at = 0; next_problem(fit, &at, chosen, names, why);) {
        const size_t needed = strlen(names) + strlen(why) + 4;
        if (used == 0 || used + needed + sizeof more <= size)
            snprintf(text + used, size - used, "; %s: %s", names, why);
        else
            snprintf(text + used, size - used, more);
        used = strlen(text);
        if (used + needed + sizeof more > size) break;
    }
    ffp_free(chosen);
}

static void tell_problems(const FfpRigFit *fit, bool *chosen) {
    char names[NAMES_SIZE], why[sizeof fit->attitudes->problem];
    for (int at = 0; next_problem(fit, &at, chosen, names, why);) {
        int count = 0;
        for (int i = 0; i < fit->n; i++) count += chosen[i];
        char said[NAMES_SIZE + 8];
        snprintf(said, sizeof said, "%s %s", names, count > 1 ? "are" : "is");
        ffp_tell(FFP_RULE_ATTITUDE, &(FfpFacts){.view = count == 1 ? names : NULL, .a = said, .b = why});
    }
}

// "4 corners left out for the camera, far from the fit (of 54 each: pose_0 3, pose_4 1)"
static void tell_corners(const FfpRigFit *fit, int device, int state, const char *why) {
    char text[640] = "";
    int used = 0, total = 0;
    for (int i = 0; i < fit->n; i++) {
        const FfpAttitude *a = &fit->attitudes[i];
        int count = 0;
        for (int k = 0; a->problem[0] == 0 && k < a->n; k++)
            count += (device == 0 ? a->camera_state : a->projector_state)[k] == state;
        total += count;
        if (count > 0 && used < (int)sizeof text - 80)
            used += snprintf(text + used, sizeof text - (size_t)used, ", %.40s %d", a->name, count);
        else if (count > 0 && strcmp(text + used - 3, "...") != 0)
            used += snprintf(text + used, sizeof text - (size_t)used, ", ...");
    }
    if (total > 0)
        ffp_note("%d corners left out for the %s, %s (of %d each: %s)", total,
                 device == 0 ? "camera" : "projector", why, fit->board.columns * fit->board.rows, text + 2);
}

void ffp_note_left_out(const FfpRigFit *fit) {
    static const char *const why[FFP_CORNER_STATES] = {
        "", "no codes read around them", "codes around them not on a plane", "far from the fit"};
    bool *chosen = ffp_alloc((size_t)fit->n, sizeof *chosen);
    tell_problems(fit, chosen);
    ffp_free(chosen);
    for (int device = 0; device < 2; device++)
        for (int state = 1; state < FFP_CORNER_STATES; state++) tell_corners(fit, device, state, why[state]);
}

void ffp_note_photographs(const FfpRigFit *fit) {
    bool *chosen = ffp_alloc((size_t)fit->n, sizeof *chosen);
    char names[NAMES_SIZE];
    double most = 0;
    for (int i = 0; i < fit->n; i++) {
        chosen[i] = fit->attitudes[i].clipped > ffp_rule(FFP_RULE_BOARD_CLIPPED)->limit;
        most = chosen[i] && fit->attitudes[i].clipped > most ? fit->attitudes[i].clipped : most;
    }
    name_chosen(fit, chosen, names);
    if (most > 0) ffp_tell(FFP_RULE_BOARD_CLIPPED, &(FfpFacts){.figure = most, .a = names});
    for (int k = 0; k < 2 * 16; k++) {
        const int axis = k % 2, bits = k / 2;
        bool any = false;
        for (int i = 0; i < fit->n; i++) {
            chosen[i] = bits > 0 && fit->attitudes[i].dropped[axis] == bits;
            any = any || chosen[i];
        }
        name_chosen(fit, chosen, names);
        if (any)
            ffp_note("the finest %d bit%s of the %s cannot be read: positions are known to %d pixels (%s)",
                     bits, bits > 1 ? "s" : "", axis == 0 ? "columns" : "rows", 1 << bits, names);
    }
    ffp_free(chosen);
}
