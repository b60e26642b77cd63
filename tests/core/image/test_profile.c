// Pictures that say what their colours are: red, green and grey of sRGB in other colours read as what they
// are.
#include <lcms2.h>
#include <math.h>
#include "core/base/call.h"
#include "core/image/image.h"
#include "core/image/picture_files.h"
#include "core/image/profile.h"

enum { SIDE = 16 };

// Display P3: sRGB's white and curve. Red of sRGB in it is 0.9175 0.2003 0.1386 (CSS Color 4, 10.9).
static const cmsCIExyY white = {0.3127, 0.3290, 1};
static const cmsCIExyYTRIPLE p3 = {{0.680, 0.320, 1}, {0.265, 0.690, 1}, {0.150, 0.060, 1}};
static const unsigned char red_in_p3[3] = {234, 51, 35}, red[3] = {255, 0, 0};

static cmsUInt32Number save(cmsHPROFILE profile, unsigned char *bytes, cmsUInt32Number room) {
    cmsUInt32Number size = 0;
    assert_true(cmsSaveProfileToMem(profile, NULL, &size));
    assert_true(size <= room && cmsSaveProfileToMem(profile, bytes, &size));
    cmsCloseProfile(profile);
    return size;
}

static cmsUInt32Number make_p3(unsigned char *bytes, cmsUInt32Number room, bool srgb) {
    const cmsFloat64Number numbers[5] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
    cmsToneCurve *curve = cmsBuildParametricToneCurve(NULL, 4, numbers), *curves[3] = {curve, curve, curve};
    cmsHPROFILE profile = srgb ? cmsCreate_sRGBProfile() : cmsCreateRGBProfile(&white, &p3, curves);
    cmsFreeToneCurve(curve);
    return save(profile, bytes, room);
}

// Inks: none is white, cyan alone a grey of L* = 50, all others black.
static cmsUInt32Number make_inks(unsigned char *bytes, cmsUInt32Number room) {
    cmsUInt16Number table[16][3];
    for (int i = 0; i < 16; i++) {
        table[i][0] = i == 0 ? 0xff00 : i == 8 ? 0x7f80 : 0; // the first ink changes slowest
        table[i][1] = table[i][2] = 0x8000;
    }
    cmsHPROFILE profile = cmsCreateProfilePlaceholder(NULL);
    cmsSetProfileVersion(profile, 2.1);
    cmsSetDeviceClass(profile, cmsSigOutputClass);
    cmsSetColorSpace(profile, cmsSigCmykData);
    cmsSetPCS(profile, cmsSigLabData);
    cmsPipeline *pipeline = cmsPipelineAlloc(NULL, 4, 3);
    cmsPipelineInsertStage(pipeline, cmsAT_BEGIN, cmsStageAllocCLut16bit(NULL, 2, 4, 3, table[0]));
    assert_true(cmsWriteTag(profile, cmsSigAToB0Tag, pipeline) &&
                cmsWriteTag(profile, cmsSigAToB1Tag, pipeline));
    cmsPipelineFree(pipeline);
    return save(profile, bytes, room);
}

typedef struct Png {
    const unsigned char *icc, *points, *exif; // points: cICP
    size_t icc_size, exif_size;
    int gamma;
} Png;

static void write_png(const char *path, const unsigned char colour[3], const Png *how) {
    FILE *stream = fopen(path, "wb");
    assert_non_null(stream);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, stream);
    png_set_IHDR(png, info, SIDE, SIDE, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (how->icc)
        png_set_iCCP(png, info, "colours", PNG_COMPRESSION_TYPE_BASE, how->icc, (png_uint_32)how->icc_size);
    if (how->gamma) png_set_gAMA_fixed(png, info, how->gamma);
    png_write_info(png, info);
    if (how->points) png_write_chunk(png, (png_const_bytep) "cICP", how->points, 4);
    if (how->exif) png_write_chunk(png, (png_const_bytep) "eXIf", how->exif, how->exif_size);
    unsigned char row[3 * SIDE];
    for (int i = 0; i < 3 * SIDE; i++) row[i] = colour[i % 3];
    for (int y = 0; y < SIDE; y++) png_write_row(png, row);
    png_write_end(png, NULL);
    png_destroy_write_struct(&png, &info);
    fclose(stream);
}

static void write_jpeg(const char *path, const unsigned char *colour, int channels, const unsigned char *icc,
                       cmsUInt32Number size) {
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr errors;
    FILE *stream = fopen(path, "wb");
    assert_non_null(stream);
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    jpeg_stdio_dest(&jpeg, stream);
    jpeg.image_width = jpeg.image_height = SIDE;
    jpeg.input_components = channels;
    jpeg.in_color_space = channels == 4 ? JCS_CMYK : JCS_RGB;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, 100, TRUE);
    jpeg_start_compress(&jpeg, TRUE);
    jpeg_write_icc_profile(&jpeg, icc, size);
    unsigned char row[4 * SIDE];
    for (int i = 0; i < channels * SIDE; i++) row[i] = colour[i % channels];
    JSAMPROW rows = row;
    for (int y = 0; y < SIDE; y++) jpeg_write_scanlines(&jpeg, &rows, 1);
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    fclose(stream);
}

