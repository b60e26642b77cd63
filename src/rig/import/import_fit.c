// Import: where nobody says how wide the capture's pictures are to be, as fine as the photographs show the
// object, and cut to it.
#include <omp.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "core/base/memory.h"
#include "core/capture/node.h"
#include "engine/pipeline/need.h"
#include "rig/import/import_steps.h"

#define SPLAT_SECONDS                                                                                        \
    5e-5 // of a processor for each pixel of the object in each view (docs/lab/notebook/sizes.md)
#define MEMORY_SHARE 0.5 // of what is free
#define STEP 0.97        // from a size that is too large to the next
#define MARGIN 0.25      // of the object's longer side that is kept around it
#define SAVED 0.5        // of the photographs' pixels, for which they are cut
#define OBJECT 0.5       // of a pixel, at least

enum { LOOK = 320 }; // pixels of the longer side of pictures in which the object is looked for

// Where the object is, and how large: the first two in shares of the photographs' sides.
typedef struct Extent {
    double low[2], high[2]; // of all views
    double longest;         // in photographs' pixels, of the view where it is longest
    double pixels;          // of the photographs, that show it
} Extent;

static void add_extent(Extent *extent, const FfpImage *mask, const FfpOptics *optics) {
    const double sides[2] = {optics->width, optics->height};
    double low[2] = {1, 1}, high[2] = {0, 0}, count = 0;
    for (int i = 0; i < mask->width * mask->height; i++) {
        if (!(mask->data[i] > OBJECT)) continue;
        const double from[2] = {(double)(i % mask->width) / mask->width,
                                floor((double)i / mask->width) / mask->height};
        const double to[2] = {from[0] + 1.0 / mask->width, from[1] + 1.0 / mask->height};
        for (int k = 0; k < 2; k++) low[k] = fmin(low[k], from[k]), high[k] = fmax(high[k], to[k]);
        count++;
    }
    for (int k = 0; k < 2; k++) {
        extent->low[k] = fmin(extent->low[k], low[k]);
        extent->high[k] = fmax(extent->high[k], high[k]);
        extent->longest = fmax(extent->longest, (high[k] - low[k]) * sides[k]);
    }
    extent->pixels += count / mask->width / mask->height * sides[0] * sides[1];
}

// --- Looking for it. ---

enum { BLACK, WHITE, EMPTY_BLACK, EMPTY_WHITE, PICTURES };

// Pixels that differ from the empty stage, those of its shadow too.
static bool differs(FfpImage *mask, const FfpImage pictures[PICTURES]) {
    FfpImage none = ffp_image_new(pictures[WHITE].width, pictures[WHITE].height, 3),
             apart = ffp_image_new(none.width, none.height, 3), holes = {0};
    for (int i = 0; i < 3 * none.width * none.height; i++)
        apart.data[i] = fabs(pictures[WHITE].data[i] - pictures[EMPTY_WHITE].data[i]) +
                        fabs(pictures[BLACK].data[i] - pictures[EMPTY_BLACK].data[i]);
    const bool ok = ffp_mask_otsu(mask, &holes, &none, &apart, "", NULL);
    ffp_image_free(&holes), ffp_image_free(&none), ffp_image_free(&apart);
    return ok;
}

// The view's coverage as import would have it of black and white alone.
static bool is_covered(FfpImporting *look, int v, const FfpImage pictures[PICTURES], const FfpImage *alphas) {
    FfpView *view = &look->capture.views[v];
    FfpCapture alone = look->capture;
    FfpImage dark = {0};
    if (pictures[EMPTY_WHITE].data && pictures[EMPTY_BLACK].data) return differs(&view->coverage, pictures);
    FfpImage *of_all = ffp_alloc((size_t)look->shots.n_patterns, sizeof *of_all);
    of_all[look->shots.white] = alphas[WHITE], of_all[look->shots.black] = alphas[BLACK];
    const bool ok = (!look->shots.empty || look->shots.masks) && ffp_importing_cover(look, v, of_all, NULL);
    ffp_free(of_all);
    alone.n_views = 1, alone.views = view, alone.n_patterns = look->shots.n_patterns;
    alone.black = look->shots.black, alone.white = look->shots.white;
    if (ok && look->made[v] && ffp_dark_masks(&dark, &alone)) {
        ffp_image_free(&view->coverage);
        view->coverage = dark;
    }
    return ok;
}

