//! What files of all dialects hold: a drawn swing, and whether it was read back.

use efam_recordings::{Length, Recording};

/// Reproducible draws.
pub struct Draw(u64);

impl Draw {
    /// A draw of its own for each seed.
    pub fn new(seed: u64) -> Self {
        let mut draw = Self(seed.wrapping_mul(7919).wrapping_add(1));
        draw.below(2);
        draw
    }

    /// A whole number below another.
    pub fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n
    }

    /// One of several.
    pub fn of<T: Clone>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())].clone()
    }

    /// Heads or tails.
    pub fn is(&mut self) -> bool {
        self.below(2) == 0
    }
}

/// What is written, whatever the dialect.
#[derive(Debug)]
pub struct Swing {
    /// Of the markers.
    pub names: Vec<String>,
    /// In the file's unit; nothing where lost.
    pub places: Vec<Vec<Option<[f64; 3]>>>,
    /// Hz
    pub rate: f64,
    /// Of the places.
    pub unit: Length,
}

impl Swing {
    /// Two or three markers with gaps.
    pub fn draw(draw: &mut Draw) -> Self {
        let all = [["tip", "base", "mid"], ["Tip 1", "base2", "q1"], ["A:tip", "A:base", "A:mid"]];
        let names: Vec<String> =
            draw.of(&all)[..2 + draw.below(2)].iter().map(|name| (*name).to_owned()).collect();
        let samples = 40 + draw.below(60);
        let gaps: Vec<usize> = (0..draw.below(4)).map(|_| draw.below(samples)).collect();
        let (long, from) = (draw.is(), draw.below(samples));
        let phase = draw.below(100) as f64;
        let place = |marker: usize, k: usize| {
            let is_lost = marker == 0 && (gaps.contains(&k) || long && (from..from + 6).contains(&k));
            let t = k as f64 + phase;
            let eighths = |value: f64| (8.0 * value).round() / 8.0;
            let swing = [
                400.0 - (0.3 * t).sin() * 30.0 / (marker + 1) as f64,
                20.0 + (0.7 * t).cos(),
                -40.0 + 90.0 * (0.3 * t).cos(),
            ];
            (!is_lost).then_some(swing.map(eighths))
        };
        let places =
            (0..names.len()).map(|marker| (0..samples).map(|k| place(marker, k)).collect()).collect();
        let unit = draw.of(&[Length::Millimetre, Length::Metre, Length::Centimetre, Length::Inch]);
        Self { names, places, rate: draw.of(&[25.0, 50.0, 100.0, 120.0, 240.0, 500.0]), unit }
    }

    /// How many.
    pub fn samples(&self) -> usize {
        self.places[0].len()
    }

    /// Without y.
    pub fn flat(mut self) -> Self {
        for place in self.places.iter_mut().flatten().flatten() {
            place[1] = 0.0;
        }
        self
    }
}

/// Whether a recording is what was written.
pub fn compare(swing: &Swing, found: &Recording, metres: impl Fn(f64) -> f64) -> Result<(), String> {
    let names: Vec<&str> = found.markers.iter().map(|marker| marker.name.as_str()).collect();
    if names != swing.names {
        return Err(format!("names {names:?}"));
    }
    if (found.rate_hz / swing.rate - 1.0).abs() > 1e-4 {
        return Err(format!("rate {}", found.rate_hz));
    }
    for (marker, places) in found.markers.iter().zip(&swing.places) {
        if marker.position.len() != places.len() {
            return Err(format!("{} samples of {}", marker.position.len(), places.len()));
        }
        for (k, (found, written)) in marker.position.iter().zip(places).enumerate() {
            if *found != written.map(|at| at.map(&metres)) {
                return Err(format!("{} in sample {k}: {found:?} for {written:?}", marker.name));
            }
        }
    }
    Ok(())
}

/// A number with one of the decimal signs.
pub fn number(value: f64, sign: char) -> String {
    value.to_string().replace('.', &sign.to_string())
}

/// A length of a unit in metres, as recordings are to have it.
pub fn metres(unit: Length) -> impl Fn(f64) -> f64 {
    // With one rounding: 1000 is an exact number, 0.001 is none.
    let per_metre = (1.0 / unit.metres()).round();
    let divides = (per_metre * unit.metres() - 1.0).abs() < f64::EPSILON;
    move |value| if divides { value / per_metre } else { value * unit.metres() }
}
