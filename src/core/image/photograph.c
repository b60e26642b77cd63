#include "core/image/photograph.h"
#include <ctype.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/base/process.h"
#include "core/image/codec.h"
#include "core/image/frames.h"
#include "core/image/profile.h"
#include "core/image/stream.h"
#include "core/image/webp.h"

#define RAW_BYTES_MAX ((size_t)1 << 30)
enum { HEAD = 512, PNG_HEAD = 65536, SAMPLE_MAX = 65535, RATE = 15 };

// Linear light of the samples of a pixmap, and the greatest of them: 255, or 65535, of two bytes.
typedef struct Samples {
    int most;
    real *light; // [most + 1]
} Samples;

typedef struct Source {
    const char *path; // as it was given
    char file[FFP_PATH_MAX];
    FfpForeign kind;
    bool part;       // of a film
    double from, to; // seconds; to < from: one frame
    FfpRate rate;    // of a film's frames; 0: its own
    bool alpha;      // of a film's frames is wanted, if it has one
    FfpStream stream;
} Source;

// --- What it is. ---

static const char *const raw_endings[] = {".cr2", ".cr3", ".crw", ".nef", ".arw", ".dng", ".raf",
                                          ".rw2", ".orf", ".pef", ".srw", ".x3f", ".mrw", NULL};
static const char *const film_endings[] = {".mp4", ".mov", ".mkv", ".avi", ".webm", NULL};

// "FROM-TO" or "AT"; false when it is neither.
static bool read_part(const char *text, double *from, double *to) {
    char *end;
    if (!isdigit((unsigned char)*text)) return false;
    *from = strtod(text, &end);
    *to = -1;
    if (*end == '-' && isdigit((unsigned char)end[1])) {
        *to = strtod(end + 1, &end);
        if (!(*to > *from)) return false;
    }
    return *end == 0 && *from < 1e6 && *to < 1e6;
}

static bool has_one_of(const char *name, const char *const *endings) {
    const char *dot = strrchr(name, '.');
    for (; dot && dot != name && *endings; endings++)
        if (strcasecmp(dot, *endings) == 0) return true;
    return false;
}

// The file that is meant, and its part; the whole path where there is a file of that name. An error: a part
// that is none, of a file that exists.
static bool find_file(Source *source, const char *path, FfpError *err) {
    const char *at = strrchr(path, '@');
    *source = (Source){.path = path};
    snprintf(source->file, sizeof source->file, "%s", path);
    if (!at || strlen(path) >= sizeof source->file || ffp_is_file(path)) return true;
    source->file[at - path] = 0;
    source->part = read_part(at + 1, &source->from, &source->to);
    if (source->part) return true;
    if (ffp_is_file(source->file))
        return ffp_fail(err, FFP_ERROR_FILE, path,
                        "invalid part of a film '%.40s': expected @AT or @FROM-TO in seconds, FROM before TO",
                        at + 1);
    source->file[at - path] = '@';
    return true;
}

static bool is_tiff_raw(const char *file) {
    char *data;
    size_t size;
    if (!ffp_read_file(file, RAW_BYTES_MAX, &data, &size, NULL)) return false;
    const bool raw =
        ffp_tiff_is_raw(&(FfpEncoded){.data = (const unsigned char *)data, .size = size, .path = file});
    ffp_free(data);
    return raw;
}

// True if it has more than one picture: its chunk acTL, before the first picture's data, says so.
static bool is_animated_png(const char *file) {
    unsigned char bytes[PNG_HEAD];
    FILE *stream = ffp_open_to_read(file, NULL);
    if (!stream) return false;
    const size_t size = fread(bytes, 1, sizeof bytes, stream);
    fclose(stream);
    for (size_t at = 8; at + 12 <= size;) {
        const unsigned char *chunk = bytes + at;
        const size_t length =
            (size_t)chunk[0] << 24 | (size_t)chunk[1] << 16 | (size_t)chunk[2] << 8 | chunk[3];
        if (memcmp(chunk + 4, "IDAT", 4) == 0) return false;
        if (memcmp(chunk + 4, "acTL", 4) == 0)
            return chunk[8] > 0 || chunk[9] > 0 || chunk[10] > 0 || chunk[11] > 1;
        at += 12 + length;
    }
    return false;
}

