// What is printed of a capture that has been read.
#ifndef FFP_DESCRIBE_PRINT_H
#define FFP_DESCRIBE_PRINT_H

#include "core/capture/capture.h"
#include "product/describe/describe.h"

// Its contents and checks, as `info` shows them.
void ffp_print_capture(FILE *out, const FfpCapture *capture);

#endif
