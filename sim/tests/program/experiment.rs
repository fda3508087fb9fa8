//! From recordings to releases and numbers, by the program itself.
//!
//! Goal: `experiment init`, `check` and `analyse` on recordings of others, read where they lie, and on
//! made-up ones of the paper's kind. Expected values of the silicone beam are those that its own
//! description states; where the recordings are not there, the test says so and passes.

use serde_json::Value;

use crate::bench::{Bench, Noise, recordings};

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// What is published of the beam; axial stiffness is E times the section.
const BEAM: &str = "[rod]\nlength = \"100 mm\"\nmass = \"96.3 g\"\nbending_stiffness = \"0.03 N m^2\"\n\
    axial_stiffness = \"237 N\"\n[effects.gravity]\nacceleration = \"9.80709 m/s^2\"\n";

#[test]
fn the_silicone_beam_has_its_published_numbers() {
    for name in ["gravity.c3d", "gravity_clamp_frame.csv"] {
        let Some(file) = recordings(&format!("silicone_beam/{name}")) else { return };
        let bench = Bench::new(&name.replace('.', "-"));
        let (code, _, stderr) = bench.run(&["experiment", "init", &file.to_string_lossy()]);
        assert_eq!(code, 0, "{stderr}");
        let draft = bench.text("experiment.toml");
        bench.file(
            "experiment.toml",
            &draft.replacen("\n[[recording]]", &format!("\n{BEAM}\n[[recording]]"), 1),
        );
        let value = bench.json(&["analyse", "experiment.toml", "--json", "--out", "out"]);
        let (release, analysis) = (&value["releases"][0], &value["analysis"][0]);
        assert_eq!(value["releases"].as_array().map(Vec::len), Some(1), "one release in {name}");
        let near = |value: &Value, expected: f64, within: f64| {
            let found = number(value);
            assert!((found - expected).abs() < within, "{name}: {found} for {expected} within {within}");
        };
        // "Near 0.71 s": a sample.
        near(&release["instant_s"], 0.71, 0.01);
        // The rest creeps by half a millimetre; its mean of the last second is within a tenth of that.
        near(&release["statistics"]["static_drop"], 6.4e-3, 0.1e-3);
        // Stated to three digits.
        near(&analysis["damped_frequency_hz"], 7.75, 0.02);
        // "Near 0.05", and not constant over the swing.
        near(&analysis["damping_ratio"], 0.05, 0.005);
        // Its EI comes from another fit, on other data of the same beam.
        near(&analysis["dynamic_stiffness"]["bending_stiffness_n_m2"], 0.01781, 0.05 * 0.01781);
        near(&release["statistics"]["noise"], 2.5e-6, 2e-6);
        // Both searches minimise the same.
        for row in analysis["static_stiffness"].as_array().expect("rows") {
            let ei = |search: &str| number(&row[search]["bending_stiffness_n_m2"]);
            assert!((ei("nelder_mead") / ei("gauss_newton") - 1.0).abs() < 1e-5, "{row}");
        }
        for file in
            ["summary.json", &format!("{name}.svg"), &format!("{name}-1.csv"), &format!("{name}-1.svg")]
        {
            assert!(bench.0.join("out").join(file).is_file(), "{file}");
        }
    }
}

#[test]
fn the_trunk_has_frequency_and_decay_and_no_stiffness() {
    let Some(folder) = recordings("trunk") else { return };
    let bench = Bench::new("trunk");
    let files: Vec<String> = (0..3)
        .map(|k| folder.join(format!("manual_decay_300g_id0{k}.csv")).to_string_lossy().into_owned())
        .collect();
    let arguments: Vec<&str> =
        ["experiment", "init"].into_iter().chain(files.iter().map(String::as_str)).collect();
    assert_eq!(bench.run(&arguments).0, 0);
    let value = bench.json(&["analyse", "experiment.toml", "--json", "--out", "out"]);
    assert_eq!(value["releases"].as_array().map(Vec::len), Some(3));
    for analysis in value["analysis"].as_array().expect("rows") {
        // It hangs, and swings level at some 2 Hz when the swing is small; the first swing is slower.
        let [x, z] = [0, 1].map(|i| number(&analysis["coordinate"]["direction"][i]));
        assert!(x.abs() > 0.99 && z.abs() < 0.1, "{analysis}");
        let hz = number(&analysis["damped_frequency_hz"]);
        assert!((1.2..2.6).contains(&hz), "{analysis}");
        assert!((0.01..0.3).contains(&number(&analysis["damping_ratio"])), "{analysis}");
        assert_eq!(analysis["dynamic_stiffness"], Value::Null);
        assert_eq!(analysis["static_stiffness"].as_array().map(Vec::len), Some(0));
    }
    for release in value["releases"].as_array().expect("rows") {
        // Pulled aside in a hand, and let go near half a second.
        assert!((0.35..0.65).contains(&number(&release["instant_s"])), "{release}");
    }
}

