// Picture files of all the kinds that cameras and programs write, and those that are refused.
#include <math.h>
#include "core/base/call.h"
#include "core/image/codec.h"
#include "core/image/image.h"
#include "core/image/picture_files.h"

static FfpImage read_as(const char *name, FfpColour colour) {
    FfpImage image;
    FfpError err = {0};
    if (!ffp_image_read(&image, in_scratch(name), colour, &err)) fail_msg("%s", err.text);
    int width, height;
    assert_true(ffp_image_read_size(&width, &height, in_scratch(name), NULL));
    assert_int_equal(width, image.width);
    assert_int_equal(height, image.height);
    return image;
}

static FfpImage read_raw(const char *name) {
    FfpImage image;
    FfpError err = {0};
    if (!ffp_image_read_raw16(&image, in_scratch(name), NULL, &err)) fail_msg("%s", err.text);
    assert_int_equal(image.channels, 1);
    return image;
}

static void expect_refusal(const char *name, const char *words) {
    FfpImage image;
    FfpError err = {0};
    assert_false(ffp_image_read(&image, in_scratch(name), FFP_COLOUR_LINEAR, &err));
    assert_null(image.data);
    if (!strstr(err.text, words)) fail_msg("'%s' does not say '%s'", err.text, words);
    if (strstr(err.text, in_scratch(name)) == NULL) fail_msg("'%s' does not name the file", err.text);
}

static void expect_near(double got, double want, double tolerance) {
    if (!(fabs(got - want) <= tolerance)) fail_msg("%g, not %g", got, want);
}

// --- PNG. ---

// Deflate makes a thousandth of them: what they hold is counted as stored, before it becomes RGB of 8 bits.
static void flat_png_is_not_truncated(void **state) {
    (void)state;
    write_flat_png(in_scratch("flat.png"), 1920, 1080, 1, PNG_COLOR_TYPE_GRAY, 255);
    FfpImage image = read_as("flat.png", FFP_COLOUR_ENCODED);
    assert_true(image.data[0] == 1 && image.data[4 * (1920 * 1080 - 1)] == 1);
    ffp_image_free(&image);
    write_flat_png(in_scratch("flat.png"), 1920, 1080, 1, PNG_COLOR_TYPE_PALETTE, 255);
    image = read_as("flat.png", FFP_COLOUR_ENCODED);
    assert_true(image.data[0] == 0 && image.data[2] == 1);
    ffp_image_free(&image);
    write_flat_png(in_scratch("flat.png"), 6000, 4000, 8, PNG_COLOR_TYPE_GRAY, 255);
    image = read_raw("flat.png");
    assert_true(image.data[0] == 255 && image.data[6000 * 4000 - 1] == 255);
    ffp_image_free(&image);
}

// --- JPEG. ---

static void cmyk_jpeg_is_read(void **state) {
    (void)state;
    static const J_COLOR_SPACE stored[2] = {JCS_CMYK, JCS_YCCK};
    for (int k = 0; k < 3; k++) {
        // inks of 0.2, 0.4, 0.6 and black 0.5; Adobe stores what they leave
        const bool adobe = k < 2;
        unsigned char pixels[16 * 16 * 4], inks[4] = {51, 102, 153, 128};
        for (int i = 0; i < 16 * 16 * 4; i++) pixels[i] = adobe ? 255 - inks[i % 4] : inks[i % 4];
        const JpegKind kind = {.given = JCS_CMYK, .stored = stored[k % 2], .no_adobe_marker = !adobe};
        write_jpeg_kind(in_scratch("cmyk.jpg"), pixels, 16, 16, &kind);
        FfpImage image = read_as("cmyk.jpg", FFP_COLOUR_ENCODED);
        for (int i = 0; i < 4 * 16 * 16; i++) {
            const double want = i % 4 == 3 ? 1 : (1 - 0.2 * (i % 4 + 1)) * 127 / 255;
            expect_near(image.data[i], want, 0.01);
        }
        ffp_image_free(&image);
    }
}

