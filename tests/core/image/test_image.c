// Image files: what is written comes back, what is broken is refused with words.
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <unistd.h>
#include <jpeglib.h>
#include "core/base/alloc.h"
#include "core/base/rng.h"
#include "core/image/image.h"
#include "scratch.h"

// Values on the grid of `steps` (255 or 65535), so that they survive a file of that depth; or any values when
// steps is 0.
static FfpImage random_image(int width, int height, int channels, int steps, uint64_t seed) {
    FfpRng rng = ffp_rng(seed, 1);
    FfpImage image = ffp_image_new(width, height, channels);
    for (int i = 0; i < width * height * channels; i++) {
        image.data[i] =
            steps > 0 ? (real)ffp_rng_below(&rng, (uint32_t)steps + 1) / (real)steps : ffp_rng_normal(&rng);
    }
    return image;
}

// Largest difference between `got` (RGBA) and the values `want` of 1, 3 or 4 channels as RGBA.
static double rgba_difference(const FfpImage *got, const FfpImage *want) {
    assert_int_equal(got->width, want->width);
    assert_int_equal(got->height, want->height);
    assert_int_equal(got->channels, 4);
    double worst = 0;
    for (int i = 0; i < want->width * want->height; i++) {
        for (int c = 0; c < 4; c++) {
            const int n = want->channels;
            const double value = c == 3 && n != 4 ? 1 : want->data[i * n + (n == 1 ? 0 : c)];
            worst = worse(worst, fabs(value - got->data[4 * i + c]));
        }
    }
    return worst;
}

static void png_comes_back(void **state) {
    (void)state;
    static const int channels[3] = {1, 3, 4};
    for (int k = 0; k < 6; k++) {
        const int depth = k < 3 ? 255 : 65535;
        FfpImage image = random_image(37, 5 + k, channels[k % 3], depth, (uint64_t)k), back;
        FfpError err = {0};
        const char *path = in_scratch("a.png");
        assert_true(depth == 255 ? ffp_image_write_png(&image, path, &err)
                                 : ffp_image_write_png16(&image, path, &err));
        int width, height;
        assert_true(ffp_image_read_size(&width, &height, path, &err));
        assert_int_equal(width, 37);
        assert_int_equal(height, 5 + k);
        assert_true(ffp_image_read(&back, path, FFP_COLOUR_ENCODED, &err));
        assert_true(rgba_difference(&back, &image) < 1e-6);
        ffp_image_free(&back);
        ffp_image_free(&image);
    }
}

// A smooth picture with values beyond both ends of the range.
static FfpImage smooth_image(int width, int height) {
    FfpImage image = ffp_image_new(width, height, 3);
    for (int i = 0; i < width * height * 3; i++)
        image.data[i] =
            (real)(0.5 + 0.55 * sin(0.07 * (i / 3 % width) + (i % 3)) * cos(0.05 * (double)(i / 3 / width)));
    return image;
}

static double jpeg_error(const FfpImage *image, int quality, size_t *size) {
    FfpError err = {0};
    FfpImage back;
    char *bytes;
    const char *path = in_scratch("a.JPG");
    if (!ffp_image_write_jpeg(image, quality, path, &err)) fail_msg("%s", err.text);
    if (!ffp_image_read(&back, path, FFP_COLOUR_ENCODED, &err)) fail_msg("%s", err.text);
    assert_true(ffp_read_file(path, 1 << 24, &bytes, size, &err));
    assert_true(back.width == image->width && back.height == image->height);
    double square = 0;
    for (int i = 0; i < back.width * back.height * 3; i++) {
        const double want = fmin(1, fmax(0, (double)image->data[i]));
        const double error = (double)back.data[i / 3 * 4 + i % 3] - want;
        square += error * error;
    }
    const double error = sqrt(square / (back.width * back.height * 3));
    ffp_free(bytes);
    ffp_image_free(&back);
    return error;
}