// A file named like a raw photograph or a film must be one, or a picture, which is then read as such; any
// other content is an error that names the file.
static bool check_name(const char *file, const FfpEncoded *head, FfpError *err) {
    const bool raw = has_one_of(file, raw_endings);
    if ((!raw && !has_one_of(file, film_endings)) || ffp_is_foreign(head) || ffp_png_is(head) ||
        ffp_jpeg_is(head) || ffp_tiff_is(head) || ffp_exr_is(head))
        return true;
    return ffp_fail(err, FFP_ERROR_FILE, file, "is not a %s despite its extension",
                    raw ? "raw photograph" : "film");
}

static bool open_source(Source *source, const char *path, FfpError *err) {
    unsigned char bytes[HEAD];
    if (!find_file(source, path, err)) return false;
    FILE *stream = ffp_open_to_read(source->file, err);
    if (!stream) return false;
    const FfpEncoded head = {.data = bytes, .size = fread(bytes, 1, sizeof bytes, stream), .path = path};
    fclose(stream);
    source->kind = ffp_foreign_kind(&head);
    if (ffp_png_is(&head) && is_animated_png(source->file)) source->kind = FFP_FOREIGN_FILM;
    if (source->kind == FFP_FOREIGN_OTHER && ffp_tiff_is(&head) && is_tiff_raw(source->file))
        source->kind = FFP_FOREIGN_RAW;
    if (source->part && source->kind != FFP_FOREIGN_FILM)
        return ffp_fail(err, FFP_ERROR_FILE, path, "'%s' is not a film: it has no parts", source->file);
    if (source->kind == FFP_FOREIGN_FILM) ffp_stream_probe(&source->stream, source->file);
    return source->kind != FFP_FOREIGN_OTHER || check_name(source->file, &head, err);
}

// --- The program at work. ---

static const char *program_of(const Source *source) {
    return source->kind == FFP_FOREIGN_RAW ? "dcraw_emu" : "ffmpeg";
}

// Of a film: an option and its value, unless it has none.
static int put(const char **arguments, int n, const char *option, const char *value) {
    if (!value) return n;
    arguments[n] = option;
    arguments[n + 1] = value;
    return n + 2;
}

static bool start_film(FfpProcess **process, const Source *source, bool size_only, FfpError *err) {
    char file[FFP_PATH_MAX + 8], from[32], length[32], rate[FFP_STREAM_WORD], filter[FFP_STREAM_FILTER];
    const char *arguments[40] = {"ffmpeg", "-hide_banner", "-loglevel", "error", "-nostdin"};
    const FfpStream *stream = &source->stream;
    const bool one = size_only || (source->part && source->to < source->from),
               alpha = source->alpha && stream->alpha;
    snprintf(file, sizeof file, "file:%s", source->file);
    snprintf(from, sizeof from, "%.6f", source->from);
    snprintf(length, sizeof length, "%.6f", source->to - source->from);
    ffp_rate_print(source->rate, rate);
    ffp_stream_filter(stream, alpha, filter);
    int n = put(arguments, 5, "-ss", from);
    n = put(arguments, n, "-t", source->part && !one ? length : NULL);
    n = put(arguments, n, "-c:v", ffp_stream_decoder(stream));
    n = put(arguments, n, "-f", ffp_stream_format(stream));
    n = put(arguments, n, "-i", file);
    n = put(arguments, n, "-map", "0:V:0");
    n = put(arguments, n, "-vf", filter);
    n = put(arguments, n, "-r", source->rate.frames > 0 ? rate : NULL);
    n = put(arguments, n, "-frames:v", one ? "1" : NULL);
    n = put(arguments, n, "-c:v", alpha ? "pam" : "ppm");
    n = put(arguments, n, "-f", "image2pipe");
    arguments[n] = "pipe:1";
    return ffp_process_start(process, arguments, FFP_PROCESS_STDOUT, source->path, err);
}