// EXIF with one entry, the orientation.
static size_t make_exif(unsigned char exif[64], int orientation, bool big_endian) {
    static const unsigned char little[] =
        "Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0?\0\0\0\0\0\0";
    static const unsigned char big[] = "Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0?\0\0\0\0\0\0";
    memcpy(exif, big_endian ? big : little, sizeof little);
    exif[big_endian ? 25 : 24] = (unsigned char)orientation;
    return sizeof little - 1;
}

// Where the stored first row's first and last pixel are to be seen, by the standard's words for each value:
// e.g. 6: "the 0th row is the visual right-hand side of the image, and the 0th column is the visual top".
static void expect_corners(const FfpImage *image, int orientation) {
    static const char *const first[9] = {"", "TL", "TR", "BR", "BL", "TL", "TR", "BR", "BL"};
    static const char *const last[9] = {"", "TR", "TL", "BL", "BR", "BL", "BR", "TR", "TL"};
    assert_int_equal(image->width, orientation < 5 ? 48 : 16);
    assert_int_equal(image->height, orientation < 5 ? 16 : 48);
    for (int k = 0; k < 4; k++) {
        static const char *const corners[4] = {"TL", "TR", "BL", "BR"};
        const int x = k % 2 ? image->width - 2 : 1, y = k / 2 ? image->height - 2 : 1;
        const real *pixel = image->data + 4 * (y * image->width + x);
        assert_int_equal(pixel[0] > 0.5F, strcmp(corners[k], first[orientation]) == 0);
        assert_int_equal(pixel[1] > 0.5F, strcmp(corners[k], last[orientation]) == 0);
    }
}

// The messages of reading a file.
typedef struct Said {
    const char *name;
    char words[512];
} Said;

static void hear(void *user, FfpLogLevel level, const char *text) {
    Said *said = user;
    assert_int_equal(level, FFP_LOG_NOTE);
    snprintf(said->words, sizeof said->words, "%s", text);
}

static bool read_aloud(void *argument, FfpError *err) {
    const Said *said = argument;
    FfpImage image;
    const bool ok = ffp_image_read(&image, in_scratch(said->name), FFP_COLOUR_ENCODED, err);
    if (ok) ffp_image_free(&image);
    return ok;
}

static void turning_is_said(void **state) {
    (void)state;
    for (int orientation = 1; orientation <= 6; orientation += 5) {
        TiffKind kind = {"w", 8, 1, PHOTOMETRIC_MINISBLACK, COMPRESSION_NONE, .extra = -1};
        kind.orientation = orientation;
        write_tiff_kind(in_scratch("said.tif"), 9, 5, &kind);
        Said said = {.name = "said.tif"};
        const FfpContextSettings settings = {.size = sizeof settings, .user = &said, .log = hear};
        FfpContext context = {.settings = settings};
        assert_true(ffp_call_run(&context, read_aloud, &said, NULL));
        assert_int_equal(strstr(said.words, "said.tif: turned clockwise by 90 degrees") != NULL,
                         orientation == 6);
        assert_int_equal(said.words[0] != 0, orientation == 6);
    }
}