static void jpeg_is_as_good_as_its_quality(void **state) {
    (void)state;
    FfpImage image = smooth_image(75, 61), grey = ffp_image_new(8, 8, 1);
    FfpError err = {0};
    size_t fine, coarse;
    const double low = jpeg_error(&image, 97, &fine), high = jpeg_error(&image, 15, &coarse);
    print_message("JPEG: error %.4f in %zu bytes, %.4f in %zu\n", low, fine, high, coarse);
    assert_true(low < 0.01 && high > 1.5 * low && fine > coarse);
    assert_false(ffp_image_write_jpeg(&grey, 90, in_scratch("b.JPG"), &err));
    assert_non_null(strstr(err.text, "1 channels"));
    assert_false(ffp_image_write_jpeg(&image, 101, in_scratch("b.JPG"), &err));
    assert_false(ffp_image_write_jpeg(&image, 90, in_scratch("nowhere/b.JPG"), &err));
    assert_int_equal(err.code, FFP_ERROR_IO);
    ffp_image_free(&image);
    ffp_image_free(&grey);
}

static void png_clamps_and_rounds(void **state) {
    (void)state;
    FfpImage image = ffp_image_new(5, 1, 1), back;
    const real values[5] = {-3, 1.5F, (real)NAN, 100.4F / 255, 100.6F / 255};
    memcpy(image.data, values, sizeof values);
    assert_true(ffp_image_write_png(&image, in_scratch("clamp.png"), NULL));
    assert_true(ffp_image_read_raw16(&back, in_scratch("clamp.png"), NULL, NULL));
    const int want[5] = {0, 255, 0, 100, 101};
    for (int i = 0; i < 5; i++) assert_int_equal((int)back.data[i], want[i]);
    ffp_image_free(&back);
    ffp_image_free(&image);
}

// Stripes of eight pixels, row by row in other colours: what a projector's pattern looks like to deflate.
static FfpImage striped_image(int side) {
    FfpImage image = ffp_image_new(side, side, 3);
    for (int i = 0; i < side * side * 3; i++) {
        const int x = i / 3 % side / 8, y = i / 3 / side / 8;
        image.data[i] = (real)((37 * x + 101 * y + 53 * (i % 3)) % 256) / 255;
    }
    return image;
}

static void png_is_compact(void **state) {
    (void)state;
    FfpImage even = striped_image(256), ramp = ffp_image_new(256, 256, 3), back;
    for (int i = 0; i < 256 * 256 * 3; i++) ramp.data[i] = (real)(i / 3 % 256) / 255;
    const struct {
        const FfpImage *image;
        size_t most;
    } cases[2] = {{&even, 8000}, {&ramp, 2000}}; // of 196608
    for (int k = 0; k < 2; k++) {
        unsigned char *bytes;
        size_t size;
        assert_true(ffp_image_encode_png(cases[k].image, &bytes, &size, NULL));
        assert_true(size < cases[k].most);
        assert_true(ffp_write_file(in_scratch("compact.png"), bytes, size, NULL));
        assert_true(ffp_image_read(&back, in_scratch("compact.png"), FFP_COLOUR_ENCODED, NULL));
        assert_true(rgba_difference(&back, cases[k].image) < 1e-6);
        ffp_image_free(&back);
        ffp_free(bytes);
    }
    ffp_image_free(&ramp);
    ffp_image_free(&even);
}

static void raw_depth_comes_back(void **state) {
    (void)state;
    FfpImage image = random_image(13, 9, 1, 65535, 3), back;
    assert_true(ffp_image_write_png16(&image, in_scratch("d.png"), NULL));
    assert_true(ffp_image_read_raw16(&back, in_scratch("d.png"), NULL, NULL));
    for (int i = 0; i < 13 * 9; i++)
        assert_int_equal((int)back.data[i], (int)lround((double)image.data[i] * 65535));
    ffp_image_free(&back);
    FfpImage colour = random_image(4, 4, 3, 255, 4);
    FfpError err = {0};
    assert_true(ffp_image_write_png(&colour, in_scratch("rgb.png"), NULL));
    assert_false(ffp_image_read_raw16(&back, in_scratch("rgb.png"), NULL, &err));
    assert_non_null(strstr(err.text, "is not a grey image"));
    ffp_image_free(&colour);
    ffp_image_free(&image);
}

