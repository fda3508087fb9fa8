//! `efam sweep`: the same rows whoever runs them, and nothing lost whatever is killed.
//!
//! Goal: shards and table are functions of the plan; a point that cannot be simulated is a row; what does not belong
//! together is refused, and what is wrong is said before anything is written.
//! Setup: releases of a second on eight nodes, two shards or more.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::bench::Bench;

/// A bench with a scenario and a sweep over it.
pub fn bench(name: &str) -> Bench {
    let bench = Bench::new(name);
    bench.file(
        "s.toml",
        "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n[rod]\nnodes = 8\n\
         [run]\nduration = \"1.5 s\"\n[effects.rayleigh_mass]\nalpha = \"1 1/s\"\n\
         [effects.rayleigh_stiffness]\nbeta = \"5 ms\"\n",
    );
    bench.file("sweep.toml", &sweep("latin_hypercube", "points = 20\nseed = 3\n"));
    bench
}

fn sweep(design: &str, more: &str) -> String {
    format!(
        "[sweep]\nscenario = \"s.toml\"\ndesign = \"{design}\"\n{more}\
         [[sweep.parameter]]\npath = \"muscle.pressure\"\nrange = [\"10 psi\", \"90 psi\"]\n\
         [[sweep.parameter]]\npath = \"effects.rayleigh_mass.alpha\"\nrange = [\"0.5 1/s\", \"5 1/s\"]\n\
         scale = \"logarithmic\"\n"
    )
}

/// Plans the sweep of [`bench`] in shards of four, in a folder.
pub fn plan(bench: &Bench, out: &str) {
    bench.json(&["sweep", "plan", "sweep.toml", "--points-per-shard", "4", "--json", "--out", out]);
}

/// The plan of a folder in another.
pub fn copied(bench: &Bench, from: &str, to: &str) {
    fs::create_dir(bench.0.join(to)).expect("a new folder");
    for file in ["plan.json", "points.csv"] {
        fs::copy(bench.0.join(from).join(file), bench.0.join(to).join(file)).expect("a plan");
    }
}

