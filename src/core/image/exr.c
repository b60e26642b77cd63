// OpenEXR through its C core: half or float channels in lines or tiles, without subsampling. Of several parts
// and layers those are taken that fit.
#include <math.h>
#include <openexr.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/image/codec.h"

bool ffp_exr_is(const FfpEncoded *file) {
    return file->size >= 4 && memcmp(file->data, "\x76\x2f\x31\x01", 4) == 0;
}

// --- The file as a stream of the library's. ---

static int64_t give_bytes(exr_const_context_t exr, void *user, void *to, uint64_t count, uint64_t offset,
                          exr_stream_error_func_ptr_t on_stream_error) {
    (void)exr;
    (void)on_stream_error;
    const FfpEncoded *file = user;
    if (offset >= file->size) return 0;
    const uint64_t left = file->size - offset, given = count < left ? count : left;
    memcpy(to, file->data + offset, given);
    return (int64_t)given;
}

static int64_t give_size(exr_const_context_t exr, void *user) {
    (void)exr;
    return (int64_t)((const FfpEncoded *)user)->size;
}

// The library calls this from many places; the first words are the ones nearest to the cause, and results
// tell the rest.
static void keep_quiet(exr_const_context_t exr, exr_result_t code, const char *message) {
    (void)exr;
    (void)code;
    (void)message;
}

#define WANTED_MAX 4
#define CHANNELS_MAX 1024 // of a part: names are compared with each other

typedef struct Reading {
    exr_context_t exr;
    int part;
    bool tiled;
    int width, height, first_line;
    int chunk_width, chunk_height; // of a tile, or of some lines
    const exr_attr_chlist_t *channels;
    int wanted[WANTED_MAX], n_wanted; // indices of channels
    bool has_alpha;                   // the last of them
    bool guessed;                     // the first of several layers
} Reading;

static bool broken(const FfpEncoded *file, exr_result_t code, FfpError *err) {
    return ffp_fail(err, FFP_ERROR_FILE, file->path, "broken EXR: %s", exr_get_default_error_message(code));
}

// --- Which channels. A layer is what a channel's name has before its last dot, and with it. ---

static const char *name_of(const Reading *r, int channel) {
    return r->channels->entries[channel].name.str;
}

static size_t layer_length(const char *name) {
    const char *dot = strrchr(name, '.');
    return dot ? (size_t)(dot - name) + 1 : 0;
}

// The channel `letter` of the layer that the channel `name` is of ("": of none), or -1.
static int find_channel(const Reading *r, const char *name, const char *letter) {
    const size_t length = layer_length(name);
    for (int i = 0; i < r->channels->num_channels; i++) {
        const char *other = name_of(r, i);
        if (layer_length(other) == length && strncmp(other, name, length) == 0 &&
            strcmp(other + length, letter) == 0)
            return i;
    }
    return -1;
}

// True if the layer's own name, without those of the groups it is in, is this.
static bool is_layer(const char *name, const char *layer) {
    const size_t length = layer_length(name), wanted = strlen(layer);
    return length > wanted && memcmp(name + length - 1 - wanted, layer, wanted) == 0 &&
           (length == wanted + 1 || name[length - 2 - wanted] == '.');
}

// R, G, B of a layer, otherwise its Y, and A; one colour alone counts as grey, outside of layers.
static bool want_colours(Reading *r, const char *name, bool grey) {
    static const char *const rgb[3] = {"R", "G", "B"};
    r->n_wanted = 0;
    for (int c = 0; c < 3; c++) {
        const int channel = find_channel(r, name, rgb[c]);
        if (channel >= 0) r->wanted[r->n_wanted++] = channel;
    }
    const int y = find_channel(r, name, "Y"), alpha = find_channel(r, name, "A");
    const bool vector = *name != 0 && find_channel(r, name, "X") >= 0;
    if (r->n_wanted == 0 && grey && y >= 0 && !vector) r->wanted[r->n_wanted++] = y;
    r->has_alpha = alpha >= 0;
    if (r->n_wanted != 3 && !(r->n_wanted == 1 && grey)) return false;
    if (r->has_alpha) r->wanted[r->n_wanted++] = alpha;
    return true;
}