static void exr_comes_back(void **state) {
    (void)state;
    static const int channels[3] = {1, 3, 4};
    for (int k = 0; k < 3; k++) {
        FfpImage image = random_image(35, 41, channels[k], 0, 7), back;
        for (int i = 0; channels[k] == 4 && i < 35 * 41; i++)
            image.data[4 * i + 3] = 1; // premultiplied equals straight
        FfpError err = {0};
        assert_true(ffp_image_write_exr(&image, in_scratch("a.exr"), &err));
        if (channels[k] == 1) {
            assert_true(ffp_image_read_raw16(&back, in_scratch("a.exr"), NULL, &err));
            assert_memory_equal(back.data, image.data, sizeof(real) * 35 * 41);
        } else {
            assert_true(ffp_image_read(&back, in_scratch("a.exr"), FFP_COLOUR_LINEAR, &err));
            assert_true(rgba_difference(&back, &image) == 0);
        }
        ffp_image_free(&back);
        ffp_image_free(&image);
    }
}

static void write_jpeg(const char *path, int width, int height, unsigned char grey) {
    struct jpeg_compress_struct jpeg = {0};
    struct jpeg_error_mgr errors;
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    FILE *stream = fopen(path, "wb");
    assert_non_null(stream);
    jpeg_stdio_dest(&jpeg, stream);
    jpeg.image_width = (JDIMENSION)width;
    jpeg.image_height = (JDIMENSION)height;
    jpeg.input_components = 3;
    jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&jpeg);
    jpeg_start_compress(&jpeg, TRUE);
    unsigned char *row = ffp_alloc((size_t)width * 3, 1);
    for (int y = 0; y < height; y++) {
        memset(row, grey, (size_t)width * 3);
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    ffp_free(row);
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    fclose(stream);
}

static void jpeg_is_read(void **state) {
    (void)state;
    write_jpeg(in_scratch("a.dat"), 33, 17, 128); // the name says nothing: content decides
    FfpImage image;
    FfpError err = {0};
    assert_true(ffp_image_read(&image, in_scratch("a.dat"), FFP_COLOUR_LINEAR, &err));
    assert_int_equal(image.width, 33);
    assert_int_equal(image.height, 17);
    for (int i = 0; i < 33 * 17; i++) assert_true(fabs((double)image.data[4 * i] - 0.2158605) < 0.004);
    ffp_image_free(&image);
}

// Reduced while they are read, pictures are the means of their light.
static void reduced_pictures_are_means(void **state) {
    (void)state;
    enum { SIDE = 48, SHRINK = 4 };
    FfpRng rng = ffp_rng(3, 1);
    FfpImage shown = ffp_image_new(SIDE, SIDE, 3), whole, small;
    for (int i = 0; i < SIDE * SIDE; i++)
        for (int c = 0; c < 3; c++)
            shown.data[3 * i + c] =
                (real)((i / SIDE / 12 + i % SIDE / 10) % 3) / 3 + 0.2F * ffp_rng_uniform(&rng);
    char names[2][300];
    snprintf(names[0], sizeof names[0], "%s", in_scratch("means.png"));
    assert_true(ffp_image_write_png(&shown, names[0], NULL));
    snprintf(names[1], sizeof names[1], "%s", in_scratch("means.jpg"));
    assert_true(ffp_image_write_jpeg(&shown, 95, names[1], NULL));
    for (int k = 0; k < 3; k++) { // the last roughly
        int size[2];
        const bool rough = k == 2;
        assert_true(ffp_image_read_over_black(&whole, NULL, names[k > 0], NULL));
        assert_true(ffp_image_read_reduced(&small, NULL, size, names[k > 0], false, SHRINK, rough, NULL));
        assert_true(size[0] == SIDE && size[1] == SIDE && small.width == SIDE / SHRINK &&
                    small.height == SIDE / SHRINK);
        ffp_image_free(&small);
        // Not reduced, it is the same to the bit.
        assert_true(ffp_image_read_reduced(&small, NULL, size, names[k > 0], false, 1, rough, NULL));
        assert_memory_equal(small.data, whole.data, 3 * SIDE * SIDE * sizeof *whole.data);
        ffp_image_free(&small);
        ffp_image_reduce(&whole, SHRINK);
        double most = 0, sum = 0;
        for (int i = 0; i < 3 * small.width * small.height; i++) {
            const double off = fabs((double)(small.data[i] - whole.data[i]));
            most = fmax(most, off), sum += off / (3.0 * small.width * small.height);
        }
        assert_true(rough ? sum < 0.03 : most < 1e-5);
        ffp_image_free(&whole), ffp_image_free(&small);
        // A number that does not divide its sides leaves a picture as it is.
        assert_true(ffp_image_read_reduced(&small, NULL, size, names[k > 0], false, 5, rough, NULL));
        assert_true(size[0] == SIDE && small.width == SIDE && small.height == SIDE);
        ffp_image_free(&small);
    }
    ffp_image_free(&shown);
}

