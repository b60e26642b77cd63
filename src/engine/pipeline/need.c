#include "engine/pipeline/need.h"
#include <math.h>
#include <omp.h>
#include "engine/match/match.h"
#include "engine/match/reduce.h"
#include "engine/pipeline/relight.h"
#include "engine/refine/pyramid.h"
#include "engine/render/strip.h"

#define GIGA 1e9
#define ROOM 1.15 // for what the allocator and the threads take besides
#define REAL ((double)sizeof(real))
#define SPLAT (18 * REAL) // of a set of Gaussians
#define DRAWN 162.0       // of a splat in a view: as projected, and 1.7 pairs with tiles, a quarter roomier
#define MAPPED 16.0       // of a camera's pixel, for its map and the depths of lit pixels
#define STAGED 130.0      // of a camera's pixel, for compensation
#define SEEN 150.0        // of a projector's pixel, for maps of it
#define PROJECTED 90.0    // of a projector's pixel, for compensation
#define LOOK (23 * REAL)  // of a pixel: what a look compares (engine/network/look_formula.h)
#define PICTURE 28.0      // of a picture's pixel: linear and encoded, and as the file has it,
#define IN_STRIPS 3.0     // or, drawn in strips, only that
#define SUMMED 24.0       // of a pattern's pixel, with a margin
#define PULLED 155.0      // of a splat's gradients in its tiles

static double pixels_of(const FfpProblemSize *s) {
    return (double)s->views * s->width * s->height;
}

static double splats_of(const FfpProblemSize *s) {
    return s->share * pixels_of(s);
}

// All views' photographs.
static double photograph_bytes(const FfpProblemSize *s) {
    return 3 * s->photographs * REAL * pixels_of(s);
}

// Photographs as a list of nine values a pixel, of the view in work, and its samples for the estimate.
static double denoise_bytes(const FfpProblemSize *s) {
    return 9 * REAL * pixels_of(s) / s->views + 1.1e6 * (9 * REAL + 2);
}

// Of pixels' photographs, those under patterns beyond the first.
static double more_bytes(const FfpProblemSize *s, double pixels) {
    return 3 * (s->photographs - 3) * REAL * pixels;
}

// Everything that matching keeps about its own pixels, and the costs of the views in work.
static double match_bytes(const FfpProblemSize *s, double pixels) {
    const FfpMatchSettings settings = ffp_match_defaults();
    const int at_a_time = s->threads < s->views ? s->threads : s->views;
    const double cells = s->share * pixels / s->views * settings.coarse_steps;
    return 36 * REAL * pixels + at_a_time * (cells * (2 * REAL + 1) + more_bytes(s, pixels / s->views));
}

// The start's maps are 16 numbers a pixel. Beside them: depths, and the observation of the views in work.
static double start_bytes(const FfpProblemSize *s, double *besides) {
    const double pixels = pixels_of(s), maps = 16 * REAL * pixels;
    const int factor = ffp_reduction_of(splats_of(s) / s->views);
    const int at_a_time = s->threads < s->views ? s->threads : s->views;
    if (factor == 1) {
        *besides = match_bytes(s, pixels) - maps;
        return maps;
    }
    const double small = pixels / factor / factor, kept = 26 * REAL * small + more_bytes(s, small);
    const double full = (1 + 3) * REAL * pixels +
                        at_a_time * (10 * REAL * pixels / s->views + more_bytes(s, pixels / s->views));
    *besides = fmax(match_bytes(s, small) - maps, full);
    return maps + kept;
}

double ffp_drawing_bytes(double splats, double pixels, int samples) {
    return DRAWN * splats + 25 * REAL * pixels * samples * samples;
}

double ffp_pictures_bytes(double splats, const FfpCamera *camera, int samples, int rows, int margin,
                          int pictures) {
    const double width = camera->width, drawn = fmin(rows + 2 * margin, camera->height) * width;
    const double smoothed = margin > 0 ? 4 * REAL * drawn : 0; // ffp_resolve_smoothly
    const double kept = rows < camera->height ? IN_STRIPS : PICTURE;
    return kept * width * camera->height * pictures + ffp_drawing_bytes(splats, drawn, samples) + smoothed;
}

// Of a strip, and of what is kept of its pixels while it is drawn.
static double strip_bytes(double splats, const FfpCamera *camera, int samples, double kept) {
    const double pixels = (double)(ffp_strip_rows(camera) + 1) * camera->width;
    return ffp_drawing_bytes(splats, pixels, samples) + kept * pixels;
}

double ffp_warps_bytes(double splats, const FfpView *view, int samples) {
    const double camera = (double)view->camera.width * view->camera.height,
                 projector = (double)view->projector.width * view->projector.height;
    return strip_bytes(splats, &view->camera, samples, STAGED) + MAPPED * camera + SEEN * projector;
}

double ffp_compensation_bytes(double splats, const FfpView *const *views, int n_views, int samples) {
    double strip = 0, kept = 0;
    for (int v = 0; v < n_views; v++) {
        strip = fmax(strip, strip_bytes(splats, &views[v]->camera, samples, 0));
        kept += STAGED * views[v]->camera.width * views[v]->camera.height +
                PROJECTED * views[v]->projector.width * views[v]->projector.height;
    }
    return strip + kept;
}

static double draw_bytes(const FfpProblemSize *s, int samples) {
    return ffp_drawing_bytes(splats_of(s), pixels_of(s) / s->views, samples);
}

