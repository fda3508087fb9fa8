//! When samples were taken: from times, from frame numbers, or from the rate alone.

use std::ops::Range;

use efam_core::quantile::quantile;

use super::error::RecordingProblem;

/// Share of a step by which times may be off before they count as uneven.
const EVEN: f64 = 0.02;
/// Share by which the stated rate may differ from what times show.
const AGREES: f64 = 0.01;
/// Steps are multiples of one if this share of them is within a quarter of it.
const LATTICE: f64 = 0.95;

/// What a file states about its clock; empty where it states nothing.
pub(super) struct Stated<'a> {
    pub frames: &'a [f64],
    /// s
    pub times: &'a [f64],
    /// Hz, positive.
    pub rate: Option<f64>,
    pub samples: usize,
}

/// Time of each sample, s, ascending; and samples a second.
#[derive(Debug)]
pub(super) struct Clock {
    pub rate_hz: f64,
    pub time: Vec<f64>,
}

impl Stated<'_> {
    /// The clock, with a wanted rate over the stated one; `place` says where a sample is.
    pub(super) fn clock(
        &self,
        wanted: Option<f64>,
        place: &dyn Fn(usize) -> String,
        findings: &mut Vec<String>,
    ) -> Result<Clock, RecordingProblem> {
        if let Some(value) = wanted.filter(|rate| !(rate.is_finite() && *rate > 0.0)) {
            return Err(RecordingProblem::Rate { value });
        }
        // A rate that is stated overrules the file's times.
        ascending(self.frames, "frame", place)?;
        if wanted.is_none() {
            ascending(self.times, "time in s", place)?;
        }
        let clock = match (wanted, self.rate) {
            (None, _) if !self.times.is_empty() => self.by_times(findings)?,
            (Some(rate), _) | (None, Some(rate)) => {
                let frame = |sample: usize| match self.frames.first() {
                    None => sample as f64,
                    Some(first) => self.frames[sample] - first,
                };
                let time = (0..self.samples).map(|sample| frame(sample) / rate).collect();
                let source = match (wanted, self.frames.first()) {
                    (Some(_), _) if !self.times.is_empty() => {
                        "as requested; the file's own times are set aside".to_owned()
                    }
                    (Some(_), _) => "as requested".to_owned(),
                    (None, Some(first)) => {
                        format!("as the file states; it has no times: frame {first} is time 0")
                    }
                    (None, None) => {
                        "as the file states; it has no times: the first sample is time 0".to_owned()
                    }
                };
                findings.push(format!("rate: {} Hz, {source}", plain(rate)));
                Clock { rate_hz: rate, time }
            }
            (None, None) => return Err(RecordingProblem::NoRate),
        };
        // Rates beyond all measure can leave no difference between times.
        ascending(&clock.time, "time in s", place)?;
        clock.resolves()?;
        let is_by_times = wanted.is_none() && !self.times.is_empty();
        let whole = if is_by_times { whole_steps(&clock.time) } else { clock.whole_steps() };
        clock.steps(&whole, self.frames, place, findings);
        Ok(clock)
    }

    fn by_times(&self, findings: &mut Vec<String>) -> Result<Clock, RecordingProblem> {
        let shown = rate_of(self.times);
        let (rate_hz, finding) = match self.rate {
            None => (shown, format!("{} Hz, as the times show", plain(shown))),
            Some(stated) if (stated / shown - 1.0).abs() <= AGREES => {
                (stated, format!("{} Hz, as the file states and its times show", plain(stated)))
            }
            Some(stated) => {
                let (stated, is) = (plain(stated), plain(shown));
                (shown, format!("{is} Hz, as the times show, though the file states {stated} Hz"))
            }
        };
        findings.push(format!("rate: {finding}"));
        if rate_hz.is_finite() && rate_hz > 0.0 {
            Ok(Clock { rate_hz, time: self.times.to_vec() })
        } else {
            Err(RecordingProblem::NoRate)
        }
    }
}

impl Clock {
    /// Whether its times have digits enough to resolve a step: a number has 53 binary ones.
    fn resolves(&self) -> Result<(), RecordingProblem> {
        let largest = self.time.iter().fold(0.0, |largest: f64, time| largest.max(time.abs()));
        if f64::EPSILON * largest * self.rate_hz <= EVEN {
            Ok(())
        } else {
            Err(RecordingProblem::Unresolved { time: plain(largest), step: plain(self.rate_hz.recip()) })
        }
    }

    /// How many steps of a known rate each sample is after the one before.
    fn whole_steps(&self) -> Vec<f64> {
        let whole = |pair: &[f64]| ((pair[1] - pair[0]) * self.rate_hz).round().max(1.0);
        self.time.windows(2).map(whole).collect()
    }

