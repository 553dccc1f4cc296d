/* The atlas as C sees it: one fact a line. Build: cc read.c $(nc-config --cflags --libs) */
#include <netcdf.h>
#include <stdio.h>

int main(int argc, char **argv) {
    int file, time, ending, i, n = 0, ndims, dims[NC_MAX_VAR_DIMS];
    size_t cells = 1, count, length;
    static double values[10000], fill, sum;
    static char units[100], meanings[1000], criterion[100];
    static signed char flags[20];
    if (argc != 3 || nc_open(argv[1], NC_NOWRITE, &file)) return 1;
    if (nc_inq_varid(file, argv[2], &time) || nc_inq_varid(file, "ending", &ending)) return 2;
    if (nc_inq_varndims(file, time, &ndims) || nc_inq_vardimid(file, time, dims)) return 3;
    if (nc_get_var_double(file, time, values)) return 4;
    if (nc_get_att_text(file, time, "units", units) || nc_get_att_double(file, time, "_FillValue", &fill)) return 5;
    if (nc_get_att_text(file, ending, "flag_meanings", meanings)) return 6;
    if (nc_inq_attlen(file, ending, "flag_values", &length) || nc_get_att_schar(file, ending, "flag_values", flags)) return 7;
    if (nc_get_att_text(file, NC_GLOBAL, "criterion", criterion)) return 8;
    printf("shape");
    for (i = 0; i < ndims; i++) {
        if (nc_inq_dimlen(file, dims[i], &count)) return 9;
        printf(" %d", (int)count);
        cells *= count;
    }
    for (i = 0; i < (int)cells; i++) if (values[i] != fill) { sum += values[i]; n++; }
    printf("\nunits %s\nknown %d\nmean %.17g\nmeanings %s\nflags", units, n, sum / n, meanings);
    for (i = 0; i < (int)length; i++) printf(" %d", flags[i]);
    printf("\ncriterion %s\n", criterion);
    return nc_close(file);
}
