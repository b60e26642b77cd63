// Import: what cameras write into the photographs. A rig stands still, so nothing turns between them, and one
// calibration is that of one camera.
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "rig/import/import_steps.h"
#include "rig/shots/tags.h"
#include "rig/shots/taken.h"

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

static bool is_of_one_camera(const FfpCalibration *c) {
    for (int v = 1; v < c->n_stops && !c->has_camera; v++)
        if (memcmp(&c->stops[v].camera, &c->stops[0].camera, sizeof c->stops->camera) != 0) return false;
    return true;
}

static void compare_cameras(const FfpImporting *import) {
    const FfpShots *shots = &import->shots;
    const int n = import->calibration.n_stops, most = shots->n_patterns + shots->n_codes + shots->n_greys;
    FfpShotFolder *views = ffp_arena_alloc(shots->arena, (size_t)n + 1, sizeof *views);
    for (int v = 0; v < n; v++) {
        const struct {
            const char **files;
            int n, apart;
        } kinds[] = {{shots->pictures, shots->n_patterns, FFP_PATTERNS_MAX},
                     {shots->codes, shots->n_codes, shots->n_codes},
                     {shots->greys, shots->n_greys, shots->n_greys}};
        views[v].name = import->calibration.stops[v].id;
        views[v].files = ffp_arena_alloc(shots->arena, (size_t)most + 1, sizeof *views->files);
        for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
            for (int i = 0; i < kinds[k].n; i++)
                views[v].files[views[v].n_files++] = kinds[k].files[(ptrdiff_t)v * kinds[k].apart + i];
    }
    ffp_taken_compare(views, n, is_of_one_camera(&import->calibration), NULL);
}

// Fails where photographs of a rig that stands still are tagged differently.
bool ffp_importing_check_tags(FfpImporting *import, FfpError *err) {
    const FfpShots *shots = &import->shots;
    const int n = import->calibration.n_stops;
    compare_cameras(import);
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
