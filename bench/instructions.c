// A plugin of qemu-user that counts the instructions that a program executes (script/test-arm --count): with
// counter=FILE in that file, 64 bits that the program itself may map and read.
// Declared here is what it takes of QEMU's interface, version 1 (docs/devel/tcg-plugins.rst), for which
// Debian has no header.
#include <fcntl.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define SHOWN __attribute__((visibility("default")))

typedef uint64_t Id;
enum { INLINE_ADD_U64 = 0 };
void qemu_plugin_register_vcpu_tb_trans_cb(Id id, void (*translated)(Id id, void *block));
void qemu_plugin_register_vcpu_tb_exec_inline(void *block, int operation, void *counter, uint64_t by);
void qemu_plugin_register_atexit_cb(Id id, void (*ended)(Id id, void *user), void *user);
size_t qemu_plugin_tb_n_insns(const void *block);
void qemu_plugin_outs(const char *text);
int qemu_plugin_install(Id id, const void *info, int count, char **arguments);

extern SHOWN int qemu_plugin_version;
SHOWN int qemu_plugin_version = 1;

static uint64_t own, *executed = &own; // of one thread: adding is not atomic

static void translated(Id id, void *block) {
    (void)id;
    qemu_plugin_register_vcpu_tb_exec_inline(block, INLINE_ADD_U64, executed, qemu_plugin_tb_n_insns(block));
}

static void ended(Id id, void *user) {
    char text[64];
    (void)id, (void)user;
    snprintf(text, sizeof text, "%" PRIu64 " instructions\n", *executed);
    qemu_plugin_outs(text);
}

static bool count_in(const char *path) {
    const int file = open(path, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    void *at = MAP_FAILED;
    if (file >= 0 && ftruncate(file, sizeof *executed) == 0)
        at = mmap(NULL, sizeof *executed, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (file >= 0) close(file);
    if (at != MAP_FAILED) executed = at;
    return at != MAP_FAILED;
}

SHOWN int qemu_plugin_install(Id id, const void *info, int count, char **arguments) {
    (void)info;
    for (int i = 0; i < count; i++)
        if (strncmp(arguments[i], "counter=", 8) != 0 || !count_in(arguments[i] + 8)) return 1;
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    qemu_plugin_register_atexit_cb(id, ended, NULL);
    return 0;
}
