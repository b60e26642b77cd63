// How much nearer a compensated projection brings what a camera sees to its target.
//   compensate_report [-m WEIGHTS] -t TARGET.. [-v VIEWS] [-p] [-o REPORT.html] CAPTURE..
// -m: weights of the reconstruction (default: the classical initialisation alone). -t: target images. -v: how
// many views of a capture (default 2). -p: all projectors at once, where several
// views have the same camera and each another projector. Patterns are computed from the reconstruction alone.
// The judge knows nothing of it: it looks the pattern up at the capture's true depth, black + (white - black)
// * pattern, with the photographs' black and white. PSNR is over the object's pixels that the projector
// lights in the photographs, of encoded 8-bit pictures. The light of several projectors adds up. The unwarped
// projection has the brightness that suits it best.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include <unistd.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "engine/apply/solve.h"
#include "engine/loss/metrics.h"
#include "engine/match/match.h"
#include "engine/pipeline/normalised.h"
#include "engine/pipeline/relight.h"
#include "lab/eval/report.h"

#define TARGETS_MAX 16
#define PROJECTORS_MAX 4
#define STEPS 30        // of descent
#define BRIGHTNESSES 24 // tried for the unwarped projection, each 0.8 times the one before

typedef struct Figures {
    double unwarped, closed, descended, cases;
} Figures;

typedef struct Bench {
    const char *targets[TARGETS_MAX];
    int n_targets, views;
    bool together; // all projectors at once
    FfpModel *model;
    FfpReport *report;
    FfpRenderSettings settings;
    // of the capture at hand
    FfpCapture *capture;
    FfpCapture normalised;
    FfpGaussians *gaussians;
} Bench;

// Views of one camera, each lit by another projector.
typedef struct Place {
    int count, view[PROJECTORS_MAX];
} Place;

static Place place_of(const Bench *bench, int view) {
    Place place = {1, {view}};
    const FfpView *views = bench->capture->views;
    for (int v = 0; bench->together && v < bench->capture->n_views && place.count < PROJECTORS_MAX; v++)
        if (v != view && ffp_same_device(&views[v].camera, &views[view].camera))
            place.view[place.count++] = v;
    return place;
}

// The camera's picture under one projector's pattern, encoded.
static FfpImage judge_one(const Bench *bench, int view, const FfpImage *pattern) {
    FfpCapture seen = bench->normalised;
    FfpPattern ours = {.image = *pattern};
    FfpView *own = &seen.views[view];
    FfpPattern *patterns = ffp_alloc((size_t)seen.n_patterns + 1, sizeof *patterns);
    memcpy(patterns, seen.patterns, (size_t)seen.n_patterns * sizeof *patterns);
    patterns[seen.n_patterns] = ours;
    seen.patterns = patterns;
    FfpImage picture = ffp_predict_by_lookup(&seen, view, seen.n_patterns, own->depth.data);
    ffp_free(patterns);
    return picture;
}

// The camera's picture under the projectors' patterns [place->count].
static FfpImage judge(const Bench *bench, const Place *place, const FfpImage *patterns) {
    FfpImage picture = judge_one(bench, place->view[0], &patterns[0]);
    for (int k = 1; k < place->count; k++) {
        const real *black = bench->capture->views[place->view[k]].images[bench->capture->black].data;
        FfpImage more = judge_one(bench, place->view[k], &patterns[k]);
        for (int i = 0; i < 3 * more.width * more.height; i++)
            picture.data[i] =
                ffp_srgb_encode(ffp_srgb_decode(picture.data[i]) + ffp_srgb_decode(more.data[i]) - black[i]);
        ffp_image_free(&more);
    }
    ffp_quantise(&picture);
    return picture;
}

static FfpImage photographed_light(const Bench *bench, const Place *place) {
    const FfpCamera *camera = &bench->capture->views[place->view[0]].camera;
    FfpImage lit = ffp_image_new(camera->width, camera->height, 1);
    for (int k = 0; k < place->count; k++) {
        const FfpView *v = &bench->capture->views[place->view[k]];
        const real *black = v->images[bench->capture->black].data,
                   *white = v->images[bench->capture->white].data;
        for (int i = 0; i < 3 * lit.width * lit.height; i++)
            if (v->coverage.data[i / 3] > 0.5F &&
                ffp_srgb_encode(white[i]) - ffp_srgb_encode(black[i]) >= 2.0F / 255)
                lit.data[i / 3] = 1;
    }
    return lit;
}

static double judged_psnr(const Bench *bench, const Place *place, const FfpImage *patterns,
                          const FfpImage *target, FfpImage *picture) {
    FfpImage seen = judge(bench, place, patterns), lit = photographed_light(bench, place);
    const double psnr = ffp_psnr_masked(&seen, target, &lit);
    ffp_image_free(&lit);
    if (picture)
        *picture = seen;
    else
        ffp_image_free(&seen);
    return psnr;
}