// `size_only`: a picture of the same size will do, soon.
static bool start(FfpProcess **process, const Source *source, bool size_only, FfpError *err) {
    char file[FFP_PATH_MAX + 8];
    const char *arguments[16] = {program_of(source)};
    int n = 1;
    if (!ffp_program_exists(arguments[0]))
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, source->path,
                        source->kind == FFP_FOREIGN_RAW
                            ? "is a raw photograph, and the program that develops them, dcraw_emu, is not "
                              "installed: install it (Debian: libraw-bin), or develop to 16-bit TIFF or PNG"
                            : "is a film, and the program that reads them, ffmpeg, is not installed: install "
                              "it, or extract a frame");
    if (source->kind == FFP_FOREIGN_RAW) {
        snprintf(file, sizeof file, "%s%s", source->file[0] == '-' ? "./" : "", source->file);
        // Linear, 16 bits, nothing brightened, white at the sensor's own level and not at the picture's.
        const char *const options[] = {"-q", size_only ? "0" : "3", "-4", "-c", "0", "-Z", "-", file};
        for (size_t i = 0; i < sizeof options / sizeof *options; i++) arguments[n++] = options[i];
        return ffp_process_start(process, arguments, FFP_PROCESS_STDOUT, source->path, err);
    }
    return start_film(process, source, size_only, err);
}

// --- Portable pixmaps, as both programs write them: "P6 WIDTH HEIGHT MOST ", samples; and with alpha "P7",
// lines of a word and its number until "ENDHDR", samples. ---

static int read_number(FfpProcess *process) {
    int value = 0, digits = 0;
    char c = ' ';
    while (isspace((unsigned char)c))
        if (ffp_process_read(process, &c, 1) != 1) return -1;
    for (; isdigit((unsigned char)c) && digits < 6; digits++) {
        value = 10 * value + (c - '0');
        if (ffp_process_read(process, &c, 1) != 1) return -1;
    }
    return digits > 0 && isspace((unsigned char)c) ? value : -1;
}

// A line of at most 31 characters.
static bool read_line(FfpProcess *process, char line[32]) {
    for (int n = 0; n < 31; n++) {
        if (ffp_process_read(process, line + n, 1) != 1) return false;
        if (line[n] == '\n') {
            line[n] = 0;
            return true;
        }
    }
    return false;
}

static bool read_alpha_header(FfpProcess *process, int *width, int *height, bool *more) {
    char line[32], magic[2];
    int depth = 0, most = 0;
    *width = *height = 0;
    *more = ffp_process_read(process, magic, 2) == 2;
    if (!*more || memcmp(magic, "P7", 2) != 0) return false;
    while (read_line(process, line)) {
        if (strcmp(line, "ENDHDR") == 0)
            return depth == 4 && most == UCHAR_MAX && ffp_check_sides(*width, *height, "", NULL);
        if (strncmp(line, "WIDTH ", 6) == 0) *width = (int)strtol(line + 6, NULL, 10);
        if (strncmp(line, "HEIGHT ", 7) == 0) *height = (int)strtol(line + 7, NULL, 10);
        if (strncmp(line, "DEPTH ", 6) == 0) depth = (int)strtol(line + 6, NULL, 10);
        if (strncmp(line, "MAXVAL ", 7) == 0) most = (int)strtol(line + 7, NULL, 10);
    }
    return false;
}

// False without a picture that could follow; *more is false where there is none at all.
static bool read_header(FfpProcess *process, int most, int *width, int *height, bool *more) {
    char magic[2];
    *more = ffp_process_read(process, magic, 2) == 2;
    if (!*more || memcmp(magic, "P6", 2) != 0) return false;
    *width = read_number(process);
    *height = read_number(process);
    return read_number(process) == most && ffp_check_sides(*width, *height, "", NULL);
}

