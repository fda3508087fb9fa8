//! A first experiment file, written from the recordings themselves: what is guessed says so, and how.

mod guess;
mod lowered;
mod stepped;

use std::fmt::Write;
use std::ops::RangeInclusive;
use std::path::Path;

use efam_recordings::{ReadOptions, Recording};
use efam_store::escape::{escaped, toml_string};

use crate::cleaning::{CleanRecording, CleanRelease, Cleaned, IS_UP, SURELY, clean_all};
use crate::experiment::{Direction, Experiment, ExperimentError};
use crate::scenario::plan;

use stepped::Steps;

pub use guess::{Guess, guess};

/// Directions of the held tip between which the rod is guessed to be straight and level, rad. Markers are on top of a rod:
/// on a thick one they are seen far above the level. Below it the tip has sagged, unless a marker hangs there: on a rod of
/// ten diameters one of them is 0.1 rad.
const LEVEL: RangeInclusive<f64> = -0.1..=0.35;

/// The keys of a recording for what the person said of its file.
fn keys(options: &ReadOptions) -> String {
    let list =
        |names: &Vec<String>| names.iter().map(|name| toml_string(name)).collect::<Vec<_>>().join(", ");
    let lines = [
        options.unit.map(|unit| format!("unit = {}\n", toml_string(&unit.symbol()))),
        options.rate_hz.map(|rate| format!("rate = \"{rate} Hz\"\n")),
        options.columns.as_ref().map(|names| format!("columns = [{}]\n", list(names))),
    ];
    lines.into_iter().flatten().collect()
}

/// A text that loads: recordings with the file names to be written into it, and the options with which they were read. What
/// is unknown is marked `FILL IN`, what is guessed `GUESS`. Of `name` stays what an experiment may be called.
pub fn draft(name: &str, recordings: &[(String, Recording)], options: &ReadOptions) -> String {
    let fit = |c: char| if plan::fits_name(c) { c } else { '-' };
    let fitting: String = name.trim_start_matches('.').chars().map(fit).collect();
    let name = if fitting.trim().is_empty() { "experiment" } else { &fitting };
    let mut starts: Vec<Guessed> = recordings.iter().map(Guessed::stepped).collect();
    let mut found = vec![Vec::new(); recordings.len()];
    // The recordings at hand are read already.
    let mut cleaned = clean(&text(name, recordings, "", &starts, &found), recordings);
    if cleaned.is_err() {
        starts = recordings.iter().zip(starts).map(|(own, stepped)| Guessed::of(own, &stepped)).collect();
        cleaned = clean(&text(name, recordings, "", &starts, &found), recordings);
    }
    match cleaned {
        Ok(cleaned) => {
            for release in &cleaned.releases {
                let s = &release.statistics;
                let held = s.hold_angle.to_degrees();
                let start = &mut starts[release.recording];
                let what = match s.static_drop.map(|drop| 1e3 * drop) {
                    None => "the tip swings, and posture and velocity there are fitted".to_owned(),
                    Some(drop) if start.steps.is_some() => {
                        format!("the pressure steps, and the tip, at rest before, sinks by {drop:.2} mm")
                    }
                    Some(drop) => {
                        format!("the tip is held {held:.1} deg above the level and sinks by {drop:.2} mm")
                    }
                };
                let about = format!("release {} at {:.3} s: {what}", release.number, release.instant);
                found[release.recording].push(about);
                if !start.is_held() {
                    continue;
                }
                if LEVEL.contains(&s.hold_angle) && start.instants.is_empty() {
                    start.angle = Some(s.hold_angle);
                }
            }
            let is_free = |start: &Guessed| start.instants.is_empty() && start.is_held();
            for (k, start) in starts.iter_mut().enumerate().filter(|(_, start)| is_free(start)) {
                start.lowered(cleaned.releases.iter().filter(|release| release.recording == k));
            }
            for decision in cleaned.decisions.iter().filter(|decision| decision.key == "up") {
                let is_about = |clean: &CleanRecording| clean.name == decision.about;
                if let Some(k) = cleaned.recordings.iter().position(is_about) {
                    let (axis, _) = Direction::nearest(cleaned.recordings[k].frame.axes[2]);
                    starts[k].up = Some((axis, decision.what.clone()));
                }
            }
        }
        Err(error) => found.iter_mut().for_each(|found| found.push(format!("NOT YET USABLE: {error}"))),
    }
    starts.iter_mut().filter_map(|start| start.steps.as_mut()).for_each(|steps| steps.file = None);
    text(name, recordings, &keys(options), &starts, &found)
}

