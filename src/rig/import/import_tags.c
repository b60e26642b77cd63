// Import: the orientation tags of the photographs. A rig stands still, so nothing turns between them.
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/image/image.h"
#include "rig/findings/tell.h"
#include "rig/import/import_steps.h"

static const char *words_of(int orientation) {
    return orientation > 1 ? ffp_orientation_words(orientation) : "upright";
}

// The tag of a stop's photographs; 0 with an error: they have several.
static int tag_of(const FfpShots *shots, int stop, FfpError *err) {
    const char *const *files = shots->pictures + (ptrdiff_t)stop * FFP_PATTERNS_MAX, *first = NULL;
    int tag = 1;
    for (int p = 0; p < shots->n_patterns; p++) {
        const int own = files[p] ? ffp_image_orientation(files[p]) : tag;
        if (!first && files[p]) first = files[p], tag = own;
        if (own == tag) continue;
        ffp_fail_by(FFP_RULE_TAGS_MIXED,
                    &(FfpFacts){.a = ffp_basename(first), .b = words_of(tag), .c = ffp_basename(files[p])},
                    first, err);
        return 0;
    }
    return tag;
}

// The views that are tagged unlike most: "views 090, 135, 180".
static bool fail_by_views(const FfpImporting *import, const int *tags, int usual, FfpError *err) {
    char names[400] = "";
    size_t used = 0;
    int other = 1, count = 0;
    for (int v = 0; v < import->calibration.n_stops; v++) {
        if (tags[v] == usual) continue;
        other = tags[v];
        if (used + FFP_NAME_MAX + 8 < sizeof names)
            used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", count > 0 ? ", " : "",
                                     import->calibration.stops[v].id);
        count++;
    }
    char views[440];
    snprintf(views, sizeof views, "view%s %s", count > 1 ? "s" : "", names);
    return ffp_fail_by(FFP_RULE_TAGS_DIFFER,
                       &(FfpFacts){.a = views, .b = words_of(other), .c = words_of(usual)}, "images", err);
}

// Fails where photographs of a rig that stands still are tagged differently.
bool ffp_importing_check_tags(FfpImporting *import, FfpError *err) {
    const int n = import->calibration.n_stops;
    int count[9] = {0}, usual = 1;
    if (!import->calibration.has_camera) return true; // cameras of their own may be turned
    int *tags = ffp_alloc((size_t)n + 1, sizeof *tags);
    bool ok = true;
    for (int v = 0; ok && v < n; v++) {
        tags[v] = tag_of(&import->shots, v, err);
        ok = tags[v] > 0;
        if (ok && ++count[tags[v]] > count[usual]) usual = tags[v];
    }
    if (ok && count[usual] < n) ok = fail_by_views(import, tags, usual, err);
    ffp_free(tags);
    return ok;
}
