// The width of the vectors that the CPU level being compiled works with: in kernels' folders only, since
// they alone are compiled for more than one level.
#ifndef FFP_BASE_VECTOR_H
#define FFP_BASE_VECTOR_H

#if defined(__AVX512F__)
enum { FFP_VECTOR_BYTES = 64 };
#elif defined(__AVX2__)
enum { FFP_VECTOR_BYTES = 32 };
#else
enum { FFP_VECTOR_BYTES = 16 };
#endif

#endif