static void write_tiff(const char *path, const unsigned char colour[3], const unsigned char *icc,
                       cmsUInt32Number size) {
    TIFF *tiff = TIFFOpen(path, "w");
    assert_non_null(tiff);
    unsigned char row[3 * SIDE];
    for (int i = 0; i < 3 * SIDE; i++) row[i] = colour[i % 3];
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, SIDE);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, SIDE);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 3);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
    TIFFSetField(tiff, TIFFTAG_ICCPROFILE, size, icc);
    for (int y = 0; y < SIDE; y++) TIFFWriteScanline(tiff, row, (uint32_t)y, 0);
    TIFFClose(tiff);
}

// --- What is read. ---

typedef struct Said {
    const char *name;
    char words[512];
    FfpImage image;
    FfpColour colour;
    int shrink;
} Said;

static void hear(void *user, FfpLogLevel level, const char *text) {
    Said *said = user;
    (void)level;
    strncat(said->words, text, sizeof said->words - strlen(said->words) - 1);
}

static bool read_it(void *argument, FfpError *err) {
    Said *said = argument;
    int whole[2];
    if (!said->shrink) return ffp_image_read(&said->image, in_scratch(said->name), said->colour, err);
    if (!ffp_image_read_reduced(&said->image, NULL, whole, in_scratch(said->name), false, said->shrink, true,
                                err))
        return false;
    ffp_image_to_srgb(&said->image);
    return true;
}

static void expect_as(const char *name, FfpColour colour, int shrink, const unsigned char wanted[3],
                      const char *note) {
    Said said = {.name = name, .colour = colour, .shrink = shrink};
    FfpError err = {0};
    FfpContext context = {.settings = {.user = &said, .log = hear}};
    if (!ffp_call_run(&context, read_it, &said, &err)) fail_msg("%s", err.text);
    for (int c = 0; c < 3; c++)
        if (!(fabs((double)said.image.data[c] * 255 - wanted[c]) <= 2.01))
            fail_msg("%s, channel %d: %.1f, not %d", name, c, (double)said.image.data[c] * 255, wanted[c]);
    if (*note ? !strstr(said.words, note) : *said.words != 0) fail_msg("%s: said \"%s\"", name, said.words);
    ffp_image_free(&said.image);
}

static void expect_colour(const char *name, const unsigned char wanted[3], const char *note) {
    expect_as(name, FFP_COLOUR_ENCODED, 0, wanted, note);
}

static void profiles_are_converted(void **state) {
    (void)state;
    static unsigned char icc[1 << 16];
    const cmsUInt32Number size = make_p3(icc, sizeof icc, false);
    write_png(in_scratch("p3.png"), red_in_p3, &(Png){.icc = icc, .icc_size = size});
    write_jpeg(in_scratch("p3.jpg"), red_in_p3, 3, icc, size);
    write_tiff(in_scratch("p3.tif"), red_in_p3, icc, size);
    expect_colour("p3.png", red, "p3.png: converted from RGB built-in to sRGB");
    expect_colour("p3.jpg", red, "p3.jpg: converted from");
    expect_as("p3.jpg", FFP_COLOUR_ENCODED, 2, red, "p3.jpg: converted from");
    expect_colour("p3.tif", red, "p3.tif: converted from");
    expect_as("p3.png", FFP_COLOUR_STORED, 0, red_in_p3, "");
}

static void srgb_stays(void **state) {
    (void)state;
    static unsigned char icc[1 << 16];
    const cmsUInt32Number size = make_p3(icc, sizeof icc, true);
    write_png(in_scratch("srgb.png"), red_in_p3, &(Png){.icc = icc, .icc_size = size});
    expect_colour("srgb.png", red_in_p3, "");
    write_png(in_scratch("gamma.png"), red_in_p3, &(Png){.gamma = 45455});
    expect_colour("gamma.png", red_in_p3, "");
}

static void tags_of_png_are_converted(void **state) {
    (void)state;
    const unsigned char grey[3] = {55, 55, 55}, light[3] = {128, 128, 128};
    write_png(in_scratch("cicp.png"), red_in_p3, &(Png){.points = (const unsigned char[]){12, 13, 0, 1}});
    expect_colour("cicp.png", red, "cicp.png: converted from its tags of colour");
    write_png(in_scratch("linear.png"), grey, &(Png){.gamma = 100000}); // 55 / 255 is 128 encoded
    expect_colour("linear.png", light, "converted");
    write_png(in_scratch("pq.png"), light, &(Png){.points = (const unsigned char[]){9, 16, 0, 1}});
    expect_colour("pq.png", light, "pq.png: is HDR");
}

