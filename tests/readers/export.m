% Reads run.mat as MATLAB would, and holds it against the run's own CSV.
run = load("run.mat");
rows = csvread("run/trajectory.csv", 1, 0);
names = strsplit(fgetl(fopen("run/trajectory.csv")), ",");
column = @(name) rows(:, strcmp(names, name));
for name = {"time_s", "tip_x_m", "tip_z_m", "total_J"}
  own = run.trajectory.(name{1});
  assert(own, column(name{1}), 1e-14);
end
assert(size(run.trajectory.z_m), [rows(end, 1) * 100 + 1, 32]);
assert(run.trajectory.z_m(:, 32), column("z_31_m"), 1e-14);
% Octave takes text of this format for numbers; MATLAB does not.
assert(char(run.unit.trajectory.tip_vx_m_s(:)'), "m/s");
summary = jsondecode(char(run.about.summary_json(:)'));
assert(summary.samples, rows(end, 1) * 100 + 1);
older = load("run5.mat");
assert(older.trajectory.z_m, run.trajectory.z_m);
assert(older.unit.trajectory.tip_vx_m_s, "m/s");
assert(jsondecode(older.about.summary_json).samples, summary.samples);
printf("Octave %s: %d samples of %d nodes\n", version(), size(run.trajectory.z_m));
