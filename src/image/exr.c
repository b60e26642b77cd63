// OpenEXR through its C core: scanline images of half or float channels, one part, no subsampling.
#include <math.h>
#include <openexr.h>
#include <stdlib.h>
#include <string.h>

#include "base/arena.h"
#include "base/file.h"
#include "image/codec.h"

bool ffp_exr_is(const FfpBytes *file) {
    return file->size >= 4 && memcmp(file->data, "\x76\x2f\x31\x01", 4) == 0;
}

// --- The file as a stream of the library's. ---

static int64_t give_bytes(exr_const_context_t exr, void *user, void *to, uint64_t count, uint64_t offset,
                          exr_stream_error_func_ptr_t on_stream_error) {
    (void)exr;
    (void)on_stream_error;
    const FfpBytes *file = user;
    if (offset >= file->size) return 0;
    const uint64_t left = file->size - offset, given = count < left ? count : left;
    memcpy(to, file->data + offset, given);
    return (int64_t)given;
}

static int64_t give_size(exr_const_context_t exr, void *user) {
    (void)exr;
    return (int64_t)((const FfpBytes *)user)->size;
}

// The library calls this from many places; the first words are the ones nearest to the cause, and results
// tell the rest.
static void keep_quiet(exr_const_context_t exr, exr_result_t code, const char *message) {
    (void)exr;
    (void)code;
    (void)message;
}

typedef struct Reading {
    exr_context_t exr;
    int width, height, first_line, lines_per_chunk;
    const exr_attr_chlist_t *channels;
} Reading;

static bool broken(const FfpBytes *file, exr_result_t code, FfpError *err) {
    return ffp_fail(err, file->path, "broken EXR: %s", exr_get_default_error_message(code));
}

static bool open_exr(Reading *r, const FfpBytes *file, FfpError *err) {
    *r = (Reading){0};
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = keep_quiet;
    settings.user_data = (void *)file;
    settings.read_fn = give_bytes;
    settings.size_fn = give_size;
    exr_result_t code = exr_start_read(&r->exr, file->path, &settings);
    exr_storage_t storage = EXR_STORAGE_LAST_TYPE;
    exr_attr_box2i_t window = {0};
    if (code == EXR_ERR_SUCCESS) code = exr_get_storage(r->exr, 0, &storage);
    if (code == EXR_ERR_SUCCESS) code = exr_get_data_window(r->exr, 0, &window);
    if (code == EXR_ERR_SUCCESS) code = exr_get_channels(r->exr, 0, &r->channels);
    if (code != EXR_ERR_SUCCESS) return broken(file, code, err);
    if (storage != EXR_STORAGE_SCANLINE)
        return ffp_fail(err, file->path, "tiled and deep EXR images are not read");
    const long long width = (long long)window.max.x - window.min.x + 1,
                    height = (long long)window.max.y - window.min.y + 1;
    if (!ffp_check_sides(width, height, file->path, err)) return false;
    r->width = (int)width;
    r->height = (int)height;
    r->first_line = window.min.y;
    code = exr_get_scanlines_per_chunk(r->exr, 0, &r->lines_per_chunk);
    if (code != EXR_ERR_SUCCESS || r->lines_per_chunk < 1) return broken(file, code, err);
    return true;
}

static int find_channel(const Reading *r, const char *name) {
    for (int i = 0; i < r->channels->num_channels; i++) {
        if (strcmp(r->channels->entries[i].name.str, name) == 0) return i;
    }
    return -1;
}

// Tells the decoder where each wanted channel of this chunk goes: planes[k] for channel wanted[k].
static void aim(exr_decode_pipeline_t *decoder, const Reading *r, const int *wanted, int n,
                float *const *planes, int line) {
    for (int c = 0; c < decoder->channel_count; c++) {
        exr_coding_channel_info_t *channel = &decoder->channels[c];
        channel->decode_to_ptr = NULL;
        for (int k = 0; k < n; k++) {
            if (strcmp(channel->channel_name, r->channels->entries[wanted[k]].name.str) != 0) continue;
            channel->decode_to_ptr = (uint8_t *)(planes[k] + (size_t)line * (size_t)r->width);
            channel->user_data_type = EXR_PIXEL_FLOAT;
            channel->user_bytes_per_element = sizeof(float);
            channel->user_pixel_stride = sizeof(float);
            channel->user_line_stride = (int32_t)((size_t)r->width * sizeof(float));
        }
    }
}

