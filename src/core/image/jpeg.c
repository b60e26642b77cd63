// JPEG through libjpeg-turbo. Its errors leave by longjmp, as libpng's do.
#include <jerror.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <jpeglib.h>
#include "core/base/arena.h"
#include "core/image/profile.h"

typedef struct Reading {
    struct jpeg_error_mgr errors; // first: libjpeg hands out pointers to it
    struct jpeg_decompress_struct jpeg;
    jmp_buf leave;
    unsigned char *pixels;         // [height, width, channels]; for `reduced`, a row of them
    size_t channels;               // 3: RGB, 4: CMYK
    const FfpReduction *reduction; // NULL: none
    FfpImage reduced;
    int orientation;
    bool no_memory;
    bool inverted; // CMYK that Adobe's programs wrote: 255 is not an ink
    char message[JMSG_LENGTH_MAX];
} Reading;

static void on_error(j_common_ptr jpeg) {
    Reading *reading = (Reading *)jpeg->err;
    jpeg->err->format_message(jpeg, reading->message);
    if (jpeg->err->msg_code == JERR_OUT_OF_MEMORY) reading->no_memory = true;
    longjmp(reading->leave, 1);
}

// Warnings are let pass (cameras write odd files), but for an end that comes too soon: half a picture is
// none.
static void on_message(j_common_ptr jpeg, int level) {
    if (level == -1 && jpeg->err->msg_code == JWRN_JPEG_EOF) on_error(jpeg);
}

bool ffp_jpeg_is(const FfpEncoded *file) {
    return file->size >= 3 && file->data[0] == 0xff && file->data[1] == 0xd8 && file->data[2] == 0xff;
}

// The orientation that the camera noted.
static int orientation_of(const Reading *r) {
    static const char mark[6] = "Exif\0";
    for (jpeg_saved_marker_ptr m = r->jpeg.marker_list; m != NULL; m = m->next) {
        if (m->data_length > sizeof mark && memcmp(m->data, mark, sizeof mark) == 0)
            return ffp_exif_orientation(m->data + sizeof mark, m->data_length - sizeof mark);
    }
    return 1;
}

// True if the file can hold the blocks of 8 x 8 that it claims. Each takes a bit at least; arithmetic coding,
// which cameras do not write, can put some fifty into one.
static bool has_bits(const struct jpeg_decompress_struct *jpeg, size_t size) {
    size_t blocks = 0;
    for (int c = 0; c < jpeg->num_components; c++)
        blocks += (size_t)jpeg->comp_info[c].width_in_blocks * jpeg->comp_info[c].height_in_blocks;
    return blocks / 8 / (jpeg->arith_code ? 64 : 1) <= size;
}

// Adds a row's light to the reduced picture's row that it belongs to.
static void add_row(Reading *r, int row, int shrink) {
    const real *light = r->reduction->light;
    const int width = (int)r->jpeg.output_width;
    real *to = r->reduced.data + (ptrdiff_t)3 * r->reduced.width * (row / shrink);
    const unsigned char *from = r->pixels;
    for (int i = 0; shrink == 1 && i < 3 * width; i++) to[i] = light[from[i]];
    for (int x = 0; shrink > 1 && x < width; to += 3)
        for (int end = x + shrink; x < end; x++, from += 3)
            for (int c = 0; c < 3; c++) to[c] += light[from[c]];
}

// Rows are summed as they come, so that no picture of the whole size is in memory.
static bool read_reduced(Reading *r) {
    const FfpReduction *reduction = r->reduction;
    int shrink = reduction->shrink;
    if (r->channels != 3) return true; // and `reduced` stays empty
    for (int k = 8; k > 1 && reduction->rough && r->jpeg.scale_denom == 1; k /= 2) {
        if (shrink % k != 0) continue;
        r->jpeg.scale_num = 1, r->jpeg.scale_denom = (unsigned)k;
        shrink /= k;
    }
    jpeg_start_decompress(&r->jpeg);
    const int width = (int)r->jpeg.output_width, height = (int)r->jpeg.output_height;
    r->reduced = (FfpImage){width / shrink, height / shrink, 3, NULL};
    r->reduced.data = (shrink == 1 ? ffp_try_take : ffp_try_alloc)(
        (size_t)r->reduced.width * (size_t)r->reduced.height, 3 * sizeof(real));
    r->pixels = ffp_try_alloc((size_t)width, 3);
    if (!r->pixels || !r->reduced.data) ERREXIT1(&r->jpeg, JERR_OUT_OF_MEMORY, 0);
    JSAMPROW row = r->pixels;
    for (int y = 0; y < height; y++) {
        jpeg_read_scanlines(&r->jpeg, &row, 1);
        add_row(r, y, shrink);
    }
    jpeg_finish_decompress(&r->jpeg);
    for (ptrdiff_t i = 0; shrink > 1 && i < (ptrdiff_t)3 * r->reduced.width * r->reduced.height; i++)
        r->reduced.data[i] /= (real)(shrink * shrink);
    return true;
}

