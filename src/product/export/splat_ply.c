// The PLY that the reference implementation of 3DGS writes (Kerbl et al. 2023), and viewers of splats read.
#include <math.h>
#include "core/base/file.h"
#include "core/gaussians/row.h"
#include "product/export/bytes.h"
#include "product/export/splats.h"

#define MARGIN 1e-6 // of opacities, whose logit has no end at 0 and 1
#define REST 45     // coefficients of higher degrees, all 0: the colour is one for all directions
#define NUMBERS (17 + REST)

static void write_header(FILE *stream, int64_t count) {
    fprintf(stream, "ply\nformat binary_little_endian 1.0\nelement vertex %lld\n", (long long)count);
    static const char *const first[6] = {"x", "y", "z", "nx", "ny", "nz"};
    for (int i = 0; i < 6; i++) fprintf(stream, "property float %s\n", first[i]);
    for (int i = 0; i < 3; i++) fprintf(stream, "property float f_dc_%d\n", i);
    for (int i = 0; i < REST; i++) fprintf(stream, "property float f_rest_%d\n", i);
    fputs("property float opacity\n", stream);
    for (int i = 0; i < 3; i++) fprintf(stream, "property float scale_%d\n", i);
    for (int i = 0; i < 4; i++) fprintf(stream, "property float rot_%d\n", i);
    fputs("end_header\n", stream);
}

static void encode(const FfpSplats *splats, int64_t i, unsigned char *bytes) {
    float row[NUMBERS] = {0};
    for (int k = 0; k < 3; k++) {
        row[k] = (float)splats->centre[3 * i + k];
        row[6 + k] = (float)(((double)splats->colour[3 * i + k] - 0.5) / FFP_SH_C0);
        row[10 + REST + k] = (float)log((double)splats->scale[3 * i + k]);
    }
    const double o = fmin(fmax((double)splats->opacity[i], MARGIN), 1 - MARGIN);
    row[9 + REST] = (float)log(o / (1 - o));
    for (int k = 0; k < 4; k++) row[13 + REST + k] = (float)splats->rotation[4 * i + k];
    for (int k = 0; k < NUMBERS; k++) ffp_put_float(bytes + 4 * k, row[k]);
}

bool ffp_splats_write_ply(const FfpSplats *splats, const char *path, FfpError *err) {
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) return false;
    write_header(out.stream, splats->count);
    for (int64_t i = 0; i < splats->count; i++) {
        unsigned char bytes[4 * NUMBERS];
        encode(splats, i, bytes);
        if (fwrite(bytes, sizeof bytes, 1, out.stream) == 1) continue;
        ffp_output_abort(&out);
        return ffp_fail(err, FFP_ERROR_IO, path, "cannot write");
    }
    return ffp_output_commit(&out, err);
}
