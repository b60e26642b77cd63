// The calibration as OpenCV's FileStorage: the keys of kamino410/procam-calibration, which `import` reads,
// the sizes of both pictures, and behind them how good it is.
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/base/rigid.h"
#include "core/base/text.h"
#include "core/capture/node.h"
#include "rig/calibrate/calibrate.h"
#include "rig/chessboard/terms.h"

typedef struct Writer {
    FILE *out;
    bool yaml;
    int depth;
    bool item; // YAML: the next line begins an item of a list
} Writer;

static void begin_line(Writer *w) {
    const int spaces = (w->yaml ? 3 : 2) * w->depth;
    if (w->yaml && w->item) {
        fprintf(w->out, "%*s- ", spaces - 2, "");
    } else {
        fprintf(w->out, "%*s", spaces, "");
    }
    w->item = false;
}

static void put_matrix(Writer *w, const char *key, int rows, int columns, const double *values) {
    const int inner = (w->yaml ? 3 : 2) * (w->depth + 1);
    begin_line(w);
    if (w->yaml)
        fprintf(w->out, "%s: !!opencv-matrix\n%*srows: %d\n%*scols: %d\n%*sdt: d\n%*sdata: [ ", key, inner,
                "", rows, inner, "", columns, inner, "", inner, "");
    else
        fprintf(w->out,
                "<%s type_id=\"opencv-matrix\">\n%*s<rows>%d</rows>\n%*s<cols>%d</cols>\n%*s<dt>d</dt>\n"
                "%*s<data>\n",
                key, inner, "", rows, inner, "", columns, inner, "", inner, "");
    for (int i = 0; i < rows * columns; i++)
        fprintf(w->out, "%s%.17g", i == 0 ? "" : w->yaml ? ", " : " ", values[i]);
    if (w->yaml)
        fputs(" ]\n", w->out);
    else
        fprintf(w->out, "</data></%s>\n", key);
}

static void put_number(Writer *w, const char *key, double value) {
    begin_line(w);
    if (w->yaml)
        fprintf(w->out, "%s: %.17g\n", key, value);
    else
        fprintf(w->out, "<%s>%.17g</%s>\n", key, value, key);
}

// Bytes of the character of UTF-8 that a text begins with; 0 where it begins with none, or with one that XML
// or YAML does not take.
static size_t character(const char *text) {
    char copy[5] = {text[0]};
    const unsigned char first = (unsigned char)text[0];
    const size_t n = first < 0x80 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
    for (size_t i = 1; i < n && copy[i - 1] != 0; i++) copy[i] = text[i];
    const bool control = first < 32 || first == 127 || (first == 0xc2 && (unsigned char)copy[1] < 0xa0);
    const bool mark = strcmp(copy, "\xef\xbb\xbf") == 0 || strcmp(copy, "\xef\xbf\xbe") == 0 ||
                      strcmp(copy, "\xef\xbf\xbf") == 0;
    return control || mark || !ffp_is_utf8(copy) ? 0 : n;
}

// A text in quotes, which both forms read as one; `?` for what they cannot hold.
static void put_text(Writer *w, const char *key, const char *text) {
    begin_line(w);
    if (w->yaml)
        fprintf(w->out, "%s: \"", key);
    else
        fprintf(w->out, "<%s>\"", key);
    for (const char *at = text; *at;) {
        const size_t n = character(at);
        if (n == 0)
            fputc('?', w->out);
        else if (w->yaml && (*at == '"' || *at == '\\'))
            fprintf(w->out, "\\%c", *at);
        else if (!w->yaml && strchr("<>&\"", *at))
            fprintf(w->out, "&#%d;", *at);
        else
            fwrite(at, 1, n, w->out);
        at += n > 0 ? n : 1;
    }
    if (w->yaml)
        fputs("\"\n", w->out);
    else
        fprintf(w->out, "\"</%s>\n", key);
}

static void open_list(Writer *w, const char *key) {
    begin_line(w);
    if (w->yaml)
        fprintf(w->out, "%s:\n", key);
    else
        fprintf(w->out, "<%s>\n", key);
    w->depth++;
}

static void close_list(Writer *w, const char *key) {
    w->depth--;
    if (w->yaml) return;
    begin_line(w);
    fprintf(w->out, "</%s>\n", key);
}

static void open_item(Writer *w) {
    w->item = w->yaml;
    if (w->yaml) {
        w->depth++;
        return;
    }
    begin_line(w);
    fputs("<_>\n", w->out);
    w->depth++;
}

static void close_item(Writer *w) {
    w->depth--;
    if (w->yaml) return;
    begin_line(w);
    fputs("</_>\n", w->out);
}