/// Time and place of a tip that is raised and let go `cycles` times, with a marker at the base: level
/// hold at 200 mm, swings of 8 rad/s about 120 mm below.
pub fn made_up(cycles: usize, lost: impl Fn(usize) -> bool, ghost: impl Fn(usize) -> f64) -> String {
    let mut noise = Noise::new(1);
    let mut noise = || 2e-4 * noise.normal();
    let mut text = String::from("t_s,Tip_x_m,Tip_y_m,Tip_z_m,Base_x_m,Base_y_m,Base_z_m\n");
    for i in 0..1200 * cycles {
        let time = 0.01 * i as f64;
        let t = time % 12.0;
        let u = if t < 1.0 {
            1.0
        } else if t < 2.4 {
            0.5 + 0.5 * (std::f64::consts::PI * (t - 1.0) / 1.4).cos()
        } else if t < INSTANT {
            0.0
        } else {
            let t = t - INSTANT;
            1.0 - (-0.4 * t).exp() * ((8.0 * t).cos() + 0.05 * (8.0 * t).sin())
        };
        let [x, y, z] = [1.2 - 0.05 * u * u + noise(), 0.3 + 0.003 * u + noise(), 0.5 - 0.12 * u + noise()];
        let tip = if lost(i) { ",,".to_owned() } else { format!("{x},{y},{}", z + ghost(i)) };
        text += &format!("{time:.2},{tip},{},{},{}\n", 1.0 + noise(), 0.3 + noise(), 0.5 + noise());
    }
    text
}

const INSTANT: f64 = 3.2043;