static void jpeg_is_turned_as_the_camera_was(void **state) {
    (void)state;
    unsigned char pixels[48 * 16 * 3], exif[64];
    for (int i = 0; i < 48 * 16 * 3; i++) { // red in the first corner, green at the end of the first row
        const int x = i / 3 % 48, y = i / 3 / 48;
        pixels[i] = (unsigned char)(y < 8 && ((i % 3 == 0 && x < 8) || (i % 3 == 1 && x >= 40)) ? 255 : 0);
    }
    for (int orientation = 1; orientation <= 8; orientation++) {
        JpegKind kind = {.given = JCS_RGB, .stored = JCS_YCbCr, .exif = exif};
        kind.exif_size = make_exif(exif, orientation, orientation % 2);
        write_jpeg_kind(in_scratch("turned.jpg"), pixels, 48, 16, &kind);
        FfpImage image = read_as("turned.jpg", FFP_COLOUR_ENCODED);
        expect_corners(&image, orientation);
        assert_int_equal(ffp_image_orientation(in_scratch("turned.jpg")), orientation);
        ffp_image_free(&image);
    }
    static const int wrong[3] = {0, 9, 255};
    for (int k = 0; k < 3; k++) { // a tag out of range says nothing, wherever the data end
        JpegKind kind = {.given = JCS_RGB, .stored = JCS_YCbCr, .exif = exif};
        kind.exif_size = make_exif(exif, wrong[k], false);
        write_jpeg_kind(in_scratch("turned.jpg"), pixels, 48, 16, &kind);
        FfpImage image = read_as("turned.jpg", FFP_COLOUR_ENCODED);
        expect_corners(&image, 1);
        ffp_image_free(&image);
    }
    for (size_t cut = 0; cut < 32; cut++) {
        make_exif(exif, 6, false);
        const JpegKind kind = {.given = JCS_RGB, .stored = JCS_YCbCr, .exif = exif, .exif_size = cut};
        write_jpeg_kind(in_scratch("turned.jpg"), pixels, 48, 16, &kind);
        FfpImage image = read_as("turned.jpg", FFP_COLOUR_ENCODED);
        expect_corners(&image, cut < 26 ? 1 : 6);
        ffp_image_free(&image);
    }
}

// --- TIFF. ---

#define TIFF_WIDTH 37
#define TIFF_HEIGHT 43

static double tiff_value(const TiffKind *kind, int x, int y, int c) {
    const int sample = tiff_sample(x, y, c);
    if (kind->bits == 1) return sample & 1;
    return kind->floats ? sample / 128.0 : sample / 255.0;
}

static void expect_tiff(const TiffKind *kind) {
    write_tiff_kind(in_scratch("a.tif"), TIFF_WIDTH, TIFF_HEIGHT, kind);
    const bool colour = kind->photometric == PHOTOMETRIC_RGB, alpha = kind->channels == (colour ? 4 : 2);
    FfpImage image = read_as("a.tif", kind->floats ? FFP_COLOUR_LINEAR : FFP_COLOUR_ENCODED);
    for (int i = 0; i < TIFF_WIDTH * TIFF_HEIGHT; i++) {
        const int x = i % TIFF_WIDTH, y = i / TIFF_WIDTH;
        const double a = alpha ? tiff_value(kind, x, y, kind->channels - 1) : 1;
        for (int c = 0; c < 3; c++) {
            double want = tiff_value(kind, x, y, colour ? c : 0);
            if (kind->photometric == PHOTOMETRIC_MINISWHITE) want = 1 - want;
            if (alpha && kind->extra == EXTRASAMPLE_ASSOCALPHA && a > 0) want = want / a;
            if (alpha && kind->extra == EXTRASAMPLE_ASSOCALPHA && !kind->floats) want = fmin(want, 1);
            if (alpha && a == 0) continue;
            expect_near(image.data[4 * i + c], want, 1e-6 * (1 + want));
        }
        expect_near(image.data[4 * i + 3], a, 1e-6);
    }
    ffp_image_free(&image);
}