static bool same_layer(const char *a, const char *b) {
    const size_t length = layer_length(a);
    return layer_length(b) == length && strncmp(a, b, length) == 0;
}

// The first layer of colours in the order of the channels' names.
static bool choose_layer(Reading *r, bool grey) {
    int first = -1;
    for (int i = 0; i < r->channels->num_channels; i++) {
        if (!want_colours(r, name_of(r, i), grey)) continue;
        if (first < 0) first = i;
        r->guessed = r->guessed || !same_layer(name_of(r, i), name_of(r, first));
    }
    return first >= 0 && want_colours(r, name_of(r, first), grey);
}

// The colours outside of any layer; otherwise those of Blender's layer "Combined"; otherwise of the first.
static bool choose_colours(Reading *r) {
    if (want_colours(r, "", true)) return true;
    for (int i = 0; i < r->channels->num_channels; i++)
        if (is_layer(name_of(r, i), "Combined") && want_colours(r, name_of(r, i), false)) return true;
    return choose_layer(r, false) || choose_layer(r, true);
}

static bool want_one(Reading *r, int channel) {
    if (channel < 0) return false;
    r->wanted[0] = channel;
    r->n_wanted = 1;
    return true;
}

// Z or Y outside of any layer; otherwise Z, V or Y of a layer "Depth", otherwise Z or Y of any that is not a
// vector's.
static bool choose_depth(Reading *r) {
    if (want_one(r, find_channel(r, "", "Z")) || want_one(r, find_channel(r, "", "Y"))) return true;
    for (int any = 0; any < 2; any++) {
        for (int i = 0; i < r->channels->num_channels; i++) {
            const char *name = name_of(r, i), *letter = name + layer_length(name);
            const bool fits =
                strcmp(letter, "Z") == 0 || strcmp(letter, "Y") == 0 || (!any && strcmp(letter, "V") == 0);
            if (fits && (any || is_layer(name, "Depth")) && find_channel(r, name, "X") < 0)
                return want_one(r, i);
        }
    }
    return false;
}

static bool choose_first(Reading *r) {
    return r->channels->num_channels > 0 && want_one(r, 0);
}

// --- Which part. ---

typedef bool Choose(Reading *r);

// Looks at a part; *readable: it is not a deep one and of no absurd number of channels.
static exr_result_t look_at_part(Reading *r, int part, bool *readable) {
    exr_storage_t storage = EXR_STORAGE_LAST_TYPE;
    r->part = part;
    r->guessed = false;
    exr_result_t code = exr_get_storage(r->exr, part, &storage);
    if (code == EXR_ERR_SUCCESS) code = exr_get_channels(r->exr, part, &r->channels);
    r->tiled = storage == EXR_STORAGE_TILED;
    *readable = code == EXR_ERR_SUCCESS && (storage == EXR_STORAGE_SCANLINE || r->tiled) &&
                r->channels->num_channels <= CHANNELS_MAX;
    return code;
}

// The first part in which `choose` finds its channels; *found tells whether there is one.
static bool find_part(Reading *r, const FfpEncoded *file, Choose *choose, bool *found, FfpError *err) {
    int parts = 0;
    exr_result_t code = exr_get_count(r->exr, &parts);
    *found = false;
    for (int p = 0; p < parts && code == EXR_ERR_SUCCESS && !*found; p++) {
        bool readable = false;
        code = look_at_part(r, p, &readable);
        *found = readable && choose(r);
    }
    return code == EXR_ERR_SUCCESS || broken(file, code, err);
}

static bool measure_part(Reading *r, const FfpEncoded *file, FfpError *err) {
    exr_attr_box2i_t window = {0};
    exr_result_t code = exr_get_data_window(r->exr, r->part, &window);
    if (code != EXR_ERR_SUCCESS) return broken(file, code, err);
    const long long width = (long long)window.max.x - window.min.x + 1,
                    height = (long long)window.max.y - window.min.y + 1;
    if (!ffp_check_sides(width, height, file->path, err)) return false;
    r->width = (int)width;
    r->height = (int)height;
    r->first_line = window.min.y;
    r->chunk_width = r->width;
    code = r->tiled ? exr_get_tile_sizes(r->exr, r->part, 0, 0, &r->chunk_width, &r->chunk_height)
                    : exr_get_scanlines_per_chunk(r->exr, r->part, &r->chunk_height);
    if (code == EXR_ERR_SUCCESS && (r->chunk_width < 1 || r->chunk_height < 1)) code = EXR_ERR_INVALID_ATTR;
    return code == EXR_ERR_SUCCESS || broken(file, code, err);
}