#[test]
fn six_noisy_cycles_with_ghosts_and_dropouts_become_six_releases() {
    let bench = Bench::new("six");
    let lost = |i: usize| (i / 20) % 33 == 7 && i % 20 < 15;
    let ghost = |i: usize| match i % 331 {
        17 => 0.15,
        200 => -0.04,
        _ if (2500..2506).contains(&i) => 0.1,
        _ => 0.0,
    };
    bench.file("15psi.csv", &made_up(6, lost, ghost));
    assert_eq!(bench.run(&["experiment", "init", "15psi.csv"]).0, 0);
    let draft = bench.text("experiment.toml");
    for line in ["file = \"15psi.csv\"", "tip = \"Tip\"", "base = \"Base\"", "pressure = \"15 psi\""] {
        assert!(draft.contains(line), "{line} in\n{draft}");
    }
    let value = bench.json(&["analyse", "experiment.toml", "--json", "--out", "out"]);
    let releases = value["releases"].as_array().expect("rows");
    assert_eq!(releases.len(), 6);
    for (k, release) in releases.iter().enumerate() {
        let expected = INSTANT + 12.0 * k as f64;
        let (instant, error) = (number(&release["instant_s"]), number(&release["instant_error_s"]));
        // A third of a sample, under noise of a fifth of a millimetre; three standard errors.
        assert!(
            (instant - expected).abs() < f64::max(0.0035, 3.0 * error),
            "{instant} ± {error} for {expected}"
        );
        let statistics = &release["statistics"];
        assert!((number(&statistics["static_drop"]) - 0.12).abs() < 5e-4, "{statistics}");
        assert!((number(&statistics["noise"]) / 2e-4 - 1.0).abs() < 0.15, "{statistics}");
        assert!(number(&statistics["masked_share"]) < 0.06, "{statistics}");
        // Three millimetres sideways at rest: the swing shows a plane that leans by 0.03 rad, which the rest, 150 mm from the
        // clamp, leaves by 7.5 mm, and the sway about it is of the second order.
        assert!((number(&statistics["out_of_plane"]) - 7.5e-3).abs() < 1e-3, "{statistics}");
        assert!((1e-3..3e-3).contains(&(0.2 * number(&statistics["sway_share"]))), "{statistics}");
    }
    assert_eq!(releases.iter().filter(|release| release["representative"] == true).count(), 1);
    // Every ghost of the swings is masked: a ghost of 40 mm at least would show.
    for number in 1..=6 {
        let text = bench.text(&format!("out/15psi.csv-{number}.csv"));
        let z: Vec<Option<f64>> =
            text.lines().skip(1).map(|line| line.split(',').nth(2)?.parse().ok()).collect();
        for pair in z.windows(2).filter_map(|pair| Some((pair[0]?, pair[1]?))) {
            assert!(
                (pair.1 - pair.0).abs() < 0.03,
                "a jump from {} to {} m in release {number}",
                pair.0,
                pair.1
            );
        }
    }
    for analysis in value["analysis"].as_array().expect("rows") {
        assert!(
            (number(&analysis["damped_frequency_hz"]) / (8.0 / std::f64::consts::TAU) - 1.0).abs() < 2e-3,
            "{analysis}"
        );
        // The tip moves on a curve: along a line, large swings lose less from peak to peak, and small ones as much as in u.
        assert!((number(&analysis["damping_ratio"]) / 0.05 - 1.0).abs() < 0.1, "{analysis}");
        let cycles = analysis["cycles"].as_array().expect("cycles");
        let small: Vec<&Value> = cycles.iter().filter(|cycle| number(&cycle["amplitude_m"]) < 0.02).collect();
        assert!(small.len() > 2, "{} of {} cycles are small", small.len(), cycles.len());
        for cycle in small {
            let [ratio, error] = ["damping_ratio", "damping_ratio_error"].map(|key| number(&cycle[key]));
            assert!((ratio - 0.05).abs() < 3.0 * error, "{cycle}");
        }
    }
    // Every decision can be decided otherwise.
    let dropped =
        ["check", "experiment.toml", "--json", "--set", "recording[1].keep=[2, 5]", "--out", "kept"];
    let value = bench.json(&[&["experiment"], &dropped[..]].concat());
    let kept =
        value["releases"].as_array().expect("rows").iter().filter(|release| release["dropped"].is_null());
    assert_eq!(kept.count(), 2);
}

#[test]
fn recordings_of_one_name_in_two_folders_keep_their_files_apart() {
    let bench = Bench::new("one-name");
    for folder in ["a", "b"] {
        std::fs::create_dir(bench.0.join(folder)).expect("the target folder can be written");
        bench.file(&format!("{folder}/x.csv"), &made_up(2, |_| false, |_| 0.0));
    }
    assert_eq!(bench.run(&["experiment", "init", "a/x.csv", "b/x.csv"]).0, 0);
    bench.json(&["analyse", "experiment.toml", "--json", "--out", "out"]);
    let mut expected = ["efam-files.json", "experiment.toml", "pictures", "report.html", "summary.json"]
        .map(str::to_owned)
        .to_vec();
    for name in ["x.csv", "x.csv_2"] {
        let of_releases = ["-1.csv", "-1.svg", "-2.csv", "-2.svg"];
        expected.extend([".svg"].into_iter().chain(of_releases).map(|end| format!("{name}{end}")));
    }
    expected.sort();
    assert_eq!(Bench(bench.0.join("out")).left(), expected);
}

#[test]
fn an_experiment_file_is_never_overwritten_unasked() {
    let bench = Bench::new("overwrite");
    bench.file("a.csv", &made_up(1, |_| false, |_| 0.0));
    bench.file("experiment.toml", "# mine\n");
    let (code, _, stderr) = bench.run(&["experiment", "init", "a.csv"]);
    assert_eq!((code, bench.text("experiment.toml").as_str()), (2, "# mine\n"));
    assert!(stderr.contains("experiment.toml: exists already; choose another --out"), "{stderr}");
    assert_eq!(bench.run(&["experiment", "init", "a.csv", "--overwrite"]).0, 0);
    assert!(bench.text("experiment.toml").contains("[[recording]]"));
}