// Composition happens in encoded values: 0.8 at alpha 0.5 is linear(0.4), not linear(0.8) / 2.
static void alpha_goes_over_black_encoded(void **state) {
    (void)state;
    FfpImage image = ffp_image_new(1, 1, 4), rgb, alpha;
    const real pixel[4] = {204.F / 255, 102.F / 255, 0, 51.F / 255};
    memcpy(image.data, pixel, sizeof pixel);
    assert_true(ffp_image_write_png(&image, in_scratch("alpha.png"), NULL));
    assert_true(ffp_image_read_over_black(&rgb, &alpha, in_scratch("alpha.png"), NULL));
    assert_true(fabs((double)alpha.data[0] - 0.2) < 1e-6);
    assert_true(fabs((double)rgb.data[0] - (double)ffp_srgb_decode(0.16F)) < 1e-6);
    ffp_image_free(&rgb);
    ffp_image_free(&alpha);
    assert_true(ffp_image_write_exr(&image, in_scratch("alpha.exr"), NULL)); // premultiplied by convention
    assert_true(ffp_image_read_over_black(&rgb, &alpha, in_scratch("alpha.exr"), NULL));
    assert_true(fabs((double)rgb.data[0] - 0.8) < 1e-6);
    ffp_image_free(&rgb);
    ffp_image_free(&alpha);
    ffp_image_free(&image);
}

// Every cut and every kind of damage is refused; nothing is returned half-read, no crash.
static void damage_is_refused(void **state) {
    (void)state;
    FfpImage image = random_image(40, 30, 3, 255, 11), back;
    assert_true(ffp_image_write_png(&image, in_scratch("whole.png"), NULL));
    assert_true(ffp_image_write_exr(&image, in_scratch("whole.exr"), NULL));
    write_jpeg(in_scratch("whole.jpg"), 40, 30, 90);
    ffp_image_free(&image);
    static const char *const names[3] = {"whole.png", "whole.exr", "whole.jpg"};
    for (int k = 0; k < 3; k++) {
        char *bytes;
        size_t size;
        assert_true(ffp_read_file(in_scratch(names[k]), 1 << 20, &bytes, &size, NULL));
        for (int cut = 0; cut < 40; cut++) {
            FfpError err = {0};
            assert_true(ffp_write_file(in_scratch("cut"), bytes, size * (size_t)cut / 40, NULL));
            assert_false(ffp_image_read(&back, in_scratch("cut"), FFP_COLOUR_LINEAR, &err));
            assert_null(back.data);
            assert_non_null(strstr(err.text, in_scratch("cut")));
        }
        FfpRng rng = ffp_rng(5, (uint64_t)k);
        for (int hit = 0; hit < 100; hit++) { // may be readable or not, but must not crash
            const size_t where = ffp_rng_below(&rng, (uint32_t)size);
            const char old = bytes[where];
            bytes[where] = (char)ffp_rng_u32(&rng);
            assert_true(ffp_write_file(in_scratch("hit"), bytes, size, NULL));
            if (ffp_image_read(&back, in_scratch("hit"), FFP_COLOUR_LINEAR, NULL)) ffp_image_free(&back);
            bytes[where] = old;
        }
        ffp_free(bytes);
    }
}

static void expect_refusal(const char *path, const char *words) {
    FfpImage image;
    FfpError err = {0};
    assert_false(ffp_image_read(&image, path, FFP_COLOUR_LINEAR, &err));
    assert_null(image.data);
    if (!strstr(err.text, words)) fail_msg("'%s' does not say '%s'", err.text, words);
    int width, height;
    if (strstr(words, "size")) assert_false(ffp_image_read_size(&width, &height, path, NULL));
}

// A PNG header with the given size and a right checksum, and no pixels behind it.
static void write_png_header(const char *path, uint32_t width, uint32_t height) {
    unsigned char bytes[33] = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR";
    for (int i = 0; i < 4; i++) bytes[16 + i] = (unsigned char)(width >> (24 - 8 * i));
    for (int i = 0; i < 4; i++) bytes[20 + i] = (unsigned char)(height >> (24 - 8 * i));
    bytes[24] = 8, bytes[25] = 2;
    uint32_t crc = 0xffffffffU; // CRC-32 of ISO 3309, bit by bit
    for (int i = 12; i < 29; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) crc = crc & 1 ? (crc >> 1) ^ 0xedb88320U : crc >> 1;
    }
    crc = ~crc;
    for (int i = 0; i < 4; i++) bytes[29 + i] = (unsigned char)(crc >> (24 - 8 * i));
    assert_true(ffp_write_file(path, bytes, sizeof bytes, NULL));
}