static void finish(void *exr) {
    exr_context_t context = exr;
    exr_finish(&context);
}

static void close_exr(Reading *r) {
    ffp_disown(r->exr);
    exr_finish(&r->exr);
}

// Takes the first of the n choices that some part meets. r->exr is to be finished whatever comes of it.
static bool open_exr(Reading *r, const FfpEncoded *file, Choose *const *choices, int n, FfpError *err) {
    *r = (Reading){0};
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = keep_quiet;
    settings.user_data = (void *)file;
    settings.read_fn = give_bytes;
    settings.size_fn = give_size;
    settings.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    const exr_result_t code = exr_start_read(&r->exr, file->path, &settings);
    if (r->exr) ffp_own(r->exr, finish);
    if (code != EXR_ERR_SUCCESS) return broken(file, code, err);
    bool found = false;
    for (int i = 0; i < n && !found; i++) {
        if (!find_part(r, file, choices[i], &found, err)) return false;
    }
    if (found) return measure_part(r, file, err);
    bool readable = false;
    look_at_part(r, 0, &readable);
    if (!readable)
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, file->path, "deep EXR images are not supported");
    return ffp_fail(err, FFP_ERROR_FILE, file->path,
                    "EXR has neither the channels R, G and B nor the channel Y");
}

// --- Pixels. ---

// The chunk in this column and row of chunks.
static exr_result_t find_chunk(const Reading *r, int column, int row, exr_chunk_info_t *chunk) {
    return r->tiled
               ? exr_read_tile_chunk_info(r->exr, r->part, column, row, 0, 0, chunk)
               : exr_read_scanline_chunk_info(r->exr, r->part, r->first_line + row * r->chunk_height, chunk);
}

// All chunks must be within the file and the picture: known before memory is taken for it.
static bool check_chunks(const Reading *r, const FfpEncoded *file, FfpError *err) {
    for (int row = 0; row * r->chunk_height < r->height; row++) {
        for (int column = 0; column * r->chunk_width < r->width; column++) {
            exr_chunk_info_t chunk;
            exr_result_t code = find_chunk(r, column, row, &chunk);
            if (code == EXR_ERR_SUCCESS &&
                (chunk.width > r->width - column * r->chunk_width ||
                 chunk.height > r->height - row * r->chunk_height || chunk.data_offset > file->size ||
                 chunk.packed_size > file->size - chunk.data_offset))
                code = EXR_ERR_BAD_CHUNK_LEADER;
            if (code != EXR_ERR_SUCCESS) return broken(file, code, err);
        }
    }
    return true;
}

// Tells the decoder where each wanted channel of the chunk at (x, y) goes: planes[k] for channel wanted[k].
// The others go to `spare`, of a chunk's lines: the library's fast paths do not ask whether there is a place
// for them.
static void aim(exr_decode_pipeline_t *decoder, const Reading *r, float *const *planes, float *spare, int x,
                int y) {
    for (int c = 0; c < decoder->channel_count; c++) {
        exr_coding_channel_info_t *channel = &decoder->channels[c];
        float *to = spare;
        for (int k = 0; k < r->n_wanted; k++) {
            if (strcmp(channel->channel_name, name_of(r, r->wanted[k])) == 0)
                to = planes[k] + (size_t)y * (size_t)r->width + x;
        }
        channel->decode_to_ptr = (uint8_t *)to;
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = (int32_t)((size_t)r->width * sizeof(float));
    }
}