static bool read_jpeg(Reading *r, const FfpEncoded *file, bool with_pixels) {
    r->jpeg.err = jpeg_std_error(&r->errors);
    r->errors.error_exit = on_error;
    r->errors.emit_message = on_message;
    if (setjmp(r->leave)) return false;
    jpeg_create_decompress(&r->jpeg);
    jpeg_mem_src(&r->jpeg, file->data, file->size);
    jpeg_save_markers(&r->jpeg, JPEG_APP0 + 1, 0xffff); // EXIF
    jpeg_read_header(&r->jpeg, TRUE);
    r->orientation = orientation_of(r);
    if (!with_pixels) return true;
    if (!has_bits(&r->jpeg, file->size)) {
        snprintf(r->message, sizeof r->message, "the file is too short for its picture");
        return false;
    }
    const bool inks = r->jpeg.jpeg_color_space == JCS_CMYK || r->jpeg.jpeg_color_space == JCS_YCCK;
    r->channels = inks ? 4 : 3;
    r->inverted = inks && r->jpeg.saw_Adobe_marker;
    r->jpeg.out_color_space = inks ? JCS_CMYK : JCS_RGB;
    if (r->reduction) return read_reduced(r);
    jpeg_start_decompress(&r->jpeg);
    const size_t stride = (size_t)r->jpeg.output_width * r->channels;
    r->pixels = ffp_try_alloc(r->jpeg.output_height, stride);
    if (!r->pixels) ERREXIT1(&r->jpeg, JERR_OUT_OF_MEMORY, 0);
    while (r->jpeg.output_scanline < r->jpeg.output_height) {
        JSAMPROW row = r->pixels + r->jpeg.output_scanline * stride;
        jpeg_read_scanlines(&r->jpeg, &row, 1);
    }
    jpeg_finish_decompress(&r->jpeg);
    return true;
}

static bool broken(const Reading *r, const FfpEncoded *file, FfpError *err) {
    if (r->no_memory) return ffp_fail(err, FFP_ERROR_MEMORY, file->path, "out of memory");
    return ffp_fail(err, FFP_ERROR_FILE, file->path, "broken JPEG: %s", r->message);
}

bool ffp_jpeg_size(const FfpEncoded *file, int *width, int *height, FfpError *err) {
    Reading r = {0};
    const bool ok = read_jpeg(&r, file, false);
    const long long w = r.jpeg.image_width, h = r.jpeg.image_height;
    jpeg_destroy_decompress(&r.jpeg);
    if (!ok) return broken(&r, file, err);
    if (!ffp_check_sides(w, h, file->path, err)) return false;
    *width = (int)w;
    *height = (int)h;
    ffp_orient_size(width, height, r.orientation);
    return true;
}

// Inks without a profile: each takes away its share of the light.
static void take_pixel(const Reading *r, const unsigned char *from, real *to) {
    for (size_t c = 0; c < 3; c++) {
        if (r->channels == 3)
            to[c] = (real)from[c] / 255;
        else if (r->inverted)
            to[c] = (real)(from[c] * from[3]) / (255 * 255);
        else
            to[c] = (real)((255 - from[c]) * (255 - from[3])) / (255 * 255);
    }
    to[3] = 1;
}

bool ffp_jpeg_decode(const FfpEncoded *file, FfpDecoded *out, FfpError *err) {
    int width = 0, height = 0;
    if (!ffp_jpeg_size(file, &width, &height, err)) return false; // before memory is taken for the pixels
    Reading r = {0};
    const bool ok = read_jpeg(&r, file, true);
    out->orientation = r.orientation;
    width = (int)r.jpeg.image_width; // as stored
    height = (int)r.jpeg.image_height;
    jpeg_destroy_decompress(&r.jpeg);
    if (!ok) {
        ffp_free(r.pixels);
        return broken(&r, file, err);
    }
    out->image = ffp_image_new(width, height, 4);
    const size_t pixels = (size_t)width * (size_t)height;
    FfpColourProfile profile = {0};
    out->inks = r.channels == 4;
    if (out->inks) profile = ffp_profile_find(file);
    if (!ffp_profile_inks(&profile, r.pixels, r.inverted, &out->image, file->path))
        for (size_t i = 0; i < pixels; i++)
            take_pixel(&r, r.pixels + r.channels * i, out->image.data + 4 * i);
    ffp_free(profile.icc);
    ffp_free(r.pixels);
    return true;
}

bool ffp_jpeg_decode_reduced(const FfpEncoded *file, const FfpReduction *reduction, FfpDecoded *out,
                             FfpError *err) {
    int width = 0, height = 0;
    if (!ffp_jpeg_size(file, &width, &height, err)) return false;
    Reading r = {.reduction = reduction};
    const bool ok = read_jpeg(&r, file, true);
    out->orientation = r.orientation;
    jpeg_destroy_decompress(&r.jpeg);
    ffp_free(r.pixels);
    if (!ok) {
        ffp_free(r.reduced.data);
        return broken(&r, file, err);
    }
    out->image = r.reduced;
    return true;
}
