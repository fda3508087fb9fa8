//! A drawn experiment: releases at several pressures and angles, of a muscle that is not quite the one
//! that is thought, with effects hidden in it.
//!
//! A plan and a seed give one experiment, to the bit, whatever the number of threads: what is common to
//! all releases is drawn first, and each release goes on with a stream of random numbers of its own.

use std::f64::consts::TAU;

use efam_experiments::release::{OutOfPlane, Point, Release, Track};
use models::model::ModelSpec;
use rayon::prelude::*;

use super::beam::Beam;
use super::hidden::{Hidden, Occasion};
use super::motion::Motion;
use super::random::Random;
use super::specimen::Specimen;
use super::tracker::Tracker;
use super::{muscle, occasion};
use crate::{PSI, paper_spec};

/// What is done, and what is hidden.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Gauge pressures, psi.
    pub pressures: Vec<f64>,
    /// Angles above the horizontal at which the straight rod is let go at each pressure, rad.
    pub angles: Vec<f64>,
    /// Whether the clamp is turned by the same angles. If not, the rod is let go with a kink at its root,
    /// which a discrete rod resolves slowly: with 25°, 65 and 129 nodes still differ from the twin by
    /// some 0.015 mm when extrapolated, and by 0.002 mm without a kink.
    pub clamp_follows: bool,
    /// How long each release is seen, s.
    pub duration: f64,
    /// Samples a second.
    pub rate: f64,
    /// How long the held rod is seen before each release, s.
    pub hold: f64,
    /// Markers on the body, as shares of the active length, beside the tip's.
    pub body: Vec<f64>,
    /// What the tracker adds and loses.
    pub tracker: Tracker,
    /// How far off the muscle and its setup may be.
    pub priors: Priors,
    /// What differs from release to release, and what no law foresees.
    pub unrepeated: Unrepeated,
    /// Effects that the fit does not know.
    pub hidden: Vec<Hidden>,
    /// How exactly it is computed.
    pub numerics: Numerics,
}

/// Standard deviations of what is not known exactly; bounds where that is said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Priors {
    /// Bounds of EI off the table at each pressure, as a share.
    pub bending_stiffness: f64,
    /// Bounds of α, 1/s, of the whole experiment.
    pub alpha: [f64; 2],
    /// Bounds of β, s, of the whole experiment.
    pub beta: [f64; 2],
    /// Bounds of the masses of rod and fitting, as a share.
    pub mass: f64,
    /// Angle of the held rod, rad, by release.
    pub hold_angle: f64,
    /// Instant of release, s.
    pub instant: f64,
    /// Tilt of the recording's frame, rad, by pressure.
    pub tilt: f64,
    /// Offset of each marker from its place, x and z, m, by pressure.
    pub offset: f64,
}

/// What no two releases share, whatever is stated: bounds of shares, and a length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Unrepeated {
    /// Of EI.
    pub bending_stiffness: f64,
    /// Of α and of β.
    pub losses: f64,
    /// Of the size of each hidden effect.
    pub hidden: f64,
    /// How far the base, and all that is seen with it, wanders to either side, m.
    pub drift: f64,
}

/// Periods between which a base wanders, s.
const WANDERS: [f64; 2] = [5.0, 20.0];

/// Mesh and tolerance of the beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numerics {
    /// Number of elements.
    pub elements: usize,
    /// Tolerance of a step, m.
    pub tolerance: f64,
}

/// What came of a plan.
#[derive(Clone)]
pub struct Drawn {
    /// The releases, by pressure, then by angle.
    pub releases: Vec<DrawnRelease>,
    /// α, 1/s.
    pub alpha: f64,
    /// β, s.
    pub beta: f64,
}

/// One release: what a fit is given, and what it is not.
#[derive(Clone)]
pub struct DrawnRelease {
    /// What was tracked.
    pub release: Release,
    /// The muscle and its setup as they are thought to be, with 32 nodes, damping at the middle of
    /// its bounds.
    pub nominal: ModelSpec,
    /// Where each track's marker is seen without noise, losses and ghosts, m, shape `[tracks][samples]`.
    pub truth: Vec<Vec<[f64; 2]>>,
    /// EI, N m², before effects.
    pub bending_stiffness: f64,
    /// How much later the release is than the estimate that times count from, s.
    pub late: f64,
}

impl Default for Priors {
    fn default() -> Self {
        Self {
            bending_stiffness: 0.05,
            alpha: [0.4, 0.8],
            beta: [0.005, 0.015],
            mass: 0.01,
            hold_angle: 0.25f64.to_radians(),
            instant: 2e-3,
            tilt: 0.2e-3,
            offset: 0.2e-3,
        }
    }
}

impl Default for Numerics {
    /// For paths within 0.01 mm of finer ones.
    fn default() -> Self {
        Self { elements: 16, tolerance: 2e-7 }
    }
}

