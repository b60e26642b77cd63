// Films as other programs write them, made by ffmpeg: what they say of their colours, their pixels and their
// transparency arrives in the frames.
#include <math.h>
#include <stdlib.h>
#include "core/base/call.h"
#include "core/base/process.h"
#include "core/image/film.h"
#include "core/image/frames.h"
#include "scratch.h"

#define SPLIT                                                                                                \
    "split[a][b];[a]crop=iw/2:ih:0:0,lutrgb=r=255:g=0:b=0[l];[b]crop=iw/2:ih:iw/2:0,lutrgb=r=0:g=200:b=0["   \
    "r];[l][r]hstack"
#define LIGHT                                                                                                \
    "format=gbrpf32le,zscale=pin=bt709:tin=iec61966-2-1:rin=full:min=gbr:npl=203:p=bt2020:m=bt2020nc:r="     \
    "limited:"

#define UNTAGGED "setparams=colorspace=unknown" // ffmpeg 7 would write what it converted to
#define CLEAR                                                                                                \
    "format=rgba,split[c][d];[c]crop=iw/2:ih:0:0[e];[d]crop=iw/2:ih:iw/2:0,lutrgb=a=0[f];[e][f]hstack"

// Of the left half red, of the right half green of 200, or none of it.
typedef struct Case {
    const char *name;
    int width, height; // as made
    const char *filter, *options;
    int wide, high, channels, frames; // as read
    int tolerance;
    int right_alpha;
    const char *note; // part of the note; "": none
} Case;

static const Case cases[] = {
    {"tagged.mkv", 64, 48, "scale=out_color_matrix=bt709,format=yuv444p",
     "-c:v libx264 -qp 0 -colorspace bt709 -color_primaries bt709 -color_trc bt709", 64, 48, 3, 3, 3, 255,
     ""},
    {"small.mkv", 64, 48, "scale=out_color_matrix=bt601,format=yuv444p," UNTAGGED, "-c:v ffv1", 64, 48, 3, 3,
     3, 255, "small.mkv: without a tag of its colours, read as BT.601"},
    {"large.mkv", 1280, 720, "scale=out_color_matrix=bt709,format=yuv444p," UNTAGGED, "-c:v ffv1", 1280, 720,
     3, 3, 3, 255, "large.mkv: without a tag of its colours, read as BT.709"},
    {"range.mkv", 64, 48, "scale=out_color_matrix=bt709:out_range=pc,format=yuv444p",
     "-c:v libx264 -qp 0 -colorspace bt709 -color_primaries bt709 -color_trc bt709 -color_range pc", 64, 48,
     3, 3, 3, 255, ""},
    {"wide.mkv", 64, 48,
     "format=gbrp16le,zscale=pin=bt709:tin=bt709:rin=full:p=bt2020:t=bt709:m=bt2020nc:r=limited,format="
     "yuv444p10le",
     "-c:v libx264 -qp 0 -colorspace bt2020nc -color_primaries bt2020 -color_trc bt709", 64, 48, 3, 3, 9, 255,
     "wide.mkv: colours of BT.2020 become sRGB"},
    {"pq.mkv", 64, 48, LIGHT "t=smpte2084,format=yuv444p10le",
     "-c:v libx265 -x265-params log-level=none:lossless=1 -colorspace bt2020nc -color_primaries bt2020 "
     "-color_trc smpte2084",
     64, 48, 3, 3, 6, 255, "pq.mkv: PQ, white at 203 cd/m2, becomes sRGB"},
    {"hlg.mkv", 64, 48, LIGHT "t=arib-std-b67,format=yuv444p10le",
     "-c:v libx265 -x265-params log-level=none:lossless=1 -colorspace bt2020nc -color_primaries bt2020 "
     "-color_trc arib-std-b67",
     64, 48, 3, 3, 6, 255, "hlg.mkv: HLG, white at 203 cd/m2, becomes sRGB"},
    {"pixels.mkv", 32, 48, "scale=out_color_matrix=bt709,setsar=2,format=yuv444p",
     "-c:v libx264 -qp 0 -colorspace bt709 -color_primaries bt709 -color_trc bt709", 64, 48, 3, 3, 3, 255,
     "pixels.mkv: pixels of 2:1 are made square"},
    {"high.mkv", 64, 24, "scale=out_color_matrix=bt709,setsar=1/2,format=yuv444p",
     "-c:v libx264 -qp 0 -colorspace bt709 -color_primaries bt709 -color_trc bt709", 64, 48, 3, 3, 3, 255,
     "pixels of 1:2 are made square"},
    {"a.gif", 64, 48, "split[c][d];[c]palettegen[e];[d][e]paletteuse", "", 64, 48, 4, 3, 8, 255, ""},
    {"animated.png", 64, 48, "format=rgb24", "-f apng", 64, 48, 3, 3, 1, 255, ""},
    {"a.webp", 64, 48, "null", "-frames:v 1 -lossless 1", 64, 48, 4, 1, 2, 255, ""},
    {"alpha.mkv", 64, 48, CLEAR, "-c:v ffv1 -pix_fmt bgra", 64, 48, 4, 3, 1, 0, ""},
    {"alpha.webm", 64, 48, CLEAR ",format=yuva420p," UNTAGGED, "-c:v libvpx-vp9 -lossless 1", 64, 48, 4, 3, 3,
     0, "read as BT.601"},
};