    /// Says where samples are missing, and whether the others are evenly spaced.
    fn steps(
        &self,
        whole: &[f64],
        frames: &[f64],
        place: &dyn Fn(usize) -> String,
        findings: &mut Vec<String>,
    ) {
        let (mut jumps, mut missing, mut longest) = (0, 0.0, (0.0, 0));
        let (mut least, mut most, mut worst) = (f64::INFINITY, 0.0_f64, 0.0_f64);
        for (sample, (pair, whole)) in self.time.windows(2).zip(whole).enumerate() {
            let (step, whole) = ((pair[1] - pair[0]) * self.rate_hz, *whole);
            worst = worst.max((step - whole).abs());
            if whole > 1.0 {
                jumps += 1;
                missing += whole - 1.0;
                longest = if whole > longest.0 { (whole, sample + 1) } else { longest };
            } else {
                (least, most) = (least.min(step), most.max(step));
            }
        }
        if jumps > 0 {
            let (whole, sample) = longest;
            let from_to = if frames.is_empty() {
                format!("{} s to {} s", plain(self.time[sample - 1]), plain(self.time[sample]))
            } else {
                format!("frame {} to {}", frames[sample - 1], frames[sample])
            };
            findings.push(format!(
                "samples are left out in {jumps} places, {} in all; the longest jump is {} samples, \
                 from {from_to} ({})",
                plain(missing),
                plain(whole - 1.0),
                place(sample)
            ));
        }
        if worst > EVEN {
            let ms = |steps: f64| plain(1e3 * steps / self.rate_hz);
            let range = if least.is_finite() {
                format!("between {} and {} ms", ms(least), ms(most))
            } else {
                "of no common measure".to_owned()
            };
            findings.push(format!("times are not even: steps are {range}, {} ms on the whole", ms(1.0)));
        }
    }
}

fn ascending(
    values: &[f64],
    what: &'static str,
    place: &dyn Fn(usize) -> String,
) -> Result<(), RecordingProblem> {
    // What is no number does not ascend, either.
    let ascends = |pair: &[f64]| pair[1] > pair[0];
    let Some(at) = values.windows(2).position(|pair| !ascends(pair)) else { return Ok(()) };
    Err(RecordingProblem::Order { place: place(at + 1), what, before: values[at], after: values[at + 1] })
}

/// Adds a day to times of the day, s, from midnight on.
pub(super) fn over_midnight(times: &mut [f64]) {
    if !times.iter().all(|time| (0.0..DAY).contains(time)) {
        return;
    }
    // A clock that is set back falls by less.
    let is_midnight = |pair: &[f64]| pair[0] - pair[1] > 0.9 * DAY;
    if let Some(at) = times.windows(2).position(is_midnight) {
        times[at + 1..].iter_mut().for_each(|time| *time += DAY);
    }
}

/// s
const DAY: f64 = 86_400.0;

