// The page of `info --report`.
#include <string.h>
#include "core/base/base64.h"
#include "core/base/file.h"
#include "core/base/kind.h"
#include "core/base/text.h"
#include "product/describe/print.h"
#include "rig/checks/checks.h"
#include "rig/checks/measure.h"
#include "rig/masks/masks.h"

static const char style[] =
    "*{box-sizing:border-box}body{font:15px/1.45 system-ui,sans-serif;max-width:1300px;margin:1em auto;"
    "padding:0 1em;color:#222;background:#fff}h2{border-bottom:1px solid #bbb;margin-top:1.5em}"
    "pre{overflow-x:auto;font-size:13px}img{max-width:100%;background:#000}"
    "figure{display:inline-block;width:250px;margin:0 6px 12px 0;vertical-align:top}"
    "figcaption{font-size:13px;color:#555;overflow-wrap:anywhere}.look{color:#b40;font-weight:"
    "bold}" FFP_REPORT_DARK;

static bool put_image(FILE *out, const FfpImage *encoded, const char *text, FfpError *err) {
    unsigned char *bytes;
    size_t size;
    if (!ffp_image_encode_png(encoded, &bytes, &size, err)) return false;
    fputs("<img alt=\"", out);
    ffp_put_html(out, text);
    fputs("\" src=\"data:image/png;base64,", out);
    ffp_write_base64(out, bytes, size);
    fputs("\">", out);
    ffp_free(bytes);
    return true;
}

static void put_checks(FILE *out, const FfpLooked *looked) {
    FfpText *text = ffp_text_new();
    FfpFindings found = {0};
    ffp_print_capture(ffp_text_stream(text), looked, &found);
    ffp_findings_free(&found);
    char *said = ffp_text_end(text);
    fputs("<pre>", out);
    ffp_put_html(out, said);
    fputs("</pre>\n", out);
    ffp_free(said);
}

// The sheet shows the photographs themselves, of which the capture has only the object; captures of other
// programs have none.
static bool put_sheet(FILE *out, const FfpCapture *capture, FfpError *err) {
    char path[FFP_PATH_MAX];
    FfpImage sheet = {0};
    if (!ffp_join_path(path, capture->folder, "masks.png") || ffp_file_kind(path) != FFP_KIND_IMAGE)
        return true;
    if (!ffp_image_read(&sheet, path, FFP_COLOUR_ENCODED, err)) return false;
    fputs(
        "<h2>Masks on the photographs</h2><p>The views in their order, row by row. Dark and blue is what is "
        "left out.</p>\n",
        out);
    const bool ok = put_image(out, &sheet, "contact sheet of the masks", err);
    ffp_image_free(&sheet);
    return ok;
}

// --- The views. ---

static double covered_share(const FfpView *view) {
    const ptrdiff_t pixels = (ptrdiff_t)view->camera.width * view->camera.height;
    double covered = 0;
    for (ptrdiff_t i = 0; i < pixels; i++) covered += (double)view->coverage.data[i];
    return covered / ((double)ffp_frame_width(view) * ffp_frame_height(view));
}

typedef struct Doubts {
    FfpSilhouettes shapes; // of a whole scene: {0}
    int light;             // a view, -1: none
} Doubts;

static Doubts find_doubts(const FfpCapture *capture) {
    const int active = ffp_capture_active_pattern(capture, NULL, NULL);
    return (Doubts){
        capture->scene ? (FfpSilhouettes){.odd = -1} : ffp_rig_silhouettes(capture),
        active >= 0 ? ffp_rig_explain(capture, active).odd : -1,
    };
}

static bool put_view(FILE *out, const FfpCapture *capture, int v, const Doubts *doubts, FfpError *err) {
    const FfpView *view = &capture->views[v];
    FfpImage thumb = ffp_contact_thumb(&view->images[capture->white]);
    FfpImage picture = ffp_contact_picture(&thumb, &view->coverage);
    const double misfit = doubts->shapes.own ? doubts->shapes.own[v] : 0;
    const bool look =
        misfit >= ffp_rule(FFP_RULE_SILHOUETTES)->limit || v == doubts->shapes.odd || v == doubts->light;
    fputs("<figure>", out);
    const bool ok = put_image(out, &picture, view->id, err);
    fprintf(out, "<figcaption>%s", look ? "<span class=look>LOOK</span> " : "");
    ffp_put_html(out, view->id);
    fprintf(out, ": %.1f %% of the picture", 100 * covered_share(view));
    if (misfit > 0) fprintf(out, "; %.1f %% of it contradicts the other views", 100 * misfit);
    if (v == doubts->shapes.odd) fputs("; without it the others agree", out);
    if (v == doubts->light) fputs("; the pattern fits it worse than the others", out);
    fputs("</figcaption></figure>\n", out);
    ffp_image_free(&thumb);
    ffp_image_free(&picture);
    return ok;
}