static bool look_at(FfpImporting *look, int v, Extent *extent) {
    const FfpShots *shots = &look->shots;
    const FfpOptics *optics = &look->calibration.stops[v].camera;
    const char *const *files = shots->pictures + (ptrdiff_t)v * FFP_PATTERNS_MAX,
                      *const *empty = shots->empty && !shots->masks
                                          ? shots->empty + (ptrdiff_t)v * FFP_PATTERNS_MAX
                                          : NULL;
    const char *paths[PICTURES] = {files[shots->black], files[shots->white],
                                   empty ? empty[shots->black] : NULL, empty ? empty[shots->white] : NULL};
    FfpView *view = &look->capture.views[v];
    FfpImage pictures[PICTURES] = {0}, alphas[PICTURES] = {0};
    view->images = ffp_alloc((size_t)shots->n_patterns, sizeof *view->images);
    bool ok = ffp_importing_read_pictures(look, paths, PICTURES, v, pictures, alphas, NULL) &&
              ffp_importing_make_plain(look, v, &pictures[BLACK], &pictures[WHITE], NULL);
    if (ok) {
        view->images[shots->black] = pictures[BLACK], view->images[shots->white] = pictures[WHITE];
        ok = is_covered(look, v, pictures, alphas);
        if (ok) add_extent(extent, &view->coverage, optics);
    }
    for (int i = 0; i < PICTURES; i++) ffp_image_free(&pictures[i]), ffp_image_free(&alphas[i]);
    ffp_free(view->images);
    ffp_image_free(&view->coverage);
    return ok;
}

static void look_at_frames(const FfpImporting *import, Extent *extent) {
    *extent = (Extent){.high = {1, 1}};
    for (int v = 0; v < import->capture.n_views; v++) {
        const FfpOptics *optics = &import->calibration.stops[v].camera;
        extent->longest = fmax(extent->longest, fmax(optics->width, optics->height));
        extent->pixels += (double)optics->width * optics->height;
    }
}

// Where nothing is found, and in whole scenes, it is all that the photographs show.
static Extent find_object(const FfpImporting *import) {
    const int n = import->capture.n_views;
    Extent extent = {.low = {1, 1}};
    FfpImporting look = *import; // whose counts nobody reads
    look.capture.views = ffp_alloc((size_t)n, sizeof *look.capture.views);
    look.made = ffp_alloc((size_t)n, sizeof *look.made);
    look.holes = ffp_alloc((size_t)n, sizeof *look.holes);
    bool found = !import->settings->scene;
    for (int v = 0; v < n && found; v++) {
        const FfpOptics *optics = &look.calibration.stops[v].camera;
        const double longer = fmax(optics->width, optics->height);
        look.capture.views[v] = import->capture.views[v];
        ffp_optics_pinhole(optics, (int)fmax(1, ceil(optics->width * fmin(1, LOOK / longer))),
                           &look.capture.views[v].camera);
        found = look_at(&look, v, &extent);
        ffp_image_free(&look.holes[v]);
    }
    ffp_free(look.capture.views), ffp_free(look.made), ffp_free(look.holes);
    if (!found || !(extent.longest > 0)) look_at_frames(import, &extent);
    return extent;
}

// --- Choosing. ---

static double bytes_at(const FfpImporting *import, const Extent *extent, double scale) {
    const FfpCamera *projector = &import->capture.views[0].projector;
    const FfpOptics *optics = &import->calibration.stops[0].camera;
    const int n = import->capture.n_views;
    const double frame = (double)optics->width * optics->height;
    const FfpProblemSize size = {.views = n,
                                 .width = (int)ceil(scale * optics->width),
                                 .height = (int)ceil(scale * optics->height),
                                 .photographs = 3,
                                 .pattern = (double)projector->width * projector->height,
                                 .share = extent->pixels / n / frame,
                                 .scene = import->settings->scene,
                                 .denoise = true,
                                 .polish = true,
                                 .samples = 2,
                                 .threads = omp_get_max_threads()};
    const double pictures = (3.0 * (import->shots.n_patterns + ffp_importing_codes_looked_at(import)) + 8) *
                            n * frame * scale * scale * sizeof(real);
    return pictures + ffp_reconstruction_bytes(&size);
}

