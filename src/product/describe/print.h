// The printed description of a capture that has been read.
#ifndef FFP_DESCRIBE_PRINT_H
#define FFP_DESCRIBE_PRINT_H

#include "core/capture/capture.h"
#include "product/describe/describe.h"

// A capture, and what is looked at of it: the same memory, or, where photographs of their own size would take
// gigabytes, reduced ones that are read one after the other.
typedef struct FfpLooked {
    FfpCapture *taken;
    FfpCapture seen;
    bool reduced;
} FfpLooked;
// Photographs of more than `values` numbers are reduced to half as many.
bool ffp_looked_open(FfpLooked *looked, const char *path, double values, FfpError *err);
#define FFP_LOOKED_VALUES 512e6 // 2 GB
void ffp_looked_free(FfpLooked *looked);

// Its contents and checks, as `info` shows them; the latter are added to what was found, too.
void ffp_print_capture(FILE *out, const FfpLooked *looked, FfpFindings *found);

#endif