// --- How depth is known. ---

static FfpImage tint_of(const FfpCapture *capture, const FfpView *view, double least) {
    static const real colours[FFP_TOLD_KINDS][3] = {
        [FFP_TOLD] = {0.1F, 0.5F, 1}, [FFP_TOLD_REFUSED] = {1, 0.85F, 0}, [FFP_TOLD_UNLIT] = {0.9F, 0, 0.1F}};
    FfpImage tint = ffp_image_new(view->camera.width, view->camera.height, 3);
    const size_t pixels = (size_t)view->camera.width * (size_t)view->camera.height;
    for (size_t i = 0; i < pixels; i++)
        if (!(view->coverage.data[i] < 0.5F))
            memcpy(tint.data + 3 * i, colours[ffp_rig_told(capture, view, i, least)], sizeof *colours);
    return tint;
}

static bool put_told_view(FILE *out, const FfpCapture *capture, int v, const FfpObjectLight *light,
                          FfpError *err) {
    const FfpView *view = &capture->views[v];
    FfpImage thumb = ffp_contact_thumb(&view->images[capture->white]);
    FfpImage tint = tint_of(capture, view, light->least);
    FfpImage picture = ffp_contact_tinted(&thumb, &tint);
    fputs("<figure>", out);
    const bool ok = put_image(out, &picture, view->id, err);
    fputs("<figcaption>", out);
    ffp_put_html(out, view->id);
    fprintf(out, ": %.1f %% told by no pattern</figcaption></figure>\n",
            light->object > 0 ? 100 * light->guessed / light->object : 0);
    ffp_image_free(&thumb);
    ffp_image_free(&tint);
    ffp_image_free(&picture);
    return ok;
}

static bool put_told(FILE *out, const FfpCapture *capture, FfpError *err) {
    FfpLights lights = ffp_rig_lights(capture, false);
    bool ok = true;
    fputs("<h2>How depth is known</h2><p><span style=color:#1a80ff>&#9632;</span> Blue: by a pattern of this "
          "view. <span style=color:#ffd900>&#9632;</span> Yellow: the projector lights the place, but its "
          "Gray codes give no position, as on mirrors. <span style=color:#e6001a>&#9632;</span> Red: the "
          "projector does not reach it. Yellow and red are guesses unless another view gives them.</p>\n",
          out);
    for (int v = 0; v < capture->n_views && ok; v++)
        ok = put_told_view(out, capture, v, &lights.views[v], err);
    ffp_rig_lights_free(&lights);
    return ok;
}

static bool put_page(FILE *out, const FfpLooked *looked, FfpError *err) {
    const FfpCapture *capture = &looked->seen;
    fputs("<!DOCTYPE html>\n<html lang=en><meta charset=utf-8><meta name=viewport "
          "content=\"width=device-width,initial-scale=1\"><title>",
          out);
    ffp_put_html(out, capture->name);
    fprintf(out, "</title>\n<style>%s</style>\n<h1>", style);
    ffp_put_html(out, capture->name);
    fputs("</h1>\n", out);
    put_checks(out, looked);
    if (!put_sheet(out, capture, err)) return false;
    fputs("<h2>Views</h2><p>What is reconstructed, under white; a red line goes round each mask.</p>\n", out);
    Doubts doubts = find_doubts(capture);
    bool ok = true;
    for (int v = 0; v < capture->n_views && ok; v++) ok = put_view(out, capture, v, &doubts, err);
    ok = ok && put_told(out, capture, err);
    fputs("</html>\n", out);
    ffp_rig_silhouettes_free(&doubts.shapes);
    return ok;
}

bool ffp_describe_report(const char *path, const char *html, FfpError *err) {
    const FfpKind kind = ffp_file_kind(path);
    FfpLooked looked;
    FfpOutput out;
    if (kind == FFP_KIND_PLY || kind == FFP_KIND_WEIGHTS || kind == FFP_KIND_FIELD)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path, "only captures have a report");
    if (!ffp_looked_open(&looked, path, FFP_LOOKED_VALUES, err)) return false;
    bool ok = ffp_output_open(&out, html, err);
    if (ok && !put_page(out.stream, &looked, err)) {
        ffp_output_abort(&out);
        ok = false;
    }
    ffp_looked_free(&looked);
    return ok && ffp_output_commit(&out, err);
}