static exr_result_t decode_chunks(const Reading *r, const int *wanted, int n, float *const *planes) {
    exr_decode_pipeline_t decoder = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_result_t code = EXR_ERR_SUCCESS;
    for (int line = 0; line < r->height && code == EXR_ERR_SUCCESS; line += r->lines_per_chunk) {
        exr_chunk_info_t chunk;
        code = exr_read_scanline_chunk_info(r->exr, 0, r->first_line + line, &chunk);
        if (code != EXR_ERR_SUCCESS) break;
        code = line == 0 ? exr_decoding_initialize(r->exr, 0, &chunk, &decoder)
                         : exr_decoding_update(r->exr, 0, &chunk, &decoder);
        if (code != EXR_ERR_SUCCESS) break;
        aim(&decoder, r, wanted, n, planes, line);
        if (line == 0) code = exr_decoding_choose_default_routines(r->exr, 0, &decoder);
        if (code == EXR_ERR_SUCCESS) code = exr_decoding_run(r->exr, 0, &decoder);
    }
    exr_decoding_destroy(r->exr, &decoder);
    return code;
}

// Decodes the n wanted channels into `out` (n channels, interleaved).
static bool decode_channels(const Reading *r, const FfpBytes *file, const int *wanted, int n, FfpImage *out,
                            FfpError *err) {
    for (int k = 0; k < n; k++) {
        const exr_attr_chlist_entry_t *channel = &r->channels->entries[wanted[k]];
        if (channel->pixel_type == EXR_PIXEL_UINT || channel->x_sampling != 1 || channel->y_sampling != 1) {
            return ffp_fail(err, file->path, "EXR channel %s is subsampled or of integers",
                            channel->name.str);
        }
    }
    const size_t pixels = (size_t)r->width * (size_t)r->height;
    float *planes[4];
    for (int k = 0; k < n; k++) planes[k] = ffp_alloc(pixels, sizeof(float));
    const exr_result_t code = decode_chunks(r, wanted, n, planes);
    bool finite = true;
    if (code == EXR_ERR_SUCCESS) *out = ffp_image_new(r->width, r->height, n);
    for (int k = 0; k < n; k++) {
        for (size_t i = 0; i < pixels && code == EXR_ERR_SUCCESS; i++) {
            finite = finite && isfinite(planes[k][i]);
            out->data[i * (size_t)n + (size_t)k] = (real)planes[k][i];
        }
        free(planes[k]);
    }
    if (code != EXR_ERR_SUCCESS) return broken(file, code, err);
    if (finite) return true;
    ffp_image_free(out);
    return ffp_fail(err, file->path, "EXR holds values that are not finite");
}

// RGB, or grey as all three; alpha 1 where there is none.
static FfpImage to_rgba(const FfpImage *image, bool has_alpha) {
    FfpImage out = ffp_image_new(image->width, image->height, 4);
    const size_t pixels = (size_t)image->width * (size_t)image->height, n = (size_t)image->channels;
    const size_t colours = has_alpha ? n - 1 : n;
    for (size_t i = 0; i < pixels; i++) {
        for (size_t c = 0; c < 3; c++) out.data[4 * i + c] = image->data[n * i + (c < colours ? c : 0)];
        out.data[4 * i + 3] = has_alpha ? image->data[n * i + n - 1] : 1;
    }
    return out;
}

static bool decode_rgba(const Reading *r, const FfpBytes *file, FfpDecoded *out, FfpError *err) {
    static const char *const rgb[3] = {"R", "G", "B"};
    int wanted[4], n = 0;
    for (int c = 0; c < 3; c++) {
        const int channel = find_channel(r, rgb[c]);
        if (channel >= 0) wanted[n++] = channel;
    }
    const int grey = find_channel(r, "Y"), alpha = find_channel(r, "A");
    if (n == 0 && grey >= 0) wanted[n++] = grey;
    if (n != 1 && n != 3) return ffp_fail(err, file->path, "EXR has neither channels R, G, B nor Y");
    if (alpha >= 0) wanted[n++] = alpha;
    FfpImage image = {0};
    if (!decode_channels(r, file, wanted, n, &image, err)) return false;
    out->image = to_rgba(&image, alpha >= 0);
    out->has_alpha = alpha >= 0;
    out->linear = true;
    ffp_image_free(&image);
    return true;
}

bool ffp_exr_size(const FfpBytes *file, int *width, int *height, FfpError *err) {
    Reading r;
    const bool ok = open_exr(&r, file, err);
    *width = r.width;
    *height = r.height;
    exr_finish(&r.exr);
    return ok;
}

bool ffp_exr_decode(const FfpBytes *file, FfpDecoded *out, FfpError *err) {
    Reading r;
    const bool ok = open_exr(&r, file, err) && decode_rgba(&r, file, out, err);
    exr_finish(&r.exr);
    return ok;
}

bool ffp_exr_decode_raw(const FfpBytes *file, FfpImage *out, FfpError *err) {
    Reading r;
    bool ok = open_exr(&r, file, err);
    if (ok) {
        int channel = find_channel(&r, "Z");
        if (channel < 0) channel = find_channel(&r, "Y");
        if (channel < 0) channel = 0;
        ok = r.channels->num_channels > 0 ? decode_channels(&r, file, &channel, 1, out, err)
                                          : ffp_fail(err, file->path, "EXR has no channels");
    }
    exr_finish(&r.exr);
    return ok;
}