static void tiff_is_read(void **state) {
    (void)state;
    static const int compressions[4] = {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE,
                                        COMPRESSION_PACKBITS};
    static const char *const modes[3] = {"w", "wb", "w8"};
    static const int bits[3] = {8, 16, 32};
    int n = 0;
    for (int b = 0; b < 3; b++)
        for (int channels = 1; channels <= 4; channels++)
            for (int layout = 0; layout < 4; layout++, n++) {
                TiffKind kind = {.mode = modes[n % 3], .bits = bits[b], .channels = channels};
                kind.photometric = channels < 3 ? PHOTOMETRIC_MINISBLACK : PHOTOMETRIC_RGB;
                kind.compression = compressions[n / 3 % 4];
                kind.floats = bits[b] == 32;
                kind.tiled = layout % 2, kind.separate = layout / 2;
                kind.extra = channels % 2 ? -1 : n % 4 < 2 ? EXTRASAMPLE_UNASSALPHA : EXTRASAMPLE_ASSOCALPHA;
                expect_tiff(&kind);
            }
    const TiffKind mask = {"w", 1, 1, PHOTOMETRIC_MINISBLACK, COMPRESSION_NONE, .extra = -1};
    expect_tiff(&mask);
    const TiffKind negative = {"w", 8, 1, PHOTOMETRIC_MINISWHITE, COMPRESSION_LZW, .extra = -1};
    expect_tiff(&negative);
    const TiffKind unsaid = {"w", 8, 4, PHOTOMETRIC_RGB, COMPRESSION_LZW, .extra = -1};
    expect_tiff(&unsaid); // as OpenCV writes alpha
}

static void tiff_holds_raw_numbers_too(void **state) {
    (void)state;
    for (int k = 0; k < 3; k++) {
        TiffKind kind = {"w", 8 << k, 1, PHOTOMETRIC_MINISBLACK, COMPRESSION_LZW, .extra = -1};
        kind.floats = k == 2;
        write_tiff_kind(in_scratch("depth.tif"), 9, 7, &kind);
        FfpImage image = read_raw("depth.tif");
        const double scale = k == 0 ? 1 : k == 1 ? 257 : 1.0 / 128;
        for (int i = 0; i < 63; i++) expect_near(image.data[i], tiff_sample(i % 9, i / 9, 0) * scale, 1e-6);
        ffp_image_free(&image);
    }
}

static void tiff_is_turned(void **state) {
    (void)state;
    for (int orientation = 1; orientation <= 8; orientation++) {
        TiffKind kind = {"w", 8, 1, PHOTOMETRIC_MINISBLACK, COMPRESSION_NONE, .extra = -1};
        kind.orientation = orientation;
        write_tiff_kind(in_scratch("t.tif"), 9, 5, &kind);
        FfpImage image = read_as("t.tif", FFP_COLOUR_ENCODED);
        assert_int_equal(image.width, orientation < 5 ? 9 : 5);
        static const int right[9] = {0, 0, 1, 1, 0, 0, 1, 1, 0}, below[9] = {0, 0, 0, 1, 1, 0, 0, 1, 1};
        const int x = right[orientation] ? image.width - 1 : 0, y = below[orientation] ? image.height - 1 : 0;
        expect_near(image.data[4 * (y * image.width + x)], tiff_sample(0, 0, 0) / 255.0, 1e-6);
        ffp_image_free(&image);
    }
}