static void bad_files_are_refused(void **state) {
    (void)state;
    expect_refusal(in_scratch("absent.png"), "cannot open");
    expect_refusal(scratch, "is a folder");
    assert_true(ffp_write_file(in_scratch("empty.png"), "", 0, NULL));
    expect_refusal(in_scratch("empty.png"), "file is empty");
    assert_true(ffp_write_file(in_scratch("text.png"), "hello, world", 12, NULL));
    expect_refusal(in_scratch("text.png"), "is not a PNG, JPEG, TIFF or EXR image");
    static const struct {
        const char *name, *bytes, *words;
    } drawn[] = {{"a.kra", "PK\3\4", "is a Krita document, which is not supported: export it as PNG"},
                 {"a.Procreate", "PK\3\4", "is a Procreate document"},
                 {"a.tga", "\2\2\2", "is a TGA picture"},
                 {"a.cube", "TITLE \"x\"", "is a table of colours (LUT), which is not supported: a picture"},
                 {"b.png", "gimp xcf v011", "is a GIMP document (XCF)"},
                 {"b.png", "%!PS-Adobe-3.0", "is a PostScript drawing"},
                 {"b.png",
                  "PK\3\4"
                  "..........................mimetypeimage/openraster",
                  "is an OpenRaster document"},
                 {"b.png", "<?xml version=\"1.0\"?>\n<!-- drawn --><svg width=\"3\">", "is an SVG drawing"},
                 {"b.png", "\xef\xbb\xbf <svg>", "is an SVG drawing"},
                 {"b.png", "<html><svg>", "is not a PNG, JPEG"}};
    for (size_t i = 0; i < sizeof drawn / sizeof *drawn; i++) {
        assert_true(ffp_write_file(in_scratch(drawn[i].name), drawn[i].bytes, strlen(drawn[i].bytes), NULL));
        expect_refusal(in_scratch(drawn[i].name), drawn[i].words);
    }
    write_png_header(in_scratch("large.png"), 20000, 20000);
    expect_refusal(in_scratch("large.png"), "image size 20000 x 20000");
    write_png_header(in_scratch("zero.png"), 0, 5);
    expect_refusal(in_scratch("zero.png"), "image size 0 x 5");
    write_png_header(in_scratch("hollow.png"), 16000, 16000); // allowed size, but 33 bytes cannot hold it
    expect_refusal(in_scratch("hollow.png"), "truncated PNG");
    FfpImage image = ffp_image_new(9, 9, 3);
    image.data[5] = (real)INFINITY;
    assert_true(ffp_image_write_exr(&image, in_scratch("infinite.exr"), NULL));
    expect_refusal(in_scratch("infinite.exr"), "not finite");
    ffp_image_free(&image);
}

static void nothing_is_left_half_written(void **state) {
    (void)state;
    FfpImage image = ffp_image_new(3, 3, 2);
    FfpError err = {0};
    assert_false(ffp_image_write_exr(&image, in_scratch("two.exr"), &err));
    assert_false(ffp_image_write_exr(&image, in_scratch("no/such/folder.exr"), &err));
    assert_false(ffp_is_file(in_scratch("two.exr")));
    image.channels = 1;
    assert_false(ffp_image_write_png(&image, in_scratch("no/such/folder.png"), &err));
    ffp_image_free(&image);
}

static void srgb_curves_agree(void **state) {
    (void)state;
    for (int i = 0; i <= 1000; i++) {
        const double x = i / 1000.0;
        assert_true(fabs((double)ffp_srgb_encode(ffp_srgb_decode((real)x)) - x) < 2e-6);
    }
    assert_true(fabs((double)ffp_srgb_decode(0.5F) - 0.21404114048223255) < 1e-6); // (0.555 / 1.055)^2.4
    for (double x = -0.2; x <= 1.2; x += 1.0 / 4096) {
        real slope;
        const real encoded = ffp_srgb_encode_with_slope((real)x, &slope);
        assert_true(fabs((double)(encoded - ffp_srgb_encode((real)x))) < 3e-7);
        const double want = (double)ffp_srgb_encode_slope((real)x);
        assert_true(fabs((double)slope - want) <= 1e-6 * want);
    }
    assert_true(ffp_srgb_encode(-1) == 0 && ffp_srgb_encode(2) == 1);
    assert_true(ffp_srgb_encode_slope(-0.1F) == 0 && ffp_srgb_encode_slope(1.1F) == 0);
}

