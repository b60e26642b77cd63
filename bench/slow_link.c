// A network cable between two network namespaces of one machine (Linux, root), with a latency and a rate: for
// measuring programs as if on two machines where the kernel has no netem. A TUN device stands at each end;
// what goes into one comes out of the other when its bits would have been sent at the rate, plus the latency.
// slow_link NAMESPACE ADDRESS NAMESPACE ADDRESS LATENCY_MS RATE_MBIT     addresses such as 10.9.0.1/24
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

enum { MTU = 65000, PLACES = 512 }; // large packets: the kernel's work for each is not what is measured
static const double FRAMES = 1538.0 / 1500; // what Ethernet would put on the wire for a byte of them

typedef struct Packet {
    int64_t due; // ns
    int size;
    unsigned char bytes[MTU + 64];
} Packet;

typedef struct Pipe { // one direction
    int from, to;     // TUN devices
    int64_t free;     // when the wire has sent all that was put on it, ns
    uint64_t put, taken;
    Packet *places; // [PLACES]
} Pipe;

static int64_t now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * 1000000000LL + time.tv_nsec;
}

static void die(const char *what) {
    fprintf(stderr, "slow_link: %s: %s\n", what, strerror(errno));
    exit(1);
}

// A TUN device called "wire" in the namespace, up, with the address.
static int open_end(const char *space, const char *address) {
    char path[256], command[512];
    snprintf(path, sizeof path, "/run/netns/%s", space);
    const int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0 || setns(fd, CLONE_NEWNET) != 0) die(path);
    close(fd);
    const int tun = open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC);
    struct ifreq request = {.ifr_flags = IFF_TUN | IFF_NO_PI};
    strcpy(request.ifr_name, "wire");
    if (tun < 0 || ioctl(tun, TUNSETIFF, &request) != 0) die("/dev/net/tun");
    snprintf(command, sizeof command,
             "ip addr add %s dev wire && ip link set wire mtu %d up && ip link set lo up", address, MTU);
    if (system(command) != 0) die(command);
    return tun;
}

// Takes what has gone into one end.
static void take_in(Pipe *pipe, int64_t latency, double ns_a_byte) {
    while (pipe->put - pipe->taken < PLACES) {
        Packet *packet = &pipe->places[pipe->put % PLACES];
        packet->size = (int)read(pipe->from, packet->bytes, sizeof packet->bytes);
        if (packet->size <= 0) return;
        const int64_t begin = pipe->free > now() ? pipe->free : now();
        pipe->free = begin + (int64_t)(ns_a_byte * FRAMES * packet->size);
        packet->due = pipe->free + latency;
        pipe->put++;
    }
}

// Lets out of the other end what is due; returns when the next one is, or -1.
static int64_t let_out(Pipe *pipe) {
    while (pipe->taken < pipe->put) {
        const Packet *packet = &pipe->places[pipe->taken % PLACES];
        if (packet->due > now()) return packet->due;
        if (write(pipe->to, packet->bytes, (size_t)packet->size) < 0 && errno == EAGAIN) return now() + 50000;
        pipe->taken++;
    }
    return -1;
}

static void carry(Pipe pipes[2], int64_t latency, double ns_a_byte) {
    for (;;) {
        int64_t next = -1;
        struct pollfd ends[2];
        for (int i = 0; i < 2; i++) {
            take_in(&pipes[i], latency, ns_a_byte);
            const int64_t due = let_out(&pipes[i]);
            if (due >= 0 && (next < 0 || due < next)) next = due;
            const bool full = pipes[i].put - pipes[i].taken == PLACES;
            ends[i] = (struct pollfd){.fd = full ? -1 : pipes[i].from, .events = POLLIN};
        }
        int64_t wait = next < 0 ? 1000000000 : next - now();
        if (wait < 0) wait = 0;
        const struct timespec time = {.tv_sec = wait / 1000000000, .tv_nsec = wait % 1000000000};
        ppoll(ends, 2, &time, NULL);
    }
}

int main(int argc, char **argv) {
    if (argc != 7) {
        fprintf(stderr, "usage: slow_link NAMESPACE ADDRESS NAMESPACE ADDRESS LATENCY_MS RATE_MBIT\n");
        return 2;
    }
    const int ends[2] = {open_end(argv[1], argv[2]), open_end(argv[3], argv[4])};
    Pipe pipes[2] = {{.from = ends[0], .to = ends[1]}, {.from = ends[1], .to = ends[0]}};
    for (int i = 0; i < 2; i++)
        if (!(pipes[i].places = calloc(PLACES, sizeof(Packet)))) die("memory");
    printf("ready\n");
    fflush(stdout);
    carry(pipes, (int64_t)(1e6 * strtod(argv[5], NULL)), 8e3 / strtod(argv[6], NULL));
}