static void odd_tiff_is_refused(void **state) {
    (void)state;
    const struct {
        TiffKind kind;
        const char *words;
    } cases[] = {
        {{"w", 8, 4, PHOTOMETRIC_SEPARATED, COMPRESSION_NONE, .extra = -1}, "TIFF in CMYK"},
        {{"w", 8, 5, PHOTOMETRIC_RGB, COMPRESSION_NONE, .extra = -1}, "channels beyond colour and alpha"},
        {{"w", 32, 1, PHOTOMETRIC_MINISBLACK, COMPRESSION_NONE, .extra = -1}, "neither 8 nor 16 bits"},
        {{"w", 64, 1, PHOTOMETRIC_MINISBLACK, COMPRESSION_NONE, .floats = true, .extra = -1},
         "64-bit floats"},
        {{"w", 8, 3, PHOTOMETRIC_CIELAB, COMPRESSION_NONE, .extra = -1}, "colours other than grey and RGB"},
        {{"w", 1, 1, PHOTOMETRIC_MINISBLACK, COMPRESSION_CCITTFAX4, .extra = -1}, "compression 4"},
        {{"w", 16, 1, PHOTOMETRIC_CFA, COMPRESSION_NONE, .extra = -1}, "raw photograph"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_tiff_kind(in_scratch("odd.tif"), 8, 8, &cases[i].kind);
        expect_refusal("odd.tif", cases[i].words);
    }
    const TiffKind infinite = {"w",        32, 1, PHOTOMETRIC_MINISBLACK, COMPRESSION_NONE, .floats = true,
                               .extra = -1};
    write_tiff_kind(in_scratch("odd.tif"), 1, 1, &infinite);
    char *bytes;
    size_t size;
    assert_true(ffp_read_file(in_scratch("odd.tif"), 1000, &bytes, &size, NULL));
    memset(bytes + 8, 0xff, 4);
    assert_true(ffp_write_file(in_scratch("odd.tif"), bytes, size, NULL));
    ffp_free(bytes);
    expect_refusal("odd.tif", "not finite");
}

// DNG, and a NEF's or ARW's small preview in front.
static void raw_photographs_are_refused(void **state) {
    (void)state;
    const TiffKind kind = {"w", 8, 3, PHOTOMETRIC_RGB, COMPRESSION_NONE, .extra = -1};
    for (int k = 0; k < 2; k++) {
        TIFF *tiff = TIFFOpen(in_scratch("raw.tif"), "w");
        const unsigned char version[4] = {1, 4, 0, 0}, pixels[8 * 8 * 3] = {0};
        const uint64_t offsets[1] = {0};
        set_tiff_fields(tiff, 8, 5, &kind);
        if (k == 0)
            TIFFSetField(tiff, TIFFTAG_DNGVERSION, version);
        else
            TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, FILETYPE_REDUCEDIMAGE),
                TIFFSetField(tiff, TIFFTAG_SUBIFD, 1, offsets);
        TIFFSetField(tiff, TIFFTAG_MAKE, "NIKON CORPORATION");
        assert_true(TIFFWriteEncodedStrip(tiff, 0, (void *)pixels, 8 * 5 * 3) > 0);
        if (k == 1) { // the directory that the preview points to
            assert_true(TIFFWriteDirectory(tiff));
            set_tiff_fields(tiff, 8, 5, &kind);
            assert_true(TIFFWriteEncodedStrip(tiff, 0, (void *)pixels, 8 * 5 * 3) > 0);
        }
        TIFFClose(tiff);
        expect_refusal("raw.tif", "NIKON CORPORATION");
        expect_refusal("raw.tif", "develop it to a 16-bit TIFF or PNG");
    }
}

// --- EXR. ---

// The colours that are read are these channels of this part.
static void expect_exr(const char *name, const ExrPart *part, int p, const int channels[4]) {
    FfpImage rgb, alpha;
    FfpError err = {0};
    if (!ffp_image_read_over_black(&rgb, &alpha, in_scratch(name), &err)) fail_msg("%s", err.text);
    int width, height;
    assert_true(ffp_image_read_size(&width, &height, in_scratch(name), NULL));
    assert_true(width == part->width && height == part->height);
    assert_true(rgb.width == part->width && rgb.height == part->height);
    for (int i = 0; i < rgb.width * rgb.height; i++) {
        for (int c = 0; c < 3; c++)
            assert_true(rgb.data[3 * i + c] == exr_sample(p, channels[c], i % rgb.width, i / rgb.width));
        if (channels[3] >= 0)
            assert_true(alpha.data[i] == exr_sample(p, channels[3], i % rgb.width, i / rgb.width));
    }
    assert_int_equal(alpha.data != NULL, channels[3] >= 0);
    ffp_image_free(&rgb);
    ffp_image_free(&alpha);
}

static void expect_exr_depth(const char *name, int width, int height, int p, int channel) {
    FfpImage depth = read_raw(name);
    assert_true(depth.width == width && depth.height == height);
    for (int i = 0; i < width * height; i++)
        expect_near(depth.data[i], exr_sample(p, channel, i % width, i / width), 0);
    ffp_image_free(&depth);
}

