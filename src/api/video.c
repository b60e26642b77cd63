#include "api/video.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <tgmath.h>
#include <zlib.h>
#include "base/arena.h"
#include "base/vec.h"

// --- Poses that go round. ---

static void mean_up(const FfpCapture *capture, real up[3]) {
    for (int k = 0; k < 3; k++) up[k] = 0;
    for (int v = 0; v < capture->n_views; v++)
        for (int k = 0; k < 3; k++) up[k] -= capture->views[v].camera.pose[4 * k + 1];
    if (ffp_normalise3(up) > 0) return;
    for (int k = 0; k < 3; k++) up[k] = -capture->views[0].camera.pose[4 * k + 1];
}

// Rodrigues' formula.
static void turn_vector(const real axis[3], real angle, real v[3]) {
    real across[3];
    const real c = cos(angle), s = sin(angle), along = ffp_dot3(axis, v) * (1 - c);
    ffp_cross3(axis, v, across);
    for (int k = 0; k < 3; k++) v[k] = c * v[k] + s * across[k] + along * axis[k];
}

static void turn_device(FfpCamera *device, const real centre[3], const real axis[3], real angle) {
    for (int column = 0; column < 4; column++) {
        real v[3];
        for (int k = 0; k < 3; k++) v[k] = device->pose[4 * k + column] - (column == 3 ? centre[k] : 0);
        turn_vector(axis, angle, v);
        for (int k = 0; k < 3; k++) device->pose[4 * k + column] = v[k] + (column == 3 ? centre[k] : 0);
    }
}

FfpView *ffp_orbit_views(const FfpCapture *capture, const FfpView *base, FfpOrbit orbit, int count) {
    FfpView *views = ffp_alloc((size_t)count, sizeof *views);
    real up[3];
    mean_up(capture, up);
    for (int f = 0; f < count; f++) {
        // turning the object is turning both devices the other way round
        const real turn = 6.283185307F * (real)f / (real)count;
        const real angle = orbit == FFP_ORBIT_OBJECT ? -turn : turn;
        views[f].camera = base->camera, views[f].projector = base->projector;
        strcpy(views[f].id, "frame");
        if (orbit != FFP_ORBIT_PROJECTOR) turn_device(&views[f].camera, capture->centre, up, angle);
        if (orbit != FFP_ORBIT_CAMERA) turn_device(&views[f].projector, capture->centre, up, angle);
    }
    return views;
}

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

// fcTL: the frame's size, place and time; it replaces what was there.
static void put_frame_control(FfpAnimation *a) {
    unsigned char data[26] = {0};
    put_u32(data, a->sequence++);
    put_u32(data + 4, (uint32_t)a->width);
    put_u32(data + 8, (uint32_t)a->height);
    data[21] = 1; // the delay is 1 / rate
    data[22] = (unsigned char)(a->rate >> 8), data[23] = (unsigned char)a->rate;
    put_chunk(a->out.stream, "fcTL", data, sizeof data, NULL, 0);
}

// Goes through a PNG that we wrote ourselves: its header before the first frame, its data as IDAT or fdAT.
static void put_frame(FfpAnimation *a, const unsigned char *png, size_t size) {
    FILE *stream = a->out.stream;
    for (size_t at = PNG_SIGNATURE_SIZE; at + 12 <= size;) {
        const uint32_t length = get_u32(png + at);
        const unsigned char *type = png + at + 4, *data = png + at + 8;
        unsigned char head[8];
        if (memcmp(type, "IHDR", 4) == 0 && a->done == 0) {
            fwrite(png, 1, PNG_SIGNATURE_SIZE, stream);
            put_chunk(stream, "IHDR", NULL, 0, data, length);
            put_u32(head, a->frames), put_u32(head + 4, 0);
            put_chunk(stream, "acTL", head, 8, NULL, 0);
            put_frame_control(a);
        } else if (memcmp(type, "IHDR", 4) == 0) {
            put_frame_control(a);
        } else if (memcmp(type, "IDAT", 4) == 0 && a->done == 0) {
            put_chunk(stream, "IDAT", NULL, 0, data, length);
        } else if (memcmp(type, "IDAT", 4) == 0) {
            put_u32(head, a->sequence++);
            put_chunk(stream, "fdAT", head, 4, data, length);
        }
        at += 12 + (size_t)length;
    }
}

