#include "core/image/film.h"
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <zlib.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "core/image/ffmpeg.h"

// --- Animated PNG. ---

#define PNG_SIGNATURE_SIZE 8

static void put_u32(unsigned char *at, uint32_t value) {
    for (int i = 0; i < 4; i++) at[i] = (unsigned char)(value >> (24 - 8 * i));
}

static uint32_t get_u32(const unsigned char *at) {
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

// Length, type, data, CRC of type and data. The data come in two parts, either may be empty. Write errors
// show at the commit.
static void put_chunk(FILE *stream, const char type[4], const unsigned char *head, uint32_t head_size,
                      const unsigned char *data, uint32_t size) {
    unsigned char bytes[4];
    uLong crc = crc32(0, (const unsigned char *)type, 4);
    if (head_size) crc = crc32(crc, head, head_size);
    if (size) crc = crc32(crc, data, size);
    put_u32(bytes, head_size + size);
    fwrite(bytes, 1, 4, stream);
    fwrite(type, 1, 4, stream);
    if (head_size) fwrite(head, 1, head_size, stream);
    if (size) fwrite(data, 1, size, stream);
    put_u32(bytes, (uint32_t)crc);
    fwrite(bytes, 1, 4, stream);
}

// acTL: how many frames there are, and that they play for ever.
static void put_control(FfpFilm *film) {
    unsigned char data[8] = {0};
    put_u32(data, film->frames);
    put_chunk(film->out.stream, "acTL", data, sizeof data, NULL, 0);
}

// fcTL: the frame's size, place and time; it replaces the frame before it.
static void put_frame_control(FfpFilm *film) {
    unsigned char data[26] = {0};
    put_u32(data, film->sequence++);
    put_u32(data + 4, (uint32_t)film->width);
    put_u32(data + 8, (uint32_t)film->height);
    const int delay[2] = {film->rate.seconds, film->rate.frames}; // as a fraction
    for (int i = 0; i < 4; i++) data[20 + i] = (unsigned char)(delay[i / 2] >> (i % 2 ? 0 : 8));
    put_chunk(film->out.stream, "fcTL", data, sizeof data, NULL, 0);
}

// Goes through a PNG that we wrote ourselves: its header before the first frame, its data as IDAT or fdAT.
static void put_frame(FfpFilm *film, const unsigned char *png, size_t size) {
    FILE *stream = film->out.stream;
    for (size_t at = PNG_SIGNATURE_SIZE; at + 12 <= size;) {
        const uint32_t length = get_u32(png + at);
        const unsigned char *type = png + at + 4, *data = png + at + 8;
        unsigned char head[8];
        if (memcmp(type, "IHDR", 4) == 0 && film->done == 0) {
            fwrite(png, 1, PNG_SIGNATURE_SIZE, stream);
            put_chunk(stream, "IHDR", NULL, 0, data, length);
            film->control = ftell(stream);
            put_control(film);
            put_frame_control(film);
        } else if (memcmp(type, "IHDR", 4) == 0) {
            put_frame_control(film);
        } else if (memcmp(type, "IDAT", 4) == 0 && film->done == 0) {
            put_chunk(stream, "IDAT", NULL, 0, data, length);
        } else if (memcmp(type, "IDAT", 4) == 0) {
            put_u32(head, film->sequence++);
            put_chunk(stream, "fdAT", head, 4, data, length);
        }
        at += 12 + (size_t)length;
    }
}

static bool add_to_png(FfpFilm *film, const FfpImage *encoded, FfpError *err) {
    unsigned char *png;
    size_t size;
    if (!ffp_image_encode_png(encoded, &png, &size, err)) return false;
    put_frame(film, png, size);
    ffp_free(png);
    return true;
}

// --- Films of either kind. ---

bool ffp_film_check(const char *path, FfpError *err) {
    const char *dot = strrchr(path, '.');
    if (dot && (strcasecmp(dot, ".png") == 0 || strcasecmp(dot, ".apng") == 0)) return true;
    if (!ffp_ffmpeg_makes(path))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path,
                        "the extension of a film must be .png, .apng, .gif, .mp4, .webm or .mkv");
    if (ffp_program_exists("ffmpeg")) return true;
    return ffp_fail(err, FFP_ERROR_UNSUPPORTED, path,
                    "the program ffmpeg, which makes %s films, is not installed: install it, or choose .png, "
                    "an animated PNG",
                    dot);
}