static void tiled_exr_is_read(void **state) {
    (void)state;
    static const exr_compression_t compressions[4] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_ZIP,
                                                      EXR_COMPRESSION_PIZ, EXR_COMPRESSION_RLE};
    for (int k = 0; k < 12; k++) {
        const ExrPart part = {.channels = {"A", "B", "G", "R", "Z"},
                              .width = 37,
                              .height = 29,
                              .tile = k < 4   ? 16
                                      : k < 8 ? 64
                                              : 5,
                              .levels = k % 2,
                              .compression = compressions[k % 4]};
        write_exr_parts(in_scratch("tiled.exr"), &part, 1);
        expect_exr("tiled.exr", &part, 0, (int[4]){3, 2, 1, 0});
        expect_exr_depth("tiled.exr", 37, 29, 0, 4);
    }
}

static void layers_of_exr_are_found(void **state) {
    (void)state;
    const struct {
        ExrPart part;
        int colours[4], depth; // which channels; -1: not asked
    } cases[] = {
        // what is in no layer comes first
        {{.channels = {"B", "G", "R", "diffuse.B", "diffuse.G", "diffuse.R", "diffuse.Z"}}, {2, 1, 0, -1}, 6},
        {{.channels = {"diffuse.A", "diffuse.B", "diffuse.G", "diffuse.R"}}, {3, 2, 1, 0}, -1},
        {{.channels = {"a.b.B", "a.b.G", "a.b.R", "c.B", "c.G", "c.R"}}, {2, 1, 0, -1}, -1},
        // Blender's passes
        {{.channels = {"ViewLayer.AO.B", "ViewLayer.AO.G", "ViewLayer.AO.R", "ViewLayer.Combined.A",
                       "ViewLayer.Combined.B", "ViewLayer.Combined.G", "ViewLayer.Combined.R",
                       "ViewLayer.Depth.Z", "ViewLayer.Mist.Z", "ViewLayer.Normal.X", "ViewLayer.Normal.Y",
                       "ViewLayer.Normal.Z"}},
         {6, 5, 4, 3},
         7},
        {{.channels = {"L.Combined.B", "L.Combined.G", "L.Combined.R", "L.Depth.V", "L.Normal.X",
                       "L.Normal.Y", "L.Normal.Z"}},
         {2, 1, 0, -1},
         3},
        {{.channels = {"N.X", "N.Y", "N.Z", "distance.Z", "luminance.Y"}}, {4, 4, 4, -1}, 3},
        {{.channels = {"Y", "Z", "x.B", "x.G", "x.R"}}, {0, 0, 0, -1}, 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        ExrPart part = cases[i].part;
        part.width = 9, part.height = 21, part.compression = EXR_COMPRESSION_ZIP;
        write_exr_parts(in_scratch("layers.exr"), &part, 1);
        expect_exr("layers.exr", &part, 0, cases[i].colours);
        if (cases[i].depth >= 0) expect_exr_depth("layers.exr", 9, 21, 0, cases[i].depth);
    }
    const ExrPart none = {.channels = {"N.X", "N.Y", "N.Z"}, .width = 4, .height = 4};
    write_exr_parts(in_scratch("layers.exr"), &none, 1);
    expect_refusal("layers.exr", "neither the channels R, G and B nor");
}

static void parts_of_exr_are_found(void **state) {
    (void)state;
    const ExrPart parts[3] = {
        {.channels = {"depth.Z"}, .width = 17, .height = 11, .tile = 8, .compression = EXR_COMPRESSION_PIZ},
        {.channels = {"B", "G", "R"}, .width = 23, .height = 35, .compression = EXR_COMPRESSION_PIZ},
        {.channels = {"B", "G", "R"}, .width = 5, .height = 5, .compression = EXR_COMPRESSION_NONE}};
    write_exr_parts(in_scratch("parts.exr"), parts, 3);
    expect_exr("parts.exr", &parts[1], 1, (int[4]){2, 1, 0, -1});
    expect_exr_depth("parts.exr", 17, 11, 0, 0);
}

// Small pictures whose chunk takes as many bytes compressed as it had, among others.
static void small_exr_comes_back(void **state) {
    (void)state;
    static const int sides[5][2] = {{1, 8}, {1, 9}, {1, 10}, {2, 4}, {10, 1}};
    for (int k = 0; k < 5 * 8; k++) {
        FfpImage image = ffp_image_new(sides[k / 8][0], sides[k / 8][1], 1);
        for (int i = 0; i < image.width * image.height; i++)
            image.data[i] = exr_sample(0, 0, 16 * (k % 8) + i % image.width, i / image.width * (k % 8 + 1));
        assert_true(ffp_image_write_exr(&image, in_scratch("small.exr"), NULL));
        FfpImage back = read_raw("small.exr");
        assert_memory_equal(back.data, image.data, sizeof(real) * (size_t)(image.width * image.height));
        ffp_image_free(&back);
        ffp_image_free(&image);
    }
}

// --- What is not read. ---

static void other_files_are_named(void **state) {
    (void)state;
    static const struct {
        const char *bytes;
        size_t size;
        const char *name, *advice;
    } cases[] = {
        {"RIFF\x10\0\0\0WEBPVP8 ", 16, "a WebP picture", "save it as PNG"},
        {"RIFF\x10\0\0\0AVI LIST", 16, "an AVI video", "ffmpeg"},
        {"GIF89a\x10\0\x10\0", 10, "a GIF", "save it as PNG"},
        {"\0\0\0\x18"
         "ftypheic\0\0\0\0",
         16, "a HEIC picture", "save it as PNG"},
        {"\0\0\0\x18"
         "ftypmp42\0\0\0\0",
         16, "an MP4 video", "ffmpeg"},
        {"\0\0\0\x14"
         "ftypqt  \0\0\0\0",
         16, "a QuickTime video", "ffmpeg"},
        {"\0\0\0\x18"
         "ftypcrx \0\0\0\x01",
         16, "(CR3)", "develop it"},
        {"II*\0\x10\0\0\0CR\x02\0", 12, "(CR2)", "develop it"},
        {"BM\x36\0\0\0\0\0\0\0\x36\0\0\0", 14, "a BMP picture", "save it as PNG"},
        {"8BPS\0\x01", 6, "Photoshop", "save it as PNG"},
        {"\x1a\x45\xdf\xa3", 4, "WebM", "ffmpeg"},
        {"P5\n16 16\n255\n", 13, "PGM", "save it as PNG"},
        {"version https://git-lfs.github.com/spec/v1\n", 43, "Git LFS", "git lfs pull"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_true(ffp_write_file(in_scratch("other.png"), cases[i].bytes, cases[i].size, NULL));
        expect_refusal("other.png", cases[i].name);
        expect_refusal("other.png", cases[i].advice);
    }
}

// --- Damage. ---

static void try_bytes(const char *bytes, size_t size) {
    const char *path = in_scratch("hurt");
    FILE *stream = fopen(path, "wb");
    assert_non_null(stream);
    assert_int_equal(fwrite(bytes, 1, size, stream), size);
    fclose(stream);
    int width, height;
    FfpImage image;
    FfpError err = {0};
    if (ffp_image_read(&image, path, FFP_COLOUR_LINEAR, &err)) {
        assert_true(ffp_image_read_size(&width, &height, path, NULL));
        if (image.width != width || image.height != height)
            fail_msg("%d x %d, but told %d x %d", image.width, image.height, width, height);
        ffp_image_free(&image);
    } else {
        assert_non_null(strstr(err.text, path));
    }
    if (ffp_image_read_raw16(&image, path, NULL, NULL)) ffp_image_free(&image);
}

// Every truncation of a file, and its every byte turned over: an error or an image, no crash.
static void hurt(const char *name) {
    char *bytes;
    size_t size;
    assert_true(ffp_read_file(in_scratch(name), 1 << 20, &bytes, &size, NULL));
    const size_t step = size / 1500 + 1;
    for (size_t at = 0; at < size; at += step) {
        char *cut = malloc(at + 1); // of its own size, so that reading past the end is noticed
        memcpy(cut, bytes, at);
        try_bytes(cut, at);
        free(cut);
        const char old = bytes[at];
        bytes[at] = (char)~old;
        try_bytes(bytes, size);
        bytes[at] = (char)(old ^ 1 << at % 8);
        try_bytes(bytes, size);
        bytes[at] = old;
    }
    ffp_free(bytes);
}

static void damaged_files_do_no_harm(void **state) {
    (void)state;
    unsigned char pixels[16 * 16 * 4], exif[64];
    for (int i = 0; i < 16 * 16 * 4; i++) pixels[i] = (unsigned char)(i * 7);
    write_flat_png(in_scratch("a"), 24, 16, 8, PNG_COLOR_TYPE_RGB_ALPHA, 90);
    hurt("a");
    write_flat_png(in_scratch("a"), 24, 16, 1, PNG_COLOR_TYPE_PALETTE, 90);
    hurt("a");
    const JpegKind rgb = {
        .given = JCS_RGB, .stored = JCS_YCbCr, .exif = exif, .exif_size = make_exif(exif, 6, false)};
    write_jpeg_kind(in_scratch("a"), pixels, 16, 16, &rgb);
    hurt("a");
    const JpegKind cmyk = {.given = JCS_CMYK, .stored = JCS_YCCK};
    write_jpeg_kind(in_scratch("a"), pixels, 16, 16, &cmyk);
    hurt("a");
    for (int k = 0; k < 6; k++) {
        TiffKind kind = {k % 2 ? "wb" : "w", k < 4 ? 8 : 32,  3,
                         PHOTOMETRIC_RGB,    COMPRESSION_LZW, .extra = -1};
        kind.compression = k % 3 == 0   ? COMPRESSION_ADOBE_DEFLATE
                           : k % 3 == 1 ? COMPRESSION_LZW
                                        : COMPRESSION_NONE;
        kind.floats = k >= 4, kind.tiled = k % 2, kind.separate = k == 3, kind.orientation = 6;
        write_tiff_kind(in_scratch("a"), 9, 7, &kind);
        hurt("a");
    }
    for (int k = 0; k < 4; k++) {
        const ExrPart parts[2] = {{.channels = {"B", "G", "R", "Z"},
                                   .width = 9,
                                   .height = 7,
                                   .tile = k % 2 ? 4 : 0,
                                   .compression = k < 2 ? EXR_COMPRESSION_ZIP : EXR_COMPRESSION_PIZ},
                                  {.channels = {"x.Z"}, .width = 3, .height = 3}};
        write_exr_parts(in_scratch("a"), parts, k < 2 ? 1 : 2);
        hurt("a");
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flat_png_is_not_truncated),
        cmocka_unit_test(cmyk_jpeg_is_read),
        cmocka_unit_test(turning_is_said),
        cmocka_unit_test(jpeg_is_turned_as_the_camera_was),
        cmocka_unit_test(tiff_is_read),
        cmocka_unit_test(tiff_holds_raw_numbers_too),
        cmocka_unit_test(tiff_is_turned),
        cmocka_unit_test(odd_tiff_is_refused),
        cmocka_unit_test(raw_photographs_are_refused),
        cmocka_unit_test(tiled_exr_is_read),
        cmocka_unit_test(layers_of_exr_are_found),
        cmocka_unit_test(parts_of_exr_are_found),
        cmocka_unit_test(small_exr_comes_back),
        cmocka_unit_test(other_files_are_named),
        cmocka_unit_test(damaged_files_do_no_harm),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
