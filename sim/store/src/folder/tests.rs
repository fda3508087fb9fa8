//! Run folders, begun and finished, given up and fought for.

use std::collections::BTreeMap;
use std::time::{Duration, UNIX_EPOCH};

use crate::added;
use crate::atomic::{write_new, write_whole};
use crate::disk::fault;
use crate::folder::*;

/// A folder of its own for each test, removed at its end.
struct Scratch(PathBuf);

impl Scratch {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("efam-folder-{test}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn entries(&self) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(&self.0)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn put(folder: &Path, overwrite: bool, text: &str) -> Result<PathBuf, StoreError> {
    let made = Folder::begin(Target::Given { folder, overwrite })?;
    made.write(MARK, text.as_bytes())?;
    made.finish()
}

#[test]
fn a_run_is_replaced_only_when_asked() {
    let scratch = Scratch::new("overwrite");
    let out = scratch.0.join("run");
    put(&out, false, "first").unwrap();
    assert!(admit(&out, false).is_err() && admit(&out, true).is_ok());
    let error = put(&out, false, "second").unwrap_err();
    assert!(matches!(&error, StoreError::Exists { folder } if *folder == out), "{error}");
    assert!(
        error
            .to_string()
            .ends_with("run: exists already; choose another --out, or replace it with --overwrite")
    );
    assert_eq!(fs::read_to_string(out.join(MARK)).unwrap(), "first");
    put(&out, true, "third").unwrap();
    assert_eq!(fs::read_to_string(out.join(MARK)).unwrap(), "third");
    assert_eq!(scratch.entries(), ["run"]);
}

#[test]
fn a_folder_of_other_things_is_never_replaced_but_an_empty_one_is_filled() {
    let scratch = Scratch::new("foreign");
    let photos = scratch.0.join("photos");
    fs::create_dir(&photos).unwrap();
    put(&photos, false, "into an empty folder").unwrap();
    fs::remove_file(photos.join(MARK)).unwrap();
    fs::remove_file(photos.join(MANIFEST)).unwrap();
    fs::write(photos.join("holiday.jpg"), "sea").unwrap();
    for overwrite in [false, true] {
        let error = put(&photos, overwrite, "run").unwrap_err();
        assert!(matches!(error, StoreError::NotARun { .. }), "{error}");
    }
    assert_eq!(fs::read_to_string(photos.join("holiday.jpg")).unwrap(), "sea");
}

/// A thesis, a repository, an edited result; there before the run or put there while it goes on.
#[test]
fn what_efam_did_not_write_stays_and_is_named() {
    let scratch = Scratch::new("strangers");
    let out = scratch.0.join("run");
    let text = |path: PathBuf| fs::read_to_string(path).unwrap();
    for (entry, expected) in [
        ("thesis.tex", "holds thesis.tex, which efam did not write"),
        (".git/HEAD", "holds .git, which efam did not write"),
        (MARK, "holds summary.json, which was changed since efam wrote it"),
    ] {
        put(&out, false, "old").unwrap();
        let made = Folder::begin(Target::Given { folder: &out, overwrite: true }).unwrap();
        made.write(MARK, b"new").unwrap();
        fs::create_dir_all(out.join(entry).parent().unwrap()).unwrap();
        fs::write(out.join(entry), "mine").unwrap();
        let error = admit(&out, true).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
        // It came while the run went on: that is kept beside it.
        let error = made.finish().unwrap_err();
        let StoreError::Kept { kept, .. } = &error else { panic!("{error}") };
        assert!(error.to_string().contains(expected), "{error}");
        assert_eq!((text(out.join(entry)).as_str(), text(kept.join(MARK)).as_str()), ("mine", "new"));
        assert_eq!(*kept, fs::canonicalize(&scratch.0).unwrap().join("run_2"));
        assert_eq!(scratch.entries(), ["run", "run_2"]);
        fs::remove_dir_all(&out).unwrap();
        fs::remove_dir_all(kept).unwrap();
    }
}

/// Where names cannot be exchanged, and in a folder that was empty or not there when the run began.
#[test]
fn what_comes_while_a_run_goes_on_stays_however_it_is_replaced() {
    let scratch = Scratch::new("late");
    let out = scratch.0.join("run");
    let read = |name: &str| fs::read_to_string(scratch.0.join(name)).unwrap();
    put(&out, false, "old").unwrap();
    let made = Folder::begin(Target::Given { folder: &out, overwrite: true }).unwrap();
    made.write(MARK, b"new").unwrap();
    fs::write(out.join("notes"), "mine").unwrap();
    assert!(matches!(made.step_aside(), Err(StoreError::Foreign { .. })));
    drop(made);
    assert_eq!((read("run/notes").as_str(), read("run/summary.json").as_str()), ("mine", "old"));
    assert_eq!(scratch.entries(), ["run"]);
    for overwrite in [false, true] {
        fs::remove_dir_all(&out).unwrap();
        fs::create_dir(&out).unwrap();
        let made = Folder::begin(Target::Given { folder: &out, overwrite }).unwrap();
        made.write(MARK, b"new").unwrap();
        fs::write(out.join("notes"), "mine").unwrap();
        let error = made.finish().unwrap_err();
        assert!(matches!(error, StoreError::Kept { .. }), "{error}");
        assert_eq!((read("run/notes").as_str(), read("run_2/summary.json").as_str()), ("mine", "new"));
        fs::remove_dir_all(scratch.0.join("run_2")).unwrap();
    }
}

#[test]
fn a_folder_that_is_given_up_leaves_nothing() {
    let scratch = Scratch::new("dropped");
    let out = scratch.0.join("run");
    let made = Folder::begin(Target::Given { folder: &out, overwrite: false }).unwrap();
    made.write("trajectory.csv", b"half of").unwrap();
    assert!(!out.exists());
    assert_eq!(scratch.entries().len(), 1);
    drop(made);
    assert!(scratch.entries().is_empty(), "{:?}", scratch.entries());
}

#[test]
fn a_file_in_place_of_the_folder_is_named() {
    let scratch = Scratch::new("file");
    let file = scratch.0.join("run");
    fs::write(&file, "a file").unwrap();
    for out in [file.clone(), file.join("below"), file.join("further/below")] {
        let error = put(&out, true, "run").unwrap_err();
        let StoreError::NotAFolder { path } = &error else { panic!("{error}") };
        assert_eq!(*path, file);
    }
    let root = scratch.0.join("run");
    let at = UNIX_EPOCH;
    let error = Folder::begin(Target::Dated { root: &root, name: "a", hash: "b", at }).unwrap_err();
    assert!(matches!(error, StoreError::NotAFolder { .. }), "{error}");
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_names_file_and_cause() {
    let scratch = Scratch::new("full");
    let out = scratch.0.join("run");
    let made = Folder::begin(Target::Given { folder: &out, overwrite: false }).unwrap();
    let full = |_: &mut File| fs::File::options().write(true).open("/dev/full")?.write_all(b"much");
    let error = made.write_with("trajectory.parquet", full).unwrap_err().to_string();
    assert!(error.contains("run/trajectory.parquet: cannot be written: No space left"), "{error}");
    drop(made);
    assert!(scratch.entries().is_empty());
}

#[test]
fn an_old_run_that_stepped_aside_for_one_that_was_killed_comes_back() {
    let scratch = Scratch::new("aside");
    let out = scratch.0.join("run");
    put(&out, false, "old").unwrap();
    fs::rename(&out, beside(&out, REPLACED)).unwrap();
    let error = put(&out, false, "new").unwrap_err();
    assert!(matches!(error, StoreError::Exists { .. }), "{error}");
    assert_eq!(fs::read_to_string(out.join(MARK)).unwrap(), "old");
    // As where names cannot be exchanged.
    let mut made = Folder::begin(Target::Given { folder: &out, overwrite: true }).unwrap();
    made.write(MARK, b"new").unwrap();
    made.step_aside().unwrap();
    made.finished = true;
    assert_eq!(fs::read_to_string(out.join(MARK)).unwrap(), "new");
    assert_eq!(scratch.entries(), ["run"]);
}

#[test]
fn rivals_for_one_name_leave_one_whole_run() {
    let scratch = Scratch::new("rivals");
    let out = scratch.0.join("run");
    let rivals = |overwrite: bool| {
        let puts = |k: usize| put(&out, overwrite, &k.to_string()).is_ok();
        std::thread::scope(|scope| {
            let rivals: Vec<_> = (0..8).map(|k| scope.spawn(move || puts(k))).collect();
            rivals.into_iter().map(|rival| rival.join().unwrap()).filter(|done| *done).count()
        })
    };
    // The others are refused at the beginning, or get the place of their run at the end.
    assert_eq!(rivals(false), 1);
    for other in scratch.entries().iter().filter(|name| *name != "run") {
        assert!(other.starts_with("run_"), "{other}");
        assert_eq!(foreign(&scratch.0.join(other)).unwrap(), None, "it is whole");
        fs::remove_dir_all(scratch.0.join(other)).unwrap();
    }
    assert_eq!(rivals(true), 8, "each replaces the one before");
    assert_eq!(scratch.entries(), ["run"]);
    assert!(fs::read_to_string(out.join(MARK)).unwrap().parse::<usize>().unwrap() < 8);
}

/// While one checks what the folder holds, others take its name, and remove what they replaced.
#[test]
fn rivals_that_overwrite_again_and_again_are_not_refused() {
    let scratch = Scratch::new("again");
    let out = scratch.0.join("run");
    std::thread::scope(|scope| {
        for rival in 0..4 {
            let out = &out;
            scope.spawn(move || {
                for round in 0..100 {
                    put(out, true, &format!("{rival} {round}")).unwrap();
                }
            });
        }
    });
    assert_eq!(scratch.entries(), ["run"]);
}

#[test]
fn two_runs_of_one_second_both_find_a_name() {
    let scratch = Scratch::new("dated");
    let at = UNIX_EPOCH + Duration::from_secs(1_709_164_799 + 86_400);
    let target = Target::Dated { root: &scratch.0, name: "15 psi", hash: "0123456789abcdef", at };
    for _ in 0..3 {
        let made = Folder::begin(target).unwrap();
        made.write(MARK, b"{}").unwrap();
        made.finish().unwrap();
    }
    let name = "20240229T235959Z_15-psi_01234567";
    assert_eq!(scratch.entries(), [name.to_owned(), format!("{name}_2"), format!("{name}_3")]);
}

#[test]
fn a_path_without_a_name_is_refused() {
    for path in ["/", "..", "."] {
        let error = admit(Path::new(path), true).unwrap_err();
        assert!(!matches!(error, StoreError::Exists { .. }), "{path}: {error}");
    }
}

/// The end of a program: one thread writes, and another gives up.
#[test]
fn what_is_given_up_while_it_is_written_leaves_nothing() {
    let scratch = Scratch::new("given-up");
    let made = Folder::begin(Target::Given { folder: &scratch.0.join("run"), overwrite: false }).unwrap();
    std::thread::scope(|scope| {
        let writes = || (0..).map_while(|k| made.write(&k.to_string(), b"x").ok()).count();
        let writer = scope.spawn(writes);
        while !made.path().join("9").exists() {
            std::thread::yield_now();
        }
        made.give_up();
        assert!(writer.join().unwrap() > 9);
    });
    assert_eq!(scratch.entries(), [""; 0]);
}

/// All files below a folder, with their contents.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path)
            } else {
                drop(found.insert(path.clone(), fs::read(&path).unwrap()))
            }
        }
    }
    found
}

