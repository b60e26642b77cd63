#include "lab/baselines/density.h"
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/vec.h"

static void make_counts(FfpDensityControl *density_control, int64_t count) {
    ffp_free(density_control->pull);
    ffp_free(density_control->seen);
    density_control->pull = ffp_alloc((size_t)count + 1, sizeof *density_control->pull);
    density_control->seen = ffp_alloc((size_t)count + 1, sizeof *density_control->seen);
}

FfpDensityControl ffp_density_control_new(const FfpDensity *density, int64_t count, uint64_t seed) {
    FfpDensityControl density_control = {.density = *density, .rng = ffp_rng(seed, 2)};
    make_counts(&density_control, count);
    return density_control;
}

void ffp_density_control_free(FfpDensityControl *density_control) {
    ffp_free(density_control->pull);
    ffp_free(density_control->seen);
    *density_control = (FfpDensityControl){0};
}

// The gradient to a centre, seen as one to its place in the picture: a step of a pixel is a step of z / f
// across the view. 3DGS measures in halves of the picture.
static void note(void *state, const FfpGaussians *gaussians, const FfpGaussians *grad,
                 const FfpCamera *camera) {
    FfpDensityControl *density_control = state;
    const real x_scale = (real)camera->width / (2 * camera->fx);
    const real y_scale = (real)camera->height / (2 * camera->fy);
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < gaussians->count; i++) {
        real g[3], at[3];
        if (ffp_dot3(grad->centre + 3 * i, grad->centre + 3 * i) == 0) continue;
        ffp_inverse_rotate(camera->pose, grad->centre + 3 * i, g);
        ffp_inverse_transform_point(camera->pose, gaussians->centre + 3 * i, at);
        const real x = g[0] * at[2] * x_scale, y = g[1] * at[2] * y_scale;
        density_control->pull[i] += sqrt(x * x + y * y);
        density_control->seen[i]++;
    }
}

// The fate of each Gaussian: where the rows of the next set come from.
typedef struct Plan {
    int64_t *from; // [count] rows of the old set
    bool *halved;  // [count] this row is one half of a split
    bool *fresh;   // [count] this row has no past: its moments start at zero
    int64_t count;
} Plan;

static void plan_row(Plan *plan, int64_t from, bool halved, bool fresh) {
    plan->from[plan->count] = from;
    plan->halved[plan->count] = halved;
    plan->fresh[plan->count++] = fresh;
}

static Plan make_plan(const FfpDensityControl *density_control, const FfpGaussians *g) {
    const FfpDensity *density = &density_control->density;
    const size_t most = 2 * (size_t)g->count + 1;
    Plan plan = {ffp_alloc(most, sizeof *plan.from), ffp_alloc(most, sizeof *plan.halved),
                 ffp_alloc(most, sizeof *plan.fresh), 0};
    int64_t room = density->most - g->count;
    for (int64_t i = 0; i < g->count; i++) {
        if (g->opacity[i] < density->least_opacity) continue;
        const real pull =
            density_control->seen[i] ? density_control->pull[i] / (real)density_control->seen[i] : 0;
        const bool grows = pull > density->gradient && room-- > 0;
        const bool splits = grows && fmax(g->scale[3 * i], g->scale[3 * i + 1]) > density->small;
        plan_row(&plan, i, splits, splits);
        if (grows) plan_row(&plan, i, splits, true);
    }
    return plan;
}

static void free_plan(Plan *plan) {
    ffp_free(plan->from);
    ffp_free(plan->halved);
    ffp_free(plan->fresh);
}

// A half lies at a point drawn from the splat, and is 1.6 times narrower (Kerbl et al. 2023).
static void halve(FfpParameters *p, const FfpGaussians *old, int64_t from, int64_t to, FfpRng *rng) {
    real m[9], step[3];
    ffp_quaternion_matrix(old->rotation + 4 * from, m);
    for (int k = 0; k < 3; k++) {
        step[k] = old->scale[3 * from + k] * (real)ffp_rng_normal(rng);
        p->numbers.scale[3 * to + k] -= log((real)1.6F);
    }
    for (int k = 0; k < 3; k++) p->numbers.centre[3 * to + k] += ffp_dot3(m + 3 * k, step);
}

static void forget(FfpGaussians *moments, const Plan *plan) {
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute x = ffp_attribute(moments, a);
        for (int64_t i = 0; i < plan->count; i++)
            if (plan->fresh[i]) memset(x.data + i * x.width, 0, (size_t)x.width * sizeof(real));
    }
}

static bool change(FfpDensityControl *density_control, FfpParameters *parameters,
                   const FfpGaussians *gaussians, FfpGaussianAdam *adam_state) {
    Plan plan = make_plan(density_control, gaussians);
    const bool any = plan.count > 0; // all gone: rather keep them
    if (any) {
        ffp_parameters_gather(parameters, plan.from, plan.count);
        ffp_gaussians_gather(&adam_state->mean, plan.from, plan.count);
        ffp_gaussians_gather(&adam_state->square, plan.from, plan.count);
        forget(&adam_state->mean, &plan);
        forget(&adam_state->square, &plan);
        for (int64_t i = 0; i < plan.count; i++)
            if (plan.halved[i]) halve(parameters, gaussians, plan.from[i], i, &density_control->rng);
    }
    free_plan(&plan);
    make_counts(density_control, parameters->numbers.count);
    return any;
}

// Opacities come back where the pictures need them; what does not is taken away later.
static void reset_opacities(const FfpDensity *density, FfpParameters *parameters,
                            FfpGaussianAdam *adam_state) {
    const real most = log(density->reset_to / (1 - density->reset_to));
    const FfpGaussians *n = &parameters->numbers;
    for (int64_t i = 0; i < n->count; i++) n->opacity[i] = fmin(n->opacity[i], most);
    memset(adam_state->mean.opacity, 0, (size_t)n->count * sizeof(real));
    memset(adam_state->square.opacity, 0, (size_t)n->count * sizeof(real));
}

static bool step_control(void *state, int64_t step, FfpParameters *parameters, const FfpGaussians *gaussians,
                         FfpGaussianAdam *adam_state) {
    FfpDensityControl *density_control = state;
    const FfpDensity *density = &density_control->density;
    if (step > density->until) return false;
    const bool changed = step >= density->from && step % density->every == 0 &&
                         change(density_control, parameters, gaussians, adam_state);
    const bool reset = step % density->reset_every == 0;
    if (reset) reset_opacities(density, parameters, adam_state);
    return changed || reset;
}

FfpGrowth ffp_density_growth(FfpDensityControl *density_control) {
    return (FfpGrowth){density_control, note, step_control};
}
