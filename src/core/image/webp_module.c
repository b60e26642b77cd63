#include "core/image/webp_module.h"
#include <webp/demux.h>

static void *open_film(const unsigned char *bytes, size_t size) {
    WebPAnimDecoderOptions options;
    const WebPData data = {bytes, size};
    if (!WebPAnimDecoderOptionsInit(&options)) return NULL;
    options.color_mode = MODE_RGBA;
    return WebPAnimDecoderNew(&data, &options);
}

static bool has_more(void *film) {
    return WebPAnimDecoderHasMoreFrames(film);
}

static bool get_next(void *film, unsigned char **rgba, int *until) {
    return WebPAnimDecoderGetNext(film, rgba, until);
}

static void close_film(void *film) {
    WebPAnimDecoderDelete(film);
}

const FfpWebpModule ffp_webp_module = {FFP_WEBP_MODULE_VERSION, open_film, has_more, get_next, close_film};