// Adds a picture's light to the sum. False when fewer samples came than it has.
static bool add_picture(FfpImage *sum, FfpProcess *process, const Samples *samples) {
    const size_t values = 3 * (size_t)sum->width, size = samples->most > UCHAR_MAX ? 2 : 1,
                 row = values * size;
    unsigned char *bytes = ffp_alloc(row, 1);
    bool whole = true;
    for (int y = 0; y < sum->height && whole; y++) {
        real *to = sum->data + (size_t)y * values;
        whole = ffp_process_read(process, bytes, row) == row;
        for (size_t i = 0; i < values && whole; i++)
            to[i] += samples->light[size == 1 ? bytes[i] : bytes[2 * i] << 8 | bytes[2 * i + 1]];
        ffp_cancel_point();
    }
    ffp_free(bytes);
    return whole;
}

// The sum of all pictures that come, and how many there are; 0: an error is set, or nothing useful came.
static int sum_pictures(FfpImage *sum, FfpProcess *process, const Samples *samples, const char *path,
                        FfpError *err) {
    int width, height, count = 0;
    bool more;
    while (read_header(process, samples->most, &width, &height, &more)) {
        if (count == 0) *sum = ffp_image_new(width, height, 3);
        if (width != sum->width || height != sum->height) {
            ffp_fail(err, FFP_ERROR_FILE, path, "its frames have several sizes, %d x %d and %d x %d",
                     sum->width, sum->height, width, height);
            return 0;
        }
        if (!add_picture(sum, process, samples)) return 0;
        count++;
    }
    return more ? 0 : count;
}

// LibRaw writes two bytes a sample. Of ffmpeg one is asked for: its two are 0.4 % too dark.
static int most_of(const Source *source) {
    return source->kind == FFP_FOREIGN_RAW ? SAMPLE_MAX : UCHAR_MAX;
}

static Samples samples_of(const Source *source, bool linear) {
    const Samples samples = {most_of(source), ffp_alloc((size_t)most_of(source) + 1, sizeof(real))};
    for (int i = 0; i <= samples.most; i++) {
        const real value = (real)i / (real)samples.most;
        samples.light[i] = linear || source->kind == FFP_FOREIGN_RAW ? value : ffp_srgb_decode(value);
    }
    return samples;
}

static bool nothing_made(const Source *source, const char *said, FfpError *err) {
    if (source->part)
        return ffp_fail(err, FFP_ERROR_FILE, source->path, "%s found no frames in this part%s%s",
                        program_of(source), *said ? ": " : ": the film may be shorter", said);
    return ffp_fail(err, FFP_ERROR_FILE, source->path, "%s could not make a picture of it%s%s",
                    program_of(source), *said ? ": " : "", said);
}

// The mean of the source's pictures in linear light, and of how many.
static bool develop(FfpImage *rgb, int *count, const Source *source, bool linear, FfpError *err) {
    char said[FFP_PROCESS_SAID];
    FfpProcess *process = NULL;
    FfpError why = {0};
    *rgb = (FfpImage){0};
    if (!start(&process, source, false, err)) return false;
    if (source->kind == FFP_FOREIGN_FILM) ffp_stream_note(&source->stream, source->path, true);
    const Samples samples = samples_of(source, linear);
    *count = sum_pictures(rgb, process, &samples, source->path, &why);
    ffp_free(samples.light);
    const bool ended = ffp_process_finish(&process, said);
    if (*count > 0 && ended) {
        const size_t values = 3 * (size_t)rgb->width * (size_t)rgb->height;
        for (size_t i = 0; i < values; i++) rgb->data[i] /= (real)*count;
        return true;
    }
    ffp_image_free(rgb);
    if (why.code != FFP_OK && err) *err = why;
    return why.code == FFP_OK && nothing_made(source, said, err);
}

// --- Reading. ---

bool ffp_photograph_read(FfpImage *rgb, FfpImage *alpha, const char *path, bool linear,
                         FfpDeveloped *developed, FfpError *err) {
    int whole[2];
    return ffp_photograph_read_reduced(rgb, alpha, whole, path, linear, 1, false, developed, err);
}

