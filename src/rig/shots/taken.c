#include "rig/shots/taken.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/image/image.h"
#include "rig/findings/tell.h"

#define SAME 0.02 // of a number: files round to millimetres

typedef enum What { MODEL, SERIAL, LENS, FOCAL_35MM, FOCAL, ZOOM, WHATS } What;

static const struct {
    size_t at; // of FfpTakenBy: texts, then numbers
    const char *words;
} whats[WHATS] = {[MODEL] = {offsetof(FfpTakenBy, model), "the camera '%s'"},
                  [SERIAL] = {offsetof(FfpTakenBy, serial), "a camera with the serial number '%s'"},
                  [LENS] = {offsetof(FfpTakenBy, lens), "the lens '%s'"},
                  [FOCAL_35MM] = {offsetof(FfpTakenBy, focal_35mm), NULL},
                  [FOCAL] = {offsetof(FfpTakenBy, focal), "a focal length of %s mm"},
                  [ZOOM] = {offsetof(FfpTakenBy, zoom), "a digital zoom of %s"}};

static const char *text_of(const FfpTakenBy *by, What what) {
    return (const char *)by + whats[what].at;
}

static double number_of(const FfpTakenBy *by, What what) {
    double number;
    memcpy(&number, text_of(by, what), sizeof number);
    return number;
}

static bool says(const FfpTakenBy *by, What what) {
    return what <= LENS ? text_of(by, what)[0] != 0 : number_of(by, what) > 0;
}

// As far as both say it.
static bool agree(const FfpTakenBy *a, const FfpTakenBy *b, What what) {
    if (!says(a, what) || !says(b, what)) return true;
    return what <= LENS ? strcmp(text_of(a, what), text_of(b, what)) == 0
                        : fabs(number_of(a, what) / number_of(b, what) - 1) <= SAME;
}

// The answers of most of n, the first of as many.
static FfpTakenBy most_of(const FfpTakenBy *all, int n) {
    FfpTakenBy usual = {.zoom = 0};
    for (What what = 0; what < WHATS; what++) {
        int most = 0;
        for (int i = 0; i < n; i++) {
            int like = 0;
            if (!says(&all[i], what) || (most > 0 && agree(&all[i], &usual, what))) continue;
            for (int k = 0; k < n; k++) like += says(&all[k], what) && agree(&all[k], &all[i], what);
            if (like <= most) continue;
            most = like;
            memcpy((char *)&usual + whats[what].at, text_of(&all[i], what),
                   what <= LENS ? FFP_TAKEN_TEXT : sizeof(double));
        }
    }
    return usual;
}

static void put_words(const FfpTakenBy *by, What what, char out[2 * FFP_TAKEN_TEXT]) {
    char number[32];
    if (what > LENS) snprintf(number, sizeof number, "%.3g", number_of(by, what));
    snprintf(out, 2 * FFP_TAKEN_TEXT, whats[what].words, what > LENS ? number : text_of(by, what));
}

// Tells of the first thing that one says otherwise; `file`: of which file, or NULL, of a whole folder.
static bool tell(const FfpTakenBy *one, const FfpTakenBy *usual, const char *folder, const char *file) {
    FfpFacts facts = {.view = folder, .a = file};
    char own[2 * FFP_TAKEN_TEXT], others[2 * FFP_TAKEN_TEXT];
    What what = 0;
    while (what < WHATS && agree(one, usual, what)) what++;
    if (what == WHATS) return false;
    if (what == FOCAL_35MM) {
        facts.figure = one->focal_35mm, facts.limit = usual->focal_35mm;
        ffp_tell(file ? FFP_RULE_FILE_LENS : FFP_RULE_PLACE_LENS, &facts);
        return true;
    }
    put_words(one, what, own), put_words(usual, what, others);
    facts.b = own, facts.c = others;
    ffp_tell(file ? FFP_RULE_FILE_CAMERA : FFP_RULE_PLACE_CAMERA, &facts);
    return true;
}

static FfpTakenBy ask_folder(const FfpShotFolder *folder) {
    FfpTakenBy *all = ffp_alloc((size_t)folder->n_files + 1, sizeof *all);
    for (int i = 0; i < folder->n_files; i++)
        if (folder->files[i]) all[i] = ffp_image_taken_by(folder->files[i]);
    const FfpTakenBy usual = most_of(all, folder->n_files);
    for (int i = 0; i < folder->n_files; i++)
        if (folder->files[i] && tell(&all[i], &usual, folder->name, ffp_basename(folder->files[i]))) break;
    ffp_free(all);
    return usual;
}

double ffp_taken_compare(const FfpShotFolder *folders, int n, bool one, double *each) {
    FfpTakenBy *all = ffp_alloc((size_t)n + 1, sizeof *all);
    for (int i = 0; i < n; i++) {
        all[i] = ask_folder(&folders[i]);
        if (each) each[i] = all[i].focal_35mm;
    }
    const FfpTakenBy usual = most_of(all, n);
    for (int i = 0; one && i < n; i++) tell(&all[i], &usual, folders[i].name, NULL);
    ffp_free(all);
    return usual.focal_35mm;
}
