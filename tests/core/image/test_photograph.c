// Raw photographs and films, with the real programs if they are installed, and with scripts in their place
// that do what programs should not.
#include <math.h>
#include <stdint.h>
#include <sys/stat.h>
#include "core/base/call.h"
#include "core/base/process.h"
#include "core/image/photograph.h"
#include "core/image/picture_files.h"

enum { WIDTH = 64, HEIGHT = 48, FRAMES = 6 };

static char path_before[4096];

static int group_setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    snprintf(path_before, sizeof path_before, "%s", getenv("PATH"));
    return ffp_make_folders(in_scratch("bin"), NULL) ? 0 : -1;
}

static int real_programs(void **state) {
    (void)state;
    return setenv("PATH", path_before, 1);
}

static void need_program(const char *name) {
    if (ffp_program_exists(name)) return;
    printf("skipped: %s is not here\n", name);
    skip();
}

// scratch/bin/NAME, found before the system's.
static void put_program(const char *name, const char *script) {
    char path[4200], file[64];
    snprintf(file, sizeof file, "bin/%s", name);
    assert_true(ffp_write_file(in_scratch(file), script, strlen(script), NULL));
    assert_int_equal(chmod(in_scratch(file), 0755), 0);
    snprintf(path, sizeof path, "%s/bin:%s", scratch, path_before);
    setenv("PATH", path, 1);
}

static FfpImage read_photograph(const char *path, bool linear, FfpDeveloped *developed) {
    FfpImage rgb, alpha;
    FfpError err = {0};
    int width, height;
    if (!ffp_photograph_read(&rgb, &alpha, path, linear, developed, &err)) fail_msg("%s", err.text);
    assert_null(alpha.data);
    if (!ffp_photograph_read_size(&width, &height, path, &err)) fail_msg("%s", err.text);
    assert_int_equal(width, rgb.width);
    assert_int_equal(height, rgb.height);
    return rgb;
}

static void expect_refusal(const char *path, const char *words) {
    FfpImage rgb;
    FfpError err = {0};
    assert_false(ffp_photograph_read(&rgb, NULL, path, false, NULL, &err));
    if (!strstr(err.text, words)) fail_msg("'%s' does not say '%s'", err.text, words);
    if (!strstr(err.text, path)) fail_msg("'%s' does not name the file", err.text);
}

// --- Raw photographs. ---

#define BLACK 256
#define WHITE 16383

static const double colour_left[3] = {0.6, 0.3, 0.1}, colour_right[3] = {0.05, 0.5, 0.9};

// A DNG of a camera whose colours are those of sRGB: the left half of one colour, the right of another, seen
// through a filter of red, green / green, blue.
static void write_dng(const char *path) {
    static const float to_camera[9] = {3.2404542F, -1.5371385F, -0.4985314F, -0.9692660F, 1.8760108F,
                                       0.0415560F, 0.0556434F,  -0.2040259F, 1.0572252F};
    const float neutral[3] = {1, 1, 1};
    const uint32_t white = WHITE;
    const float black = BLACK;
    const uint16_t pattern_size[2] = {2, 2};
    TIFF *tiff = TIFFOpen(path, "w");
    assert_non_null(tiff);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, WIDTH);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, HEIGHT);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 16);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_CFA);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, HEIGHT);
    TIFFSetField(tiff, TIFFTAG_MAKE, "Test");
    TIFFSetField(tiff, TIFFTAG_MODEL, "Test");
    TIFFSetField(tiff, TIFFTAG_UNIQUECAMERAMODEL, "Test");
    TIFFSetField(tiff, TIFFTAG_DNGVERSION, "\1\4\0\0");
    TIFFSetField(tiff, TIFFTAG_CFAREPEATPATTERNDIM, pattern_size);
    TIFFSetField(tiff, TIFFTAG_CFAPATTERN, 4, "\0\1\1\2");
    TIFFSetField(tiff, TIFFTAG_COLORMATRIX1, 9, to_camera);
    TIFFSetField(tiff, TIFFTAG_CALIBRATIONILLUMINANT1, 21); // daylight of 6504 K
    TIFFSetField(tiff, TIFFTAG_ASSHOTNEUTRAL, 3, neutral);
    TIFFSetField(tiff, TIFFTAG_WHITELEVEL, 1, &white);
    TIFFSetField(tiff, TIFFTAG_BLACKLEVEL, 1, &black);
    for (int y = 0; y < HEIGHT; y++) {
        uint16_t row[WIDTH];
        for (int x = 0; x < WIDTH; x++) {
            const double light = (x < WIDTH / 2 ? colour_left : colour_right)[x % 2 + y % 2];
            row[x] = (uint16_t)lrint(BLACK + light * (WHITE - BLACK));
        }
        assert_int_equal(TIFFWriteScanline(tiff, row, (uint32_t)y, 0), 1);
    }
    TIFFClose(tiff);
}

