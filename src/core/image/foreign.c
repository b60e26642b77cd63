// Files that people take for pictures this program reads: known by their first bytes, to say what helps.
#include <string.h>
#include <strings.h>
#include "core/image/codec.h"

#define SAVE "save it as PNG or TIFF", FFP_FOREIGN_OTHER
#define SAVE_FILM "save it as PNG or TIFF", FFP_FOREIGN_FILM
#define EXPORT "export it as PNG"
#define DRAWN EXPORT, FFP_FOREIGN_OTHER
#define ANY_26 "??????????????????????????" // of a ZIP's first entry, before its name
#define DEVELOP "develop it to a 16-bit TIFF or PNG", FFP_FOREIGN_RAW
#define EXTRACT "extract its frames, for example by ffmpeg -i FILE frame_%04d.png", FFP_FOREIGN_FILM

typedef struct Foreign {
    size_t length;
    const char *bytes; // '?' stands for any
    const char *name, *advice;
    FfpForeign kind;
} Foreign;

static const Foreign table[] = {
    {12, "RIFF????WEBP", "a WebP picture", SAVE_FILM},
    {12, "RIFF????AVI ", "an AVI video", EXTRACT},
    {4, "GIF8", "a GIF", SAVE_FILM},
    {10, "BM????\0\0\0\0", "a BMP picture", SAVE},
    {12, "????ftypheic", "a HEIC picture", SAVE},
    {12, "????ftypheix", "a HEIC picture", SAVE},
    {12, "????ftyphevc", "a HEIC sequence", SAVE},
    {12, "????ftypmif1", "a HEIF picture", SAVE},
    {12, "????ftypmsf1", "a HEIF sequence", SAVE},
    {12, "????ftypavif", "an AVIF picture", SAVE},
    {12, "????ftypavis", "an AVIF sequence", SAVE},
    {12, "????ftypcrx ", "a Canon raw photograph (CR3)", DEVELOP},
    {12, "????ftypqt  ", "a QuickTime video (MOV)", EXTRACT},
    {8, "????ftyp", "an MP4 video", EXTRACT},
    {8, "????moov", "a QuickTime video (MOV)", EXTRACT},
    {8, "????mdat", "a QuickTime video (MOV)", EXTRACT},
    {8, "????wide", "a QuickTime video (MOV)", EXTRACT},
    {4, "\x1a\x45\xdf\xa3", "a Matroska or WebM video", EXTRACT},
    {4, "\0\0\x01\xba", "an MPEG video", EXTRACT},
    {4, "\0\0\x01\xb3", "an MPEG video", EXTRACT},
    {4, "FLV\x01", "a Flash video", EXTRACT},
    {4, "\x06\x0e+4", "an MXF video", EXTRACT},
    {4, "0&\xb2u", "a Windows Media video (WMV)", EXTRACT},
    {4, "OggS", "an Ogg video", EXTRACT},
    {4, "\x1f\x07\0?", "a DV video", EXTRACT},
    {10, "II*\0????CR", "a Canon raw photograph (CR2)", DEVELOP},
    {14, "II????HEAPCCDR", "a Canon raw photograph (CRW)", DEVELOP},
    {15, "FUJIFILMCCD-RAW", "a Fujifilm raw photograph (RAF)", DEVELOP},
    {4, "IIU\0", "a Panasonic raw photograph (RW2)", DEVELOP},
    {4, "IIRO", "an Olympus raw photograph (ORF)", DEVELOP},
    {4, "IIRS", "an Olympus raw photograph (ORF)", DEVELOP},
    {4, "MMOR", "an Olympus raw photograph (ORF)", DEVELOP},
    {4, "FOVb", "a Sigma raw photograph (X3F)", DEVELOP},
    {4, "\0MRM", "a Minolta raw photograph (MRW)", DEVELOP},
    {4, "8BPS", "a Photoshop document (PSD)", SAVE},
    {12, "\0\0\0\x0cjP  \r\n\x87\n", "a JPEG 2000 picture", SAVE},
    {4, "\xff\x4f\xff\x51", "a JPEG 2000 picture", SAVE},
    {8, "\0\0\0\x0cJXL ", "a JPEG XL picture", SAVE},
    {2, "\xff\x0a", "a JPEG XL picture", SAVE},
    {4, "DDS ", "a DDS texture", SAVE},
    {10, "#?RADIANCE", "a Radiance HDR picture", "save it as EXR", FFP_FOREIGN_OTHER},
    {6, "#?RGBE", "a Radiance HDR picture", "save it as EXR", FFP_FOREIGN_OTHER},
    {3, "PF\n", "a PFM picture", "save it as EXR", FFP_FOREIGN_OTHER},
    {3, "Pf\n", "a PFM picture", "save it as EXR", FFP_FOREIGN_OTHER},
    {3, "P?\n", "a PBM, PGM or PPM picture", SAVE},
    {6, "\x93NUMPY", "a NumPy array", "save it as EXR, TIFF or PNG", FFP_FOREIGN_OTHER},
    {5, "%PDF-", "a PDF document", SAVE},
    {4, "ply\n", "a PLY file", "a picture is needed here", FFP_FOREIGN_OTHER},
    {57, "PK\x03\x04" ANY_26 "mimetypeapplication/x-krita", "a Krita document", DRAWN},
    {54, "PK\x03\x04" ANY_26 "mimetypeimage/openraster", "an OpenRaster document", DRAWN},
    {8, "gimp xcf", "a GIMP document (XCF)", DRAWN},
    {8, "CSFCHUNK", "a Clip Studio document", DRAWN},
    {4, "\0\xffKA", "an Affinity document", DRAWN},
    {4, "%!PS", "a PostScript drawing", DRAWN},
    {4, "\xc5\xd0\xd3\xc6", "a PostScript drawing (EPS)", DRAWN},
    {7, "BLENDER", "a Blender scene", DRAWN},
    {4, "PK\x03\x04", "a ZIP archive", "unpack it", FFP_FOREIGN_OTHER},
    {2, "\x1f\x8b", "a gzip archive", "unpack it", FFP_FOREIGN_OTHER},
    {17, "version https://g", "a Git LFS pointer in place of the file", "fetch it with git lfs pull",
     FFP_FOREIGN_OTHER},
};