// Rows in which values repeat, return or are NaN go through the curve value by value.
static void images_go_through_the_curve(void **state) {
    (void)state;
    const real values[8] = {0.5F, 0.5F, 0, -1, (real)NAN, 0.25F, 2, 2};
    for (int channels = 1; channels <= 4; channels++) {
        FfpImage image = ffp_image_new(8, 3, channels), before;
        for (int i = 0; i < 24 * channels; i++) image.data[i] = values[(i / channels + i % channels) % 8];
        before = ffp_image_copy(&image);
        ffp_image_to_srgb(&image);
        for (int i = 0; i < 24 * channels; i++) {
            const bool alpha = channels == 4 && i % 4 == 3;
            const real want = alpha ? before.data[i] : ffp_srgb_encode(before.data[i]);
            assert_memory_equal(&image.data[i], &want, sizeof want);
        }
        ffp_image_free(&before);
        ffp_image_free(&image);
    }
}

static void resizing_keeps_means_and_ramps(void **state) {
    (void)state;
    FfpImage image = random_image(20, 12, 3, 255, 9);
    FfpImage small = ffp_image_resize(&image, 5, 7);
    double mean[3] = {0}, small_mean[3] = {0};
    for (int i = 0; i < 3 * 20 * 12; i++) mean[i % 3] += (double)image.data[i] / (20 * 12);
    for (int i = 0; i < 3 * 5 * 7; i++) small_mean[i % 3] += (double)small.data[i] / (5 * 7);
    for (int c = 0; c < 3; c++) assert_true(fabs(mean[c] - small_mean[c]) < 1e-6);
    ffp_image_free(&small);
    ffp_image_free(&image);
    FfpImage ramp = ffp_image_new(8, 1, 1);
    for (int i = 0; i < 8; i++) ramp.data[i] = (real)i;
    FfpImage large = ffp_image_resize(&ramp, 24, 3);
    for (int i = 3; i < 21; i++) assert_true(fabs((double)large.data[24 + i] - ((i + 0.5) / 3 - 0.5)) < 1e-5);
    ffp_image_free(&large);
    ffp_image_free(&ramp);
}

static void sampling_is_bilinear_and_clamped(void **state) {
    (void)state;
    FfpImage image = ffp_image_new(3, 2, 1);
    for (int i = 0; i < 6; i++) image.data[i] = (real)(i * i);
    real out;
    ffp_image_sample(&image, 1.5F, 0.5F, &out);
    assert_true(out == 1);
    ffp_image_sample(&image, 1, 1, &out);
    assert_true(fabs((double)out - (0 + 1 + 9 + 16) / 4.0) < 1e-6);
    ffp_image_sample(&image, 100, 100, &out);
    assert_true(out == 25);
    ffp_image_sample(&image, (real)NAN, -100, &out);
    assert_true(out == 0);
    ffp_image_free(&image);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(png_comes_back),
        cmocka_unit_test(jpeg_is_as_good_as_its_quality),
        cmocka_unit_test(png_clamps_and_rounds),
        cmocka_unit_test(png_is_compact),
        cmocka_unit_test(raw_depth_comes_back),
        cmocka_unit_test(exr_comes_back),
        cmocka_unit_test(jpeg_is_read),
        cmocka_unit_test(reduced_pictures_are_means),
        cmocka_unit_test(alpha_goes_over_black_encoded),
        cmocka_unit_test(damage_is_refused),
        cmocka_unit_test(bad_files_are_refused),
        cmocka_unit_test(nothing_is_left_half_written),
        cmocka_unit_test(srgb_curves_agree),
        cmocka_unit_test(images_go_through_the_curve),
        cmocka_unit_test(resizing_keeps_means_and_ramps),
        cmocka_unit_test(sampling_is_bilinear_and_clamped),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
