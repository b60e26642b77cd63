// The page's scene as JSON, and the pictures that go with it.
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/text.h"
#include "core/capture/photographs.h"
#include "core/capture/reduce.h"
#include "product/view/view.h"

// Room for pictures, bytes before base64: together with 30,000 splats a page stays under 6 MB.
#define PATTERNS_ROOM 1000000
#define PHOTOGRAPHS_ROOM 1500000
#define READ_SIDE 2048 // pixels: larger photographs are reduced one by one

typedef struct Writer {
    const FfpPageContent *source;
    FfpByteBuffer *packed;
    FfpPageCounts *stats;
    FILE *out;
    size_t patterns, photographs; // bytes so far
    size_t typical;               // bytes of the last view's first photograph
    int views;                    // that have photographs, after those that are written
    int side;                     // to which the last one that had to shrink did; 0: none had to
} Writer;

// A JSON string that may stand in HTML: "<" is escaped too.
static void write_string(FILE *out, const char *text) {
    fputc('"', out);
    for (const unsigned char *c = (const unsigned char *)text; *c; c++) {
        if (*c < 0x20 || *c == '"' || *c == '\\' || *c == '<' || *c == '>' || *c == '&' || *c == 0x7F)
            fprintf(out, "\\u%04x", *c);
        else
            fputc(*c, out);
    }
    fputc('"', out);
}

static void write_numbers(FILE *out, const float *values, int n) {
    for (int i = 0; i < n; i++) fprintf(out, "%s%.9g", i ? "," : "[", (double)values[i]);
    fputc(']', out);
}

static void write_device(FILE *out, const char *name, const FfpCamera *c) {
    fprintf(out,
            "\"%s\":{\"width\":%d,\"height\":%d,\"fx\":%.9g,\"fy\":%.9g,\"cx\":%.9g,\"cy\":%.9g,\"pose\":",
            name, c->width, c->height, (double)c->fx, (double)c->fy, (double)c->cx, (double)c->cy);
    write_numbers(out, c->pose, 16);
    fputc('}', out);
}

// Packs a linear picture as 8-bit sRGB PNG if it fits into what is left of `room`; says where it lies.
static bool pack_picture(Writer *w, const FfpImage *linear, int longest, size_t *used, size_t room,
                         bool *fits, FfpError *err) {
    const int side = linear->width > linear->height ? linear->width : linear->height;
    const double shrink = longest > 0 && side > longest ? (double)longest / side : 1;
    const int width = (int)fmax(1, round(linear->width * shrink)),
              height = (int)fmax(1, round(linear->height * shrink));
    FfpImage picture = shrink < 1 ? ffp_image_resize(linear, width, height) : ffp_image_copy(linear);
    unsigned char *bytes = NULL;
    size_t size = 0;
    ffp_image_to_srgb(&picture);
    const bool ok = ffp_image_encode_png(&picture, &bytes, &size, err);
    ffp_image_free(&picture);
    if (!ok) return false;
    *fits = *used + size <= room;
    if (*fits) {
        fprintf(w->out, "\"at\":%zu,\"size\":%zu", w->packed->size, size);
        ffp_bytes_append(w->packed, bytes, size);
        *used += size;
    }
    ffp_free(bytes);
    return true;
}

static bool write_patterns(Writer *w, FfpError *err) {
    const FfpCapture *capture = w->source->capture;
    fputs("\"patterns\":[", w->out);
    for (int i = 0; i < ffp_patterns_shown(capture); i++) {
        const FfpPattern *pattern = &capture->patterns[i];
        bool fits = true;
        fprintf(w->out, "%s{\"name\":", i ? "," : "");
        write_string(w->out, pattern->name);
        fprintf(w->out, ",\"role\":\"%s\",",
                i == capture->black   ? "black"
                : i == capture->white ? "white"
                : pattern->novel      ? "novel"
                                      : "active");
        if (!pack_picture(w, &pattern->image, 0, &w->patterns, PATTERNS_ROOM, &fits, err)) return false;
        fputs(fits ? "}" : "\"size\":0}", w->out);
        w->stats->patterns += fits;
        w->stats->patterns_left += !fits;
    }
    fputs("],\n", w->out);
    return true;
}

