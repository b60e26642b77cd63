// Calibrations without a board of random walks, sound ones and those with a fault: how often errors lie
// within their stated deviations, and what has a name. Prints a table in Markdown.
//   walk_faults [RIGS]     of each kind; 100
#include <stdio.h>
#include <stdlib.h>
#include "tests/rig/selfcal/walks.h"

enum { SPOTS = 1000 };

typedef struct Count {
    int figures, within[2], named, refused, silent;
    double worst; // of focal lengths
} Count;

static void add(Count *c, const WalkResult *r) {
    const double *values[2] = {r->camera, r->projector};
    bool off = r->turn[0] > 3 * r->turn[1];
    c->refused += r->refused;
    if (r->refused) return;
    c->named += r->said[0] != 0;
    for (int i = 0; i < 2; i++) {
        const double error = fabs(values[i][0]);
        c->figures++;
        c->within[0] += error <= values[i][1];
        c->within[1] += error <= 3 * values[i][1];
        c->worst = fmax(c->worst, error);
        off = off || error > 3 * values[i][1];
    }
    c->silent += off && r->said[0] == 0;
}

int main(int argc, char **argv) {
    const int rigs = argc > 1 ? (int)strtol(argv[1], NULL, 10) : 100;
    printf(
        "| walk | within one deviation, %% | within three | largest error, %% | named | refused | silent |\n"
        "|---|---|---|---|---|---|---|\n");
    for (int fault = 0; fault < WALK_FAULTS; fault++) {
        Count c = {0};
        for (int i = 0; i < rigs; i++) {
            Walk walk = random_walk((uint64_t)i, SPOTS);
            put_fault(&walk, (WalkFault)fault);
            const WalkResult r = solve_walk(&walk);
            add(&c, &r);
        }
        printf("| %s | %.0f | %.0f | %.1f | %d | %d | %d |\n", walk_names[fault],
               100.0 * c.within[0] / fmax(1, c.figures), 100.0 * c.within[1] / fmax(1, c.figures),
               100 * c.worst, c.named, c.refused, c.silent);
        fflush(stdout);
    }
    return 0;
}
