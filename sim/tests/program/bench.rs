//! A folder for one test, in which the program is run.

#[path = "../../../tests/src/skipped.rs"]
mod skipped;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use efam_report::picture::dotted;
use serde_json::Value;

pub use skipped::skipped;

/// The program that is tested: the one that was built, or another that EFAM_PROGRAM names, such as an older one that a
/// test is to be seen to fail with.
pub fn program() -> PathBuf {
    std::env::var_os("EFAM_PROGRAM").map_or_else(|| env!("CARGO_BIN_EXE_efam").into(), PathBuf::from)
}

/// A page without what efam writes as scripts and as their data: nothing else may begin so. At most two are run.
pub fn without_scripts(page: &str) -> String {
    let (mut rest, mut out, mut run) = (page, String::new(), 0);
    while let Some((before, after)) = rest.split_once("<script") {
        let (tag, after) = after.split_once('>').expect("a tag ends");
        let (inside, after) = after.split_once("</script>").expect("a script ends");
        match tag {
            "" => run += 1,
            " type=\"application/json\" class=\"charts\""
            | " type=\"application/json\" class=\"rods\""
            | " type=\"application/json\" class=\"family\"" => {
                assert!(!inside.contains(['<', '>', '&']), "{inside}");
                serde_json::from_str::<Value>(inside).expect("data is JSON");
            }
            other => panic!("<script{other}>"),
        }
        out += before;
        rest = after;
    }
    assert!(run == 0 || run == 2, "{run} scripts");
    out + rest
}

/// A folder of its own for each test.
pub struct Bench(pub PathBuf);

impl Bench {
    /// The picture of a file as a page shows it, without its first word.
    pub fn picture(&self, name: &str) -> String {
        let svg = dotted(self.text(name).trim());
        svg.trim().split_once(' ').expect("an element").1.to_owned()
    }

    /// Empty; `name` is unique among the tests of the program.
    pub fn new(name: &str) -> Bench {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).expect("the target folder can be written");
        Bench(folder)
    }

    pub fn file(&self, name: &str, text: &str) {
        fs::write(self.0.join(name), text).expect("the target folder can be written");
    }

    /// The program, about to start in the folder.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(program());
        command.args(arguments).current_dir(&self.0);
        command
    }

    /// Exit code, stdout and stderr.
    pub fn run(&self, arguments: &[&str]) -> (i32, String, String) {
        let Output { status, stdout, stderr } = self.command(arguments).output().expect("efam runs");
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        (status.code().unwrap_or(-1), text(stdout), text(stderr))
    }

    /// What is printed for machines by a run that must succeed.
    pub fn json(&self, arguments: &[&str]) -> Value {
        let (code, stdout, stderr) = self.run(arguments);
        assert_eq!(code, 0, "{stderr}");
        serde_json::from_str(&stdout).expect("JSON on stdout")
    }

    pub fn text(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Names of what lies in the folder.
    pub fn left(&self) -> Vec<String> {
        let mut names: Vec<_> = (fs::read_dir(&self.0).expect("the folder is there"))
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}

/// Reproducible noise.
pub struct Noise(u64);

impl Noise {
    pub fn new(seed: u64) -> Noise {
        Noise(seed)
    }

    /// Nearly of a normal distribution, with a deviation of one: the sum of twelve uniform numbers.
    pub fn normal(&mut self) -> f64 {
        (0..12).fold(-6.0, |sum, _| {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum + (self.0 >> 33) as f64 / (1u64 << 31) as f64
        })
    }
}

/// A folder beside the project with recordings of others, or `None` and a printed line.
pub fn recordings(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/recordings").join(name);
    if !path.exists() {
        skipped("recordings", &format!("{} is not there", path.display()));
        return None;
    }
    Some(path)
}
