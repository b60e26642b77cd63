// A page describes captures alone.
#include "product/describe/describe.h"

bool ffp_describe(FILE *out, const char *path, FfpFindings *found, FfpError *err) {
    return ffp_describe_capture(out, path, found, err);
}
