// Memory that products pack their operands into: kept from one call to the next.
#ifndef FFP_TENSOR_WORKSPACE_H
#define FFP_TENSOR_WORKSPACE_H

#include <stddef.h>

// At least `bytes` bytes, 64-byte aligned, of the calling thread's own; contents undefined. Good until the
// thread's next call; freed when the thread ends. Allocates only when asked for more than ever before.
void *ffp_workspace(size_t bytes);

#endif
