//! One binary for all targets, for each would be linked with all of the program: `READER` says which runs. What they
//! do is what `suite/hostile.rs` replays.

#![no_main]

use std::panic::{catch_unwind, set_hook};
use std::sync::{LazyLock, Mutex, Once};

use libfuzzer_sys::fuzz_target;

#[path = "../src/hostile/mod.rs"]
mod hostile;

static READER: LazyLock<String> = LazyLock::new(|| std::env::var("READER").expect("READER names a target"));
static HOOK: Once = Once::new();
static LAST: Mutex<String> = Mutex::new(String::new());

// libFuzzer's own hook ends the process at any panic, and some of the parquet package's are caught where they come:
// here one ends it, with its message, that gets out of a target.
fuzz_target!(|bytes: &[u8]| {
    HOOK.call_once(|| {
        set_hook(Box::new(|info| {
            if let Ok(mut last) = LAST.lock() {
                *last = info.to_string();
            }
        }));
    });
    if catch_unwind(|| hostile::holds(&READER, bytes)).is_err() {
        eprintln!("{}", LAST.lock().map_or_else(|_| String::new(), |last| last.clone()));
        std::process::abort();
    }
});
