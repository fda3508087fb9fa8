//! `efam sweep submit` in folders of any name.
//!
//! Goal: a script does what it should and nothing else, whatever the folder of the plan is called; a name that no script
//! can hold is refused, and what is printed to be copied means what it says.
//! Setup: names drawn from words and signs of shells and of Slurm; a substitute for Slurm that reads options as it does
//! (slurm, src/sbatch/opt.c, `_get_argument`) and runs the scripts. `EFAM_FOLDERS=1000` draws as many names;
//! `EFAM_SEED` draws others, and a new seed is printed with `EFAM_SEED=new`. `tests/slurm.sh` does the same on a real one.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::bench::program;
use crate::draws::{Draws, count};
use crate::strangers::tree;

/// Parts of names. `PWNED` must never come to be.
const PARTS: [&[u8]; 34] = [
    b"map",
    b"a b",
    b"$(touch PWNED)",
    b"`touch PWNED`",
    b"; touch PWNED;",
    b"\ntouch PWNED\n",
    b"\n#SBATCH --wrap='touch PWNED'\n",
    b"\r\n",
    b"&& touch PWNED",
    b"| tee PWNED",
    b"> PWNED",
    b"'",
    b"\"",
    b"\\",
    b"%",
    b"%A_%a",
    b"%j",
    b"#",
    b" #",
    b"~",
    b"-rf",
    b"--wrap=touch",
    b"$HOME",
    b"${IFS}",
    b"*",
    b"?[a]",
    b"{a,b}",
    b"!!",
    b"\x1b[31m",
    b"\xff\xfe",
    b"caf\xc3\xa9",
    b"\xe2\x80\xae",
    b"=1",
    b".",
];

/// What a scheduler makes of a script: its options, as Slurm reads them from their comments.
fn options(script: &str) -> Vec<String> {
    let mut all = Vec::new();
    for line in script.lines() {
        let Some(line) = line.strip_prefix("#SBATCH") else { continue };
        let mut rest = line.chars().peekable();
        loop {
            while rest.next_if(|c| c.is_whitespace()).is_some() {}
            if rest.peek().is_none_or(|c| *c == '#') {
                break;
            }
            let (mut word, mut quote, mut is_escaped) = (String::new(), None, false);
            while let Some(c) = rest.next_if(|c| quote.is_some() || is_escaped || !c.is_whitespace()) {
                match (c, quote) {
                    _ if is_escaped => {
                        word.push(c);
                        is_escaped = false;
                    }
                    ('\\', _) => is_escaped = true,
                    (c, Some(own)) if c == own => quote = None,
                    ('"' | '\'', None) => quote = Some(c),
                    ('#', None) => break,
                    _ => word.push(c),
                }
            }
            all.push(word);
        }
    }
    all
}

