// The emulation of blocks and threads (emulate.h).
#include "engine/cuda/emulate.h"
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

dim3 threadIdx, blockIdx, blockDim, gridDim;
alignas(64) unsigned char ffp_emulated_shared[227 * 1024];

// Saves what a function must keep on the stack in use, leaves that stack at *from, and goes on where `to` was
// left.
#ifdef __x86_64__
extern "C" void ffp_switch_stacks(void **from, void *to);
asm(R"(
    .text
    .globl ffp_switch_stacks
    .type ffp_switch_stacks, @function
ffp_switch_stacks:
    pushq %rbp
    pushq %rbx
    pushq %r12
    pushq %r13
    pushq %r14
    pushq %r15
    movq %rsp, (%rdi)
    movq %rsi, %rsp
    popq %r15
    popq %r14
    popq %r13
    popq %r12
    popq %rbx
    popq %rbp
    ret
)");
#else
#include <ucontext.h>
#endif

namespace {

constexpr size_t STACK = 64 * 1024;
constexpr unsigned WARP = 32;
enum class State { running, at_warp, at_block, done };

// A flow of control with a stack of its own. ucontext's switch asks the system each time.
#ifdef __x86_64__
typedef void *Context;

void switch_context(Context *from, Context *to) {
    ffp_switch_stacks(from, *to);
}

void begin_context(Context *context, unsigned char *stack, void (*entry)()) {
    enum { SAVED = 6 }; // registers; then the place to go on at, aligned as a call would leave it
    void **top = reinterpret_cast<void **>(reinterpret_cast<uintptr_t>(stack + STACK) & ~(uintptr_t)15) - 2;
    *top = reinterpret_cast<void *>(entry);
    for (int i = 1; i <= SAVED; i++) top[-i] = nullptr;
    *context = top - SAVED;
}
#else
typedef ucontext_t Context;

void switch_context(Context *from, Context *to) {
    swapcontext(from, to);
}

void begin_context(Context *context, unsigned char *stack, void (*entry)()) {
    getcontext(context);
    context->uc_stack.ss_sp = stack;
    context->uc_stack.ss_size = STACK;
    context->uc_link = nullptr;
    makecontext(context, entry, 0);
}
#endif

struct Fiber {
    Context context;
    std::unique_ptr<unsigned char[]> stack;
    State state;
    unsigned parity; // of the exchange it is at
};
struct Warp {
    uint64_t slots[2][WARP][4];
};

std::vector<Fiber> fibers;
std::vector<Warp> warps;
Context scheduler;
const std::function<void()> *body;
unsigned current;
bool cooperating;

[[noreturn]] void die(const char *what) {
    fprintf(stderr, "emulated kernel: %s (block %u,%u,%u thread %u)\n", what, blockIdx.x, blockIdx.y,
            blockIdx.z, current);
    abort();
}

void place(unsigned thread) {
    current = thread;
    threadIdx = dim3(thread % blockDim.x, thread / blockDim.x % blockDim.y, thread / blockDim.x / blockDim.y);
}

void fiber_main() {
    (*body)();
    fibers[current].state = State::done;
    switch_context(&fibers[current].context, &scheduler);
}

void wait(State state) {
    if (!cooperating) die("threads meet in a launch of independent threads");
    Fiber &me = fibers[current];
    me.state = state;
    switch_context(&me.context, &scheduler);
}

void start(unsigned count) {
    if (fibers.size() < count) fibers.resize(count);
    warps.assign((count + WARP - 1) / WARP, Warp{});
    for (unsigned t = 0; t < count; t++) {
        Fiber &f = fibers[t];
        if (!f.stack) f.stack.reset(new unsigned char[STACK]);
        begin_context(&f.context, f.stack.get(), fiber_main);
        f.state = State::running;
        f.parity = 0;
    }
}

// Runs the fibers of a warp until all wait at the block's barrier or have ended.
void run_warp(unsigned first, unsigned end) {
    for (;;) {
        for (unsigned t = first; t < end; t++) {
            if (fibers[t].state != State::running) continue;
            place(t);
            switch_context(&scheduler, &fibers[t].context);
        }
        unsigned at_warp = 0, at_block = 0;
        for (unsigned t = first; t < end; t++) {
            at_warp += fibers[t].state == State::at_warp;
            at_block += fibers[t].state == State::at_block;
        }
        if (at_warp && at_block) die("some lanes of a warp wait for the warp, others for the block");
        if (!at_warp) return;
        for (unsigned t = first; t < end; t++)
            if (fibers[t].state == State::at_warp) fibers[t].state = State::running;
    }
}

void run_block(unsigned count) {
    start(count);
    for (bool waits = true; waits;) {
        waits = false;
        for (unsigned w = 0; w * WARP < count; w++)
            run_warp(w * WARP, (w + 1) * WARP < count ? (w + 1) * WARP : count);
        for (unsigned t = 0; t < count; t++)
            if (fibers[t].state == State::at_block) {
                fibers[t].state = State::running;
                waits = true;
            }
    }
}

template <typename F> void each_block(dim3 grid, F run) {
    ffp_emulated_memory(true);
    gridDim = grid;
    for (unsigned z = 0; z < grid.z; z++)
        for (unsigned y = 0; y < grid.y; y++)
            for (unsigned x = 0; x < grid.x; x++) {
                blockIdx = dim3(x, y, z);
                run();
            }
    ffp_emulated_memory(false);
}

unsigned checked_size(dim3 block) {
    const unsigned count = block.x * block.y * block.z;
    if (count == 0 || count > 1024) die("a block has 1 to 1024 threads");
    blockDim = block;
    return count;
}

} // namespace

