#include "core/image/stream.h"
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/base/process.h"

enum { HD_LINES = 720, HD_COLUMNS = 1280, ANSWER = 4096, RATE_MOST = 1000 };

#define WHITE "203" // cd/m2
#define PEAK "4.93" // 1000 cd/m2 in whites

static bool is(const char *word, const char *wanted) {
    return strcmp(word, wanted) == 0;
}

void ffp_rate_print(FfpRate rate, char text[FFP_STREAM_WORD]) {
    const int n = snprintf(text, FFP_STREAM_WORD, "%d", rate.frames);
    if (rate.seconds != 1) snprintf(text + n, FFP_STREAM_WORD - (size_t)n, "/%d", rate.seconds);
}

// --- What ffprobe says: lines "key=value". ---

static void take(char to[FFP_STREAM_WORD], const char *value) {
    if (is(value, "unknown") || is(value, "N/A") || is(value, "reserved")) value = "";
    snprintf(to, FFP_STREAM_WORD, "%s", value);
}

static bool has_alpha(const char *pixels) {
    static const char *const kinds[] = {"yuva",  "rgba", "bgra", "argb", "abgr",
                                        "gbrap", "ya8",  "ya16", "pal8"};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (strncmp(pixels, kinds[i], strlen(kinds[i])) == 0) return true;
    return false;
}

// A fraction that 16 bits hold, as films of animated PNG need it.
static void take_rate(FfpRate *rate, const char *value) {
    char *slash;
    const long frames = strtol(value, &slash, 10), seconds = *slash == '/' ? strtol(slash + 1, NULL, 10) : 1;
    const double each = seconds > 0 ? (double)frames / (double)seconds : 0;
    if (!(each > 0 && each <= RATE_MOST)) return;
    *rate = frames <= UINT16_MAX && seconds <= UINT16_MAX ? (FfpRate){(int)frames, (int)seconds}
                                                          : (FfpRate){(int)(60 * each + 0.5), 60};
    if (rate->frames == 0) rate->frames = 1;
}

static void take_line(FfpStream *stream, const char *key, const char *value) {
    const struct {
        const char *key;
        char *to;
    } words[] = {{"codec_name", stream->codec},           {"pix_fmt", stream->pixels},
                 {"color_range", stream->range},          {"color_space", stream->matrix},
                 {"color_transfer", stream->transfer},    {"color_primaries", stream->primaries},
                 {"sample_aspect_ratio", stream->aspect}, {"field_order", stream->fields}};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (is(key, words[i].key)) take(words[i].to, value);
    if (is(key, "width")) stream->width = (int)strtol(value, NULL, 10);
    if (is(key, "height")) stream->height = (int)strtol(value, NULL, 10);
    if (is(key, "avg_frame_rate") || (is(key, "r_frame_rate") && stream->rate.frames == 0))
        take_rate(&stream->rate, value);
    const double seconds = is(key, "duration") ? strtod(value, NULL) : 0;
    if (seconds > 0) stream->seconds = seconds;
    if (is(key, "interlaced_frame") && is(value, "1")) stream->interlaced = true; // DV's header does not tell
    if (is(key, "TAG:alpha_mode") && is(value, "1")) stream->alpha = true;
}

// The answer of ffprobe on some of a file's streams; "" without that program.
static void ask(char answer[ANSWER + 1], const char *file, const char *streams, const char *entries) {
    char name[FFP_PATH_MAX + 8], said[FFP_PROCESS_SAID];
    snprintf(name, sizeof name, "file:%s", file);
    const char *const arguments[] = {"ffprobe",
                                     "-v",
                                     "error",
                                     "-select_streams",
                                     streams,
                                     "-read_intervals",
                                     "%+#1",
                                     "-show_entries",
                                     entries,
                                     "-of",
                                     "default=nw=1",
                                     name,
                                     NULL};
    FfpProcess *process = NULL;
    answer[0] = 0;
    if (!ffp_program_exists("ffprobe") ||
        !ffp_process_start(&process, arguments, FFP_PROCESS_STDOUT, file, NULL))
        return;
    answer[ffp_process_read(process, answer, ANSWER)] = 0;
    ffp_process_finish(&process, said);
}

bool ffp_stream_has_sound(const char *file) {
    char answer[ANSWER + 1];
    ask(answer, file, "a:0", "stream=codec_name");
    return strstr(answer, "codec_name=") != NULL;
}

void ffp_stream_probe(FfpStream *stream, const char *file) {
    static const char entries[] =
        "format=duration:stream=codec_name,width,height,pix_fmt,sample_aspect_ratio,color_range,color_space,"
        "color_transfer,color_primaries,duration,field_order,avg_frame_rate,r_frame_rate:"
        "stream_tags=alpha_mode:frame=interlaced_frame";
    char answer[ANSWER + 1];
    *stream = (FfpStream){0};
    ask(answer, file, "V:0", entries);
    char *rest = NULL;
    for (char *line = strtok_r(answer, "\r\n", &rest); line; line = strtok_r(NULL, "\r\n", &rest)) {
        char *equals = strchr(line, '=');
        if (!equals) continue;
        *equals = 0;
        take_line(stream, line, equals + 1);
    }
    stream->alpha |= has_alpha(stream->pixels);
    if (is(stream->codec, "webp")) stream->rate.frames = 0; // 25 is told of all of them
    if (is(stream->codec, "apng") || is(stream->codec, "png"))
        stream->interlaced = false; // of Adam7, not of fields
}

const char *ffp_stream_decoder(const FfpStream *stream) {
    if (!stream->alpha) return NULL;
    return is(stream->codec, "vp9") ? "libvpx-vp9" : is(stream->codec, "vp8") ? "libvpx" : NULL;
}