static void a_raw_photograph_is_linear_light(void **state) {
    (void)state;
    need_program("dcraw_emu");
    FfpDeveloped developed = {0};
    write_dng(in_scratch("a.dng"));
    for (int linear = 0; linear < 2; linear++) {
        FfpImage rgb = read_photograph(in_scratch("a.dng"), linear, &developed);
        assert_int_equal(rgb.width, WIDTH);
        assert_int_equal(rgb.height, HEIGHT);
        for (int side = 0; side < 2; side++)
            for (int c = 0; c < 3; c++) {
                const real got = rgb.data[3 * (HEIGHT / 2 * WIDTH + WIDTH / 4 + side * WIDTH / 2) + c];
                const double want = (side ? colour_right : colour_left)[c];
                if (!(fabs((double)got - want) <= 0.01))
                    fail_msg("side %d, channel %d: %g, not %g", side, c, (double)got, want);
            }
        ffp_image_free(&rgb);
    }
    assert_int_equal(developed.raws, 2);
    assert_int_equal(developed.films, 0);
    expect_refusal(in_scratch("a.dng@1"), "is not a film: it has no parts");
}

static void a_broken_raw_photograph_is_named(void **state) {
    (void)state;
    need_program("dcraw_emu");
    const char bytes[64] = "FUJIFILMCCD-RAW 0201FF000000Test";
    assert_true(ffp_write_file(in_scratch("broken.raf"), bytes, sizeof bytes, NULL));
    expect_refusal(in_scratch("broken.raf"), "dcraw_emu could not make a picture of it");
}

static void without_the_program_it_says_which(void **state) {
    (void)state;
    const char raw[64] = "FUJIFILMCCD-RAW 0201FF000000Test", film[32] = "\0\0\0\x20"
                                                                        "ftypisom";
    assert_true(ffp_write_file(in_scratch("a.raf"), raw, sizeof raw, NULL));
    assert_true(ffp_write_file(in_scratch("a.mp4"), film, sizeof film, NULL));
    setenv("PATH", "/nonexistent", 1);
    expect_refusal(in_scratch("a.raf"), "libraw-bin");
    expect_refusal(in_scratch("a.mp4"), "ffmpeg, is not installed");
}

// --- Films. ---

static unsigned char level_of(int frame) {
    return (unsigned char)(40 + 30 * frame);
}

// Frames of one grey each, one a second, without loss.
static void write_film(const char *name) {
    char command[512];
    static unsigned char bytes[FRAMES][HEIGHT][WIDTH][3];
    for (int f = 0; f < FRAMES; f++) memset(bytes[f], level_of(f), sizeof bytes[f]);
    assert_true(ffp_write_file(in_scratch("frames"), bytes, sizeof bytes, NULL));
    snprintf(
        command, sizeof command,
        "ffmpeg -loglevel error -nostdin -y -f rawvideo -pix_fmt rgb24 -s %dx%d -r 1 -i %s/frames -c:v ffv1 "
        "-pix_fmt bgr0 %s/%s",
        WIDTH, HEIGHT, scratch, scratch, name);
    assert_int_equal(system(command), 0);
}

static void expect_mean(const char *path, bool linear, int first, int last) {
    FfpDeveloped developed = {0};
    FfpImage rgb = read_photograph(path, linear, &developed);
    double mean = 0;
    for (int f = first; f <= last; f++) {
        const real value = (real)level_of(f) / 255;
        mean += (double)(linear ? value : ffp_srgb_decode(value)) / (last - first + 1);
    }
    assert_int_equal(rgb.width, WIDTH);
    assert_int_equal(developed.films, 1);
    assert_int_equal(developed.frames, last - first + 1);
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++)
        if (!(fabs((double)rgb.data[i] - mean) <= 1e-4)) fail_msg("%g, not %g", (double)rgb.data[i], mean);
    ffp_image_free(&rgb);
}

static void a_film_is_the_mean_of_its_frames(void **state) {
    (void)state;
    need_program("ffmpeg");
    write_film("film.mkv");
    expect_mean(in_scratch("film.mkv"), false, 0, FRAMES - 1);
    expect_mean(in_scratch("film.mkv"), true, 0, FRAMES - 1);
    expect_mean(in_scratch("film.mkv@2"), false, 2, 2);
    expect_mean(in_scratch("film.mkv@1-4"), false, 1, 3);
    assert_true(ffp_photograph_check(in_scratch("film.mkv@1-4"), "the film", NULL));
    expect_refusal(in_scratch("film.mkv@20-30"), "the film may be shorter");
    write_flat_png(in_scratch("a.png"), 8, 8, 8, PNG_COLOR_TYPE_RGB, 9);
    expect_refusal(in_scratch("a.png@2"), "is not a film");
}