static exr_result_t decode_chunks(const Reading *r, float *const *planes) {
    exr_decode_pipeline_t decoder = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_result_t code = EXR_ERR_SUCCESS;
    const int lines = r->chunk_height < r->height ? r->chunk_height : r->height;
    float *spare = ffp_alloc((size_t)lines * (size_t)r->width, sizeof *spare);
    for (int row = 0; row * r->chunk_height < r->height && code == EXR_ERR_SUCCESS; row++) {
        for (int column = 0; column * r->chunk_width < r->width && code == EXR_ERR_SUCCESS; column++) {
            exr_chunk_info_t chunk;
            const bool first = column == 0 && row == 0;
            code = find_chunk(r, column, row, &chunk);
            if (code == EXR_ERR_SUCCESS)
                code = first ? exr_decoding_initialize(r->exr, r->part, &chunk, &decoder)
                             : exr_decoding_update(r->exr, r->part, &chunk, &decoder);
            if (code != EXR_ERR_SUCCESS) break;
            aim(&decoder, r, planes, spare, column * r->chunk_width, row * r->chunk_height);
            if (first) code = exr_decoding_choose_default_routines(r->exr, r->part, &decoder);
            if (code == EXR_ERR_SUCCESS) code = exr_decoding_run(r->exr, r->part, &decoder);
        }
    }
    exr_decoding_destroy(r->exr, &decoder);
    ffp_free(spare);
    return code;
}

