// The page as a file: the template with scene and data in their places.
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/base64.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "product/view/view.h"

bool ffp_page_build(const FfpPageContent *source, const char *path, FfpPageCounts *stats, FfpError *err) {
    FfpByteBuffer packed = {0};
    FfpOutput out;
    const char *page = (const char *)ffp_page_template, *scene_at = strstr(page, FFP_PAGE_SCENE),
               *data_at = strstr(page, FFP_PAGE_DATA);
    *stats = (FfpPageCounts){0};
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