fn text(
    name: &str,
    recordings: &[(String, Recording)],
    keys: &str,
    starts: &[Guessed],
    found: &[Vec<String>],
) -> String {
    let mut out = format!(
        "# An experiment, written by `efam experiment init` from the recordings themselves.\n\
         # Look at every line with GUESS, and at those with FILL IN; then `efam experiment check` and\n\
         # `efam analyse` take this file. `#` switches a line off.\n\
         name = {}\n\n\
         # FILL IN, if a model is to be compared: the rod, in its own units. Without it only what needs no\n\
         # model is done. A built-in muscle instead: [muscle] with name = \"garbulinski-2022\".\n\
         # [rod]\n\
         # length = \"… mm\"               # active length, from the clamp\n\
         # mass = \"… g\"                  # distributed mass in all\n\
         # bending_stiffness = \"… N m^2\" # first value of what is fitted, as are the losses: these need none\n\
         # The lines below may stay off.\n\
         # base_angle = \"0 deg\"          # in which the rod leaves the clamp, above the level; -90 deg hangs down\n\
         # axial_stiffness = \"… N\"       # Young's modulus times section; without it the rod does not stretch to speak of\n\
         # tip = \"… mm\"                  # tip marker, or the mean of several, beyond the active length\n\
         # [effects.gravity]\n\
         # acceleration = \"9.81 m/s^2\"\n\
         # [effects.end_fitting]\n\
         # mass = \"… g\"\n\
         # center_of_mass = \"… mm\"       # beyond the active length\n",
        toml_string(name)
    );
    for (k, (file, recording)) in recordings.iter().enumerate() {
        let _ = write!(out, "\n[[recording]]\nfile = {}\n{keys}", toml_string(file));
        for found in &found[k] {
            let _ = writeln!(out, "# found: {}", escaped(found));
        }
        match &starts[k].steps {
            Some(steps) => steps.write(&mut out),
            None => pressure(&mut out, file),
        }
        payload(&mut out, file);
        guess::write(&mut out, recording);
        start(&mut out, &starts[k]);
        out += "# clamp = [\"0 mm\", \"0 mm\", \"0 mm\"]   # where the rod leaves the clamp, in the file's frame\n\
                # held_out = true   # no part of any fit, and validates it\n";
    }
    out + GUESSED_STIFFNESS
}

/// Text for a diagnosis about a bending stiffness that nobody measured.
const GUESSED_STIFFNESS: &str = "
# `efam calibrate` fits these three anyway. `efam diagnose` holds the bending stiffness to the value above within 5 %, unless it is
# listed here: if that value is a guess, remove the # from these lines. Recordings of one frequency, at one pressure and with one
# payload, tell one of the two losses: then list the first and the last alone.
# [[calibrate.parameter]]
# path = \"rod.bending_stiffness\"
# [[calibrate.parameter]]
# path = \"effects.rayleigh_mass.alpha\"
# [[calibrate.parameter]]
# path = \"effects.rayleigh_stiffness.beta\"
";

/// How a recording seems to begin.
#[derive(Clone, Debug, Default)]
struct Guessed {
    /// Instants of its releases, s, if they cannot be found, or are not where the tip leaves the hold.
    instants: Vec<f64>,
    /// How that is known.
    why: &'static str,
    /// Direction in which the tip of a rod is held that seems to be straight and level, rad.
    angle: Option<f64>,
    /// Which axis of the file seems to be up, and how that is known.
    up: Option<(Direction, String)>,
    /// Whether it begins in mid-swing.
    in_motion: bool,
    /// The pressure whose steps begin its swings.
    steps: Option<Steps>,
}

