//! Recordings made up for the tests of cleaning.

/// Reproducible noise.
pub struct Noise(u64);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as f64 + 0.5) / (1u64 << 31) as f64
    }

    /// Of a normal distribution, by Box and Muller.
    pub fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }

    /// Adds noise of a standard deviation to each coordinate of a path.
    pub fn disturb(&mut self, path: &mut Seen, sigma: f64) {
        for point in path.iter_mut().flatten() {
            (0..3).for_each(|k| point[k] += sigma * self.normal());
        }
    }
}

type Seen = Vec<Option<[f64; 3]>>;

/// Where the tip is, from its hold, 0, over its rest, 1, to beyond.
pub fn along(u: f64, length: f64) -> [f64; 3] {
    [length - 0.05 * u * u, 0.0, -0.12 * u]
}

/// A swing from rest at 0 about 1.
fn swing(t: f64, omega: f64) -> f64 {
    let zeta: f64 = 0.05;
    let damped = omega * (1.0 - zeta * zeta).sqrt();
    1.0 - (-zeta * omega * t).exp() * ((damped * t).cos() + zeta * omega / damped * (damped * t).sin())
}

/// A tip that is held level at `length` until `instant`, and swings about 12 cm below.
pub fn falling_swing(instant: f64, duration: f64, length: f64, omega: f64, step: f64) -> (Vec<f64>, Seen) {
    let time: Vec<f64> = (0..(duration / step) as usize).map(|i| step * i as f64).collect();
    let u = |t: f64| if t < instant { 0.0 } else { swing(t - instant, omega) };
    let path = time.iter().map(|t| Some(along(u(*t), length))).collect();
    (time, path)
}

/// The same raised by hand and let go several times; with each the instant of release, and that at
/// which it is raised again or the recording ends.
pub fn raised_and_released(cycles: usize) -> (Vec<f64>, Seen, Vec<(f64, f64)>) {
    const REST: f64 = 1.0;
    const RAISE: f64 = 1.4;
    const HOLD: f64 = 0.8;
    const SWING: f64 = 9.003;
    let whole = REST + RAISE + HOLD + SWING;
    let time: Vec<f64> = (0..(whole * cycles as f64 / 0.01) as usize).map(|i| 0.01 * i as f64).collect();
    let u = |t: f64| {
        let phase = t % whole;
        if phase < REST {
            1.0
        } else if phase < REST + RAISE {
            0.5 + 0.5 * (std::f64::consts::PI * (phase - REST) / RAISE).cos()
        } else if phase < REST + RAISE + HOLD {
            0.0
        } else {
            swing(phase - REST - RAISE - HOLD, 8.0)
        }
    };
    let path = time.iter().map(|t| Some(along(u(*t), 0.2))).collect();
    let instants = (0..cycles).map(|k| {
        let instant = whole * k as f64 + REST + RAISE + HOLD;
        (instant, instant + SWING + if k + 1 < cycles { REST } else { 0.0 })
    });
    (time, path, instants.collect())
}

mod whole {
    use std::path::Path;

    use efam_recordings::{ReadOptions, parse};

    use super::*;
    use crate::cleaning::{Cleaned, clean_all};
    use crate::experiment::Experiment;
    use crate::release::Point;

    const ROD: &str = "[rod]\nlength = \"190 mm\"\nmass = \"24 g\"\nbending_stiffness = \"0.007 N m^2\"\n\
        axial_stiffness = \"300 N\"\ntip = \"10 mm\"\n";

    /// The swing of a tip and of a marker half-way, in a file whose axes are those of W in `order` with
    /// `signs`, and whose origin is elsewhere.
    fn cleaned(order: [usize; 3], signs: [f64; 3], extra: &str) -> Result<Cleaned, String> {
        let (time, path) = falling_swing(1.2345, 8.0, 0.2, 8.0, 0.01);
        let file = |at: [f64; 3]| -> String {
            let mut out = [0.0; 3];
            (0..3).for_each(|k| out[order[k]] = 0.5 + signs[k] * at[k]);
            format!(",{},{},{}", out[0], out[1], out[2])
        };
        let names = ["Tip", "Half", "Base"].map(|m| format!(",{m}_x_m,{m}_y_m,{m}_z_m"));
        let mut text = format!("t_s{}\n", names.concat());
        for (t, at) in time.iter().zip(path) {
            let [x, _, z] = at.unwrap_or_default();
            // The tip marker sits 22 mm above the axis of the rod, the other on it.
            let points = [[x, 0.0, z + 0.022], [0.5 * x, 0.001, 0.3 * z], [0.0; 3]];
            text += &format!("{t:.2}{}\n", points.map(file).concat());
        }
        let recording = parse(text.into_bytes(), Path::new("a.csv"), &ReadOptions::default());
        let experiment =
            format!("{ROD}[[recording]]\nfile = \"a.csv\"\ntip = \"Tip\"\nbase = \"Base\"\n{extra}\n");
        let experiment =
            Experiment::parse(Path::new("e.toml"), &experiment, &[]).map_err(|e| e.to_string())?;
        clean_all(&experiment, vec![recording.map_err(|e| e.to_string())?]).map_err(|e| e.to_string())
    }

