//! Goal: whatever bytes a reader gets, it neither panics nor takes memory beyond a stated bound, and what it refuses
//! has a reason. Setup: the files that fuzzing kept in `tests/fuzz/corpus`: the fewest that reach all code it
//! has reached, and those that were found to break something. Expected: [`tests::hostile`] says what must hold.

use std::fs;
use std::path::{Path, PathBuf};

use tests::hostile::TARGETS;

fn corpus(target: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target)
}

#[test]
fn what_fuzzing_kept_is_read_or_refused() {
    let mut bytes = 0;
    for target in &TARGETS {
        let mut files: Vec<PathBuf> = fs::read_dir(corpus(target.name))
            .expect("a corpus")
            .map(|entry| entry.expect("a file").path())
            .collect();
        assert!(files.len() > 1, "{} has a corpus", target.name);
        files.sort();
        for file in files {
            // Where it fails, the last of these is the file.
            println!("{}", file.display());
            let file = fs::read(file).expect("a file");
            bytes += file.len();
            target.holds(&file);
        }
    }
    assert!(bytes < 2_000_000, "{bytes} bytes are kept; minimise them, as tests/fuzz/run says");
}

/// Texts of a megabyte in which something comes over and over, which fuzzing is slow to make: where all is compared
/// with all, they take minutes or all memory.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn what_comes_over_and_over_is_read_or_refused() {
    let many = |count: usize, of: &dyn Fn(usize) -> String| (0..count).map(of).collect::<String>();
    let names = many(140_000, &|k| format!("\"{k:x}\","));
    let columns = many(70_000, &|k| format!("x_{k:06}_m,"));
    let zeros = many(70_000, &|_| "0,".to_owned());
    let axes = many(80_000, &|_| "X,Y,Z,".to_owned());
    let rows = many(60_000, &|k| format!("[{k}.0,1,0,1,1,1],"));
    let muscle = "name=\"a\"\nsource=\"b\"\ngravity=\"9.8 m/s^2\"\n[rest]\nlength=\"1 m\"\nmass_per_length=\"1 kg/m\"\n\
                  [end_fitting]\nmass=\"1 g\"\ncenter_of_mass=\"0 m\"\nrotary_inertia=\"0 kg m^2\"\n[table]\n";
    let six = "columns=[\"pressure\",\"length\",\"inner_diameter\",\"outer_diameter\",\"axial_stiffness\",\
               \"bending_stiffness_a\"]\nunits=[\"Pa\",\"m\",\"m\",\"m\",\"N\",\"N m^2\"]\n";
    let many_columns = many(30_000, &|k| format!("\"bending_stiffness_{k}\","));
    let knobs = many(500, &|k| {
        let own: String =
            (0..500).map(|l| if l == k { "1.0," } else { "0.," }).collect::<String>().replace("0.,", "0.0,");
        format!(
            "[[calibration.parameter]]\npath=\"p{k}\"\nvalue=1.0\nstandard_error=0.1\ncorrelations=[{own}]\n"
        )
    });
    let known = "[calibration]\nreleases=1\npressure_pa=[0.0,1.0]\npayload_kg=[0.0,0.0]\nexcursion_m=1.0\n";
    let calibrated = format!("{muscle}{six}rows=[[0,1,0,1,1,1],[1,1,0,1,1,1]]\n{known}{knobs}");
    let steps = many(60, &|k| {
        let path = ["length", "mass", "bending_stiffness", "axial_stiffness", "diameter", "pressure"][k % 6];
        let unit = ["m", "kg", "N m^2", "N", "m", "Pa"][k % 6];
        let prefix = if k < 6 { "" } else { "release.hold." };
        format!(
            "[[sweep.parameter]]\npath=\"{prefix}rod.{path}\"\nrange=[\"1 {unit}\",\"2 {unit}\"]\nsteps=10000000\n"
        )
    });
    for (target, text) in [
        ("experiment", format!("[[recording]]\nfile=\"a\"\ntip=[{names}]")),
        ("experiment", format!("{} = 1", "a".repeat(1_000_000))),
        ("scenario", "[a]\n".to_owned() + &many(100_000, &|k| format!("b{k}=1\n"))),
        ("scenario", format!("{}a=1", "a.".repeat(500_000))),
        ("set", format!("{}a=1", "a.".repeat(500_000))),
        ("set", format!("rod.length={}", "[".repeat(1_000_000))),
        ("muscle", format!("{muscle}{six}rows=[{rows}]\n")),
        ("muscle", format!("{muscle}columns=[{many_columns}]\nunits=[]\nrows=[]")),
        ("muscle", calibrated),
        ("recording", format!("Trajectories\n100\n{}\nFrame,Sub Frame,{axes}\n", "a,".repeat(160_000))),
        ("recording", format!("t_s,{}\n", many(30_000, &|k| format!("m{k}_x_m,m{k}_z_m,")))),
        ("recording", format!("{columns}\n{zeros}\n")),
        ("folder", format!("=== summary.json\n{{}}\n=== a.csv\n{columns}\n{zeros}\n")),
        ("sweep", format!("[sweep]\nscenario=\"release.toml\"\ndesign=\"grid\"\n{steps}")),
    ] {
        println!("{target}: {:.60}", text);
        tests::hostile::holds(target, text.as_bytes());
    }
}
