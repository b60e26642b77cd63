// Names of functions that are compiled once for each CPU level (base/cpu.h). CMake defines FFP_LEVEL as the
// level's name (portable, avx2, avx512, avx512bf16, amx) and, where products take bf16 operands, FFP_BF16.
#ifndef FFP_BASE_LEVEL_H
#define FFP_BASE_LEVEL_H

#define FFP_PASTE_LEVEL(level, name) ffp_##level##_##name
#define FFP_EXPAND_LEVEL(level, name) FFP_PASTE_LEVEL(level, name)
#define FFP_K(name) FFP_EXPAND_LEVEL(FFP_LEVEL, name)

#endif