static void put_attitudes(Writer *w, const FfpRigFit *fit, bool used) {
    for (int i = 0; i < fit->n; i++) {
        const FfpAttitude *a = &fit->attitudes[i];
        int corners = 0;
        if ((a->problem[0] == 0) != used) continue;
        for (int k = 0; k < a->n; k++)
            corners += a->camera_state[k] == FFP_CORNER_USED && a->projector_state[k] == FFP_CORNER_USED;
        open_item(w);
        put_text(w, "name", a->name);
        if (used) {
            put_number(w, "corners", corners);
            put_number(w, "cam_rms", a->camera_rms), put_number(w, "proj_rms", a->projector_rms);
            put_number(w, "stereo_cam_rms", a->rms[0]), put_number(w, "stereo_proj_rms", a->rms[1]);
        } else {
            put_text(w, "why", a->problem);
        }
        close_item(w);
    }
}

static void put_fit(Writer *w, const FfpRigFit *fit) {
    const FfpCvDevice *camera = &fit->devices[0], *projector = &fit->devices[1];
    const double shape[2] = {camera->height, camera->width};
    put_matrix(w, "img_shape", 2, 1, shape);
    put_number(w, "camW", camera->width), put_number(w, "camH", camera->height);
    put_number(w, "prjW", projector->width), put_number(w, "prjH", projector->height);
    put_number(w, "rms", fit->rms);
    put_matrix(w, "cam_int", 3, 3, camera->matrix), put_matrix(w, "cam_dist", 1, 5, camera->lens);
    put_matrix(w, "proj_int", 3, 3, projector->matrix), put_matrix(w, "proj_dist", 1, 5, projector->lens);
    put_matrix(w, "rotation", 3, 3, fit->r), put_matrix(w, "translation", 3, 1, fit->t);
    put_number(w, "cam_rms", camera->rms), put_number(w, "proj_rms", projector->rms);
    put_matrix(w, "cam_deviations", 1, FFP_TERMS, camera->deviation); // of fx fy cx cy k1 k2 p1 p2 k3
    put_matrix(w, "proj_deviations", 1, FFP_TERMS, projector->deviation);
    open_list(w, "attitudes");
    put_attitudes(w, fit, true);
    close_list(w, "attitudes");
    if (ffp_attitudes_used(fit) == fit->n) return;
    open_list(w, "left_out");
    put_attitudes(w, fit, false);
    close_list(w, "left_out");
}

static bool ends_with(const char *path, const char *ending) {
    const size_t length = strlen(path), tail = strlen(ending);
    return length >= tail && strcmp(path + length - tail, ending) == 0;
}

bool ffp_write_calibration(const FfpRigFit *fit, const char *path, FfpError *err) {
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) return false;
    Writer w = {.out = out.stream, .yaml = ends_with(path, ".yml") || ends_with(path, ".yaml")};
    fputs(w.yaml ? "%YAML:1.0\n---\n" : "<?xml version=\"1.0\"?>\n<opencv_storage>\n", out.stream);
    put_fit(&w, fit);
    if (!w.yaml) fputs("</opencv_storage>\n", out.stream);
    return ffp_output_commit(&out, err);
}

// --- The axis. ---

static void put_views(FILE *out, const FfpTableFit *fit) {
    int left_out = 0;
    fputs(" \"views\": [", out);
    for (int i = 0; i < fit->n; i++) fprintf(out, "%s\"%s\"", i > 0 ? ", " : "", fit->stops[i].view);
    fputs("],\n \"left_out\": [", out);
    for (int i = 0; i < fit->n; i++)
        if (fit->stops[i].left_out) fprintf(out, "%s\"%s\"", left_out++ > 0 ? ", " : "", fit->stops[i].view);
    fputs("],\n", out);
}

bool ffp_write_table(const FfpTableFit *fit, const char *path, FfpError *err) {
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) return false;
    const double *u = fit->axis.direction, *p = fit->axis.point;
    const double *x = fit->zero;
    fprintf(out.stream, "{\n \"axis\": [%.9g, %.9g, %.9g],\n \"point\": [%.9g, %.9g, %.9g],\n", u[0], u[1],
            u[2], p[0], p[1], p[2]);
    if (ffp_dot(x, x) > 0) fprintf(out.stream, " \"zero\": [%.9g, %.9g, %.9g],\n", x[0], x[1], x[2]);
    if (fit->stops) put_views(out.stream, fit);
    fprintf(out.stream, " \"clockwise\": %s,\n \"%s\": [", fit->reversed ? "true" : "false",
            fit->stops ? "angles" : "board_angles");
    for (int i = 0; i < fit->n; i++) fprintf(out.stream, "%s%.9g", i > 0 ? ", " : "", fit->angles[i]);
    fprintf(out.stream, "],\n \"rms\": %.6g,\n \"tilt\": %.6g,\n \"shift\": %.6g\n}\n", fit->rms, fit->tilt,
            fit->shift);
    return ffp_output_commit(&out, err);
}