// The patterns of a view's photographs, first white's, which stands for the view.
static int patterns_of(const FfpCapture *capture, const FfpCapture *from, int v, int *patterns) {
    int n = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < ffp_patterns_shown(capture); i++)
            if ((i == capture->white) == (pass == 0) && ffp_photographs_has(from, v, i)) patterns[n++] = i;
    return n;
}

// At the size that the page takes, or smaller where it does not fit and may `shrink`.
static bool pack_photograph(Writer *w, const FfpImage *image, size_t room, bool shrink, bool *fits,
                            FfpError *err) {
    const int own = image->width > image->height ? image->width : image->height;
    const int most = shrink && w->side > 0 ? w->side : w->source->photographs;
    int side = own < most ? own : most;
    bool ok = pack_picture(w, image, side, &w->photographs, room, fits, err);
    while (ok && shrink && !*fits && (side = side * 9 / 10) > 0) {
        ok = pack_picture(w, image, side, &w->photographs, room, fits, err);
        if (*fits) w->side = side;
    }
    return ok;
}

// The first one within the view's part of the room; the others as long as every later view keeps room for
// one.
static bool pack_photographs(Writer *w, const int *patterns, int n, const FfpView *read, FfpError *err) {
    const size_t before = w->photographs, later = (size_t)w->views;
    for (int i = 0; i < n; i++) {
        const size_t room = i == 0 ? before + (PHOTOGRAPHS_ROOM - before) / (later + 1)
                            : later * w->typical < PHOTOGRAPHS_ROOM ? PHOTOGRAPHS_ROOM - later * w->typical
                                                                    : 0;
        bool fits = false;
        fprintf(w->out, "%s{\"pattern\":%d,", i ? "," : "", patterns[i]);
        if (!pack_photograph(w, &read->images[patterns[i]], room, i == 0, &fits, err)) return false;
        fputs(fits ? "}" : "\"size\":0}", w->out);
        w->stats->photographs += fits;
        w->stats->photographs_left += !fits;
        if (i == 0) w->typical = w->photographs - before;
    }
    return true;
}

// Read at no more than READ_SIDE; the first one alone where there is no room for others.
static bool write_photographs(Writer *w, const FfpCapture *from, int v, FfpError *err) {
    const FfpCamera *camera = &from->views[v].camera;
    const int longest = camera->width > camera->height ? camera->width : camera->height;
    const int factor = (longest + READ_SIDE - 1) / READ_SIDE;
    int patterns[FFP_PATTERNS_MAX];
    const int n = w->source->photographs > 0 ? patterns_of(w->source->capture, from, v, patterns) : 0;
    const bool roomy = w->photographs + ((size_t)w->views + 1) * w->typical < PHOTOGRAPHS_ROOM;
    const int n_read = n > 1 && !roomy ? 1 : n;
    FfpView read = {0};
    w->views -= n > 0;
    w->stats->photographs_left += n - n_read;
    fputs(",\"photographs\":[", w->out);
    const bool ok = n == 0 || (ffp_photographs_read(&read, from, v, patterns, n_read,
                                                    (camera->width + factor - 1) / factor,
                                                    (camera->height + factor - 1) / factor, err) &&
                               pack_photographs(w, patterns, n_read, &read, err));
    ffp_view_reduced_free(&read, from->n_patterns);
    fputc(']', w->out);
    return ok;
}