/// Runs a script as member 0 of job 42; what it prints goes where its option says, in a folder that must be there.
fn run(script: &Path, home: &Path) {
    let text = fs::read_to_string(script).expect("a script");
    let options = options(&text);
    let output = options.iter().find_map(|own| own.strip_prefix("--output=")).expect("it says where");
    let known = ["--job-name=", "--cpus-per-task=1", "--requeue", "--open-mode=append", "--output="];
    assert!(
        options.iter().all(|own| known.iter().any(|known| own.starts_with(known))),
        "{options:?}\n{text}"
    );
    let output = output.replace("%A", "42").replace("%a", "0").replace("%j", "42");
    assert!(!output.contains('%'), "{output}");
    let log = fs::File::options().append(true).create(true).open(&output).expect("its folder is there");
    let mut command = Command::new("sh");
    command.arg(script).current_dir(home).env("SLURM_ARRAY_TASK_ID", "0").env("HOME", home);
    let done = command.stdout(log.try_clone().expect("a file")).stderr(log).status().expect("sh runs");
    assert!(
        done.success(),
        "{}:\n{text}\n{}",
        script.display(),
        fs::read_to_string(output).unwrap_or_default()
    );
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn scripts_create_nothing_but_what_they_should() {
    let bench = crate::sweep::bench("cluster");
    bench.json(&["sweep", "plan", "sweep.toml", "--set", "sweep.points=1", "--json", "--out", "plan"]);
    // sbatch hands nothing in: it says a number, and keeps its arguments.
    let bin = bench.0.join("bin");
    fs::create_dir(&bin).expect("made");
    fs::write(
        bin.join("sbatch"),
        "#!/bin/sh\nfor word; do printf '%s\\0' \"$word\"; done >>\"$TOLD\"\necho 42\n",
    )
    .expect("written");
    fs::set_permissions(bin.join("sbatch"), fs::Permissions::from_mode(0o755)).expect("it is ours");
    let base = bench.0.join("base");
    let mut draws = Draws::new("cluster");
    let (mut handed_in, mut refused) = (0, 0);
    for _ in 0..count("EFAM_FOLDERS", 40) {
        let parts = 1 + draws.below(3);
        let mut name: Vec<u8> = (0..parts).flat_map(|_| PARTS[draws.below(PARTS.len())]).copied().collect();
        if name == b"." || name == b".." {
            name.push(b'x');
        }
        let name = OsString::from_vec(name);
        let _ = fs::remove_dir_all(&base);
        fs::create_dir_all(base.join(&name)).expect("made");
        for file in ["plan.json", "points.csv"] {
            fs::copy(bench.0.join("plan").join(file), base.join(&name).join(file)).expect("copied");
        }
        let before = tree(&base);
        let told = bench.0.join("told");
        let _ = fs::remove_file(&told);
        // Named from outside, or as the folder in which the user is.
        let (cwd, plan) = match draws.below(2) {
            0 => (base.clone(), PathBuf::from(OsStr::from_bytes(&[b"./", name.as_bytes()].concat()))),
            _ => (base.join(&name), PathBuf::from(".")),
        };
        let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap_or_default());
        let mut command = Command::new(program());
        command.args(["sweep", "submit", "--plan"]).arg(&plan).current_dir(&cwd);
        let done = command.env("PATH", path).env("TOLD", &told).output().expect("efam runs");
        let stderr = String::from_utf8_lossy(&done.stderr).into_owned();
        let stdout = String::from_utf8(done.stdout).expect("UTF-8");
        if done.status.code() == Some(2) {
            assert!(stderr.contains("no job script can name it; rename it"), "{name:?}: {stderr}");
            let text = name.to_str().filter(|name| !name.chars().any(|c| c.is_control() || c == '\u{202e}'));
            assert!(text.is_none_or(|name| name.contains(['"', '%', '\\'])), "{name:?} could be handed in");
            assert!(tree(&base) == before, "{name:?}: refused, and something is there");
            refused += 1;
            continue;
        }
        assert_eq!(done.status.code(), Some(0), "{name:?}: {stderr}");
        handed_in += 1;
        let folder = fs::canonicalize(base.join(&name)).expect("it is there");
        let [array, merge] = ["array.sh", "merge.sh"].map(|file| folder.join(file));
        for (shell, script) in [("bash", &array), ("bash", &merge), ("sh", &array), ("sh", &merge)] {
            let checked = Command::new(shell).arg("-n").arg(script).output().expect("a shell");
            assert!(checked.status.success() && checked.stderr.is_empty(), "{name:?}: {checked:?}");
        }
        let words = fs::read(&told).expect("sbatch was asked");
        let words: Vec<&[u8]> = words.split(|byte| *byte == 0).collect();
        let expected: [&[u8]; 7] = [
            b"--parsable",
            b"--array=0",
            array.as_os_str().as_bytes(),
            b"--parsable",
            b"--dependency=afterany:42",
            merge.as_os_str().as_bytes(),
            b"",
        ];
        assert_eq!(words, expected, "{name:?}");
        // What is printed to be copied names the same folder.
        let look = stdout.lines().find_map(|line| line.strip_prefix("status: efam ")).expect("a command");
        let copied = format!("\"$EFAM\" {look} --json");
        let mut shown = Command::new("bash");
        shown.args(["-c", &copied]).env("EFAM", program()).current_dir(&cwd).stdin(Stdio::null());
        let shown = shown.output().expect("bash runs");
        assert!(shown.status.success(), "{name:?}: {look}: {}", String::from_utf8_lossy(&shown.stderr));
        run(&array, &base);
        run(&merge, &base);
        let prefix = base.join(&name);
        let own = [
            "efam-files.json",
            "array.sh",
            "merge.sh",
            "log",
            "shard=00000",
            "sweep.parquet",
            "sweep.json",
            "report.html",
            "summary.json",
        ];
        for path in tree(&base).into_keys().filter(|path| !before.contains_key(path)) {
            let below =
                path.strip_prefix(&prefix).unwrap_or_else(|_| panic!("{name:?} made {}", path.display()));
            let first = below.components().next().expect("a part").as_os_str().to_string_lossy().into_owned();
            let is_picture = first.starts_with("over-") && first.ends_with(".svg");
            assert!(is_picture || own.contains(&first.as_str()), "{name:?} made {}", path.display());
        }
    }
    println!("{handed_in} folders handed in, {refused} refused");
    assert!(handed_in > refused / 4 && refused > 0, "{handed_in} handed in, {refused} refused");
    let _ = fs::remove_dir_all(&base);
}

#[test]
fn options_are_read_as_slurm_reads_them() {
    let script = "#!/bin/sh\n#SBATCH --a=1 --b=\"x y'\\\" z\" # no\n#SBATCH -c 2\nexec x\n";
    assert_eq!(options(script), ["--a=1", "--b=x y'\" z", "-c", "2"]);
}

/// A working directory whose name is no text, which a script cannot name.
#[test]
fn a_folder_that_is_no_text_is_refused_and_nothing_is_written() {
    let bench = crate::sweep::bench("cluster-no-text");
    bench.json(&["sweep", "plan", "sweep.toml", "--json", "--out", "plan"]);
    let cwd = bench.0.join(OsStr::from_bytes(b"caf\xe9"));
    fs::create_dir(&cwd).expect("made");
    for file in ["plan.json", "points.csv"] {
        fs::copy(bench.0.join("plan").join(file), cwd.join(file)).expect("copied");
    }
    let done = Command::new(program())
        .args(["sweep", "submit", "--plan", ".", "--dry-run"])
        .current_dir(&cwd)
        .output();
    let done = done.expect("efam runs");
    let stderr = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.code() == Some(2) && stderr.contains("bytes that are not UTF-8"), "{stderr}");
    assert_eq!(fs::read_dir(&cwd).expect("a folder").count(), 2);
}
