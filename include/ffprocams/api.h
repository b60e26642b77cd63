// What the library exports: it is built with hidden symbols, and FFP_API marks those that are seen from
// outside.
#ifndef FFPROCAMS_API_H
#define FFPROCAMS_API_H

#if defined(__GNUC__)
#define FFP_API __attribute__((visibility("default")))
#else
#define FFP_API
#endif

#endif