// --- Writing: ZIP-compressed float scanlines. ---

static int64_t take_bytes(exr_const_context_t exr, void *user, const void *from, uint64_t count,
                          uint64_t offset, exr_stream_error_func_ptr_t on_stream_error) {
    (void)exr;
    (void)on_stream_error;
    FILE *stream = user;
    if (fseek(stream, (long)offset, SEEK_SET) != 0) return -1;
    return fwrite(from, 1, count, stream) == count ? (int64_t)count : -1;
}

static const char *channel_name(int channels, int channel) {
    return channels == 1 ? "Z" : (const char *[]){"R", "G", "B", "A"}[channel];
}

static exr_result_t write_header(exr_context_t exr, const FfpImage *image) {
    int part = 0;
    exr_result_t code = exr_add_part(exr, "image", EXR_STORAGE_SCANLINE, &part);
    if (code != EXR_ERR_SUCCESS) return code;
    code = exr_initialize_required_attr_simple(exr, part, image->width, image->height, EXR_COMPRESSION_ZIP);
    for (int c = 0; c < image->channels && code == EXR_ERR_SUCCESS; c++) {
        code = exr_add_channel(exr, part, channel_name(image->channels, c), EXR_PIXEL_FLOAT,
                               EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    }
    return code == EXR_ERR_SUCCESS ? exr_write_header(exr) : code;
}

static exr_result_t write_chunks(exr_context_t exr, const FfpImage *image, const float *values) {
    const size_t n = (size_t)image->channels, row = (size_t)image->width * n;
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    int lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(exr, 0, &lines);
    for (int line = 0; line < image->height && code == EXR_ERR_SUCCESS; line += lines) {
        exr_chunk_info_t chunk;
        code = exr_write_scanline_chunk_info(exr, 0, line, &chunk);
        if (code != EXR_ERR_SUCCESS) break;
        code = line == 0 ? exr_encoding_initialize(exr, 0, &chunk, &encoder)
                         : exr_encoding_update(exr, 0, &chunk, &encoder);
        if (code != EXR_ERR_SUCCESS) break;
        for (int c = 0; c < encoder.channel_count; c++) {
            exr_coding_channel_info_t *channel = &encoder.channels[c];
            size_t source = 0;
            while (source < n - 1 && strcmp(channel->channel_name, channel_name((int)n, (int)source)) != 0)
                source++;
            channel->encode_from_ptr = (const uint8_t *)(values + (size_t)line * row + source);
            channel->user_data_type = EXR_PIXEL_FLOAT;
            channel->user_bytes_per_element = sizeof(float);
            channel->user_pixel_stride = (int32_t)(n * sizeof(float));
            channel->user_line_stride = (int32_t)(row * sizeof(float));
        }
        if (line == 0) code = exr_encoding_choose_default_routines(exr, 0, &encoder);
        if (code == EXR_ERR_SUCCESS) code = exr_encoding_run(exr, 0, &encoder);
    }
    exr_encoding_destroy(exr, &encoder);
    return code;
}

static exr_result_t write_exr(FfpOutput *out, const FfpImage *image, const float *values) {
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = keep_quiet;
    settings.user_data = out->stream;
    settings.write_fn = take_bytes;
    settings.zip_level = 3; // one percent larger than zlib's own level, in two thirds of the time
    exr_context_t exr = NULL;
    exr_result_t code = exr_start_write(&exr, out->path, EXR_WRITE_FILE_DIRECTLY, &settings);
    if (code == EXR_ERR_SUCCESS) code = write_header(exr, image);
    if (code == EXR_ERR_SUCCESS) code = write_chunks(exr, image, values);
    const exr_result_t closed = exr_finish(&exr); // writes the table of chunks
    return code == EXR_ERR_SUCCESS ? closed : code;
}

bool ffp_image_write_exr(const FfpImage *image, const char *path, FfpError *err) {
    const int n = image->channels;
    if (image->data == NULL || (n != 1 && n != 3 && n != 4)) {
        return ffp_fail(err, path, "cannot write an image of %d channels as EXR", n);
    }
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) return false;
    const size_t count = (size_t)image->width * (size_t)image->height * (size_t)n;
    float *values = ffp_alloc(count, sizeof(float));
    for (size_t i = 0; i < count; i++) values[i] = (float)image->data[i];
    const exr_result_t code = write_exr(&out, image, values);
    free(values);
    if (code == EXR_ERR_SUCCESS) return ffp_output_commit(&out, err);
    ffp_output_abort(&out);
    return ffp_fail(err, path, "cannot write EXR: %s", exr_get_default_error_message(code));
}