bool ffp_film_open(FfpFilm *film, const char *path, int frames, int rate, FfpError *err) {
    *film = (FfpFilm){.frames = (uint32_t)frames, .rate = {rate, 1}, .by_ffmpeg = ffp_ffmpeg_makes(path)};
    return ffp_film_check(path, err) && ffp_output_open(&film->out, path, err);
}

void ffp_film_follow(FfpFilm *film, const FfpFrames *frames) {
    film->rate = frames->rate;
    if (frames->sound && film->by_ffmpeg && ffp_ffmpeg_sounds(film->out.path))
        film->sound = frames;
    else if (frames->sound)
        ffp_note("%s: without the sound of %s: .mp4, .webm and .mkv take it", film->out.path,
                 ffp_basename(frames->path));
}

// Values are multiples of 1/255 already (ffp_relight).
static bool add_to_ffmpeg(FfpFilm *film, const FfpImage *encoded, FfpError *err) {
    const size_t count = (size_t)encoded->width * (size_t)encoded->height * 3;
    if (film->done == 0 && !ffp_ffmpeg_start(&film->ffmpeg, film->out.path, film->out.temporary,
                                             encoded->width, encoded->height, film->rate, film->sound, err))
        return false;
    unsigned char *bytes = ffp_alloc(count, 1);
    for (size_t i = 0; i < count; i++) bytes[i] = (unsigned char)(encoded->data[i] * 255 + 0.5F);
    const bool ok = ffp_process_write(film->ffmpeg, bytes, count);
    ffp_free(bytes);
    return ok || (ffp_ffmpeg_finish(&film->ffmpeg, film->out.path, err) &&
                  ffp_fail(err, FFP_ERROR_IO, film->out.path, "ffmpeg ended before the last frame"));
}

bool ffp_film_add(FfpFilm *film, const FfpImage *encoded, FfpError *err) {
    if (film->done == 0) {
        film->width = encoded->width;
        film->height = encoded->height;
    }
    if (encoded->width != film->width || encoded->height != film->height)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, film->out.path,
                        "frames of %d x %d and %d x %d pixels do not fit one film", film->width, film->height,
                        encoded->width, encoded->height);
    if (!(film->by_ffmpeg ? add_to_ffmpeg : add_to_png)(film, encoded, err)) return false;
    film->done++;
    return true;
}

// Writes the number of frames that was not known before over the 0 in its place.
static void put_count(FfpFilm *film) {
    film->frames = film->done;
    fseek(film->out.stream, film->control, SEEK_SET);
    put_control(film);
    fseek(film->out.stream, 0, SEEK_END);
}

bool ffp_film_commit(FfpFilm *film, FfpError *err) {
    if (film->frames == 0 && film->done > 0 && !film->by_ffmpeg) put_count(film);
    if (film->frames == 0) film->frames = film->done;
    if (film->done != film->frames) {
        ffp_film_abort(film);
        return ffp_fail(err, FFP_ERROR_ARGUMENT, film->out.path, "%u frames instead of %u",
                        (unsigned)film->done, (unsigned)film->frames);
    }
    if (film->by_ffmpeg && !ffp_ffmpeg_finish(&film->ffmpeg, film->out.path, err)) {
        ffp_film_abort(film);
        return false;
    }
    if (!film->by_ffmpeg) put_chunk(film->out.stream, "IEND", NULL, 0, NULL, 0);
    return ffp_output_commit(&film->out, err);
}

void ffp_film_abort(FfpFilm *film) {
    ffp_process_kill(&film->ffmpeg);
    ffp_output_abort(&film->out);
}