#[test]
fn what_is_wrong_with_a_recording_is_said() {
    let bench = Bench::new("wrong");
    bench.file("a.csv", &made_up(1, |_| false, |_| 0.0));
    bench.file("lost.csv", &made_up(1, |i| i > 9, |_| 0.0));
    let still: String = (0..300).map(|i| format!("{:.2},0.1,0,0\n", 0.01 * f64::from(i))).collect();
    bench.file("still.csv", &format!("t_s,Tip_x_m,Tip_y_m,Tip_z_m\n{still}"));
    for (recording, code, expected) in [
        (
            "file = \"a.csv\"\ntip = \"Tipp\"",
            2,
            "e.toml:3:7: recording[1].tip = \"Tipp\": a.csv has no marker `Tipp`; did you mean `Tip`?; it has Tip, Base",
        ),
        (
            "file = \"a.csv\"\ntip = \"Tip\"\nbase = [\"Bas\"]",
            2,
            "recording[1].base = [\"Bas\"]: a.csv has no marker `Bas`; did you mean `Base`?",
        ),
        ("file = \"b.csv\"\ntip = \"Tip\"", 2, "e.toml:2:8: recording[1].file: b.csv: cannot be read"),
        (
            "file = \"lost.csv\"\ntip = \"Tip\"",
            3,
            "lost.csv: the tip (Tip) is seen in 10 of 1200 samples; a release needs at least 20",
        ),
        (
            "file = \"still.csv\"\ntip = \"Tip\"",
            3,
            "still.csv: no release in it: the tip moves at 0.0 mm/s at most",
        ),
        ("file = \"a.csv\"\ntip = \"Base\"", 3, "a.csv: no release in it:"),
        (
            "file = \"a.csv\"\ntip = \"Tip\"\nkeep = [3]",
            3,
            "a.csv: recording[1].keep: there is no release 3; 1 were found",
        ),
        (
            "file = \"a.csv\"\ntip = \"Tip\"\ninstants = [\"99 s\"]",
            3,
            "a.csv: recording[1].instants: 99 s is not inside the recording",
        ),
        (
            "file = \"a.csv\"\ntipp = \"Tip\"",
            2,
            "e.toml:3:1: recording[1].tipp: unknown key; did you mean `tip`?",
        ),
        (
            "file = \"a.csv\"\ntip = \"Tip\"\npressure = \"15 mm\"",
            2,
            "recording[1].pressure: \"15 mm\" is a length, but a pressure is due",
        ),
    ] {
        bench.file("e.toml", &format!("[[recording]]\n{recording}\n"));
        let (found, _, stderr) = bench.run(&["experiment", "check", "e.toml", "--out", "out"]);
        assert_eq!(
            (found, stderr.contains(expected)),
            (code, true),
            "expected {expected}\n   found {stderr}"
        );
        assert!(!bench.0.join("out").exists(), "nothing half-written");
    }
}

