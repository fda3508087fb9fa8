//! From a session straight to releases, as a perfect cleaning would leave them: calibration alone.

use efam_experiments::release::{OutOfPlane, Point, Release, Track};

use super::random::Random;
use super::session::Session;

/// How releases are seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Direct {
    /// Samples a second.
    pub rate: f64,
    /// Standard deviation of each coordinate, m.
    pub noise: f64,
    /// Share of samples masked.
    pub lost: f64,
    /// Standard deviation of the release instant, s.
    pub instant: f64,
    /// Standard deviation of a tip marker's offset from the tip, in x and z, m.
    pub offset: f64,
    /// How long after the release it is seen, s; no longer than the swing.
    pub horizon: f64,
    /// The observed tip beyond the active length, m.
    pub tip: f64,
    /// Further points, as shares of the active length.
    pub along: Vec<f64>,
}

impl Direct {
    /// Tip alone at 100 Hz, 3 % masked, release known to 2 ms, marker off the tip by 0.3 mm.
    pub fn usual(noise: f64, horizon: f64, tip: f64) -> Self {
        Self {
            rate: 100.0,
            noise,
            lost: 0.03,
            instant: 2e-3,
            offset: 0.3e-3,
            horizon,
            tip,
            along: Vec::new(),
        }
    }

    /// All releases of a session. The clock of the samples knows nothing of the release; times are
    /// after an estimate of its instant.
    pub fn see(&self, session: &Session, random: &mut Random) -> Vec<Release> {
        (0..session.cycles.len()).map(|cycle| self.release(session, cycle, random)).collect()
    }

    /// The release of one cycle, from 0.
    pub fn release(&self, session: &Session, cycle: usize, random: &mut Random) -> Release {
        let first = random.share() / self.rate;
        let late = self.instant * random.normal();
        let count = ((self.horizon - first) * self.rate) as usize;
        let after: Vec<f64> = (0..count).map(|k| first + k as f64 / self.rate).collect();
        let beam = &session.beam;
        let payload: f64 = beam.bodies.iter().skip(1).map(|body| body.mass).sum();
        let mut spots = vec![("tip".to_owned(), Point::Tip, 1.0 + self.tip / beam.length)];
        spots.extend(self.along.iter().map(|s| (format!("body_{:02.0}", 100.0 * s), Point::Along(*s), *s)));
        let tracks = spots.into_iter().map(|(marker, at, share)| {
            let path = session.motion(cycle).path(beam, share, &after);
            let offset = [0; 2].map(|_| self.offset * random.normal());
            let see = |x: [f64; 2]| {
                let seen = [0, 1].map(|k| x[k] + offset[k] + self.noise * random.normal());
                (!random.chance(self.lost)).then_some(seen)
            };
            Track {
                marker,
                at,
                position: path.into_iter().map(see).collect(),
                noise: self.noise,
                discrepancy: 0.0,
            }
        });
        let tracks = tracks.collect();
        Release {
            name: format!("twin#{}", cycle + 1),
            time: after.iter().map(|t| t - late).collect(),
            release_uncertainty: self.instant,
            tracks,
            pressure: None,
            payload,
            held_out: false,
            out_of_plane: OutOfPlane::default(),
        }
    }
}