impl Plan {
    /// 15, 40 and 70 psi, from the horizontal and 25° below and above it, clamp and rod together; 8 s of
    /// the tip at 100 Hz, with 0.3 mm of noise.
    pub fn usual(hidden: &[Hidden]) -> Self {
        Self {
            pressures: vec![15.0, 40.0, 70.0],
            angles: [0.0f64, -25.0, 25.0].map(f64::to_radians).to_vec(),
            clamp_follows: true,
            duration: 8.0,
            rate: 100.0,
            hold: 0.0,
            body: Vec::new(),
            tracker: Tracker::usual(0.3e-3),
            priors: Priors::default(),
            unrepeated: Unrepeated::default(),
            hidden: hidden.to_vec(),
            numerics: Numerics::default(),
        }
    }

    /// The same from the horizontal and 25° below it alone.
    pub fn of_two_angles(hidden: &[Hidden]) -> Self {
        let usual = Self::usual(hidden);
        Self { angles: usual.angles[..2].to_vec(), ..usual }
    }

    /// The same as a laboratory has it: the release from the horizontal is made twice, no two releases are alike to better
    /// than a per cent of their motion, the base wanders, and no effect is quite as large as its law says.
    pub fn of_a_laboratory(self) -> Self {
        let unrepeated = Unrepeated { bending_stiffness: 3e-3, losses: 0.03, hidden: 0.1, drift: 0.2e-3 };
        let angles = [0.0f64, 0.0, -25.0].map(f64::to_radians).to_vec();
        Self { angles, unrepeated, ..self }
    }

    /// The same with three markers on the body.
    pub fn with_body(self) -> Self {
        Self { body: vec![0.25, 0.5, 0.75], ..self }
    }

    /// The experiment of a seed.
    /// # Panics
    /// If a pressure is not in the muscle's table, or a law softens the rod until it is unstable, as
    /// `quadratic_stiffness` does in the kink of a rod that is let go far below a level clamp.
    pub fn draw(&self, seed: u64) -> Drawn {
        let mut random = Random::new(seed);
        let Priors { alpha, beta, mass, bending_stiffness, .. } = self.priors;
        let whole = Whole {
            alpha: random.between(alpha[0], alpha[1]),
            beta: random.between(beta[0], beta[1]),
            masses: [0; 2].map(|_| 1.0 + random.between(-mass, mass)),
        };
        let recording = |psi: &f64| Recording {
            psi: *psi,
            stiffness: 1.0 + random.between(-bending_stiffness, bending_stiffness),
            tilt: self.priors.tilt * random.normal(),
            offsets: (0..=self.body.len())
                .map(|_| [0; 2].map(|_| self.priors.offset * random.normal()))
                .collect(),
        };
        let recordings: Vec<_> = self.pressures.iter().map(recording).collect();
        let each = |recording| self.angles.iter().map(move |angle| (recording, *angle));
        let mut releases: Vec<_> = recordings.iter().flat_map(each).map(|at| (at, random.branch())).collect();
        let releases = releases
            .par_iter_mut()
            .enumerate()
            .map(|(number, ((recording, angle), random))| {
                self.release(&whole, recording, *angle, number, random)
            })
            .collect();
        Drawn { releases, alpha: whole.alpha, beta: whole.beta }
    }

    fn release(
        &self,
        whole: &Whole,
        recording: &Recording,
        angle: f64,
        number: usize,
        random: &mut Random,
    ) -> DrawnRelease {
        let base = if self.clamp_follows { angle } else { 0.0 };
        let (mut beam, occasion) = self.muscle(whole, recording, base, random);
        let about = |share: f64, random: &mut Random| {
            1.0 + if share > 0.0 { random.between(-share, share) } else { 0.0 }
        };
        beam.bending_stiffness *= about(self.unrepeated.bending_stiffness, random);
        beam.alpha *= about(self.unrepeated.losses, random);
        beam.beta *= about(self.unrepeated.losses, random);
        let hidden: Vec<Hidden> =
            self.hidden.iter().map(|own| own.times(about(self.unrepeated.hidden, random))).collect();
        let wander = Wander::drawn(self.unrepeated.drift, random);
        let (bending_stiffness, tip) = (beam.bending_stiffness, beam.bodies[0].center);
        let clamp: f64 = base + hidden.iter().map(Hidden::clamp_tilt).sum::<f64>();
        let held = angle - clamp + self.priors.hold_angle * random.normal();
        let late = self.priors.instant * random.normal();
        let first = random.share() / self.rate;
        let held_samples = (self.hold * self.rate).round();
        let count = ((self.duration - first) * self.rate) as usize + held_samples as usize;
        let after: Vec<f64> = (0..count).map(|k| first + (k as f64 - held_samples) / self.rate).collect();

        let specimen = Specimen::new(beam, &hidden, &occasion);
        let motion = Motion::let_go(&specimen, held, self.duration, self.numerics.tolerance);
        let view = View { hidden: &hidden, recording, specimen: &specimen };
        let mut spots = vec![("tip".to_owned(), Point::Tip, 1.0 + tip / specimen.beam.length)];
        spots.extend(self.body.iter().map(|s| (format!("body_{:02.0}", 100.0 * s), Point::Along(*s), *s)));
        let (mut tracks, mut truth) = (Vec::new(), Vec::new());
        for (k, (marker, at, share)) in spots.into_iter().enumerate() {
            let path: Vec<_> = after
                .iter()
                .map(|t| view.see(&motion.at(*t), at, share, wander.off(recording.offsets[k], *t)))
                .collect();
            let position = self.tracker.track(&path, random);
            tracks.push(Track { marker, at, position, noise: self.tracker.noise, discrepancy: 0.0 });
            truth.push(path);
        }
        let second: f64 = hidden.iter().map(Hidden::second).product();
        let release = Release {
            name: format!("drawn#{}", number + 1),
            time: after.iter().map(|t| second * t - late).collect(),
            release_uncertainty: self.priors.instant,
            tracks,
            pressure: Some(recording.psi * PSI),
            payload: 0.0,
            held_out: false,
            out_of_plane: OutOfPlane::default(),
        };
        DrawnRelease {
            release,
            nominal: self.nominal(recording.psi, base, angle),
            truth,
            bending_stiffness,
            late,
        }
    }