impl Guessed {
    /// The first sample, if the file has no release that can be found without it, and has one with it, or swings from it on. Where it
    /// does not show which way is up, the start is known all the same. `stepped` is what [`Self::stepped`] gives for it.
    fn of(recording: &(String, Recording), stepped: &Self) -> Self {
        let at_once = Guessed {
            instants: recording.1.time.first().copied().into_iter().collect(),
            why: "the file has no hold, so the rod is let go at its first sample",
            ..Guessed::default()
        };
        let in_motion = Guessed { in_motion: true, ..Guessed::default() };
        let is_found = |start: &&Guessed| {
            let has_hold = start.instants.is_empty() && !start.in_motion;
            let is_even =
                |cleaned: Cleaned| has_hold || cleaned.recordings.iter().all(CleanRecording::is_even);
            start.tried(recording).is_ok_and(is_even)
        };
        let axes = [2, 1, 0].map(|axis| Direction::Axis(axis, 1.0));
        let upright = axes.map(|axis| {
            let why = format!("{}{IS_UP}{SURELY}: it is tried", axis.text());
            Guessed { up: Some((axis, why)), ..in_motion.clone() }
        });
        let all = [stepped, &Guessed::default(), &at_once, &in_motion];
        let found = all.into_iter().chain(&upright).find(is_found).cloned().unwrap_or_default();
        Guessed { up: None, ..found }
    }

    /// What cleaning makes of a recording that starts so.
    fn tried(&self, recording: &(String, Recording)) -> Result<Cleaned, ExperimentError> {
        let alone = std::slice::from_ref(recording);
        clean(&text("draft", alone, "", std::slice::from_ref(self), &[Vec::new()]), alone)
    }

    /// At rest until its pressure steps, if the file has a pressure that begins swings.
    fn stepped(recording: &(String, Recording)) -> Self {
        let steps = Steps::of(&recording.1);
        let start = Guessed { steps, ..Guessed::default() };
        Some(start)
            .filter(|start| start.steps.is_some() && start.tried(recording).is_ok())
            .unwrap_or_default()
    }

    /// Whether something holds the rod before it is let go.
    fn is_held(&self) -> bool {
        !self.in_motion && self.steps.is_none()
    }

    /// Gives all releases of a recording their instants, if a hand lowers the rod before one of them. It is not held straight
    /// then.
    fn lowered<'a>(&mut self, releases: impl Iterator<Item = &'a CleanRelease>) {
        let each: Vec<(f64, Option<f64>)> = releases.map(|of| (of.instant, lowered::let_go(of))).collect();
        if each.iter().any(|(_, later)| later.is_some()) {
            self.instants = each.iter().map(|(instant, later)| later.unwrap_or(*instant)).collect();
            self.why =
                "half a swing before the first turn; before that the tip moves as if a hand lowered it";
            self.angle = None;
        }
    }
}

/// What cleaning makes of recordings by a draft.
fn clean(draft: &str, recordings: &[(String, Recording)]) -> Result<Cleaned, ExperimentError> {
    let experiment = Experiment::parse(Path::new("experiment.toml"), draft, &[])?;
    clean_all(&experiment, recordings.iter().map(|(_, recording)| recording.clone()).collect())
}

fn start(out: &mut String, guessed: &Guessed) {
    if !guessed.instants.is_empty() {
        let to_a_millisecond = |instant: &f64| format!("\"{} s\"", (1e3 * instant).round() / 1e3);
        let instants: Vec<String> = guessed.instants.iter().map(to_a_millisecond).collect();
        let _ = writeln!(out, "instants = [{}]   # GUESS: {}", instants.join(", "), guessed.why);
    }
    let knows_up = up(out, guessed.up.as_ref());
    match guessed.angle {
        _ if guessed.steps.is_some() => {
            *out += "start = \"rest\"   # GUESS: the tip is at rest before the pressure steps\n";
        }
        _ if guessed.in_motion => {
            *out += "start = \"in motion\"   # GUESS: the file has no hold, and begins in mid-swing\n"
        }
        Some(held) => {
            let sure = if knows_up && held.abs() <= -LEVEL.start() { "surely" } else { "perhaps" };
            let _ = writeln!(
                out,
                "angle = \"0 deg\"   # GUESS, {sure}: held straight and level (seen at {:.1} deg); what the tip marker stands off\n\
                 \x20                 # the rod's end is then taken off. Switch off if it was not held straight.",
                held.to_degrees()
            );
        }
        None => {
            *out += "# angle = \"0 deg\"   # if the rod was held straight: its angle above the level. Without it the rod\n\
                     \x20                 # is held bent by a hand, and its posture follows from the markers\n"
        }
    }
}

