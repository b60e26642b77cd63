// In a browser no program lies in a folder.
#include "core/base/file.h"

bool ffp_own_folder(char out[FFP_PATH_MAX]) {
    out[0] = 0;
    return false;
}
