//! C3D, of all three kinds of processor, as integers or floats.
//!
//! ```text
//! header, 512 bytes ─▶ parameters, from the block that byte 1 names ─▶ data, from the block in word 9
//! ```
//! A frame is `points` times x, y, z and a word of residual and cameras, then the analog samples.
//! A point is there if that word is not negative; its coordinates say nothing about that.
//! Source: The C3D File Format, User Guide, Motion Lab Systems (2008), chapters on the header, the
//! parameters, and the point data.

mod number;
mod parameters;

use number::Processor;
use parameters::Parameters;

use super::Marker;
use super::clock::plain;
use super::draft::{Draft, Unit};
use super::error::RecordingProblem;
use super::format::Format;
use super::length::Length;
use super::names::distinct;

/// Length of a block, bytes.
const BLOCK: usize = 512;
/// Byte 2 of the file, and of the parameters.
const KEY: u8 = 80;
/// The largest number that a word holds: as a last frame it says that there may be more.
const FULL: usize = 65_535;

/// Whether bytes begin as a file does whose parameters name a processor.
pub(super) fn is_c3d(bytes: &[u8]) -> bool {
    bytes.get(1) == Some(&KEY)
        && parameters::start(bytes).is_some_and(|(_, kind)| Processor::of(kind).is_some())
}

/// How the points are laid down.
#[derive(Debug)]
struct Shape {
    processor: Processor,
    /// First byte of the data.
    start: usize,
    points: usize,
    /// Analog samples in a frame, of all channels.
    analog: usize,
    /// Units of length of an integer; nothing for floats.
    scale: Option<f64>,
    first_frame: usize,
    frames: usize,
}

/// Reads a file.
pub(super) fn read(bytes: &[u8]) -> Result<Draft, RecordingProblem> {
    let broken = |text: String| RecordingProblem::C3d(text);
    if bytes.len() < BLOCK {
        return Err(broken(format!("it has {} bytes, less than its header of {BLOCK}", bytes.len())));
    }
    if bytes[1] != KEY {
        return Err(broken(format!("byte 2 is {}, not {KEY}", bytes[1])));
    }
    let (start, kind) = parameters::start(bytes)
        .ok_or_else(|| broken(format!("its parameters should be in block {}, beyond its end", bytes[0])))?;
    let processor = Processor::of(kind).ok_or_else(|| {
        broken(format!("its processor is {kind}; known are 84, 85 and 86 (Intel, DEC, MIPS)"))
    })?;
    let parameters = Parameters::read(bytes, start, processor).map_err(broken)?;
    let mut findings = Vec::new();
    let shape = shape(bytes, processor, &parameters, &mut findings).map_err(broken)?;

    let silent = Unit::Assumed(Length::Millimetre, "C3D is in millimetres as a rule");
    let unit = Unit::stated(parameters.text("POINT:UNITS").as_deref(), "POINT:UNITS", silent);
    let mut draft = Draft::new(Format::C3d, unit, "sample");
    let in_header = f64::from(processor.float(&bytes[20..24]));
    let in_parameters = parameters.number("POINT:RATE").filter(|rate| *rate > 0.0);
    draft.rate = in_parameters.or(Some(in_header));
    if let Some(rate) = in_parameters.filter(|rate| (rate - in_header).abs() > 1e-3 * rate) {
        findings.push(format!(
            "the header states {} Hz, POINT:RATE {} Hz; the latter is taken",
            plain(in_header),
            plain(rate)
        ));
    }
    draft.frames = (0..shape.frames).map(|frame| (shape.first_frame + frame) as f64).collect();
    draft.places = (1..=shape.frames as u64).collect();
    if let Some(scale) = shape.scale {
        findings.push(format!(
            "positions are whole multiples of {scale:.4} of the unit: the file holds integers"
        ));
    }
    let names = names(&parameters, shape.points, &mut findings);
    let positions = points(bytes, &shape);
    draft.markers = (names.into_iter().zip(positions))
        .map(|(name, position)| Marker { name, position, orientation: None })
        .collect();
    draft.findings = findings;
    Ok(draft)
}

