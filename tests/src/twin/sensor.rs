//! What a motion-capture system makes of a session: markers in a frame of its own, with noise, losses
//! in bursts, and ghosts.

use std::f64::consts::TAU;

use efam_recordings::{Format, Marker, Recording};

use super::random::Random;
use super::session::Session;

/// Where a marker sits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spot {
    /// On the base, in W, m.
    Base([f64; 3]),
    /// On the muscle or its end.
    Rod {
        /// Distance from the clamp along the axis over the active length; past 1 on the end body.
        share: f64,
        /// Off the axis: in the plane, from x towards z, and out of it, m.
        off: [f64; 2],
    },
}

/// A motion-capture system and what disturbs it.
#[derive(Clone, Debug, PartialEq)]
pub struct Cameras {
    /// Samples a second.
    pub rate: f64,
    /// Standard deviation of the noise of each coordinate, m.
    pub noise: f64,
    /// Share of samples lost.
    pub lost: f64,
    /// Length of the bursts in which they are lost, on average, samples.
    pub burst: f64,
    /// Share of samples that show another thing.
    pub ghosts: f64,
    /// How far from the marker such a thing may be, m.
    pub ghost_reach: f64,
    /// How far the base wanders to either side, m.
    pub drift: f64,
    /// How far the tip leaves the plane, m.
    pub out_of_plane: f64,
    /// The vertical axis of the recording's frame: 0, 1 or 2.
    pub up: usize,
    /// Angle of the muscle about it, rad.
    pub yaw: f64,
    /// Where the clamp is in that frame, m.
    pub clamp: [f64; 3],
    /// What is tracked.
    pub markers: Vec<(String, Spot)>,
}

impl Cameras {
    /// As issue 3 has them, with four base and three tip markers, whose centroids are the clamp and
    /// the point `tip`, m beyond the active length, and one marker each at shares of the length.
    pub fn usual(noise: f64, length: f64, tip: f64, along: &[f64]) -> Self {
        let mut markers = Vec::new();
        for (k, [y, z]) in [[0.06, 0.0], [0.0, 0.05], [-0.06, 0.0], [0.0, -0.05]].into_iter().enumerate() {
            markers.push((format!("base_{}", k + 1), Spot::Base([0.0, y, z])));
        }
        for share in along {
            let spot = Spot::Rod { share: *share, off: [0.0, -0.014] };
            markers.push((format!("body_{:02.0}", 100.0 * share), spot));
        }
        for (k, [beyond, off, y]) in
            [[0.012, 0.0, 0.0], [-0.006, 0.01, 0.009], [-0.006, -0.01, -0.009]].into_iter().enumerate()
        {
            let spot = Spot::Rod { share: 1.0 + (tip + beyond) / length, off: [off, y] };
            markers.push((format!("tip_{}", k + 1), spot));
        }
        Self {
            rate: 100.0,
            noise,
            lost: 0.03,
            burst: 8.0,
            ghosts: 0.003,
            ghost_reach: 0.2,
            drift: 0.3e-3,
            out_of_plane: 4e-3,
            up: 2,
            yaw: 0.6,
            clamp: [0.4, -0.3, 1.2],
            markers,
        }
    }

    /// The recording of a session.
    pub fn record(&self, session: &Session, random: &mut Random) -> Recording {
        let count = (session.duration() * self.rate) as usize + 1;
        let time: Vec<f64> = (0..count).map(|k| k as f64 / self.rate).collect();
        let mut tracks = vec![Vec::with_capacity(count); self.markers.len()];
        for t in &time {
            let q = session.at(*t);
            for (track, (_, spot)) in tracks.iter_mut().zip(&self.markers) {
                track.push(Some(self.to_lab(self.place(session, &q, *spot, *t))));
            }
        }
        for track in &mut tracks {
            self.disturb(track, random);
        }
        let marker = |(name, position)| Marker { name, position, orientation: None };
        let names = self.markers.iter().map(|(name, _)| name.clone());
        Recording {
            format: Format::Made,
            source: "twin".into(),
            rate_hz: self.rate,
            time,
            markers: names.zip(tracks).map(marker).collect(),
            findings: Vec::new(),
        }
    }

    /// A marker in W, y being what completes x and z to a right-handed frame.
    fn place(&self, session: &Session, q: &[f64], spot: Spot, time: f64) -> [f64; 3] {
        let wander = |hz: f64| self.drift * (TAU * hz * time).sin();
        let base = [wander(0.013), wander(0.021), wander(0.008)];
        let place = match spot {
            Spot::Base(at) => at,
            Spot::Rod { share, off: [across, out] } => {
                let [[x, z], p] = session.beam.axis(q, share);
                let per_length = p[0].hypot(p[1]).recip();
                let sway = self.out_of_plane * share * share * (TAU * 0.37 * time).sin();
                [x - across * per_length * p[1], out + sway, z + across * per_length * p[0]]
            }
        };
        [0, 1, 2].map(|k| place[k] + base[k])
    }

    fn to_lab(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = self.yaw.sin_cos();
        let turned = [cos * x - sin * y, sin * x + cos * y, z];
        let mut out = self.clamp;
        // A cyclic exchange of the axes is a rotation.
        (0..3).for_each(|k| out[(k + self.up + 1) % 3] += turned[k]);
        out
    }

    fn disturb(&self, track: &mut [Option<[f64; 3]>], random: &mut Random) {
        let mut lost = 0;
        // A burst begins where none is, so that losses come to their share.
        let begin = self.lost / (self.burst * (1.0 - self.lost));
        for sample in track {
            if lost == 0 && random.chance(begin) {
                lost = 1 + random.between(0.0, 2.0 * self.burst - 1.0) as usize;
            }
            let is_ghost = random.chance(self.ghosts);
            let (direction, reach) = (random.direction(), random.between(0.0, self.ghost_reach));
            let noise = [0; 3].map(|_| self.noise * random.normal());
            let seen = sample.map(|at| {
                let ghost = if is_ghost { reach } else { 0.0 };
                [0, 1, 2].map(|k| at[k] + noise[k] + ghost * direction[k])
            });
            *sample = if lost > 0 { None } else { seen };
            lost = lost.saturating_sub(1);
        }
    }
}