    /// Whatever axis of the file is vertical, and whichever way it points, W is the same.
    #[test]
    fn the_frame_is_found_in_any_orientation_of_the_file() {
        for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0], [0, 2, 1]] {
            for signs in [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0]] {
                let cleaned =
                    cleaned(order, signs, "body = [{ marker = \"Half\", at = \"95 mm\" }]").unwrap();
                let release = &cleaned.releases[0].release;
                let tip = &release.tracks[0];
                assert_eq!((tip.at, release.tracks[1].at), (Point::Tip, Point::Along(0.5)));
                for (time, at) in release.time.iter().zip(&tip.position) {
                    let [x, z] = at.unwrap();
                    let u = if *time < 0.0 { 0.0 } else { swing(*time, 8.0) };
                    let expected = along(u, 0.2);
                    // The instant is found to a fifth of a sample; the tip then moves at 1 m/s at most.
                    let off = (x - expected[0]).hypot(z - expected[2] - 0.022);
                    assert!(off < 2e-3, "{order:?} {signs:?}: {off} at {time} s");
                }
                assert!(cleaned.decisions.iter().any(|decision| decision.key == "up"));
            }
        }
    }

    #[test]
    fn a_straight_hold_gives_the_offset_of_the_marker_and_none_is_taken_off_unasked() {
        let hold = |extra: &str| {
            let cleaned = cleaned([0, 1, 2], [1.0; 3], extra).unwrap();
            let statistics = &cleaned.releases[0].statistics;
            (statistics.hold, statistics.offset)
        };
        let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9;
        let (held, offset) = hold("");
        assert!(near(held, [0.2, 0.022]) && near(offset, [0.0; 2]), "{held:?} {offset:?}");
        let (held, offset) = hold("angle = \"0 deg\"");
        assert!(near(held, [0.2, 0.0]) && near(offset, [0.0, 0.022]), "{held:?} {offset:?}");
        let (held, _) = hold("angle = \"0 deg\"\noffset = [\"1 mm\", \"20 mm\"]");
        assert!(near(held, [0.199, 0.002]), "{held:?}");
        // A rod that is held in another direction has no such offset.
        let beside = cleaned([0, 1, 2], [1.0; 3], "angle = \"60 deg\"").unwrap_err();
        assert!(beside.contains("check up, unit, angle and clamp under recording[1]"), "{beside}");
    }

    #[test]
    fn what_the_experiment_says_holds() {
        let told = cleaned(
            [0, 1, 2],
            [1.0; 3],
            "up = \"+z\"\nalong = \"+x\"\nclamp = [\"0.4 m\", \"0.5 m\", \"0.5 m\"]\n\
            instants = [\"1.23 s\"]\nnoise = \"0.3 mm\"\nheld_out = true\nmask = [[\"2 s\", \"2.495 s\"]]",
        )
        .unwrap();
        let of = &told.releases[0];
        assert_eq!((of.instant, of.release.held_out, of.release.tracks[0].noise), (1.23, true, 3e-4));
        assert!((of.statistics.hold[0] - 0.3).abs() < 1e-9, "{:?}", of.statistics);
        assert_eq!(of.statistics.masked_samples, 50);
        let masked = |t: f64| (2.0..=2.495).contains(&(t + 1.23 + 1e-9));
        for (time, at) in of.release.time.iter().zip(&of.release.tracks[0].position) {
            assert_eq!(at.is_none(), masked(*time), "{time}");
        }
        let unknown = cleaned([0, 1, 2], [1.0; 3], "body = [{ marker = \"Halv\", at = 0.5 }]").unwrap_err();
        assert!(
            unknown.contains(
                "recording[1].body[1].marker = \"Halv\": a.csv has no marker `Halv`; did you mean `Half`?"
            ),
            "{unknown}"
        );
    }
}

/// A period of 8 s at 100 Hz, in noise of 0.3 mm that hides the speed in a window of 60 ms; and no turn of it is a hold.
#[test]
fn a_slow_rod_is_let_go_once() {
    let (time, mut path) = falling_swing(3.0, 60.0, 0.2, 0.785, 0.01);
    Noise::new(5).disturb(&mut path, 3e-4);
    let cuts = super::cycles::cut(&time, &path, 0.01, 3e-4, None).unwrap_or_else(|why| panic!("{why}"));
    assert_eq!(cuts.len(), 1, "{cuts:?}");
    assert!((time[cuts[0].hold.end] - 3.0).abs() < 0.4, "{cuts:?}");
}
