// The page that shows what a calibration was made of and how good it is.
#include <math.h>
#include <stdio.h>
#include "core/base/alloc.h"
#include "core/base/base64.h"
#include "core/base/file.h"
#include "core/base/rigid.h"
#include "core/base/text.h"
#include "rig/calibrate/calibrate.h"
#include "rig/chessboard/terms.h"

enum { CELLS_X = 16, CELLS_Y = 12 };
#define ARROW 0.025 // of a picture's longer side: what a typical error is drawn as

static const char *const device_names[2] = {"camera", "projector"};
static const char *const state_names[FFP_CORNER_STATES] = {"used", "not decoded", "codes uneven",
                                                           "far from the fit"};
static const char *const state_colours[FFP_CORNER_STATES] = {"#0c4", "#28f", "#f80", "#f22"};

static const char style[] =
    "*{box-sizing:border-box}body{font:15px/1.45 system-ui,sans-serif;max-width:1300px;margin:1em auto;"
    "padding:0 1em;color:#222;background:#fff}h2{border-bottom:1px solid #bbb;margin-top:1.5em}"
    "figure{display:inline-block;width:calc(50% - 12px);margin:0 6px 12px 0;vertical-align:top}"
    "figcaption{font-size:13px;color:#555;overflow-wrap:anywhere}svg{width:100%;height:auto;background:#000;"
    "display:block}.wide{overflow-x:auto}table{border-collapse:collapse}"
    "td,th{border-bottom:1px solid #ddd;padding:3px 10px;text-align:right}td:first-child,th:first-child,"
    ".why{text-align:left}.open{color:#b40}i{display:inline-block;width:.8em;height:.8em;border-radius:50%}"
    "@media(max-width:700px){figure{width:100%}}" FFP_REPORT_DARK;

// --- Figures as numbers. ---

static void put_terms(FILE *out, const FfpRigFit *fit) {
    fputs("<h2>Optics</h2><div class=wide><table><tr><th>", out);
    for (int term = 0; term < FFP_TERMS; term++) fprintf(out, "<th>%s", ffp_term_names[term]);
    fputs("<th>rms, pixels</tr>\n", out);
    for (int d = 0; d < 2; d++) {
        const FfpCvDevice *device = &fit->devices[d];
        fprintf(out, "<tr><td>%s, %d &times; %d", device_names[d], device->width, device->height);
        for (int term = 0; term < FFP_TERMS; term++) {
            const bool open = term > 3 && ffp_term_open(device, term);
            fprintf(out, term < 4 ? "<td%s>%.2f &plusmn; %.2g" : "<td%s>%.5g &plusmn; %.2g",
                    open ? " class=open" : "", ffp_term(device, term), device->deviation[term]);
        }
        fprintf(out, "<td>%.3f</tr>\n", device->rms);
    }
    fputs(
        "</table></div><p>Pixel centres lie at integers, as OpenCV has them. &plusmn;: standard deviations. "
        "<span class=open>Terms in this colour</span> are not determined by these photographs: fix them, "
        "or add attitudes that reach the edges of the field.</p>\n",
        out);
}

static int count_used(const FfpAttitude *a, int device) {
    const unsigned char *states = device == 0 ? a->camera_state : a->projector_state;
    int n = 0;
    for (int i = 0; i < a->n; i++) n += states[i] == FFP_CORNER_USED;
    return n;
}

static void put_attitudes(FILE *out, const FfpRigFit *fit) {
    fputs(
        "<h2>Attitudes of the board</h2><div class=wide><table><tr><th>folder<th>tilt<th>corners, camera<th>"
        "projector<th>rms, camera alone<th>projector alone<th>camera, one pose for both<th>projector</tr>\n",
        out);
    for (int i = 0; i < fit->n; i++) {
        const FfpAttitude *a = &fit->attitudes[i];
        fputs("<tr><td>", out);
        ffp_put_html(out, a->name);
        if (a->problem[0]) {
            fputs("<td class=why colspan=7>left out: ", out);
            ffp_put_html(out, a->problem);
        } else {
            fprintf(out, "<td>%.0f&deg;<td>%d<td>%d<td>%.3f<td>%.3f<td>%.3f<td>%.3f",
                    acos(fmin(1, fabs(a->normal[2]))) * 180 / FFP_PI_DOUBLE, count_used(a, 0),
                    count_used(a, 1), a->camera_rms, a->projector_rms, a->rms[0], a->rms[1]);
        }
        fputs("</tr>\n", out);
    }
    fputs("</table></div>\n", out);
}

