//! A folder for readers that take paths.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

thread_local! {
    static SCRATCH: Scratch = Scratch::new();
}

/// It goes with the thread.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        Self(std::env::temp_dir().join(format!("efam-hostile-{}-{number}", std::process::id())))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Does something in a folder that has these files and no others.
pub fn with(files: &[(&str, &[u8])], act: impl FnOnce(&Path)) {
    SCRATCH.with(|scratch| {
        let folder = &scratch.0;
        let _ = fs::remove_dir_all(folder);
        fs::create_dir_all(folder).expect("a folder for files");
        for (name, bytes) in files {
            fs::write(folder.join(name), bytes).expect("a file in it");
        }
        act(folder);
    });
}
