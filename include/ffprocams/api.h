// The library is built with hidden symbols; FFP_API marks those that it exports.
#ifndef FFPROCAMS_API_H
#define FFPROCAMS_API_H

#if defined(__GNUC__)
#define FFP_API __attribute__((visibility("default")))
#else
#define FFP_API
#endif

#endif
