// Files that people take for Gaussians this program reads: known by their first bytes or their ending, to say
// what helps.
#include <string.h>
#include <strings.h>
#include "core/base/file.h"
#include "core/gaussians/elsewhere.h"

enum { HEAD = 32 };

#define CONVERT "convert it to PLY or SPZ, for example with SuperSplat or splat-transform"
#define EXPORT "export its Gaussians as PLY with the program that trained them"
#define POINTS "train splats from it, and take those"

typedef struct Foreign {
    const char *bytes, *ending; // NULL: any
    const char *name, *advice;
} Foreign;

static const Foreign table[] = {
    {"PK\3\4", ".sog", "SOG", CONVERT},
    {NULL, ".ksplat", "KSPLAT", CONVERT},
    {NULL, "meta.json", "SOG", CONVERT},
    {NULL, ".lcc", "an LCC scene", CONVERT},
    {NULL, ".rad", "a RAD scene", CONVERT},
    {"PK\3\4", ".usdz", "a USD scene", CONVERT},
    {"PXR-USDC", NULL, "a USD scene", CONVERT},
    {"#usda", NULL, "a USD scene", CONVERT},
    {"PK\3\4", ".npz", "an archive of NumPy", EXPORT},
    {"PK\3\4", ".pt", "a checkpoint of PyTorch", EXPORT},
    {"PK\3\4", ".pth", "a checkpoint of PyTorch", EXPORT},
    {"PK\3\4", ".ckpt", "a checkpoint of PyTorch", EXPORT},
    {"PK\3\4", NULL, "a ZIP archive", "unpack it"},
    {"\x28\xb5\x2f\xfd", NULL, "compressed by zstd", "unpack it"},
    {"LASF", NULL, "a point cloud (LAS)", POINTS},
    {"ASTM-E57", NULL, "a point cloud (E57)", POINTS},
    {"# .PCD", NULL, "a point cloud (PCD)", POINTS},
    {"Kaydara FBX", NULL, "an FBX scene", POINTS},
    {NULL, ".obj", "a mesh (OBJ)", POINTS},
    {NULL, ".stl", "a mesh (STL)", POINTS},
    {"version https://git-lfs", NULL, "a Git LFS pointer in place of the file", "fetch it with git lfs pull"},
    {"<!DOCTYPE", NULL, "a web page", "download the file that it offers"},
    {"<html", NULL, "a web page", "download the file that it offers"},
};

static bool fits(const Foreign *kind, const char *head, size_t size, const char *path) {
    const size_t length = kind->bytes ? strlen(kind->bytes) : 0,
                 end = kind->ending ? strlen(kind->ending) : 0;
    return size >= length && strncasecmp(head, kind->bytes ? kind->bytes : "", length) == 0 &&
           strlen(path) >= end && (end == 0 || strcasecmp(path + strlen(path) - end, kind->ending) == 0);
}

bool ffp_refuse_splats(const char *path, FfpError *err) {
    char head[HEAD + 1] = "";
    FILE *stream = ffp_open_to_read(path, err);
    if (!stream) return false;
    const size_t size = fread(head, 1, HEAD, stream);
    fclose(stream);
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        if (fits(&table[i], head, size, path))
            return ffp_fail(err, FFP_ERROR_UNSUPPORTED, path, "is %s, which is not supported: %s",
                            table[i].name, table[i].advice);
    return ffp_fail(err, FFP_ERROR_FILE, path,
                    size == 0 ? "is empty"
                              : "is not a capture, a model, Gaussians (PLY, SPZ, glTF, .splat) or a field");
}
