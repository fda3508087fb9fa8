//! What lies in folders: plans and shards of sweeps, and runs.

use std::collections::BTreeMap;
use std::fs;

use efam_report::export::{Format, export, read as stored};
use efam_report::reread::reread;
use efam_report::{Request, compared};
use efam_store::columns::{Cells, Column, Found as FoundColumn, Holds, about, read, table};
use efam_store::folder::{Folder, Target};
use efam_store::sha::sha256;
use efam_sweeps::plan::{Head, PLAN, POINTS, Plan, freeze, head_text};
use efam_sweeps::request::SweepRequest;
use efam_sweeps::shard::{Found, is_due, look};
use efam_sweeps::work::Work;

use super::{is_message, scratch};

const SCENARIO: &[u8] = include_bytes!("../../../scenarios/release-15psi.toml");
/// Points and shards of a plan that are looked at.
const LOOKED_AT: usize = 20;
/// A line of an input that holds several files begins so; the rest of it is the file's name.
const MARK: &str = "=== ";

/// A sweep's file beside its scenario; a small one becomes a plan.
pub fn sweep(bytes: &[u8]) {
    scratch::with(&[("release.toml", SCENARIO), ("sweep.toml", bytes)], |folder| {
        let asked = match SweepRequest::load(&folder.join("sweep.toml"), &[]) {
            Ok(asked) => asked,
            Err(error) => return is_message(&error.to_string()),
        };
        if asked.points() <= LOOKED_AT {
            match freeze(&asked, 7, &mut Vec::new()) {
                Ok(head) => assert_eq!(head.points, asked.points()),
                Err(error) => is_message(&error.to_string()),
            }
        }
    });
}

/// A plan: its head and its points. Hashes are made to fit, for else nothing but hashes is tried.
pub fn plan(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let files = files(text);
    let of = |name: &str| files.get(name).copied().unwrap_or_default();
    let (mut head, points) = (of(PLAN).to_owned(), of(POINTS));
    if let Ok(mut fitting) = serde_json::from_str::<Head>(&head) {
        fitting.points_sha256 = sha256(points.as_bytes());
        fitting.sha256 = String::new();
        fitting.sha256 = sha256(serde_json::to_string(&fitting).expect("a head is JSON").as_bytes());
        head = head_text(&fitting);
    }
    scratch::with(&[(PLAN, head.as_bytes()), (POINTS, points.as_bytes())], |folder| {
        let plan = match Plan::open(folder) {
            Ok(plan) => plan,
            Err(error) => return is_message(&error.to_string()),
        };
        let shards = plan.head.shards();
        for shard in [0, shards.saturating_sub(1), shards, usize::MAX] {
            if let Err(error) = is_due(&plan, shard, false) {
                is_message(&error.to_string());
            }
        }
        let mut points = plan.points().expect("its points are there");
        for shard in 0..shards.min(LOOKED_AT) {
            match points.of(shard) {
                Err(error) => return is_message(&error.to_string()),
                Ok(points) => {
                    let Work::Simulate(work) = &plan.head.work else { continue };
                    for point in points.iter().take(2) {
                        if let Err(error) = work.case(point) {
                            is_message(&error.message());
                        }
                    }
                }
            }
        }
    });
}

/// A table that efam wrote, or says so.
pub fn shard(bytes: &[u8]) {
    let head = Head { points: 2, points_per_shard: 2, ..empty() };
    scratch::with(&[], |folder| {
        let plan = Plan { folder: folder.to_owned(), head };
        let file = efam_sweeps::shard::file(folder, 0);
        fs::create_dir_all(file.parent().expect("a folder")).expect("a folder for a shard");
        fs::write(&file, bytes).expect("a shard");
        let said = about(&file);
        if let Found::Damaged(why) = look(&plan, 0) {
            is_message(&why);
        }
        if let Err(error) = is_due(&plan, 0, false) {
            is_message(&error.to_string());
        }
        let found = match table(&file) {
            Ok(found) => found,
            Err(error) => return is_message(&error.to_string()),
        };
        let rows = said.expect("a table says what it is").rows;
        let columns: Vec<Column> = found.iter().map(column).collect();
        match read(&file, &columns) {
            Err(error) => is_message(&error.to_string()),
            Ok(cells) => assert!(cells.iter().all(|cells| cells.len() == rows), "{rows} rows"),
        }
        assert!(found.iter().all(|column| column.cells.len() == rows), "{rows} rows");
    });
}

fn column(found: &FoundColumn) -> Column {
    let holds = match found.cells {
        Cells::Numbers(_) => Holds::NumbersOrNone,
        Cells::Counts(_) => Holds::Counts,
        Cells::Texts(_) => Holds::Texts,
    };
    Column { name: found.name.clone(), unit: "", holds }
}

fn empty() -> Head {
    let text = r#"{"sha256":"","name":"","efam":"","work":{"simulate":{"design":"grid","seed":0,"parameters":[],
        "scenario":"","scenario_text":"","set":[]}},"points":1,"points_per_shard":1,
        "points_sha256":"","sweep":"","sweep_text":"","warnings":[]}"#;
    serde_json::from_str(text).expect("a head")
}

/// The folder of a run: it can be compared and exported, or says why not.
pub fn folder(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let files = files(text);
    let known = |name: &&str| {
        let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending);
        ["json", "toml", "csv"].contains(&ending) && !name.contains(['/', '\\', '\0']) && name.len() < 40
    };
    let files: Vec<(&str, &[u8])> = files
        .into_iter()
        .filter(|(name, _)| known(name))
        .map(|(name, text)| (name, text.as_bytes()))
        .collect();
    scratch::with(&files, |folder| {
        match reread(folder) {
            Err(error) => is_message(&error.to_string()),
            Ok(run) => {
                let both = [run.clone(), run];
                let compared = compared::compare(&both);
                let begun =
                    Folder::begin(Target::Given { folder: &folder.join("compared"), overwrite: false });
                let page = begun.expect("a folder for the page");
                let written = compared::write_comparison(&page, &Request::default(), &both, &compared);
                written.expect("what can be read can be shown");
            }
        }
        let stored = match stored(folder) {
            Ok(stored) => stored,
            Err(error) => return is_message(&error.to_string()),
        };
        for format in [Format::Mat, Format::Mcap] {
            let file = folder.join(format!("export.{}", format.ending()));
            if let Err(error) = export(&stored, format, &file, true) {
                is_message(&error.to_string());
            }
        }
    });
}

/// The files of an input; of two that have one name, the last.
fn files(text: &str) -> BTreeMap<&str, &str> {
    let mut files = BTreeMap::new();
    for part in text.split(MARK) {
        if let Some((name, text)) = part.split_once('\n') {
            files.insert(name.trim(), text);
        }
    }
    files
}