// Decodes the wanted channels into `out`, interleaved.
static bool decode_channels(const Reading *r, const FfpEncoded *file, FfpImage *out, FfpError *err) {
    const int n = r->n_wanted;
    for (int k = 0; k < n; k++) {
        const exr_attr_chlist_entry_t *channel = &r->channels->entries[r->wanted[k]];
        if (channel->pixel_type == EXR_PIXEL_UINT || channel->x_sampling != 1 || channel->y_sampling != 1) {
            return ffp_fail(err, FFP_ERROR_FILE, file->path, "EXR channel %s is subsampled or holds integers",
                            channel->name.str);
        }
    }
    if (!check_chunks(r, file, err)) return false;
    const size_t pixels = (size_t)r->width * (size_t)r->height;
    float *planes[WANTED_MAX] = {NULL};
    for (int k = 0; k < n; k++) planes[k] = ffp_alloc(pixels, sizeof(float));
    const exr_result_t code = decode_chunks(r, planes);
    bool finite = true;
    if (code == EXR_ERR_SUCCESS) *out = ffp_image_new(r->width, r->height, n);
    for (int k = 0; k < n; k++) {
        for (size_t i = 0; i < pixels && code == EXR_ERR_SUCCESS; i++) {
            finite = finite && isfinite(planes[k][i]);
            out->data[i * (size_t)n + (size_t)k] = (real)planes[k][i];
        }
        ffp_free(planes[k]);
    }
    if (code != EXR_ERR_SUCCESS) return broken(file, code, err);
    if (finite) return true;
    ffp_image_free(out);
    return ffp_fail(err, FFP_ERROR_FILE, file->path, "EXR holds values that are not finite");
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

static void say_layer(const Reading *r, const FfpEncoded *file) {
    const char *name = name_of(r, r->wanted[0]);
    if (r->guessed) ffp_note("%s: several layers; using %.*s", file->path, (int)layer_length(name) - 1, name);
}

bool ffp_exr_size(const FfpEncoded *file, int *width, int *height, FfpError *err) {
    Choose *const choices[3] = {choose_colours, choose_depth, choose_first};
    Reading r;
    const bool ok = open_exr(&r, file, choices, 3, err);
    *width = r.width;
    *height = r.height;
    close_exr(&r);
    return ok;
}

bool ffp_exr_decode(const FfpEncoded *file, FfpDecoded *out, FfpError *err) {
    Choose *const choices[1] = {choose_colours};
    Reading r;
    FfpImage image = {0};
    const bool ok = open_exr(&r, file, choices, 1, err) && decode_channels(&r, file, &image, err);
    if (ok) {
        say_layer(&r, file);
        out->image = to_rgba(&image, r.has_alpha);
        out->has_alpha = r.has_alpha;
        out->linear = true;
    }
    ffp_image_free(&image);
    close_exr(&r);
    return ok;
}

bool ffp_exr_decode_raw(const FfpEncoded *file, FfpDecoded *out, FfpError *err) {
    Choose *const choices[2] = {choose_depth, choose_first};
    Reading r;
    const bool ok = open_exr(&r, file, choices, 2, err) && decode_channels(&r, file, &out->image, err);
    close_exr(&r);
    return ok;
}

// --- Writing: ZIP-compressed float scanlines. ---

enum { ZIP_LINES = 16 }; // of a chunk

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

typedef exr_result_t Compress(exr_encode_pipeline_t *encoder);

// The library keeps a chunk as it was if that is smaller than its compressed form, but not if both have one
// size, which readers take for a chunk as it was (OpenEXR 3.1.5).
static exr_result_t compress(exr_encode_pipeline_t *encoder) {
    Compress *const *usual = encoder->encoding_user_data;
    const exr_result_t code = (*usual)(encoder);
    if (code == EXR_ERR_SUCCESS && encoder->compressed_bytes == encoder->packed_bytes)
        memcpy(encoder->compressed_buffer, encoder->packed_buffer, encoder->packed_bytes);
    return code;
}

static void convert(const FfpImage *image, int line, int lines, float *values) {
    const size_t row = (size_t)image->width * (size_t)image->channels;
    const real *from = image->data + (size_t)line * row;
    const size_t count = (size_t)(lines < image->height - line ? lines : image->height - line) * row;
    for (size_t i = 0; i < count; i++) values[i] = (float)from[i];
}

// `values`: room for a chunk.
static exr_result_t write_chunks(exr_context_t exr, const FfpImage *image, float *values) {
    const size_t n = (size_t)image->channels, row = (size_t)image->width * n;
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    Compress *usual = NULL;
    int lines = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(exr, 0, &lines);
    if (code == EXR_ERR_SUCCESS && (lines < 1 || lines > ZIP_LINES)) code = EXR_ERR_INVALID_ATTR;
    for (int line = 0; line < image->height && code == EXR_ERR_SUCCESS; line += lines) {
        exr_chunk_info_t chunk;
        code = exr_write_scanline_chunk_info(exr, 0, line, &chunk);
        if (code != EXR_ERR_SUCCESS) break;
        code = line == 0 ? exr_encoding_initialize(exr, 0, &chunk, &encoder)
                         : exr_encoding_update(exr, 0, &chunk, &encoder);
        if (code != EXR_ERR_SUCCESS) break;
        convert(image, line, lines, values);
        for (int c = 0; c < encoder.channel_count; c++) {
            exr_coding_channel_info_t *channel = &encoder.channels[c];
            size_t source = 0;
            while (source < n - 1 && strcmp(channel->channel_name, channel_name((int)n, (int)source)) != 0)
                source++;
            channel->encode_from_ptr = (const uint8_t *)(values + source);
            channel->user_data_type = EXR_PIXEL_FLOAT;
            channel->user_bytes_per_element = sizeof(float);
            channel->user_pixel_stride = (int32_t)(n * sizeof(float));
            channel->user_line_stride = (int32_t)(row * sizeof(float));
        }
        if (line == 0) {
            code = exr_encoding_choose_default_routines(exr, 0, &encoder);
            usual = encoder.compress_fn;
            encoder.compress_fn = compress;
            encoder.encoding_user_data = &usual;
        }
        if (code == EXR_ERR_SUCCESS) code = exr_encoding_run(exr, 0, &encoder);
    }
    exr_encoding_destroy(exr, &encoder);
    return code;
}

static exr_result_t write_exr(FfpOutput *out, const FfpImage *image, float *values) {
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
    if (!image->data || (n != 1 && n != 3 && n != 4)) {
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path, "cannot write an image of %d channels as EXR", n);
    }
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) return false;
    // Taken while no EXR is open: nothing would finish it if memory ran out.
    float *values = ffp_alloc((size_t)ZIP_LINES * (size_t)image->width * (size_t)n, sizeof *values);
    const exr_result_t code = write_exr(&out, image, values);
    ffp_free(values);
    if (code == EXR_ERR_SUCCESS) return ffp_output_commit(&out, err);
    ffp_output_abort(&out);
    return ffp_fail(err, FFP_ERROR_IO, path, "cannot write EXR: %s", exr_get_default_error_message(code));
}
