// Import: the orientation tags of the photographs. A rig stands still, so nothing turns between them.
#include <stdio.h>
#include "core/base/alloc.h"
#include "rig/import/import_steps.h"
#include "rig/shots/tags.h"

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
    return ffp_tag_fail(views, other, usual, "images", err);
}

// Fails where photographs of a rig that stands still are tagged differently.
bool ffp_importing_check_tags(FfpImporting *import, FfpError *err) {
    const FfpShots *shots = &import->shots;
    const int n = import->calibration.n_stops;
    if (!import->calibration.has_camera) return true; // cameras of their own may be turned
    int *tags = ffp_alloc((size_t)n + 1, sizeof *tags);
    bool ok = true;
    for (int v = 0; ok && v < n; v++) {
        const char *const *files = shots->pictures + (ptrdiff_t)v * FFP_PATTERNS_MAX;
        tags[v] = ffp_tag_of(files, shots->n_patterns, files[shots->black], err);
        ok = tags[v] > 0;
    }
    const int usual = ok ? ffp_tag_usual(tags, n) : 1;
    for (int v = 0; ok && v < n; v++) ok = tags[v] == usual || fail_by_views(import, tags, usual, err);
    ffp_free(tags);
    return ok;
}
