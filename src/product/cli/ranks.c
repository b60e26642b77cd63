// Several processes of one program under mpirun or srun: who this one is. A process that was started alone
// never meets MPI.
#include <stdio.h>
#include <stdlib.h>
#include "cli.h"
#ifdef FFP_WITH_MPI
#include "product/cluster/cluster.h"
#endif

static const FfpRanks *ranks; // NULL: alone

// How many processes the job has that started this one, by what MPI's starters leave in the environment: Open
// MPI; MPICH, Intel MPI and Slurm's PMI-2; Slurm's PMIx, which tells the rank alone.
static long processes(void) {
    static const char *const sizes[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        const char *size = getenv(sizes[i]);
        if (size) return strtol(size, NULL, 10);
    }
    const char *tasks = getenv("SLURM_STEP_NUM_TASKS");
    return getenv("PMIX_RANK") && tasks ? strtol(tasks, NULL, 10) : 1;
}

bool ffp_cli_join_ranks(FfpError *err) {
    if (ranks || processes() < 2) return true;
#ifdef FFP_WITH_MPI
    ranks = ffp_cluster_join(err);
    return ranks != NULL;
#else
    err->code = FFP_ERROR_UNSUPPORTED;
    snprintf(err->text, sizeof err->text,
             "this is one of %ld processes of an MPI job, but the program was built without MPI (cmake "
             "-DFFPROCAMS_MPI=ON)",
             processes());
    return false;
#endif
}

const FfpRanks *ffp_cli_ranks(void) {
    return ranks;
}

const char *ffp_cli_rank_name(void) {
    static char name[32];
    if (ranks) snprintf(name, sizeof name, "rank %d: ", ranks->rank);
    return name;
}

int ffp_cli_leave_ranks(int status) {
#ifdef FFP_WITH_MPI
    if (!ranks) return status;
    fflush(stdout);
    if (status != FFP_EXIT_OK) ffp_cluster_abort();
    ffp_cluster_leave();
    ranks = NULL;
#endif
    return status;
}
