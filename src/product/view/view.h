// A page that shows Gaussians under projected light in a browser: one HTML file, which holds the program
// (view/, put together when the library is built), the splats, the capture's devices and some of its
// pictures.
#ifndef FFP_VIEW_VIEW_H
#define FFP_VIEW_VIEW_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "engine/render/render.h"

typedef struct FfpPageContent {
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpCapture *poses; // more views to look from, after the capture's own; NULL: none
    const FfpRenderSettings *settings;
    int photographs; // longest side at which photographs go into the page, pixels; 0: none do
} FfpPageContent;

typedef struct FfpPageCounts {
    int patterns, photographs;           // that the page holds,
    int patterns_left, photographs_left; // and that there was no room for
    long long bytes;                     // of the file
} FfpPageCounts;

bool ffp_page_build(const FfpPageContent *source, const char *path, FfpPageCounts *stats, FfpError *err);

// --- Inside the room. ---

// A growing sequence of bytes.
typedef struct FfpByteBuffer {
    unsigned char *bytes;
    size_t size, room;
} FfpByteBuffer;
void ffp_bytes_append(FfpByteBuffer *packed, const void *bytes, size_t size);

// splats.c: the splats as the page reads them. First the centres, float [count,3]; then the columns (at most
// FFP_PAGE_COLUMNS), uint16 [count], scaled from low to high: logarithms of the scales, rotation w x y z,
// opacity, albedo, roughness, ambient and, where any light is scattered, scattered. `low` and `high` are the
// ranges of the columns. Splats too faint to be drawn (opacity below 1/255) are left out; returns the number
// of the others.
enum { FFP_PAGE_COLUMNS = 18 };
int ffp_page_columns(const FfpGaussians *gaussians);
int64_t ffp_pack_splats(FfpByteBuffer *packed, const FfpGaussians *gaussians, float low[FFP_PAGE_COLUMNS],
                        float high[FFP_PAGE_COLUMNS]);

// scene.c: the JSON that describes everything, released with ffp_free; packs splats and pictures.
char *ffp_page_scene(const FfpPageContent *source, FfpByteBuffer *packed, FfpPageCounts *stats,
                     FfpError *err);

// The page itself, made from view/ by cmake/page.cmake; FFP_PAGE_SCENE and FFP_PAGE_DATA stand where scene
// and data go.
#define FFP_PAGE_SCENE "@FFP_PAGE_SCENE@"
#define FFP_PAGE_DATA "@FFP_PAGE_DATA@"
extern const unsigned char ffp_page_template[]; // ends with a zero

#endif
