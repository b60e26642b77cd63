// The ranks of an MPI job (FfpRanks, ffprocams/context.h): part of the program, not of the library, and the
// only place that knows MPI.
#ifndef FFP_CLUSTER_CLUSTER_H
#define FFP_CLUSTER_CLUSTER_H

#include "ffprocams/context.h"

// Joins the job in which this process was started; once per process. NULL with an error.
const FfpRanks *ffp_cluster_join(FfpError *err);
// Waits for the other ranks and leaves the job, after success.
void ffp_cluster_leave(void);
// Ends the job: the other ranks are killed. Does not return.
void ffp_cluster_abort(void);

#endif