// The target itself as every projector's pattern, as bright as is best.
static double unwarped_psnr(const Bench *bench, const Place *place, const FfpImage *image,
                            const FfpImage *target, FfpImage *picture) {
    FfpImage pattern[PROJECTORS_MAX];
    real brightness = 1, best = 1;
    double most = -INFINITY;
    for (int trial = 0; trial <= BRIGHTNESSES; trial++) {
        if (trial == BRIGHTNESSES) brightness = best;
        for (int k = 0; k < place->count; k++) {
            const FfpCamera *projector = &bench->capture->views[place->view[k]].projector;
            pattern[k] = ffp_image_resize(image, projector->width, projector->height);
            for (int i = 0; i < 3 * pattern[k].width * pattern[k].height; i++)
                pattern[k].data[i] *= brightness;
        }
        const double psnr =
            judged_psnr(bench, place, pattern, target, trial == BRIGHTNESSES ? picture : NULL);
        for (int k = 0; k < place->count; k++) ffp_image_free(&pattern[k]);
        if (psnr > most) {
            most = psnr;
            best = brightness;
        }
        brightness *= 0.8F;
    }
    return most;
}

// The target as the judge means it: painted between the photographs under black and white.
static FfpImage encoded_target(const Bench *bench, const Place *place, const FfpImage *fitted) {
    const int black = bench->capture->black, white = bench->capture->white;
    FfpImage target = ffp_image_copy(fitted);
    for (int i = 0; i < 3 * target.width * target.height; i++) {
        const FfpView *first = &bench->capture->views[place->view[0]];
        real light = 0;
        for (int k = 0; k < place->count; k++) {
            const FfpView *v = &bench->capture->views[place->view[k]];
            light += v->images[white].data[i] - v->images[black].data[i];
        }
        target.data[i] = first->images[black].data[i] + light * target.data[i];
    }
    ffp_image_to_srgb(&target);
    return target;
}

static void show(const Bench *bench, const FfpView *view, const char *what, double psnr,
                 const FfpImage *encoded) {
    char caption[256];
    snprintf(caption, sizeof caption, "%s: %s %.2f dB", view->id, what, psnr);
    if (isnan(psnr)) snprintf(caption, sizeof caption, "%s: %s", view->id, what);
    if (bench->report) ffp_report_picture(bench->report, encoded, caption);
}

static void show_pattern(const Bench *bench, const FfpView *view, const FfpImage *pattern) {
    FfpImage encoded = ffp_image_copy(pattern);
    ffp_image_to_srgb(&encoded);
    show(bench, view, "the pattern", NAN, &encoded);
    ffp_image_free(&encoded);
}

static double judged(const Bench *bench, const Place *place, const FfpProCams *procams,
                     const FfpImage *target, const char *what) {
    FfpImage picture, patterns[PROJECTORS_MAX];
    for (int k = 0; k < place->count; k++) {
        patterns[k] = ffp_image_copy(&procams->projections[k].pattern);
        ffp_image_to_srgb(&patterns[k]);
        ffp_quantise(&patterns[k]);
        for (int i = 0; i < 3 * patterns[k].width * patterns[k].height; i++)
            patterns[k].data[i] = ffp_srgb_decode(patterns[k].data[i]);
    }
    const double psnr = judged_psnr(bench, place, patterns, target, &picture);
    show(bench, &bench->capture->views[place->view[0]], what, psnr, &picture);
    ffp_image_free(&picture);
    for (int k = 0; k < place->count; k++) ffp_image_free(&patterns[k]);
    return psnr;
}

static void run_case(const Bench *bench, int v, const FfpImage *image, Figures *sum) {
    const FfpView *view = &bench->capture->views[v], *views[PROJECTORS_MAX];
    const Place place = place_of(bench, v);
    for (int k = 0; k < place.count; k++) views[k] = &bench->capture->views[place.view[k]];
    FfpProCams procams =
        ffp_procams_new(bench->gaussians, bench->capture, views, place.count, &bench->settings, true);
    FfpImage fitted = ffp_image_resize(image, view->camera.width, view->camera.height);
    for (int c = 0; c < procams.n_camera_views; c++) ffp_procams_aim(&procams, c, &fitted, NULL);
    ffp_procams_paint(&procams);
    FfpImage target = encoded_target(bench, &place, &fitted), picture;
    show(bench, view, "target", NAN, &target);
    const double unwarped = unwarped_psnr(bench, &place, image, &target, &picture);
    show(bench, view, "unwarped", unwarped, &picture);
    ffp_image_free(&picture);
    const FfpGamut gamut = ffp_procams_gamut(&procams);
    ffp_procams_closed_form(&procams, 1);
    const double own_closed = ffp_procams_psnr(&procams);
    const double closed_psnr = judged(bench, &place, &procams, &target, "closed form");
    const double started = ffp_seconds();
    ffp_procams_descend(&procams, STEPS);
    const double ended = ffp_seconds(), descended = judged(bench, &place, &procams, &target, "descended");
    for (int k = 0; k < place.count; k++) show_pattern(bench, views[k], &procams.projections[k].pattern);
    printf("%-8s %-18s %6.2f %6.2f %6.2f | predicted %6.2f %6.2f | unlit %.1f dark %.1f bright "
           "%.1f %% | %.1f s\n",
           bench->capture->name, view->id, unwarped, closed_psnr, descended, own_closed,
           ffp_procams_psnr(&procams), 100 * gamut.unlit, 100 * gamut.too_dark, 100 * gamut.too_bright,
           ended - started);
    fflush(stdout);
    sum->unwarped += unwarped;
    sum->closed += closed_psnr;
    sum->descended += descended;
    sum->cases++;
    ffp_image_free(&target);
    ffp_image_free(&fitted);
    ffp_procams_free(&procams);
}

