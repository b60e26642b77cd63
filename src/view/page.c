// The page as a file: the template with scene and data in their places.
#include <stdio.h>
#include <string.h>
#include "base/alloc.h"
#include "base/base64.h"
#include "base/call.h"
#include "base/file.h"
#include "view/view.h"

void ffp_pack(FfpPacked *packed, const void *bytes, size_t size) {
    if (size > packed->room - packed->size) {
        if (size > SIZE_MAX / 4 || packed->size > SIZE_MAX / 4) ffp_no_memory(size);
        packed->room = 2 * packed->room > packed->size + size ? 2 * packed->room : packed->size + size;
        packed->bytes = ffp_grow(packed->bytes, packed->room, 1);
    }
    if (bytes) memcpy(packed->bytes + packed->size, bytes, size);
    packed->size += size;
}

bool ffp_page_write(const FfpPageSource *source, const char *path, FfpPageStats *stats, FfpError *err) {
    FfpPacked packed = {0};
    FfpOutput out;
    const char *page = (const char *)ffp_page_template, *scene_at = strstr(page, FFP_PAGE_SCENE),
               *data_at = strstr(page, FFP_PAGE_DATA);
    *stats = (FfpPageStats){0};
    if (!ffp_output_open(&out, path, err)) return false;
    char *scene = ffp_page_scene(source, &packed, stats, err);
    if (!scene) {
        ffp_output_abort(&out);
        ffp_free(packed.bytes);
        return false;
    }
    ffp_cancel_point();
    fwrite(page, 1, (size_t)(scene_at - page), out.stream);
    fputs(scene, out.stream);
    scene_at += strlen(FFP_PAGE_SCENE);
    fwrite(scene_at, 1, (size_t)(data_at - scene_at), out.stream);
    ffp_write_base64(out.stream, packed.bytes, packed.size);
    fputs(data_at + strlen(FFP_PAGE_DATA), out.stream);
    stats->bytes = (long long)ftello(out.stream);
    ffp_free(scene);
    ffp_free(packed.bytes);
    return ffp_output_commit(&out, err);
}
