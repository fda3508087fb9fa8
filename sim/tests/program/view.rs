//! `efam view` says what is missing where it has nothing to open.

use std::fs;

use crate::bench::Bench;

#[test]
fn what_cannot_be_viewed_is_said_with_the_way_to_it() {
    let bench = Bench::new("view");
    let says = |folder: &str, expected: &str| {
        let (code, stdout, stderr) = bench.run(&["view", folder]);
        assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
        assert!(stderr.contains(expected), "{stderr}");
    };
    says("absent", "absent: is no folder of a run, for it has no summary.json");
    fs::create_dir_all(bench.0.join("run")).expect("the target folder can be written");
    bench.file("run/summary.json", "{}");
    says("run", "run it again with --rerun save");
    bench.file("run/scenario.resolved.toml", "");
    says("run", "efam simulate run/scenario.resolved.toml --rerun spawn");
}