typedef struct Said {
    const Case *of;
    char words[512];
} Said;

static void hear(void *user, FfpLogLevel level, const char *text) {
    Said *said = user;
    (void)level;
    strncat(said->words, text, sizeof said->words - strlen(said->words) - 1);
}

static void expect_pixel(const Case *of, const FfpRaw *frame, int x, const int wanted[4]) {
    const unsigned char *at = (const unsigned char *)frame->data +
                              (size_t)frame->channels * (size_t)(frame->height / 2 * frame->width + x);
    for (int c = 0; c < frame->channels; c++)
        if (abs(at[c] - wanted[c]) > of->tolerance)
            fail_msg("%s, column %d: %d %d %d %d, not %d %d %d %d", of->name, x, at[0], at[1], at[2],
                     frame->channels > 3 ? at[3] : 255, wanted[0], wanted[1], wanted[2], wanted[3]);
}

static bool read_film(void *argument, FfpError *err) {
    const Case *of = ((Said *)argument)->of;
    FfpFrames frames;
    FfpRaw frame;
    int status;
    assert_true(ffp_frames_are_in(in_scratch(of->name)));
    if (!ffp_frames_open(&frames, in_scratch(of->name), 3, err)) return false;
    while ((status = ffp_frames_next(&frames, &frame, err)) > 0) {
        assert_int_equal(frame.width, of->wide);
        assert_int_equal(frame.height, of->high);
        assert_int_equal(frame.channels, of->channels);
        expect_pixel(of, &frame, frame.width / 4, (const int[4]){255, 0, 0, 255});
        expect_pixel(of, &frame, 3 * frame.width / 4, (const int[4]){0, 200, 0, of->right_alpha});
    }
    assert_int_equal(frames.count, of->frames);
    ffp_frames_close(&frames);
    return status == 0;
}

static void need_ffmpeg(void) {
    if (ffp_program_exists("ffmpeg") && ffp_program_exists("ffprobe")) return;
    printf("skipped: ffmpeg is not here\n");
    skip();
}

static void films_of_many_kinds(void **state) {
    (void)state;
    need_ffmpeg();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const Case *of = &cases[i];
        char command[2048];
        Said said = {.of = of};
        FfpError err = {0};
        snprintf(command, sizeof command,
                 "ffmpeg -loglevel error -nostdin -y -f lavfi -i color=red:s=%dx%d:r=3:d=1 -filter_complex "
                 "\"format=gbrp," SPLIT ",%s\" %s %s/%s",
                 of->width, of->height, of->filter, of->options, scratch, of->name);
        if (system(command) != 0) fail_msg("%s", command);
        FfpContext context = {.settings = {.user = &said, .log = hear}};
        if (!ffp_call_run(&context, read_film, &said, &err)) fail_msg("%s: %s", of->name, err.text);
        if (*of->note ? !strstr(said.words, of->note) : *said.words != 0)
            fail_msg("%s: said \"%s\"", of->name, said.words);
    }
}

