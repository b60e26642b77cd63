// The page that lists what can be wrong.
#include <stdio.h>
#include <string.h>
#include "rig/findings/rules.h"

static const struct {
    const char *subject, *meaning;
} subjects[] = {
    {"devices",
     "Where camera and projector stand around the object, from the calibration and the turntable's axis."},
    {"frusta", "What the devices see of the object's sphere: the camera should see all of it, and the "
               "pattern cover it."},
    {"lit pixels", "Pixels that white brightens must lie where the projector's light can reach."},
    {"silhouettes", "A pixel that shows the object needs a point on its ray that no other view shows as "
                    "background: with right poses and masks every pixel has one."},
    {"masks", "Which pixels show the object."},
    {"photographs", "The photographs of a view, one under each pattern."},
    {"clipping", "Pixels at the camera's limit have lost their colour."},
    {"exposure", "How bright the object is under white."},
    {"black level", "Nothing can be darker under more light."},
    {"lit share", "How much of the object the projector's light reaches."},
    {"ambient", "The room's light, which remains when the projector shows black."},
    {"camera", "Distances, angles and fields of view, beside those of the rigs that the shipped model was "
               "trained on. Others work, but less well; `--model none` does not depend on them."},
    {"views", "How the views are spread around the object."},
    {"size", "The size of the photographs as they were imported."},
    {"pattern", "Along the right ray through the projector's picture there is a point of the colour that the "
                "camera saw; along a wrong one only by chance."},
    {"surfaces", "Each view's own light gives the surface that it sees; those of neighbouring views are one "
                 "surface, unless something moved in between."},
    {"parallax",
     "In a whole scene, depth where no projector reaches comes from views that are near each other."},
};

// Templates with their placeholders as words in capitals.
static void put_template(FILE *out, const char *template) {
    static const char *const words[][2] = {
        {"view", "VIEW"}, {"other", "OTHER"}, {"figure", "N"}, {"limit", "N"}, {"x", "N"},
        {"y", "N"},       {"z", "N"},         {"a", "A"},      {"b", "B"},     {"c", "C"}};
    for (const char *at = template; *at; at++) {
        if (*at != '{') {
            fputc(*at, out);
            continue;
        }
        const size_t length = strcspn(at + 1, ":}"), whole = strcspn(at, "}");
        for (size_t i = 0; i < sizeof words / sizeof *words; i++)
            if (strlen(words[i][0]) == length && strncmp(words[i][0], at + 1, length) == 0)
                fputs(words[i][1], out);
        if (at[whole - 1] == '%') fputs(" %", out);
        at += whole;
    }
}

static const char *meaning_of(const char *subject) {
    for (size_t i = 0; i < sizeof subjects / sizeof *subjects; i++)
        if (strcmp(subjects[i].subject, subject) == 0) return subjects[i].meaning;
    return NULL;
}

static void put_rule(FILE *out, const FfpRule *rule) {
    static const char *const severities[] = {"", "a note", "a doubt", "a fault"};
    fprintf(out, "\n**`%s`** (%s): ", rule->code, severities[rule->severity]);
    put_template(out, rule->sentence);
    fputs(".\n", out);
    if (rule->advice) {
        fputs("What to do: ", out);
        put_template(out, rule->advice);
        fputs(strchr("?!.", rule->advice[strlen(rule->advice) - 1]) ? "\n" : ".\n", out);
    }
    if (rule->measure && rule->limit > 0) fprintf(out, "Limit: %g, %s.\n", rule->limit, rule->measure);
}

void ffp_write_troubleshooting(FILE *out) {
    const char *subject = "";
    fputs("# Troubleshooting\n\n"
          "This page is made from `src/rig/findings/rules.c` (`FFP_WRITE=1 build/test_troubleshooting`), and "
          "holds every message "
          "about photographs, poses and calibrations by its code, which `ffprocams info --json` "
          "and "
          "`ffp_capture_check` give, too.\n"
          "A fault makes the result wrong: `reconstruct`, `refine` and `evaluate` refuse such a capture "
          "unless they are "
          "told `--force`. A doubt makes the result worse, or may not be what you intended; notes are worth "
          "knowing.\n"
          "Capitals stand for names and numbers.\n",
          out);
    for (int id = 0; id < FFP_RULES; id++) {
        const FfpRule *rule = ffp_rule((FfpRuleId)id);
        if (rule->severity == FFP_FINDING_OK) continue;
        if (strcmp(subject, rule->subject) != 0) {
            const char *meaning = meaning_of(rule->subject);
            fprintf(out, "\n## %c%s\n", rule->subject[0] - 'a' + 'A', rule->subject + 1);
            if (meaning) fprintf(out, "\n%s\n", meaning);
        }
        subject = rule->subject;
        put_rule(out, rule);
    }
}