static bool add_to_png(FfpAnimation *a, const FfpImage *encoded, FfpError *err) {
    unsigned char *png;
    size_t size;
    if (!ffp_image_encode_png(encoded, &png, &size, err)) return false;
    put_frame(a, png, size);
    ffp_free(png);
    return true;
}

// --- Films of either kind. ---

bool ffp_animation_check(const char *path, FfpError *err) {
    const char *dot = strrchr(path, '.');
    if (dot && (strcasecmp(dot, ".png") == 0 || strcasecmp(dot, ".apng") == 0)) return true;
    if (!ffp_ffmpeg_makes(path))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path,
                        "a film ends in .png, .apng, .gif, .mp4, .webm or .mkv");
    if (ffp_program_is_there("ffmpeg")) return true;
    return ffp_fail(err, FFP_ERROR_UNSUPPORTED, path,
                    "the program ffmpeg, which makes %s films, is not here: install it, or choose .png, an "
                    "animated PNG",
                    dot);
}

bool ffp_animation_open(FfpAnimation *animation, const char *path, int frames, int rate, FfpError *err) {
    *animation =
        (FfpAnimation){.frames = (uint32_t)frames, .rate = rate, .by_ffmpeg = ffp_ffmpeg_makes(path)};
    return ffp_animation_check(path, err) && ffp_output_open(&animation->out, path, err);
}

// Values are multiples of 1/255 already (ffp_relight).
static bool add_to_ffmpeg(FfpAnimation *a, const FfpImage *encoded, FfpError *err) {
    const size_t count = (size_t)encoded->width * (size_t)encoded->height * 3;
    if (a->done == 0 && !ffp_ffmpeg_start(&a->ffmpeg, a->out.path, a->out.temporary, encoded->width,
                                          encoded->height, a->rate, err))
        return false;
    unsigned char *bytes = ffp_alloc(count, 1);
    for (size_t i = 0; i < count; i++) bytes[i] = (unsigned char)(encoded->data[i] * 255 + 0.5F);
    const bool ok = ffp_process_write(a->ffmpeg, bytes, count);
    ffp_free(bytes);
    return ok || (ffp_ffmpeg_finish(&a->ffmpeg, a->out.path, err) &&
                  ffp_fail(err, FFP_ERROR_IO, a->out.path, "ffmpeg ended before the last frame"));
}

bool ffp_animation_add(FfpAnimation *animation, const FfpImage *encoded, FfpError *err) {
    if (animation->done == 0) animation->width = encoded->width, animation->height = encoded->height;
    if (encoded->width != animation->width || encoded->height != animation->height)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, animation->out.path,
                        "frames of %d x %d and %d x %d pixels do not fit one film", animation->width,
                        animation->height, encoded->width, encoded->height);
    if (!(animation->by_ffmpeg ? add_to_ffmpeg : add_to_png)(animation, encoded, err)) return false;
    animation->done++;
    return true;
}

bool ffp_animation_commit(FfpAnimation *animation, FfpError *err) {
    if (animation->done != animation->frames) {
        ffp_animation_abort(animation);
        return ffp_fail(err, FFP_ERROR_ARGUMENT, animation->out.path, "%u frames instead of %u",
                        (unsigned)animation->done, (unsigned)animation->frames);
    }
    if (animation->by_ffmpeg && !ffp_ffmpeg_finish(&animation->ffmpeg, animation->out.path, err)) {
        ffp_animation_abort(animation);
        return false;
    }
    if (!animation->by_ffmpeg) put_chunk(animation->out.stream, "IEND", NULL, 0, NULL, 0);
    return ffp_output_commit(&animation->out, err);
}

void ffp_animation_abort(FfpAnimation *animation) {
    ffp_process_kill(&animation->ffmpeg);
    ffp_output_abort(&animation->out);
}
