#include "lab/eval/report.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/base64.h"
#include "core/base/file.h"
#include "core/base/text.h"
#include "engine/pipeline/maps.h"

#define PICTURE_SIDE_MAX 256 // pixels; larger pictures are averaged down so that a page stays a page
#define LARGE_SIDE_MAX 1024  // of large ones

struct FfpReport {
    FfpText *text; // grows until the page is written
    FILE *body;    // its stream
    const char *predictor;
};

FfpReport *ffp_report_new(const char *predictor) {
    FfpReport *report = ffp_alloc(1, sizeof *report);
    report->predictor = predictor;
    report->text = ffp_text_new();
    report->body = ffp_text_stream(report->text);
    return report;
}

void ffp_report_free(FfpReport *report) {
    if (!report) return;
    ffp_text_free(report->text);
    ffp_free(report);
}

// Pictures are made in memory: the encoder can only fail for lack of it.
static void put_image(FILE *out, const FfpImage *encoded, int side_max) {
    unsigned char *bytes = NULL;
    size_t size = 0;
    const int side = encoded->width > encoded->height ? encoded->width : encoded->height;
    FfpImage small = {0};
    if (side > side_max) {
        const double share = (double)side_max / side;
        const int width = (int)(encoded->width * share), height = (int)(encoded->height * share);
        small = ffp_image_resize(encoded, width > 0 ? width : 1, height > 0 ? height : 1);
    }
    if (!ffp_image_encode_png(small.data ? &small : encoded, &bytes, &size, NULL)) ffp_no_memory(0);
    fputs("<img alt=\"\" src=\"data:image/png;base64,", out);
    ffp_write_base64(out, bytes, size);
    fputs("\">", out);
    ffp_free(bytes);
    ffp_image_free(&small);
}

static void put_figure_of(FfpReport *report, const char *kind, const FfpImage *encoded, int side_max,
                          const char *caption) {
    fprintf(report->body, "<figure class=%s>", kind);
    put_image(report->body, encoded, side_max);
    fputs("<figcaption>", report->body);
    ffp_put_html(report->body, caption);
    fputs("</figcaption></figure>\n", report->body);
}

void ffp_report_picture(FfpReport *report, const FfpImage *encoded, const char *caption) {
    put_figure_of(report, "one", encoded, PICTURE_SIDE_MAX, caption);
}

void ffp_report_large(FfpReport *report, const FfpImage *encoded, const char *caption) {
    put_figure_of(report, "large", encoded, LARGE_SIDE_MAX, caption);
}

void ffp_report_heading(FfpReport *report, const char *title, const char *explanation) {
    fputs("<h3>", report->body);
    ffp_put_html(report->body, title);
    fputs("</h3>\n<p>", report->body);
    ffp_put_html(report->body, explanation);
    fputs("</p>\n", report->body);
}

static void put_input_row(FfpReport *report, const FfpCapture *capture, int pattern) {
    fputs("<div class=row>", report->body);
    FfpImage projected = ffp_image_copy(&capture->patterns[pattern].image);
    ffp_image_to_srgb(&projected);
    ffp_report_picture(report, &projected, capture->patterns[pattern].name);
    ffp_image_free(&projected);
    for (int v = 0; v < capture->n_views && v < 8; v++) {
        const FfpView *view = &capture->views[v];
        if (!view->images[pattern].data) continue;
        FfpImage picture = ffp_image_copy(&view->images[pattern]);
        ffp_image_to_srgb(&picture);
        ffp_report_picture(report, &picture, view->id);
        ffp_image_free(&picture);
    }
    fputs("</div>\n", report->body);
}

void ffp_report_title(FfpReport *report, const char *title) {
    fputs("<h2>", report->body);
    ffp_put_html(report->body, title);
    fputs("</h2>\n", report->body);
}

void ffp_report_input(FfpReport *report, const FfpCapture *capture, const int *given, int n) {
    ffp_report_heading(report, "Input",
                       n > 3 ? "Everything given to the predictor: each view under black, white and some "
                               "patterns. First, what the projector showed."
                             : "Everything given to the predictor: each view under black, white and one "
                               "pattern. First, what the projector showed.");
    for (int i = 0; i < n; i++) put_input_row(report, capture, given[i]);
}

void ffp_report_stats(FfpReport *report, const FfpReconstructionStats *stats) {
    fprintf(report->body,
            "<p>%lld Gaussians in %.2f s: filtering noise of %.2f %% of white %.2f s, projector matching and "
            "the classical estimates %.2f s, network %.2f s, polish %.2f s.</p>\n",
            (long long)stats->gaussians,
            stats->denoise_s + stats->initialisation_s + stats->network_s + stats->polish_s,
            100 * stats->noise, stats->denoise_s, stats->initialisation_s, stats->network_s, stats->polish_s);
}

void ffp_report_maps(FfpReport *report, const char *view, const FfpGbuffer *gbuffer) {
    fputs("<div class=row>", report->body);
    for (int m = 0; m < FFP_MAP_PICTURES; m++) {
        char caption[FFP_NAME_MAX + 32];
        snprintf(caption, sizeof caption, "%s, %s", view, ffp_map_name((FfpMap)m));
        FfpImage picture = ffp_map_picture(gbuffer, (FfpMap)m);
        ffp_report_picture(report, &picture, caption);
        ffp_image_free(&picture);
    }
    fputs("</div>\n", report->body);
}