/// A laser sees one coordinate, from which no EI follows; and a swing of 1.4 Hz, seen 2.5 times in a period, looks like one
/// of 2.1 Hz.
#[test]
fn an_analysis_says_what_one_coordinate_and_few_samples_do_not_show() {
    let bench = Bench::new("analyse-little");
    bench.file("truth.toml", &crate::calibrate::scenario().replace("3 s", "9 s"));
    bench.json(&["simulate", "truth.toml", "--csv", "--json", "--out", "truth"]);
    let run = crate::calibrate::simulated(&bench.text("truth/trajectory.csv"));
    let hold = (0..100).map(|k| [0.01 * f64::from(k), run[0][1], run[0][2]]);
    let all: Vec<[f64; 3]> = hold.chain(run.iter().map(|[t, x, z]| [t + 1.0, *x, *z])).collect();
    let table = |names: &str, every: usize, row: fn(&[f64; 3]) -> String| {
        all.iter().step_by(every).fold(format!("{names}\n"), |text, own| text + &row(own))
    };
    let experiment = "[muscle]\nname = \"garbulinski-2022\"\n[[recording]]\nfile = \"15psi.csv\"\npressure = \"15 psi\"\n\
         tip = \"tip\"\nup = \"+z\"\nalong = \"+x\"\n";
    let said = |text: &str, experiment: &str| {
        bench.file("15psi.csv", text);
        bench.file("e.toml", experiment);
        let (code, stdout, stderr) =
            bench.run(&["analyse", "e.toml", "--nodes", "16", "--out", "out", "--overwrite"]);
        assert_eq!(code, 0, "{stderr}");
        stdout.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let no_rest = "no EI puts the tip where it rests";
    let whole = |[t, x, z]: &[f64; 3]| format!("{t:.4},{x},{z}\n");
    let right = said(&table("t_s,tip_x_m,tip_z_m", 1, whole), experiment);
    assert!(!right.contains(no_rest) && !right.contains("would look the same"), "{right}");
    let laser = said(&table("t_s,tip_z_m", 1, |[t, _, z]| format!("{t:.4},{z}\n")), experiment);
    assert!(laser.contains(no_rest), "{laser}");
    let few =
        said(&table("t_s,tip_x_m,tip_z_m", 29, whole), &format!("{experiment}instants = [\"0.87 s\"]\n"));
    assert!(few.contains("samples in a period") && few.contains("would look the same"), "{few}");
}

/// Six releases of 8 s, three of them 25 degrees down: what is left of the swing is said, and the paper's beam, which is
/// clamped level, is fitted to the level ones alone.
#[test]
fn an_analysis_says_what_has_not_settled_and_where_the_beam_means_nothing() {
    let bench = Bench::new("analyse-settling");
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/diagnosis/nothing/experiment.toml");
    let (code, stdout, stderr) = bench.run(&["analyse", example, "--nodes", "32", "--out", "out"]);
    assert_eq!(code, 0, "{stderr}");
    // Whatever goes on in the next line.
    let said = stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    let count = |words: &str| said.matches(words).count();
    assert_eq!(count("not settled: the tip swings by"), 6, "{stdout}");
    assert_eq!(count("Euler-Bernoulli"), 6, "{stdout}");
    assert_eq!(
        count("not fitted: the paper's beam is clamped level, this base is inclined by -25.0 deg"),
        3,
        "{stdout}"
    );
    let value = bench.json(&["analyse", example, "--nodes", "32", "--out", "out", "--overwrite", "--json"]);
    for analysis in value["analysis"].as_array().expect("rows") {
        let is_level = analysis["name"].as_str().expect("a name").contains("-1.csv");
        let models =
            analysis["static_stiffness"].as_array().expect("rows").iter().map(|row| row["model"].clone());
        assert_eq!(
            models.collect::<Vec<_>>(),
            if is_level { vec!["euler_bernoulli", "pder"] } else { vec!["pder"] }
        );
        assert_eq!(
            (analysis["settled"].as_bool(), analysis["why_no_beam"].is_null()),
            (Some(false), is_level)
        );
        // Both are of one muscle: the tip at rest, and the swing at its own amplitude.
        let rod = analysis["static_stiffness"].as_array().expect("rows").last().expect("a rod").clone();
        let tip = number(&rod["gauss_newton"]["bending_stiffness_n_m2"]);
        let motion = number(&analysis["dynamic_stiffness"]["bending_stiffness_n_m2"]);
        assert!(
            (motion / tip - 1.0).abs() < 0.02,
            "{motion} from the frequency, {tip} from the tip: {analysis}"
        );
    }
    let page = bench.text("out/report.html");
    assert!(page.contains("not settled: the tip swings by") && page.contains("Euler-Bernoulli: not fitted"));
}

/// A table of a tip at 0.4 m that swings at 1.6 Hz about a rest which changes at some instants, and a pressure beside it.
fn stepped(pressure: &str, steps: &[(f64, f64)], of_pressure: impl Fn(f64) -> f64) -> String {
    let mut noise = Noise::new(7);
    let mut text = format!("t_s,valve_V,tip_x_m,tip_z_m,{pressure}\n");
    for time in (0..1800).map(|k| 0.01 * f64::from(k)) {
        let change = |(at, by): &(f64, f64)| {
            let since = (time - at).max(0.0);
            by * (1.0 - (-0.4 * since).exp() * (std::f64::consts::TAU * 1.6 * since).cos())
        };
        let z = -0.12 + steps.iter().map(change).sum::<f64>() + 2e-5 * noise.normal();
        text += &format!("{time:.2},0.5,{:.7},{z:.7},{:.1}\n", (0.16 - z * z).sqrt(), of_pressure(time));
    }
    text
}

/// `init` takes the column with a unit of pressure whose steps begin swings; a pressure that stays, or a column of another unit,
/// leaves the key to the person.
#[test]
fn a_column_of_pressure_whose_steps_begin_swings_is_found() {
    let bench = Bench::new("stepped");
    let draft = |text: &str| {
        bench.file("a.csv", text);
        bench.json(&["experiment", "init", "a.csv", "--overwrite", "--json"]);
        bench.text("experiment.toml")
    };
    let steps = [(2.0, 0.05), (10.0, -0.05)];
    let held = |time: f64| if (2.0..10.0).contains(&time) { 350.0 } else { 0.0 };
    for name in ["p_mbar", "Druck [mbar]"] {
        let found = draft(&stepped(name, &steps, held));
        assert!(found.contains(&format!("\npressure = {{ column = \"{name}\" }}")), "{found}");
        assert!(found.contains("\nstart = \"rest\""), "{found}");
        for at in ["release 1 at 1.9", "release 2 at 9.9"] {
            assert!(found.contains(at), "{at}: {found}");
        }
    }
    for (name, pressure) in [("p_mbar", 350.0), ("p_V", 3.0)] {
        let alone = draft(&stepped(name, &[(2.0, -0.1)], |_| pressure));
        assert!(!alone.contains("\npressure") && !alone.contains("start = \"rest\""), "{alone}");
        assert!(alone.contains("\n# found: release 1 at 1.99"), "{alone}");
    }
}

/// Two rods in one file: the draft takes one of them, with its own base, and names the markers of the other.
#[test]
fn markers_of_another_rod_are_named() {
    let bench = Bench::new("two-rods");
    let mut noise = Noise::new(5);
    let markers = ["A_base", "A_tip", "B_base", "B_mid", "B_tip"];
    let names: Vec<String> =
        markers.iter().flat_map(|name| ["x", "y", "z"].map(|axis| format!("{name}_{axis}_m"))).collect();
    let mut text = format!("t_s,{}\n", names.join(","));
    for time in (0..900).map(|k| 0.01 * f64::from(k)) {
        let swing = |from: f64, by: f64, hertz: f64| {
            let since = (time - from).max(0.0);
            -by * (1.0 - (-0.5 * since).exp() * (std::f64::consts::TAU * hertz * since).cos())
        };
        let (a, b) = (swing(1.0, 0.1, 1.65), swing(1.5, 0.18, 1.2));
        let arc = |z: f64| (0.16 - z * z).sqrt();
        let places = [
            [0.0, 0.0, 0.0],
            [arc(a), 0.0, a],
            [0.0, 0.5, 0.0],
            [0.5 * arc(b), 0.5, 0.3 * b],
            [arc(b), 0.5, b],
        ];
        let cells = places.into_iter().flatten().map(|at| format!(",{:.7}", at + 2e-5 * noise.normal()));
        text += &format!("{time:.2}{}\n", cells.collect::<String>());
    }
    bench.file("a.csv", &text);
    bench.json(&["experiment", "init", "a.csv", "--json"]);
    let draft = bench.text("experiment.toml");
    for line in [
        "\ntip = \"B_tip\"",
        "\nbase = \"B_base\"",
        "{ marker = \"B_mid\"",
        "\n# not used: [\"A_base\", \"A_tip\"]   # GUESS, perhaps of another rod",
    ] {
        assert!(draft.contains(line), "{line}: {draft}");
    }
}