// Behind "Exif": the colours are not sRGB (65535), and the rule of interoperability is R03; cut or with
// another rule, they stay.
static void adobe_rgb_is_told_by_exif(void **state) {
    (void)state;
    static unsigned char exif[] =
        "Exif\0\0MM\0*\0\0\0\x08\0\x01\x87\x69\0\x04\0\0\0\x01\0\0\0\x1a\0\0\0\0"
        "\0\x02\xa0\x01\0\x03\0\0\0\x01\xff\xff\0\0\xa0\x05\0\x04\0\0\0\x01\0\0\0\x38\0\0\0\0"
        "\0\x01\0\x01\0\x02\0\0\0\x04R03";
    enum { WHOLE = sizeof exif, RULE = 6 + 0x38 + 10, COLOURS = 6 + 0x1a + 10 };
    static const unsigned char in_adobe[3] = {219, 0, 0};
    static const char note[] = "converted from Adobe RGB, as its EXIF data say, to sRGB";
    unsigned char pixels[SIDE * SIDE * 3];
    for (int i = 0; i < SIDE * SIDE * 3; i++) pixels[i] = in_adobe[i % 3];
    JpegKind kind = {.given = JCS_RGB, .stored = JCS_RGB, .exif = exif, .exif_size = WHOLE};
    write_jpeg_kind(in_scratch("adobe.jpg"), pixels, SIDE, SIDE, &kind);
    expect_colour("adobe.jpg", red, note);
    expect_as("adobe.jpg", FFP_COLOUR_ENCODED, 2, red, note);
    write_png(in_scratch("adobe.png"), in_adobe, &(Png){.exif = exif + 6, .exif_size = WHOLE - 6});
    expect_colour("adobe.png", red, note);
    kind.exif_size = RULE + 2;
    write_jpeg_kind(in_scratch("cut.jpg"), pixels, SIDE, SIDE, &kind);
    expect_colour("cut.jpg", in_adobe, "");
    kind.exif_size = WHOLE;
    memcpy(exif + RULE, "R98", 3);
    write_jpeg_kind(in_scratch("srgb.jpg"), pixels, SIDE, SIDE, &kind);
    expect_colour("srgb.jpg", in_adobe, "");
    memcpy(exif + COLOURS, "\0\2", 2);
    write_jpeg_kind(in_scratch("two.jpg"), pixels, SIDE, SIDE, &kind);
    expect_colour("two.jpg", red, note);
}

static void inks_are_converted(void **state) {
    (void)state;
    static unsigned char icc[1 << 16];
    const cmsUInt32Number size = make_inks(icc, sizeof icc);
    // libjpeg writes Adobe's marker: 255 is not an ink
    const unsigned char none[4] = {255, 255, 255, 255}, cyan[4] = {0, 255, 255, 255},
                        black[4] = {255, 255, 255, 0};
    write_jpeg(in_scratch("none.jpg"), none, 4, icc, size);
    write_jpeg(in_scratch("cyan.jpg"), cyan, 4, icc, size);
    write_jpeg(in_scratch("black.jpg"), black, 4, icc, size);
    expect_colour("none.jpg", (const unsigned char[]){255, 255, 255}, "none.jpg: converted");
    expect_colour("cyan.jpg", (const unsigned char[]){119, 119, 119}, "converted"); // L* = 50
    expect_colour("black.jpg", (const unsigned char[]){0, 0, 0}, "converted");
}

static void broken_profiles_are_ignored(void **state) {
    (void)state;
    static unsigned char icc[1 << 16];
    cmsUInt32Number size = make_p3(icc, sizeof icc, false);
    memset(icc + 40, 0xff, 200);
    write_jpeg(in_scratch("broken.jpg"), red_in_p3, 3, icc, size);
    expect_colour("broken.jpg", red_in_p3, "cannot be used, and is ignored");
    size = make_inks(icc, sizeof icc);
    write_jpeg(in_scratch("other.jpg"), red_in_p3, 3, icc, size);
    expect_colour("other.jpg", red_in_p3, "cannot be used, and is ignored");
}

// Behind the header of a WebP; of a length that goes beyond the file there is none.
static void profiles_of_webp_are_found(void **state) {
    (void)state;
    enum { AT = 38, ROOM = 4096 };
    unsigned char bytes[AT + ROOM] = "RIFF....WEBPVP8X\x0a\0\0\0\x20.........ICCP";
    for (int srgb = 0; srgb < 2; srgb++) {
        const cmsUInt32Number size = make_p3(bytes + AT, ROOM, srgb);
        bytes[AT - 4] = size & 255, bytes[AT - 3] = (unsigned char)(size >> 8);
        FfpColourProfile found = ffp_profile_find(&(FfpEncoded){bytes, AT + size, "a.webp"});
        assert_int_equal(found.size, size);
        assert_true(ffp_profile_is_srgb(&found) == srgb);
        ffp_free(found.icc);
        for (size_t cut = 12; cut < AT + size; cut += cut < AT + 2 ? 1 : 100)
            assert_true(ffp_profile_find(&(FfpEncoded){bytes, cut, "a.webp"}).kind == FFP_PROFILE_NONE);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(profiles_are_converted),    cmocka_unit_test(srgb_stays),
        cmocka_unit_test(tags_of_png_are_converted), cmocka_unit_test(adobe_rgb_is_told_by_exif),
        cmocka_unit_test(inks_are_converted),        cmocka_unit_test(broken_profiles_are_ignored),
        cmocka_unit_test(profiles_of_webp_are_found)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