void ffp_report_prediction(FfpReport *report, const char *view, const char *pattern, const FfpImage *truth,
                           const FfpImage *prediction, double psnr) {
    FfpImage error = ffp_image_copy(prediction);
    const size_t count = (size_t)error.width * error.height * error.channels;
    for (size_t i = 0; i < count; i++) error.data[i] = fmin(4 * fabs(error.data[i] - truth->data[i]), 1);
    char caption[2 * FFP_NAME_MAX + 64];
    snprintf(caption, sizeof caption, "%s, %s: %.2f dB", view, pattern, psnr);
    fputs("<figure class=three>", report->body);
    put_image(report->body, prediction, PICTURE_SIDE_MAX);
    put_image(report->body, truth, PICTURE_SIDE_MAX);
    put_image(report->body, &error, PICTURE_SIDE_MAX);
    fputs("<figcaption>", report->body);
    ffp_put_html(report->body, caption);
    fputs("</figcaption></figure>\n", report->body);
    ffp_image_free(&error);
}

static void put_figure(FILE *out, double value, int digits) {
    if (isfinite(value))
        fprintf(out, "<td>%.*f</td>", digits, value);
    else
        fputs("<td>&ndash;</td>", out);
}

static void put_scores(FILE *out, const FfpScore *scores, int n_scores) {
    fputs("<h2>Figures</h2>\n<div "
          "class=wide><table><tr><th>capture</th><th>protocol</th><th>pictures</th><th>PSNR, "
          "dB</th><th>foreground, "
          "dB</th><th>highlights, dB</th>"
          "<th>SSIM</th><th>LPIPS</th><th>reconstruct, s</th><th>render, s a "
          "picture</th></tr>\n",
          out);
    for (int i = 0; i < n_scores; i++) {
        const FfpScore *score = &scores[i];
        fputs("<tr><td>", out);
        ffp_put_html(out, score->capture);
        fprintf(out, "</td><td>%s</td><td>%d</td>", score->protocol, score->images);
        put_figure(out, score->psnr, 2);
        put_figure(out, score->psnr_foreground, 2);
        put_figure(out, score->psnr_gloss, 2);
        put_figure(out, score->ssim, 4);
        put_figure(out, score->lpips, 4);
        put_figure(out, score->reconstruct_s, 2);
        put_figure(out, score->render_s / score->images, 3);
        fputs("</tr>\n", out);
    }
    fputs(
        "</table></div>\n<p>PSNR over all pixels and channels of sRGB-encoded pictures over black, averaged "
        "over pictures; foreground: "
        "only the pixels that the object covers; highlights: under white, only those whose true specular "
        "part is above 0.05. novel_pattern: held-out patterns at the input poses; novel_pose: new camera and "
        "projector poses; rendering: black, white and lollipops at the input poses; unseen: those of them "
        "that the predictor was not given; given: those that it was.</p>\n",
        out);
}

// Flexible from wide windows down to phones: large pictures fill the width, small ones go several to a row,
// wide tables scroll by themselves.
static const char style[] =
    "*{box-sizing:border-box}body{font:15px/1.45 system-ui,sans-serif;max-width:1500px;margin:1em auto;"
    "padding:0 1em;color:#222;background:#fff}h1{margin:.5em 0}h2{border-bottom:1px solid "
    "#bbb;margin-top:1.5em}"
    "figure{display:inline-block;margin:0 6px 6px 0;vertical-align:top}"
    "figcaption{font-size:12px;color:#555;overflow-wrap:anywhere}"
    "img{width:100%;image-rendering:pixelated;background:#000;vertical-align:top}"
    "figure.large{width:calc(33.3% - 12px)}figure.large img{image-rendering:auto}"
    ".row{display:grid;grid-template-columns:repeat(9,1fr)}figure.one{width:calc(11.1% - 12px)}"
    ".row figure.one{width:auto}figure.three{width:calc(33.3% - 12px)}figure.three img{width:33.3%}"
    ".wide{overflow-x:auto}table{border-collapse:collapse}"
    "td,th{border-bottom:1px solid #ddd;padding:3px 10px;text-align:right}td:first-child,th:first-child,"
    "td:nth-child(2),th:nth-child(2){text-align:left}"
    "@media(max-width:900px){figure.large,figure.three{width:calc(50% - 8px)}figure.one{width:calc(20% - "
    "7px)}"
    ".row{grid-template-columns:repeat(5,1fr)}}"
    "@media(max-width:600px){body{padding:0 .5em}figure.large{width:calc(50% - 8px)}"
    "figure.three{width:100%;margin-right:0}"
    "figure.one{flex:0 0 30%}.row{display:flex;overflow-x:auto}}" FFP_REPORT_DARK;

bool ffp_report_write(FfpReport *report, const FfpScore *scores, int n_scores, const char *viewer,
                      const char *path, FfpError *err) {
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) return false;
    fputs("<!DOCTYPE html>\n<html lang=en><meta charset=utf-8><meta name=viewport "
          "content=\"width=device-width,initial-scale=1\"><title>Relit captures</title>\n<style>",
          out.stream);
    fputs(style, out.stream);
    fputs("</style>\n<h1>Relit captures</h1>\n", out.stream);
    if (viewer) {
        fputs("<p><a href=\"", out.stream);
        ffp_put_html(out.stream, viewer);
        fputs("\">See it live: move the projector, drop in a picture</a></p>\n", out.stream);
    }
    size_t size;
    const char *text = ffp_text_so_far(report->text, &size);
    fwrite(text, 1, size, out.stream);
    if (n_scores > 0) put_scores(out.stream, scores, n_scores);
    fputs("<p>Predicted by: ", out.stream);
    ffp_put_html(out.stream, report->predictor);
    fputs(".</p>\n</html>\n", out.stream);
    return ffp_output_commit(&out, err);
}
