// The configuration of a training run. An accepted one must be printed in a form that reads to the same.
#include <stdlib.h>
#include <string.h>
#include "fuzz.h"
#include "lab/train/train.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    FfpTrainConfig config = ffp_train_defaults(), again;
    FfpError err = {0};
    const bool ok = ffp_train_config_overlay(&config, fuzz_file(data, size), &err);
    fuzz_verdict(ok, &err);
    if (!ok) return 0;
    char *text = ffp_train_config_print(&config, &err);
    if (!text || !ffp_train_config_parse(&again, text, "print", &err)) abort();
    ffp_free(text);
    return 0;
}