/// Turns times into seconds that are so many ms, µs or ns since 1970 that they are of no other time; says so.
pub(super) fn since_1970(times: &mut [f64], column: &str) -> Option<String> {
    let (unit, second) = [("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)]
        .into_iter()
        .find(|(_, second)| times.iter().all(|time| THESE_YEARS.contains(&(time * second))))?;
    times.iter_mut().for_each(|time| *time *= second);
    Some(format!(
        "time: `{column}` states no unit; it is {unit} since 1970, in the year {:.0}",
        1970.0 + (times[0] / YEAR).floor()
    ))
}

/// 2000 to 2065, s since 1970.
const THESE_YEARS: Range<f64> = 30.0 * YEAR..95.0 * YEAR;
/// s
const YEAR: f64 = 365.2425 * DAY;

/// Whether each value is more than the one before.
pub(super) fn ascends(values: &[f64]) -> bool {
    values.windows(2).all(|pair| pair[1] > pair[0])
}

/// Samples a second: whole steps over the time that they take.
pub(super) fn rate_of(times: &[f64]) -> f64 {
    let whole: f64 = whole_steps(times).iter().sum();
    let rate = whole / (times[times.len() - 1] - times[0]);
    // Times are decimal: 99.99999999999 Hz is 100 Hz.
    if (rate - rate.round()).abs() <= 1e-6 * rate { rate.round() } else { rate }
}

/// How many steps of the clock each sample is after the one before.
///
/// Where steps are multiples of one, up to rounding, the longer ones have left samples out. Where they scatter, a step
/// counts as one unless it is longer than the scatter explains: a program that logs in a loop is late at times, and
/// leaves nothing out.
fn whole_steps(times: &[f64]) -> Vec<f64> {
    let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let part = |share: f64| quantile(steps.clone(), share).unwrap_or(f64::NAN);
    let [low, median, high] = [0.1, 0.5, 0.9].map(part);
    let mean_below = |limit: f64| {
        let single: Vec<f64> = steps.iter().copied().filter(|step| *step < limit).collect();
        single.iter().sum::<f64>() / single.len() as f64
    };
    // Times may be rounded to the step's own size: those between neighbours say what a step is on
    // the whole, and that step how many a jump has.
    let step = mean_below(1.5 * median);
    let is_multiple = |own: &&f64| ((*own / step).round().max(1.0) - *own / step).abs() < 0.25;
    if steps.iter().filter(is_multiple).count() as f64 >= LATTICE * steps.len() as f64 {
        return steps.iter().map(|own| (own / step).round().max(1.0)).collect();
    }
    let longest_single = median + (0.5 * median).max(2.0 * (high - low));
    let step = mean_below(longest_single);
    let whole = |own: &f64| if *own < longest_single { 1.0 } else { (own / step).round().max(1.0) };
    steps.iter().map(whole).collect()
}

/// A number with six digits at most, without zeros at its end.
pub(super) fn plain(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude != 0.0 && !(1e-3..1e6).contains(&magnitude) {
        return format!("{value:.4e}");
    }
    let digits = 5 - magnitude.max(1e-3).log10().floor() as i32;
    let text = format!("{value:.*}", digits.clamp(0, 9) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(stated: &Stated, wanted: Option<f64>) -> (Clock, Vec<String>) {
        let mut findings = Vec::new();
        let clock = stated.clock(wanted, &|sample| format!("line {}", sample + 2), &mut findings).unwrap();
        (clock, findings)
    }

    #[test]
    fn a_rate_comes_from_rounded_times_and_over_jumps() {
        // 120 Hz to three decimals, as spreadsheets round it; ten samples are left out.
        let times: Vec<f64> =
            (0..600).filter(|k| !(100..110).contains(k)).map(|k| (k as f64 / 0.12).round() / 1e3).collect();
        let (clock, findings) = clock(&Stated { frames: &[], times: &times, rate: None, samples: 590 }, None);
        // The last time is rounded by at most 0.5 ms of 5 s.
        assert!((clock.rate_hz - 120.0).abs() < 120.0 * 1e-4, "{}", clock.rate_hz);
        assert!(findings[1].starts_with("samples are left out in 1 places, 10 in all"), "{findings:?}");
        assert!(findings[2].starts_with("times are not even: steps are between 8 and 9 ms"), "{findings:?}");
    }

    /// A loop that is late at times, and a clock of whole milliseconds at 400 Hz, with and without a gap.
    #[test]
    fn an_uneven_clock_leaves_nothing_out() {
        let late = |k: usize| 0.002 * ((k * k * 7 % 19) as f64 / 18.0);
        let times: Vec<f64> = (0..400).map(|k| k as f64 * 0.005 + late(k)).collect();
        let stated =
            |times: &[f64]| clock(&Stated { frames: &[], times, rate: None, samples: times.len() }, None);
        let (found, findings) = stated(&times);
        assert!((found.rate_hz / 200.0 - 1.0).abs() < 1e-3, "{}", found.rate_hz);
        assert!(!findings.iter().any(|finding| finding.contains("left out")), "{findings:?}");
        assert!(findings.iter().any(|finding| finding.contains("times are not even")), "{findings:?}");
        for without in [0..0, 300..330] {
            let kept = (0..800).filter(|k| !without.contains(k));
            let times: Vec<f64> = kept.map(|k| (k as f64 * 2.5).floor() / 1e3).collect();
            let (found, findings) = stated(&times);
            assert!((found.rate_hz / 400.0 - 1.0).abs() < 1e-3, "{} {without:?}", found.rate_hz);
            let is_said = findings.iter().any(|finding| finding.contains("left out in 1 places, 30 in all"));
            assert_eq!(is_said, !without.is_empty(), "{findings:?}");
        }
    }

    #[test]
    fn a_jump_of_frames_is_one_of_time() {
        let frames = [695.0, 696.0, 700.0];
        let stated = Stated { frames: &frames, times: &[], rate: Some(100.0), samples: 3 };
        let (from_file, findings) = clock(&stated, None);
        assert_eq!(from_file.time, [0.0, 0.01, 0.05]);
        assert!(findings[1].ends_with("from frame 696 to 700 (line 4)"), "{findings:?}");
        assert_eq!(clock(&stated, Some(50.0)).0.time, [0.0, 0.02, 0.1]);
    }

    #[test]
    fn a_stated_rate_that_times_contradict_is_said() {
        let times: Vec<f64> = (0..5).map(|k| k as f64 * 0.02).collect();
        let stated = Stated { frames: &[], times: &times, rate: Some(100.0), samples: 5 };
        let (clock, findings) = clock(&stated, None);
        assert_eq!(clock.rate_hz, 50.0);
        assert_eq!(findings, ["rate: 50 Hz, as the times show, though the file states 100 Hz"]);
    }

    #[test]
    fn numbers_are_printed_plainly() {
        for (value, text) in
            [(100.0, "100"), (119.88, "119.88"), (8.333333333, "8.33333"), (0.0, "0"), (1e9, "1.0000e9")]
        {
            assert_eq!(plain(value), text);
        }
    }
}