// --- Drawings. ---

static double enlargement(double rms, double width, double height) {
    return ARROW * fmax(width, height) / fmax(rms, 0.01);
}

// A dot at a corner and, where it has a place in the fit, its error as an arrow. Drawings have a pixel's
// centre half a pixel from its corner.
static void put_corner(FILE *out, const double at[2], const double off[2], unsigned char state, double scale,
                       double size) {
    const double x = at[0] + 0.5, y = at[1] + 0.5;
    fprintf(out, "<circle cx=%.1f cy=%.1f r=%.1f fill='%s'/>", x, y, size, state_colours[state]);
    if (state == FFP_CORNER_USED || state == FFP_CORNER_FAR)
        fprintf(out, "<path d='M%.1f %.1fl%.1f %.1f' stroke='%s' stroke-width=%.1f />", x, y, scale * off[0],
                scale * off[1], state_colours[state], 0.6 * size);
}

static bool put_picture(FILE *out, const FfpImage *picture, double width, double height, FfpError *err) {
    unsigned char *bytes;
    size_t size;
    if (!ffp_image_encode_png(picture, &bytes, &size, err)) return false;
    fprintf(out, "<image width=%.0f height=%.0f href='data:image/png;base64,", width, height);
    ffp_write_base64(out, bytes, size);
    fputs("'/>", out);
    ffp_free(bytes);
    return true;
}

static bool put_board(FILE *out, const FfpAttitude *a, const FfpCvDevice *camera, FfpError *err) {
    const double w = a->picture.width / a->scale, h = a->picture.height / a->scale;
    const double scale = enlargement(camera->rms, w, h), size = fmax(w, h) / 250;
    fprintf(out, "<figure><svg viewBox='0 0 %.0f %.0f'>", w, h);
    if (!put_picture(out, &a->picture, w, h, err)) return false;
    for (int i = 0; i < a->n; i++) {
        // One dot for both devices, in the colour of the first fault. The arrow is the camera's error.
        const unsigned char both = a->camera_state[i] ? a->camera_state[i] : a->projector_state[i];
        put_corner(out, a->camera + 2 * (size_t)i, a->camera_off + 2 * (size_t)i, both, scale, size);
    }
    fputs("</svg><figcaption>", out);
    ffp_put_html(out, a->name);
    if (a->problem[0]) {
        fputs(": left out: ", out);
        ffp_put_html(out, a->problem);
    } else {
        fprintf(out, ": the camera's errors, enlarged %.0f times", scale);
    }
    fputs("</figcaption></figure>\n", out);
    return true;
}

static void count_cells(const FfpRigFit *fit, int which, int cells[CELLS_Y][CELLS_X]) {
    const FfpCvDevice *device = &fit->devices[which];
    for (int i = 0; i < fit->n; i++) {
        const FfpAttitude *a = &fit->attitudes[i];
        const double *points = which == 0 ? a->camera : a->projector;
        const unsigned char *states = which == 0 ? a->camera_state : a->projector_state;
        for (int k = 0; a->problem[0] == 0 && k < a->n; k++) {
            const int x = (int)floor((points[2 * k] + 0.5) / device->width * CELLS_X),
                      y = (int)floor((points[2 * k + 1] + 0.5) / device->height * CELLS_Y);
            if (states[k] == FFP_CORNER_USED && x >= 0 && y >= 0 && x < CELLS_X && y < CELLS_Y) cells[y][x]++;
        }
    }
}

