// Drawing of a subject's pictures: Gaussians or a neural field.
#include "lab/eval/subject.h"
#include "core/base/alloc.h"

bool ffp_subject_given(const FfpSubject *subject, int pattern) {
    for (int i = 0; i < subject->n_given; i++)
        if (subject->given[i] == pattern) return true;
    return false;
}

bool ffp_subject_draws(const FfpSubject *subject) {
    return subject->gaussians || subject->field;
}

void ffp_subject_draw(FfpSubject *subject, const FfpCamera *camera, const FfpCamera *projector) {
    if (subject->field)
        ffp_field_pass_draw(subject->field_pass, subject->field, camera, projector,
                            subject->capture->intensity);
    else
        ffp_view_pass_draw(subject->pass, subject->gaussians, camera, projector);
}

FfpImage ffp_subject_relight(FfpSubject *subject, const FfpSummed *pattern) {
    if (!subject->field) return ffp_relight(subject->pass, subject->capture->intensity, pattern);
    FfpImage picture = ffp_field_pass_shade(subject->field_pass, pattern);
    ffp_quantise(&picture);
    return picture;
}

const FfpGbuffer *ffp_subject_gbuffer(const FfpSubject *subject) {
    return subject->field ? ffp_field_pass_gbuffer(subject->field_pass)
                          : ffp_view_pass_gbuffer(subject->pass);
}

void ffp_subject_free_drawing(FfpSubject *subject) {
    ffp_view_pass_free(subject->pass);
    if (subject->gaussians) ffp_gaussians_free(subject->gaussians);
    ffp_free(subject->gaussians);
    ffp_field_pass_free(subject->field_pass);
    if (subject->field) ffp_neural_field_free(subject->field);
    ffp_free(subject->field);
}
