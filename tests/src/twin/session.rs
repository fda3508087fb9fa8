//! What the hand and the muscle do in one recording: hang, be raised, be held, be let go; six times.

use super::beam::Beam;
use super::motion::Motion;
use super::random::Random;

/// Of one raise and release.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycle {
    /// The hand raises the muscle for so long, s.
    pub raise: f64,
    /// And holds it for so long, s.
    pub hold: f64,
    /// Then it swings, s.
    pub swing: f64,
    /// Angle above the horizontal at which it is let go, rad.
    pub angle: f64,
}

/// How a hand holds still: a sum of two slow turns of the whole muscle, rad, that dies away before
/// the release, so that the release is from rest at its angle.
const JITTER: [(f64, f64); 2] = [(1.1, 2e-3), (2.7, 1e-3)];
/// Over this time before the release the jitter dies away, s.
const STILL: f64 = 0.3;
/// It hangs before the first raise, s.
const HANGING: f64 = 1.5;

/// The true motion over a recording.
#[derive(Clone, Debug)]
pub struct Session {
    /// The muscle.
    pub beam: Beam,
    /// Its cycles.
    pub cycles: Vec<Cycle>,
    /// Instants of release on the recording's clock, s; they fall on no sample.
    pub releases: Vec<f64>,
    motions: Vec<Motion>,
    /// Which motion a cycle shows.
    motion_of: Vec<usize>,
}

impl Session {
    /// Plays cycles with steps of `step`, s; cycles of one angle and length share one motion.
    pub fn play(beam: &Beam, cycles: &[Cycle], step: f64) -> Self {
        let mut played: Vec<(f64, Motion)> = Vec::new();
        let (mut motion_of, mut releases) = (Vec::new(), Vec::new());
        let mut clock = HANGING;
        for cycle in cycles {
            let known = played
                .iter()
                .position(|(angle, motion)| *angle == cycle.angle && motion.duration() >= cycle.swing);
            motion_of.push(known.unwrap_or(played.len()));
            if known.is_none() {
                let longest =
                    cycles.iter().filter(|c| c.angle == cycle.angle).map(|c| c.swing).fold(0.0, f64::max);
                let start = beam.straight(cycle.angle);
                played.push((cycle.angle, Motion::from_rest(beam, start, longest, step)));
            }
            releases.push(clock + cycle.raise + cycle.hold);
            clock = releases[releases.len() - 1] + cycle.swing;
        }
        let motions = played.into_iter().map(|(_, motion)| motion).collect();
        Self { beam: beam.clone(), cycles: cycles.to_vec(), releases, motions, motion_of }
    }

    /// End of the last swing, s.
    pub fn duration(&self) -> f64 {
        self.releases.last().map_or(HANGING, |release| release + self.cycles[self.cycles.len() - 1].swing)
    }

    /// The motion after a release.
    pub fn motion(&self, cycle: usize) -> &Motion {
        &self.motions[self.motion_of[cycle]]
    }

    /// The beam's coordinates at a time of the recording, s.
    pub fn at(&self, time: f64) -> Vec<f64> {
        let next = self.releases.iter().position(|release| time < *release);
        let last = next.unwrap_or(self.releases.len()).checked_sub(1);
        let swung = last.map(|k| time - self.releases[k]);
        match (next, swung) {
            (_, Some(t)) if t <= self.cycles[last.expect("swung")].swing || next.is_none() => {
                self.motion(last.expect("swung")).at(t)
            }
            (Some(k), _) => self.in_the_hand(k, self.releases[k] - time),
            (None, _) => self.beam.at_rest(),
        }
    }

    /// Raised and held `ahead` seconds before the release of a cycle.
    fn in_the_hand(&self, cycle: usize, ahead: f64) -> Vec<f64> {
        let Cycle { raise, hold, angle, .. } = self.cycles[cycle];
        let before = cycle.saturating_sub(1);
        let hangs = self.motion(before).at(self.cycles[before].swing);
        let share = ((hold + raise - ahead) / raise).clamp(0.0, 1.0);
        let up = share * share * (3.0 - 2.0 * share);
        let still = ((ahead - STILL) / STILL).clamp(0.0, 1.0) * up;
        let jitter: f64 =
            JITTER.iter().map(|(hz, size)| size * (std::f64::consts::TAU * hz * ahead).sin()).sum();
        if up == 0.0 {
            return hangs;
        }
        self.beam.along(|s| {
            let [_, [x, z]] = self.beam.axis(&hangs, s);
            let (stretched, hanging) = (x.hypot(z), z.atan2(x));
            let (length, angle) = (stretched + up * (1.0 - stretched), hanging + up * (angle - hanging));
            let angle = angle + still * jitter;
            [length * angle.cos(), length * angle.sin()]
        })
    }
}

/// Six cycles as a hand does them: raised in two seconds or so, held for one to two, let go within
/// `spread` rad of the horizontal; after `swing` seconds it is nearly at rest.
pub fn six_cycles(random: &mut Random, swing: f64, spread: f64) -> Vec<Cycle> {
    let cycle = |_| Cycle {
        raise: random.between(1.7, 2.3),
        hold: random.between(1.0, 2.0),
        swing,
        angle: if spread > 0.0 { random.between(-spread, spread) } else { 0.0 },
    };
    (0..6).map(cycle).collect()
}
