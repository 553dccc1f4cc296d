# The atlas as R sees it: one fact a line.
library(ncdf4)
file <- nc_open(commandArgs(TRUE)[1])
name <- commandArgs(TRUE)[2]
time <- ncvar_get(file, name)
cat("shape", rev(dim(time)), "\n") # R counts the dimensions from the fastest
cat("units", ncatt_get(file, name, "units")$value, "\n")
cat("known", sum(!is.na(time)), "\n")
cat("mean", format(mean(time, na.rm = TRUE), digits = 17), "\n")
cat("meanings", ncatt_get(file, "ending", "flag_meanings")$value, "\n")
cat("flags", ncatt_get(file, "ending", "flag_values")$value, "\n")
cat("criterion", ncatt_get(file, 0, "criterion")$value, "\n")
