// Which of the photographs is which.
#include "core/patterns/patterns.h"
#include "rig/graycode/decoder.h"

int ffp_gray_photographs(int width, int height) {
    return 2 * (ffp_gray_code_bits(width) + ffp_gray_code_bits(height));
}

const char *ffp_gray_photograph(const FfpGrayDecoder *d, int axis, int bit, int inverse) {
    const char *const *pair = d->from->codes + 2 * ((axis ? d->bits[0] : 0) + bit);
    return pair[inverse] ? pair[inverse] : pair[1 - inverse];
}

bool ffp_gray_has_photograph(const FfpGrayDecoder *d, int axis, int bit, int inverse) {
    return d->from->codes[2 * ((axis ? d->bits[0] : 0) + bit) + inverse] != NULL;
}