static void add_row(const char *name, const Figures *f) {
    printf("%-27s %6.2f %6.2f %6.2f   over unwarped %+.2f, over closed form %+.2f dB\n", name,
           f->unwarped / f->cases, f->closed / f->cases, f->descended / f->cases,
           (f->descended - f->unwarped) / f->cases, (f->descended - f->closed) / f->cases);
}

static void add_figures(Figures *sum, const Figures *f) {
    sum->unwarped += f->unwarped;
    sum->closed += f->closed;
    sum->descended += f->descended;
    sum->cases += f->cases;
}

static bool run_target(const Bench *bench, const char *path, Figures *sum, FfpError *err) {
    FfpImage image;
    if (!ffp_image_read_over_black(&image, NULL, path, err)) return false;
    if (bench->report) ffp_report_heading(bench->report, bench->capture->name, path);
    const int n = bench->capture->n_views, views = bench->views < n ? bench->views : n;
    for (int v = 0; v < views; v++) run_case(bench, v * n / views, &image, sum);
    ffp_image_free(&image);
    return true;
}

static bool has_depth(const FfpCapture *capture, FfpError *err) {
    for (int v = 0; v < capture->n_views; v++)
        if (!capture->views[v].depth.data)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->folder, "view %s has no true depth to judge by",
                            capture->views[v].id);
    return true;
}

static bool run_capture(Bench *bench, const char *path, Figures *sum, FfpError *err) {
    const FfpReconstruction how = {.size = sizeof how,
                                   .model = bench->model,
                                   .polish = FFP_POLISH_STEPS,
                                   .noise = FFP_NOISE_ESTIMATED,
                                   .layers = FFP_LAYERS_AUTO};
    Figures own = {0};
    bench->capture = ffp_capture_open(NULL, path, NULL, err);
    bool ok = bench->capture && has_depth(bench->capture, err);
    bench->gaussians = ok ? ffp_reconstruct(NULL, bench->capture, &how, NULL, err) : NULL;
    if (bench->gaussians) {
        bench->normalised = ffp_normalised_alias(bench->capture);
        for (int t = 0; ok && t < bench->n_targets; t++) ok = run_target(bench, bench->targets[t], &own, err);
        if (ok) add_row(bench->capture->name, &own);
        add_figures(sum, &own);
        ffp_normalised_alias_free(&bench->normalised);
    }
    ok = ok && bench->gaussians;
    ffp_gaussians_close(bench->gaussians);
    ffp_capture_close(bench->capture);
    return ok;
}

static int fail(const FfpError *err) {
    fprintf(stderr, "compensate_report: error: %s\n", err->text);
    return 1;
}

int main(int argc, char **argv) {
    Bench bench = {.views = 2, .settings = ffp_render_defaults()};
    const char *weights = NULL, *page = NULL;
    Figures all = {0};
    FfpError err = {0};
    for (int option; (option = getopt(argc, argv, "m:t:v:po:")) != -1;) {
        if (option == '?') return 2;
        if (option == 'm') weights = optarg;
        if (option == 't' && bench.n_targets < TARGETS_MAX) bench.targets[bench.n_targets++] = optarg;
        if (option == 'v') bench.views = atoi(optarg);
        if (option == 'p') bench.together = true;
        if (option == 'o') page = optarg;
    }
    if (optind == argc || !bench.n_targets || bench.views < 1) {
        fprintf(
            stderr,
            "usage: compensate_report [-m WEIGHTS] -t TARGET.. [-v VIEWS] [-p] [-o REPORT.html] CAPTURE..\n");
        return 2;
    }
    if (weights && !(bench.model = ffp_model_open(NULL, weights, NULL, &err))) return fail(&err);
    if (page) bench.report = ffp_report_new("compensated projections");
    bool ok = true;
    printf("%-27s %6s %6s %6s\n", "PSNR, dB, judged", "unwarp", "closed", "desc.");
    for (int i = optind; ok && i < argc; i++) ok = run_capture(&bench, argv[i], &all, &err);
    if (ok) add_row("mean", &all);
    if (ok && page) ok = ffp_report_write(bench.report, NULL, 0, NULL, page, &err);
    ffp_report_free(bench.report);
    ffp_model_close(bench.model);
    return ok ? 0 : fail(&err);
}
