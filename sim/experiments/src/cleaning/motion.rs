//! Velocity of a point, smoothed over a few samples, for finding where it rests and where it moves.

use efam_core::quantile::quantile;

/// Velocity of a path and the noise in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Velocity, m/s, shape `[samples]`; nothing where too little is seen.
    pub velocity: Vec<Option<[f64; 3]>>,
    /// Standard deviation of the noise of each component, m/s.
    pub noise: f64,
}

/// Half width of the window, s; at most and at least so many periods, so that it is shorter for fast rods and longer for those
/// whose period is above 2.5 s: these are so slow that noise would hide their speed.
const HALF_WIDTH: f64 = 0.03;
const HALF_PERIODS: f64 = 0.1;
const SLOW_PERIODS: f64 = 0.012;
/// Its width and the period are found in turn: at most so often.
const MOST_STEPS: usize = 20;
/// By how much a window is made wider at least.
const WIDER: f64 = 1.05;
/// Least half width in samples.
const LEAST_SAMPLES: f64 = 2.5;
/// Times its noise, by which a speed is none of noise.
const NOISE: f64 = 30.0;

impl Motion {
    /// Slope of the straight line through the samples near each; `sigma` is their noise, m.
    pub fn new(time: &[f64], path: &[Option<[f64; 3]>], step: f64, sigma: f64) -> Motion {
        Self::within(HALF_WIDTH, time, path, step, sigma)
    }

    /// The same with a window that belongs to the period of the motion, and that period, s.
    pub fn paced(time: &[f64], path: &[Option<[f64; 3]>], step: f64, sigma: f64) -> (Motion, f64) {
        let mut half = HALF_WIDTH;
        let mut motion = Self::new(time, path, step, sigma);
        for _ in 0..MOST_STEPS {
            let period = motion.period(path);
            let due = HALF_WIDTH.min(HALF_PERIODS * period).max(SLOW_PERIODS * period);
            // Noise alone has no period, and a short one.
            let is_shortest = || half < LEAST_SAMPLES * step || motion.fastest() < NOISE * motion.noise;
            let is_narrower = due < half && half <= HALF_WIDTH && !is_shortest();
            if !is_narrower && due < WIDER * half {
                break;
            }
            half = due;
            motion = Self::within(half, time, path, step, sigma);
        }
        let period = motion.period(path);
        (motion, period)
    }

    /// The fastest speed, m/s.
    pub fn fastest(&self) -> f64 {
        (0..self.velocity.len()).filter_map(|i| self.speed(i)).fold(0.0, f64::max)
    }

    /// Time, s, in which a point that moves as far and as fast as this one swings once, or longer: a hand moves it too.
    pub fn period(&self, path: &[Option<[f64; 3]>]) -> f64 {
        let range = (0..3).map(|k| {
            let seen = || path.iter().flatten().map(|at| at[k]).collect();
            let [low, high] = [0.01, 0.99].map(|share| quantile(seen(), share));
            high.zip(low).map_or(0.0, |(high, low)| high - low)
        });
        // A swing of amplitude a is fastest at a ω.
        std::f64::consts::PI * range.map(|range| range * range).sum::<f64>().sqrt() / self.fastest()
    }

    fn within(half: f64, time: &[f64], path: &[Option<[f64; 3]>], step: f64, sigma: f64) -> Motion {
        let half = half.max(LEAST_SAMPLES * step) * (1.0 + 1e-9);
        let full = (half / step).floor();
        let mut low = 0;
        let velocity = (0..path.len())
            .map(|i| {
                while time[i] - time[low] > half {
                    low += 1;
                }
                let near = (low..path.len()).take_while(|&k| time[k] - time[i] <= half);
                let seen: Vec<_> = near.filter_map(|k| Some((time[k] - time[i], path[k]?))).collect();
                slope(&seen)
            })
            .collect();
        let samples = 2.0 * full + 1.0;
        let noise = sigma / (step * (samples * (samples * samples - 1.0) / 12.0).sqrt());
        Motion { velocity, noise }
    }

    /// Speed, m/s.
    pub fn speed(&self, i: usize) -> Option<f64> {
        self.velocity[i].map(|[x, y, z]| (x * x + y * y + z * z).sqrt())
    }
}

/// Slope of the line through points of time and place; none of fewer than three.
fn slope(seen: &[(f64, [f64; 3])]) -> Option<[f64; 3]> {
    if seen.len() < 3 {
        return None;
    }
    let mean = seen.iter().map(|(t, _)| t).sum::<f64>() / seen.len() as f64;
    let square: f64 = seen.iter().map(|(t, _)| (t - mean).powi(2)).sum();
    Some(std::array::from_fn(|k| seen.iter().map(|(t, p)| (t - mean) * p[k]).sum::<f64>() / square))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_motion_keeps_its_velocity_across_a_gap() {
        let time: Vec<f64> = (0..30).map(|i| 0.01 * i as f64).collect();
        let mut path: Vec<_> = time.iter().map(|t| Some([1.0 + 0.3 * t, -2.0 * t, 0.0])).collect();
        path[9] = None;
        let motion = Motion::new(&time, &path, 0.01, 1e-4);
        for velocity in &motion.velocity {
            let [x, y, z] = velocity.unwrap();
            assert!((x - 0.3).abs() < 1e-9 && (y + 2.0).abs() < 1e-9 && z.abs() < 1e-9);
        }
        // Seven samples, 10 ms apart: σ / (h √28).
        assert!((motion.noise - 1e-4 / (0.01 * 28f64.sqrt())).abs() < 1e-12);
    }
}
