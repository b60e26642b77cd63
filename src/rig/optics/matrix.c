#include "rig/optics/matrix.h"
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define POINT ": decimals take a point, not a comma"
#define NUMBER_MAX 1e9 // as of poses: squares of it still fit a float

static bool append(const FfpNode *field, FfpMatrix *matrix, int *count, double value, FfpError *err) {
    if (*count == FFP_MATRIX_MAX)
        return ffp_node_fail(field, err, "more than %d numbers in a matrix", FFP_MATRIX_MAX);
    if (!(fabs(value) <= NUMBER_MAX))
        return ffp_node_fail(field, err, "%g is outside %g to %g", value, -NUMBER_MAX, NUMBER_MAX);
    matrix->values[(*count)++] = value;
    return true;
}

// True of "408,5" and "0,12 0,05", not of "1, 2", "0.5,2" and "1,2,3; 4,5,6".
static bool has_decimal_comma(const char *text) {
    if (text && (strchr(text, '.') || strstr(text, ", ") || strstr(text, " ,"))) return false;
    for (const char *at = text, *end; at && *at != 0; at = end + strspn(end, " ;")) {
        end = at + strcspn(at, " ;");
        const char *comma = memchr(at, ',', (size_t)(end - at));
        if (comma && comma > at && isdigit((unsigned char)comma[-1]) && isdigit((unsigned char)comma[1]) &&
            !memchr(comma + 1, ',', (size_t)(end - comma - 1)))
            return true;
    }
    return false;
}

static bool append_text(const FfpNode *field, FfpMatrix *matrix, int *count, FfpError *err) {
    const char *text = json_string_value(field->value);
    if (strpbrk(text, " ;") && has_decimal_comma(text))
        return ffp_node_fail(field, err, "'%.60s' is not a row of numbers%s", text, POINT);
    for (const char *at = text + strspn(text, " ,;"); *at != 0; at += strspn(at, " ,;")) {
        char *end = NULL;
        const double value = strtod(at, &end);
        if (end == at || (*end != 0 && !strchr(" ,;", *end)))
            return ffp_node_fail(field, err, "'%.60s' is not a row of numbers", text);
        if (!append(field, matrix, count, value, err)) return false;
        at = end;
    }
    return true;
}

// The numbers of a list, of a text, or one number.
static bool append_row(const FfpNode *field, FfpMatrix *matrix, int *count, FfpError *err) {
    if (json_is_string(field->value)) return append_text(field, matrix, count, err);
    if (json_is_number(field->value))
        return append(field, matrix, count, json_number_value(field->value), err);
    int n = 0;
    if (!ffp_node_count(field, 1, FFP_MATRIX_MAX, &n, err)) return false;
    for (int i = 0; i < n; i++) {
        FfpNode item;
        if (!ffp_node_item(field, i, &item, err)) return false;
        if (!json_is_number(item.value))
            return ffp_node_fail(&item, err, "must be a number%s",
                                 has_decimal_comma(json_string_value(item.value)) ? POINT : "");
        if (!append(&item, matrix, count, json_number_value(item.value), err)) return false;
    }
    return true;
}

static bool read_opencv(const FfpNode *field, FfpMatrix *matrix, FfpError *err) {
    FfpNode data, type;
    int count = 0;
    const char *dt = "d";
    if (!ffp_get_whole(field, "rows", 1, FFP_MATRIX_MAX, &matrix->rows, err) ||
        !ffp_get_whole(field, "cols", 1, FFP_MATRIX_MAX, &matrix->cols, err) ||
        !ffp_node_get(field, "data", &data, err)) {
        return false;
    }
    if (ffp_node_find(field, "dt", &type) && !ffp_node_text(&type, &dt, err)) return false;
    if (strlen(dt) != 1)
        return ffp_node_fail(&type, err, "'%.20s': only single-channel matrices are supported", dt);
    if (!append_row(&data, matrix, &count, err)) return false;
    return count == matrix->rows * matrix->cols ||
           ffp_node_fail(&data, err, "holds %d numbers, but the matrix has %d x %d%s", count, matrix->rows,
                         matrix->cols, count > matrix->rows * matrix->cols ? POINT : "");
}

bool ffp_node_matrix(const FfpNode *field, FfpMatrix *matrix, FfpError *err) {
    *matrix = (FfpMatrix){0};
    if (json_is_object(field->value)) return read_opencv(field, matrix, err);
    int count = 0;
    if (!ffp_node_count(field, 1, FFP_MATRIX_MAX, &matrix->rows, err)) return false;
    for (int i = 0; i < matrix->rows; i++) {
        FfpNode row;
        const int before = count;
        if (!ffp_node_item(field, i, &row, err) || !append_row(&row, matrix, &count, err)) return false;
        if (i > 0 && count - before != matrix->cols)
            return ffp_node_fail(&row, err, "rows of different lengths");
        matrix->cols = count - before;
    }
    return true;
}

bool ffp_node_matrix_of(const FfpNode *field, int rows, int cols, double *values, FfpError *err) {
    FfpMatrix matrix;
    if (!ffp_node_matrix(field, &matrix, err)) return false;
    const bool flat = (matrix.cols == 1 || matrix.rows == 1) && matrix.rows * matrix.cols == rows * cols;
    if (!flat && (matrix.rows != rows || matrix.cols != cols)) {
        const bool vector = rows == 3 && cols == 3 && matrix.rows * matrix.cols == 3;
        return ffp_node_fail(field, err, "matrix has %d x %d numbers, expected %d x %d%s", matrix.rows,
                             matrix.cols, rows, cols,
                             vector ? ": cv2.Rodrigues makes a matrix of a rotation vector" : "");
    }
    memcpy(values, matrix.values, (size_t)(rows * cols) * sizeof *values);
    return true;
}

bool ffp_pose_from_rotation(const FfpNode *field, const double rotation[9], const double translation[3],
                            double pose[16], FfpError *err) {
    json_t *rows = json_array();
    for (int i = 0; i < 4; i++) {
        json_t *row = json_array();
        for (int j = 0; j < 4; j++) {
            const double last = i == 3 ? 1 : translation[i];
            const double value = j == 3 ? last : i == 3 ? 0 : rotation[3 * i + j];
            json_array_append_new(row, json_real(value));
        }
        json_array_append_new(rows, row);
    }
    FfpNode matrix = *field;
    matrix.value = rows;
    real checked[16];
    const bool ok = ffp_node_pose(&matrix, false, checked, err);
    for (int i = 0; i < 16 && ok; i++) pose[i] = (double)checked[i];
    json_decref(rows);
    return ok;
}

void ffp_pose_product(const double a[16], const double b[16], double out[16]) {
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            double sum = 0;
            for (int k = 0; k < 4; k++) sum += a[4 * i + k] * b[4 * k + j];
            out[4 * i + j] = sum;
        }
    }
}

void ffp_pose_inverse(const double a[16], double out[16]) {
    for (int i = 0; i < 3; i++) {
        out[4 * i + 3] = 0;
        for (int j = 0; j < 3; j++) {
            out[4 * i + j] = a[4 * j + i];
            out[4 * i + 3] -= a[4 * j + i] * a[4 * j + 3];
        }
    }
    for (int j = 0; j < 4; j++) out[12 + j] = j == 3;
}
