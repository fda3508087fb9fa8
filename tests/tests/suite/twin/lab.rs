//! Goal: the worked examples in `scenarios/diagnosis` are what their heads say.
//! Setup: each head names the words by which it was drawn.
//! Expected: those words give the same experiment files, and the same recordings to the bit.

use std::fs;
use std::path::{Path, PathBuf};

use tests::twin::lab::Lab;

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/diagnosis")
}

/// The request in the head of an experiment file.
fn asked(text: &str) -> Lab {
    let line = text.lines().find_map(|line| line.split_once("--bin draw_experiment -- "));
    let words: Vec<String> = line.expect("a command").1.split(' ').map(str::to_owned).collect();
    Lab::asked(&words).unwrap_or_else(|| panic!("{words:?} asks for nothing"))
}

#[test]
fn every_example_has_the_file_that_its_head_asks_for() {
    let mut count = 0;
    for entry in fs::read_dir(examples()).expect("there are examples") {
        let folder = entry.expect("an entry").path();
        let text = fs::read_to_string(folder.join("experiment.toml")).expect("an experiment");
        assert_eq!(asked(&text).experiment(), text, "{}", folder.display());
        count += 1;
    }
    assert_eq!(count, 7);
}

/// One is enough: all are drawn by the same lines.
#[test]
fn an_example_is_drawn_again_to_the_bit() {
    let folder = examples().join("nothing");
    let text = fs::read_to_string(folder.join("experiment.toml")).expect("an experiment");
    let recordings = asked(&text).recordings();
    assert_eq!(recordings.len(), 6);
    for (name, drawn) in recordings {
        let kept = fs::read_to_string(folder.join(&name)).expect("a recording");
        assert!(kept == drawn, "{name} is another recording");
    }
}

#[test]
fn what_makes_no_sense_is_not_drawn() {
    for words in ["", "folder", "folder one", "folder 1 drag=1", "folder 1 air_drag", "folder 1 air_drag=1,2"]
    {
        let words: Vec<String> = words.split_whitespace().map(str::to_owned).collect();
        assert_eq!(Lab::asked(&words), None, "{words:?}");
    }
}