/// Sizes, with every one of them checked against the length of the file.
fn shape(
    bytes: &[u8],
    processor: Processor,
    parameters: &Parameters,
    findings: &mut Vec<String>,
) -> Result<Shape, String> {
    let word = |index: usize| usize::from(processor.word(&bytes[2 * index - 2..]));
    let whole = |key: &str| parameters.number(key).filter(|value| *value >= 0.0).map(|value| value as usize);
    let (points, analog) = (word(2), word(3));
    if points == 0 {
        return Err("it has no points, only analog samples or nothing".to_owned());
    }
    if let Some(used) = whole("POINT:USED").filter(|used| *used != points) {
        findings.push(format!("the header states {points} points, POINT:USED {used}; the former is taken"));
    }
    let block = match word(9) {
        0 => whole("POINT:DATA_START").unwrap_or(0),
        block => block,
    };
    let start = block.saturating_sub(1).saturating_mul(BLOCK);
    if block < 2 || start >= bytes.len() {
        let blocks = bytes.len() / BLOCK;
        return Err(format!("its data should begin in block {block}, and it has {blocks} blocks"));
    }
    let scales = scales(f64::from(processor.float(&bytes[12..16])), parameters, findings);
    let (first, last) = (word(4), word(5));
    let stated = [
        long(parameters, "TRIAL:ACTUAL_END_FIELD").zip(long(parameters, "TRIAL:ACTUAL_START_FIELD")),
        Some((last, first)),
    ];
    // Words of the header end at 65535: of a longer recording only TRIAL states both frames.
    let (end, begin) = stated.into_iter().flatten().next().unwrap_or((last, first));
    if end < begin {
        return Err(format!("its last frame, {end}, is before its first, {begin}"));
    }
    let mut counts: Vec<usize> = stated
        .into_iter()
        .flatten()
        .filter(|(last, first)| last >= first)
        .map(|(last, first)| last - first + 1)
        .collect();
    counts.extend(
        whole("POINT:LONG_FRAMES").into_iter().chain(whole("POINT:FRAMES")).filter(|count| *count > 0),
    );
    // Word 3 may count channels instead of samples.
    let per_frame = word(10).max(1);
    let used = whole("ANALOG:USED").unwrap_or(analog);
    let channels = analog.saturating_mul(per_frame);
    let mut analogs = vec![analog];
    analogs.extend([used.saturating_mul(per_frame), channels].into_iter().filter(|other| *other != analog));
    let all: Vec<(f64, usize)> =
        scales.iter().flat_map(|scale| analogs.iter().map(|analog| (*scale, *analog))).collect();
    let size =
        |(scale, analog): (f64, usize)| if scale < 0.0 { 4 } else { 2 } * (4 * points).saturating_add(analog);
    let length = bytes.len() - start;
    // The end of the file is that of the block in which its last frame ends.
    let ends = |way: &(f64, usize)| {
        counts.iter().any(|count| {
            let taken = count.saturating_mul(size(*way));
            taken <= length && length - taken < BLOCK
        })
    };
    let stated = *all.first().ok_or("it states no scale of its points (POINT:SCALE)")?;
    let way =
        if ends(&stated) { stated } else { all.iter().copied().find(|way| ends(way)).unwrap_or(stated) };
    let (scale, analog) = way;
    if all.len() > 1 && way != stated {
        findings.push(format!(
            "the length of the file shows {analog} analog samples in a frame and points as {}; the header's word 3 is {}",
            if scale < 0.0 { "floats" } else { "integers" },
            word(3)
        ));
    }
    let frames = frames(&counts, length / size(way), last, findings)?;
    let first_frame = long(parameters, "TRIAL:ACTUAL_START_FIELD").unwrap_or(first);
    let scale = (scale > 0.0).then_some(scale);
    Ok(Shape { processor, start, points, analog, scale, first_frame, frames })
}

/// Scales of the points that the file states, the likelier one first.
fn scales(in_header: f64, parameters: &Parameters, findings: &mut Vec<String>) -> Vec<f64> {
    let is_scale = |scale: &f64| scale.is_finite() && *scale != 0.0;
    let stated = parameters.number("POINT:SCALE").filter(is_scale);
    let mut scales: Vec<f64> = stated.into_iter().chain(Some(in_header).filter(is_scale)).collect();
    if let [scale, header] = scales[..] {
        // Only its sign counts for floats.
        if scale.signum() == header.signum() && (scale < 0.0 || (scale - header).abs() <= 1e-6 * scale) {
            scales.pop();
        } else {
            findings.push(format!("the header states a scale of {header}, POINT:SCALE one of {scale}"));
        }
    }
    scales
}