// Red for 200 ms, then green for 600: each picture as long as it shows, and a part of them.
static void pictures_of_webp_show_as_long_as_they_say(void **state) {
    (void)state;
    static const struct {
        const char *part;
        int rate, red, green;
    } parts[] = {{"", 5, 1, 3}, {"", 0, 3, 9}, {"", 10, 2, 6}, {"@0.3-0.5", 10, 0, 2}, {"@0.1", 5, 1, 0}};
    char command[1024], name[64];
    need_ffmpeg();
    snprintf(
        command, sizeof command,
        "ffmpeg -loglevel error -nostdin -y -f lavfi -i color=red:s=16x12:r=5:d=0.2 -f lavfi -i "
        "color=0x00c800:s=16x12:r=5:d=0.6 -filter_complex \"[0][1]concat,format=bgra\" -c:v libwebp_anim "
        "-lossless 1 %s/moves.webp",
        scratch);
    if (system(command) != 0) fail_msg("%s", command);
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        FfpFrames frames;
        FfpRaw frame;
        FfpError err = {0};
        int seen[2] = {0}, status;
        snprintf(name, sizeof name, "moves.webp%s", parts[i].part);
        if (!ffp_frames_open(&frames, in_scratch(name), parts[i].rate, &err)) {
            if (!strstr(err.text, "libwebp-dev")) fail_msg("%s", err.text);
            printf("skipped: built without libwebp\n");
            skip();
        }
        while ((status = ffp_frames_next(&frames, &frame, &err)) > 0) {
            const unsigned char *at = frame.data;
            assert_true(frame.width == 16 && frame.height == 12 && frame.channels == 4 && at[3] == 255);
            seen[at[1] > 100]++;
        }
        if (status < 0) fail_msg("%s", err.text);
        if (seen[0] != parts[i].red || seen[1] != parts[i].green)
            fail_msg("%s at %d: %d and %d", name, parts[i].rate, seen[0], seen[1]);
        ffp_frames_close(&frames);
    }
}

static void damaged_webp_is_refused(void **state) {
    (void)state;
    FfpFrames frames;
    FfpRaw frame;
    FfpError err = {0};
    static const unsigned char head[40] = "RIFF\x20\0\0\0WEBPVP8X\x0a\0\0\0\x02\0\0\0\x0f\0\0\x0b\0\0";
    FILE *file = fopen(in_scratch("damaged.webp"), "wb");
    fwrite(head, 1, sizeof head, file);
    fclose(file);
    const bool open = ffp_frames_open(&frames, in_scratch("damaged.webp"), 5, &err);
    assert_true(!open || ffp_frames_next(&frames, &frame, &err) < 0);
    assert_non_null(strstr(err.text, "damaged.webp"));
    ffp_frames_close(&frames);
}

// A picture alone is not a film, an animation whose number of frames was not known before is one.
static void animated_pictures(void **state) {
    (void)state;
    FfpImage picture = ffp_image_new(4, 4, 3);
    for (int frames = 1; frames <= 2; frames++) {
        FfpFilm film;
        FfpError err = {0};
        assert_true(ffp_film_open(&film, in_scratch("own.png"), 0, 10, &err));
        for (int f = 0; f < frames; f++) assert_true(ffp_film_add(&film, &picture, &err));
        if (!ffp_film_commit(&film, &err)) fail_msg("%s", err.text);
        assert_int_equal(ffp_frames_are_in(in_scratch("own.png")), frames > 1);
    }
    ffp_image_free(&picture);
    need_ffmpeg();
    FfpFrames frames;
    FfpRaw frame;
    FfpError err = {0};
    if (!ffp_frames_open(&frames, in_scratch("own.png"), 10, &err)) fail_msg("%s", err.text);
    while (ffp_frames_next(&frames, &frame, &err) > 0) assert_int_equal(frame.width, 4);
    assert_int_equal(frames.count, 2);
    ffp_frames_close(&frames);
}

// A film is exactly as large as its frames, even where sides are odd.
static void films_keep_their_size(void **state) {
    (void)state;
    static const char *const names[] = {"odd.mp4", "odd.mkv", "odd.webm", "odd.gif"};
    need_ffmpeg();
    FfpImage picture = ffp_image_new(35, 21, 3);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        FfpFilm film;
        FfpFrames frames;
        FfpRaw frame;
        FfpError err = {0};
        assert_true(ffp_film_open(&film, in_scratch(names[i]), 1, 10, &err));
        assert_true(ffp_film_add(&film, &picture, &err));
        if (!ffp_film_commit(&film, &err)) fail_msg("%s", err.text);
        if (!ffp_frames_open(&frames, in_scratch(names[i]), 10, &err)) fail_msg("%s", err.text);
        assert_int_equal(ffp_frames_next(&frames, &frame, &err), 1);
        assert_int_equal(frame.width, 35);
        assert_int_equal(frame.height, 21);
        ffp_frames_close(&frames);
    }
    ffp_image_free(&picture);
}

