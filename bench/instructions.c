// A plugin of qemu-user that counts the instructions that a program executes (script/test-arm --count).
// Declared here is what it takes of QEMU's interface, version 1 (docs/devel/tcg-plugins.rst), for which
// Debian has no header.
#include <inttypes.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

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

static uint64_t executed; // of one thread: adding is not atomic

static void translated(Id id, void *block) {
    (void)id;
    qemu_plugin_register_vcpu_tb_exec_inline(block, INLINE_ADD_U64, &executed, qemu_plugin_tb_n_insns(block));
}

static void ended(Id id, void *user) {
    char text[64];
    (void)id, (void)user;
    snprintf(text, sizeof text, "%" PRIu64 " instructions\n", executed);
    qemu_plugin_outs(text);
}

SHOWN int qemu_plugin_install(Id id, const void *info, int count, char **arguments) {
    (void)info, (void)count, (void)arguments;
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    qemu_plugin_register_atexit_cb(id, ended, NULL);
    return 0;
}