bool ffp_photograph_read_reduced(FfpImage *rgb, FfpImage *alpha, int whole[2], const char *path, bool linear,
                                 int shrink, bool rough, FfpDeveloped *developed, FfpError *err) {
    Source source;
    FfpDeveloped none = {0};
    int count = 0;
    if (!open_source(&source, path, err)) return false;
    if (source.kind == FFP_FOREIGN_OTHER)
        return ffp_image_read_reduced(rgb, alpha, whole, path, linear, shrink, rough, err);
    if (alpha) *alpha = (FfpImage){0};
    if (!develop(rgb, &count, &source, linear, err)) return false;
    whole[0] = rgb->width, whole[1] = rgb->height;
    if (whole[0] % shrink == 0 && whole[1] % shrink == 0) ffp_image_reduce(rgb, shrink);
    if (!developed) developed = &none;
    developed->raws += source.kind == FFP_FOREIGN_RAW;
    developed->films += source.kind == FFP_FOREIGN_FILM;
    developed->frames += source.kind == FFP_FOREIGN_FILM ? count : 0;
    return true;
}

FfpImage ffp_photograph_luma(FfpImage *rgb) {
    FfpImage luma = ffp_image_new(rgb->width, rgb->height, 1);
    const size_t pixels = (size_t)rgb->width * (size_t)rgb->height;
    ffp_image_to_srgb(rgb);
    for (size_t i = 0; i < pixels; i++) {
        const real *c = rgb->data + 3 * i;
        luma.data[i] = 0.299F * c[0] + 0.587F * c[1] + 0.114F * c[2];
    }
    return luma;
}

bool ffp_photograph_read_size(int *width, int *height, const char *path, FfpError *err) {
    char said[FFP_PROCESS_SAID];
    Source source;
    FfpProcess *process = NULL;
    bool more;
    if (!open_source(&source, path, err)) return false;
    if (source.kind == FFP_FOREIGN_OTHER) return ffp_image_read_size(width, height, path, err);
    if (!start(&process, &source, true, err)) return false;
    if (read_header(process, most_of(&source), width, height, &more)) {
        ffp_process_kill(&process);
        return true;
    }
    ffp_process_finish(&process, said);
    return nothing_made(&source, said, err);
}

bool ffp_photograph_is_raw(const char *name) {
    return has_one_of(name, raw_endings);
}

bool ffp_photograph_has_ending(const char *name) {
    return has_one_of(name, raw_endings) || has_one_of(name, film_endings) || ffp_image_has_ending(name);
}

bool ffp_photograph_check(const char *path, const char *what, FfpError *err) {
    Source source;
    return find_file(&source, path, err) &&
           (ffp_is_file(source.file) || ffp_fail(err, FFP_ERROR_FILE, path, "no such file: %s", what));
}

bool ffp_photograph_names_part(const char *path) {
    char file[FFP_PATH_MAX];
    const char *at = strrchr(path, '@');
    if (!at || (size_t)(at - path) >= sizeof file) return false;
    snprintf(file, sizeof file, "%.*s", (int)(at - path), path);
    return has_one_of(file, film_endings);
}

// --- Frames. ---

bool ffp_frames_are_in(const char *path) {
    Source source;
    return open_source(&source, path, NULL) && source.kind == FFP_FOREIGN_FILM;
}

// Frames of animated pictures are read as they are, whatever their profile.
static void note_profile(const Source *source) {
    const char *codec = source->stream.codec;
    FfpEncoded file = {.path = source->path};
    char *data;
    if ((strcmp(codec, "apng") != 0 && strcmp(codec, "webp") != 0) ||
        !ffp_read_file(source->file, RAW_BYTES_MAX, &data, &file.size, NULL))
        return;
    file.data = (const unsigned char *)data;
    FfpColourProfile profile = ffp_profile_find(&file);
    if (!ffp_profile_is_srgb(&profile))
        ffp_note("%s: its colour profile is left out: make it of sRGB pictures", ffp_basename(source->path));
    ffp_free(profile.icc);
    ffp_free(data);
}