/// The axis that is up, switched off where the rod's angle may still decide otherwise; whether it is known.
fn up(out: &mut String, up: Option<&(Direction, String)>) -> bool {
    let Some((axis, what)) = up else {
        *out += "# up = \"+z\"         # FILL IN: against gravity\n";
        return false;
    };
    let why = what.split_once(IS_UP).map_or(what.as_str(), |(_, why)| why);
    let is_sure = why.starts_with(SURELY);
    let (switch, or) =
        if is_sure { ("", "") } else { ("# ", "; say it, or rod.base_angle, if it is not so") };
    let _ = writeln!(out, "{switch}up = \"{}\"   # GUESS, {}{or}", axis.text(), escaped(why));
    is_sure
}

/// The name of a file without its folders.
fn base_name(file: &str) -> &str {
    file.rsplit(['/', '\\']).next().unwrap_or(file)
}

fn pressure(out: &mut String, file: &str) {
    match number_before(base_name(file), &["psi", "kpa", "mbar", "bar"]) {
        Some((number, unit)) => {
            let unit = if unit == "kpa" { "kPa" } else { unit };
            let _ = writeln!(out, "pressure = \"{number} {unit}\"   # GUESS: from the file's name");
        }
        None => *out += "# pressure = \"… psi\"   # FILL IN, if there is one: gauge pressure\n",
    }
}

fn payload(out: &mut String, file: &str) {
    match number_before(base_name(file), &["kg", "g"]) {
        Some((number, unit)) => {
            let _ = writeln!(out, "payload = \"{number} {unit}\"   # GUESS: from the file's name");
        }
        None => *out += "# payload = \"… g\"      # what hung on the tip beside its end fitting\n",
    }
}

