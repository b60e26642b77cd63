// How long a reconstruction will take.
#include <math.h>
#include "ffprocams/rig.h"
#include "rules.h"

// Processor seconds.
#define START_SECONDS 16.0 // of all commands, whatever the size
#define CODE_SECONDS 1e-7  // to read a pixel of a photograph, for the calibration and for the capture
#define SPLAT_SECONDS 5e-5 // to reconstruct a pixel of the object in a view (rig/import/import_fit.c),
#define OBJECT_SHARE 0.25  // which shows it in so much of a photograph

json_t *ffp_studio_expected(const FfpStudio *studio, const char *object) {
    FfpStudioSet set;
    char names[FFP_STUDIO_SETS][FFP_STUDIO_NAME];
    const double pixels = (double)ffp_studio_number(studio, "photograph", 0, 0) *
                          (double)ffp_studio_number(studio, "photograph", 1, 0),
                 width = (double)ffp_studio_number(studio, "photograph", 0, 1),
                 narrow = (double)ffp_studio_number(studio, "width", -1, 128) / width;
    const int count = ffp_studio_set_names(studio, object, names, FFP_STUDIO_SETS);
    double photographs = 0, stops = 0;
    for (int i = 0; i < count; i++)
        if (ffp_studio_set(studio, names[i], &set) && set.kind != FFP_SET_SECOND)
            photographs += set.count, stops++;
    const double shown = fmin(stops * fmin(OBJECT_SHARE * pixels, (double)FFP_IMPORT_SIDE * FFP_IMPORT_SIDE),
                              FFP_IMPORT_PIXELS);
    const double import = (START_SECONDS + CODE_SECONDS * photographs * pixels) / studio->speed,
                 draft = SPLAT_SECONDS * shown * fmin(1, narrow * narrow) / studio->speed,
                 fine = fmin(SPLAT_SECONDS * shown / studio->speed, FFP_IMPORT_SECONDS);
    const bool known = pixels > 0 && photographs > 0;
    return json_pack("{s:f, s:f}", "draft", known ? import + draft : 0, "fine",
                     known ? import + draft + fine : 0);
}