// The scale at which the photographs are used; why it is not 1 is kept for the note.
static double choose_scale(FfpImporting *import, const Extent *extent) {
    const double free = ffp_memory_available();
    double scale = fmin(1, FFP_IMPORT_SIDE / extent->longest);
    import->limit = scale < 1 ? "more are of little use" : "";
    const double in_page = sqrt(FFP_IMPORT_PIXELS / extent->pixels);
    if (in_page < scale) scale = in_page, import->limit = "more would be too much for the page";
    while (free > 0 && scale * extent->longest > LOOK &&
           bytes_at(import, extent, scale) > MEMORY_SHARE * free)
        scale *= STEP, import->limit = "more would take more than half of the memory that is free";
    const double seconds = SPLAT_SECONDS * extent->pixels / omp_get_max_threads();
    const double in_time = sqrt(FFP_IMPORT_SECONDS / seconds);
    if (in_time < scale)
        scale = in_time, import->limit = "a reconstruction of more would take over three minutes";
    return scale;
}

// --- Cameras. ---

static bool have_one_size(const FfpImporting *import) {
    const FfpStop *stops = import->calibration.stops;
    for (int v = 1; v < import->capture.n_views; v++)
        if (stops[v].camera.width != stops[0].camera.width ||
            stops[v].camera.height != stops[0].camera.height)
            return false;
    return true;
}

// The part of all pictures that shows the object, in shares; false: it is not much less than all.
static bool choose_part(const FfpImporting *import, Extent *part) {
    const FfpOptics *optics = &import->calibration.stops[0].camera;
    const double sides[2] = {optics->width, optics->height};
    double area = 1;
    for (int k = 0; k < 2; k++) {
        const double margin = MARGIN * part->longest / sides[k];
        part->low[k] = fmax(0, part->low[k] - margin), part->high[k] = fmin(1, part->high[k] + margin);
        area *= part->high[k] - part->low[k];
    }
    return have_one_size(import) && area <= 1 - SAVED;
}

static void cut(FfpCamera *camera, const Extent *part) {
    const int left = (int)floor(part->low[0] * camera->width),
              top = (int)floor(part->low[1] * camera->height);
    camera->width = (int)ceil(part->high[0] * camera->width) - left;
    camera->height = (int)ceil(part->high[1] * camera->height) - top;
    camera->cx -= (real)left, camera->cy -= (real)top;
}

void ffp_importing_fit_object(FfpImporting *import) {
    import->limit = "";
    if (import->settings->width > 0) return;
    Extent extent = find_object(import);
    const double scale = choose_scale(import, &extent);
    const bool cuts = choose_part(import, &extent);
    for (int v = 0; v < import->capture.n_views; v++) {
        const FfpOptics *optics = &import->calibration.stops[v].camera;
        FfpCamera *camera = &import->capture.views[v].camera;
        ffp_optics_pinhole(optics, (int)lround(scale * optics->width), camera);
        if (cuts) cut(camera, &extent);
    }
}

// --- Saying so. ---

void ffp_importing_tell_size(FfpImporting *import) {
    const FfpCapture *capture = &import->capture;
    for (int v = 0; v < capture->n_views; v++) {
        Extent extent = {.low = {1, 1}};
        const FfpView *view = &capture->views[v];
        const FfpOptics here = {.width = view->camera.width, .height = view->camera.height};
        add_extent(&extent, &view->coverage, &here);
        if (extent.longest <= import->pixels[0]) continue;
        import->pixels[0] = (int)lround(extent.longest);
        import->pixels[1] =
            (int)lround(extent.longest * import->calibration.stops[v].camera.fx / (double)view->camera.fx);
    }
    ffp_note("made at %d of the %d pixels that the object's longer side has in the photographs%s%s",
             import->pixels[0], import->pixels[1], *import->limit ? ": " : "", import->limit);
}

bool ffp_importing_keep_size(const char *folder, const FfpImporting *import, FfpError *err) {
    return ffp_scene_json_add(folder, "object", "pixels",
                              json_pack("[i,i]", import->pixels[0], import->pixels[1]), err);
}