bool ffp_frames_open(FfpFrames *frames, const char *path, int rate, FfpError *err) {
    Source source;
    *frames = (FfpFrames){.path = path};
    if (!open_source(&source, path, err)) return false;
    source.rate = (FfpRate){rate > 0 ? rate : RATE, 1};
    source.alpha = true;
    if (source.kind != FFP_FOREIGN_FILM) return ffp_fail(err, FFP_ERROR_FILE, path, "is not a film");
    frames->from = source.from;
    frames->length = source.part && source.to > source.from ? source.to - source.from : 0;
    snprintf(frames->file, sizeof frames->file, "%s", source.file);
    if (rate == 0 && source.stream.rate.frames > 0) source.rate = source.stream.rate;
    frames->rate = source.rate;
    note_profile(&source);
    if (ffp_webp_moves(source.file)) {
        const double to = !source.part ? INFINITY : source.to < source.from ? source.from + 1e-3 : source.to;
        frames->webp = ffp_webp_open(source.file, path, source.rate.frames, source.from, to, err);
        return frames->webp != NULL;
    }
    ffp_stream_note(&source.stream, path, false);
    const double own = (double)source.stream.rate.frames / fmax(source.stream.rate.seconds, 1);
    if (rate > 0 && own > 0 && fabs(own - rate) > 0.05 * rate) // a GIF's own is known no better
        ffp_note("%s: read at %d frames a second, not at its own %.4g", ffp_basename(path), rate, own);
    frames->channels = source.stream.alpha ? 4 : 3;
    const double left = source.stream.seconds - source.from,
                 seconds = source.part && source.to - source.from < left ? source.to - source.from : left;
    const double count = seconds * source.rate.frames / source.rate.seconds;
    frames->expected = count > 0 && count < 1e9 ? (int)(count + 0.5) : 0;
    const bool one = source.part && source.to < source.from;
    frames->sound = !one && ffp_stream_has_sound(source.file);
    return start(&frames->process, &source, false, err);
}

// Of no more frames: whether that is the end, or something went wrong.
static int end_of_frames(FfpFrames *frames, bool more, FfpError *err) {
    char said[FFP_PROCESS_SAID];
    const bool ended = ffp_process_finish(&frames->process, said);
    if (!more && ended && frames->count > 0) return 0;
    ffp_fail(err, FFP_ERROR_FILE, frames->path, "ffmpeg could not read all of the film%s%s",
             *said ? ": " : "", said);
    return -1;
}

int ffp_frames_next(FfpFrames *frames, FfpRaw *out, FfpError *err) {
    int width, height;
    bool more;
    ffp_cancel_point();
    if (frames->webp) {
        const int status = ffp_webp_next(frames->webp, out, err);
        frames->count += status > 0;
        if (status != 0 || frames->count > 0) return status;
        ffp_fail(err, FFP_ERROR_FILE, frames->path, "has no pictures in this part: the film may be shorter");
        return -1;
    }
    if (!(frames->channels == 4 ? read_alpha_header(frames->process, &width, &height, &more)
                                : read_header(frames->process, UCHAR_MAX, &width, &height, &more)))
        return end_of_frames(frames, more, err);
    const size_t size = (size_t)frames->channels * (size_t)width * (size_t)height;
    if (!frames->bytes) {
        frames->width = width;
        frames->height = height;
        frames->bytes = ffp_alloc(size, 1);
    }
    if (width != frames->width || height != frames->height) {
        ffp_fail(err, FFP_ERROR_FILE, frames->path, "its frames have several sizes, %d x %d and %d x %d",
                 frames->width, frames->height, width, height);
        return -1;
    }
    if (ffp_process_read(frames->process, frames->bytes, size) != size)
        return end_of_frames(frames, true, err);
    frames->count++;
    *out = (FfpRaw){.data = frames->bytes,
                    .width = width,
                    .height = height,
                    .channels = frames->channels,
                    .type = FFP_RAW_U8};
    return 1;
}

void ffp_frames_close(FfpFrames *frames) {
    ffp_webp_close(frames->webp);
    frames->webp = NULL;
    ffp_process_kill(&frames->process);
    ffp_free(frames->bytes);
    frames->bytes = NULL;
}
