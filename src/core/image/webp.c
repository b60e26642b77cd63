#include "core/image/webp.h"
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/image/codec.h"
#include "core/image/webp_module.h"

enum { HEAD = 30, FLAGS = 20, ANIMATED = 2, CANVAS = 24 };

#define BYTES_MAX ((size_t)1 << 30)

struct FfpWebp {
    const char *path;
    const FfpWebpModule *module;
    char *bytes;
    void *film;
    unsigned char *rgba; // of the last picture
    int width, height, rate, count;
    double from, to; // ms
    int until;       // when the last picture ends, ms
};

bool ffp_webp_moves(const char *path) {
    unsigned char head[HEAD];
    FILE *stream = ffp_open_to_read(path, NULL);
    if (!stream) return false;
    const size_t size = fread(head, 1, HEAD, stream);
    fclose(stream);
    return size == HEAD && memcmp(head, "RIFF", 4) == 0 && memcmp(head + 8, "WEBPVP8X", 8) == 0 &&
           head[FLAGS] & ANIMATED;
}

static int side_at(const char *bytes) {
    const unsigned char *at = (const unsigned char *)bytes;
    return (at[0] | at[1] << 8 | at[2] << 16) + 1;
}

// The canvas is checked first: libwebp takes memory for all of it.
static bool open_film(FfpWebp *webp, const char *file, FfpError *err) {
    static FfpModule module = {.name = "webp",
                               .version = FFP_WEBP_MODULE_VERSION,
                               .purpose = "animated WebP is read by libwebp",
                               .origin = "a build with libwebp-dev; or save it as GIF, animated PNG or MP4"};
    size_t size;
    if (!ffp_read_file(file, BYTES_MAX, &webp->bytes, &size, err)) return false;
    if (size < HEAD) return ffp_fail(err, FFP_ERROR_FILE, webp->path, "ends inside its header");
    webp->width = side_at(webp->bytes + CANVAS);
    webp->height = side_at(webp->bytes + CANVAS + 3);
    if (!ffp_check_sides(webp->width, webp->height, webp->path, err)) return false;
    webp->module = ffp_module_load(&module, err);
    if (!webp->module) return false;
    webp->film = webp->module->open((const unsigned char *)webp->bytes, size);
    if (!webp->film) return ffp_fail(err, FFP_ERROR_FILE, webp->path, "is a damaged WebP film");
    ffp_own(webp->film, webp->module->close);
    return true;
}

FfpWebp *ffp_webp_open(const char *file, const char *path, int rate, double from, double to, FfpError *err) {
    FfpWebp *webp = ffp_alloc(1, sizeof *webp);
    *webp = (FfpWebp){.path = path, .rate = rate, .from = 1000 * from, .to = 1000 * to};
    if (open_film(webp, file, err)) return webp;
    ffp_webp_close(webp);
    return NULL;
}

// The picture after the last one. False: there is none, or an error.
static bool advance(FfpWebp *webp, FfpError *err) {
    if (!webp->module->more(webp->film)) return false;
    return webp->module->next(webp->film, &webp->rgba, &webp->until) ||
           ffp_fail(err, FFP_ERROR_FILE, webp->path, "is a damaged WebP film");
}

int ffp_webp_next(FfpWebp *webp, FfpRaw *out, FfpError *err) {
    FfpError why = {0};
    const double wanted = webp->from + 1000.0 * webp->count / webp->rate;
    bool shown = webp->rgba && wanted < webp->until;
    while (!shown && advance(webp, &why)) shown = wanted < webp->until;
    if (why.code != FFP_OK) {
        if (err) *err = why;
        return -1;
    }
    if (!shown || wanted >= webp->to) return 0;
    webp->count++;
    *out = (FfpRaw){
        .data = webp->rgba, .width = webp->width, .height = webp->height, .channels = 4, .type = FFP_RAW_U8};
    return 1;
}

void ffp_webp_close(FfpWebp *webp) {
    if (!webp) return;
    if (webp->film) {
        ffp_disown(webp->film);
        webp->module->close(webp->film);
    }
    ffp_free(webp->bytes);
    ffp_free(webp);
}
