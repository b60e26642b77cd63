// JPEG through libjpeg-turbo. Its errors leave by longjmp, as libpng's do.
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jpeglib.h>
#include <jerror.h>

#include "base/arena.h"
#include "image/codec.h"

typedef struct Reading {
    struct jpeg_error_mgr errors; // first: libjpeg hands out pointers to it
    struct jpeg_decompress_struct jpeg;
    jmp_buf leave;
    unsigned char *pixels; // [height, width, 3]
    char message[JMSG_LENGTH_MAX];
} Reading;

static void on_error(j_common_ptr jpeg) {
    Reading *reading = (Reading *)jpeg->err;
    jpeg->err->format_message(jpeg, reading->message);
    longjmp(reading->leave, 1);
}

// Warnings are let pass (cameras write odd files), but for an end that comes too soon: half a picture is
// none.
static void on_message(j_common_ptr jpeg, int level) {
    if (level == -1 && jpeg->err->msg_code == JWRN_JPEG_EOF) on_error(jpeg);
}

bool ffp_jpeg_is(const FfpBytes *file) {
    return file->size >= 3 && file->data[0] == 0xff && file->data[1] == 0xd8 && file->data[2] == 0xff;
}

static bool read_jpeg(Reading *r, const FfpBytes *file, bool with_pixels) {
    r->jpeg.err = jpeg_std_error(&r->errors);
    r->errors.error_exit = on_error;
    r->errors.emit_message = on_message;
    if (setjmp(r->leave)) return false;
    jpeg_create_decompress(&r->jpeg);
    jpeg_mem_src(&r->jpeg, file->data, file->size);
    jpeg_read_header(&r->jpeg, TRUE);
    if (!with_pixels) return true;
    r->jpeg.out_color_space = JCS_RGB;
    jpeg_start_decompress(&r->jpeg);
    const size_t stride = (size_t)r->jpeg.output_width * 3;
    r->pixels = ffp_alloc(r->jpeg.output_height, stride);
    while (r->jpeg.output_scanline < r->jpeg.output_height) {
        JSAMPROW row = r->pixels + r->jpeg.output_scanline * stride;
        jpeg_read_scanlines(&r->jpeg, &row, 1);
    }
    jpeg_finish_decompress(&r->jpeg);
    return true;
}

bool ffp_jpeg_size(const FfpBytes *file, int *width, int *height, FfpError *err) {
    Reading r = {0};
    const bool ok = read_jpeg(&r, file, false);
    const long long w = r.jpeg.image_width, h = r.jpeg.image_height;
    jpeg_destroy_decompress(&r.jpeg);
    if (!ok) return ffp_fail(err, file->path, "broken JPEG: %s", r.message);
    if (!ffp_check_sides(w, h, file->path, err)) return false;
    *width = (int)w;
    *height = (int)h;
    return true;
}

bool ffp_jpeg_decode(const FfpBytes *file, FfpDecoded *out, FfpError *err) {
    int width = 0, height = 0;
    if (!ffp_jpeg_size(file, &width, &height, err)) return false; // before memory is taken for the pixels
    Reading r = {0};
    const bool ok = read_jpeg(&r, file, true);
    jpeg_destroy_decompress(&r.jpeg);
    if (!ok) {
        free(r.pixels);
        return ffp_fail(err, file->path, "broken JPEG: %s", r.message);
    }
    out->image = ffp_image_new(width, height, 4);
    const size_t pixels = (size_t)width * (size_t)height;
    for (size_t i = 0; i < pixels; i++) {
        for (size_t c = 0; c < 3; c++) out->image.data[4 * i + c] = (real)r.pixels[3 * i + c] / 255;
        out->image.data[4 * i + 3] = 1;
    }
    free(r.pixels);
    return true;
}
