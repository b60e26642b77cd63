#include "core/image/ffmpeg.h"
#include <string.h>
#include <strings.h>
#include "core/base/file.h"

enum { OPTIONS_MAX = 20 };

// Colours as players expect them of untagged files too. Odd sides take a colour for each pixel (4:4:4).
#define YUV                                                                                                  \
    even, "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv"
static const char even[] = "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p",
                  odd[] = "scale=out_color_matrix=bt709:out_range=tv,format=yuv444p";

static const struct Format {
    const char *ending;
    const char *options[OPTIONS_MAX];
} formats[] = {
    {".gif", {"-vf", "split[a][b];[a]palettegen[p];[b][p]paletteuse", "-loop", "0", "-f", "gif"}},
    {".mp4", {"-vf", YUV, "-crf", "18", "-movflags", "+faststart", "-f", "mp4"}},
    {".webm", {"-vf", YUV, "-b:v", "0", "-crf", "24", "-f", "webm"}},
    {".mkv", {"-vf", YUV, "-crf", "18", "-f", "matroska"}},
};

static const struct Format *find_format(const char *path) {
    const char *dot = strrchr(path, '.');
    for (size_t i = 0; dot && i < sizeof formats / sizeof *formats; i++)
        if (strcasecmp(dot, formats[i].ending) == 0) return &formats[i];
    return NULL;
}

bool ffp_ffmpeg_makes(const char *path) {
    return find_format(path) != NULL;
}

bool ffp_ffmpeg_sounds(const char *path) {
    const struct Format *format = find_format(path);
    return format && strcmp(format->ending, ".gif") != 0;
}

bool ffp_ffmpeg_start(FfpProcess **ffmpeg, const char *path, const char *file, int width, int height,
                      FfpRate rate, const FfpFrames *sound, FfpError *err) {
    const struct Format *format = find_format(path);
    char size[32], speed[FFP_STREAM_WORD], output[2 * FFP_PATH_MAX], from[32], length[32],
        film[FFP_PATH_MAX + 8];
    const char *arguments[OPTIONS_MAX + 36] = {"ffmpeg", "-hide_banner", "-loglevel", "error", "-nostdin",
                                               "-f",     "rawvideo",     "-pix_fmt",  "rgb24", "-s",
                                               size,     "-r",           speed,       "-i",    "pipe:0"};
    int n = 15;
    snprintf(size, sizeof size, "%dx%d", width, height);
    ffp_rate_print(rate, speed);
    snprintf(output, sizeof output, "file:%s", file);
    if (sound) {
        snprintf(film, sizeof film, "file:%s", sound->file);
        snprintf(from, sizeof from, "%.6f", sound->from);
        snprintf(length, sizeof length, "%.6f", sound->length);
        const char *const more[] = {"-ss", from, "-t", length, "-i", film, "-map", "0:v", "-map", "1:a:0"};
        for (size_t i = 0; i < sizeof more / sizeof *more; i++)
            if (sound->length > 0 || (i != 2 && i != 3)) arguments[n++] = more[i];
    }
    for (int i = 0; format->options[i]; i++)
        arguments[n++] = format->options[i] == even && (width % 2 || height % 2) ? odd : format->options[i];
    arguments[n++] = "-y";
    arguments[n++] = output;
    return ffp_process_start(ffmpeg, arguments, FFP_PROCESS_STDIN, path, err);
}

bool ffp_ffmpeg_finish(FfpProcess **ffmpeg, const char *path, FfpError *err) {
    char said[FFP_PROCESS_SAID];
    if (ffp_process_finish(ffmpeg, said)) return true;
    return ffp_fail(err, FFP_ERROR_IO, path, "ffmpeg failed: %s", *said ? said : "no reason given");
}