// Drawing programs' own files. Their bytes tell less than their endings: many are ZIP archives.
static const struct {
    const char *ending, *name, *advice; // NULL: export it
} natives[] = {
    {".kra", "a Krita document", NULL},
    {".ora", "an OpenRaster document", NULL},
    {".procreate", "a Procreate document", NULL},
    {".xcf", "a GIMP document (XCF)", NULL},
    {".clip", "a Clip Studio document", NULL},
    {".afphoto", "an Affinity document", NULL},
    {".afdesign", "an Affinity document", NULL},
    {".afpub", "an Affinity document", NULL},
    {".af", "an Affinity document", NULL},
    {".ai", "an Illustrator document", NULL},
    {".eps", "a PostScript drawing (EPS)", NULL},
    {".ps", "a PostScript drawing", NULL},
    {".psb", "a Photoshop document (PSB)", NULL},
    {".svgz", "an SVG drawing", NULL},
    {".sketch", "a Sketch document", NULL},
    {".cdr", "a CorelDRAW document", NULL},
    {".blend", "a Blender scene", NULL},
    {".pxd", "a Pixelmator document", NULL},
    {".sai2", "a PaintTool SAI document", NULL},
    {".pdn", "a Paint.NET document", NULL},
    {".tga", "a TGA picture", NULL},
    {".cube", "a table of colours (LUT)", "a picture is needed here"},
};

// -1: it has another ending.
static int native_of(const char *path) {
    const size_t length = strlen(path);
    for (size_t i = 0; i < sizeof natives / sizeof *natives; i++) {
        const size_t end = strlen(natives[i].ending);
        if (length > end && strcasecmp(path + length - end, natives[i].ending) == 0) return (int)i;
    }
    return -1;
}

// XML declares itself, and comments come before what it holds.
static bool is_svg(const FfpEncoded *file) {
    enum { HEAD = 4096 };
    const size_t size = file->size < HEAD ? file->size : HEAD;
    size_t at = size > 3 && memcmp(file->data, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    while (at < size && file->data[at] != 0 && strchr(" \t\r\n", file->data[at])) at++;
    if (at == size || file->data[at] != '<') return false;
    for (; at + 5 <= size && strncasecmp((const char *)file->data + at, "<html", 5) != 0; at++)
        if (memcmp(file->data + at, "<svg", 4) == 0 && strchr(" \t\r\n>", file->data[at + 4])) return true;
    return false;
}

// MPEG's transport stream: packets of 188 bytes, behind the time of each in files of cameras (AVCHD).
static bool is_transport_stream(const FfpEncoded *file) {
    enum { PACKET = 188, TIME = 4, PACKETS = 3 };
    for (size_t time = 0; time <= TIME; time += TIME) {
        size_t n = 0;
        while (n < PACKETS && time + n * (PACKET + time) < file->size &&
               file->data[time + n * (PACKET + time)] == 'G')
            n++;
        if (n == PACKETS) return true;
    }
    return false;
}

static const Foreign *find(const FfpEncoded *file) {
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        const Foreign *kind = &table[i];
        size_t same = 0;
        while (same < kind->length && same < file->size &&
               (kind->bytes[same] == '?' || (unsigned char)kind->bytes[same] == file->data[same]))
            same++;
        if (same == kind->length) return kind;
    }
    static const Foreign stream = {0, "", "an MPEG video", EXTRACT};
    return is_transport_stream(file) ? &stream : NULL;
}

bool ffp_is_foreign(const FfpEncoded *file) {
    return find(file) != NULL;
}

FfpForeign ffp_foreign_kind(const FfpEncoded *head) {
    const Foreign *kind = find(head);
    return kind ? kind->kind : FFP_FOREIGN_OTHER;
}

bool ffp_refuse_foreign(const FfpEncoded *file, FfpError *err) {
    const Foreign *kind = find(file);
    Foreign other = {.name = "an SVG drawing", .advice = EXPORT};
    const int native = native_of(file->path);
    if (native >= 0) {
        other.name = natives[native].name;
        if (natives[native].advice) other.advice = natives[native].advice;
    }
    if (native >= 0 || is_svg(file)) kind = &other;
    if (!kind) return ffp_fail(err, FFP_ERROR_FILE, file->path, "is not a PNG, JPEG, TIFF or EXR image");
    return ffp_fail(err, FFP_ERROR_UNSUPPORTED, file->path, "is %s, which is not supported: %s", kind->name,
                    kind->advice);
}