// gAMA of 1, behind the header of an animated PNG.
static void profiles_of_animations_are_told(void **state) {
    (void)state;
    static const char linear[] = "\0\0\0\x04gAMA\0\x01\x86\xa0\x31\xe8\x96\x5f";
    enum { HEADER = 33 };
    static const Case of = {.name = "linear.png",
                            .wide = 64,
                            .high = 48,
                            .channels = 3,
                            .frames = 3,
                            .tolerance = 1,
                            .right_alpha = 255};
    need_ffmpeg();
    char command[1024], *png;
    size_t size;
    FfpError err = {0};
    snprintf(command, sizeof command,
             "ffmpeg -loglevel error -nostdin -y -f lavfi -i color=red:s=64x48:r=3:d=1 -filter_complex "
             "\"format=gbrp," SPLIT ",format=rgb24\" -f apng %s/plain.png",
             scratch);
    if (system(command) != 0) fail_msg("%s", command);
    assert_true(ffp_read_file(in_scratch("plain.png"), 1 << 20, &png, &size, &err));
    FILE *out = fopen(in_scratch("linear.png"), "wb");
    assert_non_null(out);
    fwrite(png, 1, HEADER, out);
    fwrite(linear, 1, sizeof linear - 1, out);
    fwrite(png + HEADER, 1, size - HEADER, out);
    assert_int_equal(fclose(out), 0);
    ffp_free(png);
    Said said = {.of = &of};
    FfpContext context = {.settings = {.user = &said, .log = hear}};
    if (!ffp_call_run(&context, read_film, &said, &err)) fail_msg("%s", err.text);
    if (!strstr(said.words, "its colour profile is left out")) fail_msg("said \"%s\"", said.words);
}

// Containers of cameras and editors. Of tapes the frames alone tell that they are interlaced.
static void films_of_cameras(void **state) {
    (void)state;
    static const struct {
        const char *options, *name;
        bool interlaced;
    } films[] = {{"-vf setfield=bff -c:v dvvideo -pix_fmt yuv420p", "tape.avi", true},
                 {"-vf setfield=bff -c:v dvvideo -pix_fmt yuv420p", "tape.dv", true},
                 {"-c:v mpeg2video", "card.ts", false},
                 {"-c:v mpeg2video -mpegts_m2ts_mode 1", "card.m2ts", false},
                 {"-c:v mpeg2video", "card.mxf", false},
                 {"-c:v wmv2", "card.wmv", false},
                 {"-c:v libtheora", "card.ogv", false},
                 {"-flags +ildct -plays 0", "passes.apng", false}}; // Adam7, which ffprobe tells as fields
    need_ffmpeg();
    for (size_t i = 0; i < sizeof films / sizeof *films; i++) {
        char command[1024], filter[FFP_STREAM_FILTER];
        FfpStream stream;
        snprintf(command, sizeof command,
                 "ffmpeg -loglevel error -nostdin -y -f lavfi -i color=red:s=720x576:r=25:d=0.2 %s %s/%s",
                 films[i].options, scratch, films[i].name);
        if (system(command) != 0) fail_msg("%s", command);
        if (!ffp_frames_are_in(in_scratch(films[i].name))) fail_msg("%s is not a film", films[i].name);
        ffp_stream_probe(&stream, in_scratch(films[i].name));
        ffp_stream_filter(&stream, false, filter);
        if ((strstr(filter, "bwdif") != NULL) != films[i].interlaced)
            fail_msg("%s: %s", films[i].name, filter);
    }
}

// The left half of each field's lines moves on between the two: whole frames have no combs.
static void interlaced_frames_are_made_whole(void **state) {
    (void)state;
    need_ffmpeg();
    char command[1024];
    snprintf(
        command, sizeof command,
        "ffmpeg -loglevel error -nostdin -y -f lavfi -i \"nullsrc=s=64x48:r=50:d=0.4,geq=lum='if(lt(X,8+4*N)"
        ",235,16)':cb=128:cr=128,format=yuv420p,tinterlace=interleave_top,setfield=tff\" -c:v mpeg2video "
        "-flags +ilme+ildct -q:v 2 %s/fields.mpg",
        scratch);
    if (system(command) != 0) fail_msg("%s", command);
    FfpFrames frames;
    FfpRaw frame;
    FfpError err = {0};
    int combs = 0;
    if (!ffp_frames_open(&frames, in_scratch("fields.mpg"), 0, &err)) fail_msg("%s", err.text);
    assert_true(frames.rate.frames == 25 * frames.rate.seconds);
    while (ffp_frames_next(&frames, &frame, &err) > 0)
        for (int y = 8; frames.count > 1 && y < 40; y++) {
            const unsigned char *at = (const unsigned char *)frame.data + (ptrdiff_t)3 * 64 * y;
            for (int x = 0; x < 64; x++)
                combs += abs(at[3 * x] - at[3 * (x - 64)]) > 100 && abs(at[3 * x] - at[3 * (x + 64)]) > 100;
        }
    assert_true(frames.count > 5);
    ffp_frames_close(&frames);
    assert_int_equal(combs, 0);
}

