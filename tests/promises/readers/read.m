% Atlases as Octave sees them: paths and names of times in turns; one fact a line.
pkg load netcdf
for i = 1:2:numel(argv())
  path = argv(){i};
  name = argv(){i + 1};
  ncinfo(path); % of the whole file: it fails where the file holds a type that it does not know
  time = ncread(path, name);
  known = !isnan(time);
  shape = fliplr(size(time)); % Octave counts the dimensions from the fastest, and has two at least
  printf("shape %s\n", num2str(shape(1 + isvector(time):end)));
  printf("units %s\n", ncreadatt(path, name, "units"));
  printf("known %d\n", sum(known(:)));
  printf("mean %.17g\n", mean(time(known)));
  printf("meanings %s\n", ncreadatt(path, "ending", "flag_meanings"));
  printf("flags %s\n", num2str(double(ncreadatt(path, "ending", "flag_values")(:)')));
  printf("criterion %s\n", ncreadatt(path, "/", "criterion"));
end
