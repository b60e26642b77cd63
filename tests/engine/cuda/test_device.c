// The device's memory, and kernels whose threads meet.
#include <string.h>
#include "engine/cuda/cuda.h"
#include "support.h"

static void test_memory_goes_there_and_back(void **state) {
    (void)state;
    FfpError err = {0};
    const FfpDevice *device = ffp_cuda_device(&err);
    if (!device) {
        print_message("%s\n", err.text);
        skip();
    }
    print_message("%s\n", ffp_cuda_describe());
    ffp_device_use(device);
    const float numbers[5] = {1, 2, 3, 4, 5};
    float back[5] = {0};
    float *there = ffp_memory_uploaded(numbers, 5, sizeof *there);
    float *copy = ffp_memory_new(5, sizeof *copy);
    ffp_memory_download(back, copy, sizeof back);
    for (int i = 0; i < 5; i++) assert_true(back[i] == 0);
    ffp_memory_copy(copy, there, sizeof numbers);
    ffp_memory_zero(copy + 3, sizeof *copy);
    ffp_memory_download(back, copy, sizeof back);
    for (int i = 0; i < 5; i++) assert_true(back[i] == (i == 3 ? 0 : numbers[i]));
    ffp_memory_free(there);
    ffp_memory_free(copy);
    ffp_device_use(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_memory_goes_there_and_back)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