typedef struct Copied {
    const char *name;
    int rate;
    char words[512];
} Copied;

static void hear_copy(void *user, FfpLogLevel level, const char *text) {
    (void)level;
    Copied *copied = user;
    strncat(copied->words, text, sizeof copied->words - strlen(copied->words) - 1);
}

static bool copy_film(void *argument, FfpError *err) {
    const Copied *copied = argument;
    FfpFilm film;
    FfpFrames frames;
    FfpRaw frame;
    FfpImage picture = ffp_image_new(16, 16, 3);
    bool ok = ffp_film_open(&film, in_scratch(copied->name), 0, 0, err) &&
              ffp_frames_open(&frames, in_scratch("sounds.mkv@0.2-1"), copied->rate, err);
    if (ok) ffp_film_follow(&film, &frames);
    while (ok && ffp_frames_next(&frames, &frame, err) > 0) ok = ffp_film_add(&film, &picture, err);
    ffp_frames_close(&frames);
    ffp_image_free(&picture);
    return ok && ffp_film_commit(&film, err);
}

// Of a part, at a rate that is not whole.
static void a_film_keeps_its_rate_and_sound(void **state) {
    (void)state;
    static const struct {
        const char *name, *note;
        bool sound;
    } copies[] = {{"copy.mp4", "", true},
                  {"copy.mkv", "", true},
                  {"copy.png", "without the sound of sounds.mkv", false}};
    need_ffmpeg();
    char command[1024];
    snprintf(command, sizeof command,
             "ffmpeg -loglevel error -nostdin -y -f lavfi -i testsrc2=s=32x32:r=30000/1001:d=1 -f lavfi -i "
             "sine=d=1 "
             "-c:v mpeg4 -c:a flac %s/sounds.mkv",
             scratch);
    if (system(command) != 0) fail_msg("%s", command);
    for (size_t i = 0; i < sizeof copies / sizeof *copies; i++) {
        Copied copied = {.name = copies[i].name};
        FfpError err = {0};
        FfpStream stream;
        FfpContext context = {.settings = {.user = &copied, .log = hear_copy}};
        if (!ffp_call_run(&context, copy_film, &copied, &err)) fail_msg("%s", err.text);
        ffp_stream_probe(&stream, in_scratch(copies[i].name));
        assert_int_equal(stream.rate.frames, 30000);
        assert_int_equal(stream.rate.seconds, 1001);
        assert_true(ffp_stream_has_sound(in_scratch(copies[i].name)) == copies[i].sound);
        if (copies[i].sound && !(fabs(stream.seconds - 0.8) < 0.1)) fail_msg("%g s", stream.seconds);
        assert_null(strstr(copied.words, "frames a second"));
        if (*copies[i].note && !strstr(copied.words, copies[i].note)) fail_msg("said \"%s\"", copied.words);
    }
    Copied slow = {.name = "slow.mkv", .rate = 10};
    FfpContext context = {.settings = {.user = &slow, .log = hear_copy}};
    assert_true(ffp_call_run(&context, copy_film, &slow, NULL));
    assert_non_null(strstr(slow.words, "read at 10 frames a second, not at its own 29.97"));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(films_of_many_kinds),
                                       cmocka_unit_test(pictures_of_webp_show_as_long_as_they_say),
                                       cmocka_unit_test(damaged_webp_is_refused),
                                       cmocka_unit_test(animated_pictures),
                                       cmocka_unit_test(films_keep_their_size),
                                       cmocka_unit_test(interlaced_frames_are_made_whole),
                                       cmocka_unit_test(films_of_cameras),
                                       cmocka_unit_test(profiles_of_animations_are_told),
                                       cmocka_unit_test(a_film_keeps_its_rate_and_sound)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
