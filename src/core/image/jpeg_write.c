// Pictures as a camera's JPEG through libjpeg-turbo. Its errors leave by longjmp: all that must survive the
// jump lies in a struct of the caller's.
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <jpeglib.h>
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/image/image.h"

typedef struct Writing {
    struct jpeg_error_mgr errors; // first: libjpeg hands out pointers to it
    struct jpeg_compress_struct jpeg;
    jmp_buf leave;
    unsigned char *bytes; // libjpeg's memory
    unsigned long size;
    unsigned char *row;
    char message[JMSG_LENGTH_MAX];
} Writing;

static void on_error(j_common_ptr jpeg) {
    Writing *w = (Writing *)jpeg->err;
    jpeg->err->format_message(jpeg, w->message);
    longjmp(w->leave, 1);
}

static void take_row(const FfpImage *image, int y, unsigned char *row) {
    const size_t count = (size_t)image->width * 3;
    const real *from = image->data + (size_t)y * count;
    for (size_t i = 0; i < count; i++) {
        const real bound = from[i] > 0 ? (from[i] < 1 ? from[i] : 1) : 0; // NaN: 0
        row[i] = (unsigned char)(bound * 255 + (real)0.5);
    }
}

static bool encode(Writing *w, const FfpImage *image, int quality) {
    w->jpeg.err = jpeg_std_error(&w->errors);
    w->errors.error_exit = on_error;
    if (setjmp(w->leave)) return false;
    jpeg_create_compress(&w->jpeg);
    jpeg_mem_dest(&w->jpeg, &w->bytes, &w->size);
    w->jpeg.image_width = (JDIMENSION)image->width, w->jpeg.image_height = (JDIMENSION)image->height;
    w->jpeg.input_components = 3, w->jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&w->jpeg);
    jpeg_set_quality(&w->jpeg, quality, TRUE);
    jpeg_start_compress(&w->jpeg, TRUE);
    for (int y = 0; y < image->height; y++) {
        take_row(image, y, w->row);
        jpeg_write_scanlines(&w->jpeg, &w->row, 1);
    }
    jpeg_finish_compress(&w->jpeg);
    return true;
}

bool ffp_image_write_jpeg(const FfpImage *image, int quality, const char *path, FfpError *err) {
    if (!image->data || image->channels != 3 || quality < 1 || quality > 100)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path,
                        "cannot write an image of %d channels as JPEG of quality %d", image->channels,
                        quality);
    Writing w = {.row = ffp_alloc((size_t)image->width, 3)};
    const bool ok = encode(&w, image, quality);
    jpeg_destroy_compress(&w.jpeg);
    ffp_free(w.row);
    if (!ok) {
        free(w.bytes);
        return ffp_fail(err, FFP_ERROR_IO, path, "cannot write JPEG: %s", w.message);
    }
    ffp_own(w.bytes, free);
    const bool written = ffp_write_file(path, w.bytes, w.size, err);
    ffp_disown(w.bytes);
    free(w.bytes);
    return written;
}
