//! What a tracker makes of a path in the plane: white and coloured noise, losses in bursts, ghosts.

use super::random::Random;

/// A tracker's disturbances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracker {
    /// Standard deviation of each coordinate, m, white and coloured together.
    pub noise: f64,
    /// Share of its variance that is coloured: a process of first order.
    pub coloured: f64,
    /// Correlation of the coloured part from a sample to the next.
    pub correlation: f64,
    /// Share of samples lost.
    pub lost: f64,
    /// Length of the bursts in which they are lost, on average, samples.
    pub burst: f64,
    /// Share of samples that show another thing.
    pub ghosts: f64,
    /// How far from the marker such a thing may be, m.
    pub ghost_reach: f64,
}

impl Tracker {
    /// A third of the variance forgets itself over some three samples; 3 % lost, eight at a time; 0.3 %
    /// ghosts within 200 mm.
    pub fn usual(noise: f64) -> Self {
        Self {
            noise,
            coloured: 1.0 / 3.0,
            correlation: 0.7,
            lost: 0.03,
            burst: 8.0,
            ghosts: 0.003,
            ghost_reach: 0.2,
        }
    }

    /// A path as it is tracked.
    pub fn track(&self, path: &[[f64; 2]], random: &mut Random) -> Vec<Option<[f64; 2]>> {
        let white = self.noise * (1.0 - self.coloured).sqrt();
        let coloured = self.noise * self.coloured.sqrt();
        let fresh = (1.0 - self.correlation * self.correlation).sqrt();
        let mut slow = [0; 2].map(|_| random.normal());
        // A burst begins where none is, so that losses come to their share.
        let begin = self.lost / (self.burst * (1.0 - self.lost));
        let mut lost = 0;
        let sample = |at: &[f64; 2]| {
            if lost == 0 && random.chance(begin) {
                lost = 1 + random.between(0.0, 2.0 * self.burst - 1.0) as usize;
            }
            slow = slow.map(|x| self.correlation * x + fresh * random.normal());
            let noise = slow.map(|x| coloured * x + white * random.normal());
            let is_ghost = random.chance(self.ghosts);
            let (angle, reach) = (random.between(0.0, std::f64::consts::TAU), random.share());
            let ghost = if is_ghost { self.ghost_reach * reach } else { 0.0 };
            let seen = [0, 1].map(|k| at[k] + noise[k] + ghost * [angle.cos(), angle.sin()][k]);
            let is_lost = lost > 0;
            lost = lost.saturating_sub(1);
            (!is_lost).then_some(seen)
        };
        path.iter().map(sample).collect()
    }
}