/// Each call that changes the disk fails once: what is under a name is the old or the new, and an error says so.
#[test]
fn whichever_call_fails_nothing_is_torn_and_nothing_is_lost() {
    type Work = fn(&Path) -> Result<(), StoreError>;
    let folder: Work = |root| {
        let made = Folder::begin(Target::Given { folder: &root.join("run"), overwrite: true })?;
        made.write(MARK, b"new mark")?;
        made.write("pictures/a.svg", b"new picture")?;
        made.finish().map(drop)
    };
    let dated: Work = |root| {
        let target = Target::Dated { root: &root.join("outputs"), name: "a", hash: "b", at: UNIX_EPOCH };
        let made = Folder::begin(target)?;
        made.write(MARK, b"dated")?;
        made.finish().map(drop)
    };
    let free: Work = |root| {
        let made = Folder::begin(Target::Given { folder: &root.join("free"), overwrite: true })?;
        made.write(MARK, b"first mark")?;
        made.finish().map(drop)
    };
    let whole: Work = |root| write_whole(&root.join("run.mat"), |file| file.write_all(b"new file"));
    let new: Work = |root| write_new(&root.join("new.mat"), |file| file.write_all(b"first file"));
    let add: Work = |root| {
        added::add(&root.join("run"), MARK, |file| file.write_all(b"added mark"))?;
        added::replace(&root.join("run/shard=1"), "part", |file| file.write_all(b"added part"))
    };
    let (mut struck, scratch) = (0, Scratch::new("struck"));
    for (name, work) in
        [("folder", folder), ("free", free), ("dated", dated), ("whole", whole), ("new", new), ("add", add)]
    {
        let prepared = |k: u64| {
            let root = scratch.0.join(format!("{name}-{k}"));
            fs::create_dir(&root).unwrap();
            let mut made =
                Folder::begin(Target::Given { folder: &root.join("run"), overwrite: false }).unwrap();
            made.may_have(&["shard=*"]);
            made.write(MARK, b"old mark").unwrap();
            made.finish().unwrap();
            fs::write(root.join("run.mat"), "old file").unwrap();
            fs::write(root.join("notes.txt"), "mine").unwrap();
            root
        };
        let relative = |root: &Path| -> BTreeMap<PathBuf, Vec<u8>> {
            let all = contents(root).into_iter();
            all.map(|(path, bytes)| (path.strip_prefix(root).unwrap().to_owned(), bytes)).collect()
        };
        let whole = prepared(1000);
        let old = relative(&whole);
        work(&whole).unwrap();
        let new = relative(&whole);
        for k in 0.. {
            let root = prepared(k);
            fault::LEFT.set(Some(k));
            let done = work(&root);
            let is_over = fault::LEFT.take().is_some();
            let all = relative(&root);
            let is_hidden = |path: &PathBuf| {
                path.components().any(|part| part.as_os_str().to_string_lossy().starts_with('.'))
            };
            for (path, bytes) in all.iter().filter(|(path, _)| !path.ends_with(MANIFEST) && !is_hidden(path))
            {
                let is_known = [&old, &new].into_iter().any(|of| of.get(path) == Some(bytes));
                // A run whose name could not be taken is kept beside it.
                assert!(is_known || path.starts_with("run_2"), "{name} {k}: {} is torn", path.display());
            }
            for path in old.keys().filter(|path| new.contains_key(*path)) {
                assert!(all.contains_key(path), "{name} {k}: {} is lost", path.display());
            }
            assert_eq!(
                admit(&root.join("run"), true).map_err(|error| error.to_string()),
                Ok(()),
                "{name} {k}"
            );
            match done {
                Ok(()) => assert!(new.keys().all(|path| all.contains_key(path)), "{name} {k}"),
                // Results that have their own name are not kept beside it.
                Err(StoreError::Kept { kept, .. }) => {
                    assert!(kept.ends_with("run_2"), "{name} {k}: {kept:?}")
                }
                Err(error) => assert!(error.to_string().contains(&root.display().to_string()), "{error}"),
            }
            if is_over {
                break;
            }
            struck += 1;
            // The next one succeeds, and tidies.
            let again = work(&root);
            let exists = matches!(again, Err(StoreError::Exists { .. }));
            assert!(again.is_ok() || exists && name == "new", "{name} {k}: {again:?}");
            let all = relative(&root);
            assert!(!all.keys().any(is_hidden), "{name} {k}: {:?}", all.keys());
            for path in new.keys().filter(|path| name != "dated" && !path.ends_with(MANIFEST)) {
                assert_eq!(all.get(path), new.get(path), "{name} {k}");
            }
        }
    }
    println!("{struck} calls failed, 0 torn, 0 lost");
    assert!(struck > 40, "{struck}");
}