const char *ffp_stream_format(const FfpStream *stream) {
    return is(stream->codec, "apng") ? "apng" : NULL; // otherwise a picture alone
}

// --- The filters. ---

static bool is_rgb(const FfpStream *stream) {
    return is(stream->matrix, "gbr") || is(stream->codec, "gif") || is(stream->codec, "apng") ||
           is(stream->codec, "png") || strstr(stream->pixels, "rgb") || strstr(stream->pixels, "bgr") ||
           strncmp(stream->pixels, "gbr", 3) == 0 || strncmp(stream->pixels, "gray", 4) == 0;
}

static bool is_large(const FfpStream *stream) {
    return stream->height >= HD_LINES || stream->width >= HD_COLUMNS;
}

// For ffmpeg's scale.
static const char *matrix_of(const FfpStream *stream) {
    static const char *const names[][2] = {{"bt709", "bt709"},   {"smpte170m", "bt601"},
                                           {"bt470bg", "bt601"}, {"bt2020nc", "bt2020"},
                                           {"fcc", "fcc"},       {"smpte240m", "smpte240m"}};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (is(stream->matrix, names[i][0])) return names[i][1];
    if (is(stream->primaries, "bt2020")) return "bt2020";
    return is(stream->primaries, "bt709") || is_large(stream) ? "bt709" : "bt601";
}

static bool is_hdr(const FfpStream *stream) {
    return is(stream->transfer, "arib-std-b67") || is(stream->transfer, "smpte2084");
}

static bool is_interlaced(const FfpStream *stream) {
    return stream->interlaced || (*stream->fields && !is(stream->fields, "progressive"));
}

static bool is_wide(const FfpStream *stream) {
    return is(stream->primaries, "bt2020") || is(stream->primaries, "smpte432") ||
           is(stream->primaries, "smpte431");
}

enum { LIGHT_MAX = 384 };

// To light and back, with zscale. Of what is not HDR only the primaries change.
static void put_light(const FfpStream *stream, bool alpha, char filter[LIGHT_MAX]) {
    const char *light = alpha ? "gbrapf32le" : "gbrpf32le",
               *primaries = *stream->primaries ? stream->primaries : "bt2020";
    const char *in = is_hdr(stream) ? stream->transfer : "bt709";
    char of[96] = "";
    if (!is_rgb(stream))
        snprintf(of, sizeof of, ":matrixin=%s:rangein=%s",
                 is(matrix_of(stream), "bt2020")  ? "bt2020nc"
                 : is(matrix_of(stream), "bt601") ? "smpte170m"
                                                  : "bt709",
                 is(stream->range, "pc") ? "full" : "limited");
    if (is_hdr(stream))
        snprintf(filter, LIGHT_MAX,
                 ",zscale=transferin=%s:primariesin=%s%s:transfer=linear:npl=" WHITE ",format=%s,"
                 "zscale=primaries=bt709,tonemap=mobius:param=0.95:desat=0:peak=" PEAK
                 ",zscale=transfer=iec61966-2-1:range=full",
                 in, primaries, of, light);
    else
        snprintf(filter, LIGHT_MAX,
                 ",zscale=transferin=%s:primariesin=%s%s:transfer=linear,format=%s,"
                 "zscale=primaries=bt709,zscale=transfer=bt709:range=full",
                 in, primaries, of, light);
}

void ffp_stream_filter(const FfpStream *stream, bool alpha, char filter[FFP_STREAM_FILTER]) {
    static const char square[] = "w='if(gt(sar,1),round(iw*sar),iw)':h='if(lt(sar,1),round(ih/sar),ih)'";
    char light[LIGHT_MAX] = "", matrix[48] = "";
    if (is_hdr(stream) || is_wide(stream))
        put_light(stream, alpha, light);
    else if (!is_rgb(stream))
        snprintf(matrix, sizeof matrix, ":in_color_matrix=%s", matrix_of(stream));
    snprintf(filter, FFP_STREAM_FILTER, "%sscale=%s%s,setsar=1%s,format=%s",
             is_interlaced(stream) ? "bwdif=mode=send_frame," : "", square, matrix, light,
             alpha ? "rgba" : "rgb24");
}

// --- Notes. ---

static void add(char *words, size_t size, const char *one) {
    const size_t length = strlen(words);
    snprintf(words + length, size - length, "%s%s", length ? "; " : "", one);
}

void ffp_stream_note(const FfpStream *stream, const char *path, bool hdr_only) {
    char words[320] = "", one[96];
    if (is_hdr(stream)) {
        snprintf(one, sizeof one, "%s, white at " WHITE " cd/m2, becomes sRGB",
                 is(stream->transfer, "smpte2084") ? "PQ" : "HLG");
        add(words, sizeof words, one);
    } else if (is_wide(stream)) {
        snprintf(one, sizeof one, "colours of %s become sRGB",
                 is(stream->primaries, "bt2020") ? "BT.2020" : "P3");
        add(words, sizeof words, one);
    }
    if (is_interlaced(stream)) add(words, sizeof words, "interlaced frames are made whole");
    if (!hdr_only && *stream->pixels && !*stream->matrix && !*stream->primaries && !is_rgb(stream)) {
        snprintf(one, sizeof one, "without a tag of its colours, read as %s by its size",
                 is_large(stream) ? "BT.709" : "BT.601");
        add(words, sizeof words, one);
    }
    if (!hdr_only && *stream->aspect && !is(stream->aspect, "1:1") && !is(stream->aspect, "0:1")) {
        snprintf(one, sizeof one, "pixels of %s are made square", stream->aspect);
        add(words, sizeof words, one);
    }
    if (*words) ffp_note("%s: %s", ffp_basename(path), words);
}
