//! Every reader under bytes that anybody may have written: what each target does with them, and what
//! must hold whatever they are. libFuzzer runs this (`tests/fuzz`), and so does `suite/hostile.rs` on
//! the files that it kept.

mod folders;
mod recordings;
mod scratch;
mod texts;

/// A reader by its name; the files that were kept for it lie in `tests/fuzz/corpus/<name>`.
pub struct Target {
    /// Its name.
    pub name: &'static str,
    read: fn(&[u8]),
    /// Memory that a byte of the input may take, bytes.
    times: u64,
}

/// All of them.
pub const TARGETS: [Target; 9] = [
    Target::new("experiment", texts::experiment),
    // An export has a channel with a schema for each column of a body, and each analysis its words on a page.
    Target { times: 300, ..Target::new("folder", folders::folder) },
    Target::new("muscle", texts::muscle),
    Target::new("plan", folders::plan),
    // Columns that repeat themselves take no room in Parquet: what a reader of recordings admits.
    Target { times: 2000, ..Target::new("recording", recordings::recording) },
    Target::new("scenario", texts::scenario),
    Target::new("set", texts::set),
    Target::new("shard", folders::shard),
    Target::new("sweep", folders::sweep),
];

/// Memory that is admitted whatever the input, bytes.
const ALWAYS: u64 = 64 << 20;

impl Target {
    const fn new(name: &'static str, read: fn(&[u8])) -> Self {
        Self { name, read, times: 100 }
    }

    /// Reads some bytes, and checks what was read, how it is refused, and what memory that took.
    /// # Panics
    /// If anything of this is not as it should be.
    pub fn holds(&self, bytes: &[u8]) {
        let most = ALWAYS + self.times * bytes.len() as u64;
        let taken = allocation_counter::measure(|| (self.read)(bytes)).bytes_max;
        assert!(taken <= most, "{}: {} bytes take {taken} of memory, {most} at most", self.name, bytes.len());
    }
}

/// Of a target by its name.
/// # Panics
/// As [`Target::holds`], and without a target of that name.
pub fn holds(name: &str, bytes: &[u8]) {
    TARGETS.iter().find(|target| target.name == name).expect("a target").holds(bytes);
}

/// A message says more than nothing.
fn is_message(text: &str) {
    assert!(text.len() > 10, "{text}");
}