    /// The muscle as it is, before effects.
    fn muscle(
        &self,
        whole: &Whole,
        recording: &Recording,
        base: f64,
        random: &mut Random,
    ) -> (Beam, Occasion) {
        let mut beam = muscle(recording.psi, self.numerics.elements, whole.alpha, whole.beta);
        beam.incline = base;
        beam.bending_stiffness *= recording.stiffness;
        beam.mass *= whole.masses[0];
        beam.bodies[0].mass *= whole.masses[1];
        (beam, occasion(recording.psi, random.between(-1.0, 1.0)))
    }

    /// The model as a fit may know it.
    fn nominal(&self, psi: f64, base_angle: f64, release_angle: f64) -> ModelSpec {
        let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
        let damping = [
            ("rayleigh_mass.alpha", middle(self.priors.alpha)),
            ("rayleigh_stiffness.beta", middle(self.priors.beta)),
        ];
        ModelSpec { base_angle, release_angle, ..paper_spec(psi, 32, &damping) }
    }
}

impl DrawnRelease {
    /// Distance of paths from the truth, rms over all tracks and samples, m; `paths` as `truth`.
    pub fn gap(&self, paths: &[Vec<[f64; 2]>]) -> f64 {
        let pairs = self.truth.iter().flatten().zip(paths.iter().flatten());
        let squares: Vec<f64> = pairs.map(|(a, b)| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }
}

/// What all releases share.
struct Whole {
    alpha: f64,
    beta: f64,
    /// Of rod and fitting, over what is thought.
    masses: [f64; 2],
}

/// What the releases at one pressure share.
struct Recording {
    psi: f64,
    /// EI over that of the table.
    stiffness: f64,
    tilt: f64,
    /// Of the tip's marker, then of those on the body.
    offsets: Vec<[f64; 2]>,
}

/// How the base wanders in x and z: amplitudes, m, angular frequencies and phases.
struct Wander([[f64; 3]; 2]);

impl Wander {
    fn drawn(drift: f64, random: &mut Random) -> Self {
        if drift == 0.0 {
            return Self([[0.0; 3]; 2]);
        }
        let axis = |random: &mut Random| {
            let [shortest, longest] = WANDERS;
            let period = random.between(shortest, longest);
            [drift, TAU / period, random.between(0.0, TAU)]
        };
        Self([axis(random), axis(random)])
    }

    /// An offset at a time after the release, s.
    fn off(&self, [x, z]: [f64; 2], time: f64) -> [f64; 2] {
        let [dx, dz] = self.0.map(|[size, frequency, phase]| size * (frequency * time + phase).sin());
        [x + dx, z + dz]
    }
}

/// What the cameras see without noise.
struct View<'a> {
    hidden: &'a [Hidden],
    recording: &'a Recording,
    specimen: &'a Specimen,
}

impl View<'_> {
    fn see(&self, q: &[f64], at: Point, share: f64, offset: [f64; 2]) -> [f64; 2] {
        let beam = &self.specimen.beam;
        let [place, gradient] = beam.axis(q, share).map(|x| turned(x, beam.incline));
        let length = gradient[0].hypot(gradient[1]);
        let tangent = (at == Point::Tip).then(|| gradient.map(|x| x / length));
        let seen = self.hidden.iter().fold(place, |place, effect| effect.see(place, tangent));
        let [x, z] = turned(seen, self.recording.tilt);
        [x + offset[0], z + offset[1]]
    }
}

/// Turned about the clamp, from x towards z, rad.
fn turned([x, z]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * z, sin * x + cos * z]
}