/// How many of the stated counts of frames is right, where there is room for `held`; `last` is the header's last frame.
fn frames(counts: &[usize], held: usize, last: usize, findings: &mut Vec<String>) -> Result<usize, String> {
    // Words end at 65535, so the largest count that the file holds is the right one; and where a word
    // is full, the largest of all.
    let most = counts.iter().copied().max().filter(|most| last == FULL && *most > held);
    let fitting = counts.iter().copied().filter(|count| *count <= held && most.is_none()).max();
    let frames = match (fitting, most.or(counts.iter().copied().min())) {
        (Some(frames), _) => frames,
        (None, Some(stated)) => {
            return Err(format!("it states {stated} frames, and there is room for {held}: it is cut short"));
        }
        (None, None) => return Err("it states no frames".to_owned()),
    };
    if let Some(other) = counts.iter().find(|count| **count != frames) {
        findings.push(format!("the file states {other} frames as well as {frames}; the latter is taken"));
    }
    if last == FULL && frames <= FULL && held > frames {
        findings.push(format!(
            "the file has room for {held} frames, and states {frames}, the most that a word holds"
        ));
    }
    Ok(frames)
}

/// A number in two words, the lower first.
fn long(parameters: &Parameters, key: &str) -> Option<usize> {
    match parameters.words(key)?[..] {
        [low, high, ..] => Some(usize::from(low) + (usize::from(high) << 16)),
        [low] => Some(usize::from(low)),
        [] => None,
    }
}

/// Labels of the points: 255 in POINT:LABELS, further ones in POINT:LABELS2 and so on.
fn names(parameters: &Parameters, points: usize, findings: &mut Vec<String>) -> Vec<String> {
    let mut labels = parameters.texts("POINT:LABELS");
    for index in 2.. {
        let more = parameters.texts(&format!("POINT:LABELS{index}"));
        if more.is_empty() || labels.len() >= points {
            break;
        }
        labels.extend(more);
    }
    labels.resize(points.max(labels.len()), String::new());
    labels.truncate(points);
    let unnamed = labels.iter().filter(|label| label.is_empty()).count();
    if unnamed > 0 {
        findings.push(format!(
            "{unnamed} points have no label; they are called by their number, such as `point 1`"
        ));
    }
    let named = labels
        .into_iter()
        .enumerate()
        .map(|(index, label)| if label.is_empty() { format!("point {}", index + 1) } else { label });
    distinct(named, findings)
}

/// Positions of each point in the file's unit. What this takes follows from `shape`, which holds no
/// more frames than the file has bytes for.
fn points(bytes: &[u8], shape: &Shape) -> Vec<Vec<Option<[f64; 3]>>> {
    let processor = shape.processor;
    match shape.scale {
        Some(scale) => decode(bytes, shape, 2, |word| scale * f64::from(processor.word(word) as i16)),
        None => match processor {
            Processor::Intel => decode(bytes, shape, 4, |word| f64::from(number::intel(word))),
            Processor::Dec => decode(bytes, shape, 4, |word| f64::from(number::dec(word))),
            Processor::Mips => decode(bytes, shape, 4, |word| f64::from(number::mips(word))),
        },
    }
}

fn decode(
    bytes: &[u8],
    shape: &Shape,
    size: usize,
    value: impl Fn(&[u8]) -> f64,
) -> Vec<Vec<Option<[f64; 3]>>> {
    let mut positions: Vec<_> = (0..shape.points).map(|_| Vec::with_capacity(shape.frames)).collect();
    let frames = bytes[shape.start..].chunks_exact(size * (4 * shape.points + shape.analog));
    for frame in frames.take(shape.frames) {
        for (point, position) in frame.chunks_exact(4 * size).zip(&mut positions) {
            let at = |index: usize| value(&point[size * index..]);
            let seen = [at(0), at(1), at(2)];
            // No number is not positive, either.
            let is_valid = at(3) >= 0.0 && seen.iter().all(|value| value.is_finite());
            position.push(is_valid.then_some(seen));
        }
    }
    positions
}
