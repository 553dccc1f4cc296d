# Atlases as R sees them: paths and names of times in turns; one fact a line.
library(ncdf4)
words <- commandArgs(TRUE)
for (i in seq(1, length(words), 2)) {
  file <- nc_open(words[i])
  time <- ncvar_get(file, words[i + 1])
  cat("shape", rev(dim(time)), "\n") # R counts the dimensions from the fastest
  cat("units", ncatt_get(file, words[i + 1], "units")$value, "\n")
  cat("known", sum(!is.na(time)), "\n")
  cat("mean", format(mean(time, na.rm = TRUE), digits = 17), "\n")
  cat("meanings", ncatt_get(file, "ending", "flag_meanings")$value, "\n")
  cat("flags", ncatt_get(file, "ending", "flag_values")$value, "\n")
  cat("criterion", ncatt_get(file, 0, "criterion")$value, "\n")
}