// All corners in one device's field, over how often each part of it was covered.
static void put_field(FILE *out, const FfpRigFit *fit, int which) {
    const FfpCvDevice *device = &fit->devices[which];
    const double w = device->width, h = device->height, scale = enlargement(device->rms, w, h);
    int cells[CELLS_Y][CELLS_X] = {{0}}, covered = 0;
    count_cells(fit, which, cells);
    fprintf(out, "<figure><svg viewBox='0 0 %.0f %.0f'>", w, h);
    for (int y = 0; y < CELLS_Y; y++)
        for (int x = 0; x < CELLS_X; x++) {
            covered += cells[y][x] > 0;
            if (cells[y][x] == 0) continue;
            fprintf(out, "<rect x=%.1f y=%.1f width=%.1f height=%.1f fill='#fff' opacity=%.2f />",
                    x * w / CELLS_X, y * h / CELLS_Y, w / CELLS_X, h / CELLS_Y,
                    fmin(0.45, 0.12 + 0.03 * cells[y][x]));
        }
    for (int i = 0; i < fit->n; i++) {
        const FfpAttitude *a = &fit->attitudes[i];
        const unsigned char *states = which == 0 ? a->camera_state : a->projector_state;
        for (int k = 0; a->problem[0] == 0 && k < a->n; k++)
            if (states[k] == FFP_CORNER_USED || states[k] == FFP_CORNER_FAR)
                put_corner(out, (which == 0 ? a->camera : a->projector) + 2 * (size_t)k,
                           (which == 0 ? a->camera_off : a->projector_off) + 2 * (size_t)k, states[k], scale,
                           fmax(w, h) / 400);
    }
    fprintf(out,
            "</svg><figcaption>the %s's field: %d of %d parts have corners; errors enlarged %.0f times. "
            "Where there are none, the lens model extrapolates.</figcaption></figure>\n",
            device_names[which], covered, CELLS_X * CELLS_Y, scale);
}

static void put_legend(FILE *out) {
    fputs("<p>", out);
    for (int s = 0; s < FFP_CORNER_STATES; s++)
        fprintf(out, "<i style='background:%s'></i> %s &nbsp; ", state_colours[s], state_names[s]);
    fputs(
        "Errors that all point the same way, or swirl, indicate a board that is not flat or a lens that the "
        "model does not fit.</p>\n",
        out);
}

static bool put_table(FILE *out, const FfpTableFit *table, const FfpCvDevice *camera, FfpError *err) {
    const double *u = table->axis.direction, *p = table->axis.point;
    fprintf(out,
            "<h2>Turntable</h2><p>Axis %.6f, %.6f, %.6f through %.6g, %.6g, %.6g (camera coordinates); "
            "uncertain by "
            "%.3f&deg; and %.3g units. %d of %d photographs; rms %.3f pixels.</p>\n",
            u[0], u[1], u[2], p[0], p[1], p[2], table->tilt, table->shift, table->used, table->n, table->rms);
    for (int i = 0; i < table->n; i++)
        if (!put_board(out, &table->attitudes[i], camera, err)) return false;
    return true;
}

// --- The page. ---

static bool put_rig(FILE *out, const FfpRigFit *fit, FfpError *err) {
    double v[3];
    ffp_rotation_to_vector(fit->r, v);
    fprintf(out,
            "<p>%d of %d attitudes, root mean square %.3f pixels with one pose of the board for both "
            "devices. Camera "
            "and projector are %.4g units apart and turned by %.2f&deg;; the boards differ by up to "
            "%.0f&deg;.</p>\n",
            ffp_attitudes_used(fit), fit->n, fit->rms, sqrt(ffp_dot(fit->t, fit->t)),
            sqrt(ffp_dot(v, v)) * 180 / FFP_PI_DOUBLE, fit->spread);
    put_terms(out, fit);
    put_attitudes(out, fit);
    fputs("<h2>Coverage</h2>\n", out);
    for (int d = 0; d < 2; d++) put_field(out, fit, d);
    fputs("<h2>Corners</h2>\n", out);
    put_legend(out);
    for (int i = 0; i < fit->n; i++)
        if (fit->attitudes[i].picture.data && !put_board(out, &fit->attitudes[i], &fit->devices[0], err))
            return false;
    return true;
}

bool ffp_write_calibration_report(const FfpRigFit *fit, const FfpTableFit *table, const char *path,
                                  FfpError *err) {
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) return false;
    fputs("<!DOCTYPE html>\n<html lang=en><meta charset=utf-8><meta name=viewport "
          "content=\"width=device-width,initial-scale=1\"><title>Calibration</title>\n<style>",
          out.stream);
    fputs(style, out.stream);
    fputs("</style>\n<h1>Calibration</h1>\n", out.stream);
    const bool ok = (fit->n == 0 || put_rig(out.stream, fit, err)) &&
                    (!table || put_table(out.stream, table, &fit->devices[0], err));
    if (!ok) {
        ffp_output_abort(&out);
        return false;
    }
    fputs("</html>\n", out.stream);
    return ffp_output_commit(&out, err);
}