/// A number right before one of some units that end a word, such as `15psi` or `300g`.
fn number_before<'a>(name: &str, units: &[&'a str]) -> Option<(String, &'a str)> {
    let lower = name.to_lowercase();
    for unit in units {
        for (at, _) in lower.match_indices(unit) {
            let ends = lower[at + unit.len()..].chars().next().is_none_or(|c| !c.is_alphanumeric());
            let before = lower[..at].trim_end_matches([' ', '_', '-']);
            let digits = before.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.');
            let number = before[digits.len()..].trim_start_matches('.');
            if ends && !number.is_empty() && number.parse::<f64>().is_ok() {
                return Some((number.to_owned(), unit));
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use efam_recordings::parse;

    use super::*;

    /// A tip that swings about a rest and is let go at 0.1 s of a rod of 0.2 m, from `z` m; seen from `from` on.
    fn swing(z: f64, from: f64) -> Recording {
        let mut text = "t_s,A_x_m,A_y_m,A_z_m\n".to_owned();
        for k in 0..400 {
            let time = from + 0.01 * f64::from(k);
            let since = (time - 0.1).max(0.0);
            let height = -0.05 + (z + 0.05) * (-0.5 * since).exp() * (8.0 * since).cos();
            text += &format!(
                "{:.2},{:.9},0,{height:.9}\n",
                0.01 * f64::from(k),
                (0.04f64 - height * height).sqrt()
            );
        }
        parse(text.into_bytes(), Path::new("a.csv"), &ReadOptions::default()).expect("a table")
    }

    #[test]
    fn a_start_is_guessed_from_the_recording() {
        let draft =
            |recording: Recording| draft("name", &[("a.csv".to_owned(), recording)], &ReadOptions::default());
        let level = draft(swing(0.01, -0.4));
        assert!(
            level.contains("\nangle = \"0 deg\"   # GUESS, surely") && !level.contains("\ninstants"),
            "{level}"
        );
        assert!(level.contains("\nup = \"+z\"   # GUESS, surely: "), "{level}");
        let bent = draft(swing(-0.03, -0.4));
        assert!(bent.contains("\n# angle = ") && !bent.contains("\ninstants"), "{bent}");
        let at_once = draft(swing(0.01, 0.1));
        assert!(
            at_once.contains("\ninstants = [\"0 s\"]   # GUESS") && at_once.contains("\n# angle"),
            "{at_once}"
        );
    }

    /// A recording of the path of a tip, in metres: a height over time beside 0.4 m.
    fn tip(height: impl Fn(f64) -> f64) -> (String, Recording) {
        let mut text = "t_s,A_x_m,A_y_m,A_z_m\n".to_owned();
        for time in (0..900).map(|k| 0.01 * f64::from(k)) {
            text += &format!("{time:.2},0.4,0.01,{:.9}\n", height(time));
        }
        let file = Path::new("a.csv");
        ("a.csv".to_owned(), parse(text.into_bytes(), file, &ReadOptions::default()).expect("a table"))
    }

    /// A drift, and a bump between two rests, are no swing of a rod that is let go at the first sample; a swing in full motion is
    /// one, though nothing says which way is up.
    #[test]
    fn what_does_not_swing_has_no_start() {
        let draft = |own: (String, Recording)| draft("name", &[own], &ReadOptions::default());
        for still in [draft(tip(|t| 1e-3 * t)), draft(tip(|t| 0.01 * (-((t - 4.0) / 0.5).powi(2)).exp()))] {
            assert!(still.contains("NOT YET USABLE") && !still.contains("\ninstants"), "{still}");
            assert!(!still.contains("\nstart"), "{still}");
        }
        let swing = draft(tip(|t| -0.14 + 0.1 * (-0.4 * t).exp() * (10.0 * t + 1.2).cos()));
        assert!(swing.contains("\nstart = \"in motion\"") && swing.contains("which way is up"), "{swing}");
    }

    #[test]
    fn pressure_and_payload_are_read_from_a_files_name_and_nothing_else_is() {
        for (name, pressure) in [
            ("15psi.csv", Some(("15", "psi"))),
            ("run_2.5 bar-b.csv", Some(("2.5", "bar"))),
            ("100mbar.c3d", Some(("100", "mbar"))),
            ("psi.csv", None),
            ("3psia.csv", None),
        ] {
            let found = number_before(name, &["psi", "kpa", "mbar", "bar"]);
            assert_eq!(found, pressure.map(|(number, unit)| (number.to_owned(), unit)), "{name}");
        }
        assert_eq!(number_before("manual_300gram.csv", &["kg", "g"]), None, "a word goes on");
        assert_eq!(number_before("manual_300g_id00.csv", &["kg", "g"]), Some(("300".to_owned(), "g")));
    }

    /// What cannot be cleaned still gives a file that loads, and says why.
    #[test]
    fn a_draft_loads_whatever_the_recording() {
        for rows in ["0.0,0,0,0,1,1,1\n0.01,0,0,0,1,1,1\n", "0.0,,,,,,\n0.01,,,,1,1,1\n"] {
            let text = format!("t_s,A_x_m,A_y_m,A_z_m,B_x_m,B_y_m,B_z_m\n{rows}");
            let Ok(recording) = parse(text.into_bytes(), Path::new("a.csv"), &ReadOptions::default()) else {
                continue;
            };
            let draft = draft("name", &[("a b/\"c\".csv".to_owned(), recording)], &ReadOptions::default());
            assert!(draft.contains("NOT YET USABLE"), "{draft}");
            Experiment::parse(Path::new("e.toml"), &draft, &[])
                .unwrap_or_else(|error| panic!("{error}\n{draft}"));
        }
    }
}
