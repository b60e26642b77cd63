// The number type of the numeric rooms: float, or double when the same sources are built for the gradient
// tests. Write constants with the F suffix (0.5F) and include <tgmath.h> so that one text serves both.
#ifndef FFP_BASE_REAL_H
#define FFP_BASE_REAL_H

#ifndef FFP_REAL
#define FFP_REAL float
#endif
typedef FFP_REAL real;

#define FFP_PI 3.14159265358979324F          // in a numeric room's formulas
#define FFP_PI_DOUBLE 3.14159265358979323846 // where all is double

// How a formula is declared that the kernels of the CPU and of the GPU share: one text for both.
#ifdef __CUDACC__
#define FFP_FORMULA static __host__ __device__ inline
#else
#define FFP_FORMULA static inline
#endif

#endif
