// relight FILE.ply CAPTURE OUT.ppm: one view of an object under many patterns that exist only in memory. It
// is rasterised once; every pattern then is a matter of milliseconds. The pictures go side by side into a
// file.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include "ffprocams.h"

enum { FRAMES = 8 };

// Coloured stripes that wander with the frame.
static void paint(unsigned char *pattern, int width, int height, int frame) {
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            for (int c = 0; c < 3; c++) {
                const double phase = 40.0 * x / width + 6.2831853 * ((double)frame / FRAMES + c / 3.0);
                pattern[3 * ((size_t)y * (size_t)width + (size_t)x) + (size_t)c] =
                    (unsigned char)(127.5 + 127.5 * sin(phase));
            }
}

static double seconds(void) {
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static bool write_strip(const char *path, const unsigned char *strip, int width, int height) {
    FILE *file = fopen(path, "wb");
    if (!file) return false;
    fprintf(file, "P6 %d %d 255\n", width, height);
    fwrite(strip, 3, (size_t)width * (size_t)height, file);
    return fclose(file) == 0;
}

// FRAMES pictures beside each other: rows of one picture lie apart by the strip's width.
static bool draw(FfpRenderer *renderer, const FfpPinhole *camera, const FfpPinhole *projector,
                 const double intensity[3], unsigned char *strip, unsigned char *pattern, FfpError *err) {
    const size_t row = 3 * (size_t)camera->width * FRAMES;
    const FfpPicture light = {.data = pattern,
                              .width = projector->width,
                              .height = projector->height,
                              .channels = 3,
                              .type = FFP_PIXELS_U8};
    const double begin = seconds();
    for (int f = 0; f < FRAMES; f++) {
        paint(pattern, projector->width, projector->height, f);
        const size_t left = 3 * (size_t)camera->width * (size_t)f;
        if (!ffp_renderer_shade(NULL, renderer, &light, intensity, strip + left,
                                row * (size_t)camera->height - left, FFP_PIXELS_U8, row, err))
            return false;
    }
    printf("%d pictures of %d x %d in %.1f ms\n", FRAMES, camera->width, camera->height,
           1e3 * (seconds() - begin));
    return true;
}

int main(int argc, char **argv) {
    FfpError err = {0};
    if (argc != 4) {
        fprintf(stderr, "usage: relight FILE.ply CAPTURE OUT.ppm\n");
        return 2;
    }
    FfpPinhole camera, projector;
    double intensity[3];
    bool done = false;
    FfpGaussians *gaussians = ffp_gaussians_open(NULL, argv[1], NULL, &err);
    FfpCapture *capture = gaussians ? ffp_capture_open(NULL, argv[2], NULL, &err) : NULL;
    const FfpDrawing drawing = {.form = FFP_FORM_OURS};
    FfpRenderer *renderer = capture ? ffp_renderer_new(NULL, drawing, &err) : NULL;
    if (renderer) {
        ffp_capture_view_devices(capture, 0, &camera, &projector);
        ffp_capture_intensity(capture, intensity);
        unsigned char *strip = calloc(3 * (size_t)camera.width * (size_t)camera.height, FRAMES);
        unsigned char *pattern = calloc(3 * (size_t)projector.width, (size_t)projector.height);
        done = strip && pattern && ffp_renderer_aim(NULL, renderer, gaussians, &camera, &projector, &err) &&
               draw(renderer, &camera, &projector, intensity, strip, pattern, &err) &&
               write_strip(argv[3], strip, FRAMES * camera.width, camera.height);
        free(strip), free(pattern);
    }
    if (!done) fprintf(stderr, "relight: %s\n", err.text[0] ? err.text : "out of memory, or cannot write");
    ffp_renderer_close(renderer);
    ffp_capture_close(capture);
    ffp_gaussians_close(gaussians);
    return done ? 0 : 1;
}