// Of the context: inputs, activations of the blocks, features of its pixels, and where it is a capture of its
// own, that and its matching. Of the splats: what the heads start from, raw numbers, result and its copy.
// A look, where no fit follows, takes photographs and errors of all views, and the splats again. Then both
// predictions are drawn.
static double network_bytes(const FfpProblemSize *s) {
    const FfpModelConfig *c = s->network;
    if (!c) return 0;
    const double patch = (double)c->patch * c->patch, own = pixels_of(s) / patch;
    const double tokens = fmin(own, ffp_pixel_context_tokens(c, s->views));
    const double inputs = patch * ((c->match_input ? 30 : 15) + c->pixel_features);
    const double blocks = 36.0 * c->dim; // all blocks of a kind work in the same memory
    const double context = own > tokens ? match_bytes(s, tokens * patch) + more_bytes(s, tokens * patch) : 0;
    const double looks =
        c->looks && !s->polish ? LOOK * pixels_of(s) + draw_bytes(s, c->samples) + SPLAT * splats_of(s) : 0;
    const double forward =
        REAL * tokens * (inputs + blocks) + context + (4 * SPLAT + 6 * REAL) * splats_of(s) + looks;
    return fmax(forward, SPLAT * splats_of(s) + photograph_bytes(s) + draw_bytes(s, 1) +
                             SUMMED * s->photographs * s->pattern);
}

// Parameters, their mean, two gradients, moments and copies of the splats, encoded photographs, and a view
// with its gradients or two of them; of a large picture the photographs of a level, and the splats as they
// were.
static double polish_bytes(const FfpProblemSize *s) {
    if (!s->polish) return 0;
    const double gradients = 30 * REAL * pixels_of(s) / s->views * s->samples * s->samples; // of samples
    const bool pairs =
        (double)s->width * s->height <= FFP_AT_ONCE_PIXELS && (s->threads == 2 || s->threads == 3);
    const double view = gradients + draw_bytes(s, s->samples) + PULLED * splats_of(s);
    const bool levels = fmax(s->width, s->height) > FFP_PYRAMID_SIDE;
    const double level = levels ? photograph_bytes(s) + REAL * pixels_of(s) + SPLAT * splats_of(s) : 0;
    return (10 * SPLAT + 11 * REAL) * splats_of(s) + photograph_bytes(s) + (pairs ? 2 : 1) * view + level +
           SUMMED * s->photographs * s->pattern;
}

double ffp_reconstruction_bytes(const FfpProblemSize *s) {
    const double photographs = s->denoise ? photograph_bytes(s) : 0, splats = SPLAT * splats_of(s);
    double matching;
    const double start = start_bytes(s, &matching);
    const double network = splats + network_bytes(s), polish = splats + polish_bytes(s);
    const double most = fmax(s->denoise ? denoise_bytes(s) : 0, start + fmax(matching, network));
    return ROOM * (photographs + fmax(most, s->scene ? start + polish : polish)); // which needs no start else
}

FfpProblemSize ffp_problem_size(const FfpCapture *capture, const FfpReconstruction *options) {
    const FfpRenderSettings drawing = ffp_drawing_settings(options->drawing, options->model);
    FfpProblemSize s = {.views = capture->n_views,
                        .photographs = 2 + (options->n_patterns > 1 ? options->n_patterns : 1),
                        .scene = capture->scene,
                        .denoise = options->noise != 0,
                        .polish = options->polish != 0,
                        .pattern =
                            (double)capture->views[0].projector.width * capture->views[0].projector.height,
                        .samples = drawing.samples,
                        .threads = omp_get_max_threads(),
                        .network = options->model ? &options->model->config : NULL};
    double shown = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpImage *coverage = &capture->views[v].coverage;
        const size_t pixels = (size_t)coverage->width * (size_t)coverage->height;
        s.width = coverage->width > s.width ? coverage->width : s.width;
        s.height = coverage->height > s.height ? coverage->height : s.height;
        for (size_t i = 0; i < pixels; i++) shown += coverage->data[i] > 0;
    }
    s.share = shown / pixels_of(&s);
    return s;
}

// The largest share of the scale's sides, in steps of a sixteenth, that fits; 0: none.
static double fitting_share(const FfpProblemSize *scale, double available) {
    for (int n = 15; n > 0; n--) {
        FfpProblemSize s = *scale;
        s.width = scale->width * n / 16;
        s.height = scale->height * n / 16;
        if (s.width > 0 && s.height > 0 && ffp_reconstruction_bytes(&s) <= available) return n / 16.0;
    }
    return 0;
}

bool ffp_check_memory(const FfpCapture *capture, const FfpReconstruction *options, double available,
                      FfpError *err) {
    const FfpProblemSize s = ffp_problem_size(capture, options);
    const double need = ffp_reconstruction_bytes(&s);
    if (available < 0 || need <= available) return true;
    const double share = fitting_share(&s, available);
    if (share > 0)
        return ffp_fail(
            err, FFP_ERROR_MEMORY, capture->folder,
            "%d views of %d x %d pixels need %.1f GB of memory, but only %.1f GB are free: a resolution "
            "of %d x %d would fit",
            s.views, s.width, s.height, need / GIGA, available / GIGA, (int)(share * s.width),
            (int)(share * s.height));
    return ffp_fail(
        err, FFP_ERROR_MEMORY, capture->folder,
        "%d views of %d x %d pixels need %.1f GB of memory, but only %.1f GB are free: give fewer views",
        s.views, s.width, s.height, need / GIGA, available / GIGA);
}