static bool write_views(Writer *w, FfpError *err) {
    const FfpCapture *sources[] = {w->source->capture, w->source->poses};
    int written = 0, patterns[FFP_PATTERNS_MAX];
    for (int pass = 0; pass < 2; pass++)
        for (int v = 0; sources[pass] && v < sources[pass]->n_views; v++)
            w->views += patterns_of(w->source->capture, sources[pass], v, patterns) > 0;
    fputs("\"views\":[", w->out);
    for (int pass = 0; pass < 2; pass++) {
        const FfpCapture *from = sources[pass];
        for (int v = 0; from && v < from->n_views; v++) {
            const FfpView *view = &from->views[v];
            fprintf(w->out, "%s\n{\"id\":", written++ ? "," : "");
            write_string(w->out, view->id);
            fprintf(w->out, ",\"new\":%s,", pass ? "true" : "false");
            write_device(w->out, "camera", &view->camera);
            fputc(',', w->out);
            write_device(w->out, "projector", &view->projector);
            if (!write_photographs(w, from, v, err)) return false;
            fputc('}', w->out);
        }
    }
    fputs("]}\n", w->out);
    return true;
}

static void write_drawing(FILE *out, const FfpRenderSettings *s) {
    fprintf(
        out,
        "\"drawing\":{\"samples\":%d,\"blur\":%.9g,\"compensation\":%s,\"firmness\":%.9g,\"footprint\":%s,"
        "\"shadows\":%s,\"shadow_side\":%d,\"shadow_bias\":%.9g,\"smooth\":%s},\n",
        s->samples, (double)s->blur, s->compensation ? "true" : "false", (double)s->firmness,
        s->footprint ? "true" : "false", s->shadows ? "true" : "false", s->shadow_side,
        (double)s->shadow_bias, s->smooth ? "true" : "false");
}

static void write_baked(FILE *out, const FfpBakedShadows *baked) {
    if (!(baked->within > 0)) return;
    fputs("\"baked\":{\"light\":", out);
    write_numbers(out, baked->light, 3);
    fprintf(out, ",\"within\":%.9g},\n", (double)baked->within);
}

static void write_splats(Writer *w) {
    float low[FFP_PAGE_COLUMNS], high[FFP_PAGE_COLUMNS];
    const int columns = ffp_page_columns(w->source->gaussians);
    const int64_t count = ffp_pack_splats(w->packed, w->source->gaussians, low, high);
    fprintf(w->out, "\"count\":%lld,\"low\":", (long long)count);
    write_numbers(w->out, low, columns);
    fputs(",\"high\":", w->out);
    write_numbers(w->out, high, columns);
    fputs(",\n", w->out);
}

static void write_panel(FILE *out, const FfpPanel *p) {
    if (!p->known) return;
    fprintf(out,
            "\"panel\":{\"width\":%d,\"height\":%d,\"fx\":%.9g,\"fy\":%.9g,\"cx\":%.9g,\"cy\":%.9g,\"lens\":",
            p->width, p->height, (double)p->fx, (double)p->fy, (double)p->cx, (double)p->cy);
    write_numbers(out, p->lens, 5);
    if (p->power) {
        fputs(",\"gamma\":", out);
        write_numbers(out, p->gamma, 3);
    }
    if (p->spread_reach > 0) {
        fputs(",\"spread\":{\"share\":", out);
        write_numbers(out, p->spread, 3);
        fprintf(out, ",\"deviation\":%.9g}", (double)p->spread_reach);
    }
    fputs("},\n", out);
}

char *ffp_page_scene(const FfpPageContent *source, FfpByteBuffer *packed, FfpPageCounts *stats,
                     FfpError *err) {
    FfpText *text = ffp_text_new();
    Writer w = {.source = source, .packed = packed, .stats = stats, .out = ffp_text_stream(text)};
    const FfpCapture *capture = source->capture;
    fputs("{\"name\":", w.out);
    write_string(w.out, capture->name);
    fputs(",\"centre\":", w.out);
    write_numbers(w.out, capture->centre, 3);
    fprintf(w.out, ",\"radius\":%.9g,\"whole\":%s,\"intensity\":", (double)capture->radius,
            capture->scene ? "true" : "false");
    write_numbers(w.out, capture->intensity, 3);
    fputs(",\n", w.out);
    write_drawing(w.out, source->settings);
    write_panel(w.out, &capture->panel);
    write_baked(w.out, &source->gaussians->baked);
    write_splats(&w);
    if (write_patterns(&w, err) && write_views(&w, err)) return ffp_text_end(text);
    ffp_text_free(text);
    return NULL;
}