// Wrong parts of a film are told before anything is developed.
static void wrong_parts_are_named(void **state) {
    (void)state;
    static const char *const wrong[] = {"4-1", "1x", "1-", "-2", "start", "", "1,5"};
    const char film[64] = "\0\0\0\x20"
                          "ftypisom";
    char name[64], path[4200], words[64];
    assert_true(ffp_write_file(in_scratch("p.mp4"), film, sizeof film, NULL));
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        FfpError err = {0};
        snprintf(name, sizeof name, "p.mp4@%s", wrong[i]);
        snprintf(words, sizeof words, "invalid part of a film '%s'", wrong[i]);
        snprintf(path, sizeof path, "%s", in_scratch(name));
        expect_refusal(path, words);
        assert_false(ffp_photograph_check(path, "the film", &err));
        if (!strstr(err.text, words)) fail_msg("%s", err.text);
        assert_true(ffp_photograph_names_part(path));
    }
    FfpError err = {0};
    assert_false(ffp_photograph_check(in_scratch("other.mkv@1"), "view '000'", &err));
    assert_non_null(strstr(err.text, "no such file: view '000'"));
    assert_true(ffp_write_file(in_scratch("a@b.png"), film, sizeof film, NULL));
    assert_false(ffp_photograph_names_part(in_scratch("a@b.png")));
    assert_true(ffp_photograph_check(in_scratch("a@b.png"), "", NULL));
}

// By its bytes, whatever the name says; a picture under such a name is read as one.
static void what_is_only_named_so_is_told(void **state) {
    (void)state;
    const char text[] = "aperture 5.6, 1/30 s\n";
    assert_true(ffp_write_file(in_scratch("x.cr2"), text, sizeof text, NULL));
    expect_refusal(in_scratch("x.cr2"), "is not a raw photograph despite its extension");
    assert_true(ffp_write_file(in_scratch("x.MOV"), text, sizeof text, NULL));
    expect_refusal(in_scratch("x.MOV"), "is not a film despite its extension");
    assert_true(ffp_write_file(in_scratch("x.png"), text, sizeof text, NULL));
    expect_refusal(in_scratch("x.png"), "is not a PNG");
    write_flat_png(in_scratch("really.nef"), 8, 8, 8, PNG_COLOR_TYPE_RGB, 9);
    FfpImage rgb = read_photograph(in_scratch("really.nef"), false, NULL);
    ffp_image_free(&rgb);
}

static void a_broken_film_is_named(void **state) {
    (void)state;
    need_program("ffmpeg");
    const char film[64] = "\0\0\0\x20"
                          "ftypisom";
    assert_true(ffp_write_file(in_scratch("broken.mp4"), film, sizeof film, NULL));
    expect_refusal(in_scratch("broken.mp4"), "ffmpeg could not make a picture of it: ");
}

// --- What programs should not do. ---

static void odd_output_is_refused(void **state) {
    (void)state;
    static const char *const odd[][2] = {
        {"true", "could not make a picture of it"},
        {"printf 'P5 2 2 255 '", "could not make a picture of it"},
        {"printf 'P6 2 2 65535 '; head -c 24 /dev/zero", "could not make a picture of it"},
        {"printf 'P6 2 2 255 '; head -c 11 /dev/zero", "could not make a picture of it"},
        {"printf 'P6 999999 999999 255 '; head -c 99 /dev/zero", "could not make a picture of it"},
        {"printf 'P6 99999999999999999999 2 255 '", "could not make a picture of it"},
        {"printf 'P6 2 2 255 '; head -c 12 /dev/zero; printf 'P6 2 1 255 '; head -c 6 /dev/zero",
         "several sizes, 2 x 2 and 2 x 1"},
        {"printf 'P6 2 2 255 '; head -c 12 /dev/zero; echo 'no memory' >&2; exit 3", "no memory"},
    };
    const char film[32] = "\0\0\0\x20"
                          "ftypisom";
    assert_true(ffp_write_file(in_scratch("b.mp4"), film, sizeof film, NULL));
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        char script[256];
        snprintf(script, sizeof script, "#!/bin/sh\n%s\n", odd[i][0]);
        put_program("ffmpeg", script);
        expect_refusal(in_scratch("b.mp4"), odd[i][1]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_raw_photograph_is_linear_light, real_programs),
        cmocka_unit_test_setup(a_broken_raw_photograph_is_named, real_programs),
        cmocka_unit_test_setup(without_the_program_it_says_which, real_programs),
        cmocka_unit_test_setup(a_film_is_the_mean_of_its_frames, real_programs),
        cmocka_unit_test_setup(wrong_parts_are_named, real_programs),
        cmocka_unit_test_setup(what_is_only_named_so_is_told, real_programs),
        cmocka_unit_test_setup(a_broken_film_is_named, real_programs),
        cmocka_unit_test_setup(odd_output_is_refused, real_programs),
    };
    return cmocka_run_group_tests(tests, group_setup, scratch_teardown);
}