pub fn bytes(bench: &Bench, file: &str) -> Vec<u8> {
    fs::read(bench.0.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// Lines of a CSV file, cell by cell; none of these tests has commas in its texts.
fn rows(text: &str) -> Vec<Vec<String>> {
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn rows_are_the_same_whoever_runs_them() {
    let bench = bench("sweep-same");
    let shards = ["--points-per-shard", "4", "--csv", "--json", "--out", "whole"];
    let whole = bench.json(&[&["sweep", "sweep.toml"], &shards[..]].concat());
    assert_eq!((&whole["sweep"]["points"], &whole["sweep"]["failed"]), (&20.into(), &0.into()));
    // Task by task, the last first, on one thread, numbered by different schedulers.
    copied(&bench, "whole", "tasks");
    let tasks = [
        ("SLURM_ARRAY_TASK_ID", "4"),
        ("PBS_ARRAY_INDEX", "3"),
        ("SGE_TASK_ID", "3"),
        ("AWS_BATCH_JOB_ARRAY_INDEX", "1"),
    ];
    for (name, place) in tasks {
        let mut command = bench.command(&["sweep", "run", "--plan", "tasks", "-q"]);
        // Of a member that is handed in alone Slurm says that it is one of one.
        command.env(name, place).env("SLURM_ARRAY_TASK_COUNT", "1").env("RAYON_NUM_THREADS", "1");
        assert!(command.status().expect("efam runs").success());
    }
    let ran = bench.json(&["sweep", "run", "--plan", "tasks/plan.json", "--shard", "0", "--json"]);
    assert_eq!(ran["run"], serde_json::json!([0]));
    let again = bench.json(&["sweep", "run", "--plan", "tasks", "--json"]);
    assert_eq!((&again["run"], &again["skipped"]), (&serde_json::json!([]), &5.into()));
    bench.json(&["sweep", "merge", "--plan", "tasks", "--json"]);
    let parts = (0..5).map(|shard| format!("shard={shard:05}/part.parquet"));
    for file in parts.chain(["sweep.parquet".to_owned()]) {
        let [a, b] = ["whole", "tasks"].map(|folder| bytes(&bench, &format!("{folder}/{file}")));
        assert!(a == b, "{file}");
    }
    // Other shards are another plan, and the same rows.
    let more = ["--points-per-shard", "7", "--csv", "--json", "--out", "other"];
    bench.json(&[&["sweep", "sweep.toml"], &more[..]].concat());
    assert_eq!(bench.text("other/sweep.csv"), bench.text("whole/sweep.csv"));
    // And the same command again finds all done.
    bench.json(&[&["sweep", "sweep.toml"], &shards[..]].concat());
    let (code, _, stderr) = bench.run(&[&["sweep", "sweep.toml"], &more[..4], &["--out", "whole"]].concat());
    assert!(code == 2 && stderr.contains("whole: holds the sweep of another plan"), "{stderr}");
}

/// A row says what `efam simulate` says of its values, and the page what the table says.
#[test]
fn a_row_is_a_run() {
    let bench = bench("sweep-run");
    let value = bench.json(&["sweep", "sweep.toml", "--csv", "--json", "--out", "out"]);
    let table = rows(&bench.text("out/sweep.csv"));
    let (names, row) = (&table[0], &table[8]);
    let cell =
        |name: &str| &row[names.iter().position(|own| own == name).unwrap_or_else(|| panic!("{name}"))];
    assert_eq!((cell("point").as_str(), cell("status").as_str()), ("7", "ok"));
    let pressure = format!("{} Pa", cell("muscle_pressure_pa"));
    let alpha = format!("effects.rayleigh_mass.alpha=\"{} 1/s\"", cell("effects_rayleigh_mass_alpha_1_s"));
    let run = ["simulate", "s.toml", "--pressure", &pressure, "--set", &alpha, "--json", "--out", "run"];
    let run = &bench.json(&[&run[..], &["--no-error-estimate"]].concat())["runs"][0];
    for (column, entry) in [
        ("rest_z_m", &run["rest"]["tip_z_m"]),
        ("peak_speed_m_s", &run["peak_speed"]["speed_m_s"]),
        ("small_damping_ratio", &run["modes"][0]["damping_ratio"]),
        ("dissipated_j", &run["energy"]["dissipated_J"]),
        ("steps", &run["effort"]["steps"]),
    ] {
        let own: f64 = cell(column).parse().expect("a number");
        assert!((own / number(entry) - 1.0).abs() < 1e-15, "{column}: {own} {entry}");
    }
    assert!(bench.text("out/sweep.csv").contains("settling_2_percent_s: "), "why numbers are missing");
    let page = bench.text("out/report.html");
    assert!(
        page.contains("20 points of a latin hypercube over muscle.pressure, effects.rayleigh_mass.alpha")
    );
    for picture in ["over-muscle_pressure_pa", "over-effects_rayleigh_mass_alpha_1_s"] {
        let svg = bench.picture(&format!("out/{picture}.svg"));
        assert!(page.contains(&svg), "{picture}");
    }
    let spreads = value["sweep"]["parameters"].as_array().expect("rows");
    assert!(number(&spreads[0]["least"]) >= 68_947.0 && number(&spreads[0]["greatest"]) <= 620_529.0);
    assert_eq!(bench.text("out/summary.json").matches("\"kind\": \"sweep\"").count(), 1);
}

/// The air drag of the catalogue and the same law as text give the same rows over its coefficient.
#[test]
fn a_parameter_of_a_law_as_text_varies() {
    let bench = bench("sweep-law");
    let law = "[effects.my_drag]\nc = \"0.6 kg/m^3\"\n[laws.my_drag]\nplace = \"flow\"\n\
        force = \"-c * v_n * abs(v_n) * diameter\"\n\
        parameters.c = { unit = \"kg/m^3\", default = 0.6, range = [0, 10] }\n";
    bench.file("law.toml", &format!("{}{law}", bench.text("s.toml")));
    let sweep = |scenario: &str, path: &str, values: &str| {
        format!(
            "[sweep]\nscenario = \"{scenario}\"\ndesign = \"grid\"\n\
             [[sweep.parameter]]\npath = \"{path}\"\nvalues = [{values}]\n"
        )
    };
    let c = "\"0 kg/m^3\", \"1.2 kg/m^3\", \"6000 g/m^3\"";
    bench.file("text.toml", &sweep("law.toml", "effects.my_drag.c", c));
    // Half the density of air times the coefficient.
    let coefficients = "\"0\", \"2\", \"10\"";
    bench.file("own.toml", &sweep("s.toml", "effects.air_drag.drag_coefficient", coefficients));
    bench.json(&["sweep", "plan", "text.toml", "--points-per-shard", "1", "--json", "--out", "text"]);
    bench.json(&["sweep", "run", "--plan", "text", "--json"]);
    bench.json(&["sweep", "merge", "--plan", "text", "--csv", "--json"]);
    bench.json(&["sweep", "own.toml", "--csv", "--json", "--out", "own"]);
    let [text, own] = ["text", "own"].map(|name| rows(&bench.text(&format!("{name}/sweep.csv"))));
    assert_eq!(text[0][2], "effects_my_drag_c_kg_m3");
    let column = |table: &[Vec<String>], name: &str| -> Vec<f64> {
        let k = table[0].iter().position(|own| own == name).unwrap_or_else(|| panic!("{name}"));
        table[1..].iter().map(|row| row[k].parse().expect("a number")).collect()
    };
    assert_eq!(column(&text, "effects_my_drag_c_kg_m3"), [0.0, 1.2, 6.0]);
    for name in ["lowest_z_m", "peak_speed_m_s"] {
        let [text, own] = [&text, &own].map(|table| column(table, name));
        assert!(
            text.iter().zip(&own).all(|(a, b)| (a - b).abs() < 1e-6 * b.abs()),
            "{name}: {text:?} {own:?}"
        );
        assert!((text[2] - text[0]).abs() > 1e-4 * text[0].abs(), "{name}: {text:?}");
    }
    bench.file("wrong.toml", &sweep("law.toml", "effects.my_drag.d", c));
    let (code, _, stderr) = bench.run(&["sweep", "wrong.toml", "--out", "wrong"]);
    assert_eq!(code, 2);
    assert!(stderr.contains("did you mean `effects.my_drag.c`"), "{stderr}");
}

#[test]
fn a_point_that_cannot_be_simulated_is_a_row() {
    let bench = bench("sweep-failed");
    bench.file(
        "sweep.toml",
        "[sweep]\nscenario = \"s.toml\"\ndesign = \"grid\"\n\
         [[sweep.parameter]]\npath = \"muscle.pressure\"\nvalues = [\"15 psi\", \"400 psi\", \"40 psi\"]\n\
         [[sweep.parameter]]\npath = \"rod.scheme\"\nvalues = [\"consistent\", \"paper\"]\n",
    );
    let value = bench.json(&["sweep", "sweep.toml", "--json", "--csv", "--out", "out"]);
    let sweep = &value["sweep"];
    assert_eq!((&sweep["points"], &sweep["failed"]), (&6.into(), &2.into()));
    let reason = &sweep["reasons"][0];
    assert_eq!((&reason["points"], &reason["first"]), (&2.into(), &2.into()));
    assert!(reason["reason"].as_str().is_some_and(|words| words.contains("muscle.pressure")), "{reason}");
    assert!(sweep["warnings"][0].as_str().is_some_and(|words| words.starts_with("2 of 6 points could not")));
    let text = bench.text("out/sweep.csv");
    let statuses: Vec<&str> =
        text.lines().skip(1).map(|line| line.split(',').nth(4).expect("a cell")).collect();
    assert_eq!(statuses, ["ok", "ok", "failed", "failed", "ok", "ok"]);
    let roots: Vec<&str> = text.lines().skip(1).map(|line| line.split(',').nth(3).expect("a cell")).collect();
    assert_eq!(roots[..2], ["consistent", "paper"]);
    let is_there = |picture: &str| bench.0.join("out").join(picture).is_file();
    assert!(is_there("over-muscle_pressure_pa.svg") && !is_there("maps.svg"), "words are on no axis");
}

#[test]
fn what_is_missing_is_said_as_slurm_takes_it() {
    let bench = bench("sweep-missing");
    plan(&bench, "out");
    let (_, stdout, _) = bench.run(&["sweep", "status", "--plan", "out", "-q"]);
    assert_eq!(stdout, "--array=0-4\n");
    bench.json(&["sweep", "run", "--plan", "out", "--json"]);
    let whole: Vec<_> =
        (0..5).map(|shard| bytes(&bench, &format!("out/shard={shard:05}/part.parquet"))).collect();
    for shard in [1, 3] {
        fs::remove_dir_all(bench.0.join(format!("out/shard={shard:05}"))).expect("a shard");
    }
    // Half of a file is none; what a killed task leaves beside it does no harm.
    fs::write(bench.0.join("out/shard=00004/part.parquet"), &whole[4][..whole[4].len() / 2])
        .expect("written");
    fs::write(bench.0.join("out/shard=00000/.part.parquet.partial-node7-1-2"), "half").expect("written");
    let (code, stdout, stderr) = bench.run(&["sweep", "status", "--plan", "out"]);
    assert_eq!(code, 0);
    assert!(
        stdout.contains("2 of 5 shards, 8 of 20 points") && stdout.ends_with("missing: --array=1,3-4\n"),
        "{stdout}"
    );
    assert!(stderr.contains("shard=00004/part.parquet: cannot be read ("), "{stderr}");
    let (code, stdout, stderr) = bench.run(&["sweep", "merge", "--plan", "out"]);
    assert_eq!((code, stdout.as_str()), (3, ""), "{stderr}");
    fs::remove_file(bench.0.join("out/shard=00004/part.parquet")).expect("a file");
    let (code, _, stderr) = bench.run(&["sweep", "merge", "--plan", "out"]);
    assert!(
        code == 3 && stderr.contains("3 of 5 shards are missing: --array=1,3-4; run them first"),
        "{stderr}"
    );
    assert!(!bench.0.join("out/sweep.parquet").exists());
    let ran = bench.json(&["sweep", "run", "--plan", "out", "--json"]);
    assert_eq!((&ran["run"], &ran["skipped"]), (&serde_json::json!([1, 3, 4]), &2.into()));
    bench.json(&["sweep", "merge", "--plan", "out", "--json"]);
    for (shard, whole) in whole.iter().enumerate() {
        assert!(bytes(&bench, &format!("out/shard={shard:05}/part.parquet")) == *whole, "{shard}");
    }
    assert!(!bench.0.join("out/shard=00000/.part.parquet.partial-node7-1-2").exists());
    let (_, stdout, _) = bench.run(&["sweep", "status", "--plan", "out"]);
    assert!(stdout.ends_with("merged: out/sweep.parquet\n"), "{stdout}");
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let bench = bench("sweep-refused");
    plan(&bench, "out");
    let says = |arguments: &[&str], code: i32, expected: &str| {
        let (own, stdout, stderr) = bench.run(&[&["sweep"], arguments].concat());
        assert_eq!((own, stdout.as_str()), (code, ""), "{arguments:?}: {stderr}");
        assert!(stderr.contains(expected), "{arguments:?}\n{stderr}");
    };
    // The shard of another plan is kept, unless it may go.
    bench.json(&["sweep", "run", "--plan", "out", "--shard", "2", "--json"]);
    let set = ["--set", "sweep.seed=4", "--points-per-shard", "4", "--json", "--out", "other"];
    bench.json(&[&["sweep", "plan", "sweep.toml"], &set[..]].concat());
    fs::create_dir(bench.0.join("other/shard=00002")).expect("a folder");
    let part = "shard=00002/part.parquet";
    fs::copy(bench.0.join("out").join(part), bench.0.join("other").join(part)).expect("a shard");
    says(&["run", "--plan", "other"], 2, "other/shard=00002/part.parquet: belongs to another plan (");
    assert_eq!(
        bytes(&bench, "other/shard=00002/part.parquet"),
        bytes(&bench, "out/shard=00002/part.parquet")
    );
    let ran = bench.json(&["sweep", "run", "--plan", "other", "--shard", "2", "--overwrite", "--json"]);
    assert_eq!(ran["run"], serde_json::json!([2]));
    // A shard under another number, too.
    fs::create_dir(bench.0.join("out/shard=00003")).expect("a folder");
    fs::copy(bench.0.join("out").join(part), bench.0.join("out/shard=00003/part.parquet")).expect("a shard");
    says(&["run", "--plan", "out", "--shard", "3"], 2, "belongs to another plan");
    says(
        &["run", "--plan", "out", "--shard", "5"],
        2,
        "shard 5: the plan has 5, 0 to 4; ask for one of these",
    );
    says(&["run", "--plan", "nowhere"], 3, "nowhere/plan.json: cannot be read (");
    let points = bench.text("out/points.csv");
    bench.file("out/points.csv", &points.replacen("\n3,", "\n3,1", 1));
    says(&["run", "--plan", "out"], 3, "out/points.csv: was altered since the plan was made");
    bench.file("out/points.csv", &points);
    let head = bench.text("out/plan.json");
    bench.file("out/plan.json", &head.replacen("\"points_per_shard\": 4", "\"points_per_shard\": 5", 1));
    says(&["status", "--plan", "out"], 3, "out/plan.json: was altered since the plan was made");
    bench.file("out/plan.json", "{}");
    says(&["merge", "--plan", "out"], 3, "out/plan.json: was altered");
    let mut command = bench.command(&["sweep", "run", "--plan", "other"]);
    let output = command.env("SGE_TASK_ID", "0").output().expect("efam runs");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("SGE_TASK_ID = 0: must be a number from 1 on"));
}

#[test]
fn what_is_wrong_with_a_sweep_is_said_and_nothing_is_written() {
    let bench = bench("sweep-wrong");
    let before = bench.left();
    let grid = sweep("grid", "").replace("\"]\n", "\"]\nsteps = 3\n");
    let says = |text: &str, expected: &str| {
        bench.file("sweep.toml", text);
        for command in [&["sweep", "sweep.toml", "--out", "out"][..], &["sweep", "plan", "sweep.toml"]] {
            let (code, stdout, stderr) = bench.run(command);
            assert_eq!((code, stdout.as_str()), (2, ""), "{text}\n{stderr}");
            assert!(stderr.contains(expected), "{text}\n{stderr}");
            assert_eq!(bench.left(), before, "{text}: leaves something behind");
        }
    };
    let sobol = |points: &str| sweep("sobol", points);
    says("", "sweep: is missing; write [sweep]");
    says("[sweep]\n", "sweep.scenario: is missing; write scenario = \"release-15psi.toml\", or experiments");
    says("[sweep]\nscenario = \"s.toml\"\n", "sweep.design: is missing");
    says("[sweep]\nscenario = \"absent.toml\"\ndesign = \"grid\"\n", "absent.toml: cannot be read (");
    says("[sweep]\nscenario = \"s.toml\"\ndesign = \"grid\"\n", "sweep.parameter: is missing");
    says(&sobol(""), "sweep.points: is missing; write points = 256");
    says(&sobol("points = 65537\n"), "sweep.points = 65537: must lie in 1..=65536");
    says(&sobol("points = 0\n"), "must lie in 1..=65536");
    says(
        &sobol("points = 4\n").replace("muscle.pressure", "muscle.presure"),
        "did you mean `muscle.pressure`?",
    );
    says(
        &sobol("points = 4\n").replace("10 psi", "10 mm"),
        "sweep.parameter[1].range: \"10 mm\" is a length",
    );
    says(&sobol("points = 4\n").replace("0.5 1/s", "0 1/s"), "be two positive values, the lower one first");
    says(&sobol("points = 4\n").replace("10 psi", "99 psi"), "must be two values, the lower one first");
    says(&sobol("points = 4\n").replace("sobol", "sobl"), "did you mean `sobol`?");
    says(&sobol("points = 4\nsed = 1\n"), "sweep.sed: unknown key; did you mean `seed`?");
    says(&sweep("grid", ""), "sweep.parameter[1].steps: is missing; write steps = 11");
    says(
        &grid.replace("= \"grid\"\n", "= \"grid\"\npoints = 3\n"),
        "a grid has as many points as its values give",
    );
    says(&grid.replace("steps = 3", "steps = 1"), "must lie in 2..=1000000");
    says(
        &sweep("sobol", "points = 4\n").replace("\"]\n", "\"]\nsteps = 3\n"),
        "belongs to a range in a grid",
    );
    let twice = grid.replace("effects.rayleigh_mass.alpha", "muscle.pressure");
    says(&twice.replace("0.5 1/s", "20 psi").replace("5 1/s", "50 psi"), "is varied already");
    says(&sweep("posterior", "points = 4\n"), "has no [calibration] to draw from");
    bench.file("s.toml", "[rod]\nnodes = 8\n");
    says(&sobol("points = 4\n"), "muscle.name: is missing");
}

/// Errors of a calibration that are known come out of the draws.
#[test]
fn a_posterior_is_drawn_from_the_calibration() {
    let bench = bench("sweep-posterior");
    let muscle = include_str!("../../../models/muscles/garbulinski-2022.toml");
    let parameter = "[[calibration.parameter]]\npath = \"rod.bending_stiffness\"\npressure_pa = 103421.3\n\
                     value = 0.00709\nstandard_error = 7e-5\ncorrelations = [1.0]\n";
    let known = "releases = 2\npressure_pa = [1e5, 1.1e5]\npayload_kg = [0.0, 0.0]\nexcursion_m = 0.2\n";
    bench.file("known.toml", &format!("{muscle}\n[calibration]\n{known}{parameter}"));
    let scenario = bench.text("s.toml").replace("name = \"garbulinski-2022\"", "file = \"known.toml\"");
    bench.file("s.toml", &scenario.replace("1.5 s", "0.1 s"));
    bench.file("sweep.toml", "[sweep]\nscenario = \"s.toml\"\ndesign = \"posterior\"\npoints = 400\n");
    let value = bench.json(&["sweep", "plan", "sweep.toml", "--json", "--out", "out"]);
    assert_eq!(value["plan"]["work"]["simulate"]["parameters"], serde_json::json!(["rod.bending_stiffness"]));
    let warning = value["plan"]["warnings"][0].as_str().expect("a warning");
    assert!(warning.starts_with("the calibration removed the error of its mesh"), "{warning}");
    let points = rows(&bench.text("out/points.csv"));
    let drawn: Vec<f64> = points[1..].iter().map(|row| row[2].parse().expect("a number")).collect();
    let mean = drawn.iter().sum::<f64>() / 400.0;
    let deviation = (drawn.iter().map(|own| (own - mean).powi(2)).sum::<f64>() / 399.0).sqrt();
    // Of 400 draws the mean is known to a twentieth of the deviation, and that to 3.5 %.
    assert!(
        (mean - 0.00709).abs() < 4.0 * 7e-5 / 20.0 && (deviation / 7e-5 - 1.0).abs() < 0.15,
        "{mean} {deviation}"
    );
    // The plan needs the muscle's file no longer.
    fs::remove_file(bench.0.join("known.toml")).expect("a file");
    fs::remove_file(bench.0.join("s.toml")).expect("a file");
    bench.json(&["sweep", "run", "--plan", "out", "--json"]);
    let merged = bench.json(&["sweep", "merge", "--plan", "out", "--json"]);
    assert_eq!(merged["sweep"]["failed"], 0, "{merged}");
}

/// A scheduler that notes what it is handed.
#[cfg(unix)]
#[test]
fn an_array_and_its_merge_are_handed_in() {
    use std::os::unix::fs::PermissionsExt;
    let bench = bench("sweep-submit");
    plan(&bench, "out");
    bench.json(&["sweep", "run", "--plan", "out", "--shard", "1", "--json"]);
    let submit = |path: &Path, more: &[&str]| {
        let mut command = bench.command(&[&["sweep", "submit", "--plan", "out"], more].concat());
        let output = command.env("PATH", path).output().expect("efam runs");
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        (output.status.code(), text(output.stdout), text(output.stderr))
    };
    let (code, _, stderr) = submit(&bench.0, &[]);
    assert!(code == Some(1) && stderr.contains("sbatch: cannot be started ("), "{stderr}");
    assert!(stderr.contains("submit it yourself: sbatch --array=0,2-4 "), "{stderr}");
    bench.file("sbatch", "#!/bin/sh\necho \"$@\" >>noted\necho 42\n");
    fs::set_permissions(bench.0.join("sbatch"), PermissionsExt::from_mode(0o755)).expect("it can be run");
    let (code, stdout, stderr) = submit(&bench.0, &["--json", "--", "--partition=short"]);
    assert_eq!(code, Some(0), "{stderr}");
    let printed: Value = serde_json::from_str(&stdout).expect("JSON");
    assert_eq!((&printed["job"], &printed["array"]), (&"42".into(), &"0,2-4".into()));
    let noted = bench.text("noted");
    let lines: Vec<&str> = noted.lines().collect();
    assert!(lines[0].starts_with("--parsable --array=0,2-4 --partition=short /"), "{noted}");
    assert!(lines[1].starts_with("--parsable --dependency=afterany:42 /") && lines[1].ends_with("merge.sh"));
    // What the script says is what a member does.
    let script = bench.0.join("out/array.sh");
    let status = std::process::Command::new("sh").arg(script).env("SLURM_ARRAY_TASK_ID", "3").status();
    assert!(status.expect("sh").success() && bench.0.join("out/shard=00003/part.parquet").is_file());
    let (code, stdout, _) = submit(&bench.0, &["--dry-run"]);
    assert!(code == Some(0) && stdout.starts_with("sbatch --array=0,2,4 /"), "{stdout}");
    assert_eq!(bench.text("noted"), noted, "nothing is handed in");
    bench.file("sbatch", "#!/bin/sh\necho 'no such partition' >&2\nexit 1\n");
    let (code, _, stderr) = submit(&bench.0, &[]);
    assert!(code == Some(1) && stderr.contains("submitted nothing (no such partition)"), "{stderr}");
}