void ffp_emulate(dim3 grid, dim3 block, const std::function<void()> &thread) {
    const unsigned count = checked_size(block);
    cooperating = false;
    each_block(grid, [&] {
        for (unsigned t = 0; t < count; t++) {
            place(t);
            thread();
        }
    });
}

void ffp_emulate_blocks(dim3 grid, dim3 block, size_t shared, const std::function<void()> &thread) {
    const unsigned count = checked_size(block);
    if (shared > sizeof ffp_emulated_shared) die("more than 227 KB of shared memory");
    cooperating = true;
    body = &thread;
    each_block(grid, [&] {
        memset(ffp_emulated_shared, 0xff, shared); // nobody may rely on earlier contents
        run_block(count);
    });
}

int ffp_emulated_lane() {
    return (int)(current % WARP);
}

void __syncthreads() {
    wait(State::at_block);
}

void __syncwarp(unsigned) {
    wait(State::at_warp);
}

uint64_t ffp_emulated_exchange(uint64_t mine, int lane) {
    const unsigned me = current;
    Warp &warp = warps[me / WARP];
    const unsigned parity = fibers[me].parity;
    fibers[me].parity ^= 1;
    warp.slots[parity][me % WARP][0] = mine;
    wait(State::at_warp);
    if (lane < 0 || lane >= (int)WARP) return mine;
    return warp.slots[parity][lane][0];
}

const uint64_t (*ffp_emulated_show(const uint64_t mine[4]))[4] {
    const unsigned me = current;
    Warp &warp = warps[me / WARP];
    const unsigned parity = fibers[me].parity;
    fibers[me].parity ^= 1;
    memcpy(warp.slots[parity][me % WARP], mine, sizeof warp.slots[0][0]);
    wait(State::at_warp);
    return warp.slots[parity];
}

unsigned __ballot_sync(unsigned mask, int predicate) {
    const unsigned me = current;
    Warp &warp = warps[me / WARP];
    const unsigned parity = fibers[me].parity;
    fibers[me].parity ^= 1;
    warp.slots[parity][me % WARP][0] = predicate != 0;
    wait(State::at_warp);
    unsigned result = 0;
    const unsigned threads = blockDim.x * blockDim.y * blockDim.z, first = me / WARP * WARP;
    for (unsigned i = 0; i < WARP && first + i < threads; i++)
        if ((mask >> i & 1) && fibers[first + i].state != State::done && warp.slots[parity][i][0])
            result |= 1u << i;
    return result;
}

int __all_sync(unsigned mask, int predicate) {
    return __ballot_sync(mask, !predicate) == 0;
}
